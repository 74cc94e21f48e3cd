// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the codec of XHC pendants
 *
 * The same source runs in a kernel and, under sanitizers, on the host. "seed" in the name of a row
 * means examples and tables of the document "XHC xHB03 & xHB04 INTERNALS".
 */

#include <kunit/test.h>
#include <linux/module.h>

/* not linked but included: the codec exports no symbols */
#include "../drivers/hid-xhc/xhc-codec.c"

static const struct xhc_model *hb03(void)
{
	return xhc_model_find(XHC_PRODUCT_HB03);
}

static const struct xhc_model *hb04(void)
{
	return xhc_model_find(XHC_PRODUCT_HB04);
}

static void model_find_test(struct kunit *test)
{
	KUNIT_ASSERT_NOT_NULL(test, hb03());
	KUNIT_ASSERT_NOT_NULL(test, hb04());
	KUNIT_EXPECT_STREQ(test, hb03()->name, "HB03");
	KUNIT_EXPECT_STREQ(test, hb04()->name, "HB04");
	/* other products of the vendor: a serial bridge and a motion card */
	KUNIT_EXPECT_NULL(test, xhc_model_find(0xea6a));
	KUNIT_EXPECT_NULL(test, xhc_model_find(0xeb73));
	KUNIT_EXPECT_NULL(test, xhc_model_find(0x1eb70));
}

static void model_sizes_test(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, hb03()->chunks, 5);
	KUNIT_EXPECT_EQ(test, hb04()->chunks, 6);
}

/* ---- input reports ---- */

struct report_row {
	const char *name;
	u16 product;
	u8 day;
	bool swap;
	u8 data[6];
	struct xhc_input_state want;
};

