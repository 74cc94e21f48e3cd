// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: the queue of blocks of frames to the controller
 *
 * The controller gets up to XY3_BLOCKS_QUEUED blocks at a time, so that it has the next one when
 * one is done. Commands are sent between two blocks. While a stream runs and its writer is late,
 * blocks that repeat the last position keep the bus busy.
 *
 * Blocks are queued when something is written and when a message is done.
 */

#include <linux/completion.h>
#include <linux/dev_printk.h>
#include <linux/list.h>
#include <linux/poll.h>

#include "xy3-spi.h"

/* Repeating starts while the controller still has a block: with the next one it has this number */
#define XY3_BLOCKS_LOW		2

/* It was written, and does not repeat a position, carry a command or end a stream */
static bool xy3_is_written(const struct xy3_block *block)
{
	return !block->repeats && block != xy3_queue(block->stream)->commands.block;
}

static u8 *xy3_last_scan(struct xy3_block *block)
{
	return block->data + (block->scans - 1) * block->stream->map.scan_size;
}

/* Written blocks: full ones first, then one that the writer has only started to fill */
static struct xy3_block *xy3_next_written(struct xy3_stream *stream)
{
	struct xy3_queue *queue = xy3_queue(stream);
	struct xy3_block *block = list_first_entry_or_null(&queue->full, struct xy3_block, node);

	if (block) {
		list_del(&block->node);
		queue->fulls--;
	} else {
		block = queue->filling;
		queue->filling = NULL;
	}
	/* it may take some time until more is sent */
	if (block)
		xy3_lower_gate_behind(&stream->map, xy3_last_scan(block));
	return block;
}

/* The controller has a written block */
static void xy3_written_is_given(struct xy3_block *block)
{
	struct xy3_stream *stream = block->stream;
	struct xy3_queue *queue = xy3_queue(stream);

	memcpy(queue->last, xy3_last_scan(block), stream->map.scan_size);
	xy3_lower_gate(&stream->map, queue->last);
	queue->primed = true;
	queue->repeating = false;
}

static struct xy3_block *xy3_next_repeated(struct xy3_stream *stream)
{
	struct xy3_queue *queue = xy3_queue(stream);
	struct xy3_block *block = list_first_entry_or_null(&queue->spare, struct xy3_block, node);
	size_t size = stream->map.scan_size;

	if (!block || !queue->running || !queue->primed || queue->queued >= XY3_BLOCKS_LOW)
		return NULL;
	list_del(&block->node);
	for (unsigned int i = 0; i < block->scans; i++)
		memcpy(block->data + i * size, queue->last, size);
	if (!queue->repeating)
		xy3_underrun_begins(stream);
	queue->repeating = true;
	return block;
}

/**
 * xy3_command_put() - stop using a command, which is free after its last user
 * @stream: the stream
 * @command: the command, or NULL
 */
void xy3_command_put(struct xy3_stream *stream, struct xy3_command *command)
{
	struct xy3_queue *queue = xy3_queue(stream);

	if (command && !--command->users)
		list_add(&command->node, &queue->commands.free);
}

static void xy3_command_end(struct xy3_stream *stream, struct xy3_command *command, int err)
{
	command->err = err;
	complete_all(&command->done);
	xy3_command_put(stream, command);
}

/* The block with the next pending command; NULL without one, or while none can be sent */
static struct xy3_block *xy3_next_command(struct xy3_stream *stream)
{
	struct xy3_commands *commands = &xy3_queue(stream)->commands;
	struct xy3_block *block = commands->block;
	struct xy3_command *command;

	if (commands->sending || commands->held)
		return NULL;
	command = list_first_entry_or_null(&commands->waiting, struct xy3_command, node);
	if (!command)
		return NULL;
	list_del(&command->node);
	commands->count--;
	xy3_forward_has_room(stream->forward);
	commands->sending = command;
	xy3_encode_command_scan(&stream->map, command->code, block->data);
	return block;
}

/* The command that was being sent is done: @err is the error if it was not sent */
static void xy3_command_done(struct xy3_stream *stream, int err)
{
	struct xy3_queue *queue = xy3_queue(stream);
	struct xy3_command *command = queue->commands.sending;

	queue->commands.sending = NULL;
	queue->stat[XY3_COMMANDS] += !err;
	xy3_command_end(stream, command, err);
}

/* Drop all pending commands */
static void xy3_commands_fail(struct xy3_stream *stream, int err)
{
	struct xy3_commands *commands = &xy3_queue(stream)->commands;
	struct xy3_command *command, *next;

	list_for_each_entry_safe(command, next, &commands->waiting, node) {
		list_del(&command->node);
		xy3_command_end(stream, command, err);
	}
	commands->count = 0;
	xy3_forward_has_room(stream->forward);
}

/**
 * xy3_put_empty() - return a block to the writer
 * @block: the block, in no list
 */
void xy3_put_empty(struct xy3_block *block)
{
	struct xy3_queue *queue = xy3_queue(block->stream);

	list_add_tail(&block->node, &queue->empty);
	queue->empties++;
}

static void xy3_block_recycle(struct xy3_block *block, int err)
{
	struct xy3_stream *stream = block->stream;
	struct xy3_queue *queue = xy3_queue(stream);

	if (block == queue->commands.block)
		xy3_command_done(stream, err);
	else if (block == stream->closing)
		return;
	else if (block->repeats)
		list_add_tail(&block->node, &queue->spare);
	else
		xy3_put_empty(block);
}

/**
 * xy3_drop_written() - drop written blocks that the controller does not have yet
 * @stream: the stream
 */
