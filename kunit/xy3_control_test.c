// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of scanheads - attributes: rates, commands, values reported by the head
 *
 * With a UART of xy3_rig_serdev.h and a forward channel of xy3_rig.h.
 */

#include <linux/delay.h>
#include <linux/module.h>

#include "xy3_rig_serdev.h"

/* ---- the rate ---- */

struct rate_row {
	u32 rate;
	u32 frame;
};

static const struct rate_row rate_rows[] = {
	{ 57600, 0x280002 },
	{ 230400, 0x040001 },
	{ 460800, 0x240002 },
	{ 921600, 0x340003 },
};

static void rate_row_name(const struct rate_row *row, char *name)
{
	snprintf(name, KUNIT_PARAM_DESC_SIZE, "%u", row->rate);
}

KUNIT_ARRAY_PARAM(rate, rate_rows, rate_row_name);

/* The head gets the command at the old rate, and then the UART is set; in both directions */
static void rate_test(struct kunit *test)
{
	const struct rate_row *row = test->param_value;
	const struct call there[] = { { FRAME, row->frame }, { UART, row->rate } };
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	struct sync_source *source = sync_source_start(test, uart_send_syncs, uart, row->rate);
	char text[16];

	forward_come(test);
	snprintf(text, sizeof(text), "%u\n", row->rate);
	KUNIT_EXPECT_EQ(test, store(head, "rate", text), 0);
	expect_calls(test, there, ARRAY_SIZE(there));
	KUNIT_EXPECT_GT(test, show(head, "rate"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, text);

	/* nothing to do */
	KUNIT_EXPECT_EQ(test, store(head, "rate", text), 0);
	expect_no_call(test);

	WRITE_ONCE(source->rate, 115200);
	KUNIT_EXPECT_EQ(test, store(head, "rate", "115200"), 0);
	EXPECT_CALLS(test, { FRAME, 0x380003 }, { UART, 115200 });
	EXPECT_SHOWS(test, head, "in_sync", "1");
}

/* If the head ignores the command, both ends have the old rate again after three seconds */
static void rate_deaf_head_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	ktime_t start = ktime_get();
	s64 ms;

	sync_source_start(test, uart_send_syncs, uart, 115200);
	forward_come(test);
	KUNIT_EXPECT_EQ(test, store(head, "rate", "230400"), -ETIMEDOUT);
	ms = ktime_ms_delta(ktime_get(), start);
	KUNIT_EXPECT_GE(test, ms, 3000);
	KUNIT_EXPECT_LT(test, ms, 3500);
	EXPECT_CALLS(test, { FRAME, 0x040001 }, { UART, 230400 }, { FRAME, 0x380003 },
		     { UART, 115200 });
	EXPECT_SHOWS(test, head, "rate", "115200");
	msleep(300);
	EXPECT_SHOWS(test, head, "in_sync", "1");
}

/* Sync in transit when the rate of the UART changed is of the old rate, and proves nothing */
static void rate_late_sync_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	forward_come(test);
	uart->babble = true;
	KUNIT_EXPECT_EQ(test, store(head, "rate", "230400"), -ETIMEDOUT);
	EXPECT_SHOWS(test, head, "rate", "115200");
}

struct one_sync {
	struct uart *uart;
	unsigned int calls;
};

/* For a sync source: one sync sequence, 100 ms after the rate of the UART was changed */
static void send_one_sync(void *data, unsigned int rate)
{
	static const u8 sync[] = { SYNC, 0x48 };
	struct one_sync *one = data;

	guard(mutex)(&one->uart->lock);
	if (!one->uart->opened || one->uart->rate != rate || ++one->calls != 2)
		return;
	serdev_controller_receive_buf(one->uart->ctrl, sync, sizeof(sync));
}

