// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: messages, and time on the wires
 *
 * Messages are sent one at a time, at full speed or at the speed of the wire. In both cases their
 * time on the wire is computed. Between two messages a controller requires some time, the
 * turnaround. A longer time is a gap: the controller had no message when the last one ended, and
 * got the next one later.
 */

#include <linux/atomic.h>
#include <linux/cleanup.h>
#include <linux/delay.h>
#include <linux/kernel.h>
#include <linux/ktime.h>
#include <linux/log2.h>
#include <linux/math64.h>
#include <linux/minmax.h>
#include <linux/spi/spi.h>
#include <linux/string.h>
#include <linux/time64.h>

#include "sim.h"

/* Do not sleep for less; the time of the wire is counted nevertheless */
#define SIM_SLEEP_MIN_NS	(20 * NSEC_PER_USEC)

/* Default delay of the SPI core between two transfers */
#define SIM_CS_CHANGE_NS	(10 * NSEC_PER_USEC)

/* ---- time ---- */

static u64 sim_clocks_ns(u64 clocks, u32 speed)
{
	return div_u64(clocks * NSEC_PER_SEC, speed);
}

/* A message begins: check whether the wire had none before */
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

/* The delay of a transfer; the SPI core has a default for 0 */
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

/* Number of lanes used at the same time, with a word on each; otherwise words are sent singly */
static unsigned int sim_lanes(const struct xy3_sim *sim, const struct spi_transfer *transfer)
{
	if (!xy3_sim_has_lanes(sim) || transfer->multi_lane_mode != SPI_MULTI_LANE_MODE_STRIPE)
		return 1;
	return sim->config.lanes;
}

static void sim_send_lanes(struct xy3_sim *sim, const struct spi_transfer *transfer)
{
	unsigned int size = sim_word_size(transfer), lanes = sim->config.lanes;
	u32 words[XY3_SIM_LINES_MAX];

	for (unsigned int i = 0; i + lanes <= transfer->len / size; i += lanes) {
		for (unsigned int lane = 0; lane < lanes; lane++)
			words[lane] = sim_word(transfer, size, i + lane);
		xy3_sim_head_lanes(sim, words, lanes, transfer->bits_per_word);
	}
}

static void sim_send(struct xy3_sim *sim, const struct spi_transfer *transfer, bool cs_word,
		     bool active)
{
	unsigned int size = sim_word_size(transfer);
	unsigned int nbits = min(sim_nbits(transfer), sim->config.driven_lines);

	if (sim_lanes(sim, transfer) > 1) {
		sim_send_lanes(sim, transfer);
		return;
	}
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

/* Transfers that the hardware does not support */
static int sim_check(const struct xy3_sim *sim, const struct spi_transfer *transfer)
{
	if (sim->config.max_transfer && transfer->len > sim->config.max_transfer)
		return -EMSGSIZE;
	if (!transfer->len)
		return 0;
	if (!transfer->speed_hz || sim_nbits(transfer) > sim->config.lines)
		return -EINVAL;
	/* several lines can only send: there is no data to read */
	if (transfer->rx_buf && (transfer->rx_nbits != SPI_NBITS_SINGLE ||
				 sim_nbits(transfer) != SPI_NBITS_SINGLE))
		return -EINVAL;
	return 0;
}

/* The actual clock for the requested one */
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
		return max(highest / roundup_pow_of_two(divider), 1UL);
	case XY3_SIM_CLOCK_SETUP:
		return READ_ONCE(sim->setup_hz);
	case XY3_SIM_CLOCK_FIXED:
		return highest;
	}
	return asked;
}

/* Drivers that ignore the clock of a transfer do not report the actual one, either */
static bool sim_clock_known(const struct xy3_sim *sim)
{
	return sim->config.clock != XY3_SIM_CLOCK_SETUP && sim->config.clock != XY3_SIM_CLOCK_FIXED;
}

static void sim_transfer(struct xy3_sim *sim, struct spi_device *spi,
			 struct spi_transfer *transfer, bool last)
{
	struct xy3_sim_bus *bus = &sim->bus;
	unsigned int words = transfer->len / sim_word_size(transfer);
	u64 clocks = div_u64((u64)words * transfer->bits_per_word,
			     sim_nbits(transfer) * sim_lanes(sim, transfer));
	bool cs_word = spi->mode & SPI_CS_WORD;
	bool select = !(spi->mode & SPI_NO_CS) && !transfer->cs_off;
	u32 speed = clocks ? sim_clock(sim, transfer->speed_hz) : 0;
	u64 ns = clocks ? sim_clocks_ns(clocks, speed) : 0;
	u64 delay = sim_delay_ns(&transfer->delay, transfer, 0);

	if (!cs_word)
		xy3_sim_head_select(sim, select);
	sim_send(sim, transfer, cs_word, select);
	/* the head sends nothing on this bus */
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

/* The mode that the controller uses for a mode */
static u32 sim_mode_done(const struct xy3_sim *sim, u32 mode)
{
	if (sim->config.modes == XY3_SIM_MODES_CLAIMED && mode != SPI_MODE_3)
		return SPI_MODE_0;
	return mode;
}

/*
 * A head samples data when CLK falls. In modes 1 and 2 they are valid then, in 0 and 3 they change;
 * with the pair crossed it is the opposite.
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

/* Levels of floating lines: a gate has a pull-down, as the manual requires */
static u8 sim_pulled_down(struct xy3_sim *sim)
{
	return sim->head.gate < 0 ? 0 : BIT(sim->head.gate);
}

/**
 * xy3_sim_idle() - set the levels of the data lines while no message is being sent
 * @sim: the head; its lock is held. The chip select is not active.
 */
void xy3_sim_idle(struct xy3_sim *sim)
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

/* Duration of the fault, in ms */
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

/**
 * xy3_sim_message() - send a message
 * @controller: the controller
 * @message: the message, with its result on return
 *
 * Return: 0.
 */
int xy3_sim_message(struct spi_controller *controller, struct spi_message *message)
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
		xy3_sim_idle(sim);
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
	/* an error is in the message; the SPI core does not have to report it again */
	spi_finalize_current_message(controller);
	return 0;
}
