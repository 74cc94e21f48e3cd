// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: content of the packets of the backchannel
 *
 * Numbers, names and sizes are from the description of the format, not from the codec.
 */

#include <kunit/test.h>
#include <linux/module.h>

/* not linked but included: the codec exports no symbols */
#include "../drivers/xy3/xy3-packet.c"

#define COMPONENTS	22
#define AXES		5

/* A packet in memory of exactly its size: reads beyond it are detected */
static struct xy3_packet packet_of(struct kunit *test, u8 type, const void *payload, u8 length)
{
	u8 *raw = kunit_kmalloc(test, 3 + length, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, raw);
	raw[0] = 0x48;
	raw[1] = type;
	raw[2] = length;
	memcpy(raw + 3, payload, length);
	return (struct xy3_packet){ .type = type, .length = length, .known = true, .raw = raw };
}

/* ---- temperatures ---- */

struct temperature_row {
	const char *name;
	u8 length;
	u8 payload[44];
	s16 little[COMPONENTS];
	s16 big[COMPONENTS];
};

static const struct temperature_row temperature_rows[] = {
	{ "head alone, 25.50 degrees", 2, { 0xf6, 0x09 }, { 2550 }, { -2551 } },
	{ "below zero", 2, { 0xff, 0xff }, { -1 }, { -1 } },
	{ "highest", 2, { 0xff, 0x7f }, { 32767 }, { -129 } },
	{ "lowest", 2, { 0x00, 0x80 }, { -32768 }, { 128 } },
	{ "not supported is -32767", 2, { 0x01, 0x80 }, { -32767 }, { 384 } },
	{ "not supported, big endian", 2, { 0x80, 0x01 }, { 384 }, { -32767 } },
	{ "zero is a temperature", 4, { 0, 0, 0, 0 }, { 0, 0 }, { 0, 0 } },
	{ "not supported in the middle", 6, { 1, 0, 0x01, 0x80, 3, 0 }, { 1, -32767, 3 },
	  { 256, 384, 768 } },
	{ "all but the last", 42,
	  { 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0, 8, 0, 9, 0, 10, 0, 11, 0, 12, 0, 13, 0, 14,
	    0, 15, 0, 16, 0, 17, 0, 18, 0, 19, 0, 20, 0, 21, 0 },
	  { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21 },
	  { 256, 512, 768, 1024, 1280, 1536, 1792, 2048, 2304, 2560, 2816, 3072, 3328, 3584,
	    3840, 4096, 4352, 4608, 4864, 5120, 5376 } },
	{ "all", 44,
	  { 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7, 0, 8, 0, 9, 0, 10, 0, 11, 0, 12, 0, 13, 0,
	    14, 0, 15, 0, 16, 0, 17, 0, 18, 0, 19, 0, 20, 0, 21, 0, 22 },
	  { 256, 512, 768, 1024, 1280, 1536, 1792, 2048, 2304, 2560, 2816, 3072, 3328, 3584,
	    3840, 4096, 4352, 4608, 4864, 5120, 5376, 5632 },
	  { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22 } },
};

KUNIT_ARRAY_PARAM_DESC(temperature, temperature_rows, name);

static void temperature_test(struct kunit *test)
{
	const struct temperature_row *row = test->param_value;
	struct xy3_packet packet = packet_of(test, 0x05, row->payload, row->length);
	unsigned int count = row->length / 2;

	for (unsigned int big = 0; big < 2; big++) {
		s16 *got = kunit_kmalloc(test, COMPONENTS * sizeof(*got), GFP_KERNEL);
		const s16 *want = big ? row->big : row->little;

		KUNIT_ASSERT_NOT_NULL(test, got);
		memset(got, 0x5a, COMPONENTS * sizeof(*got));
		KUNIT_EXPECT_EQ(test, count, xy3_packet_temperatures(&packet, big ?
				XY3_BIG_ENDIAN : XY3_LITTLE_ENDIAN, got));
		/* a missing component is like one without a sensor: no old value is kept */
		for (unsigned int i = 0; i < COMPONENTS; i++)
			KUNIT_EXPECT_EQ_MSG(test, got[i], i < count ? want[i] : -32767,
					    "component %u, big %u", i, big);
	}
}

/* ---- hours and frame errors ---- */

struct number_row {
	const char *name;
	u8 length;
	u8 payload[88];
	u32 little[COMPONENTS];
	u32 big[COMPONENTS];
};

