// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of scanheads - data for a reader of the tty of a head, also over hangups
 */

#include <linux/delay.h>
#include <linux/fs.h>
#include <linux/kthread.h>
#include <linux/module.h>
#include <linux/rwsem.h>

#include "xy3_rig_tty.h"

/* ---- the tty of the head: read ---- */

static void read_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct xy3_head *head = head_of_number(0);

	/* without a reader nothing is stored, and nothing is lost */
	LINE_SEND(test, line, 0x99, SYNC, SYNC, TEXT_PACKET(1, 3), 'a', 'b', 'c');
	reader_come(test, head, READER_MAX);
	flush_work(&reader.tty->port->buf.work);
	KUNIT_EXPECT_EQ(test, reader.size, 0);

	/* complete packets only, and nothing between them */
	LINE_SEND(test, line, SYNC, TEXT_PACKET(4, 3), '1', '2');
	EXPECT_READ(test, SYNC);
	LINE_SEND(test, line, '3', 0x99, SYNC, 0x48);
	EXPECT_READ(test, TEXT_PACKET(4, 3), '1', '2', '3', SYNC);
	LINE_SEND(test, line, 0x77, 0x02, 0x0a, 0x00);
	EXPECT_READ(test, TEXT_PACKET(0x77, 2), 0x0a, 0x00);
	LINE_SEND(test, line, TEXT_PACKET(1, 2), 'x', 'y', SYNC, SYNC);
	EXPECT_READ(test, SYNC, SYNC);
	EXPECT_SHOWS(test, head, "stats/lost_packets", "0");

	/* unread data are dropped on close */
	reader.tty->receive_room = 0;
	LINE_SEND(test, line, SYNC, SYNC);
	reader_leave(NULL);
	LINE_SEND(test, line, SYNC);
	reader_come(test, head, READER_MAX);
	LINE_SEND(test, line, TEXT_PACKET(4, 3), '4', '5', '6');
	EXPECT_READ(test, TEXT_PACKET(4, 3), '4', '5', '6');
}

#define MANY_PACKETS	4000	/* of 258 bytes: more than a tty stores */

/* A reader that does not read loses complete packets, which are counted */
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

	/* it reads again: all packets that were not lost are complete */
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

/* The head is removed while its tty is open */
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

	/* the next head has the same number, and works; its reader does not get the rest */
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

/* In time-travel mode of the test kernel a sleep ends when nothing else can run */
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

/* Two sync packets, and more packets than N_TTY stores; all parts of STREAM_READ bytes differ */
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

/**
 * read_over_hangup() - a hangup while a reader is in read()
 * @test: the test
 * @tty: the tty of the head, which has received the first packets of @stream
 * @stream: of make_stream()
 * @hang_up: hangs up
 * @arg: of @hang_up
 * @data: the data of the next read()
 *
 * The thread of the test is the reader. It holds the same locks as tty_read() and n_tty_read(): a
 * reference to the line discipline and, as its read is not complete, termios_rwsem. So the first
 * flush of the hangup waits for termios_rwsem. The worker that moves data to the line discipline is
 * started then, and waits as well. The two continue in this order when the read completes.
 *
 * Another thread hangs up, for which lockdep does not see the locks of the reader.
 *
 * Return: the result of read() after the flush.
 */
static ssize_t read_over_hangup(struct kunit *test, struct tty_struct *tty, const u8 *stream,
				int (*hang_up)(void *arg), void *arg, u8 data[STREAM_READ])
{
	static const struct file_operations no_operations = { };
	struct file file = { .f_op = &no_operations, .f_flags = O_NONBLOCK };
	struct task_struct *thread = kthread_create(hang_up, arg, "xy3-rig-hangup");
	struct tty_ldisc *ld;
	void *cookie = NULL;
	ssize_t got;

	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, thread);
	get_task_struct(thread);

	ld = tty_ldisc_ref_wait(tty);
	KUNIT_EXPECT_EQ(test, ld->ops->read(tty, &file, data, STREAM_READ, &cookie, 0),
			STREAM_READ);
	KUNIT_EXPECT_MEMEQ(test, data, stream, STREAM_READ);
	KUNIT_EXPECT_NOT_NULL(test, cookie);

	wake_up_process(thread);
	WAIT_FOR(test, rwsem_is_contended(&tty->termios_rwsem));
	tty_flip_buffer_push(tty->port);
	WAIT_FOR(test, mutex_is_locked(&tty->port->buf.lock));
	if (cookie)
		ld->ops->read(tty, &file, data, 0, &cookie, 0);
	KUNIT_EXPECT_NULL(test, cookie);
	WAIT_FOR(test, test_bit(TTY_HUPPING, &tty->flags) &&
		 !mutex_is_locked(&tty->port->buf.lock));

	got = ld->ops->read(tty, &file, data, STREAM_READ, &cookie, 0);
	if (cookie)
		ld->ops->read(tty, &file, data, 0, &cookie, 0);
	tty_ldisc_deref(ld);
	WAIT_FOR(test, test_bit(TTY_HUPPED, &tty->flags));
	KUNIT_EXPECT_EQ(test, kthread_stop_put(thread), 0);
	return got;
}

