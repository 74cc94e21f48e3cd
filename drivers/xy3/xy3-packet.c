// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 backchannel: packets in a stream of bytes, and their content
 *
 * In sync, a packet that is complete in the data is returned in place, and only its header is
 * examined; a partial one at the end of the data is kept until the rest arrives. Out of sync,
 * everything is skipped up to the sequence 48h 41h 00h 48h: a sync packet and the start of the
 * next one.
 */

#include <linux/kernel.h>
#include <linux/minmax.h>
#include <linux/string.h>
#include <linux/unaligned.h>

#include "xy3-packet.h"

/* ---- packet types ---- */

/* Valid lengths by type: from min to max in steps of step, 0 for an unknown type */
static const struct xy3_packet_kind {
	u8 min;
	u8 max;
	u8 step;
} xy3_kinds[] = {
	[XY3_PACKET_VENDOR]       = { XY3_TEXT_MIN, XY3_TEXT_MAX,       1 },
	[XY3_PACKET_MODEL]        = { XY3_TEXT_MIN, XY3_TEXT_MAX,       1 },
	[XY3_PACKET_FIRMWARE]     = { XY3_TEXT_MIN, XY3_TEXT_MAX,       1 },
	[XY3_PACKET_SERIAL]       = { XY3_TEXT_MIN, XY3_TEXT_MAX,       1 },
	[XY3_PACKET_TEMPERATURES] = { 2,            2 * XY3_COMPONENTS, 2 },
	[XY3_PACKET_FRAME_ERRORS] = { 4 * XY3_AXES, 4 * XY3_AXES,       4 },
	[XY3_PACKET_ERRORS]       = { 1,            XY3_COMPONENTS,     1 },
	[XY3_PACKET_DEBUG]        = { XY3_TEXT_MIN, XY3_TEXT_MAX,       1 },
	[XY3_PACKET_HOURS]        = { 4,            4 * XY3_COMPONENTS, 4 },
	[XY3_PACKET_SYNC]         = { 0,            0,                  1 },
};

/* a sync packet, and the start of the next one */
static const u8 xy3_sync_sequence[] = { XY3_PACKET_START, XY3_PACKET_SYNC, 0, XY3_PACKET_START };

#define XY3_SYNC_PACKET_SIZE	(ARRAY_SIZE(xy3_sync_sequence) - 1)

static const char * const xy3_component_names[XY3_COMPONENTS] = {
	[XY3_HEAD] = "head",
	[XY3_DSP] = "dsp",
	[XY3_DAC_X] = "dac_x",
	[XY3_DAC_Y] = "dac_y",
	[XY3_DAC_Z] = "dac_z",
	[XY3_DAC_U] = "dac_u",
	[XY3_DAC_W] = "dac_w",
	[XY3_DRIVER_X] = "driver_x",
	[XY3_DRIVER_Y] = "driver_y",
	[XY3_DRIVER_Z] = "driver_z",
	[XY3_DRIVER_U] = "driver_u",
	[XY3_DRIVER_W] = "driver_w",
	[XY3_GALVO_X] = "galvo_x",
	[XY3_GALVO_Y] = "galvo_y",
	[XY3_GALVO_Z] = "galvo_z",
	[XY3_GALVO_U] = "galvo_u",
	[XY3_GALVO_W] = "galvo_w",
	[XY3_MIRROR_X] = "mirror_x",
	[XY3_MIRROR_Y] = "mirror_y",
	[XY3_MIRROR_Z] = "mirror_z",
	[XY3_MIRROR_U] = "mirror_u",
	[XY3_MIRROR_W] = "mirror_w",
};

static const char * const xy3_axis_names[XY3_AXES] = {
	[XY3_AXIS_X] = "x",
	[XY3_AXIS_Y] = "y",
	[XY3_AXIS_Z] = "z",
	[XY3_AXIS_U] = "u",
	[XY3_AXIS_W] = "w",
};

static const char * const xy3_error_names[] = {
	[XY3_ERROR_NONE] = "none",
	[XY3_ERROR_TEMPERATURE] = "temperature",
	[XY3_ERROR_DATA] = "data",
	[XY3_ERROR_RANGE] = "range",
	[XY3_ERROR_POWER] = "power",
	[XY3_ERROR_ELECTRICAL] = "electrical",
	[XY3_ERROR_ADJUSTMENT] = "adjustment",
	[XY3_ERROR_MECHANICAL] = "mechanical",
};

/**
 * xy3_component_name() - name of a part of the head
 * @component: enum xy3_component
 *
 * Return: "head", "galvo_x" and so on; NULL when there is no such component.
 */
const char *xy3_component_name(unsigned int component)
{
	return component < XY3_COMPONENTS ? xy3_component_names[component] : NULL;
}

/**
 * xy3_axis_name() - name of an axis
 * @axis: enum xy3_axis
 *
 * Return: its letter; NULL when there is no such axis.
 */
const char *xy3_axis_name(unsigned int axis)
{
	return axis < XY3_AXES ? xy3_axis_names[axis] : NULL;
}

/**
 * xy3_error_name() - name of an error code
 * @error: enum xy3_error
 *
 * Return: "none", "temperature" and so on; NULL for a code without a name.
 */
