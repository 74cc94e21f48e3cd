// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: its settings, from text and to text
 */

#include <linux/cleanup.h>
#include <linux/errno.h>
#include <linux/kernel.h>
#include <linux/kstrtox.h>
#include <linux/log2.h>
#include <linux/slab.h>
#include <linux/string.h>
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
	case XY3_SIM_KIND_NUMBER:
		return sim_parse_number(setting, field, text);
	case XY3_SIM_KIND_FLAG:
		return kstrtobool(text, field);
	case XY3_SIM_KIND_CHOICE:
		return sim_parse_choice(setting, field, text);
	case XY3_SIM_KIND_TEXT:
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
 * Return: number of bytes written to @page.
 */
int xy3_sim_setting_print(const struct xy3_sim_setting *setting,
			  const struct xy3_sim_config *config, char *page)
{
	const void *field = (const void *)config + setting->offset;

	switch (setting->kind) {
	case XY3_SIM_KIND_NUMBER:
		return sprintf(page, "%u\n", *(const unsigned int *)field);
	case XY3_SIM_KIND_FLAG:
		return sprintf(page, "%d\n", *(const bool *)field);
	case XY3_SIM_KIND_CHOICE:
		return sprintf(page, "%s\n", setting->names[*(const unsigned int *)field]);
	case XY3_SIM_KIND_TEXT:
		return sprintf(page, "%s\n", (const char *)field);
	}
	return -EINVAL;
}

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
 * Return: the word for it that xy3_sim_parse_signals() accepts.
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
