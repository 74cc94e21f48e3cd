// SPDX-License-Identifier: GPL-2.0-only
/*
 * The file of udev's hwdb that chooses a keycap layout. See hwdb.h.
 */
#include <errno.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "cli.h"
#include "hwdb.h"
#include "pendant.h"

#define NODES_MAX	16

char *hwdb_path(const char *root)
{
	char *path;

	return asprintf(&path, "%s%s", root ?: "", HWDB_FILE) < 0 ? NULL : path;
}

/* The folders of a file, below the first one that is there */
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

	/* udev reads no name that does not end in .hwdb */
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
	return err ? cli_errno(err, "%s", path) : CLI_OK;
}

int hwdb_remove(const char *path)
{
	if (unlink(path) && errno != ENOENT)
		return cli_errno(errno, "%s", path);
	return CLI_OK;
}

static int run(char **argv)
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

int hwdb_apply(void)
{
	char *update[3] = { 0 };
	char *trigger[2 + NODES_MAX + 1] = { 0 };
	struct pendants list;
	size_t count = 0;
	int status, err;

	update[0] = "systemd-hwdb";
	update[1] = "update";
	trigger[0] = "udevadm";
	trigger[1] = "trigger";
	status = run(update);
	if (status != CLI_OK)
		return status;
	err = pendants_find(&list);
	if (err)
		status = cli_errno(err, "pendants");
	for (size_t i = 0; i < list.count && count < NODES_MAX; i++) {
		if (*list.item[i].event)
			trigger[2 + count++] = list.item[i].event;
	}
	/* without a node it would be everything that udev knows */
	if (count)
		status = run(trigger);
	pendants_free(&list);
	return status;
}

void hwdb_say(const char *root)
{
	struct pendants list;

	if (root) {
		fprintf(stderr, "To put it to work:\n  systemd-hwdb update --root=%s\n", root);
		return;
	}
	fprintf(stderr, "To put it to work:\n  systemd-hwdb update\n");
	if (!pendants_find(&list)) {
		for (size_t i = 0; i < list.count; i++) {
			if (*list.item[i].event)
				fprintf(stderr, "  udevadm trigger %s\n", list.item[i].event);
		}
	}
	pendants_free(&list);
}
