// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: the SPI controller, and the device on it
 */

#include <linux/atomic.h>
#include <linux/bug.h>
#include <linux/cleanup.h>
#include <linux/delay.h>
#include <linux/device.h>
#include <linux/kernel.h>
#include <linux/platform_device.h>
#include <linux/spi/spi-mem.h>
#include <linux/spi/spi.h>
#include <linux/string.h>
#include <linux/workqueue.h>

#include "sim.h"

/* the device as described by firmware; faults are detected on the side of the head */
#define SIM_MODE		SPI_MODE_1

/* ---- features of the controller ---- */

/* A driver of another device on the bus has locked it */
static void sim_lock_bus(struct work_struct *work)
{
	struct xy3_sim *sim = container_of(work, struct xy3_sim, bus_lock);

	spi_bus_lock(sim->controller);
	msleep(READ_ONCE(sim->bus_lock_ms));
	spi_bus_unlock(sim->controller);
}

static void sim_end_lock(void *data)
{
	struct xy3_sim *sim = data;

	cancel_work_sync(&sim->bus_lock);
}

static size_t sim_max_transfer(struct spi_device *spi)
{
	struct xy3_sim *sim = spi_controller_get_devdata(spi->controller);

	return sim->config.max_transfer ?: SIZE_MAX;
}

static size_t sim_max_message(struct spi_device *spi)
{
	struct xy3_sim *sim = spi_controller_get_devdata(spi->controller);

	return sim->config.max_message ?: SIZE_MAX;
}

static int sim_setup(struct spi_device *spi)
{
	struct xy3_sim *sim = spi_controller_get_devdata(spi->controller);
	u32 mode = spi->mode & SPI_MODE_X_MASK;

	if (sim->config.modes == XY3_SIM_MODES_0_3 && mode != SPI_MODE_0 && mode != SPI_MODE_3)
		return -EINVAL;
	WRITE_ONCE(sim->setup_hz, spi->max_speed_hz);
	/* as in the SPI core for a devicetree; this device is described by a software node */
	if (xy3_sim_has_lanes(sim) && sim->config.lanes <= SPI_DEVICE_DATA_LANE_CNT_MAX)
		spi->num_tx_lanes = sim->config.lanes;
	return 0;
}

/* Like spi-axi-spi-engine, which compiles each message to a program and may wait for memory */
static int sim_optimize(struct spi_message *message)
{
	struct xy3_sim *sim = spi_controller_get_devdata(message->spi->controller);

	might_sleep();
	fsleep(sim->config.prepare_us);
	atomic_inc(&sim->prepared);
	return 0;
}

static int sim_unoptimize(struct spi_message *message)
{
	struct xy3_sim *sim = spi_controller_get_devdata(message->spi->controller);

	atomic_dec(&sim->prepared);
	return 0;
}

static void sim_check_prepared(void *data)
{
	struct xy3_sim *sim = data;
	int left = atomic_read(&sim->prepared);

	WARN(left, "xy3-sim: %d messages were prepared and never released\n", left);
}

/* A controller for flash memory supports nothing else */
static int sim_flash_operation(struct spi_mem *memory, const struct spi_mem_op *operation)
{
	return -EOPNOTSUPP;
}

static const struct spi_controller_mem_ops sim_flash_operations = {
	.exec_op = sim_flash_operation,
};

/* ---- the controller and its device ---- */

static u32 sim_line_modes(unsigned int lines)
{
	u32 modes = 0;

	if (lines >= 2)
		modes |= SPI_TX_DUAL;
	if (lines >= 4)
		modes |= SPI_TX_QUAD;
	if (lines >= 8)
		modes |= SPI_TX_OCTAL;
	return modes;
}

static u32 sim_device_mode(unsigned int lines)
{
	switch (lines) {
	case 2:
		return SPI_TX_DUAL;
	case 4:
		return SPI_TX_QUAD;
	case 8:
		return SPI_TX_OCTAL;
	}
	return 0;
}

static void sim_remove_node(void *data)
{
	struct xy3_sim *sim = data;

	software_node_unregister(&sim->swnode);
}

/*
 * The SPI core would register the node itself, and drop it before the driver of the device is
 * unbound; devices created by the driver also refer to it.
 */
