// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: scans over one to eight data lines, against a wire that is computed bit by bit
 *
 * Signals and bits are from the description of the format, not from the header.
 */

#include <kunit/test.h>
#include <linux/module.h>

/* not linked but included: the codec exports no symbols */
#include "../drivers/xy3/xy3-lines.c"

enum { X, Y, Z, U, W, SYNC, GATE, NONE };

#define NO	NONE	/* short, for rows */

/* ---- the wire ---- */

#define GATE_DATA	5	/* index of the gate, after the axes */

struct wire {
	unsigned int lines;
	unsigned int frame_bits;
	u8 signal[8];
	bool command;	/* it is a command frame */
};

static bool has(const struct wire *wire, u8 signal)
{
	for (unsigned int line = 0; line < wire->lines; line++)
		if (wire->signal[line] == signal)
			return true;
	return false;
}

static unsigned int clocks_of(const struct wire *wire)
{
	return wire->frame_bits + (has(wire, SYNC) ? 2 : 0);
}

/* The n-th bit of a frame, of which 0 is the first */
static bool frame_bit(const struct wire *wire, u32 data, unsigned int n)
{
	unsigned int data_bits = wire->frame_bits == 32 ? 26 : 20;
	unsigned int ones = 0;

	if (n == 0)
		return wire->frame_bits == 32;
	if (n == 1)
		return !wire->command;
	if (n < 2 + data_bits)
		return data >> (data_bits + 1 - n) & 1;
	for (unsigned int i = 0; i < data_bits; i++)
		ones += data >> i & 1;
	return ones >> (wire->frame_bits - 1 - n) & 1;
}

/* Level of a line in one clock of a scan with @data, by axis, and after them the gate */
static bool level(const struct wire *wire, const u32 *data, unsigned int line, unsigned int clock)
{
	u8 signal = wire->signal[line];

	if (signal == SYNC)
		return clock >= wire->frame_bits;
	if (signal == GATE)
		return !wire->command && data[GATE_DATA] == 1;
	if (signal == NONE || clock >= wire->frame_bits)
		return false;
	/* the other axes get an empty command: only its first bit, the length, is set */
	if (wire->command && signal != X)
		return wire->frame_bits == 32 && !clock;
	return frame_bit(wire, data[signal], clock);
}

/* A scan as bytes. Return their number. */
static size_t slice(const struct wire *wire, const u32 *data, u8 *out)
{
	size_t bits = 0;

	for (unsigned int clock = 0; clock < clocks_of(wire); clock++)
		for (int line = wire->lines - 1; line >= 0; line--, bits++) {
			if (bits % 8 == 0)
				out[bits / 8] = 0;
			if (level(wire, data, line, clock))
				out[bits / 8] |= 0x80 >> bits % 8;
		}
	return bits / 8;
}

/* The level of a line, decoded from the bytes of scans */
static bool line_at(const struct wire *wire, const u8 *bytes, unsigned int line, size_t clock)
{
	size_t bit = clock * wire->lines + wire->lines - 1 - line;

	return bytes[bit / 8] >> (7 - bit % 8) & 1;
}

/* ---- the codec ---- */

/* With the signals in memory that ends after them */
static int map_init(struct kunit *test, struct xy3_line_map *map, const struct wire *wire)
{
	unsigned int count = min(wire->lines, 8U);
	u8 *signal = kunit_kmalloc(test, max(count, 1U), GFP_KERNEL);
	int err;

	KUNIT_ASSERT_NOT_NULL(test, signal);
	memcpy(signal, wire->signal, count);
	err = xy3_line_map_init(map, wire->lines, wire->frame_bits, signal);
	kunit_kfree(test, signal);
	return err;
}

static u32 next_random(u32 *state)
{
	*state ^= *state << 13;
	*state ^= *state >> 17;
	*state ^= *state << 5;
	return *state;
}

static void check_fields(struct kunit *test, const struct xy3_line_map *map,
			 const struct wire *wire)
{
	unsigned int axes = 0;

	KUNIT_EXPECT_EQ(test, map->lines, wire->lines);
	KUNIT_EXPECT_EQ(test, map->frame_bits, wire->frame_bits);
	KUNIT_EXPECT_MEMEQ(test, map->signal, wire->signal, wire->lines);
	KUNIT_EXPECT_EQ(test, map->scan_size, clocks_of(wire) * wire->lines / 8);
	KUNIT_EXPECT_EQ(test, map->sync_line >= 0, has(wire, SYNC));
	if (map->sync_line >= 0)
		KUNIT_EXPECT_EQ(test, wire->signal[map->sync_line], SYNC);
	for (unsigned int axis = X; axis <= W; axis++) {
		if (!has(wire, axis))
			continue;
		KUNIT_EXPECT_EQ(test, map->axis[axes], axis);
		KUNIT_EXPECT_EQ(test, wire->signal[map->axis_line[axes]], axis);
		axes++;
	}
	KUNIT_EXPECT_EQ(test, map->axes, axes);
	KUNIT_EXPECT_EQ(test, map->gate_line >= 0, has(wire, GATE));
	if (map->gate_line >= 0)
		KUNIT_EXPECT_EQ(test, wire->signal[map->gate_line], GATE);
	KUNIT_EXPECT_EQ(test, map->columns, axes + has(wire, GATE));
}

