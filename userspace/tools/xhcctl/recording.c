// SPDX-License-Identifier: GPL-2.0-only
/*
 * Recordings. See recording.h. They are untrusted input.
 */
#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "recording.h"

/* Longer than any valid line: the largest report, three characters per byte */
#define LINE_MAX_SIZE	(3 * REPORT_MAX + 64)
#define SECONDS_MAX	1000000000ul

struct reader {
	struct recording *recording;
	bool name, phys, info;
	size_t room;		/* for reports */
};

/* A number without sign. Return false if it is not a number or above the limit. */
static bool take_number(const char **text, int base, unsigned long max, unsigned long *number)
{
	char *end;

	while (**text == ' ')
		(*text)++;
	if (!isxdigit((unsigned char)**text))
		return false;
	errno = 0;
	*number = strtoul(*text, &end, base);
	if (errno || end == *text || *number > max)
		return false;
	*text = end;
	return true;
}

/* SIZE BYTE... up to the end of the line */
static const char *take_bytes(const char *text, uint8_t *data, size_t max, size_t *size)
{
	unsigned long count, byte;

	if (!take_number(&text, 10, max, &count) || !count)
		return "no size, or an invalid one";
	for (size_t i = 0; i < count; i++) {
		if (*text != ' ' || !take_number(&text, 16, 0xff, &byte))
			return "fewer bytes than its size, or invalid ones";
		data[i] = byte;
	}
	while (*text == ' ')
		text++;
	if (*text)
		return "more bytes than its size";
	*size = count;
	return NULL;
}

/* Seconds and six digits after the point */
static bool take_time(const char **text, uint64_t *us)
{
	unsigned long seconds, fraction;
	const char *point;

	if (!take_number(text, 10, SECONDS_MAX, &seconds) || **text != '.')
		return false;
	point = ++*text;
	if (*point == ' ' || !take_number(text, 10, 999999, &fraction) || *text != point + 6)
		return false;
	*us = seconds * UINT64_C(1000000) + fraction;
	return true;
}

static const char *take_report(struct reader *reader, const char *text)
{
	struct recording *recording = reader->recording;
	struct recorded_report report;
	uint8_t data[REPORT_MAX];
	const char *wrong;

	if (!recording->descriptor_size)
		return "a report before the descriptor";
	if (!take_time(&text, &report.us) || *text != ' ')
		return "no time, such as 000001.250000";
	if (recording->count && report.us < recording->report[recording->count - 1].us)
		return "earlier than the report before";
	wrong = take_bytes(text, data, sizeof(data), &report.size);
	if (wrong)
		return wrong;
	if (recording->count == reader->room) {
		size_t room = reader->room ? 2 * reader->room : 64;
		void *larger = reallocarray(recording->report, room, sizeof(report));

		if (!larger)
			return "no memory for all reports";
		recording->report = larger;
		reader->room = room;
	}
	report.data = malloc(report.size);
	if (!report.data)
		return "no memory for all reports";
	memcpy(report.data, data, report.size);
	recording->report[recording->count++] = report;
	return NULL;
}

static const char *take_text(char *to, size_t size, const char *text, bool *seen)
{
	if (*seen)
		return "it is given twice";
	*seen = true;
	while (*text == ' ')
		text++;
	if (strlen(text) >= size)
		return "too long";
	memcpy(to, text, strlen(text) + 1);
	return NULL;
}

static const char *take_info(struct reader *reader, const char *text)
{
	struct recording *recording = reader->recording;
	unsigned long bus, vendor, product;

	if (reader->info)
		return "it is given twice";
	reader->info = true;
	if (!take_number(&text, 16, 0xffff, &bus) || !take_number(&text, 16, 0xffff, &vendor) ||
	    !take_number(&text, 16, 0xffff, &product) || *text)
		return "bus, vendor and product are required";
	recording->bus = bus;
	recording->vendor = vendor;
	recording->product = product;
	return NULL;
}

/* Return an error message for a line, or NULL. */
static const char *take_line(struct reader *reader, const char *line)
{
	struct recording *recording = reader->recording;
	unsigned long number;
	const char *text;

	if (!*line || *line == '#')
		return NULL;
	if (line[1] != ':')
		return "not a line of a recording";
	text = line + 2;
	switch (line[0]) {
	case 'D':
		if (!take_number(&text, 10, 0, &number) || *text)
			return "only one device is supported, number 0";
		return NULL;
	case 'R':
		if (recording->descriptor_size)
			return "it is given twice";
		return take_bytes(text, recording->descriptor, sizeof(recording->descriptor),
				  &recording->descriptor_size);
	case 'N':
		return take_text(recording->name, sizeof(recording->name), text, &reader->name);
	case 'P':
		return take_text(recording->phys, sizeof(recording->phys), text, &reader->phys);
	case 'I':
		return take_info(reader, text);
	case 'E':
		return take_report(reader, text);
	}
	return "not a line of a recording";
}

/* Return its length without the newline; -1 at the end. It is truncated to the size. */
static long next_line(FILE *stream, char *line, size_t size)
{
	long length = 0;
	int c;

	while ((c = getc(stream)) != EOF && c != '\n') {
		if ((size_t)length + 1 < size)
			line[length++] = c;
	}
	if (c == EOF && !length)
		return -1;
	if (length && line[length - 1] == '\r')
		length--;
	line[length] = '\0';
	return length;
}

int recording_read(FILE *stream, const char *path, struct recording *recording)
{
	struct reader reader = { .recording = recording };
	static char line[LINE_MAX_SIZE];
	unsigned long number = 0;
	long length;

	*recording = (struct recording){ 0 };
	while ((length = next_line(stream, line, sizeof(line))) >= 0) {
		const char *wrong = NULL;

		number++;
		if ((size_t)length >= sizeof(line) - 1)
			wrong = "the line is too long";
		else if (strlen(line) != (size_t)length)
			wrong = "a byte 0 in it";
		else
			wrong = take_line(&reader, line);
		if (wrong)
			return cli_error("%s:%lu: %s", path, number, wrong);
	}
	if (ferror(stream))
		return cli_errno(errno, "%s", path);
	if (!recording->descriptor_size || !reader.info)
		return cli_error("%s:%lu: it ends without %s", path, number,
				 recording->descriptor_size ? "the ids (I:)" :
							      "a report descriptor (R:)");
	return CLI_OK;
}

void recording_free(struct recording *recording)
{
	for (size_t i = 0; i < recording->count; i++)
		free(recording->report[i].data);
	free(recording->report);
	*recording = (struct recording){ 0 };
}

static void write_bytes(FILE *stream, const uint8_t *data, size_t size)
{
	fprintf(stream, " %zu", size);
	for (size_t i = 0; i < size; i++)
		fprintf(stream, " %02x", data[i]);
	fputc('\n', stream);
}

void recording_write_head(FILE *stream, const struct recording *recording)
{
	fprintf(stream, "R:");
	write_bytes(stream, recording->descriptor, recording->descriptor_size);
	fprintf(stream, "N: %s\nP: %s\nI: %x %04x %04x\n", recording->name, recording->phys,
		recording->bus, recording->vendor, recording->product);
}

void recording_write_report(FILE *stream, uint64_t us, const uint8_t *data, size_t size)
{
	fprintf(stream, "E: %06llu.%06llu", (unsigned long long)us / 1000000,
		(unsigned long long)us % 1000000);
	write_bytes(stream, data, size);
}
