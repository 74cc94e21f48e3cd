// SPDX-License-Identifier: GPL-2.0-only
/*
 * The forward channel, by IIO or spidev. See forward.h.
 */
#include <endian.h>
#include <errno.h>
#include <fcntl.h>
#include <libxy3.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "forward.h"
#include "head.h"
#include "number.h"

#define RATE_MAX 100000000
#define WAIT_MS 100		/* maximum delay of a signal that is not noticed at once */
#define BUFFER_SCANS 4096	/* queued in the kernel: 41 ms at 100 000 frames/s */

struct forward {
	char name[64];
	unsigned int axes;
	bool gate;
	uint32_t top;
	long rate;
	/* IIO */
	struct head head;
	struct forward_settings settings;	/* see forward_apply() */
	int fd;
	long long underruns;	/* before the stream */
	long long sent;		/* scans at this time, as counted by iio_sent() */
	long long dropped;	/* pending scans when the stream was aborted */
	/* spidev, or NULL */
	struct xy3_spidev *spidev;
	struct xy3_line_map *map;
};

/* ---- options ---- */

enum { KEY_SPIDEV = 0x200, KEY_LINES, KEY_MAP, KEY_BITS };

static const struct argp_option forward_options[] = {
	{ "bits", KEY_BITS, "24|32", 0, "Bits of a frame: codes of 20 or 26 bits", 5 },
	{ "rate", 'r', "FRAMES", 0, "Frames per second", 5 },
	{ "spidev", KEY_SPIDEV, "NODE", 0,
	  "Use a plain /dev/spidevB.C, where xy3-spi cannot be used", 6 },
	{ "lines", KEY_LINES, "1|2|4|8", 0, "Data lines of the spidev (1)", 6 },
	{ "map", KEY_MAP, "SIGNALS", 0,
	  "What each line of the spidev carries, from IO0 on: x y z u w sync gate -", 6 },
	{ 0 }
};

