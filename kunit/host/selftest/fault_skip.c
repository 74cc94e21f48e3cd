// SPDX-License-Identifier: GPL-2.0-only
/* Planted: a case that skips itself; a test that cannot run is a failure. */
#include <kunit/test.h>

static void bad(struct kunit *test)
{
	kunit_skip(test, "planted");
}

static struct kunit_case cases[] = { KUNIT_CASE(bad), {} };
static struct kunit_suite suite = { .name = "planted_skip", .test_cases = cases };
kunit_test_suite(suite);
