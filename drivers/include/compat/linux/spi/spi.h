/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_SPI_H
#define COMPAT_SPI_H

#include_next <linux/spi/spi.h>
#include "../../callback.h"

#ifndef KERNEL_HAS_SPI_LANES
/*
 * A device had one lane. The mode for more is mapped to a bit of the transfer, which stays 0, and
 * their number to the word size of the device: code for more than one lane is not reached.
 */
#define SPI_DEVICE_DATA_LANE_CNT_MAX	1
#define SPI_MULTI_LANE_MODE_SINGLE	0
#define SPI_MULTI_LANE_MODE_STRIPE	1
#define multi_lane_mode			dummy_data
#define num_tx_lanes			bits_per_word
#endif

#ifndef KERNEL_HAS_SPI_NBITS_OCTAL
/* transfers could not use eight lines: a device does not get them, as if its controller had none */
static inline int spi_setup_up_to_quad(struct spi_device *spi)
{
	spi->mode &= ~SPI_TX_OCTAL;
	return spi_setup(spi);
}

#define spi_setup(spi)	spi_setup_up_to_quad(spi)
#endif

#ifndef KERNEL_HAS_SPI_OPTIMIZE_MESSAGE
/* each message was prepared just before it was sent, with the controller as an argument */
#define optimize_message	prepare_message
#define unoptimize_message	unprepare_message

#define sim_optimize(parameter)							\
	COMPAT_CALLBACK(int, sim_optimize, int,					\
			(struct spi_controller *controller, struct spi_message *message),	\
			(message), (parameter))
#define sim_unoptimize(parameter)						\
	COMPAT_CALLBACK(int, sim_unoptimize, int,				\
			(struct spi_controller *controller, struct spi_message *message),	\
			(message), (parameter))

/* each message was prepared when it was sent */
static inline int spi_optimize_message(struct spi_device *spi, struct spi_message *message)
{
	return 0;
}

static inline void spi_unoptimize_message(struct spi_message *message)
{
}
#endif

#endif /* COMPAT_SPI_H */
