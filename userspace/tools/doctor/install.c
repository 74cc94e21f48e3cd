// SPDX-License-Identifier: GPL-2.0-only
/*
 * Checks of the installation by both tools: headers, DKMS, modules, signatures, udev rules.
 */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "cli.h"
#include "doctor.h"

#define NAME "xhc-xy3"		/* PACKAGE_NAME of dkms.conf */

/* ---- the file of the module ---- */

/*
 * The path in modules.dep of a module of the running kernel, below the folder of the kernel: "" if
 * there is none.
 */
static void find_module(struct doctor *doctor, const char *module, char *path, size_t size)
{
	char wanted[64], *line = NULL;
	size_t room = 0;
	FILE *file = fopen(doctor_path(doctor, "/lib/modules/%s/modules.dep",
				       doctor_kernel(doctor)), "re");

	path[0] = '\0';
	if (!file)
		return;
	snprintf(wanted, sizeof(wanted), "/%s.ko", module);
	while (getline(&line, &room, file) >= 0) {
		line[strcspn(line, ":")] = '\0';
		if (strstr(line, wanted)) {
			snprintf(path, size, "%s", line);
			break;
		}
	}
	free(line);
	fclose(file);
}

/* The contents of a file, to be freed; NULL if it cannot be read */
static char *read_whole(struct doctor *doctor, const char *path, size_t *size)
{
	FILE *file = fopen(doctor_path(doctor, "%s", path), "re");
	char *data = NULL;
	long length = -1;

	if (!file)
		return NULL;
	if (!fseek(file, 0, SEEK_END))
		length = ftell(file);
	if (length >= 0 && !fseek(file, 0, SEEK_SET))
		data = malloc(length + 1);
	if (data) {
		*size = fread(data, 1, length, file);
		data[*size] = '\0';
	}
	fclose(file);
	return data;
}

/* The version in the file of a module; "" if it is missing or compressed */
static void module_version(struct doctor *doctor, const char *module, char *version, size_t size)
{
	static const char mark[] = "\0version=";
	const size_t mark_size = sizeof(mark) - 1;
	char path[PATH_MAX], file[PATH_MAX], *data, *found;
	size_t length;

	version[0] = '\0';
	find_module(doctor, module, path, sizeof(path));
	if (snprintf(file, sizeof(file), "/lib/modules/%s/%s", doctor_kernel(doctor), path) >=
	    (int)sizeof(file))
		return;
	data = path[0] ? read_whole(doctor, file, &length) : NULL;
	if (!data)
		return;
	found = memmem(data, length, mark, mark_size);
	if (found)
		snprintf(version, size, "%s", found + mark_size);
	free(data);
}

static bool is_loaded(struct doctor *doctor, const struct doctor_driver *driver)
{
	char path[PATH_MAX];

	snprintf(path, sizeof(path), "/sys/module/%s", driver->sysfs);
	return doctor_exists(doctor, path);
}

/* Check that there is a module for each driver */
static bool has_modules(struct doctor *doctor)
{
	const struct doctor_driver *driver = doctor_tool_of(doctor)->drivers;
	char path[PATH_MAX];

	for (; driver->module; driver++) {
		find_module(doctor, driver->module, path, sizeof(path));
		if (!path[0] && !is_loaded(doctor, driver))
			return false;
	}
	return true;
}

/* ---- headers ---- */

static void look_headers(struct doctor *doctor)
{
	const char *kernel = doctor_kernel(doctor);
	char path[PATH_MAX], fix[256];

	snprintf(path, sizeof(path), "/lib/modules/%s/build/Makefile", kernel);
	if (doctor_exists(doctor, path)) {
		doctor_ok(doctor, "headers of kernel %s are installed", kernel);
		return;
	}
	if (has_modules(doctor)) {
		doctor_skip(doctor, "headers of kernel %s are missing; they are required only to "
			    "build the drivers again", kernel);
		return;
	}
	doctor_headers_fix(doctor, fix, sizeof(fix));
	doctor_found(doctor, fix, "headers of kernel %s are missing: the drivers cannot be built",
		     kernel);
}

/* ---- DKMS ---- */

struct states {
	bool installed;		/* for the running kernel */
	char version[32];	/* the newest one */
};

static struct states dkms;

