// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: /dev/xy3-<n> - packets out, command frames in, the rate as the tty's speed
 *
 * Each number has a line, which outlives its head: a program that still holds the hung up tty
 * blocks neither the number nor the tty of the next head.
 */

#include <linux/bitmap.h>
#include <linux/err.h>
#include <linux/lockdep.h>
#include <linux/sizes.h>
#include <linux/slab.h>
#include <linux/tty.h>
#include <linux/tty_driver.h>
#include <linux/tty_flip.h>
#include <linux/wait.h>

#include "xy3.h"

/* Time that a new head waits for the hangup of the tty of an earlier one */
#define XY3_HANGUP_TIMEOUT	HZ

/**
 * struct xy3_line - the tty of a number
 * @port: the tty's port
 * @number: the number
 * @lock: protects @head
 * @head: the head with this number, or NULL
 * @open: the tty is open and receives packets; read without a lock
 * @hangup: hangs up the tty of the last head
 * @show_rate: sets the speed of the tty to the rate in force
 */
struct xy3_line {
	struct tty_port port;
	unsigned int number;
	spinlock_t lock;	/* protects @head */
	struct xy3_head *head;
	bool open;
	struct work_struct hangup;
	struct work_struct show_rate;
};

static struct tty_driver *xy3_tty_driver;
static struct xy3_line *xy3_lines[XY3_HEADS_MAX];

/* Numbers whose last head was removed, and whose tty is still to be hung up */
static DECLARE_BITMAP(xy3_hanging, XY3_HEADS_MAX);
static DECLARE_WAIT_QUEUE_HEAD(xy3_hung);

static struct xy3_line *xy3_port_line(struct tty_port *port)
{
	return container_of(port, struct xy3_line, port);
}

/* The head of a line, to be released by put_device(); NULL if it was removed */
static struct xy3_head *xy3_line_head(struct xy3_line *line)
{
	guard(spinlock_irqsave)(&line->lock);
	if (line->head)
		get_device(&line->head->dev);
	return line->head;
}

/* ---- the port ---- */

static int xy3_port_activate(struct tty_port *port, struct tty_struct *tty)
{
	/* data left by the last reader may start in the middle of a packet */
	tty_ldisc_flush(tty);
	WRITE_ONCE(xy3_port_line(port)->open, true);
	return 0;
}

static void xy3_port_shutdown(struct tty_port *port)
{
	WRITE_ONCE(xy3_port_line(port)->open, false);
}

static void xy3_port_destruct(struct tty_port *port)
{
	kfree(xy3_port_line(port));
}

static const struct tty_port_operations xy3_port_ops = {
	.activate = xy3_port_activate,
	.shutdown = xy3_port_shutdown,
	.destruct = xy3_port_destruct,
};

/* ---- to the line discipline ---- */

/*
 * Number of bytes that the line discipline accepts now. N_TTY updates receive_room at each call of
 * receive_buf(), also for no data.
 */
static size_t xy3_ldisc_room(struct tty_port *port, struct tty_struct *tty)
{
	tty_port_default_client_ops.receive_buf(port, NULL, NULL, 0);
	return READ_ONCE(tty->receive_room);
}

/* Bytes of as many packets from the start of @data as fit into @room; @data are whole packets */
static size_t xy3_packets_that_fit(const u8 *data, size_t count, size_t room)
{
	size_t whole = 0;

	while (whole < count) {
		size_t size = XY3_PACKET_HEADER + data[whole + XY3_PACKET_HEADER - 1];

		if (whole + size > room)
			break;
		whole += size;
	}
	return whole;
}

/*
 * Pass complete packets to the line discipline. N_TTY would accept as many bytes as it has room
 * for. If it is flushed then, by TCSAFLUSH or a hangup, a reader would get the rest of a partial
 * packet as if it were the start of one.
 */
static size_t xy3_receive_buf(struct tty_port *port, const u8 *data, const u8 *flags,
			      size_t count)
{
	struct tty_struct *tty = READ_ONCE(port->itty);
	size_t whole;

	if (!tty)
		return 0;
	whole = xy3_packets_that_fit(data, count, xy3_ldisc_room(port, tty));
	if (!whole) {
		set_bit(TTY_THROTTLED, &tty->flags);
		/*
		 * From now on unthrottle() is called when the reader makes room. It may have done
		 * so just before, so check again. Pairs with the barrier in tty_set_flow_change().
		 */
		smp_mb__after_atomic();
		whole = xy3_packets_that_fit(data, count, xy3_ldisc_room(port, tty));
	}
	/*
	 * A hangup flushes N_TTY, and waits for readers. They must not get data that follow the
	 * flushed packets. A test after N_TTY's lock was taken leaves only a hangup that starts
	 * right here.
	 */
	if (test_bit(TTY_HUPPING, &tty->flags))
		return count;
	return tty_port_default_client_ops.receive_buf(port, data, flags, whole);
}

