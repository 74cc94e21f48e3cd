// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: blocks of scans as SPI messages
 *
 * Where SYNC is the chip select each scan is a transfer, else a block is one. The message of a
 * whole block is made ready once, when a stream begins, and sent again and again; for a block that
 * is sent before it is full one of a few messages is lent.
 */

#include <linux/math.h>
#include <linux/minmax.h>
#include <linux/slab.h>

#include "xy3-spi.h"

/* ---- sizes ---- */

/**
 * xy3_stream_scan_size() - bytes of a scan in a block
 * @stream: the stream
 *
 * Return: that.
 */
size_t xy3_stream_scan_size(const struct xy3_stream *stream)
{
	return stream->word_is_scan ? sizeof(u32) : stream->map.scan_size;
}

/* The same for the longest frames: blocks are good for both */
static size_t xy3_scan_room(const struct xy3_stream *stream)
{
	return DIV_ROUND_UP((32 + XY3_GAP_CLOCKS) * stream->map.lines, 8);
}

/**
 * xy3_scan_clocks() - clocks from the start of one frame to the start of the next
 * @stream: the stream
 *
 * Return: as far as they are ours; a controller may have more to do for a chip select.
 */
unsigned int xy3_scan_clocks(const struct xy3_stream *stream)
{
	return stream->map.frame_bits + (stream->map.sync_line < 0 ? 0 : XY3_GAP_CLOCKS);
}

/* SYNC is the chip select, and a transfer of its own for each frame moves it */
static bool xy3_transfer_is_scan(const struct xy3_stream *stream)
{
	return stream->map.sync_line < 0 && !stream->word_is_scan;
}

/**
 * xy3_scans_max() - scans that the controller takes in one message
 * @stream: the stream
 * @wished: no more than that
 *
 * Return: at least 1.
 */
unsigned int xy3_scans_max(const struct xy3_stream *stream, unsigned int wished)
{
	size_t limit = spi_max_message_size(stream->spi);

	if (!xy3_transfer_is_scan(stream))
		limit = spi_max_transfer_size(stream->spi);
	return clamp_t(size_t, limit / xy3_scan_room(stream), 1, wished);
}

/* ---- messages ---- */

static unsigned int xy3_transfers(const struct xy3_stream *stream, unsigned int scans)
{
	return xy3_transfer_is_scan(stream) ? scans : 1;
}

static int xy3_message_init(struct xy3_message *message, struct xy3_stream *stream,
			    unsigned int scans)
{
	unsigned int count = xy3_transfers(stream, scans);

	message->transfers = kvcalloc(count, sizeof(*message->transfers), GFP_KERNEL);
	return message->transfers ? 0 : -ENOMEM;
}

/* Transfers of the scans that are in the block: one for all of them, or one for each */
static void xy3_message_fill(struct xy3_message *message, struct xy3_block *block)
{
	struct xy3_stream *stream = block->stream;
	unsigned int count = xy3_transfers(stream, block->scans);
	size_t size = block->scans / count * xy3_stream_scan_size(stream);

	for (unsigned int i = 0; i < count; i++)
		message->transfers[i] = (struct spi_transfer) {
			.tx_buf = block->data + i * size,
			.len = size,
			.tx_nbits = stream->map.lines,
			.speed_hz = stream->rate * xy3_scan_clocks(stream),
			.bits_per_word = stream->word_is_scan ? stream->map.frame_bits : 8,
			.cs_change = i + 1 < count,
			/* 0 microseconds would mean 10 to the SPI core, 0 nanoseconds are none */
			.cs_change_delay.unit = SPI_DELAY_UNIT_NSECS,
		};
	spi_message_init_with_transfers(&message->spi, message->transfers, count);
}

/* The message for what is in the block */
static struct xy3_message *xy3_block_message(struct xy3_block *block)
{
	struct xy3_stream *stream = block->stream;
	struct xy3_message *message = &block->whole;

	if (block->ready && block->scans == block->scans_max)
		return message;
	if (block->ready) {
		/* there is one for each block that the controller can have at a time */
		message = list_first_entry(&stream->lent, struct xy3_message, node);
		list_del(&message->node);
	}
	xy3_message_fill(message, block);
	return message;
}

/**
 * xy3_block_send() - give a block to the controller
 * @block: the block, with one scan at least in it
 * @done: is called when it has been sent, or not; in any context
 *
 * Return: 0 or the controller's error.
 */
int xy3_block_send(struct xy3_block *block, void (*done)(void *context))
{
	int err;

	lockdep_assert_held(&block->stream->lock);
	block->sent = xy3_block_message(block);
	block->sent->spi.complete = done;
	block->sent->spi.context = block;
	err = spi_async(block->stream->spi, &block->sent->spi);
	if (err)
		xy3_block_back(block);
	return err;
}

