/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Shapes to draw: closed paths in X and Y. The square is in the circle and the grid in the square;
 * all begin and end at the same corner, so that one can follow another without a jump. (The same
 * as userspace/examples/figure.py.)
 */
#ifndef SHAPE_H
#define SHAPE_H

struct shape {
	const char *name;
	/* Position after a part of the path, 0 to 1, for a circle of radius 1 */
	void (*place)(double way, double *x, double *y);
	double length;		/* of the path, for a circle of radius 1 */
};

/* The shape of this name, or NULL */
const struct shape *shape_find(const char *name);

#endif /* SHAPE_H */
