/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef HOST_LINUX_SPRINTF_H
#define HOST_LINUX_SPRINTF_H

#include <stdarg.h>
#include <stdio.h>
#include <linux/compiler_types.h>
#include <linux/types.h>

/* Like snprintf, but returns what was really stored. */
__printf(3, 4) int scnprintf(char *buf, size_t size, const char *fmt, ...);
__printf(3, 0) int vscnprintf(char *buf, size_t size, const char *fmt, va_list args);

#endif
