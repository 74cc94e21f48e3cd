/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The forward channel: positions and commands to a head, through xy3-spi's IIO device
 * (userspace/abi/sysfs-bus-iio-xy3), or with --spidev through a plain spidev by libxy3.
 *
 * Functions return an enum cli_status, and have said what was wrong when it is not CLI_OK.
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
	const char *spidev;	/* NULL: the head's IIO device */
	unsigned int lines;	/* of a spidev */
	const char *map;
	unsigned int frame_bits;	/* 0: as it is, for a spidev 24 */
	unsigned int rate;	/* frames per second, 0: as it is */
};

/* For a verb's struct argp: an input of these as well as of the common options */
extern const struct argp_child forward_children[];
#define FORWARD_CHILD_COMMON 0
#define FORWARD_CHILD_FORWARD 1

struct forward;

/* Numbers of a scan, at most: all axes and the gate */
#define FORWARD_COLUMNS_MAX (XY3_AXES + 1)

/* device: name of the head, or NULL for the first one that has a forward channel */
int forward_open(struct forward **forward, const struct forward_settings *settings,
		 const char *device);
/* Set what the settings say. To be called once all else was found to be good, and before a rate. */
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
 * Move axes that are chosen, by index, to codes, by one scan: all at once. The others stay; with a
 * spidev they move to the middle, as their positions are not known.
 */
int forward_move(struct forward *forward, const uint32_t *codes, const bool *chosen);

/* A stream of scans. What forward_write() was given is sent when forward_stop() returns. */
int forward_start(struct forward *forward);
int forward_write(struct forward *forward, const uint32_t *codes, size_t scans, size_t *written);
int forward_stop(struct forward *forward);
/*
 * To be followed by forward_stop(): drop what the controller does not have yet, so that the mirrors
 * stop, with the gate low. With a
 * spidev nothing is under way between writes.
 */
int forward_abort(struct forward *forward);
/*
 * Scans that were sent, of this many that were written and are not under way any more. But for root
 * that is a guess behind forward_abort(): those that went out while it was called are not in it.
 */
unsigned long forward_sent(const struct forward *forward, unsigned long written);

/* Frames per second, requested and last measured; 0: not known */
long forward_rate(const struct forward *forward);
long forward_achieved(const struct forward *forward);
/* How often the stream was late; -1: not known */
long forward_underruns(const struct forward *forward);

/* A command, XY3_COMMAND_*, through the spidev; IIO has none: see head_write() */
int forward_command(struct forward *forward, uint32_t command);

#endif /* FORWARD_H */
