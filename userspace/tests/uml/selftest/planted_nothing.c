// SPDX-License-Identifier: GPL-2.0-only
/* The control: a correct suite, which the verdict must accept. */
#include <kunit/test.h>
#include <linux/module.h>
#include <linux/slab.h>

static void allocates_and_frees(struct kunit *test)
{
	u8 *p = kmalloc(64, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, p);
	p[63] = 1;
	KUNIT_EXPECT_EQ(test, p[63], 1);
	kfree(p);
}

static const int numbers[] = { 1, 2, 3 };

static void number_name(const int *number, char *name)
{
	snprintf(name, KUNIT_PARAM_DESC_SIZE, "number %d", *number);
}

KUNIT_ARRAY_PARAM(numbers, numbers, number_name);

static void has_rows(struct kunit *test)
{
	const int *number = test->param_value;

	KUNIT_EXPECT_GT(test, *number, 0);
}

static struct kunit_case cases[] = {
	KUNIT_CASE(allocates_and_frees),
	KUNIT_CASE_PARAM(has_rows, numbers_gen_params),
	{}
};

static struct kunit_suite suite = {
	.name = "planted_nothing",
	.test_cases = cases,
};

kunit_test_suite(suite);

MODULE_DESCRIPTION("a good suite");
MODULE_LICENSE("GPL");
