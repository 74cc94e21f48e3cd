// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of scanheads - heads and their two transports, rates, commands, the serdev
 *
 * xy3.ko is loaded like by users, with the UARTs of xy3_rig_serdev.h on one side and the forward
 * channels of xy3_rig.h on the other. Line discipline and tty have separate suites.
 */

#include <linux/delay.h>
#include <linux/kthread.h>
#include <linux/module.h>

#include "xy3_rig_serdev.h"

/* ---- joining ---- */

struct join_row {
	const char *name;
	bool back_first;
	bool back_leaves_first;
};

static const struct join_row join_rows[] = {
	{ "back comes first, leaves first", true, true },
	{ "back comes first, leaves last", true, false },
	{ "forward comes first, leaves last", false, true },
	{ "forward comes first, leaves first", false, false },
};

static void join_row_name(const struct join_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(join, join_rows, join_row_name);

static void join_test(struct kunit *test)
{
	const struct join_row *row = test->param_value;
	struct forward *forward;
	struct xy3_head *head;
	struct uart *uart;

	if (row->back_first) {
		uart = uart_come(test, NULL);
		forward = forward_come(test);
	} else {
		forward = forward_come(test);
		uart = uart_come(test, NULL);
	}
	head = head_of_number(0);
	KUNIT_ASSERT_NOT_NULL(test, head);
	KUNIT_EXPECT_EQ(test, heads(), 1);
	KUNIT_EXPECT_PTR_EQ(test, uart_head(uart), head);
	KUNIT_EXPECT_PTR_EQ(test, forward->xy3.head, head);

	if (row->back_leaves_first) {
		uart_unplug(uart);
		KUNIT_EXPECT_PTR_EQ(test, head_of_number(0), head);
		EXPECT_SHOWS_ERROR(test, head, "rate", -ENODEV);
		KUNIT_EXPECT_EQ(test, store(head, "reference", ""), 0);
		EXPECT_CALLS(test, { FRAME, 0x080001 });
		forward_leave(forward);
	} else {
		forward_leave(forward);
		KUNIT_EXPECT_PTR_EQ(test, head_of_number(0), head);
		EXPECT_SHOWS(test, head, "rate", "115200");
		KUNIT_EXPECT_EQ(test, store(head, "reference", ""), -ENODEV);
		expect_no_call(test);
		uart_unplug(uart);
	}
	KUNIT_EXPECT_EQ(test, heads(), 0);
}

/* A transport that is removed and added again finds its head, with its old counters */
static void come_back_test(struct kunit *test)
{
	struct forward *forward = forward_come(test);
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	SEND(test, uart, SYNC, SYNC, TEXT_PACKET(1, 3), 'a', 'b', 'c',
	     TEXT_PACKET(7, 2), 0, 1);
	EXPECT_SHOWS(test, head, "vendor", "abc");
	EXPECT_SHOWS(test, head, "errors/dsp", "temperature");
	uart_unplug(uart);
	EXPECT_SHOWS_ERROR(test, head, "errors/dsp", -ENODATA);
	EXPECT_SHOWS(test, head, "in_sync", "0");
	EXPECT_SHOWS_ERROR(test, head, "vendor", -ENODATA);

	uart = uart_come(test, NULL);
	KUNIT_ASSERT_PTR_EQ(test, uart_head(uart), head);
	EXPECT_SHOWS(test, head, "in_sync", "0");
	EXPECT_SHOWS(test, head, "stats/rx_packets", "4");
	SEND(test, uart, SYNC, SYNC);
	EXPECT_SHOWS(test, head, "in_sync", "1");

	forward_leave(forward);
	forward = forward_come(test);
	KUNIT_EXPECT_PTR_EQ(test, forward->xy3.head, head);
	KUNIT_EXPECT_EQ(test, heads(), 1);
}

static void numbers_test(struct kunit *test)
{
	struct forward *forwards[3], *late;

	for (unsigned int i = 0; i < ARRAY_SIZE(forwards); i++) {
		forwards[i] = forward_come(test);
		KUNIT_EXPECT_EQ(test, forwards[i]->xy3.head->number, i);
	}
	/* the lowest free one */
	forward_leave(forwards[1]);
	forward_leave(forwards[0]);
	late = forward_come(test);
	KUNIT_EXPECT_EQ(test, late->xy3.head->number, 0);
	late = forward_come(test);
	KUNIT_EXPECT_EQ(test, late->xy3.head->number, 1);
	late = forward_come(test);
	KUNIT_EXPECT_EQ(test, late->xy3.head->number, 3);
}

/* The head with the lowest number that lacks it, independent of the order of creation */
static void lowest_test(struct kunit *test)
{
	struct forward *forwards[3];
	struct uart *uart;

	for (unsigned int i = 0; i < ARRAY_SIZE(forwards); i++)
		forwards[i] = forward_come(test);
	/* head 0 is created again, later than the others */
	forward_leave(forwards[0]);
	forwards[0] = forward_come(test);
	for (unsigned int i = 0; i < ARRAY_SIZE(forwards); i++) {
		uart = uart_come(test, NULL);
		KUNIT_EXPECT_EQ(test, uart_head(uart)->number, i);
	}
	uart = uart_come(test, NULL);
	KUNIT_EXPECT_EQ(test, uart_head(uart)->number, 3);
	KUNIT_EXPECT_EQ(test, heads(), 4);
}

static void full_test(struct kunit *test)
{
	struct forward *first = forward_come(test), *one_too_many;
	struct uart *uart;

	for (unsigned int i = 1; i < XY3_HEADS_MAX; i++)
		forward_come(test);
	one_too_many = forward_make(test, NULL);
	KUNIT_EXPECT_EQ(test, xy3_forward_attach(&one_too_many->xy3), -ENOSPC);
	KUNIT_EXPECT_FALSE(test, forward_attached(one_too_many));
	KUNIT_EXPECT_EQ(test, heads(), XY3_HEADS_MAX);

	/* control: a head that lacks a transport still accepts it, and numbers can be freed */
	uart = uart_come(test, NULL);
	KUNIT_EXPECT_EQ(test, uart_head(uart)->number, 0);
	forward_leave(first);
	KUNIT_EXPECT_EQ(test, xy3_forward_attach(&one_too_many->xy3), 0);
	KUNIT_EXPECT_EQ(test, one_too_many->xy3.head->number, 0);
}

static void two_heads_test(struct kunit *test)
{
	struct uart *uarts[2] = { uart_come(test, NULL), uart_come(test, NULL) };
	struct xy3_head *head[2] = { uart_head(uarts[0]), uart_head(uarts[1]) };
	struct forward *forwards[2] = { forward_come(test), forward_come(test) };

	KUNIT_ASSERT_PTR_NE(test, head[0], head[1]);
	KUNIT_EXPECT_PTR_EQ(test, forwards[1]->xy3.head, head[1]);
	SEND(test, uarts[1], SYNC, SYNC, TEXT_PACKET(4, 3), '1', '2', '3');
	EXPECT_SHOWS(test, head[1], "serial", "123");
	EXPECT_SHOWS_ERROR(test, head[0], "serial", -ENODATA);
	EXPECT_SHOWS(test, head[0], "stats/rx_bytes", "0");

	forwards[0]->error = -EIO;
	KUNIT_EXPECT_EQ(test, store(head[1], "calibrate", "x"), 0);
	EXPECT_CALLS(test, { FRAME, 0x300007 });
	KUNIT_EXPECT_EQ(test, store(head[0], "calibrate", "x"), -EIO);
	EXPECT_CALLS(test, { NO_FRAME, 0x300007 });

	sync_source_start(test, uart_send_syncs, uarts[1], 57600);
	KUNIT_EXPECT_EQ(test, store(head[1], "rate", "57600"), 0);
	EXPECT_SHOWS(test, head[0], "rate", "115200");
	KUNIT_EXPECT_EQ(test, uarts[0]->rate, 115200);
	KUNIT_EXPECT_EQ(test, uarts[1]->rate, 57600);
}

/* ---- joining as firmware defines ---- */

static void named_back_first_test(struct kunit *test)
{
	struct device_node *node = firmware_forward(test);
	struct uart *named = uart_come(test, &(struct firmware_text){ .forward = node });
	struct uart *other = uart_come(test, NULL);
	struct forward *forward;

	/* the forward channel of head 0 is reserved: no other one joins it */
	forward = forward_come(test);
	KUNIT_EXPECT_PTR_EQ(test, forward->xy3.head, uart_head(other));
	forward = forward_come(test);
	KUNIT_EXPECT_EQ(test, forward->xy3.head->number, 2);

	forward = forward_make(test, node);
	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&forward->xy3));
	KUNIT_EXPECT_PTR_EQ(test, forward->xy3.head, uart_head(named));

	/* and it remains reserved */
	forward_leave(forward);
	KUNIT_EXPECT_EQ(test, forward_come(test)->xy3.head->number, 3);
	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&forward->xy3));
	KUNIT_EXPECT_PTR_EQ(test, forward->xy3.head, uart_head(named));
}

