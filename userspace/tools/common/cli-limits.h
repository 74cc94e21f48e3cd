/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * --count and --timeout of verbs that run until they are interrupted
 */
#ifndef CLI_LIMITS_H
#define CLI_LIMITS_H

#include <argp.h>
#include <stdbool.h>
#include <time.h>

struct limits {
	unsigned long count;	/* 0: none */
	unsigned long seen;
	double seconds;		/* 0: none */
	struct timespec began;
};

/* Arguments of the options; an invalid one is a usage error and exits */
void limits_count(struct limits *limits, const char *text, const struct argp_state *state);
void limits_timeout(struct limits *limits, const char *text, const struct argp_state *state);

void limits_start(struct limits *limits);
bool limits_reached(const struct limits *limits);
bool limits_time_is_up(const struct limits *limits);
/* Timeout for poll(), limited to this number of milliseconds */
int limits_wait_ms(const struct limits *limits, double most);
/* The status of such an end: a count that was not reached in time is a failure. */
int limits_status(const struct limits *limits);

/* Seconds from text; exits after a usage error. Also used for other times. */
double parse_seconds(const char *text, const char *what, const struct argp_state *state);

#endif /* CLI_LIMITS_H */