#define SCANS	4

/* Scans of the codec, in memory that ends after them, are equal to those of the wire */
static void check_scans(struct kunit *test, const struct xy3_line_map *map,
			const struct wire *wire, u32 *random)
{
	u8 *out = kunit_kmalloc(test, SCANS * map->scan_size, GFP_KERNEL);
	u32 *codes = kunit_kmalloc(test, SCANS * map->columns * sizeof(*codes), GFP_KERNEL);
	u8 want[34];

	KUNIT_ASSERT_NOT_NULL(test, out);
	KUNIT_ASSERT_NOT_NULL(test, codes);
	memset(out, 0x5a, SCANS * map->scan_size);
	/* all 32 bits: those above the code must be dropped; the gate is high in some scans */
	for (unsigned int i = 0; i < SCANS * map->columns; i++)
		codes[i] = next_random(random);
	for (unsigned int i = 0; has(wire, GATE) && i < SCANS; i++)
		codes[i * map->columns + map->axes] &= 3;
	xy3_encode_scans(map, codes, SCANS, out);
	for (unsigned int scan = 0; scan < SCANS; scan++) {
		const u32 *column = codes + scan * map->columns;
		u32 data[6] = { 0 };

		for (unsigned int axis = X; axis <= W; axis++)
			if (has(wire, axis))
				data[axis] = *column++;
		if (has(wire, GATE))
			data[GATE_DATA] = *column;
		KUNIT_ASSERT_EQ(test, slice(wire, data, want), map->scan_size);
		KUNIT_EXPECT_MEMEQ_MSG(test, out + scan * map->scan_size, want, map->scan_size,
				       "scan %u, %u lines", scan, wire->lines);
	}
	kunit_kfree(test, codes);
	kunit_kfree(test, out);
}

static void check_command(struct kunit *test, const struct xy3_line_map *map, struct wire wire,
			  u32 command)
{
	/* of X only */
	u32 data[6] = { command & 0xfffff, ~0U, ~0U, ~0U, ~0U, 1 };
	u8 *out = kunit_kmalloc(test, map->scan_size, GFP_KERNEL);
	u8 want[34];

	KUNIT_ASSERT_NOT_NULL(test, out);
	memset(out, 0x5a, map->scan_size);
	wire.command = true;
	xy3_encode_command_scan(map, command, out);
	KUNIT_ASSERT_EQ(test, slice(&wire, data, want), map->scan_size);
	KUNIT_EXPECT_MEMEQ_MSG(test, out, want, map->scan_size, "command %#x, %u lines", command,
			       wire.lines);
	kunit_kfree(test, out);
}

static void check_wire(struct kunit *test, const struct wire *wire, u32 *random)
{
	struct xy3_line_map map;

	KUNIT_ASSERT_EQ(test, map_init(test, &map, wire), 0);
	check_fields(test, &map, wire);
	check_scans(test, &map, wire, random);
	check_command(test, &map, *wire, next_random(random));
}

/* ---- arrangements ---- */

struct default_row {
	const char *name;
	bool sync_is_line;
	struct wire wire;
	size_t scan_size;
};

static const struct default_row default_rows[] = {
	{ "1 line, 24 bits", false, { 1, 24, { X } }, 3 },
	{ "1 line, 32 bits", false, { 1, 32, { X } }, 4 },
	{ "2 lines, 24 bits", false, { 2, 24, { X, Y } }, 6 },
	{ "2 lines, 32 bits", false, { 2, 32, { X, Y } }, 8 },
	{ "4 lines, 24 bits", false, { 4, 24, { X, Y, Z, U } }, 12 },
	{ "4 lines, 32 bits", false, { 4, 32, { X, Y, Z, U } }, 16 },
	{ "8 lines, 24 bits", false, { 8, 24, { X, Y, Z, U, W, NO, NO, NO } }, 24 },
	{ "8 lines, 32 bits", false, { 8, 32, { X, Y, Z, U, W, NO, NO, NO } }, 32 },
	{ "4 lines with SYNC, 24 bits", true, { 4, 24, { SYNC, X, Y, Z } }, 13 },
	{ "4 lines with SYNC, 32 bits", true, { 4, 32, { SYNC, X, Y, Z } }, 17 },
	{ "8 lines with SYNC, 24 bits", true, { 8, 24, { SYNC, X, Y, Z, U, W, NO, NO } }, 26 },
	{ "8 lines with SYNC, 32 bits", true, { 8, 32, { SYNC, X, Y, Z, U, W, NO, NO } }, 34 },
};

KUNIT_ARRAY_PARAM_DESC(default, default_rows, name);

