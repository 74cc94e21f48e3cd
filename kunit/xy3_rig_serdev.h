/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * A UART described by firmware, for the KUnit suite of the driver of scanheads
 *
 * Nodes are added to the devicetree, and a mock serdev controller registers the child node of a
 * scanhead, so that the driver binds as on a board.
 */
#ifndef XY3_RIG_SERDEV_H
#define XY3_RIG_SERDEV_H

#include <linux/device/driver.h>
#include <linux/mutex.h>
#include <linux/serdev.h>

#include "xy3_rig.h"

/* ---- firmware ---- */

/**
 * struct firmware_text - properties of the backchannel of a scanhead
 * @has_speed: the property current-speed exists
 * @speed: its value
 * @big_endian: the property big-endian exists
 * @forward: node of the forward channel of the same head, or NULL
 */
struct firmware_text {
	bool has_speed;
	u32 speed;
	bool big_endian;
	struct device_node *forward;
};

/**
 * struct firmware - nodes added to the tree
 * @changes: the change set that added them
 * @np: the outer one
 * @child: the inner one, or NULL
 */
struct firmware {
	struct of_changeset changes;
	struct device_node *np;
	struct device_node *child;
};

static u32 firmware_phandles = 0x1000;

static void firmware_drop(void *data)
{
	struct firmware *firmware = data;

	of_changeset_revert(&firmware->changes);
	of_changeset_destroy(&firmware->changes);
	of_node_put(firmware->child);
	of_node_put(firmware->np);
}

static struct firmware *firmware_begin(struct kunit *test, const char *kind)
{
	struct firmware *firmware = kunit_kzalloc(test, sizeof(*firmware), GFP_KERNEL);
	char name[32];

	KUNIT_ASSERT_NOT_NULL(test, firmware);
	KUNIT_ASSERT_NOT_NULL(test, of_root);
	snprintf(name, sizeof(name), "xy3-rig-%s-%u", kind, rig_numbers++);
	of_changeset_init(&firmware->changes);
	firmware->np = of_changeset_create_node(&firmware->changes, of_root, name);
	KUNIT_ASSERT_NOT_NULL(test, firmware->np);
	return firmware;
}

static void firmware_end(struct kunit *test, struct firmware *firmware)
{
	KUNIT_ASSERT_EQ(test, 0, of_changeset_apply(&firmware->changes));
	KUNIT_ASSERT_EQ(test, 0, kunit_add_action_or_reset(test, firmware_drop, firmware));
}

/* The node of a forward channel */
static inline struct device_node *firmware_forward(struct kunit *test)
{
	struct firmware *firmware = firmware_begin(test, "forward");

	firmware_end(test, firmware);
	/* a change set would add properties too late for this one */
	firmware->np->phandle = firmware_phandles++;
	return firmware->np;
}

/* The node of a UART, and in it that of a scanhead */
static struct device_node *firmware_uart(struct kunit *test, const struct firmware_text *text)
{
	struct firmware *firmware = firmware_begin(test, "uart");
	struct of_changeset *changes = &firmware->changes;
	struct device_node *child;
	int err;

	child = of_changeset_create_node(changes, firmware->np, "scanhead");
	KUNIT_ASSERT_NOT_NULL(test, child);
	firmware->child = child;
	err = of_changeset_add_prop_string(changes, child, "compatible",
					   "lasia,xy3-100-backchannel");
	if (!err && text->has_speed)
		err = of_changeset_add_prop_u32(changes, child, "current-speed", text->speed);
	if (!err && text->big_endian)
		err = of_changeset_add_prop_bool(changes, child, "big-endian");
	if (!err && text->forward)
		err = of_changeset_add_prop_u32(changes, child, "lasia,forward",
						text->forward->phandle);
	KUNIT_ASSERT_EQ(test, 0, err);
	firmware_end(test, firmware);
	return firmware->np;
}

/* ---- the UART ---- */

/**
 * struct uart - a UART with a scanhead on it
 * @ctrl: its serdev controller
 * @dev: the device on it
 * @lock: protects @opened; data are only received while it is held
 * @opened: opens minus closes
 * @open_error: result of open()
 * @rate: in bit/s
 * @can: supported rates; NULL for all
 * @too_fast: deviation of its rates in parts per 1000
 * @flow_control: hardware flow control is on
 * @parity: as set last
 * @parity_error: result of set_parity()
 * @babble: data are received before the end of the driver's probe
 */
struct uart {
	struct serdev_controller *ctrl;
	struct device *dev;
	struct mutex lock;	/* see above */
	int opened;
	int open_error;
	unsigned int rate;
	bool (*can)(unsigned int rate);
	int too_fast;
	bool flow_control;
	enum serdev_parity parity;
	int parity_error;
	bool babble;
};

static struct uart *uart_of(struct serdev_controller *ctrl)
{
	return *(struct uart **)serdev_controller_get_drvdata(ctrl);
}

/* Memory of exactly @size bytes: KASAN detects that the driver reads beyond it */
static void uart_send(struct kunit *test, struct uart *uart, const u8 *data, size_t size)
{
	u8 *copy = kmemdup(data, size, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, copy);
	scoped_guard(mutex, &uart->lock)
		if (uart->opened)
			serdev_controller_receive_buf(uart->ctrl, copy, size);
	kfree(copy);
}

