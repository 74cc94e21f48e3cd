// SPDX-License-Identifier: GPL-2.0-only
/*
 * Shapes to draw. See shape.h.
 */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "cli.h"
#include "shape.h"

#define SIDE M_SQRT2			/* of the square in the circle */
#define CORNER (SIDE / 2)
#define GRID_LINES 5			/* an odd number, so that the path ends at its start */
#define GRID_STEP (SIDE / (GRID_LINES - 1))
/* all rows to and fro, with a step from one to the next; then all columns */
#define GRID_HALF (GRID_LINES * SIDE + SIDE)

static void circle(double way, double *x, double *y)
{
	double angle = M_PI / 4 + 2 * M_PI * way;

	*x = cos(angle);
	*y = sin(angle);
}

static void square(double way, double *x, double *y)
{
	double along = fmod(way, 1) * 4, part = along - floor(along);

	switch ((int)along) {
	case 0:
		*x = CORNER - part * SIDE;
		*y = CORNER;
		break;
	case 1:
		*x = -CORNER;
		*y = CORNER - part * SIDE;
		break;
	case 2:
		*x = -CORNER + part * SIDE;
		*y = -CORNER;
		break;
	default:
		*x = CORNER;
		*y = -CORNER + part * SIDE;
	}
}

/* To and fro over all lines from corner to corner: position along and across after this length */
static void zigzag(double length, double *along, double *across)
{
	int line = length / (SIDE + GRID_STEP);
	double rest = length - line * (SIDE + GRID_STEP);
	double forth;

	if (line >= GRID_LINES) {	/* rounding, at the very end */
		line = GRID_LINES - 1;
		rest = SIDE;
	}
	forth = fmin(rest, SIDE);
	*along = line % 2 ? SIDE - forth : forth;
	*across = line * GRID_STEP + (rest - forth);
}

/* The path back over the columns is that over the rows, turned by a right angle */
static void grid(double way, double *x, double *y)
{
	double length = fmin(way, 1) * 2 * GRID_HALF, along, across;

	if (length <= GRID_HALF) {
		zigzag(length, &along, &across);
		*x = CORNER - along;
		*y = CORNER - across;
	} else {
		zigzag(length - GRID_HALF, &along, &across);
		*x = -CORNER + across;
		*y = -CORNER + along;
	}
}

static const struct shape shapes[] = {
	{ "circle", circle, 2 * M_PI },
	{ "square", square, 4 * SIDE },
	{ "grid", grid, 2 * GRID_HALF },
};

const struct shape *shape_find(const char *name)
{
	for (size_t i = 0; i < ARRAY_SIZE(shapes); i++) {
		if (!strcmp(shapes[i].name, name))
			return &shapes[i];
	}
	return NULL;
}