static const struct report_row report_rows[] = {
	{ "idle, selector off", XHC_PRODUCT_HB04, 0xdd, false,
	  { 4, 0, 0, 0, 0, 0xdd }, { .selector_ok = true } },
	{ "asleep", XHC_PRODUCT_HB04, 0, false,
	  { 4, 0, 0, 0, 0, 0 }, { .asleep = true, .selector_ok = true } },
	{ "key 1 equal to the day is not sleep", XHC_PRODUCT_HB04, 0x17, false,
	  { 4, 0x17, 0, 0, 0, 0 }, { .key = { 0x17 }, .selector_ok = true } },
	{ "two keys (seed: XORED DAY is day XOR button 1)", XHC_PRODUCT_HB04, 13, false,
	  { 4, 0x01, 0x16, 0x11, 0, 13 ^ 1 },
	  { .key = { 0x01, 0x16 }, .selector = XHC_SEL_X, .selector_ok = true } },
	{ "key in slot 2 only", XHC_PRODUCT_HB04, 13, false,
	  { 4, 0, 0x0e, 0x11, 0, 13 },
	  { .key = { 0, 0x0e }, .selector = XHC_SEL_X, .selector_ok = true } },
	{ "another day is told, not refused", XHC_PRODUCT_HB04, 12, false,
	  { 4, 0x01, 0, 0x12, 1, 13 },
	  { .key = { 0x01 }, .selector = XHC_SEL_Y, .wheel = 1, .selector_ok = true } },
	{ "wheel +10 (seed)", XHC_PRODUCT_HB04, 1, false,
	  { 4, 0, 0, 0x11, 10, 1 },
	  { .selector = XHC_SEL_X, .wheel = 10, .selector_ok = true } },
	{ "wheel -10 (seed)", XHC_PRODUCT_HB04, 1, false,
	  { 4, 0, 0, 0x11, 0xf6, 1 },
	  { .selector = XHC_SEL_X, .wheel = -10, .selector_ok = true } },
	{ "wheel -128", XHC_PRODUCT_HB04, 1, false,
	  { 4, 0, 0, 0x11, 0x80, 1 },
	  { .selector = XHC_SEL_X, .wheel = -128, .selector_ok = true } },
	{ "HB03 selector X 11h (seed)", XHC_PRODUCT_HB03, 1, false, { 4, 0, 0, 0x11, 0, 1 },
	  { .selector = XHC_SEL_X, .selector_ok = true } },
	{ "HB03 selector Y 12h (seed)", XHC_PRODUCT_HB03, 1, false, { 4, 0, 0, 0x12, 0, 1 },
	  { .selector = XHC_SEL_Y, .selector_ok = true } },
	{ "HB03 selector Z 13h (seed)", XHC_PRODUCT_HB03, 1, false, { 4, 0, 0, 0x13, 0, 1 },
	  { .selector = XHC_SEL_Z, .selector_ok = true } },
	{ "HB03 selector feed 14h (seed)", XHC_PRODUCT_HB03, 1, false, { 4, 0, 0, 0x14, 0, 1 },
	  { .selector = XHC_SEL_FEED, .selector_ok = true } },
	{ "HB03 selector spindle 15h (seed)", XHC_PRODUCT_HB03, 1, false, { 4, 0, 0, 0x15, 0, 1 },
	  { .selector = XHC_SEL_SPINDLE, .selector_ok = true } },
	{ "HB03 selector speed 18h (seed)", XHC_PRODUCT_HB03, 1, false, { 4, 0, 0, 0x18, 0, 1 },
	  { .selector = XHC_SEL_A, .selector_ok = true } },
	{ "HB04 selector A 18h (seed)", XHC_PRODUCT_HB04, 1, false, { 4, 0, 0, 0x18, 0, 1 },
	  { .selector = XHC_SEL_A, .selector_ok = true } },
	{ "HB04 selector Z 13h (seed)", XHC_PRODUCT_HB04, 1, false, { 4, 0, 0, 0x13, 0, 1 },
	  { .selector = XHC_SEL_Z, .selector_ok = true } },
	{ "HB04 selector spindle 14h (field)", XHC_PRODUCT_HB04, 1, false, { 4, 0, 0, 0x14, 0, 1 },
	  { .selector = XHC_SEL_SPINDLE, .selector_ok = true } },
	{ "HB04 selector feed 15h (field)", XHC_PRODUCT_HB04, 1, false, { 4, 0, 0, 0x15, 0, 1 },
	  { .selector = XHC_SEL_FEED, .selector_ok = true } },
	{ "HB03 feed and spindle swapped", XHC_PRODUCT_HB03, 1, true, { 4, 0, 0, 0x14, 0, 1 },
	  { .selector = XHC_SEL_SPINDLE, .selector_ok = true } },
	{ "HB04 feed and spindle swapped", XHC_PRODUCT_HB04, 1, true, { 4, 0, 0, 0x14, 0, 1 },
	  { .selector = XHC_SEL_FEED, .selector_ok = true } },
	{ "HB04 spindle and feed swapped", XHC_PRODUCT_HB04, 1, true, { 4, 0, 0, 0x15, 0, 1 },
	  { .selector = XHC_SEL_SPINDLE, .selector_ok = true } },
	{ "swapped, X stays X", XHC_PRODUCT_HB04, 1, true, { 4, 0, 0, 0x11, 0, 1 },
	  { .selector = XHC_SEL_X, .selector_ok = true } },
	{ "unknown selector is off", XHC_PRODUCT_HB04, 1, false, { 4, 0, 0, 0x16, 0, 1 },
	  { } },
	{ "unknown selector FFh is off", XHC_PRODUCT_HB03, 1, false, { 4, 0, 0, 0xff, 0, 1 },
	  { } },
	{ "unknown key is passed on", XHC_PRODUCT_HB04, 1, false, { 4, 0x30, 0, 0, 0, 0x31 },
	  { .key = { 0x30 }, .selector_ok = true } },
};

