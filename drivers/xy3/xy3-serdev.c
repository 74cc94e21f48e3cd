// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: the serdev driver - a backchannel that firmware describes
 *
 * The binding is lasia,xy3-100-backchannel.yaml. A serdev does not report line errors.
 */

#include <linux/errno.h>
#include <linux/mod_devicetable.h>
#include <linux/module.h>
#include <linux/property.h>
#include <linux/serdev.h>
#include <linux/slab.h>

#include "xy3.h"

/**
 * struct xy3_serdev - a backchannel by serdev
 * @back: the backchannel
 * @serdev: the UART
 * @lock: held while data are received; protects @attached
 * @attached: @back has a head. The UART is opened before that, and closed after that
 */
struct xy3_serdev {
	struct xy3_back back;
	struct serdev_device *serdev;
	struct mutex lock;	/* protects @attached */
	bool attached;
};

static size_t xy3_serdev_receive(struct serdev_device *serdev, const u8 *data, size_t size)
{
	struct xy3_serdev *xs = serdev_device_get_drvdata(serdev);

	guard(mutex)(&xs->lock);
	if (xs->attached)
		xy3_back_receive(&xs->back, data, NULL, size);
	return size;
}

static const struct serdev_device_ops xy3_serdev_ops = {
	.receive_buf = xy3_serdev_receive,
};

static int xy3_serdev_set_rate(struct xy3_back *back, unsigned int old_rate,
			       unsigned int rate)
{
	struct serdev_device *serdev = container_of(back, struct xy3_serdev, back)->serdev;

	if (xy3_rate_close(serdev_device_set_baudrate(serdev, rate), rate))
		return 0;
	serdev_device_set_baudrate(serdev, old_rate);
	return -EINVAL;
}

static const struct xy3_back_ops xy3_serdev_back_ops = {
	.set_rate = xy3_serdev_set_rate,
};

static int xy3_serdev_open(struct xy3_serdev *xs)
{
	unsigned int rate = XY3_RATE_DEFAULT;
	int err;

	device_property_read_u32(&xs->serdev->dev, "current-speed", &rate);
	if (!xy3_is_rate(rate))
		return dev_err_probe(&xs->serdev->dev, -EINVAL, "a head has no rate of %u bit/s\n",
				     rate);

	err = serdev_device_open(xs->serdev);
	if (err)
		return err;
	serdev_device_set_flow_control(xs->serdev, false);
	err = serdev_device_set_parity(xs->serdev, SERDEV_PARITY_NONE);
	if (err) {
		dev_err_probe(&xs->serdev->dev, err, "the UART cannot do without parity\n");
		goto err_close;
	}
	if (!xy3_rate_close(serdev_device_set_baudrate(xs->serdev, rate), rate)) {
		err = dev_err_probe(&xs->serdev->dev, -EINVAL, "the UART cannot do %u bit/s\n",
				    rate);
		goto err_close;
	}
	xs->back.rate = rate;
	return 0;

err_close:
	serdev_device_close(xs->serdev);
	return err;
}

static int xy3_serdev_probe(struct serdev_device *serdev)
{
	struct xy3_serdev *xs;
	int err;

	xs = devm_kzalloc(&serdev->dev, sizeof(*xs), GFP_KERNEL);
	if (!xs)
		return -ENOMEM;
	xs->serdev = serdev;
	xs->back.ops = &xy3_serdev_back_ops;
	xs->back.dev = &serdev->dev;
	mutex_init(&xs->lock);
	serdev_device_set_drvdata(serdev, xs);
	serdev_device_set_client_ops(serdev, &xy3_serdev_ops);

	err = xy3_serdev_open(xs);
	if (err)
		return err;
	err = xy3_back_attach(&xs->back);
	if (err) {
		serdev_device_close(serdev);
		return err;
	}
	guard(mutex)(&xs->lock);
	xs->attached = true;
	return 0;
}

static void xy3_serdev_remove(struct serdev_device *serdev)
{
	struct xy3_serdev *xs = serdev_device_get_drvdata(serdev);

	scoped_guard(mutex, &xs->lock)
		xs->attached = false;
	xy3_back_detach(&xs->back);
	serdev_device_close(serdev);
}

static const struct of_device_id xy3_serdev_of_match[] = {
	{ .compatible = "lasia,xy3-100-backchannel" },
	{ }
};
MODULE_DEVICE_TABLE(of, xy3_serdev_of_match);

static struct serdev_device_driver xy3_serdev_driver = {
	.driver = {
		.name = "xy3-backchannel",
		.of_match_table = xy3_serdev_of_match,
	},
	.probe = xy3_serdev_probe,
	.remove = xy3_serdev_remove,
};

/**
 * xy3_serdev_init() - register the driver
 *
 * Return: 0 or an error.
 */
int __init xy3_serdev_init(void)
{
	return serdev_device_driver_register(&xy3_serdev_driver);
}

/**
 * xy3_serdev_exit() - unregister it
 */
void xy3_serdev_exit(void)
{
	serdev_device_driver_unregister(&xy3_serdev_driver);
}
