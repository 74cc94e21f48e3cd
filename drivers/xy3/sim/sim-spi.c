// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: the SPI controller, and time on its wires
 *
 * It takes a message at a time, as fast as it can or as slowly as the wire does. In both cases it
 * knows how long the wire is busy with it. To go from one message to the next takes it a time of
 * its own, the turnaround. There is a gap beyond that when it had no message as the last one ended,
 * and the next one came later.
 */

#include <linux/atomic.h>
#include <linux/bug.h>
#include <linux/cleanup.h>
#include <linux/delay.h>
#include <linux/device.h>
#include <linux/kernel.h>
#include <linux/ktime.h>
#include <linux/log2.h>
#include <linux/math64.h>
#include <linux/minmax.h>
#include <linux/platform_device.h>
#include <linux/spi/spi-mem.h>
#include <linux/spi/spi.h>
#include <linux/string.h>
#include <linux/time64.h>
#include <linux/workqueue.h>

#include "sim.h"

/* It is not worth to sleep for less; the wire's clock goes on all the same */
#define SIM_SLEEP_MIN_NS	(20 * NSEC_PER_USEC)

/* What the SPI core waits between two transfers when nothing else is said */
#define SIM_CS_CHANGE_NS	(10 * NSEC_PER_USEC)

/* the device as firmware describes it; what is right is judged at the head's side of the wires */
#define SIM_MODE		SPI_MODE_1

/* ---- time ---- */

static u64 sim_clocks_ns(u64 clocks, u32 speed)
{
	return div_u64(clocks * NSEC_PER_SEC, speed);
}

/* A message begins: has the wire been without one? */
static void sim_bus_begin(struct xy3_sim_bus *bus, u64 turnaround)
{
	u64 now = ktime_get_ns();
	u64 gap = 0;

	if (!bus->started) {
		bus->started = true;
		bus->until = now;
		return;
	}
	bus->until += turnaround;
	bus->turnaround_ns += turnaround;
	if (bus->dry && now > bus->until) {
		gap = now - bus->until;
		bus->gaps++;
		bus->gap_ns += gap;
		bus->longest_gap_ns = max(bus->longest_gap_ns, gap);
		bus->until = now;
	}
	bus->longest_silence_ns = max(bus->longest_silence_ns, turnaround + gap);
}

/* The time that is said in a transfer, where the SPI core has one of its own for nothing */
static u64 sim_delay_ns(struct spi_delay *delay, struct spi_transfer *transfer, u64 otherwise)
{
	int ns;

	if (!delay->value)
		return delay->unit == SPI_DELAY_UNIT_USECS ? otherwise : 0;
	ns = spi_delay_to_ns(delay, transfer);
	return ns > 0 ? ns : 0;
}

static void sim_wait(u64 until)
{
	u64 now = ktime_get_ns();
	u64 us;

	if (until < now + SIM_SLEEP_MIN_NS)
		return;
	us = div_u64(until - now, NSEC_PER_USEC);
	usleep_range(us, us + 10);
}

/* ---- transfers ---- */

static unsigned int sim_word_size(const struct spi_transfer *transfer)
{
	return transfer->bits_per_word <= 8 ? 1 : transfer->bits_per_word <= 16 ? 2 : 4;
}

static u32 sim_word(const struct spi_transfer *transfer, unsigned int size, unsigned int at)
{
	const void *data = transfer->tx_buf;

	if (!data)
		return 0;
	switch (size) {
	case 1:
		return ((const u8 *)data)[at];
	case 2:
		return ((const u16 *)data)[at];
	default:
		return ((const u32 *)data)[at];
	}
}

static unsigned int sim_nbits(const struct spi_transfer *transfer)
{
	return transfer->tx_buf ? transfer->tx_nbits : SPI_NBITS_SINGLE;
}

static void sim_send(struct xy3_sim *sim, const struct spi_transfer *transfer, bool cs_word,
		     bool active)
{
	unsigned int size = sim_word_size(transfer);
	unsigned int nbits = min(sim_nbits(transfer), sim->config.driven_lines);

	if (size == 1 && !cs_word) {
		xy3_sim_head_bytes(sim, transfer->tx_buf, transfer->len, nbits);
		return;
	}
	for (unsigned int i = 0; i < transfer->len / size; i++) {
		if (cs_word)
			xy3_sim_head_select(sim, active);
		xy3_sim_head_word(sim, sim_word(transfer, size, i), transfer->bits_per_word,
				  nbits);
		if (cs_word)
			xy3_sim_head_select(sim, false);
	}
}

/* What hardware cannot do */
static int sim_check(const struct xy3_sim *sim, const struct spi_transfer *transfer)
{
	if (sim->config.max_transfer && transfer->len > sim->config.max_transfer)
		return -EMSGSIZE;
	if (!transfer->len)
		return 0;
	if (!transfer->speed_hz || sim_nbits(transfer) > sim->config.lines)
		return -EINVAL;
	/* several lines go one way; on the others nobody speaks */
	if (transfer->rx_buf && (transfer->rx_nbits != SPI_NBITS_SINGLE ||
				 sim_nbits(transfer) != SPI_NBITS_SINGLE))
		return -EINVAL;
	return 0;
}

