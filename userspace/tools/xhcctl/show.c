// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl show
 */
#include <errno.h>
#include <json-c/json.h>
#include <stdio.h>
#include <stdlib.h>

#include "fields.h"
#include "layout.h"
#include "model.h"
#include "stats.h"
#include "sysfs.h"
#include "verbs.h"

static const char text[] =
	"Show all attributes of a pendant."
	"\v"
	"One attribute per line, with its path in the pendant's sysfs directory: the display (dro/), "
	"counters (stats/), the model, and whether it is awake. `set' changes dro/. hid-xhc(4) "
	"describes each attribute.";

const char *const stat_names[STATS] = {
	[REPORTS] = "reports",
	[BAD_REPORTS] = "bad_reports",
	[XOR_MISMATCHES] = "xor_mismatches",
	[UNKNOWN_KEYS] = "unknown_keys",
	[FRAMES_SENT] = "frames_sent",
	[FRAME_ERRORS] = "frame_errors",
};

int stats_read(const struct pendant *pendant, long long stat[STATS])
{
	for (enum stat_index i = 0; i < STATS; i++) {
		int err = sysfs_read_number(&stat[i], "%s/stats/%s", pendant->path,
					    stat_names[i]);

		if (err)
			return err;
	}
	return 0;
}

struct state {
	struct values values;
	char steps[FIELD_TEXT];		/* step_available */
	long long stat[STATS];
};

static int read_state(const struct pendant *pendant, struct state *state)
{
	int err = values_read(pendant, &state->values);

	if (!err && model_has(pendant->model_row, STEP))
		err = sysfs_read(state->steps, sizeof(state->steps), "%s/dro/step_available",
				 pendant->path);
	return err < 0 ? err : stats_read(pendant, state->stat);
}

static void print_line(const char *folder, const char *name, const char *value)
{
	char path[64];

	snprintf(path, sizeof(path), "%s%s", folder, name);
	printf("%-23s %s%s%s\n", path, cli_colour(CLI_BOLD), value, cli_colour(CLI_PLAIN));
}

static void print_text(const struct pendant *pendant, const struct state *state)
{
	char number[32];

	print_line("", "name", pendant->name);
	print_line("", "model", pendant->model);
	print_line("", "awake", pendant->awake ? "1" : "0");
	print_line("", "layout", *pendant->layout ? pendant->layout : "-");
	for (enum field_index i = 0; i < FIELDS; i++) {
		if (!model_has(pendant->model_row, i))
			continue;
		print_line("dro/", fields[i].name, state->values.text[i]);
		if (i == STEP)
			print_line("dro/", "step_available", state->steps);
	}
	for (enum stat_index i = 0; i < STATS; i++) {
		snprintf(number, sizeof(number), "%lld", state->stat[i]);
		print_line("stats/", stat_names[i], number);
	}
}

static struct json_object *steps_json(const char *steps)
{
	struct json_object *array = json_object_new_array();
	char *end;

	for (long step = strtol(steps, &end, 10); end != steps; step = strtol(steps, &end, 10)) {
		json_object_array_add(array, json_object_new_int64(step));
		steps = end;
	}
	return array;
}

static int print_json(const struct pendant *pendant, const struct state *state)
{
	struct json_object *document = cli_json_new("show"), *stats = json_object_new_object();
	struct json_object *dro = values_json(&state->values);

	cli_json_text(document, "name", pendant->name);
	cli_json_text(document, "model", pendant->model);
	cli_json_bool(document, "awake", pendant->awake);
	cli_json_text(document, "layout", *pendant->layout ? pendant->layout : NULL);
	if (model_has(pendant->model_row, STEP))
		json_object_object_add(dro, "step_available", steps_json(state->steps));
	json_object_object_add(document, "dro", dro);
	for (enum stat_index i = 0; i < STATS; i++)
		cli_json_number(stats, stat_names[i], state->stat[i]);
	json_object_object_add(document, "stats", stats);
	return cli_json_print(document);
}

int show_verb(int argc, char **argv)
{
	struct cli_common common = cli_parse_common(text, argc, argv);
	struct pendant pendant;
	struct state state;
	int err, status;

	status = pendant_choose(common.device, &pendant);
	if (status != CLI_OK)
		return status;
	err = read_state(&pendant, &state);
	if (err && !pendant_present(&pendant))
		return cli_no_device("%s has gone", pendant.name);
	if (err)
		return cli_errno(err, "%s", pendant.name);
	if (common.json)
		return print_json(&pendant, &state);
	print_text(&pendant, &state);
	return CLI_OK;
}
