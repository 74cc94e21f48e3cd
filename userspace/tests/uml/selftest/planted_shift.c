// SPDX-License-Identifier: GPL-2.0-only
/* A shift by more than the width of the type. */
#include <kunit/test.h>
#include <linux/module.h>

static void shift(struct kunit *test)
{
	int bits = 33;

	OPTIMIZER_HIDE_VAR(bits);
	KUNIT_EXPECT_NE(test, 1 << bits, 0);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(shift),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_shift",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("undefined behaviour");
MODULE_LICENSE("GPL");
