/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The fields of the display of a pendant: attributes in dro/, one table for show, set and monitor.
 * The fields of each model are in model.h.
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
	/* write only: they are read as the coordinates */
	POSITION = FIELDS, ROWS,
	SETTABLE
};

struct field {
	const char *name;
	const char *range;	/* as text; NULL: see field_print_range() */
	bool number;		/* a JSON number, if it is a number */
	enum field_index group;	/* the group with this field; 0: none */
};

extern const struct field fields[SETTABLE];

/* The range of a value, for messages */
void field_print_range(FILE *stream, enum field_index index, const struct pendant *pendant);

/* By name; SETTABLE if there is none */
enum field_index field_find(const char *name, size_t length);

#define FIELD_TEXT	128

struct values {
	const struct model *model;
	char text[FIELDS][FIELD_TEXT];
};

/* Return 0 or a negative errno: -ENOENT, -ENODEV if the pendant was removed. */
int values_read(const struct pendant *pendant, struct values *values);

/* The fields of the model as members of an object */
struct json_object *values_json(const struct values *values);

#endif /* FIELDS_H */