static const struct number_row hours_rows[] = {
	{ "head alone, 4711 hours", 4, { 0x67, 0x12, 0, 0 }, { 4711 }, { 0x67120000 } },
	{ "none", 4, { 0, 0, 0, 0 }, { 0 }, { 0 } },
	{ "not supported is FFFFFFFFh", 4, { 0xff, 0xff, 0xff, 0xff }, { 0xffffffff },
	  { 0xffffffff } },
	{ "the highest", 4, { 0xfe, 0xff, 0xff, 0xff }, { 0xfffffffe }, { 0xfeffffff } },
	{ "the highest, big endian", 4, { 0xff, 0xff, 0xff, 0xfe }, { 0xfeffffff },
	  { 0xfffffffe } },
	{ "top bit", 4, { 0, 0, 0, 0x80 }, { 0x80000000 }, { 0x80 } },
	{ "four bytes apart", 8, { 1, 2, 3, 4, 5, 6, 7, 8 }, { 0x04030201, 0x08070605 },
	  { 0x01020304, 0x05060708 } },
	{ "not supported in the middle", 12, { 1, 0, 0, 0, 0xff, 0xff, 0xff, 0xff, 3, 0, 0, 0 },
	  { 1, 0xffffffff, 3 }, { 0x01000000, 0xffffffff, 0x03000000 } },
	{ "all", 88, { [0] = 1, [80] = 21, [84] = 22, [87] = 23 },
	  { [0] = 1, [20] = 21, [21] = 0x17000016 },
	  { [0] = 0x01000000, [20] = 0x15000000, [21] = 0x16000017 } },
};

KUNIT_ARRAY_PARAM_DESC(hours, hours_rows, name);

static void hours_test(struct kunit *test)
{
	const struct number_row *row = test->param_value;
	struct xy3_packet packet = packet_of(test, 0x09, row->payload, row->length);
	unsigned int count = row->length / 4;

	for (unsigned int big = 0; big < 2; big++) {
		u32 *got = kunit_kmalloc(test, COMPONENTS * sizeof(*got), GFP_KERNEL);
		const u32 *want = big ? row->big : row->little;

		KUNIT_ASSERT_NOT_NULL(test, got);
		memset(got, 0x5a, COMPONENTS * sizeof(*got));
		KUNIT_EXPECT_EQ(test, count, xy3_packet_hours(&packet, big ?
				XY3_BIG_ENDIAN : XY3_LITTLE_ENDIAN, got));
		for (unsigned int i = 0; i < COMPONENTS; i++)
			KUNIT_EXPECT_EQ_MSG(test, got[i], i < count ? want[i] : 0xffffffff,
					    "component %u, big %u", i, big);
	}
}

static const struct number_row frame_errors_rows[] = {
	{ "none", 20, { 0 }, { 0 }, { 0 } },
	{ "one of each axis", 20,
	  { 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0, 5, 0, 0, 0 }, { 1, 2, 3, 4, 5 },
	  { 0x01000000, 0x02000000, 0x03000000, 0x04000000, 0x05000000 } },
	{ "FFFFFFFFh is a count", 20,
	  { [0] = 0xff, 0xff, 0xff, 0xff, [16] = 0xfe, 0xff, 0xff, 0xff },
	  { 0xffffffff, 0, 0, 0, 0xfffffffe }, { 0xffffffff, 0, 0, 0, 0xfeffffff } },
	{ "each byte in its place", 20,
	  { 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20 },
	  { 0x04030201, 0x08070605, 0x0c0b0a09, 0x100f0e0d, 0x14131211 },
	  { 0x01020304, 0x05060708, 0x090a0b0c, 0x0d0e0f10, 0x11121314 } },
};

KUNIT_ARRAY_PARAM_DESC(frame_errors, frame_errors_rows, name);

static void frame_errors_test(struct kunit *test)
{
	const struct number_row *row = test->param_value;
	struct xy3_packet packet = packet_of(test, 0x06, row->payload, row->length);

	for (unsigned int big = 0; big < 2; big++) {
		u32 *got = kunit_kmalloc(test, AXES * sizeof(*got), GFP_KERNEL);
		const u32 *want = big ? row->big : row->little;

		KUNIT_ASSERT_NOT_NULL(test, got);
		memset(got, 0x5a, AXES * sizeof(*got));
		KUNIT_EXPECT_EQ(test, 5U, xy3_packet_frame_errors(&packet, big ?
				XY3_BIG_ENDIAN : XY3_LITTLE_ENDIAN, got));
		for (unsigned int i = 0; i < AXES; i++)
			KUNIT_EXPECT_EQ_MSG(test, got[i], want[i], "axis %u, big %u", i, big);
	}
}

