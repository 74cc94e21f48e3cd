// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: /dev/xy3-<n> - packets out, command frames in, the rate as the tty's speed
 *
 * Each number has a line, which stays when its head goes: a program that still holds the hung up
 * tty does not keep the number from the next head, nor is its tty in that one's way.
 */

#include <linux/bitmap.h>
#include <linux/err.h>
#include <linux/lockdep.h>
#include <linux/slab.h>
#include <linux/tty.h>
#include <linux/tty_driver.h>
#include <linux/tty_flip.h>
#include <linux/wait.h>

#include "xy3.h"

/* How long a new head waits for the hangup of an earlier one's tty */
#define XY3_HANGUP_TIMEOUT	HZ

/**
 * struct xy3_line - what belongs to a number
 * @port: the tty's port
 * @number: the number
 * @lock: protects @head
 * @head: the head with this number, or NULL
 * @open: the tty is open, and packets go there; read without a lock
 * @hangup: hangs up the tty of the last head
 * @show_rate: lets the tty's speed be the rate in force
 */
struct xy3_line {
	struct tty_port port;
	unsigned int number;
	spinlock_t lock;	/* see above */
	struct xy3_head *head;
	bool open;
	struct work_struct hangup;
	struct work_struct show_rate;
};

static struct tty_driver *xy3_tty_driver;
static struct xy3_line *xy3_lines[XY3_HEADS_MAX];

/* Numbers whose last head has gone, and whose tty is yet to be hung up */
static DECLARE_BITMAP(xy3_hanging, XY3_HEADS_MAX);
static DECLARE_WAIT_QUEUE_HEAD(xy3_hung);

static struct xy3_line *xy3_port_line(struct tty_port *port)
{
	return container_of(port, struct xy3_line, port);
}

/* The head of a line, to be given back by put_device(); NULL when it has gone */
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
	/* what the last reader has left may begin in the middle of a packet */
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

/* ---- the way to the line discipline ---- */

/*
 * How many bytes the line discipline takes now. N_TTY sets receive_room whenever it is given data,
 * also when there are none.
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
 * Give packets to the line discipline, and only whole ones. N_TTY would take as many bytes as it
 * has room for. If it is flushed then, by TCSAFLUSH or a hangup, a reader gets the rest of the
 * packet that was cut as if it were the start of one.
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
		 * so just before, so look again. Pairs with the barrier in tty_set_flow_change().
		 */
		smp_mb__after_atomic();
		whole = xy3_packets_that_fit(data, count, xy3_ldisc_room(port, tty));
	}
	/*
	 * A hangup flushes N_TTY, and waits for readers. These must not get what is behind the
	 * packets that were flushed. To test for it after N_TTY's lock was taken leaves only a
	 * hangup that begins right here.
	 */
	if (test_bit(TTY_HUPPING, &tty->flags))
		return count;
	return tty_port_default_client_ops.receive_buf(port, data, flags, whole);
}

/* The default ones but for receive_buf(); filled in by xy3_tty_init() */
static struct tty_port_client_operations xy3_client_ops;

/* Go on: the line discipline may have room */
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
	/* a write comes in one piece, so that no frame is torn */
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

	/* A head that went before the port knew of the tty has not hung it up */
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
	/* the next head may have the same tty, for any program to open */
	clear_bit(TTY_EXCLUSIVE, &tty->flags);
}

static void xy3_unthrottle(struct tty_struct *tty)
{
	xy3_restart(tty->driver_data);
}

/* N_TTY waits for xy3_tty_wakeup() when not all frames are taken, or gives -EAGAIN */
static ssize_t xy3_write(struct tty_struct *tty, const u8 *data, size_t size)
{
	struct xy3_line *line = tty->driver_data;
	struct xy3_head *head = xy3_line_head(line);
	ssize_t sent;

	if (!head)
		return -EIO;
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

	/* bits and parity are what they are, and packets and frames pass unchanged */
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

/* ---- for the head ---- */

/**
 * xy3_tty_put() - give a packet to the reader of the tty
 * @head: the head; its lock is held
 * @packet: the packet
 * @size: its bytes
 *
 * Return: true, also when the tty is not open; false when there is no room for the whole packet,
 * and then nothing was given.
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
 * A work of the line, not of the head: it waits for readers, each of which may take any time to
 * copy its data to user space, and a head that goes must not wait for that.
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
 * Hang up the tty of a head that has gone. A hangup drops what N_TTY holds, but not what is on its
 * way to N_TTY, and a reader that is in read() at this moment may get that: bytes from behind
 * dropped ones, in the middle of a packet. So all of it is dropped before; as no head puts anything
 * into the port any more, a reader gets what follows its last read() without a gap, or nothing.
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

static struct xy3_line *xy3_line_new(unsigned int number)
{
	struct xy3_line *line = kzalloc(sizeof(*line), GFP_KERNEL);

	if (!line)
		return NULL;
	tty_port_init(&line->port);
	line->port.ops = &xy3_port_ops;
	line->port.client_ops = &xy3_client_ops;
	spin_lock_init(&line->lock);
	line->number = number;
	INIT_WORK(&line->hangup, xy3_hangup_work);
	INIT_WORK(&line->show_rate, xy3_show_rate_work);
	return line;
}

/**
 * xy3_tty_wait_hung() - wait for the hangups of ttys whose heads have gone, for a second at most
 *
 * A reader can hold up the hangup of its tty for as long as it likes. Nothing may be locked here
 * that another head requires to go.
 */
void xy3_tty_wait_hung(void)
{
	wait_event_timeout(xy3_hung, bitmap_empty(xy3_hanging, XY3_HEADS_MAX),
			   XY3_HANGUP_TIMEOUT);
}

/**
 * xy3_tty_is_free() - can a new head have this number
 * @number: the number, which no head has
 *
 * Return: whether the tty of the last head with it has been hung up.
 */
bool xy3_tty_is_free(unsigned int number)
{
	return !test_bit(number, xy3_hanging);
}

/**
 * xy3_tty_add() - make the tty of a new head
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
 * xy3_tty_remove() - hang the tty up and take it away
 * @head: the head that goes; it need not have one
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
 * xy3_tty_wakeup() - let writers of the tty try again
 * @head: the head
 *
 * In any context.
 */
void xy3_tty_wakeup(struct xy3_head *head)
{
	tty_port_tty_wakeup(&xy3_lines[head->number]->port);
}

/**
 * xy3_tty_is_ours() - is it the driver of our own ttys
 * @driver: a tty's driver
 *
 * Return: whether it is.
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
 * xy3_tty_exit() - unregister the tty driver; there are no heads any more
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
