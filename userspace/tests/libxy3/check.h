/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Print a line for each case: "ok NAME" or "not ok NAME". The last line has the counts.
 */
#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>

static const char *check_case;
static unsigned int check_bad, check_passed, check_failed;

#define CHECK(condition)							\
	do {									\
		if (!(condition)) {						\
			printf("    %s, line %d: %s\n", check_case, __LINE__, #condition); \
			check_bad++;						\
		}								\
	} while (0)

static inline void check_run(const char *name, void (*function)(void))
{
	check_case = name;
	check_bad = 0;
	function();
	printf("%s %s\n", check_bad ? "not ok" : "ok", name);
	check_failed += check_bad > 0;
	check_passed += !check_bad;
	fflush(stdout);
}

#define RUN(function)	check_run(#function, function)

static inline int check_end(const char *program)
{
	printf("%s: %u passed, %u failed\n", program, check_passed, check_failed);
	return check_failed > 0;
}

#endif /* CHECK_H */
