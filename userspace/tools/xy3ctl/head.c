// SPDX-License-Identifier: GPL-2.0-only
/*
 * Scanheads in sysfs. See head.h.
 */
#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <glob.h>
#include <libgen.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "head.h"
#include "sysfs.h"

#define CLASS "/sys/class/xy3"
#define COUNTERS "/sys/kernel/debug/xy3-spi"

/* The last component of the first path that matches the pattern, "" if none does */
static void first_match(char *name, size_t size, const char *pattern)
{
	glob_t found;

	name[0] = '\0';
	if (!glob(pattern, 0, NULL, &found))
		snprintf(name, size, "%s", basename(found.gl_pathv[0]));
	globfree(&found);
}

/* The name of the target of a link in the folder of the head, "" if there is no such link */
static void link_name(const struct head *head, const char *link, char *name, size_t size)
{
	char path[PATH_MAX], *target;

	name[0] = '\0';
	snprintf(path, sizeof(path), "%s/%s", head->path, link);
	target = realpath(path, NULL);
	if (!target)
		return;
	snprintf(name, size, "%s", basename(target));
	free(target);
}

static void look(struct head *head, unsigned int number)
{
	char pattern[128];

	memset(head, 0, sizeof(*head));
	snprintf(head->name, sizeof(head->name), "xy3-%u", number);
	snprintf(head->path, sizeof(head->path), CLASS "/%s", head->name);
	snprintf(head->node, sizeof(head->node), "/dev/%s", head->name);
	link_name(head, "back", head->back, sizeof(head->back));
	link_name(head, "forward", head->forward, sizeof(head->forward));
	snprintf(pattern, sizeof(pattern), "%s/forward/iio:device*", head->path);
	first_match(head->iio, sizeof(head->iio), pattern);
}

/* The number in the name of a head; -1 if it is not a head */
static long number_of(const char *name)
{
	char *end;
	long number;

	if (!strncmp(name, "/dev/", 5))
		name += 5;
	if (!strncmp(name, "xy3-", 4))
		name += 4;
	if (!isdigit((unsigned char)*name))
		return -1;
	number = strtol(name, &end, 10);
	return *end || number >= HEADS_MAX ? -1 : number;
}

static bool is_there(long number)
{
	char text[8];

	/* every head has it */
	return sysfs_read(text, sizeof(text), CLASS "/xy3-%ld/in_sync", number) >= 0;
}

size_t head_list(struct head heads[HEADS_MAX])
{
	size_t count = 0;

	for (long number = 0; number < HEADS_MAX; number++) {
		if (is_there(number))
			look(&heads[count++], number);
	}
	return count;
}

int head_find(struct head *head, const char *name)
{
	struct head heads[HEADS_MAX];
	long number = 0;

	if (!name || !strcmp(name, "/dev/xy3")) {
		if (!head_list(heads))
			return cli_no_device("no scanhead; `xy3ctl doctor' looks for the reason");
		*head = heads[0];
		return CLI_OK;
	}
	number = number_of(name);
	if (number < 0 || !is_there(number))
		return cli_no_device("no scanhead %s", name);
	look(head, number);
	return CLI_OK;
}

int head_read(const struct head *head, const char *name, char *text, size_t size)
{
	return sysfs_read(text, size, "%s/%s", head->path, name);
}

int head_read_iio(const struct head *head, const char *name, long long *number)
{
	if (!head->iio[0])
		return -ENODEV;
	return sysfs_read_number(number, "/sys/bus/iio/devices/%s/%s", head->iio, name);
}

int head_read_counter(const struct head *head, const char *name, long long *number)
{
	if (!head->forward[0])
		return -ENODEV;
	return sysfs_read_number(number, COUNTERS "/%s/%s", head->forward, name);
}

int head_write(const struct head *head, const char *name, const char *text)
{
	return sysfs_write(text, "%s/%s", head->path, name);
}

int head_write_iio(const struct head *head, const char *name, long long number)
{
	char text[32];

	if (!head->iio[0])
		return -ENODEV;
	snprintf(text, sizeof(text), "%lld", number);
	return sysfs_write(text, "/sys/bus/iio/devices/%s/%s", head->iio, name);
}

int head_temperature(const struct head *head, unsigned int component, long *millidegrees)
{
	char pattern[128], hwmon[32];
	long long number;

	snprintf(pattern, sizeof(pattern), "%s/hwmon[0-9]*", head->path);
	first_match(hwmon, sizeof(hwmon), pattern);
	/* temp1 is the first component */
	if (!hwmon[0] || sysfs_read_number(&number, "%s/%s/temp%u_input", head->path, hwmon,
					   component + 1))
		return -ENODATA;
	*millidegrees = number;
	return 0;
}

unsigned int head_axes(const struct head *head)
{
	char text[16];
	unsigned int axes = 0;

	while (head->iio[0] && axes < XY3_AXES &&
	       sysfs_read(text, sizeof(text), "/sys/bus/iio/devices/%s/out_angl%u_raw", head->iio,
			  axes) >= 0)
		axes++;
	return axes;
}
