// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the scanhead's driver between two ttys - the line discipline on a UART's tty below, the
 * head's own tty above
 *
 * The UART's tty belongs to xy3_rig_tty.h, so that bytes can be marked as damaged.
 */

#include <linux/completion.h>
#include <linux/cred.h>
#include <linux/delay.h>
#include <linux/fs.h>
#include <linux/kthread.h>
#include <linux/module.h>
#include <linux/rwsem.h>

#include "xy3_rig_tty.h"

/* ---- the line discipline ---- */

static void attach_test(struct kunit *test)
{
	struct line *line = line_open(test, 0);
	struct xy3_head *head;

	KUNIT_EXPECT_EQ(test, heads(), 0);
	KUNIT_ASSERT_EQ(test, set_speed(line->tty, 230400), 230400);
	KUNIT_ASSERT_EQ(test, line_attach(line), 0);
	head = head_of_number(0);
	KUNIT_ASSERT_NOT_NULL(test, head);
	EXPECT_SHOWS(test, head, "rate", "230400");
	LINE_SEND(test, line, SYNC, SYNC);
	EXPECT_SHOWS(test, head, "in_sync", "1");

	/* once more is nothing */
	KUNIT_EXPECT_EQ(test, line_attach(line), 0);
	KUNIT_EXPECT_EQ(test, heads(), 1);
	EXPECT_SHOWS(test, head, "in_sync", "1");

	line_detach(line);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	/* what comes now is somebody else's */
	LINE_SEND(test, line, SYNC, SYNC);
	KUNIT_ASSERT_EQ(test, line_attach(line), 0);
	EXPECT_SHOWS(test, head_of_number(0), "stats/rx_bytes", "0");
}

static void attach_two_test(struct kunit *test)
{
	struct line *first = line_come(test), *second = line_open(test, 1);

	KUNIT_ASSERT_EQ(test, line_attach(second), 0);
	KUNIT_EXPECT_EQ(test, heads(), 2);
	LINE_SEND(test, second, SYNC, SYNC);
	EXPECT_SHOWS(test, head_of_number(0), "in_sync", "0");
	EXPECT_SHOWS(test, head_of_number(1), "in_sync", "1");
	line_close(first);
	KUNIT_EXPECT_NULL(test, head_of_number(0));
	KUNIT_EXPECT_NOT_NULL(test, head_of_number(1));
}

static void attach_refused_test(struct kunit *test)
{
	struct class_attribute *attr;
	struct line *line = line_open(test, 0);

	attr = container_of(find_attribute(xy3_class->class_groups, "attach"),
			    struct class_attribute, attr);
	KUNIT_ASSERT_EQ(test, attr->store(xy3_class, attr, "xy3-4", 5), 5);
	KUNIT_EXPECT_EQ(test, line_attach(line), -ENODEV);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	KUNIT_EXPECT_EQ(test, line->tty->ldisc->ops->num, N_TTY);
	LINE_SEND(test, line, SYNC, SYNC);
	KUNIT_EXPECT_EQ(test, line_attach(line), 0);
}

static void attach_unprivileged_test(struct kunit *test)
{
	struct line *line = line_open(test, 0);
	struct cred *cred = prepare_creds();
	const struct cred *own;
	int err;

	KUNIT_ASSERT_NOT_NULL(test, cred);
	cap_lower(cred->cap_effective, CAP_SYS_ADMIN);
	own = override_creds(cred);
	err = line_attach(line);
	revert_creds(own);
	put_cred(cred);
	KUNIT_EXPECT_EQ(test, err, -EPERM);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	KUNIT_EXPECT_EQ(test, line_attach(line), 0);
}

/* A backchannel of a backchannel */
static void attach_own_test(struct kunit *test)
{
	struct tty_struct *tty;

	line_come(test);
	tty = reader_come(test, head_of_number(0), READER_MAX);
	KUNIT_EXPECT_EQ(test, tty_set_ldisc(tty, N_DEVELOPMENT), -EINVAL);
	KUNIT_EXPECT_EQ(test, heads(), 1);
}

static void lower_write_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct tty_ldisc_ops *ops = line->tty->ldisc->ops;

	KUNIT_EXPECT_STREQ(test, ops->name, "xy3");
	KUNIT_EXPECT_EQ(test, ops->write(line->tty, NULL, "x", 1), -EOPNOTSUPP);
}

/* The UART is unplugged */
static void hangup_test(struct kunit *test)
{
	struct line *line = line_come(test);

	LINE_SEND(test, line, SYNC, SYNC, TEXT_PACKET(4, 3), '1', '2', '3');
	tty_vhangup(line->tty);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	line_close(line);
	line = line_come(test);
	EXPECT_SHOWS_ERROR(test, head_of_number(0), "serial", -ENODATA);
}

