// SPDX-License-Identifier: GPL-2.0-only
/*
 * Reports of a head. See telemetry.h.
 */
#include <errno.h>
#include <json-c/json.h>
#include <libxy3.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "telemetry.h"

static const char *const texts[FACT_TEXTS] = { "vendor", "model", "firmware", "serial" };

static void name_it(struct fact *fact, const char *name)
{
	snprintf(fact->name, sizeof(fact->name), "%s", name);
}

/* Read a fact from the attribute of its name */
static void take(const struct head *head, struct fact *fact, bool is_number)
{
	fact->is_number = is_number;
	/* if it cannot be read, it was not reported */
	if (head_read(head, fact->name, fact->value, sizeof(fact->value)) < 0)
		fact->value[0] = '\0';
}

static void take_temperature(const struct head *head, struct fact *fact, unsigned int component)
{
	long millidegrees;

	fact->is_number = true;
	fact->value[0] = '\0';
	snprintf(fact->name, sizeof(fact->name), "temperature/%s", xy3_component_name(component));
	if (!head_temperature(head, component, &millidegrees))
		snprintf(fact->value, sizeof(fact->value), "%.2f", millidegrees / 1000.0);
}

int telemetry_read(const struct head *head, struct telemetry *telemetry)
{
	struct fact *fact = telemetry->facts;

	for (unsigned int i = 0; i < FACT_TEXTS; i++, fact++) {
		name_it(fact, texts[i]);
		take(head, fact, false);
	}
	name_it(fact, "in_sync");
	take(head, fact++, true);
	if (!fact[-1].value[0])
		return -ENODEV;		/* always known */
	name_it(fact, "rate");
	take(head, fact++, true);
	for (unsigned int i = 0; i < XY3_COMPONENTS; i++)
		take_temperature(head, fact++, i);
	for (unsigned int i = 0; i < XY3_COMPONENTS; i++, fact++) {
		snprintf(fact->name, sizeof(fact->name), "errors/%s", xy3_component_name(i));
		take(head, fact, false);
	}
	for (unsigned int i = 0; i < XY3_COMPONENTS; i++, fact++) {
		snprintf(fact->name, sizeof(fact->name), "hours/%s", xy3_component_name(i));
		take(head, fact, true);
	}
	for (unsigned int i = 0; i < XY3_AXES; i++, fact++) {
		snprintf(fact->name, sizeof(fact->name), "frame_errors/%s", xy3_axis_name(i));
		take(head, fact, true);
	}
	return 0;
}

const char *telemetry_get(const struct telemetry *telemetry, const char *format, ...)
{
	char name[64];
	va_list arguments;

	va_start(arguments, format);
	vsnprintf(name, sizeof(name), format, arguments);
	va_end(arguments);
	for (unsigned int i = 0; i < FACTS; i++) {
		if (!strcmp(telemetry->facts[i].name, name))
			return telemetry->facts[i].value;
	}
	return "";
}

struct json_object *fact_json(const struct fact *fact)
{
	if (!fact->value[0])
		return NULL;
	if (!fact->is_number)
		return json_object_new_string(fact->value);
	if (!strcmp(fact->name, "in_sync"))
		return json_object_new_boolean(atoi(fact->value));
	if (strchr(fact->value, '.'))
		return json_object_new_double_s(atof(fact->value), fact->value);
	return json_object_new_int64(atoll(fact->value));
}

void telemetry_json(struct json_object *object, const struct head *head,
		    const struct telemetry *telemetry)
{
	struct json_object *folder;

	cli_json_text(object, "head", head->name);
	cli_json_text(object, "node", head->node);
	cli_json_text(object, "back", head->back[0] ? head->back : NULL);
	cli_json_text(object, "forward", head->forward[0] ? head->forward : NULL);
	cli_json_text(object, "iio", head->iio[0] ? head->iio : NULL);
	for (unsigned int i = 0; i < FACTS; i++) {
		const struct fact *fact = &telemetry->facts[i];
		const char *slash = strchr(fact->name, '/');
		char name[32];

		if (!slash) {
			json_object_object_add(object, fact->name, fact_json(fact));
			continue;
		}
		/* reports of components and axes: an object with the known ones */
		snprintf(name, sizeof(name), "%.*s", (int)(slash - fact->name), fact->name);
		if (!json_object_object_get_ex(object, name, &folder)) {
			folder = json_object_new_object();
			json_object_object_add(object, name, folder);
		}
		if (fact->value[0])
			json_object_object_add(folder, slash + 1, fact_json(fact));
	}
}

/* ---- counters ---- */

static const char *const head_counters[] = {
	"rx_bytes", "rx_packets", "syncs", "resyncs", "dropped_bytes", "bad_lengths",
	"unknown_packets", "line_errors", "lost_packets",
};

static const char *const stream_numbers[] = {
	"frame_bits", "sampling_frequency", "achieved_frequency", "underruns",
};

static const char *const stream_counters[] = {
	"scans", "repeated", "commands", "bus_errors", "clamped_codes",
};

static long long head_counter(const struct head *head, const char *name)
{
	char path[64], text[32];

	snprintf(path, sizeof(path), "stats/%s", name);
	return head_read(head, path, text, sizeof(text)) < 0 ? 0 : atoll(text);
}

void statistics_print(const struct head *head)
{
	long long number;

	printf("\nbackchannel\n");
	for (unsigned int i = 0; i < ARRAY_SIZE(head_counters); i++)
		printf("  %-20s %lld\n", head_counters[i], head_counter(head, head_counters[i]));
	if (!head->iio[0])
		return;
	printf("\nforward channel\n");
	for (unsigned int i = 0; i < ARRAY_SIZE(stream_numbers); i++) {
		if (!head_read_iio(head, stream_numbers[i], &number))
			printf("  %-20s %lld\n", stream_numbers[i], number);
	}
	for (unsigned int i = 0; i < ARRAY_SIZE(stream_counters); i++) {
		if (!head_read_counter(head, stream_counters[i], &number))
			printf("  %-20s %lld\n", stream_counters[i], number);
	}
}

void statistics_json(struct json_object *object, const struct head *head)
{
	struct json_object *back = json_object_new_object(), *forward = NULL;
	long long number;

	for (unsigned int i = 0; i < ARRAY_SIZE(head_counters); i++)
		cli_json_number(back, head_counters[i], head_counter(head, head_counters[i]));
	if (head->iio[0]) {
		forward = json_object_new_object();
		for (unsigned int i = 0; i < ARRAY_SIZE(stream_numbers); i++) {
			if (!head_read_iio(head, stream_numbers[i], &number))
				cli_json_number(forward, stream_numbers[i], number);
		}
		for (unsigned int i = 0; i < ARRAY_SIZE(stream_counters); i++) {
			if (!head_read_counter(head, stream_counters[i], &number))
				cli_json_number(forward, stream_counters[i], number);
		}
	}
	json_object_object_add(object, "statistics", back);
	json_object_object_add(object, "stream", forward);
}
