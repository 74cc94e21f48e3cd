/* SPDX-License-Identifier: GPL-2.0-only */
/* Contests, which compare several ways to do the same work. */
#ifndef HOST_BENCH_H
#define HOST_BENCH_H

#include <linux/types.h>

#define CONTENDERS_MAX	4

/**
 * struct contender - one way to do the work of a contest
 * @name: its name in the table
 * @block: do a block of the work
 */
struct contender {
	const char *name;
	void (*block)(void *job);
};

/**
 * struct contest - the same work, done in several ways
 * @table: heading of its table
 * @name: its row in the table
 * @unit: the unit that is counted
 * @units: number of units in a block
 * @bytes: number of bytes in a block
 * @job: data for the contenders
 * @good: do it once in all ways and compare the results
 * @contender: the ways; the first is compared with the others
 */
struct contest {
	const char *table;
	const char *name;
	const char *unit;
	size_t units;
	size_t bytes;
	void *job;
	bool (*good)(void *job);
	struct contender contender[CONTENDERS_MAX];
};

void add_contest(const struct contest *contest);

/* One for each codec */
void add_encoding(void);
void add_parsing(void);
void add_display(void);

/* Pseudo-random numbers, the same ones each time */
static inline u32 next_random(u32 *state)
{
	*state ^= *state << 13;
	*state ^= *state >> 17;
	*state ^= *state << 5;
	return *state;
}

#endif
