// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: commands, which are sent between two blocks
 */

#include <linux/completion.h>
#include <linux/errno.h>
#include <linux/kernel.h>
#include <linux/list.h>
#include <linux/minmax.h>
#include <linux/wait.h>

#include "xy3-spi.h"

/* ---- the block ---- */

/**
 * xy3_commands_new_block() - replace the block for commands
 * @stream: the stream; commands are held, or there are none yet
 *
 * Return: 0, -ENOMEM or the controller's error; on error the old one is kept.
 */
int xy3_commands_new_block(struct xy3_stream *stream)
{
	struct xy3_block *block = xy3_block_new(stream, 1);
	int err;

	if (!block)
		return -ENOMEM;
	block->scans = 1;
	err = xy3_block_prepare(block);
	if (err) {
		xy3_block_free(block);
		return err;
	}
	scoped_guard(spinlock_irqsave, &stream->lock)
		swap(xy3_queue(stream)->commands.block, block);
	xy3_block_free(block);
	return 0;
}

static bool xy3_command_busy(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	return xy3_queue(stream)->commands.sending;
}

/**
 * xy3_commands_hold() - send no command until xy3_commands_release(); they are still queued
 * @stream: the stream
 *
 * On return none is being sent.
 */
void xy3_commands_hold(struct xy3_stream *stream)
{
	scoped_guard(spinlock_irqsave, &stream->lock)
		xy3_queue(stream)->commands.held = true;
	wait_event(stream->done, !xy3_command_busy(stream));
}

/**
 * xy3_commands_release() - send commands again, after xy3_commands_hold()
 * @stream: the stream
 */
void xy3_commands_release(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	xy3_queue(stream)->commands.held = false;
	xy3_pump(stream, false);
}

/* ---- for the head ---- */

/**
 * xy3_stream_command() - send a command as soon as possible, between two blocks
 * @stream: the stream
 * @code: its 20 bits
 *
 * In any context.
 *
 * Return: 0; -EAGAIN if there is no room for it; or the controller's error, after which this and
 * all pending commands are not sent.
 */
int xy3_stream_command(struct xy3_stream *stream, u32 code)
{
	struct xy3_commands *commands;
	struct xy3_command *command;
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	commands = &queue->commands;
	if (!queue->running)
		queue->error = 0;
	if (queue->error)
		return queue->error;
	if (commands->count == XY3_COMMANDS_QUEUED)
		return -EAGAIN;
	command = list_first_entry(&commands->free, struct xy3_command, node);
	reinit_completion(&command->done);
	command->code = code;
	command->users = 2;
	list_move_tail(&command->node, &commands->waiting);
	commands->count++;
	xy3_command_put(stream, commands->last);
	commands->last = command;
	xy3_pump(stream, false);
	return queue->error;
}

/**
 * xy3_stream_command_room() - number of commands that can be queued
 * @stream: the stream
 *
 * In any context.
 *
 * Return: the number; a large one if a command would fail.
 */
unsigned int xy3_stream_command_room(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	return XY3_COMMANDS_QUEUED - xy3_queue(stream)->commands.count;
}

/**
 * xy3_stream_drain() - wait until all queued commands have been sent
 * @stream: the stream
 * @timeout: maximum time to wait, in jiffies
 *
 * For one caller at a time.
 *
 * Return: 0; the controller's error if the last of them was not sent; or 1 after @timeout.
 */
int xy3_stream_drain(struct xy3_stream *stream, unsigned long timeout)
{
	struct xy3_command *last;
	bool done;
	int err;

	scoped_guard(spinlock_irqsave, &stream->lock) {
		last = xy3_queue(stream)->commands.last;
		if (last)
			last->users++;
	}
	if (!last)
		return 0;
	done = wait_for_completion_timeout(&last->done, timeout);
	guard(spinlock_irqsave)(&stream->lock);
	err = done ? last->err : 1;
	xy3_command_put(stream, last);
	return err;
}

/**
 * xy3_commands_init() - prepare for commands
 * @stream: the stream
 *
 * Return: 0, -ENOMEM or the controller's error.
 */
int xy3_commands_init(struct xy3_stream *stream)
{
	struct xy3_queue *queue = &stream->queue;
	struct xy3_commands *commands = &queue->commands;

	INIT_LIST_HEAD(&commands->waiting);
	INIT_LIST_HEAD(&commands->free);
	for (unsigned int i = 0; i < ARRAY_SIZE(commands->pool); i++) {
		init_completion(&commands->pool[i].done);
		list_add(&commands->pool[i].node, &commands->free);
	}
	return xy3_commands_new_block(stream);
}

/**
 * xy3_commands_exit() - free what xy3_commands_init() has allocated
 * @stream: the stream; all commands have been sent
 */
void xy3_commands_exit(struct xy3_stream *stream)
{
	struct xy3_queue *queue = &stream->queue;

	xy3_block_free(queue->commands.block);
}