static void default_test(struct kunit *test)
{
	const struct default_row *row = test->param_value;
	const u8 *signal = xy3_default_signals(row->wire.lines, row->sync_is_line);
	struct xy3_line_map map;
	u32 random = 0x4711;

	KUNIT_ASSERT_NOT_NULL(test, signal);
	KUNIT_EXPECT_MEMEQ(test, signal, row->wire.signal, row->wire.lines);
	KUNIT_ASSERT_EQ(test, map_init(test, &map, &row->wire), 0);
	KUNIT_EXPECT_EQ(test, map.scan_size, row->scan_size);
	KUNIT_EXPECT_LE(test, row->scan_size, XY3_SCAN_SIZE_MAX);
	KUNIT_EXPECT_EQ(test, xy3_code_max(&map), row->wire.frame_bits == 32 ? 0x3ffffff : 0xfffff);
	for (unsigned int i = 0; i < 50; i++)
		check_wire(test, &row->wire, &random);
}

static void no_default_test(struct kunit *test)
{
	static const unsigned int none[] = { 0, 3, 5, 6, 7, 9, 16, 256 + 4, UINT_MAX };

	for (unsigned int i = 0; i < ARRAY_SIZE(none); i++) {
		KUNIT_EXPECT_NULL(test, xy3_default_signals(none[i], false));
		KUNIT_EXPECT_NULL(test, xy3_default_signals(none[i], true));
	}
	/* the gap would end in the middle of a byte */
	KUNIT_EXPECT_NULL(test, xy3_default_signals(1, true));
	KUNIT_EXPECT_NULL(test, xy3_default_signals(2, true));
}

static bool legal(const struct wire *wire)
{
	unsigned int count[9] = { 0 };

	for (unsigned int line = 0; line < wire->lines; line++)
		count[wire->signal[line]]++;
	for (unsigned int signal = X; signal <= GATE; signal++)
		if (count[signal] > 1)
			return false;
	return count[X] && !count[NONE + 1] && (!count[SYNC] || wire->lines >= 4);
}

/* Each signal, and an invalid number, on each of up to four lines */
static void every_map_test(struct kunit *test)
{
	unsigned int good = 0;
	u32 random = 0x0815;

	for (unsigned int lines = 1, maps = 9; lines <= 4; lines *= 2, maps *= maps)
		for (unsigned int which = 0; which < maps; which++) {
			struct wire wire = { lines, random & 1 ? 32 : 24 };
			struct xy3_line_map map;
			unsigned int rest = which;

			for (unsigned int line = 0; line < lines; line++, rest /= 9)
				wire.signal[line] = rest % 9;
			if (!legal(&wire)) {
				KUNIT_EXPECT_EQ_MSG(test, map_init(test, &map, &wire), -EINVAL,
						    "%u lines, %u", lines, which);
				continue;
			}
			good++;
			check_wire(test, &wire, &random);
		}
	/*
	 * X alone, and k of three other lines with k of n other signals, in every order: 1;
	 * 2 * (1 + 5); 4 * (1 + 3 * 6 + 3 * 30 + 120)
	 */
	KUNIT_EXPECT_EQ(test, good, 1 + 12 + 916);
}

/* Some of the signals, shuffled over eight lines */
static void eight_lines_test(struct kunit *test)
{
	unsigned int with_sync = 0;
	u32 random = 0xbeef;

	for (unsigned int i = 0; i < 600; i++) {
		struct wire wire = { 8, i & 1 ? 32 : 24, { X, NO, NO, NO, NO, NO, NO, NO } };

		for (unsigned int signal = Y; signal <= GATE; signal++)
			if (next_random(&random) >> 7 & 1)
				wire.signal[signal] = signal;
		for (unsigned int line = 7; line > 0; line--) {
			unsigned int other = next_random(&random) % (line + 1);

			swap(wire.signal[line], wire.signal[other]);
		}
		with_sync += has(&wire, SYNC);
		check_wire(test, &wire, &random);
	}
	KUNIT_EXPECT_GT(test, with_sync, 200U);
	KUNIT_EXPECT_LT(test, with_sync, 400U);
}

struct invalid_row {
	const char *name;
	int error;	/* 0: the control, without the fault */
	struct wire wire;
};

