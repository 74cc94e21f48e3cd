/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * An example of a protocol page, as passed by `check` and as returned by a codec
 */
#ifndef EXAMPLE_H
#define EXAMPLE_H

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#define EXAMPLE_BYTES	512
#define EXAMPLE_WORDS	1024

/**
 * struct example - bytes, and their meaning
 * @kind: kind of bytes
 * @about: subject: the model, the data lines ...
 * @bytes: the bytes
 * @size: their number
 * @words: their meaning
 */
struct example {
	char *kind;
	char *about;
	u8 bytes[EXAMPLE_BYTES];
	size_t size;
	char words[EXAMPLE_WORDS];
};

/* Append to the words, separated by @part unless there are none */
static inline void example_add(struct example *example, const char *part, const char *format, ...)
{
	size_t length = strlen(example->words);
	va_list list;

	length += snprintf(example->words + length, EXAMPLE_WORDS - length, "%s",
			   length ? part : "");
	va_start(list, format);
	vsnprintf(example->words + length, EXAMPLE_WORDS - length, format, list);
	va_end(list);
}

/* The example of this line: KIND;ABOUT;BYTES;WORDS */
static inline void example_read(char *line, struct example *example)
{
	char *field[4], *at;

	for (size_t i = 0; i < ARRAY_SIZE(field); i++)
		field[i] = strsep(&line, ";\n");
	example->kind = field[0];
	example->about = field[1];
	example->size = 0;
	for (at = field[2]; *at && example->size < EXAMPLE_BYTES; at += strspn(at, " "))
		example->bytes[example->size++] = strtoul(at, &at, 16);
	snprintf(example->words, EXAMPLE_WORDS, "%s", field[3]);
}

/**
 * struct example_kind - conversion of one kind of example by a codec
 * @kind: its name
 * @judge: convert the bytes to words, or the words to bytes
 */
struct example_kind {
	const char *kind;
	void (*judge)(struct example *example);
};

static inline void example_judge(const struct example_kind *kinds, size_t count,
				 struct example *example)
{
	for (size_t i = 0; i < count; i++)
		if (!strcmp(example->kind, kinds[i].kind))
			return kinds[i].judge(example);
	fprintf(stderr, "unknown kind of example: %s\n", example->kind);
	exit(3);
}

/* For each line of standard input print the bytes and the words of the codec */
static inline int example_main(const struct example_kind *kinds, size_t count)
{
	char line[EXAMPLE_BYTES * 3 + EXAMPLE_WORDS];

	while (fgets(line, sizeof(line), stdin)) {
		struct example example;

		example_read(line, &example);
		example_judge(kinds, count, &example);
		for (size_t i = 0; i < example.size; i++)
			printf("%s%02x", i ? " " : "", example.bytes[i]);
		printf(";%s\n", example.words);
	}
	return fflush(stdout) ? 2 : 0;
}

#endif /* EXAMPLE_H */
