/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Key layouts: the labels of the keys of a pendant. userspace/hwdb/README has the format of their
 * files.
 */
#ifndef LAYOUT_H
#define LAYOUT_H

#include <stdio.h>

#include "pendant.h"

#define LAYOUT_SUFFIX	".layout"
#define LAYOUT_KEYS	0x17	/* scan codes 01h..17h */
#define LAYOUT_SELECTOR	0x20	/* its positions have scan codes, too: 21h.. */
#define LAYOUT_POSITIONS	8

struct layout_key {
	char caption[32];	/* empty: the pendant has no such key */
	char code[40];		/* KEY_STOP; empty: none fits */
	char fn[32];		/* caption while Fn is held; empty: none */
};

struct layout {
	char name[64];
	char title[64];
	char match[128];	/* of udev, for pendants with such keys */
	unsigned int fn;	/* scan code of the key Fn, 0: there is none */
	struct layout_key key[LAYOUT_KEYS + 1];	/* by scan code */
};

/* The folders with layouts, in the order of the search, terminated by NULL */
const char *const *layout_folders(void);

/* Whether this is a valid name. It becomes the name of a file. */
bool layout_name_ok(const char *name);

/* Return CLI_OK; CLI_USAGE: there is none of this name; CLI_FAILURE: it is invalid. */
int layout_read(const char *name, struct layout *layout);

/* Name of the layout whose captions are shown for a pendant: the chosen one, or its model's */
const char *layout_name(const struct pendant *pendant);

/* The label of a key, or NULL. fn: for a key that is pressed while Fn is held */
const char *layout_caption(const struct layout *layout, unsigned int scan, bool fn);

/*
 * The entry of udev's hwdb that selects a layout, with a comment on each key. pendant: only for
 * this one, by its port; NULL for all of the model. captions: only the name of the layout, without
 * codes of keys.
 */
void layout_entry(FILE *stream, const struct layout *layout, const struct pendant *pendant,
		  bool captions);

#endif /* LAYOUT_H */
