// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: scans as a stream of bits over one to eight data lines
 */

#include <linux/bits.h>
#include <linux/bitops.h>
#include <linux/errno.h>
#include <linux/kernel.h>
#include <linux/string.h>
#include <linux/unaligned.h>

#include "xy3-frame.h"
#include "xy3-lines.h"

/*
 * A byte with its bits spread, so that there is room for those of the other lines between them:
 * bit n moves to bit n times the number of lines.
 */
#define SPREAD(b, n, lines)	((u64)((b) >> (n) & 1) << ((n) * (lines)))
#define SPREAD1(b, l)	(SPREAD(b, 0, l) | SPREAD(b, 1, l) | SPREAD(b, 2, l) | SPREAD(b, 3, l) | \
			 SPREAD(b, 4, l) | SPREAD(b, 5, l) | SPREAD(b, 6, l) | SPREAD(b, 7, l))
#define SPREAD4(b, l)	SPREAD1(b, l), SPREAD1((b) + 1, l), SPREAD1((b) + 2, l), \
			SPREAD1((b) + 3, l)
#define SPREAD16(b, l)	SPREAD4(b, l), SPREAD4((b) + 4, l), SPREAD4((b) + 8, l), \
			SPREAD4((b) + 12, l)
#define SPREAD64(b, l)	SPREAD16(b, l), SPREAD16((b) + 16, l), SPREAD16((b) + 32, l), \
			SPREAD16((b) + 48, l)
#define SPREAD256(l)	{ SPREAD64(0, l), SPREAD64(64, l), SPREAD64(128, l), SPREAD64(192, l) }

static const u16 xy3_spread2[] = SPREAD256(2);
static const u32 xy3_spread4[] = SPREAD256(4);
static const u64 xy3_spread8[] = SPREAD256(8);

/* the gap between two frames: a line is high in all clocks of a byte */
#define XY3_GAP4	0x11
#define XY3_GAP8	0x01

/*
 * Default signals of the lines. With SYNC as a line, at least four lines are required: on two, the
 * gap would end in the middle of a byte.
 */
static const struct xy3_default_row {
	u8 lines;
	bool sync_is_line;
	u8 signal[XY3_LINES_MAX];
} xy3_defaults[] = {
	{ 1, false, { XY3_SIGNAL_X } },
	{ 2, false, { XY3_SIGNAL_X, XY3_SIGNAL_Y } },
	{ 4, false, { XY3_SIGNAL_X, XY3_SIGNAL_Y, XY3_SIGNAL_Z, XY3_SIGNAL_U } },
	{ 8, false, { XY3_SIGNAL_X, XY3_SIGNAL_Y, XY3_SIGNAL_Z, XY3_SIGNAL_U, XY3_SIGNAL_W,
		      XY3_SIGNAL_NONE, XY3_SIGNAL_NONE, XY3_SIGNAL_NONE } },
	{ 4, true, { XY3_SIGNAL_SYNC, XY3_SIGNAL_X, XY3_SIGNAL_Y, XY3_SIGNAL_Z } },
	{ 8, true, { XY3_SIGNAL_SYNC, XY3_SIGNAL_X, XY3_SIGNAL_Y, XY3_SIGNAL_Z, XY3_SIGNAL_U,
		     XY3_SIGNAL_W, XY3_SIGNAL_NONE, XY3_SIGNAL_NONE } },
};

/**
 * xy3_default_signals() - default signals of the lines
 * @lines: number of lines
 * @sync_is_line: SYNC is one of them, not the chip select
 *
 * Return: enum xy3_signal for each line; NULL if there is no such arrangement.
 */
const u8 *xy3_default_signals(unsigned int lines, bool sync_is_line)
{
	for (size_t i = 0; i < ARRAY_SIZE(xy3_defaults); i++)
		if (xy3_defaults[i].lines == lines && xy3_defaults[i].sync_is_line == sync_is_line)
			return xy3_defaults[i].signal;
	return NULL;
}

/* The line of a signal; -1 for none, -EINVAL for more than one */
static int xy3_line_of(const u8 *signal, unsigned int lines, u8 wanted)
{
	int found = -1;

	for (unsigned int i = 0; i < lines; i++) {
		if (signal[i] != wanted)
			continue;
		if (found >= 0)
			return -EINVAL;
		found = i;
	}
	return found;
}

