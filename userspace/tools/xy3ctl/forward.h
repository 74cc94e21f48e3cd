/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The forward channel: positions and commands to a head, through xy3-spi's IIO device
 * (userspace/abi/sysfs-bus-iio-xy3), or with --spidev through a plain spidev by libxy3.
 *
 * Functions return an enum cli_status, and have reported the error if it is not CLI_OK.
 */
#ifndef FORWARD_H
#define FORWARD_H

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <linux/xy3.h>

/* The options */
struct forward_settings {
	const char *spidev;	/* NULL: the IIO device of the head */
	unsigned int lines;	/* of a spidev */
	const char *map;
	unsigned int frame_bits;	/* 0: unchanged, for a spidev 24 */
	unsigned int rate;	/* frames per second, 0: unchanged */
};

/* For the struct argp of a verb: an input of these and of the common options */
extern const struct argp_child forward_children[];
#define FORWARD_CHILD_COMMON 0
#define FORWARD_CHILD_FORWARD 1

struct forward;

/* Maximum numbers of a scan: all axes and the gate */
#define FORWARD_COLUMNS_MAX (XY3_AXES + 1)

/* device: name of the head, or NULL for the first one that has a forward channel */
int forward_open(struct forward **forward, const struct forward_settings *settings,
		 const char *device);
/* Apply the settings. To be called after all checks have passed, and before a rate. */
int forward_apply(struct forward *forward);
void forward_close(struct forward *forward);

const char *forward_name(const struct forward *forward);
/* Codes of a scan; the axis of each; and the highest code */
unsigned int forward_axes(const struct forward *forward);
/* A scan of a stream has 1 or 0 for the laser's gate after its codes; it is not an interlock */
bool forward_gate(const struct forward *forward);
enum xy3_axis forward_axis(const struct forward *forward, unsigned int index);
uint32_t forward_top(const struct forward *forward);

/*
 * Move selected axes, by index, to codes, by one scan: all at the same time. The others stay; with
 * a spidev they move to the middle, as their positions are unknown.
 */
int forward_move(struct forward *forward, const uint32_t *codes, const bool *chosen);

/* A stream of scans. All scans of forward_write() have been sent when forward_stop() returns. */
int forward_start(struct forward *forward);
int forward_write(struct forward *forward, const uint32_t *codes, size_t scans, size_t *written);
int forward_stop(struct forward *forward);
/*
 * To be followed by forward_stop(): drop scans that the controller does not have yet, so that the
 * mirrors stop, with the gate low. With a spidev nothing is pending between writes.
 */
int forward_abort(struct forward *forward);
/*
 * Scans sent, of this number that were written and are not pending any more. After forward_abort()
 * it is an estimate, except for root: it does not include scans sent during the call.
 */
unsigned long forward_sent(const struct forward *forward, unsigned long written);

/* Frames per second, requested and last measured; 0: unknown */
long forward_rate(const struct forward *forward);
long forward_achieved(const struct forward *forward);
/* Number of times that the stream was late; -1: unknown */
long forward_underruns(const struct forward *forward);

/* A command, XY3_COMMAND_*, through the spidev; IIO has none: see head_write() */
int forward_command(struct forward *forward, uint32_t command);

#endif /* FORWARD_H */