/* The default operations except receive_buf(); filled in by xy3_tty_init() */
static struct tty_port_client_operations xy3_client_ops;

/* Continue: the line discipline may have room */
static void xy3_restart(struct xy3_line *line)
{
	struct xy3_head *head = xy3_line_head(line);

	if (!head)
		return;
	scoped_guard(mutex, &head->lock)
		tty_flip_buffer_push(&line->port);
	put_device(&head->dev);
}

/* ---- the tty ---- */

static int xy3_install(struct tty_driver *driver, struct tty_struct *tty)
{
	struct xy3_line *line = xy3_lines[tty->index];
	struct xy3_head *head = line ? xy3_line_head(line) : NULL;
	unsigned int rate;
	int err;

	if (!head)
		return -ENODEV;
	err = tty_port_install(&line->port, driver, tty);
	rate = xy3_get_rate(head);
	if (!err && rate)
		tty_encode_baud_rate(tty, rate, rate);
	put_device(&head->dev);
	if (err)
		return err;
	/* a write is passed in one piece, so that no frame is torn */
	set_bit(TTY_NO_WRITE_SPLIT, &tty->flags);
	tty->driver_data = line;
	return 0;
}

static int xy3_open(struct tty_struct *tty, struct file *file)
{
	struct xy3_line *line = tty->driver_data;
	struct xy3_head *head;
	int err;

	err = tty_port_open(&line->port, tty, file);
	if (err)
		return err;

	/* A head that was removed before the port had the tty has not hung it up */
	head = xy3_line_head(line);
	if (!head)
		return -ENODEV;
	put_device(&head->dev);
	return 0;
}

static void xy3_close(struct tty_struct *tty, struct file *file)
{
	struct xy3_line *line = tty->driver_data;

	tty_port_close(&line->port, tty, file);
}

static void xy3_hangup(struct tty_struct *tty)
{
	struct xy3_line *line = tty->driver_data;

	tty_port_hangup(&line->port);
	/* the next head may get the same tty, for any program to open */
	clear_bit(TTY_EXCLUSIVE, &tty->flags);
}

static void xy3_unthrottle(struct tty_struct *tty)
{
	xy3_restart(tty->driver_data);
}

/* The tty core passes a longer write() in pieces of this size */
#define XY3_WRITE_PIECE		SZ_64K

/* If not all frames are accepted, N_TTY waits for xy3_tty_wakeup() or returns -EAGAIN */
static ssize_t xy3_write(struct tty_struct *tty, const u8 *data, size_t size)
{
	struct xy3_line *line = tty->driver_data;
	struct xy3_head *head = xy3_line_head(line);
	ssize_t sent;

	if (!head)
		return -EIO;
	/* the rest of a frame may be in the next piece, which starts where this one was accepted */
	if (size == XY3_WRITE_PIECE)
		size = xy3_whole_frames(data, size);
	sent = xy3_send_frames(head, data, size);
	put_device(&head->dev);
	return sent;
}

static unsigned int xy3_write_room(struct tty_struct *tty)
{
	struct xy3_line *line = tty->driver_data;
	struct xy3_head *head = xy3_line_head(line);
	unsigned int room;

	if (!head)
		return 0;
	room = xy3_forward_room(head) * XY3_FRAME24_SIZE;
	put_device(&head->dev);
	return room;
}

static void xy3_show_rate(struct tty_struct *tty, unsigned int rate)
{
	if (rate && tty_get_baud_rate(tty) != rate)
		tty_encode_baud_rate(tty, rate, rate);
}

