// SPDX-License-Identifier: GPL-2.0-only
/*
 * Coordinates on the wire: every fraction with either sign and a few integers, every integer with a
 * few fractions. The reference rounds in floating point, unlike the driver.
 */
#include <math.h>

#include "../../../../drivers/hid-xhc/xhc-codec.c"
#include "pendant.h"

static const long long integers[] = { 0, 1, 9, 255, 256, 32767, 32768, 65534, 65535 };
static const long long fractions[] = { 0, 1, 49, 50, 51, 4999, 5000, 9899, 9949, 9950, 9999 };

/* The bytes of one coordinate on the wire as in the document; false: out of range. */
static bool reference(const struct pendant *p, long long units, u8 *bytes)
{
	long long shown = llround((double)units / p->units_shown);
	long long scale = llround(pow(10, p->decimals));
	long long integer = llabs(shown) / scale;
	long long fraction = llabs(shown) % scale;

	if (integer > 65535)
		return false;
	bytes[0] = integer & 255;
	bytes[1] = integer / 256;
	if (p->decimals == 2) {
		bytes[2] = fraction + (shown < 0 ? 128 : 0);
	} else {
		fraction += shown < 0 ? 32768 : 0;
		bytes[2] = fraction & 255;
		bytes[3] = fraction / 256;
	}
	return true;
}

static void check(struct kunit *test, long long units, unsigned int slot)
{
	const struct pendant *p = test->param_value;
	struct xhc_display display = { .day = 1 };
	u8 payload[XHC_PAYLOAD_MAX];
	u8 bytes[4];
	int ret;

	display.position[slot] = units;
	ret = xhc_encode_payload(pendant_model(test), &display, payload);
	if (!reference(p, units, bytes)) {
		KUNIT_ASSERT_EQ_MSG(test, ret, -ERANGE, "units %lld", units);
		return;
	}
	KUNIT_ASSERT_EQ_MSG(test, ret, p->frame_size, "units %lld", units);
	KUNIT_ASSERT_MEMEQ_MSG(test, payload + p->position_at[slot], bytes,
			       p->decimals == 2 ? 3 : 4, "units %lld in slot %u", units, slot);
}

static void every_fraction(struct kunit *test)
{
	for (size_t i = 0; i < ARRAY_SIZE(integers); i++)
		for (long long f = 0; f < 10000; f++) {
			check(test, integers[i] * 10000 + f, i % 6);
			check(test, -(integers[i] * 10000 + f), (i + 1) % 6);
		}
}

static void every_integer(struct kunit *test)
{
	for (long long i = 0; i <= 65535; i++)
		for (size_t f = 0; f < ARRAY_SIZE(fractions); f++) {
			check(test, i * 10000 + fractions[f], f % 6);
			check(test, -(i * 10000 + fractions[f]), (f + 1) % 6);
		}
}

static void beyond_the_wire(struct kunit *test)
{
	static const long long units[] = { 655360000, 655370000, S32_MAX - 1, S32_MAX };

	for (size_t i = 0; i < ARRAY_SIZE(units); i++) {
		check(test, units[i], 0);
		check(test, -units[i], 5);
	}
	check(test, S32_MIN, 3);
}

/* Of all values of the bytes of a fraction, exactly the legal ones occur. */
static void every_fraction_word(struct kunit *test)
{
	const struct pendant *p = test->param_value;
	size_t words = p->decimals == 2 ? 256 : 65536;
	bool *seen = kunit_kzalloc(test, words * sizeof(*seen), GFP_KERNEL);
	u32 limit = p->decimals == 2 ? 100 : 10000;
	u8 payload[XHC_PAYLOAD_MAX];

	KUNIT_ASSERT_NOT_NULL(test, seen);
	for (s32 units = -29999; units <= 29999; units++) {
		struct xhc_display display = { .day = 1, .position = { units } };
		const u8 *at = payload + p->position_at[0] + 2;

		KUNIT_ASSERT_EQ(test, p->frame_size,
				xhc_encode_payload(pendant_model(test), &display, payload));
		seen[p->decimals == 2 ? at[0] : at[0] + 256 * at[1]] = true;
	}
	for (u32 word = 0; word < words; word++)
		KUNIT_ASSERT_EQ_MSG(test, seen[word], word % (words / 2) < limit, "word %#x", word);
}

static struct kunit_case cases[] = {
	KUNIT_CASE_PARAM(every_fraction, pendants_gen_params),
	KUNIT_CASE_PARAM(every_integer, pendants_gen_params),
	KUNIT_CASE_PARAM(beyond_the_wire, pendants_gen_params),
	KUNIT_CASE_PARAM(every_fraction_word, pendants_gen_params),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_positions", .test_cases = cases };
kunit_test_suite(suite);
