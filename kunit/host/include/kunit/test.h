/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * KUnit for user space: the part of the kernel's <kunit/test.h> that suites of pure code use.
 *
 * The same test source runs in the kernel (check-kunit) and here (check-host). Names and meaning
 * are those of the kernel header; host/kunit.c has main() and prints KTAP.
 */
#ifndef HOST_KUNIT_TEST_H
#define HOST_KUNIT_TEST_H

#include <setjmp.h>
#include <linux/err.h>
#include <linux/kernel.h>
#include <linux/module.h>
#include <linux/slab.h>
#include <linux/string.h>
#include <linux/types.h>

#define KUNIT_PARAM_DESC_SIZE	128

enum kunit_status { KUNIT_SUCCESS, KUNIT_FAILURE, KUNIT_SKIPPED };

struct kunit_allocation;

struct kunit {
	void *priv;
	const void *param_value;
	int param_index;
	const char *name;
	/* private to the runner */
	enum kunit_status status;
	char status_comment[256];
	jmp_buf abort;
	struct kunit_allocation *allocations;
};

struct kunit_case {
	void (*run_case)(struct kunit *test);
	const char *name;
	const void *(*generate_params)(const void *prev, char *desc);
};

struct kunit_suite {
	const char name[256];
	int (*suite_init)(struct kunit_suite *suite);
	void (*suite_exit)(struct kunit_suite *suite);
	int (*init)(struct kunit *test);
	void (*exit)(struct kunit *test);
	struct kunit_case *test_cases;
};

