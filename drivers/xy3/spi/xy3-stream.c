// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: a stream from its start to its end, its settings, single positions
 */

#include <linux/freezer.h>
#include <linux/jiffies.h>
#include <linux/ktime.h>
#include <linux/list.h>
#include <linux/minmax.h>
#include <linux/poll.h>
#include <linux/wait.h>

#include "xy3-spi.h"

/* Interval of checking whether the system suspends, while pending data are sent */
#define XY3_FREEZING_CHECK	msecs_to_jiffies(100)

/**
 * xy3_stream_rate_min() - the lowest rate that the bus supports
 * @stream: the stream
 *
 * Return: in frames per second, at least 1.
 */
unsigned int xy3_stream_rate_min(const struct xy3_stream *stream)
{
	return max(DIV_ROUND_UP(stream->spi->controller->min_speed_hz, xy3_scan_clocks(stream)),
		   1U);
}

/**
 * xy3_stream_rate_max() - the highest rate that the bus supports
 * @stream: the stream
 *
 * Return: the rate in frames per second.
 */
unsigned int xy3_stream_rate_max(const struct xy3_stream *stream)
{
	return stream->spi->max_speed_hz / xy3_scan_clocks(stream);
}

/* The controller has no written block, and will get none: all are empty */
static bool xy3_stream_silent(struct xy3_stream *stream)
{
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	return queue->queued == !!queue->commands.sending && list_empty(&queue->full) &&
	       !queue->filling;
}

/* The same, and it has no command */
static bool xy3_stream_idle(struct xy3_stream *stream)
{
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	return !queue->queued && list_empty(&queue->commands.waiting);
}

/**
 * xy3_stream_position() - positions of the axes: the last ones that the controller has sent
 * @stream: the stream
 * @position: array for all columns: a code for each axis of the line map, then 0 for a gate
 */
void xy3_stream_position(struct xy3_stream *stream, u32 *position)
{
	const struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	memcpy(position, queue->position, sizeof(queue->position));
}

static bool xy3_stream_leaves(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	return xy3_queue(stream)->leaving;
}

/**
 * xy3_stream_send_position() - send one scan and wait until it has been sent
 * @stream: the stream, which does not run
 * @position: a code for each column, 0 for a gate
 *
 * Return: 0, -ENODEV if the stream ends permanently, or the controller's error.
 */
int xy3_stream_send_position(struct xy3_stream *stream, const u32 *position)
{
	struct xy3_queue *queue;
	struct xy3_block *block;
	int err;

	if (xy3_stream_leaves(stream))
		return -ENODEV;
	block = xy3_block_new(stream, 1);
	if (!block)
		return -ENOMEM;
	block->scans = 1;
	xy3_encode_scans(&stream->map, position, 1, block->data);
	err = xy3_block_prepare(block);
	if (!err)
		err = xy3_block_send_now(block);
	if (!err) {
		guard(spinlock_irqsave)(&stream->lock);
		queue = xy3_queue(stream);
		queue->stat[XY3_SCANS]++;
		memcpy(queue->position, position, sizeof(queue->position));
	}
	xy3_block_free(block);
	return err;
}

/* Take all blocks from their lists, as a controller may sleep. The stream does not run. */
static void xy3_take_blocks(struct xy3_stream *stream, struct list_head *empty,
			    struct list_head *spare)
{
	guard(spinlock_irqsave)(&stream->lock);
	list_splice_init(&xy3_queue(stream)->empty, empty);
	list_splice_init(&xy3_queue(stream)->spare, spare);
}

static void xy3_return_blocks(struct xy3_stream *stream, struct list_head *empty,
			      struct list_head *spare)
{
	guard(spinlock_irqsave)(&stream->lock);
	list_splice(empty, &xy3_queue(stream)->empty);
	list_splice(spare, &xy3_queue(stream)->spare);
}

static int xy3_stream_prepare(struct xy3_stream *stream)
{
	unsigned int repeats = clamp(xy3_scans_in(stream, XY3_REPEAT_US), 1U,
				     xy3_scans_max(stream, XY3_REPEAT_SCANS_MAX));
	LIST_HEAD(empty);
	LIST_HEAD(spare);
	int err;

	xy3_take_blocks(stream, &empty, &spare);
	err = xy3_blocks_prepare(&empty, stream->block_scans);
	if (!err)
		err = xy3_blocks_prepare(&spare, repeats);
	if (!err)
		err = xy3_block_prepare(stream->closing);
	xy3_return_blocks(stream, &empty, &spare);
	return err;
}