/* /var/lib/dkms/NAME/VERSION; and NAME/kernel-RELEASE-MACHINE beside it if installed */
static void take_state(struct doctor *doctor, const char *path)
{
	const char *name = strrchr(path, '/') + 1;
	size_t length = strlen(doctor_kernel(doctor));

	if (strncmp(name, "kernel-", 7))
		snprintf(dkms.version, sizeof(dkms.version), "%s", name);
	else if (!strncmp(name + 7, doctor_kernel(doctor), length) && name[7 + length] == '-')
		dkms.installed = true;
}

/* The compiler that a build has not found: "/bin/sh: 1: gcc-14: not found" */
static void find_compiler(struct doctor *doctor, const char *path, char *name, size_t size)
{
	FILE *file = fopen(doctor_path(doctor, "%s", path), "re");
	char *line = NULL;
	size_t room = 0;

	name[0] = '\0';
	if (!file)
		return;
	while (getline(&line, &room, file) >= 0) {
		char *end = strstr(line, ": not found"), *start;

		if (!end)
			end = strstr(line, ": command not found");
		if (!end)
			continue;
		*end = '\0';
		start = strrchr(line, ' ') ? strrchr(line, ' ') + 1 : line;
		if (!strncmp(start, "gcc", 3) || !strncmp(start, "clang", 5))
			snprintf(name, size, "%s", start);
	}
	free(line);
	fclose(file);
}

static void look_dkms(struct doctor *doctor)
{
	const char *kernel = doctor_kernel(doctor);
	char fix[512], path[PATH_MAX], compiler[64];

	memset(&dkms, 0, sizeof(dkms));
	doctor_each(doctor, "/var/lib/dkms/" NAME "/*", take_state);
	if (!dkms.version[0]) {
		doctor_skip(doctor, NAME " is not installed by DKMS");
		return;
	}
	if (dkms.installed) {
		doctor_ok(doctor, NAME "/%s is installed for %s", dkms.version, kernel);
		return;
	}
	snprintf(path, sizeof(path), "/var/lib/dkms/" NAME "/%s/build/make.log", dkms.version);
	find_compiler(doctor, path, compiler, sizeof(compiler));
	if (compiler[0] && !doctor_is_image(doctor)) {
		doctor_package_fix(doctor, "install", compiler, fix, sizeof(fix));
		doctor_found(doctor, fix, NAME "/%s could not be built for kernel %s: its compiler "
			     "%s is missing", dkms.version, kernel, compiler);
		return;
	}
	if (doctor_is_image(doctor))
		snprintf(fix, sizeof(fix), DOCTOR_IMAGE);
	else
		snprintf(fix, sizeof(fix), "sudo dkms install " NAME "/%s -k %s", dkms.version,
			 kernel);
	doctor_found(doctor, fix, NAME "/%s is there, but not built and installed for kernel "
		     "%s%s%s", dkms.version, kernel, doctor_exists(doctor, path) ? "; why: " : "",
		     doctor_exists(doctor, path) ? path : "");
}

/* ---- modules ---- */

static struct {
	const char *module;
	char why[128];		/* "" if it was not left out */
} left_out;

/* The log of a build has a line for each module that is left out, see Kbuild at the top */
static void take_left_out(struct doctor *doctor, const char *path)
{
	char *line = NULL, start[64];
	FILE *file = fopen(doctor_path(doctor, "%s", path), "re");
	size_t room = 0;

	if (!file)
		return;
	snprintf(start, sizeof(start), NAME ": %s is left out: ", left_out.module);
	while (getline(&line, &room, file) >= 0) {
		line[strcspn(line, "\n")] = '\0';
		if (!strncmp(line, start, strlen(start)))
			snprintf(left_out.why, sizeof(left_out.why), "%s", line + strlen(start));
	}
	free(line);
	fclose(file);
}

static void look_left_out(struct doctor *doctor, const char *module)
{
	char pattern[PATH_MAX];

	left_out.module = module;
	left_out.why[0] = '\0';
	snprintf(pattern, sizeof(pattern), "/var/lib/dkms/" NAME "/kernel-%s-*/log/make.log",
		 doctor_kernel(doctor));
	doctor_each(doctor, pattern, take_left_out);
}