/* The UART's input modes are put back, unless they were changed meanwhile */
static void modes_put_back_test(struct kunit *test)
{
	struct line *line = line_open(test, 0);
	struct ktermios termios = line->tty->termios;

	termios.c_iflag = IGNBRK | IGNPAR | IXANY;
	tty_set_termios(line->tty, &termios);
	for (unsigned int i = 0; i < 2; i++) {
		KUNIT_ASSERT_EQ(test, line_attach(line), 0);
		KUNIT_EXPECT_EQ(test, line->tty->termios.c_iflag, BRKINT | INPCK | IXANY);
		line_detach(line);
		KUNIT_EXPECT_EQ(test, line->tty->termios.c_iflag, IGNBRK | IGNPAR | IXANY);
	}

	KUNIT_ASSERT_EQ(test, line_attach(line), 0);
	termios.c_iflag = INPCK;
	tty_set_termios(line->tty, &termios);
	line_detach(line);
	KUNIT_EXPECT_EQ(test, line->tty->termios.c_iflag, INPCK);
}

/* ---- line errors ---- */

struct flag_row {
	const char *name;
	u8 flag;
};

static const struct flag_row flag_rows[] = {
	{ "control: no error", TTY_NORMAL },
	{ "break", TTY_BREAK },
	{ "framing", TTY_FRAME },
	{ "parity", TTY_PARITY },
	{ "overrun", TTY_OVERRUN },
};

static void flag_row_name(const struct flag_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(flag, flag_rows, flag_row_name);

/* A damaged byte takes the packet with it, and sync; nothing of it is believed */
static void line_error_test(struct kunit *test)
{
	static const u8 data[] = { SYNC, SYNC, TEXT_PACKET(1, 3), 'a', 'b', 'c', SYNC, SYNC };
	const struct flag_row *row = test->param_value;
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);
	u8 flags[sizeof(data)] = { };

	flags[10] = row->flag;
	line_send(test, line, data, flags, 11);
	KUNIT_EXPECT_GT(test, show(head, "in_sync"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, row->flag ? "0\n" : "1\n");
	line_send(test, line, data + 11, flags + 11, sizeof(data) - 11);

	EXPECT_SHOWS(test, head, "in_sync", "1");
	EXPECT_SHOWS(test, head, "stats/rx_bytes", "18");
	if (row->flag) {
		EXPECT_SHOWS_ERROR(test, head, "vendor", -ENODATA);
		EXPECT_SHOWS(test, head, "stats/line_errors", "1");
		EXPECT_SHOWS(test, head, "stats/dropped_bytes", "6");
		EXPECT_SHOWS(test, head, "stats/resyncs", "1");
	} else {
		EXPECT_SHOWS(test, head, "vendor", "abc");
		EXPECT_SHOWS(test, head, "stats/line_errors", "0");
		EXPECT_SHOWS(test, head, "stats/dropped_bytes", "0");
		EXPECT_SHOWS(test, head, "stats/resyncs", "0");
	}
}

/* A damaged byte is not a part of the sync sequence, even if it looks like one */
static void line_error_sync_test(struct kunit *test)
{
	static const u8 data[] = { SYNC, SYNC };
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);

	for (unsigned int i = 0; i < 4; i++) {
		u8 flags[sizeof(data)] = { };

		flags[i] = TTY_PARITY;
		line_send(test, line, data, flags, 4);
		EXPECT_SHOWS(test, head, "in_sync", "0");
		LINE_SEND(test, line, 0x99);
	}
	EXPECT_SHOWS(test, head, "stats/line_errors", "4");
	EXPECT_SHOWS(test, head, "stats/rx_bytes", "20");
	/* sync was never there, so it was not lost */
	LINE_SEND(test, line, SYNC, SYNC);
	EXPECT_SHOWS(test, head, "in_sync", "1");
	EXPECT_SHOWS(test, head, "stats/resyncs", "0");
}