static int xy3_map_signals(struct xy3_line_map *map, unsigned int lines, unsigned int frame_bits,
			   const u8 *signal)
{
	int line;

	if (frame_bits != 24 && frame_bits != 32)
		return -EINVAL;
	for (unsigned int i = 0; i < lines; i++)
		if (signal[i] > XY3_SIGNAL_NONE)
			return -EINVAL;

	*map = (struct xy3_line_map) { .lines = lines, .frame_bits = frame_bits };
	memcpy(map->signal, signal, lines);
	for (unsigned int axis = 0; axis < XY3_AXES; axis++) {
		line = xy3_line_of(signal, lines, XY3_SIGNAL_X + axis);
		if (line < -1 || (line < 0 && axis == XY3_AXIS_X))
			return -EINVAL;
		if (line < 0)
			continue;
		map->axis[map->axes] = axis;
		map->axis_line[map->axes++] = line;
	}

	line = xy3_line_of(signal, lines, XY3_SIGNAL_SYNC);
	if (line < -1)
		return -EINVAL;
	map->sync_line = line;
	line = xy3_line_of(signal, lines, XY3_SIGNAL_GATE);
	if (line < -1)
		return -EINVAL;
	map->gate_line = line;
	map->columns = map->axes + (line >= 0);
	return 0;
}

/**
 * xy3_line_map_init() - initialise a line map
 * @map: the map
 * @lines: 1, 2, 4 or 8
 * @frame_bits: 24 or 32
 * @signal: enum xy3_signal for each line
 *
 * Return: 0; -EINVAL for any other number, or if a signal is on two lines, X is on none, or SYNC
 * is one of less than four lines.
 */
int xy3_line_map_init(struct xy3_line_map *map, unsigned int lines, unsigned int frame_bits,
		      const u8 *signal)
{
	unsigned int clocks = frame_bits;
	int err;

	if (!xy3_default_signals(lines, false))
		return -EINVAL;
	err = xy3_map_signals(map, lines, frame_bits, signal);
	if (err)
		return err;
	if (map->sync_line >= 0) {
		if (!xy3_default_signals(lines, true))
			return -EINVAL;
		clocks += XY3_GAP_CLOCKS;
	}
	map->scan_size = clocks * lines / 8;
	return 0;
}

/**
 * xy3_word_map_init() - initialise a line map of lanes
 * @map: the map
 * @lanes: 1 to XY3_LINES_MAX
 * @frame_bits: 24 or 32
 * @signal: enum xy3_signal for each lane
 *
 * Return: 0; -EINVAL for any other number, or if a signal is on two lanes, X is on none, or SYNC is
 * on one: it is the chip select.
 */
int xy3_word_map_init(struct xy3_line_map *map, unsigned int lanes, unsigned int frame_bits,
		      const u8 *signal)
{
	int err;

	if (!lanes || lanes > XY3_LINES_MAX)
		return -EINVAL;
	err = xy3_map_signals(map, lanes, frame_bits, signal);
	if (err)
		return err;
	if (map->sync_line >= 0)
		return -EINVAL;
	map->words = true;
	map->scan_size = lanes * sizeof(u32);
	return 0;
}

/**
 * xy3_code_max() - the highest position code
 * @map: the line map
 *
 * Return: 2^20 - 1 or 2^26 - 1.
 */
u32 xy3_code_max(const struct xy3_line_map *map)
{
	return map->frame_bits == 32 ? XY3_CODE32_MAX : XY3_CODE24_MAX;
}

/* ---- words: for each lane a number, in the byte order of the processor ---- */

static u32 xy3_position_word(const struct xy3_line_map *map, u32 code)
{
	return map->frame_bits == 32 ? xy3_frame32(code) | XY3_FRAME32_POSITION :
				       xy3_frame24(code) | XY3_FRAME24_POSITION;
}

static u32 xy3_command_word(const struct xy3_line_map *map, u32 command)
{
	command &= XY3_COMMAND_MAX;
	return map->frame_bits == 32 ? xy3_frame32(command) : xy3_frame24(command);
}

static void xy3_put_words(const struct xy3_line_map *map, const u32 *codes, size_t scans, u32 *out)
{
	for (; scans; scans--, out += map->lines) {
		memset(out, 0, map->scan_size);
		for (unsigned int i = 0; i < map->axes; i++)
			out[map->axis_line[i]] = xy3_position_word(map, *codes++);
		if (map->gate_line >= 0 && *codes++ == 1)
			out[map->gate_line] = GENMASK(map->frame_bits - 1, 0);
	}
}

static void xy3_put_command_words(const struct xy3_line_map *map, u32 command, u32 *out)
{
	memset(out, 0, map->scan_size);
	for (unsigned int i = 0; i < map->axes; i++)
		out[map->axis_line[i]] = xy3_command_word(map, i ? 0 : command);
}

