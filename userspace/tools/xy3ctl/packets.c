// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl packets: the packets of the backchannel, live or from a file.
 *
 * Formats: <linux/xy3.h>. The receiver is that of libxy3, the same as in the driver.
 */
#include <errno.h>
#include <fcntl.h>
#include <json-c/json.h>
#include <libxy3.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "cli-limits.h"
#include "cli.h"
#include "head.h"
#include "verbs.h"

/* Maximum wait: a signal may have arrived just before it */
#define WAIT_MS	500

struct settings {
	struct cli_common common;
	const char *file;	/* NULL: live */
	bool raw;
	bool big_endian;
	struct limits limits;	/* of packets */
};

enum { KEY_BIG_ENDIAN = 0x100 };

static const struct argp_option options[] = {
	{ "big-endian", KEY_BIG_ENDIAN, NULL, 0,
	  "Numbers of FILE are big endian", 0 },
	{ "count", 'n', "NUMBER", 0, "End after this number of packets", 0 },
	{ "raw", 'r', NULL, 0, "Also print the bytes of each packet, in hexadecimal", 0 },
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
	case ARGP_KEY_ARG:
		if (settings->file)
			argp_error(state, "only one FILE is possible");
		settings->file = argument;
		return 0;
	case KEY_BIG_ENDIAN:
		settings->big_endian = true;
		return 0;
	case 'r':
		settings->raw = true;
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
	.options = options, .parser = parse, .children = cli_children, .args_doc = "[FILE]",
	.doc = "Print the packets of a scanhead's backchannel, one per line."
	       "\v"
	       "Without FILE they are read live from the head's tty, and a line begins with the "
	       "time of day; no other program should read the tty at the same time, as the two "
	       "would share its bytes. FILE has the bytes received from a UART or from the tty, and "
	       "- is standard input; a line begins with the offset of the packet in bytes. Bytes "
	       "outside packets are omitted, and counted at the end, on standard error. With --json "
	       "the last object has the counts. The exit status is 1 if FILE has no packet, and 3 "
	       "when the head is removed.\n\n"
	       "  xy3ctl packets --raw\n"
	       "  xy3ctl packets --json uart.bin",
};

static const struct {
	enum xy3_packet_type type;
	const char *name;
} types[] = {
	{ XY3_PACKET_VENDOR, "vendor" },
	{ XY3_PACKET_MODEL, "model" },
	{ XY3_PACKET_FIRMWARE, "firmware" },
	{ XY3_PACKET_SERIAL, "serial" },
	{ XY3_PACKET_TEMPERATURES, "temperatures" },
	{ XY3_PACKET_FRAME_ERRORS, "frame_errors" },
	{ XY3_PACKET_ERRORS, "errors" },
	{ XY3_PACKET_DEBUG, "debug" },
	{ XY3_PACKET_HOURS, "hours" },
	{ XY3_PACKET_SYNC, "sync" },
};

static const char *type_name(uint8_t type)
{
	for (size_t i = 0; i < ARRAY_SIZE(types); i++) {
		if (types[i].type == type)
			return types[i].name;
	}
	return NULL;
}

/* ---- the content of a packet as JSON, from which the text is also made ---- */

static struct json_object *temperatures(const struct xy3_receiver *receiver)
{
	struct json_object *values = json_object_new_object();
	int16_t centidegrees[XY3_COMPONENTS];
	unsigned int count = xy3_receiver_temperatures(receiver, centidegrees);
	char text[16];

	for (unsigned int i = 0; i < count; i++) {
		if (centidegrees[i] == XY3_TEMPERATURE_NONE)
			continue;
		snprintf(text, sizeof(text), "%.2f", centidegrees[i] / 100.0);
		json_object_object_add(values, xy3_component_name(i),
				       json_object_new_double_s(centidegrees[i] / 100.0, text));
	}
	return values;
}

static struct json_object *frame_errors(const struct xy3_receiver *receiver)
{
	struct json_object *values = json_object_new_object();
	uint32_t frames[XY3_AXES];
	unsigned int count = xy3_receiver_frame_errors(receiver, frames);

	for (unsigned int i = 0; i < count; i++)
		cli_json_number(values, xy3_axis_name(i), frames[i]);
	return values;
}

static struct json_object *errors(const struct xy3_receiver *receiver)
{
	struct json_object *values = json_object_new_object();
	uint8_t error[XY3_COMPONENTS];
	unsigned int count = xy3_receiver_errors(receiver, error);
	char text[8];

	for (unsigned int i = 0; i < count; i++) {
		snprintf(text, sizeof(text), "%u", error[i]);
		cli_json_text(values, xy3_component_name(i), xy3_error_name(error[i]) ?: text);
	}
	return values;
}

static struct json_object *hours(const struct xy3_receiver *receiver)
{
	struct json_object *values = json_object_new_object();
	uint32_t number[XY3_COMPONENTS];
	unsigned int count = xy3_receiver_hours(receiver, number);

