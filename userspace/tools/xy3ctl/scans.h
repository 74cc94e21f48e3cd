/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Source of the scans of a stream: a shape, a file of numbers, or codes ready to be sent.
 */
#ifndef SCANS_H
#define SCANS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <linux/xy3.h>

struct shape;
struct xy3_path;

struct scans {
	unsigned int axes;	/* codes of a scan */
	bool gate;		/* followed by 1 or 0 for the gate */
	bool shape_gate;	/* a shape requests it, except on the way to its first position */
	uint32_t top;		/* the highest code */
	int index_of[XY3_AXES];	/* of an axis in a scan; -1: not in it */

	const struct shape *shape;	/* or NULL: a file */
	double size;		/* radius of the circle, 0 to 1 */
	unsigned long points;	/* scans of one round */
	unsigned long left;	/* remaining scans of a shape; ULONG_MAX: endless */
	unsigned long done;	/* scans returned */

	const char *name;	/* of the file */
	FILE *file;
	bool is_regular;	/* it can be read twice */
	bool raw;
	bool codes;		/* numbers are codes, not -1 to 1 */
	unsigned long line;
	unsigned int numbers;	/* of each line; 0: before the first */
	struct xy3_path *path;	/* lines are its vertices; NULL: they are scans */
	bool path_ends;
	bool failed;		/* it was reported, and there are no further scans */
};

/*
 * The next scans, up to count. Return their number, 0 at the end, or -1 after an error in the file
 * has been reported. Scans before an invalid one are returned first.
 */
long scans_next(struct scans *scans, uint32_t *codes, size_t count);

/* Check all scans of a regular file before the first is returned. Return an enum cli_status. */
int scans_check(struct scans *scans);

#endif /* SCANS_H */
