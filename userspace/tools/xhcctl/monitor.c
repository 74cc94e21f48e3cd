// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl monitor: the verb, and its main loop
 */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli-limits.h"
#include "monitor.h"
#include "verbs.h"

/* Interval of reading the display: changes are not notified */
#define LOOK_MS		100
/* Maximum wait otherwise: a signal may have arrived just before it */
#define WAIT_MS		500

struct options {
	struct cli_common common;
	struct limits limits;
	bool lines, display;
};

static const struct argp_option option_table[] = {
	{ "count", 'n', "NUMBER", 0, "End after this number of events", 0 },
	{ "timeout", 't', "SECONDS", 0, "End after this time", 0 },
	{ "lines", 'l', NULL, 0, "Print one event per line, also on a terminal", 0 },
	{ "display", 'D', NULL, 0, "With lines or JSON, also print each change of the display", 0 },
	{ 0 }
};

static const char doc[] =
	"Show the events of a pendant, with the labels of its keys, and its display."
	"\v"
	"On a terminal this is a picture that is redrawn at each event; its display shows what the "
	"driver sent last. Otherwise, and with --lines, one line is printed per event: time, kind, and "
	"for a key its label (with Fn, if that is held), down or up, scan code and key code. Kinds: start "
	"(always the first: the current state), key, selector, rotary (the second one of a WHB04B), "
	"wheel, awake, display, unknown (a key that no pendant should have), lost (events arrived "
	"faster than they were read; keys and selector are correct again, wheel counts are missing), "
	"gone. With --json each event is an object on one line.\n\n"
	"Ends when it is interrupted, after --timeout, or after --count events (start does not "
	"count). The exit status is 1 if the time is up before the count, and 3 if the pendant is "
	"unplugged; pressed keys are first reported as released.\n\n"
	"  xhcctl monitor\n"
	"  xhcctl monitor --count 1 --timeout 10 --json   # wait for a key";

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct options *options = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[0] = &options->common;
		return 0;
	case 'n':
		limits_count(&options->limits, argument, state);
		return 0;
	case 't':
		limits_timeout(&options->limits, argument, state);
		return 0;
	case 'l':
		options->lines = true;
		return 0;
	case 'D':
		options->display = true;
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static struct event now(enum event_kind kind, int value)
{
	struct event event = { .kind = kind, .value = value };

	gettimeofday(&event.time, NULL);
	return event;
}

static int tell(struct monitor *monitor, struct limits *limits, const struct event *event)
{
	int status = monitor->tell(monitor, event);

	if (event->kind != EVENT_START && event->kind != EVENT_GONE)
		limits->seen++;
	return status;
}

/* Return 0 or a negative errno. */
static int read_awake(struct monitor *monitor, bool *changed)
{
	char text[8] = "";
	ssize_t length = pread(monitor->awake_fd, text, sizeof(text) - 1, 0);
	bool awake = text[0] == '1';

	if (length < 0)
		return -errno;
	*changed = awake != monitor->awake;
	monitor->awake = awake;
	return 0;
}

/* Return 0 or a negative errno. */
static int read_display(struct monitor *monitor, bool *changed)
{
	struct values values;
	int err;

	err = values_read(&monitor->pendant, &values);
	if (!err)
		err = stats_read(&monitor->pendant, monitor->stat);
	if (err)
		return err;
	*changed = false;
	for (enum field_index i = 0; i < FIELDS; i++)
		*changed |= strcmp(values.text[i], monitor->values.text[i]) != 0;
	monitor->values = values;
	return 0;
}

/* Report all events. Return 0, a negative errno, or an enum cli_status. */
static int take_events(struct monitor *monitor, struct limits *limits)
{
	struct event event;
	bool changed = false;
	int result;

	while (!limits_reached(limits)) {
		result = events_next(&monitor->events, &event);
		if (result < 0)
			return result;
		if (!result)
			break;
		result = tell(monitor, limits, &event);
		if (result)
			return result;
	}
	result = read_awake(monitor, &changed);
	if (result || !changed || limits_reached(limits))
		return result;
	event = now(EVENT_AWAKE, monitor->awake);
	return tell(monitor, limits, &event);
}

