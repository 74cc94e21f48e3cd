// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl set
 */
#include <errno.h>
#include <json-c/json.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fields.h"
#include "model.h"
#include "sysfs.h"
#include "verbs.h"

struct assignment {
	enum field_index field;
	const char *value;
	char old[FIELD_TEXT];
};

struct options {
	struct cli_common common;
	bool wait;
	size_t count;
	struct assignment assignment[SETTABLE];
};

static const struct argp_option option_table[] = {
	{ "wait", 'w', NULL, 0, "Wait for the transfer, and report its error", 0 },
	{ 0 }
};

static const char doc[] =
	"Set values of the display."
	"\v"
	"Fields of HB03 and HB04: work_x work_y work_z machine_x machine_y machine_z, or all six in one "
	"as position; feedrate_override spindle_override feedrate spindle_speed; step icon state day. "
	"Fields of WHB04B: row1 row2 row3, or all three in one as rows; feedrate_override "
	"spindle_override; mode coordinates reset. All have refresh_ms, the minimum time between "
	"two frames. An error names the valid values of a field.\n\n"
	"Several fields are set together: if one of them is refused, all keep their values. They "
	"reach the display in one frame, unless the machine is too busy to write them within 5 ms. "
	"Without --wait the command ends before the frame has been sent.\n\n"
	"  xhcctl set work_x=135.17 work_y=-77.89 state=run step=10\n"
	"  xhcctl set position='135.17 -77.89 0 -220.334 0 1.5'\n"
	"  xhcctl set rows='135.17 -77.89 0' mode=step coordinates=work reset=0";

/* Exits after a usage error */
static void add_assignment(struct options *options, const char *argument,
			   struct argp_state *state)
{
	const char *equals = strchr(argument, '=');
	struct assignment *assignment;
	enum field_index field;

	if (!equals)
		argp_error(state, "%s: FIELD=VALUE is required", argument);
	field = field_find(argument, equals - argument);
	if (field == SETTABLE)
		argp_error(state, "no field %.*s", (int)(equals - argument), argument);
	for (size_t i = 0; i < options->count; i++) {
		enum field_index other = options->assignment[i].field;

		if (field == other)
			argp_error(state, "%s is given twice", fields[field].name);
		if (fields[other].group == field && field >= FIELDS)
			argp_error(state, "%s is a part of %s", fields[other].name,
				   fields[field].name);
		if (fields[field].group == other && other >= FIELDS)
			argp_error(state, "%s is a part of %s", fields[field].name,
				   fields[other].name);
	}
	assignment = &options->assignment[options->count++];
	assignment->field = field;
	assignment->value = equals + 1;
}

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct options *options = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[0] = &options->common;
		return 0;
	case 'w':
		options->wait = true;
		return 0;
	case ARGP_KEY_ARG:
		add_assignment(options, argument, state);
		return 0;
	case ARGP_KEY_NO_ARGS:
		argp_error(state, "nothing to set");
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

/* Before anything is written */
static int check_fields(const struct pendant *pendant, const struct options *options)
{
	for (size_t i = 0; i < options->count; i++) {
		enum field_index field = options->assignment[i].field;

		if (!model_has(pendant->model_row, field))
			return cli_usage("the %s has no %s, see `%s show'", pendant->model,
					 fields[field].name, cli_tool_name());
	}
	return CLI_OK;
}

static int write_field(const struct pendant *pendant, enum field_index field, const char *value)
{
	/* an empty write would not reach the driver */
	return sysfs_write(*value ? value : "\n", "%s/dro/%s", pendant->path,
			   fields[field].name);
}

static int refused(const struct pendant *pendant, const struct assignment *assignment, int err)
{
	const char *name = fields[assignment->field].name;
	size_t size = 0;
	char *range = NULL;
	FILE *stream;
	int status;

	if (!pendant_present(pendant))
		return cli_no_device("%s has gone", pendant->name);
	if (err == -EACCES)
		return cli_error("%s: permission denied: join the group dialout", name);
	if (err != -EINVAL && err != -ERANGE)
		return cli_errno(err, "%s", name);
	stream = open_memstream(&range, &size);
	if (!stream)
		return cli_errno(errno, "%s", name);
	field_print_range(stream, assignment->field, pendant);
	fclose(stream);
	status = cli_error("%s: \"%s\" is %s: %s", name, assignment->value,
			   err == -ERANGE ? "out of range" : "not a value", range);
	free(range);
	return status;
}

/* The driver checks each value as it is written: restore those before one that it refuses. */
static int write_all(const struct pendant *pendant, struct options *options)
{
	for (size_t i = 0; i < options->count; i++) {
		struct assignment *assignment = &options->assignment[i];
		int err = sysfs_read(assignment->old, sizeof(assignment->old), "%s/dro/%s",
				     pendant->path, fields[assignment->field].name);

		if (err < 0)
			return refused(pendant, assignment, err);
	}
	for (size_t i = 0; i < options->count; i++) {
		struct assignment *assignment = &options->assignment[i];
		int err = write_field(pendant, assignment->field, assignment->value);

		if (!err)
			continue;
		while (i-- > 0)
			write_field(pendant, options->assignment[i].field,
				    options->assignment[i].old);
		return refused(pendant, assignment, err);
	}
	return CLI_OK;
}

static int flush(const struct pendant *pendant)
{
	int err = sysfs_write("1", "%s/dro/flush", pendant->path);

	if (!err)
		return CLI_OK;
	if (!pendant_present(pendant))
		return cli_no_device("%s has gone", pendant->name);
	return cli_errno(err, "the pendant has not accepted it");
}

/* The current content of the display: the driver rounds values to it */
static int print_json(const struct pendant *pendant)
{
	struct json_object *document;
	struct values values;
	int err;

	err = values_read(pendant, &values);
	if (err)
		return cli_errno(err, "%s", pendant->name);
	document = cli_json_new("set");
	cli_json_text(document, "name", pendant->name);
	json_object_object_add(document, "dro", values_json(&values));
	return cli_json_print(document);
}

int set_verb(int argc, char **argv)
{
	const struct argp argp = {
		.options = option_table, .parser = parse, .args_doc = "FIELD=VALUE...",
		.doc = doc, .children = cli_children,
	};
	struct options options = { 0 };
	struct pendant pendant;
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &options);
	status = pendant_choose(options.common.device, &pendant);
	if (status == CLI_OK)
		status = check_fields(&pendant, &options);
	if (status == CLI_OK)
		status = write_all(&pendant, &options);
	if (status == CLI_OK && options.wait)
		status = flush(&pendant);
	if (status == CLI_OK && options.common.json)
		status = print_json(&pendant);
	return status;
}
