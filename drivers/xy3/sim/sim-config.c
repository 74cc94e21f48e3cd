// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: its settings
 *
 * A line in the table of settings defines a module parameter, for heads that are created when the
 * module is loaded and as the default in configfs, and a file of each head in configfs. Limits are
 * those of existing controllers, whose driver is given in brackets.
 */

#include <linux/cleanup.h>
#include <linux/configfs.h>
#include <linux/errno.h>
#include <linux/kernel.h>
#include <linux/log2.h>
#include <linux/module.h>
#include <linux/slab.h>
#include <linux/string.h>
#include <linux/time64.h>
#include <linux/types.h>

#include "sim-config.h"

struct xy3_sim_config xy3_sim_defaults = {
	.lines = 1,
	.framing = XY3_SIM_FRAMING_CS,
	.max_speed_hz = 50000000,
	.clock = XY3_SIM_CLOCK_ANY,
	.modes = XY3_SIM_MODES_ALL,
	.word_bits = 32,
	.idle = XY3_SIM_IDLE_FLOAT,
	.turnaround_us = 20,
	.prepare_us = 10,
	.driver = "xy3-sim",
	.modalias = "xy3-100",
	.uart_max = 4000000,
	.interval_ms = 1000,
	.sync_ms = 100,
	.seed = 1,
};

/* ---- kinds of settings ---- */

enum sim_kind {
	SIM_KIND_NUMBER,
	SIM_KIND_FLAG,
	SIM_KIND_CHOICE,
	SIM_KIND_TEXT,
};

/**
 * struct xy3_sim_setting - a setting
 * @kind: the type of its member in struct xy3_sim_config
 * @offset: offset of the member
 * @size: size of the member
 * @min: lowest number
 * @max: highest number, or number of names
 * @names: of a choice
 */
struct xy3_sim_setting {
	enum sim_kind kind;
	size_t offset;
	size_t size;
	unsigned int min;
	unsigned int max;
	const char * const *names;
};

static int sim_parse_number(const struct xy3_sim_setting *setting, unsigned int *field,
			    const char *text)
{
	unsigned int number;
	int err;

	err = kstrtouint(text, 0, &number);
	if (err)
		return err;
	if (number < setting->min || number > setting->max)
		return -EINVAL;
	*field = number;
	return 0;
}

static int sim_parse_choice(const struct xy3_sim_setting *setting, unsigned int *field,
			    const char *text)
{
	int found = __sysfs_match_string(setting->names, setting->max, text);

	if (found < 0)
		return found;
	*field = found;
	return 0;
}

static int sim_parse_text(const struct xy3_sim_setting *setting, char *field, const char *text)
{
	size_t length = strcspn(text, "\n");

	if (length >= setting->size)
		return -EINVAL;
	memcpy(field, text, length);
	field[length] = '\0';
	return 0;
}

/**
 * xy3_sim_setting_parse() - change a setting
 * @setting: the setting
 * @config: the settings of a head
 * @text: the new value; a newline may follow
 *
 * Return: 0 or an error.
 */
int xy3_sim_setting_parse(const struct xy3_sim_setting *setting, struct xy3_sim_config *config,
			  const char *text)
{
	void *field = (void *)config + setting->offset;

	switch (setting->kind) {
	case SIM_KIND_NUMBER:
		return sim_parse_number(setting, field, text);
	case SIM_KIND_FLAG:
		return kstrtobool(text, field);
	case SIM_KIND_CHOICE:
		return sim_parse_choice(setting, field, text);
	case SIM_KIND_TEXT:
		return sim_parse_text(setting, field, text);
	}
	return -EINVAL;
}

/**
 * xy3_sim_setting_print() - print a setting
 * @setting: the setting
 * @config: the settings of a head
 * @page: the destination
 *
 * Return: the length.
 */
int xy3_sim_setting_print(const struct xy3_sim_setting *setting,
			  const struct xy3_sim_config *config, char *page)
{
	const void *field = (const void *)config + setting->offset;

	switch (setting->kind) {
	case SIM_KIND_NUMBER:
		return sprintf(page, "%u\n", *(const unsigned int *)field);
	case SIM_KIND_FLAG:
		return sprintf(page, "%d\n", *(const bool *)field);
	case SIM_KIND_CHOICE:
		return sprintf(page, "%s\n", setting->names[*(const unsigned int *)field]);
	case SIM_KIND_TEXT:
		return sprintf(page, "%s\n", (const char *)field);
	}
	return -EINVAL;
}

static int sim_param_set(const char *text, const struct kernel_param *param)
{
	return xy3_sim_setting_parse(param->arg, &xy3_sim_defaults, text);
}

