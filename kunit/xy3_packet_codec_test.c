// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: packets from the byte stream of the backchannel
 *
 * The same source runs in a kernel and, under sanitizers, on the host. Streams are in the notation
 * of stream_of(). "ruled" in the name of a row: the case is decided on the protocol page.
 */

#include <kunit/test.h>
#include <linux/module.h>

/* not linked but included: the codec exports no symbols */
#include "../drivers/xy3/xy3-packet.c"
#include "xy3_stream.h"

/* ---- finding and losing sync ---- */

#define SYNC	"48 41 00 "		/* a sync packet; with the next start it is the sequence */
#define NEXT	"48 07 01 03"		/* a packet to come after it */
#define FOUND	"48 41 00 / 48 07 01 03"	/* the result of these two */

struct stream_row {
	const char *name;
	const char *stream;
	const char *packets;
	struct outcome want;
};

static const struct stream_row stream_rows[] = {
	{ "nothing", "", "", { } },
	{ "no packet before the first sync", NEXT, "", { .dropped = 4 } },
	{ "a sync packet alone waits for a start", SYNC, "", { .kept = 3 } },
	{ "the sequence", SYNC "48", SYNC, { .kept = 1, .in_sync = true } },
	{ "the sequence, and on", SYNC NEXT, FOUND, { .in_sync = true } },
	{ "noise before it", "00 ff 41 00 " SYNC NEXT, FOUND, { .dropped = 4, .in_sync = true } },
	{ "four of its bytes before it", "00 41 00 41 " SYNC NEXT, FOUND,
	  { .dropped = 4, .in_sync = true } },
	{ "overlap 48 48 41 00 48 (ruled)", "48 " SYNC NEXT, FOUND,
	  { .dropped = 1, .in_sync = true } },
	{ "overlap 48 41 48 41 00 48 (ruled)", "48 41 " SYNC NEXT, FOUND,
	  { .dropped = 2, .in_sync = true } },
	{ "overlap of three starts", "48 48 48 " SYNC NEXT, FOUND,
	  { .dropped = 3, .in_sync = true } },
	{ "overlap of both kinds", "48 41 48 48 41 48 " SYNC NEXT, FOUND,
	  { .dropped = 6, .in_sync = true } },
	{ "00 in place of the next start", SYNC "00 " SYNC NEXT, FOUND,
	  { .dropped = 4, .in_sync = true } },
	{ "41 in place of the next start", SYNC "41 " SYNC NEXT, FOUND,
	  { .dropped = 4, .in_sync = true } },
	{ "41 00 again in place of the next start", SYNC "41 00 48 41", "",
	  { .dropped = 5, .kept = 2 } },
	{ "41 twice", "48 41 41 00 " SYNC NEXT, FOUND, { .dropped = 4, .in_sync = true } },
	{ "41 left out", "48 00 " SYNC NEXT, FOUND, { .dropped = 2, .in_sync = true } },
	{ "each start is the next sequence's", SYNC SYNC SYNC "48",
	  "48 41 00 / 48 41 00 / 48 41 00", { .kept = 1, .in_sync = true } },
	{ "a sync packet in sync is no new sync", SYNC NEXT " " SYNC NEXT, FOUND " / " FOUND,
	  { .in_sync = true } },
	{ "first sync after much noise", "a5*300 " SYNC NEXT, FOUND,
	  { .dropped = 300, .in_sync = true } },
	{ "starts only", "48*300", "", { .dropped = 299, .kept = 1 } },

	{ "a byte between packets", SYNC NEXT " 00 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 1, .resyncs = 1, .in_sync = true } },
	{ "41 between packets", SYNC NEXT " 41 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 1, .resyncs = 1, .in_sync = true } },
	{ "the sequence behind a byte that broke sync (ruled)", SYNC "48 41 00 ff " SYNC "48",
	  "48 41 00 / 48 41 00 / 48 41 00",
	  { .dropped = 1, .resyncs = 1, .kept = 1, .in_sync = true } },
	{ "without a sequence nothing more is found", SYNC NEXT " 00 " NEXT " " NEXT, FOUND,
	  { .dropped = 9 } },
	{ "start of a packet lost", SYNC NEXT " 07 01 04 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 3, .resyncs = 1, .in_sync = true } },
	{ "start of a packet doubled is type 48h", SYNC "48 48 07 01 04*5 " SYNC NEXT,
	  SYNC "/ 48 48 07 01 04*5 48", { .unknown = 1, .dropped = 6 } },
	{ "byte of a payload lost", SYNC "48 07 02 03 " NEXT " " SYNC NEXT,
	  SYNC "/ 48 07 02 03 48 / " FOUND,
	  { .dropped = 3, .resyncs = 1, .in_sync = true } },
	{ "byte of a payload doubled", SYNC "48 07 01 03 03 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 1, .resyncs = 1, .in_sync = true } },
	{ "lost twice, found twice", SYNC NEXT " 00 " SYNC NEXT " 00 " SYNC NEXT,
	  FOUND " / " FOUND " / " FOUND, { .dropped = 2, .resyncs = 2, .in_sync = true } },
	{ "a torn packet takes what follows for its own", SYNC "48 09 58 01 00 " SYNC NEXT, SYNC,
	  { .kept = 12, .in_sync = true } },

	{ "illegal length 0", SYNC "48 07 00 " SYNC NEXT, SYNC "/ " FOUND,
	  { .dropped = 3, .bad_lengths = 1, .resyncs = 1, .in_sync = true } },
	{ "48 07 48 41 00 48: its length is the start", SYNC "48 07 " SYNC NEXT, SYNC "/ " FOUND,
	  { .dropped = 2, .bad_lengths = 1, .resyncs = 1, .in_sync = true } },
	{ "48 41 48 41 00 48 in sync: a sync packet's length", SYNC "48 41 " SYNC NEXT,
	  SYNC "/ " FOUND,
	  { .dropped = 2, .bad_lengths = 1, .resyncs = 1, .in_sync = true } },
	{ "48 48 41 00 48 in sync is an unknown type", SYNC "48 " SYNC "48", SYNC,
	  { .kept = 5, .in_sync = true } },
	{ "illegal length whose payload holds the sequence", SYNC "48 07 17 " SYNC NEXT " 00*14",
	  SYNC "/ " FOUND, { .dropped = 17, .bad_lengths = 1, .resyncs = 1 } },
	{ "illegal length, then no sequence", SYNC "48 05 03 00*3 " NEXT, SYNC,
	  { .dropped = 10, .bad_lengths = 1 } },
	{ "illegal lengths out of sync count for nothing", "48 07 00 48 05 01 48 41 01", "",
	  { .dropped = 9 } },
	{ "sync packet with a payload", SYNC "48 41 01 00 " SYNC NEXT, SYNC "/ " FOUND,
	  { .dropped = 4, .bad_lengths = 1, .resyncs = 1, .in_sync = true } },

	{ "unknown type is handed out", SYNC "48 0a 02 01 02 " NEXT,
	  SYNC "/ 48 0a 02 01 02 / " NEXT, { .unknown = 1, .in_sync = true } },
	{ "unknown type, empty", SYNC "48 00 00 " NEXT, SYNC "/ 48 00 00 / " NEXT,
	  { .unknown = 1, .in_sync = true } },
	{ "unknown type of 255 bytes", SYNC "48 ff ff 48*255 " NEXT,
	  SYNC "/ 48 ff ff 48*255 / " NEXT, { .unknown = 1, .in_sync = true } },
	{ "unknown type with the sequence inside", SYNC "48 7f 05 " SYNC "48 41 " NEXT,
	  SYNC "/ 48 7f 05 " SYNC "48 41 / " NEXT, { .unknown = 1, .in_sync = true } },
	{ "known type with the sequence inside", SYNC "48 07 04 " SYNC "48 " NEXT,
	  SYNC "/ 48 07 04 " SYNC "48 / " NEXT, { .in_sync = true } },
	{ "an unfinished packet is kept", SYNC "48 07 16 48*21", SYNC,
	  { .kept = 24, .in_sync = true } },
	{ "an unfinished packet of 255 bytes", SYNC "48 ff ff a5*254", SYNC,
	  { .kept = 257, .in_sync = true } },

	/* joined within a payload that contains the sequence: 03 04 48 41 00 48 11 00 05 */
	{ "false sync heals by the start", "03 04 " SYNC "48 11 00 05 " NEXT " " SYNC NEXT,
	  SYNC "/ 48 11 00 / " FOUND,
	  { .dropped = 7, .unknown = 1, .resyncs = 1, .in_sync = true } },
	{ "false sync heals by the length", "03 04 " SYNC "48 06 15 05 " NEXT " " SYNC NEXT,
	  SYNC "/ " FOUND, { .dropped = 10, .bad_lengths = 1, .resyncs = 1, .in_sync = true } },
	{ "false sync in the place of a lost one",
	  SYNC NEXT " 07 05 " SYNC "48 00 00 01 " SYNC NEXT,
	  FOUND " / " SYNC "/ 48 00 00 / " FOUND,
	  { .dropped = 3, .unknown = 1, .resyncs = 2, .in_sync = true } },
};

static void stream_row_name(const struct stream_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(stream, stream_rows, stream_row_name);

static void stream_test(struct kunit *test)
{
	const struct stream_row *row = test->param_value;

	check_every_way(test, stream_of(test, row->stream), stream_of(test, row->packets),
			&row->want);
}

/* ---- damaged bytes ---- */

static const struct stream_row damage_rows[] = {
	{ "nothing damaged", SYNC NEXT " " SYNC NEXT, FOUND " / " FOUND, { .in_sync = true } },
	{ "before anything", "!48 " SYNC NEXT, FOUND, { .dropped = 1, .in_sync = true } },
	{ "alone", "!00", "", { .dropped = 1 } },
	{ "between packets", SYNC NEXT " !00 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 1, .resyncs = 1, .in_sync = true } },
	{ "behind the last packet", SYNC NEXT " !48", FOUND, { .dropped = 1 } },
	{ "start", SYNC NEXT " !48 07 01 04 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 4, .resyncs = 1, .in_sync = true } },
	{ "type", SYNC NEXT " 48 !07 01 04 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 4, .resyncs = 1, .in_sync = true } },
	{ "length", SYNC NEXT " 48 07 !01 04 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 4, .resyncs = 1, .in_sync = true } },
	{ "payload", SYNC NEXT " 48 07 01 !04 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 4, .resyncs = 1, .in_sync = true } },
	{ "middle of a payload", SYNC NEXT " 48 07 05 01 02 !03 04 05 " SYNC NEXT,
	  FOUND " / " FOUND,
	  { .dropped = 8, .resyncs = 1, .in_sync = true } },
	{ "payload of an unknown type", SYNC NEXT " 48 0a 03 01 !02 03 " SYNC NEXT,
	  FOUND " / " FOUND,
	  { .dropped = 6, .resyncs = 1, .in_sync = true } },
	{ "several in a row", SYNC NEXT " 48 07 !05*5 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 7, .resyncs = 1, .in_sync = true } },
	{ "every other byte", SYNC NEXT " !48 07 !01 04 !00 00 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 6, .resyncs = 1, .in_sync = true } },
	{ "first of the sequence", SYNC NEXT " !48 41 00 48 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 4, .resyncs = 1, .in_sync = true } },
	{ "second of the sequence", SYNC NEXT " 00 48 !41 00 48 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 5, .resyncs = 1, .in_sync = true } },
	{ "third of the sequence", SYNC NEXT " 00 48 41 !00 48 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 5, .resyncs = 1, .in_sync = true } },
	{ "last of the sequence", SYNC NEXT " 00 48 41 00 !48 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 5, .resyncs = 1, .in_sync = true } },
	{ "none of the first sequence, then one", "48 41 !00 48 " SYNC NEXT, FOUND,
	  { .dropped = 4, .in_sync = true } },
	{ "a damaged byte does not count as a start", SYNC "!48 07 01 04", "", { .dropped = 7 } },
	{ "the rest of a packet is not a packet", SYNC NEXT " 48 ff ff 01 !02 " NEXT " " NEXT,
	  FOUND, { .dropped = 13 } },
	{ "255 bytes are dropped", SYNC NEXT " 48 ff ff a5*254 !a5 " SYNC NEXT, FOUND " / " FOUND,
	  { .dropped = 258, .resyncs = 1, .in_sync = true } },
};

KUNIT_ARRAY_PARAM(damage, damage_rows, stream_row_name);

static void damage_test(struct kunit *test)
{
	stream_test(test);
}

/* ---- types and lengths ---- */

struct length_row {
	const char *name;
	u8 type;
	u8 length;
	bool legal;
};

static const struct length_row length_rows[] = {
	{ "vendor 01h, empty", 0x01, 0, false },
	{ "vendor, one below the shortest", 0x01, 2, false },
	{ "vendor, shortest", 0x01, 3, true },
	{ "vendor, one above the shortest", 0x01, 4, true },
	{ "vendor, one below the longest", 0x01, 199, true },
	{ "vendor, longest", 0x01, 200, true },
	{ "vendor, one above the longest", 0x01, 201, false },
	{ "vendor, 255", 0x01, 255, false },
	{ "model 02h, empty", 0x02, 0, false },
	{ "model, one below the shortest", 0x02, 2, false },
	{ "model, shortest", 0x02, 3, true },
	{ "model, one above the shortest", 0x02, 4, true },
	{ "model, one below the longest", 0x02, 199, true },
	{ "model, longest", 0x02, 200, true },
	{ "model, one above the longest", 0x02, 201, false },
	{ "model, 255", 0x02, 255, false },
	{ "firmware 03h, empty", 0x03, 0, false },
	{ "firmware, one below the shortest", 0x03, 2, false },
	{ "firmware, shortest", 0x03, 3, true },
	{ "firmware, one above the shortest", 0x03, 4, true },
	{ "firmware, one below the longest", 0x03, 199, true },
	{ "firmware, longest", 0x03, 200, true },
	{ "firmware, one above the longest", 0x03, 201, false },
	{ "firmware, 255", 0x03, 255, false },
	{ "serial 04h, empty", 0x04, 0, false },
	{ "serial, one below the shortest", 0x04, 2, false },
	{ "serial, shortest", 0x04, 3, true },
	{ "serial, one above the shortest", 0x04, 4, true },
	{ "serial, one below the longest", 0x04, 199, true },
	{ "serial, longest", 0x04, 200, true },
	{ "serial, one above the longest", 0x04, 201, false },
	{ "serial, 255", 0x04, 255, false },
	{ "debug 08h, empty", 0x08, 0, false },
	{ "debug, one below the shortest", 0x08, 2, false },
	{ "debug, shortest", 0x08, 3, true },
	{ "debug, one above the shortest", 0x08, 4, true },
	{ "debug, one below the longest", 0x08, 199, true },
	{ "debug, longest", 0x08, 200, true },
	{ "debug, one above the longest", 0x08, 201, false },
	{ "debug, 255", 0x08, 255, false },
	{ "temperatures 05h, empty", 0x05, 0, false },
	{ "temperatures, one below the shortest", 0x05, 1, false },
	{ "temperatures, shortest", 0x05, 2, true },
	{ "temperatures, odd", 0x05, 3, false },
	{ "temperatures, two", 0x05, 4, true },
	{ "temperatures, 42", 0x05, 42, true },
	{ "temperatures, one below the longest is odd", 0x05, 43, false },
	{ "temperatures, longest", 0x05, 44, true },
	{ "temperatures, one above the longest", 0x05, 45, false },
	{ "temperatures, even above the longest", 0x05, 46, false },
	{ "temperatures, 254", 0x05, 254, false },
	{ "temperatures, 255", 0x05, 255, false },
	{ "frame errors 06h, empty", 0x06, 0, false },
	{ "frame errors, four axes", 0x06, 16, false },
	{ "frame errors, one below", 0x06, 19, false },
	{ "frame errors, their length", 0x06, 20, true },
	{ "frame errors, one above", 0x06, 21, false },
	{ "frame errors, six axes", 0x06, 24, false },
	{ "frame errors, 255", 0x06, 255, false },
	{ "errors 07h, empty", 0x07, 0, false },
	{ "errors, shortest", 0x07, 1, true },
	{ "errors, two", 0x07, 2, true },
	{ "errors, one below the longest", 0x07, 21, true },
	{ "errors, longest", 0x07, 22, true },
	{ "errors, one above the longest", 0x07, 23, false },
	{ "errors, 255", 0x07, 255, false },
	{ "hours 09h, empty", 0x09, 0, false },
	{ "hours, one below the shortest", 0x09, 3, false },
	{ "hours, shortest", 0x09, 4, true },
	{ "hours, one above the shortest", 0x09, 5, false },
	{ "hours, one and a half", 0x09, 6, false },
	{ "hours, one below two", 0x09, 7, false },
	{ "hours, two", 0x09, 8, true },
	{ "hours, 84", 0x09, 84, true },
	{ "hours, one below the longest", 0x09, 87, false },
	{ "hours, longest", 0x09, 88, true },
	{ "hours, one above the longest", 0x09, 89, false },
	{ "hours, 92", 0x09, 92, false },
	{ "hours, 252", 0x09, 252, false },
	{ "hours, 255", 0x09, 255, false },
	{ "sync 41h, empty", 0x41, 0, true },
	{ "sync, one byte", 0x41, 1, false },
	{ "sync, 255", 0x41, 255, false },
	{ "type 00h, below the first, empty", 0x00, 0, true },
	{ "type 00h, below the first, one byte", 0x00, 1, true },
	{ "type 00h, below the first, 255", 0x00, 255, true },
	{ "type 0Ah, behind the last, empty", 0x0a, 0, true },
	{ "type 0Ah, behind the last, one byte", 0x0a, 1, true },
	{ "type 0Ah, behind the last, 255", 0x0a, 255, true },
	{ "type 40h, empty", 0x40, 0, true },
	{ "type 40h, one byte", 0x40, 1, true },
	{ "type 40h, 255", 0x40, 255, true },
	{ "type 42h, empty", 0x42, 0, true },
	{ "type 42h, one byte", 0x42, 1, true },
	{ "type 42h, 255", 0x42, 255, true },
	{ "type 48h, as the start, empty", 0x48, 0, true },
	{ "type 48h, as the start, one byte", 0x48, 1, true },
	{ "type 48h, as the start, 255", 0x48, 255, true },
	{ "type 81h, vendor but for the top bit, empty", 0x81, 0, true },
	{ "type 81h, vendor but for the top bit, one byte", 0x81, 1, true },
	{ "type 81h, vendor but for the top bit, 255", 0x81, 255, true },
	{ "type FFh, empty", 0xff, 0, true },
	{ "type FFh, one byte", 0xff, 1, true },
	{ "type FFh, 255", 0xff, 255, true },
};

static void length_row_name(const struct length_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(length, length_rows, length_row_name);

/* The packet of the row between sync packets, split at every position */
static void length_test(struct kunit *test)
{
	const struct length_row *row = test->param_value;
	struct outcome want = { .kept = 1, .in_sync = true };
	struct stream *stream = stream_of(test, SYNC);
	struct stream *packets = stream_of(test, SYNC);
	u8 head[] = { 0x48, row->type, row->length };
	u8 tail[] = { 0x48, 0x41, 0x00, 0x48 };

	for (unsigned int i = 0; i < sizeof(head) + row->length; i++) {
		u8 byte = i < sizeof(head) ? head[i] : 0x80 | i;

		stream_add(test, stream, byte, false);
		if (row->legal)
			stream_add(test, packets, byte, false);
	}
	for (unsigned int i = 0; i < sizeof(tail); i++)
		stream_add(test, stream, tail[i], false);
	if (row->legal) {
		stream_end_packet(test, packets);
		want.unknown = !is_known_type(row->type);
	} else {
		want.dropped = sizeof(head) + row->length;
		want.bad_lengths = 1;
		want.resyncs = 1;
	}
	for (unsigned int i = 0; i < 3; i++)
		stream_add(test, packets, tail[i], false);
	stream_end_packet(test, packets);

	check_every_way(test, stream, packets, &want);
}

/* ---- chunks of any size ---- */

#define LONG_SIZE	(3 * 65536)

struct chunk_row {
	const char *name;
	size_t size;
};

static const struct chunk_row chunk_rows[] = {
	{ "1 byte", 1 },
	{ "2 bytes", 2 },
	{ "3 bytes", 3 },
	{ "7 bytes", 7 },
	{ "16 bytes, an 8250's FIFO", 16 },
	{ "62 bytes, an FTDI's packet", 62 },
	{ "255 bytes", 255 },
	{ "258 bytes, the longest packet", 258 },
	{ "4095 bytes", 4095 },
	{ "64 KiB less 1", 65535 },
	{ "64 KiB", 65536 },
	{ "64 KiB and 1", 65537 },
	{ "all at once", LONG_SIZE },
};

KUNIT_ARRAY_PARAM_DESC(chunk, chunk_rows, name);

/* An endless sequence of packets, by a fixed rule: every length, with sync packets between them */
static void fill_with_packets(u8 *bytes, size_t size, size_t *whole, u64 *packets)
{
	u8 packet[XY3_PACKET_MAX];
	u32 random = 1;
	size_t part;

	*packets = 0;
	*whole = 0;
	for (size_t at = 0; at < size; at += part) {
		packet[0] = 0x48;
		packet[1] = *packets % 2 ? 0x80 : 0x41;
		packet[2] = *packets % 2 ? *packets / 2 : 0;
		part = 3 + packet[2];
		for (size_t i = 3; i < part; i++) {
			random = random * 1664525 + 1013904223;
			packet[i] = random >> 24;
		}
		if (at + part < size) {
			*whole = at + part;
			++*packets;
		}
		memcpy(bytes + at, packet, min(part, size - at));
	}
}

static void chunk_test(struct kunit *test)
{
	const struct chunk_row *row = test->param_value;
	struct xy3_parser *parser = kunit_kzalloc(test, sizeof(*parser), GFP_KERNEL);
	u8 *bytes = kunit_kmalloc(test, LONG_SIZE, GFP_KERNEL);
	struct xy3_packet packet;
	size_t whole, heard = 0;
	u64 packets;

	KUNIT_ASSERT_NOT_NULL(test, parser);
	KUNIT_ASSERT_NOT_NULL(test, bytes);
	fill_with_packets(bytes, LONG_SIZE, &whole, &packets);

	for (size_t at = 0; at < LONG_SIZE; at += row->size) {
		size_t size = min(row->size, LONG_SIZE - at);
		const u8 *data = bytes + at;

		while (xy3_parse(parser, &data, &size, &packet)) {
			KUNIT_ASSERT_MEMEQ(test, packet.raw, bytes + heard,
					   xy3_packet_size(&packet));
			heard += xy3_packet_size(&packet);
		}
		KUNIT_ASSERT_EQ(test, size, (size_t)0);
		KUNIT_ASSERT_PTR_EQ(test, data, bytes + min(at + row->size, (size_t)LONG_SIZE));
	}
	KUNIT_EXPECT_EQ(test, heard, whole);
	KUNIT_EXPECT_EQ(test, parser->packets, packets);
	KUNIT_EXPECT_EQ(test, parser->packet_bytes, (u64)whole);
	KUNIT_EXPECT_EQ(test, parser->dropped_bytes, 0ULL);
	KUNIT_EXPECT_EQ(test, parser->kept, LONG_SIZE - whole);
}

/* ---- corner cases of calls ---- */

static void empty_test(struct kunit *test)
{
	struct listener *listener = listener_new(test);
	const struct stream *stream = stream_of(test, SYNC "48 07 02 01 02");

	/* no data, before, within and after a packet: nothing happens, nothing is read */
	for (size_t at = 0; at <= stream->size; at++) {
		struct xy3_parser before = listener->parser;

		hear_chunk(test, listener, stream->byte, 0);
		KUNIT_EXPECT_MEMEQ(test, &before, &listener->parser, sizeof(before));
		if (at < stream->size)
			hear(test, listener, stream, at, at + 1);
	}
	KUNIT_EXPECT_EQ(test, listener->heard.packets, 2U);
}

static void lost_test(struct kunit *test)
{
	struct listener *listener = listener_new(test);
	const struct stream *stream = stream_of(test, SYNC "48 07 02 01");

	hear(test, listener, stream, 0, stream->size);
	KUNIT_ASSERT_TRUE(test, listener->parser.in_sync);
	KUNIT_ASSERT_EQ(test, listener->parser.kept, 4);

	/* sync is also lost without a lost byte: a break, an overrun */
	xy3_parse_lost(&listener->parser, 0);
	KUNIT_EXPECT_FALSE(test, listener->parser.in_sync);
	KUNIT_EXPECT_EQ(test, listener->parser.kept, 0);
	KUNIT_EXPECT_EQ(test, listener->parser.dropped_bytes, 4ULL);
	check_accounts(test, listener);

	/* packets found later do not depend on kept bytes */
	hear(test, listener, stream, 0, stream->size);
	KUNIT_EXPECT_EQ(test, listener->parser.resyncs, 1ULL);
	KUNIT_EXPECT_EQ(test, listener->heard.packets, 2U);
}

static struct kunit_case xy3_packet_cases[] = {
	KUNIT_CASE_PARAM(stream_test, stream_gen_params),
	KUNIT_CASE_PARAM(damage_test, damage_gen_params),
	KUNIT_CASE_PARAM(length_test, length_gen_params),
	KUNIT_CASE_PARAM(chunk_test, chunk_gen_params),
	KUNIT_CASE(empty_test),
	KUNIT_CASE(lost_test),
	{}
};

static struct kunit_suite xy3_packet_suite = {
	.name = "xy3_packet",
	.test_cases = xy3_packet_cases,
};

kunit_test_suite(xy3_packet_suite);

MODULE_DESCRIPTION("KUnit tests of the XY3-100 packet codec");
MODULE_LICENSE("GPL");
