// SPDX-License-Identifier: GPL-2.0-only
/* An expectation that does not hold. */
#include <kunit/test.h>
#include <linux/module.h>

static void holds(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, 1 + 1, 2);
}

static void does_not_hold(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, 1 + 1, 3);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(holds),
	KUNIT_CASE(does_not_hold),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_failure",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a failing case");
MODULE_LICENSE("GPL");
