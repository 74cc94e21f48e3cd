// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl watch: show changes in the telemetry of a head.
 *
 * Errors, sync and identity wake us by the head's uevents; the rest is polled.
 */
#include <errno.h>
#include <json-c/json.h>
#include <libudev.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cli-limits.h"
#include "cli.h"
#include "telemetry.h"
#include "verbs.h"

struct settings {
	struct cli_common common;
	struct limits limits;	/* of lines, or pictures */
	double interval;	/* seconds */
};

static const struct argp_option options[] = {
	{ "interval", 'i', "SECONDS", 0, "Read temperatures and hours at this interval (1)", 0 },
	{ "count", 'n', "NUMBER", 0, "End after this number of lines, or pictures", 0 },
	{ "timeout", 't', "SECONDS", 0, "End after this time", 0 },
	{ 0 }
};

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct settings *settings = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[0] = &settings->common;
		return 0;
	case 'i':
		settings->interval = parse_seconds(argument, "--interval", state);
		if (settings->interval == 0)
			argp_error(state, "--interval: must be more than 0");
		return 0;
	case 'n':
		limits_count(&settings->limits, argument, state);
		return 0;
	case 't':
		limits_timeout(&settings->limits, argument, state);
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static const struct argp argp = {
	.options = options, .parser = parse, .children = cli_children,
	.doc = "Watch a scanhead: a picture on a terminal, otherwise a line for each change."
	       "\v"
	       "A line has the time of day, the name and the value, which is a dash when the head "
	       "has stopped reporting it; all known values come first. With --json a line is an "
	       "object with the members name and value. Temperatures are read once per interval; "
	       "errors and sync are printed at once. The exit status is 3 when the head is removed, "
	       "1 if the time is up before the count, and 130 when it is interrupted.\n\n"
	       "  xy3ctl watch\n"
	       "  xy3ctl watch --interval 10 --json\n"
	       "  xy3ctl watch --count 1 --timeout 60",
};

static void print_change(const struct settings *settings, const struct head *head,
			 const struct fact *fact)
{
	struct json_object *document;
	char text[16];
	struct timespec now;

	clock_gettime(CLOCK_REALTIME, &now);
	if (settings->common.json) {
		document = cli_json_new("watch");
		cli_json_text(document, "head", head->name);
		cli_json_seconds(document, "time", now.tv_sec + now.tv_nsec / 1e9);
		cli_json_text(document, "name", fact->name);
		json_object_object_add(document, "value", fact_json(fact));
		cli_json_print(document);
		return;
	}
	strftime(text, sizeof(text), "%H:%M:%S", localtime(&now.tv_sec));
	printf("%s %s %s\n", text, fact->name, fact->value[0] ? fact->value : "-");
	fflush(stdout);
}

static void print_changes(struct settings *settings, const struct head *head,
			  const struct telemetry *before, const struct telemetry *after)
{
	for (unsigned int i = 0; i < FACTS && !limits_reached(&settings->limits); i++) {
		if (strcmp(before->facts[i].value, after->facts[i].value)) {
			print_change(settings, head, &after->facts[i]);
			settings->limits.seen++;
		}
	}
}

static void print_picture(const struct head *head, const struct telemetry *telemetry)
{
	printf("\033[H\033[2J");
	telemetry_print(head, telemetry);
	fflush(stdout);
}

/* Wait for a uevent of a head, a signal, or the timeout */
static void wait_for_news(struct udev_monitor *monitor, int ms)
{
	struct pollfd file = { .fd = udev_monitor_get_fd(monitor), .events = POLLIN };
	struct udev_device *device;

	if (poll(&file, 1, ms) <= 0)
		return;
	while ((device = udev_monitor_receive_device(monitor)))
		udev_device_unref(device);
}

static int watch(struct settings *settings, struct head *head, struct udev_monitor *monitor)
{
	bool picture = cli_is_terminal(STDOUT_FILENO) && !settings->common.json;
	struct limits *limits = &settings->limits;
	struct telemetry before = { 0 }, after;

	limits_start(limits);
	while (!cli_interrupted()) {
		/* a channel may have been attached or detached */
		if (head_find(head, head->name))
			return CLI_NO_DEVICE;
		if (telemetry_read(head, &after))
			return cli_no_device("%s has gone", head->name);
		if (picture) {
			print_picture(head, &after);
			limits->seen++;
		} else {
			print_changes(settings, head, &before, &after);
		}
		before = after;
		if (limits_reached(limits) || limits_time_is_up(limits))
			return limits_status(limits);
		wait_for_news(monitor, limits_wait_ms(limits, settings->interval * 1000 + 1));
	}
	return CLI_OK;
}

int watch_verb(int argc, char **argv)
{
	struct settings settings = { .interval = 1 };
	struct udev_monitor *monitor;
	struct udev *udev;
	struct head head;
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &settings);
	status = head_find(&head, settings.common.device);
	if (status)
		return status;
	udev = udev_new();
	/* uevents of the kernel: udevd may be slow, or not running */
	monitor = udev ? udev_monitor_new_from_netlink(udev, "kernel") : NULL;
	if (!monitor)
		return cli_errno(errno, "events of the kernel");
	udev_monitor_filter_add_match_subsystem_devtype(monitor, "xy3", NULL);
	status = udev_monitor_enable_receiving(monitor);
	if (status < 0)
		return cli_errno(status, "events of the kernel");
	cli_catch_signals();
	status = watch(&settings, &head, monitor);
	udev_monitor_unref(monitor);
	udev_unref(udev);
	return status;
}
