// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: the IIO device - one output channel for each axis, and a buffer
 */

#include <linux/err.h>
#include <linux/iio/buffer.h>
#include <linux/iio/iio.h>
#include <linux/iio/sysfs.h>
#include <linux/kobject.h>
#include <linux/kstrtox.h>
#include <linux/lockdep.h>
#include <linux/sysfs.h>

#include "xy3-spi.h"

static const char * const xy3_letters[XY3_AXES] = {
	[XY3_AXIS_X] = "x",
	[XY3_AXIS_Y] = "y",
	[XY3_AXIS_Z] = "z",
	[XY3_AXIS_U] = "u",
	[XY3_AXIS_W] = "w",
};

#define XY3_GATE_LABEL	"gate"

/* ---- one position ---- */

static int xy3_read_raw(struct iio_dev *indio_dev, struct iio_chan_spec const *channel, int *value,
			int *shift, long mask)
{
	struct xy3_iio *iio = iio_priv(indio_dev);
	struct xy3_stream *stream = &iio->stream;
	u32 position[XY3_COLUMNS_MAX];
	unsigned int bits, rate;

	scoped_guard(spinlock_irqsave, &stream->lock) {
		bits = channel->scan_type.realbits;
		rate = stream->rate;
	}
	switch (mask) {
	case IIO_CHAN_INFO_RAW:
		xy3_stream_position(stream, position);
		*value = position[channel->scan_index];
		return IIO_VAL_INT;
	/* the field's angle is unknown: 0 is its middle, 1 a step of the codes of short frames */
	case IIO_CHAN_INFO_OFFSET:
		*value = -(1 << (bits - 1));
		return IIO_VAL_INT;
	case IIO_CHAN_INFO_SCALE:
		*value = 1;
		*shift = bits - XY3_CODE24_BITS;
		return IIO_VAL_FRACTIONAL_LOG2;
	case IIO_CHAN_INFO_SAMP_FREQ:
		*value = rate;
		return IIO_VAL_INT;
	default:
		return -EINVAL;
	}
}

static int xy3_read_avail(struct iio_dev *indio_dev, struct iio_chan_spec const *channel,
			  const int **values, int *type, int *count, long mask)
{
	struct xy3_iio *iio = iio_priv(indio_dev);

	if (mask != IIO_CHAN_INFO_SAMP_FREQ)
		return -EINVAL;
	scoped_guard(spinlock_irqsave, &iio->stream.lock) {
		iio->rates[0] = xy3_stream_rate_min(&iio->stream);
		iio->rates[1] = 1;
		iio->rates[2] = xy3_stream_rate_max(&iio->stream);
	}
	*values = iio->rates;
	*type = IIO_VAL_INT;
	return IIO_AVAIL_RANGE;
}

static int xy3_write_position(struct xy3_iio *iio, unsigned int index, int value)
{
	u32 position[XY3_COLUMNS_MAX];

	lockdep_assert_held(&iio->lock);
	if (value < 0 || value > xy3_code_max(&iio->stream.map))
		return -ERANGE;
	xy3_stream_position(&iio->stream, position);
	position[index] = value;
	return xy3_stream_send_position(&iio->stream, position);
}

static int xy3_write_raw(struct iio_dev *indio_dev, struct iio_chan_spec const *channel, int value,
			 int unused, long mask)
{
	struct xy3_iio *iio = iio_priv(indio_dev);
	int err = -EINVAL;

	/* while a stream runs, only its scans are sent */
	if (!iio_device_claim_direct(indio_dev))
		return -EBUSY;
	scoped_guard(mutex, &iio->lock) {
		if (mask == IIO_CHAN_INFO_RAW)
			err = xy3_write_position(iio, channel->scan_index, value);
		else if (mask == IIO_CHAN_INFO_SAMP_FREQ)
			err = value < 0 ? -ERANGE : xy3_stream_set_rate(&iio->stream, value);
	}
	iio_device_release_direct(indio_dev);
	return err;
}

