// SPDX-License-Identifier: GPL-2.0-only
/*
 * streams SEED COUNT [LIE]: generate streams of the backchannel, good, mutated and random ones,
 * decode them with the codec of the driver, and write input and results to standard output, for
 * `compare`. Stream LIE, counted from 0, gets a wrong number of dropped bytes.
 *
 * A record, all numbers little endian: struct record, then the steps (16 bit each: n > 0 bytes are
 * passed in one piece, or -n bytes are damaged), then the bytes passed, then the packets found.
 */
#include <stdio.h>
#include <stdlib.h>

#include "../../../../drivers/xy3/xy3-packet.c"

#define STREAM_MAX	4096
#define STEPS_MAX	STREAM_MAX

struct record {
	__le16 steps;
	__le16 bytes;
	__le16 found;		/* bytes of the packets found */
	__le16 packets;
	__le16 packet_bytes;
	__le16 dropped;
	__le16 kept;
	__le16 bad_lengths;
	__le16 unknown;
	__le16 resyncs;
	__le16 in_sync;
} __packed;

/* ---- chance ---- */

static u64 state;

static u32 chance(u32 below)
{
	state ^= state << 13;
	state ^= state >> 7;
	state ^= state << 17;
	return (state >> 32) % below;
}

static u8 telling_byte(void)
{
	static const u8 bytes[] = { 0x48, 0x48, 0x41, 0x00, 0x01, 0x07, 0x05, 0x14, 0x16, 0xff };

	return bytes[chance(sizeof(bytes))];
}

/* ---- a stream ---- */

static u8 stream[STREAM_MAX];
static bool damaged[STREAM_MAX];
static size_t size;

static void insert(size_t at, u8 byte)
{
	if (size == STREAM_MAX)
		return;
	memmove(stream + at + 1, stream + at, size - at);
	stream[at] = byte;
	size++;
}

static void add(u8 byte)
{
	insert(size, byte);
}

static void add_sequence(size_t at)
{
	insert(at, 0x48);
	insert(at, 0x00);
	insert(at, 0x41);
	insert(at, 0x48);
}

/* Lengths are mostly short, so that many streams can be tried */
static u8 good_length(u8 type)
{
	switch (type) {
	case 5:
		return 2 * (1 + chance(chance(4) ? 4 : 22));
	case 6:
		return 20;
	case 7:
		return 1 + chance(chance(4) ? 4 : 22);
	case 9:
		return 4 * (1 + chance(chance(4) ? 2 : 22));
	case 0x41:
		return 0;
	case 1: case 2: case 3: case 4: case 8:
		return 3 + chance(chance(16) ? 8 : 198);
	default:
		return chance(chance(16) ? 8 : 256);
	}
}

static void add_packet(void)
{
	u8 type = chance(12) ? 1 + chance(9) : chance(256);
	u8 length;

	if (!chance(4))
		type = 0x41;
	length = chance(16) ? good_length(type) : chance(2) ? chance(256) : chance(25);
	add(0x48);
	add(type);
	add(length);
	for (unsigned int i = 0; i < length; i++)
		add(chance(4) ? chance(256) : telling_byte());
}

static void add_packets(void)
{
	if (chance(8))
		add_sequence(0);
	size -= size ? 1 : 0;
	for (unsigned int n = 1 + chance(5); n; n--)
		add_packet();
}

static void mutate(void)
{
	size_t at = chance(size);

	switch (chance(9)) {
	case 0:
		stream[at] ^= 1 << chance(8);
		break;
	case 1:
		memmove(stream + at, stream + at + 1, size - at - 1);
		size--;
		break;
	case 2:
		insert(at, stream[at]);
		break;
	case 3:
		insert(at, chance(2) ? telling_byte() : chance(256));
		break;
	case 4:
		add_sequence(at);
		break;
	case 5:
		stream[at] = telling_byte();
		break;
	case 6:
		size = at + 1;
		break;
	case 7:	/* the tail of the stream again, as after a restart */
		for (size_t end = size; at < end; at++)
			add(stream[at]);
		break;
	default:
		for (size_t n = 1 + chance(3); n && at < size; n--)
			damaged[at++] = true;
		break;
	}
}

