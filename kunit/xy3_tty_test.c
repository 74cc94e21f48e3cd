// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of scanheads - speed, writes and modes of the tty of a head
 */

#include <linux/completion.h>
#include <linux/delay.h>
#include <linux/fs.h>
#include <linux/kthread.h>
#include <linux/module.h>
#include <linux/sizes.h>

#include "xy3_rig_tty.h"

/* ---- the tty of the head: speed ---- */

/* The speed after all requests have been processed */
static unsigned int set_head_speed(struct tty_struct *tty, struct xy3_head *head,
				   unsigned int rate)
{
	set_speed(tty, rate);
	flush_work(&head->rate_request);
	flush_work(head->show_rate);
	return tty_get_baud_rate(tty);
}

static bool can_up_to_460800(unsigned int rate)
{
	return rate <= 460800;
}

static void speed_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);
	struct tty_struct *tty = reader_come(test, head, READER_MAX);

	forward_come(test);
	sync_source_start(test, line_send_syncs, line, 460800);
	line->can = can_up_to_460800;
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(tty), 115200);
	KUNIT_EXPECT_EQ(test, set_head_speed(tty, head, 460800), 460800);
	EXPECT_CALLS(test, { FRAME, 0x240002 }, { UART, 460800 });
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(line->tty), 460800);
	EXPECT_SHOWS(test, head, "rate", "460800");

	/* not a rate of a head */
	KUNIT_EXPECT_EQ(test, set_head_speed(tty, head, 9600), 460800);
	expect_no_call(test);
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(line->tty), 460800);

	/* a rate that the UART refuses */
	KUNIT_EXPECT_EQ(test, set_head_speed(tty, head, 921600), 460800);
	EXPECT_CALLS(test, { FRAME, 0x340003 }, { NO_UART, 921600 }, { FRAME, 0x240002 });
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(line->tty), 460800);
	EXPECT_SHOWS(test, head, "rate", "460800");

	/* one that differs too much from the actual rate of the UART */
	line->instead = 500000;
	KUNIT_EXPECT_EQ(test, set_head_speed(tty, head, 921600), 460800);
	EXPECT_CALLS(test, { FRAME, 0x340003 }, { NO_UART, 921600 }, { UART, 460800 },
		     { FRAME, 0x240002 });
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(line->tty), 460800);
	EXPECT_SHOWS(test, head, "rate", "460800");
}

/* tcsetattr() does not wait for a head that ignores the command; readers would wait, too */
static void speed_deaf_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);
	struct tty_struct *tty = reader_come(test, head, READER_MAX);
	s64 begin = ktime_to_ms(ktime_get());

	forward_come(test);
	KUNIT_EXPECT_EQ(test, set_speed(tty, 460800), 460800);
	KUNIT_EXPECT_FALSE(test, rwsem_is_locked(&tty->termios_rwsem));
	KUNIT_EXPECT_LT(test, ktime_to_ms(ktime_get()) - begin, 1000);
	flush_work(&head->rate_request);
	flush_work(head->show_rate);
	KUNIT_EXPECT_GE(test, ktime_to_ms(ktime_get()) - begin, 3000);
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(tty), 115200);
	EXPECT_CALLS(test, { FRAME, 0x240002 }, { UART, 460800 }, { FRAME, 0x380003 },
		     { UART, 115200 });

	/* a head that is removed during a request */
	set_speed(tty, 230400);
	KUNIT_EXPECT_TRUE(test, wait_calls(2));
	line_close(line);
	clear_call_log();
}

static void speed_shown_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);
	struct tty_struct *tty = reader_come(test, head, READER_MAX);

	forward_come(test);
	sync_source_start(test, line_send_syncs, line, 921600);
	/* by the attribute */
	KUNIT_EXPECT_EQ(test, store(head, "rate", "921600"), 0);
	EXPECT_CALLS(test, { FRAME, 0x340003 }, { UART, 921600 });
	msleep(100);
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(tty), 921600);

	/* from below, without a command to the head */
	KUNIT_EXPECT_EQ(test, set_speed(line->tty, 57600), 57600);
	EXPECT_CALLS(test, { UART, 57600 });
	EXPECT_SHOWS(test, head, "rate", "57600");
	msleep(100);
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(tty), 57600);
	expect_no_call(test);
}

