// SPDX-License-Identifier: GPL-2.0-only
/*
 * The verb doctor: common functions of checks. See doctor.h.
 */
#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <grp.h>
#include <json-c/json.h>
#include <libgen.h>
#include <limits.h>
#include <pwd.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli.h"
#include "doctor.h"

#define GROUP "dialout"		/* userspace/udev */

struct doctor {
	struct cli_common common;
	const char *root;
	const struct doctor_tool *tool;
	const struct doctor_check *check;	/* the current one */
	char kernel[128];
	char paths[8][PATH_MAX];
	unsigned int path;
	unsigned int found;
	struct json_object *findings;
};

/* ---- command line ---- */

enum { KEY_ROOT = 0x100 };

static const struct argp_option options[] = {
	{ "root", KEY_ROOT, "DIR", OPTION_HIDDEN, "Look there instead of /, for tests", 0 },
	{ 0 }
};

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct doctor *doctor = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[0] = &doctor->common;
		return 0;
	case KEY_ROOT:
		doctor->root = argument;
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static void list_checks(FILE *stream, const struct doctor_check *checks)
{
	for (; checks->id; checks++)
		fprintf(stream, "%s (%s), ", checks->id, checks->what);
}

static char *doc(const struct doctor_tool *tool)
{
	char *text = NULL;
	size_t size = 0;
	FILE *stream = open_memstream(&text, &size);

	if (!stream)
		exit(cli_errno(errno, "no help"));
	fprintf(stream, "Diagnose a device and suggest a fix."
		"\v"
		"It changes nothing. Each line has a status, which is ok, found or skipped, the "
		"id of the check, and the result; a fix follows each fault. Some checks require "
		"root. The exit status is 1 when something was found. Checks are ");
	list_checks(stream, doctor_install_checks);
	list_checks(stream, tool->checks);
	fseek(stream, -2, SEEK_CUR);
	fprintf(stream, ".");
	fclose(stream);
	return text;
}

/* ---- messages ---- */

static void say(struct doctor *doctor, const char *status, enum cli_colour colour, const char *fix,
		const char *format, va_list arguments)
{
	struct json_object *finding;
	char *text;

	if (vasprintf(&text, format, arguments) < 0)
		exit(cli_errno(ENOMEM, "%s", doctor->check->id));
	if (doctor->common.json) {
		finding = json_object_new_object();
		cli_json_text(finding, "id", doctor->check->id);
		cli_json_text(finding, "status", status);
		cli_json_text(finding, "text", text);
		cli_json_text(finding, "fix", fix);
		json_object_array_add(doctor->findings, finding);
	} else {
		printf("%s%-8s%s %-12s %s\n", cli_colour(colour), status, cli_colour(CLI_PLAIN),
		       doctor->check->id, text);
		if (fix)
			printf("         fix:          %s%s%s\n", cli_colour(CLI_BOLD), fix,
			       cli_colour(CLI_PLAIN));
	}
	free(text);
}

void doctor_ok(struct doctor *doctor, const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	say(doctor, "ok", CLI_GREEN, NULL, format, arguments);
	va_end(arguments);
}

void doctor_skip(struct doctor *doctor, const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	say(doctor, "skipped", CLI_DIM, NULL, format, arguments);
	va_end(arguments);
}

void doctor_found(struct doctor *doctor, const char *fix, const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	say(doctor, "found", CLI_RED, fix, format, arguments);
	va_end(arguments);
	doctor->found++;
}

/* ---- data to check ---- */

const struct doctor_tool *doctor_tool_of(const struct doctor *doctor)
{
	return doctor->tool;
}

const char *doctor_kernel(const struct doctor *doctor)
{
	return doctor->kernel;
}

bool doctor_wants(const struct doctor *doctor, const char *device)
{
	return !doctor->common.device || !strcmp(doctor->common.device, device);
}

const char *doctor_path(struct doctor *doctor, const char *format, ...)
{
	char *path = doctor->paths[doctor->path++ % 8];
	size_t size = snprintf(path, PATH_MAX, "%s", doctor->root);
	va_list arguments;

	va_start(arguments, format);
	vsnprintf(path + size, PATH_MAX - size, format, arguments);
	va_end(arguments);
	return path;
}

bool doctor_exists(struct doctor *doctor, const char *path)
{
	return !access(doctor_path(doctor, "%s", path), F_OK);
}