/* Any errors anywhere: each byte is counted once, and each damaged one */
static void line_error_any_test(struct kunit *test)
{
	static const u8 data[] = {
		SYNC, TEXT_PACKET(1, 3), 'a', 'b', 'c', SYNC, TEXT_PACKET(7, 2), 0, 1, SYNC, 0x99,
		SYNC, TEXT_PACKET(4, 2), 'x', 'y', TEXT_PACKET(0x60, 1), 0x48, SYNC,
	};
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);
	u64 bytes = 0, errors = 0;
	u32 noise = 1;
	char text[24];

	for (unsigned int i = 0; i < 500; i++) {
		u8 flags[sizeof(data)] = { };
		size_t size;

		noise = noise * 1664525 + 1013904223;
		size = 1 + (noise >> 8) % sizeof(data);
		for (unsigned int j = 0; j < size && i % 2; j++) {
			noise = noise * 1664525 + 1013904223;
			flags[j] = noise >> 16 & 0x1c ? 0 : TTY_BREAK + (noise >> 24) % 4;
			errors += !!flags[j];
		}
		bytes += size;
		line_send(test, line, data, flags, size);
	}
	KUNIT_EXPECT_GT(test, errors, 100);
	snprintf(text, sizeof(text), "%llu\n", bytes);
	KUNIT_EXPECT_GT(test, show(head, "stats/rx_bytes"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, text);
	snprintf(text, sizeof(text), "%llu\n", errors);
	KUNIT_EXPECT_GT(test, show(head, "stats/line_errors"), 0);
	KUNIT_EXPECT_STREQ(test, rig_page, text);
}

/* Line errors prove that the rate is wrong: the search for it moves on at once */
static void search_line_errors_test(struct kunit *test)
{
	static const u8 data[] = { 0, 0, 0, 0 };
	static const u8 flags[] = { TTY_FRAME, TTY_FRAME, TTY_BREAK, TTY_PARITY };
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);
	s64 begin;

	forward_come(test);
	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	/* into the round whose turns last for 4 s */
	KUNIT_ASSERT_TRUE(test, wait_calls(15));
	clear_call_log();
	EXPECT_SHOWS(test, head, "rate", "115200");
	begin = ktime_to_ms(ktime_get());
	line_send(test, line, data, flags, sizeof(data));
	KUNIT_ASSERT_TRUE(test, wait_calls(1));
	KUNIT_EXPECT_LT(test, ktime_to_ms(ktime_get()) - begin, 2000);
	EXPECT_CALLS(test, { UART, 230400 });

	/* control: so many bytes without errors do nothing */
	line_send(test, line, data, NULL, sizeof(data));
	msleep(2000);
	expect_no_call(test);
	LINE_SEND(test, line, SYNC, SYNC);
	/* nor do errors of a head that was in sync at this rate, for as long as a turn lasts */
	line_send(test, line, data, flags, sizeof(data));
	msleep(200);
	LINE_SEND(test, line, SYNC, SYNC);
	msleep(20000);
	EXPECT_SHOWS(test, head, "rate", "230400");
}

/* A UART at a rate that no head has: all five come after it, and it does not come again */
static void search_odd_rate_test(struct kunit *test)
{
	struct line *line = line_open(test, 0);

	KUNIT_ASSERT_EQ(test, set_speed(line->tty, 9600), 9600);
	KUNIT_ASSERT_EQ(test, line_attach(line), 0);
	EXPECT_SHOWS(test, head_of_number(0), "rate", "9600");
	clear_call_log();
	KUNIT_ASSERT_EQ(test, store(head_of_number(0), "autobaud", "1"), 0);
	KUNIT_ASSERT_TRUE(test, wait_calls(6));
	EXPECT_CALLS(test, { UART, 57600 }, { UART, 115200 }, { UART, 230400 },
		     { UART, 460800 }, { UART, 921600 }, { UART, 57600 });
}

/* ---- the head's tty: speed ---- */

/* What the speed is when all that was requested has been done */
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

	/* no rate of a head */
	KUNIT_EXPECT_EQ(test, set_head_speed(tty, head, 9600), 460800);
	expect_no_call(test);
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(line->tty), 460800);

	/* a rate that the UART refuses */
	KUNIT_EXPECT_EQ(test, set_head_speed(tty, head, 921600), 460800);
	EXPECT_CALLS(test, { FRAME, 0x340003 }, { NO_UART, 921600 }, { FRAME, 0x240002 });
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(line->tty), 460800);
	EXPECT_SHOWS(test, head, "rate", "460800");

	/* one that is too far off what the UART makes of it */
	line->instead = 500000;
	KUNIT_EXPECT_EQ(test, set_head_speed(tty, head, 921600), 460800);
	EXPECT_CALLS(test, { FRAME, 0x340003 }, { NO_UART, 921600 }, { UART, 460800 },
		     { FRAME, 0x240002 });
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(line->tty), 460800);
	EXPECT_SHOWS(test, head, "rate", "460800");
}

/* tcsetattr() does not wait for a head that does not follow; readers would wait as long */
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

	/* a head that goes with a request under way */
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

	/* from below, where nobody tells the head */
	KUNIT_EXPECT_EQ(test, set_speed(line->tty, 57600), 57600);
	EXPECT_CALLS(test, { UART, 57600 });
	EXPECT_SHOWS(test, head, "rate", "57600");
	msleep(100);
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(tty), 57600);
	expect_no_call(test);
}

