// SPDX-License-Identifier: GPL-2.0-only
/*
 * The shim against the documented behaviour of the kernel: a codec that uses it must get the same
 * results in both.
 */
#include <kunit/test.h>
#include <linux/bitfield.h>
#include <linux/math64.h>
#include <linux/unaligned.h>

struct number_row {
	const char *name;
	const char *text;
	unsigned int base;
	int ret;
	int value;
};

static const struct number_row int_rows[] = {
	{ "plain", "42", 10, 0, 42 },
	{ "newline", "42\n", 10, 0, 42 },
	{ "plus", "+42", 10, 0, 42 },
	{ "minus", "-42", 10, 0, -42 },
	{ "smallest", "-2147483648", 10, 0, -2147483647 - 1 },
	{ "hex", "0x40", 0, 0, 64 },
	{ "hex, base given", "0x40", 16, 0, 64 },
	{ "octal", "010", 0, 0, 8 },
	{ "empty", "", 10, -EINVAL, 0 },
	{ "newline only", "\n", 10, -EINVAL, 0 },
	{ "two newlines", "1\n\n", 10, -EINVAL, 0 },
	{ "leading blank", " 1", 10, -EINVAL, 0 },
	{ "trailing junk", "1x", 10, -EINVAL, 0 },
	{ "two signs", "-+1", 10, -EINVAL, 0 },
	{ "bare 0x", "0x", 0, -EINVAL, 0 },
	{ "one too big", "2147483648", 10, -ERANGE, 0 },
	{ "too big for 64 bits, junk behind", "99999999999999999999x", 10, -ERANGE, 0 },
};

KUNIT_ARRAY_PARAM_DESC(int_rows, int_rows, name);

static void kstrtoint_is_the_kernels(struct kunit *test)
{
	const struct number_row *row = test->param_value;
	int value = 0;

	KUNIT_EXPECT_EQ(test, kstrtoint(row->text, row->base, &value), row->ret);
	KUNIT_EXPECT_EQ(test, value, row->value);
}

static void narrow_numbers(struct kunit *test)
{
	unsigned int u = 7;
	u16 u16_value;
	bool yes;
	u8 u8_value;
	s8 s8_value;

	KUNIT_EXPECT_EQ(test, kstrtouint("-1", 10, &u), -EINVAL);
	KUNIT_EXPECT_EQ(test, u, 7);
	KUNIT_EXPECT_EQ(test, kstrtouint("4294967295", 10, &u), 0);
	KUNIT_EXPECT_EQ(test, u, U32_MAX);
	KUNIT_EXPECT_EQ(test, kstrtou8("256", 10, &u8_value), -ERANGE);
	KUNIT_EXPECT_EQ(test, kstrtou8("255", 10, &u8_value), 0);
	KUNIT_EXPECT_EQ(test, kstrtou16("65536", 10, &u16_value), -ERANGE);
	KUNIT_EXPECT_EQ(test, kstrtos8("-129", 10, &s8_value), -ERANGE);
	KUNIT_EXPECT_EQ(test, kstrtobool("maybe", &yes), -EINVAL);
	KUNIT_EXPECT_EQ(test, kstrtobool("on", &yes), 0);
	KUNIT_EXPECT_TRUE(test, yes);
}

static void texts(struct kunit *test)
{
	char small[4];

	KUNIT_EXPECT_EQ(test, strscpy(small, "abc", sizeof(small)), 3);
	KUNIT_EXPECT_EQ(test, strscpy(small, "abcd", sizeof(small)), -E2BIG);
	KUNIT_EXPECT_STREQ(test, small, "abc");
	KUNIT_EXPECT_EQ(test, scnprintf(small, sizeof(small), "%d", 12345), 3);
	KUNIT_EXPECT_STREQ(test, small, "123");
	KUNIT_EXPECT_STREQ(test, skip_spaces(" \t\n x "), "x ");
	KUNIT_EXPECT_TRUE(test, sysfs_streq("run\n", "run"));
	KUNIT_EXPECT_FALSE(test, sysfs_streq("run ", "run"));
	KUNIT_EXPECT_FALSE(test, sysfs_streq("run\n\n", "run"));
	KUNIT_EXPECT_EQ(test, str_has_prefix("0x40", "0x"), 2);
	KUNIT_EXPECT_EQ(test, str_has_prefix("0", "0x"), 0);
	KUNIT_EXPECT_NULL(test, memchr_inv("\0\0", 0, 2));
	KUNIT_EXPECT_NOT_NULL(test, memchr_inv("\0\1", 0, 2));
}

static void arithmetic(struct kunit *test)
{
	u8 bytes[4] = { 1, 2, 3, 4 };

	KUNIT_EXPECT_EQ(test, get_unaligned_le16(bytes + 1), 0x0302);
	KUNIT_EXPECT_EQ(test, get_unaligned_be32(bytes), 0x01020304);
	put_unaligned_be16(0xabcd, bytes);
	put_unaligned_le16(0xabcd, bytes + 2);
	KUNIT_EXPECT_MEMEQ(test, bytes, ((const u8[]){ 0xab, 0xcd, 0xcd, 0xab }), sizeof(bytes));
	KUNIT_EXPECT_EQ(test, le16_to_cpu(cpu_to_le16(0x1234)), 0x1234);
	KUNIT_EXPECT_EQ(test, FIELD_PREP(GENMASK(7, 4), 0x1f), 0xf0);
	KUNIT_EXPECT_EQ(test, FIELD_GET(GENMASK(7, 4), 0xa5), 0x0a);
	KUNIT_EXPECT_EQ(test, DIV_ROUND_UP(31, 7), 5);
	KUNIT_EXPECT_EQ(test, DIV_ROUND_CLOSEST(-15, 10), -2);
	KUNIT_EXPECT_EQ(test, div_s64(-7, 2), -3);
	KUNIT_EXPECT_EQ(test, abs(-5LL), 5);
	KUNIT_EXPECT_EQ(test, clamp(12, 0, 10), 10);
}

static int own_memory_init(struct kunit *test)
{
	test->priv = kunit_kzalloc(test, 3, GFP_KERNEL);
	KUNIT_ASSERT_NOT_NULL(test, test->priv);
	return 0;
}

static void memory_is_there(struct kunit *test)
{
	KUNIT_EXPECT_MEMEQ(test, test->priv, "\0\0", 3);
	kunit_kfree(test, kunit_kmalloc(test, 1, GFP_KERNEL));
}

static struct kunit_case shim_cases[] = {
	KUNIT_CASE_PARAM(kstrtoint_is_the_kernels, int_rows_gen_params),
	KUNIT_CASE(narrow_numbers),
	KUNIT_CASE(texts),
	KUNIT_CASE(arithmetic),
	KUNIT_CASE(memory_is_there),
	{}
};

static struct kunit_suite shim_suite = {
	.name = "host_shim",
	.init = own_memory_init,
	.test_cases = shim_cases,
};

kunit_test_suite(shim_suite);
