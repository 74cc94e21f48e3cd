/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Types in the callbacks of ttys and classes that have changed over the kernels. Written as they
 * are today; one reason a line.
 */
#ifndef TTY_COMPAT_H
#define TTY_COMPAT_H

#include <linux/types.h>
#include <linux/version.h>

#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 6, 0)
typedef char tty_flag_t;	/* tty_ldisc_ops.receive_buf: flags are u8 since 6.6 */
typedef int tty_count_t;	/* tty_ldisc_ops.receive_buf: the count is size_t since 6.6 */
typedef int tty_size_t;		/* tty_operations.write: the size is size_t since 6.6 */
typedef int tty_ssize_t;	/* tty_operations.write: ssize_t is returned since 6.6 */
typedef int tty_taken_t;	/* tty_port_client_operations.receive_buf: size_t since 6.6 */
#else
typedef u8 tty_flag_t;
typedef size_t tty_count_t;
typedef size_t tty_size_t;
typedef ssize_t tty_ssize_t;
typedef size_t tty_taken_t;
#endif

#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 8, 0)
typedef int serdev_size_t;	/* serdev_device_ops.receive_buf: size_t is returned since 6.8 */
#else
typedef size_t serdev_size_t;
#endif

#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 4, 0)
#define class_const		/* class_attribute: class and attribute are const since 6.4 */
#else
#define class_const const
#endif

#endif /* TTY_COMPAT_H */