static int sim_add_node(struct xy3_sim *sim)
{
	unsigned int lines = sim->config.lanes ?: sim->config.lines;
	int err;

	for (unsigned int i = 0; i < lines; i++)
		sim->line_map[i] = xy3_sim_signal_name(sim->config.signal[i]);
	sim->properties[0] = PROPERTY_ENTRY_STRING_ARRAY_LEN("lasia,line-map", sim->line_map,
							     lines);
	sim->properties[1] = PROPERTY_ENTRY_U32("spi-tx-bus-width", sim->config.device_lines);
	if (sim->config.lanes) {
		for (unsigned int i = 0; i < sim->config.lanes; i++)
			sim->lane_widths[i] = 1;
		sim->properties[1] = PROPERTY_ENTRY_U32_ARRAY_LEN("spi-tx-bus-width",
								  sim->lane_widths,
								  sim->config.lanes);
	}
	if (sim->config.clock_inverted)
		sim->properties[2] = PROPERTY_ENTRY_BOOL("lasia,clock-inverted");
	snprintf(sim->node_name, sizeof(sim->node_name), "xy3-sim.%u", sim->number);
	sim->swnode.name = sim->node_name;
	sim->swnode.properties = sim->properties;
	err = software_node_register(&sim->swnode);
	if (err)
		return err;
	return devm_add_action_or_reset(&sim->pdev->dev, sim_remove_node, sim);
}

static int sim_add_device(struct xy3_sim *sim)
{
	struct spi_board_info info = {
		.max_speed_hz = sim->config.max_speed_hz,
		.mode = SIM_MODE,
		.swnode = &sim->swnode,
	};
	struct spi_device *spi;

	if (!sim->config.lanes)
		info.mode |= sim_device_mode(sim->config.device_lines);
	if (sim->config.modes == XY3_SIM_MODES_0 || sim->config.modes == XY3_SIM_MODES_0_3)
		info.mode &= ~SPI_MODE_X_MASK;
	if (sim->config.lsb_first)
		info.mode |= SPI_LSB_FIRST;
	/* a scan of one line is a word, and in spidev this cannot be selected */
	if (sim->config.cs_word && sim->config.device_lines == 1)
		info.mode |= SPI_CS_WORD;
	/* spidev does not accept its own name for a device; this is in its table in all kernels */
	strscpy(info.modalias, strcmp(sim->config.modalias, "spidev") ? sim->config.modalias :
		"dh2228fv", sizeof(info.modalias));
	spi = spi_new_device(sim->controller, &info);
	if (!spi)
		return -ENODEV;
	strscpy(sim->spi_name, dev_name(&spi->dev), sizeof(sim->spi_name));
	return 0;
}

/**
 * xy3_sim_spi_add() - create the controller and the device on it
 * @sim: the head
 *
 * Both are removed with the platform device.
 *
 * Return: 0 or an error.
 */
int xy3_sim_spi_add(struct xy3_sim *sim)
{
	struct device *dev = &sim->pdev->dev;
	struct spi_controller *controller;
	int err;

	err = sim_add_node(sim);
	if (err)
		return err;
	controller = devm_spi_alloc_host(dev, 0);
	if (!controller)
		return -ENOMEM;
	sim->controller = controller;
	INIT_WORK(&sim->bus_lock, sim_lock_bus);
	scoped_guard(mutex, &sim->lock)
		xy3_sim_idle(sim);
	spi_controller_set_devdata(controller, sim);
	controller->bus_num = -1;
	controller->num_chipselect = 1;
	controller->min_speed_hz = sim->config.min_speed_hz;
	controller->max_speed_hz = sim->config.max_speed_hz;
	controller->mode_bits = SPI_NO_CS | SPI_LSB_FIRST | sim_line_modes(sim->config.lines);
	if (sim->config.modes != XY3_SIM_MODES_0)
		controller->mode_bits |= SPI_CPOL | SPI_CPHA;
	controller->bits_per_word_mask = SPI_BPW_MASK(8);
	if (sim->config.cs_word)
		controller->mode_bits |= SPI_CS_WORD;
	if (sim->config.cs_word || sim->config.lanes) {
		controller->bits_per_word_mask |= SPI_BPW_MASK(16);
		if (sim->config.word_bits == 32)
			controller->bits_per_word_mask |= SPI_BPW_MASK(24) | SPI_BPW_MASK(32);
	}
	controller->setup = sim_setup;
	if (sim->config.prepare_us) {
		controller->optimize_message = sim_optimize;
		controller->unoptimize_message = sim_unoptimize;
	}
	controller->max_transfer_size = sim_max_transfer;
	controller->max_message_size = sim_max_message;
	if (sim->config.flash_only)
		controller->mem_ops = &sim_flash_operations;
	else
		controller->transfer_one_message = xy3_sim_message;
	err = devm_add_action(dev, sim_check_prepared, sim);
	if (err)
		return err;
	err = devm_spi_register_controller(dev, controller);
	if (err)
		return dev_err_probe(dev, err, "no SPI controller\n");
	err = devm_add_action_or_reset(dev, sim_end_lock, sim);
	if (err)
		return err;
	err = sim_add_device(sim);
	if (err)
		return dev_err_probe(dev, err, "no SPI device\n");
	return 0;
}
