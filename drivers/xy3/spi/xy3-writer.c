// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: the writer's side of a stream
 *
 * A writer takes a block, fills it and gives it back. Blocks that are full wait in a list until
 * xy3-queue hands them to the controller; the last one may be sent with room left in it.
 */

#include <linux/err.h>
#include <linux/minmax.h>
#include <linux/sched.h>

#include "xy3-spi.h"

/**
 * xy3_stream_blocks() - make the writer's blocks
 * @stream: the stream, which does not run
 * @scans: how many scans a write may have and still be taken whole
 *
 * Return: 0 or -ENOMEM.
 */
int xy3_stream_blocks(struct xy3_stream *stream, unsigned int scans)
{
	unsigned int each = xy3_scans_max(stream, clamp(xy3_scans_in(stream, XY3_BLOCK_US),
							XY3_BLOCK_SCANS_MIN,
							XY3_BLOCK_SCANS_MAX));
	unsigned int half = clamp(DIV_ROUND_UP(min(scans, XY3_WRITE_MAX), each),
				  XY3_BLOCKS_MIN / 2, XY3_BLOCKS_MAX / 2);
	int err;

	xy3_stream_no_blocks(stream);
	err = xy3_blocks_new(stream, &stream->queue.empty, 2 * half, each);
	if (err)
		return err;
	stream->queue.empties = 2 * half;
	stream->block_scans = each;
	stream->write_max = half * each;
	return 0;
}

/**
 * xy3_stream_no_blocks() - the writer has no blocks any more
 * @stream: the stream, which does not run
 *
 * Commands may be on their way; they leave the writer's blocks alone, all of which are empty.
 */
void xy3_stream_no_blocks(struct xy3_stream *stream)
{
	xy3_blocks_free(&stream->queue.empty);
	stream->queue.empties = 0;
}

/* Scans that there is room for */
static size_t xy3_stream_free(struct xy3_stream *stream)
{
	const struct xy3_queue *queue = xy3_queue(stream);
	const struct xy3_block *block = queue->filling;

	return queue->empties * stream->block_scans +
	       (block ? block->scans_max - block->scans : 0);
}

/**
 * xy3_stream_write_max() - how much is taken whole, or not at all
 * @stream: the stream
 *
 * Return: scans, at least 1.
 */
size_t xy3_stream_write_max(const struct xy3_stream *stream)
{
	return stream->write_max;
}

/**
 * xy3_stream_room() - how much can be written now
 * @stream: the stream
 *
 * Return: scans; 0 as long as there is no room for the write that has found none; at least 1 when
 * the stream does not run or has an error to report, or a writer that waits for room would wait
 * for ever.
 */
size_t xy3_stream_room(struct xy3_stream *stream)
{
	struct xy3_queue *queue;
	size_t scans;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	if (!queue->running || queue->leaving || queue->error)
		return 1;
	scans = xy3_stream_free(stream);
	return scans < queue->wanted ? 0 : scans;
}

/**
 * xy3_stream_waiting() - how much was written that the controller does not have yet
 * @stream: the stream
 *
 * Return: scans.
 */
size_t xy3_stream_waiting(struct xy3_stream *stream)
{
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	return queue->fulls * stream->block_scans +
	       (queue->filling ? queue->filling->scans : 0);
}

/**
 * xy3_stream_begin_write() - what is taken from now on is no part of a write that was aborted
 * @stream: the stream
 *
 * Unless it is the rest of one: the IIO core makes several writes of a long one.
 */
void xy3_stream_begin_write(struct xy3_stream *stream)
{
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	queue->aborted = queue->cancelled == current;
}

/**
 * xy3_stream_end_write() - the IIO core will not call again with the rest of this write
 * @stream: the stream
 */
void xy3_stream_end_write(struct xy3_stream *stream)
{
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	if (queue->cancelled == current)
		queue->cancelled = NULL;
}

/**
 * xy3_stream_take() - take the block that is to be filled
 * @stream: the stream
 * @scans: what is to be written, to this block and the next ones
 *
 * There is one writer at a time: room that it has found stays.
 *
 * Return: the block, with room for one scan at least; NULL when there is no room for @scans;
 * -ECANCELED when the write is aborted, -ENODEV when the stream ends for good, -EINVAL when it does
 * not run, or the controller's error.
 */
struct xy3_block *xy3_stream_take(struct xy3_stream *stream, size_t scans)
{
	struct xy3_queue *queue;
	struct xy3_block *block;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	if (queue->leaving)
		return ERR_PTR(-ENODEV);
	if (!queue->running)
		return ERR_PTR(-EINVAL);
	if (queue->error)
		return ERR_PTR(queue->error);
	if (queue->aborted)
		return ERR_PTR(-ECANCELED);
	if (xy3_stream_free(stream) < scans) {
		queue->wanted = scans;
		return NULL;
	}
	queue->wanted = 0;
	block = queue->filling;
	queue->filling = NULL;
	if (!block) {
		block = list_first_entry(&queue->empty, struct xy3_block, node);
		list_del(&block->node);
		queue->empties--;
		block->scans = 0;
	}
	return block;
}

static void xy3_put_full(struct xy3_block *block)
{
	struct xy3_queue *queue = xy3_queue(block->stream);

	list_add_tail(&block->node, &queue->full);
	queue->fulls++;
}

/**
 * xy3_stream_give() - give a block back, with more in it or not
 * @stream: the stream
 * @block: the block that xy3_stream_take() gave
 */
void xy3_stream_give(struct xy3_stream *stream, struct xy3_block *block)
{
	int err = block->scans ? xy3_block_prepare(block) : 0;
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	if (err) {
		queue->stat[XY3_ERRORS]++;
		xy3_stream_fail(stream, err);
		xy3_close_after_error(stream);
	}
	if (!block->scans || queue->error || queue->aborted)
		xy3_put_empty(block);
	else if (block->scans < block->scans_max)
		queue->filling = block;
	else
		xy3_put_full(block);
	xy3_pump(stream, false);
}
