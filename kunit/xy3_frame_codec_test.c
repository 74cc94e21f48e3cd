// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: command frames, the rates of the backchannel, and texts with names of axes
 *
 * Codes and bits are from the description of the format, not from the UAPI header.
 */

#include <kunit/test.h>
#include <linux/module.h>
#include <linux/unaligned.h>

/* not linked but included: the codec exports no symbols */
#include "../drivers/xy3/xy3-frame.c"

/* ---- frames made bit by bit ---- */

struct bits {
	u8 byte[4];
	unsigned int count;
};

static void push(struct bits *bits, bool bit)
{
	if (bit)
		bits->byte[bits->count / 8] |= 0x80 >> bits->count % 8;
	bits->count++;
}

/* In the order of sending: size, kind, data and parity, each from its top bit */
static struct bits frame_of(bool is_32, bool position, u32 data)
{
	unsigned int data_bits = is_32 ? 26 : 20, parity_bits = is_32 ? 4 : 2;
	struct bits bits = { };
	unsigned int ones = 0;

	push(&bits, is_32);
	push(&bits, position);
	for (int i = data_bits - 1; i >= 0; i--) {
		push(&bits, data >> i & 1);
		ones += data >> i & 1;
	}
	for (int i = parity_bits - 1; i >= 0; i--)
		push(&bits, ones >> i & 1);
	return bits;
}

/* Decode from memory of exactly this size */
static struct xy3_frame decoded(struct kunit *test, const u8 *raw, size_t size)
{
	u8 *copy = kunit_kmalloc(test, size, GFP_KERNEL);
	struct xy3_frame frame;

	KUNIT_ASSERT_NOT_NULL(test, copy);
	memcpy(copy, raw, size);
	memset(&frame, 0x5a, sizeof(frame));
	xy3_decode_frame(copy, size, &frame);
	kunit_kfree(test, copy);
	return frame;
}

/* ---- decoding ---- */

struct frame_row {
	const char *name;
	u8 raw[4];
	size_t given;
	enum xy3_frame_verdict verdict;
	u8 size;
	u32 data;
};

static const struct frame_row frame_rows[] = {
	{ "command 0", { 0x00, 0x00, 0x00 }, 3, XY3_FRAME_COMMAND, 3, 0 },
	{ "calibrate all axes", { 0x30, 0x00, 0x02 }, 3, XY3_FRAME_COMMAND, 3, 0xc0000 },
	{ "calibrate X and W", { 0x30, 0x00, 0x44 }, 3, XY3_FRAME_COMMAND, 3, 0xc0011 },
	{ "rate 921600", { 0x34, 0x00, 0x03 }, 3, XY3_FRAME_COMMAND, 3, 0xd0000 },
	{ "all data bits: 20 ones are parity 0", { 0x3f, 0xff, 0xfc }, 3, XY3_FRAME_COMMAND, 3,
	  0xfffff },
	{ "position 0", { 0x40, 0x00, 0x00 }, 3, XY3_FRAME_POSITION, 3, 0 },
	{ "position, 19 ones", { 0x7f, 0xff, 0xfb }, 3, XY3_FRAME_POSITION, 3, 0xffffe },
	{ "calibrate all axes, 32 bits", { 0x80, 0xc0, 0x00, 0x02 }, 4, XY3_FRAME_COMMAND, 4,
	  0xc0000 },
	{ "all 20 bits, 32 bits: parity 4", { 0x80, 0xff, 0xff, 0xf4 }, 4, XY3_FRAME_COMMAND, 4,
	  0xfffff },
	{ "position of 26 ones: parity 10", { 0xff, 0xff, 0xff, 0xfa }, 4, XY3_FRAME_POSITION, 4,
	  0x3ffffff },
	{ "position 0, 32 bits", { 0xc0, 0x00, 0x00, 0x00 }, 4, XY3_FRAME_POSITION, 4, 0 },
	{ "the six bits over a command count", { 0xbf, 0x00, 0x00, 0x06 }, 4, XY3_FRAME_COMMAND,
	  4, 0 },
	{ "the six bits over a command do not count", { 0xbf, 0x00, 0x00, 0x00 }, 4,
	  XY3_FRAME_BAD_PARITY, 4, 0 },
	{ "parity of 16 ones is 0", { 0x80, 0xff, 0xff, 0x00 }, 4, XY3_FRAME_COMMAND, 4,
	  0xffff0 },
	{ "parity of too few bits (a field defect)", { 0xff, 0xff, 0xff, 0xf4 }, 4,
	  XY3_FRAME_BAD_PARITY, 4, 0x3ffffff },
	{ "bad parity, command", { 0x30, 0x00, 0x00 }, 3, XY3_FRAME_BAD_PARITY, 3, 0xc0000 },
	{ "bad parity, position", { 0x40, 0x00, 0x01 }, 3, XY3_FRAME_BAD_PARITY, 3, 0 },
	{ "24 bits, more behind them", { 0x30, 0x00, 0x02, 0x30 }, 4, XY3_FRAME_COMMAND, 3,
	  0xc0000 },
	{ "24 bits torn after two bytes", { 0x30, 0x00 }, 2, XY3_FRAME_TORN, 3, 0 },
	{ "24 bits torn after one byte", { 0x30 }, 1, XY3_FRAME_TORN, 3, 0 },
	{ "position torn", { 0x40 }, 1, XY3_FRAME_TORN, 3, 0 },
	{ "32 bits torn after three bytes", { 0x80, 0xc0, 0x00 }, 3, XY3_FRAME_TORN, 4, 0 },
	{ "32 bits torn after two bytes", { 0x80, 0xc0 }, 2, XY3_FRAME_TORN, 4, 0 },
	{ "32 bits torn after one byte", { 0x80 }, 1, XY3_FRAME_TORN, 4, 0 },
};

