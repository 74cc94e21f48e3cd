// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: blocks of frames on their way to the controller
 *
 * A writer fills blocks, the controller is given up to XY3_BLOCKS_QUEUED of them at a time, so that
 * it has the next one when one is done. Commands go between two blocks. While a stream runs and
 * its writer is late, blocks that repeat the last position keep the bus busy.
 *
 * All is set in motion when something is written and when a message is done.
 */

#include <linux/err.h>
#include <linux/ktime.h>
#include <linux/minmax.h>
#include <linux/poll.h>
#include <linux/slab.h>

#include "xy3-spi.h"

/* Repeating begins while the controller still has a block: with the next one it has this many */
#define XY3_BLOCKS_LOW		2

/**
 * xy3_stream_encode() - make the bytes of scans
 * @stream: the stream
 * @codes: the columns of the line map for each scan
 * @scans: how many scans
 * @out: room for @scans scans
 */
void xy3_stream_encode(const struct xy3_stream *stream, const u32 *codes, size_t scans, u8 *out)
{
	if (!stream->word_is_scan) {
		xy3_encode_scans(&stream->map, codes, scans, out);
		return;
	}
	/* one axis; the controller requires words in the byte order of the processor */
	for (size_t i = 0; i < scans; i++)
		((u32 *)out)[i] = xy3_position_word(&stream->map, codes[i]);
}

/* ---- what the controller is given ---- */

/* What was written: whole blocks first, then one that the writer has only begun */
static struct xy3_block *xy3_next_written(struct xy3_stream *stream)
{
	struct xy3_block *block = list_first_entry_or_null(&stream->full, struct xy3_block, node);
	size_t size = xy3_stream_scan_size(stream);

	if (block) {
		list_del(&block->node);
	} else {
		block = stream->filling;
		stream->filling = NULL;
	}
	if (block) {
		u8 *last = block->data + (block->scans - 1) * size;

		memcpy(stream->last, last, size);
		xy3_lower_gate(&stream->map, stream->last);
		/* nothing may follow for some time */
		xy3_lower_gate_behind(&stream->map, last);
		stream->primed = true;
		stream->repeating = false;
	}
	return block;
}

static struct xy3_block *xy3_next_repeated(struct xy3_stream *stream)
{
	struct xy3_block *block = list_first_entry_or_null(&stream->spare, struct xy3_block, node);
	size_t size = xy3_stream_scan_size(stream);

	if (!block || !stream->running || !stream->primed || stream->queued >= XY3_BLOCKS_LOW)
		return NULL;
	list_del(&block->node);
	for (unsigned int i = 0; i < block->scans; i++)
		memcpy(block->data + i * size, stream->last, size);
	if (!stream->repeating)
		xy3_underrun_begins(stream);
	stream->repeating = true;
	return block;
}

static void xy3_put_empty(struct xy3_block *block)
{
	list_add_tail(&block->node, &block->stream->empty);
	block->stream->empties++;
}

static void xy3_block_recycle(struct xy3_block *block, int err)
{
	struct xy3_stream *stream = block->stream;

	if (block == stream->commands.block)
		xy3_command_done(stream, err);
	else if (block == stream->closing)
		return;
	else if (block->repeats)
		list_add_tail(&block->node, &stream->spare);
	else
		xy3_put_empty(block);
}

static void xy3_drop_written(struct xy3_stream *stream)
{
	struct xy3_block *block, *next;

	list_for_each_entry_safe(block, next, &stream->full, node) {
		list_del(&block->node);
		xy3_put_empty(block);
	}
	if (stream->filling)
		xy3_put_empty(stream->filling);
	stream->filling = NULL;
}

/* The stream has failed: nothing that waits is to go out at some later time */
static void xy3_stream_fail(struct xy3_stream *stream, int err)
{
	stream->error = err;
	xy3_commands_fail(stream, err);
	xy3_drop_written(stream);
}

static void xy3_block_done(void *context);

/*
 * While another driver has locked the bus the controller refuses messages. It does not tell when
 * that ends, and so the block is offered again and again; those behind it wait.
 */
static int xy3_submit(struct xy3_stream *stream, struct xy3_block *block)
{
	int err = xy3_block_send(block, xy3_block_done);

	lockdep_assert_held(&stream->lock);
	if (err == -EBUSY) {
		stream->refused = block;
		queue_delayed_work(system_percpu_wq, &stream->retry, 1);
		err = 0;
	}
	if (!err)
		stream->queued++;
	return err;
}

