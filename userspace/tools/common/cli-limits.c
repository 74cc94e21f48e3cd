// SPDX-License-Identifier: GPL-2.0-only
/*
 * --count and --timeout. See cli-limits.h.
 */
#include <limits.h>
#include <math.h>

#include "cli-limits.h"
#include "cli.h"
#include "number.h"

#define SECONDS_MAX	1e9

double parse_seconds(const char *text, const char *what, const struct argp_state *state)
{
	return option_real(what, text, 0, SECONDS_MAX, state);
}

void limits_count(struct limits *limits, const char *text, const struct argp_state *state)
{
	limits->count = option_whole("--count", text, 1, ULONG_MAX, state);
}

void limits_timeout(struct limits *limits, const char *text, const struct argp_state *state)
{
	limits->seconds = parse_seconds(text, "--timeout", state);
	if (limits->seconds == 0)
		argp_error(state, "--timeout: must be more than 0");
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

int limits_wait_ms(const struct limits *limits, double most)
{
	double ms = most;

	if (limits->seconds > 0)
		ms = fmin(left(limits) * 1000 + 1, most);
	return fmin(fmax(ms, 0), INT_MAX);
}

int limits_status(const struct limits *limits)
{
	if (limits->count && limits->seen < limits->count)
		return cli_error("timed out: %lu of %lu", limits->seen, limits->count);
	return CLI_OK;
}
