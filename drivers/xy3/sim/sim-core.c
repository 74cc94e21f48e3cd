// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: module, parameters, devices
 *
 * Each head is a platform device with an SPI controller, an SPI device on it, and a tty.
 */

#include <linux/cleanup.h>
#include <linux/device.h>
#include <linux/err.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/slab.h>
#include <linux/string.h>
#include <linux/time64.h>

#include "sim.h"

#define SIM_NAME		"xy3-sim"
#define SIM_RATE_DEFAULT	115200

static unsigned int heads = 1;
module_param(heads, uint, 0444);
MODULE_PARM_DESC(heads, "Number of heads, 1 to 4 (default: 1)");

static unsigned int lines = 1;
module_param(lines, uint, 0444);
MODULE_PARM_DESC(lines, "Data lines of the SPI controller: 1, 2, 4 or 8 (default: 1)");

static unsigned int device_lines;
module_param(device_lines, uint, 0444);
MODULE_PARM_DESC(device_lines, "Data lines of the SPI device (default: as the controller's)");

static char *framing = "cs";
module_param(framing, charp, 0444);
MODULE_PARM_DESC(framing, "What SYNC is: cs, the chip select, or line, a data line (default: cs)");

static char *signals;
module_param(signals, charp, 0444);
MODULE_PARM_DESC(signals, "What lines carry from IO0 on, x y z u w sync or -, with commas between");

static bool cs_word;
module_param(cs_word, bool, 0444);
MODULE_PARM_DESC(cs_word, "The controller moves the chip select after each word (default: no)");

static unsigned int max_speed_hz = 50000000;
module_param(max_speed_hz, uint, 0444);
MODULE_PARM_DESC(max_speed_hz, "Highest clock of the SPI controller (default: 50000000)");

static unsigned int min_speed_hz;
module_param(min_speed_hz, uint, 0444);
MODULE_PARM_DESC(min_speed_hz, "Lowest clock of the SPI controller (default: 0, any)");

static unsigned int max_transfer;
module_param(max_transfer, uint, 0444);
MODULE_PARM_DESC(max_transfer, "Longest SPI transfer in bytes (default: 0, any)");

static char *modes = "all";
module_param(modes, charp, 0444);
MODULE_PARM_DESC(modes, "SPI modes: all; 0,3; 0; or claimed: takes all, does 0 or 3 (default: all)");

static bool clock_inverted;
module_param(clock_inverted, bool, 0444);
MODULE_PARM_DESC(clock_inverted, "The pair of CLK is crossed, as the device is described (default: no)");

static unsigned int word_bits = 32;
module_param(word_bits, uint, 0444);
MODULE_PARM_DESC(word_bits, "Longest word that goes with cs_word: 16 or 32 (default: 32)");

static unsigned int driven_lines;
module_param(driven_lines, uint, 0444);
MODULE_PARM_DESC(driven_lines, "Data lines that transfers really use (default: as many as lines)");

static bool flash_only;
module_param(flash_only, bool, 0444);
MODULE_PARM_DESC(flash_only, "The controller has flash operations, no transfers (default: no)");

static bool lsb_first;
module_param(lsb_first, bool, 0444);
MODULE_PARM_DESC(lsb_first, "The device is described with its lowest bit first (default: no)");

static unsigned int lanes;
module_param(lanes, uint, 0444);
MODULE_PARM_DESC(lanes, "Number of lanes, of one line each, that firmware describes (default: 0)");

static char *driver = SIM_NAME;
module_param(driver, charp, 0444);
MODULE_PARM_DESC(driver, "Name of the controller's driver (default: " SIM_NAME ")");

static char *modalias = "xy3-100";
module_param(modalias, charp, 0444);
MODULE_PARM_DESC(modalias, "Name of the SPI device: xy3-100, spidev, or another (default: xy3-100)");

static bool realtime;
module_param(realtime, bool, 0444);
MODULE_PARM_DESC(realtime, "Transfers take as long as on a wire (default: no)");

