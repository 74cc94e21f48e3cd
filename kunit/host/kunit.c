// SPDX-License-Identifier: GPL-2.0-only
/*
 * Runs the suites of one program in order and prints KTAP like KUnit in the kernel. Exit status: 0
 * if every suite had cases and none failed.
 */
#include <stdarg.h>
#include <stdio.h>

#include <kunit/test.h>

#define INDENT	"    "

struct kunit_allocation {
	void *ptr;
	struct kunit_allocation *next;
};

/* ---- memory of a case ---- */

static void *keep(struct kunit *test, void *ptr)
{
	struct kunit_allocation *a = malloc(sizeof(*a));

	if (!a || !ptr) {
		free(a);
		free(ptr);
		return NULL;
	}
	a->ptr = ptr;
	a->next = test->allocations;
	test->allocations = a;
	return ptr;
}

void *kunit_kmalloc(struct kunit *test, size_t size, gfp_t gfp)
{
	return keep(test, kmalloc(size, gfp));
}

void *kunit_kzalloc(struct kunit *test, size_t size, gfp_t gfp)
{
	return keep(test, kzalloc(size, gfp));
}

void *kunit_kcalloc(struct kunit *test, size_t n, size_t size, gfp_t gfp)
{
	(void)gfp;
	return keep(test, calloc(n, size));
}

void kunit_kfree(struct kunit *test, const void *ptr)
{
	struct kunit_allocation **link = &test->allocations;

	while (*link && (*link)->ptr != ptr)
		link = &(*link)->next;
	if (*link) {
		struct kunit_allocation *a = *link;

		*link = a->next;
		free(a->ptr);
		free(a);
	}
}

/* ---- messages of a case ---- */

void kunit_log_line(struct kunit *test, const char *level, const char *fmt, ...)
{
	va_list args;

	printf(INDENT "# %s: %s", test->name, level);
	va_start(args, fmt);
	vprintf(fmt, args);
	va_end(args);
	printf("\n");
}

void kunit_failed(struct kunit *test, const struct kunit_place *place, const char *fmt, ...)
{
	va_list args;

	printf(INDENT "# %s: %s FAILED at %s:%d ", test->name,
	       place->fatal ? "ASSERTION" : "EXPECTATION", place->file, place->line);
	va_start(args, fmt);
	vprintf(fmt, args);
	va_end(args);
	printf("\n");

	test->status = KUNIT_FAILURE;
	if (place->fatal)
		longjmp(test->abort, 1);
}

void kunit_values(struct kunit *test, const char *left, long long l,
		  const char *right, long long r)
{
	kunit_info(test, "expected %s %s, but %lld (0x%llx) against %lld (0x%llx)",
		   left, right, l, l, r, r);
}

void kunit_strings(struct kunit *test, const char *left, const char *l,
		   const char *right, const char *r)
{
	kunit_info(test, "expected %s %s, but \"%s\" against \"%s\"",
		   left, right, l ? l : "(null)", r ? r : "(null)");
}

void kunit_bytes(struct kunit *test, const char *what, const void *bytes, size_t size)
{
	const u8 *b = bytes;

	printf(INDENT "# %s: %s =", test->name, what);
	for (size_t i = 0; b && i < size; i++)
		printf(" %02x", b[i]);
	printf("\n");
}

/* ---- running ---- */

/* An assertion may exit init, the case or exit. */
static void call(struct kunit *test, void (*step)(struct kunit *test))
{
	if (step && !setjmp(test->abort))
		step(test);
}

static void call_init(struct kunit *test, int (*init)(struct kunit *test))
{
	int ret;

	if (!init || setjmp(test->abort))
		return;
	ret = init(test);
	if (ret)
		kunit_failed(test, KUNIT_PLACE(false), "init returned %d", ret);
}

static enum kunit_status run_once(struct kunit_suite *suite, struct kunit_case *c,
				  const void *param, int index, struct kunit *test)
{
	*test = (struct kunit){ .name = c->name, .param_value = param, .param_index = index };

	call_init(test, suite->init);
	if (test->status == KUNIT_SUCCESS)
		call(test, c->run_case);
	call(test, suite->exit);

	while (test->allocations)
		kunit_kfree(test, test->allocations->ptr);
	return test->status;
}

static void print_result(const char *indent, enum kunit_status status, int number,
			 const char *name, const char *comment)
{
	printf("%s%s %d %s%s%s\n", indent, status == KUNIT_FAILURE ? "not ok" : "ok", number, name,
	       status == KUNIT_SKIPPED ? " # SKIP " : "",
	       status == KUNIT_SKIPPED ? comment : "");
}

static int count_params(const struct kunit_case *c)
{
	char desc[KUNIT_PARAM_DESC_SIZE];
	const void *param = NULL;
	int n = 0;

	while ((param = c->generate_params(param, desc)))
		n++;
	return n;
}

static enum kunit_status run_params(struct kunit_suite *suite, struct kunit_case *c)
{
	enum kunit_status worst = KUNIT_SUCCESS;
	char desc[KUNIT_PARAM_DESC_SIZE];
	const void *param = NULL;
	struct kunit test;
	int n = 0;

	printf(INDENT INDENT "KTAP version 1\n");
	printf(INDENT INDENT "# Subtest: %s\n", c->name);
	printf(INDENT INDENT "1..%d\n", count_params(c));
	for (;;) {
		enum kunit_status status;

		desc[0] = '\0';
		param = c->generate_params(param, desc);
		if (!param)
			break;
		if (!desc[0])
			scnprintf(desc, sizeof(desc), "param-%d", n);
		status = run_once(suite, c, param, n, &test);
		print_result(INDENT INDENT, status, ++n, desc, test.status_comment);
		if (status == KUNIT_FAILURE)
			worst = status;
	}
	if (n == 0) {
		printf(INDENT "# %s: no parameters\n", c->name);
		return KUNIT_FAILURE;
	}
	return worst;
}

static int count_cases(const struct kunit_suite *suite)
{
	int n = 0;

	while (suite->test_cases[n].run_case)
		n++;
	return n;
}

static bool run_suite(struct kunit_suite *suite)
{
	int cases = count_cases(suite);
	struct kunit test = {};
	bool good = cases > 0;

	printf(INDENT "KTAP version 1\n");
	printf(INDENT "# Subtest: %s\n", suite->name);
	printf(INDENT "1..%d\n", cases);
	if (suite->suite_init && suite->suite_init(suite)) {
		printf(INDENT "# %s: suite_init failed\n", suite->name);
		return false;
	}
	for (int i = 0; i < cases; i++) {
		struct kunit_case *c = &suite->test_cases[i];
		enum kunit_status status;

		test.status_comment[0] = '\0';
		if (c->generate_params)
			status = run_params(suite, c);
		else
			status = run_once(suite, c, NULL, 0, &test);
		print_result(INDENT, status, i + 1, c->name, test.status_comment);
		if (status == KUNIT_FAILURE)
			good = false;
	}
	if (suite->suite_exit)
		suite->suite_exit(suite);
	return good;
}

int main(void)
{
	bool all_good = true;
	int n = 0;

	/* messages before a crash must not be lost */
	setvbuf(stdout, NULL, _IOLBF, 0);

	while (kunit_suites[n])
		n++;
	printf("KTAP version 1\n1..%d\n", n);
	for (int i = 0; i < n; i++) {
		bool good = run_suite(kunit_suites[i]);

		print_result("", good ? KUNIT_SUCCESS : KUNIT_FAILURE, i + 1,
			     kunit_suites[i]->name, "");
		all_good &= good;
	}
	return n && all_good ? 0 : 1;
}
