/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XY3-100 backchannel: packets in a stream of bytes, and their content
 *
 *   byte  0    1     2       3 ...
 *         48h  type  length  payload of length bytes
 *
 * Pure functions over bytes, without allocation, sleeping or a device, so that the same
 * source is compiled into the driver and into user-space programs.
 */
#ifndef XY3_PACKET_H
#define XY3_PACKET_H

#include <linux/types.h>
#include <linux/xy3.h>

/**
 * struct xy3_packet - a complete packet
 * @type: enum xy3_packet_type, or unknown
 * @length: bytes of payload
 * @known: the type is known, and so @length is one of its lengths
 * @raw: the packet as received, XY3_PACKET_HEADER + @length bytes
 *
 * @raw points into the data passed to xy3_parse(), into the parser or to a constant, and is
 * valid until the next call.
 */
struct xy3_packet {
	u8 type;
	u8 length;
	bool known;
	const u8 *raw;
};

static inline const u8 *xy3_packet_payload(const struct xy3_packet *packet)
{
	return packet->raw + XY3_PACKET_HEADER;
}

static inline size_t xy3_packet_size(const struct xy3_packet *packet)
{
	return XY3_PACKET_HEADER + packet->length;
}

/**
 * struct xy3_parser - splits a stream of bytes into packets
 * @in_sync: the next byte, or the first of those kept, is the start of a packet
 * @kept: bytes in @buffer: the start of a packet or, out of sync, of the sync sequence
 * @buffer: data of the stream that are not complete
 * @packets: packets found, all types
 * @packet_bytes: bytes of these packets
 * @dropped_bytes: bytes that are not part of a packet
 * @resyncs: number of times that sync was regained after it was lost
 * @bad_lengths: known types with an invalid length
 * @unknown: packets of unknown types
 * @synced: sync was found before
 *
 * Zeroed memory is a parser in its initial state, out of sync. At any time the bytes passed are
 * @packet_bytes + @dropped_bytes + @kept.
 */
struct xy3_parser {
	bool in_sync;
	bool synced;
	u16 kept;
	u8 buffer[XY3_PACKET_MAX];
	u64 packets;
	u64 packet_bytes;
	u64 dropped_bytes;
	u64 resyncs;
	u64 bad_lengths;
	u64 unknown;
};

bool xy3_parse(struct xy3_parser *parser, const u8 **data, size_t *size,
	       struct xy3_packet *packet);
void xy3_parse_lost(struct xy3_parser *parser, size_t size);

/**
 * enum xy3_byte_order - byte order of numbers
 * @XY3_LITTLE_ENDIAN: least significant byte first, the default
 * @XY3_BIG_ENDIAN: most significant byte first
 */
enum xy3_byte_order {
	XY3_LITTLE_ENDIAN,
	XY3_BIG_ENDIAN
};

unsigned int xy3_packet_temperatures(const struct xy3_packet *packet, enum xy3_byte_order order,
				     s16 centidegrees[XY3_COMPONENTS]);
unsigned int xy3_packet_frame_errors(const struct xy3_packet *packet, enum xy3_byte_order order,
				     u32 frames[XY3_AXES]);
unsigned int xy3_packet_errors(const struct xy3_packet *packet, u8 error[XY3_COMPONENTS]);
unsigned int xy3_packet_hours(const struct xy3_packet *packet, enum xy3_byte_order order,
			      u32 hours[XY3_COMPONENTS]);
size_t xy3_packet_text(const struct xy3_packet *packet, char *text, size_t size);

const char *xy3_component_name(unsigned int component);
const char *xy3_axis_name(unsigned int axis);
const char *xy3_error_name(unsigned int error);

#endif /* XY3_PACKET_H */