KUNIT_ARRAY_PARAM_DESC(frame, frame_rows, name);

static void frame_test(struct kunit *test)
{
	const struct frame_row *row = test->param_value;
	struct xy3_frame frame = decoded(test, row->raw, row->given);

	KUNIT_EXPECT_EQ(test, frame.verdict, row->verdict);
	KUNIT_EXPECT_EQ(test, frame.size, row->size);
	KUNIT_EXPECT_EQ(test, frame.data, row->data);
}

/* Data of one bit, of all bits up to it, and of all others: all parities except one are bad */
static void parity_test(struct kunit *test)
{
	for (unsigned int which = 0; which < 4 * 3 * 26; which++) {
		bool is_32 = which & 1, position = which & 2;
		u32 all = is_32 ? 0x3ffffff : 0xfffff;
		u32 bit = (1U << which / 12) & all;
		u32 data = which / 4 % 3 == 0 ? bit : which / 4 % 3 == 1 ? bit - !!bit : all & ~bit;
		struct bits good = frame_of(is_32, position, data);
		size_t size = good.count / 8;
		u8 *last = &good.byte[size - 1];
		u8 parity_mask = is_32 ? 15 : 3, parity = *last & parity_mask;

		for (unsigned int p = 0; p <= parity_mask; p++) {
			struct xy3_frame frame;

			*last = (*last & ~parity_mask) | p;
			frame = decoded(test, good.byte, size);
			KUNIT_EXPECT_EQ_MSG(test, frame.verdict,
					    p != parity ? XY3_FRAME_BAD_PARITY :
					    position ? XY3_FRAME_POSITION : XY3_FRAME_COMMAND,
					    "%#x of %zu bytes, parity %u", data, size, p);
			KUNIT_EXPECT_EQ(test, frame.size, size);
			KUNIT_EXPECT_EQ(test, frame.data, position ? data : data & 0xfffff);
		}
	}
}

/* Each single flipped bit in data or parity of a good frame is detected */
static void flip_test(struct kunit *test)
{
	for (unsigned int kind = 0; kind < 4; kind++) {
		struct bits good = frame_of(kind & 1, kind & 2, 0x12345);

		for (unsigned int bit = 2; bit < good.count; bit++) {
			struct bits bad = good;

			bad.byte[bit / 8] ^= 0x80 >> bit % 8;
			KUNIT_EXPECT_EQ_MSG(test, XY3_FRAME_BAD_PARITY,
					    decoded(test, bad.byte, bad.count / 8).verdict,
					    "kind %u, bit %u", kind, bit);
		}
		KUNIT_EXPECT_NE(test, XY3_FRAME_BAD_PARITY,
				decoded(test, good.byte, good.count / 8).verdict);
	}
}