/**
 * xy3_block_back() - a block comes back from the controller
 * @block: the block
 *
 * Return: 0 or why it was not sent.
 */
int xy3_block_back(struct xy3_block *block)
{
	struct xy3_message *message = block->sent;

	lockdep_assert_held(&block->stream->lock);
	if (message != &block->whole)
		list_add(&message->node, &block->stream->lent);
	return message->spi.status;
}

/**
 * xy3_block_send_now() - send a block that is in no stream, and wait
 * @block: the block, with one scan at least in it
 *
 * Return: 0 or the controller's error.
 */
int xy3_block_send_now(struct xy3_block *block)
{
	xy3_message_fill(&block->whole, block);
	return spi_sync(block->stream->spi, &block->whole.spi);
}

/* ---- blocks ---- */

/**
 * xy3_block_free() - let a block go
 * @block: the block, or NULL; not ready
 */
void xy3_block_free(struct xy3_block *block)
{
	if (!block)
		return;
	kvfree(block->whole.transfers);
	kfree(block->data);
	kfree(block);
}

/**
 * xy3_block_new() - make a block
 * @stream: whose it will be
 * @scans: scans that it has room for
 *
 * Return: the block, empty and not ready; NULL without memory.
 */
struct xy3_block *xy3_block_new(struct xy3_stream *stream, unsigned int scans)
{
	struct xy3_block *block;

	block = kzalloc(sizeof(*block), GFP_KERNEL);
	if (!block)
		return NULL;
	block->stream = stream;
	block->scans_max = scans;
	block->data = kmalloc_array(scans, xy3_scan_room(stream), GFP_KERNEL);
	if (!block->data || xy3_message_init(&block->whole, stream, scans)) {
		xy3_block_free(block);
		return NULL;
	}
	return block;
}

/**
 * xy3_blocks_free() - let blocks go
 * @list: the blocks, not ready
 */
void xy3_blocks_free(struct list_head *list)
{
	struct xy3_block *block, *next;

	list_for_each_entry_safe(block, next, list, node) {
		list_del(&block->node);
		xy3_block_free(block);
	}
}

/**
 * xy3_blocks_new() - make blocks
 * @stream: whose they will be
 * @list: where they are put; empty
 * @count: how many
 * @scans: scans that each has room for
 *
 * Return: 0 or -ENOMEM, and then there is none.
 */
int xy3_blocks_new(struct xy3_stream *stream, struct list_head *list, unsigned int count,
		   unsigned int scans)
{
	struct xy3_block *block;

	while (count--) {
		block = xy3_block_new(stream, scans);
		if (!block) {
			xy3_blocks_free(list);
			return -ENOMEM;
		}
		list_add_tail(&block->node, list);
	}
	return 0;
}

/**
 * xy3_blocks_ready() - let the controller look at the messages of whole blocks once and for all
 * @list: the blocks; rate and line map of the stream stand
 *
 * Return: 0 or the controller's error; then some may be ready.
 */
int xy3_blocks_ready(struct list_head *list)
{
	struct xy3_block *block;
	int err;

	list_for_each_entry(block, list, node) {
		block->scans = block->scans_max;
		xy3_message_fill(&block->whole, block);
		err = spi_optimize_message(block->stream->spi, &block->whole.spi);
		if (err)
			return err;
		block->ready = true;
	}
	return 0;
}

/**
 * xy3_blocks_unready() - undo that
 * @list: the blocks, ready or not; the controller has none of them
 */
void xy3_blocks_unready(struct list_head *list)
{
	struct xy3_block *block;

	list_for_each_entry(block, list, node) {
		if (block->ready)
			spi_unoptimize_message(&block->whole.spi);
		block->ready = false;
	}
}

/**
 * xy3_lent_free() - let go the messages for blocks that are not full
 * @stream: the stream; it has them all
 */
void xy3_lent_free(struct xy3_stream *stream)
{
	struct xy3_message *message, *next;

	list_for_each_entry_safe(message, next, &stream->lent, node) {
		list_del(&message->node);
		kvfree(message->transfers);
		kfree(message);
	}
}

/**
 * xy3_lent_new() - make them
 * @stream: the stream
 * @scans: scans of a full block
 *
 * Return: 0 or -ENOMEM, and then there is none.
 */
int xy3_lent_new(struct xy3_stream *stream, unsigned int scans)
{
	for (unsigned int i = 0; i < XY3_BLOCKS_QUEUED; i++) {
		struct xy3_message *message = kzalloc(sizeof(*message), GFP_KERNEL);

		if (!message || xy3_message_init(message, stream, scans)) {
			kfree(message);
			xy3_lent_free(stream);
			return -ENOMEM;
		}
		list_add(&message->node, &stream->lent);
	}
	return 0;
}
