// SPDX-License-Identifier: GPL-2.0-only
/*
 * Scans from shapes and files. See scans.h.
 */
#include <endian.h>
#include <errno.h>
#include <libxy3.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "number.h"
#include "scans.h"
#include "shape.h"

#define CHECKED 1024	/* scans at once */

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
		/* the last one is at the end of the path, which is also its start */
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

/* ---- numbers, one scan per line ---- */

#define BLANKS	" \t\r\n"
#define BOM	"\xef\xbb\xbf"	/* some spreadsheets start a file with it */

static int __attribute__((format(printf, 2, 3)))
line_wrong(const struct scans *scans, const char *format, ...)
{
	va_list arguments;
	char *text;

	va_start(arguments, format);
	if (vasprintf(&text, format, arguments) < 0)
		text = NULL;
	va_end(arguments);
	cli_error("%s: line %lu: %s", scans->name, scans->line, text ?: "wrong");
	free(text);
	return -1;
}

/* One number of a line, as a code. Return 0, or -1. */
static int take_number(const struct scans *scans, const char *text, bool gate, uint32_t *code)
{
	long number;
	double unit;
	int error;

	if (gate || scans->codes) {
		error = number_code(text, 0, gate ? 1 : scans->top, &number);
		if (error == -EINVAL)
			return line_wrong(scans, "'%s' is not a whole number", text);
		if (error && gate)
			return line_wrong(scans, "'%s' is not 0 or 1, for the gate", text);
		if (error)
			return line_wrong(scans, "'%s' is not a code from 0 to %u", text,
					  scans->top);
		*code = number;
		return 0;
	}
	error = number_real(text, -1, 1, &unit);
	if (error == -EINVAL)
		return line_wrong(scans, "'%s' is not a number%s", text,
				  scans->numbers ? "" : "; a line of names begins with #");
	if (error)
		return line_wrong(scans, "'%s' is not from -1 to 1", text);
	*code = code_of(scans, unit);
	return 0;
}

/*
 * The text of the next number, without surrounding blanks. separators: those in the line; several
 * blanks are one. NULL at the end.
 */
static char *next_text(char **rest, const char *separators)
{
	char *text, *end;

	do
		text = strsep(rest, separators);
	while (text && !*text && separators[0] == ' ');
	if (!text)
		return NULL;
	text += strspn(text, BLANKS);
	for (end = text + strlen(text); end > text && strchr(BLANKS, end[-1]); end--)
		;
	*end = '\0';
	return text;
}

static int take_numbers(struct scans *scans, char *rest, uint32_t *scan)
{
	const char *separators = strchr(rest, ';') ? ";" : strchr(rest, ',') ? "," : BLANKS;
	unsigned int count = 0;
	char *text;

	if (*separators == ';' && strchr(rest, ','))
		return line_wrong(scans, "commas and semicolons: a number has a decimal point");
	middle(scans, scan);
	for (; (text = next_text(&rest, separators)); count++) {
		if (!*text)
			return line_wrong(scans, "number %u is empty", count + 1);
		if (count < columns(scans) &&
		    take_number(scans, text, count == scans->axes, &scan[count]))
			return -1;
	}
	if (count > columns(scans))
		return line_wrong(scans, "%u numbers, and the head has %u axes%s", count,
				  scans->axes, scans->gate ? " and a gate" : "");
	if (scans->numbers && count != scans->numbers)
		return line_wrong(scans, "%u numbers, where the lines before have %u", count,
				  scans->numbers);
	scans->numbers = count;
	return 1;
}

/* The scan of a line. Return 1, 0 for an empty line or a comment, or -1. */
static int take_line(struct scans *scans, char *text, size_t length, uint32_t *scan)
{
	scans->line++;
	if (strlen(text) != length)
		return line_wrong(scans, "a byte of 0");
	if (scans->line == 1 && !strncmp(text, BOM, strlen(BOM)))
		text += strlen(BOM);
	text += strspn(text, BLANKS);
	if (!*text || *text == '#')
		return 0;
	for (length = strlen(text); strchr(BLANKS, text[length - 1]); length--)
		;
	text[length] = '\0';
	return take_numbers(scans, text, scan);
}

