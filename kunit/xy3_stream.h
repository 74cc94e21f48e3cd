/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * For tests of the packet codec: streams in text form, and a listener that checks the counters of
 * the codec after every call. To be included after the codec itself.
 */
#ifndef XY3_STREAM_H
#define XY3_STREAM_H

#include <kunit/test.h>
#include <linux/ctype.h>

#define STREAM_MAX	1024
#define STREAM_PACKETS	32

/* Bytes on the line, and the ends of packets in them */
struct stream {
	size_t size;
	u8 byte[STREAM_MAX];
	bool damaged[STREAM_MAX];
	unsigned int packets;
	size_t end[STREAM_PACKETS];
};

static void stream_add(struct kunit *test, struct stream *stream, u8 byte, bool damaged)
{
	KUNIT_ASSERT_LT(test, stream->size, (size_t)STREAM_MAX);
	stream->byte[stream->size] = byte;
	stream->damaged[stream->size++] = damaged;
}

static void stream_end_packet(struct kunit *test, struct stream *stream)
{
	KUNIT_ASSERT_LT(test, stream->packets, (unsigned int)STREAM_PACKETS);
	stream->end[stream->packets++] = stream->size;
}

static u8 hex_of(struct kunit *test, const char **text)
{
	u8 value = 0;

	for (unsigned int i = 0; i < 2; i++, (*text)++) {
		char c = **text;

		KUNIT_ASSERT_TRUE(test, isxdigit(c) && !isupper(c));
		value = value << 4 | (isdigit(c) ? c - '0' : c - 'a' + 10);
	}
	return value;
}

static unsigned int times_of(const char **text)
{
	unsigned int times = 0;

	if (**text != '*')
		return 1;
	for ((*text)++; isdigit(**text); (*text)++)
		times = 10 * times + (**text - '0');
	return times;
}

/*
 * "48" is a byte, "48*9" nine of it, "!48" a damaged one; "/" separates packets, and is optional
 * after the last one.
 */
static struct stream *stream_of(struct kunit *test, const char *text)
{
	struct stream *stream = kunit_kzalloc(test, sizeof(*stream), GFP_KERNEL);
	size_t ended = 0;

	KUNIT_ASSERT_NOT_NULL(test, stream);
	for (; *text; text += *text == ' ') {
		bool damaged = *text == '!';
		unsigned int times;
		u8 byte;

		if (*text == '/') {
			stream_end_packet(test, stream);
			ended = stream->size;
			text++;
			continue;
		}
		text += damaged;
		byte = hex_of(test, &text);
		times = times_of(&text);
		while (times--)
			stream_add(test, stream, byte, damaged);
	}
	if (stream->size > ended)
		stream_end_packet(test, stream);
	return stream;
}

/* A parser, its input and its output */
struct listener {
	struct xy3_parser parser;
	u64 given;
	u64 unknown;
	struct stream heard;
};

static void listener_reset(struct listener *listener)
{
	memset(listener, 0, sizeof(*listener));
}

static struct listener *listener_new(struct kunit *test)
{
	struct listener *listener = kunit_kzalloc(test, sizeof(*listener), GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, listener);
	return listener;
}

/* The types of the document: 01h..09h and 41h */
static bool is_known_type(u8 type)
{
	return (type >= 1 && type <= 9) || type == 0x41;
}

static void check_accounts(struct kunit *test, const struct listener *listener)
{
	const struct xy3_parser *parser = &listener->parser;

	KUNIT_ASSERT_EQ(test, listener->given,
			parser->packet_bytes + parser->dropped_bytes + parser->kept);
	KUNIT_ASSERT_LT(test, (size_t)parser->kept, sizeof(parser->buffer));
	KUNIT_ASSERT_EQ(test, parser->packets, listener->heard.packets);
	KUNIT_ASSERT_EQ(test, parser->packet_bytes, listener->heard.size);
	KUNIT_ASSERT_EQ(test, parser->unknown, listener->unknown);
}

