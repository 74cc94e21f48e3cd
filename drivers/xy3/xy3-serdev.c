// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: the serdev driver - a backchannel that firmware describes
 *
 * The binding is lasia,xy3-100-backchannel.yaml. A serdev hands over no line errors.
 */

#include <linux/errno.h>
#include <linux/mod_devicetable.h>
#include <linux/module.h>
#include <linux/property.h>
#include <linux/serdev.h>
#include <linux/slab.h>
#include <tty-compat.h>

#include "xy3.h"

/**
 * struct xy3_serdev - a backchannel by serdev
 * @back: the backchannel
 * @serdev: the UART
 * @lock: held while data are taken in; protects @attached
 * @attached: @back has a head. The UART is opened before and closed after that
 */
struct xy3_serdev {
	struct xy3_back back;
	struct serdev_device *serdev;
	struct mutex lock;	/* see above */
	bool attached;
};

static serdev_size_t xy3_serdev_receive(struct serdev_device *serdev, const u8 *data, size_t size)
{
	struct xy3_serdev *x = serdev_device_get_drvdata(serdev);

	guard(mutex)(&x->lock);
	if (x->attached)
		xy3_back_receive(&x->back, data, NULL, size);
	return size;
}

static const struct serdev_device_ops xy3_serdev_ops = {
	.receive_buf = xy3_serdev_receive,
};

static int xy3_serdev_set_rate(struct xy3_back *back, unsigned int was, unsigned int rate)
{
	struct serdev_device *serdev = container_of(back, struct xy3_serdev, back)->serdev;

	if (xy3_rate_close(serdev_device_set_baudrate(serdev, rate), rate))
		return 0;
	serdev_device_set_baudrate(serdev, was);
	return -EINVAL;
}

static const struct xy3_back_ops xy3_serdev_back_ops = {
	.set_rate = xy3_serdev_set_rate,
};

static int xy3_serdev_open(struct xy3_serdev *x)
{
	unsigned int rate = XY3_RATE_DEFAULT;
	int err;

	device_property_read_u32(&x->serdev->dev, "current-speed", &rate);
	if (xy3_rate_command(rate) < 0)
		return dev_err_probe(&x->serdev->dev, -EINVAL, "a head has no rate of %u bit/s\n",
				     rate);

	err = serdev_device_open(x->serdev);
	if (err)
		return err;
	serdev_device_set_flow_control(x->serdev, false);
	serdev_device_set_parity(x->serdev, SERDEV_PARITY_NONE);
	if (!xy3_rate_close(serdev_device_set_baudrate(x->serdev, rate), rate)) {
		serdev_device_close(x->serdev);
		return dev_err_probe(&x->serdev->dev, -EINVAL, "the UART cannot do %u bit/s\n",
				     rate);
	}
	x->back.rate = rate;
	return 0;
}

static int xy3_serdev_probe(struct serdev_device *serdev)
{
	struct xy3_serdev *x;
	int err;

	x = devm_kzalloc(&serdev->dev, sizeof(*x), GFP_KERNEL);
	if (!x)
		return -ENOMEM;
	x->serdev = serdev;
	x->back.ops = &xy3_serdev_back_ops;
	x->back.dev = &serdev->dev;
	mutex_init(&x->lock);
	serdev_device_set_drvdata(serdev, x);
	serdev_device_set_client_ops(serdev, &xy3_serdev_ops);

	err = xy3_serdev_open(x);
	if (err)
		return err;
	err = xy3_back_attach(&x->back);
	if (err) {
		serdev_device_close(serdev);
		return err;
	}
	guard(mutex)(&x->lock);
	x->attached = true;
	return 0;
}

static void xy3_serdev_remove(struct serdev_device *serdev)
{
	struct xy3_serdev *x = serdev_device_get_drvdata(serdev);

	scoped_guard(mutex, &x->lock)
		x->attached = false;
	xy3_back_detach(&x->back);
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