static const struct invalid_row invalid_rows[] = {
	{ "X alone", 0, { 1, 24, { X } } },
	{ "no line", -EINVAL, { 0, 24, { X } } },
	{ "3 lines", -EINVAL, { 3, 24, { X, Y, Z } } },
	{ "5 lines", -EINVAL, { 5, 24, { X, Y, Z, U, W } } },
	{ "6 lines", -EINVAL, { 6, 24, { SYNC, X, Y, Z, U, W } } },
	{ "16 lines", -EINVAL, { 16, 24, { X, Y, NO, NO, NO, NO, NO, NO } } },
	{ "260 lines, 4 in 8 bits", -EINVAL, { 256 + 4, 24, { X, Y, Z, U } } },
	{ "no bits", -EINVAL, { 1, 0, { X } } },
	{ "16 bits", -EINVAL, { 1, 16, { X } } },
	{ "40 bits", -EINVAL, { 1, 40, { X } } },
	{ "280 bits, 24 in 8 bits", -EINVAL, { 1, 256 + 24, { X } } },
	{ "Y alone", -EINVAL, { 1, 24, { Y } } },
	{ "nothing on the only line", -EINVAL, { 1, 24, { NO } } },
	{ "X on the second line", 0, { 2, 24, { NO, X } } },
	{ "X missing on 2 lines", -EINVAL, { 2, 24, { Y, Z } } },
	{ "X missing on 8 lines", -EINVAL, { 8, 32, { SYNC, Y, Z, U, W, NO, NO, NO } } },
	{ "X twice", -EINVAL, { 2, 24, { X, X } } },
	{ "Y twice", -EINVAL, { 4, 24, { X, Y, Z, Y } } },
	{ "Z twice", -EINVAL, { 4, 32, { Z, X, Y, Z } } },
	{ "W twice", -EINVAL, { 8, 24, { X, W, NO, NO, NO, NO, NO, W } } },
	{ "SYNC twice", -EINVAL, { 8, 24, { SYNC, X, NO, NO, NO, NO, NO, SYNC } } },
	{ "the gate twice", -EINVAL, { 8, 24, { GATE, X, NO, NO, NO, NO, NO, GATE } } },
	{ "the gate on 2 lines", 0, { 2, 24, { X, GATE } } },
	{ "the gate alone", -EINVAL, { 1, 24, { GATE } } },
	{ "nothing three times", 0, { 4, 24, { NO, NO, NO, X } } },
	{ "SYNC on 2 lines", -EINVAL, { 2, 24, { SYNC, X } } },
	{ "SYNC on the only line", -EINVAL, { 1, 24, { SYNC } } },
	{ "SYNC on 4 lines", 0, { 4, 24, { X, NO, NO, SYNC } } },
	{ "a signal behind the last", -EINVAL, { 2, 24, { X, NONE + 1 } } },
	{ "signal 255", -EINVAL, { 2, 24, { X, 255 } } },
	{ "an unknown signal behind the lines", 0, { 1, 24, { X, 255 } } },
	{ "X twice, once behind the lines", 0, { 1, 24, { X, X } } },
};

KUNIT_ARRAY_PARAM_DESC(invalid, invalid_rows, name);

static void invalid_test(struct kunit *test)
{
	const struct invalid_row *row = test->param_value;
	struct xy3_line_map map;

	KUNIT_EXPECT_EQ(test, map_init(test, &map, &row->wire), row->error);
}

/* ---- bytes computed by hand ---- */

struct bytes_row {
	const char *name;
	struct wire wire;	/* the first code is the command */
	u32 codes[6];
	size_t size;
	u8 bytes[34];
};

