// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: commands on their way to the forward channel
 */

#include <linux/errno.h>
#include <linux/export.h>
#include <linux/spinlock.h>

#include "trace.h"
#include "xy3.h"

/* More than fits into any write(), so that the write() is what fails */
#define XY3_ROOM_WITHOUT_END	65536

static int xy3_send_frame(struct xy3_head *head, const u8 *frame, size_t size)
{
	int err;

	scoped_guard(spinlock_irqsave, &head->forward_lock)
		err = head->forward ?
			head->forward->ops->command(head->forward, frame, size) : -ENODEV;
	trace_xy3_frame(head->number, frame, size, err);
	return err;
}

/**
 * xy3_send_frames() - send command frames, as many as there is room for
 * @head: the head
 * @frames: whole command frames, 3 or 4 bytes each
 * @size: bytes of all of them
 *
 * May be called in any context.
 *
 * Return: bytes of the frames that were taken, whole ones, from the first on; 0 when there is no
 * room for any. -EINVAL when there is anything but whole command frames with good parity, and then
 * none is sent; -ENODEV without a forward channel, or its error, when this befalls the first.
 */
ssize_t xy3_send_frames(struct xy3_head *head, const u8 *frames, size_t size)
{
	struct xy3_frame frame;
	size_t at;
	int err;

	for (at = 0; at < size; at += frame.size) {
		xy3_decode_frame(frames + at, size - at, &frame);
		if (frame.verdict != XY3_FRAME_COMMAND)
			return -EINVAL;
	}

	for (at = 0; at < size; at += frame.size) {
		xy3_decode_frame(frames + at, size - at, &frame);
		err = xy3_send_frame(head, frames + at, frame.size);
		if (err)
			return at || err == -EAGAIN ? at : err;
	}
	return at;
}

/**
 * xy3_forward_room() - how many command frames there is room for
 * @head: the head
 *
 * Return: the number; also a large one when to send a frame would be an error.
 */
unsigned int xy3_forward_room(struct xy3_head *head)
{
	guard(spinlock_irqsave)(&head->forward_lock);
	if (!head->forward || !head->forward->ops->room)
		return XY3_ROOM_WITHOUT_END;
	return head->forward->ops->room(head->forward);
}

/**
 * xy3_send_command() - send one command
 * @head: the head
 * @command: XY3_COMMAND_*, with its axes
 *
 * Return: 0; -EAGAIN when there is no room for it; or an error as of xy3_send_frames().
 */
int xy3_send_command(struct xy3_head *head, u32 command)
{
	u8 raw[XY3_FRAME24_SIZE];
	ssize_t sent;

	xy3_encode_command(command, raw);
	sent = xy3_send_frames(head, raw, sizeof(raw));
	if (sent < 0)
		return sent;
	return sent ? 0 : -EAGAIN;
}

/**
 * xy3_forward_unpack() - take a command frame apart, for a forward channel
 * @frame: what its command() was given
 * @size: its bytes
 *
 * Return: XY3_COMMAND_*, with its axes.
 */
u32 xy3_forward_unpack(const u8 *frame, size_t size)
{
	struct xy3_frame parts;

	xy3_decode_frame(frame, size, &parts);
	return parts.data;
}
EXPORT_SYMBOL_GPL(xy3_forward_unpack);