static char *idle = "float";
module_param(idle, charp, 0444);
MODULE_PARM_DESC(idle, "Data lines between messages: keep, low, high or float (default: float)");

static unsigned int turnaround_us = 20;
module_param(turnaround_us, uint, 0444);
MODULE_PARM_DESC(turnaround_us, "Time between two messages that follow one another (default: 20)");

static unsigned int uart_max = 4000000;
module_param(uart_max, uint, 0444);
MODULE_PARM_DESC(uart_max, "Highest speed of the UART in bit/s (default: 4000000)");

static unsigned int interval_ms = 1000;
module_param(interval_ms, uint, 0444);
MODULE_PARM_DESC(interval_ms, "Time between rounds of telemetry, 0 for none (default: 1000)");

static unsigned int sync_ms = 100;
module_param(sync_ms, uint, 0444);
MODULE_PARM_DESC(sync_ms, "Time between sync packets, 0 for none (default: 100)");

static unsigned int seed = 1;
module_param(seed, uint, 0444);
MODULE_PARM_DESC(seed, "The same seed gives the same faults (default: 1)");

static struct xy3_sim_config sim_config;
static struct platform_device *sim_devices[XY3_SIM_HEADS_MAX];

/* ---- signals ---- */

static const char * const sim_signal_names[] = {
	"x", "y", "z", "u", "w",
	[XY3_SIM_SYNC] = "sync",
	[XY3_SIM_GATE] = "gate",
	[XY3_SIM_NONE] = "-",
};

/**
 * xy3_sim_signal_name() - name of a signal
 * @signal: enum xy3_sim_signal
 *
 * Return: the name.
 */
const char *xy3_sim_signal_name(u8 signal)
{
	return sim_signal_names[signal];
}

static int sim_find_signal(const char *name, u8 *signal)
{
	for (unsigned int i = 0; i < ARRAY_SIZE(sim_signal_names); i++) {
		if (!strcasecmp(name, sim_signal_names[i])) {
			*signal = i;
			return 0;
		}
	}
	return -EINVAL;
}

/**
 * xy3_sim_parse_signals() - what lines carry
 * @text: their names, from IO0 on, with blanks or commas between
 * @lines: how many lines there are; those without a name carry nothing
 * @signal: the signals
 *
 * Return: 0; -EINVAL when there are too many, or a name is unknown or comes twice, or X is missing.
 */
int xy3_sim_parse_signals(const char *text, unsigned int lines, u8 *signal)
{
	char *copy __free(kfree) = kstrdup(text, GFP_KERNEL);
	u32 seen = 0;
	unsigned int count = 0;
	char *rest = copy, *word;

	if (!copy)
		return -ENOMEM;
	memset(signal, XY3_SIM_NONE, XY3_SIM_LINES_MAX);
	while ((word = strsep(&rest, " ,\t\n"))) {
		if (!*word)
			continue;
		if (count == lines || sim_find_signal(word, &signal[count]))
			return -EINVAL;
		if (signal[count] != XY3_SIM_NONE && seen & BIT(signal[count]))
			return -EINVAL;
		seen |= BIT(signal[count++]);
	}
	return seen & BIT(XY3_SIM_X) ? 0 : -EINVAL;
}

static const char *sim_default_signals(unsigned int lines, bool line)
{
	switch (lines) {
	case 1:
		return line ? NULL : "x";
	case 2:
		return line ? NULL : "x y";
	case 4:
		return line ? "sync x y z" : "x y z u";
	case 8:
		return line ? "sync x y z u w" : "x y z u w";
	}
	return NULL;
}

/* ---- a head ---- */

/**
 * xy3_sim_reset_counts() - count from 0 again, and keep no scans any more
 * @sim: the head; its lock is held
 */
