// SPDX-License-Identifier: GPL-2.0-only
/*
 * libxy3: frames of the forward channel, and encoding of scans
 */

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include <linux/unaligned.h>

#include "libxy3.h"
#include "scans.h"
#include "xy3-frame.h"
#include "xy3-lines.h"

/* ---- one frame ---- */

int xy3_frame_encode(unsigned int frame_bits, bool position, uint32_t data,
		     uint8_t raw[XY3_FRAME32_SIZE])
{
	if (frame_bits != 24 && frame_bits != 32)
		return -EINVAL;
	if (data > (!position ? XY3_COMMAND_MAX : frame_bits == 32 ? XY3_CODE32_MAX :
								     XY3_CODE24_MAX))
		return -ERANGE;

	if (frame_bits == 32) {
		put_unaligned_be32(xy3_frame32(data) | (position ? XY3_FRAME32_POSITION : 0), raw);
		return XY3_FRAME32_SIZE;
	}
	put_unaligned_be24(xy3_frame24(data) | (position ? XY3_FRAME24_POSITION : 0), raw);
	return XY3_FRAME24_SIZE;
}

int xy3_frame_decode(const uint8_t *raw, size_t size, bool *position, uint32_t *data)
{
	struct xy3_frame frame;

	if (!size)
		return -EMSGSIZE;
	xy3_decode_frame(raw, size, &frame);
	switch (frame.verdict) {
	case XY3_FRAME_TORN:
		return -EMSGSIZE;
	case XY3_FRAME_BAD_PARITY:
		return -EBADMSG;
	case XY3_FRAME_POSITION:
	case XY3_FRAME_COMMAND:
		break;
	}
	*position = frame.verdict == XY3_FRAME_POSITION;
	*data = frame.data;
	return frame.size;
}

size_t xy3_frame_size(uint8_t first)
{
	struct xy3_frame frame;

	xy3_decode_frame(&first, 1, &frame);
	return frame.size;
}

/* ---- line maps ---- */

/* The enum xy3_signal of a word of @length characters, or -EINVAL */
static int xy3_signal_of(const char *word, size_t length)
{
	if (length == 4 && !memcmp(word, "sync", 4))
		return XY3_SIGNAL_SYNC;
	if (length == 4 && !memcmp(word, "gate", 4))
		return XY3_SIGNAL_GATE;
	if (length != 1)
		return -EINVAL;
	if (*word == '-')
		return XY3_SIGNAL_NONE;
	for (unsigned int axis = 0; axis < XY3_AXES; axis++)
		if (*word == *xy3_axis_name(axis))
			return XY3_SIGNAL_X + axis;
	return -EINVAL;
}

static int xy3_parse_signals(const char *text, unsigned int lines, u8 signal[XY3_LINES_MAX])
{
	static const char between[] = " ,\t\n";
	unsigned int count = 0;
	int found;

	memset(signal, XY3_SIGNAL_NONE, XY3_LINES_MAX);
	for (text += strspn(text, between); *text; text += strspn(text, between)) {
		size_t length = strcspn(text, between);

		found = xy3_signal_of(text, length);
		if (found < 0 || count == lines)
			return -EINVAL;
		signal[count++] = found;
		text += length;
	}
	return 0;
}

int xy3_line_map_new(struct xy3_line_map **map, unsigned int lines, unsigned int frame_bits,
		     const char *signals)
{
	const u8 *usual = xy3_default_signals(lines, false);
	u8 signal[XY3_LINES_MAX];
	struct xy3_line_map made;
	int err;

	if (!usual)
		return -EINVAL;
	if (signals) {
		err = xy3_parse_signals(signals, lines, signal);
		if (err)
			return err;
	}
	err = xy3_line_map_init(&made, lines, frame_bits, signals ? signal : usual);
	if (err)
		return err;
	*map = malloc(sizeof(**map));
	if (!*map)
		return -ENOMEM;
	**map = made;
	return 0;
}

void xy3_line_map_free(struct xy3_line_map *map)
{
	free(map);
}

unsigned int xy3_line_map_axes(const struct xy3_line_map *map)
{
	return map->axes;
}

int xy3_line_map_axis(const struct xy3_line_map *map, unsigned int index)
{
	return index < map->axes ? map->axis[index] : -EINVAL;
}

bool xy3_line_map_has_gate(const struct xy3_line_map *map)
{
	return map->gate_line >= 0;
}

int xy3_check_scans(const struct xy3_line_map *map, const uint32_t *codes, size_t scans)
{
	for (size_t i = 0; i < scans * map->columns; i++)
		if (codes[i] > (i % map->columns < map->axes ? xy3_code_max(map) : 1))
			return -ERANGE;
	return 0;
}

size_t xy3_line_map_scan_size(const struct xy3_line_map *map)
{
	return map->scan_size;
}

int xy3_line_map_encode(const struct xy3_line_map *map, const uint32_t *codes, size_t scans,
			uint8_t *out)
{
	/* the codec silently drops excess bits */
	int err = xy3_check_scans(map, codes, scans);

	if (!err)
		xy3_encode_scans(map, codes, scans, out);
	return err;
}

int xy3_line_map_encode_command(const struct xy3_line_map *map, uint32_t command, uint8_t *out)
{
	if (command > XY3_COMMAND_MAX)
		return -ERANGE;
	xy3_encode_command_scan(map, command, out);
	return 0;
}
