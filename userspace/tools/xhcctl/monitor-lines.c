// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl monitor: events as lines of text and as JSON
 */
#include <errno.h>
#include <json-c/json.h>
#include <libevdev/libevdev.h>
#include <stdio.h>
#include <time.h>

#include "cli.h"
#include "monitor.h"

static const char *const kinds[] = {
	[EVENT_START] = "start",
	[EVENT_KEY] = "key",
	[EVENT_UNKNOWN] = "unknown",
	[EVENT_SELECTOR] = "selector",
	[EVENT_ROTARY] = "rotary",
	[EVENT_WHEEL] = "wheel",
	[EVENT_LOST] = "lost",
	[EVENT_AWAKE] = "awake",
	[EVENT_DISPLAY] = "display",
	[EVENT_GONE] = "gone",
};

static const char *code_name(unsigned int code)
{
	return libevdev_event_code_get_name(EV_KEY, code) ?: "?";
}

void event_line(FILE *stream, const struct monitor *monitor, const struct event *event)
{
	const struct model *model = monitor->pendant.model_row;
	const char *caption;
	time_t seconds = event->time.tv_sec;
	struct tm tm;
	char clock[16];

	strftime(clock, sizeof(clock), "%H:%M:%S", localtime_r(&seconds, &tm));
	fprintf(stream, "%s.%03ld %-9s", clock, (long)event->time.tv_usec / 1000,
		kinds[event->kind]);
	switch (event->kind) {
	case EVENT_START:
		fprintf(stream, "%s %s selector %s", monitor->pendant.name,
			monitor->awake ? "awake" : "asleep",
			selector_name(model, monitor->events.selector));
		if (model_has_rotary(model))
			fprintf(stream, " rotary %s", rotary_name(model, monitor->events.rotary));
		break;
	case EVENT_KEY:
		caption = layout_caption(&monitor->layout, event->scan, event->fn);
		fprintf(stream, "%-12s %-5s %02xh %s", caption ?: "-", event->value ? "down" : "up",
			event->scan, code_name(event->code));
		break;
	case EVENT_UNKNOWN:
		fprintf(stream, "%-12s %-5s %02xh", "-", "down", event->scan);
		break;
	case EVENT_SELECTOR:
		fputs(selector_name(model, event->value), stream);
		break;
	case EVENT_ROTARY:
		fputs(rotary_name(model, event->value), stream);
		break;
	case EVENT_WHEEL:
		fprintf(stream, "%+d", event->value);
		break;
	case EVENT_AWAKE:
		fputs(event->value ? "awake" : "asleep", stream);
		break;
	case EVENT_DISPLAY:
		model->line(stream, &monitor->values);
		break;
	case EVENT_LOST:
		fputs("too late in reading; wheel counts are missing", stream);
		break;
	case EVENT_GONE:
		fputs(monitor->pendant.name, stream);
		break;
	}
}

int tell_line(const struct monitor *monitor, const struct event *event)
{
	event_line(stdout, monitor, event);
	putchar('\n');
	if (fflush(stdout))
		return cli_errno(errno, "standard output");
	return CLI_OK;
}

static void add_time(struct json_object *document, const struct timeval *time)
{
	double seconds = time->tv_sec + time->tv_usec / 1e6;
	char text[40];

	snprintf(text, sizeof(text), "%lld.%06ld", (long long)time->tv_sec,
		 (long)time->tv_usec);
	json_object_object_add(document, "time", json_object_new_double_s(seconds, text));
}

static void add_start(struct json_object *document, const struct monitor *monitor)
{
	const struct model *model = monitor->pendant.model_row;

	cli_json_text(document, "name", monitor->pendant.name);
	cli_json_text(document, "model", monitor->pendant.model);
	cli_json_text(document, "layout",
		      *monitor->layout.name ? monitor->layout.name : NULL);
	cli_json_bool(document, "awake", monitor->awake);
	cli_json_text(document, "selector",
		      selector_name(model, monitor->events.selector));
	cli_json_text(document, "rotary", model_has_rotary(model) ?
		      rotary_name(model, monitor->events.rotary) : NULL);
	json_object_object_add(document, "dro", values_json(&monitor->values));
}

int tell_json(const struct monitor *monitor, const struct event *event)
{
	struct json_object *document = cli_json_new("monitor");

	cli_json_text(document, "event", kinds[event->kind]);
	add_time(document, &event->time);
	switch (event->kind) {
	case EVENT_START:
		add_start(document, monitor);
		break;
	case EVENT_KEY:
		cli_json_number(document, "scan", event->scan);
		cli_json_text(document, "caption",
			      layout_caption(&monitor->layout, event->scan, event->fn));
		cli_json_text(document, "code", code_name(event->code));
		cli_json_bool(document, "down", event->value);
		break;
	case EVENT_UNKNOWN:
		cli_json_number(document, "scan", event->scan);
		break;
	case EVENT_SELECTOR:
		cli_json_text(document, "position",
			      selector_name(monitor->pendant.model_row, event->value));
		cli_json_number(document, "value", event->value);
		break;
	case EVENT_ROTARY:
		cli_json_text(document, "position",
			      rotary_name(monitor->pendant.model_row, event->value));
		cli_json_number(document, "value", event->value);
		break;
	case EVENT_WHEEL:
		cli_json_number(document, "detents", event->value);
		break;
	case EVENT_AWAKE:
		cli_json_bool(document, "awake", event->value);
		break;
	case EVENT_DISPLAY:
		json_object_object_add(document, "dro", values_json(&monitor->values));
		break;
	case EVENT_LOST:
	case EVENT_GONE:
		break;
	}
	return cli_json_print(document);
}
