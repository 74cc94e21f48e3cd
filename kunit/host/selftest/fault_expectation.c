// SPDX-License-Identifier: GPL-2.0-only
/* Planted: one expectation fails, in the middle of parameters that hold. */
#include <kunit/test.h>

static const struct row { const char *name; int value; } rows[] = { { "one", 1 }, { "two", 3 } };
KUNIT_ARRAY_PARAM_DESC(rows, rows, name);

static void good(struct kunit *test)
{
	KUNIT_SUCCEED(test);
}

static void bad(struct kunit *test)
{
	const struct row *row = test->param_value;

	KUNIT_EXPECT_LT_MSG(test, row->value, 3, "planted in row %s", row->name);
}

static struct kunit_case cases[] = { KUNIT_CASE(good), KUNIT_CASE_PARAM(bad, rows_gen_params), {} };
static struct kunit_suite suite = { .name = "planted_expectation", .test_cases = cases };
kunit_test_suite(suite);