static error_t parse_forward(int key, char *argument, struct argp_state *state)
{
	struct forward_settings *settings = state->input;

	switch (key) {
	case KEY_SPIDEV:
		settings->spidev = argument;
		return 0;
	case KEY_MAP:
		settings->map = argument;
		return 0;
	case KEY_LINES:
		settings->lines = option_whole("--lines", argument, 1, 8, state);
		return 0;
	case KEY_BITS:
		settings->frame_bits = option_whole("--bits", argument, 24, 32, state);
		if (settings->frame_bits != 24 && settings->frame_bits != 32)
			argp_error(state, "--bits: must be 24 or 32");
		return 0;
	case 'r':
		settings->rate = option_whole("--rate", argument, 1, RATE_MAX, state);
		return 0;
	case ARGP_KEY_END:
		if (!settings->spidev && (settings->lines || settings->map))
			argp_error(state, "--lines and --map require --spidev");
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static const struct argp forward_argp = { .options = forward_options, .parser = parse_forward };

const struct argp_child forward_children[] = {
	[FORWARD_CHILD_COMMON] = { &cli_common_argp, 0, NULL, 0 },
	[FORWARD_CHILD_FORWARD] = { &forward_argp, 0, NULL, 0 },
	{ 0 }
};

/* ---- IIO ---- */

static int iio_failed(const struct forward *forward, const char *name, int error)
{
	if (error == -EBUSY)
		return cli_error("%s: a stream runs; "
				 "`echo 0 > /sys/bus/iio/devices/%s/buffer/enable' "
				 "ends one that a program has left enabled",
				 forward->name, forward->head.iio);
	if (error == -EACCES)
		return cli_error("%s: %s: permission denied: join the group dialout",
				 forward->name, name);
	return cli_errno(error, "%s: %s", forward->name, name);
}

static int iio_set(const struct forward *forward, const char *name, long long value)
{
	int error = head_write_iio(&forward->head, name, value);

	return error ? iio_failed(forward, name, error) : CLI_OK;
}

static int find_head(struct head *head, const char *device)
{
	struct head heads[HEADS_MAX];
	size_t count;

	if (device) {
		int status = head_find(head, device);

		if (!status && !head->iio[0])
			return cli_no_device("%s has no forward channel", head->name);
		return status;
	}
	count = head_list(heads);
	for (size_t i = 0; i < count; i++) {
		if (heads[i].iio[0]) {
			*head = heads[i];
			return CLI_OK;
		}
	}
	return cli_no_device("no scanhead with a forward channel; run `xy3ctl doctor' to find the "
			     "reason");
}

static int iio_open(struct forward *forward, const struct forward_settings *settings,
		    const char *device)
{
	char path[96], label[8];
	long long bits = settings->frame_bits;
	int status;

	status = find_head(&forward->head, device);
	if (status)
		return status;
	snprintf(forward->name, sizeof(forward->name), "%s", forward->head.name);
	forward->settings = *settings;
	if (!bits && head_read_iio(&forward->head, "frame_bits", &bits))
		return cli_no_device("%s has gone", forward->name);
	forward->axes = head_axes(&forward->head);
	snprintf(path, sizeof(path), "forward/%s/out_voltage0_label", forward->head.iio);
	forward->gate = head_read(&forward->head, path, label, sizeof(label)) > 0;
	/* <linux/xy3.h>: 20 data bits in 24, 26 in 32 */
	forward->top = bits == 32 ? (1u << 26) - 1 : (1u << 20) - 1;
	return CLI_OK;
}

static int iio_apply(struct forward *forward)
{
	long long rate;
	int status = CLI_OK;

	if (forward->settings.frame_bits)
		status = iio_set(forward, "frame_bits", forward->settings.frame_bits);
	if (!status && forward->settings.rate)
		status = iio_set(forward, "sampling_frequency", forward->settings.rate);
	if (status)
		return status;
	if (head_read_iio(&forward->head, "sampling_frequency", &rate))
		return cli_no_device("%s has gone", forward->name);
	forward->rate = rate;
	return CLI_OK;
}

/* Scans of streams sent since the device was created; -1: unknown, except for root */
static long long iio_sent(const struct forward *forward)
{
	long long scans, repeated, commands;

	if (head_read_counter(&forward->head, "scans", &scans) ||
	    head_read_counter(&forward->head, "repeated", &repeated) ||
	    head_read_counter(&forward->head, "commands", &commands))
		return -1;
	return scans - repeated - commands;
}

static int iio_start(struct forward *forward)
{
	char name[64];
	int status;

	for (unsigned int i = 0; i < forward->axes; i++) {
		snprintf(name, sizeof(name), "scan_elements/out_angl%u_en", i);
		status = iio_set(forward, name, 1);
		if (status)
			return status;
	}
	if (forward->gate) {
		status = iio_set(forward, "scan_elements/out_voltage0_en", 1);
		if (status)
			return status;
	}
	status = iio_set(forward, "buffer/length", BUFFER_SCANS);
	if (status)
		return status;
	snprintf(name, sizeof(name), "/dev/%s", forward->head.iio);
	forward->fd = open(name, O_WRONLY | O_CLOEXEC);
	if (forward->fd < 0 || fcntl(forward->fd, F_SETFL, O_WRONLY | O_NONBLOCK))
		return iio_failed(forward, name, -errno);
	head_read_iio(&forward->head, "underruns", &forward->underruns);
	forward->sent = iio_sent(forward);
	status = iio_set(forward, "buffer/enable", 1);
	if (status) {
		close(forward->fd);
		forward->fd = -1;
	}
	return status;
}

static int iio_write(struct forward *forward, const uint32_t *codes, size_t scans, size_t *written)
{
	static uint32_t data[1024 * FORWARD_COLUMNS_MAX];	/* little endian */
	struct pollfd file = { .fd = forward->fd, .events = POLLOUT };
	size_t size = 4 * (forward->axes + forward->gate);
	ssize_t taken;

	if (scans > sizeof(data) / size)
		scans = sizeof(data) / size;
	for (size_t i = 0; i < scans * size / 4; i++)
		data[i] = htole32(codes[i]);
	taken = write(forward->fd, data, scans * size);
	if (taken >= 0) {
		*written = taken / size;
		return CLI_OK;
	}
	*written = 0;
	if (errno == EAGAIN) {
		/* a signal just before a blocking write() would be noticed after it only */
		poll(&file, 1, WAIT_MS);
		return CLI_OK;
	}
	if (errno == EINTR)
		return CLI_OK;
	if (errno == ENODEV)
		return cli_no_device("%s has gone", forward->name);
	return cli_errno(errno, "%s: the stream has ended", forward->name);
}

/* ---- spidev ---- */

static int spidev_failed(const struct forward *forward, int error)
{
	switch (error) {
	case -ENOENT:
	case -ENODEV:
	case -ENXIO:
	case -ESHUTDOWN:
		return cli_no_device("%s: %s", forward->name, strerror(-error));
	case -EOPNOTSUPP:
		return cli_error("%s: the controller has fewer data lines", forward->name);
	case -EINVAL:
		return cli_error("%s: the controller refuses this mode", forward->name);
	case -ERANGE:
		return cli_error("%s: the bus is too slow for this rate", forward->name);
	}
	return cli_errno(error, "%s", forward->name);
}

static int spidev_open(struct forward *forward, const struct forward_settings *settings)
{
	unsigned int bits = settings->frame_bits ?: 24, lines = settings->lines ?: 1;
	int error;

	snprintf(forward->name, sizeof(forward->name), "%s", settings->spidev);
	error = xy3_line_map_new(&forward->map, lines, bits, settings->map);
	if (error == -EINVAL)
		return cli_usage("unsupported line map: --lines %u --map '%s'",
				 lines, settings->map ?: "");
	if (error)
		return cli_errno(error, "%s", forward->name);
	error = xy3_spidev_open(&forward->spidev, settings->spidev, forward->map, settings->rate);
	if (error)
		return spidev_failed(forward, error);
	forward->axes = xy3_line_map_axes(forward->map);
	forward->gate = xy3_line_map_has_gate(forward->map);
	forward->top = xy3_code_max(forward->map);
	forward->rate = xy3_spidev_rate(forward->spidev);
	return CLI_OK;
}

static int spidev_write(struct forward *forward, const uint32_t *codes, size_t scans,
			size_t *written)
{
	ssize_t sent = xy3_spidev_write(forward->spidev, codes, scans);

	*written = sent < 0 ? 0 : sent;
	if (sent >= 0 || sent == -EINTR)
		return CLI_OK;
	return spidev_failed(forward, sent);
}

/* ---- both ---- */

int forward_open(struct forward **result, const struct forward_settings *settings,
		 const char *device)
{
	struct forward *forward = calloc(1, sizeof(*forward));
	int status;

	if (!forward)
		return cli_errno(ENOMEM, "forward channel");
	forward->fd = -1;
	status = settings->spidev ? spidev_open(forward, settings) :
				    iio_open(forward, settings, device);
	if (status) {
		forward_close(forward);
		return status;
	}
	*result = forward;
	return CLI_OK;
}

int forward_apply(struct forward *forward)
{
	return forward->spidev ? CLI_OK : iio_apply(forward);
}

void forward_close(struct forward *forward)
{
	if (forward->fd >= 0)
		close(forward->fd);
	if (forward->spidev)
		xy3_spidev_close(forward->spidev);
	xy3_line_map_free(forward->map);
	free(forward);
}

const char *forward_name(const struct forward *forward)
{
	return forward->name;
}

unsigned int forward_axes(const struct forward *forward)
{
	return forward->axes;
}

bool forward_gate(const struct forward *forward)
{
	return forward->gate;
}

/* The channels of IIO are the axes that are on a line, in their order, with labels as names */
static enum xy3_axis iio_axis(const struct forward *forward, unsigned int index)
{
	char path[96], label[8];

	snprintf(path, sizeof(path), "forward/%s/out_angl%u_label", forward->head.iio, index);
	if (head_read(&forward->head, path, label, sizeof(label)) > 0) {
		for (unsigned int axis = 0; axis < XY3_AXES; axis++) {
			if (!strcmp(xy3_axis_name(axis), label))
				return axis;
		}
	}
	return index;
}

enum xy3_axis forward_axis(const struct forward *forward, unsigned int index)
{
	return forward->spidev ? (enum xy3_axis)xy3_line_map_axis(forward->map, index) :
				 iio_axis(forward, index);
}

uint32_t forward_top(const struct forward *forward)
{
	return forward->top;
}

int forward_start(struct forward *forward)
{
	return forward->spidev ? CLI_OK : iio_start(forward);
}

int forward_write(struct forward *forward, const uint32_t *codes, size_t scans, size_t *written)
{
	return forward->spidev ? spidev_write(forward, codes, scans, written) :
				 iio_write(forward, codes, scans, written);
}

int forward_stop(struct forward *forward)
{
	/* it returns when the last scan has been sent */
	return forward->spidev ? CLI_OK : iio_set(forward, "buffer/enable", 0);
}

int forward_abort(struct forward *forward)
{
	if (forward->spidev)
		return CLI_OK;
	head_read_iio(&forward->head, "buffer/data_available", &forward->dropped);
	return iio_set(forward, "abort", 1);
}

/* The position of an axis in the driver */
static int iio_position(const struct forward *forward, unsigned int index, long long *code)
{
	char name[32];

	snprintf(name, sizeof(name), "out_angl%u_raw", index);
	if (head_read_iio(&forward->head, name, code))
		return cli_no_device("%s has gone", forward->name);
	return CLI_OK;
}

/* A stream of one scan, which is stopped in any case */
static int iio_move(struct forward *forward, const uint32_t *scan)
{
	size_t written;
	long long code;
	int status, end;

	cli_catch_signals();
	status = forward_start(forward);
	if (status)
		return status;
	status = forward_write(forward, scan, 1, &written);
	cli_release_signals();
	end = forward_stop(forward);
	if (status || end || cli_interrupted())
		return status ?: end;
	/* the error of the controller may have occurred after the write */
	for (unsigned int i = 0; i < forward->axes; i++) {
		status = iio_position(forward, i, &code);
		if (status)
			return status;
		if (code != scan[i])
			return cli_error("%s: the controller has not sent the position; see dmesg",
					 forward->name);
	}
	return CLI_OK;
}

int forward_move(struct forward *forward, const uint32_t *codes, const bool *chosen)
{
	uint32_t scan[FORWARD_COLUMNS_MAX] = { 0 };	/* the gate is low */
	long long code = forward->top / 2 + 1;
	size_t written;
	int status;

	for (unsigned int i = 0; i < forward->axes; i++) {
		status = forward->spidev || chosen[i] ? CLI_OK : iio_position(forward, i, &code);
		if (status)
			return status;
		scan[i] = chosen[i] ? codes[i] : code;
	}
	return forward->spidev ? spidev_write(forward, scan, 1, &written) :
				 iio_move(forward, scan);
}

unsigned long forward_sent(const struct forward *forward, unsigned long written)
{
	long long sent = forward->spidev ? -1 : iio_sent(forward);

	if (sent < 0 || forward->sent < 0)
		return written - forward->dropped;
	sent -= forward->sent;
	return sent > (long long)written ? written : (unsigned long)sent;
}

long forward_rate(const struct forward *forward)
{
	return forward->rate;
}

long forward_achieved(const struct forward *forward)
{
	long long rate = 0;

	if (!forward->spidev)
		head_read_iio(&forward->head, "achieved_frequency", &rate);
	return rate;
}

long forward_underruns(const struct forward *forward)
{
	long long underruns;

	if (forward->spidev || head_read_iio(&forward->head, "underruns", &underruns))
		return -1;
	return underruns - forward->underruns;
}

int forward_command(struct forward *forward, uint32_t command)
{
	int error = xy3_spidev_command(forward->spidev, command);

	return error ? spidev_failed(forward, error) : CLI_OK;
}