static void report_row_name(const struct report_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(report, report_rows, report_row_name);

/* A copy of exactly @size bytes, so that KASAN or ASan reports a read beyond them */
static u8 *exact(struct kunit *test, const u8 *data, size_t size)
{
	u8 *copy = kunit_kmalloc(test, size, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, copy);
	memcpy(copy, data, size);
	return copy;
}

static void report_test(struct kunit *test)
{
	const struct report_row *row = test->param_value;
	u8 *data = exact(test, row->data, sizeof(row->data));
	struct xhc_input_state in;

	memset(&in, 0xa5, sizeof(in));
	KUNIT_ASSERT_EQ(test, 0, xhc_decode_report(xhc_model_find(row->product), data,
						   sizeof(row->data), row->swap, &in));
	KUNIT_EXPECT_EQ(test, in.key[0], row->want.key[0]);
	KUNIT_EXPECT_EQ(test, in.key[1], row->want.key[1]);
	KUNIT_EXPECT_EQ(test, in.selector, row->want.selector);
	KUNIT_EXPECT_EQ(test, in.wheel, row->want.wheel);
	KUNIT_EXPECT_EQ(test, in.asleep, row->want.asleep);
	KUNIT_EXPECT_EQ(test, in.day, row->day);
	KUNIT_EXPECT_EQ(test, in.selector_ok, row->want.selector_ok);
}

static void report_refused_test(struct kunit *test)
{
	static const u8 good[8] = { 4, 1, 2, 0x11, 5, 6 };
	struct xhc_input_state in, before;

	memset(&in, 0xa5, sizeof(in));
	before = in;
	for (size_t size = 0; size <= sizeof(good); size++) {
		u8 *data = exact(test, good, size);

		/* the valid one is the control */
		KUNIT_EXPECT_EQ_MSG(test, size == 6 ? 0 : -EINVAL,
				    xhc_decode_report(hb04(), data, size, false, &in),
				    "%zu bytes", size);
		if (size < 6)
			KUNIT_EXPECT_MEMEQ(test, &in, &before, sizeof(in));
	}
	for (unsigned int id = 0; id < 256; id++) {
		u8 data[6] = { id };

		KUNIT_EXPECT_EQ_MSG(test, id == 4 ? 0 : -EINVAL,
				    xhc_decode_report(hb04(), data, 6, false, &in),
				    "id %u", id);
	}
}

/* A pendant returns the day that it was sent, XOR its first key, for any other report content */
static void matches_test(struct kunit *test)
{
	static const u8 idle[6] = { 4, 0, 0, 0, 0, 22 };
	static const u8 busy[6] = { 4, 0x0d, 0x17, 0x11, 0xff, 22 ^ 0x0d };

	for (unsigned int day = 0; day < 256; day++) {
		KUNIT_EXPECT_EQ(test, day == 22, xhc_report_matches(hb04(), idle, day));
		KUNIT_EXPECT_EQ(test, day == 22, xhc_report_matches(hb03(), busy, day));
	}
}

/* ---- key changes ---- */

struct keys_row {
	const char *name;
	u8 was[2], now[2];
	unsigned int n;
	struct xhc_key_change want[XHC_KEY_CHANGES_MAX];
};

static const struct keys_row keys_rows[] = {
	{ "nothing", { 0, 0 }, { 0, 0 }, 0, { } },
	{ "press", { 0, 0 }, { 5, 0 }, 1, { { 5, true } } },
	{ "press in slot 2", { 0, 0 }, { 0, 5 }, 1, { { 5, true } } },
	{ "release", { 5, 0 }, { 0, 0 }, 1, { { 5, false } } },
	{ "release from slot 2", { 5, 6 }, { 5, 0 }, 1, { { 6, false } } },
	{ "held", { 5, 0 }, { 5, 0 }, 0, { } },
	{ "second key", { 5, 0 }, { 5, 6 }, 1, { { 6, true } } },
	{ "slots exchanged", { 5, 6 }, { 6, 5 }, 0, { } },
	{ "key moves up when the first is released", { 5, 6 }, { 6, 0 }, 1, { { 5, false } } },
	{ "key moves to slot 2 when another comes", { 6, 0 }, { 5, 6 }, 1, { { 5, true } } },
	{ "one key in both slots is down once", { 0, 0 }, { 5, 5 }, 1, { { 5, true } } },
	{ "and up once", { 5, 5 }, { 0, 0 }, 1, { { 5, false } } },
	{ "from both slots to one", { 5, 5 }, { 0, 5 }, 0, { } },
	{ "releases first", { 5, 6 }, { 7, 8 }, 4,
	  { { 5, false }, { 6, false }, { 7, true }, { 8, true } } },
	{ "one of two changes", { 5, 6 }, { 5, 7 }, 2, { { 6, false }, { 7, true } } },
};

static void keys_row_name(const struct keys_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(keys, keys_rows, keys_row_name);

static void keys_test(struct kunit *test)
{
	const struct keys_row *row = test->param_value;
	struct xhc_key_change change[XHC_KEY_CHANGES_MAX] = { };

	KUNIT_ASSERT_EQ(test, row->n, xhc_key_changes(row->was, row->now, change));
	for (unsigned int i = 0; i < row->n; i++) {
		KUNIT_EXPECT_EQ(test, change[i].code, row->want[i].code);
		KUNIT_EXPECT_EQ(test, change[i].down, row->want[i].down);
	}
}

/* ---- positions: text -> units -> wire, and back to text ---- */

struct position_row {
	const char *name;
	u16 product;
	const char *text;
	int error;
	s32 units;
	u8 wire[4];
	const char *back;
};

#define HB03 XHC_PRODUCT_HB03
#define HB04 XHC_PRODUCT_HB04

static const struct position_row position_rows[] = {
	{ "seed: integer of 135.17 is 135", HB03, "135.17", 0, 1351700,
	  { 135, 0, 17 }, "135.17" },
	{ "seed: integer of 135.17 is 135, HB04", HB04, "135.17", 0, 1351700,
	  { 135, 0, 0xa4, 0x06 }, "135.17" },
	{ "seed: integer of -77.89 is 77", HB03, "-77.89", 0, -778900,
	  { 77, 0, 89 | 0x80 }, "-77.89" },
	{ "seed: integer of -77.89 is 77, HB04", HB04, "-77.89", 0, -778900,
	  { 77, 0, 0xc4, 0x22 | 0x80 }, "-77.89" },
	{ "seed: -117.33 on HB03 is 33 OR 80h", HB03, "-117.33", 0, -1173300,
	  { 117, 0, 33 | 0x80 }, "-117.33" },
	{ "seed: -220.334 on HB04 is 3340 OR 8000h", HB04, "-220.334", 0, -2203340,
	  { 220, 0, 3340 & 0xff, 3340 >> 8 | 0x80 }, "-220.334" },
	{ "-0.5 has its sign in the fraction", HB04, "-0.5", 0, -5000,
	  { 0, 0, 0x88, 0x93 }, "-0.5" },
	{ "zero", HB04, "0", 0, 0, { 0, 0, 0, 0 }, "0" },
	{ "minus zero has no sign", HB04, "-0.0000", 0, 0, { 0, 0, 0, 0 }, "0" },
	{ "less than shown has no sign", HB04, "-0.00004", 0, 0, { 0, 0, 0, 0 }, "0" },
	{ "less than shown has no sign, HB03", HB03, "-0.0049", 0, 0, { 0, 0, 0 }, "0" },
	{ "carry reaches the integer", HB04, "1.99999", 0, 20000, { 2, 0, 0, 0 }, "2" },
	{ "carry reaches the integer, below zero", HB04, "-1.99996", 0, -20000,
	  { 2, 0, 0, 0x80 }, "-2" },
	{ "carry reaches the integer, HB03", HB03, "9.995", 0, 100000, { 10, 0, 0 }, "10" },
	{ "half goes away from zero", HB04, "0.00005", 0, 1, { 0, 0, 1, 0 }, "0.0001" },
	{ "half goes away from zero, below it", HB04, "-0.00005", 0, -1,
	  { 0, 0, 1, 0x80 }, "-0.0001" },
	{ "under half goes down", HB04, "0.000149999", 0, 1, { 0, 0, 1, 0 }, "0.0001" },
	{ "rounded once, not twice", HB03, "0.0049999", 0, 0, { 0, 0, 0 }, "0" },
	{ "two decimals are kept on HB03", HB03, "-220.334", 0, -2203300,
	  { 220, 0, 33 | 0x80 }, "-220.33" },
	{ "fraction below ten", HB04, "3.0007", 0, 30007, { 3, 0, 7, 0 }, "3.0007" },
	{ "no digit before the point", HB04, ".5", 0, 5000, { 0, 0, 0x88, 0x13 }, "0.5" },
	{ "no digit behind the point", HB04, "5.", 0, 50000, { 5, 0, 0, 0 }, "5" },
	{ "plus sign", HB04, "+5.25", 0, 52500, { 5, 0, 0xc4, 0x09 }, "5.25" },
	{ "leading zeros", HB04, "0000000000012.5", 0, 125000, { 12, 0, 0x88, 0x13 }, "12.5" },
	{ "white space around", HB04, " \t-1\n", 0, -10000, { 1, 0, 0, 0x80 }, "-1" },
	{ "fifty decimals", HB04, "1.00000000000000000000000000000000000000000000000001", 0,
	  10000, { 1, 0, 0, 0 }, "1" },
	{ "largest", HB04, "65535.9999", 0, 655359999, { 0xff, 0xff, 0x0f, 0x27 },
	  "65535.9999" },
	{ "smallest", HB04, "-65535.9999", 0, -655359999, { 0xff, 0xff, 0x0f, 0xa7 },
	  "-65535.9999" },
	{ "largest on HB03", HB03, "65535.994", 0, 655359900, { 0xff, 0xff, 99 }, "65535.99" },
	{ "over by rounding", HB04, "65535.99995", -ERANGE, 0, { }, NULL },
	{ "over by rounding, HB03", HB03, "-65535.995", -ERANGE, 0, { }, NULL },
	{ "over", HB04, "65536", -ERANGE, 0, { }, NULL },
	{ "over by far", HB04, "-4294967296", -ERANGE, 0, { }, NULL },
	{ "over by very far", HB04, "99999999999999999999999999999999", -ERANGE, 0, { }, NULL },
	{ "junk goes before range", HB04, "65536x", -EINVAL, 0, { }, NULL },
	{ "empty", HB04, "", -EINVAL, 0, { }, NULL },
	{ "blank", HB04, "\t ", -EINVAL, 0, { }, NULL },
	{ "sign alone", HB04, "-", -EINVAL, 0, { }, NULL },
	{ "point alone", HB04, ".", -EINVAL, 0, { }, NULL },
	{ "two signs", HB04, "--1", -EINVAL, 0, { }, NULL },
	{ "space behind the sign", HB04, "- 1", -EINVAL, 0, { }, NULL },
	{ "two points", HB04, "1.2.3", -EINVAL, 0, { }, NULL },
	{ "decimal comma", HB04, "1,5", -EINVAL, 0, { }, NULL },
	{ "exponent", HB04, "1e3", -EINVAL, 0, { }, NULL },
	{ "hexadecimal", HB04, "0x10", -EINVAL, 0, { }, NULL },
	{ "two numbers", HB04, "1 2", -EINVAL, 0, { }, NULL },
	{ "not a number", HB04, "nan", -EINVAL, 0, { }, NULL },
	{ "junk in the digits that are rounded off", HB04, "1.00001x", -EINVAL, 0, { }, NULL },
};

static void position_row_name(const struct position_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(position, position_rows, position_row_name);

static void position_test(struct kunit *test)
{
	const struct position_row *row = test->param_value;
	const struct xhc_model *model = xhc_model_find(row->product);
	char text[XHC_POSITION_TEXT];
	s32 units = 4711;
	u8 wire[4] = { };

	KUNIT_ASSERT_EQ(test, row->error, xhc_parse_position(model, row->text, &units));
	if (row->error) {
		KUNIT_EXPECT_EQ(test, units, 4711);
		return;
	}
	KUNIT_EXPECT_EQ(test, units, row->units);
	KUNIT_EXPECT_EQ(test, 0, xhc_encode_position(model, units, wire));
	KUNIT_EXPECT_MEMEQ(test, wire, row->wire, sizeof(wire));
	KUNIT_EXPECT_EQ(test, (int)strlen(row->back),
			xhc_format_position(units, text, sizeof(text)));
	KUNIT_EXPECT_STREQ(test, text, row->back);
}

/* Units that are not from xhc_parse_position() */
static void position_encode_test(struct kunit *test)
{
	u8 wire[4] = { };

	/* 1/10000 units on a display of 1/100, half away from zero */
	KUNIT_EXPECT_EQ(test, 0, xhc_encode_position(hb03(), 50, wire));
	KUNIT_EXPECT_EQ(test, wire[2], 1);
	KUNIT_EXPECT_EQ(test, 0, xhc_encode_position(hb03(), -50, wire));
	KUNIT_EXPECT_EQ(test, wire[2], 0x81);
	KUNIT_EXPECT_EQ(test, 0, xhc_encode_position(hb03(), -49, wire));
	KUNIT_EXPECT_EQ(test, wire[2], 0);
	KUNIT_EXPECT_EQ(test, 0, xhc_encode_position(hb03(), 655359949, wire));
	KUNIT_EXPECT_EQ(test, wire[2], 99);
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_encode_position(hb03(), 655359950, wire));
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_encode_position(hb04(), 655360000, wire));
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_encode_position(hb04(), S32_MAX, wire));
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_encode_position(hb04(), S32_MIN, wire));
}