static long next_of_lines(struct scans *scans, uint32_t *codes, size_t count)
{
	size_t size = 0, done = 0;
	char *text = NULL;
	ssize_t length;
	int taken;

	while (done < count && (length = getline(&text, &size, scans->file)) >= 0) {
		taken = take_line(scans, text, length, codes + done * columns(scans));
		if (taken < 0) {
			scans->failed = true;
			break;
		}
		done += taken;
	}
	free(text);
	return done;
}

/* ---- codes in the format of the IIO device ---- */

/* Number of valid scans read before an invalid one */
static size_t check_raw(struct scans *scans, uint32_t *codes, size_t count)
{
	for (size_t i = 0; i < count; i++) {
		uint32_t top = i % columns(scans) < scans->axes ? scans->top : 1;

		codes[i] = le32toh(codes[i]);
		if (codes[i] > top) {
			cli_error("%s: scan %lu: a code is %u, and %u is the highest", scans->name,
				  scans->done + i / columns(scans) + 1, codes[i], top);
			scans->failed = true;
			return i / columns(scans);
		}
	}
	return count / columns(scans);
}

static long next_of_raw(struct scans *scans, uint32_t *codes, size_t count)
{
	size_t size = 4 * columns(scans), got = fread(codes, 1, count * size, scans->file);

	count = check_raw(scans, codes, got / 4);
	if (got % size && !scans->failed) {
		cli_error("%s: ends in the middle of scan %lu, of %u codes of 4 bytes",
			  scans->name, scans->done + count + 1, columns(scans));
		scans->failed = true;
	}
	return count;
}

/* ---- any of them ---- */

static long next_of_file(struct scans *scans, uint32_t *codes, size_t count)
{
	long got;

	if (scans->failed)
		return -1;
	got = scans->raw ? next_of_raw(scans, codes, count) : next_of_lines(scans, codes, count);
	scans->done += got;
	if (got || cli_interrupted())
		return got;
	if (!scans->failed && ferror(scans->file))
		cli_errno(errno, "%s", scans->name);
	else if (!scans->failed && !scans->done)
		cli_error("%s: no scan in it", scans->name);
	else if (!scans->failed)
		return 0;
	scans->failed = true;
	return -1;
}

/* The file has vertices */
static long next_of_path(struct scans *scans, uint32_t *codes, size_t count)
{
	uint32_t vertex[XY3_AXES + 1];
	size_t done = 0;
	long got;

	while (done < count) {
		if (xy3_path_next(scans->path, codes + done * columns(scans))) {
			done++;
			continue;
		}
		if (scans->path_ends)
			break;
		got = next_of_file(scans, vertex, 1);
		if (got < 0)
			return done ? (long)done : -1;
		xy3_path_to(scans->path, got ? vertex : NULL);
		scans->path_ends = !got;
	}
	return done;
}

long scans_next(struct scans *scans, uint32_t *codes, size_t count)
{
	if (scans->shape)
		return next_of_shape(scans, codes, count);
	return scans->path ? next_of_path(scans, codes, count) : next_of_file(scans, codes, count);
}

int scans_check(struct scans *scans)
{
	static uint32_t codes[CHECKED * (XY3_AXES + 1)];
	struct scans before = *scans;
	long start, got;

	if (scans->shape || !scans->is_regular)
		return CLI_OK;
	start = ftell(scans->file);
	while ((got = next_of_file(scans, codes, CHECKED)) > 0)
		;
	if (got < 0 || scans->failed)
		return CLI_FAILURE;
	if (fseek(scans->file, start, SEEK_SET))
		return cli_errno(errno, "%s", scans->name);
	*scans = before;
	return CLI_OK;
}