#define KUNIT_CASE(test_name)	{ .run_case = test_name, .name = #test_name }
#define KUNIT_CASE_SLOW(test_name)	KUNIT_CASE(test_name)
#define KUNIT_CASE_PARAM(test_name, gen_params) \
	{ .run_case = test_name, .name = #test_name, .generate_params = gen_params }

/* One list of suites per program, for kunit.c. */
#define kunit_test_suites(...) \
	struct kunit_suite * const kunit_suites[] = { __VA_ARGS__, NULL }
#define kunit_test_suite(suite)	kunit_test_suites(&suite)

extern struct kunit_suite * const kunit_suites[];

#define KUNIT_GENERATOR(name, array, describe)						\
	static const void *name##_gen_params(const void *prev, char *desc)		\
	{										\
		const typeof((array)[0]) *next_ = prev;					\
											\
		next_ = next_ ? next_ + 1 : (array);					\
		if (next_ - (array) >= (ptrdiff_t)ARRAY_SIZE(array))			\
			return NULL;							\
		describe;								\
		return next_;								\
	}

#define KUNIT_ARRAY_PARAM(name, array, get_desc)					\
	KUNIT_GENERATOR(name, array, do {						\
		void (*get_desc_)(typeof(next_), char *) = get_desc;			\
											\
		if (get_desc_)								\
			get_desc_(next_, desc);						\
	} while (0))

#define KUNIT_ARRAY_PARAM_DESC(name, array, desc_member)				\
	KUNIT_GENERATOR(name, array,							\
			strscpy(desc, next_->desc_member, KUNIT_PARAM_DESC_SIZE))

/* Memory that is freed after the case; the size is exact, so that ASan detects reads beyond it. */
void *kunit_kmalloc(struct kunit *test, size_t size, gfp_t gfp);
void *kunit_kzalloc(struct kunit *test, size_t size, gfp_t gfp);
void *kunit_kcalloc(struct kunit *test, size_t n, size_t size, gfp_t gfp);
void kunit_kfree(struct kunit *test, const void *ptr);

__printf(3, 4) void kunit_log_line(struct kunit *test, const char *level, const char *fmt, ...);

#define kunit_info(test, fmt, ...)	kunit_log_line(test, "", fmt, ##__VA_ARGS__)
#define kunit_warn(test, fmt, ...)	kunit_log_line(test, "warning: ", fmt, ##__VA_ARGS__)
#define kunit_err(test, fmt, ...)	kunit_log_line(test, "error: ", fmt, ##__VA_ARGS__)

#define kunit_mark_skipped(test, fmt, ...) do {						\
	struct kunit *skipped_ = (test);						\
											\
	skipped_->status = KUNIT_SKIPPED;						\
	scnprintf(skipped_->status_comment, sizeof(skipped_->status_comment), fmt,	\
		  ##__VA_ARGS__);							\
} while (0)
#define kunit_skip(test, fmt, ...) do {							\
	kunit_mark_skipped(test, fmt, ##__VA_ARGS__);					\
	longjmp((test)->abort, 1);							\
} while (0)

/* Called by every failed expectation; an assertion also exits the case. */
struct kunit_place {
	const char *file;
	int line;
	bool fatal;
};

#define KUNIT_PLACE(fatal)	(&(const struct kunit_place){ __FILE__, __LINE__, fatal })

__printf(3, 4)
void kunit_failed(struct kunit *test, const struct kunit_place *place, const char *fmt, ...);
void kunit_values(struct kunit *test, const char *left, long long l,
		  const char *right, long long r);
void kunit_strings(struct kunit *test, const char *left, const char *l,
		   const char *right, const char *r);
void kunit_bytes(struct kunit *test, const char *what, const void *bytes, size_t size);

#define KUNIT_CHECK(test, fatal, good, show, fmt, ...) do {				\
	if (!(good)) {									\
		show;									\
		kunit_failed(test, KUNIT_PLACE(fatal), fmt, ##__VA_ARGS__);		\
	}										\
} while (0)

#define KUNIT_BINARY(test, fatal, left, op, right, fmt, ...) do {			\
	const typeof(left) l_ = (left);							\
	const typeof(right) r_ = (right);						\
											\
	KUNIT_CHECK(test, fatal, l_ op r_,						\
		    kunit_values(test, #left " " #op, (long long)l_,			\
				 #right, (long long)r_), fmt, ##__VA_ARGS__);		\
} while (0)

#define KUNIT_POINTERS(test, fatal, left, op, right, fmt, ...) do {			\
	const void *l_ = (left);							\
	const void *r_ = (right);							\
											\
	KUNIT_CHECK(test, fatal, l_ op r_,						\
		    kunit_values(test, #left " " #op, (long long)(uintptr_t)l_,		\
				 #right, (long long)(uintptr_t)r_), fmt, ##__VA_ARGS__);	\
} while (0)

#define KUNIT_STRINGS(test, fatal, left, op, right, fmt, ...) do {			\
	const char *l_ = (left);							\
	const char *r_ = (right);							\
											\
	KUNIT_CHECK(test, fatal, l_ && r_ && strcmp(l_, r_) op 0,			\
		    kunit_strings(test, #left " " #op, l_, #right, r_), fmt, ##__VA_ARGS__); \
} while (0)

#define KUNIT_MEMORY(test, fatal, left, op, right, size, fmt, ...) do {			\
	const void *l_ = (left);							\
	const void *r_ = (right);							\
	const size_t size_ = (size);							\
											\
	KUNIT_CHECK(test, fatal, l_ && r_ && memcmp(l_, r_, size_) op 0,		\
		    do {								\
			kunit_bytes(test, #left, l_, size_);				\
			kunit_bytes(test, #right, r_, size_);				\
		    } while (0), fmt, ##__VA_ARGS__);					\
} while (0)

#define KUNIT_TRUTH(test, fatal, good, text, fmt, ...) \
	KUNIT_CHECK(test, fatal, good, kunit_info(test, "expected %s", text), fmt, ##__VA_ARGS__)

#define KUNIT_FAIL(test, fmt, ...) \
	kunit_failed(test, KUNIT_PLACE(false), fmt, ##__VA_ARGS__)
#define KUNIT_FAIL_AND_ABORT(test, fmt, ...) \
	kunit_failed(test, KUNIT_PLACE(true), fmt, ##__VA_ARGS__)
#define KUNIT_SUCCEED(test)	do { (void)(test); } while (0)

/* The simple forms: an expectation without a message. */
#define KUNIT_NO_MSG	"%s", ""

#define KUNIT_EXPECT_EQ(t, l, r)	KUNIT_BINARY(t, false, l, ==, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_NE(t, l, r)	KUNIT_BINARY(t, false, l, !=, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_LT(t, l, r)	KUNIT_BINARY(t, false, l, <, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_LE(t, l, r)	KUNIT_BINARY(t, false, l, <=, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_GT(t, l, r)	KUNIT_BINARY(t, false, l, >, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_GE(t, l, r)	KUNIT_BINARY(t, false, l, >=, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_EQ(t, l, r)	KUNIT_BINARY(t, true, l, ==, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_NE(t, l, r)	KUNIT_BINARY(t, true, l, !=, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_LT(t, l, r)	KUNIT_BINARY(t, true, l, <, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_LE(t, l, r)	KUNIT_BINARY(t, true, l, <=, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_GT(t, l, r)	KUNIT_BINARY(t, true, l, >, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_GE(t, l, r)	KUNIT_BINARY(t, true, l, >=, r, KUNIT_NO_MSG)

#define KUNIT_EXPECT_TRUE(t, c)		KUNIT_TRUTH(t, false, !!(c), #c, KUNIT_NO_MSG)
#define KUNIT_EXPECT_FALSE(t, c)	KUNIT_TRUTH(t, false, !(c), "not " #c, KUNIT_NO_MSG)
#define KUNIT_ASSERT_TRUE(t, c)		KUNIT_TRUTH(t, true, !!(c), #c, KUNIT_NO_MSG)
#define KUNIT_ASSERT_FALSE(t, c)	KUNIT_TRUTH(t, true, !(c), "not " #c, KUNIT_NO_MSG)

#define KUNIT_EXPECT_PTR_EQ(t, l, r)	KUNIT_POINTERS(t, false, l, ==, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_PTR_NE(t, l, r)	KUNIT_POINTERS(t, false, l, !=, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_NULL(t, p)		KUNIT_POINTERS(t, false, p, ==, NULL, KUNIT_NO_MSG)
#define KUNIT_EXPECT_NOT_NULL(t, p)	KUNIT_POINTERS(t, false, p, !=, NULL, KUNIT_NO_MSG)
#define KUNIT_ASSERT_PTR_EQ(t, l, r)	KUNIT_POINTERS(t, true, l, ==, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_PTR_NE(t, l, r)	KUNIT_POINTERS(t, true, l, !=, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_NULL(t, p)		KUNIT_POINTERS(t, true, p, ==, NULL, KUNIT_NO_MSG)
#define KUNIT_ASSERT_NOT_NULL(t, p)	KUNIT_POINTERS(t, true, p, !=, NULL, KUNIT_NO_MSG)
#define KUNIT_EXPECT_NOT_ERR_OR_NULL(t, p) \
	KUNIT_TRUTH(t, false, !IS_ERR_OR_NULL(p), #p " valid", KUNIT_NO_MSG)
#define KUNIT_ASSERT_NOT_ERR_OR_NULL(t, p) \
	KUNIT_TRUTH(t, true, !IS_ERR_OR_NULL(p), #p " valid", KUNIT_NO_MSG)

#define KUNIT_EXPECT_STREQ(t, l, r)	KUNIT_STRINGS(t, false, l, ==, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_STRNEQ(t, l, r)	KUNIT_STRINGS(t, false, l, !=, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_STREQ(t, l, r)	KUNIT_STRINGS(t, true, l, ==, r, KUNIT_NO_MSG)
#define KUNIT_ASSERT_STRNEQ(t, l, r)	KUNIT_STRINGS(t, true, l, !=, r, KUNIT_NO_MSG)
#define KUNIT_EXPECT_MEMEQ(t, l, r, n)	KUNIT_MEMORY(t, false, l, ==, r, n, KUNIT_NO_MSG)
#define KUNIT_EXPECT_MEMNEQ(t, l, r, n)	KUNIT_MEMORY(t, false, l, !=, r, n, KUNIT_NO_MSG)
#define KUNIT_ASSERT_MEMEQ(t, l, r, n)	KUNIT_MEMORY(t, true, l, ==, r, n, KUNIT_NO_MSG)
#define KUNIT_ASSERT_MEMNEQ(t, l, r, n)	KUNIT_MEMORY(t, true, l, !=, r, n, KUNIT_NO_MSG)

#define KUNIT_EXPECT_EQ_MSG(t, l, r, ...)	KUNIT_BINARY(t, false, l, ==, r, __VA_ARGS__)
#define KUNIT_EXPECT_NE_MSG(t, l, r, ...)	KUNIT_BINARY(t, false, l, !=, r, __VA_ARGS__)
#define KUNIT_EXPECT_LT_MSG(t, l, r, ...)	KUNIT_BINARY(t, false, l, <, r, __VA_ARGS__)
#define KUNIT_EXPECT_LE_MSG(t, l, r, ...)	KUNIT_BINARY(t, false, l, <=, r, __VA_ARGS__)
#define KUNIT_EXPECT_GT_MSG(t, l, r, ...)	KUNIT_BINARY(t, false, l, >, r, __VA_ARGS__)
#define KUNIT_EXPECT_GE_MSG(t, l, r, ...)	KUNIT_BINARY(t, false, l, >=, r, __VA_ARGS__)
#define KUNIT_ASSERT_EQ_MSG(t, l, r, ...)	KUNIT_BINARY(t, true, l, ==, r, __VA_ARGS__)
#define KUNIT_ASSERT_NE_MSG(t, l, r, ...)	KUNIT_BINARY(t, true, l, !=, r, __VA_ARGS__)
#define KUNIT_ASSERT_LT_MSG(t, l, r, ...)	KUNIT_BINARY(t, true, l, <, r, __VA_ARGS__)
#define KUNIT_ASSERT_LE_MSG(t, l, r, ...)	KUNIT_BINARY(t, true, l, <=, r, __VA_ARGS__)
#define KUNIT_ASSERT_GT_MSG(t, l, r, ...)	KUNIT_BINARY(t, true, l, >, r, __VA_ARGS__)
#define KUNIT_ASSERT_GE_MSG(t, l, r, ...)	KUNIT_BINARY(t, true, l, >=, r, __VA_ARGS__)
#define KUNIT_EXPECT_TRUE_MSG(t, c, ...)	KUNIT_TRUTH(t, false, !!(c), #c, __VA_ARGS__)
#define KUNIT_EXPECT_FALSE_MSG(t, c, ...)	KUNIT_TRUTH(t, false, !(c), "not " #c, __VA_ARGS__)
#define KUNIT_ASSERT_TRUE_MSG(t, c, ...)	KUNIT_TRUTH(t, true, !!(c), #c, __VA_ARGS__)
#define KUNIT_ASSERT_FALSE_MSG(t, c, ...)	KUNIT_TRUTH(t, true, !(c), "not " #c, __VA_ARGS__)
#define KUNIT_EXPECT_PTR_EQ_MSG(t, l, r, ...)	KUNIT_POINTERS(t, false, l, ==, r, __VA_ARGS__)
#define KUNIT_EXPECT_PTR_NE_MSG(t, l, r, ...)	KUNIT_POINTERS(t, false, l, !=, r, __VA_ARGS__)
#define KUNIT_EXPECT_NULL_MSG(t, p, ...)	KUNIT_POINTERS(t, false, p, ==, NULL, __VA_ARGS__)
#define KUNIT_EXPECT_NOT_NULL_MSG(t, p, ...)	KUNIT_POINTERS(t, false, p, !=, NULL, __VA_ARGS__)
#define KUNIT_ASSERT_PTR_EQ_MSG(t, l, r, ...)	KUNIT_POINTERS(t, true, l, ==, r, __VA_ARGS__)
#define KUNIT_ASSERT_PTR_NE_MSG(t, l, r, ...)	KUNIT_POINTERS(t, true, l, !=, r, __VA_ARGS__)
#define KUNIT_ASSERT_NULL_MSG(t, p, ...)	KUNIT_POINTERS(t, true, p, ==, NULL, __VA_ARGS__)
#define KUNIT_ASSERT_NOT_NULL_MSG(t, p, ...)	KUNIT_POINTERS(t, true, p, !=, NULL, __VA_ARGS__)
#define KUNIT_EXPECT_NOT_ERR_OR_NULL_MSG(t, p, ...) \
	KUNIT_TRUTH(t, false, !IS_ERR_OR_NULL(p), #p " valid", __VA_ARGS__)
#define KUNIT_ASSERT_NOT_ERR_OR_NULL_MSG(t, p, ...) \
	KUNIT_TRUTH(t, true, !IS_ERR_OR_NULL(p), #p " valid", __VA_ARGS__)
#define KUNIT_EXPECT_STREQ_MSG(t, l, r, ...)	KUNIT_STRINGS(t, false, l, ==, r, __VA_ARGS__)
#define KUNIT_EXPECT_STRNEQ_MSG(t, l, r, ...)	KUNIT_STRINGS(t, false, l, !=, r, __VA_ARGS__)
#define KUNIT_ASSERT_STREQ_MSG(t, l, r, ...)	KUNIT_STRINGS(t, true, l, ==, r, __VA_ARGS__)
#define KUNIT_ASSERT_STRNEQ_MSG(t, l, r, ...)	KUNIT_STRINGS(t, true, l, !=, r, __VA_ARGS__)
#define KUNIT_EXPECT_MEMEQ_MSG(t, l, r, n, ...)	KUNIT_MEMORY(t, false, l, ==, r, n, __VA_ARGS__)
#define KUNIT_EXPECT_MEMNEQ_MSG(t, l, r, n, ...)	\
	KUNIT_MEMORY(t, false, l, !=, r, n, __VA_ARGS__)
#define KUNIT_ASSERT_MEMEQ_MSG(t, l, r, n, ...)	KUNIT_MEMORY(t, true, l, ==, r, n, __VA_ARGS__)
#define KUNIT_ASSERT_MEMNEQ_MSG(t, l, r, n, ...)	\
	KUNIT_MEMORY(t, true, l, !=, r, n, __VA_ARGS__)

#endif
