// SPDX-License-Identifier: GPL-2.0-only
/* Allocations without a reference. */
#include <kunit/test.h>
#include <linux/module.h>
#include <linux/slab.h>

static noinline void lose(void)
{
	void *p = kzalloc(200, GFP_KERNEL);

	OPTIMIZER_HIDE_VAR(p);
}

static void leak(struct kunit *test)
{
	int i;

	/* several: a stale register or stack slot may still point to one */
	for (i = 0; i < 10; i++)
		lose();
}

static struct kunit_case cases[] = {
	KUNIT_CASE(leak),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_leak",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a memory leak");
MODULE_LICENSE("GPL");