	for (unsigned int i = 0; i < count; i++) {
		if (number[i] != XY3_HOURS_NONE)
			cli_json_number(values, xy3_component_name(i), number[i]);
	}
	return values;
}

static struct json_object *hexadecimal(const uint8_t *data, size_t size)
{
	char text[3 * XY3_PACKET_MAX + 1] = "";

	for (size_t i = 0; i < size; i++)
		sprintf(text + 3 * i, "%02x ", data[i]);
	return json_object_new_string_len(text, size ? 3 * size - 1 : 0);
}

static struct json_object *value_of(const struct xy3_receiver *receiver)
{
	char text[XY3_PACKET_MAX];
	const uint8_t *packet;
	size_t size;

	switch (xy3_receiver_type(receiver)) {
	case XY3_PACKET_TEMPERATURES:
		return temperatures(receiver);
	case XY3_PACKET_FRAME_ERRORS:
		return frame_errors(receiver);
	case XY3_PACKET_ERRORS:
		return errors(receiver);
	case XY3_PACKET_HOURS:
		return hours(receiver);
	case XY3_PACKET_SYNC:
		return NULL;
	}
	if (xy3_receiver_is_known(receiver)) {
		xy3_receiver_text(receiver, text, sizeof(text));
		return json_object_new_string(text);
	}
	packet = xy3_receiver_packet(receiver, &size);
	return hexadecimal(packet + XY3_PACKET_HEADER, size - XY3_PACKET_HEADER);
}

/* ---- printing ---- */

static void print_value(struct json_object *value)
{
	if (!json_object_is_type(value, json_type_object)) {
		if (value)
			printf(" %s", json_object_get_string(value));
		return;
	}
	json_object_object_foreach(value, name, member)
		printf(" %s=%s", name, json_object_get_string(member));
}

static void print_text(const struct settings *settings, const struct xy3_receiver *receiver,
		       const char *place)
{
	struct json_object *value = value_of(receiver), *bytes;
	uint8_t type = xy3_receiver_type(receiver);
	const uint8_t *packet;
	char number[8];
	size_t size;

	snprintf(number, sizeof(number), "type_%02x", type);
	printf("%s%12s%s %s%s%s", cli_colour(CLI_DIM), place, cli_colour(CLI_PLAIN),
	       cli_colour(CLI_BOLD), type_name(type) ?: number, cli_colour(CLI_PLAIN));
	print_value(value);
	putchar('\n');
	json_object_put(value);
	if (settings->raw) {
		packet = xy3_receiver_packet(receiver, &size);
		bytes = hexadecimal(packet, size);
		printf("%12s %s\n", "", json_object_get_string(bytes));
		json_object_put(bytes);
	}
}

static void print_json(const struct settings *settings, const struct xy3_receiver *receiver,
		       long long offset)
{
	struct json_object *document = cli_json_new("packets");
	uint8_t type = xy3_receiver_type(receiver);
	const uint8_t *packet;
	struct timespec time;
	size_t size;

	if (settings->file) {
		cli_json_number(document, "offset", offset);
	} else {
		clock_gettime(CLOCK_REALTIME, &time);
		cli_json_seconds(document, "time", time.tv_sec + time.tv_nsec / 1e9);
	}
	cli_json_number(document, "type", type);
	cli_json_text(document, "name", type_name(type));
	json_object_object_add(document, "value", value_of(receiver));
	if (settings->raw) {
		packet = xy3_receiver_packet(receiver, &size);
		json_object_object_add(document, "raw", hexadecimal(packet, size));
	}
	cli_json_print(document);
}

static void print_packet(const struct settings *settings, const struct xy3_receiver *receiver,
			 long long offset)
{
	struct timespec time;
	struct tm day;
	char place[24];

	if (settings->common.json) {
		print_json(settings, receiver, offset);
		return;
	}
	if (settings->file) {
		snprintf(place, sizeof(place), "%lld", offset);
	} else {
		clock_gettime(CLOCK_REALTIME, &time);
		localtime_r(&time.tv_sec, &day);
		snprintf(place, sizeof(place), "%02d:%02d:%02d.%03ld", day.tm_hour, day.tm_min,
			 day.tm_sec, time.tv_nsec / 1000000);
	}
	print_text(settings, receiver, place);
}

static const struct {
	enum xy3_counter counter;
	const char *name;
} counters[] = {
	{ XY3_COUNT_PACKETS, "packets" },
	{ XY3_COUNT_PACKET_BYTES, "packet_bytes" },
	{ XY3_COUNT_DROPPED_BYTES, "dropped_bytes" },
	{ XY3_COUNT_WAITING_BYTES, "waiting_bytes" },
	{ XY3_COUNT_RESYNCS, "resyncs" },
	{ XY3_COUNT_BAD_LENGTHS, "bad_lengths" },
	{ XY3_COUNT_UNKNOWN, "unknown_packets" },
};

