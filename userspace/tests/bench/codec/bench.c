// SPDX-License-Identifier: GPL-2.0-only
/*
 * bench: measures the codecs, for bench-codec, which makes tables of the output:
 *
 *   bench list                     list the contests and their contenders, one per line
 *   bench check                    check that the contenders of a contest have the same results
 *   bench time ROUNDS USEC         time all of them, in turns, about USEC of work each time
 *   bench blocks CONTEST CONTENDER TIMES	do TIMES blocks, for counting instructions
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "bench.h"

#define CONTESTS_MAX	32

static struct contest contests[CONTESTS_MAX];
static unsigned int count;

void add_contest(const struct contest *contest)
{
	if (count == CONTESTS_MAX)
		abort();
	contests[count++] = *contest;
}

static unsigned int contenders(const struct contest *contest)
{
	unsigned int n = 0;

	while (n < CONTENDERS_MAX && contest->contender[n].block)
		n++;
	return n;
}

static void list(void)
{
	for (unsigned int i = 0; i < count; i++)
		for (unsigned int k = 0; k < contenders(&contests[i]); k++)
			printf("%u\t%u\t%s\t%s\t%s\t%s\t%zu\t%zu\n", i, k, contests[i].table,
			       contests[i].name, contests[i].contender[k].name, contests[i].unit,
			       contests[i].units, contests[i].bytes);
}

static int check(void)
{
	unsigned int failed = 0;

	for (unsigned int i = 0; i < count; i++) {
		bool good = contests[i].good(contests[i].job);

		failed += !good;
		printf("%s %s: %s\n", good ? "ok" : "not ok", contests[i].table,
		       contests[i].name);
	}
	printf("%u passed, %u failed\n", count - failed, failed);
	return failed || !count;
}

/* Through a pointer that is opaque to the compiler, so that nothing is moved out of the loop */
static void blocks(const struct contest *contest, unsigned int which, unsigned long times)
{
	void (*block)(void *job) = contest->contender[which].block;

	for (; times; times--)
		block(contest->job);
}

/* In ns, of the CPU time of this program, to reduce the influence of other programs */
static u64 now(void)
{
	struct timespec t;

	clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
	return t.tv_sec * 1000000000ULL + t.tv_nsec;
}

static u64 timed(const struct contest *contest, unsigned int which, unsigned long times)
{
	u64 start = now();

	blocks(contest, which, times);
	return now() - start;
}

static unsigned long enough(const struct contest *contest, unsigned int which, unsigned long usec)
{
	unsigned long times = 1;

	while (timed(contest, which, times) < usec * 1000)
		times *= 2;
	return times;
}

static void time_all(unsigned long rounds, unsigned long usec)
{
	for (unsigned int i = 0; i < count; i++) {
		unsigned int n = contenders(&contests[i]);
		unsigned long times[CONTENDERS_MAX];

		for (unsigned int k = 0; k < n; k++)
			times[k] = enough(&contests[i], k, usec);
		for (unsigned long round = 0; round < rounds; round++)
			for (unsigned int k = 0; k < n; k++)
				printf("%u\t%u\t%lu\t%llu\n", i, k, times[k],
				       (unsigned long long)timed(&contests[i], k, times[k]));
	}
}

static unsigned long number(const char *text, unsigned long end)
{
	char *rest;
	unsigned long n = strtoul(text, &rest, 10);

	if (rest == text || *rest || n >= end) {
		fprintf(stderr, "bench: invalid value: %s\n", text);
		exit(2);
	}
	return n;
}

int main(int argc, char **argv)
{
	const char *what = argc > 1 ? argv[1] : "";

	add_encoding();
	add_parsing();
	add_display();
	for (unsigned int i = 0; i < count; i++)	/* touch all pages before measuring */
		for (unsigned int k = 0; k < contenders(&contests[i]); k++)
			blocks(&contests[i], k, 1);

	if (!strcmp(what, "list") && argc == 2) {
		list();
	} else if (!strcmp(what, "check") && argc == 2) {
		return check();
	} else if (!strcmp(what, "time") && argc == 4) {
		time_all(number(argv[2], 1000), number(argv[3], 1000000));
	} else if (!strcmp(what, "blocks") && argc == 5) {
		const struct contest *contest = &contests[number(argv[2], count)];

		blocks(contest, number(argv[3], contenders(contest)), number(argv[4], 1000000));
	} else {
		fprintf(stderr, "bench: list, check, time ROUNDS USEC or blocks A B TIMES\n");
		return 2;
	}
	return 0;
}
