// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: hwmon - the temperature sensors of the head, in millidegrees Celsius
 */

#include <linux/bitops.h>
#include <linux/err.h>
#include <linux/hwmon.h>

#include "xy3.h"

#define XY3_MILLIDEGREES	10	/* in 1/100 of a degree */

static umode_t xy3_hwmon_is_visible(const void *data, enum hwmon_sensor_types type, u32 attr,
				    int channel)
{
	const struct xy3_head *head = data;

	return head->hwmon_thermometers & BIT(channel) ? 0444 : 0;
}

static int xy3_hwmon_read(struct device *dev, enum hwmon_sensor_types type, u32 attr,
			  int channel, long *value)
{
	struct xy3_head *head = dev_get_drvdata(dev);
	const struct xy3_telemetry *now;

	guard(mutex)(&head->lock);
	now = xy3_telemetry(head);
	switch (attr) {
	case hwmon_temp_input:
		if (channel >= now->temperatures ||
		    now->temperature[channel] == XY3_TEMPERATURE_NONE)
			return -ENODATA;
		*value = now->temperature[channel] * XY3_MILLIDEGREES;
		return 0;
	case hwmon_temp_fault:
		*value = channel < now->errors &&
			 now->error[channel] == XY3_ERROR_TEMPERATURE;
		return 0;
	default:
		return -EOPNOTSUPP;
	}
}

static int xy3_hwmon_read_string(struct device *dev, enum hwmon_sensor_types type, u32 attr,
				 int channel, const char **text)
{
	*text = xy3_component_name(channel);
	return 0;
}

static const struct hwmon_ops xy3_hwmon_ops = {
	.is_visible = xy3_hwmon_is_visible,
	.read = xy3_hwmon_read,
	.read_string = xy3_hwmon_read_string,
};

#define XY3_THERMOMETER		(HWMON_T_INPUT | HWMON_T_LABEL | HWMON_T_FAULT)

static const u32 xy3_hwmon_config[] = {
	[0 ... XY3_COMPONENTS - 1] = XY3_THERMOMETER,
	0
};

static const struct hwmon_channel_info xy3_hwmon_temp = {
	.type = hwmon_temp,
	.config = xy3_hwmon_config,
};

static const struct hwmon_channel_info *xy3_hwmon_info[] = { &xy3_hwmon_temp, NULL };

static const struct hwmon_chip_info xy3_hwmon_chip = {
	.ops = &xy3_hwmon_ops,
	.info = xy3_hwmon_info,
};

/**
 * xy3_hwmon_update() - update the set of temperature sensors
 * @head: the head; the only caller is the worker of its events
 * @thermometers: components, by bit; components are never removed
 *
 * The attributes of a hwmon device are fixed, so a new device replaces it.
 */
void xy3_hwmon_update(struct xy3_head *head, u32 thermometers)
{
	struct device *hwmon;

	if (thermometers == head->hwmon_thermometers)
		return;
	xy3_hwmon_remove(head);
	head->hwmon_thermometers = thermometers;
	hwmon = hwmon_device_register_with_info(&head->dev, "xy3", head, &xy3_hwmon_chip, NULL);
	if (IS_ERR(hwmon)) {
		dev_warn_once(&head->dev, "no hwmon device: %pe\n", hwmon);
		head->hwmon_thermometers = 0;	/* try again with the next event */
		return;
	}
	head->hwmon = hwmon;
}

/**
 * xy3_hwmon_remove() - remove the hwmon device
 * @head: the head; the worker of its events does not run, or is the caller
 */
void xy3_hwmon_remove(struct xy3_head *head)
{
	if (head->hwmon)
		hwmon_device_unregister(head->hwmon);
	head->hwmon = NULL;
}
