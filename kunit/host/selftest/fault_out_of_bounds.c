// SPDX-License-Identifier: GPL-2.0-only
/* Planted: reads one byte beyond memory of the case, which ASan must detect. */
#include <kunit/test.h>

static void bad(struct kunit *test)
{
	const volatile u8 *bytes = kunit_kzalloc(test, 6, GFP_KERNEL);
	volatile unsigned int past = 6;

	KUNIT_EXPECT_GE(test, bytes[past], 0);
}

static struct kunit_case cases[] = { KUNIT_CASE(bad), {} };
static struct kunit_suite suite = { .name = "planted_out_of_bounds", .test_cases = cases };
kunit_test_suite(suite);