static int sim_param_get(char *page, const struct kernel_param *param)
{
	return xy3_sim_setting_print(param->arg, &xy3_sim_defaults, page);
}

static const struct kernel_param_ops sim_param_ops = {
	.set = sim_param_set,
	.get = sim_param_get,
};

/* ---- the table ---- */

#define SIM_SETTING(_name, _kind, _min, _max, _names, _text)					\
static const struct xy3_sim_setting sim_setting_##_name = {					\
	.kind = _kind,										\
	.offset = offsetof(struct xy3_sim_config, _name),					\
	.size = sizeof_field(struct xy3_sim_config, _name),					\
	.min = _min,										\
	.max = _max,										\
	.names = _names,									\
};												\
static ssize_t sim_##_name##_show(struct config_item *item, char *page)			\
{												\
	return xy3_sim_configfs_show(item, &sim_setting_##_name, page);				\
}												\
static ssize_t sim_##_name##_store(struct config_item *item, const char *page, size_t count)	\
{												\
	return xy3_sim_configfs_store(item, &sim_setting_##_name, page, count);			\
}												\
CONFIGFS_ATTR(sim_, _name);									\
module_param_cb(_name, &sim_param_ops, (void *)&sim_setting_##_name, 0444);			\
MODULE_PARM_DESC(_name, _text)

#define SIM_NUMBER(_name, _min, _max, _text)							\
	SIM_SETTING(_name, SIM_KIND_NUMBER, _min, _max, NULL, _text)
#define SIM_FLAG(_name, _text)									\
	SIM_SETTING(_name, SIM_KIND_FLAG, 0, 1, NULL, _text)
#define SIM_CHOICE(_name, _names, _text)							\
	SIM_SETTING(_name, SIM_KIND_CHOICE, 0, ARRAY_SIZE(_names), _names, _text)
#define SIM_TEXT(_name, _text)									\
	SIM_SETTING(_name, SIM_KIND_TEXT, 0, 0, NULL, _text)

static const char * const sim_framing_names[] = {
	[XY3_SIM_FRAMING_CS] = "cs",
	[XY3_SIM_FRAMING_LINE] = "line",
};

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

static const char * const sim_clock_names[] = {
	[XY3_SIM_CLOCK_ANY] = "any",
	[XY3_SIM_CLOCK_DIVIDED] = "divided",
	[XY3_SIM_CLOCK_HALVED] = "halved",
	[XY3_SIM_CLOCK_SETUP] = "setup",
	[XY3_SIM_CLOCK_FIXED] = "fixed",
};

SIM_NUMBER(lines, 1, XY3_SIM_LINES_MAX, "Data lines of the controller: 1, 2, 4 or 8 (default: 1)");
SIM_NUMBER(device_lines, 0, XY3_SIM_LINES_MAX,
	   "Data lines of the SPI device (default: 0, as the controller's)");
SIM_CHOICE(framing, sim_framing_names,
	   "What SYNC is: cs, the chip select, or line, a data line (default: cs)");
SIM_TEXT(signals, "What lines carry from IO0 on, x y z u w sync gate or -, with commas between");
SIM_FLAG(cs_word, "The controller moves the chip select after each word (default: no)");
SIM_NUMBER(word_bits, 16, 32,
	   "Longest word with cs_word: 32, or 16 (spi-davinci, spi-orion) (default: 32)");
SIM_NUMBER(max_speed_hz, 1, INT_MAX, "Highest clock of the controller (default: 50000000)");
SIM_NUMBER(min_speed_hz, 0, INT_MAX,
	   "Lowest clock of the controller (spi-synquacer) (default: 0, any)");
SIM_CHOICE(clock, sim_clock_names,
	   "Clocks: any; divided (spi-bcm2835) or halved (spi-stm32) from the highest one; setup, the device's when it was set up (spi-stm32-qspi); or fixed (spi-xilinx) (default: any)");
SIM_NUMBER(max_transfer, 0, INT_MAX,
	   "Longest SPI transfer in bytes (spi-bcm2835) (default: 0, any)");
SIM_NUMBER(max_message, 0, INT_MAX,
	   "Longest SPI message in bytes (spi-bcm63xx-hsspi) (default: 0, any)");
SIM_CHOICE(modes, sim_mode_names,
	   "SPI modes: all; 0,3 (spi-qcom-qspi); 0 (spi-stm32-qspi); or claimed: takes all, does 0 or 3 (spi-tegra210-quad) (default: all)");
SIM_FLAG(clock_inverted, "The pair of CLK is crossed, as the device is described (default: no)");
SIM_NUMBER(driven_lines, 0, XY3_SIM_LINES_MAX,
	   "Data lines that transfers really use (spi-mt65xx up to 6.12: 1) (default: 0, all)");
SIM_FLAG(flash_only, "Flash operations and no transfers (spi-zynqmp-gqspi) (default: no)");
SIM_FLAG(lsb_first, "The device is described with its lowest bit first (default: no)");
SIM_NUMBER(lanes, 0, XY3_SIM_LINES_MAX,
	   "Number of lanes, of one line each (spi-axi-spi-engine from 7.2 on) (default: 0)");
SIM_CHOICE(idle, sim_idle_names,
	   "Data lines between messages: keep, low, high or float (default: float)");
SIM_NUMBER(turnaround_us, 0, USEC_PER_SEC,
	   "Time between two messages that follow one another (default: 20)");
SIM_NUMBER(prepare_us, 0, USEC_PER_SEC,
	   "Time to prepare a message (spi-axi-spi-engine), 0 for a controller that does not (default: 10)");
SIM_TEXT(driver, "Name of the controller's driver (default: xy3-sim)");
SIM_TEXT(modalias, "Name of the SPI device: xy3-100, spidev, or another (default: xy3-100)");
SIM_FLAG(realtime, "Transfers take as long as on a wire (default: no)");
SIM_NUMBER(uart_max, 0, INT_MAX, "Highest speed of the UART in bit/s (default: 4000000)");
SIM_NUMBER(interval_ms, 0, UINT_MAX,
	   "Time between rounds of telemetry, 0 for none (default: 1000)");
SIM_NUMBER(sync_ms, 0, UINT_MAX, "Time between sync packets, 0 for none (default: 100)");
SIM_NUMBER(seed, 0, UINT_MAX, "The same seed gives the same faults (default: 1)");

CONFIGFS_ATTR_RO(xy3_sim_, number);
CONFIGFS_ATTR(xy3_sim_, live);

struct configfs_attribute *xy3_sim_config_attrs[] = {
	&xy3_sim_attr_number,
	&xy3_sim_attr_live,
	&sim_attr_lines,
	&sim_attr_device_lines,
	&sim_attr_framing,
	&sim_attr_signals,
	&sim_attr_cs_word,
	&sim_attr_word_bits,
	&sim_attr_max_speed_hz,
	&sim_attr_min_speed_hz,
	&sim_attr_clock,
	&sim_attr_max_transfer,
	&sim_attr_max_message,
	&sim_attr_modes,
	&sim_attr_clock_inverted,
	&sim_attr_driven_lines,
	&sim_attr_flash_only,
	&sim_attr_lsb_first,
	&sim_attr_lanes,
	&sim_attr_idle,
	&sim_attr_turnaround_us,
	&sim_attr_prepare_us,
	&sim_attr_driver,
	&sim_attr_modalias,
	&sim_attr_realtime,
	&sim_attr_uart_max,
	&sim_attr_interval_ms,
	&sim_attr_sync_ms,
	&sim_attr_seed,
	NULL
};

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
 * xy3_sim_parse_signals() - parse the signals of lines
 * @text: their names, from IO0 on, separated by blanks or commas
 * @lines: number of lines; those without a name are unused
 * @signal: the signals
 *
 * Return: 0; -EINVAL if there are too many, a name is unknown or given twice, or X is missing.
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

static const char *sim_default_signals(const struct xy3_sim_config *config)
{
	bool line = config->framing == XY3_SIM_FRAMING_LINE;

	switch (config->lines) {
	case 1:
		return line ? "" : "x";
	case 2:
		return line ? "" : "x y";
	case 4:
		return line ? "sync x y z" : "x y z u";
	default:
		return line ? "sync x y z u w" : "x y z u w";
	}
}

/* ---- all of them together ---- */

static bool sim_lines_good(unsigned int count)
{
	return is_power_of_2(count) && count <= XY3_SIM_LINES_MAX;
}

/**
 * xy3_sim_config_resolve() - set values that depend on other settings
 * @config: the settings
 *
 * Return: 0; -EINVAL if they are inconsistent.
 */
int xy3_sim_config_resolve(struct xy3_sim_config *config)
{
	config->device_lines = config->device_lines ?: config->lines;
	config->driven_lines = config->driven_lines ?: config->lines;
	if (!sim_lines_good(config->lines) || !sim_lines_good(config->device_lines) ||
	    config->driven_lines > config->lines ||
	    (config->word_bits != 16 && config->word_bits != 32) || !*config->driver)
		return -EINVAL;
	return xy3_sim_parse_signals(*config->signals ? config->signals :
				     sim_default_signals(config), config->lines, config->signal);
}
