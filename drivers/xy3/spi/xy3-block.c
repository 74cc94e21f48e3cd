// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: blocks of scans as SPI messages
 *
 * If SYNC is the chip select, each scan is a transfer, otherwise each block. A controller may sleep
 * when it prepares a message, and gets messages in atomic context: so each one is prepared before,
 * when the block is filled. It stays prepared as long as blocks of this size are sent.
 */

#include <linux/math.h>
#include <linux/math64.h>
#include <linux/minmax.h>
#include <linux/slab.h>
#include <linux/time64.h>

#include "xy3-spi.h"

/* ---- sizes ---- */

/* Bytes of a scan of the longest frames: blocks can hold both sizes */
static size_t xy3_scan_room(const struct xy3_stream *stream)
{
	return XY3_SCAN_ROOM(stream->map.lines);
}

/**
 * xy3_scan_clocks() - clocks from the start of one frame to the start of the next
 * @stream: the stream
 *
 * Return: the number without clocks that a controller may add for a chip select.
 */
unsigned int xy3_scan_clocks(const struct xy3_stream *stream)
{
	return stream->map.frame_bits + (stream->map.sync_line < 0 ? 0 : XY3_GAP_CLOCKS);
}

/* SYNC is the chip select, and a separate transfer for each frame toggles it */
static bool xy3_transfer_is_scan(const struct xy3_stream *stream)
{
	return stream->map.sync_line < 0 && !(stream->spi->mode & SPI_CS_WORD);
}

/**
 * xy3_scans_max() - scans that the controller supports in one message
 * @stream: the stream
 * @wished: upper limit
 *
 * Return: at least 1.
 */
unsigned int xy3_scans_max(const struct xy3_stream *stream, unsigned int wished)
{
	size_t limit = spi_max_message_size(stream->spi);

	if (!xy3_transfer_is_scan(stream))
		limit = spi_max_transfer_size(stream->spi) - xy3_gap_size(&stream->map);
	return clamp_t(size_t, limit / xy3_scan_room(stream), 1, wished);
}

/**
 * xy3_scans_in() - scans that are sent in a time
 * @stream: the stream
 * @us: the time, in microseconds
 *
 * Return: the number of complete scans.
 */
unsigned int xy3_scans_in(const struct xy3_stream *stream, unsigned int us)
{
	return div_u64((u64)stream->rate * us, USEC_PER_SEC);
}

/* ---- messages ---- */

static unsigned int xy3_transfers(const struct xy3_stream *stream, unsigned int scans)
{
	return xy3_transfer_is_scan(stream) ? scans : 1;
}

static unsigned int xy3_lane_mode(const struct xy3_line_map *map)
{
	return map->words && map->lines > 1 ? SPI_MULTI_LANE_MODE_STRIPE :
					      SPI_MULTI_LANE_MODE_SINGLE;
}

/*
 * Transfers of the scans in the block: one for all of them, preceded by a gap if SYNC is a line; or
 * one for each
 */
static void xy3_block_message(struct xy3_block *block)
{
	struct xy3_stream *stream = block->stream;
	unsigned int count = xy3_transfers(stream, block->scans);
	size_t size = block->scans / count * stream->map.scan_size;
	size_t gap = xy3_gap_size(&stream->map);

	xy3_encode_gap(&stream->map, block->buffer);
	for (unsigned int i = 0; i < count; i++)
		block->transfers[i] = (struct spi_transfer) {
			.tx_buf = block->buffer + i * size,
			.len = gap + size,
			.multi_lane_mode = xy3_lane_mode(&stream->map),
			.tx_nbits = stream->map.words ? SPI_NBITS_SINGLE : stream->map.lines,
			.speed_hz = stream->rate * xy3_scan_clocks(stream),
			.bits_per_word = stream->map.words ? stream->map.frame_bits : 8,
			.cs_change = i + 1 < count,
			/* in the SPI core 0 microseconds mean 10, 0 nanoseconds mean none */
			.cs_change_delay.unit = SPI_DELAY_UNIT_NSECS,
		};
	spi_message_init_with_transfers(&block->message, block->transfers, count);
}

/**
 * xy3_block_unprepare() - unprepare the message of a block
 * @block: the block, prepared or not; the controller does not have it
 *
 * May sleep.
 */
void xy3_block_unprepare(struct xy3_block *block)
{
	if (block->prepared)
		spi_unoptimize_message(&block->message);
	block->prepared = 0;
}