static void named_forward_first_test(struct kunit *test)
{
	struct device_node *node = firmware_forward(test);
	struct forward *other = forward_come(test), *forward = forward_make(test, node);
	struct uart *named, *plain;

	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&forward->xy3));
	KUNIT_EXPECT_EQ(test, forward->xy3.head->number, 1);
	named = uart_come(test, &(struct firmware_text){ .forward = node });
	KUNIT_EXPECT_PTR_EQ(test, uart_head(named), forward->xy3.head);
	plain = uart_come(test, NULL);
	KUNIT_EXPECT_PTR_EQ(test, uart_head(plain), other->xy3.head);
}

/* A head that lacks a forward channel is not the one given in firmware */
static void named_elsewhere_test(struct kunit *test)
{
	struct device_node *node = firmware_forward(test), *else_node = firmware_forward(test);
	struct forward *forward = forward_make(test, node);
	struct uart *named;

	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&forward->xy3));
	named = uart_come(test, &(struct firmware_text){ .forward = else_node });
	KUNIT_EXPECT_PTR_NE(test, uart_head(named), forward->xy3.head);
	KUNIT_EXPECT_EQ(test, heads(), 2);
}

/* The place is taken by a backchannel that is not in firmware */
static void named_taken_test(struct kunit *test)
{
	struct device_node *node = firmware_forward(test);
	struct forward *forward = forward_make(test, node);
	struct uart *plain, *named = uart_make(test);

	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&forward->xy3));
	plain = uart_come(test, NULL);
	KUNIT_EXPECT_PTR_EQ(test, uart_head(plain), forward->xy3.head);
	uart_plug(test, named, &(struct firmware_text){ .forward = node });
	KUNIT_EXPECT_FALSE(test, uart_bound(named));
	KUNIT_EXPECT_EQ(test, named->opened, 0);
	KUNIT_EXPECT_EQ(test, heads(), 1);

	/* and becomes free */
	uart_unplug(plain);
	KUNIT_ASSERT_EQ(test, 1, device_attach(named->dev));
	KUNIT_EXPECT_PTR_EQ(test, uart_head(named), forward->xy3.head);
}

