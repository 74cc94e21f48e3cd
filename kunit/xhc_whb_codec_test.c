// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the codec of XHC pendants, for the WHB04B
 *
 * The same source runs in a kernel and, under sanitizers, on the host. "field" in the name of a row
 * means frames of a program that is used with real units, and captures of their reports.
 */

#include <kunit/test.h>
#include <linux/module.h>

/* not linked but included: the codec exports no symbols */
#include "../drivers/hid-xhc/xhc-codec.c"

#define SEED		0xfe

static const struct xhc_model *whb04b(void)
{
	return xhc_model_find(0xeb93);
}

static void model_test(struct kunit *test)
{
	static const u16 others[] = { 0xea6a, 0xeb71, 0xeb73, 0xeb91 };

	KUNIT_ASSERT_NOT_NULL(test, whb04b());
	KUNIT_EXPECT_STREQ(test, whb04b()->name, "WHB04B");
	KUNIT_EXPECT_EQ(test, whb04b()->report_size, 8);
	KUNIT_EXPECT_EQ(test, whb04b()->chunks, 3);
	KUNIT_EXPECT_EQ(test, whb04b()->key_max, 0x10);
	for (size_t i = 0; i < ARRAY_SIZE(others); i++)
		KUNIT_EXPECT_NULL(test, xhc_model_find(others[i]));
}

/* A copy of exactly @size bytes, so that KASAN or ASan reports a read beyond them */
static u8 *exact(struct kunit *test, const u8 *data, size_t size)
{
	u8 *copy = kunit_kmalloc(test, size, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, copy);
	memcpy(copy, data, size);
	return copy;
}

/* ---- input reports ---- */

struct report_row {
	const char *name;
	u8 data[8];
	struct xhc_input_state want;
};

/* The check byte of each row is valid for the seed FEh */
static const struct report_row report_rows[] = {
	{ "field: idle at X, 5 %", { 0x04, 0xba, 0x00, 0x00, 0x0e, 0x11, 0x00, 0xba },
	  { .selector = XHC_SEL_X, .selector_ok = true,
	    .feed = XHC_FEED_5, .feed_ok = true } },
	{ "field: Reset at Y, 5 %", { 0x04, 0x82, 0x01, 0x00, 0x0e, 0x12, 0x00, 0x81 },
	  { .key = { 0x01 }, .selector = XHC_SEL_Y, .selector_ok = true,
	    .feed = XHC_FEED_5, .feed_ok = true } },
	{ "field: a detent at Y, 5 %", { 0x04, 0x9d, 0x00, 0x00, 0x0e, 0x12, 0x01, 0x9c },
	  { .selector = XHC_SEL_Y, .selector_ok = true, .wheel = 1,
	    .feed = XHC_FEED_5, .feed_ok = true } },
	{ "field: Start/Pause at Y, 30 %", { 0x04, 0x47, 0x03, 0x00, 0x10, 0x12, 0x00, 0x45 },
	  { .key = { 0x03 }, .selector = XHC_SEL_Y, .selector_ok = true,
	    .feed = XHC_FEED_30, .feed_ok = true } },
	{ "field: idle at X, 100 %", { 0x04, 0x10, 0x00, 0x00, 0x1b, 0x11, 0x00, 0x10 },
	  { .selector = XHC_SEL_X, .selector_ok = true,
	    .feed = XHC_FEED_100, .feed_ok = true } },
	{ "off, 2 %", { 4, 0, 0, 0, 0x0d, 0x06, 0, 0x00 },
	  { .selector_ok = true, .feed = XHC_FEED_2, .feed_ok = true } },
	{ "Z, 10 %", { 4, 0, 0, 0, 0x0f, 0x13, 0, 0x00 },
	  { .selector = XHC_SEL_Z, .selector_ok = true,
	    .feed = XHC_FEED_10, .feed_ok = true } },
	{ "A at 14h, 60 %", { 4, 0, 0, 0, 0x1a, 0x14, 0, 0x00 },
	  { .selector = XHC_SEL_A, .selector_ok = true,
	    .feed = XHC_FEED_60, .feed_ok = true } },
	{ "B at 15h, Lead at 1Ch", { 4, 0, 0, 0, 0x1c, 0x15, 0, 0x00 },
	  { .selector = XHC_SEL_B, .selector_ok = true,
	    .feed = XHC_FEED_LEAD, .feed_ok = true } },
	{ "C, Lead at 9Bh", { 4, 0, 0, 0, 0x9b, 0x16, 0, 0x00 },
	  { .selector = XHC_SEL_C, .selector_ok = true,
	    .feed = XHC_FEED_LEAD, .feed_ok = true } },
	{ "A of HB04 is not known", { 4, 0, 0, 0, 0x0d, 0x18, 0, 0x00 },
	  { .feed = XHC_FEED_2, .feed_ok = true } },
	{ "a feed that is not known", { 4, 0, 0, 0, 0x11, 0x11, 0, 0x00 },
	  { .selector = XHC_SEL_X, .selector_ok = true } },
	{ "Fn and a key", { 4, 0, 0x0c, 0x01, 0x0d, 0x06, 0, 0xf4 },
	  { .key = { 0x0c, 0x01 }, .selector_ok = true,
	    .feed = XHC_FEED_2, .feed_ok = true } },
	{ "wheel -128", { 4, 0, 0, 0, 0x0d, 0x11, 0x80, 0x00 },
	  { .selector = XHC_SEL_X, .selector_ok = true, .wheel = -128,
	    .feed = XHC_FEED_2, .feed_ok = true } },
	{ "asleep", { 4, 0x5a, 0, 0, 0, 0, 0, 0x5a },
	  { .asleep = true, .selector_ok = true, .feed_ok = true } },
	{ "no position, but a key in slot 2: not asleep", { 4, 0, 0, 0x05, 0, 0, 0, 0x00 },
	  { .key = { 0, 0x05 }, .selector_ok = true, .feed_ok = true } },
	{ "no axis, but a feed: not asleep", { 4, 0, 0, 0, 0x0d, 0, 0, 0x00 },
	  { .selector_ok = true, .feed = XHC_FEED_2, .feed_ok = true } },
	{ "off, and no feed: not asleep", { 4, 0, 0, 0, 0, 0x06, 0, 0x00 },
	  { .selector_ok = true, .feed_ok = true } },
};

