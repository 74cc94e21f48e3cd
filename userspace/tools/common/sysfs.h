/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Attributes of sysfs, one value per file. Paths are printf formats. Return a negative errno: that
 * of the driver, or of the open.
 */
#ifndef SYSFS_H
#define SYSFS_H

#include <stddef.h>

/* The text without its last newline, truncated to the room. Return its length. */
int sysfs_read(char *text, size_t size, const char *path, ...)
	__attribute__((format(printf, 3, 4)));
/* A number, decimal or 0x hexadecimal. Return 0, or -EINVAL if it is not a number. */
int sysfs_read_number(long long *number, const char *path, ...)
	__attribute__((format(printf, 2, 3)));
/* The whole text by one write. Return 0. */
int sysfs_write(const char *text, const char *path, ...) __attribute__((format(printf, 2, 3)));

#endif /* SYSFS_H */