/* ---- the head's tty: write ---- */

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
	data = kunit_kmalloc(test, row->size, GFP_KERNEL);	/* not one byte more, for KASAN */
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

/* A write is taken as far as there is room, in whole frames; poll() is told of the same room */
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

	/* without a forward channel there is no reason to wait for the error */
	forward_leave(forward);
	KUNIT_EXPECT_GT(test, tty_write_room(tty), 0);
	KUNIT_EXPECT_EQ(test, tty->ops->write(tty, frames, sizeof(frames)), -ENODEV);
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

	/* the forward channel goes while a writer waits */
	writer->flags = 0;
	writer_start(test, writer);
	KUNIT_EXPECT_FALSE(test, wait_for_completion_timeout(&writer->done, HZ));
	forward_leave(forward);
	KUNIT_EXPECT_TRUE(test, wait_for_completion_timeout(&writer->done, 10 * HZ));
	KUNIT_EXPECT_EQ(test, writer->written, -ENODEV);
	expect_no_call(test);
}

/* ---- the head's tty: read ---- */

static void read_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);

	/* nobody reads: nothing is kept, nothing is lost */
	LINE_SEND(test, line, 0x99, SYNC, SYNC, TEXT_PACKET(1, 3), 'a', 'b', 'c');
	reader_come(test, head, READER_MAX);
	flush_work(&reader.tty->port->buf.work);
	KUNIT_EXPECT_EQ(test, reader.size, 0);

	/* whole packets only, and nothing between them */
	LINE_SEND(test, line, SYNC, TEXT_PACKET(4, 3), '1', '2');
	EXPECT_READ(test, SYNC);
	LINE_SEND(test, line, '3', 0x99, SYNC, 0x48);
	EXPECT_READ(test, TEXT_PACKET(4, 3), '1', '2', '3', SYNC);
	LINE_SEND(test, line, 0x77, 0x02, 0x0a, 0x00);
	EXPECT_READ(test, TEXT_PACKET(0x77, 2), 0x0a, 0x00);
	LINE_SEND(test, line, TEXT_PACKET(1, 2), 'x', 'y', SYNC, SYNC);
	EXPECT_READ(test, SYNC, SYNC);
	EXPECT_SHOWS(test, head, "stats/lost_packets", "0");

	/* what was not read before the close is not there after the next open */
	reader.tty->receive_room = 0;
	LINE_SEND(test, line, SYNC, SYNC);
	reader_leave(NULL);
	LINE_SEND(test, line, SYNC);
	reader_come(test, head, READER_MAX);
	LINE_SEND(test, line, TEXT_PACKET(4, 3), '4', '5', '6');
	EXPECT_READ(test, TEXT_PACKET(4, 3), '4', '5', '6');
}

#define MANY_PACKETS	4000	/* of 258 bytes: more than a tty keeps */

/* A reader that does not read loses whole packets, and the count says how many */
static void lost_test(struct kunit *test)
{
	static const u8 sync[] = { SYNC, SYNC };
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);
	unsigned int lost;
	u8 *packet = kunit_kzalloc(test, XY3_PACKET_MAX, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, packet);
	memcpy(packet, ((u8[]){ TEXT_PACKET(0x60, 255) }), XY3_PACKET_HEADER);
	line_send(test, line, sync, NULL, sizeof(sync));
	for (unsigned int i = 0; i < MANY_PACKETS; i++)
		line_send(test, line, packet, NULL, XY3_PACKET_MAX);
	EXPECT_SHOWS(test, head, "stats/lost_packets", "0");

	reader_come(test, head, 0);
	for (unsigned int i = 0; i < MANY_PACKETS; i++)
		line_send(test, line, packet, NULL, XY3_PACKET_MAX);
	KUNIT_ASSERT_GT(test, show(head, "stats/lost_packets"), 0);
	KUNIT_ASSERT_EQ(test, kstrtouint(rig_page, 10, &lost), 0);
	KUNIT_EXPECT_GT(test, lost, 0);
	KUNIT_EXPECT_LT(test, lost, MANY_PACKETS);
	KUNIT_EXPECT_EQ(test, reader.size, 0);
	EXPECT_SHOWS(test, head, "stats/dropped_bytes", "0");

	/* it reads again: all that was not lost is there, and whole */
	reader.tty->receive_room = 65536;
	tty_flip_buffer_push(reader.tty->port);
	flush_work(&reader.tty->port->buf.work);
	KUNIT_EXPECT_EQ(test, reader.packets, MANY_PACKETS - lost);
	KUNIT_EXPECT_EQ(test, reader.size, (MANY_PACKETS - lost) * (size_t)XY3_PACKET_MAX);
	KUNIT_EXPECT_EQ(test, reader.torn, 0);
	KUNIT_EXPECT_EQ(test, reader.header, 0);
	reader.size = 0;
	line_send(test, line, sync, NULL, sizeof(sync));
	EXPECT_READ(test, SYNC, SYNC);
}

