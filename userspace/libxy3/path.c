// SPDX-License-Identifier: GPL-2.0-only
/*
 * libxy3: scans of a path of jumps and marks, each at its speed, with delays behind them
 *
 * A vertex that asks for the gate is marked to: the gate is high in all scans of the way to it.
 * Any other is jumped to. Mirrors lag behind their scans, so that they are given time where a way
 * ends: behind the last of several marks, before the jump away from it, and behind each jump.
 */

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "libxy3.h"

/* In codes a scan; the longest way has 2^38 scans then */
static const double xy3_path_speed_min = 0.001, xy3_path_speed_max = 1000000000;

/**
 * struct xy3_path - a path, and how far it is
 * @axes: codes of a vertex
 * @settings: speeds and delays
 * @begun: there was a vertex
 * @mark: the gate is high on the way
 * @from: the vertex before
 * @to: the vertex that is on the way to
 * @before: scans to stand at @from
 * @steps: scans of the way; the last is at @to
 * @step: those that have come out
 * @after: scans to stand at @to
 */
struct xy3_path {
	unsigned int axes;
	struct xy3_path_settings settings;
	bool begun;
	bool mark;
	uint32_t from[XY3_AXES];
	uint32_t to[XY3_AXES];
	unsigned int before;
	uint64_t steps;
	uint64_t step;
	unsigned int after;
};

static bool xy3_path_speed_ok(double speed)
{
	return speed >= xy3_path_speed_min && speed <= xy3_path_speed_max;
}

int xy3_path_new(struct xy3_path **path, unsigned int axes,
		 const struct xy3_path_settings *settings)
{
	struct xy3_path *p;

	if (!axes || axes > XY3_AXES || !xy3_path_speed_ok(settings->jump_speed) ||
	    !xy3_path_speed_ok(settings->mark_speed))
		return -EINVAL;
	p = calloc(1, sizeof(*p));
	if (!p)
		return -ENOMEM;
	p->axes = axes;
	p->settings = *settings;
	*path = p;
	return 0;
}

void xy3_path_free(struct xy3_path *path)
{
	free(path);
}

/* Whether these scans are too few. As its ends are rounded, a way may be a code longer. */
static bool xy3_path_too_few(uint64_t scans, double square, double speed)
{
	double way = scans * speed + 1;

	return way * way < square;
}

/* The least number of scans, one at least, for a way of this square; without the root of libm */
static uint64_t xy3_path_steps(double square, double speed)
{
	uint64_t low = 0, high = 1;

	while (xy3_path_too_few(high, square, speed))
		high *= 2;
	while (high - low > 1) {
		uint64_t middle = low + (high - low) / 2;

		if (xy3_path_too_few(middle, square, speed))
			low = middle;
		else
			high = middle;
	}
	return high;
}

void xy3_path_to(struct xy3_path *path, const uint32_t *vertex)
{
	bool mark = path->begun && vertex && vertex[path->axes];
	double square = 0;

	path->before = path->mark && !mark ? path->settings.mark_delay : 0;
	memcpy(path->from, path->to, sizeof(path->from));
	path->mark = mark;
	path->step = 0;
	path->steps = 0;
	path->after = 0;
	if (!vertex)
		return;
	memcpy(path->to, vertex, path->axes * sizeof(*vertex));
	if (path->begun) {
		for (unsigned int i = 0; i < path->axes; i++) {
			double way = (double)path->to[i] - path->from[i];

			square += way * way;
		}
	}
	path->steps = xy3_path_steps(square, mark ? path->settings.mark_speed :
						    path->settings.jump_speed);
	path->after = mark ? 0 : path->settings.jump_delay;
	path->begun = true;
}

bool xy3_path_next(struct xy3_path *path, uint32_t *scan)
{
	double part = 1;

	scan[path->axes] = 0;
	if (path->before) {
		path->before--;
		part = 0;
	} else if (path->step < path->steps) {
		path->step++;
		part = (double)path->step / path->steps;
		scan[path->axes] = path->mark;
	} else if (path->after) {
		path->after--;
	} else {
		return false;
	}
	for (unsigned int i = 0; i < path->axes; i++)
		scan[i] = path->from[i] + ((double)path->to[i] - path->from[i]) * part + 0.5;
	return true;
}
