// SPDX-License-Identifier: GPL-2.0-only
/*
 * The file of udev's hwdb that selects a key layout. See hwdb.h.
 */
#include <errno.h>
#include <fcntl.h>
#include <linux/input.h>
#include <spawn.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli.h"
#include "hwdb.h"
#include "layout.h"
#include "pendant.h"

/* of udevd, while it runs */
#define UDEVD_SOCKET			"/run/udev/control"
#define HWDB_BIN			"/etc/udev/hwdb.bin"
#define HWDB_BIN_OF_DISTRIBUTION	"/usr/lib/udev/hwdb.bin"

char *hwdb_path(const char *root)
{
	char *path;

	return asprintf(&path, "%s%s", root ?: "", HWDB_FILE) < 0 ? NULL : path;
}

static int failed(const char *path, int err)
{
	if (err == EACCES)
		return cli_error("%s: permission denied: run this as root", path);
	return cli_errno(err, "%s", path);
}

/* Create the folders of a file, below the first existing one */
static int make_folders(char *path)
{
	for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
		int err;

		*slash = '\0';
		err = mkdir(path, 0755) && errno != EEXIST ? errno : 0;
		if (err == EROFS && !access(path, F_OK))
			err = 0;
		*slash = '/';
		if (err)
			return err;
	}
	return 0;
}

static int fill(int fd, const char *entry)
{
	FILE *stream = fdopen(fd, "w");
	int err = 0;

	if (!stream) {
		err = errno;
		close(fd);
		return err;
	}
	if (fputs(entry, stream) < 0 || fflush(stream) || fchmod(fd, 0644) || fsync(fd))
		err = errno;
	if (fclose(stream) && !err)
		err = errno;
	return err;
}

int hwdb_write(const char *path, const char *entry)
{
	char *new;
	int err, fd;

	/* udev ignores names that do not end with .hwdb */
	if (asprintf(&new, "%s.XXXXXX", path) < 0)
		return cli_errno(ENOMEM, "%s", path);
	err = make_folders(new);
	if (!err) {
		fd = mkstemp(new);
		err = fd < 0 ? errno : fill(fd, entry);
		if (!err && rename(new, path))
			err = errno;
		if (err && fd >= 0)
			unlink(new);
	}
	free(new);
	return err ? failed(path, err) : CLI_OK;
}

int hwdb_remove(const char *path)
{
	if (unlink(path) && errno != ENOENT)
		return failed(path, errno);
	return CLI_OK;
}

static int run(char *const argv[])
{
	int err, status;
	pid_t child;

	err = posix_spawnp(&child, argv[0], NULL, NULL, argv, environ);
	if (err)
		return cli_errno(err, "%s", argv[0]);
	while (waitpid(child, &status, 0) < 0) {
		if (errno != EINTR)
			return cli_errno(errno, "%s", argv[0]);
	}
	if (!WIFEXITED(status) || WEXITSTATUS(status))
		return cli_error("%s %s has failed", argv[0], argv[1]);
	return CLI_OK;
}

/* Whether both files exist and have the same content */
static bool same(const char *one, const char *two)
{
	FILE *a = fopen(one, "re"), *b = fopen(two, "re");
	bool equal = a && b;

	while (equal) {
		int byte = getc_unlocked(a);

		equal = byte == getc_unlocked(b);
		if (byte == EOF)
			break;
	}
	equal = equal && !ferror(a) && !ferror(b);
	if (a)
		fclose(a);
	if (b)
		fclose(b);
	return equal;
}

/*
 * systemd-hwdb compiles all entries to HWDB_BIN. With only entries of the distribution it is a copy
 * of the file of the distribution, which was sufficient before.
 */
static int compile(void)
{
	char *const update[] = { "systemd-hwdb", "update", NULL };
	int status = run(update);

	if (status == CLI_OK && same(HWDB_BIN, HWDB_BIN_OF_DISTRIBUTION))
		status = hwdb_remove(HWDB_BIN);
	return status;
}

/* udevd of systemd 252 sometimes closes the connection of udevadm: retry. */
static int ask_udevd(char *const argv[])
{
	int status = CLI_FAILURE;

	for (unsigned int attempt = 0; attempt < 3 && status != CLI_OK; attempt++)
		status = run(argv);
	return status;
}

/* udevd detects a new file by itself, but checks at most every three seconds. */
static int reload(void)
{
	char *const control[] = { "udevadm", "control", "--reload", NULL };

	return ask_udevd(control);
}

static int settle(void)
{
	char *const wait[] = { "udevadm", "settle", "--timeout=60", NULL };

	return ask_udevd(wait);
}

static int give_code(int fd, unsigned int scan, unsigned int code)
{
	unsigned int pair[2] = { scan, code };

	/* EINVAL: this model has no such key */
	if (ioctl(fd, EVIOCSKEYCODE, pair) && errno != EINVAL)
		return errno;
	return 0;
}

/*
 * The codes that the driver has assigned to keys and positions of the selector. udev sets other
 * codes, but does not restore these when an entry is removed.
 */
static int give_first_codes(const char *node)
{
	int fd = open(node, O_RDONLY | O_CLOEXEC), err = 0;

	if (fd < 0)
		err = errno;
	for (unsigned int scan = 1; scan <= LAYOUT_KEYS && !err; scan++)
		err = give_code(fd, scan, BTN_TRIGGER_HAPPY1 + scan - 1);
	for (unsigned int position = 1; position <= LAYOUT_POSITIONS && !err; position++)
		err = give_code(fd, LAYOUT_SELECTOR + position, BTN_TRIGGER_HAPPY31 + position - 1);
	if (fd >= 0)
		close(fd);
	/* it has been unplugged */
	if (err == ENODEV || err == ENOENT || err == ENXIO)
		err = 0;
	return err ? cli_errno(err, "%s", node) : CLI_OK;
}

/*
 * Events from before the reload must be complete: they set the codes of the old entries. The
 * trigger sets those of the new ones.
 */
static int apply_to(char *node)
{
	char *const trigger[] = { "udevadm", "trigger", node, NULL };
	int status = settle();

	if (status == CLI_OK)
		status = give_first_codes(node);
	if (status == CLI_OK)
		status = run(trigger);
	if (status == CLI_OK)
		status = settle();
	return status;
}

int hwdb_apply(void)
{
	struct pendants list;
	int status, err;

	status = compile();
	/* in a container there may be no udevd, and no keys with other codes */
	if (status != CLI_OK || access(UDEVD_SOCKET, F_OK))
		return status;
	status = reload();
	if (status != CLI_OK)
		return status;
	err = pendants_find(&list);
	if (err)
		status = cli_errno(err, "pendants");
	for (size_t i = 0; i < list.count && status == CLI_OK; i++) {
		if (*list.item[i].event)
			status = apply_to(list.item[i].event);
	}
	pendants_free(&list);
	return status;
}

void hwdb_say(const char *root)
{
	struct pendants list;

	if (root) {
		fprintf(stderr, "To activate it:\n  systemd-hwdb update --root=%s\n", root);
		return;
	}
	fprintf(stderr, "To activate it:\n  systemd-hwdb update\n  udevadm control --reload\n");
	if (!pendants_find(&list)) {
		for (size_t i = 0; i < list.count; i++) {
			if (*list.item[i].event)
				fprintf(stderr, "  udevadm trigger %s\n", list.item[i].event);
		}
	}
	pendants_free(&list);
}
