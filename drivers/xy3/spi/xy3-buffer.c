// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: the IIO output buffer
 *
 * The writer encodes its data immediately, in the blocks for the controller. When a message is
 * done, the next one only has to be queued.
 */

#include <linux/err.h>
#include <linux/lockdep.h>
#include <linux/minmax.h>
#include <linux/module.h>
#include <linux/uaccess.h>

#include "xy3-spi.h"

static struct xy3_iio *xy3_from_buffer(struct iio_buffer *buffer)
{
	return container_of(buffer, struct xy3_iio, buffer);
}

/* The code, clamped to the nearest edge of the field if it is below 0 or above the maximum */
static u32 xy3_clamp_code(u32 code, u32 max)
{
	if (code <= max)
		return code;
	return (s32)code < 0 ? 0 : max;
}

/*
 * Merge the written channels with the positions of those that are not in the buffer, which do not
 * change during a stream. @position becomes the last scan.
 */
static void xy3_spread_channels(struct xy3_iio *iio, const __le32 *in, size_t scans,
				u32 *position)
{
	const unsigned long *mask = iio->buffer.scan_mask;
	unsigned int axes = iio->stream.map.axes;
	u32 max = xy3_code_max(&iio->stream.map);
	u32 *out = iio->codes;
	u64 clamped = 0;

	xy3_stream_position(&iio->stream, position);

	for (; scans; scans--) {
		for (unsigned int i = 0; i < axes; i++) {
			if (test_bit(i, mask)) {
				u32 code = le32_to_cpu(*in++);

				clamped += code > max;
				position[i] = xy3_clamp_code(code, max);
			}
			*out++ = position[i];
		}
		if (iio->stream.map.gate_line >= 0)
			*out++ = test_bit(axes, mask) ? le32_to_cpu(*in++) : 0;
	}
	if (clamped)
		xy3_stream_count_clamped(&iio->stream, clamped);
}

/* Fill one block, or the rest of it. Return the number of scans; 0 if @wanted have no room. */
static ssize_t xy3_fill_block(struct xy3_iio *iio, const __le32 *in, size_t scans, size_t wanted)
{
	struct xy3_stream *stream = &iio->stream;
	struct xy3_block *block;

	lockdep_assert_held(&iio->lock);
	block = xy3_stream_take(stream, wanted);
	if (IS_ERR_OR_NULL(block))
		return PTR_ERR_OR_ZERO(block);

	scans = min_t(size_t, block->scans_max - block->scans, scans);
	xy3_spread_channels(iio, in, scans, block->position);
	xy3_encode_scans(&stream->map, iio->codes, scans,
			 block->data + block->scans * stream->map.scan_size);
	block->scans += scans;
	xy3_stream_give(stream, block);
	return scans;
}

/* The next scans of a write, of the number @wanted. Return the bytes consumed. */
static ssize_t xy3_write_piece(struct xy3_iio *iio, size_t each, size_t wanted,
			       const char __user *data)
{
	size_t scans = min_t(size_t, wanted, XY3_BLOCK_SCANS_MAX), done = 0;
	ssize_t part;

	/* no lock: a page fault may take long, and the end of a stream must not wait for it */
	if (copy_from_user(iio->input, data, scans * each))
		return -EFAULT;
	guard(mutex)(&iio->lock);
	while (done < scans) {
		part = xy3_fill_block(iio, (void *)iio->input + done * each, scans - done,
				      wanted - done);
		if (part <= 0)
			return done ? done * each : part;
		done += part;
	}
	return done * each;
}

/*
 * If a signal interrupts a write, the IIO core does not return the number of bytes already written,
 * and the program would write them again: so a write is accepted completely or not at all, if
 * possible.
 */
static int xy3_write_all(struct xy3_iio *iio, size_t size, const char __user *data)
{
	struct iio_buffer *buffer = &iio->buffer;
	ssize_t part = 0, done = 0;
	size_t all = size;
	size_t each;

	if (mutex_lock_killable(&iio->writer))
		return -EINTR;
	scoped_guard(mutex, &iio->lock) {
		each = buffer->bytes_per_datum;
		if (!each || !size || size % each)
			part = -EINVAL;
		/* the IIO core calls again with the rest; other writers can write in between */
		size = min(size, xy3_stream_write_max(&iio->stream) * each);
		xy3_stream_begin_write(&iio->stream);
	}
	while (part >= 0 && done < size) {
		part = xy3_write_piece(iio, each, (size - done) / each, data + done);
		/* aborted: all of it was accepted, and dropped */
		if (part == -ECANCELED)
			part = all - done;
		if (part <= 0)
			break;
		done += part;
	}
	if (part < 0 || done == all)
		xy3_stream_end_write(&iio->stream);
	mutex_unlock(&iio->writer);
	return done ?: part;
}

static int xy3_buffer_write(struct iio_buffer *buffer, size_t size, const char __user *data)
{
	int done;

	/* a file of the buffer alone does not hold the module, and a page fault may take long */
	if (!try_module_get(THIS_MODULE))
		return -ENODEV;
	done = xy3_write_all(xy3_from_buffer(buffer), size, data);
	module_put(THIS_MODULE);
	return done;
}

static size_t xy3_buffer_space(struct iio_buffer *buffer)
{
	return xy3_stream_room(&xy3_from_buffer(buffer)->stream);
}

/* The IIO core calls this for an attribute, without a check for NULL */
static size_t xy3_buffer_data(struct iio_buffer *buffer)
{
	return xy3_stream_waiting(&xy3_from_buffer(buffer)->stream);
}

static int xy3_buffer_set_bytes_per_datum(struct iio_buffer *buffer, size_t bytes)
{
	buffer->bytes_per_datum = bytes;
	return 0;
}

static int xy3_buffer_set_length(struct iio_buffer *buffer, unsigned int length)
{
	buffer->length = max(length, 2U);
	return 0;
}

static int xy3_buffer_request_update(struct iio_buffer *buffer)
{
	struct xy3_iio *iio = xy3_from_buffer(buffer);

	guard(mutex)(&iio->lock);
	return xy3_stream_blocks(&iio->stream, buffer->length);
}

static const struct iio_buffer_access_funcs xy3_buffer_access = {
	.write = xy3_buffer_write,
	.space_available = xy3_buffer_space,
	.data_available = xy3_buffer_data,
	.set_bytes_per_datum = xy3_buffer_set_bytes_per_datum,
	.set_length = xy3_buffer_set_length,
	.request_update = xy3_buffer_request_update,
	.modes = INDIO_BUFFER_SOFTWARE,
};

/**
 * xy3_buffer_init() - prepare the buffer of an IIO device
 * @iio: the IIO device
 *
 * The buffer is a part of the IIO device and is freed with it: its first reference is never put,
 * and it has no release(). A file of the buffer may be closed after this module was unloaded. The
 * IIO core reads the functions until then, so these are a part of the IIO device, too.
 */
void xy3_buffer_init(struct xy3_iio *iio)
{
	struct iio_buffer *buffer = &iio->buffer;

	iio_buffer_init(buffer);
	iio->access = xy3_buffer_access;
	buffer->access = &iio->access;
	buffer->direction = IIO_BUFFER_DIRECTION_OUT;
	buffer->length = XY3_WRITE_DEFAULT;
}