/* ---- the tty of the head: write ---- */

struct write_row {
	const char *name;
	u8 size;
	u8 data[12];
	u8 frames;	/* 0: -EINVAL, and nothing is sent */
	struct call sent[3];
};

static const struct write_row write_rows[] = {
	{ "24 bits, bad parity", 3, { 0x08, 0x00, 0x07 }, 0 },
	{ "24 bits", 3, { 0x08, 0x00, 0x06 }, 1, { { FRAME, 0x080006 } } },
	{ "32 bits", 4, { 0x80, 0x20, 0x00, 0x12 }, 1, { { FRAME, 0x80200012 } } },
	{ "two", 6, { 0x08, 0x00, 0x06, 0x30, 0x00, 0x02 }, 2,
	  { { FRAME, 0x080006 }, { FRAME, 0x300002 } } },
	{ "24, 32, 24", 10, { 0x08, 0, 0x06, 0x80, 0x20, 0, 0x12, 0x30, 0, 0x02 }, 3,
	  { { FRAME, 0x080006 }, { FRAME, 0x80200012 }, { FRAME, 0x300002 } } },
	{ "second has bad parity", 6, { 0x08, 0x00, 0x06, 0x30, 0x00, 0x03 }, 0 },
	{ "last is a position", 6, { 0x08, 0x00, 0x06, 0x40, 0x00, 0x05 }, 0 },
	{ "last is a 32-bit position", 7, { 0x08, 0, 0x06, 0xc0, 0, 0, 0x11 }, 0 },
	{ "last is torn", 5, { 0x08, 0x00, 0x06, 0x30, 0x00 }, 0 },
	{ "last is a torn 32-bit one", 6, { 0x08, 0, 0x06, 0x80, 0x20, 0x00 }, 0 },
	{ "one byte", 1, { 0x08 }, 0 },
	{ "a command without a meaning", 3, { 0x00, 0x00, 0x00 }, 1, { { FRAME, 0 } } },
};