/* What was sent last, with the gate low. Return false when nothing could have raised it. */
static bool xy3_make_closing(struct xy3_stream *stream)
{
	struct xy3_block *block = stream->closing;

	if (stream->map.gate_line < 0 || !stream->primed)
		return false;
	xy3_stream_encode(stream, stream->position, 1, block->data);
	return true;
}

/* After an error the gate's line may be at any level; try once to make it low */
static void xy3_close_after_error(struct xy3_stream *stream)
{
	lockdep_assert_held(&stream->lock);
	if (!stream->error || stream->queued || stream->closed || !xy3_make_closing(stream))
		return;
	stream->closed = true;
	xy3_submit(stream, stream->closing);
}

/**
 * xy3_pump() - give the controller what there is
 * @stream: the stream
 * @late: only what has just been sent is to be followed
 */
void xy3_pump(struct xy3_stream *stream, bool late)
{
	struct xy3_block *block;
	int err;

	lockdep_assert_held(&stream->lock);
	while (!stream->error && !stream->refused && stream->queued < XY3_BLOCKS_QUEUED) {
		block = xy3_next_command(stream);
		if (!block)
			block = xy3_next_written(stream);
		if (!block && late)
			block = xy3_next_repeated(stream);
		if (!block)
			return;
		err = xy3_submit(stream, block);
		if (err) {
			stream->stat[XY3_ERRORS]++;
			xy3_stream_fail(stream, err);
			xy3_block_recycle(block, err);
			xy3_close_after_error(stream);
			return;
		}
	}
}

static void xy3_block_sent(struct xy3_stream *stream, struct xy3_block *block, int err)
{
	lockdep_assert_held(&stream->lock);
	stream->queued--;
	if (err) {
		stream->stat[XY3_ERRORS]++;
		xy3_stream_fail(stream, err);
	} else {
		stream->stat[XY3_SCANS] += block->scans;
		stream->stat[XY3_REPEATED] += block->repeats ? block->scans : 0;
		if (block != stream->commands.block && !block->repeats)
			memcpy(stream->position, block->position, sizeof(stream->position));
		xy3_measure(stream, block->scans);
	}
	xy3_block_recycle(block, err);
	xy3_pump(stream, true);
	xy3_close_after_error(stream);
	/* under the lock, as the stream may be gone behind it */
	wake_up_all(&stream->done);
	if (stream->writers)
		wake_up_interruptible_poll(stream->writers, EPOLLOUT | EPOLLWRNORM);
}

/* A message is done, whatever became of it. In any context. */
static void xy3_block_done(void *context)
{
	struct xy3_block *block = context;
	struct xy3_stream *stream = block->stream;

	guard(spinlock_irqsave)(&stream->lock);
	xy3_block_sent(stream, block, xy3_block_status(block));
}

/* Offer the block that was refused once more, unless the stream has failed meanwhile */
static void xy3_retry(struct work_struct *work)
{
	struct xy3_stream *stream = container_of(to_delayed_work(work), struct xy3_stream, retry);
	struct xy3_block *block;
	int err;

	guard(spinlock_irqsave)(&stream->lock);
	block = stream->refused;
	stream->refused = NULL;
	stream->queued--;
	err = block == stream->closing ? 0 : stream->error;
	if (!err)
		err = xy3_submit(stream, block);
	if (err) {
		stream->queued++;
		xy3_block_sent(stream, block, err);
		return;
	}
	xy3_pump(stream, false);
}

/* ---- for the others ---- */

/**
 * xy3_stream_rate_min() - the lowest rate that the bus can do
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
 * xy3_stream_rate_max() - the highest rate that the bus can do
 * @stream: the stream
 *
 * Return: in frames per second.
 */
unsigned int xy3_stream_rate_max(const struct xy3_stream *stream)
{
	return stream->spi->max_speed_hz / xy3_scan_clocks(stream);
}

/* The controller has no block of what was written, and will be given none: all are empty */
static bool xy3_stream_silent(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	return stream->queued == !!stream->commands.sending && list_empty(&stream->full) &&
	       !stream->filling;
}

