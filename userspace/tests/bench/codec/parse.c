// SPDX-License-Identifier: GPL-2.0-only
/* bench: packets of the backchannel, and noise without packets, against memchr and memcpy */
#include <stdlib.h>
#include <linux/kernel.h>
#include <linux/string.h>

#include "../../../../drivers/xy3/xy3-packet.h"
#include "bench.h"

#define STREAM	16384
#define PIECE	32	/* bytes that a UART delivers at a time */

struct parse_job {
	size_t size;
	size_t packets;		/* in the stream */
	size_t found;		/* by the last contender */
	struct xy3_parser parser;
	u8 stream[STREAM];
	u8 other[STREAM];
};

static void parse(struct parse_job *job, size_t piece)
{
	memset(&job->parser, 0, sizeof(job->parser));
	job->found = 0;
	for (size_t at = 0; at < job->size; at += piece) {
		size_t left = min(piece, job->size - at);
		const u8 *data = job->stream + at;
		struct xy3_packet packet;

		while (xy3_parse(&job->parser, &data, &left, &packet))
			job->found++;
	}
}

static void codec_block(void *data)
{
	struct parse_job *job = data;

	parse(job, job->size);
}

static void pieces_block(void *data)
{
	parse(data, PIECE);
}

/* The minimum for any search for the start of a packet */
static void memchr_block(void *data)
{
	struct parse_job *job = data;
	const u8 *p = job->stream, *end = job->stream + job->size;

	job->found = 0;
	while ((p = memchr(p, XY3_PACKET_START, end - p))) {
		job->found++;
		if (++p == end)
			break;
	}
}

static void memcpy_block(void *data)
{
	struct parse_job *job = data;

	memcpy(job->other, job->stream, job->size);
}

/* The expected final state, independent of the pieces of the stream */
static bool parsed(const struct parse_job *job)
{
	const struct xy3_parser *p = &job->parser;

	return job->found == job->packets && p->packets == job->packets && !p->resyncs &&
	       p->packet_bytes + p->dropped_bytes + p->kept == job->size &&
	       (job->packets ? !p->dropped_bytes : !p->packet_bytes);
}

static bool parse_good(void *data)
{
	struct parse_job *job = data;
	size_t starts = 0;
	bool good;

	codec_block(job);
	good = parsed(job);
	pieces_block(job);
	good &= parsed(job);
	for (size_t i = 0; i < job->size; i++)
		starts += job->stream[i] == XY3_PACKET_START;
	memchr_block(job);
	good &= job->found == starts;
	memset(job->other, 0, sizeof(job->other));
	memcpy_block(job);
	return good && !memcmp(job->other, job->stream, job->size);
}

/* The packets of a head: all types, with a sync before each */
static void fill_packets(struct parse_job *job)
{
	static const u8 says[][2] = {
		{ XY3_PACKET_SYNC, 0 }, { XY3_PACKET_TEMPERATURES, 44 },
		{ XY3_PACKET_SYNC, 0 }, { XY3_PACKET_ERRORS, 22 },
		{ XY3_PACKET_SYNC, 0 }, { XY3_PACKET_FRAME_ERRORS, 20 },
		{ XY3_PACKET_SYNC, 0 }, { XY3_PACKET_HOURS, 88 },
		{ XY3_PACKET_SYNC, 0 }, { XY3_PACKET_MODEL, 12 },
		{ XY3_PACKET_SYNC, 0 }, { XY3_PACKET_SERIAL, 9 },
		{ XY3_PACKET_SYNC, 0 }, { 0x0a, 10 },	/* an unknown type */
	};
	u32 random = 0x2468ace;

	for (size_t n = 0;; n = (n + 1) % ARRAY_SIZE(says)) {
		u8 *p = job->stream + job->size;

		if (job->size + XY3_PACKET_HEADER + says[n][1] > STREAM)
			break;
		p[0] = XY3_PACKET_START;
		p[1] = says[n][0];
		p[2] = says[n][1];
		for (unsigned int i = 0; i < says[n][1]; i++)
			p[3 + i] = next_random(&random) >> 9;
		job->size += XY3_PACKET_HEADER + says[n][1];
		job->packets++;
	}
}

/* No byte is 00h, so it contains no sync */
static void fill_noise(struct parse_job *job, unsigned int starts_of_16)
{
	u32 random = 0x13579bd;

	for (job->size = 0; job->size < STREAM; job->size++) {
		u32 r = next_random(&random) >> 4;
		u8 byte = 1 + (r >> 8) % 255;

		if (r % 16 < starts_of_16)
			byte = XY3_PACKET_START;
		else if (byte == XY3_PACKET_START)
			byte = XY3_PACKET_SYNC;
		job->stream[job->size] = byte;
	}
}

static void add_stream(struct parse_job *job, const char *table, const char *name, const char *unit)
{
	add_contest(&(struct contest) {
		.table = table,
		.name = name,
		.unit = unit,
		.units = job->packets ? job->packets : job->size,
		.bytes = job->size,
		.job = job,
		.good = parse_good,
		.contender = {
			{ "codec", codec_block },
			{ "codec, 32 at a time", pieces_block },
			{ "memchr", memchr_block },
			{ "memcpy", memcpy_block },
		},
	});
}

void add_parsing(void)
{
	static struct parse_job packets, quiet, some, many;

	fill_packets(&packets);
	fill_noise(&quiet, 0);
	fill_noise(&some, 1);
	fill_noise(&many, 8);
	add_stream(&packets, "packets read, in sync", "all types", "packet");
	add_stream(&quiet, "bytes searched, out of sync", "no 48h", "byte");
	add_stream(&some, "bytes searched, out of sync", "each 16th 48h", "byte");
	add_stream(&many, "bytes searched, out of sync", "each 2nd 48h", "byte");
}