/* ---- display frames ---- */

static const struct xhc_display example = {
	.position = { 1351700, -778900, -1173300, -2203340, -5000, 655359999 },
	.number = { 0x0102, 0x0304, 0x0506, 0x0708 },
	.day = 22,
	.step = 0x8,
	.icon = 0x3,
	.state = XHC_STATE_RUN | 0x40,
};

static const u8 example_hb03[31] = {
	0xfe, 0xfd, 22,
	135, 0, 17, 77, 0, 89 | 0x80, 117, 0, 33 | 0x80,
	220, 0, 33 | 0x80, 0, 0, 50 | 0x80, 1, 0, 0,
	0x02, 0x01, 0x04, 0x03, 0x06, 0x05, 0x08, 0x07,
	0x38, 0x41,
};

static const u8 example_hb04[37] = {
	0xfe, 0xfd, 22,
	135, 0, 0xa4, 0x06, 77, 0, 0xc4, 0xa2, 117, 0, 0xe4, 0x8c,
	220, 0, 0x0c, 0x8d, 0, 0, 0x88, 0x93, 0xff, 0xff, 0x0f, 0x27,
	0x02, 0x01, 0x04, 0x03, 0x06, 0x05, 0x08, 0x07,
	0x38, 0x41,
};

static void payload_hb04_test(struct kunit *test)
{
	u8 *payload = kunit_kzalloc(test, sizeof(example_hb04), GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, payload);
	KUNIT_ASSERT_EQ(test, (int)sizeof(example_hb04),
			xhc_encode_payload(hb04(), &example, payload));
	KUNIT_EXPECT_MEMEQ(test, payload, example_hb04, sizeof(example_hb04));
}

