// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: the line discipline - any UART tty as a backchannel
 *
 *   ldattach -s 115200 -8 -n -1 29 /dev/ttyUSB0
 */

#include <linux/capability.h>
#include <linux/errno.h>
#include <linux/module.h>
#include <linux/slab.h>
#include <linux/tty.h>
#include <linux/tty_driver.h>
#include <linux/tty_ldisc.h>

#include "xy3.h"

/* Maximum size that tty_ldisc_ops.receive_buf gets */
#define XY3_RECEIVE_ROOM	65536

static int ldisc = N_DEVELOPMENT;
module_param(ldisc, int, 0444);
MODULE_PARM_DESC(ldisc, "Number of the line discipline (default: 29)");

/**
 * struct xy3_uart - a backchannel by line discipline
 * @back: the backchannel
 * @tty: the UART's tty
 * @iflag: its input modes before attaching
 */
struct xy3_uart {
	struct xy3_back back;
	struct tty_struct *tty;
	tcflag_t iflag;
};

static void xy3_uart_set_speed(struct tty_struct *tty, unsigned int rate)
{
	struct ktermios termios = tty->termios;

	tty_termios_encode_baud_rate(&termios, rate, rate);
	tty_set_termios(tty, &termios);
}

static int xy3_uart_set_rate(struct xy3_back *back, unsigned int old_rate,
			     unsigned int rate)
{
	struct tty_struct *tty = container_of(back, struct xy3_uart, back)->tty;

	xy3_uart_set_speed(tty, rate);
	if (xy3_rate_close(tty_get_baud_rate(tty), rate))
		return 0;
	xy3_uart_set_speed(tty, old_rate);
	return -EINVAL;
}

static const struct xy3_back_ops xy3_uart_ops = {
	.set_rate = xy3_uart_set_rate,
};

#define XY3_IFLAGS		(IGNBRK | IGNPAR | BRKINT | INPCK)
#define XY3_IFLAGS_FLAGGED	(BRKINT | INPCK)

/* Have the UART's driver flag damaged bytes, which most do only on request */
static void xy3_uart_flag_errors(struct xy3_uart *uart)
{
	struct ktermios termios = uart->tty->termios;

	uart->iflag = termios.c_iflag;
	termios.c_iflag = (termios.c_iflag & ~XY3_IFLAGS) | XY3_IFLAGS_FLAGGED;
	tty_set_termios(uart->tty, &termios);
}

/* Restore the modes for the next user of the UART, unless they have been changed since */
static void xy3_uart_unflag_errors(struct xy3_uart *uart)
{
	struct tty_struct *tty = uart->tty;
	struct ktermios termios = tty->termios;

	if ((termios.c_iflag & XY3_IFLAGS) != XY3_IFLAGS_FLAGGED)
		return;
	termios.c_iflag = (termios.c_iflag & ~XY3_IFLAGS) | (uart->iflag & XY3_IFLAGS);
	if (tty->count && !test_bit(TTY_HUPPING, &tty->flags)) {
		tty_set_termios(tty, &termios);
		return;
	}
	/* the UART is closed or removed; these are for the next open() */
	down_write(&tty->termios_rwsem);
	tty->termios.c_iflag = termios.c_iflag;
	up_write(&tty->termios_rwsem);
}

static int xy3_ldisc_open(struct tty_struct *tty)
{
	struct xy3_uart *uart;
	int err;

	if (!capable(CAP_SYS_ADMIN))
		return -EPERM;
	/* a backchannel of a backchannel could be its own */
	if (xy3_tty_is_ours(tty->driver))
		return -EINVAL;
	/* the master of a pty has no settings to change */
	if (tty->driver->type == TTY_DRIVER_TYPE_PTY && tty->driver->subtype == PTY_TYPE_MASTER)
		return -EINVAL;

	uart = kzalloc(sizeof(*uart), GFP_KERNEL);
	if (!uart)
		return -ENOMEM;
	uart->tty = tty;
	xy3_uart_flag_errors(uart);
	uart->back.ops = &xy3_uart_ops;
	uart->back.dev = tty->dev;	/* ptys have none */
	uart->back.rate = tty_get_baud_rate(tty);
	err = xy3_back_attach(&uart->back);
	if (err) {
		xy3_uart_unflag_errors(uart);
		kfree(uart);
		return err;
	}
	tty->disc_data = uart;
	tty->receive_room = XY3_RECEIVE_ROOM;
	/* the previous line discipline may have left the UART throttled */
	tty_unthrottle(tty);
	return 0;
}

/* Also called after a hangup. No more data are received. */
static void xy3_ldisc_close(struct tty_struct *tty)
{
	struct xy3_uart *uart = tty->disc_data;

	xy3_back_detach(&uart->back);
	xy3_uart_unflag_errors(uart);
	tty->disc_data = NULL;
	kfree(uart);
}

static void xy3_ldisc_receive(struct tty_struct *tty, const u8 *data, const u8 *flags,
			      size_t count)
{
	struct xy3_uart *uart = tty->disc_data;

	xy3_back_receive(&uart->back, data, flags, count);
	/* wake a writer that is blocked on the master of a pty */
	tty_unthrottle(tty);
}

/* The backchannel has one direction */
static ssize_t xy3_ldisc_write(struct tty_struct *tty, struct file *file, const u8 *data,
			       size_t size)
{
	return -EOPNOTSUPP;
}

static void xy3_ldisc_set_termios(struct tty_struct *tty, const struct ktermios *old)
{
	struct xy3_uart *uart = tty->disc_data;

	xy3_back_rate_changed(&uart->back, tty_get_baud_rate(tty));
}

static struct tty_ldisc_ops xy3_ldisc_ops = {
	.owner = THIS_MODULE,
	.name = "xy3",
	.open = xy3_ldisc_open,
	.close = xy3_ldisc_close,
	.write = xy3_ldisc_write,
	.ioctl = n_tty_ioctl_helper,
	.set_termios = xy3_ldisc_set_termios,
	.receive_buf = xy3_ldisc_receive,
};

/**
 * xy3_ldisc_init() - register the line discipline
 *
 * Return: 0; -EINVAL if the number is not available; or another error.
 */
int __init xy3_ldisc_init(void)
{
	/* it would replace the standard line discipline of all ttys */
	if (ldisc == N_TTY)
		return -EINVAL;
	xy3_ldisc_ops.num = ldisc;
	return tty_register_ldisc(&xy3_ldisc_ops);
}

/**
 * xy3_ldisc_exit() - unregister it
 */
void xy3_ldisc_exit(void)
{
	tty_unregister_ldisc(&xy3_ldisc_ops);
}

MODULE_ALIAS_LDISC(N_DEVELOPMENT);