/* ---- frames as numbers ---- */

/* A frame with the significant bits of @data, as the bits that a sender sends */
static void check_made(struct kunit *test, bool is_32, u32 data)
{
	u32 word = is_32 ? xy3_frame32(data) : xy3_frame24(data);
	u32 counted = data & (is_32 ? 0x3ffffff : 0xfffff);

	for (unsigned int position = 0; position < 2; position++) {
		struct bits want = frame_of(is_32, position, counted);
		struct xy3_frame frame;
		u8 raw[4];

		if (position)
			word |= is_32 ? XY3_FRAME32_POSITION : XY3_FRAME24_POSITION;
		put_unaligned_be32(is_32 ? word : word << 8, raw);
		KUNIT_EXPECT_MEMEQ_MSG(test, raw, want.byte, 4, "%#x", data);

		frame = decoded(test, raw, want.count / 8);
		KUNIT_EXPECT_EQ(test, frame.size, want.count / 8);
		KUNIT_EXPECT_EQ(test, frame.verdict,
				position ? XY3_FRAME_POSITION : XY3_FRAME_COMMAND);
		KUNIT_EXPECT_EQ(test, frame.data, position ? counted : counted & 0xfffff);
	}
}

static void made_test(struct kunit *test)
{
	u32 data = 0x2badcafe;

	KUNIT_EXPECT_EQ(test, XY3_CODE24_MAX, 0xfffffU);
	KUNIT_EXPECT_EQ(test, XY3_CODE32_MAX, 0x3ffffffU);
	for (unsigned int which = 0; which < 32 * 3 * 2; which++) {
		u32 bit = 1U << which / 6;

		check_made(test, which & 1, which / 2 % 3 == 0 ? bit :
			   which / 2 % 3 == 1 ? bit - 1 : ~bit);
	}
	/* pseudo-random, the same ones each time */
	for (unsigned int i = 0; i < 20000; i++) {
		data ^= data << 13;
		data ^= data >> 17;
		data ^= data << 5;
		check_made(test, i & 1, data);
	}
}

/* ---- commands ---- */

struct command_row {
	const char *name;
	u32 header;	/* as in the UAPI header */
	u32 document;
	bool axes;
};

static const struct command_row command_rows[] = {
	{ "autocalib on", XY3_COMMAND_AUTOCALIB_ON_AXES, 0x80000, true },
	{ "autocalib off", XY3_COMMAND_AUTOCALIB_OFF_AXES, 0x40000, true },
	{ "calibrate", XY3_COMMAND_CALIBRATE_AXES, 0xc0000, true },
	{ "reference", XY3_COMMAND_REFERENCE_AXES, 0x20000, true },
	{ "temp_comp on", XY3_COMMAND_TEMP_COMP_ON_AXES, 0x88000, true },
	{ "temp_comp off", XY3_COMMAND_TEMP_COMP_OFF_AXES, 0x48000, true },
	{ "rate 57600", XY3_COMMAND_RATE_57600, 0xa0000, false },
	{ "rate 115200", XY3_COMMAND_RATE_115200, 0xe0000, false },
	{ "rate 230400", XY3_COMMAND_RATE_230400, 0x10000, false },
	{ "rate 460800", XY3_COMMAND_RATE_460800, 0x90000, false },
	{ "rate 921600", XY3_COMMAND_RATE_921600, 0xd0000, false },
};

KUNIT_ARRAY_PARAM_DESC(command, command_rows, name);

/* With each set of axes: the frame is equal to that made bit by bit, and decodes, in both sizes */
static void command_test(struct kunit *test)
{
	const struct command_row *row = test->param_value;

	KUNIT_EXPECT_EQ(test, row->header, row->document);
	for (unsigned int axes = 0; axes < (row->axes ? 32 : 1); axes++) {
		struct bits short_frame = frame_of(false, false, row->document | axes);
		struct bits long_frame = frame_of(true, false, row->document | axes);
		struct xy3_frame frame;
		u8 *raw = kunit_kmalloc(test, 3, GFP_KERNEL);

		KUNIT_ASSERT_NOT_NULL(test, raw);
		xy3_encode_command(row->header | axes, raw);
		KUNIT_EXPECT_MEMEQ(test, raw, short_frame.byte, 3);
		kunit_kfree(test, raw);
		check_made(test, false, row->header | axes);
		check_made(test, true, row->header | axes);

		frame = decoded(test, short_frame.byte, 3);
		KUNIT_EXPECT_EQ(test, frame.verdict, XY3_FRAME_COMMAND);
		KUNIT_EXPECT_EQ(test, frame.data, row->document | axes);
		frame = decoded(test, long_frame.byte, 4);
		KUNIT_EXPECT_EQ(test, frame.verdict, XY3_FRAME_COMMAND);
		KUNIT_EXPECT_EQ(test, frame.size, 4);
		KUNIT_EXPECT_EQ(test, frame.data, row->document | axes);
	}
}