static bool hear_packet(struct kunit *test, struct listener *listener, const u8 **data,
			size_t *size)
{
	bool at_start = listener->parser.in_sync && !listener->parser.kept;
	const u8 *before = *data;
	const u8 *end = before + *size;
	struct xy3_packet packet = { };
	bool found = xy3_parse(&listener->parser, data, size, &packet);

	KUNIT_ASSERT_PTR_EQ(test, *data + *size, end);
	listener->given += *data - before;
	if (found) {
		KUNIT_ASSERT_EQ(test, packet.raw[0], 0x48);
		KUNIT_ASSERT_EQ(test, packet.raw[1], packet.type);
		KUNIT_ASSERT_EQ(test, packet.raw[2], packet.length);
		KUNIT_ASSERT_EQ(test, packet.known, is_known_type(packet.type));
		KUNIT_ASSERT_EQ(test, xy3_packet_size(&packet), (size_t)packet.length + 3);
		/* a packet that is complete in the data is not copied */
		if (at_start && *data - before == packet.length + 3)
			KUNIT_ASSERT_PTR_EQ(test, packet.raw, before);
		for (unsigned int i = 0; i < packet.length + 3u; i++)
			stream_add(test, &listener->heard, packet.raw[i], false);
		stream_end_packet(test, &listener->heard);
		listener->unknown += !packet.known;
	} else {
		KUNIT_ASSERT_EQ(test, *size, (size_t)0);
	}
	check_accounts(test, listener);
	return found;
}

/* One chunk, in memory of exactly its size: reads before or after it are detected */
static void hear_chunk(struct kunit *test, struct listener *listener, const u8 *bytes, size_t size)
{
	u8 *chunk = kunit_kmalloc(test, size, GFP_KERNEL);
	const u8 *data = chunk;

	KUNIT_ASSERT_NOT_NULL(test, chunk);
	memcpy(chunk, bytes, size);
	while (hear_packet(test, listener, &data, &size))
		;
	kunit_kfree(test, chunk);
}

/* From one position in a stream to another, as for a line discipline: good and damaged bytes */
static void hear(struct kunit *test, struct listener *listener, const struct stream *stream,
		 size_t from, size_t to)
{
	while (from < to) {
		bool damaged = stream->damaged[from];
		size_t size = 1;

		while (from + size < to && stream->damaged[from + size] == damaged)
			size++;
		if (damaged) {
			xy3_parse_lost(&listener->parser, size);
			listener->given += size;
			check_accounts(test, listener);
			KUNIT_ASSERT_FALSE(test, listener->parser.in_sync);
		} else {
			hear_chunk(test, listener, stream->byte + from, size);
		}
		from += size;
	}
}

/* The expected result of a stream */
struct outcome {
	u64 dropped;
	u64 bad_lengths;
	u64 unknown;
	u64 resyncs;
	unsigned int kept;
	bool in_sync;
};

static void check_outcome(struct kunit *test, const struct listener *listener,
			  const struct stream *packets, const struct outcome *want, const char *how)
{
	const struct xy3_parser *parser = &listener->parser;
	const struct stream *heard = &listener->heard;

	KUNIT_ASSERT_EQ_MSG(test, heard->packets, packets->packets, "%s", how);
	KUNIT_ASSERT_EQ_MSG(test, heard->size, packets->size, "%s", how);
	for (unsigned int i = 0; i < packets->packets; i++)
		KUNIT_ASSERT_EQ_MSG(test, heard->end[i], packets->end[i], "%s, packet %u", how, i);
	KUNIT_ASSERT_TRUE_MSG(test, !memcmp(heard->byte, packets->byte, packets->size), "%s", how);
	KUNIT_ASSERT_EQ_MSG(test, parser->dropped_bytes, want->dropped, "%s", how);
	KUNIT_ASSERT_EQ_MSG(test, parser->bad_lengths, want->bad_lengths, "%s", how);
	KUNIT_ASSERT_EQ_MSG(test, parser->unknown, want->unknown, "%s", how);
	KUNIT_ASSERT_EQ_MSG(test, parser->resyncs, want->resyncs, "%s", how);
	KUNIT_ASSERT_EQ_MSG(test, parser->kept, want->kept, "%s", how);
	KUNIT_ASSERT_EQ_MSG(test, parser->in_sync, want->in_sync, "%s", how);
}

#define STREAM_SHORT	40	/* up to here all splits into three pieces, then into two */

/* The result must be the same for all pieces of the stream */
static void check_every_way(struct kunit *test, const struct stream *stream,
			    const struct stream *packets, const struct outcome *want)
{
	struct listener *listener = listener_new(test);
	size_t size = stream->size;
	char how[48];

	for (size_t at = 0; at < size; at++)
		hear(test, listener, stream, at, at + 1);
	check_outcome(test, listener, packets, want, "byte by byte");

	for (size_t one = 0; one <= size; one++)
		for (size_t two = size <= STREAM_SHORT ? one : size; two <= size; two++) {
			listener_reset(listener);
			hear(test, listener, stream, 0, one);
			hear(test, listener, stream, one, two);
			hear(test, listener, stream, two, size);
			scnprintf(how, sizeof(how), "cut at %zu and %zu of %zu", one, two, size);
			check_outcome(test, listener, packets, want, how);
		}
}

#endif