/*
 * The head is removed while a reader is in read(): the next data of the reader follow the previous
 * ones, or it gets the end of the file. It never gets data after bytes dropped by the hangup.
 */
static void hangup_in_read_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct tty_struct *tty = reader_open(test, head_of_number(0));
	u8 *stream = make_stream(test), data[STREAM_READ];
	ssize_t got;

	line_send(test, line, stream, NULL, STREAM_SIZE);
	flush_work(&tty->port->buf.work);
	got = read_over_hangup(test, tty, stream, detach_thread, line, data);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	KUNIT_EXPECT_GE(test, got, 0);
	if (got > 0)
		KUNIT_EXPECT_MEMEQ_MSG(test, data, stream + STREAM_READ, got,
				       "%zd bytes from behind dropped ones", got);
}

/*
 * The head is removed during an open() of its tty, which is still hung up from an earlier head.
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

/* Read from N_TTY like a nonblocking program */
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

/* Read until there are no more data */
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

/* A reader that is behind by more than N_TTY stores gets all data when it continues to read */
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
 * tcsetattr(TCSAFLUSH) with more pending data than N_TTY stores: it drops the data in N_TTY, which
 * are complete packets. The rest is received after it.
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
 * TIOCVHANGUP, or the exit of a session leader. Only the kernel flushes: data after it are dropped.
 */
static void user_hangup_in_read_test(struct kunit *test)
{
	struct line *line = line_come(test);
	struct tty_struct *tty = reader_open(test, head_of_number(0));
	u8 *stream = make_stream(test), data[STREAM_READ];
	ssize_t got;

	line_send(test, line, stream, NULL, STREAM_SIZE);
	flush_work(&tty->port->buf.work);
	got = read_over_hangup(test, tty, stream, vhangup_thread, tty, data);
	KUNIT_EXPECT_LE_MSG(test, got, 0, "%zd bytes from behind dropped ones", got);
}

/* TIOCEXCL of a reader ends with the head, even if its file remains open */
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
 * A head is removed while its tty is being opened, and the next one is added before that open() has
 * failed. Another open() finds a port in use, and must get packets nevertheless.
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

/* For lockdep termios_rwsem is the same for all ttys: another thread must hold it */
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
 * A reader that stays in read(), in a long page fault, prevents the hangup of the tty of a removed
 * head. The next head gets another number, and nothing waits for long.
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
	/* showing the rate must not wait for the reader either */
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

static struct kunit_case xy3_tty_read_cases[] = {
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
	{}
};

static int xy3_tty_read_suite_init(struct kunit_suite *suite)
{
	return rig_tty_suite_init();
}

static void xy3_tty_read_suite_exit(struct kunit_suite *suite)
{
	rig_tty_suite_exit();
}

static int xy3_tty_read_case_init(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, heads(), 0);
	clear_call_log();
	return 0;
}

static struct kunit_suite xy3_tty_read_suite = {
	.name = "xy3_tty_read",
	.suite_init = xy3_tty_read_suite_init,
	.suite_exit = xy3_tty_read_suite_exit,
	.init = xy3_tty_read_case_init,
	.test_cases = xy3_tty_read_cases,
};

kunit_test_suite(xy3_tty_read_suite);

MODULE_DESCRIPTION("KUnit tests of the scanhead's driver: reading from the tty");
MODULE_LICENSE("GPL");