const char *xy3_error_name(unsigned int error)
{
	return error < ARRAY_SIZE(xy3_error_names) ? xy3_error_names[error] : NULL;
}

/* ---- the parser ---- */

/* Fill in @packet from the header at @raw. Return false if no packet can start like this. */
static bool xy3_read_header(const u8 *raw, struct xy3_packet *packet)
{
	const struct xy3_packet_kind *kind;

	if (raw[0] != XY3_PACKET_START)
		return false;
	packet->raw = raw;
	packet->type = raw[1];
	packet->length = raw[2];

	kind = packet->type < ARRAY_SIZE(xy3_kinds) ? &xy3_kinds[packet->type] : NULL;
	packet->known = kind && kind->step;
	return !packet->known ||
	       (packet->length >= kind->min && packet->length <= kind->max &&
		packet->length % kind->step == 0);
}

static void xy3_count_packet(struct xy3_parser *parser, const struct xy3_packet *packet)
{
	parser->packets++;
	parser->packet_bytes += xy3_packet_size(packet);
	parser->unknown += !packet->known;
}

/*
 * Out of sync, with the first @kept bytes of the sequence in @buffer: take one more. If it does not
 * continue the sequence, it may start a new one: only the first byte occurs twice in it.
 */
static void xy3_match(struct xy3_parser *parser, u8 byte)
{
	if (byte != xy3_sync_sequence[parser->kept]) {
		parser->dropped_bytes += parser->kept;
		parser->kept = 0;
	}
	if (byte == xy3_sync_sequence[parser->kept])
		parser->buffer[parser->kept++] = byte;
	else
		parser->dropped_bytes++;
}

/* Out of sync: skip up to the sequence. Its last byte is kept as the first of the next packet. */
static bool xy3_search(struct xy3_parser *parser, const u8 **data, size_t *size,
		       struct xy3_packet *packet)
{
	for (; *size; (*data)++, (*size)--) {
		if (!parser->kept) {
			const u8 *start = memchr(*data, XY3_PACKET_START, *size);
			size_t skip = start ? (size_t)(start - *data) : *size;

			parser->dropped_bytes += skip;
			*data += skip;
			*size -= skip;
			if (!start)
				return false;
		}
		if (parser->kept == XY3_SYNC_PACKET_SIZE && **data == XY3_PACKET_START) {
			parser->kept = 0;
			parser->in_sync = true;
			parser->resyncs += parser->synced;
			parser->synced = true;
			return xy3_read_header(xy3_sync_sequence, packet);
		}
		xy3_match(parser, **data);
	}
	return false;
}

/* Keep data until there are @want bytes. Return false if there are too few. */
static bool xy3_keep(struct xy3_parser *parser, const u8 **data, size_t *size, size_t want)
{
	size_t part;

	if (parser->kept < want) {
		part = min(want - parser->kept, *size);
		memcpy(parser->buffer + parser->kept, *data, part);
		parser->kept += part;
		*data += part;
		*size -= part;
	}
	return parser->kept >= want;
}

/* The bytes kept are not a header, but a sync sequence may start within them. */
static void xy3_lose_header(struct xy3_parser *parser)
{
	u8 header[XY3_PACKET_HEADER];

	memcpy(header, parser->buffer, sizeof(header));
	parser->in_sync = false;
	parser->bad_lengths++;
	parser->dropped_bytes++;
	parser->kept = 0;
	for (size_t i = 1; i < sizeof(header); i++)
		xy3_match(parser, header[i]);
}

/* In sync: take a packet, in place if it is complete, otherwise through the buffer */
static bool xy3_take(struct xy3_parser *parser, const u8 **data, size_t *size,
		     struct xy3_packet *packet)
{
	if (!parser->kept) {
		if (**data != XY3_PACKET_START) {
			parser->in_sync = false;	/* and the search drops it */
			return false;
		}
		if (*size >= XY3_PACKET_HEADER && xy3_read_header(*data, packet) &&
		    *size >= xy3_packet_size(packet)) {
			*data += xy3_packet_size(packet);
			*size -= xy3_packet_size(packet);
			return true;
		}
	}

	if (!xy3_keep(parser, data, size, XY3_PACKET_HEADER))
		return false;
	if (!xy3_read_header(parser->buffer, packet)) {
		xy3_lose_header(parser);
		return false;
	}
	if (!xy3_keep(parser, data, size, xy3_packet_size(packet)))
		return false;
	parser->kept = 0;
	return true;
}

/**
 * xy3_parse() - extract the next packet from a stream
 * @parser: state of the stream
 * @data: the next bytes of the stream, in pieces of any size; advanced past what was consumed
 * @size: number of these bytes; reduced likewise
 * @packet: the packet, if there is one
 *
 * Call it until it returns false; then all data are consumed.
 *
 * Return: true if @packet was filled in.
 */
bool xy3_parse(struct xy3_parser *parser, const u8 **data, size_t *size,
	       struct xy3_packet *packet)
{
	bool found = false;