/* The head goes while its tty is open */
static void gone_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct tty_struct *tty = reader_come(test, head_of_number(0), READER_MAX);

	tty->receive_room = 0;
	LINE_SEND(test, line, SYNC, SYNC);
	line_detach(line);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	for (unsigned int i = 0; i < 100 && !test_bit(TTY_HUPPED, &tty->flags); i++)
		msleep(20);
	KUNIT_EXPECT_TRUE(test, test_bit(TTY_HUPPED, &tty->flags));

	/* the next head has the same number, and does not mind; nor does its reader get the rest */
	KUNIT_ASSERT_EQ(test, line_attach(line), 0);
	KUNIT_ASSERT_NOT_NULL(test, head_of_number(0));
	LINE_SEND(test, line, SYNC, SYNC, TEXT_PACKET(4, 3), '1', '2', '3');
	EXPECT_SHOWS(test, head_of_number(0), "serial", "123");
	reader_leave(NULL);
	reader_come(test, head_of_number(0), READER_MAX);
	LINE_SEND(test, line, SYNC);
	EXPECT_READ(test, SYNC);
}

/* ---- a hangup while the tty is in use ---- */

/* In the test kernel's time-travel a sleep ends when nothing else can run */
#define WAIT_FOR(test, condition) do {							\
	bool __met = false;								\
											\
	for (unsigned int __i = 0; __i < 500 && !__met; __i++) {			\
		msleep(20);								\
		__met = (condition);							\
	}										\
	KUNIT_EXPECT_TRUE_MSG(test, __met, "still not: " #condition);			\
} while (0)

#define STREAM_PACKETS	40
#define STREAM_PAYLOAD	200
#define STREAM_SIZE	(2 * XY3_PACKET_HEADER +					\
			 STREAM_PACKETS * (XY3_PACKET_HEADER + STREAM_PAYLOAD))
#define STREAM_READ	64

/* Two sync packets, and more packets than N_TTY keeps; no two stretches of STREAM_READ are alike */
static u8 *make_stream(struct kunit *test)
{
	static const u8 syncs[] = { SYNC, SYNC }, header[] = { TEXT_PACKET(0x60, STREAM_PAYLOAD) };
	u8 *stream = kunit_kzalloc(test, STREAM_SIZE, GFP_KERNEL), *at = stream;

	KUNIT_ASSERT_NOT_NULL(test, stream);
	memcpy(at, syncs, sizeof(syncs));
	at += sizeof(syncs);
	for (unsigned int i = 0; i < STREAM_PACKETS; i++) {
		memcpy(at, header, sizeof(header));
		at += sizeof(header);
		for (unsigned int j = 0; j < STREAM_PAYLOAD; j++)
			*at++ = i + 3 * j;
	}
	return stream;
}

static int detach_thread(void *line)
{
	line_detach(line);
	return 0;
}

/*
 * The head goes while a reader is in read(): what the reader gets next follows what it got before,
 * or it is the end of the file. It is never what was behind bytes that the hangup has dropped.
 *
 * The test's thread is the reader. It holds what tty_read() and n_tty_read() hold: a reference to
 * the line discipline and, as its read is not complete, termios_rwsem. So the first flush of the
 * hangup waits for termios_rwsem. The worker that moves data to the line discipline is started
 * then, and waits as well. This is the order in which the two go on when the read completes.
 *
 * The head is detached by another thread, for which lockdep does not see the reader's locks.
 */