void xy3_sim_reset_counts(struct xy3_sim *sim)
{
	struct xy3_sim_head *head = &sim->head;
	struct xy3_sim_uart *uart = &sim->uart;

	for (unsigned int i = 0; i < XY3_SIM_AXES; i++) {
		struct xy3_sim_axis *axis = &head->axis[i];

		*axis = (struct xy3_sim_axis) {
			.line = axis->line, .bits = axis->bits, .code = axis->code,
		};
	}
	head->scans = 0;
	head->short_gaps = 0;
	head->stalled_frames = 0;
	head->stray_clocks = 0;
	head->gate_scans = 0;
	head->gate_torn = 0;
	head->gate_commands = 0;
	head->commands = 0;
	head->unknown_commands = 0;
	sim->bus = (struct xy3_sim_bus) { };
	uart->openings = 0;
	uart->packets = 0;
	uart->bytes = 0;
	uart->damaged_packets = 0;
	uart->garbled_packets = 0;
	uart->silenced_packets = 0;
	uart->held_back = 0;
	uart->lost_bytes = 0;
	atomic64_set(&uart->written_bytes, 0);
	for (unsigned int i = 0; i < XY3_SIM_FAULTS; i++)
		atomic_set(&sim->fault_count[i], 0);
	sim->frames = 0;
	sim->message = 0;
	xy3_sim_record_start(sim, 0, false);
}

/**
 * xy3_sim_power_cycle() - the head loses what it was told, and its counts
 * @sim: the head; its lock is held
 */
void xy3_sim_power_cycle(struct xy3_sim *sim)
{
	struct xy3_sim_head *head = &sim->head;

	xy3_sim_reset_counts(sim);
	for (unsigned int i = 0; i < XY3_SIM_AXES; i++) {
		head->axis[i].bits = 0;
		head->axis[i].code = 0;
	}
	head->inside = false;
	head->stalled = false;
	head->clocks = 0;
	head->gap = XY3_SIM_GAP_CLOCKS;
	head->autocalib = 0;
	head->temp_comp = 0;
	head->calibrated = 0;
	head->referenced = 0;
	head->rate = SIM_RATE_DEFAULT;
	xy3_sim_telemetry_soon(sim);
}

static void sim_init(struct xy3_sim *sim)
{
	const struct xy3_sim_config *config = sim->config;

	mutex_init(&sim->lock);
	sim->realtime = config->realtime;
	prandom_seed_state(&sim->random, seed + sim->number);
	xy3_sim_head_wire(sim, config->lines, config->signal);
	sim->head.rate = SIM_RATE_DEFAULT;
	xy3_sim_telemetry_init(sim);
}

static int sim_probe(struct platform_device *pdev)
{
	struct device *dev = &pdev->dev;
	struct xy3_sim *sim;
	int err;

	sim = kzalloc(sizeof(*sim), GFP_KERNEL);
	if (!sim)
		return -ENOMEM;
	sim->pdev = pdev;
	sim->number = pdev->id;
	sim->config = &sim_config;
	sim_init(sim);

	/* from here on the tty's port is what frees it */
	err = xy3_sim_uart_add(sim);
	if (err)
		return dev_err_probe(dev, err, "no tty\n");
	err = devm_add_action_or_reset(dev, xy3_sim_uart_remove, sim);
	if (err)
		return err;
	err = xy3_sim_debugfs_add(sim);
	if (err)
		return err;
	/* last, as its driver may send something at once */
	err = xy3_sim_spi_add(sim);
	if (!err)
		platform_set_drvdata(pdev, sim);
	return err;
}

static struct platform_driver sim_driver = {
	.driver = {
		.name = SIM_NAME,
	},
	.probe = sim_probe,
};

/* ---- the module ---- */

static bool sim_lines_good(unsigned int count)
{
	return count == 1 || count == 2 || count == 4 || count == 8;
}

static const char * const sim_mode_names[] = {
	[XY3_SIM_MODES_ALL] = "all",
	[XY3_SIM_MODES_0_3] = "0,3",
	[XY3_SIM_MODES_0] = "0",
	[XY3_SIM_MODES_CLAIMED] = "claimed",
};

static const char * const sim_idle_names[] = {
	[XY3_SIM_IDLE_KEEP] = "keep",
	[XY3_SIM_IDLE_LOW] = "low",
	[XY3_SIM_IDLE_HIGH] = "high",
	[XY3_SIM_IDLE_FLOAT] = "float",
};