/* Nor a command */
static bool xy3_stream_idle(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	return !stream->queued && list_empty(&stream->commands.waiting);
}

/**
 * xy3_stream_position() - where the axes are, as far as the controller has told
 * @stream: the stream
 * @position: room for all columns: a code for each axis of the line map, and behind them 0 for a
 *	      gate
 */
void xy3_stream_position(struct xy3_stream *stream, u32 *position)
{
	guard(spinlock_irqsave)(&stream->lock);
	memcpy(position, stream->position, sizeof(stream->position));
}

/**
 * xy3_stream_send_position() - send one scan and wait until it has been sent
 * @stream: the stream, which does not run
 * @position: a code for each column, 0 for a gate
 *
 * Return: 0 or the controller's error.
 */
int xy3_stream_send_position(struct xy3_stream *stream, const u32 *position)
{
	struct xy3_block *block = xy3_block_new(stream, 1);
	int err;

	if (!block)
		return -ENOMEM;
	block->scans = 1;
	xy3_stream_encode(stream, position, 1, block->data);
	err = xy3_block_prepare(block);
	if (!err)
		err = xy3_block_send_now(block);
	if (!err) {
		guard(spinlock_irqsave)(&stream->lock);
		stream->stat[XY3_SCANS]++;
		memcpy(stream->position, position, sizeof(stream->position));
	}
	xy3_block_free(block);
	return err;
}

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
	err = xy3_blocks_new(stream, &stream->empty, 2 * half, each);
	if (err)
		return err;
	stream->empties = 2 * half;
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
	xy3_blocks_free(&stream->empty);
	stream->empties = 0;
}

static int xy3_stream_prepare(struct xy3_stream *stream)
{
	unsigned int repeats = clamp(xy3_scans_in(stream, XY3_REPEAT_US), 1U,
				     xy3_scans_max(stream, XY3_REPEAT_SCANS_MAX));
	int err;

	err = xy3_blocks_prepare(&stream->empty, stream->block_scans);
	if (!err)
		err = xy3_blocks_prepare(&stream->spare, repeats);
	if (!err)
		err = xy3_block_prepare(stream->closing);
	return err;
}

static void xy3_stream_unprepare(struct xy3_stream *stream)
{
	xy3_blocks_unprepare(&stream->empty);
	xy3_blocks_unprepare(&stream->spare);
	xy3_block_unprepare(stream->closing);
}

/**
 * xy3_stream_start() - start a stream; it begins with the first scan that is written
 * @stream: the stream
 *
 * Return: 0, or the controller's error when it does not take blocks like these.
 */
int xy3_stream_start(struct xy3_stream *stream)
{
	int err;

	err = xy3_stream_prepare(stream);
	if (err) {
		xy3_stream_unprepare(stream);
		return err;
	}
	guard(spinlock_irqsave)(&stream->lock);
	stream->running = true;
	stream->primed = false;
	stream->closed = false;
	stream->wanted = 0;
	stream->error = 0;
	stream->achieved = 0;
	stream->measured_scans = 0;
	stream->measured_from = ktime_get_ns();
	return 0;
}

/*
 * A controller keeps its lines at their last levels, or moves them as it likes: with a gate a
 * stream ends with a scan that has it low.
 */
static void xy3_stream_close(struct xy3_stream *stream)
{
	bool wanted;
	int err;

	scoped_guard(spinlock_irqsave, &stream->lock) {
		wanted = xy3_make_closing(stream);
		stream->primed = false;
	}
	if (!wanted)
		return;
	err = xy3_block_send_now(stream->closing);
	guard(spinlock_irqsave)(&stream->lock);
	stream->stat[XY3_SCANS] += !err;
	stream->stat[XY3_REPEATED] += !err;
	stream->stat[XY3_ERRORS] += !!err;
}

/**
 * xy3_stream_abort() - drop what was written and the controller does not have yet
 * @stream: the stream
 *
 * A stream that runs goes on, and repeats the last position that the controller has. Commands are
 * not dropped. Does not wait for a writer, nor for xy3_stream_stop(), which then ends sooner.
 */
void xy3_stream_abort(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	stream->aborted = true;
	xy3_drop_written(stream);
	wake_up_all(&stream->done);
	wake_up_interruptible_poll(stream->writers, EPOLLOUT | EPOLLWRNORM);
}