KUNIT_ARRAY_PARAM_DESC(report, report_rows, name);

static void report_test(struct kunit *test)
{
	const struct report_row *row = test->param_value;
	u8 *data = exact(test, row->data, sizeof(row->data));

	for (unsigned int swap = 0; swap < 2; swap++) {
		struct xhc_input_state in;

		memset(&in, 0xa5, sizeof(in));
		KUNIT_ASSERT_EQ(test, 0, xhc_decode_report(whb04b(), data, 8, swap, &in));
		KUNIT_EXPECT_EQ(test, in.key[0], row->want.key[0]);
		KUNIT_EXPECT_EQ(test, in.key[1], row->want.key[1]);
		KUNIT_EXPECT_EQ(test, in.selector, row->want.selector);
		KUNIT_EXPECT_EQ(test, in.selector_code, row->data[5]);
		KUNIT_EXPECT_EQ(test, in.selector_ok, row->want.selector_ok);
		KUNIT_EXPECT_EQ(test, in.feed, row->want.feed);
		KUNIT_EXPECT_EQ(test, in.feed_code, row->data[4]);
		KUNIT_EXPECT_EQ(test, in.feed_ok, row->want.feed_ok);
		KUNIT_EXPECT_EQ(test, in.wheel, row->want.wheel);
		KUNIT_EXPECT_EQ(test, in.asleep, row->want.asleep);
	}
	KUNIT_EXPECT_TRUE(test, xhc_report_matches(whb04b(), data, SEED));
}

/* A report of the other format is refused, for both models, and nothing beyond it is read */
static void report_refused_test(struct kunit *test)
{
	static const u8 good[16] = { 4, 0xba, 1, 0, 0x0e, 0x11, 0, 0xbb };
	static const u16 products[] = { 0xeb6e, 0xeb70, 0xeb93 };
	struct xhc_input_state in, before;

	memset(&in, 0xa5, sizeof(in));
	before = in;
	for (size_t i = 0; i < ARRAY_SIZE(products); i++) {
		const struct xhc_model *model = xhc_model_find(products[i]);
		size_t right = products[i] == 0xeb93 ? 8 : 6;

		for (size_t size = 0; size <= sizeof(good); size++) {
			struct xhc_input_state taken;
			u8 *data = exact(test, good, size);

			if (size == right) {
				KUNIT_EXPECT_EQ(test, 0, xhc_decode_report(model, data, size,
									   false, &taken));
				continue;
			}
			KUNIT_EXPECT_EQ_MSG(test, -EINVAL,
					    xhc_decode_report(model, data, size, false, &in),
					    "%s: %zu bytes", model->name, size);
		}
	}
	for (unsigned int id = 0; id < 256; id++) {
		u8 data[8] = { id, 0, 1 };

		if (id != 4)
			KUNIT_EXPECT_EQ(test, -EINVAL,
					xhc_decode_report(whb04b(), data, 8, false, &in));
	}
	KUNIT_EXPECT_MEMEQ(test, &in, &before, sizeof(in));
}

