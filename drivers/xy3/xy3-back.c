// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: the backchannel - data in
 */

#include "trace.h"
#include "xy3.h"

static void xy3_back_packet(struct xy3_head *head, const struct xy3_packet *packet)
{
	trace_xy3_packet(head->number, packet->type, xy3_packet_payload(packet), packet->length);
	if (packet->type == XY3_PACKET_SYNC)
		head->syncs++;
	if (!xy3_tty_put(head, packet->raw, xy3_packet_size(packet)))
		head->lost_packets++;
	xy3_telemetry_packet(head, packet);
}

static void xy3_back_bytes(struct xy3_head *head, const u8 *data, size_t size)
{
	struct xy3_packet packet;

	while (xy3_parse(&head->parser, &data, &size, &packet))
		xy3_back_packet(head, &packet);
}

/* @flags may be NULL: no errors. Bytes that the UART has flagged are dropped. */
static void xy3_back_flagged(struct xy3_head *head, const u8 *data, const u8 *flags, size_t size)
{
	size_t good, bad;

	if (!flags) {
		xy3_back_bytes(head, data, size);
		return;
	}
	while (size) {
		for (good = 0; good < size && !flags[good]; good++)
			;
		xy3_back_bytes(head, data, good);
		for (bad = good; bad < size && flags[bad]; bad++)
			;
		if (bad > good) {
			xy3_parse_lost(&head->parser, bad - good);
			head->line_errors += bad - good;
			head->autobaud.line_errors += bad - good;
		}
		data += bad;
		flags += bad;
		size -= bad;
	}
}

/**
 * xy3_back_receive() - process data from the head
 * @back: the backchannel
 * @data: the data
 * @flags: for each byte 0, or its error (TTY_PARITY and so on); NULL if there was none
 * @size: number of bytes
 *
 * Context: sleeps. Calls for one backchannel must be serialised.
 */
void xy3_back_receive(struct xy3_back *back, const u8 *data, const u8 *flags, size_t size)
{
	struct xy3_head *head = back->head;
	bool was_in_sync;
	u64 resyncs;

	guard(mutex)(&head->lock);
	was_in_sync = head->parser.in_sync;
	resyncs = head->parser.resyncs;
	head->autobaud.bytes += size;

	xy3_back_flagged(head, data, flags, size);
	if (head->parser.in_sync != was_in_sync || head->parser.resyncs != resyncs)
		xy3_sync_changed(head);
	xy3_rate_data(head);
}
