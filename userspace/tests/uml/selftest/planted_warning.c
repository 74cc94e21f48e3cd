// SPDX-License-Identifier: GPL-2.0-only
/* A WARN_ON. */
#include <kunit/test.h>
#include <linux/module.h>

static void warning(struct kunit *test)
{
	WARN_ON(test);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(warning),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_warning",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a kernel warning");
MODULE_LICENSE("GPL");
