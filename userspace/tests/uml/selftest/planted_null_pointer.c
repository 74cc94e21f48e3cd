// SPDX-License-Identifier: GPL-2.0-only
/* A write through a null pointer, outside of KUnit's threads: the kernel crashes. */
#include <kunit/test.h>
#include <linux/module.h>
#include <linux/workqueue.h>

static int *nowhere;

static void write_nowhere(struct work_struct *work)
{
	WRITE_ONCE(*nowhere, 1);
}

static void null_pointer(struct kunit *test)
{
	struct work_struct work;

	INIT_WORK_ONSTACK(&work, write_nowhere);
	schedule_work(&work);
	flush_work(&work);
	destroy_work_on_stack(&work);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(null_pointer),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_null_pointer",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a kernel crash");
MODULE_LICENSE("GPL");
