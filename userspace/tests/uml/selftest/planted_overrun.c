// SPDX-License-Identifier: GPL-2.0-only
/* A read of one byte beyond an allocation. */
#include <kunit/test.h>
#include <linux/module.h>
#include <linux/slab.h>

static void overrun(struct kunit *test)
{
	u8 *p = kmalloc(6, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, p);
	OPTIMIZER_HIDE_VAR(p);	/* the compiler would warn */
	READ_ONCE(p[6]);
	kfree(p);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(overrun),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_overrun",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a read beyond an allocation");
MODULE_LICENSE("GPL");