/* ---- error states ---- */

/* Every length: bytes are unchanged, and missing ones are no error */
static void errors_test(struct kunit *test)
{
	static const u8 payload[COMPONENTS] = {
		1, 2, 3, 4, 5, 6, 7, 0, 8, 99, 100, 101, 127, 128, 254, 255, 1, 1, 1, 1, 1, 255
	};

	for (unsigned int length = 1; length <= COMPONENTS; length++) {
		struct xy3_packet packet = packet_of(test, 0x07, payload, length);
		u8 *got = kunit_kmalloc(test, COMPONENTS, GFP_KERNEL);

		KUNIT_ASSERT_NOT_NULL(test, got);
		memset(got, 0x5a, COMPONENTS);
		KUNIT_EXPECT_EQ(test, length, xy3_packet_errors(&packet, got));
		for (unsigned int i = 0; i < COMPONENTS; i++)
			KUNIT_EXPECT_EQ_MSG(test, got[i], i < length ? payload[i] : 0,
					    "component %u of %u", i, length);
	}
}

/* ---- packets of other types ---- */

/* Every reader with every type: only its own type has values, and no old ones are kept */
static void other_type_test(struct kunit *test)
{
	static const u8 payload[20] = { [0 ... 19] = 1 };

	for (unsigned int type = 0; type < 256; type++) {
		struct xy3_packet packet = packet_of(test, type, payload, sizeof(payload));
		s16 temperature[COMPONENTS];
		u32 frames[AXES];
		u32 hours[COMPONENTS];
		u8 error[COMPONENTS];

		memset(temperature, 0x5a, sizeof(temperature));
		memset(frames, 0x5a, sizeof(frames));
		memset(hours, 0x5a, sizeof(hours));
		memset(error, 0x5a, sizeof(error));
		packet.known = (type >= 1 && type <= 9) || type == 0x41;

		KUNIT_EXPECT_EQ(test, type == 0x05 ? 10U : 0U,
				xy3_packet_temperatures(&packet, XY3_LITTLE_ENDIAN, temperature));
		KUNIT_EXPECT_EQ(test, temperature[0], type == 0x05 ? 0x0101 : -32767);
		KUNIT_EXPECT_EQ(test, temperature[21], -32767);
		KUNIT_EXPECT_EQ(test, type == 0x06 ? 5U : 0U,
				xy3_packet_frame_errors(&packet, XY3_LITTLE_ENDIAN, frames));
		KUNIT_EXPECT_EQ(test, frames[0], type == 0x06 ? 0x01010101 : 0);
		KUNIT_EXPECT_EQ(test, frames[4], type == 0x06 ? 0x01010101 : 0);
		KUNIT_EXPECT_EQ(test, type == 0x07 ? 20U : 0U, xy3_packet_errors(&packet, error));
		KUNIT_EXPECT_EQ(test, error[0], type == 0x07 ? 1 : 0);
		KUNIT_EXPECT_EQ(test, error[21], 0);
		KUNIT_EXPECT_EQ(test, type == 0x09 ? 5U : 0U,
				xy3_packet_hours(&packet, XY3_BIG_ENDIAN, hours));
		KUNIT_EXPECT_EQ(test, hours[0], type == 0x09 ? 0x01010101 : 0xffffffff);
		KUNIT_EXPECT_EQ(test, hours[21], 0xffffffff);
		kunit_kfree(test, packet.raw);
	}
}

/* ---- text ---- */

struct text_row {
	const char *name;
	const char *payload;
	u8 length;
	size_t room;
	const char *want;
};

static const struct text_row text_rows[] = {
	{ "plain", "XY3", 3, 201, "XY3" },
	{ "all marks", " !\"#$%&'()*+,-./:;<=>?@[\\]^_`{|}~", 33, 201,
	  " !\"#$%&'()*+,-./:;<=>?@[\\]^_`{|}~" },
	{ "first and last that can be printed", "\x20\x7e\x20", 3, 201, " ~ " },
	{ "one below and one above them", "\x1f\x7f\x20", 3, 201, "?? " },
	{ "NUL does not end it", "A\0B", 3, 201, "A?B" },
	{ "NULs", "\0\0\0", 3, 201, "???" },
	{ "line feed, tab, carriage return", "a\nb\tc\r", 6, 201, "a?b?c?" },
	{ "escape sequence", "\033[2Jx", 5, 201, "?[2Jx" },
	{ "8-bit bytes", "\x80\xa0\xc3\xa4\xff", 5, 201, "?????" },
	{ "spaces are kept", "  x  ", 5, 201, "  x  " },
	{ "percent is no format", "%s%n", 4, 201, "%s%n" },
	{ "room for all and the end", "abcd", 4, 5, "abcd" },
	{ "room for one less", "abcd", 4, 4, "abc" },
	{ "room for one", "abcd", 4, 2, "a" },
	{ "room for the end only", "abcd", 4, 1, "" },
	{ "empty", "", 0, 5, "" },
	{ "empty, room for the end only", "", 0, 1, "" },
};

