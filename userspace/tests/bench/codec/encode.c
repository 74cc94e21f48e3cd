// SPDX-License-Identifier: GPL-2.0-only
/* bench: scans of the forward channel, against a simple loop over bits, and against the floor */
#include <stdlib.h>
#include <linux/kernel.h>
#include <linux/string.h>
#include <linux/unaligned.h>

#include "../../../../drivers/xy3/xy3-frame.h"
#include "../../../../drivers/xy3/xy3-lines.h"
#include "bench.h"

#define SCANS	256	/* in a block */

struct encode_job {
	struct xy3_line_map map;
	size_t size;
	u32 codes[SCANS * XY3_AXES];
	u8 scans[SCANS * XY3_SCAN_SIZE_MAX];
	u8 other[SCANS * XY3_SCAN_SIZE_MAX];
};

static u32 bit_loop_frame(unsigned int frame_bits, u32 code)
{
	unsigned int data_bits = frame_bits == 32 ? 26 : 20, parity_bits = frame_bits == 32 ? 4 : 2;
	u32 frame = frame_bits == 32 ? 3 : 1, ones = 0;

	for (unsigned int bit = data_bits; bit-- > 0;) {
		frame = frame << 1 | (code >> bit & 1);
		ones += code >> bit & 1;
	}
	return frame << parity_bits | (ones & ((1U << parity_bits) - 1));
}

/* Bit by bit, in the order on the wire: the simplest implementation */
static void bit_loop_encode(const struct xy3_line_map *map, const u32 *codes, size_t scans, u8 *out)
{
	unsigned int lines = map->lines, bits = 0;
	unsigned int clocks = map->frame_bits + (map->sync_line < 0 ? 0 : XY3_GAP_CLOCKS);
	u8 byte = 0;

	for (; scans; scans--) {
		u32 frame[XY3_LINES_MAX] = { 0 };

		for (unsigned int i = 0; i < map->axes; i++)
			frame[map->axis_line[i]] = bit_loop_frame(map->frame_bits, *codes++);
		for (unsigned int clock = 0; clock < clocks; clock++)
			for (unsigned int line = lines; line-- > 0;) {
				byte <<= 1;
				if (clock < map->frame_bits)
					byte |= frame[line] >> (map->frame_bits - 1 - clock) & 1;
				else
					byte |= (int)line == map->sync_line;
				if (++bits % 8 == 0)
					*out++ = byte;
			}
	}
}

static void codec_block(void *data)
{
	struct encode_job *job = data;

	xy3_encode_scans(&job->map, job->codes, SCANS, job->scans);
}

static void bit_loop_block(void *data)
{
	struct encode_job *job = data;

	bit_loop_encode(&job->map, job->codes, SCANS, job->other);
}

/* The minimum for any encoder: parity and framing, and storing the bytes, frame by frame */
static void floor_block(void *data)
{
	struct encode_job *job = data;
	size_t frames = SCANS * job->map.axes;
	u8 *out = job->other;

	if (job->map.frame_bits == 32) {
		for (size_t i = 0; i < frames; i++, out += XY3_FRAME32_SIZE)
			put_unaligned_be32(xy3_frame32(job->codes[i]) | XY3_FRAME32_POSITION, out);
		return;
	}
	for (size_t i = 0; i < frames; i++, out += XY3_FRAME24_SIZE)
		put_unaligned_be24(xy3_frame24(job->codes[i]) | XY3_FRAME24_POSITION, out);
}

static bool floor_good(struct encode_job *job)
{
	unsigned int size = job->map.frame_bits / 8;

	memset(job->other, 0x22, sizeof(job->other));
	floor_block(job);
	for (size_t i = 0; i < SCANS * job->map.axes; i++) {
		u32 frame = bit_loop_frame(job->map.frame_bits, job->codes[i]);

		for (unsigned int k = 0; k < size; k++) {
			if (job->other[i * size + k] != (u8)(frame >> 8 * (size - 1 - k)))
				return false;
		}
	}
	return true;
}

static bool encode_good(void *data)
{
	struct encode_job *job = data;
	bool same;

	memset(job->scans, 0x11, sizeof(job->scans));
	memset(job->other, 0x22, sizeof(job->other));
	codec_block(job);
	bit_loop_block(job);
	same = !memcmp(job->scans, job->other, job->size);
	return same && floor_good(job);
}

static const struct arrangement {
	const char *name;
	u8 lines;
	u8 frame_bits;
	bool sync_is_line;
} arrangements[] = {
	{ "24 bits, 1 line", 1, 24, false },
	{ "32 bits, 1 line", 1, 32, false },
	{ "24 bits, 2 lines", 2, 24, false },
	{ "32 bits, 2 lines", 2, 32, false },
	{ "24 bits, 4 lines", 4, 24, false },
	{ "32 bits, 4 lines", 4, 32, false },
	{ "24 bits, 4 lines with SYNC", 4, 24, true },
	{ "32 bits, 4 lines with SYNC", 4, 32, true },
	{ "24 bits, 8 lines", 8, 24, false },
	{ "32 bits, 8 lines", 8, 32, false },
	{ "24 bits, 8 lines with SYNC", 8, 24, true },
	{ "32 bits, 8 lines with SYNC", 8, 32, true },
};

void add_encoding(void)
{
	static struct encode_job jobs[ARRAY_SIZE(arrangements)];
	u32 random = 0x1234567;

	for (size_t i = 0; i < ARRAY_SIZE(arrangements); i++) {
		const struct arrangement *a = &arrangements[i];
		struct encode_job *job = &jobs[i];

		if (xy3_line_map_init(&job->map, a->lines, a->frame_bits,
				      xy3_default_signals(a->lines, a->sync_is_line)))
			abort();
		job->size = SCANS * job->map.scan_size;
		for (size_t k = 0; k < ARRAY_SIZE(job->codes); k++)
			job->codes[k] = next_random(&random) & xy3_code_max(&job->map);
		add_contest(&(struct contest) {
			.table = "position frames made",
			.name = a->name,
			.unit = "frame",
			.units = SCANS * job->map.axes,
			.bytes = job->size,
			.job = job,
			.good = encode_good,
			.contender = {
				{ "codec", codec_block },
				{ "bit loop", bit_loop_block },
				{ "floor", floor_block },
			},
		});
	}
}