/* One sync packet proves nothing: it may be in transit for longer than the driver waits */
static void rate_one_sync_test(struct kunit *test)
{
	struct one_sync *one = kunit_kzalloc(test, sizeof(*one), GFP_KERNEL);
	struct xy3_head *head;

	KUNIT_ASSERT_NOT_NULL(test, one);
	one->uart = uart_come(test, NULL);
	head = uart_head(one->uart);
	forward_come(test);
	sync_source_start(test, send_one_sync, one, 230400);
	KUNIT_EXPECT_EQ(test, store(head, "rate", "230400"), -ETIMEDOUT);
	KUNIT_EXPECT_GT(test, one->calls, 2);
	EXPECT_SHOWS(test, head, "rate", "115200");
}

/* A restarted head gets the command for the current rate again; another head does not */
static void rate_again_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	forward_come(test);
	sync_source_start(test, uart_send_syncs, uart, 115200);
	EXPECT_SHOWS(test, head, "in_sync", "0");
	KUNIT_EXPECT_EQ(test, store(head, "rate", "115200"), 0);
	EXPECT_CALLS(test, { FRAME, 0x380003 }, { UART, 115200 });
	EXPECT_SHOWS(test, head, "in_sync", "1");
	KUNIT_EXPECT_EQ(test, store(head, "rate", "115200"), 0);
	expect_no_call(test);
}

struct parting {
	struct delayed_work work;
	void (*leave)(void *data);
	void *data;
};

static void parting_work(struct work_struct *work)
{
	struct parting *parting = container_of(to_delayed_work(work), struct parting, work);

	parting->leave(parting->data);
}

/* Removing a transport ends a change of the rate in progress */
static void expect_parting(struct kunit *test, struct xy3_head *head, void (*leave)(void *data),
			   void *data)
{
	struct parting *parting = kunit_kzalloc(test, sizeof(*parting), GFP_KERNEL);
	ktime_t start = ktime_get();

	KUNIT_ASSERT_NOT_NULL(test, parting);
	parting->leave = leave;
	parting->data = data;
	INIT_DELAYED_WORK(&parting->work, parting_work);
	schedule_delayed_work(&parting->work, HZ / 2);
	KUNIT_EXPECT_EQ(test, store(head, "rate", "57600"), -ENODEV);
	flush_delayed_work(&parting->work);
	KUNIT_EXPECT_LT(test, ktime_ms_delta(ktime_get(), start), 1000);
}

/* The head does not respond */
static void expect_parting_deaf(struct kunit *test, struct xy3_head *head,
				void (*leave)(void *data), void *data)
{
	expect_parting(test, head, leave, data);
	EXPECT_CALLS(test, { FRAME, 0x280002 }, { UART, 57600 }, { FRAME, 0x380003 },
		     { UART, 115200 });
}

static void rate_uart_leaves_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	forward_come(test);
	expect_parting_deaf(test, head, uart_unplug, uart);
	EXPECT_SHOWS_ERROR(test, head, "rate", -ENODEV);
}

static void rate_forward_leaves_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	struct forward *forward = forward_come(test);

	expect_parting_deaf(test, head, forward_leave, forward);
	EXPECT_SHOWS(test, head, "rate", "115200");
	/* and now there is no wait */
	KUNIT_EXPECT_EQ(test, store(head, "rate", "57600"), 0);
}

/* The command may still be sent, so the one for the old rate follows it */
static void rate_stuck_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	struct forward *forward = forward_come(test);

	forward->stuck = true;
	expect_parting(test, head, uart_unplug, uart);
	EXPECT_CALLS(test, { FRAME, 0x280002 }, { FRAME, 0x380003 });
	uart = uart_come(test, NULL);
	expect_parting(test, head, forward_leave, forward);
	EXPECT_CALLS(test, { FRAME, 0x280002 }, { FRAME, 0x380003 });
	EXPECT_SHOWS(test, head, "rate", "115200");
}