static void xy3_stream_unprepare(struct xy3_stream *stream)
{
	LIST_HEAD(empty);
	LIST_HEAD(spare);

	xy3_take_blocks(stream, &empty, &spare);
	xy3_blocks_unprepare(&empty);
	xy3_blocks_unprepare(&spare);
	xy3_block_unprepare(stream->closing);
	xy3_return_blocks(stream, &empty, &spare);
}

/**
 * xy3_stream_start() - start a stream; it begins with the first written scan
 * @stream: the stream
 *
 * Return: 0; -ENODEV if the stream ends permanently; or the controller's error if it refuses these
 * blocks.
 */
int xy3_stream_start(struct xy3_stream *stream)
{
	struct xy3_queue *queue;
	int err;

	if (xy3_stream_leaves(stream))
		return -ENODEV;
	err = xy3_stream_prepare(stream);
	if (err) {
		xy3_stream_unprepare(stream);
		return err;
	}
	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	queue->running = true;
	queue->primed = false;
	queue->closed = false;
	/* a write that has waited for a page since the previous stream is not part of this one */
	queue->aborted = true;
	queue->wanted = 0;
	queue->error = 0;
	queue->achieved = 0;
	queue->measured_scans = 0;
	queue->measured_from = ktime_get_ns();
	return 0;
}

/*
 * A controller keeps its lines at their last levels, or at any others: with a gate a stream ends
 * with a scan that has it low.
 */
static void xy3_stream_close(struct xy3_stream *stream)
{
	struct xy3_queue *queue;
	bool wanted;
	int err;

	scoped_guard(spinlock_irqsave, &stream->lock) {
		wanted = xy3_make_closing(stream);
		xy3_queue(stream)->primed = false;
	}
	if (!wanted)
		return;
	err = xy3_block_send_now(stream->closing);
	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	queue->stat[XY3_SCANS] += !err;
	queue->stat[XY3_REPEATED] += !err;
	queue->stat[XY3_ERRORS] += !!err;
}

/*
 * The task whose write() is in progress, or NULL. From its start to its end, also while there is no
 * room, the IIO core has an entry of this kind in the queue of the writers; those of poll() are of
 * another kind.
 */
static struct task_struct *xy3_writing_task(wait_queue_head_t *writers)
{
	struct wait_queue_entry *entry;

	guard(spinlock_irqsave)(&writers->lock);
	list_for_each_entry(entry, &writers->head, entry)
		if (entry->func == woken_wake_function)
			return entry->private;
	return NULL;
}

/**
 * xy3_stream_abort() - drop written data that the controller does not have yet
 * @stream: the stream
 *
 * A running stream continues, and repeats the last position that the controller has. Commands are
 * not dropped. Does not wait for a writer, nor for xy3_stream_stop(), which then ends earlier.
 */
void xy3_stream_abort(struct xy3_stream *stream)
{
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	queue->aborted = true;
	queue->cancelled = xy3_writing_task(stream->writers);
	xy3_drop_written(stream);
	wake_up_all(&stream->done);
	wake_up_interruptible_poll(stream->writers, EPOLLOUT | EPOLLWRNORM);
}

/**
 * xy3_stream_leave() - the stream will end permanently: drop written data, accept no more
 * @stream: the stream
 */
void xy3_stream_leave(struct xy3_stream *stream)
{
	scoped_guard(spinlock_irqsave, &stream->lock)
		xy3_queue(stream)->leaving = true;
	xy3_stream_abort(stream);
	cancel_delayed_work_sync(&stream->underrun);
}

/**
 * xy3_stream_suspend() - stop a running stream, as after an error
 * @stream: the stream
 *
 * Blocks that the controller has are sent, and the gate is lowered; the rest is dropped. Writers
 * get -ESHUTDOWN until the stream is started again. Processes are frozen, and none is in
 * xy3_stream_stop().
 */
void xy3_stream_suspend(struct xy3_stream *stream)
{
	scoped_guard(spinlock_irqsave, &stream->lock) {
		if (!xy3_queue(stream)->running)
			return;
		xy3_stream_fail(stream, -ESHUTDOWN);
		xy3_close_after_error(stream);
		wake_up_all(&stream->done);
		wake_up_interruptible_poll(stream->writers, EPOLLOUT | EPOLLWRNORM);
	}
	wait_event(stream->done, xy3_stream_idle(stream));
}

/**
 * xy3_stream_end() - accept no more data; those written are sent
 * @stream: the stream
 */
void xy3_stream_end(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	xy3_queue(stream)->running = false;
	xy3_pump(stream, false);
}

/**
 * xy3_stream_stop() - send written data, then stop
 * @stream: the stream
 *
 * The last scan written is the last one sent; with a gate it is repeated once with the gate low.
 * If the process is killed in the meantime, or the system suspends, it only waits for blocks that
 * the controller has; the rest is dropped.
 */
