// SPDX-License-Identifier: GPL-2.0-only
/* Planted: a suite that runs nothing. */
#include <kunit/test.h>

static struct kunit_case cases[] = { {} };
static struct kunit_suite suite = { .name = "planted_no_cases", .test_cases = cases };
kunit_test_suite(suite);