/* The controller fails: the head has its old rate */
static void rate_unsent_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	forward_come(test)->unsent = -ETIMEDOUT;
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), -ETIMEDOUT);
	EXPECT_CALLS(test, { FRAME, 0x340003 }, { FRAME, 0x380003 });
	EXPECT_SHOWS(test, head, "rate", "115200");
}

/* Data at the new rate are another stream */
static void rate_sync_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	SEND(test, uart, SYNC, SYNC, TEXT_PACKET(1, 3), 'a');
	EXPECT_SHOWS(test, head, "in_sync", "1");
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), 0);
	EXPECT_SHOWS(test, head, "in_sync", "0");
	SEND(test, uart, 'b', 'c', SYNC, SYNC);
	EXPECT_SHOWS(test, head, "in_sync", "1");
	EXPECT_SHOWS_ERROR(test, head, "vendor", -ENODATA);
	/* the incomplete packet, and the bytes after it */
	EXPECT_SHOWS(test, head, "stats/dropped_bytes", "6");
	EXPECT_SHOWS(test, head, "stats/resyncs", "1");
}

static void rate_no_forward_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	KUNIT_EXPECT_EQ(test, store(head, "rate", "460800"), 0);
	EXPECT_CALLS(test, { UART, 460800 });
	EXPECT_SHOWS(test, head, "rate", "460800");
}

static void rate_no_back_test(struct kunit *test)
{
	struct xy3_head *head = forward_come(test)->xy3.head;

	EXPECT_SHOWS_ERROR(test, head, "rate", -ENODEV);
	KUNIT_EXPECT_EQ(test, store(head, "rate", "460800"), -ENODEV);
	KUNIT_EXPECT_EQ(test, store(head, "rate", "9600"), -EINVAL);
	expect_no_call(test);
}

static bool can_up_to_460800(unsigned int rate)
{
	return rate <= 460800;
}

static bool can_up_to_57600(unsigned int rate)
{
	return rate <= 57600;
}

/* The UART refuses: the head gets the command for the old rate, which is kept */
static void rate_uart_refuses_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	struct forward *forward = forward_come(test);

	SEND(test, uart, SYNC, SYNC);
	uart->can = can_up_to_460800;
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), -EINVAL);
	EXPECT_CALLS(test, { FRAME, 0x340003 }, { NO_UART, 921600 }, { UART, 115200 },
		     { FRAME, 0x380003 });
	EXPECT_SHOWS(test, head, "rate", "115200");
	KUNIT_EXPECT_EQ(test, uart->rate, 115200);
	EXPECT_SHOWS(test, head, "in_sync", "1");

	forward_leave(forward);
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), -EINVAL);
	EXPECT_CALLS(test, { NO_UART, 921600 }, { UART, 115200 });
}

static void uart_slow_down(void *data)
{
	struct uart *uart = data;

	uart->can = can_up_to_57600;
}

/* The attribute shows the rate of the UART, even if that cannot return to the old rate */
static void rate_no_return_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	struct parting *parting = kunit_kzalloc(test, sizeof(*parting), GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, parting);
	forward_come(test);
	parting->leave = uart_slow_down;
	parting->data = uart;
	INIT_DELAYED_WORK(&parting->work, parting_work);
	schedule_delayed_work(&parting->work, HZ / 2);
	KUNIT_EXPECT_EQ(test, store(head, "rate", "57600"), -ETIMEDOUT);
	flush_delayed_work(&parting->work);
	EXPECT_CALLS(test, { FRAME, 0x280002 }, { UART, 57600 }, { FRAME, 0x380003 },
		     { NO_UART, 115200 }, { UART, 57600 });
	EXPECT_SHOWS(test, head, "rate", "57600");
	/* the head has returned, so it gets the command again */
	KUNIT_EXPECT_EQ(test, store(head, "rate", "57600"), -ETIMEDOUT);
}