static int __init sim_read_parameters(void)
{
	bool line = !strcmp(framing, "line");
	const char *text = signals ?: sim_default_signals(lines, line);
	int err;

	if (!heads || heads > XY3_SIM_HEADS_MAX || !sim_lines_good(lines) || !max_speed_hz ||
	    (!line && strcmp(framing, "cs")) || !text)
		return -EINVAL;
	device_lines = device_lines ?: lines;
	if (!sim_lines_good(device_lines))
		return -EINVAL;
	err = xy3_sim_parse_signals(text, lines, sim_config.signal);
	if (err)
		return err;

	err = match_string(sim_mode_names, ARRAY_SIZE(sim_mode_names), modes);
	if (err < 0)
		return err;
	sim_config.modes = err;
	err = match_string(sim_idle_names, ARRAY_SIZE(sim_idle_names), idle);
	if (err < 0)
		return err;
	sim_config.idle = err;
	if ((word_bits != 16 && word_bits != 32) || driven_lines > lines ||
	    lanes > XY3_SIM_LINES_MAX || turnaround_us > USEC_PER_SEC)
		return -EINVAL;

	sim_config.lines = lines;
	sim_config.device_lines = device_lines;
	sim_config.cs_word = cs_word;
	sim_config.max_speed_hz = max_speed_hz;
	sim_config.min_speed_hz = min_speed_hz;
	sim_config.max_transfer = max_transfer;
	sim_config.clock_inverted = clock_inverted;
	sim_config.word_bits = word_bits;
	sim_config.driven_lines = driven_lines ?: lines;
	sim_config.flash_only = flash_only;
	sim_config.lsb_first = lsb_first;
	sim_config.lanes = lanes;
	sim_config.turnaround_us = turnaround_us;
	sim_config.uart_max = uart_max;
	/* spidev takes no device by its own name; this is one of its table in all kernels */
	sim_config.modalias = strcmp(modalias, "spidev") ? modalias : "dh2228fv";
	sim_config.realtime = realtime;
	sim_config.interval_ms = interval_ms;
	sim_config.sync_ms = sync_ms;
	return 0;
}

static void sim_remove_devices(void)
{
	for (unsigned int i = 0; i < heads; i++)
		platform_device_unregister(sim_devices[i]);
}

static int __init sim_add_devices(void)
{
	struct platform_device *pdev;

	for (unsigned int i = 0; i < heads; i++) {
		pdev = platform_device_register_simple(driver, i, NULL, 0);
		sim_devices[i] = IS_ERR(pdev) ? NULL : pdev;
		/* a module without its heads is of no use to anybody */
		if (IS_ERR(pdev) || !platform_get_drvdata(pdev)) {
			sim_remove_devices();
			return IS_ERR(pdev) ? PTR_ERR(pdev) : -ENODEV;
		}
	}
	return 0;
}

static int __init sim_module_init(void)
{
	int err;

	err = sim_read_parameters();
	if (err)
		return err;
	err = xy3_sim_tty_init();
	if (err)
		return err;
	xy3_sim_debugfs_init();
	sim_driver.driver.name = driver;
	err = platform_driver_register(&sim_driver);
	if (err)
		goto no_driver;
	err = sim_add_devices();
	if (!err)
		return 0;
	platform_driver_unregister(&sim_driver);
no_driver:
	xy3_sim_debugfs_exit();
	xy3_sim_tty_exit();
	return err;
}

static void __exit sim_module_exit(void)
{
	sim_remove_devices();
	platform_driver_unregister(&sim_driver);
	xy3_sim_debugfs_exit();
	xy3_sim_tty_exit();
}

module_init(sim_module_init);
module_exit(sim_module_exit);

MODULE_DESCRIPTION("XY3-100 compatible laser scanheads: a virtual one");
MODULE_AUTHOR("xhc-xy3 developers");
MODULE_LICENSE("GPL");
MODULE_VERSION("0.1.0");