static void make_stream(void)
{
	u32 kind = chance(16);

	size = 0;
	memset(damaged, 0, sizeof(damaged));
	if (kind == 0) {
		for (u32 n = 1 + chance(40); n; n--)
			add(chance(256));
	} else if (kind == 1) {
		for (u32 n = 1 + chance(40); n; n--)
			add(telling_byte());
	} else {
		add_packets();
		if (kind > 5)
			for (u32 n = 1 + chance(4); n && size; n--)
				mutate();
	}
	if (!chance(4))
		add_sequence(size);
}

/* ---- reading it ---- */

static __le16 steps[STEPS_MAX];
static size_t step_count;
static u8 found[STREAM_MAX];
static size_t found_size;

static void give(struct xy3_parser *parser, const u8 *data, size_t n)
{
	u8 *piece = malloc(n);	/* exact size, for ASan */
	const u8 *at = piece;
	struct xy3_packet packet;
	size_t left = n;

	if (!piece)
		exit(2);
	memcpy(piece, data, n);
	while (xy3_parse(parser, &at, &left, &packet)) {
		memcpy(found + found_size, packet.raw, xy3_packet_size(&packet));
		found_size += xy3_packet_size(&packet);
	}
	free(piece);
	steps[step_count++] = cpu_to_le16(n);
}

static void lose(struct xy3_parser *parser, size_t n)
{
	xy3_parse_lost(parser, n);
	steps[step_count++] = cpu_to_le16(-n);
}

static void read_stream(struct xy3_parser *parser)
{
	u32 piece = chance(8) ? chance(4) ? 1 + chance(24) : STREAM_MAX : 1;
	size_t at = 0;

	step_count = 0;
	found_size = 0;
	while (at < size) {
		size_t most = piece == 1 ? 1 : 1 + chance(piece), n = 1;

		if (piece == STREAM_MAX)
			most = piece;
		while (n < most && at + n < size && damaged[at + n] == damaged[at])
			n++;
		if (damaged[at])
			lose(parser, n);
		else
			give(parser, stream + at, n);
		at += n;
	}
}

static void write_record(const struct xy3_parser *parser, bool lie)
{
	struct record record = {
		.steps = cpu_to_le16(step_count),
		.bytes = cpu_to_le16(size),
		.found = cpu_to_le16(found_size),
		.packets = cpu_to_le16(parser->packets),
		.packet_bytes = cpu_to_le16(parser->packet_bytes),
		.dropped = cpu_to_le16(parser->dropped_bytes + lie),
		.kept = cpu_to_le16(parser->kept),
		.bad_lengths = cpu_to_le16(parser->bad_lengths),
		.unknown = cpu_to_le16(parser->unknown),
		.resyncs = cpu_to_le16(parser->resyncs),
		.in_sync = cpu_to_le16(parser->in_sync),
	};

	if (fwrite(&record, sizeof(record), 1, stdout) != 1 ||
	    fwrite(steps, 2, step_count, stdout) != step_count ||
	    fwrite(stream, 1, size, stdout) != size ||
	    fwrite(found, 1, found_size, stdout) != found_size)
		exit(3);
}

int main(int argc, char **argv)
{
	unsigned long count;
	long lie;

	if (argc < 3)
		return 2;
	state = strtoull(argv[1], NULL, 0) * 0x9e3779b97f4a7c15 | 1;
	count = strtoul(argv[2], NULL, 0);
	lie = argc > 3 ? strtol(argv[3], NULL, 0) : -1;

	for (unsigned long i = 0; i < count; i++) {
		struct xy3_parser parser = {};

		make_stream();
		read_stream(&parser);
		write_record(&parser, i == lie);
	}
	return fflush(stdout) ? 3 : 0;
}