static void write_row_name(const struct write_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(write, write_rows, write_row_name);

static void write_test(struct kunit *test)
{
	const struct write_row *row = test->param_value;
	struct forward *forward = forward_come(test);
	struct tty_struct *tty;
	u8 *data;

	line_come(test);
	tty = reader_come(test, head_of_number(0), READER_MAX);
	data = kunit_kmalloc(test, row->size, GFP_KERNEL);	/* exact size, for KASAN */
	KUNIT_ASSERT_NOT_NULL(test, data);
	memcpy(data, row->data, row->size);

	KUNIT_EXPECT_EQ(test, tty->ops->write(tty, data, row->size),
			row->frames ? row->size : -EINVAL);
	expect_calls(test, row->sent, row->frames);

	forward->error = -ENOSPC;
	if (row->frames)
		KUNIT_EXPECT_EQ(test, tty->ops->write(tty, data, row->size), -ENOSPC);
	forward_leave(forward);
	clear_call_log();
	KUNIT_EXPECT_EQ(test, tty->ops->write(tty, data, row->size),
			row->frames ? -ENODEV : -EINVAL);
	expect_no_call(test);
}

/* A write accepts complete frames up to the free room; poll() reports the same room */
static void write_room_test(struct kunit *test)
{
	static const u8 frames[] = { 0x08, 0, 0x06, 0x80, 0x20, 0, 0x12, 0x30, 0, 0x02 };
	static const u8 bad[] = { 0x08, 0, 0x06, 0x08, 0, 0x07 };
	struct forward *forward = forward_come(test);
	struct tty_struct *tty;

	line_come(test);
	tty = reader_open(test, head_of_number(0));
	forward->limited = true;
	forward->room = 2;
	KUNIT_EXPECT_EQ(test, tty_write_room(tty), 6);
	KUNIT_EXPECT_EQ(test, tty->ops->write(tty, frames, sizeof(frames)), 7);
	EXPECT_CALLS(test, { FRAME, 0x080006 }, { FRAME, 0x80200012 });
	KUNIT_EXPECT_EQ(test, tty_write_room(tty), 0);
	KUNIT_EXPECT_EQ(test, tty->ops->write(tty, frames + 7, 3), 0);
	KUNIT_EXPECT_EQ(test, tty->ops->write(tty, bad, sizeof(bad)), -EINVAL);
	KUNIT_EXPECT_EQ(test, store(head_of_number(0), "calibrate", "x"), -EAGAIN);
	expect_no_call(test);

	/* without a forward channel the error is immediate */
	forward_leave(forward);
	KUNIT_EXPECT_GT(test, tty_write_room(tty), 0);
	KUNIT_EXPECT_EQ(test, tty->ops->write(tty, frames, sizeof(frames)), -ENODEV);
}

/*
 * The tty core passes a long write() in pieces of 64 KiB. The end of one may be within a frame,
 * which the next piece starts with; a shorter write() is refused.
 */
static void long_write_test(struct kunit *test)
{
	static const struct {
		u8 rest[3];
		size_t size;
	} torn[] = {
		{ { 0x08 }, 1 }, { { 0x08, 0 }, 2 }, { { 0x80 }, 1 }, { { 0x80, 0x20 }, 2 },
		{ { 0x80, 0x20, 0 }, 3 },
	};
	static const u8 frame[] = { 0x08, 0, 0x06 }, wide[] = { 0x80, 0x20, 0, 0x12 };
	u8 *data = kunit_kzalloc(test, SZ_64K, GFP_KERNEL);
	struct tty_struct *tty;

	KUNIT_ASSERT_NOT_NULL(test, data);
	forward_come(test);
	line_come(test);
	tty = reader_open(test, head_of_number(0));
	for (unsigned int i = 0; i < ARRAY_SIZE(torn); i++) {
		size_t whole = SZ_64K - torn[i].size, at = 0;

		while ((whole - at) % sizeof(frame)) {
			memcpy(data + at, wide, sizeof(wide));
			at += sizeof(wide);
		}
		for (; at < whole; at += sizeof(frame))
			memcpy(data + at, frame, sizeof(frame));
		memcpy(data + whole, torn[i].rest, torn[i].size);
		KUNIT_EXPECT_EQ(test, tty->ops->write(tty, data, SZ_64K), whole);
		clear_call_log();
		KUNIT_EXPECT_EQ(test, tty->ops->write(tty, data + whole, torn[i].size), -EINVAL);
		at = data[0] == wide[0] ? sizeof(wide) : sizeof(frame);
		KUNIT_EXPECT_EQ(test, tty->ops->write(tty, data + at, SZ_64K - at), -EINVAL);
		data[0] ^= 1;
		KUNIT_EXPECT_EQ(test, tty->ops->write(tty, data, SZ_64K), -EINVAL);
		expect_no_call(test);
	}
}

/* A program that writes three frames */
struct writer {
	struct tty_struct *tty;
	unsigned int flags;
	ssize_t written;
	struct completion done;
};

static ssize_t write_three(struct writer *writer)
{
	static const struct file_operations no_operations = { };
	static const u8 frames[] = { 0x08, 0, 0x06, 0x08, 0, 0x06, 0x30, 0, 0x02 };
	struct file file = { .f_op = &no_operations, .f_flags = writer->flags };
	struct tty_ldisc *ld = tty_ldisc_ref_wait(writer->tty);
	ssize_t written;

	written = ld->ops->write(writer->tty, &file, frames, sizeof(frames));
	tty_ldisc_deref(ld);
	return written;
}

static int writer_thread(void *data)
{
	struct writer *writer = data;

	writer->written = write_three(writer);
	complete(&writer->done);
	return 0;
}

static void writer_start(struct kunit *test, struct writer *writer)
{
	init_completion(&writer->done);
	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, kthread_run(writer_thread, writer, "xy3-rig-writer"));
}