static int look_at_display(struct monitor *monitor, struct limits *limits)
{
	struct event event;
	bool changed = false;
	int err;

	err = read_display(monitor, &changed);
	if (err || !changed || limits_reached(limits))
		return err;
	event = now(EVENT_DISPLAY, 0);
	return tell(monitor, limits, &event);
}

/* Return an enum cli_status, or a negative errno if the pendant was removed. */
static int watch(struct monitor *monitor, struct options *options)
{
	struct limits *limits = &options->limits;
	bool display = options->display || monitor->look;
	struct pollfd poll_fds[] = {
		{ .fd = monitor->events.fd, .events = POLLIN },
		{ .fd = monitor->awake_fd, .events = POLLPRI },
	};

	while (!cli_interrupted()) {
		int result = take_events(monitor, limits);

		if (!result && display)
			result = look_at_display(monitor, limits);
		if (result)
			return result;
		if (monitor->look)
			monitor->look(monitor);
		if (limits_reached(limits) || limits_time_is_up(limits))
			return limits_status(limits);
		poll(poll_fds, 2, limits_wait_ms(limits, display ? LOOK_MS : WAIT_MS));
	}
	return CLI_OK;
}

/* Release all keys, and print the message */
static int gone(struct monitor *monitor, int err)
{
	struct event event;

	if (pendant_present(&monitor->pendant) && err != -ENODEV)
		return cli_errno(err, "%s", monitor->pendant.name);
	while (events_release(&monitor->events, &event))
		monitor->tell(monitor, &event);
	event = now(EVENT_GONE, 0);
	monitor->tell(monitor, &event);
	if (monitor->look)
		monitor->look(monitor);
	return CLI_NO_DEVICE;
}

static int run(struct monitor *monitor, struct options *options)
{
	struct event start = now(EVENT_START, 0);
	bool changed;
	int result;

	result = read_awake(monitor, &changed);
	if (!result)
		result = read_display(monitor, &changed);
	if (!result && monitor->look)
		screen_begin();
	if (!result)
		result = tell(monitor, &options->limits, &start);
	if (!result)
		result = watch(monitor, options);
	if (result < 0)
		result = gone(monitor, result);
	if (monitor->look)
		screen_end();
	if (result == CLI_NO_DEVICE)
		cli_no_device("%s has gone", monitor->pendant.name);
	return result;
}

static int open_all(struct monitor *monitor)
{
	char path[sizeof(monitor->pendant.path) + 16];
	int err;

	err = events_open(&monitor->events, monitor->pendant.event);
	if (err)
		return cli_errno(err, "%s", monitor->pendant.event);
	snprintf(path, sizeof(path), "%s/awake", monitor->pendant.path);
	monitor->awake_fd = open(path, O_RDONLY | O_CLOEXEC);
	if (monitor->awake_fd < 0) {
		err = errno;
		events_close(&monitor->events);
		return cli_errno(err, "%s", path);
	}
	return CLI_OK;
}

int monitor_verb(int argc, char **argv)
{
	const struct argp argp = {
		.options = option_table, .parser = parse, .doc = doc, .children = cli_children,
	};
	struct options options = { 0 };
	struct monitor monitor = { 0 };
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &options);
	cli_catch_signals();
	status = pendant_choose(options.common.device, &monitor.pendant);
	if (status != CLI_OK)
		return status;
	if (!*monitor.pendant.event)
		return cli_no_device("%s has no event node", monitor.pendant.name);
	if (layout_read(layout_name(&monitor.pendant), &monitor.layout) != CLI_OK)
		monitor.layout = (struct layout){ 0 };	/* keys by their scan codes */
	monitor.tell = options.common.json ? tell_json : tell_line;
	if (!options.common.json && !options.lines && cli_is_terminal(STDOUT_FILENO)) {
		monitor.tell = screen_tell;
		monitor.look = screen_look;
	}
	monitor.events.fn_scan = monitor.layout.fn;
	status = open_all(&monitor);
	if (status != CLI_OK)
		return status;
	limits_start(&options.limits);
	status = run(&monitor, &options);
	close(monitor.awake_fd);
	events_close(&monitor.events);
	return status;
}