void xy3_drop_written(struct xy3_stream *stream)
{
	struct xy3_queue *queue = xy3_queue(stream);

	/* there may be thousands, and interrupts are disabled */
	list_splice_tail_init(&queue->full, &queue->empty);
	queue->empties += queue->fulls;
	queue->fulls = 0;
	if (queue->filling)
		xy3_put_empty(queue->filling);
	queue->filling = NULL;
	if (queue->refused && xy3_is_written(queue->refused)) {
		xy3_put_empty(queue->refused);
		queue->refused = NULL;
		queue->queued--;
	}
}

/**
 * xy3_stream_fail() - the stream has failed: drop all that is pending
 * @stream: the stream
 * @err: the reason
 */
void xy3_stream_fail(struct xy3_stream *stream, int err)
{
	struct xy3_queue *queue = xy3_queue(stream);

	/* once for each stream, and suspending is not an error */
	if (!queue->error && err != -ESHUTDOWN)
		dev_err_ratelimited(&stream->spi->dev,
				    "the controller has not sent a block: error %d\n", err);
	queue->error = err;
	xy3_commands_fail(stream, err);
	xy3_drop_written(stream);
}

static void xy3_block_done(void *context);

/*
 * While another driver has locked the bus, the controller refuses messages. There is no
 * notification of the end of the lock, so the block is retried periodically; the next ones wait.
 */
static int xy3_submit(struct xy3_stream *stream, struct xy3_block *block)
{
	struct xy3_queue *queue = xy3_queue(stream);
	int err = xy3_block_send(block, xy3_block_done);

	if (err == -EBUSY) {
		queue->refused = block;
		queue_delayed_work(system_percpu_wq, &stream->retry, 1);
		err = 0;
	} else if (!err && xy3_is_written(block)) {
		xy3_written_is_given(block);
	}
	if (!err)
		queue->queued++;
	return err;
}

/**
 * xy3_make_closing() - make the scan that ends a stream: the last one sent, with the gate low
 * @stream: the stream
 *
 * Return: false if the gate cannot be high, so that the scan is not required.
 */
bool xy3_make_closing(struct xy3_stream *stream)
{
	struct xy3_queue *queue = xy3_queue(stream);
	struct xy3_block *block = stream->closing;

	if (stream->map.gate_line < 0 || !queue->primed)
		return false;
	xy3_encode_scans(&stream->map, queue->position, 1, block->data);
	return true;
}

/**
 * xy3_close_after_error() - try once to lower the line of the gate, which may be at any level
 * @stream: the stream; nothing is sent unless it has failed, and the controller has no block
 *
 * xy3_stream_stop() sends the same block as soon as the controller has no written block.
 */
void xy3_close_after_error(struct xy3_stream *stream)
{
	struct xy3_queue *queue = xy3_queue(stream);

	if (!queue->running || !queue->error || queue->queued || queue->closed ||
	    !xy3_make_closing(stream))
		return;
	queue->closed = true;
	xy3_submit(stream, stream->closing);
}

/**
 * xy3_pump() - pass pending blocks to the controller
 * @stream: the stream
 * @late: only follow a block that has just been sent
 */
void xy3_pump(struct xy3_stream *stream, bool late)
{
	struct xy3_queue *queue = xy3_queue(stream);
	struct xy3_block *block;
	int err;

	while (!queue->error && !queue->refused && queue->queued < XY3_BLOCKS_QUEUED) {
		block = xy3_next_command(stream);
		if (!block)
			block = xy3_next_written(stream);
		if (!block && late)
			block = xy3_next_repeated(stream);
		if (!block)
			return;
		err = xy3_submit(stream, block);
		if (err) {
			queue->stat[XY3_ERRORS]++;
			xy3_stream_fail(stream, err);
			xy3_block_recycle(block, err);
			xy3_close_after_error(stream);
			return;
		}
	}
}

static void xy3_block_sent(struct xy3_stream *stream, struct xy3_block *block, int err)
{
	struct xy3_queue *queue = xy3_queue(stream);

	queue->queued--;
	if (err) {
		queue->stat[XY3_ERRORS]++;
		xy3_stream_fail(stream, err);
	} else {
		queue->stat[XY3_SCANS] += block->scans;
		queue->stat[XY3_REPEATED] += block->repeats ? block->scans : 0;
		if (xy3_is_written(block))
			memcpy(queue->position, block->position, sizeof(queue->position));
		xy3_measure(stream, block->scans);
	}
	xy3_block_recycle(block, err);
	xy3_pump(stream, true);
	xy3_close_after_error(stream);
	/* under the lock, as the stream may be freed after it */
	wake_up_all(&stream->done);
	if (stream->writers)
		wake_up_interruptible_poll(stream->writers, EPOLLOUT | EPOLLWRNORM);
}

/* A message is done, successfully or not. In any context. */
static void xy3_block_done(void *context)
{
	struct xy3_block *block = context;
	struct xy3_stream *stream = block->stream;

	guard(spinlock_irqsave)(&stream->lock);
	xy3_block_sent(stream, block, xy3_block_status(block));
}

/**
 * xy3_retry() - try to send the refused block again, unless the stream has failed in the meantime
 * @work: the stream's retry
 */
void xy3_retry(struct work_struct *work)
{
	struct xy3_stream *stream = container_of(to_delayed_work(work), struct xy3_stream, retry);
	struct xy3_queue *queue;
	struct xy3_block *block;
	int err;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	block = queue->refused;
	if (!block) {
		/* it was dropped */
		xy3_pump(stream, true);
		return;
	}
	queue->refused = NULL;
	queue->queued--;
	err = block == stream->closing ? 0 : queue->error;
	if (!err)
		err = xy3_submit(stream, block);
	if (err) {
		queue->queued++;
		xy3_block_sent(stream, block, err);
		return;
	}
	xy3_pump(stream, false);
}