static int xy3_write_raw_get_fmt(struct iio_dev *indio_dev, struct iio_chan_spec const *channel,
				 long mask)
{
	return IIO_VAL_INT;
}

static int xy3_read_label(struct iio_dev *indio_dev, struct iio_chan_spec const *channel,
			  char *label)
{
	return sysfs_emit(label, "%s\n", channel->type == IIO_ANGL ?
			  xy3_letters[channel->address] : XY3_GATE_LABEL);
}

/* ---- settings and status ---- */

#define XY3_CODE_BITS_MORE	(XY3_CODE32_BITS - XY3_CODE24_BITS)

static void xy3_set_bits(struct xy3_iio *iio, unsigned int bits)
{
	for (unsigned int i = 0; i < iio->stream.map.axes; i++)
		iio->channels[i].scan_type.realbits = bits == 32 ? XY3_CODE32_BITS :
								     XY3_CODE24_BITS;
}

static ssize_t frame_bits_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_stream *stream = xy3_iio_stream(dev_to_iio_dev(dev));
	unsigned int bits;

	scoped_guard(spinlock_irqsave, &stream->lock)
		bits = stream->map.frame_bits;
	return sysfs_emit(buf, "%u\n", bits);
}

/* Positions do not change: six bits more, or six less */
static int xy3_change_bits(struct xy3_iio *iio, unsigned int bits)
{
	unsigned int was = iio->stream.map.frame_bits;
	u32 *position;
	int err;

	lockdep_assert_held(&iio->lock);
	err = xy3_stream_resize(&iio->stream, bits);
	if (err || bits == was)
		return err;
	guard(spinlock_irqsave)(&iio->stream.lock);
	position = xy3_queue(&iio->stream)->position;
	for (unsigned int i = 0; i < iio->stream.map.axes; i++) {
		if (bits == 32)
			position[i] <<= XY3_CODE_BITS_MORE;
		else
			position[i] >>= XY3_CODE_BITS_MORE;
	}
	xy3_set_bits(iio, bits);
	return 0;
}

static ssize_t frame_bits_store(struct device *dev, struct device_attribute *attr, const char *buf,
				size_t count)
{
	struct iio_dev *indio_dev = dev_to_iio_dev(dev);
	struct xy3_iio *iio = iio_priv(indio_dev);
	unsigned int bits;
	int err;

	err = kstrtouint(buf, 10, &bits);
	if (err)
		return err;
	if (!iio_device_claim_direct(indio_dev))
		return -EBUSY;
	scoped_guard(mutex, &iio->lock)
		err = xy3_change_bits(iio, bits);
	iio_device_release_direct(indio_dev);
	return err ?: count;
}
static DEVICE_ATTR_RW(frame_bits);

/* Takes no lock that a writer, or a waiter for the end of the stream, may hold for long */
static ssize_t abort_store(struct device *dev, struct device_attribute *attr, const char *buf,
			   size_t count)
{
	bool value;
	int err;

	err = kstrtobool(buf, &value);
	if (err)
		return err;
	if (!value)
		return -EINVAL;
	xy3_stream_abort(xy3_iio_stream(dev_to_iio_dev(dev)));
	return count;
}
static DEVICE_ATTR_WO(abort);

static ssize_t underruns_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_stream *stream = xy3_iio_stream(dev_to_iio_dev(dev));

	return sysfs_emit(buf, "%llu\n", xy3_stream_stat(stream, XY3_UNDERRUNS));
}
static DEVICE_ATTR_RO(underruns);

static ssize_t achieved_frequency_show(struct device *dev, struct device_attribute *attr,
				       char *buf)
{
	return sysfs_emit(buf, "%u\n", xy3_stream_achieved(xy3_iio_stream(dev_to_iio_dev(dev))));
}
static DEVICE_ATTR_RO(achieved_frequency);

static struct attribute *xy3_iio_attrs[] = {
	&dev_attr_frame_bits.attr,
	&dev_attr_abort.attr,
	&dev_attr_achieved_frequency.attr,
	&dev_attr_underruns.attr,
	NULL
};