static void rate_forward_refuses_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	struct forward *forward = forward_come(test);

	SEND(test, uart, SYNC, SYNC);
	forward->error = -ENOSPC;
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), -ENOSPC);
	EXPECT_CALLS(test, { NO_FRAME, 0x340003 });
	EXPECT_SHOWS(test, head, "rate", "115200");
	EXPECT_SHOWS(test, head, "in_sync", "1");
}

/* The divider of a UART seldom has the exact rate */
static void rate_rounded_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	uart->too_fast = 24;
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), 0);
	EXPECT_SHOWS(test, head, "rate", "921600");
	uart->too_fast = -24;
	KUNIT_EXPECT_EQ(test, store(head, "rate", "57600"), 0);
	EXPECT_SHOWS(test, head, "rate", "57600");
	clear_call_log();

	uart->too_fast = 27;
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), -EINVAL);
	EXPECT_CALLS(test, { UART, 921600 }, { UART, 57600 });
	uart->too_fast = -27;
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), -EINVAL);
	EXPECT_CALLS(test, { UART, 921600 }, { UART, 57600 });
	EXPECT_SHOWS(test, head, "rate", "57600");
}

static void rate_text_test(struct kunit *test)
{
	static const char * const bad[] = {
		"", "\n", "0", "9600", "115201", "57600x", "-57600", "1843200", "4295024896",
		"fast", "57600 230400",
	};
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	forward_come(test);
	for (unsigned int i = 0; i < ARRAY_SIZE(bad); i++)
		KUNIT_EXPECT_LT_MSG(test, store(head, "rate", bad[i]), 0, "\"%s\"", bad[i]);
	expect_no_call(test);
	EXPECT_SHOWS(test, head, "rate", "115200");
}

/* ---- commands ---- */

struct command_row {
	const char *attribute;
	const char *text;
	u32 frame;	/* 0: -EINVAL, and nothing is sent */
};

static const struct command_row command_rows[] = {
	{ "autocalib", "on", 0x200001 },
	{ "autocalib", "on x\n", 0x200006 },
	{ "autocalib", "on y", 0x20000a },
	{ "autocalib", "on xyzuw", 0x20007e },
	{ "autocalib", "on all", 0x200001 },
	{ "autocalib", "off", 0x100001 },
	{ "autocalib", "off z", 0x100012 },
	{ "temp_comp", "on", 0x220002 },
	{ "temp_comp", "on u", 0x220023 },
	{ "temp_comp", "off\n", 0x120002 },
	{ "temp_comp", "off xy", 0x12000c },
	{ "calibrate", "", 0x300002 },
	{ "calibrate", "\n", 0x300002 },
	{ "calibrate", "all\n", 0x300002 },
	{ "calibrate", "w", 0x300043 },
	{ "calibrate", "yx", 0x30000c },
	{ "reference", "", 0x080001 },
	{ "reference", "uzwyx", 0x08007e },
	{ "autocalib", "", 0 },
	{ "autocalib", "x", 0 },
	{ "autocalib", "onx", 0 },
	{ "autocalib", "on q", 0 },
	{ "autocalib", "on x y", 0 },
	{ "autocalib", "1", 0 },
	{ "temp_comp", "offf", 0 },
	{ "temp_comp", "on off", 0 },
	{ "calibrate", "on", 0 },
	{ "calibrate", "xa", 0 },
	{ "calibrate", "x,y", 0 },
	{ "reference", "allx", 0 },
	{ "reference", "0", 0 },
};

static void command_row_name(const struct command_row *row, char *name)
{
	snprintf(name, KUNIT_PARAM_DESC_SIZE, "%s \"%.*s\"", row->attribute,
		 (int)strcspn(row->text, "\n"), row->text);
}

KUNIT_ARRAY_PARAM(command, command_rows, command_row_name);

