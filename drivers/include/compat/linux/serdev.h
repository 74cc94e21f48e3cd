/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_SERDEV_H
#define COMPAT_SERDEV_H

#include_next <linux/serdev.h>
#include "../callback.h"

#ifndef KERNEL_HAS_SERDEV_RECEIVE_SIZE
/* serdev_device_ops.receive_buf: int was returned */
#define xy3_serdev_receive(...)							\
	COMPAT_CALLBACK(size_t, xy3_serdev_receive, int,			\
			(struct serdev_device *serdev, const u8 *data, size_t size), \
			(serdev, data, size), (__VA_ARGS__))
#endif

#endif /* COMPAT_SERDEV_H */