/* The clock that there is for the one that is asked for */
static u32 sim_clock(const struct xy3_sim *sim, u32 asked)
{
	u32 highest = sim->config.max_speed_hz;
	u32 divider = DIV_ROUND_UP(highest, asked);

	switch ((enum xy3_sim_clock)sim->config.clock) {
	case XY3_SIM_CLOCK_ANY:
		return asked;
	case XY3_SIM_CLOCK_DIVIDED:
		return highest / divider;
	case XY3_SIM_CLOCK_HALVED:
		return highest / roundup_pow_of_two(divider);
	case XY3_SIM_CLOCK_SETUP:
		return READ_ONCE(sim->setup_hz);
	case XY3_SIM_CLOCK_FIXED:
		return highest;
	}
	return asked;
}

/* Drivers that do not look at a transfer's clock do not report the one that it had, either */
static bool sim_clock_known(const struct xy3_sim *sim)
{
	return sim->config.clock != XY3_SIM_CLOCK_SETUP && sim->config.clock != XY3_SIM_CLOCK_FIXED;
}

static void sim_transfer(struct xy3_sim *sim, struct spi_device *spi,
			 struct spi_transfer *transfer, bool last)
{
	struct xy3_sim_bus *bus = &sim->bus;
	unsigned int words = transfer->len / sim_word_size(transfer);
	u64 clocks = div_u64((u64)words * transfer->bits_per_word, sim_nbits(transfer));
	bool cs_word = spi->mode & SPI_CS_WORD;
	bool select = !(spi->mode & SPI_NO_CS) && !transfer->cs_off;
	u32 speed = clocks ? sim_clock(sim, transfer->speed_hz) : 0;
	u64 ns = clocks ? sim_clocks_ns(clocks, speed) : 0;
	u64 delay = sim_delay_ns(&transfer->delay, transfer, 0);

	if (!cs_word)
		xy3_sim_head_select(sim, select);
	sim_send(sim, transfer, cs_word, select);
	/* the head says nothing on this bus */
	if (transfer->rx_buf)
		memset(transfer->rx_buf, 0xff, transfer->len);

	delay += words * sim_delay_ns(&transfer->word_delay, transfer, 0);
	if (transfer->cs_change != last)
		xy3_sim_head_select(sim, false);
	if (transfer->cs_change && !last)
		delay += sim_delay_ns(&transfer->cs_change_delay, transfer, SIM_CS_CHANGE_NS);

	if (sim_clock_known(sim))
		transfer->effective_speed_hz = speed;
	bus->transfers++;
	bus->clocks += clocks;
	bus->busy_ns += ns;
	bus->delay_ns += delay;
	bus->until += ns + delay;
}

/* ---- messages ---- */

static bool sim_message_fails(struct xy3_sim *sim)
{
	unsigned int every = xy3_sim_fault_value(sim, XY3_SIM_SPI_ERROR_EVERY);
	unsigned int in = xy3_sim_fault_value(sim, XY3_SIM_SPI_ERROR_IN);

	if (in && !atomic_dec_return(&sim->fault[XY3_SIM_SPI_ERROR_IN])) {
		atomic_inc(&sim->fault_count[XY3_SIM_SPI_ERROR_IN]);
		return true;
	}
	if (!every || ++sim->message < every)
		return false;
	sim->message = 0;
	atomic_inc(&sim->fault_count[XY3_SIM_SPI_ERROR_EVERY]);
	return true;
}

/* What the controller does for a mode */
static u32 sim_mode_done(const struct xy3_sim *sim, u32 mode)
{
	if (sim->config.modes == XY3_SIM_MODES_CLAIMED && mode != SPI_MODE_3)
		return SPI_MODE_0;
	return mode;
}

/*
 * A head takes data when CLK falls. In modes 1 and 2 they are valid then, in 0 and 3 they change;
 * with the pair crossed it is the other way round.
 */
static bool sim_wrong_edge(const struct xy3_sim *sim, u32 mode)
{
	u32 done = sim_mode_done(sim, mode & SPI_MODE_X_MASK);
	bool falling = done == SPI_MODE_1 || done == SPI_MODE_2;

	return falling == sim->config.clock_inverted || mode & SPI_LSB_FIRST;
}

static int sim_transfers(struct xy3_sim *sim, struct spi_message *message)
{
	struct spi_transfer *transfer;
	int err;

	if (sim_message_fails(sim))
		return -EIO;
	if (sim->config.max_message && message->frame_length > sim->config.max_message)
		return -EMSGSIZE;
	list_for_each_entry(transfer, &message->transfers, transfer_list) {
		err = sim_check(sim, transfer);
		if (err)
			return err;
	}
	sim->head.wrong_mode = sim_wrong_edge(sim, message->spi->mode);
	list_for_each_entry(transfer, &message->transfers, transfer_list) {
		sim_transfer(sim, message->spi, transfer,
			     list_is_last(&transfer->transfer_list, &message->transfers));
		message->actual_length += transfer->len;
	}
	return 0;
}

