// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl record
 */
#include <errno.h>
#include <fcntl.h>
#include <json-c/json.h>
#include <linux/hidraw.h>
#include <poll.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "cli-limits.h"
#include "pendant.h"
#include "recording.h"
#include "verbs.h"

/* Maximum wait: a signal may have arrived just before it */
#define WAIT_MS	500

struct options {
	struct cli_common common;
	struct limits limits;
	const char *path;
};

static const struct argp_option option_table[] = {
	{ "count", 'n', "NUMBER", 0, "End after this number of reports", 0 },
	{ "timeout", 't', "SECONDS", 0, "End after this time", 0 },
	{ 0 }
};

static const char doc[] =
	"Record the reports of a pendant in a file."
	"\v"
	"Reports are recorded with their times, in the format of hid-recorder, which `replay' and "
	"hid-tools read. Without FILE they go to standard output. It requires permission to read the "
	"pendant's hidraw node, which usually only root has.\n\n"
	"Ends when it is interrupted, after --timeout, or after --count reports. The exit status is 1 "
	"if the time is up before the count, and 3 if the pendant is unplugged. The recording is "
	"complete up to that moment in each case.\n\n"
	"  sudo xhcctl record pendant.hid   # to attach to a bug report";

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
	case ARGP_KEY_ARG:
		if (options->path)
			argp_error(state, "one file only");
		options->path = argument;
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

/* Return 0 or a negative errno. */
static int read_head(int fd, struct recording *head)
{
	struct hidraw_report_descriptor descriptor;
	struct hidraw_devinfo info;
	int size;

	if (ioctl(fd, HIDIOCGRDESCSIZE, &size) < 0)
		return -errno;
	descriptor.size = size;
	if (ioctl(fd, HIDIOCGRDESC, &descriptor) < 0 || ioctl(fd, HIDIOCGRAWINFO, &info) < 0 ||
	    ioctl(fd, HIDIOCGRAWNAME(sizeof(head->name)), head->name) < 0 ||
	    ioctl(fd, HIDIOCGRAWPHYS(sizeof(head->phys)), head->phys) < 0)
		return -errno;
	head->name[sizeof(head->name) - 1] = '\0';
	head->phys[sizeof(head->phys) - 1] = '\0';
	head->descriptor_size = descriptor.size;
	memcpy(head->descriptor, descriptor.value, descriptor.size);
	head->bus = info.bustype;
	head->vendor = (uint16_t)info.vendor;
	head->product = (uint16_t)info.product;
	return 0;
}

static uint64_t now_us(void)
{
	struct timespec now;

	clock_gettime(CLOCK_MONOTONIC, &now);
	return now.tv_sec * UINT64_C(1000000) + now.tv_nsec / 1000;
}

/* Return an enum cli_status, or a negative errno. */
static int record(int fd, FILE *stream, struct limits *limits)
{
	struct pollfd poll_fd = { .fd = fd, .events = POLLIN };
	uint64_t began = 0, now;

	while (!cli_interrupted() && !limits_reached(limits) && !limits_time_is_up(limits)) {
		uint8_t data[REPORT_MAX];
		ssize_t size;

		if (poll(&poll_fd, 1, limits_wait_ms(limits, WAIT_MS)) <= 0)
			continue;
		size = read(fd, data, sizeof(data));
		if (size < 0 && (errno == EAGAIN || errno == EINTR))
			continue;
		if (size < 0)
			return -errno;
		now = now_us();
		if (!began)
			began = now;
		recording_write_report(stream, now - began, data, size);
		if (fflush(stream))
			return cli_errno(errno, "recording");
		limits->seen++;
	}
	return cli_interrupted() ? CLI_OK : limits_status(limits);
}

static int record_to(FILE *stream, const struct pendant *pendant, struct options *options)
{
	struct recording head = { 0 };
	int fd, result;

	fd = open(pendant->hidraw, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
	if (fd < 0)
		return cli_errno(errno, "%s", pendant->hidraw);
	result = read_head(fd, &head);
	if (!result) {
		recording_write_head(stream, &head);
		result = fflush(stream) ? -errno : record(fd, stream, &options->limits);
	}
	close(fd);
	if (result >= 0)
		return result;
	if (!pendant_present(pendant))
		return cli_no_device("%s has gone", pendant->name);
	return cli_errno(result, "%s", pendant->hidraw);
}

static int record_to_file(const struct pendant *pendant, struct options *options)
{
	FILE *stream = fopen(options->path, "we");
	int status;

	if (!stream)
		return cli_errno(errno, "%s", options->path);
	status = record_to(stream, pendant, options);
	if (fclose(stream))
		status = cli_errno(errno, "%s", options->path);
	return status;
}

static int print_json(const struct pendant *pendant, const struct options *options)
{
	struct json_object *document = cli_json_new("record");

	cli_json_text(document, "name", pendant->name);
	cli_json_text(document, "file", options->path);
	cli_json_number(document, "reports", options->limits.seen);
	return cli_json_print(document);
}

int record_verb(int argc, char **argv)
{
	const struct argp argp = {
		.options = option_table, .parser = parse, .args_doc = "[FILE]", .doc = doc,
		.children = cli_children,
	};
	struct options options = { 0 };
	struct pendant pendant;
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &options);
	if (options.common.json && !options.path)
		return cli_usage("--json requires a FILE: the recording itself is not JSON");
	cli_catch_signals();
	status = pendant_choose(options.common.device, &pendant);
	if (status != CLI_OK)
		return status;
	if (!*pendant.hidraw)
		return cli_no_device("%s has no hidraw node", pendant.name);
	limits_start(&options.limits);
	status = options.path ? record_to_file(&pendant, &options) :
				record_to(stdout, &pendant, &options);
	if (options.common.json)
		status = print_json(&pendant, &options) ?: status;
	return status;
}
