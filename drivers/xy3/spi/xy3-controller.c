// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: what the SPI controller has to do, and whether it can
 *
 * The head takes data at the falling edge of CLK, on as many lines at once as there are axes. What
 * a controller states about its modes is looked at here, and nowhere else.
 */

#include <linux/bits.h>
#include <linux/err.h>
#include <linux/property.h>
#include <linux/string.h>

#include "xy3-spi.h"

/* Bits of a device's mode that give the number of its data lines */
#define XY3_SPI_TX_LINES	(SPI_TX_DUAL | SPI_TX_QUAD | SPI_TX_OCTAL)

/* What firmware may add to the mode; all else, such as the order of bits, is fixed by the head */
#define XY3_SPI_MODE_KEPT	(XY3_SPI_TX_LINES | SPI_CS_HIGH | SPI_NO_CS)

/**
 * enum xy3_defect - what a controller's driver promises and does not do
 * @XY3_DEFECT_CPHA: takes SPI mode 1, and does mode 0
 * @XY3_DEFECT_LINES: takes several data lines, and sends plain transfers on one
 * @XY3_DEFECT_CLOCK: does not look at the clock of a transfer
 * @XY3_DEFECT_LANES: chooses the lanes of plain transfers by a variable that it has not
 *		      initialised, and counts their words by the lanes for reading
 */
enum xy3_defect {
	XY3_DEFECT_CPHA = BIT(0),
	XY3_DEFECT_LINES = BIT(1),
	XY3_DEFECT_CLOCK = BIT(2),
	XY3_DEFECT_LANES = BIT(3),
};

/*
 * Drivers by name, as the SPI core has no flag for it: drivers/spi/ of 6.12 and 7.3 were read. In
 * some a later kernel or another chip does better, so that this is a warning only.
 */
static const struct {
	const char *driver;
	unsigned int defects;
} xy3_defects[] = {
	{ "tegra-qspi", XY3_DEFECT_CPHA },		/* spi-tegra210-quad.c */
	{ "microchip,coreqspi", XY3_DEFECT_CPHA | XY3_DEFECT_CLOCK },
	{ "mxic-spi", XY3_DEFECT_CPHA | XY3_DEFECT_LINES },
	{ "cadence-xspi", XY3_DEFECT_LINES },
	{ "img-spfi", XY3_DEFECT_LINES },
	{ "mtk-spi", XY3_DEFECT_LINES },		/* spi-mt65xx.c, up to 6.12 */
	{ "spi-engine", XY3_DEFECT_LANES },		/* spi-axi-spi-engine.c, 7.3 */
	{ "spi-pci1xxxx", XY3_DEFECT_LINES },
	{ "sprd-spi", XY3_DEFECT_LINES },
	{ "stm32-ospi", XY3_DEFECT_CLOCK },		/* the device's, as the next one */
	{ "stm32-qspi", XY3_DEFECT_CLOCK },
	{ "xilinx_spi", XY3_DEFECT_CLOCK },		/* that of the FPGA's design */
};

static unsigned int xy3_defects_of(const struct spi_controller *controller)
{
	const struct device *dev = controller->dev.parent;

	if (!dev || !dev->driver)
		return 0;
	for (size_t i = 0; i < ARRAY_SIZE(xy3_defects); i++)
		if (!strcmp(dev->driver->name, xy3_defects[i].driver))
			return xy3_defects[i].defects;
	return 0;
}

static void xy3_warn_of_defects(const struct spi_device *spi, unsigned int lines, bool lanes)
{
	unsigned int defects = xy3_defects_of(spi->controller);

	if (defects & XY3_DEFECT_CPHA && (spi->mode & SPI_MODE_X_MASK) == SPI_MODE_1)
		dev_warn(&spi->dev,
			 "this controller is known to send in SPI mode 0 for mode 1: cross the CLK pair and set lasia,clock-inverted\n");
	if (defects & XY3_DEFECT_LINES && lines > 1)
		dev_warn(&spi->dev,
			 "this controller is known to use one data line for plain transfers\n");
	if (defects & XY3_DEFECT_LANES && lanes)
		dev_warn(&spi->dev,
			 "this controller is known to send plain transfers on lanes that were not chosen\n");
	if (defects & XY3_DEFECT_CLOCK)
		dev_warn(&spi->dev,
			 "this controller is known to send at one clock: sampling_frequency does not change it, achieved_frequency tells what it is\n");
}

static u32 xy3_lines_of(u32 mode)
{
	if (mode & SPI_TX_OCTAL)
		return 8;
	if (mode & SPI_TX_QUAD)
		return 4;
	return mode & SPI_TX_DUAL ? 2 : 1;
}

static bool xy3_can_words(struct spi_device *spi)
{
	return spi_is_bpw_supported(spi, 24) && spi_is_bpw_supported(spi, 32);
}

