/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The pendants that hid-xhc drives, as udev and sysfs show them
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
	const struct model *model_row;	/* what the tool knows of it */
	char input[64];		/* name of the input device; empty: there is none (yet) */
	char event[64];		/* node; empty likewise */
	char hidraw[64];	/* node; empty: the kernel has no hidraw */
	char phys[96];
	char layout[64];	/* the chosen one's name; empty: none was chosen */
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
 * The one that the user means: that named, or the only one. Return CLI_OK; another enum cli_status
 * when that is none or when there are several, and it has been said.
 */
int pendants_choose(const struct pendants *list, const char *name, struct pendant *pendant);
/* The same among all that are there */
int pendant_choose(const char *name, struct pendant *pendant);

/* Is it still there? */
bool pendant_present(const struct pendant *pendant);

#endif /* PENDANT_H */
