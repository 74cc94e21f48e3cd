/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The IIO core as it is today, for kernels where it was not. One reason a line.
 */
#ifndef IIO_COMPAT_H
#define IIO_COMPAT_H

#include <linux/iio/iio.h>
#include <linux/version.h>

#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 15, 0)
/* direct mode is claimed with a truth value since 6.15 */
static inline bool iio_device_claim_direct(struct iio_dev *indio_dev)
{
	return !iio_device_claim_direct_mode(indio_dev);
}

static inline void iio_device_release_direct(struct iio_dev *indio_dev)
{
	iio_device_release_direct_mode(indio_dev);
}
#endif

#endif /* IIO_COMPAT_H */