/*
 * The SPI core drops what the controller cannot do without a word, and has done so before this
 * driver saw the device: how many lines were meant is known from the property alone. From 7.2 on
 * it may be an array, with a width for each lane: a line that has a shift register of its own.
 */
static int xy3_lines_wanted(struct spi_device *spi, u32 *lines, bool *lanes)
{
	int cells = device_property_count_u32(&spi->dev, "spi-tx-bus-width");
	u32 width[XY3_LINES_MAX];

	*lines = xy3_lines_of(spi->mode);
	*lanes = cells > 1;
	if (cells == 1)
		device_property_read_u32(&spi->dev, "spi-tx-bus-width", lines);
	if (!*lanes)
		return 0;

	if (cells > min(SPI_DEVICE_DATA_LANE_CNT_MAX, XY3_LINES_MAX))
		return dev_err_probe(&spi->dev, -EINVAL,
				     "spi-tx-bus-width: this kernel has no %d lanes\n", cells);
	/* it does so for devicetrees only, and compares their number with the controller's there */
	if (spi->num_tx_lanes != cells)
		return dev_err_probe(&spi->dev, -EINVAL,
				     "spi-tx-bus-width: the SPI core has not set up %d lanes\n",
				     cells);
	device_property_read_u32_array(&spi->dev, "spi-tx-bus-width", width, cells);
	for (int i = 0; i < cells; i++)
		if (width[i] != 1)
			return dev_err_probe(&spi->dev, -EINVAL,
					     "spi-tx-bus-width: a lane is one line wide\n");
	if (!xy3_can_words(spi))
		return dev_err_probe(&spi->dev, -EINVAL,
				     "spi-tx-bus-width: lanes require words of 24 and 32 bits\n");
	*lines = cells;
	return 0;
}

/*
 * Data are valid at the falling edge of CLK. With the pair of CLK crossed that is the rising edge
 * of the controller's clock: mode 3, or 0 for controllers that have no clock phase.
 */
static u32 xy3_clock_mode(const struct spi_device *spi, bool inverted)
{
	const u32 both = SPI_CPOL | SPI_CPHA;

	if (!inverted)
		return SPI_MODE_1;
	return (spi->controller->mode_bits & both) == both ? SPI_MODE_3 : SPI_MODE_0;
}

/* A word is a frame, and the controller moves SYNC by itself */
static bool xy3_can_cs_word(struct spi_device *spi)
{
	/* with a GPIO as chip select the SPI core would cut every message up, a transfer a word */
	return spi->controller->mode_bits & SPI_CS_WORD && !spi_get_csgpiod(spi, 0) &&
	       xy3_can_words(spi);
}

/**
 * xy3_controller_setup() - set a device's controller up for a head
 * @spi: the device; its mode is changed
 * @lines: number of data lines that it has
 * @words: it is given scans as words
 *
 * What cannot be done is an error with a sentence in the log.
 *
 * Return: 0; -EOPNOTSUPP when the controller has no plain transfers; -EINVAL when it lacks lines,
 * the clock's edge or the length of a transfer.
 */
int xy3_controller_setup(struct spi_device *spi, unsigned int *lines, bool *words)
{
	struct device *dev = &spi->dev;
	bool inverted = device_property_read_bool(dev, "lasia,clock-inverted");
	size_t room;
	u32 wanted;
	bool lanes;
	int err;

	if (!spi->controller->transfer)
		return dev_err_probe(dev, -EOPNOTSUPP,
				     "the controller has flash operations only (spi-mem)\n");
	err = xy3_lines_wanted(spi, &wanted, &lanes);
	if (err)
		return err;
	spi->mode &= XY3_SPI_MODE_KEPT;
	spi->mode |= xy3_clock_mode(spi, inverted);
	if (wanted == 1 && xy3_can_cs_word(spi))
		spi->mode |= SPI_CS_WORD;
	spi->bits_per_word = 8;
	/* other work must not keep the next block from the controller */
	spi->rt = true;
	err = spi_setup(spi);
	if (err)
		return dev_err_probe(dev, err, inverted ?
				     "the controller refuses SPI modes 0 and 3\n" :
				     "the controller refuses SPI mode 1; with the CLK pair crossed, lasia,clock-inverted\n");

	*lines = lanes ? wanted : xy3_lines_of(spi->mode);
	if (*lines != wanted)
		return dev_err_probe(dev, -EINVAL, "the controller has no %u data lines\n", wanted);
	room = XY3_GAP_ROOM(*lines) + XY3_SCAN_ROOM(*lines);
	if (spi_max_transfer_size(spi) < room)
		return dev_err_probe(dev, -EINVAL,
				     "the controller takes %zu bytes at a time, a scan has up to %zu\n",
				     spi_max_transfer_size(spi), room);
	xy3_warn_of_defects(spi, *lines, lanes);
	*words = lanes || spi->mode & SPI_CS_WORD;
	return 0;
}
