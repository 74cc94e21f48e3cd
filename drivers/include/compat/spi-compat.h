/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * What SPI controllers can do today, for kernels where they could not. One reason a line.
 */
#ifndef SPI_COMPAT_H
#define SPI_COMPAT_H

#include <linux/spi/spi.h>
#include <linux/version.h>

#ifdef SPI_NBITS_OCTAL
#define SPI_LINES_MAX	8
#else
#define SPI_LINES_MAX	4	/* a transfer over eight lines came with 6.12 */
#endif

#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 9, 0)
/* a message is made ready by itself, each time, before 6.9 */
static inline int spi_optimize_message(struct spi_device *spi, struct spi_message *message)
{
	return 0;
}

static inline void spi_unoptimize_message(struct spi_message *message)
{
}
#endif

#endif /* SPI_COMPAT_H */
