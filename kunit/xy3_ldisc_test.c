// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of scanheads - the line discipline on the tty of a UART
 *
 * The tty of the UART is from xy3_rig_tty.h, so that bytes can be marked as damaged.
 */

#include <linux/cred.h>
#include <linux/delay.h>
#include <linux/module.h>

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

	/* once more has no effect */
	KUNIT_EXPECT_EQ(test, line_attach(line), 0);
	KUNIT_EXPECT_EQ(test, heads(), 1);
	EXPECT_SHOWS(test, head, "in_sync", "1");

	line_detach(line);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	/* data from now on are for another line discipline */
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
	const struct tty_ldisc_ops *ops = line->tty->ldisc->ops;

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

/* The input modes of the UART are restored, unless they were changed in the meantime */
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

/* The UART keeps the rate of the head, which keeps it, too: it can be attached again */
static void speed_stays_test(struct kunit *test)
{
	struct line *line = line_come(test);

	KUNIT_EXPECT_EQ(test, store(head_of_number(0), "rate", "57600"), 0);
	line_detach(line);
	KUNIT_EXPECT_EQ(test, tty_get_baud_rate(line->tty), 57600);
	KUNIT_ASSERT_EQ(test, line_attach(line), 0);
	EXPECT_SHOWS(test, head_of_number(0), "rate", "57600");
	EXPECT_CALLS(test, { UART, 57600 });
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

/* A damaged byte loses the packet, and sync; nothing of the packet is used */
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
	/* it was never in sync, so sync was not lost */
	LINE_SEND(test, line, SYNC, SYNC);
	EXPECT_SHOWS(test, head, "in_sync", "1");
	EXPECT_SHOWS(test, head, "stats/resyncs", "0");
}

/* Any errors at any position: each byte is counted once, and so is each damaged one */
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

/* Line errors prove that the rate is wrong: the search tries the next one immediately */
static void search_line_errors_test(struct kunit *test)
{
	static const u8 data[] = { 0, 0, 0, 0 };
	static const u8 flags[] = { TTY_FRAME, TTY_FRAME, TTY_BREAK, TTY_PARITY };
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);
	s64 begin;

	forward_come(test);
	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	/* until the round with turns of 4 s */
	KUNIT_ASSERT_TRUE(test, wait_calls(15));
	clear_call_log();
	EXPECT_SHOWS(test, head, "rate", "115200");
	msleep(SETTLED_MS);
	begin = ktime_to_ms(ktime_get());
	line_send(test, line, data, flags, sizeof(data));
	KUNIT_ASSERT_TRUE(test, wait_calls(1));
	KUNIT_EXPECT_LT(test, ktime_to_ms(ktime_get()) - begin, 2000);
	EXPECT_CALLS(test, { UART, 230400 });

	/* control: the same number of bytes without errors has no effect */
	line_send(test, line, data, NULL, sizeof(data));
	msleep(2000);
	expect_no_call(test);
	LINE_SEND(test, line, SYNC, SYNC);
	/* nor do errors of a head that was in sync at this rate, for the time of a turn */
	line_send(test, line, data, flags, sizeof(data));
	msleep(200);
	LINE_SEND(test, line, SYNC, SYNC);
	msleep(20000);
	EXPECT_SHOWS(test, head, "rate", "230400");
}

/* A UART at a rate of no head: all five are tried after it, and it is not tried again */
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

static struct kunit_case xy3_ldisc_cases[] = {
	KUNIT_CASE(attach_test),
	KUNIT_CASE(attach_two_test),
	KUNIT_CASE(attach_refused_test),
	KUNIT_CASE(attach_unprivileged_test),
	KUNIT_CASE(attach_own_test),
	KUNIT_CASE(lower_write_test),
	KUNIT_CASE(hangup_test),
	KUNIT_CASE(modes_put_back_test),
	KUNIT_CASE(speed_stays_test),
	KUNIT_CASE_PARAM(line_error_test, flag_gen_params),
	KUNIT_CASE(line_error_sync_test),
	KUNIT_CASE(line_error_any_test),
	KUNIT_CASE_SLOW(search_line_errors_test),
	KUNIT_CASE_SLOW(search_odd_rate_test),
	{}
};

static int xy3_ldisc_suite_init(struct kunit_suite *suite)
{
	return rig_tty_suite_init();
}

static void xy3_ldisc_suite_exit(struct kunit_suite *suite)
{
	rig_tty_suite_exit();
}

static int xy3_ldisc_case_init(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, heads(), 0);
	clear_call_log();
	return 0;
}

static struct kunit_suite xy3_ldisc_suite = {
	.name = "xy3_ldisc",
	.suite_init = xy3_ldisc_suite_init,
	.suite_exit = xy3_ldisc_suite_exit,
	.init = xy3_ldisc_case_init,
	.test_cases = xy3_ldisc_cases,
};

kunit_test_suite(xy3_ldisc_suite);

MODULE_DESCRIPTION("KUnit tests of the scanhead's driver: line discipline");
MODULE_LICENSE("GPL");
