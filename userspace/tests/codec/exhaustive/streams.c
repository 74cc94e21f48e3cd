// SPDX-License-Identifier: GPL-2.0-only
/*
 * Every stream of some bytes, from those with a meaning in the backchannel, passed byte by byte and
 * at once, against a reference that reads the whole stream from its start each time.
 */
#include "../../../../drivers/xy3/xy3-packet.c"
#include <kunit/test.h>

#define LONGEST		16
#define OUT_MAX		64	/* a byte is in at most one packet, except when counting below */

/* One byte of a stream; DAMAGED is a byte with a line error */
enum { DAMAGED = -1 };

static const int alphabet[] = { 0x48, 0x41, 0x00, 0x07, 0x01, 0xa5, DAMAGED };

struct result {
	u8 out[OUT_MAX];	/* the packets, concatenated */
	size_t size;
	u64 packets;
	u64 unknown;
	u64 dropped;
	u64 bad_lengths;
	u64 resyncs;
	size_t kept;
	bool in_sync;
};

/* ---- the reference ---- */

static bool follows(const int *stream, size_t at, size_t end, int a, int b, int c, int d)
{
	return end - at >= 4 && stream[at] == a && stream[at + 1] == b && stream[at + 2] == c &&
	       stream[at + 3] == d;
}

/* The number of last bytes that may be the start of the sequence */
static size_t promising(const int *stream, size_t at, size_t end)
{
	size_t left = end - at;

	if (left >= 3 && stream[end - 3] == 0x48 && stream[end - 2] == 0x41 && !stream[end - 1])
		return 3;
	if (left >= 2 && stream[end - 2] == 0x48 && stream[end - 1] == 0x41)
		return 2;
	return left >= 1 && stream[end - 1] == 0x48;
}

/* 1 good, 0 unknown, -1 illegal; only known types that are in the alphabet */
static int judge(int type, int length)
{
	switch (type) {
	case 0x01:
		return length >= 3 && length <= 200 ? 1 : -1;
	case 0x07:
		return length >= 1 && length <= 22 ? 1 : -1;
	case 0x41:
		return length == 0 ? 1 : -1;
	default:
		return 0;
	}
}

static void hand_out(struct result *r, const int *stream, size_t size)
{
	for (size_t i = 0; i < size; i++)
		r->out[r->size++] = stream[i];
	r->packets++;
}

/* Undamaged bytes from at to end, out of sync before them */
static void undamaged(struct result *r, const int *stream, size_t at, size_t end, bool *had_sync)
{
	r->in_sync = false;
	r->kept = 0;
	while (at < end) {
		int verdict;

		if (!r->in_sync && follows(stream, at, end, 0x48, 0x41, 0x00, 0x48)) {
			hand_out(r, stream + at, 3);
			at += 3;
			r->in_sync = true;
			r->resyncs += *had_sync;
			*had_sync = true;
			continue;
		}
		if (!r->in_sync) {
			if (promising(stream, at, end) == end - at) {
				r->kept = end - at;
				return;
			}
			r->dropped++;
			at++;
			continue;
		}
		if (stream[at] != 0x48) {
			r->in_sync = false;
			continue;
		}
		if (end - at < 3) {
			r->kept = end - at;
			return;
		}
		verdict = judge(stream[at + 1], stream[at + 2]);
		if (verdict < 0) {
			r->bad_lengths++;
			r->in_sync = false;
			r->dropped++;
			at++;
			continue;
		}
		if (end - at < 3 + (size_t)stream[at + 2]) {
			r->kept = end - at;
			return;
		}
		r->unknown += verdict == 0;
		hand_out(r, stream + at, 3 + stream[at + 2]);
		at += 3 + stream[at + 2];
	}
}

static struct result reference(const int *stream, size_t size)
{
	struct result r = {};
	bool had_sync = false;
	size_t at = 0;

	while (at < size) {
		size_t end = at;

		while (end < size && stream[end] != DAMAGED)
			end++;
		undamaged(&r, stream, at, end, &had_sync);
		at = end;
		if (at < size) {
			r.dropped += r.kept + 1;
			r.kept = 0;
			r.in_sync = false;
			at++;
		}
	}
	return r;
}

/* ---- the codec ---- */

struct reader {
	struct xy3_parser parser;
	u8 out[OUT_MAX];
	size_t size;
};

static void give(struct reader *reader, const u8 *data, size_t size)
{
	struct xy3_packet packet;

	while (xy3_parse(&reader->parser, &data, &size, &packet)) {
		memcpy(reader->out + reader->size, packet.raw, xy3_packet_size(&packet));
		reader->size += xy3_packet_size(&packet);
	}
}

static void give_all(struct reader *reader, const int *stream, size_t size)
{
	u8 bytes[LONGEST];
	size_t n = 0;

	for (size_t i = 0; i < size; i++) {
		if (stream[i] != DAMAGED) {
			bytes[n++] = stream[i];
			continue;
		}
		give(reader, bytes, n);
		xy3_parse_lost(&reader->parser, 1);
		n = 0;
	}
	give(reader, bytes, n);
}