static void print_counts(const struct settings *settings, const struct xy3_receiver *receiver)
{
	struct json_object *document, *counts = json_object_new_object();

	for (size_t i = 0; i < ARRAY_SIZE(counters); i++)
		cli_json_number(counts, counters[i].name,
				xy3_receiver_count(receiver, counters[i].counter));
	if (settings->common.json) {
		document = cli_json_new("packets");
		json_object_object_add(document, "counts", counts);
		cli_json_print(document);
		return;
	}
	fflush(stdout);
	json_object_object_foreach(counts, name, value)
		fprintf(stderr, "%s %s  ", name, json_object_get_string(value));
	fputc('\n', stderr);
	json_object_put(counts);
}

/* ---- reading ---- */

struct source {
	int fd;
	struct xy3_receiver *receiver;
	long long offset;	/* of the next data */
};

/* Print the packets in data. Return false if the count is reached. */
static bool take(struct settings *settings, struct source *source, const uint8_t *data,
		 size_t size)
{
	const uint8_t *start = data;
	size_t length;

	while (xy3_receiver_next(source->receiver, &data, &size)) {
		/* the packet ends here */
		xy3_receiver_packet(source->receiver, &length);
		print_packet(settings, source->receiver,
			     source->offset + (data - start) - (long long)length);
		settings->limits.seen++;
		if (limits_reached(&settings->limits))
			return false;
	}
	source->offset += data - start;
	return true;
}

/* The next data. Return their size, 0 at the end, -EINTR to stop. */
static ssize_t next_data(const struct limits *limits, int fd, uint8_t *data, size_t size)
{
	struct pollfd file = { .fd = fd, .events = POLLIN };
	ssize_t got;

	do {
		if (cli_interrupted() || limits_time_is_up(limits))
			return -EINTR;
	} while (poll(&file, 1, limits_wait_ms(limits, WAIT_MS)) <= 0);
	got = read(fd, data, size);
	return got < 0 ? -errno : got;
}

/* Return an enum cli_status */
static int read_all(struct settings *settings, struct source *source)
{
	const char *name = settings->file ?: "the head";
	static uint8_t data[65536];
	ssize_t got;

	do {
		got = next_data(&settings->limits, source->fd, data, sizeof(data));
	} while (got > 0 && take(settings, source, data, got));

	if (got > 0 || cli_interrupted())
		return CLI_OK;
	if (got == -EINTR)
		return limits_status(&settings->limits);
	/* the tty has hung up */
	if (!settings->file && (!got || got == -EIO))
		return cli_no_device("the head has gone");
	return got < 0 ? cli_errno(got, "%s", name) : CLI_OK;
}

/* A tty delivers complete packets: there is no need to wait for a sync */
static void begin_in_sync(struct xy3_receiver *receiver)
{
	static const uint8_t syncs[] = {
		XY3_PACKET_START, XY3_PACKET_SYNC, 0, XY3_PACKET_START, XY3_PACKET_SYNC, 0,
	};
	const uint8_t *data = syncs;
	size_t size = sizeof(syncs);

	while (xy3_receiver_next(receiver, &data, &size))
		;
}

static int packets_of_file(struct settings *settings, struct source *source)
{
	uint64_t bytes, packets;
	int status;

	source->fd = strcmp(settings->file, "-") ? open(settings->file, O_RDONLY) : STDIN_FILENO;
	if (source->fd < 0)
		return cli_errno(errno, "%s", settings->file);
	xy3_receiver_set_big_endian(source->receiver, settings->big_endian);
	status = read_all(settings, source);
	print_counts(settings, source->receiver);
	packets = xy3_receiver_count(source->receiver, XY3_COUNT_PACKETS);
	bytes = xy3_receiver_count(source->receiver, XY3_COUNT_DROPPED_BYTES) +
		xy3_receiver_count(source->receiver, XY3_COUNT_WAITING_BYTES);
	if (status == CLI_OK && !packets && !cli_interrupted())
		return cli_error("%s: no packet in %llu bytes", settings->file,
				 (unsigned long long)bytes);
	return status;
}

static int packets_of_head(struct settings *settings, struct source *source)
{
	struct head head;
	char order[16];
	int status;

	status = head_find(&head, settings->common.device);
	if (status)
		return status;
	source->fd = open(head.node, O_RDONLY | O_NOCTTY | O_CLOEXEC);
	if (source->fd < 0)
		return cli_errno(errno, "%s", head.node);
	if (head_read(&head, "byte_order", order, sizeof(order)) > 0)
		xy3_receiver_set_big_endian(source->receiver, !strcmp(order, "big"));
	begin_in_sync(source->receiver);
	return read_all(settings, source);
}

int packets_verb(int argc, char **argv)
{
	struct settings settings = { 0 };
	struct source source = { .fd = -1 };
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &settings);
	source.receiver = xy3_receiver_new();
	if (!source.receiver)
		return cli_errno(ENOMEM, "packets");
	limits_start(&settings.limits);
	cli_catch_signals();
	status = settings.file ? packets_of_file(&settings, &source) :
				 packets_of_head(&settings, &source);
	if (source.fd >= 0)
		close(source.fd);
	xy3_receiver_free(source.receiver);
	return status;
}