static void look_module(struct doctor *doctor, const struct doctor_driver *driver)
{
	char path[PATH_MAX], fix[256];

	find_module(doctor, driver->module, path, sizeof(path));
	if (path[0] || is_loaded(doctor, driver)) {
		doctor_ok(doctor, "%s is installed%s", driver->module,
			  is_loaded(doctor, driver) ? " and loaded" : "");
		return;
	}
	look_left_out(doctor, driver->module);
	if (left_out.why[0]) {
		doctor_found(doctor, "boot a kernel with these options",
			     "kernel %s has no module %s: it was left out, as %s",
			     doctor_kernel(doctor), driver->module, left_out.why);
		return;
	}
	if (dkms.version[0] && !dkms.installed) {
		doctor_skip(doctor, "kernel %s has no module %s: see dkms", doctor_kernel(doctor),
			    driver->module);
		return;
	}
	if (doctor_is_image(doctor))
		snprintf(fix, sizeof(fix), DOCTOR_IMAGE);
	else if (dkms.installed)
		snprintf(fix, sizeof(fix), "sudo dkms install --force " NAME "/%s -k %s",
			 dkms.version, doctor_kernel(doctor));
	else
		snprintf(fix, sizeof(fix), "sudo make install   # in the source of " NAME);
	doctor_found(doctor, fix, "kernel %s has no module %s", doctor_kernel(doctor),
		     driver->module);
}

static void look_modules(struct doctor *doctor)
{
	const struct doctor_driver *driver = doctor_tool_of(doctor)->drivers;

	for (; driver->module; driver++)
		look_module(doctor, driver);
}

/* ---- the configuration of modprobe ---- */

static struct {
	const char *module;
	char file[PATH_MAX];	/* that prevents loading it; "" if there is none */
} barred;

/* modprobe treats - and _ as the same */
static bool is_module(const char *name, const char *module)
{
	for (; *name && *module; name++, module++) {
		if (*name != *module && !(strchr("-_", *name) && strchr("-_", *module)))
			return false;
	}
	return *name == *module;
}

/* "blacklist MODULE", or "install MODULE" with a command that does not load it */
static void look_line(char *line, const char *path)
{
	char *save, *verb = strtok_r(line, " \t\n", &save), *name = strtok_r(NULL, " \t\n", &save);
	char *command = name ? strtok_r(NULL, "\n", &save) : NULL;

	if (!name || !is_module(name, barred.module))
		return;
	if (!strcmp(verb, "blacklist") ||
	    (!strcmp(verb, "install") && !(command && strstr(command, "modprobe"))))
		snprintf(barred.file, sizeof(barred.file), "%s", path);
}

static void look_modprobe_file(struct doctor *doctor, const char *path)
{
	FILE *file = fopen(doctor_path(doctor, "%s", path), "re");
	char *line = NULL;
	size_t room = 0;

	if (!file)
		return;
	while (getline(&line, &room, file) >= 0)
		look_line(line, path);
	free(line);
	fclose(file);
}

/* module_blacklist=NAME,... is for the kernel; modprobe.blacklist=NAME,... for modprobe */
static void look_command_line(struct doctor *doctor)
{
	char text[4096], *words = text, *word, *names, *name;

	if (doctor_read(doctor, text, sizeof(text), "/proc/cmdline") < 0)
		return;
	while ((word = strsep(&words, " "))) {
		if (strncmp(word, "module_blacklist=", 17) &&
		    strncmp(word, "modprobe.blacklist=", 19))
			continue;
		names = strchr(word, '=') + 1;
		while ((name = strsep(&names, ","))) {
			if (is_module(name, barred.module))
				snprintf(barred.file, sizeof(barred.file), "the kernel's command "
					 "line");
		}
	}
}

static void look_blacklist(struct doctor *doctor)
{
	const struct doctor_driver *driver = doctor_tool_of(doctor)->drivers;

	for (; driver->module; driver++) {
		barred.module = driver->module;
		barred.file[0] = '\0';
		doctor_each(doctor, "/usr/lib/modprobe.d/*.conf", look_modprobe_file);
		doctor_each(doctor, "/lib/modprobe.d/*.conf", look_modprobe_file);
		doctor_each(doctor, "/run/modprobe.d/*.conf", look_modprobe_file);
		doctor_each(doctor, "/etc/modprobe.d/*.conf", look_modprobe_file);
		look_command_line(doctor);
		if (!barred.file[0])
			doctor_ok(doctor, "%s is not excluded", driver->module);
		else if (is_loaded(doctor, driver))
			doctor_skip(doctor, "%s is loaded, although %s names it", driver->module,
				    barred.file);
		else
			doctor_found(doctor, "remove that line, then load the module by modprobe",
				     "%s prevents loading %s", barred.file, driver->module);
	}
}