/* ---- the check byte ---- */

struct check_row {
	const char *name;
	u8 random;
	u8 key;
	u8 seed;
	u8 check;
};

static const struct check_row check_rows[] = {
	{ "field: no key", 0xba, 0x00, SEED, 0xba },
	{ "field: Reset", 0x82, 0x01, SEED, 0x81 },
	{ "field: Start/Pause", 0x47, 0x03, SEED, 0x45 },
	{ "the sum wraps", 0x01, 0x10, SEED, 0x0e ^ 0xfe },
	{ "no random bit: the seed does not show", 0x00, 0x00, SEED, 0x00 },
	{ "all random bits: the seed alone", 0xff, 0x00, SEED, 0xfe },
	{ "all random bits and a key", 0xff, 0x10, SEED, 0xee },
	{ "before the first frame", 0xff, 0x00, 0x01, 0x01 },
};

KUNIT_ARRAY_PARAM_DESC(check, check_rows, name);

static void check_test(struct kunit *test)
{
	const struct check_row *row = test->param_value;

	for (unsigned int check = 0; check < 256; check++) {
		const u8 data[8] = { 4, row->random, row->key, 0x05, 0x0d, 0x11, 0x01, check };

		KUNIT_EXPECT_EQ_MSG(test, check == row->check,
				    xhc_report_matches(whb04b(), data, row->seed),
				    "check byte %02x", check);
	}
}

/* Only the first key changes it: neither the second one, nor a rotary switch, nor the wheel */
static void check_of_others_test(struct kunit *test)
{
	for (size_t at = 3; at < 7; at++)
		for (unsigned int value = 0; value < 256; value++) {
			u8 data[8] = { 4, 0x47, 0x03, 0, 0x10, 0x12, 0, 0x45 };

			data[at] = value;
			KUNIT_EXPECT_TRUE(test, xhc_report_matches(whb04b(), data, SEED));
			data[7] ^= 0x02;
			KUNIT_EXPECT_FALSE(test, xhc_report_matches(whb04b(), data, SEED));
		}
}

/* ---- display frames ---- */

struct frame_row {
	const char *name;
	const char *text[3];
	u16 feedrate_override;
	u16 spindle_override;
	u8 mode;
	bool reset;
	bool work;
	u8 payload[21];
	u8 report[3][8];
};

static const struct frame_row frame_rows[] = {
	{ "field: init_cleared", { "0", "0", "0" }, 0, 0, XHC_MODE_MPG, true, false,
	  { 0xfe, 0xfd, 0xfe, 0x42 },
	  { { 0x06, 0xfe, 0xfd, 0xfe, 0x42 }, { 0x06 }, { 0x06 } } },
	{ "field: typical_machine_step", { "12.345", "-6.789", "0.001" }, 100, 80,
	  XHC_MODE_STEP, false, false,
	  { 0xfe, 0xfd, 0xfe, 0x01, 0x0c, 0x00, 0x7a, 0x0d, 0x06, 0x00, 0xd2, 0x9e,
	    0x00, 0x00, 0x0a, 0x00, 0x64, 0x00, 0x50, 0x00, 0x00 },
	  { { 0x06, 0xfe, 0xfd, 0xfe, 0x01, 0x0c, 0x00, 0x7a },
	    { 0x06, 0x0d, 0x06, 0x00, 0xd2, 0x9e, 0x00, 0x00 },
	    { 0x06, 0x0a, 0x00, 0x64, 0x00, 0x50, 0x00, 0x00 } } },
	{ "field: minus_half", { "-0.5", "0.5", "-0.0004" }, 100, 100,
	  XHC_MODE_STEP, false, true,
	  { 0xfe, 0xfd, 0xfe, 0x81, 0x00, 0x00, 0x88, 0x93, 0x00, 0x00, 0x88, 0x13,
	    0x00, 0x00, 0x04, 0x80, 0x64, 0x00, 0x64, 0x00, 0x00 },
	  { { 0x06, 0xfe, 0xfd, 0xfe, 0x81, 0x00, 0x00, 0x88 },
	    { 0x06, 0x93, 0x00, 0x00, 0x88, 0x13, 0x00, 0x00 },
	    { 0x06, 0x04, 0x80, 0x64, 0x00, 0x64, 0x00, 0x00 } } },
	{ "field: four_decimals_kept", { "1.2345", "-1.2345", "1.99999" }, 120, 50,
	  XHC_MODE_PERCENT, false, false,
	  { 0xfe, 0xfd, 0xfe, 0x03, 0x01, 0x00, 0x29, 0x09, 0x01, 0x00, 0x29, 0x89,
	    0x02, 0x00, 0x00, 0x00, 0x78, 0x00, 0x32, 0x00, 0x00 },
	  { { 0x06, 0xfe, 0xfd, 0xfe, 0x03, 0x01, 0x00, 0x29 },
	    { 0x06, 0x09, 0x01, 0x00, 0x29, 0x89, 0x02, 0x00 },
	    { 0x06, 0x00, 0x00, 0x78, 0x00, 0x32, 0x00, 0x00 } } },
	{ "nothing left to have a sign", { "-0.00001", "-0.00004", "-0" }, 0, 0,
	  XHC_MODE_CONTINUOUS, false, false,
	  { 0xfe, 0xfd, 0xfe, 0x00 },
	  { { 0x06, 0xfe, 0xfd, 0xfe, 0x00 }, { 0x06 }, { 0x06 } } },
	{ "the largest of all", { "65535.9999", "-65535.9999", "65535.99994" }, 65535, 65535,
	  XHC_MODE_PERCENT, true, true,
	  { 0xfe, 0xfd, 0xfe, 0xc3, 0xff, 0xff, 0x0f, 0x27, 0xff, 0xff, 0x0f, 0xa7,
	    0xff, 0xff, 0x0f, 0x27, 0xff, 0xff, 0xff, 0xff, 0x00 },
	  { { 0x06, 0xfe, 0xfd, 0xfe, 0xc3, 0xff, 0xff, 0x0f },
	    { 0x06, 0x27, 0xff, 0xff, 0x0f, 0xa7, 0xff, 0xff },
	    { 0x06, 0x0f, 0x27, 0xff, 0xff, 0xff, 0xff, 0x00 } } },
};