static void encode_test(struct kunit *test)
{
	static const u8 calibrate_x_w[3] = { 0x30, 0x00, 0x44 };
	u8 raw[3];

	/* bits above the 20 change neither data nor parity */
	xy3_encode_command(0xfff00000 | 0xc0011, raw);
	KUNIT_EXPECT_MEMEQ(test, raw, calibrate_x_w, 3);
}

static void axis_test(struct kunit *test)
{
	/* the flags of the document: X 1, Y 2, Z 4, U 8, W 16 */
	KUNIT_EXPECT_EQ(test, XY3_COMMAND_AXIS(XY3_AXIS_X), 0x01U);
	KUNIT_EXPECT_EQ(test, XY3_COMMAND_AXIS(XY3_AXIS_Y), 0x02U);
	KUNIT_EXPECT_EQ(test, XY3_COMMAND_AXIS(XY3_AXIS_Z), 0x04U);
	KUNIT_EXPECT_EQ(test, XY3_COMMAND_AXIS(XY3_AXIS_U), 0x08U);
	KUNIT_EXPECT_EQ(test, XY3_COMMAND_AXIS(XY3_AXIS_W), 0x10U);
	KUNIT_EXPECT_EQ(test, XY3_COMMAND_AXES, 0x1fU);
}

/* ---- rates ---- */

static void rate_test(struct kunit *test)
{
	static const unsigned int rates[] = { 57600, 115200, 230400, 460800, 921600 };
	static const int commands[] = { 0xa0000, 0xe0000, 0x10000, 0x90000, 0xd0000 };
	static const unsigned int others[] = {
		0, 1, 9600, 19200, 38400, 57599, 57601, 115199, 115201, 912600, 912000, 921601,
		500000, 1000000, 1843200, UINT_MAX,
	};

	for (unsigned int i = 0; i < 5; i++) {
		KUNIT_EXPECT_EQ(test, xy3_rate(i), rates[i]);
		KUNIT_EXPECT_EQ(test, xy3_rate_command(rates[i]), commands[i]);
		KUNIT_EXPECT_TRUE(test, xy3_is_rate(rates[i]));
	}
	KUNIT_EXPECT_EQ(test, xy3_rate(5), 0U);
	KUNIT_EXPECT_EQ(test, xy3_rate(UINT_MAX), 0U);
	for (unsigned int i = 0; i < ARRAY_SIZE(others); i++) {
		KUNIT_EXPECT_EQ_MSG(test, xy3_rate_command(others[i]), -EINVAL, "%u", others[i]);
		KUNIT_EXPECT_FALSE(test, xy3_is_rate(others[i]));
	}
	KUNIT_EXPECT_EQ(test, XY3_RATE_DEFAULT, 115200);
}

/* ---- texts ---- */

struct axes_row {
	const char *name;
	const char *text;
	int error;
	u32 axes;
};