static void payload_hb03_test(struct kunit *test)
{
	struct xhc_display display = example;
	u8 *payload = kunit_kzalloc(test, sizeof(example_hb03), GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, payload);
	display.position[XHC_MACHINE_Z] = 9950;	/* 0.995: the carry again */
	KUNIT_ASSERT_EQ(test, (int)sizeof(example_hb03),
			xhc_encode_payload(hb03(), &display, payload));
	KUNIT_EXPECT_MEMEQ(test, payload, example_hb03, sizeof(example_hb03));
}

static void payload_refused_test(struct kunit *test)
{
	struct xhc_display display = example;
	u8 payload[XHC_PAYLOAD_MAX];

	display.day = 0;
	KUNIT_EXPECT_EQ(test, -EINVAL, xhc_encode_payload(hb04(), &display, payload));
	display.day = 32;
	KUNIT_EXPECT_EQ(test, -EINVAL, xhc_encode_payload(hb04(), &display, payload));
	for (display.day = 1; display.day <= 31; display.day++) {
		KUNIT_EXPECT_EQ(test, 37, xhc_encode_payload(hb04(), &display, payload));
		KUNIT_EXPECT_EQ(test, payload[2], display.day);
	}

	display = example;
	display.position[XHC_WORK_Z] = -655360000;
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_encode_payload(hb04(), &display, payload));
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_encode_payload(hb03(), &display, payload));
}

