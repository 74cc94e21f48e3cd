/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef HOST_LINUX_ERRNO_H
#define HOST_LINUX_ERRNO_H

/* libc's <errno.h> takes its numbers from here as well */
#include_next <linux/errno.h>

#endif
