// SPDX-License-Identifier: GPL-2.0-only
/*
 * Positions and commands over all default arrangements of lines: sampled clock by clock, each line
 * separately, and decoded by the rules of a receiver. One line gets all values of 20 bits, each of
 * two lines half of them, spread over the whole range, and so on; commands fewer.
 */
#include "../../../../drivers/xy3/xy3-lines.c"
#include <kunit/test.h>

struct arrangement {
	const char *name;
	unsigned int lines;
	unsigned int frame_bits;
	bool sync_is_line;
};

static const struct arrangement arrangements[] = {
	{ "1 line, 24 bits", 1, 24, false },
	{ "1 line, 32 bits", 1, 32, false },
	{ "2 lines, 24 bits", 2, 24, false },
	{ "2 lines, 32 bits", 2, 32, false },
	{ "4 lines, 24 bits", 4, 24, false },
	{ "4 lines, 32 bits", 4, 32, false },
	{ "8 lines, 24 bits", 8, 24, false },
	{ "8 lines, 32 bits", 8, 32, false },
	{ "4 lines with SYNC, 24 bits", 4, 24, true },
	{ "4 lines with SYNC, 32 bits", 4, 32, true },
	{ "8 lines with SYNC, 24 bits", 8, 24, true },
	{ "8 lines with SYNC, 32 bits", 8, 32, true },
};

KUNIT_ARRAY_PARAM_DESC(arrangement, arrangements, name);

/* The bits received on each line, first bit on top */
struct taken {
	u64 line[8];
	unsigned int clocks;
};

static struct taken take(const struct arrangement *a, const u8 *scan, size_t size)
{
	struct taken taken = { .clocks = size * 8 / a->lines };
	unsigned int mask = (1U << a->lines) - 1;

	for (unsigned int clock = 0; clock < taken.clocks; clock++) {
		unsigned int at = clock * a->lines;
		unsigned int group = scan[at / 8] >> (8 - a->lines - at % 8) & mask;

		for (unsigned int line = 0; line < a->lines; line++)
			taken.line[line] = taken.line[line] << 1 | (group >> line & 1);
	}
	return taken;
}

/* The frame that a receiver must get; its bits are added up one by one */
static u32 frame_word(const struct arrangement *a, bool position, u32 data)
{
	unsigned int ones = 0;

	for (u32 rest = data; rest; rest &= rest - 1)
		ones++;
	if (a->frame_bits == 32)
		return (position ? 0xc0000000 : 0x80000000) + data * 16 + ones % 16;
	return (position ? 0x400000 : 0) + data * 4 + ones % 4;
}

static void check(struct kunit *test, const struct xy3_line_map *map, const u8 *scan,
		  bool position, const u32 *data)
{
	const struct arrangement *a = test->param_value;
	struct taken taken = take(a, scan, map->scan_size);
	unsigned int gap = a->sync_is_line ? 2 : 0;

	if (taken.clocks != a->frame_bits + gap)
		KUNIT_FAIL_AND_ABORT(test, "%u clocks", taken.clocks);
	for (unsigned int line = 0; line < a->lines; line++) {
		int axis = (int)line - a->sync_is_line;	/* the same order in all arrangements */
		u64 want = 0;

		if (axis < 0)
			want = 3;
		else if (axis < map->axes)	/* the other axes get an empty command */
			want = (u64)frame_word(a, position,
					       position || !axis ? data[axis] : 0) << gap;
		if (taken.line[line] != want)
			KUNIT_FAIL_AND_ABORT(test, "line %u: %#llx, not %#llx", line,
					     (unsigned long long)taken.line[line],
					     (unsigned long long)want);
	}
}

static void init(struct kunit *test, struct xy3_line_map *map)
{
	const struct arrangement *a = test->param_value;
	const u8 *signal = xy3_default_signals(a->lines, a->sync_is_line);

	KUNIT_ASSERT_NOT_NULL(test, signal);
	KUNIT_ASSERT_EQ(test, xy3_line_map_init(map, a->lines, a->frame_bits, signal), 0);
}

#define BLOCK	256

/* No two axes get the codes in the same order */
static void every_position(struct kunit *test)
{
	static const u32 odd[XY3_AXES] = { 0x9e375, 0x3fffb, 0xb504f, 0x6a09f, 0xc2b2b };
	static u32 codes[BLOCK * XY3_AXES];
	static u8 out[BLOCK * XY3_SCAN_SIZE_MAX];
	struct xy3_line_map map;

	init(test, &map);
	for (u32 first = 0; first < (1U << 20) / map.lines; first += BLOCK) {
		for (u32 i = 0; i < BLOCK * map.axes; i++)
			codes[i] = (first + i / map.axes) * odd[i % map.axes] & 0xfffff;
		xy3_encode_scans(&map, codes, BLOCK, out);
		for (u32 i = 0; i < BLOCK; i++)
			check(test, &map, out + i * map.scan_size, true, codes + i * map.axes);
	}
}

static void every_command(struct kunit *test)
{
	struct xy3_line_map map;
	u32 step;

	init(test, &map);
	step = map.lines == 1 ? 1 : 8 * map.lines + 1;
	for (u32 command = 0; command < 1U << 20; command += step) {
		u8 out[XY3_SCAN_SIZE_MAX];

		/* bits above the 20 are dropped */
		xy3_encode_command_scan(&map, command | command << 20, out);
		check(test, &map, out, false, &command);
	}
}

static struct kunit_case cases[] = {
	KUNIT_CASE_PARAM(every_position, arrangement_gen_params),
	KUNIT_CASE_PARAM(every_command, arrangement_gen_params),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_lines", .test_cases = cases };
kunit_test_suite(suite);
