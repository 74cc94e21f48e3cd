// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: frames, commands and the rates of the backchannel
 */

#include <linux/ctype.h>
#include <linux/errno.h>
#include <linux/kernel.h>
#include <linux/string.h>
#include <linux/unaligned.h>

#include "xy3-frame.h"

/* The first bit of a frame, in its first byte */
#define XY3_FRAME_IS_32		BIT(7)

static const struct xy3_rate_row {
	unsigned int rate;
	u32 command;
} xy3_rates[] = {
	{  57600, XY3_COMMAND_RATE_57600 },
	{ 115200, XY3_COMMAND_RATE_115200 },
	{ 230400, XY3_COMMAND_RATE_230400 },
	{ 460800, XY3_COMMAND_RATE_460800 },
	{ 921600, XY3_COMMAND_RATE_921600 },
};

static bool xy3_decode24(u32 bits, struct xy3_frame *frame)
{
	frame->data = FIELD_GET(XY3_FRAME24_DATA, bits);
	frame->verdict = bits & XY3_FRAME24_POSITION ? XY3_FRAME_POSITION : XY3_FRAME_COMMAND;
	return FIELD_GET(XY3_FRAME24_PARITY, bits) == (hweight32(frame->data) & XY3_FRAME24_PARITY);
}

static bool xy3_decode32(u32 bits, struct xy3_frame *frame)
{
	frame->data = FIELD_GET(XY3_FRAME32_DATA, bits);
	frame->verdict = bits & XY3_FRAME32_POSITION ? XY3_FRAME_POSITION : XY3_FRAME_COMMAND;
	return FIELD_GET(XY3_FRAME32_PARITY, bits) == (hweight32(frame->data) & XY3_FRAME32_PARITY);
}

/**
 * xy3_decode_frame() - read the frame at the start of some bytes
 * @raw: the bytes, most significant first
 * @size: number of bytes, at least 1
 * @frame: the frame read
 *
 * For a torn frame only the size is set. The bits of a command above its 20 only count for the
 * parity.
 */
void xy3_decode_frame(const u8 *raw, size_t size, struct xy3_frame *frame)
{
	bool good;

	*frame = (struct xy3_frame) {
		.size = raw[0] & XY3_FRAME_IS_32 ? XY3_FRAME32_SIZE : XY3_FRAME24_SIZE,
		.verdict = XY3_FRAME_TORN,
	};
	if (size < frame->size)
		return;

	if (frame->size == XY3_FRAME32_SIZE)
		good = xy3_decode32(get_unaligned_be32(raw), frame);
	else
		good = xy3_decode24(get_unaligned_be24(raw), frame);

	if (frame->verdict == XY3_FRAME_COMMAND)
		frame->data &= XY3_COMMAND_MAX;
	if (!good)
		frame->verdict = XY3_FRAME_BAD_PARITY;
}

/**
 * xy3_encode_command() - make a 24-bit command frame
 * @command: XY3_COMMAND_*, with axes where it takes them; bits above 20 are ignored
 * @raw: the frame
 */
void xy3_encode_command(u32 command, u8 raw[XY3_FRAME24_SIZE])
{
	put_unaligned_be24(xy3_frame24(command & XY3_COMMAND_MAX), raw);
}

/**
 * xy3_rate() - a rate that the backchannel supports
 * @index: 0 for the lowest
 *
 * Return: the rate in bit/s, 0 after the last one.
 */
unsigned int xy3_rate(unsigned int index)
{
	return index < ARRAY_SIZE(xy3_rates) ? xy3_rates[index].rate : 0;
}

/**
 * xy3_rate_command() - the command that sets a rate of the backchannel
 * @rate: in bit/s
 *
 * Return: XY3_COMMAND_RATE_*, or -EINVAL if the backchannel does not support this rate.
 */
int xy3_rate_command(unsigned int rate)
{
	for (size_t i = 0; i < ARRAY_SIZE(xy3_rates); i++)
		if (xy3_rates[i].rate == rate)
			return xy3_rates[i].command;
	return -EINVAL;
}

/**
 * xy3_is_rate() - whether the backchannel can have a rate
 * @rate: in bit/s
 *
 * Return: true if it is one of the five.
 */
bool xy3_is_rate(unsigned int rate)
{
	return xy3_rate_command(rate) != -EINVAL;
}

static int xy3_axis_of(char letter)
{
	static const char letters[] = "xyzuw";
	const char *found = letter ? strchr(letters, tolower(letter)) : NULL;

	return found ? (int)(found - letters) : -EINVAL;
}

/**
 * xy3_parse_axes() - read the axes of a command
 * @text: letters out of xyzuw; nothing or "all" for all axes; white space around them is ignored
 * @axes: XY3_COMMAND_AXIS() of each, by |; 0 for all
 *
 * Return: 0, or -EINVAL if @text is anything else.
 */
int xy3_parse_axes(const char *text, u32 *axes)
{
	u32 mask = 0;
	int axis;

	text = skip_spaces(text);
	if (!strncmp(text, "all", 3))
		text += 3;
	else
		for (; *text && !isspace(*text); text++) {
			axis = xy3_axis_of(*text);
			if (axis < 0)
				return axis;
			mask |= XY3_COMMAND_AXIS(axis);
		}
	if (*skip_spaces(text))
		return -EINVAL;
	*axes = mask;
	return 0;
}

/**
 * xy3_parse_switch() - read "on" or "off" and which axes it is for
 * @text: on or off, optionally followed by white space and axes as for xy3_parse_axes()
 * @on: which of the two
 * @axes: as xy3_parse_axes()
 *
 * Return: 0, or -EINVAL when @text is anything else.
 */
int xy3_parse_switch(const char *text, bool *on, u32 *axes)
{
	bool is_on;

	text = skip_spaces(text);
	is_on = !strncmp(text, "on", 2);
	if (!is_on && strncmp(text, "off", 3))
		return -EINVAL;
	text += is_on ? 2 : 3;
	if (*text && !isspace(*text))
		return -EINVAL;
	*on = is_on;
	return xy3_parse_axes(text, axes);
}