	while (!found && *size) {
		if (parser->in_sync)
			found = xy3_take(parser, data, size, packet);
		else
			found = xy3_search(parser, data, size, packet);
	}
	if (found)
		xy3_count_packet(parser, packet);
	return found;
}

/**
 * xy3_parse_lost() - account for damaged bytes of a stream
 * @parser: state of the stream
 * @size: number of damaged bytes, after all those passed to xy3_parse()
 *
 * They are dropped, along with a packet that they may be part of; sync is lost.
 */
void xy3_parse_lost(struct xy3_parser *parser, size_t size)
{
	parser->dropped_bytes += parser->kept + size;
	parser->kept = 0;
	parser->in_sync = false;
}

/* ---- content of packets ---- */

static u16 xy3_get16(const u8 *p, enum xy3_byte_order order)
{
	return order == XY3_BIG_ENDIAN ? get_unaligned_be16(p) : get_unaligned_le16(p);
}

static u32 xy3_get32(const u8 *p, enum xy3_byte_order order)
{
	return order == XY3_BIG_ENDIAN ? get_unaligned_be32(p) : get_unaligned_le32(p);
}

/* Entries of an array packet; none for another packet */
static unsigned int xy3_entries(const struct xy3_packet *packet, u8 type)
{
	return packet->type == type ? packet->length / xy3_kinds[type].step : 0;
}

/**
 * xy3_packet_temperatures() - read a temperature packet
 * @packet: the packet
 * @order: byte order of the head
 * @centidegrees: by enum xy3_component, in 1/100 degree Celsius; XY3_TEMPERATURE_NONE where the
 *		  head has no sensor, and for components that the packet leaves out
 *
 * Return: components that are in the packet; 0 for a packet of another type.
 */
unsigned int xy3_packet_temperatures(const struct xy3_packet *packet, enum xy3_byte_order order,
				     s16 centidegrees[XY3_COMPONENTS])
{
	unsigned int count = xy3_entries(packet, XY3_PACKET_TEMPERATURES);

	for (unsigned int i = 0; i < XY3_COMPONENTS; i++)
		centidegrees[i] = i < count ?
			(s16)xy3_get16(xy3_packet_payload(packet) + 2 * i, order) :
			XY3_TEMPERATURE_NONE;
	return count;
}

/**
 * xy3_packet_frame_errors() - read a frame error packet
 * @packet: the packet
 * @order: byte order of the head
 * @frames: by enum xy3_axis: frames with bad parity since power-up
 *
 * Return: axes that are in the packet, all or, for a packet of another type, none.
 */
unsigned int xy3_packet_frame_errors(const struct xy3_packet *packet, enum xy3_byte_order order,
				     u32 frames[XY3_AXES])
{
	unsigned int count = xy3_entries(packet, XY3_PACKET_FRAME_ERRORS);

	for (unsigned int i = 0; i < XY3_AXES; i++)
		frames[i] = i < count ?
			xy3_get32(xy3_packet_payload(packet) + 4 * i, order) : 0;
	return count;
}

/**
 * xy3_packet_errors() - read an error state packet
 * @packet: the packet
 * @error: by enum xy3_component: enum xy3_error; XY3_ERROR_NONE for components that the packet
 *	   leaves out
 *
 * Return: components that are in the packet; 0 for a packet of another type.
 */
unsigned int xy3_packet_errors(const struct xy3_packet *packet, u8 error[XY3_COMPONENTS])
{
	unsigned int count = xy3_entries(packet, XY3_PACKET_ERRORS);

	for (unsigned int i = 0; i < XY3_COMPONENTS; i++)
		error[i] = i < count ? xy3_packet_payload(packet)[i] : XY3_ERROR_NONE;
	return count;
}

/**
 * xy3_packet_hours() - read an operating hours packet
 * @packet: the packet
 * @order: byte order of the head
 * @hours: by enum xy3_component; XY3_HOURS_NONE where the head does not count, and for components
 *	   that the packet leaves out
 *
 * Return: components that are in the packet; 0 for a packet of another type.
 */
unsigned int xy3_packet_hours(const struct xy3_packet *packet, enum xy3_byte_order order,
			      u32 hours[XY3_COMPONENTS])
{
	unsigned int count = xy3_entries(packet, XY3_PACKET_HOURS);

	for (unsigned int i = 0; i < XY3_COMPONENTS; i++)
		hours[i] = i < count ?
			xy3_get32(xy3_packet_payload(packet) + 4 * i, order) : XY3_HOURS_NONE;
	return count;
}

/**
 * xy3_packet_text() - the payload as printable text
 * @packet: the packet, of any type
 * @text: the text, terminated by NUL; bytes that are not printable ASCII are "?"
 * @size: room in @text, at least 1; what does not fit is left out
 *
 * Return: length of the text.
 */
size_t xy3_packet_text(const struct xy3_packet *packet, char *text, size_t size)
{
	size_t length = min_t(size_t, packet->length, size - 1);

	for (size_t i = 0; i < length; i++) {
		u8 c = xy3_packet_payload(packet)[i];

		text[i] = c >= 0x20 && c <= 0x7e ? c : '?';
	}
	text[length] = '\0';
	return length;
}
