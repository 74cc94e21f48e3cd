// SPDX-License-Identifier: GPL-2.0-only
/* Planted: a failed assertion must exit the case immediately, and be counted. */
#include <kunit/test.h>

static void bad(struct kunit *test)
{
	int *nowhere = NULL;

	KUNIT_ASSERT_NOT_NULL(test, nowhere);
	*nowhere = 1;
}

static struct kunit_case cases[] = { KUNIT_CASE(bad), {} };
static struct kunit_suite suite = { .name = "planted_assertion", .test_cases = cases };
kunit_test_suite(suite);