static void chunk_check(struct kunit *test, const struct xhc_model *model, const u8 *payload,
			size_t size)
{
	u8 *exactly = exact(test, payload, size);

	for (unsigned int i = 0; i < model->chunks; i++) {
		u8 report[XHC_CHUNK_SIZE];

		memset(report, 0xa5, sizeof(report));
		xhc_encode_chunk(exactly, size, i, report);
		KUNIT_EXPECT_EQ(test, report[0], 0x06);
		for (unsigned int j = 0; j < 7; j++) {
			unsigned int at = 7 * i + j;
			u8 want = at < size ? payload[at] : 0;

			KUNIT_EXPECT_EQ_MSG(test, report[1 + j], want, "chunk %u byte %u", i, j);
		}
	}
}

static void chunk_test(struct kunit *test)
{
	static const u8 first[8] = { 0x06, 0xfe, 0xfd, 22, 135, 0, 0xa4, 0x06 };
	/* 37 bytes in six chunks: two bytes of the last one belong to the frame */
	static const u8 last[8] = { 0x06, 0x38, 0x41, 0, 0, 0, 0, 0 };
	u8 report[XHC_CHUNK_SIZE];

	xhc_encode_chunk(example_hb04, sizeof(example_hb04), 0, report);
	KUNIT_EXPECT_MEMEQ(test, report, first, sizeof(first));
	xhc_encode_chunk(example_hb04, sizeof(example_hb04), 5, report);
	KUNIT_EXPECT_MEMEQ(test, report, last, sizeof(last));
	chunk_check(test, hb03(), example_hb03, sizeof(example_hb03));
	chunk_check(test, hb04(), example_hb04, sizeof(example_hb04));
}