static const struct bytes_row bytes_rows[] = {
	{ "0", { 1, 24, { X } }, { 0 }, 3, { 0x40, 0x00, 0x00 } },
	{ "1", { 1, 24, { X } }, { 1 }, 3, { 0x40, 0x00, 0x05 } },
	{ "top bit", { 1, 24, { X } }, { 0x80000 }, 3, { 0x60, 0x00, 0x01 } },
	{ "20 ones are parity 0", { 1, 24, { X } }, { 0xfffff }, 3, { 0x7f, 0xff, 0xfc } },
	{ "19 ones are parity 3", { 1, 24, { X } }, { 0xffffe }, 3, { 0x7f, 0xff, 0xfb } },
	{ "bit 20 is none of 24", { 1, 24, { X } }, { 0x100001 }, 3, { 0x40, 0x00, 0x05 } },
	{ "0 in 32", { 1, 32, { X } }, { 0 }, 4, { 0xc0, 0x00, 0x00, 0x00 } },
	{ "top bit in 32", { 1, 32, { X } }, { 0x2000000 }, 4, { 0xe0, 0x00, 0x00, 0x01 } },
	{ "26 ones are parity 10", { 1, 32, { X } }, { 0x3ffffff }, 4, { 0xff, 0xff, 0xff, 0xfa } },
	{ "bits over the 26", { 1, 32, { X } }, { 0xffffffff }, 4, { 0xff, 0xff, 0xff, 0xfa } },
	{ "two zeros", { 2, 24, { X, Y } }, { 0, 0 }, 6, { 0x30 } },
	{ "X 1 on line 0 of 2", { 2, 24, { X, Y } }, { 1, 0 }, 6, { 0x30, 0, 0, 0, 0, 0x11 } },
	{ "Y 1 on line 1 of 2", { 2, 24, { X, Y } }, { 0, 1 }, 6, { 0x30, 0, 0, 0, 0, 0x22 } },
	{ "X on line 1, Y on line 0", { 2, 24, { Y, X } }, { 1, 0 }, 6,
	  { 0x30, 0, 0, 0, 0, 0x22 } },
	{ "X on line 1 alone", { 2, 32, { NO, X } }, { 0 }, 8, { 0xa0 } },
	{ "four zeros", { 4, 24, { X, Y, Z, U } }, { 0, 0, 0, 0 }, 12, { 0x0f } },
	{ "X 1 on line 0 of 4", { 4, 24, { X, Y, Z, U } }, { 1, 0, 0, 0 }, 12,
	  { 0x0f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x01, 0x01 } },
	{ "U 1 on line 3 of 4", { 4, 24, { X, Y, Z, U } }, { 0, 0, 0, 1 }, 12,
	  { 0x0f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x08, 0x08 } },
	{ "SYNC and three zeros", { 4, 24, { SYNC, X, Y, Z } }, { 0, 0, 0 }, 13,
	  { 0x0e, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x11 } },
	{ "SYNC and three zeros, 32 bits", { 4, 32, { SYNC, X, Y, Z } }, { 0, 0, 0 }, 17,
	  { 0xee, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x11 } },
	{ "SYNC and all ones on X", { 4, 24, { SYNC, X, Y, Z } }, { 0xfffff, 0, 0 }, 13,
	  { 0x0e, 0x22, 0x22, 0x22, 0x22, 0x22, 0x22, 0x22, 0x22, 0x22, 0x22, 0, 0x11 } },
	{ "SYNC on the highest line of 4", { 4, 24, { X, NO, NO, SYNC } }, { 0 }, 13,
	  { 0x01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x88 } },
	{ "five zeros", { 8, 32, { X, Y, Z, U, W, NO, NO, NO } }, { 0, 0, 0, 0, 0 }, 32,
	  { 0x1f, 0x1f } },
	{ "SYNC and five zeros", { 8, 24, { SYNC, X, Y, Z, U, W, NO, NO } }, { 0, 0, 0, 0, 0 }, 26,
	  { 0, 0x3e, [24] = 0x01, 0x01 } },
	{ "SYNC on the highest line of 8", { 8, 32, { X, NO, NO, NO, NO, NO, NO, SYNC } }, { 2 },
	  34, { 0x01, 0x01, [26] = 0x01, [31] = 0x01, [32] = 0x80, 0x80 } },
	{ "the gate on 2 lines", { 2, 24, { X, GATE } }, { 0, 1 }, 6,
	  { 0xba, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa } },
	{ "SYNC, two zeros, the gate", { 4, 24, { SYNC, X, Y, GATE } }, { 0, 0, 1 }, 13,
	  { 0x8e, 0x88, 0x88, 0x88, 0x88, 0x88, 0x88, 0x88, 0x88, 0x88, 0x88, 0x88, 0x99 } },
	{ "the gate is low with 0", { 4, 24, { SYNC, X, Y, GATE } }, { 0, 0, 0 }, 13,
	  { 0x06, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x11 } },
	{ "and with what is neither", { 4, 24, { SYNC, X, Y, GATE } }, { 0, 0, 3 }, 13,
	  { 0x06, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x11 } },
	{ "SYNC, five zeros, the gate", { 8, 24, { SYNC, X, Y, Z, U, W, GATE, NO } },
	  { 0, 0, 0, 0, 0, 1 }, 26,
	  { 0x40, 0x7e, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40,
	    0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x40, 0x41, 0x41 } },
	{ "calibrate X and W", { 1, 24, { X }, true }, { 0xc0011 }, 3, { 0x30, 0x00, 0x44 } },
	{ "calibrate, 32 bits", { 1, 32, { X }, true }, { 0xc0000 }, 4,
	  { 0x80, 0xc0, 0x00, 0x02 } },
	{ "bits over a command's 20", { 1, 32, { X }, true }, { 0xfff00001 }, 4,
	  { 0x80, 0x00, 0x00, 0x11 } },
	{ "calibrate, 4 lines with SYNC", { 4, 24, { SYNC, X, Y, Z }, true }, { 0xc0000 }, 13,
	  { 0, 0x22, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x20, 0x11 } },
	{ "calibrate, with a gate", { 4, 24, { SYNC, X, Y, GATE }, true }, { 0xc0000, 0, 1 }, 13,
	  { 0, 0x22, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x20, 0x11 } },
	{ "calibrate, 8 lines", { 8, 24, { X, Y, Z, U, W, NO, NO, NO }, true }, { 0xc0000 }, 24,
	  { 0, 0, 0x01, 0x01, [22] = 0x01, 0 } },
};

KUNIT_ARRAY_PARAM_DESC(bytes, bytes_rows, name);

static void bytes_test(struct kunit *test)
{
	const struct bytes_row *row = test->param_value;
	struct xy3_line_map map;
	u8 out[34];

	KUNIT_ASSERT_EQ(test, map_init(test, &map, &row->wire), 0);
	KUNIT_ASSERT_EQ(test, map.scan_size, row->size);
	memset(out, 0x5a, sizeof(out));
	if (row->wire.command)
		xy3_encode_command_scan(&map, row->codes[0], out);
	else
		xy3_encode_scans(&map, row->codes, 1, out);
	KUNIT_EXPECT_MEMEQ(test, out, row->bytes, row->size);
}

/* ---- levels of the lines at all times ---- */

