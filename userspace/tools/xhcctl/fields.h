/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The fields of a pendant's display: attributes in dro/, one table for show, set and monitor. Which
 * of them a model has is in model.h.
 */
#ifndef FIELDS_H
#define FIELDS_H

#include <stdio.h>

#include "pendant.h"

struct json_object;
struct model;

enum field_index {
	WORK_X, WORK_Y, WORK_Z, MACHINE_X, MACHINE_Y, MACHINE_Z,
	ROW1, ROW2, ROW3,
	FEEDRATE_OVERRIDE, SPINDLE_OVERRIDE, FEEDRATE, SPINDLE_SPEED,
	STEP, ICON, STATE, DAY, MODE, COORDINATES, RESET, REFRESH_MS,
	FIELDS,
	/* to be written only: they read as the coordinates that they are */
	POSITION = FIELDS, ROWS,
	SETTABLE
};

struct field {
	const char *name;
	const char *range;	/* in words; NULL: see field_print_range() */
	bool number;		/* a JSON number, whenever it is one */
	enum field_index group;	/* that it is a part of; 0: of none */
};

extern const struct field fields[SETTABLE];

/* What a value may be, for messages */
void field_print_range(FILE *stream, enum field_index index, const struct pendant *pendant);

/* By name; SETTABLE when there is none */
enum field_index field_find(const char *name, size_t length);

#define FIELD_TEXT	128

struct values {
	const struct model *model;
	char text[FIELDS][FIELD_TEXT];
};

/* Return 0 or a negative errno: -ENOENT, -ENODEV when the pendant is gone. */
int values_read(const struct pendant *pendant, struct values *values);

/* Those that the model has as members of an object */
struct json_object *values_json(const struct values *values);

#endif /* FIELDS_H */
