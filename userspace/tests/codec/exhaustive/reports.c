// SPDX-License-Identifier: GPL-2.0-only
/* Input report: every value of every byte, every length, every day. */
#include "../../../../drivers/hid-xhc/xhc-codec.c"
#include "pendant.h"

/* Positions of the rotary switch by code; other codes are off and unknown. */
static int selector_of(const struct pendant *p, int code, bool swap)
{
	static const int position[256] = {
		[0x11] = 1, [0x12] = 2, [0x13] = 3, [0x18] = 4, [0x14] = 5, [0x15] = 6,
	};
	bool as_in_the_document = (p->product == 0xeb6e) != swap;

	/* if false, the codes of 5 and 6 are swapped */
	return position[code] >= 5 && !as_in_the_document ? 11 - position[code] : position[code];
}

static void check(struct kunit *test, const u8 *bytes, bool swap)
{
	const struct pendant *p = test->param_value;
	struct xhc_input_state in;
	u8 *data = kunit_kmalloc(test, 6, GFP_KERNEL);	/* exact size, for ASan */

	KUNIT_ASSERT_NOT_NULL(test, data);
	memset(&in, 0x5a, sizeof(in));
	memcpy(data, bytes, 6);
	KUNIT_ASSERT_EQ(test, xhc_decode_report(pendant_model(test), data, 6, swap, &in), 0);
	KUNIT_ASSERT_EQ(test, in.key[0], bytes[1]);
	KUNIT_ASSERT_EQ(test, in.key[1], bytes[2]);
	KUNIT_ASSERT_EQ_MSG(test, in.selector, selector_of(p, bytes[3], swap), "%#x", bytes[3]);
	KUNIT_ASSERT_EQ(test, in.selector_ok, in.selector != 0 || bytes[3] == 0);
	KUNIT_ASSERT_EQ(test, in.wheel, bytes[4] < 128 ? bytes[4] : bytes[4] - 256);
	KUNIT_ASSERT_EQ(test, in.day, bytes[5] ^ bytes[1]);
	KUNIT_ASSERT_EQ(test, in.asleep,
			!(bytes[1] + bytes[2] + bytes[3] + bytes[4] + bytes[5]));
	kunit_kfree(test, data);
}

static void every_value_of_every_byte(struct kunit *test)
{
	static const u8 around[][6] = {
		{ 4, 0, 0, 0, 0, 0 },
		{ 4, 0, 0, 0, 0, 22 },
		{ 4, 0x17, 0x01, 0x11, 0x01, 0x17 ^ 22 },
		{ 4, 0xff, 0xff, 0xff, 0xff, 0xff },
	};

	for (size_t row = 0; row < ARRAY_SIZE(around); row++)
		for (int at = 1; at < 6; at++)
			for (int value = 0; value < 256; value++) {
				u8 bytes[6];

				memcpy(bytes, around[row], 6);
				bytes[at] = value;
				check(test, bytes, false);
				check(test, bytes, true);
			}
}

static void every_day_with_every_key(struct kunit *test)
{
	for (int day = 0; day < 256; day++)
		for (int key = 0; key < 256; key++) {
			const u8 bytes[6] = { 4, key, 0, 0, 0, key ^ day };

			check(test, bytes, false);
		}
}

/* Refused, nothing written, and no byte read beyond those received. */
static void every_wrong_size_and_id(struct kunit *test)
{
	struct xhc_input_state in, clean;

	memset(&in, 0x5a, sizeof(in));
	clean = in;
	for (size_t size = 0; size <= 64; size++)
		for (int id = 0; id < 256; id++) {
			u8 *data = kunit_kzalloc(test, size, GFP_KERNEL);

			if (size == 6 && id == 4)
				continue;
			KUNIT_ASSERT_NOT_NULL(test, data);
			if (size)
				data[0] = id;
			KUNIT_ASSERT_EQ(test, xhc_decode_report(pendant_model(test), data, size,
								false, &in), -EINVAL);
			KUNIT_ASSERT_MEMEQ(test, &in, &clean, sizeof(in));
			kunit_kfree(test, data);
		}
}

static struct kunit_case cases[] = {
	KUNIT_CASE_PARAM(every_value_of_every_byte, pendants_gen_params),
	KUNIT_CASE_PARAM(every_day_with_every_key, pendants_gen_params),
	KUNIT_CASE_PARAM(every_wrong_size_and_id, pendants_gen_params),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_reports", .test_cases = cases };
kunit_test_suite(suite);
