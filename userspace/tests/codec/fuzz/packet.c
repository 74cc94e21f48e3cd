// SPDX-License-Identifier: GPL-2.0-only
/*
 * libFuzzer target: the packet codec of the backchannel.
 *
 * An input is a sequence of steps, each starting with a byte n:
 *
 *   00..DF  the next n bytes are passed in one piece
 *   E0..EF  the next 64 * (n - DFh) bytes
 *   F0..FF  n - F0h bytes are damaged
 *
 * A second parser gets the same bytes one by one; results must be the same. FAULT, if defined,
 * plants a fault that must be found (see run-fuzz).
 */
#include "../../../../drivers/xy3/xy3-packet.c"
#include "fuzz.h"

struct reader {
	struct xy3_parser parser;
	u64 given;
	u64 hash;	/* over all bytes of all packets */
};

/* ---- content of packets ---- */

static void check_numbers(const struct xy3_packet *packet, enum xy3_byte_order order)
{
	unsigned int length = packet->length, n;
	s16 temperature[XY3_COMPONENTS];
	u32 hours[XY3_COMPONENTS];
	u32 frames[XY3_AXES];
	u8 error[XY3_COMPONENTS];

	n = xy3_packet_temperatures(packet, order, temperature);
	must(n == (packet->type == XY3_PACKET_TEMPERATURES ? length / 2 : 0));
	for (; n < XY3_COMPONENTS; n++)
		must(temperature[n] == XY3_TEMPERATURE_NONE);

	n = xy3_packet_hours(packet, order, hours);
	must(n == (packet->type == XY3_PACKET_HOURS ? length / 4 : 0));
	for (; n < XY3_COMPONENTS; n++)
		must(hours[n] == XY3_HOURS_NONE);

	n = xy3_packet_frame_errors(packet, order, frames);
	must(n == (packet->type == XY3_PACKET_FRAME_ERRORS ? 5 : 0));
	for (; n < XY3_AXES; n++)
		must(frames[n] == 0);

	n = xy3_packet_errors(packet, error);
	must(n == (packet->type == XY3_PACKET_ERRORS ? length : 0));
	for (; n < XY3_COMPONENTS; n++)
		must(error[n] == XY3_ERROR_NONE);
	for (n = 0; n < XY3_COMPONENTS; n++)
		must(!xy3_error_name(error[n]) == (error[n] > XY3_ERROR_MECHANICAL));
}

static void check_text(const struct xy3_packet *packet)
{
	size_t room = 1 + (packet->length * 7 + packet->type) % 256;
	char *text = malloc(room);
	size_t length;

	must(text);
	length = xy3_packet_text(packet, text, room);
	must(length == (packet->length < room ? packet->length : room - 1));
	must(strlen(text) == length);
	for (size_t i = 0; i < length; i++)
		must(text[i] >= ' ' && text[i] <= '~');
	if (FAULT != 2)
		free(text);
}

/* ---- the stream ---- */

static void check_accounts(const struct reader *reader)
{
	const struct xy3_parser *parser = &reader->parser;
	u64 given = parser->packet_bytes + parser->dropped_bytes + parser->kept;

	if (FAULT == 1)
		given += parser->unknown;
	must(reader->given == given);
	must(parser->kept < sizeof(parser->buffer));
}

static void give(struct reader *reader, const u8 *data, size_t size)
{
	const u8 *at = data;
	size_t left = size;
	struct xy3_packet packet;

	while (xy3_parse(&reader->parser, &at, &left, &packet)) {
		reader->given += size - left;
		check_accounts(reader);
		reader->given -= size - left;

		must(packet.raw[0] == XY3_PACKET_START && packet.raw[1] == packet.type &&
		     packet.raw[2] == packet.length);
		for (size_t i = 0; i < xy3_packet_size(&packet) + (FAULT == 3); i++)
			reader->hash = (reader->hash ^ packet.raw[i]) * 0x100000001b3;
		check_numbers(&packet, XY3_LITTLE_ENDIAN);
		check_numbers(&packet, XY3_BIG_ENDIAN);
		check_text(&packet);
	}
	must(left == 0 && at == data + size);
	reader->given += size;
	check_accounts(reader);
}

/* In memory of the exact size, for ASan */
static void give_piece(struct reader *reader, const u8 *data, size_t size)
{
	u8 *piece = malloc(size);

	must(piece);
	memcpy(piece, data, size);
	give(reader, piece, size);
	free(piece);
}

static void lose(struct reader *reader, size_t size)
{
	xy3_parse_lost(&reader->parser, size);
	reader->given += size;
	check_accounts(reader);
	must(!reader->parser.in_sync && !reader->parser.kept);
}

static void compare(const struct reader *a, const struct reader *b)
{
	must(a->hash == b->hash);
	must(a->parser.packets == b->parser.packets);
	must(a->parser.packet_bytes == b->parser.packet_bytes);
	must(a->parser.dropped_bytes == b->parser.dropped_bytes);
	must(a->parser.resyncs == b->parser.resyncs);
	must(a->parser.bad_lengths == b->parser.bad_lengths);
	must(a->parser.unknown == b->parser.unknown);
	must(a->parser.in_sync == b->parser.in_sync);
	must(a->parser.kept == b->parser.kept);
	must(!memcmp(a->parser.buffer, b->parser.buffer, a->parser.kept));
}

int LLVMFuzzerTestOneInput(const u8 *data, size_t size)
{
	struct reader in_pieces = {}, in_bytes = {};

	while (size) {
		size_t n = *data++;

		size--;
		if (n >= 0xf0) {
			lose(&in_pieces, n - 0xf0);
			lose(&in_bytes, n - 0xf0);
			continue;
		}
		if (n >= 0xe0)
			n = 64 * (n - 0xdf);
		n = min(n, size);
		give_piece(&in_pieces, data, n);
		for (size_t i = 0; i < n; i++)
			give(&in_bytes, data + i, 1);
		compare(&in_pieces, &in_bytes);
		data += n;
		size -= n;
	}
	return 0;
}