/* A module of another version is loaded */
static void look_other_version(struct doctor *doctor, const char *module, const char *loaded)
{
	char file[64], fix[256];

	module_version(doctor, module, file, sizeof(file));
	if (!file[0] || !strcmp(file, VERSION)) {
		snprintf(fix, sizeof(fix), "sudo modprobe -r %s && sudo modprobe %s", module,
			 module);
		doctor_found(doctor, fix, "%s %s is loaded, and this tool is %s", module, loaded,
			     VERSION);
		return;
	}
	if (!strcmp(dkms.version, VERSION))
		snprintf(fix, sizeof(fix), "sudo dkms install --force " NAME "/" VERSION " -k %s "
			 "&& sudo modprobe -r %s && sudo modprobe %s", doctor_kernel(doctor),
			 module, module);
	else
		snprintf(fix, sizeof(fix), "sudo make install install-tools   # in the source of "
			 NAME "; or upgrade both packages");
	doctor_found(doctor, fix, "%s %s is loaded and installed, and this tool is %s", module,
		     loaded, VERSION);
}

static void look_version(struct doctor *doctor)
{
	const struct doctor_driver *driver = doctor_tool_of(doctor)->drivers;
	char path[PATH_MAX], version[64];

	for (; driver->module; driver++) {
		snprintf(path, sizeof(path), "/sys/module/%s/version", driver->sysfs);
		if (doctor_read(doctor, version, sizeof(version), path) < 0)
			doctor_skip(doctor, "%s is not loaded", driver->module);
		else if (strcmp(version, VERSION))
			look_other_version(doctor, driver->module, version);
		else
			doctor_ok(doctor, "%s %s is loaded", driver->module, version);
	}
}

/* ---- Secure Boot ---- */

/* Appended to a signed module (scripts/sign-file.c) */
static const char signature_mark[] = "~Module signature appended~\n";

/* 1: signed, 0: not signed, -1: unknown, as the file is compressed or missing */
static int is_signed(struct doctor *doctor, const char *path)
{
	const size_t size = sizeof(signature_mark) - 1;
	char end[sizeof(signature_mark)] = "";
	size_t length = strlen(path);
	bool result;
	FILE *file;

	if (length < 3 || strcmp(path + length - 3, ".ko"))
		return -1;
	file = fopen(doctor_path(doctor, "/lib/modules/%s/%s", doctor_kernel(doctor), path), "re");
	if (!file)
		return -1;
	result = !fseek(file, -(long)size, SEEK_END) && fread(end, 1, size, file) == size &&
		 !memcmp(end, signature_mark, size);
	fclose(file);
	return result;
}

/* Whether the kernel only loads signed modules, and why */
static const char *enforced_by(struct doctor *doctor)
{
	static const char variable[] = "/sys/firmware/efi/efivars/"
		"SecureBoot-8be4df61-93ca-11d2-aa0d-00e098032b8c";
	static const char parameter[] = "/sys/module/module/parameters/sig_enforce";
	char text[128];

	/* four bytes of attributes, then the value */
	if (doctor_read(doctor, text, sizeof(text), variable) == 5 && text[4] == 1)
		return "Secure Boot is on";
	if (doctor_read(doctor, text, sizeof(text), parameter) > 0 && text[0] == 'Y')
		return "the kernel was started with module.sig_enforce";
	if (doctor_read(doctor, text, sizeof(text), "/sys/kernel/security/lockdown") > 0 &&
	    !strstr(text, "[none]"))
		return "the kernel is locked down";
	return NULL;
}

