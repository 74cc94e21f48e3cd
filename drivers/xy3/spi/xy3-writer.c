// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: the writer's side of a stream
 *
 * A writer takes a block, fills it and returns it. Full blocks wait in a list until xy3-queue
 * passes them to the controller; the last one may be sent with room left in it.
 */

#include <linux/err.h>
#include <linux/list.h>
#include <linux/minmax.h>
#include <linux/sched.h>

#include "xy3-spi.h"

/**
 * xy3_stream_blocks() - allocate the blocks for writers
 * @stream: the stream, which does not run
 * @scans: maximum number of scans of a write that is accepted completely
 *
 * Return: 0 or -ENOMEM.
 */
int xy3_stream_blocks(struct xy3_stream *stream, unsigned int scans)
{
	unsigned int wanted = min(scans, XY3_WRITE_MAX);
	unsigned int least = max(DIV_ROUND_UP(wanted, XY3_BLOCKS_MAX / 2), XY3_BLOCK_SCANS_MIN);
	unsigned int each = xy3_scans_max(stream, clamp(xy3_scans_in(stream, XY3_BLOCK_US),
							least, XY3_BLOCK_SCANS_MAX));
	unsigned int half = clamp(DIV_ROUND_UP(wanted, each),
				  XY3_BLOCKS_MIN / 2, XY3_BLOCKS_MAX / 2);
	struct xy3_queue *queue;
	LIST_HEAD(blocks);
	int err;

	xy3_stream_no_blocks(stream);
	err = xy3_blocks_new(stream, &blocks, 2 * half, each);
	if (err)
		return err;
	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	list_splice(&blocks, &queue->empty);
	queue->empties = 2 * half;
	stream->block_scans = each;
	stream->write_max = half * each;
	return 0;
}

/**
 * xy3_stream_no_blocks() - free the blocks for writers
 * @stream: the stream, which does not run
 *
 * Commands may be being sent; they do not use the blocks for writers, which are all empty.
 */
void xy3_stream_no_blocks(struct xy3_stream *stream)
{
	LIST_HEAD(blocks);

	scoped_guard(spinlock_irqsave, &stream->lock) {
		list_splice_init(&xy3_queue(stream)->empty, &blocks);
		xy3_queue(stream)->empties = 0;
	}
	xy3_blocks_free(&blocks);
}

/* Number of scans that can be written */
static size_t xy3_stream_free(struct xy3_stream *stream)
{
	const struct xy3_queue *queue = xy3_queue(stream);
	const struct xy3_block *block = queue->filling;

	return queue->empties * stream->block_scans +
	       (block ? block->scans_max - block->scans : 0);
}

/**
 * xy3_stream_write_max() - size of a write that is accepted completely, or not at all
 * @stream: the stream
 *
 * Return: scans, at least 1.
 */
size_t xy3_stream_write_max(const struct xy3_stream *stream)
{
	return stream->write_max;
}

/**
 * xy3_stream_room() - size of data that can be written now
 * @stream: the stream
 *
 * Return: scans; 0 as long as there is no room for a write that has found none; at least 1 if the
 * stream does not run or has an error to report, or a writer that waits for room would wait
 * forever.
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
 * xy3_stream_waiting() - size of written data that the controller does not have yet
 * @stream: the stream
 *
 * Return: number of scans.
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
 * xy3_stream_begin_write() - data from now on are not part of an aborted write
 * @stream: the stream
 *
 * Unless they are the rest of one: the IIO core splits a long write into several ones.
 */
void xy3_stream_begin_write(struct xy3_stream *stream)
{
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	queue->aborted = queue->cancelled == current;
}

/**
 * xy3_stream_end_write() - the IIO core will not call again for the rest of this write
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
 * xy3_stream_take() - take the next block to fill
 * @stream: the stream
 * @scans: number of scans to write, to this block and the next ones
 *
 * There is one writer at a time: room that it has found is kept.
 *
 * Return: the block, with room for at least one scan; NULL if there is no room for @scans;
 * -ECANCELED if the write is aborted, -ENODEV if the stream ends permanently, -EINVAL if it does
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
 * xy3_stream_give() - return a block, filled further or not
 * @stream: the stream
 * @block: the block returned by xy3_stream_take()
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
