/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_TTY_DRIVER_H
#define COMPAT_TTY_DRIVER_H

#include_next <linux/tty_driver.h>
#include "../callback.h"

#ifndef KERNEL_HAS_TTY_WRITE_SIZE
/* tty_operations.write: sizes were int */
#define COMPAT_TTY_WRITE(name, ...)						\
	COMPAT_CALLBACK(ssize_t, name, int,					\
			(struct tty_struct *tty, const u8 *data, int size),	\
			(tty, data, size), (__VA_ARGS__))
#define sim_write(...)	COMPAT_TTY_WRITE(sim_write, __VA_ARGS__)
#define xy3_write(...)	COMPAT_TTY_WRITE(xy3_write, __VA_ARGS__)
#endif

#endif /* COMPAT_TTY_DRIVER_H */