/* Two backchannels, one forward channel: the second one is refused */
static void named_twice_test(struct kunit *test)
{
	struct device_node *node = firmware_forward(test);
	const struct firmware_text text = { .forward = node };
	struct forward *forward = forward_make(test, node);
	struct uart *first, *second = uart_make(test);

	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&forward->xy3));
	first = uart_come(test, &text);
	uart_plug(test, second, &text);
	KUNIT_EXPECT_FALSE(test, uart_bound(second));
	KUNIT_EXPECT_PTR_EQ(test, uart_head(first), forward->xy3.head);
}

/* ---- joining as the user chooses ---- */

static struct class_attribute *attach_attribute(struct kunit *test)
{
	struct attribute *attr = find_attribute(xy3_class->class_groups, "attach");

	KUNIT_ASSERT_NOT_NULL(test, attr);
	return container_of(attr, struct class_attribute, attr);
}

static int choose(struct kunit *test, const char *text)
{
	struct class_attribute *attr = attach_attribute(test);
	ssize_t taken = attr->store(xy3_class, attr, text, strlen(text));

	return taken < 0 ? taken : taken != strlen(text) ? -EIO : 0;
}

static void expect_choice(struct kunit *test, const char *text)
{
	struct class_attribute *attr = attach_attribute(test);

	KUNIT_EXPECT_GT(test, attr->show(xy3_class, attr, rig_page), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, text);
}