/* SYNC, on each line: low for a frame, high for two clocks, with all other lines low */
static void gap_test(struct kunit *test)
{
	u32 codes[3];

	memset(codes, 0xff, sizeof(codes));
	for (unsigned int lines = 4; lines <= 8; lines *= 2)
		for (unsigned int which = 0; which < lines * lines * 2; which++) {
			struct wire wire = { lines, which & 1 ? 32 : 24 };
			unsigned int sync = which / 2 / lines, x = which / 2 % lines, period;
			struct xy3_line_map map;
			u8 out[3 * 34];

			if (sync == x)
				continue;
			memset(wire.signal, NONE, lines);
			wire.signal[sync] = SYNC;
			wire.signal[x] = X;
			KUNIT_ASSERT_EQ(test, map_init(test, &map, &wire), 0);
			xy3_encode_scans(&map, codes, 3, out);
			period = wire.frame_bits + 2;
			KUNIT_ASSERT_EQ(test, 3 * map.scan_size * 8, 3 * period * lines);
			for (unsigned int clock = 0; clock < 3 * period; clock++) {
				bool gap = clock % period >= wire.frame_bits;

				KUNIT_EXPECT_EQ(test, line_at(&wire, out, sync, clock), gap);
				for (unsigned int line = 0; gap && line < lines; line++)
					if (line != sync)
						KUNIT_EXPECT_FALSE(test, line_at(&wire, out, line,
										 clock));
			}
		}
}

/* Before the first scan, in memory that ends after it */
static void front_gap_test(struct kunit *test)
{
	const struct default_row *row = test->param_value;
	size_t size = row->sync_is_line ? 2 * row->wire.lines / 8 : 0;
	u8 *out = kunit_kzalloc(test, max_t(size_t, size, 1), GFP_KERNEL);
	struct xy3_line_map map;

	KUNIT_ASSERT_NOT_NULL(test, out);
	KUNIT_ASSERT_EQ(test, map_init(test, &map, &row->wire), 0);
	KUNIT_ASSERT_EQ(test, xy3_gap_size(&map), size);
	xy3_encode_gap(&map, out);
	for (size_t clock = 0; clock < size * 8 / row->wire.lines; clock++)
		for (unsigned int line = 0; line < row->wire.lines; line++)
			KUNIT_EXPECT_EQ(test, line_at(&row->wire, out, line, clock),
					row->wire.signal[line] == SYNC);
}

/* With all ones on X, the other lines are low from first to last clock */
static void unused_test(struct kunit *test)
{
	u32 codes[2] = { ~0U, ~0U };

	for (unsigned int lines = 2; lines <= 8; lines *= 2)
		for (unsigned int which = 0; which < lines * 2; which++) {
			struct wire wire = { lines, which & 1 ? 32 : 24 };
			unsigned int x = which / 2, ones = 0;
			struct xy3_line_map map;
			u8 out[2 * 34];

			memset(wire.signal, NONE, lines);
			wire.signal[x] = X;
			KUNIT_ASSERT_EQ(test, map_init(test, &map, &wire), 0);
			KUNIT_EXPECT_EQ(test, map.sync_line, -1);
			xy3_encode_scans(&map, codes, 2, out);
			for (unsigned int clock = 0; clock < 2 * wire.frame_bits; clock++)
				for (unsigned int line = 0; line < lines; line++)
					if (line == x)
						ones += line_at(&wire, out, line, clock);
					else
						KUNIT_EXPECT_FALSE(test, line_at(&wire, out, line,
										 clock));
			/* 32 bits: size, kind, 26 of data, 1010; 24 bits: kind, 20 of data, 00 */
			KUNIT_EXPECT_EQ(test, ones, wire.frame_bits == 32 ? 60 : 42);
		}
}

/* ---- the gate ---- */

static const struct default_row gate_rows[] = {
	{ "2 lines, 24 bits", false, { 2, 24, { GATE, X } } },
	{ "4 lines, 32 bits", false, { 4, 32, { X, Y, GATE, NO } } },
	{ "8 lines, 24 bits", false, { 8, 24, { X, Y, Z, U, W, NO, NO, GATE } } },
	{ "4 lines with SYNC, 24 bits", true, { 4, 24, { SYNC, X, Y, GATE } } },
	{ "4 lines with SYNC, 32 bits", true, { 4, 32, { GATE, X, Y, SYNC } } },
	{ "8 lines with SYNC, 24 bits", true, { 8, 24, { SYNC, X, Y, Z, U, W, GATE, NO } } },
	{ "8 lines with SYNC, 32 bits", true, { 8, 32, { SYNC, X, GATE, NO, NO, NO, NO, Y } } },
	{ "no gate", true, { 4, 24, { SYNC, X, Y, Z } } },
};

KUNIT_ARRAY_PARAM_DESC(gate, gate_rows, name);

