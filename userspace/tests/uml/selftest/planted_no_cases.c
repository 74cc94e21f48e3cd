// SPDX-License-Identifier: GPL-2.0-only
/* A suite without cases. */
#include <kunit/test.h>
#include <linux/module.h>

static struct kunit_case cases[] = {
	{}
};

static struct kunit_suite suite = {
	.name = "planted_no_cases",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a suite without a case");
MODULE_LICENSE("GPL");
