// SPDX-License-Identifier: GPL-2.0-only
/*
 * The WHB04B: every value of each byte of its report, its check byte for all seeds, and every value
 * of each field of its display frame. The references are written from what is known about units in
 * the field, independent of the tables of the driver.
 */
#include <kunit/test.h>

#include "../../../../drivers/hid-xhc/xhc-codec.c"

static const struct xhc_model *whb04b(struct kunit *test)
{
	const struct xhc_model *model = xhc_model_find(0xeb93);

	KUNIT_ASSERT_NOT_NULL(test, model);
	return model;
}

static int selector_of(int code)
{
	static const int position[256] = {
		[0x11] = 1, [0x12] = 2, [0x13] = 3, [0x14] = 4, [0x15] = 7, [0x16] = 8,
	};

	return position[code];
}

static int feed_of(int code)
{
	static const int position[256] = {
		[0x0d] = 1, [0x0e] = 2, [0x0f] = 3, [0x10] = 4, [0x1a] = 5, [0x1b] = 6,
		[0x1c] = 7, [0x9b] = 7,
	};

	return position[code];
}

static void check(struct kunit *test, const struct xhc_model *model, const u8 *bytes, bool swap)
{
	u8 *data = kunit_kmalloc(test, 8, GFP_KERNEL);	/* exact size, for ASan */
	struct xhc_input_state in;

	KUNIT_ASSERT_NOT_NULL(test, data);
	memset(&in, 0x5a, sizeof(in));
	memcpy(data, bytes, 8);
	KUNIT_ASSERT_EQ(test, xhc_decode_report(model, data, 8, swap, &in), 0);
	KUNIT_ASSERT_EQ(test, in.key[0], bytes[2]);
	KUNIT_ASSERT_EQ(test, in.key[1], bytes[3]);
	KUNIT_ASSERT_EQ_MSG(test, in.feed, feed_of(bytes[4]), "%#x", bytes[4]);
	KUNIT_ASSERT_EQ(test, in.feed_code, bytes[4]);
	KUNIT_ASSERT_EQ(test, in.feed_ok, in.feed != 0 || bytes[4] == 0);
	KUNIT_ASSERT_EQ_MSG(test, in.selector, selector_of(bytes[5]), "%#x", bytes[5]);
	KUNIT_ASSERT_EQ(test, in.selector_code, bytes[5]);
	KUNIT_ASSERT_EQ(test, in.selector_ok,
			in.selector != 0 || bytes[5] == 0 || bytes[5] == 6);
	KUNIT_ASSERT_EQ(test, in.wheel, bytes[6] < 128 ? bytes[6] : bytes[6] - 256);
	KUNIT_ASSERT_EQ(test, in.asleep, !(bytes[2] + bytes[3] + bytes[4] + bytes[5]));
	kunit_kfree(test, data);
}

static void every_value_of_every_byte(struct kunit *test)
{
	static const u8 around[][8] = {
		{ 4, 0, 0, 0, 0, 0, 0, 0 },
		{ 4, 0xba, 0, 0, 0x0e, 0x11, 0, 0xba },
		{ 4, 0x47, 0x03, 0x0c, 0x9b, 0x16, 0xff, 0x45 },
		{ 4, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff },
	};
	const struct xhc_model *model = whb04b(test);

	for (size_t row = 0; row < ARRAY_SIZE(around); row++)
		for (int at = 1; at < 8; at++)
			for (int value = 0; value < 256; value++) {
				u8 bytes[8];

				memcpy(bytes, around[row], 8);
				bytes[at] = value;
				check(test, model, bytes, false);
				check(test, model, bytes, true);
			}
}

static void every_pair_of_keys(struct kunit *test)
{
	const struct xhc_model *model = whb04b(test);

	for (int one = 0; one < 256; one++)
		for (int two = 0; two < 256; two++) {
			const u8 bytes[8] = { 4, one ^ two, one, two };

			check(test, model, bytes, false);
		}
}

static void every_pair_of_rotaries(struct kunit *test)
{
	const struct xhc_model *model = whb04b(test);

	for (int feed = 0; feed < 256; feed++)
		for (int axis = 0; axis < 256; axis++) {
			const u8 bytes[8] = { 4, 0x5a, 0, 0, feed, axis };

			check(test, model, bytes, false);
		}
}

/* Bit by bit: the bit of (255 - r) + key, inverted if it is 0 in r or 1 in the seed */
static int check_byte(int r, int key, int seed)
{
	int sum = (255 - r + key) % 256, byte = 0;

	for (int bit = 1; bit < 256; bit *= 2)
		if (!(sum & bit) == (!(r & bit) || seed & bit))
			byte += bit;
	return byte;
}