static void choice_test(struct kunit *test)
{
	struct uart *uarts[2] = { uart_come(test, NULL), uart_come(test, NULL) };
	struct forward *forward, *fail = forward_make(test, NULL);

	expect_choice(test, "auto\n");
	KUNIT_ASSERT_EQ(test, choose(test, "xy3-1\n"), 0);
	expect_choice(test, "xy3-1\n");
	forward = forward_come(test);
	KUNIT_EXPECT_PTR_EQ(test, forward->xy3.head, uart_head(uarts[1]));

	/* only once, also if it fails */
	expect_choice(test, "auto\n");
	KUNIT_ASSERT_EQ(test, choose(test, "xy3-1"), 0);
	KUNIT_EXPECT_EQ(test, xy3_forward_attach(&fail->xy3), -EBUSY);
	expect_choice(test, "auto\n");
	KUNIT_ASSERT_EQ(test, choose(test, "xy3-7"), 0);
	KUNIT_EXPECT_EQ(test, xy3_forward_attach(&fail->xy3), -ENODEV);
	expect_choice(test, "auto\n");
	KUNIT_EXPECT_EQ(test, heads(), 2);

	KUNIT_ASSERT_EQ(test, choose(test, "new"), 0);
	expect_choice(test, "new\n");
	forward = forward_come(test);
	KUNIT_EXPECT_EQ(test, forward->xy3.head->number, 2);
	expect_choice(test, "auto\n");
	forward = forward_come(test);
	KUNIT_EXPECT_PTR_EQ(test, forward->xy3.head, uart_head(uarts[0]));
}

static void choice_back_test(struct kunit *test)
{
	struct forward *forwards[2] = { forward_come(test), forward_come(test) };
	struct uart *uart, *fail = uart_make(test);

	KUNIT_ASSERT_EQ(test, choose(test, "xy3-1"), 0);
	uart = uart_come(test, NULL);
	KUNIT_EXPECT_PTR_EQ(test, uart_head(uart), forwards[1]->xy3.head);

	/* refused: the UART is released, and nothing is left */
	KUNIT_ASSERT_EQ(test, choose(test, "xy3-1"), 0);
	uart_plug(test, fail, &(struct firmware_text){ });
	KUNIT_EXPECT_FALSE(test, uart_bound(fail));
	KUNIT_EXPECT_EQ(test, fail->opened, 0);
	KUNIT_EXPECT_EQ(test, heads(), 2);
	KUNIT_ASSERT_EQ(test, 1, device_attach(fail->dev));
	KUNIT_EXPECT_PTR_EQ(test, uart_head(fail), forwards[0]->xy3.head);
}

static void choice_text_test(struct kunit *test)
{
	static const char * const bad[] = {
		"", "\n", "old", "newer", "xy3", "xy3-", "xy3-x", "xy3-32", "xy3--1", "xy3-1 ",
		"xy3-0x1g", "0", "auto new", "xy3-4294967296",
	};

	KUNIT_ASSERT_EQ(test, choose(test, "xy3-31"), 0);
	for (unsigned int i = 0; i < ARRAY_SIZE(bad); i++)
		KUNIT_EXPECT_EQ_MSG(test, choose(test, bad[i]), -EINVAL, "\"%s\"", bad[i]);
	expect_choice(test, "xy3-31\n");
	KUNIT_EXPECT_EQ(test, choose(test, "auto\n"), 0);
	expect_choice(test, "auto\n");
}

/*
 * The user has given the place reserved by firmware to another forward channel. The reserved one is
 * refused then, like a backchannel; commands of the head still go to the first one.
 */
static void named_forward_taken_test(struct kunit *test)
{
	struct device_node *node = firmware_forward(test);
	struct uart *named = uart_come(test, &(struct firmware_text){ .forward = node });
	struct xy3_head *head = uart_head(named);
	struct forward *first = forward_make(test, NULL), *promised = forward_make(test, node);

	KUNIT_ASSERT_EQ(test, choose(test, "xy3-0"), 0);
	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&first->xy3));
	KUNIT_ASSERT_PTR_EQ(test, first->xy3.head, head);
	KUNIT_EXPECT_EQ(test, xy3_forward_attach(&promised->xy3), -EBUSY);
	KUNIT_EXPECT_PTR_EQ(test, head->forward, &first->xy3);

	/* the head exists until the last of its transports is removed */
	uart_unplug(named);
	forward_leave(promised);
	KUNIT_EXPECT_EQ(test, heads(), 1);
	forward_leave(first);
	KUNIT_EXPECT_EQ(test, heads(), 0);
}

/* The @nth allocation of this task fails; 0: none */
static void fail_allocation(unsigned int nth)
{
#ifdef CONFIG_FAULT_INJECTION
	current->fail_nth = nth;
#endif
}

/* Requires FAILSLAB, with ignore-gfp-wait off */
static bool allocations_fail(void)
{
	void *memory;

	fail_allocation(1);
	memory = kmalloc(1, GFP_KERNEL);
	fail_allocation(0);
	kfree(memory);
	return !memory;
}