/* ---- step and state ---- */

static void step_test(struct kunit *test)
{
	/* seed: low nibble of STEP MUL, 0x00..0x0A */
	static const unsigned int seed[] = { 0, 1, 5, 10, 20, 30, 40, 50, 100, 500, 1000 };

	for (unsigned int code = 0; code < ARRAY_SIZE(seed); code++) {
		KUNIT_EXPECT_EQ(test, (int)code, xhc_step_code(seed[code]));
		KUNIT_EXPECT_EQ(test, (int)seed[code], xhc_step_multiplier(code));
	}
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_step_code(2));
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_step_code(1001));
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_step_code(65536));
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_step_multiplier(0xb));
	KUNIT_EXPECT_EQ(test, -ERANGE, xhc_step_multiplier(0xf));
}

struct step_row {
	const char *text;
	int code;
};

static const struct step_row step_rows[] = {
	{ "0", 0 }, { "10", 3 }, { "1000\n", 10 },
	{ "0x0b", 0x0b }, { "0xb\n", 0x0b }, { "0x0F", 0x0f }, { "0x3", 3 }, { "0x00", 0 },
	{ "11", -ERANGE }, { "2", -ERANGE }, { "-1", -ERANGE }, { "0x10", -ERANGE },
	{ "99999999999", -ERANGE },
	{ "", -EINVAL }, { "0x", -EINVAL }, { "0xg", -EINVAL }, { "b", -EINVAL },
	{ "1 5", -EINVAL }, { "0x-1", -EINVAL }, { "1.5", -EINVAL },
};

static void step_row_name(const struct step_row *row, char *name)
{
	snprintf(name, KUNIT_PARAM_DESC_SIZE, "\"%.*s\"", (int)strcspn(row->text, "\n"),
		 row->text);
}

KUNIT_ARRAY_PARAM(step, step_rows, step_row_name);

static void step_text_test(struct kunit *test)
{
	const struct step_row *row = test->param_value;

	KUNIT_EXPECT_EQ(test, row->code, xhc_parse_step(row->text));
}

struct state_row {
	const char *text;
	u16 product;
	int error;
	u8 state;
	const char *back;
};