void xy3_stream_stop(struct xy3_stream *stream)
{
	long left;

	xy3_stream_end(stream);
	/* the process has locks of the IIO core, so that it must not be frozen here */
	do {
		left = wait_event_killable_timeout(stream->done, xy3_stream_silent(stream),
						   XY3_FREEZING_CHECK);
	} while (!left && !freezing(current));
	if (left <= 0) {
		xy3_stream_abort(stream);
		wait_event(stream->done, xy3_stream_silent(stream));
	}
	xy3_stream_close(stream);
	xy3_stream_unprepare(stream);
}

/* With the nearest rate that the bus supports */
static void xy3_stream_take_over(struct xy3_stream *stream, const struct xy3_line_map *map,
				 unsigned int rate)
{
	guard(spinlock_irqsave)(&stream->lock);
	stream->map = *map;
	stream->rate = clamp(rate, xy3_stream_rate_min(stream), xy3_stream_rate_max(stream));
}

static int xy3_stream_change(struct xy3_stream *stream, const struct xy3_line_map *map,
			     unsigned int rate)
{
	struct xy3_line_map map_was = stream->map;
	unsigned int rate_was = stream->rate;
	int err;

	if (xy3_stream_leaves(stream))
		return -ENODEV;
	xy3_commands_hold(stream);
	xy3_stream_take_over(stream, map, rate);
	err = xy3_commands_new_block(stream);
	if (err)
		xy3_stream_take_over(stream, &map_was, rate_was);
	xy3_commands_release(stream);
	return err;
}

/**
 * xy3_stream_resize() - change the size of the frames
 * @stream: the stream, which does not run
 * @frame_bits: 24 or 32
 *
 * The rate changes to the nearest one that the bus supports with frames of this size.
 *
 * Return: 0, -EINVAL, -ENODEV, -ENOMEM or the controller's error.
 */
int xy3_stream_resize(struct xy3_stream *stream, unsigned int frame_bits)
{
	struct xy3_line_map map;
	int err;

	err = xy3_map_init(&map, stream->map.words, stream->map.lines, frame_bits,
			   stream->map.signal);
	if (err)
		return err;
	return xy3_stream_change(stream, &map, stream->rate);
}

/**
 * xy3_stream_set_rate() - change the rate
 * @stream: the stream, which does not run
 * @rate: frames per second
 *
 * Return: 0; -ERANGE if the bus does not support it; -ENODEV, -ENOMEM or the controller's error.
 */
int xy3_stream_set_rate(struct xy3_stream *stream, unsigned int rate)
{
	if (rate < xy3_stream_rate_min(stream) || rate > xy3_stream_rate_max(stream))
		return -ERANGE;
	return xy3_stream_change(stream, &stream->map, rate);
}

/**
 * xy3_stream_init() - prepare a stream
 * @stream: the stream; all members before its lock are set
 *
 * Return: 0, -ENOMEM or the controller's error.
 */
int xy3_stream_init(struct xy3_stream *stream)
{
	unsigned int repeats = xy3_scans_max(stream, XY3_REPEAT_SCANS_MAX);
	struct xy3_queue *queue = &stream->queue;
	struct xy3_block *block;
	int err;

	INIT_DELAYED_WORK(&stream->retry, xy3_retry);
	spin_lock_init(&stream->lock);
	init_waitqueue_head(&stream->done);
	INIT_LIST_HEAD(&queue->empty);
	INIT_LIST_HEAD(&queue->full);
	INIT_LIST_HEAD(&queue->spare);
	stream->write_max = 1;

	err = xy3_commands_init(stream);
	if (err)
		return err;
	stream->closing = xy3_block_new(stream, 1);
	err = stream->closing ? xy3_blocks_new(stream, &queue->spare, XY3_BLOCKS_QUEUED, repeats) :
				-ENOMEM;
	if (err) {
		xy3_block_free(stream->closing);
		xy3_commands_exit(stream);
		return err;
	}
	stream->closing->scans = 1;
	stream->closing->repeats = true;
	list_for_each_entry(block, &queue->spare, node)
		block->repeats = true;
	return 0;
}

/**
 * xy3_stream_exit() - free a stream, after the controller has sent all
 * @stream: the stream
 */
void xy3_stream_exit(struct xy3_stream *stream)
{
	struct xy3_queue *queue = &stream->queue;

	xy3_stream_stop(stream);
	wait_event(stream->done, xy3_stream_idle(stream));
	cancel_delayed_work_sync(&stream->retry);
	xy3_stream_no_blocks(stream);
	xy3_blocks_free(&queue->spare);
	xy3_block_free(stream->closing);
	xy3_commands_exit(stream);
}
