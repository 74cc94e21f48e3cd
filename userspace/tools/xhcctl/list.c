// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl list
 */
#include <json-c/json.h>
#include <stdio.h>
#include <string.h>

#include "layout.h"
#include "pendant.h"
#include "verbs.h"

static const char text[] =
	"List pendants and their names."
	"\v"
	"Columns: number, name of the HID device, model, awake (yes or no), event node, hidraw node, "
	"key layout (in brackets if none was chosen and it is the default), port. A dash "
	"stands for a missing value. The exit status is 3 if there is no pendant.\n\n"
	"To get the name of the event node only:\n"
	"  xhcctl list --json | jq -r '.pendants[].event'";

static const char *last_word(const char *node)
{
	const char *slash = strrchr(node, '/');

	if (!*node)
		return "-";
	return slash ? slash + 1 : node;
}

static void print_text(const struct pendants *list)
{
	printf("%sN NAME                MODEL  AWAKE EVENTS  HIDRAW  LAYOUT    PHYS%s\n",
	       cli_colour(CLI_BOLD), cli_colour(CLI_PLAIN));
	for (size_t i = 0; i < list->count; i++) {
		const struct pendant *one = &list->item[i];
		char layout[80];

		snprintf(layout, sizeof(layout), *one->layout ? "%s" : "(%s)",
			 layout_name(one));
		printf("%u %-19s %-6s %-5s %-7s %-7s %-9s %s\n", one->index, one->name,
		       one->model, one->awake ? "yes" : "no", last_word(one->event),
		       last_word(one->hidraw), layout, *one->phys ? one->phys : "-");
	}
}

static void text_or_null(struct json_object *object, const char *key, const char *value)
{
	cli_json_text(object, key, *value ? value : NULL);
}

static int print_json(const struct pendants *list)
{
	struct json_object *document = cli_json_new("list"), *array = json_object_new_array();

	for (size_t i = 0; i < list->count; i++) {
		const struct pendant *one = &list->item[i];
		struct json_object *object = json_object_new_object();

		cli_json_number(object, "index", one->index);
		cli_json_text(object, "name", one->name);
		cli_json_text(object, "model", one->model);
		cli_json_bool(object, "awake", one->awake);
		text_or_null(object, "event", one->event);
		text_or_null(object, "hidraw", one->hidraw);
		text_or_null(object, "layout", one->layout);
		text_or_null(object, "phys", one->phys);
		json_object_array_add(array, object);
	}
	json_object_object_add(document, "pendants", array);
	return cli_json_print(document);
}

/* Those requested by the user */
static int select_pendants(struct pendants *list, const char *device)
{
	struct pendant one;
	int status;

	if (list->count && !device)
		return CLI_OK;
	status = pendants_choose(list, device, &one);
	list->count = status == CLI_OK ? 1 : 0;
	if (list->count)
		list->item[0] = one;
	return status;
}

int list_verb(int argc, char **argv)
{
	struct cli_common common = cli_parse_common(text, argc, argv);
	struct pendants list;
	int err, status;

	err = pendants_find(&list);
	status = err ? cli_errno(err, "pendants") : select_pendants(&list, common.device);
	if (!err && common.json)
		status = print_json(&list) ?: status;
	else if (list.count)
		print_text(&list);
	pendants_free(&list);
	return status;
}
