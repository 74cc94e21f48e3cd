// SPDX-License-Identifier: GPL-2.0-only
/*
 * The fields of a pendant's display. See fields.h.
 */
#include <errno.h>
#include <json-c/json.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "fields.h"
#include "model.h"
#include "sysfs.h"

/* What the driver accepts; a test compares it with the driver */
#define RANGE_WORD	"0..65535"

const struct field fields[SETTABLE] = {
	[WORK_X] = { "work_x", NULL, true, POSITION },
	[WORK_Y] = { "work_y", NULL, true, POSITION },
	[WORK_Z] = { "work_z", NULL, true, POSITION },
	[MACHINE_X] = { "machine_x", NULL, true, POSITION },
	[MACHINE_Y] = { "machine_y", NULL, true, POSITION },
	[MACHINE_Z] = { "machine_z", NULL, true, POSITION },
	[ROW1] = { "row1", NULL, true, ROWS },
	[ROW2] = { "row2", NULL, true, ROWS },
	[ROW3] = { "row3", NULL, true, ROWS },
	[FEEDRATE_OVERRIDE] = { "feedrate_override", RANGE_WORD, true, 0 },
	[SPINDLE_OVERRIDE] = { "spindle_override", RANGE_WORD, true, 0 },
	[FEEDRATE] = { "feedrate", RANGE_WORD, true, 0 },
	[SPINDLE_SPEED] = { "spindle_speed", RANGE_WORD, true, 0 },
	[STEP] = { "step", NULL, true, 0 },
	[ICON] = { "icon", "0..15", true, 0 },
	[STATE] = { "state", NULL, false, 0 },
	[DAY] = { "day", "1..31 or auto", true, 0 },
	[MODE] = { "mode", "continuous, step, mpg or percent", false, 0 },
	[COORDINATES] = { "coordinates", "machine or work", false, 0 },
	[RESET] = { "reset", "0 or 1", true, 0 },
	[REFRESH_MS] = { "refresh_ms", "10..1000", true, 0 },
	[POSITION] = { "position", NULL, false, 0 },
	[ROWS] = { "rows", NULL, false, 0 },
};

void field_print_range(FILE *stream, enum field_index index, const struct pendant *pendant)
{
	const struct model *model = pendant->model_row;
	int decimals = model->decimals;
	char steps[FIELD_TEXT];

	if (fields[index].range) {
		fputs(fields[index].range, stream);
	} else if (index == STEP) {
		if (sysfs_read(steps, sizeof(steps), "%s/dro/step_available", pendant->path) < 0)
			snprintf(steps, sizeof(steps), "those in step_available");
		fprintf(stream, "one of %s, or a code 0x0..0xf", steps);
	} else if (index == STATE) {
		fprintf(stream, "%s, joined by +, or a number 0..255", model->states);
	} else {
		fprintf(stream, "%s-65535.%.*s..65535.%.*s",
			index == POSITION ? "six of " : index == ROWS ? "three of " : "",
			decimals, "9999", decimals, "9999");
	}
}

enum field_index field_find(const char *name, size_t length)
{
	enum field_index index = 0;

	while (index < SETTABLE && (strlen(fields[index].name) != length ||
				    strncmp(fields[index].name, name, length)))
		index++;
	return index;
}

/* From the attribute that has all of them, read at the same time */
static int read_coordinates(const struct pendant *pendant, struct values *values)
{
	const struct model *model = values->model;
	char text[FIELD_TEXT], *rest = text;
	int length;

	length = sysfs_read(text, sizeof(text), "%s/dro/%s", pendant->path,
			    fields[model->group].name);
	if (length < 0)
		return length;
	for (enum field_index i = model->first; i <= model->last; i++) {
		const char *word = strsep(&rest, " ");

		if (!word)
			return -EIO;
		snprintf(values->text[i], sizeof(values->text[i]), "%s", word);
	}
	return 0;
}

int values_read(const struct pendant *pendant, struct values *values)
{
	int err;

	*values = (struct values){ .model = pendant->model_row };
	err = values->model->fields ? read_coordinates(pendant, values) : 0;
	if (err)
		return err;
	for (enum field_index i = 0; i < FIELDS; i++) {
		int length;

		if (!model_has(values->model, i) || fields[i].group)
			continue;
		length = sysfs_read(values->text[i], sizeof(values->text[i]), "%s/dro/%s",
				    pendant->path, fields[i].name);
		if (length < 0)
			return length;
	}
	return 0;
}

/* As printed by the driver, with all digits; JSON has no hexadecimal numbers */
static struct json_object *value_json(const char *text)
{
	char *end;
	double value = strtod(text, &end);

	if (*end || strchr(text, 'x'))
		return json_object_new_string(text);
	return json_object_new_double_s(value, text);
}

struct json_object *values_json(const struct values *values)
{
	struct json_object *object = json_object_new_object();

	for (enum field_index i = 0; i < FIELDS; i++) {
		if (!model_has(values->model, i))
			continue;
		if (i == RESET)
			cli_json_bool(object, fields[i].name, atoi(values->text[i]));
		else if (fields[i].number)
			json_object_object_add(object, fields[i].name,
					       value_json(values->text[i]));
		else
			cli_json_text(object, fields[i].name, values->text[i]);
	}
	return object;
}
