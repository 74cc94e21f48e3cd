/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_TTY_PORT_H
#define COMPAT_TTY_PORT_H

#include_next <linux/tty_port.h>
#include "../callback.h"

#ifndef KERNEL_HAS_TTY_PORT_RECEIVE_SIZE
/* tty_port_client_operations.receive_buf: int was returned */
#define xy3_receive_buf(...)							\
	COMPAT_CALLBACK(size_t, xy3_receive_buf, int,				\
			(struct tty_port *port, const u8 *data, const u8 *flags, size_t count), \
			(port, data, flags, count), (__VA_ARGS__))
#endif

#endif /* COMPAT_TTY_PORT_H */
