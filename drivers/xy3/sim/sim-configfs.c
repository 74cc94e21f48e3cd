// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: module parameters, and heads by configfs
 *
 * A line in the table of settings defines a module parameter, for heads that are created when the
 * module is loaded and as the default in configfs, and a file of each head in configfs. Limits are
 * those of existing controllers, whose driver is given in brackets.
 *
 * A folder is a head. Its settings cannot be changed while it is live.
 */

#include <linux/cleanup.h>
#include <linux/configfs.h>
#include <linux/err.h>
#include <linux/kernel.h>
#include <linux/kstrtox.h>
#include <linux/module.h>
#include <linux/mutex.h>
#include <linux/platform_device.h>
#include <linux/slab.h>
#include <linux/stddef.h>
#include <linux/time64.h>

#include "sim.h"

/**
 * struct sim_group - a folder
 * @group: its group of configfs
 * @number: of its head
 * @lock: protects the following members
 * @config: the settings
 * @pdev: the device of the head while it is live, or NULL
 */
struct sim_group {
	struct config_group group;
	unsigned int number;
	struct mutex lock;	/* see above */
	struct xy3_sim_config config;
	struct platform_device *pdev;
};

static struct sim_group *to_sim_group(struct config_item *item)
{
	return container_of(to_config_group(item), struct sim_group, group);
}

/* ---- files ---- */

static ssize_t sim_show(struct config_item *item, const struct xy3_sim_setting *setting,
			char *page)
{
	struct sim_group *group = to_sim_group(item);

	guard(mutex)(&group->lock);
	return xy3_sim_setting_print(setting, &group->config, page);
}

static ssize_t sim_store(struct config_item *item, const struct xy3_sim_setting *setting,
			 const char *page, size_t count)
{
	struct sim_group *group = to_sim_group(item);

	guard(mutex)(&group->lock);
	if (group->pdev)
		return -EBUSY;
	return xy3_sim_setting_parse(setting, &group->config, page) ?: count;
}

static ssize_t sim_number_show(struct config_item *item, char *page)
{
	return sprintf(page, "%u\n", to_sim_group(item)->number);
}

static ssize_t sim_live_show(struct config_item *item, char *page)
{
	struct sim_group *group = to_sim_group(item);

	guard(mutex)(&group->lock);
	return sprintf(page, "%d\n", !!group->pdev);
}

static int sim_start(struct sim_group *group)
{
	struct platform_device *pdev;

	if (group->pdev)
		return -EBUSY;
	pdev = xy3_sim_add(&group->config, group->number);
	if (IS_ERR(pdev))
		return PTR_ERR(pdev);
	group->pdev = pdev;
	return 0;
}

static void sim_stop(struct sim_group *group)
{
	if (group->pdev)
		xy3_sim_remove(group->pdev);
	group->pdev = NULL;
}

static ssize_t sim_live_store(struct config_item *item, const char *page, size_t count)
{
	struct sim_group *group = to_sim_group(item);
	bool live;
	int err;

	err = kstrtobool(page, &live);
	if (err)
		return err;
	guard(mutex)(&group->lock);
	if (live)
		err = sim_start(group);
	else
		sim_stop(group);
	return err ?: count;
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
static ssize_t sim_##_name##_show(struct config_item *item, char *page)				\
{												\
	return sim_show(item, &sim_setting_##_name, page);					\
}												\
static ssize_t sim_##_name##_store(struct config_item *item, const char *page, size_t count)	\
{												\
	return sim_store(item, &sim_setting_##_name, page, count);				\
}												\
CONFIGFS_ATTR(sim_, _name);									\
module_param_cb(_name, &sim_param_ops, (void *)&sim_setting_##_name, 0444);			\
MODULE_PARM_DESC(_name, _text)

#define SIM_NUMBER(_name, _min, _max, _text)							\
	SIM_SETTING(_name, XY3_SIM_KIND_NUMBER, _min, _max, NULL, _text)
#define SIM_FLAG(_name, _text)									\
	SIM_SETTING(_name, XY3_SIM_KIND_FLAG, 0, 1, NULL, _text)
#define SIM_CHOICE(_name, _names, _text)							\
	SIM_SETTING(_name, XY3_SIM_KIND_CHOICE, 0, ARRAY_SIZE(_names), _names, _text)
#define SIM_TEXT(_name, _text)									\
	SIM_SETTING(_name, XY3_SIM_KIND_TEXT, 0, 0, NULL, _text)

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

CONFIGFS_ATTR_RO(sim_, number);
CONFIGFS_ATTR(sim_, live);

static struct configfs_attribute *sim_attrs[] = {
	&sim_attr_number,
	&sim_attr_live,
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

/* ---- folders ---- */

static void sim_group_release(struct config_item *item)
{
	struct sim_group *group = to_sim_group(item);

	sim_stop(group);
	xy3_sim_free_number(group->number);
	mutex_destroy(&group->lock);
	kfree(group);
}

static struct configfs_item_operations sim_group_operations = {
	.release = sim_group_release,
};

static const struct config_item_type sim_group_type = {
	.ct_item_ops = &sim_group_operations,
	.ct_attrs = sim_attrs,
	.ct_owner = THIS_MODULE,
};

static struct config_group *sim_make_group(struct config_group *parent, const char *name)
{
	struct sim_group *group;
	int number;

	group = kzalloc(sizeof(*group), GFP_KERNEL);
	if (!group)
		return ERR_PTR(-ENOMEM);
	number = xy3_sim_new_number();
	if (number < 0) {
		kfree(group);
		return ERR_PTR(number);
	}
	group->number = number;
	group->config = xy3_sim_defaults;
	mutex_init(&group->lock);
	config_group_init_type_name(&group->group, name, &sim_group_type);
	return &group->group;
}

static struct configfs_group_operations sim_subsystem_operations = {
	.make_group = sim_make_group,
};

static const struct config_item_type sim_subsystem_type = {
	.ct_group_ops = &sim_subsystem_operations,
	.ct_owner = THIS_MODULE,
};

static struct configfs_subsystem sim_subsystem = {
	.su_group = {
		.cg_item = {
			.ci_namebuf = "xy3-sim",
			.ci_type = &sim_subsystem_type,
		},
	},
};

/**
 * xy3_sim_configfs_init() - create the folder of all heads
 *
 * Return: 0 or an error.
 */
int __init xy3_sim_configfs_init(void)
{
	config_group_init(&sim_subsystem.su_group);
	mutex_init(&sim_subsystem.su_mutex);
	return configfs_register_subsystem(&sim_subsystem);
}

/**
 * xy3_sim_configfs_exit() - remove the folder, which has no heads any more
 */
void xy3_sim_configfs_exit(void)
{
	configfs_unregister_subsystem(&sim_subsystem);
}
