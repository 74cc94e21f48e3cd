// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: the SPI driver - the forward channel
 *
 * Data lines are those of the controller, which must support the number of the device. The line map
 * has the signal of each; SYNC is the chip select, or one of the lines.
 */

#include <linux/bits.h>
#include <linux/err.h>
#include <linux/lockdep.h>
#include <linux/mod_devicetable.h>
#include <linux/module.h>
#include <linux/pm.h>
#include <linux/property.h>
#include <linux/string.h>

#include "xy3-spi.h"

#define XY3_FRAME_BITS_DEFAULT	24
#define XY3_FRAME_RATE_DEFAULT	100000
#define XY3_MIDDLE		BIT(XY3_CODE32_BITS - 1)

/**
 * struct xy3_spi - a forward channel
 * @forward: the interface to the head
 * @spi: the SPI device
 * @lines: number of data lines, or lanes
 * @words: the controller gets a word for each of them
 * @lock: held while the line map is changed; protects @signal and @kept
 * @signal: the line map: enum xy3_signal for each line
 * @kept: initial state of the IIO device
 * @iio_lock: also held while @iio is changed; for commands, which are sent in any context
 * @iio: the IIO device; see xy3_iio()
 * @broken: there is none until another line map is written; protected by @iio_lock
 */
struct xy3_spi {
	struct xy3_forward forward;
	struct spi_device *spi;
	unsigned int lines;
	bool words;
	struct mutex lock;	/* see above */
	u8 signal[XY3_LINES_MAX];
	struct xy3_kept kept;
	spinlock_t iio_lock;	/* see above */
	struct iio_dev *iio;
	bool broken;
};

/* The IIO device does not change while either of the locks is held */
static struct iio_dev *xy3_iio(const struct xy3_spi *x)
{
	lockdep_assert(lockdep_is_held(&x->lock) || lockdep_is_held(&x->iio_lock));
	return x->iio;
}

static void xy3_set_iio(struct xy3_spi *x, struct iio_dev *iio)
{
	lockdep_assert_held(&x->lock);
	lockdep_assert_held(&x->iio_lock);
	x->iio = iio;
	x->broken = false;
}

/* Commands fail, and none waits for an IIO device */
static void xy3_give_up(struct xy3_spi *x)
{
	scoped_guard(spinlock_irqsave, &x->iio_lock)
		x->broken = true;
	xy3_forward_has_room(&x->forward);
}

/* ---- for the head ---- */

static int xy3_spi_command(struct xy3_forward *forward, const u8 *frame, size_t size)
{
	struct xy3_spi *x = container_of(forward, struct xy3_spi, forward);
	u32 command = xy3_forward_unpack(frame, size);
	struct iio_dev *iio;

	guard(spinlock_irqsave)(&x->iio_lock);
	iio = xy3_iio(x);
	if (!iio)
		return x->broken ? -ENODEV : -EAGAIN;
	return xy3_stream_command(xy3_iio_stream(iio), command);
}

static unsigned int xy3_spi_room(struct xy3_forward *forward)
{
	struct xy3_spi *x = container_of(forward, struct xy3_spi, forward);

	struct iio_dev *iio;

	guard(spinlock_irqsave)(&x->iio_lock);
	iio = xy3_iio(x);
	if (!iio)
		return x->broken ? XY3_COMMANDS_QUEUED : 0;
	return xy3_stream_command_room(xy3_iio_stream(iio));
}

static int xy3_spi_drain(struct xy3_forward *forward, unsigned long timeout)
{
	struct xy3_spi *x = container_of(forward, struct xy3_spi, forward);

	struct iio_dev *iio;

	guard(mutex)(&x->lock);
	iio = xy3_iio(x);
	return iio ? xy3_stream_drain(xy3_iio_stream(iio), timeout) : -ENODEV;
}

static const struct xy3_forward_ops xy3_spi_ops = {
	.command = xy3_spi_command,
	.room = xy3_spi_room,
	.drain = xy3_spi_drain,
};

/* ---- the line map ---- */

