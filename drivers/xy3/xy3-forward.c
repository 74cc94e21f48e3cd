// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: commands on their way to the forward channel
 */

#include <linux/errno.h>
#include <linux/export.h>
#include <linux/spinlock.h>

#include "trace.h"
#include "xy3.h"

static void xy3_trace_frames(const struct xy3_head *head, const u8 *frames, size_t size, int err)
{
	struct xy3_frame frame;

	if (!trace_frame_enabled())
		return;
	for (; size; frames += frame.size, size -= frame.size) {
		xy3_decode_frame(frames, size, &frame);
		trace_frame(head->number, frames, frame.size, err);
	}
}

/**
 * xy3_send_frames() - send command frames
 * @head: the head
 * @frames: whole command frames, 3 or 4 bytes each
 * @size: bytes of all of them
 *
 * May be called in any context.
 *
 * Return: 0; -EINVAL when there is anything but whole command frames with good parity; -ENODEV
 * without a forward channel; or the forward channel's error. Then none of them was sent.
 */
int xy3_send_frames(struct xy3_head *head, const u8 *frames, size_t size)
{
	struct xy3_frame frame;
	int err;

	for (size_t at = 0; at < size; at += frame.size) {
		xy3_decode_frame(frames + at, size - at, &frame);
		if (frame.verdict != XY3_FRAME_COMMAND)
			return -EINVAL;
	}

	scoped_guard(spinlock_irqsave, &head->forward_lock)
		err = head->forward ?
			head->forward->ops->command(head->forward, frames, size) : -ENODEV;
	xy3_trace_frames(head, frames, size, err);
	return err;
}

/**
 * xy3_send_command() - send one command
 * @head: the head
 * @command: XY3_COMMAND_*, with its axes
 *
 * Return: as xy3_send_frames().
 */
int xy3_send_command(struct xy3_head *head, u32 command)
{
	u8 raw[XY3_FRAME24_SIZE];

	xy3_encode_command(command, raw);
	return xy3_send_frames(head, raw, sizeof(raw));
}

/**
 * xy3_forward_unpack() - take the first of some command frames apart, for a forward channel
 * @frames: what its command() was given
 * @size: their bytes
 * @command: XY3_COMMAND_*, with its axes
 *
 * Return: bytes of the first frame.
 */
size_t xy3_forward_unpack(const u8 *frames, size_t size, u32 *command)
{
	struct xy3_frame frame;

	xy3_decode_frame(frames, size, &frame);
	*command = frame.data;
	return frame.size;
}
EXPORT_SYMBOL_GPL(xy3_forward_unpack);