int doctor_read(struct doctor *doctor, char *text, size_t size, const char *path)
{
	int fd = open(doctor_path(doctor, "%s", path), O_RDONLY | O_CLOEXEC);
	ssize_t length;

	text[0] = '\0';
	if (fd < 0)
		return -errno;
	length = read(fd, text, size - 1);
	if (length < 0)
		length = -errno;
	close(fd);
	if (length < 0)
		return length;
	if (length > 0 && text[length - 1] == '\n')
		length--;
	text[length] = '\0';
	return length;
}

long long doctor_number(struct doctor *doctor, const char *path)
{
	char text[32];

	return doctor_read(doctor, text, sizeof(text), path) > 0 ? atoll(text) : -1;
}

void doctor_link(struct doctor *doctor, char *name, size_t size, const char *path)
{
	char target[PATH_MAX];
	ssize_t length = readlink(doctor_path(doctor, "%s", path), target, sizeof(target) - 1);

	name[0] = '\0';
	if (length <= 0)
		return;
	target[length] = '\0';
	snprintf(name, size, "%s", basename(target));
}

int doctor_each(struct doctor *doctor, const char *pattern,
		void (*look)(struct doctor *doctor, const char *path))
{
	size_t skip = strlen(doctor->root);
	glob_t found;
	int count = 0;

	if (!glob(doctor_path(doctor, "%s", pattern), 0, NULL, &found)) {
		for (size_t i = 0; i < found.gl_pathc; i++, count++)
			look(doctor, found.gl_pathv[i] + skip);
	}
	globfree(&found);
	return count;
}

bool doctor_holder(struct doctor *doctor, const char *node, char *name, size_t size, pid_t *pid)
{
	char path[PATH_MAX], target[PATH_MAX];
	bool held = false;
	ssize_t length;
	glob_t found;

	if (glob(doctor_path(doctor, "/proc/[0-9]*/fd/*"), 0, NULL, &found))
		return false;
	for (size_t i = 0; i < found.gl_pathc && !held; i++) {
		const char *process = found.gl_pathv[i] + strlen(doctor->root);

		length = readlink(found.gl_pathv[i], target, sizeof(target) - 1);
		if (length <= 0)
			continue;
		target[length] = '\0';
		*pid = atoi(process + strlen("/proc/"));
		if (strcmp(target, node) || *pid == getpid())
			continue;
		snprintf(path, sizeof(path), "/proc/%d/comm", (int)*pid);
		if (doctor_read(doctor, name, size, path) < 0)
			snprintf(name, size, "?");
		held = true;
	}
	globfree(&found);
	return held;
}

/* The line that makes udev process devices again, and the one that makes a user a member */
#define TRIGGER "sudo udevadm control --reload && sudo udevadm trigger --action=bind " \
	"--subsystem-match=hid && sudo udevadm trigger --action=add --subsystem-match=input " \
	"--subsystem-match=xy3 --subsystem-match=iio --subsystem-match=tty"
#define JOIN "sudo usermod -aG " GROUP " \"$USER\"   # and log in again"

/* From the list of groups; a process has those of its login */
static bool is_member(const struct group *group)
{
	const struct passwd *user = getpwuid(getuid());

	for (char **member = group->gr_mem; user && *member; member++) {
		if (!strcmp(*member, user->pw_name))
			return true;
	}
	return false;
}

void doctor_access(struct doctor *doctor, const char *path, bool read, const char *device)
{
	const char *whole = doctor_path(doctor, "%s", path);
	const mode_t wanted = read ? 0060 : 0020;
	const struct group *group = getgrnam(GROUP);
	struct stat about;

	if (stat(whole, &about)) {
		doctor_skip(doctor, "%s: %s: %s", device, path, strerror(errno));
		return;
	}
	if (!group) {
		doctor_skip(doctor, "%s: there is no group " GROUP " here", device);
		return;
	}
	if (about.st_gid != group->gr_gid || (about.st_mode & wanted) != wanted) {
		doctor_found(doctor, TRIGGER, "%s: the group " GROUP " has no access to %s: the "
			     "udev rules have not been applied", device, path);
		return;
	}
	/* also by an ACL, which udev sets for the user at the seat */
	if (access(whole, read ? R_OK | W_OK : W_OK) && is_member(group)) {
		doctor_found(doctor, "log out and in again, or restart", "%s: no access to %s: you "
			     "are in the group " GROUP ", but were not when you logged in",
			     device, path);
		return;
	}
	if (access(whole, read ? R_OK | W_OK : W_OK)) {
		doctor_found(doctor, JOIN, "%s: no access to %s: you are not in the group "
			     GROUP, device, path);
		return;
	}
	doctor_ok(doctor, "%s: the group " GROUP " has access to %s", device, path);
}

