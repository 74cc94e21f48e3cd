// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl replay
 */
#include <errno.h>
#include <json-c/json.h>
#include <string.h>
#include <time.h>

#include "cli-limits.h"
#include "recording.h"
#include "uhid-device.h"
#include "verbs.h"

/* Time limit for a driver to bind; udev may have to load it first */
#define DRIVER_US	10000000
/* Maximum wait: a signal may have arrived just before it */
#define WAIT_US		500000

struct options {
	struct cli_common common;
	const char *path;
	bool fast, check;
	double before, after;
};

static const struct argp_option option_table[] = {
	{ "fast", 'f', NULL, 0, "Leave out the pauses between the reports", 0 },
	{ "before", 'b', "SECONDS", 0, "Wait for this time before the first report (1)", 0 },
	{ "after", 'a', "SECONDS", 0, "Stay plugged in for this time after the last one (1)", 0 },
	{ "check", 'c', NULL, 0, "Only read the file", 0 },
	{ 0 }
};

static const char doc[] =
	"Replay a recording by a virtual pendant."
	"\v"
	"FILE is a recording by `record' or by hid-recorder; - is standard input. The device has the "
	"recorded report descriptor and ids, and its driver cannot distinguish it from a real one; "
	"frames for the display are accepted and dropped. Reports are sent with their recorded "
	"pauses. After the last one the device is unplugged.\n\n"
	"An invalid file is refused as a whole, with the number of the line. The exit status is 3 if "
	"there is no /dev/uhid (modprobe uhid).\n\n"
	"  sudo xhcctl replay pendant.hid";

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct options *options = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[0] = &options->common;
		return 0;
	case 'f':
		options->fast = true;
		return 0;
	case 'b':
		options->before = parse_seconds(argument, "--before", state);
		return 0;
	case 'a':
		options->after = parse_seconds(argument, "--after", state);
		return 0;
	case 'c':
		options->check = true;
		return 0;
	case ARGP_KEY_ARG:
		if (options->path)
			argp_error(state, "one file only");
		options->path = argument;
		return 0;
	case ARGP_KEY_NO_ARGS:
		argp_error(state, "missing FILE");
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static int64_t now_us(void)
{
	struct timespec now;

	clock_gettime(CLOCK_MONOTONIC, &now);
	return now.tv_sec * INT64_C(1000000) + now.tv_nsec / 1000;
}

/* Serve the device until this time, or until it is open if we wait for that */
static int serve_until(struct uhid_device *device, int64_t until, bool open)
{
	while (!cli_interrupted() && !(open && device->open)) {
		int64_t left = until - now_us();
		int err;

		if (left <= 0)
			break;
		/* with millisecond resolution, never too early */
		err = uhid_serve(device, ((left < WAIT_US ? left : WAIT_US) + 999) / 1000);
		if (err)
			return err;
	}
	return 0;
}

/* Return the number of reports sent, or a negative errno. */
static long send_all(struct uhid_device *device, const struct recording *recording, bool fast)
{
	int64_t began = now_us();
	size_t i;

	for (i = 0; i < recording->count && !cli_interrupted(); i++) {
		const struct recorded_report *report = &recording->report[i];
		uint64_t offset = report->us - recording->report[0].us;
		int err;

		err = serve_until(device, fast ? 0 : began + (int64_t)offset, false);
		if (!err && !cli_interrupted())
			err = uhid_send(device, report->data, report->size);
		if (err)
			return err;
	}
	return i;
}

static int finish(const struct recording *recording, const struct options *options, long sent)
{
	struct json_object *document;

	if (!options->common.json) {
		printf("%ld of %zu reports %s\n", sent, recording->count,
		       options->check ? "sent, the recording is valid" : "sent");
		return CLI_OK;
	}
	document = cli_json_new("replay");
	cli_json_text(document, "file", options->path);
	cli_json_number(document, "reports", recording->count);
	cli_json_number(document, "sent", sent);
	return cli_json_print(document);
}

static int play(struct uhid_device *device, const struct recording *recording,
		const struct options *options)
{
	long sent = 0;
	int err;

	err = serve_until(device, now_us() + DRIVER_US, true);
	if (!err && !device->open && !cli_interrupted())
		return cli_error("no driver is bound to the virtual device: is hid-xhc installed?");
	if (!err)
		err = serve_until(device, now_us() + (int64_t)(options->before * 1e6), false);
	if (!err)
		sent = send_all(device, recording, options->fast);
	if (!err && sent >= 0)
		err = serve_until(device, now_us() + (int64_t)(options->after * 1e6), false);
	if (err || sent < 0)
		return cli_errno(err ?: (int)sent, "/dev/uhid");
	return finish(recording, options, sent);
}

static int replay(const struct recording *recording, const struct options *options)
{
	struct uhid_device device;
	int err, status;

	if (options->common.device)
		return cli_usage("--device cannot be used: a new device is created");
	if (options->check)
		return finish(recording, options, 0);
	cli_catch_signals();
	err = uhid_create(&device, recording);
	if (err == -ENOENT || err == -ENODEV)
		return cli_no_device("no /dev/uhid: try `modprobe uhid'");
	if (err)
		return cli_errno(err, "/dev/uhid");
	status = play(&device, recording, options);
	uhid_destroy(&device);
	return status;
}

int replay_verb(int argc, char **argv)
{
	const struct argp argp = {
		.options = option_table, .parser = parse, .args_doc = "FILE", .doc = doc,
		.children = cli_children,
	};
	struct options options = { .before = 1, .after = 1 };
	struct recording recording;
	FILE *stream;
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &options);
	stream = strcmp(options.path, "-") ? fopen(options.path, "re") : stdin;
	if (!stream)
		return cli_errno(errno, "%s", options.path);
	status = recording_read(stream, options.path, &recording);
	if (stream != stdin)
		fclose(stream);
	if (status == CLI_OK)
		status = replay(&recording, &options);
	recording_free(&recording);
	return status;
}
