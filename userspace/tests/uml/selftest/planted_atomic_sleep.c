// SPDX-License-Identifier: GPL-2.0-only
/* An allocation that may sleep, under a spinlock. */
#include <kunit/test.h>
#include <linux/module.h>
#include <linux/slab.h>
#include <linux/spinlock.h>

static DEFINE_SPINLOCK(lock);

static void atomic_sleep(struct kunit *test)
{
	void *p;

	spin_lock(&lock);
	p = kmalloc(16, GFP_KERNEL);
	spin_unlock(&lock);
	kfree(p);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(atomic_sleep),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_atomic_sleep",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a sleep under a spinlock");
MODULE_LICENSE("GPL");
