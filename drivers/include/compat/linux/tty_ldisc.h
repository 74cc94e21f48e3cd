/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_TTY_LDISC_H
#define COMPAT_TTY_LDISC_H

#include_next <linux/tty_ldisc.h>
#include "../callback.h"

#ifndef KERNEL_HAS_TTY_LDISC_RECEIVE_SIZE
/* tty_ldisc_ops.receive_buf: the count was int, the flags were char */
#define xy3_ldisc_receive(...)							\
	COMPAT_CALLBACK(void, xy3_ldisc_receive, void,				\
			(struct tty_struct *tty, const u8 *data, const char *flags, int count), \
			(tty, data, (const u8 *)flags, count), (__VA_ARGS__))
#endif

#endif /* COMPAT_TTY_LDISC_H */
