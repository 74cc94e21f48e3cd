// SPDX-License-Identifier: GPL-2.0-only
/*
 * libxy3: scans of a path of jumps and marks, with their speeds and delays
 *
 * A vertex with the gate set is marked: the gate is high in all scans of the segment to it. Any
 * other vertex is a jump. Mirrors lag behind their scans, hence the delays at the end of a segment:
 * after the last of several marks, before the next jump, and after each jump.
 */

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "libxy3.h"

/* In codes per scan; the longest segment has 2^38 scans then */
static const double xy3_path_speed_min = 0.001, xy3_path_speed_max = 1000000000;

/**
 * struct xy3_path - a path and its progress
 * @axes: number of codes of a vertex
 * @settings: speeds and delays
 * @begun: there was a vertex
 * @mark: the gate is high during the segment
 * @from: the start of the segment
 * @to: the end of the segment
 * @before: remaining delay at @from, in scans
 * @steps: scans of the segment; the last is at @to
 * @step: scans returned so far
 * @after: remaining delay at @to, in scans
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

/* Whether @scans are too few. As its ends are rounded, a segment may be one code longer. */
static bool xy3_path_too_few(uint64_t scans, double square, double speed)
{
	double way = scans * speed + 1;

	return way * way < square;
}

/* The least number of scans, at least 1, for a segment of this length squared; no sqrt() of libm */
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
	bool mark = path->begun && vertex && vertex[path->axes] == 1;
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