static int xy3_make_iio(struct xy3_spi *x, const u8 *signal)
{
	unsigned int clocks, lowest, highest;
	struct xy3_line_map map;
	struct iio_dev *iio;
	int err;

	err = xy3_map_init(&map, x->words, x->lines, x->kept.frame_bits, signal);
	if (err)
		return err;
	clocks = map.frame_bits + (map.sync_line < 0 ? 0 : XY3_GAP_CLOCKS);
	lowest = DIV_ROUND_UP(x->spi->controller->min_speed_hz, clocks);
	highest = x->spi->max_speed_hz / clocks;
	if (!highest || lowest > highest)
		return -EINVAL;
	x->kept.rate = clamp(x->kept.rate, lowest, highest);
	xy3_controller_warn_of_map(x->spi, &map);
	iio = xy3_iio_register(x->spi, &map, &x->kept, &x->forward);
	if (IS_ERR(iio))
		return PTR_ERR(iio);
	memcpy(x->signal, signal, x->lines);
	scoped_guard(spinlock_irqsave, &x->iio_lock)
		xy3_set_iio(x, iio);
	xy3_forward_has_room(&x->forward);
	return 0;
}

static void xy3_drop_iio(struct xy3_spi *x)
{
	struct iio_dev *iio = xy3_iio(x);

	if (!iio)
		return;
	scoped_guard(spinlock_irqsave, &x->iio_lock)
		xy3_set_iio(x, NULL);
	xy3_iio_unregister(iio, &x->kept);
}

static const char * const xy3_signal_names[] = {
	[XY3_SIGNAL_X] = "x",
	[XY3_SIGNAL_Y] = "y",
	[XY3_SIGNAL_Z] = "z",
	[XY3_SIGNAL_U] = "u",
	[XY3_SIGNAL_W] = "w",
	[XY3_SIGNAL_SYNC] = "sync",
	[XY3_SIGNAL_GATE] = "gate",
	[XY3_SIGNAL_NONE] = "-",
};

/* Parse a line map: words, one for each line from IO0 on; other lines are unused */
static int xy3_parse_map(const struct xy3_spi *x, const char *const *words, unsigned int count,
			 u8 *signal)
{
	struct xy3_line_map map;
	int found;

	if (!count || count > x->lines)
		return -EINVAL;
	memset(signal, XY3_SIGNAL_NONE, x->lines);
	for (unsigned int i = 0; i < count; i++) {
		found = match_string(xy3_signal_names, ARRAY_SIZE(xy3_signal_names), words[i]);
		if (found < 0)
			return -EINVAL;
		signal[i] = found;
	}
	return xy3_map_init(&map, x->words, x->lines, XY3_FRAME_BITS_DEFAULT, signal);
}

static int xy3_change_map(struct xy3_spi *x, const char *const *words, unsigned int count)
{
	u8 signal[XY3_LINES_MAX];
	int err;

	guard(mutex)(&x->lock);
	err = xy3_parse_map(x, words, count, signal);
	if (err)
		return err;
	if (xy3_iio(x) && !xy3_iio_retire(xy3_iio(x)))
		return -EBUSY;
	/* other axes are other channels: another IIO device starts with the state of this one */
	xy3_drop_iio(x);
	err = xy3_make_iio(x, signal);
	if (err && xy3_make_iio(x, x->signal))
		xy3_give_up(x);
	return err;
}

static const char *xy3_line_signal(const struct xy3_spi *x, unsigned int line)
{
	lockdep_assert_held(&x->lock);
	return xy3_signal_names[x->signal[line]];
}

static ssize_t line_map_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_spi *x = dev_get_drvdata(dev);
	int at = 0;

	guard(mutex)(&x->lock);
	for (unsigned int i = 0; i < x->lines; i++)
		at += sysfs_emit_at(buf, at, "%s%s", i ? " " : "", xy3_line_signal(x, i));
	return at + sysfs_emit_at(buf, at, "\n");
}

static ssize_t line_map_store(struct device *dev, struct device_attribute *attr, const char *buf,
			      size_t count)
{
	struct xy3_spi *x = dev_get_drvdata(dev);
	const char *words[XY3_LINES_MAX];
	unsigned int n = 0;
	char *text, *rest, *word;
	int err = 0;

	text = kstrndup(buf, count, GFP_KERNEL);
	if (!text)
		return -ENOMEM;
	rest = text;
	while (!err && (word = strsep(&rest, " \t\n"))) {
		if (!*word)
			continue;
		if (n == ARRAY_SIZE(words))
			err = -EINVAL;
		else
			words[n++] = word;
	}
	if (!err)
		err = xy3_change_map(x, words, n);
	kfree(text);
	return err ?: count;
}
static DEVICE_ATTR_RW(line_map);

static struct attribute *xy3_spi_attrs[] = {
	&dev_attr_line_map.attr,
	NULL
};
ATTRIBUTE_GROUPS(xy3_spi);

