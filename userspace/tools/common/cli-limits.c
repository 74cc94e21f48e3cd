// SPDX-License-Identifier: GPL-2.0-only
/*
 * --count and --timeout. See cli-limits.h.
 */
#include <ctype.h>
#include <errno.h>
#include <stdlib.h>

#include "cli-limits.h"
#include "cli.h"

#define SECONDS_MAX	1e9

double parse_seconds(const char *text, const char *what, const struct argp_state *state)
{
	double seconds;
	char *end;

	seconds = strtod(text, &end);
	if (!(isdigit((unsigned char)*text) || *text == '.') || end == text || *end ||
	    !(seconds >= 0 && seconds <= SECONDS_MAX))
		argp_error(state, "%s: \"%s\" is no number of seconds", what, text);
	return seconds;
}

void limits_count(struct limits *limits, const char *text, const struct argp_state *state)
{
	char *end;

	errno = 0;
	limits->count = strtoul(text, &end, 10);
	if (!isdigit((unsigned char)*text) || *end || errno || !limits->count)
		argp_error(state, "--count: \"%s\" is no number above 0", text);
}

void limits_timeout(struct limits *limits, const char *text, const struct argp_state *state)
{
	limits->seconds = parse_seconds(text, "--timeout", state);
	if (limits->seconds == 0)
		argp_error(state, "--timeout: some time is wanted");
}

void limits_start(struct limits *limits)
{
	clock_gettime(CLOCK_MONOTONIC, &limits->began);
}

bool limits_reached(const struct limits *limits)
{
	return limits->count && limits->seen >= limits->count;
}

static double left(const struct limits *limits)
{
	struct timespec now;

	clock_gettime(CLOCK_MONOTONIC, &now);
	return limits->seconds - (now.tv_sec - limits->began.tv_sec) -
	       (now.tv_nsec - limits->began.tv_nsec) / 1e9;
}

bool limits_time_is_up(const struct limits *limits)
{
	return limits->seconds > 0 && left(limits) <= 0;
}

int limits_wait_ms(const struct limits *limits, int most)
{
	double ms;

	if (limits->seconds == 0)
		return most;
	ms = left(limits) * 1000 + 1;
	return ms < 0 ? 0 : ms > most ? most : (int)ms;
}

int limits_status(const struct limits *limits)
{
	if (limits->count && limits->seen < limits->count)
		return cli_error("time is up: %lu of %lu", limits->seen, limits->count);
	return CLI_OK;
}