/* udev rules write to the attributes of a head as soon as it exists */
static int write_and_fail(struct device *dev)
{
	store(to_xy3_head(dev), "autobaud", "1");
	fail_allocation(1);
	return 0;
}

/* Out of memory for the tty of a new head; work started by a write to it ends with it */
static void no_tty_test(struct kunit *test)
{
	struct class_interface writer = { .class = xy3_class, .add_dev = write_and_fail };
	struct forward *forward;
	int err;

	if (!allocations_fail())
		kunit_skip(test, "the kernel does not make allocations fail");
	forward = forward_make(test, NULL);
	KUNIT_ASSERT_EQ(test, class_interface_register(&writer), 0);
	err = xy3_forward_attach(&forward->xy3);
	class_interface_unregister(&writer);
	fail_allocation(0);
	KUNIT_ASSERT_EQ(test, err, -ENOMEM);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	msleep(2000);

	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&forward->xy3));
	KUNIT_EXPECT_NOT_NULL(test, head_of_number(0));
}

/* ---- the serdev ---- */

static void probe_test(struct kunit *test)
{
	struct uart *uart = uart_make(test);

	uart_plug(test, uart, &(struct firmware_text){ });
	KUNIT_ASSERT_TRUE(test, uart_bound(uart));
	KUNIT_EXPECT_STREQ(test, uart->dev->driver->name, "xy3-backchannel");
	EXPECT_CALLS(test, { UART, 115200 });
	KUNIT_EXPECT_EQ(test, uart->opened, 1);
	KUNIT_EXPECT_FALSE(test, uart->flow_control);
	KUNIT_EXPECT_EQ(test, uart->parity, SERDEV_PARITY_NONE);
	EXPECT_SHOWS(test, uart_head(uart), "rate", "115200");
	EXPECT_SHOWS(test, uart_head(uart), "byte_order", "little");

	device_release_driver(uart->dev);
	KUNIT_EXPECT_EQ(test, uart->opened, 0);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	expect_no_call(test);
}

struct speed_row {
	u32 speed;
	bool good;
};

static const struct speed_row speed_rows[] = {
	{ 57600, true }, { 115200, true }, { 230400, true }, { 460800, true }, { 921600, true },
	{ 0 }, { 9600 }, { 57601 }, { 115199 }, { 1000000 }, { 1843200 }, { 0xffffffff },
};

static void speed_row_name(const struct speed_row *row, char *name)
{
	snprintf(name, KUNIT_PARAM_DESC_SIZE, "%u", row->speed);
}

KUNIT_ARRAY_PARAM(speed, speed_rows, speed_row_name);

static void speed_test(struct kunit *test)
{
	const struct speed_row *row = test->param_value;
	struct uart *uart = uart_make(test);

	uart_plug(test, uart, &(struct firmware_text){ .has_speed = true, .speed = row->speed });
	KUNIT_EXPECT_EQ(test, uart_bound(uart), row->good);
	KUNIT_EXPECT_EQ(test, uart->opened, row->good);
	KUNIT_EXPECT_EQ(test, heads(), row->good);
	if (row->good)
		expect_calls(test, &(struct call){ UART, row->speed }, 1);
	else
		expect_no_call(test);
}

static void open_error_test(struct kunit *test)
{
	struct uart *uart = uart_make(test);

	uart->open_error = -EIO;
	uart_plug(test, uart, &(struct firmware_text){ });
	KUNIT_EXPECT_FALSE(test, uart_bound(uart));
	KUNIT_EXPECT_EQ(test, heads(), 0);
	uart->open_error = 0;
	KUNIT_EXPECT_EQ(test, 1, device_attach(uart->dev));
	KUNIT_EXPECT_EQ(test, heads(), 1);
}

static bool can_all_but_115200(unsigned int rate)
{
	return rate != 115200;
}

/* The UART does not support the rate of firmware: it does not listen at another rate */
static void probe_refused_test(struct kunit *test)
{
	struct uart *uart = uart_make(test);

	uart->can = can_all_but_115200;
	uart_plug(test, uart, &(struct firmware_text){ });
	KUNIT_EXPECT_FALSE(test, uart_bound(uart));
	KUNIT_EXPECT_EQ(test, uart->opened, 0);
	KUNIT_EXPECT_EQ(test, heads(), 0);
}

/* A UART that cannot disable the parity bit would receive no valid byte */
static void parity_refused_test(struct kunit *test)
{
	struct uart *uart = uart_make(test);

	uart->parity_error = -EINVAL;
	uart_plug(test, uart, &(struct firmware_text){ });
	KUNIT_EXPECT_FALSE(test, uart_bound(uart));
	KUNIT_EXPECT_EQ(test, uart->opened, 0);
	KUNIT_EXPECT_EQ(test, heads(), 0);
}

