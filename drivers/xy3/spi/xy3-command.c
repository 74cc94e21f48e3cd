// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: commands, which go between two blocks
 */

#include <linux/err.h>
#include <linux/kfifo.h>
#include <linux/wait.h>

#include "xy3-spi.h"

/**
 * xy3_command_block_new() - make a block that carries commands
 * @stream: the stream
 *
 * Return: the block, prepared, or an error.
 */
struct xy3_block *xy3_command_block_new(struct xy3_stream *stream)
{
	struct xy3_block *block = xy3_block_new(stream, 1);
	int err;

	if (!block)
		return ERR_PTR(-ENOMEM);
	block->scans = 1;
	err = xy3_block_prepare(block);
	if (err) {
		xy3_block_free(block);
		return ERR_PTR(err);
	}
	return block;
}

static bool xy3_command_busy(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	return stream->command_busy;
}

/**
 * xy3_commands_hold() - send no command until xy3_commands_release(); they are still taken
 * @stream: the stream
 *
 * On return none is on its way.
 */
void xy3_commands_hold(struct xy3_stream *stream)
{
	scoped_guard(spinlock_irqsave, &stream->lock)
		stream->command_held = true;
	wait_event(stream->done, !xy3_command_busy(stream));
}

/**
 * xy3_commands_release() - undo that
 * @stream: the stream
 */
void xy3_commands_release(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	stream->command_held = false;
	xy3_pump(stream, false);
}

/**
 * xy3_next_command() - take the next command that waits
 * @stream: the stream
 *
 * Return: the block that carries it; NULL without a command, or while none can be sent.
 */
struct xy3_block *xy3_next_command(struct xy3_stream *stream)
{
	struct xy3_block *block = stream->command_block;
	u32 command;

	lockdep_assert_held(&stream->lock);
	if (stream->command_busy || stream->command_held ||
	    !kfifo_get(&stream->commands, &command))
		return NULL;
	xy3_forward_has_room(stream->forward);
	stream->command_busy = true;
	stream->command_number = stream->commands_taken - kfifo_len(&stream->commands);
	if (stream->word_is_scan)
		*(u32 *)block->data = xy3_command_word(&stream->map, command);
	else
		xy3_encode_command_scan(&stream->map, command, block->data);
	return block;
}

/* Numbers of commands go round */
static bool xy3_number_reached(u32 number, u32 reached)
{
	return (s32)(reached - number) >= 0;
}

/**
 * xy3_command_sent() - the command that was on its way has been sent
 * @stream: the stream
 */
void xy3_command_sent(struct xy3_stream *stream)
{
	lockdep_assert_held(&stream->lock);
	stream->stat[XY3_COMMANDS]++;
	if (xy3_number_reached(stream->commands_done, stream->command_number))
		stream->commands_done = stream->command_number;
}

/**
 * xy3_commands_fail() - no command that was taken is sent any more
 * @stream: the stream
 * @err: why
 */
void xy3_commands_fail(struct xy3_stream *stream, int err)
{
	lockdep_assert_held(&stream->lock);
	kfifo_reset(&stream->commands);
	xy3_forward_has_room(stream->forward);
	if (stream->commands_done != stream->commands_taken) {
		stream->command_error = err;
		stream->commands_failed_from = stream->commands_done + 1;
		stream->commands_failed = stream->commands_taken;
		stream->commands_done = stream->commands_taken;
	}
}

/**
 * xy3_stream_command() - send a command as soon as possible, between two blocks
 * @stream: the stream
 * @command: its 20 bits
 *
 * In any context.
 *
 * Return: 0; -EAGAIN when there is no room for it; or the controller's error, and then it and
 * those that were not sent yet never are.
 */
int xy3_stream_command(struct xy3_stream *stream, u32 command)
{
	guard(spinlock_irqsave)(&stream->lock);
	if (!stream->running)
		stream->error = 0;
	if (stream->error)
		return stream->error;
	if (!kfifo_put(&stream->commands, command))
		return -EAGAIN;
	stream->commands_taken++;
	xy3_pump(stream, false);
	return stream->error;
}

/**
 * xy3_stream_command_room() - how many commands there is room for
 * @stream: the stream
 *
 * In any context.
 *
 * Return: the number; also a large one when a command would be an error.
 */
unsigned int xy3_stream_command_room(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	return kfifo_avail(&stream->commands);
}

static bool xy3_command_done(struct xy3_stream *stream, u32 number)
{
	guard(spinlock_irqsave)(&stream->lock);
	return xy3_number_reached(number, stream->commands_done);
}

/**
 * xy3_stream_drain() - wait until all commands that were taken so far have been sent
 * @stream: the stream
 *
 * Return: 0, or the controller's error when the last of them was not.
 */
int xy3_stream_drain(struct xy3_stream *stream)
{
	u32 number;

	scoped_guard(spinlock_irqsave, &stream->lock)
		number = stream->commands_taken;
	wait_event(stream->done, xy3_command_done(stream, number));

	guard(spinlock_irqsave)(&stream->lock);
	if (stream->command_error &&
	    xy3_number_reached(stream->commands_failed_from, number) &&
	    xy3_number_reached(number, stream->commands_failed))
		return stream->command_error;
	return 0;
}