static const struct axes_row axes_rows[] = {
	{ "nothing is all", "", 0, 0 },
	{ "blank is all", " \t\n", 0, 0 },
	{ "all", "all", 0, 0 },
	{ "all, as echo writes it", "all\n", 0, 0 },
	{ "x", "x", 0, 1 },
	{ "y", "y", 0, 2 },
	{ "z", "z", 0, 4 },
	{ "u", "u", 0, 8 },
	{ "w", "w\n", 0, 16 },
	{ "all five", "xyzuw", 0, 31 },
	{ "all five, the other way round", "wuzyx", 0, 31 },
	{ "one twice", "xx", 0, 1 },
	{ "capitals", "XW", 0, 17 },
	{ "white space around", "  xz \t", 0, 5 },
	{ "v is no axis", "v", -EINVAL, 0 },
	{ "a letter among good ones", "xav", -EINVAL, 0 },
	{ "a digit", "1", -EINVAL, 0 },
	{ "comma", "x,y", -EINVAL, 0 },
	{ "white space within", "x y", -EINVAL, 0 },
	{ "line feed within", "x\ny", -EINVAL, 0 },
	{ "all and more", "all x", -EINVAL, 0 },
	{ "all grown together", "allx", -EINVAL, 0 },
	{ "all cut short", "al", -EINVAL, 0 },
	{ "8-bit byte", "x\xff", -EINVAL, 0 },
	{ "a letter with the top bit", "\xf8", -EINVAL, 0 },
};

KUNIT_ARRAY_PARAM_DESC(axes, axes_rows, name);

static void axes_test(struct kunit *test)
{
	const struct axes_row *row = test->param_value;
	u32 axes = 4711;

	KUNIT_EXPECT_EQ(test, xy3_parse_axes(row->text, &axes), row->error);
	KUNIT_EXPECT_EQ(test, axes, row->error ? 4711 : row->axes);
}

struct switch_row {
	const char *name;
	const char *text;
	int error;
	bool on;
	u32 axes;
};

static const struct switch_row switch_rows[] = {
	{ "on", "on", 0, true, 0 },
	{ "off", "off", 0, false, 0 },
	{ "on, as echo writes it", "on\n", 0, true, 0 },
	{ "on all", "on all\n", 0, true, 0 },
	{ "off xy", "off xy", 0, false, 3 },
	{ "on w", "on w\n", 0, true, 16 },
	{ "white space", "  on \t  zu \t", 0, true, 12 },
	{ "empty", "", -EINVAL, false, 0 },
	{ "blank", "\n", -EINVAL, false, 0 },
	{ "axes alone", "xy", -EINVAL, false, 0 },
	{ "all alone", "all", -EINVAL, false, 0 },
	{ "on with a bad axis", "on v", -EINVAL, false, 0 },
	{ "on twice", "on on", -EINVAL, false, 0 },
	{ "on and off", "on off", -EINVAL, false, 0 },
	{ "on grown together with axes", "onx", -EINVAL, false, 0 },
	{ "off grown together with axes", "offxy", -EINVAL, false, 0 },
	{ "off cut short", "of", -EINVAL, false, 0 },
	{ "on cut short", "o", -EINVAL, false, 0 },
	{ "capitals", "ON", -EINVAL, false, 0 },
	{ "1 is not on", "1", -EINVAL, false, 0 },
	{ "axes in two words", "on x y", -EINVAL, false, 0 },
	{ "axes first", "xy on", -EINVAL, false, 0 },
};

KUNIT_ARRAY_PARAM_DESC(switch, switch_rows, name);

static void switch_test(struct kunit *test)
{
	const struct switch_row *row = test->param_value;
	bool on = !row->on;
	u32 axes = 4711;

	KUNIT_EXPECT_EQ(test, xy3_parse_switch(row->text, &on, &axes), row->error);
	KUNIT_EXPECT_EQ(test, axes, row->error ? 4711 : row->axes);
	if (!row->error)
		KUNIT_EXPECT_EQ(test, on, row->on);
}

static struct kunit_case xy3_frame_cases[] = {
	KUNIT_CASE_PARAM(frame_test, frame_gen_params),
	KUNIT_CASE(parity_test),
	KUNIT_CASE(flip_test),
	KUNIT_CASE(made_test),
	KUNIT_CASE_PARAM(command_test, command_gen_params),
	KUNIT_CASE(encode_test),
	KUNIT_CASE(axis_test),
	KUNIT_CASE(rate_test),
	KUNIT_CASE_PARAM(axes_test, axes_gen_params),
	KUNIT_CASE_PARAM(switch_test, switch_gen_params),
	{}
};

static struct kunit_suite xy3_frame_suite = {
	.name = "xy3_frame",
	.test_cases = xy3_frame_cases,
};

kunit_test_suite(xy3_frame_suite);

MODULE_DESCRIPTION("KUnit tests of the XY3-100 frame codec");
MODULE_LICENSE("GPL");
