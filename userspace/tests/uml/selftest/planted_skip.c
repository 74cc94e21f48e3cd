// SPDX-License-Identifier: GPL-2.0-only
/* A case that does not run. */
#include <kunit/test.h>
#include <linux/module.h>

static void runs(struct kunit *test)
{
	KUNIT_SUCCEED(test);
}

static void does_not_run(struct kunit *test)
{
	kunit_skip(test, "on purpose");
}

static struct kunit_case cases[] = {
	KUNIT_CASE(runs),
	KUNIT_CASE(does_not_run),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_skip",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a skipped case");
MODULE_LICENSE("GPL");
