// SPDX-License-Identifier: GPL-2.0-only
/* Two locks taken in both orders: a deadlock between two threads, but not in this one. */
#include <kunit/test.h>
#include <linux/module.h>
#include <linux/mutex.h>

static DEFINE_MUTEX(first);
static DEFINE_MUTEX(second);

static void lock_order(struct kunit *test)
{
	mutex_lock(&first);
	mutex_lock(&second);
	mutex_unlock(&second);
	mutex_unlock(&first);

	mutex_lock(&second);
	mutex_lock(&first);
	mutex_unlock(&first);
	mutex_unlock(&second);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(lock_order),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_lock_order",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a lock order inversion");
MODULE_LICENSE("GPL");
