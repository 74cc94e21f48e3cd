// SPDX-License-Identifier: GPL-2.0-only
/* Decimal text: every number of up to 9.9999 there and back, and every rounding of six decimals. */
#include <math.h>

#include "../../../../drivers/hid-xhc/xhc-codec.c"
#include "pendant.h"

#define MOST	99999

/* The shortest decimal text, by removing zeros from a long one. */
static void shortest(long long units, char *text, size_t size)
{
	size_t len;

	scnprintf(text, size, "%s%lld.%04lld", units < 0 ? "-" : "",
		  llabs(units) / 10000, llabs(units) % 10000);
	len = strlen(text);
	while (text[len - 1] == '0')
		len--;
	if (text[len - 1] == '.')
		len--;
	text[len] = '\0';
}

static void expect_units(struct kunit *test, const char *text, long long units)
{
	s32 got = 0x5a5a5a5a;

	KUNIT_ASSERT_EQ_MSG(test, xhc_parse_position(pendant_model(test), text, &got), 0,
			    "\"%s\"", text);
	KUNIT_ASSERT_EQ_MSG(test, got, units, "\"%s\"", text);
}

static void there_and_back(struct kunit *test)
{
	const struct pendant *p = test->param_value;

	for (long long units = -MOST; units <= MOST; units++) {
		char want[32], got[XHC_POSITION_TEXT];

		shortest(units, want, sizeof(want));
		KUNIT_ASSERT_EQ(test, xhc_format_position(units, got, sizeof(got)), strlen(want));
		KUNIT_ASSERT_STREQ(test, got, want);
		expect_units(test, got, llround((double)units / p->units_shown) * p->units_shown);
	}
}

/* Half away from zero, from the text: 0.004999 is not rounded twice. */
static void six_decimals(struct kunit *test)
{
	const struct pendant *p = test->param_value;

	for (long long millionths = -2 * MOST; millionths <= 2 * MOST; millionths++) {
		long long shown = llround((double)millionths / (p->units_shown * 100));
		char text[32];

		scnprintf(text, sizeof(text), "%s%lld.%06lld", millionths < 0 ? "-" : "",
			  llabs(millionths) / 1000000, llabs(millionths) % 1000000);
		expect_units(test, text, shown * p->units_shown);
	}
}

static void every_integer(struct kunit *test)
{
	for (long long i = -70000; i <= 70000; i++) {
		char text[32];
		s32 units = 1;
		int ret;

		scnprintf(text, sizeof(text), "%lld", i);
		ret = xhc_parse_position(pendant_model(test), text, &units);
		KUNIT_ASSERT_EQ_MSG(test, ret, llabs(i) > 65535 ? -ERANGE : 0, "%s", text);
		KUNIT_ASSERT_EQ_MSG(test, units, ret ? 1 : i * 10000, "%s", text);
	}
}

/* Any byte at any position of a good number: a number, or refused, never misread. */
static void every_stray_byte(struct kunit *test)
{
	static const char good[] = "-12.75";

	for (size_t at = 0; at < sizeof(good); at++)
		for (int byte = 1; byte < 256; byte++) {
			bool blank = isspace(byte) && (at == 0 || at == strlen(good));
			bool digit = byte >= '0' && byte <= '9' && at > 0;
			s32 units = 1;
			char *text;
			int ret;

			text = kunit_kzalloc(test, sizeof(good) + 1, GFP_KERNEL);
			KUNIT_ASSERT_NOT_NULL(test, text);
			memcpy(text, good, at);
			text[at] = byte;
			memcpy(text + at + 1, good + at, sizeof(good) - at);

			ret = xhc_parse_position(pendant_model(test), text, &units);
			KUNIT_ASSERT_EQ_MSG(test, ret, blank || digit ? 0 : -EINVAL,
					    "\"%s\"", text);
			if (blank)
				KUNIT_ASSERT_EQ(test, units, -127500);
			kunit_kfree(test, text);
		}
}

static struct kunit_case cases[] = {
	KUNIT_CASE_PARAM(there_and_back, pendants_gen_params),
	KUNIT_CASE_PARAM(six_decimals, pendants_gen_params),
	KUNIT_CASE_PARAM(every_integer, pendants_gen_params),
	KUNIT_CASE_PARAM(every_stray_byte, pendants_gen_params),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_texts", .test_cases = cases };
kunit_test_suite(suite);
