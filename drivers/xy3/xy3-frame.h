/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XY3-100 forward channel: frames, commands and the rates of the backchannel
 *
 *   24 bits   0 P D19..D0 p1 p0         32 bits   1 P D25..D0 p3..p0
 *
 * P is 1 for a position, 0 for a command; p counts the ones among D. A command has 20 bits, in a
 * 32-bit frame at D19..D0 with D25..D20 zero. Frames travel most significant byte first.
 *
 * Pure functions over bytes, without allocation, sleeping or a device.
 */
#ifndef XY3_FRAME_H
#define XY3_FRAME_H

#include <linux/bitfield.h>
#include <linux/bitops.h>
#include <linux/bits.h>
#include <linux/types.h>
#include <linux/xy3.h>

#define XY3_FRAME24_POSITION	BIT(22)
#define XY3_FRAME24_DATA	GENMASK(21, 2)
#define XY3_FRAME24_PARITY	GENMASK(1, 0)

#define XY3_FRAME32_LONG	BIT(31)
#define XY3_FRAME32_POSITION	BIT(30)
#define XY3_FRAME32_DATA	GENMASK(29, 4)
#define XY3_FRAME32_PARITY	GENMASK(3, 0)

#define XY3_CODE24_MAX		FIELD_MAX(XY3_FRAME24_DATA)
#define XY3_CODE32_MAX		FIELD_MAX(XY3_FRAME32_DATA)

/**
 * enum xy3_frame_verdict - how a receiver classifies a frame
 * @XY3_FRAME_POSITION: a position
 * @XY3_FRAME_COMMAND: a command
 * @XY3_FRAME_TORN: fewer bytes than its first bit requires
 * @XY3_FRAME_BAD_PARITY: the count of ones is wrong
 */
enum xy3_frame_verdict {
	XY3_FRAME_POSITION,
	XY3_FRAME_COMMAND,
	XY3_FRAME_TORN,
	XY3_FRAME_BAD_PARITY
};

/**
 * struct xy3_frame - a frame
 * @verdict: its class
 * @size: its bytes, XY3_FRAME24_SIZE or XY3_FRAME32_SIZE
 * @data: D, 20 or 26 bits; always 20 for a command
 */
struct xy3_frame {
	enum xy3_frame_verdict verdict;
	u8 size;
	u32 data;
};

/* A 24-bit frame of @data, of which 20 bits count, as a command */
static inline u32 xy3_frame24(u32 data)
{
	data &= XY3_CODE24_MAX;
	return FIELD_PREP(XY3_FRAME24_DATA, data) | (hweight32(data) & XY3_FRAME24_PARITY);
}

/* A 32-bit frame of @data, of which 26 bits count, as a command */
static inline u32 xy3_frame32(u32 data)
{
	data &= XY3_CODE32_MAX;
	return XY3_FRAME32_LONG | FIELD_PREP(XY3_FRAME32_DATA, data) |
	       (hweight32(data) & XY3_FRAME32_PARITY);
}

void xy3_decode_frame(const u8 *raw, size_t size, struct xy3_frame *frame);
void xy3_encode_command(u32 command, u8 raw[XY3_FRAME24_SIZE]);

/* Rates of the backchannel in bit/s, ascending; 0 after the last one */
unsigned int xy3_rate(unsigned int index);
bool xy3_is_rate(unsigned int rate);
int xy3_rate_command(unsigned int rate);

int xy3_parse_axes(const char *text, u32 *axes);
int xy3_parse_switch(const char *text, bool *on, u32 *axes);

#endif /* XY3_FRAME_H */
