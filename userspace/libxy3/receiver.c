// SPDX-License-Identifier: GPL-2.0-only
/*
 * libxy3: packets of the backchannel
 */

#include <stdlib.h>

#include "libxy3.h"
#include "xy3-packet.h"

/**
 * struct xy3_receiver - a stream of bytes
 * @parser: splits it into packets
 * @packet: the last packet; zeros if there is none
 * @order: byte order of the head
 */
struct xy3_receiver {
	struct xy3_parser parser;
	struct xy3_packet packet;
	enum xy3_byte_order order;
};

struct xy3_receiver *xy3_receiver_new(void)
{
	return calloc(1, sizeof(struct xy3_receiver));
}

void xy3_receiver_free(struct xy3_receiver *receiver)
{
	free(receiver);
}

void xy3_receiver_set_big_endian(struct xy3_receiver *receiver, bool big_endian)
{
	receiver->order = big_endian ? XY3_BIG_ENDIAN : XY3_LITTLE_ENDIAN;
}

bool xy3_receiver_next(struct xy3_receiver *receiver, const uint8_t **data, size_t *size)
{
	bool found = xy3_parse(&receiver->parser, data, size, &receiver->packet);

	/* the bytes of the last packet may be invalid now */
	if (!found)
		receiver->packet = (struct xy3_packet) { };
	return found;
}

void xy3_receiver_lost(struct xy3_receiver *receiver, size_t size)
{
	xy3_parse_lost(&receiver->parser, size);
}

bool xy3_receiver_in_sync(const struct xy3_receiver *receiver)
{
	return receiver->parser.in_sync;
}

uint64_t xy3_receiver_count(const struct xy3_receiver *receiver, enum xy3_counter counter)
{
	const struct xy3_parser *parser = &receiver->parser;

	switch (counter) {
	case XY3_COUNT_PACKETS:
		return parser->packets;
	case XY3_COUNT_PACKET_BYTES:
		return parser->packet_bytes;
	case XY3_COUNT_DROPPED_BYTES:
		return parser->dropped_bytes;
	case XY3_COUNT_WAITING_BYTES:
		return parser->kept;
	case XY3_COUNT_RESYNCS:
		return parser->resyncs;
	case XY3_COUNT_BAD_LENGTHS:
		return parser->bad_lengths;
	case XY3_COUNT_UNKNOWN:
		return parser->unknown;
	}
	return 0;
}

uint8_t xy3_receiver_type(const struct xy3_receiver *receiver)
{
	return receiver->packet.type;
}

bool xy3_receiver_is_known(const struct xy3_receiver *receiver)
{
	return receiver->packet.known;
}

const uint8_t *xy3_receiver_packet(const struct xy3_receiver *receiver, size_t *size)
{
	*size = receiver->packet.raw ? xy3_packet_size(&receiver->packet) : 0;
	return receiver->packet.raw;
}

unsigned int xy3_receiver_temperatures(const struct xy3_receiver *receiver,
				       int16_t centidegrees[XY3_COMPONENTS])
{
	return xy3_packet_temperatures(&receiver->packet, receiver->order, centidegrees);
}

unsigned int xy3_receiver_frame_errors(const struct xy3_receiver *receiver,
				       uint32_t frames[XY3_AXES])
{
	return xy3_packet_frame_errors(&receiver->packet, receiver->order, frames);
}

unsigned int xy3_receiver_errors(const struct xy3_receiver *receiver,
				 uint8_t error[XY3_COMPONENTS])
{
	return xy3_packet_errors(&receiver->packet, error);
}

unsigned int xy3_receiver_hours(const struct xy3_receiver *receiver,
				uint32_t hours[XY3_COMPONENTS])
{
	return xy3_packet_hours(&receiver->packet, receiver->order, hours);
}

size_t xy3_receiver_text(const struct xy3_receiver *receiver, char *text, size_t size)
{
	return size ? xy3_packet_text(&receiver->packet, text, size) : 0;
}