/* Three scans that request it; it is set low in the middle one, or in the gap after that */
static void lower_gate_test(struct kunit *test)
{
	const struct default_row *row = test->param_value;
	const struct wire *wire = &row->wire;
	unsigned int clocks = clocks_of(wire);
	u8 was[3 * 34], out[3 * 34];
	struct xy3_line_map map;
	u32 codes[3 * 6];

	KUNIT_ASSERT_EQ(test, map_init(test, &map, wire), 0);
	for (unsigned int i = 0; i < 3 * map.columns; i++)
		codes[i] = i % map.columns < map.axes ? ~i * 0x12345 : 1;
	xy3_encode_scans(&map, codes, 3, was);
	for (unsigned int behind = 0; behind < 2; behind++) {
		memcpy(out, was, sizeof(out));
		if (behind)
			xy3_lower_gate_behind(&map, out + map.scan_size);
		else
			xy3_lower_gate(&map, out + map.scan_size);
		for (unsigned int clock = 0; clock < 3 * clocks; clock++) {
			unsigned int from = clocks + (behind ? wire->frame_bits : 0);
			bool lowered = clock >= from && clock < 2 * clocks;

			for (unsigned int line = 0; line < wire->lines; line++) {
				bool level = line_at(wire, was, line, clock);

				if (wire->signal[line] == GATE) {
					KUNIT_EXPECT_TRUE(test, level);
					level = !lowered;
				}
				KUNIT_EXPECT_EQ(test, line_at(wire, out, line, clock), level);
			}
		}
	}
}

/* ---- words ---- */

static void check_words(struct kunit *test, const struct xy3_line_map *map, u32 value)
{
	struct wire wire = { .frame_bits = map->frame_bits };
	u32 position = 0, command = 0, word;

	for (unsigned int n = 0; n < wire.frame_bits; n++) {
		wire.command = false;
		position = position << 1 | frame_bit(&wire, value, n);
		wire.command = true;
		command = command << 1 | frame_bit(&wire, value & 0xfffff, n);
	}
	xy3_encode_scans(map, &value, 1, (u8 *)&word);
	KUNIT_EXPECT_EQ_MSG(test, word, position, "%#x", value);
	xy3_encode_command_scan(map, value, (u8 *)&word);
	KUNIT_EXPECT_EQ_MSG(test, word, command, "%#x", value);
}

static void word_test(struct kunit *test)
{
	struct wire wire = { 1, 24, { X } };
	struct xy3_line_map map;
	u32 random = 0xcafe;

	for (; wire.frame_bits <= 32; wire.frame_bits += 8) {
		KUNIT_ASSERT_EQ(test, xy3_word_map_init(&map, 1, wire.frame_bits, wire.signal), 0);
		for (unsigned int bit = 0; bit < 32; bit++) {
			check_words(test, &map, 1U << bit);
			check_words(test, &map, (1U << bit) - 1);
			check_words(test, &map, ~(1U << bit));
		}
		for (unsigned int i = 0; i < 5000; i++)
			check_words(test, &map, next_random(&random));
	}
}

/* ---- memory ---- */

/* No scan, some scans, a command: memory on both sides is unchanged, at any address */
static void bounds_test(struct kunit *test)
{
	u32 codes[7 * 5];
	u8 out[8 + 7 * 34 + 16];

	memset(codes, 0xff, sizeof(codes));
	for (unsigned int which = 0; which < ARRAY_SIZE(default_rows) * 9 * 8; which++) {
		const struct wire *wire = &default_rows[which / 72].wire;
		unsigned int scans = which / 8 % 9, start = which % 8, end;
		struct xy3_line_map map;

		KUNIT_ASSERT_EQ(test, map_init(test, &map, wire), 0);
		memset(out, 0x5a, sizeof(out));
		if (scans == 8)
			xy3_encode_command_scan(&map, 0xfffff, out + start);
		else
			xy3_encode_scans(&map, codes, scans, out + start);
		end = start + (scans == 8 ? 1 : scans) * map.scan_size;
		for (unsigned int i = 0; i < sizeof(out); i++)
			if (i < start || i >= end)
				KUNIT_EXPECT_EQ_MSG(test, out[i], 0x5a, "byte %u of %u..%u", i,
						    start, end);
		/* the control: the last byte was written */
		if (end > start)
			KUNIT_EXPECT_NE(test, out[end - 1], 0x5a);
	}
}

/* ---- lanes: a word for each ---- */

static const struct lanes_row {
	const char *name;
	struct wire wire;
	int err;
} lanes_rows[] = {
	{ "one lane", { 1, 24, { X } } },
	{ "five lanes, 24 bits", { 5, 24, { X, Y, Z, U, W } } },
	{ "five lanes, 32 bits", { 5, 32, { W, U, Z, Y, X } } },
	{ "three lanes with a gate, 24 bits", { 3, 24, { GATE, Y, X } } },
	{ "eight lanes with a gate, 32 bits", { 8, 32, { X, Y, NO, U, W, GATE, NO, Z } } },
	{ "no lane", { 0, 24, { X } }, -EINVAL },
	{ "nine lanes", { 9, 24, { X } }, -EINVAL },
	{ "no X", { 2, 24, { Y, NO } }, -EINVAL },
	{ "an axis twice", { 3, 24, { X, Y, Y } }, -EINVAL },
	{ "two gates", { 3, 24, { X, GATE, GATE } }, -EINVAL },
	{ "SYNC as a lane", { 5, 24, { SYNC, X, Y, Z, U } }, -EINVAL },
	{ "a frame of 25 bits", { 2, 25, { X, Y } }, -EINVAL },
};