/* ---- the device ---- */

/* The signal of each line: from the property of the device, or the default */
static int xy3_first_map(struct xy3_spi *x, u8 *signal)
{
	const char *words[XY3_LINES_MAX];
	int count;

	count = device_property_string_array_count(&x->spi->dev, "lasia,line-map");
	if (count <= 0) {
		memcpy(signal, xy3_default_signals(x->words ? XY3_LINES_MAX : x->lines, false),
		       x->lines);
		return 0;
	}
	if (count > ARRAY_SIZE(words))
		return -EINVAL;
	count = device_property_read_string_array(&x->spi->dev, "lasia,line-map", words, count);
	if (count < 0)
		return count;
	return xy3_parse_map(x, words, count, signal);
}

static int xy3_spi_probe(struct spi_device *spi)
{
	u8 signal[XY3_LINES_MAX];
	struct xy3_spi *x;
	int err;

	x = devm_kzalloc(&spi->dev, sizeof(*x), GFP_KERNEL);
	if (!x)
		return -ENOMEM;
	x->spi = spi;
	x->forward.ops = &xy3_spi_ops;
	x->forward.dev = &spi->dev;
	mutex_init(&x->lock);
	spin_lock_init(&x->iio_lock);
	x->kept.frame_bits = XY3_FRAME_BITS_DEFAULT;
	x->kept.rate = XY3_FRAME_RATE_DEFAULT;
	/* the positions of the mirrors are unknown; the middle of the field is the safest guess */
	for (unsigned int i = 0; i < XY3_AXES; i++)
		x->kept.position[i] = XY3_MIDDLE;
	spi_set_drvdata(spi, x);

	err = xy3_controller_setup(spi, &x->lines, &x->words);
	if (err)
		return err;
	err = xy3_first_map(x, signal);
	if (err)
		return dev_err_probe(&spi->dev, err, "no line map: lasia,line-map\n");
	scoped_guard(mutex, &x->lock)
		err = xy3_make_iio(x, signal);
	if (err)
		return dev_err_probe(&spi->dev, err, "no IIO device\n");
	err = xy3_forward_attach(&x->forward);
	if (err) {
		guard(mutex)(&x->lock);
		xy3_drop_iio(x);
	}
	return err;
}

static void xy3_spi_remove(struct spi_device *spi)
{
	struct xy3_spi *x = spi_get_drvdata(spi);

	xy3_forward_detach(&x->forward);
	guard(mutex)(&x->lock);
	xy3_drop_iio(x);
}

static int xy3_spi_suspend(struct device *dev)
{
	struct xy3_spi *x = dev_get_drvdata(dev);

	struct iio_dev *iio;

	guard(mutex)(&x->lock);
	iio = xy3_iio(x);
	if (iio)
		xy3_stream_suspend(xy3_iio_stream(iio));
	return 0;
}

static DEFINE_SIMPLE_DEV_PM_OPS(xy3_spi_pm, xy3_spi_suspend, NULL);

static const struct spi_device_id xy3_spi_ids[] = {
	{ .name = "xy3-100" },
	{ }
};
MODULE_DEVICE_TABLE(spi, xy3_spi_ids);

static const struct of_device_id xy3_spi_of_match[] = {
	{ .compatible = "lasia,xy3-100" },
	{ }
};
MODULE_DEVICE_TABLE(of, xy3_spi_of_match);

static struct spi_driver xy3_spi_driver = {
	.driver = {
		.name = "xy3-spi",
		.of_match_table = xy3_spi_of_match,
		.dev_groups = xy3_spi_groups,
		.pm = pm_sleep_ptr(&xy3_spi_pm),
	},
	.id_table = xy3_spi_ids,
	.probe = xy3_spi_probe,
	.remove = xy3_spi_remove,
};

static int __init xy3_spi_init(void)
{
	int err;

	xy3_debugfs_init();
	err = spi_register_driver(&xy3_spi_driver);
	if (err)
		xy3_debugfs_exit();
	return err;
}
module_init(xy3_spi_init);

static void __exit xy3_spi_exit(void)
{
	spi_unregister_driver(&xy3_spi_driver);
	xy3_debugfs_exit();
}
module_exit(xy3_spi_exit);

MODULE_DESCRIPTION("XY3-100 compatible laser scanheads: forward channel by SPI");
MODULE_AUTHOR("xhc-xy3 developers");
MODULE_LICENSE("GPL");
MODULE_VERSION("0.1.0");