static const struct attribute_group xy3_iio_group = {
	.attrs = xy3_iio_attrs,
};

static const struct iio_info xy3_iio_info = {
	.read_raw = xy3_read_raw,
	.read_avail = xy3_read_avail,
	.write_raw = xy3_write_raw,
	.write_raw_get_fmt = xy3_write_raw_get_fmt,
	.read_label = xy3_read_label,
	.attrs = &xy3_iio_group,
};

/* ---- the stream of the buffer ---- */

static int xy3_postenable(struct iio_dev *indio_dev)
{
	return xy3_stream_start(xy3_iio_stream(indio_dev));
}

static int xy3_predisable(struct iio_dev *indio_dev)
{
	struct xy3_iio *iio = iio_priv(indio_dev);

	/* a part of a write in progress may complete; no writer waits until all has been sent */
	scoped_guard(mutex, &iio->lock)
		xy3_stream_end(&iio->stream);
	xy3_stream_stop(&iio->stream);
	return 0;
}

static void xy3_notify_underrun(struct work_struct *work)
{
	struct xy3_iio *iio = container_of(to_delayed_work(work), struct xy3_iio, stream.underrun);
	char *properties[] = { "XY3_EVENT=underrun", NULL };

	xy3_stream_notified(&iio->stream);
	sysfs_notify(&iio->dev->kobj, NULL, "underruns");
	kobject_uevent_env(&iio->dev->kobj, KOBJ_CHANGE, properties);
}

static const struct iio_buffer_setup_ops xy3_setup_ops = {
	.postenable = xy3_postenable,
	.predisable = xy3_predisable,
};

/* ---- for the bus ---- */

static void xy3_make_channels(struct xy3_iio *iio)
{
	unsigned int axes = iio->stream.map.axes;

	for (unsigned int i = 0; i < axes; i++)
		iio->channels[i] = (struct iio_chan_spec) {
			.type = IIO_ANGL,
			.output = 1,
			.indexed = 1,
			.channel = i,
			.address = iio->stream.map.axis[i],
			.info_mask_separate = BIT(IIO_CHAN_INFO_RAW),
			.info_mask_shared_by_type = BIT(IIO_CHAN_INFO_SCALE) |
						    BIT(IIO_CHAN_INFO_OFFSET),
			.info_mask_shared_by_all = BIT(IIO_CHAN_INFO_SAMP_FREQ),
			.info_mask_shared_by_all_available = BIT(IIO_CHAN_INFO_SAMP_FREQ),
			.scan_index = i,
			.scan_type = {
				.sign = 'u',
				.storagebits = 32,
				.endianness = IIO_LE,
			},
		};
	xy3_set_bits(iio, iio->stream.map.frame_bits);
	/* no raw value: the gate is low outside of streams */
	iio->channels[axes] = (struct iio_chan_spec) {
		.type = IIO_VOLTAGE,
		.output = 1,
		.indexed = 1,
		.info_mask_shared_by_all = BIT(IIO_CHAN_INFO_SAMP_FREQ),
		.info_mask_shared_by_all_available = BIT(IIO_CHAN_INFO_SAMP_FREQ),
		.scan_index = axes,
		.scan_type = {
			.sign = 'u',
			.realbits = 1,
			.storagebits = 32,
			.endianness = IIO_LE,
		},
	};
}

static void xy3_keep(struct xy3_stream *stream, struct xy3_kept *kept)
{
	const struct xy3_line_map *map = &stream->map;
	const struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	kept->frame_bits = map->frame_bits;
	kept->rate = stream->rate;
	for (unsigned int i = 0; i < map->axes; i++)
		kept->position[map->axis[i]] = queue->position[i] << xy3_code_shift(map);
	memcpy(kept->stat, queue->stat, sizeof(kept->stat));
}

