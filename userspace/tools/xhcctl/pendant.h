/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The pendants of hid-xhc, from udev and sysfs
 */
#ifndef PENDANT_H
#define PENDANT_H

#include <stdbool.h>
#include <stddef.h>

struct model;

struct pendant {
	unsigned int index;	/* among all, in the order of their names */
	char name[64];		/* of the HID device: 0003:10CE:EB70.0001 */
	char path[512];		/* its folder in sysfs */
	char model[16];
	const struct model *model_row;	/* properties known to the tool */
	char input[64];		/* name of the input device; empty: there is none (yet) */
	char event[64];		/* node; empty: none (yet) */
	char hidraw[64];	/* node; empty: the kernel has no hidraw */
	char phys[96];
	char layout[64];	/* name of the chosen one; empty: none was chosen */
	bool awake;
};

struct pendants {
	size_t count;
	struct pendant *item;
};

/* Return 0 or a negative errno. The caller frees the list in any case. */
int pendants_find(struct pendants *list);
void pendants_free(struct pendants *list);

/*
 * The selected pendant: that given by name, or the only one. Return CLI_OK; another enum cli_status
 * if there is none, or several, which has been reported.
 */
int pendants_choose(const struct pendants *list, const char *name, struct pendant *pendant);
/* The same in a list of all pendants */
int pendant_choose(const char *name, struct pendant *pendant);

/* Whether it still exists */
bool pendant_present(const struct pendant *pendant);

#endif /* PENDANT_H */
