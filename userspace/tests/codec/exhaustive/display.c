// SPDX-License-Identifier: GPL-2.0-only
/* Display frame: every value of each field except coordinates; the words for step and state. */
#include "../../../../drivers/hid-xhc/xhc-codec.c"
#include "pendant.h"

/* Build a frame in memory of its exact size. */
static u8 *encode(struct kunit *test, const struct xhc_display *display)
{
	const struct pendant *p = test->param_value;
	u8 *payload = kunit_kmalloc(test, p->frame_size, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, payload);
	KUNIT_ASSERT_EQ(test, xhc_encode_payload(pendant_model(test), display, payload),
			p->frame_size);
	KUNIT_ASSERT_EQ(test, payload[0], 0xfe);
	KUNIT_ASSERT_EQ(test, payload[1], 0xfd);
	return payload;
}

static void every_day(struct kunit *test)
{
	const struct pendant *p = test->param_value;
	struct xhc_display display = {};
	u8 any[XHC_PAYLOAD_MAX];

	for (int day = 0; day < 256; day++) {
		display.day = day;
		if (day >= 1 && day <= 31)
			KUNIT_ASSERT_EQ(test, encode(test, &display)[p->day_at], day);
		else
			KUNIT_ASSERT_EQ(test, -EINVAL,
					xhc_encode_payload(pendant_model(test), &display, any));
	}
}

static void every_number(struct kunit *test)
{
	const struct pendant *p = test->param_value;

	for (u32 value = 0; value <= 65535; value++) {
		struct xhc_display display = { .day = 1 };
		u8 *payload;

		for (int i = 0; i < 4; i++)
			display.number[i] = value ^ (0x1111 * i);
		payload = encode(test, &display);
		for (int i = 0; i < 4; i++) {
			const u8 *at = payload + p->number_at[i];

			KUNIT_ASSERT_EQ(test, at[0] + 256 * at[1], value ^ (0x1111 * i));
		}
		kunit_kfree(test, payload);
	}
}

static void every_step_and_icon_and_state(struct kunit *test)
{
	const struct pendant *p = test->param_value;

	for (int value = 0; value < 256; value++) {
		struct xhc_display display = {
			.day = 31, .step = value % 16, .icon = value / 16, .state = 255 - value,
		};
		u8 *payload = encode(test, &display);

		KUNIT_ASSERT_EQ(test, payload[p->step_at], value);
		KUNIT_ASSERT_EQ(test, payload[p->state_at], 255 - value);
	}
}

/* The chunks, when joined, are the frame, then zeros. */
static void every_chunk(struct kunit *test)
{
	const struct pendant *p = test->param_value;
	const struct xhc_display display = { .day = 9, .position = { -1, 2, -3, 4, -5, 6 },
					     .number = { 1, 2, 3, 4 }, .step = 10, .state = 0x81 };
	u8 *payload = encode(test, &display);
	unsigned int chunks = pendant_model(test)->chunks;

	KUNIT_ASSERT_EQ(test, chunks, p->decimals == 2 ? 5 : 6);
	for (unsigned int i = 0; i < chunks; i++) {
		u8 *report = kunit_kmalloc(test, 8, GFP_KERNEL);

		KUNIT_ASSERT_NOT_NULL(test, report);
		xhc_encode_chunk(payload, p->frame_size, i, report);
		KUNIT_ASSERT_EQ(test, report[0], 0x06);
		for (size_t b = 0; b < 7; b++) {
			size_t at = 7 * i + b;

			KUNIT_ASSERT_EQ(test, report[1 + b], at < p->frame_size ? payload[at] : 0);
		}
	}
}

static void every_step_code(struct kunit *test)
{
	static const int table[] = { 0, 1, 5, 10, 20, 30, 40, 50, 100, 500, 1000 };

	for (int code = 0; code < 256; code++)
		KUNIT_ASSERT_EQ(test, xhc_step_multiplier(code),
				code <= 10 ? table[code] : -ERANGE);
	for (int multiplier = 0; multiplier <= 70000; multiplier++) {
		int want = -ERANGE;

		for (int code = 0; code <= 10; code++)
			if (table[code] == multiplier)
				want = code;
		KUNIT_ASSERT_EQ(test, xhc_step_code(multiplier), want);
	}
}

static void expect_state(struct kunit *test, const char *text, int state)
{
	u8 got = ~state;

	KUNIT_ASSERT_EQ_MSG(test, xhc_parse_state(pendant_model(test), text, &got), 0,
			    "\"%s\"", text);
	KUNIT_ASSERT_EQ_MSG(test, got, state, "\"%s\"", text);
}

static void every_state(struct kunit *test)
{
	const struct pendant *p = test->param_value;
	bool inch = p->product == 0xeb70;

	for (int state = 0; state < 256; state++) {
		int rest = state & (inch ? 0x7c : 0xfc);
		char want[64] = "", number[16], got[XHC_STATE_TEXT];

		scnprintf(number, sizeof(number), "0x%02x", rest);
		if (state & 0x01)
			strcat(want, "+run");
		if (state & 0x02)
			strcat(want, "+pause");
		if (state & 0x80 && inch)
			strcat(want, "+inch");
		if (rest)
			strcat(strcat(want, "+"), number);
		if (!state)
			strcat(want, "+idle");

		KUNIT_ASSERT_EQ(test, strlen(want + 1),
				xhc_format_state(pendant_model(test), state, got, sizeof(got)));
		KUNIT_ASSERT_STREQ(test, got, want + 1);
		expect_state(test, got, state);

		scnprintf(number, sizeof(number), "%d", state);
		expect_state(test, number, state);
		scnprintf(number, sizeof(number), "0x%x\n", state);
		expect_state(test, number, state);
	}
}

static struct kunit_case cases[] = {
	KUNIT_CASE_PARAM(every_day, pendants_gen_params),
	KUNIT_CASE_PARAM(every_number, pendants_gen_params),
	KUNIT_CASE_PARAM(every_step_and_icon_and_state, pendants_gen_params),
	KUNIT_CASE_PARAM(every_chunk, pendants_gen_params),
	KUNIT_CASE(every_step_code),
	KUNIT_CASE_PARAM(every_state, pendants_gen_params),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_display", .test_cases = cases };
kunit_test_suite(suite);