static void xy3_restore(struct xy3_stream *stream, const struct xy3_kept *kept)
{
	const struct xy3_line_map *map = &stream->map;
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	for (unsigned int i = 0; i < map->axes; i++)
		queue->position[i] = kept->position[map->axis[i]] >> xy3_code_shift(map);
	memcpy(queue->stat, kept->stat, sizeof(kept->stat));
}

/**
 * xy3_iio_register() - create the IIO device
 * @spi: the SPI device
 * @map: the signals of the lines
 * @kept: initial rate, positions and counters; @map has the size of frames
 * @forward: the forward channel, by which it gets commands
 *
 * Return: the IIO device or an error.
 */
struct iio_dev *xy3_iio_register(struct spi_device *spi, const struct xy3_line_map *map,
				 const struct xy3_kept *kept, struct xy3_forward *forward)
{
	struct iio_dev *indio_dev;
	struct xy3_iio *iio;
	int err;

	indio_dev = iio_device_alloc(&spi->dev, sizeof(*iio));
	if (!indio_dev)
		return ERR_PTR(-ENOMEM);
	iio = iio_priv(indio_dev);
	iio->dev = &indio_dev->dev;
	mutex_init(&iio->writer);
	mutex_init(&iio->lock);
	iio->stream.spi = spi;
	iio->stream.map = *map;
	iio->stream.rate = kept->rate;
	iio->stream.forward = forward;
	xy3_buffer_init(iio);
	iio->stream.writers = &iio->buffer.pollq;
	INIT_DELAYED_WORK(&iio->stream.underrun, xy3_notify_underrun);
	xy3_make_channels(iio);

	indio_dev->name = "xy3-100";
	indio_dev->info = &xy3_iio_info;
	indio_dev->setup_ops = &xy3_setup_ops;
	indio_dev->modes = INDIO_DIRECT_MODE | INDIO_BUFFER_SOFTWARE;
	indio_dev->channels = iio->channels;
	indio_dev->num_channels = map->columns;

	err = xy3_stream_init(&iio->stream);
	if (err)
		goto no_stream;
	xy3_restore(&iio->stream, kept);
	err = iio_device_attach_buffer(indio_dev, &iio->buffer);
	if (!err)
		err = iio_device_register(indio_dev);
	if (err)
		goto not_registered;
	xy3_stream_show_counters(&iio->stream);
	return indio_dev;

not_registered:
	xy3_stream_exit(&iio->stream);
no_stream:
	iio_device_free(indio_dev);
	return ERR_PTR(err);
}

/**
 * xy3_iio_retire() - refuse streams, positions and settings, before xy3_iio_unregister()
 * @indio_dev: the IIO device
 *
 * Return: false if a stream runs; then nothing has changed.
 */
bool xy3_iio_retire(struct iio_dev *indio_dev)
{
	if (!iio_device_claim_direct(indio_dev))
		return false;
	xy3_stream_leave(xy3_iio_stream(indio_dev));
	iio_device_release_direct(indio_dev);
	return true;
}

/**
 * xy3_iio_unregister() - remove the IIO device
 * @indio_dev: the IIO device
 * @kept: its state, for the next one
 *
 * If a stream runs, the controller sends the blocks that it has, the rest is dropped.
 */
void xy3_iio_unregister(struct iio_dev *indio_dev, struct xy3_kept *kept)
{
	struct xy3_iio *iio = iio_priv(indio_dev);
	struct kernfs_node *underruns;

	xy3_stream_hide_counters(&iio->stream);
	xy3_stream_leave(&iio->stream);
	underruns = sysfs_get_dirent(iio->dev->kobj.sd, dev_attr_underruns.attr.name);
	iio_device_unregister(indio_dev);
	/* removing a file does not wake its pollers */
	sysfs_notify_dirent(underruns);
	sysfs_put(underruns);
	/* the stream has ended, and writers get no blocks */
	xy3_stream_exit(&iio->stream);
	xy3_keep(&iio->stream, kept);
	iio_device_free(indio_dev);
}