#define SEND(test, uart, ...) do {							\
	static const u8 __data[] = { __VA_ARGS__ };					\
											\
	uart_send(test, uart, __data, sizeof(__data));					\
} while (0)

/* For a sync source */
static inline void uart_send_syncs(void *data, unsigned int rate)
{
	static const u8 syncs[] = { SYNC, SYNC };
	struct uart *uart = data;

	guard(mutex)(&uart->lock);
	if (uart->opened && uart->rate == rate)
		serdev_controller_receive_buf(uart->ctrl, syncs, sizeof(syncs));
}

static int uart_open(struct serdev_controller *ctrl)
{
	struct uart *uart = uart_of(ctrl);

	if (uart->open_error)
		return uart->open_error;
	guard(mutex)(&uart->lock);
	uart->opened++;
	return 0;
}

static void uart_close(struct serdev_controller *ctrl)
{
	struct uart *uart = uart_of(ctrl);

	guard(mutex)(&uart->lock);
	uart->opened--;
}

static unsigned int uart_set_baudrate(struct serdev_controller *ctrl, unsigned int rate)
{
	static const u8 babble[] = { SYNC, SYNC };
	struct uart *uart = uart_of(ctrl);

	if (uart->can && !uart->can(rate)) {
		log_call(NO_UART, rate);
		return uart->rate;
	}
	uart->rate = rate + (int)rate / 1000 * uart->too_fast;
	log_call(UART, rate);
	if (uart->babble)
		serdev_controller_receive_buf(ctrl, babble, sizeof(babble));
	return uart->rate;
}

static void uart_set_flow_control(struct serdev_controller *ctrl, bool on)
{
	uart_of(ctrl)->flow_control = on;
}

static int uart_set_parity(struct serdev_controller *ctrl, enum serdev_parity parity)
{
	struct uart *uart = uart_of(ctrl);

	if (uart->parity_error)
		return uart->parity_error;
	uart->parity = parity;
	return 0;
}

static const struct serdev_controller_ops uart_ops = {
	.open = uart_open,
	.close = uart_close,
	.set_baudrate = uart_set_baudrate,
	.set_flow_control = uart_set_flow_control,
	.set_parity = uart_set_parity,
};

static void uart_unplug(void *data)
{
	struct uart *uart = data;

	if (!uart->dev)
		return;
	uart->dev = NULL;
	serdev_controller_remove(uart->ctrl);
	serdev_controller_put(uart->ctrl);
}

static struct uart *uart_make(struct kunit *test)
{
	struct uart *uart = kunit_kzalloc(test, sizeof(*uart), GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, uart);
	mutex_init(&uart->lock);
	uart->rate = 9600;
	uart->flow_control = true;
	uart->parity = SERDEV_PARITY_ODD;
	return uart;
}

/* The driver has had the chance to bind when this returns */
static void uart_plug(struct kunit *test, struct uart *uart, const struct firmware_text *text)
{
	struct device_node *np = firmware_uart(test, text);	/* outlives the devices */
	struct device *host;
	char name[32];

	snprintf(name, sizeof(name), "xy3-rig-uart%u", rig_numbers++);
	host = kunit_device_register(test, name);
	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, host);
	device_set_node(host, of_fwnode_handle(np));

	uart->ctrl = serdev_controller_alloc(host, host, sizeof(uart));
	KUNIT_ASSERT_NOT_NULL(test, uart->ctrl);
	*(struct uart **)serdev_controller_get_drvdata(uart->ctrl) = uart;
	uart->ctrl->ops = &uart_ops;
	if (serdev_controller_add(uart->ctrl)) {
		serdev_controller_put(uart->ctrl);
		KUNIT_FAIL_AND_ABORT(test, "no serdev controller");
	}
	wait_for_device_probe();	/* serdev probes asynchronously */
	uart->dev = &uart->ctrl->serdev->dev;
	KUNIT_ASSERT_EQ(test, 0, kunit_add_action_or_reset(test, uart_unplug, uart));
}

static bool uart_bound(const struct uart *uart)
{
	return uart->dev->driver;
}

static int head_is_of(struct device *dev, const void *data)
{
	const struct xy3_back *back = to_xy3_head(dev)->back;

	return back && back->dev == data;
}

/* The head of a UART, or NULL */
static struct xy3_head *uart_head(const struct uart *uart)
{
	struct device *dev = class_find_device(xy3_class, NULL, uart->dev, head_is_of);

	put_device(dev);
	return dev ? to_xy3_head(dev) : NULL;
}

/* A UART whose scanhead is bound; the call log is empty */
static struct uart *uart_come(struct kunit *test, const struct firmware_text *text)
{
	static const struct firmware_text nothing;
	struct uart *uart = uart_make(test);

	uart_plug(test, uart, text ?: &nothing);
	KUNIT_ASSERT_TRUE_MSG(test, uart_bound(uart), "is xy3 loaded?");
	KUNIT_ASSERT_NOT_NULL(test, uart_head(uart));
	clear_call_log();
	return uart;
}

#endif /* XY3_RIG_SERDEV_H */
