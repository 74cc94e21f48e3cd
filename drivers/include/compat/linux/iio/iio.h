/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_IIO_H
#define COMPAT_IIO_H

#include_next <linux/iio/iio.h>

#ifndef KERNEL_HAS_IIO_CLAIM_DIRECT
/* claiming direct mode returned an error; the function that returns bool has another name */
static inline bool iio_device_claim_direct(struct iio_dev *indio_dev)
{
	return !iio_device_claim_direct_mode(indio_dev);
}

static inline void iio_device_release_direct(struct iio_dev *indio_dev)
{
	iio_device_release_direct_mode(indio_dev);
}
#endif

#endif /* COMPAT_IIO_H */