/* ---- bits of several lines side by side ---- */

/* A position frame with its first bit at bit 31; excess bits of the code are ignored */
static __always_inline u32 xy3_position(u32 code, unsigned int frame_bits)
{
	if (frame_bits == 32)
		return xy3_frame32(code) | XY3_FRAME32_POSITION;
	return (xy3_frame24(code) | XY3_FRAME24_POSITION) << 8;
}

/* All lines in eight clocks, four times: the bytes of a scan without the gap */
struct xy3_clocks {
	u64 first, second, third, fourth;
};

/* The lowest eight bits, spread by the number of lines */
static __always_inline u64 xy3_spread(unsigned int lines, u32 bits)
{
	bits &= 0xff;
	if (lines == 2)
		return xy3_spread2[bits];
	if (lines == 4)
		return xy3_spread4[bits];
	return xy3_spread8[bits];
}

/* Unrolled by hand, as compilers do not unroll such a loop in the kernel */
static __always_inline void xy3_add_frame(struct xy3_clocks *clocks, unsigned int lines,
					  unsigned int frame_bits, unsigned int line, u32 frame)
{
	clocks->first |= xy3_spread(lines, frame >> 24) << line;
	clocks->second |= xy3_spread(lines, frame >> 16) << line;
	clocks->third |= xy3_spread(lines, frame >> 8) << line;
	if (frame_bits == 32)
		clocks->fourth |= xy3_spread(lines, frame) << line;
}

static __always_inline u8 *xy3_put(unsigned int lines, u64 bits, u8 *out)
{
	if (lines == 2)
		put_unaligned_be16(bits, out);
	else if (lines == 4)
		put_unaligned_be32(bits, out);
	else
		put_unaligned_be64(bits, out);
	return out + lines;
}

/* Two clocks with some lines high, and the others low */
static __always_inline u8 *xy3_put_gap(unsigned int lines, u8 high, u8 *out)
{
	if (lines == 4) {
		*out++ = XY3_GAP4 * high;
	} else {
		*out++ = XY3_GAP8 * high;
		*out++ = XY3_GAP8 * high;
	}
	return out;
}

/*
 * The frames of all axes, and if SYNC is a line the gap after them, in which the lines of @held
 * stay high. Return the end.
 */
static __always_inline u8 *xy3_put_scan(const struct xy3_clocks *clocks, unsigned int lines,
					unsigned int frame_bits, int sync_line, u8 held, u8 *out)
{
	out = xy3_put(lines, clocks->first, out);
	out = xy3_put(lines, clocks->second, out);
	out = xy3_put(lines, clocks->third, out);
	if (frame_bits == 32)
		out = xy3_put(lines, clocks->fourth, out);
	if (sync_line < 0)
		return out;
	return xy3_put_gap(lines, held | BIT(sync_line), out);
}

/* One line, that of X */
static __always_inline u8 *xy3_put_frame(unsigned int frame_bits, u32 frame, u8 *out)
{
	if (frame_bits == 32)
		put_unaligned_be32(frame, out);
	else
		put_unaligned_be24(frame >> 8, out);
	return out + frame_bits / 8;
}

static __always_inline void xy3_put_positions(const struct xy3_line_map *map, unsigned int lines,
					      unsigned int frame_bits, const u32 *codes,
					      size_t scans, u8 *out)
{
	int sync_line = map->sync_line, gate_line = map->gate_line;
	unsigned int axes = map->axes;

	for (; scans; scans--) {
		struct xy3_clocks clocks = { };
		u8 held = 0;

		if (lines == 1) {
			out = xy3_put_frame(frame_bits, xy3_position(*codes++, frame_bits), out);
			continue;
		}
		for (unsigned int i = 0; i < axes; i++)
			xy3_add_frame(&clocks, lines, frame_bits, map->axis_line[i],
				      xy3_position(*codes++, frame_bits));
		if (gate_line >= 0 && *codes++ == 1) {
			xy3_add_frame(&clocks, lines, frame_bits, gate_line, ~0U);
			held = BIT(gate_line);
		}
		out = xy3_put_scan(&clocks, lines, frame_bits, sync_line, held, out);
	}
}

/**
 * xy3_encode_scans() - encode a block of scans
 * @map: the line map
 * @codes: @map->columns numbers for each scan: positions, of which bits over xy3_code_max() are
 *	   ignored, and after them the gate, which is high only with 1
 * @scans: number of scans
 * @out: @scans times @map->scan_size bytes, aligned as a u32 for words
 */