/* Whether the firmware's list of keys has this certificate */
static bool is_enrolled(struct doctor *doctor, const char *key)
{
	static const char list[] = "/sys/firmware/efi/efivars/"
		"MokListRT-605dab50-e046-4300-abb6-3dd810dd8b23";
	size_t keys_size = 0, key_size = 0;
	char *keys = read_whole(doctor, list, &keys_size);
	char *certificate = read_whole(doctor, key, &key_size);
	bool result = keys && key_size && memmem(keys, keys_size, certificate, key_size);

	free(certificate);
	free(keys);
	return result;
}

static void look_signature(struct doctor *doctor)
{
	const struct doctor_driver *driver = doctor_tool_of(doctor)->drivers;
	const char *who = enforced_by(doctor), *key = doctor_key(doctor);
	char path[PATH_MAX], enrol[256], sign[512];
	bool enrolled;
	int answer;

	if (!who) {
		doctor_ok(doctor, "the kernel does not require signed modules");
		return;
	}
	enrolled = is_enrolled(doctor, key);
	for (; driver->module; driver++) {
		if (is_loaded(doctor, driver)) {
			doctor_ok(doctor, "%s, and %s is loaded", who, driver->module);
			continue;
		}
		find_module(doctor, driver->module, path, sizeof(path));
		if (!path[0]) {
			doctor_skip(doctor, "%s, and there is no %s", who, driver->module);
			continue;
		}
		answer = is_signed(doctor, path);
		snprintf(enrol, sizeof(enrol), "sudo mokutil --import %s   # then restart, and "
			 "choose Enroll MOK", key);
		/* DKMS signs in builds: installing it again is not sufficient */
		snprintf(sign, sizeof(sign), "%s%s%ssudo dkms build --force " NAME "/" VERSION
			 " && sudo dkms install --force " NAME "/" VERSION "%s",
			 enrolled ? "" : "sudo mokutil --import ", enrolled ? "" : key,
			 enrolled ? "" : " && ",
			 enrolled ? "" : "   # then restart, and choose Enroll MOK");
		if (!dkms.version[0])
			doctor_found(doctor, "sign it with a key that is enrolled, or install by "
				     "DKMS, which does", "%s, and %s is not loaded: it is refused "
				     "if it is not signed", who, driver->module);
		else if (!answer)
			doctor_found(doctor, sign, "%s, and %s is not signed: it is refused", who,
				     driver->module);
		else if (enrolled)
			doctor_ok(doctor, "%s, and the key of %s is enrolled", who,
				  driver->module);
		else
			doctor_found(doctor, enrol, "%s, and %s is not loaded: it is refused if "
				     "its key is not enrolled (see `mokutil --test-key %s')", who,
				     driver->module, key);
	}
}

/* ---- udev ---- */

static void look_rules(struct doctor *doctor)
{
	/* the first one with the file has priority (udev(7)) */
	static const char *const folders[] = {
		"/etc/udev/rules.d", "/run/udev/rules.d", "/usr/local/lib/udev/rules.d",
		"/usr/lib/udev/rules.d", "/lib/udev/rules.d",
	};
	const char *name = doctor_tool_of(doctor)->rules;
	char path[PATH_MAX], fix[PATH_MAX + 64];
	struct stat about;

	for (size_t i = 0; i < ARRAY_SIZE(folders); i++) {
		snprintf(path, sizeof(path), "%s/%s", folders[i], name);
		if (stat(doctor_path(doctor, "%s", path), &about))
			continue;
		/* the usual way to disable one: empty, or a link to /dev/null */
		if (!S_ISREG(about.st_mode) || !about.st_size) {
			snprintf(fix, sizeof(fix), "sudo rm %s && sudo udevadm control --reload",
				 path);
			doctor_found(doctor, fix, "%s disables the rules", path);
		} else {
			doctor_ok(doctor, "%s", path);
		}
		return;
	}
	doctor_found(doctor, "install " NAME " again: its package, or `sudo make install' in the "
		     "source", "%s is missing: no names, and no access without root", name);
}

const struct doctor_check doctor_install_checks[] = {
	{ "headers", "of the running kernel", look_headers },
	{ "dkms", "its state", look_dkms },
	{ "module", "installed for the running kernel", look_modules },
	{ "blacklist", "not excluded by the configuration of modprobe", look_blacklist },
	{ "version", "module and tool have the same version", look_version },
	{ "signature", "Secure Boot, and a module that it refuses", look_signature },
	{ "rules", "udev's", look_rules },
	{ 0 }
};