static void hangup_in_read_test(struct kunit *test)
{
	static const struct file_operations no_operations = { };
	struct file file = { .f_op = &no_operations, .f_flags = O_NONBLOCK };
	struct line *line = line_come(test);
	u8 *stream = make_stream(test), data[STREAM_READ];
	struct task_struct *detach;
	struct tty_struct *tty;
	struct tty_ldisc *ld;
	void *cookie = NULL;
	ssize_t got;

	tty = reader_open(test, head_of_number(0));
	line_send(test, line, stream, NULL, STREAM_SIZE);
	flush_work(&tty->port->buf.work);
	detach = kthread_create(detach_thread, line, "xy3-rig-detach");
	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, detach);
	get_task_struct(detach);

	ld = tty_ldisc_ref_wait(tty);
	KUNIT_EXPECT_EQ(test, ld->ops->read(tty, &file, data, STREAM_READ, &cookie, 0),
			STREAM_READ);
	KUNIT_EXPECT_MEMEQ(test, data, stream, STREAM_READ);
	KUNIT_EXPECT_NOT_NULL(test, cookie);

	wake_up_process(detach);
	WAIT_FOR(test, rwsem_is_contended(&tty->termios_rwsem));
	KUNIT_EXPECT_EQ(test, heads(), 0);
	tty_flip_buffer_push(tty->port);
	WAIT_FOR(test, mutex_is_locked(&tty->port->buf.lock));
	if (cookie)
		ld->ops->read(tty, &file, data, 0, &cookie, 0);
	KUNIT_EXPECT_NULL(test, cookie);
	WAIT_FOR(test, test_bit(TTY_HUPPING, &tty->flags) &&
		 !mutex_is_locked(&tty->port->buf.lock));

	got = ld->ops->read(tty, &file, data, STREAM_READ, &cookie, 0);
	if (got > 0)
		KUNIT_EXPECT_MEMEQ_MSG(test, data, stream + STREAM_READ, got,
				       "%zd bytes from behind dropped ones", got);
	else
		KUNIT_EXPECT_EQ(test, got, 0);
	if (cookie)
		ld->ops->read(tty, &file, data, 0, &cookie, 0);
	tty_ldisc_deref(ld);
	WAIT_FOR(test, test_bit(TTY_HUPPED, &tty->flags));
	KUNIT_EXPECT_EQ(test, kthread_stop_put(detach), 0);
}

/*
 * The head goes while an open() of its tty, which an earlier head has left hung up, is under way.
 * There is nothing to hang up then, and the next head with this number does not wait for it.
 */
static void hangup_in_open_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct tty_struct *tty = reader_open(test, head_of_number(0));
	s64 begin;

	line_detach(line);
	WAIT_FOR(test, test_bit(TTY_HUPPED, &tty->flags));

	KUNIT_ASSERT_EQ(test, line_attach(line), 0);
	tty_lock(tty);
	KUNIT_EXPECT_EQ(test, tty->ops->open(tty, NULL), 0);
	tty_unlock(tty);
	line_detach(line);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	tty_lock(tty);
	tty->ops->close(tty, NULL);
	tty_unlock(tty);

	for (unsigned int i = 0; i < 2; i++) {
		begin = ktime_to_ms(ktime_get());
		KUNIT_ASSERT_EQ(test, line_attach(line), 0);
		KUNIT_EXPECT_LT(test, ktime_to_ms(ktime_get()) - begin, 1000);
		line_detach(line);
	}
}

/* Read from N_TTY like a program that does not wait */
static ssize_t reader_read(struct tty_struct *tty, u8 *data, size_t size)
{
	static const struct file_operations no_operations = { };
	struct file file = { .f_op = &no_operations, .f_flags = O_NONBLOCK };
	struct tty_ldisc *ld = tty_ldisc_ref_wait(tty);
	void *cookie = NULL;
	ssize_t got, more;

	flush_work(&tty->port->buf.work);
	got = ld->ops->read(tty, &file, data, size, &cookie, 0);
	while (cookie) {
		more = ld->ops->read(tty, &file, data + got, size - got, &cookie, 0);
		if (more > 0)
			got += more;
	}
	tty_ldisc_deref(ld);
	return got;
}

/* All that comes, until there is no more */
static size_t reader_read_all(struct tty_struct *tty, u8 *data, size_t size)
{
	size_t got = 0;
	ssize_t more;

	for (;;) {
		more = reader_read(tty, data + got, size - got);
		if (more <= 0)
			return got;
		got += more;
	}
}

/* A reader that is behind by more than N_TTY keeps gets all of it when it reads on */
static void behind_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct tty_struct *tty = reader_open(test, head_of_number(0));
	u8 *stream = make_stream(test), *data = kunit_kzalloc(test, STREAM_SIZE, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, data);
	line_send(test, line, stream, NULL, STREAM_SIZE);
	KUNIT_EXPECT_EQ(test, reader_read_all(tty, data, STREAM_SIZE), STREAM_SIZE);
	KUNIT_EXPECT_MEMEQ(test, data, stream, STREAM_SIZE);
}

/*
 * tcsetattr(TCSAFLUSH) when more waits than N_TTY keeps: it drops what N_TTY has, and that is whole
 * packets. The rest comes by itself.
 */