/* ---- the device of --device ---- */

#define FOUND_MAX 32

static struct {
	const char *node;	/* without its folder */
	bool has_node;
	char name[FOUND_MAX][64];
	size_t count;
} search;

static const char *last_part(const char *path)
{
	const char *slash = strrchr(path, '/');

	return slash ? slash + 1 : path;
}

static void compare_node(struct doctor *doctor, const char *path)
{
	(void)doctor;
	search.has_node |= !strcmp(last_part(path), search.node);
}

static void add_device(struct doctor *doctor, const char *path)
{
	(void)doctor;
	if (search.count < FOUND_MAX)
		snprintf(search.name[search.count++], sizeof(search.name[0]), "%s",
			 last_part(path));
}

/* A device by its name, a node of it, or its port */
static void compare_device(struct doctor *doctor, const char *path)
{
	static const char *const nodes[] = { "input/input*/event*", "hidraw/hidraw*" };
	char file[PATH_MAX], text[1024], phys[PATH_MAX];

	search.has_node = !strcasecmp(last_part(path), search.node);
	for (size_t i = 0; i < ARRAY_SIZE(nodes); i++) {
		snprintf(file, sizeof(file), "%s/%s", path, nodes[i]);
		doctor_each(doctor, file, compare_node);
	}
	snprintf(file, sizeof(file), "%s/uevent", path);
	snprintf(phys, sizeof(phys), "HID_PHYS=%s", doctor->common.device);
	doctor_read(doctor, text, sizeof(text), file);
	for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"))
		search.has_node |= !strcmp(line, phys);
	if (search.has_node)
		add_device(doctor, path);
}

/* In the order of the verb list: numbers after the last . or - */
static int compare_numbers(const void *one, const void *two)
{
	unsigned long x = strtoul(one + strcspn(one, ".-") + 1, NULL, 16);
	unsigned long y = strtoul(two + strcspn(two, ".-") + 1, NULL, 16);

	return (x > y) - (x < y);
}

/* Replace a name of the verb list by that of the device. Return an enum cli_status. */
static int find_device(struct doctor *doctor)
{
	const char *name = doctor->common.device;
	char link[PATH_MAX];
	const char *end;
	unsigned long number;

	if (!name)
		return CLI_OK;
	number = strtoul(name, (char **)&end, 10);
	if (!isdigit((unsigned char)*name))
		end = "no number";
	if (!*end && doctor->tool->bound) {
		doctor_each(doctor, doctor->tool->bound, add_device);
		qsort(search.name, search.count, sizeof(search.name[0]), compare_numbers);
	} else {
		doctor_link(doctor, link, sizeof(link), name);
		if (!*end)
			snprintf(link, sizeof(link), "xy3-%lu", number);
		search.node = last_part(link[0] ? link : name);
		number = 0;
		doctor_each(doctor, doctor->tool->devices, compare_device);
	}
	if (number >= search.count)
		return cli_no_device("no %s %s", doctor->tool->what, name);
	doctor->common.device = search.name[number];
	return CLI_OK;
}

/* ---- the verb ---- */

static void run_checks(struct doctor *doctor, const struct doctor_check *checks)
{
	for (; checks->id; checks++) {
		doctor->check = checks;
		checks->look(doctor);
	}
}

int doctor_run(const struct doctor_tool *tool, int argc, char **argv)
{
	struct doctor doctor = { .root = "", .tool = tool };
	struct argp argp = { .options = options, .parser = parse, .children = cli_children };
	struct json_object *document;
	int status;

	argp.doc = doc(tool);
	argp_parse(&argp, argc, argv, 0, NULL, &doctor);
	free((char *)argp.doc);
	doctor.findings = json_object_new_array();
	doctor_read(&doctor, doctor.kernel, sizeof(doctor.kernel), "/proc/sys/kernel/osrelease");
	status = find_device(&doctor);
	if (status != CLI_OK) {
		json_object_put(doctor.findings);
		return status;
	}
	run_checks(&doctor, doctor_install_checks);
	run_checks(&doctor, tool->checks);
	if (doctor.common.json) {
		document = cli_json_new("doctor");
		json_object_object_add(document, "findings", doctor.findings);
		cli_json_print(document);
	} else {
		json_object_put(doctor.findings);
	}
	return doctor.found ? CLI_FAILURE : CLI_OK;
}
