/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Ttys for the KUnit suite of the driver of scanheads
 *
 *   struct line      a tty of a mock UART driver, for the line discipline: data are received with
 *                    any mark of a line error
 *   struct reader    a mock line discipline on the open tty of a head
 */
#ifndef XY3_RIG_TTY_H
#define XY3_RIG_TTY_H

#include <linux/tty_driver.h>
#include <linux/tty_flip.h>
#include <linux/tty_ldisc.h>

#include "xy3_rig.h"

#define N_READER	N_MASC		/* a number that is unused in this kernel */
#define READER_MAX	256

/* ---- the UART ---- */

/**
 * struct line - the tty of a UART
 * @port: its port
 * @tty: the tty while it is open, or NULL
 * @can: supported rates; NULL for all
 * @instead: the rate used instead of an unsupported one; 0 to keep the old one
 */
struct line {
	struct tty_port port;
	struct tty_struct *tty;
	bool (*can)(unsigned int rate);
	unsigned int instead;
};

static struct tty_driver *line_driver;
static struct line line_0, line_1;
static struct line * const lines[] = { &line_0, &line_1 };

static int line_op_open(struct tty_struct *tty, struct file *file)
{
	return tty_port_open(tty->port, tty, file);
}

static void line_op_close(struct tty_struct *tty, struct file *file)
{
	tty_port_close(tty->port, tty, file);
}

static void line_op_hangup(struct tty_struct *tty)
{
	tty_port_hangup(tty->port);
}

static ssize_t line_op_write(struct tty_struct *tty, const u8 *data, size_t size)
{
	return size;
}

static unsigned int line_op_write_room(struct tty_struct *tty)
{
	return 4096;
}

static void line_op_set_termios(struct tty_struct *tty, const struct ktermios *old)
{
	struct line *line = container_of(tty->port, struct line, port);
	unsigned int was = tty_termios_baud_rate(old), rate = tty_get_baud_rate(tty);

	if (line->can && !line->can(rate)) {
		log_call(NO_UART, rate);
		rate = line->instead ?: was;
		tty_encode_baud_rate(tty, rate, rate);
	} else if (rate != was) {
		log_call(UART, rate);
	}
}

static const struct tty_operations line_ops = {
	.open = line_op_open,
	.close = line_op_close,
	.hangup = line_op_hangup,
	.write = line_op_write,
	.write_room = line_op_write_room,
	.set_termios = line_op_set_termios,
};

static const struct tty_port_operations line_port_ops;

static struct tty_struct *rig_open(struct kunit *test, dev_t number)
{
	struct tty_struct *tty = tty_kopen_exclusive(number);
	int err;

	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, tty);
	err = tty->ops->open(tty, NULL);
	tty_unlock(tty);
	if (err)
		tty_kclose(tty);
	KUNIT_ASSERT_EQ(test, 0, err);
	return tty;
}

static void rig_close(struct tty_struct *tty)
{
	tty_lock(tty);
	if (!test_bit(TTY_HUPPED, &tty->flags))
		tty->ops->close(tty, NULL);
	tty_unlock(tty);
	tty_kclose(tty);
}

static void line_close(void *data)
{
	struct line *line = data;
	struct tty_struct *tty = line->tty;

	line->tty = NULL;
	if (tty)
		rig_close(tty);
}

static struct line *line_open(struct kunit *test, unsigned int number)
{
	struct line *line = lines[number];

	line->can = NULL;
	line->instead = 0;
	line->tty = rig_open(test, MKDEV(line_driver->major, line_driver->minor_start + number));
	KUNIT_ASSERT_EQ(test, 0, kunit_add_action_or_reset(test, line_close, line));
	return line;
}

/* For a sync source, which must be the only sender in the meantime */
static inline void line_send_syncs(void *data, unsigned int rate)
{
	static const u8 syncs[] = { SYNC, SYNC };
	struct line *line = data;

	if (tty_get_baud_rate(line->tty) != rate)
		return;
	tty_insert_flip_string(&line->port, syncs, sizeof(syncs));
	tty_flip_buffer_push(&line->port);
}

static int line_attach(struct line *line)
{
	return tty_set_ldisc(line->tty, N_DEVELOPMENT);
}

static inline void line_detach(struct line *line)
{
	tty_set_ldisc(line->tty, N_TTY);
}

/* A UART that is attached to a new head */
static struct line *line_come(struct kunit *test)
{
	struct line *line = line_open(test, 0);

	KUNIT_ASSERT_EQ(test, 0, line_attach(line));
	KUNIT_ASSERT_NOT_NULL(test, head_of_number(0));
	return line;
}

static void line_push(struct line *line)
{
	tty_flip_buffer_push(&line->port);
	flush_work(&line->port.buf.work);
}

/* @flags may be NULL; the driver has received the data when this returns */
static inline void line_send(struct kunit *test, struct line *line, const u8 *data,
			     const u8 *flags, size_t size)
{
	size_t taken;

	if (flags)
		taken = tty_insert_flip_string_flags(&line->port, data, flags, size);
	else
		taken = tty_insert_flip_string(&line->port, data, size);
	KUNIT_EXPECT_EQ(test, taken, size);
	line_push(line);
}

#define LINE_SEND(test, line, ...) do {							\
	static const u8 __data[] = { __VA_ARGS__ };					\
											\
	line_send(test, line, __data, NULL, sizeof(__data));				\
} while (0)

/* Returns the resulting speed */
static inline unsigned int set_speed(struct tty_struct *tty, unsigned int rate)
{
	struct ktermios termios = tty->termios;

	tty_termios_encode_baud_rate(&termios, rate, rate);
	tty_set_termios(tty, &termios);
	return tty_get_baud_rate(tty);
}