KUNIT_ARRAY_PARAM_DESC(frame, frame_rows, name);

static void frame_test(struct kunit *test)
{
	const struct frame_row *row = test->param_value;
	/* values that WHB04B does not display must not matter */
	struct xhc_display display = {
		.position = { [XHC_MACHINE_X] = 1, 2, 3 },
		.number = { row->feedrate_override, row->spindle_override, 7, 8 },
		.step = 9,
		.icon = 3,
		.state = 0xff,
		.mode = row->mode,
		.reset = row->reset,
		.work = row->work,
	};
	u8 *payload = kunit_kzalloc(test, 21, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, payload);
	for (size_t i = 0; i < XHC_ROWS; i++)
		KUNIT_ASSERT_EQ(test, 0, xhc_parse_position(whb04b(), row->text[i],
							    &display.position[i]));
	KUNIT_ASSERT_EQ(test, 21, xhc_encode_payload(whb04b(), &display, payload));
	KUNIT_EXPECT_MEMEQ(test, payload, row->payload, 21);
	for (unsigned int i = 0; i < 3; i++) {
		u8 report[XHC_CHUNK_SIZE];

		memset(report, 0xa5, sizeof(report));
		xhc_encode_chunk(payload, 21, i, report);
		KUNIT_EXPECT_MEMEQ(test, report, row->report[i], sizeof(report));
	}
}

static void frame_refused_test(struct kunit *test)
{
	for (size_t i = 0; i < XHC_ROWS; i++) {
		struct xhc_display display = { };
		u8 payload[XHC_PAYLOAD_MAX];

		KUNIT_EXPECT_EQ(test, 21, xhc_encode_payload(whb04b(), &display, payload));
		display.position[i] = -655360000;
		KUNIT_EXPECT_EQ(test, -ERANGE, xhc_encode_payload(whb04b(), &display, payload));
	}
}

static struct kunit_case xhc_whb_codec_cases[] = {
	KUNIT_CASE(model_test),
	KUNIT_CASE_PARAM(report_test, report_gen_params),
	KUNIT_CASE(report_refused_test),
	KUNIT_CASE_PARAM(check_test, check_gen_params),
	KUNIT_CASE(check_of_others_test),
	KUNIT_CASE_PARAM(frame_test, frame_gen_params),
	KUNIT_CASE(frame_refused_test),
	{}
};

static struct kunit_suite xhc_whb_codec_suite = {
	.name = "hid_xhc_whb_codec",
	.test_cases = xhc_whb_codec_cases,
};

kunit_test_suite(xhc_whb_codec_suite);

MODULE_DESCRIPTION("KUnit tests of the XHC pendant's codec: WHB04B");
MODULE_LICENSE("GPL");