/* Where the lines float: a gate has a pull-down, as the manual requires */
static u8 sim_pulled_down(struct xy3_sim *sim)
{
	return sim->head.gate < 0 ? 0 : BIT(sim->head.gate);
}

/* The message is over: what becomes of the data lines? The chip select is not active. */
static void sim_idle(struct xy3_sim *sim)
{
	switch (sim->config.idle) {
	case XY3_SIM_IDLE_KEEP:
		return;
	case XY3_SIM_IDLE_LOW:
		return xy3_sim_head_idle(sim, 0);
	case XY3_SIM_IDLE_HIGH:
		return xy3_sim_head_idle(sim, U8_MAX);
	case XY3_SIM_IDLE_FLOAT:
		return xy3_sim_head_idle(sim, xy3_sim_random(sim, 256) & ~sim_pulled_down(sim));
	}
}

/* Time that the fault takes, in ms */
static unsigned int sim_stall(struct xy3_sim *sim)
{
	int ms = atomic_xchg(&sim->fault[XY3_SIM_SPI_STALL_MS], 0);

	if (ms <= 0)
		return 0;
	atomic_inc(&sim->fault_count[XY3_SIM_SPI_STALL_MS]);
	sim->bus.until += (u64)ms * NSEC_PER_MSEC;
	sim->bus.stalled_ns += (u64)ms * NSEC_PER_MSEC;
	return ms;
}

static int sim_message(struct spi_controller *controller, struct spi_message *message)
{
	struct xy3_sim *sim = spi_controller_get_devdata(controller);
	unsigned int stall;
	u64 until = 0;
	bool dry;

	scoped_guard(mutex, &sim->lock) {
		sim_bus_begin(&sim->bus, sim->config.turnaround_us * NSEC_PER_USEC);
		stall = sim_stall(sim);
		message->status = sim_transfers(sim, message);
		if (message->status) {
			xy3_sim_head_select(sim, false);
			sim->bus.failed_messages++;
		} else {
			sim->bus.messages++;
		}
		sim_idle(sim);
		if (sim->realtime)
			until = sim->bus.until;
	}
	if (stall)
		msleep(stall);
	sim_wait(until);

	scoped_guard(spinlock_irqsave, &controller->queue_lock)
		dry = list_empty(&controller->queue);
	scoped_guard(mutex, &sim->lock)
		sim->bus.dry = dry;
	/* an error is in the message; the SPI core need not say it once more */
	spi_finalize_current_message(controller);
	return 0;
}

/* A driver of another device on the bus has it for itself */
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
	return 0;
}

/* Like spi-axi-spi-engine, which makes a program of each message, in memory that it may wait for */
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

/* A controller that has been made for flash memory takes nothing else */
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
 * The SPI core would register the node by itself, and drop it before the device's driver has gone;
 * the devices that the driver has made have it as theirs, too.
 */
static int sim_add_node(struct xy3_sim *sim)
{
	int err;

	for (unsigned int i = 0; i < sim->config.lines; i++)
		sim->line_map[i] = xy3_sim_signal_name(sim->config.signal[i]);
	sim->properties[0] = PROPERTY_ENTRY_STRING_ARRAY_LEN("lasia,line-map", sim->line_map,
							     sim->config.lines);
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
		.mode = SIM_MODE | sim_device_mode(sim->config.device_lines),
		.swnode = &sim->swnode,
	};
	struct spi_device *spi;

	if (sim->config.modes == XY3_SIM_MODES_0 || sim->config.modes == XY3_SIM_MODES_0_3)
		info.mode &= ~SPI_MODE_X_MASK;
	if (sim->config.lsb_first)
		info.mode |= SPI_LSB_FIRST;
	/* a scan of one line is a word, and spidev does not let anybody choose */
	if (sim->config.cs_word && sim->config.device_lines == 1)
		info.mode |= SPI_CS_WORD;
	/* spidev takes no device by its own name; this is one of its table in all kernels */
	strscpy(info.modalias, strcmp(sim->config.modalias, "spidev") ? sim->config.modalias :
		"dh2228fv", sizeof(info.modalias));
	spi = spi_new_device(sim->controller, &info);
	if (!spi)
		return -ENODEV;
	strscpy(sim->spi_name, dev_name(&spi->dev), sizeof(sim->spi_name));
	return 0;
}

/**
 * xy3_sim_spi_add() - make the controller and the device on it
 * @sim: the head
 *
 * Both go with the platform device.
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
		sim_idle(sim);
	spi_controller_set_devdata(controller, sim);
	controller->bus_num = -1;
	controller->num_chipselect = 1;
	controller->min_speed_hz = sim->config.min_speed_hz;
	controller->max_speed_hz = sim->config.max_speed_hz;
	controller->mode_bits = SPI_NO_CS | SPI_LSB_FIRST | sim_line_modes(sim->config.lines);
	if (sim->config.modes != XY3_SIM_MODES_0)
		controller->mode_bits |= SPI_CPOL | SPI_CPHA;
	controller->bits_per_word_mask = SPI_BPW_MASK(8);
	if (sim->config.cs_word) {
		controller->mode_bits |= SPI_CS_WORD;
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
		controller->transfer_one_message = sim_message;
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
