/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Scanheads of xy3 and xy3-spi: /sys/class/xy3/xy3-<n> (userspace/abi/sysfs-class-xy3) and, for
 * those with a forward channel, an IIO device (userspace/abi/sysfs-bus-iio-xy3).
 */
#ifndef HEAD_H
#define HEAD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <linux/xy3.h>

#define HEADS_MAX 32	/* of xy3.ko */

struct head {
	char name[16];		/* xy3-<n> */
	char path[64];		/* in /sys/class/xy3 */
	char node[32];		/* /dev/xy3-<n> */
	char back[64];		/* device of the UART; "" if there is none or it has no name */
	char forward[64];	/* SPI device, or "" */
	char iio[32];		/* iio:device<n>, or "" */
};

/* All heads in ascending order. Return their number. */
size_t head_list(struct head heads[HEADS_MAX]);

/*
 * The head of this name: xy3-<n>, <n>, /dev/xy3-<n>, or NULL for the first. Return 0, or
 * CLI_NO_DEVICE after a message.
 */
int head_find(struct head *head, const char *name);

/* An attribute of the head or of its IIO device, see sysfs.h; -ENODEV without a device */
int head_read(const struct head *head, const char *name, char *text, size_t size);
int head_read_iio(const struct head *head, const char *name, long long *number);
/* A counter of its forward channel, which is in debugfs: for root, if it is mounted */
int head_read_counter(const struct head *head, const char *name, long long *number);
int head_write(const struct head *head, const char *name, const char *text);
int head_write_iio(const struct head *head, const char *name, long long number);

/* Temperature of a component in millidegrees. Return 0, or -ENODATA if it is not reported. */
int head_temperature(const struct head *head, unsigned int component, long *millidegrees);

/* Number of axes of its forward channel, out_angl0 and so on */
unsigned int head_axes(const struct head *head);

#endif /* HEAD_H */
