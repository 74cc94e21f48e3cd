// SPDX-License-Identifier: GPL-2.0-only
/*
 * JSON documents, by json-c. See cli.h.
 */
#include <errno.h>
#include <json-c/json.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli.h"

struct json_object *cli_json_new(const char *verb)
{
	struct json_object *document = json_object_new_object();

	cli_json_number(document, "schema", CLI_SCHEMA);
	cli_json_text(document, "tool", cli_tool_name());
	cli_json_text(document, "verb", verb);
	return document;
}

int cli_json_print(struct json_object *document)
{
	char *message = cli_take_message();

	if (message)
		cli_json_text(document, "error", message);
	free(message);
	puts(json_object_to_json_string_ext(document, JSON_C_TO_STRING_PLAIN |
					    JSON_C_TO_STRING_NOSLASHESCAPE));
	json_object_put(document);
	if (fflush(stdout))
		return cli_errno(errno, "standard output");
	return CLI_OK;
}

void cli_json_text(struct json_object *object, const char *key, const char *value)
{
	json_object_object_add(object, key, value ? json_object_new_string(value) : NULL);
}

void cli_json_number(struct json_object *object, const char *key, long long value)
{
	json_object_object_add(object, key, json_object_new_int64(value));
}

void cli_json_seconds(struct json_object *object, const char *key, double seconds)
{
	char text[32];

	/* a double would be printed with more digits than were measured */
	snprintf(text, sizeof(text), "%.3f", seconds);
	json_object_object_add(object, key, json_object_new_double_s(seconds, text));
}

void cli_json_bool(struct json_object *object, const char *key, bool value)
{
	json_object_object_add(object, key, json_object_new_boolean(value));
}