static const struct state_row state_rows[] = {
	{ "idle", HB04, 0, 0x00, "idle" },
	{ "run", HB04, 0, 0x01, "run" },
	{ "pause", HB04, 0, 0x02, "pause" },
	{ "inch", HB04, 0, 0x80, "inch" },
	{ "run+inch", HB04, 0, 0x81, "run+inch" },
	{ "inch+pause+run", HB04, 0, 0x83, "run+pause+inch" },
	{ "idle+run", HB04, 0, 0x01, "run" },
	{ "run+run", HB04, 0, 0x01, "run" },
	{ " run\n", HB04, 0, 0x01, "run" },
	{ "0", HB04, 0, 0x00, "idle" },
	{ "3", HB04, 0, 0x03, "run+pause" },
	{ "255", HB04, 0, 0xff, "run+pause+inch+0x7c" },
	{ "0x40", HB04, 0, 0x40, "0x40" },
	{ "run+0x40", HB04, 0, 0x41, "run+0x40" },
	{ "32+64", HB04, 0, 0x60, "0x60" },
	{ "0x80", HB03, 0, 0x80, "0x80" },
	{ "run+pause", HB03, 0, 0x03, "run+pause" },
	{ "0x04", HB03, 0, 0x04, "0x04" },
	/* 80h flashes the yes/no lights of HB03 (seed): it does not mean inch there */
	{ "inch", HB03, -EINVAL, 0, NULL },
	{ "256", HB04, -ERANGE, 0, NULL },
	{ "-1", HB04, -ERANGE, 0, NULL },
	{ "run+0x100", HB04, -ERANGE, 0, NULL },
	{ "99999999999", HB04, -ERANGE, 0, NULL },
	{ "", HB04, -EINVAL, 0, NULL },
	{ "\n", HB04, -EINVAL, 0, NULL },
	{ "+", HB04, -EINVAL, 0, NULL },
	{ "run+", HB04, -EINVAL, 0, NULL },
	{ "+run", HB04, -EINVAL, 0, NULL },
	{ "run pause", HB04, -EINVAL, 0, NULL },
	{ "Run", HB04, -EINVAL, 0, NULL },
	{ "running", HB04, -EINVAL, 0, NULL },
	{ "ru", HB04, -EINVAL, 0, NULL },
	{ "0x", HB04, -EINVAL, 0, NULL },
	{ "12a", HB04, -EINVAL, 0, NULL },
	{ "0123456789012345678901234567890123456789", HB04, -EINVAL, 0, NULL },
};

static void state_row_name(const struct state_row *row, char *name)
{
	strscpy(name, row->text, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(state, state_rows, state_row_name);

static void state_test(struct kunit *test)
{
	const struct state_row *row = test->param_value;
	const struct xhc_model *model = xhc_model_find(row->product);
	char text[XHC_STATE_TEXT];
	u8 state = 0x5a;

	KUNIT_ASSERT_EQ(test, row->error, xhc_parse_state(model, row->text, &state));
	if (row->error) {
		KUNIT_EXPECT_EQ(test, state, 0x5a);
		return;
	}
	KUNIT_EXPECT_EQ(test, state, row->state);
	KUNIT_EXPECT_EQ(test, (int)strlen(row->back),
			xhc_format_state(model, state, text, sizeof(text)));
	KUNIT_EXPECT_STREQ(test, text, row->back);
}

static struct kunit_case xhc_codec_cases[] = {
	KUNIT_CASE(matches_test),
	KUNIT_CASE(model_find_test),
	KUNIT_CASE(model_sizes_test),
	KUNIT_CASE_PARAM(report_test, report_gen_params),
	KUNIT_CASE(report_refused_test),
	KUNIT_CASE_PARAM(keys_test, keys_gen_params),
	KUNIT_CASE_PARAM(position_test, position_gen_params),
	KUNIT_CASE(position_encode_test),
	KUNIT_CASE(payload_hb04_test),
	KUNIT_CASE(payload_hb03_test),
	KUNIT_CASE(payload_refused_test),
	KUNIT_CASE(chunk_test),
	KUNIT_CASE(step_test),
	KUNIT_CASE_PARAM(step_text_test, step_gen_params),
	KUNIT_CASE_PARAM(state_test, state_gen_params),
	{}
};

static struct kunit_suite xhc_codec_suite = {
	.name = "hid_xhc_codec",
	.test_cases = xhc_codec_cases,
};

kunit_test_suite(xhc_codec_suite);

MODULE_DESCRIPTION("KUnit tests of the XHC pendant's codec");
MODULE_LICENSE("GPL");