/* Data received while there is no head yet */
static void early_data_test(struct kunit *test)
{
	struct uart *uart = uart_make(test);
	struct xy3_head *head;

	uart->babble = true;
	uart_plug(test, uart, &(struct firmware_text){ });
	KUNIT_ASSERT_TRUE(test, uart_bound(uart));
	uart->babble = false;
	head = uart_head(uart);
	EXPECT_SHOWS(test, head, "stats/rx_bytes", "0");
	EXPECT_SHOWS(test, head, "in_sync", "0");
	SEND(test, uart, SYNC, SYNC);
	EXPECT_SHOWS(test, head, "stats/rx_bytes", "6");
	EXPECT_SHOWS(test, head, "in_sync", "1");
}

struct flow {
	struct kunit *test;
	struct uart *uart;
	struct completion begun;
};

static int flow_thread(void *data)
{
	static const u8 stream[] = { SYNC, SYNC, TEXT_PACKET(4, 3), '1', '2', '3', 0x99, SYNC };
	struct flow *flow = data;

	while (!kthread_should_stop()) {
		uart_send(flow->test, flow->uart, stream, sizeof(stream));
		complete(&flow->begun);
		usleep_range(50, 100);
	}
	return 0;
}

/* The head continues to send while its driver is unbound and bound repeatedly */
static void remove_in_flow_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct flow flow = { .test = test, .uart = uart };
	struct task_struct *thread;

	init_completion(&flow.begun);
	thread = kthread_run(flow_thread, &flow, "xy3-rig-flow");
	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, thread);
	for (unsigned int i = 0; i < 20; i++) {
		wait_for_completion(&flow.begun);
		msleep(i * 10);		/* up to beyond 100 ms between notifications */
		device_release_driver(uart->dev);
		KUNIT_EXPECT_EQ(test, uart->opened, 0);
		KUNIT_EXPECT_EQ(test, heads(), 0);
		KUNIT_EXPECT_EQ(test, 1, device_attach(uart->dev));
		KUNIT_EXPECT_EQ(test, heads(), 1);
	}
	msleep(20);
	kthread_stop(thread);
	EXPECT_SHOWS(test, uart_head(uart), "serial", "123");
}

static struct kunit_case xy3_driver_cases[] = {
	KUNIT_CASE_PARAM(join_test, join_gen_params),
	KUNIT_CASE(come_back_test),
	KUNIT_CASE(numbers_test),
	KUNIT_CASE(lowest_test),
	KUNIT_CASE(full_test),
	KUNIT_CASE(two_heads_test),
	KUNIT_CASE(named_back_first_test),
	KUNIT_CASE(named_forward_first_test),
	KUNIT_CASE(named_elsewhere_test),
	KUNIT_CASE(named_taken_test),
	KUNIT_CASE(named_twice_test),
	KUNIT_CASE(choice_test),
	KUNIT_CASE(choice_back_test),
	KUNIT_CASE(choice_text_test),
	KUNIT_CASE(named_forward_taken_test),
	KUNIT_CASE_SLOW(no_tty_test),
	KUNIT_CASE(probe_test),
	KUNIT_CASE_PARAM(speed_test, speed_gen_params),
	KUNIT_CASE(open_error_test),
	KUNIT_CASE(probe_refused_test),
	KUNIT_CASE(parity_refused_test),
	KUNIT_CASE(early_data_test),
	KUNIT_CASE(remove_in_flow_test),
	{}
};

static int xy3_driver_suite_init(struct kunit_suite *suite)
{
	return rig_suite_init();
}

static void xy3_driver_suite_exit(struct kunit_suite *suite)
{
	rig_suite_exit();
}

/* Check that the case before has removed all that it had added */
static int xy3_driver_init(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, heads(), 0);
	clear_call_log();
	return 0;
}

static struct kunit_suite xy3_driver_suite = {
	.name = "xy3_driver",
	.suite_init = xy3_driver_suite_init,
	.suite_exit = xy3_driver_suite_exit,
	.init = xy3_driver_init,
	.test_cases = xy3_driver_cases,
};

kunit_test_suite(xy3_driver_suite);

MODULE_DESCRIPTION("KUnit tests of the scanhead's driver: heads and their transports");
MODULE_LICENSE("GPL");