void xy3_encode_scans(const struct xy3_line_map *map, const u32 *codes, size_t scans, u8 *out)
{
	if (map->words) {
		xy3_put_words(map, codes, scans, (u32 *)out);
		return;
	}
	/* each with constants, for the compiler */
	switch (map->lines << 8 | map->frame_bits) {
	case 1 << 8 | 24:
		return xy3_put_positions(map, 1, 24, codes, scans, out);
	case 1 << 8 | 32:
		return xy3_put_positions(map, 1, 32, codes, scans, out);
	case 2 << 8 | 24:
		return xy3_put_positions(map, 2, 24, codes, scans, out);
	case 2 << 8 | 32:
		return xy3_put_positions(map, 2, 32, codes, scans, out);
	case 4 << 8 | 24:
		return xy3_put_positions(map, 4, 24, codes, scans, out);
	case 4 << 8 | 32:
		return xy3_put_positions(map, 4, 32, codes, scans, out);
	case 8 << 8 | 24:
		return xy3_put_positions(map, 8, 24, codes, scans, out);
	case 8 << 8 | 32:
		return xy3_put_positions(map, 8, 32, codes, scans, out);
	}
}

/**
 * xy3_gap_size() - bytes of the gap between scans
 * @map: the line map
 *
 * Return: size in bytes, 0 if SYNC is the chip select.
 */
size_t xy3_gap_size(const struct xy3_line_map *map)
{
	return map->sync_line < 0 ? 0 : XY3_GAP_CLOCKS * map->lines / 8;
}

/**
 * xy3_encode_gap() - encode the gap before the first scan
 * @map: the line map
 * @out: xy3_gap_size() bytes
 */
void xy3_encode_gap(const struct xy3_line_map *map, u8 *out)
{
	if (map->sync_line >= 0)
		xy3_put_gap(map->lines, BIT(map->sync_line), out);
}

/* Clear the bit of the gate in all clocks of some bytes */
static void xy3_clear_gate(const struct xy3_line_map *map, u8 *bytes, size_t size)
{
	for (size_t i = 0; i < size; i++)
		for (unsigned int bit = map->gate_line; bit < 8; bit += map->lines)
			bytes[i] &= ~BIT(bit);
}

/**
 * xy3_lower_gate() - set the gate of a scan low
 * @map: the line map, with a gate or without
 * @scan: bytes of a scan from xy3_encode_scans(); its positions are kept
 */
void xy3_lower_gate(const struct xy3_line_map *map, u8 *scan)
{
	if (map->gate_line < 0)
		return;
	if (map->words)
		((u32 *)scan)[map->gate_line] = 0;
	else
		xy3_clear_gate(map, scan, map->scan_size);
}

/**
 * xy3_lower_gate_behind() - set the gate low in the gap after a scan
 * @map: the line map, with a gate or without
 * @scan: bytes of the scan
 *
 * For the last scan before a pause, in which many controllers keep the lines at their last bits.
 * If SYNC is the chip select there is no gap, and the gate is not changed.
 */
void xy3_lower_gate_behind(const struct xy3_line_map *map, u8 *scan)
{
	size_t frames = map->frame_bits * map->lines / 8;

	if (map->gate_line >= 0 && !map->words)
		xy3_clear_gate(map, scan + frames, map->scan_size - frames);
}

/**
 * xy3_encode_command_scan() - make the bytes of a scan that carries a command
 * @map: the line map
 * @command: 20 bits, for axis X's line; those of other axes carry an empty command of the same
 *	     length, which is low with 24 bits
 * @out: @map->scan_size bytes, aligned as a u32 for words
 */
void xy3_encode_command_scan(const struct xy3_line_map *map, u32 command, u8 *out)
{
	unsigned int unused = 32 - map->frame_bits;
	struct xy3_clocks clocks = { };
	u32 frame;

	if (map->words) {
		xy3_put_command_words(map, command, (u32 *)out);
		return;
	}
	frame = xy3_command_word(map, command) << unused;
	if (map->lines == 1) {
		xy3_put_frame(map->frame_bits, frame, out);
		return;
	}
	xy3_add_frame(&clocks, map->lines, map->frame_bits, map->axis_line[0], frame);
	frame = xy3_command_word(map, 0) << unused;
	for (unsigned int i = 1; i < map->axes; i++)
		xy3_add_frame(&clocks, map->lines, map->frame_bits, map->axis_line[i], frame);
	xy3_put_scan(&clocks, map->lines, map->frame_bits, map->sync_line, 0, out);
}