static void every_seed(struct kunit *test)
{
	static const int keys[] = { 0, 1, 2, 0x0c, 0x10, 0x7f, 0x80, 0xff };
	const struct xhc_model *model = whb04b(test);

	for (int seed = 0; seed < 256; seed++)
		for (int r = 0; r < 256; r++)
			for (size_t i = 0; i < ARRAY_SIZE(keys); i++) {
				u8 data[8] = { 4, r, keys[i], 0x01, 0x0d, 0x11, 0x01 };

				data[7] = check_byte(r, keys[i], seed);
				KUNIT_ASSERT_TRUE_MSG(test, xhc_report_matches(model, data, seed),
						      "seed %#x r %#x key %#x", seed, r, keys[i]);
				data[7] ^= 1 << (seed + r) % 8;
				KUNIT_ASSERT_FALSE(test, xhc_report_matches(model, data, seed));
			}
}

/* Two seeds cannot be distinguished if they only differ in bits that are 0 in r */
static void every_pair_of_seeds(struct kunit *test)
{
	const struct xhc_model *model = whb04b(test);

	for (int seed = 0; seed < 256; seed++)
		for (int r = 0; r < 256; r++) {
			const u8 data[8] = { 4, r, 0x03, 0, 0x0d, 0x11, 0, check_byte(r, 3, seed) };

			KUNIT_ASSERT_EQ(test, xhc_report_matches(model, data, 0xfe),
					!((seed ^ 0xfe) & r));
		}
}

/* Refused, nothing written, and no byte read beyond those received. */
static void every_wrong_size_and_id(struct kunit *test)
{
	const struct xhc_model *model = whb04b(test);
	struct xhc_input_state in, clean;

	memset(&in, 0x5a, sizeof(in));
	clean = in;
	for (size_t size = 0; size <= 64; size++)
		for (int id = 0; id < 256; id++) {
			u8 *data = kunit_kzalloc(test, size, GFP_KERNEL);

			if (size == 8 && id == 4)
				continue;
			KUNIT_ASSERT_NOT_NULL(test, data);
			if (size)
				data[0] = id;
			KUNIT_ASSERT_EQ(test, xhc_decode_report(model, data, size, false, &in),
					-EINVAL);
			KUNIT_ASSERT_MEMEQ(test, &in, &clean, sizeof(in));
			kunit_kfree(test, data);
		}
}

/* In memory of its exact size */
static u8 *encode(struct kunit *test, const struct xhc_display *display)
{
	static const u8 start[3] = { 0xfe, 0xfd, 0xfe };
	u8 *payload = kunit_kmalloc(test, 21, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, payload);
	KUNIT_ASSERT_EQ(test, xhc_encode_payload(whb04b(test), display, payload), 21);
	KUNIT_ASSERT_MEMEQ(test, payload, start, sizeof(start));
	KUNIT_ASSERT_EQ(test, payload[20], 0);
	return payload;
}

static void every_mode_and_flag(struct kunit *test)
{
	for (int value = 0; value < 16; value++) {
		const struct xhc_display display = {
			.mode = value % 4, .reset = value & 4, .work = value & 8,
		};

		KUNIT_ASSERT_EQ(test, encode(test, &display)[3],
				value % 4 + (value & 4 ? 64 : 0) + (value & 8 ? 128 : 0));
	}
}

static void every_override(struct kunit *test)
{
	for (u32 value = 0; value <= 65535; value++) {
		const struct xhc_display display = { .number = { value, value ^ 0x1234, 1, 2 } };
		u8 *payload = encode(test, &display);

		KUNIT_ASSERT_EQ(test, payload[16] + 256 * payload[17], value);
		KUNIT_ASSERT_EQ(test, payload[18] + 256 * payload[19], value ^ 0x1234);
		kunit_kfree(test, payload);
	}
}

/* Every fraction with either sign, and every integer; no part of a frame looks like its start */
static void every_row(struct kunit *test)
{
	for (u32 value = 0; value <= 65535; value++)
		for (int row = 0; row < 3; row++) {
			struct xhc_display display = { };
			int fraction = value % 10000, sign = value & 1;
			u8 *payload, *at;

			display.position[row] = value * 10000 + fraction;
			if (sign)
				display.position[row] = -display.position[row];
			payload = encode(test, &display);
			at = payload + 4 + 4 * row;
			KUNIT_ASSERT_EQ(test, at[0] + 256 * at[1], value);
			KUNIT_ASSERT_EQ(test, at[2] + 256 * at[3],
					fraction + (sign && value ? 32768 : 0));
			for (int chunk = 7; chunk < 21; chunk += 7)
				KUNIT_ASSERT_FALSE(test, payload[chunk] == 0xfe &&
						   payload[chunk + 1] == 0xfd);
			kunit_kfree(test, payload);
		}
}

static struct kunit_case cases[] = {
	KUNIT_CASE(every_value_of_every_byte),
	KUNIT_CASE(every_pair_of_keys),
	KUNIT_CASE(every_pair_of_rotaries),
	KUNIT_CASE(every_seed),
	KUNIT_CASE(every_pair_of_seeds),
	KUNIT_CASE(every_wrong_size_and_id),
	KUNIT_CASE(every_mode_and_flag),
	KUNIT_CASE(every_override),
	KUNIT_CASE(every_row),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_whb04b", .test_cases = cases };
kunit_test_suite(suite);