KUNIT_ARRAY_PARAM_DESC(text, text_rows, name);

static void text_test(struct kunit *test)
{
	const struct text_row *row = test->param_value;
	struct xy3_packet packet = packet_of(test, 0x01, row->payload, row->length);
	char *text = kunit_kmalloc(test, row->room, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, text);
	memset(text, 'Z', row->room);
	KUNIT_EXPECT_EQ(test, strlen(row->want), xy3_packet_text(&packet, text, row->room));
	KUNIT_EXPECT_STREQ(test, text, row->want);
}

/* The longest, and that of an unknown type: the buffer has at most 256 bytes */
static void text_long_test(struct kunit *test)
{
	static u8 payload[255];
	char *text = kunit_kmalloc(test, 256, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, text);
	memset(payload, '~', sizeof(payload));
	for (unsigned int length = 199; length <= 255; length++) {
		struct xy3_packet packet = packet_of(test, 0x08, payload, length);

		KUNIT_EXPECT_EQ(test, (size_t)length, xy3_packet_text(&packet, text, 256));
		KUNIT_EXPECT_EQ(test, (size_t)length, strlen(text));
		KUNIT_EXPECT_EQ(test, (size_t)200, xy3_packet_text(&packet, text, 201) +
				(length < 200 ? 1 : 0));
	}
}

/* ---- names ---- */

static void names_test(struct kunit *test)
{
	static const char * const components[COMPONENTS] = {
		"head", "dsp",
		"dac_x", "dac_y", "dac_z", "dac_u", "dac_w",
		"driver_x", "driver_y", "driver_z", "driver_u", "driver_w",
		"galvo_x", "galvo_y", "galvo_z", "galvo_u", "galvo_w",
		"mirror_x", "mirror_y", "mirror_z", "mirror_u", "mirror_w",
	};
	static const char * const errors[] = {
		"none", "temperature", "data", "range", "power", "electrical", "adjustment",
		"mechanical",
	};
	static const char * const axes[AXES] = { "x", "y", "z", "u", "w" };

	for (unsigned int i = 0; i < COMPONENTS; i++)
		KUNIT_EXPECT_STREQ(test, xy3_component_name(i), components[i]);
	for (unsigned int i = 0; i < AXES; i++)
		KUNIT_EXPECT_STREQ(test, xy3_axis_name(i), axes[i]);
	for (unsigned int i = 0; i < 256; i++) {
		if (i < ARRAY_SIZE(errors))
			KUNIT_EXPECT_STREQ(test, xy3_error_name(i), errors[i]);
		else
			KUNIT_EXPECT_NULL(test, xy3_error_name(i));
	}
	KUNIT_EXPECT_NULL(test, xy3_component_name(COMPONENTS));
	KUNIT_EXPECT_NULL(test, xy3_component_name(UINT_MAX));
	KUNIT_EXPECT_NULL(test, xy3_axis_name(AXES));
	KUNIT_EXPECT_NULL(test, xy3_axis_name(UINT_MAX));
}

static struct kunit_case xy3_content_cases[] = {
	KUNIT_CASE_PARAM(temperature_test, temperature_gen_params),
	KUNIT_CASE_PARAM(hours_test, hours_gen_params),
	KUNIT_CASE_PARAM(frame_errors_test, frame_errors_gen_params),
	KUNIT_CASE(errors_test),
	KUNIT_CASE(other_type_test),
	KUNIT_CASE_PARAM(text_test, text_gen_params),
	KUNIT_CASE(text_long_test),
	KUNIT_CASE(names_test),
	{}
};

static struct kunit_suite xy3_content_suite = {
	.name = "xy3_content",
	.test_cases = xy3_content_cases,
};

kunit_test_suite(xy3_content_suite);

MODULE_DESCRIPTION("KUnit tests of what XY3-100 packets say");
MODULE_LICENSE("GPL");
