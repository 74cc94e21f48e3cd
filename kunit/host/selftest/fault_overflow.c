// SPDX-License-Identifier: GPL-2.0-only
/* Planted: a signed overflow, which UBSan must detect. */
#include <kunit/test.h>

static void bad(struct kunit *test)
{
	volatile int big = INT_MAX;

	KUNIT_EXPECT_NE(test, big + 1, 0);
}

static struct kunit_case cases[] = { KUNIT_CASE(bad), {} };
static struct kunit_suite suite = { .name = "planted_overflow", .test_cases = cases };
kunit_test_suite(suite);
