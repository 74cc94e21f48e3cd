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
#include "lcd.h"
#include "sysfs.h"

/* What the driver takes; a test holds it against the driver */
#define RANGE_WORD	"0..65535"

const struct field fields[SETTABLE] = {
	[WORK_X] = { "work_x", NULL, true },
	[WORK_Y] = { "work_y", NULL, true },
	[WORK_Z] = { "work_z", NULL, true },
	[MACHINE_X] = { "machine_x", NULL, true },
	[MACHINE_Y] = { "machine_y", NULL, true },
	[MACHINE_Z] = { "machine_z", NULL, true },
	[FEEDRATE_OVERRIDE] = { "feedrate_override", RANGE_WORD, true },
	[SPINDLE_OVERRIDE] = { "spindle_override", RANGE_WORD, true },
	[FEEDRATE] = { "feedrate", RANGE_WORD, true },
	[SPINDLE_SPEED] = { "spindle_speed", RANGE_WORD, true },
	[STEP] = { "step", NULL, true },
	[ICON] = { "icon", "0..15", true },
	[STATE] = { "state", NULL, false },
	[DAY] = { "day", "1..31 or auto", true },
	[REFRESH_MS] = { "refresh_ms", "10..1000", true },
	[POSITION] = { "position", NULL, false },
};

void field_print_range(FILE *stream, enum field_index index, const struct pendant *pendant)
{
	unsigned int decimals = lcd_decimals(pendant->model);
	char steps[FIELD_TEXT];

	if (fields[index].range) {
		fputs(fields[index].range, stream);
	} else if (index == STEP) {
		if (sysfs_read(steps, sizeof(steps), "%s/dro/step_available", pendant->path) < 0)
			snprintf(steps, sizeof(steps), "those in step_available");
		fprintf(stream, "one of %s, or a code 0x0..0xf", steps);
	} else if (index == STATE) {
		fprintf(stream, "idle, run, pause%s, joined by +, or a number 0..255",
			decimals == 4 ? ", inch" : "");
	} else {
		fprintf(stream, "%s-65535.%.*s..65535.%.*s", index == POSITION ? "six of " : "",
			(int)decimals, "9999", (int)decimals, "9999");
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

/* By the one attribute that has all six of the same moment */
static int read_position(const struct pendant *pendant, struct values *values)
{
	char text[FIELD_TEXT], *rest = text;
	int length;

	length = sysfs_read(text, sizeof(text), "%s/dro/position", pendant->path);
	if (length < 0)
		return length;
	for (enum field_index i = WORK_X; i <= MACHINE_Z; i++) {
		const char *word = strsep(&rest, " ");

		if (!word)
			return -EIO;
		snprintf(values->text[i], sizeof(values->text[i]), "%s", word);
	}
	return 0;
}

int values_read(const struct pendant *pendant, struct values *values)
{
	int err = read_position(pendant, values);

	if (err)
		return err;
	for (enum field_index i = MACHINE_Z + 1; i < FIELDS; i++) {
		int length = sysfs_read(values->text[i], sizeof(values->text[i]), "%s/dro/%s",
					pendant->path, fields[i].name);

		if (length < 0)
			return length;
	}
	return 0;
}

/* As the driver has written it, with all its digits; JSON has no hexadecimal numbers */
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
		if (fields[i].number)
			json_object_object_add(object, fields[i].name,
					       value_json(values->text[i]));
		else
			cli_json_text(object, fields[i].name, values->text[i]);
	}
	return object;
}