static void xy3_set_termios(struct tty_struct *tty, const struct ktermios *old)
{
	struct xy3_line *line = tty->driver_data;
	struct xy3_head *head = xy3_line_head(line);
	unsigned int rate = tty_get_baud_rate(tty);

	/* bits and parity are fixed, and packets and frames pass unchanged */
	tty_termios_copy_hw(&tty->termios, old);
	tty->termios.c_iflag = 0;
	tty->termios.c_oflag = 0;
	tty->termios.c_lflag = 0;
	/* TCSAFLUSH has emptied N_TTY, without a call of unthrottle() */
	xy3_restart(line);
	if (!head)
		return;
	/*
	 * Requested, but not waited for: the head may take seconds to follow, and readers wait as
	 * long as the settings are locked. Meanwhile the tty has the speed that was requested.
	 */
	if (rate != tty_termios_baud_rate(old) && xy3_is_rate(rate) && xy3_get_rate(head)) {
		tty_encode_baud_rate(tty, rate, rate);
		xy3_request_rate(head, rate);
	}
	put_device(&head->dev);
}

static const struct tty_operations xy3_tty_ops = {
	.install = xy3_install,
	.open = xy3_open,
	.close = xy3_close,
	.hangup = xy3_hangup,
	.unthrottle = xy3_unthrottle,
	.write = xy3_write,
	.write_room = xy3_write_room,
	.set_termios = xy3_set_termios,
};

/* ---- interface to the head ---- */

/**
 * xy3_tty_put() - pass a packet to the reader of the tty
 * @head: the head; its lock is held
 * @packet: the packet
 * @size: bytes in @packet
 *
 * Return: true, also if the tty is not open; false if there is no room for the complete packet,
 * which is then dropped.
 */
bool xy3_tty_put(struct xy3_head *head, const u8 *packet, size_t size)
{
	struct xy3_line *line = xy3_lines[head->number];

	lockdep_assert_held(&head->lock);
	if (!READ_ONCE(line->open))
		return true;
	if (tty_buffer_request_room(&line->port, size) < size)
		return false;
	tty_insert_flip_string(&line->port, packet, size);
	tty_flip_buffer_push(&line->port);
	return true;
}

/*
 * A work of the line, not of the head: it waits for readers, which may take any time to copy
 * their data to user space, and the removal of a head must not wait for that.
 */
static void xy3_show_rate_work(struct work_struct *work)
{
	struct xy3_line *line = container_of(work, struct xy3_line, show_rate);
	struct tty_struct *tty = tty_port_tty_get(&line->port);
	struct xy3_head *head;

	if (!tty)
		return;
	down_write(&tty->termios_rwsem);
	head = xy3_line_head(line);
	if (head) {
		xy3_show_rate(tty, xy3_get_rate(head));
		put_device(&head->dev);
	}
	up_write(&tty->termios_rwsem);
	tty_kref_put(tty);
}

/*
 * Hang up the tty of a removed head. A hangup drops the data in N_TTY, but not data in flight to
 * N_TTY, which a concurrent read() may get: bytes that follow dropped ones, in the middle of a
 * packet. So drop all of it first; as no head passes data to the port any more, a reader gets what
 * follows its last read() without a gap, or nothing.
 */
static void xy3_hangup_work(struct work_struct *work)
{
	struct xy3_line *line = container_of(work, struct xy3_line, hangup);
	struct tty_struct *tty = tty_port_tty_get(&line->port);

	if (tty) {
		tty_ldisc_flush(tty);
		tty_vhangup(tty);
		tty_kref_put(tty);
	}
	clear_bit(line->number, xy3_hanging);
	wake_up_all(&xy3_hung);
}

/*
 * Opening flushes the line discipline, which takes termios_rwsem, with the mutex of our port. The
 * serial core takes that of its port, the UART of a head, the other way round: another class.
 */
static struct lock_class_key xy3_port_mutex;

static struct xy3_line *xy3_line_new(unsigned int number)
{
	struct xy3_line *line = kzalloc(sizeof(*line), GFP_KERNEL);

	if (!line)
		return NULL;
	tty_port_init(&line->port);
	lockdep_set_class(&line->port.mutex, &xy3_port_mutex);
	line->port.ops = &xy3_port_ops;
	line->port.client_ops = &xy3_client_ops;
	spin_lock_init(&line->lock);
	line->number = number;
	INIT_WORK(&line->hangup, xy3_hangup_work);
	INIT_WORK(&line->show_rate, xy3_show_rate_work);
	return line;
}

/**
 * xy3_tty_wait_hung() - wait for the hangups of ttys of removed heads, for a second at most
 *
 * A reader can delay the hangup of its tty for any time. The caller must not hold locks that the
 * removal of another head requires.
 */
void xy3_tty_wait_hung(void)
{
	wait_event_timeout(xy3_hung, bitmap_empty(xy3_hanging, XY3_HEADS_MAX),
			   XY3_HANGUP_TIMEOUT);
}