static void blocking_write_test(struct kunit *test)
{
	struct forward *forward = forward_come(test);
	struct writer *writer = kunit_kzalloc(test, sizeof(*writer), GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, writer);
	line_come(test);
	writer->tty = reader_open(test, head_of_number(0));
	forward->limited = true;
	forward->room = 1;
	writer_start(test, writer);
	KUNIT_EXPECT_FALSE(test, wait_for_completion_timeout(&writer->done, HZ));
	EXPECT_CALLS(test, { FRAME, 0x080006 });
	forward->room = 2;
	xy3_forward_has_room(&forward->xy3);
	KUNIT_EXPECT_TRUE(test, wait_for_completion_timeout(&writer->done, 10 * HZ));
	KUNIT_EXPECT_EQ(test, writer->written, 9);
	EXPECT_CALLS(test, { FRAME, 0x080006 }, { FRAME, 0x300002 });

	/* O_NONBLOCK */
	writer->flags = O_NONBLOCK;
	KUNIT_EXPECT_EQ(test, write_three(writer), -EAGAIN);
	forward->room = 2;
	KUNIT_EXPECT_EQ(test, write_three(writer), 6);
	clear_call_log();

	/* the forward channel is removed while a writer waits */
	writer->flags = 0;
	writer_start(test, writer);
	KUNIT_EXPECT_FALSE(test, wait_for_completion_timeout(&writer->done, HZ));
	forward_leave(forward);
	KUNIT_EXPECT_TRUE(test, wait_for_completion_timeout(&writer->done, 10 * HZ));
	KUNIT_EXPECT_EQ(test, writer->written, -ENODEV);
	expect_no_call(test);
}

/* ---- the tty of the head: modes ---- */

/* Modes that would change read or written data cannot be enabled */
static void raw_test(struct kunit *test)
{
	struct tty_struct *tty;
	struct ktermios termios;

	line_come(test);
	tty = reader_open(test, head_of_number(0));
	termios = tty->termios;
	termios.c_iflag = ~0;
	termios.c_oflag = ~0;
	termios.c_lflag = ~0;
	termios.c_cc[VMIN] = 7;
	tty_set_termios(tty, &termios);
	KUNIT_EXPECT_EQ(test, tty->termios.c_iflag, 0);
	KUNIT_EXPECT_EQ(test, tty->termios.c_oflag, 0);
	KUNIT_EXPECT_EQ(test, tty->termios.c_lflag, 0);
	KUNIT_EXPECT_EQ(test, tty->termios.c_cc[VMIN], 7);
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(tty), 115200);
}

static struct kunit_case xy3_tty_cases[] = {
	KUNIT_CASE(speed_test),
	KUNIT_CASE_SLOW(speed_deaf_test),
	KUNIT_CASE(speed_shown_test),
	KUNIT_CASE_PARAM(write_test, write_gen_params),
	KUNIT_CASE(write_room_test),
	KUNIT_CASE(long_write_test),
	KUNIT_CASE(blocking_write_test),
	KUNIT_CASE(raw_test),
	{}
};

static int xy3_tty_suite_init(struct kunit_suite *suite)
{
	return rig_tty_suite_init();
}

static void xy3_tty_suite_exit(struct kunit_suite *suite)
{
	rig_tty_suite_exit();
}

static int xy3_tty_case_init(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, heads(), 0);
	clear_call_log();
	return 0;
}

static struct kunit_suite xy3_tty_suite = {
	.name = "xy3_tty",
	.suite_init = xy3_tty_suite_init,
	.suite_exit = xy3_tty_suite_exit,
	.init = xy3_tty_case_init,
	.test_cases = xy3_tty_cases,
};

kunit_test_suite(xy3_tty_suite);

MODULE_DESCRIPTION("KUnit tests of the scanhead's driver: speed, writes and modes of the tty");
MODULE_LICENSE("GPL");
