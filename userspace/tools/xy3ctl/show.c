// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl list, xy3ctl show: list heads, and show all values of one.
 */
#include <json-c/json.h>
#include <stdio.h>

#include "cli.h"
#include "telemetry.h"
#include "verbs.h"

static const char list_text[] =
	"List scanheads, one per line."
	"\v"
	"With --json the list also has the serial number and all else that a head has reported. "
	"If there is no head, the exit status is 3.";

static const char show_text[] =
	"Show all that a scanhead has reported: identity, temperatures, errors, hours of operation, "
	"frames that it could not read; and the counters of both channels."
	"\v"
	"A dash stands for a value that the head has not reported. Components are those of "
	"/sys/class/xy3/xy3-<n>/errors; one with an error is shown in red.";

/* above the output of print_line() */
#define LIST_TITLE "HEAD    SYNC  RATE    BACK        FORWARD  IIO          VENDOR MODEL"

static void print_line(const struct head *head, const struct telemetry *telemetry)
{
	printf("%-7s %-5s %-7s %-11s %-8s %-12s %.12s %.12s\n", head->name,
	       telemetry_get(telemetry, "in_sync")[0] == '1' ? "yes" : "no",
	       or_dash(telemetry_get(telemetry, "rate")), or_dash(head->back),
	       or_dash(head->forward), or_dash(head->iio),
	       or_dash(telemetry_get(telemetry, "vendor")),
	       or_dash(telemetry_get(telemetry, "model")));
}

int list_verb(int argc, char **argv)
{
	const struct cli_common common = cli_parse_common(list_text, argc, argv);
	struct json_object *list = json_object_new_array(), *document;
	struct head heads[HEADS_MAX];
	struct telemetry telemetry;
	size_t count, printed = 0;
	int status = CLI_OK;

	if (common.device) {
		if (head_find(&heads[0], common.device))
			return CLI_NO_DEVICE;
		count = 1;
	} else {
		count = head_list(heads);
	}
	for (size_t i = 0; i < count; i++) {
		if (telemetry_read(&heads[i], &telemetry))
			continue;	/* removed in the meantime */
		if (common.json) {
			struct json_object *head = json_object_new_object();

			telemetry_json(head, &heads[i], &telemetry);
			json_object_array_add(list, head);
		} else {
			if (!printed)
				puts(LIST_TITLE);
			print_line(&heads[i], &telemetry);
		}
		printed++;
	}
	if (!printed)
		status = cli_no_device("no scanhead; `xy3ctl doctor' looks for the reason");
	if (common.json) {
		document = cli_json_new("list");
		json_object_object_add(document, "heads", list);
		cli_json_print(document);
	} else {
		json_object_put(list);
	}
	return status;
}

int show_verb(int argc, char **argv)
{
	const struct cli_common common = cli_parse_common(show_text, argc, argv);
	struct telemetry telemetry;
	struct json_object *document;
	struct head head;
	int status;

	status = head_find(&head, common.device);
	if (status)
		return status;
	if (telemetry_read(&head, &telemetry))
		return cli_no_device("%s has gone", head.name);
	if (!common.json) {
		telemetry_print(&head, &telemetry);
		statistics_print(&head);
		return CLI_OK;
	}
	document = cli_json_new("show");
	telemetry_json(document, &head, &telemetry);
	statistics_json(document, &head);
	return cli_json_print(document);
}