/**
 * xy3_stream_leave() - the stream is going to end for good: drop what was written, take no more
 * @stream: the stream
 */
void xy3_stream_leave(struct xy3_stream *stream)
{
	scoped_guard(spinlock_irqsave, &stream->lock)
		stream->leaving = true;
	xy3_stream_abort(stream);
	cancel_delayed_work_sync(&stream->underrun);
}

/**
 * xy3_stream_suspend() - stop a stream that runs, as after an error
 * @stream: the stream
 *
 * What the controller has is sent, and the gate lowered; the rest is dropped. Writers get
 * -ESHUTDOWN until the stream is started anew.
 */
void xy3_stream_suspend(struct xy3_stream *stream)
{
	scoped_guard(spinlock_irqsave, &stream->lock) {
		if (!stream->running)
			return;
		xy3_stream_fail(stream, -ESHUTDOWN);
		xy3_close_after_error(stream);
		wake_up_all(&stream->done);
		wake_up_interruptible_poll(stream->writers, EPOLLOUT | EPOLLWRNORM);
	}
	wait_event(stream->done, xy3_stream_idle(stream));
}

/**
 * xy3_stream_stop() - send what was written, then stop
 * @stream: the stream
 *
 * The last scan written is the last one sent; with a gate it is repeated once with the gate low.
 * Who is killed meanwhile waits for what the controller has only, and the rest is dropped.
 */
void xy3_stream_stop(struct xy3_stream *stream)
{
	scoped_guard(spinlock_irqsave, &stream->lock) {
		stream->running = false;
		xy3_pump(stream, false);
	}
	if (wait_event_killable(stream->done, xy3_stream_silent(stream))) {
		xy3_stream_abort(stream);
		wait_event(stream->done, xy3_stream_silent(stream));
	}
	xy3_stream_close(stream);
	xy3_stream_unprepare(stream);
}

/* Scans that there is room for */
static size_t xy3_stream_free(const struct xy3_stream *stream)
{
	const struct xy3_block *block = stream->filling;

	return stream->empties * stream->block_scans +
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
	size_t scans;

	guard(spinlock_irqsave)(&stream->lock);
	if (!stream->running || stream->leaving || stream->error)
		return 1;
	scans = xy3_stream_free(stream);
	return scans < stream->wanted ? 0 : scans;
}

/**
 * xy3_stream_waiting() - how much was written that the controller does not have yet
 * @stream: the stream
 *
 * Return: scans.
 */
size_t xy3_stream_waiting(struct xy3_stream *stream)
{
	const struct xy3_block *block;
	size_t scans;

	guard(spinlock_irqsave)(&stream->lock);
	scans = stream->filling ? stream->filling->scans : 0;
	list_for_each_entry(block, &stream->full, node)
		scans += block->scans;
	return scans;
}

/**
 * xy3_stream_begin_write() - what is taken from now on is no part of a write that was aborted
 * @stream: the stream
 */
void xy3_stream_begin_write(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	stream->aborted = false;
}

/**
 * xy3_stream_take() - take the block that is to be filled
 * @stream: the stream
 * @scans: what is to be written, to this block and the next ones
 *
 * There is one writer at a time: once it has found room for all, nobody takes that away.
 *
 * Return: the block, with room for one scan at least; NULL when there is no room for @scans;
 * -ECANCELED when the write is aborted, -ENODEV when the stream ends for good, -EINVAL when it does
 * not run, or the controller's error.
 */
struct xy3_block *xy3_stream_take(struct xy3_stream *stream, size_t scans)
{
	struct xy3_block *block;

	guard(spinlock_irqsave)(&stream->lock);
	if (stream->leaving)
		return ERR_PTR(-ENODEV);
	if (!stream->running)
		return ERR_PTR(-EINVAL);
	if (stream->error)
		return ERR_PTR(stream->error);
	if (stream->aborted)
		return ERR_PTR(-ECANCELED);
	if (xy3_stream_free(stream) < scans) {
		stream->wanted = scans;
		return NULL;
	}
	stream->wanted = 0;
	block = stream->filling;
	stream->filling = NULL;
	if (!block) {
		block = list_first_entry(&stream->empty, struct xy3_block, node);
		list_del(&block->node);
		stream->empties--;
		block->scans = 0;
	}
	return block;
}