static void command_test(struct kunit *test)
{
	const struct command_row *row = test->param_value;
	struct forward *forward = forward_come(test);
	struct xy3_head *head = forward->xy3.head;

	KUNIT_EXPECT_EQ(test, store(head, row->attribute, row->text), row->frame ? 0 : -EINVAL);
	if (row->frame)
		expect_calls(test, &(struct call){ FRAME, row->frame }, 1);
	else
		expect_no_call(test);

	/* without a forward channel a valid text is -ENODEV, an invalid one still -EINVAL */
	uart_come(test, NULL);
	forward_leave(forward);
	KUNIT_EXPECT_EQ(test, store(head, row->attribute, row->text),
			row->frame ? -ENODEV : -EINVAL);
	expect_no_call(test);
}

static void command_refused_test(struct kunit *test)
{
	struct forward *forward = forward_come(test);

	forward->error = -EBUSY;
	KUNIT_EXPECT_EQ(test, store(forward->xy3.head, "autocalib", "off"), -EBUSY);
	EXPECT_CALLS(test, { NO_FRAME, 0x100001 });
	KUNIT_EXPECT_EQ(test, store(forward->xy3.head, "reference", "x"), -EBUSY);
	forward->error = 0;
	clear_call_log();
	KUNIT_EXPECT_EQ(test, store(forward->xy3.head, "autocalib", "off"), 0);
	EXPECT_CALLS(test, { FRAME, 0x100001 });
}

/* ---- values reported by the head ---- */

static void identity_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	SEND(test, uart, SYNC, SYNC);
	EXPECT_SHOWS_ERROR(test, head, "vendor", -ENODATA);
	SEND(test, uart, TEXT_PACKET(1, 4), 'A', 'c', 'm', 'e', TEXT_PACKET(2, 3), 'X', '-', '1',
	     TEXT_PACKET(3, 5), '1', '.', '0', 0x07, 0xe4, TEXT_PACKET(4, 3), '0', '0', '7');
	EXPECT_SHOWS(test, head, "vendor", "Acme");
	EXPECT_SHOWS(test, head, "model", "X-1");
	EXPECT_SHOWS(test, head, "firmware", "1.0??");
	EXPECT_SHOWS(test, head, "serial", "007");
	msleep(500);
	SEND(test, uart, TEXT_PACKET(4, 3), '0', '0', '8');
	EXPECT_SHOWS(test, head, "serial", "008");
	EXPECT_SHOWS(test, head, "vendor", "Acme");
}

static void byte_order_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, &(struct firmware_text){ .big_endian = true });
	struct xy3_head *head = uart_head(uart);

	EXPECT_SHOWS(test, head, "byte_order", "big");
	SEND(test, uart, SYNC, SYNC, TEXT_PACKET(9, 8), 0, 0, 1, 0, 0xff, 0xff, 0xff, 0xff);
	SEND(test, uart, TEXT_PACKET(6, 20), 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4,
	     0xff, 0, 0, 0);
	SEND(test, uart, TEXT_PACKET(7, 2), 0, 2);
	EXPECT_SHOWS(test, head, "hours/head", "256");
	EXPECT_SHOWS_ERROR(test, head, "hours/dsp", -ENODATA);
	EXPECT_SHOWS_ERROR(test, head, "hours/dac_x", -ENODATA);
	EXPECT_SHOWS(test, head, "frame_errors/x", "1");
	EXPECT_SHOWS(test, head, "frame_errors/w", "4278190080");

	/* setting the same order keeps all values; the other one clears numbers, but no errors */
	KUNIT_EXPECT_EQ(test, store(head, "byte_order", "big\n"), 0);
	EXPECT_SHOWS(test, head, "hours/head", "256");
	KUNIT_EXPECT_EQ(test, store(head, "byte_order", "middle"), -EINVAL);
	KUNIT_EXPECT_EQ(test, store(head, "byte_order", "little"), 0);
	EXPECT_SHOWS(test, head, "byte_order", "little");
	EXPECT_SHOWS_ERROR(test, head, "hours/head", -ENODATA);
	EXPECT_SHOWS_ERROR(test, head, "frame_errors/x", -ENODATA);
	EXPECT_SHOWS(test, head, "errors/dsp", "data");
	SEND(test, uart, TEXT_PACKET(9, 4), 0, 0, 1, 0);
	EXPECT_SHOWS(test, head, "hours/head", "65536");
}