/**
 * xy3_block_prepare() - prepare the message for the content of a block
 * @block: the block, with at least one scan; rate and line map of the stream are final. Bytes may
 *	   change later, but not the number of scans.
 *
 * May sleep.
 *
 * Return: 0 or the controller's error.
 */
int xy3_block_prepare(struct xy3_block *block)
{
	int err;

	if (block->prepared == block->scans)
		return 0;
	xy3_block_unprepare(block);
	xy3_block_message(block);
	err = spi_optimize_message(block->stream->spi, &block->message);
	if (!err)
		block->prepared = block->scans;
	return err;
}

/**
 * xy3_block_send() - give a block to the controller
 * @block: the block, prepared
 * @done: called after it was sent or has failed, in any context
 *
 * In any context.
 *
 * Return: 0 or the controller's error.
 */
int xy3_block_send(struct xy3_block *block, void (*done)(void *context))
{
	block->message.complete = done;
	block->message.context = block;
	return spi_async(block->stream->spi, &block->message);
}

/**
 * xy3_block_send_now() - give a block to the controller, and wait until it has been sent
 * @block: the block, prepared
 *
 * Return: 0 or the controller's error.
 */
int xy3_block_send_now(struct xy3_block *block)
{
	/* spi_sync() would call the function set by xy3_block_send() */
	block->message.complete = NULL;
	return spi_sync(block->stream->spi, &block->message);
}

/**
 * xy3_block_status() - result of sending a block
 * @block: the block, returned by the controller
 *
 * Return: 0 or the error if it was not sent.
 */
int xy3_block_status(const struct xy3_block *block)
{
	return block->message.status;
}

/* ---- blocks ---- */

/**
 * xy3_block_free() - free a block
 * @block: the block, or NULL; the controller does not have it
 */
void xy3_block_free(struct xy3_block *block)
{
	if (!block)
		return;
	xy3_block_unprepare(block);
	kvfree(block->transfers);
	kfree(block->buffer);
	kfree(block);
}

/**
 * xy3_block_new() - allocate a block
 * @stream: the stream
 * @scans: maximum number of scans
 *
 * The length of the buffer, which determines their number, is set by the user: the memory is
 * accounted.
 *
 * Return: the block, empty and not prepared; NULL if out of memory.
 */
struct xy3_block *xy3_block_new(struct xy3_stream *stream, unsigned int scans)
{
	struct xy3_block *block;

	block = kzalloc(sizeof(*block), GFP_KERNEL_ACCOUNT);
	if (!block)
		return NULL;
	block->stream = stream;
	block->scans_max = scans;
	block->buffer = kmalloc(XY3_GAP_ROOM(stream->map.lines) + scans * xy3_scan_room(stream),
				GFP_KERNEL_ACCOUNT);
	block->transfers = kvcalloc(xy3_transfers(stream, scans), sizeof(*block->transfers),
				    GFP_KERNEL_ACCOUNT);
	if (!block->buffer || !block->transfers) {
		xy3_block_free(block);
		return NULL;
	}
	block->data = block->buffer + xy3_gap_size(&stream->map);
	return block;
}

/**
 * xy3_blocks_free() - free blocks
 * @list: the blocks; the controller has none of them
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
 * xy3_blocks_new() - allocate blocks
 * @stream: the stream
 * @list: empty list, to which they are added
 * @count: number of blocks
 * @scans: maximum number of scans of each
 *
 * Return: 0, or -ENOMEM without any block.
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
 * xy3_blocks_prepare() - prepare the messages of blocks
 * @list: the blocks; rate and line map of the stream are final
 * @scans: number of scans that each of them will have
 *
 * Return: 0 or the controller's error; then some may be prepared.
 */
int xy3_blocks_prepare(struct list_head *list, unsigned int scans)
{
	struct xy3_block *block;
	int err;

	list_for_each_entry(block, list, node) {
		block->scans = scans;
		err = xy3_block_prepare(block);
		if (err)
			return err;
	}
	return 0;
}

/**
 * xy3_blocks_unprepare() - unprepare the messages of blocks
 * @list: the blocks, prepared or not; the controller has none of them
 */
void xy3_blocks_unprepare(struct list_head *list)
{
	struct xy3_block *block;

	list_for_each_entry(block, list, node)
		xy3_block_unprepare(block);
}