/**
 * xy3_stream_give() - give a block back, with more in it or not
 * @stream: the stream
 * @block: the block that xy3_stream_take() gave
 */
void xy3_stream_give(struct xy3_stream *stream, struct xy3_block *block)
{
	int err = block->scans ? xy3_block_prepare(block) : 0;

	guard(spinlock_irqsave)(&stream->lock);
	if (err) {
		stream->stat[XY3_ERRORS]++;
		xy3_stream_fail(stream, err);
		xy3_close_after_error(stream);
	}
	if (!block->scans || stream->error || stream->aborted)
		xy3_put_empty(block);
	else if (block->scans == block->scans_max)
		list_add_tail(&block->node, &stream->full);
	else
		stream->filling = block;
	xy3_pump(stream, false);
}

static int xy3_stream_change(struct xy3_stream *stream, const struct xy3_line_map *map,
			     unsigned int rate)
{
	struct xy3_line_map map_was = stream->map;
	unsigned int rate_was = stream->rate;
	int err;

	xy3_commands_hold(stream);
	stream->map = *map;
	stream->rate = clamp(rate, xy3_stream_rate_min(stream), xy3_stream_rate_max(stream));
	err = xy3_commands_new_block(stream);
	if (err) {
		stream->map = map_was;
		stream->rate = rate_was;
	}
	xy3_commands_release(stream);
	return err;
}

/**
 * xy3_stream_resize() - change the size of the frames
 * @stream: the stream, which does not run
 * @frame_bits: 24 or 32
 *
 * The rate goes to the nearest one that the bus can do with frames of that size.
 *
 * Return: 0, -EINVAL, -ENOMEM or the controller's error.
 */
int xy3_stream_resize(struct xy3_stream *stream, unsigned int frame_bits)
{
	struct xy3_line_map map;
	int err;

	err = xy3_line_map_init(&map, stream->map.lines, frame_bits, stream->map.signal);
	if (err)
		return err;
	return xy3_stream_change(stream, &map, stream->rate);
}

/**
 * xy3_stream_set_rate() - change the rate
 * @stream: the stream, which does not run
 * @rate: frames per second
 *
 * Return: 0; -ERANGE when the bus cannot do it; -ENOMEM or the controller's error.
 */
int xy3_stream_set_rate(struct xy3_stream *stream, unsigned int rate)
{
	if (rate < xy3_stream_rate_min(stream) || rate > xy3_stream_rate_max(stream))
		return -ERANGE;
	return xy3_stream_change(stream, &stream->map, rate);
}

/**
 * xy3_stream_init() - prepare a stream
 * @stream: the stream; all up to its lock is filled in
 *
 * Return: 0, -ENOMEM or the controller's error.
 */
int xy3_stream_init(struct xy3_stream *stream)
{
	unsigned int repeats = xy3_scans_max(stream, XY3_REPEAT_SCANS_MAX);
	struct xy3_block *block;
	int err;

	INIT_DELAYED_WORK(&stream->retry, xy3_retry);
	spin_lock_init(&stream->lock);
	init_waitqueue_head(&stream->done);
	INIT_LIST_HEAD(&stream->empty);
	INIT_LIST_HEAD(&stream->full);
	INIT_LIST_HEAD(&stream->spare);
	stream->write_max = 1;

	err = xy3_commands_init(stream);
	if (err)
		return err;
	stream->closing = xy3_block_new(stream, 1);
	err = stream->closing ? xy3_blocks_new(stream, &stream->spare, XY3_BLOCKS_QUEUED, repeats) :
				-ENOMEM;
	if (err) {
		xy3_block_free(stream->closing);
		xy3_commands_exit(stream);
		return err;
	}
	stream->closing->scans = 1;
	stream->closing->repeats = true;
	list_for_each_entry(block, &stream->spare, node)
		block->repeats = true;
	return 0;
}

/**
 * xy3_stream_exit() - let a stream go, when the controller has sent all
 * @stream: the stream
 */
void xy3_stream_exit(struct xy3_stream *stream)
{
	xy3_stream_stop(stream);
	wait_event(stream->done, xy3_stream_idle(stream));
	cancel_delayed_work_sync(&stream->retry);
	xy3_stream_no_blocks(stream);
	xy3_blocks_free(&stream->spare);
	xy3_block_free(stream->closing);
	xy3_commands_exit(stream);
}
