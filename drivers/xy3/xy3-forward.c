// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: commands on their way to the forward channel
 */

#include <linux/errno.h>
#include <linux/export.h>
#include <linux/spinlock.h>

#include "trace.h"
#include "xy3.h"

/* More than fits into any write(), so that the write() fails */
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
 * xy3_whole_frames() - leave off a torn last frame
 * @frames: frames
 * @size: bytes of all of them
 *
 * Return: bytes up to the end of the last whole frame.
 */
size_t xy3_whole_frames(const u8 *frames, size_t size)
{
	struct xy3_frame frame;
	size_t at;

	for (at = 0; at < size; at += frame.size) {
		xy3_decode_frame(frames + at, size - at, &frame);
		if (frame.verdict == XY3_FRAME_TORN)
			break;
	}
	return at;
}

/**
 * xy3_send_frames() - send as many command frames as there is room for
 * @head: the head
 * @frames: whole command frames, 3 or 4 bytes each
 * @size: bytes of all of them
 *
 * Context: any.
 *
 * Return: bytes of the complete frames that were accepted, from the first on; 0 if there is no
 * room for any. -EINVAL if @frames holds anything but complete command frames with good parity;
 * then none is sent. -ENODEV without a forward channel, or its error, if the first frame fails.
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
 * xy3_forward_room() - number of command frames that there is room for
 * @head: the head
 *
 * Return: the number; a large one if sending a frame would fail.
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
 * Return: 0, -EAGAIN if there is no room for it, or an error of xy3_send_frames().
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
 * xy3_forward_unpack() - decode a command frame, for a forward channel
 * @frame: the frame passed to its command()
 * @size: bytes in @frame
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