static void flush_of_a_full_buffer_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct tty_struct *tty = reader_open(test, head_of_number(0));
	u8 *stream = make_stream(test), *data = kunit_kzalloc(test, STREAM_SIZE, GFP_KERNEL);
	struct ktermios termios;
	struct tty_ldisc *ld;
	size_t got;

	KUNIT_ASSERT_NOT_NULL(test, data);
	line_send(test, line, stream, NULL, STREAM_SIZE);
	flush_work(&tty->port->buf.work);
	ld = tty_ldisc_ref_wait(tty);
	ld->ops->flush_buffer(tty);
	tty_ldisc_deref(ld);
	termios = tty->termios;
	tty_set_termios(tty, &termios);

	got = reader_read_all(tty, data, STREAM_SIZE);
	KUNIT_EXPECT_GT(test, got, STREAM_SIZE / 2 - STREAM_SIZE / 10);
	KUNIT_EXPECT_LT(test, got, STREAM_SIZE);
	KUNIT_EXPECT_EQ(test, got % (XY3_PACKET_HEADER + STREAM_PAYLOAD), 0);
	KUNIT_EXPECT_MEMEQ(test, data, stream + STREAM_SIZE - got, got);
}

static int vhangup_thread(void *tty)
{
	tty_vhangup(tty);
	return 0;
}

/*
 * TIOCVHANGUP, or the exit of a session leader, while a reader is in read(), as in
 * hangup_in_read_test. The kernel's own flush is all there is: what comes behind it is dropped.
 */
static void user_hangup_in_read_test(struct kunit *test)
{
	static const struct file_operations no_operations = { };
	struct file file = { .f_op = &no_operations, .f_flags = O_NONBLOCK };
	struct line *line = line_come(test);
	u8 *stream = make_stream(test), data[STREAM_READ];
	struct task_struct *hangup;
	struct tty_struct *tty;
	struct tty_ldisc *ld;
	void *cookie = NULL;
	ssize_t got;

	tty = reader_open(test, head_of_number(0));
	line_send(test, line, stream, NULL, STREAM_SIZE);
	flush_work(&tty->port->buf.work);
	hangup = kthread_create(vhangup_thread, tty, "xy3-rig-hangup");
	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, hangup);
	get_task_struct(hangup);

	ld = tty_ldisc_ref_wait(tty);
	KUNIT_EXPECT_EQ(test, ld->ops->read(tty, &file, data, STREAM_READ, &cookie, 0),
			STREAM_READ);
	KUNIT_EXPECT_MEMEQ(test, data, stream, STREAM_READ);
	KUNIT_EXPECT_NOT_NULL(test, cookie);

	wake_up_process(hangup);
	WAIT_FOR(test, rwsem_is_contended(&tty->termios_rwsem));
	tty_flip_buffer_push(tty->port);
	WAIT_FOR(test, mutex_is_locked(&tty->port->buf.lock));
	if (cookie)
		ld->ops->read(tty, &file, data, 0, &cookie, 0);
	KUNIT_EXPECT_NULL(test, cookie);
	WAIT_FOR(test, test_bit(TTY_HUPPING, &tty->flags) &&
		 !mutex_is_locked(&tty->port->buf.lock));

	got = ld->ops->read(tty, &file, data, STREAM_READ, &cookie, 0);
	KUNIT_EXPECT_LE_MSG(test, got, 0, "%zd bytes from behind dropped ones", got);
	if (cookie)
		ld->ops->read(tty, &file, data, 0, &cookie, 0);
	tty_ldisc_deref(ld);
	WAIT_FOR(test, test_bit(TTY_HUPPED, &tty->flags));
	KUNIT_EXPECT_EQ(test, kthread_stop_put(hangup), 0);
}

/* What a reader does by TIOCEXCL ends with the head, even if it keeps its file */
static void exclusive_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct tty_struct *tty = reader_open(test, head_of_number(0));

	set_bit(TTY_EXCLUSIVE, &tty->flags);
	line_detach(line);
	WAIT_FOR(test, test_bit(TTY_HUPPED, &tty->flags));
	KUNIT_EXPECT_FALSE(test, test_bit(TTY_EXCLUSIVE, &tty->flags));
}

/*
 * A head goes while its tty is being opened, and the next one comes before that open() has failed.
 * Another open() finds a port that is in use, and must get packets nevertheless.
 */