/* The byte order of a UART is reset when it is removed; one set by a user is kept */
static void byte_order_of_uart_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, &(struct firmware_text){ .big_endian = true });
	struct xy3_head *head = uart_head(uart);

	forward_come(test);
	uart_unplug(uart);
	EXPECT_SHOWS(test, head, "byte_order", "little");

	uart = uart_come(test, NULL);
	KUNIT_ASSERT_PTR_EQ(test, uart_head(uart), head);
	KUNIT_EXPECT_EQ(test, store(head, "byte_order", "big"), 0);
	uart_unplug(uart);
	EXPECT_SHOWS(test, head, "byte_order", "big");
}

static void errors_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	EXPECT_SHOWS_ERROR(test, head, "errors/head", -ENODATA);
	SEND(test, uart, SYNC, SYNC, TEXT_PACKET(7, 9), 0, 1, 2, 3, 4, 5, 6, 7, 100);
	EXPECT_SHOWS(test, head, "errors/head", "none");
	EXPECT_SHOWS(test, head, "errors/dsp", "temperature");
	EXPECT_SHOWS(test, head, "errors/driver_x", "mechanical");
	EXPECT_SHOWS(test, head, "errors/driver_y", "100");
	EXPECT_SHOWS_ERROR(test, head, "errors/driver_z", -ENODATA);
	/* the next one replaces all of it */
	SEND(test, uart, TEXT_PACKET(7, 1), 4);
	EXPECT_SHOWS(test, head, "errors/head", "power");
	EXPECT_SHOWS_ERROR(test, head, "errors/dsp", -ENODATA);
}

static int find_hwmon(struct device *dev, void *found)
{
	if (!dev->class || strcmp(dev->class->name, "hwmon"))
		return 0;
	*(struct device **)found = get_device(dev);
	return 1;
}