/* ---- the reader of the tty of a head ---- */

/**
 * struct reader - the reader of the tty of a head
 * @tty: the tty, or NULL
 * @room: bytes that it accepts at once; 0 for none
 * @size: number of bytes received
 * @data: the first of them
 * @packets: complete packets among them
 * @left: missing bytes of the current packet
 * @header: received bytes of its header
 * @torn: bytes received where a packet must start that are not its start
 */
struct reader {
	struct tty_struct *tty;
	unsigned int room;
	size_t size;
	u8 data[READER_MAX];
	unsigned int packets;
	unsigned int left;
	unsigned int header;
	unsigned int torn;
};

static struct reader reader;

static void reader_byte(u8 byte)
{
	if (reader.size < READER_MAX)
		reader.data[reader.size] = byte;
	reader.size++;
	if (reader.left) {
		reader.left--;
	} else if (reader.header == 0 && byte != XY3_PACKET_START) {
		reader.torn++;
		return;
	} else if (++reader.header == XY3_PACKET_HEADER) {
		reader.left = byte;
	}
	if (reader.header == XY3_PACKET_HEADER && !reader.left) {
		reader.packets++;
		reader.header = 0;
	}
}

static int reader_op_open(struct tty_struct *tty)
{
	tty->receive_room = reader.room;
	return 0;
}

static void reader_op_receive(struct tty_struct *tty, const u8 *data, const u8 *flags,
			      size_t size)
{
	while (size--)
		reader_byte(*data++);
}

static struct tty_ldisc_ops reader_ops = {
	.owner = THIS_MODULE,
	.num = N_READER,
	.name = "xy3-rig",
	.open = reader_op_open,
	.receive_buf = reader_op_receive,
};

static void reader_leave(void *data)
{
	struct tty_struct *tty = reader.tty;

	reader.tty = NULL;
	if (tty)
		rig_close(tty);
}

/* Open the tty of a head; its line discipline is N_TTY */
static struct tty_struct *reader_open(struct kunit *test, struct xy3_head *head)
{
	struct device *dev = device_find_child_by_name(&head->dev, dev_name(&head->dev));
	dev_t number;

	KUNIT_ASSERT_NOT_NULL(test, dev);
	number = dev->devt;
	put_device(dev);
	reader = (struct reader){ };
	reader.tty = rig_open(test, number);
	KUNIT_ASSERT_EQ(test, 0, kunit_add_action_or_reset(test, reader_leave, NULL));
	return reader.tty;
}

/* Open the tty of a head with a line discipline that accepts @room bytes at once */
static struct tty_struct *reader_come(struct kunit *test, struct xy3_head *head, unsigned int room)
{
	struct tty_struct *tty = reader_open(test, head);

	reader.room = room;
	KUNIT_ASSERT_EQ(test, 0, tty_set_ldisc(tty, N_READER));
	return tty;
}

static inline void expect_read(struct kunit *test, const u8 *want, size_t size)
{
	flush_work(&reader.tty->port->buf.work);
	KUNIT_EXPECT_EQ(test, reader.size, size);
	KUNIT_EXPECT_MEMEQ(test, reader.data, want, min(size, reader.size));
	reader.size = 0;
}

#define EXPECT_READ(test, ...) do {							\
	static const u8 __want[] = { __VA_ARGS__ };					\
											\
	expect_read(test, __want, sizeof(__want));					\
} while (0)

/* ---- the suite ---- */

static int line_register(void)
{
	int err;

	line_driver = tty_alloc_driver(ARRAY_SIZE(lines),
				       TTY_DRIVER_REAL_RAW | TTY_DRIVER_RESET_TERMIOS);
	if (IS_ERR(line_driver))
		return PTR_ERR(line_driver);
	line_driver->driver_name = "xy3-rig";
	line_driver->name = "xy3-rig-uart";
	line_driver->type = TTY_DRIVER_TYPE_SERIAL;
	line_driver->init_termios = tty_std_termios;
	line_driver->init_termios.c_cflag = B115200 | CS8 | CREAD | CLOCAL;
	line_driver->init_termios.c_ispeed = 115200;
	line_driver->init_termios.c_ospeed = 115200;
	line_driver->init_termios.c_lflag = 0;
	tty_set_operations(line_driver, &line_ops);
	for (unsigned int i = 0; i < ARRAY_SIZE(lines); i++) {
		tty_port_init(&lines[i]->port);
		lines[i]->port.ops = &line_port_ops;
		tty_port_link_device(&lines[i]->port, line_driver, i);
	}
	err = tty_register_driver(line_driver);
	if (err)
		tty_driver_kref_put(line_driver);
	return err;
}

static void line_unregister(void)
{
	tty_unregister_driver(line_driver);
	tty_driver_kref_put(line_driver);
	for (unsigned int i = 0; i < ARRAY_SIZE(lines); i++)
		tty_port_destroy(&lines[i]->port);
}

static int rig_tty_suite_init(void)
{
	int err;

	err = rig_suite_init();
	if (err)
		return err;
	err = line_register();
	if (err)
		goto no_lines;
	err = tty_register_ldisc(&reader_ops);
	if (err)
		goto no_ldisc;
	return 0;

no_ldisc:
	line_unregister();
no_lines:
	rig_suite_exit();
	return err;
}

static void rig_tty_suite_exit(void)
{
	tty_unregister_ldisc(&reader_ops);
	line_unregister();
	rig_suite_exit();
}

#endif /* XY3_RIG_TTY_H */