/**
 * xy3_tty_is_free() - check whether a new head can have a number
 * @number: a number without a head
 *
 * Return: true if the tty of its last head has been hung up.
 */
bool xy3_tty_is_free(unsigned int number)
{
	return !test_bit(number, xy3_hanging);
}

/**
 * xy3_tty_add() - create the tty of a new head
 * @head: the head
 *
 * Return: 0 or an error.
 */
int xy3_tty_add(struct xy3_head *head)
{
	struct xy3_line *line = xy3_lines[head->number];
	struct device *dev;

	if (!line) {
		line = xy3_line_new(head->number);
		if (!line)
			return -ENOMEM;
		xy3_lines[head->number] = line;
	}
	scoped_guard(spinlock_irqsave, &line->lock)
		line->head = head;

	dev = tty_port_register_device(&line->port, xy3_tty_driver, head->number, &head->dev);
	if (IS_ERR(dev)) {
		scoped_guard(spinlock_irqsave, &line->lock)
			line->head = NULL;
		return PTR_ERR(dev);
	}
	head->tty = dev;
	head->show_rate = &line->show_rate;
	return 0;
}

/**
 * xy3_tty_remove() - hang up and remove the tty of a head
 * @head: the head that is removed; it need not have a tty
 */
void xy3_tty_remove(struct xy3_head *head)
{
	struct xy3_line *line = xy3_lines[head->number];

	if (!head->tty)
		return;
	scoped_guard(spinlock_irqsave, &line->lock)
		line->head = NULL;
	/* by a worker: the UART's tty is locked here, and the hangup waits for readers */
	set_bit(line->number, xy3_hanging);
	queue_work(system_dfl_wq, &line->hangup);
	tty_unregister_device(xy3_tty_driver, head->number);
}

/**
 * xy3_tty_wakeup() - wake up writers of the tty
 * @head: the head
 *
 * Context: any.
 */
void xy3_tty_wakeup(struct xy3_head *head)
{
	tty_port_tty_wakeup(&xy3_lines[head->number]->port);
}

/**
 * xy3_tty_is_ours() - check whether a driver is that of this module's ttys
 * @driver: the driver of a tty
 *
 * Return: true if it is.
 */
bool xy3_tty_is_ours(const struct tty_driver *driver)
{
	return driver == xy3_tty_driver;
}

/**
 * xy3_tty_init() - register the tty driver
 *
 * Return: 0 or an error.
 */
int __init xy3_tty_init(void)
{
	struct tty_driver *driver;
	int err;

	xy3_client_ops = tty_port_default_client_ops;
	xy3_client_ops.receive_buf = xy3_receive_buf;
	driver = tty_alloc_driver(XY3_HEADS_MAX, TTY_DRIVER_REAL_RAW | TTY_DRIVER_DYNAMIC_DEV |
				  TTY_DRIVER_RESET_TERMIOS);
	if (IS_ERR(driver))
		return PTR_ERR(driver);

	driver->driver_name = "xy3";
	driver->name = "xy3-";
	driver->type = TTY_DRIVER_TYPE_SERIAL;
	driver->subtype = SERIAL_TYPE_NORMAL;
	driver->init_termios = tty_std_termios;
	driver->init_termios.c_iflag = 0;
	driver->init_termios.c_oflag = 0;
	driver->init_termios.c_lflag = 0;
	driver->init_termios.c_cflag = B115200 | CS8 | CREAD | CLOCAL;
	driver->init_termios.c_ispeed = XY3_RATE_DEFAULT;
	driver->init_termios.c_ospeed = XY3_RATE_DEFAULT;
	tty_set_operations(driver, &xy3_tty_ops);

	err = tty_register_driver(driver);
	if (err) {
		tty_driver_kref_put(driver);
		return err;
	}
	xy3_tty_driver = driver;
	return 0;
}

/**
 * xy3_tty_exit() - unregister the tty driver; no heads are left
 */
void xy3_tty_exit(void)
{
	tty_unregister_driver(xy3_tty_driver);
	tty_driver_kref_put(xy3_tty_driver);
	for (unsigned int i = 0; i < XY3_HEADS_MAX; i++) {
		if (!xy3_lines[i])
			continue;
		flush_work(&xy3_lines[i]->hangup);
		flush_work(&xy3_lines[i]->show_rate);
		tty_port_put(&xy3_lines[i]->port);
	}
}