static void hwmon_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	struct device *hwmon = NULL;

	/* 25.31 degrees, none, -0.5 degrees */
	SEND(test, uart, SYNC, SYNC, TEXT_PACKET(5, 6), 0xe3, 0x09, 0x01, 0x80, 0xce, 0xff);
	SEND(test, uart, TEXT_PACKET(7, 1), 1);
	msleep(500);
	device_for_each_child(&head->dev, &hwmon, find_hwmon);
	KUNIT_ASSERT_NOT_NULL(test, hwmon);
	KUNIT_EXPECT_GT(test, show_in(hwmon, hwmon->groups, "temp1_input"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, "25310\n");
	KUNIT_EXPECT_GT(test, show_in(hwmon, hwmon->groups, "temp1_fault"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, "1\n");
	KUNIT_EXPECT_EQ(test, show_in(hwmon, hwmon->groups, "temp2_input"), -ENOENT);
	KUNIT_EXPECT_GT(test, show_in(hwmon, hwmon->groups, "temp3_input"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, "-500\n");
	KUNIT_EXPECT_GT(test, show_in(hwmon, hwmon->groups, "temp3_label"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, "dac_x\n");
	SEND(test, uart, TEXT_PACKET(5, 2), 0x10, 0x27);
	KUNIT_EXPECT_EQ(test, show_in(hwmon, hwmon->groups, "temp3_input"), -ENODATA);
	KUNIT_EXPECT_GT(test, show_in(hwmon, hwmon->groups, "temp1_input"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, "100000\n");

	/* a component that is not in the newest packet has no fault */
	SEND(test, uart, TEXT_PACKET(7, 3), 1, 0, 1);
	KUNIT_EXPECT_GT(test, show_in(hwmon, hwmon->groups, "temp3_fault"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, "1\n");
	SEND(test, uart, TEXT_PACKET(7, 2), 2, 0);
	KUNIT_EXPECT_GT(test, show_in(hwmon, hwmon->groups, "temp3_fault"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, "0\n");
	KUNIT_EXPECT_GT(test, show_in(hwmon, hwmon->groups, "temp1_fault"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, "0\n");

	KUNIT_EXPECT_EQ(test, store(head, "byte_order", "big\n"), 0);
	KUNIT_EXPECT_EQ(test, show_in(hwmon, hwmon->groups, "temp1_input"), -ENODATA);
	put_device(hwmon);
}

static void counters_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	/* two bytes of noise, sync, an unknown packet, a bad length, sync, half a packet */
	SEND(test, uart, 0x01, 0x48, SYNC, SYNC);
	SEND(test, uart, TEXT_PACKET(0x30, 2), 0x48, 0x41, TEXT_PACKET(4, 2), 'a', 'b');
	SEND(test, uart, SYNC, SYNC, TEXT_PACKET(1, 3), 'a');
	EXPECT_SHOWS(test, head, "in_sync", "1");
	EXPECT_SHOWS(test, head, "stats/rx_bytes", "28");
	EXPECT_SHOWS(test, head, "stats/rx_packets", "5");
	EXPECT_SHOWS(test, head, "stats/syncs", "4");
	EXPECT_SHOWS(test, head, "stats/resyncs", "1");
	EXPECT_SHOWS(test, head, "stats/dropped_bytes", "7");
	EXPECT_SHOWS(test, head, "stats/bad_lengths", "1");
	EXPECT_SHOWS(test, head, "stats/unknown_packets", "1");
	EXPECT_SHOWS(test, head, "stats/line_errors", "0");
	EXPECT_SHOWS(test, head, "stats/lost_packets", "0");
}

static struct kunit_case xy3_control_cases[] = {
	KUNIT_CASE_PARAM(rate_test, rate_gen_params),
	KUNIT_CASE(rate_deaf_head_test),
	KUNIT_CASE(rate_late_sync_test),
	KUNIT_CASE(rate_one_sync_test),
	KUNIT_CASE(rate_again_test),
	KUNIT_CASE(rate_uart_leaves_test),
	KUNIT_CASE(rate_forward_leaves_test),
	KUNIT_CASE(rate_stuck_test),
	KUNIT_CASE(rate_unsent_test),
	KUNIT_CASE(rate_sync_test),
	KUNIT_CASE(rate_no_forward_test),
	KUNIT_CASE(rate_no_back_test),
	KUNIT_CASE(rate_uart_refuses_test),
	KUNIT_CASE(rate_no_return_test),
	KUNIT_CASE(rate_forward_refuses_test),
	KUNIT_CASE(rate_rounded_test),
	KUNIT_CASE(rate_text_test),
	KUNIT_CASE_PARAM(command_test, command_gen_params),
	KUNIT_CASE(command_refused_test),
	KUNIT_CASE(identity_test),
	KUNIT_CASE(byte_order_test),
	KUNIT_CASE(byte_order_of_uart_test),
	KUNIT_CASE(errors_test),
	KUNIT_CASE(hwmon_test),
	KUNIT_CASE(counters_test),
	{}
};

static int xy3_control_suite_init(struct kunit_suite *suite)
{
	return rig_suite_init();
}

static void xy3_control_suite_exit(struct kunit_suite *suite)
{
	rig_suite_exit();
}

static int xy3_control_init(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, heads(), 0);
	clear_call_log();
	return 0;
}

static struct kunit_suite xy3_control_suite = {
	.name = "xy3_control",
	.suite_init = xy3_control_suite_init,
	.suite_exit = xy3_control_suite_exit,
	.init = xy3_control_init,
	.test_cases = xy3_control_cases,
};

kunit_test_suite(xy3_control_suite);

MODULE_DESCRIPTION("KUnit tests of the scanhead's driver: rates, commands, reports");
MODULE_LICENSE("GPL");
