/* SPDX-License-Identifier: GPL-2.0-only */
/* What is measured: contests, in each of which the same work is done in several ways. */
#ifndef HOST_BENCH_H
#define HOST_BENCH_H

#include <linux/types.h>

#define CONTENDERS_MAX	4

/**
 * struct contender - one way to do a contest's work
 * @name: what it is called in the table
 * @block: do a block of it
 */
struct contender {
	const char *name;
	void (*block)(void *job);
};

/**
 * struct contest - the same work, done in several ways
 * @table: heading of the table where it stands
 * @name: its row there
 * @unit: what is counted
 * @units: how many of them are in a block
 * @bytes: how many bytes are in a block
 * @job: what it is done with
 * @good: do it once in all ways and compare what comes out
 * @contender: the ways; the first is the one that is judged by the others
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

/* Numbers without any order, the same ones each time */
static inline u32 next_random(u32 *state)
{
	*state ^= *state << 13;
	*state ^= *state >> 17;
	*state ^= *state << 5;
	return *state;
}

#endif