static void deaf_test(struct kunit *test)
{
	static const u8 syncs[] = { SYNC, SYNC };
	struct line *line = line_come(test);
	struct tty_struct *tty = reader_open(test, head_of_number(0));
	u8 data[READER_MAX];

	tty_lock(tty);
	tty->ops->close(tty, NULL);
	tty_unlock(tty);
	line_detach(line);
	msleep(100);		/* in time-travel, until the hangup has found nothing to hang up */
	tty_lock(tty);
	KUNIT_EXPECT_EQ(test, tty->ops->open(tty, NULL), -ENODEV);
	tty_unlock(tty);

	KUNIT_ASSERT_EQ(test, line_attach(line), 0);
	tty_lock(tty);
	tty->count++;
	KUNIT_EXPECT_EQ(test, tty->ops->open(tty, NULL), 0);
	tty->ops->close(tty, NULL);	/* of the open() that failed */
	tty->count--;
	tty_unlock(tty);
	line_send(test, line, syncs, NULL, sizeof(syncs));
	KUNIT_EXPECT_EQ(test, reader_read(tty, data, sizeof(data)), sizeof(syncs));
}

/* For lockdep a tty's termios_rwsem is that of any tty: another thread has to hold it */
static int stuck_reader_thread(void *data)
{
	struct tty_struct *tty = data;

	down_read(&tty->termios_rwsem);
	while (!kthread_should_stop())
		msleep(20);
	up_read(&tty->termios_rwsem);
	return 0;
}

/*
 * A reader that stays in read(), in a page fault that takes its time, keeps the tty of a head that
 * has gone from being hung up. The next head gets another number, and nothing waits for long.
 */
static void stuck_reader_test(struct kunit *test)
{
	struct line *line = line_come(test), *second = line_open(test, 1);
	struct tty_struct *tty = reader_open(test, head_of_number(0));
	struct task_struct *stuck;
	s64 begin;

	stuck = kthread_run(stuck_reader_thread, tty, "xy3-rig-reader");
	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, stuck);
	WAIT_FOR(test, rwsem_is_locked(&tty->termios_rwsem));
	/* the rate is to be shown, for which the reader is in the way as well */
	KUNIT_EXPECT_EQ(test, store(head_of_number(0), "rate", "57600"), 0);
	begin = ktime_to_ms(ktime_get());
	line_detach(line);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	KUNIT_EXPECT_LT(test, ktime_to_ms(ktime_get()) - begin, 1000);

	begin = ktime_to_ms(ktime_get());
	KUNIT_EXPECT_EQ(test, line_attach(second), 0);
	KUNIT_EXPECT_LT(test, ktime_to_ms(ktime_get()) - begin, 2000);
	KUNIT_EXPECT_NULL(test, head_of_number(0));
	KUNIT_EXPECT_NOT_NULL(test, head_of_number(1));
	KUNIT_EXPECT_EQ(test, kthread_stop(stuck), 0);
	WAIT_FOR(test, test_bit(TTY_HUPPED, &tty->flags));
	KUNIT_EXPECT_EQ(test, line_attach(line), 0);
	KUNIT_EXPECT_NOT_NULL(test, head_of_number(0));
}

/* Nothing that would change what is read or written can be switched on */
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
	KUNIT_CASE(attach_test),
	KUNIT_CASE(attach_two_test),
	KUNIT_CASE(attach_refused_test),
	KUNIT_CASE(attach_unprivileged_test),
	KUNIT_CASE(attach_own_test),
	KUNIT_CASE(lower_write_test),
	KUNIT_CASE(hangup_test),
	KUNIT_CASE(modes_put_back_test),
	KUNIT_CASE_PARAM(line_error_test, flag_gen_params),
	KUNIT_CASE(line_error_sync_test),
	KUNIT_CASE(line_error_any_test),
	KUNIT_CASE_SLOW(search_line_errors_test),
	KUNIT_CASE_SLOW(search_odd_rate_test),
	KUNIT_CASE(speed_test),
	KUNIT_CASE_SLOW(speed_deaf_test),
	KUNIT_CASE(speed_shown_test),
	KUNIT_CASE_PARAM(write_test, write_gen_params),
	KUNIT_CASE(write_room_test),
	KUNIT_CASE(blocking_write_test),
	KUNIT_CASE(read_test),
	KUNIT_CASE(lost_test),
	KUNIT_CASE(gone_test),
	KUNIT_CASE(hangup_in_read_test),
	KUNIT_CASE(hangup_in_open_test),
	KUNIT_CASE(behind_test),
	KUNIT_CASE(flush_of_a_full_buffer_test),
	KUNIT_CASE(user_hangup_in_read_test),
	KUNIT_CASE(exclusive_test),
	KUNIT_CASE(deaf_test),
	KUNIT_CASE(stuck_reader_test),
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

MODULE_DESCRIPTION("KUnit tests of the scanhead's driver: line discipline and tty");
MODULE_LICENSE("GPL");
