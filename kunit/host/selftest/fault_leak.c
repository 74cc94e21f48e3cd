// SPDX-License-Identifier: GPL-2.0-only
/* Planted: memory that is not freed. */
#include <kunit/test.h>

static void *volatile lost;

static void bad(struct kunit *test)
{
	lost = kmalloc(6, GFP_KERNEL);
	KUNIT_EXPECT_NOT_NULL(test, lost);
	lost = NULL;
}

static struct kunit_case cases[] = { KUNIT_CASE(bad), {} };
static struct kunit_suite suite = { .name = "planted_leak", .test_cases = cases };
kunit_test_suite(suite);