static bool same(const struct reader *reader, const struct result *r)
{
	const struct xy3_parser *p = &reader->parser;

	return reader->size == r->size && !memcmp(reader->out, r->out, r->size) &&
	       p->packets == r->packets && p->packet_bytes == r->size &&
	       p->unknown == r->unknown && p->dropped_bytes == r->dropped &&
	       p->bad_lengths == r->bad_lengths && p->resyncs == r->resyncs &&
	       p->kept == r->kept && p->in_sync == r->in_sync;
}

static void fail(struct kunit *test, const char *how, const int *stream, size_t size)
{
	char text[3 * LONGEST + 1];
	size_t used = 0;

	for (size_t i = 0; i < size; i++)
		used += scnprintf(text + used, sizeof(text) - used, stream[i] == DAMAGED ? " !!" :
				  " %02x", (unsigned int)stream[i]);
	KUNIT_FAIL_AND_ABORT(test, "%s:%s", how, text);
}

static unsigned long long tried;

/* This stream, and every longer one that starts with it */
static void walk(struct kunit *test, const struct reader *so_far, int *stream, size_t size,
		 size_t longest)
{
	struct result want = reference(stream, size);
	struct reader at_once = {};

	if (!same(so_far, &want))
		fail(test, "byte by byte", stream, size);
	give_all(&at_once, stream, size);
	if (!same(&at_once, &want))
		fail(test, "at once", stream, size);
	tried++;

	for (size_t i = 0; size < longest && i < ARRAY_SIZE(alphabet); i++) {
		struct reader next = *so_far;
		u8 byte = alphabet[i];

		stream[size] = alphabet[i];
		if (alphabet[i] == DAMAGED)
			xy3_parse_lost(&next.parser, 1);
		else
			give(&next, &byte, 1);
		walk(test, &next, stream, size + 1, longest);
	}
}

struct beginning {
	const char *name;
	int stream[6];
	size_t size;
	size_t more;
};

/* 7^7 is 823543 */
static const struct beginning beginnings[] = {
	{ "from nothing", { 0 }, 0, 7 },
	{ "in sync", { 0x48, 0x41, 0x00 }, 3, 7 },
	{ "behind a packet and a stray byte", { 0x48, 0x41, 0x00, 0x48, 0x41, 0x01 }, 6, 6 },
	{ "within an error packet", { 0x48, 0x41, 0x00, 0x48, 0x07 }, 5, 6 },
};

KUNIT_ARRAY_PARAM_DESC(beginnings, beginnings, name);

static void every_short_stream(struct kunit *test)
{
	const struct beginning *from = test->param_value;
	struct reader reader = {};
	int stream[LONGEST];
	unsigned long long want = 0, level = 1;

	memcpy(stream, from->stream, sizeof(from->stream));
	give_all(&reader, stream, from->size);
	tried = 0;
	walk(test, &reader, stream, from->size, from->size + from->more);

	for (size_t i = 0; i <= from->more; i++, level *= ARRAY_SIZE(alphabet))
		want += level;
	KUNIT_EXPECT_EQ(test, tried, want);
}

/* ---- every type with every length ---- */

/* The legal lengths of a type, from the description of the format; -1 for an unknown type */
static int legal(unsigned int type, unsigned int length)
{
	switch (type) {
	case 1: case 2: case 3: case 4: case 8:
		return length >= 3 && length <= 200;
	case 5:
		return length >= 2 && length <= 44 && length % 2 == 0;
	case 6:
		return length == 20;
	case 7:
		return length >= 1 && length <= 22;
	case 9:
		return length >= 4 && length <= 88 && length % 4 == 0;
	case 0x41:
		return length == 0;
	default:
		return -1;
	}
}

static void every_type_with_every_length(struct kunit *test)
{
	for (unsigned int type = 0; type < 256; type++)
		for (unsigned int length = 0; length < 256; length++) {
			size_t size = 3 + 3 + length;
			u8 *stream = kunit_kzalloc(test, size, GFP_KERNEL);
			struct xy3_parser parser = {};
			struct xy3_packet packet;
			const u8 *data = stream;
			int want = legal(type, length);

			memcpy(stream, "\x48\x41\x00\x48", 4);
			stream[4] = type;
			stream[5] = length;
			KUNIT_ASSERT_TRUE(test, xy3_parse(&parser, &data, &size, &packet));
			KUNIT_ASSERT_EQ_MSG(test, xy3_parse(&parser, &data, &size, &packet),
					    want != 0, "type %#x length %u", type, length);
			KUNIT_ASSERT_EQ(test, parser.bad_lengths, (u64)(want == 0));
			KUNIT_ASSERT_EQ(test, parser.unknown, (u64)(want < 0));
			KUNIT_ASSERT_EQ(test, parser.in_sync, want != 0);
			if (want) {
				KUNIT_ASSERT_EQ(test, packet.length, length);
				KUNIT_ASSERT_EQ(test, packet.known, want > 0);
				KUNIT_ASSERT_EQ(test, size, 0);
			}
			kunit_kfree(test, stream);
		}
}

static struct kunit_case cases[] = {
	KUNIT_CASE_PARAM(every_short_stream, beginnings_gen_params),
	KUNIT_CASE(every_type_with_every_length),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_streams", .test_cases = cases };
kunit_test_suite(suite);
