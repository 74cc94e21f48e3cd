// SPDX-License-Identifier: GPL-2.0-only
/* Memory used after it was freed, in a thread that KUnit does not check: its cases are ok. */
#include <kunit/test.h>
#include <linux/module.h>
#include <linux/slab.h>
#include <linux/workqueue.h>

static u8 *stale;

static void read_stale(struct work_struct *work)
{
	READ_ONCE(stale[5]);
}

static void use_after_free(struct kunit *test)
{
	struct work_struct work;

	stale = kmalloc(64, GFP_KERNEL);
	KUNIT_ASSERT_NOT_NULL(test, stale);
	kfree(stale);
	INIT_WORK_ONSTACK(&work, read_stale);
	schedule_work(&work);
	flush_work(&work);
	destroy_work_on_stack(&work);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(use_after_free),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_use_after_free",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("use after free in a worker");
MODULE_LICENSE("GPL");
