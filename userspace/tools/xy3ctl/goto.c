// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl goto: move the mirrors to a position.
 */
#include <errno.h>
#include <json-c/json.h>
#include <libxy3.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cli.h"
#include "forward.h"
#include "number.h"
#include "verbs.h"

struct settings {
	struct cli_common common;
	struct forward_settings forward;
	bool unit;
	unsigned int count;
	struct place {
		char axis[2];
		const char *value;
	} places[XY3_AXES];
};

static const struct argp_option options[] = {
	{ "unit", 'u', NULL, 0,
	  "Values are from -1 to 1, with 0 in the middle, instead of codes", 0 },
	{ 0 }
};

static void take(struct settings *settings, const char *argument, struct argp_state *state)
{
	const char *equals = strchr(argument, '=');
	struct place *place = &settings->places[settings->count];

	if (settings->count == XY3_AXES)
		argp_error(state, "a head has %d axes", XY3_AXES);
	if (equals && (equals - argument != 1 || !strchr("xyzuw", *argument)))
		argp_error(state, "%s: an axis is a letter out of xyzuw", argument);
	snprintf(place->axis, sizeof(place->axis), "%s",
		 equals ? argument : xy3_axis_name(settings->count));
	place->value = equals ? equals + 1 : argument;
	settings->count++;
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct settings *settings = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[FORWARD_CHILD_COMMON] = &settings->common;
		state->child_inputs[FORWARD_CHILD_FORWARD] = &settings->forward;
		return 0;
	case 'u':
		settings->unit = true;
		return 0;
	case ARGP_KEY_ARG:
		take(settings, argument, state);
		return 0;
	case ARGP_KEY_NO_ARGS:
		argp_error(state, "missing position");
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static const struct argp argp = {
	.options = options, .parser = parse, .children = forward_children,
	.args_doc = "[AXIS=]VALUE...",
	.doc = "Move the mirrors of a scanhead to a position."
	       "\v"
	       "AXIS is one of x y z u w; without it values are for x, y, z, u and w in this "
	       "order. "
	       "A code is a whole number from 0 to 1048575, or to 67108863 with frames of 32 bits; "
	       "0x prefixes are accepted. With --unit, write negative numbers as x=-0.5 or after "
	       "--. Axes that are not named keep their position; with --spidev they "
	       "go to the middle. All axes move at once, by one scan: for a path, see "
	       "`xy3ctl stream'.\n\n"
	       "  xy3ctl goto 524288 524288\n"
	       "  xy3ctl goto --unit x=0.5 y=-0.5",
};

/* Return an enum cli_status */
static int code_of(const struct settings *settings, const struct place *place, uint32_t top,
		   uint32_t *code)
{
	double unit = 0;
	long number = 0;
	int error;

	error = settings->unit ? number_real(place->value, -1, 1, &unit) :
				 number_code(place->value, 0, top, &number);
	if (error == -EINVAL)
		return cli_usage("%s: '%s' is not a %snumber", place->axis, place->value,
				 settings->unit ? "" : "whole ");
	if (error && settings->unit)
		return cli_error("%s=%s: must be from -1 to 1", place->axis, place->value);
	if (error)
		return cli_error("%s=%s: must be from 0 to %u", place->axis, place->value, top);
	*code = settings->unit ? lrint((unit + 1) / 2 * top) : number;
	return CLI_OK;
}

static int index_of(const struct forward *forward, const char *name)
{
	for (unsigned int i = 0; i < forward_axes(forward); i++) {
		if (!strcmp(xy3_axis_name(forward_axis(forward, i)), name))
			return i;
	}
	return -1;
}

static int go(const struct settings *settings, struct forward *forward)
{
	struct json_object *document, *codes;
	uint32_t scan[XY3_AXES];
	bool chosen[XY3_AXES] = { 0 };
	int status;

	/* all arguments are checked before anything is set, or moves */
	for (unsigned int i = 0; i < settings->count; i++) {
		const struct place *place = &settings->places[i];
		int index = index_of(forward, place->axis);

		if (index < 0)
			return cli_usage("%s has no axis %s", forward_name(forward), place->axis);
		if (chosen[index])
			return cli_usage("axis %s is given twice", place->axis);
		status = code_of(settings, place, forward_top(forward), &scan[index]);
		if (status)
			return status;
		chosen[index] = true;
	}
	status = forward_apply(forward);
	if (!status)
		status = forward_move(forward, scan, chosen);
	if (status || !settings->common.json)
		return status;
	document = cli_json_new("goto");
	cli_json_text(document, "head", forward_name(forward));
	codes = json_object_new_object();
	for (unsigned int i = 0; i < forward_axes(forward); i++) {
		if (chosen[i])
			cli_json_number(codes, xy3_axis_name(forward_axis(forward, i)), scan[i]);
	}
	json_object_object_add(document, "codes", codes);
	return cli_json_print(document);
}

int goto_verb(int argc, char **argv)
{
	struct settings settings = { 0 };
	struct forward *forward;
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &settings);
	status = forward_open(&forward, &settings.forward, settings.common.device);
	if (status)
		return status;
	status = go(&settings, forward);
	forward_close(forward);
	return status;
}
