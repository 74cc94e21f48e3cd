// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: requirements for the SPI controller
 *
 * The head samples data at the falling edge of CLK, on one line for each axis at the same time. The
 * modes of controllers are only checked here.
 */

#include <linux/bits.h>
#include <linux/err.h>
#include <linux/property.h>
#include <linux/string.h>

#include "xy3-spi.h"

/* Bits of the mode of a device for the number of its data lines */
#define XY3_SPI_TX_LINES	(SPI_TX_DUAL | SPI_TX_QUAD | SPI_TX_OCTAL)

/* Mode bits that firmware may set; others, such as the order of bits, are fixed by the head */
#define XY3_SPI_MODE_KEPT	(XY3_SPI_TX_LINES | SPI_CS_HIGH | SPI_NO_CS)

/**
 * enum xy3_defect - features that a controller driver accepts, but does not support
 * @XY3_DEFECT_CPHA: accepts SPI mode 1, but uses mode 0
 * @XY3_DEFECT_LINES: accepts several data lines, but sends plain transfers on one
 * @XY3_DEFECT_CLOCK: ignores the clock of a transfer
 * @XY3_DEFECT_LANES: selects the lanes of plain transfers by an uninitialised variable, and
 *		      counts their words by the lanes for reading
 * @XY3_DEFECT_GPIO: never finishes a plain transfer whose chip select is not a GPIO
 * @XY3_DEFECT_CS: ignores cs_change: sends all transfers of a message with one chip select
 * @XY3_DEFECT_CHANGE: changes the transfers that it sends, so that they cannot be sent again
 */
enum xy3_defect {
	XY3_DEFECT_CPHA = BIT(0),
	XY3_DEFECT_LINES = BIT(1),
	XY3_DEFECT_CLOCK = BIT(2),
	XY3_DEFECT_LANES = BIT(3),
	XY3_DEFECT_GPIO = BIT(4),
	XY3_DEFECT_CS = BIT(5),
	XY3_DEFECT_CHANGE = BIT(6),
};

/*
 * Drivers by name, as the SPI core has no flag for it, from drivers/spi/ of 6.12 and 7.3. Some work
 * with a later kernel or another chip, so that this is only a warning, unless a driver cannot work
 * with any, or a wait would never end.
 */
static const struct {
	const char *driver;
	unsigned int defects;
} xy3_defects[] = {
	{ "amd_spi", XY3_DEFECT_CHANGE },		/* spi-amd.c */
	{ "amd_spi_pci", XY3_DEFECT_CHANGE },
	{ "tegra-qspi", XY3_DEFECT_CPHA },		/* spi-tegra210-quad.c */
	{ "microchip,coreqspi", XY3_DEFECT_CPHA | XY3_DEFECT_CLOCK },
	{ "mxic-spi", XY3_DEFECT_CPHA | XY3_DEFECT_LINES },
	{ "cadence-xspi", XY3_DEFECT_LINES },
	{ "dw_spi_mmio", XY3_DEFECT_LINES },		/* spi-dw-core.c, 7.3 */
	{ "dw_spi_pci", XY3_DEFECT_LINES },
	{ "fsl_espi", XY3_DEFECT_CS },
	{ "img-spfi", XY3_DEFECT_LINES },
	{ "mtk-spi", XY3_DEFECT_LINES },		/* spi-mt65xx.c, up to 6.12 */
	{ "spi-engine", XY3_DEFECT_LANES },		/* spi-axi-spi-engine.c, 7.3 */
	{ "spi-pci1xxxx", XY3_DEFECT_LINES },
	{ "sprd-spi", XY3_DEFECT_LINES },
	{ "sqi-pic32", XY3_DEFECT_CPHA | XY3_DEFECT_CS },
	/* the clock of the device */
	{ "stm32-ospi", XY3_DEFECT_CLOCK | XY3_DEFECT_GPIO | XY3_DEFECT_CS },
	{ "stm32-qspi", XY3_DEFECT_CLOCK | XY3_DEFECT_GPIO | XY3_DEFECT_CS },
	{ "ti-qspi", XY3_DEFECT_CS },
	{ "xilinx_spi", XY3_DEFECT_CLOCK },		/* clock of the FPGA design */
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

/**
 * xy3_controller_warn_of_map() - warn if the controller is known not to support a line map
 * @spi: the device
 * @map: the line map
 */
void xy3_controller_warn_of_map(const struct spi_device *spi, const struct xy3_line_map *map)
{
	if (map->sync_line < 0 && !map->words &&
	    xy3_defects_of(spi->controller) & XY3_DEFECT_CS)
		dev_warn(&spi->dev,
			 "this controller is known to ignore cs_change: SYNC does not change between frames unless it is a data line\n");
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
 * The SPI core silently drops unsupported mode bits before this driver is probed: only the property
 * has the number of lines. Since 7.2 it may be an array, with a width for each lane: a line with a
 * separate shift register.
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
	/* it only parses lanes in devicetrees, and checks their number there */
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
 * Data are valid at the falling edge of CLK. With the pair of CLK crossed this is the rising edge
 * of the clock of the controller: mode 3, or 0 for controllers without a clock phase.
 */
static u32 xy3_clock_mode(const struct spi_device *spi, bool inverted)
{
	const u32 both = SPI_CPOL | SPI_CPHA;

	if (!inverted)
		return SPI_MODE_1;
	return (spi->controller->mode_bits & both) == both ? SPI_MODE_3 : SPI_MODE_0;
}

/* A word is a frame, and the controller toggles SYNC */
static bool xy3_can_cs_word(struct spi_device *spi)
{
	/* with a GPIO as chip select the SPI core would send each word as a transfer */
	return spi->controller->mode_bits & SPI_CS_WORD && !spi_get_csgpiod(spi, 0) &&
	       xy3_can_words(spi);
}

/**
 * xy3_controller_setup() - set up the controller of a device for a head
 * @spi: the device; its mode is changed
 * @lines: returns the number of its data lines
 * @words: returns whether it gets scans as words
 *
 * If a requirement is not met, a message is logged.
 *
 * Return: 0; -EOPNOTSUPP if the controller has no plain transfers, or none with this chip select;
 * -EINVAL if it does not support the lines, the edge of the clock or the length of a transfer.
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
	if (xy3_defects_of(spi->controller) & XY3_DEFECT_GPIO && !spi_get_csgpiod(spi, 0))
		return dev_err_probe(dev, -EOPNOTSUPP,
				     "with this controller the chip select must be a GPIO: cs-gpios\n");
	if (xy3_defects_of(spi->controller) & XY3_DEFECT_CHANGE)
		return dev_err_probe(dev, -EOPNOTSUPP,
				     "the controller changes messages, which cannot be sent again\n");
	err = xy3_lines_wanted(spi, &wanted, &lanes);
	if (err)
		return err;
	spi->mode &= XY3_SPI_MODE_KEPT;
	spi->mode |= xy3_clock_mode(spi, inverted);
	if (wanted == 1 && xy3_can_cs_word(spi))
		spi->mode |= SPI_CS_WORD;
	spi->bits_per_word = 8;
	/* other work must not delay the next block to the controller */
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