KUNIT_ARRAY_PARAM_DESC(lanes, lanes_rows, name);

/* The word of a lane, bit by bit; that of the gate is all ones or zeros */
static u32 lane_word(const struct wire *wire, unsigned int lane, const u32 *data)
{
	u8 signal = wire->signal[lane];
	u32 word = 0;

	for (unsigned int n = 0; n < wire->frame_bits; n++) {
		word <<= 1;
		if (signal <= W)
			word |= frame_bit(wire, data[signal], n);
		else if (signal == GATE && !wire->command)
			word |= data[GATE_DATA] == 1;
	}
	return word;
}

/* By axis, then the gate -> columns of the map */
static unsigned int columns_of(const struct wire *wire, const u32 *data, u32 *codes)
{
	unsigned int count = 0;

	for (u8 axis = X; axis <= W; axis++)
		if (has(wire, axis))
			codes[count++] = data[axis];
	if (has(wire, GATE))
		codes[count++] = data[GATE_DATA];
	return count;
}

static void lanes_test(struct kunit *test)
{
	const struct lanes_row *row = test->param_value;
	struct wire wire = row->wire;
	u32 code_max = wire.frame_bits == 32 ? 0x3ffffff : 0xfffff;
	u32 random = 0xbeef, data[4][GATE_DATA + 1], codes[4 * (GATE_DATA + 1)];
	static const u32 empty[GATE_DATA + 1];
	struct xy3_line_map map;
	unsigned int count = 0;
	u32 *out;

	KUNIT_ASSERT_EQ(test, xy3_word_map_init(&map, wire.lines, wire.frame_bits, wire.signal),
			row->err);
	if (row->err)
		return;
	KUNIT_ASSERT_EQ(test, map.scan_size, 4 * wire.lines);
	KUNIT_EXPECT_EQ(test, xy3_gap_size(&map), 0);
	for (unsigned int scan = 0; scan < 4; scan++) {
		for (unsigned int i = 0; i < GATE_DATA; i++)
			data[scan][i] = next_random(&random) & code_max;
		data[scan][GATE_DATA] = scan < 3 ? scan : 1;	/* 2 is not 1 */
		count += columns_of(&wire, data[scan], codes + count);
	}
	KUNIT_ASSERT_EQ(test, count, 4 * map.columns);

	/* in memory of the exact size */
	out = kunit_kmalloc(test, 4 * map.scan_size, GFP_KERNEL);
	KUNIT_ASSERT_NOT_NULL(test, out);
	memset(out, 0x5a, 4 * map.scan_size);
	xy3_encode_scans(&map, codes, 4, (u8 *)out);
	for (unsigned int i = 0; i < 4 * wire.lines; i++)
		KUNIT_EXPECT_EQ_MSG(test, out[i],
				    lane_word(&wire, i % wire.lines, data[i / wire.lines]),
				    "lane %u", i % wire.lines);

	/* the last scan requests the gate */
	data[3][GATE_DATA] = 0;
	xy3_lower_gate_behind(&map, (u8 *)(out + 3 * wire.lines));
	xy3_lower_gate(&map, (u8 *)(out + 3 * wire.lines));
	for (unsigned int lane = 0; lane < wire.lines; lane++)
		KUNIT_EXPECT_EQ(test, out[3 * wire.lines + lane],
				lane_word(&wire, lane, data[3]));

	wire.command = true;
	memset(data[0], 0, sizeof(data[0]));
	data[0][X] = 0xa5a5a;
	xy3_encode_command_scan(&map, data[0][X], (u8 *)out);
	for (unsigned int lane = 0; lane < wire.lines; lane++)
		KUNIT_EXPECT_EQ(test, out[lane],
				lane_word(&wire, lane, wire.signal[lane] == X ? data[0] : empty));
}

static struct kunit_case xy3_lines_cases[] = {
	KUNIT_CASE_PARAM(default_test, default_gen_params),
	KUNIT_CASE(no_default_test),
	KUNIT_CASE(every_map_test),
	KUNIT_CASE(eight_lines_test),
	KUNIT_CASE_PARAM(invalid_test, invalid_gen_params),
	KUNIT_CASE_PARAM(bytes_test, bytes_gen_params),
	KUNIT_CASE(gap_test),
	KUNIT_CASE_PARAM(front_gap_test, default_gen_params),
	KUNIT_CASE(unused_test),
	KUNIT_CASE_PARAM(lower_gate_test, gate_gen_params),
	KUNIT_CASE(word_test),
	KUNIT_CASE_PARAM(lanes_test, lanes_gen_params),
	KUNIT_CASE(bounds_test),
	{}
};

static struct kunit_suite xy3_lines_suite = {
	.name = "xy3_lines",
	.test_cases = xy3_lines_cases,
};

kunit_test_suite(xy3_lines_suite);

MODULE_DESCRIPTION("KUnit tests of XY3-100 scans over several lines");
MODULE_LICENSE("GPL");
