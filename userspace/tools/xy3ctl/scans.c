// SPDX-License-Identifier: GPL-2.0-only
/*
 * Scans out of shapes and files. See scans.h.
 */
#include <endian.h>
#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "scans.h"
#include "shape.h"

/* -1 to 1 as a code */
static uint32_t code_of(const struct scans *scans, double unit)
{
	return lrint((unit + 1) / 2 * scans->top);
}

static void put(const struct scans *scans, uint32_t *scan, enum xy3_axis axis, uint32_t code)
{
	if (scans->index_of[axis] >= 0)
		scan[scans->index_of[axis]] = code;
}

/* Numbers of a scan */
static unsigned int columns(const struct scans *scans)
{
	return scans->axes + scans->gate;
}

static void middle(const struct scans *scans, uint32_t *scan)
{
	if (scans->gate)
		scan[scans->axes] = 0;
	for (unsigned int i = 0; i < scans->axes; i++)
		scan[i] = code_of(scans, 0);
}

/* ---- shapes ---- */

static long next_of_shape(struct scans *scans, uint32_t *codes, size_t count)
{
	double x, y;
	size_t i;

	for (i = 0; i < count && scans->left; i++, codes += columns(scans)) {
		/* the last one is at the end of the path, which is where it began */
		double way = (double)(scans->done % scans->points) / scans->points;

		scans->shape->place(way, &x, &y);
		middle(scans, codes);
		put(scans, codes, XY3_AXIS_X, code_of(scans, x * scans->size));
		put(scans, codes, XY3_AXIS_Y, code_of(scans, y * scans->size));
		if (scans->gate)
			codes[scans->axes] = scans->shape_gate && scans->done;
		scans->done++;
		if (scans->left != ULONG_MAX)
			scans->left--;
	}
	return i;
}

/* ---- numbers, a scan a line ---- */

static int line_wrong(const struct scans *scans, const char *what)
{
	cli_error("%s: line %lu: %s", scans->name, scans->line, what);
	return -1;
}

/* One number of a line, as a code. Return 0, or -1. */
static int take_number(struct scans *scans, char **text, uint32_t *code, bool gate)
{
	char *end;
	double number = strtod(*text, &end);

	if (end == *text || !isfinite(number) || (*end && !strchr(" \t,;\r\n", *end)))
		return line_wrong(scans, "not a number");
	if (gate) {
		if (number != 0 && number != 1)
			return line_wrong(scans, "a gate that is neither 0 nor 1");
		*code = number;
	} else if (scans->codes) {
		if (number < 0 || number > scans->top || number != floor(number))
			return line_wrong(scans, "not a code that a frame can have");
		*code = number;
	} else {
		if (number < -1 || number > 1)
			return line_wrong(scans, "a number that is not from -1 to 1");
		*code = code_of(scans, number);
	}
	*text = end;
	return 0;
}

/* A line's scan. Return 1, 0 for an empty line or a comment, or -1. */
static int take_line(struct scans *scans, char *text, uint32_t *scan)
{
	unsigned int count = 0;

	text += strspn(text, " \t\r\n");
	if (!*text || *text == '#')
		return 0;
	middle(scans, scan);
	while (*text) {
		if (count == columns(scans))
			return line_wrong(scans, "more numbers than the head has axes");
		if (take_number(scans, &text, &scan[count], count == scans->axes))
			return -1;
		count++;
		text += strspn(text, " \t,;\r\n");
	}
	return 1;
}

static long next_of_lines(struct scans *scans, uint32_t *codes, size_t count)
{
	char *text = NULL;
	size_t size = 0, done = 0;
	int taken = 0;

	while (done < count && taken >= 0 && getline(&text, &size, scans->file) >= 0) {
		scans->line++;
		taken = take_line(scans, text, codes + done * columns(scans));
		done += taken > 0;
	}
	free(text);
	if (taken < 0)
		return -1;
	if (!done && ferror(scans->file) && errno != EINTR) {
		cli_errno(errno, "%s", scans->name);
		return -1;
	}
	return done;
}

/* ---- codes as the IIO device takes them ---- */

static long next_of_raw(struct scans *scans, uint32_t *codes, size_t count)
{
	size_t size = 4 * columns(scans), wanted = count * size, got;

	got = fread(codes, 1, wanted, scans->file);
	if (got < wanted && ferror(scans->file) && errno != EINTR) {
		cli_errno(errno, "%s", scans->name);
		return -1;
	}
	if (got % size) {
		cli_error("%s: ends in the middle of a scan of %u codes of 4 bytes", scans->name,
			  columns(scans));
		return -1;
	}
	for (size_t i = 0; i < got / 4; i++) {
		uint32_t top = i % columns(scans) < scans->axes ? scans->top : 1;

		codes[i] = le32toh(codes[i]);
		if (codes[i] > top) {
			cli_error("%s: a code is %u, and %u is the highest", scans->name, codes[i],
				  top);
			return -1;
		}
	}
	return got / size;
}

long scans_next(struct scans *scans, uint32_t *codes, size_t count)
{
	if (scans->shape)
		return next_of_shape(scans, codes, count);
	return scans->raw ? next_of_raw(scans, codes, count) : next_of_lines(scans, codes, count);
}
