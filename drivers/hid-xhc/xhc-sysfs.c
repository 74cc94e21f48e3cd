// SPDX-License-Identifier: GPL-2.0-only
/*
 * XHC pendant: sysfs, as userspace/abi/sysfs-driver-hid-xhc describes it
 *
 * Values go to struct xhc_dro under its lock, and the worker sends them. Text that is not a
 * number returns -EINVAL, a number out of range -ERANGE; then nothing is changed.
 */

#include <linux/device.h>
#include <linux/hid.h>
#include <linux/slab.h>
#include <linux/spinlock.h>
#include <linux/string.h>
#include <linux/sysfs.h>

#include "xhc.h"

/* Attributes that share their show and store, and differ by an index */
#define XHC_ATTR(_name, _mode, _show, _store, _index)				\
	static struct dev_ext_attribute xhc_attr_##_name = {			\
		__ATTR(_name, _mode, _show, _store), (void *)(_index)		\
	}
#define XHC_ATTR_RW(_name, _show, _store, _index)	XHC_ATTR(_name, 0644, _show, _store, _index)
#define XHC_ATTR_RO(_name, _show, _index)		XHC_ATTR(_name, 0444, _show, NULL, _index)

static unsigned int xhc_attr_index(const struct device_attribute *attr)
{
	return (uintptr_t)container_of(attr, struct dev_ext_attribute, attr)->var;
}

static int xhc_parse_number(const char *buf, int min, int max, int *number)
{
	int err, n;

	err = kstrtoint(buf, 10, &n);
	if (err)
		return err;
	if (n < min || n > max)
		return -ERANGE;
	*number = n;
	return 0;
}

static ssize_t axis_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	char text[XHC_POSITION_TEXT];

	guard(mutex)(&xhc->dro.lock);
	xhc_format_position(xhc_dro_want(xhc)->position[xhc_attr_index(attr)], text, sizeof(text));
	return sysfs_emit(buf, "%s\n", text);
}

static ssize_t axis_store(struct device *dev, struct device_attribute *attr,
			  const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	s32 units;
	int err;

	err = xhc_parse_position(xhc->model, buf, &units);
	if (err)
		return err;

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->position[xhc_attr_index(attr)] = units;
	xhc_dro_changed(xhc);
	return count;
}

XHC_ATTR_RW(work_x, axis_show, axis_store, XHC_WORK_X);
XHC_ATTR_RW(work_y, axis_show, axis_store, XHC_WORK_Y);
XHC_ATTR_RW(work_z, axis_show, axis_store, XHC_WORK_Z);
XHC_ATTR_RW(machine_x, axis_show, axis_store, XHC_MACHINE_X);
XHC_ATTR_RW(machine_y, axis_show, axis_store, XHC_MACHINE_Y);
XHC_ATTR_RW(machine_z, axis_show, axis_store, XHC_MACHINE_Z);
XHC_ATTR_RW(row1, axis_show, axis_store, XHC_ROW_1);
XHC_ATTR_RW(row2, axis_show, axis_store, XHC_ROW_2);
XHC_ATTR_RW(row3, axis_show, axis_store, XHC_ROW_3);

static ssize_t position_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	ssize_t len = 0;

	guard(mutex)(&xhc->dro.lock);
	for (unsigned int i = 0; i < xhc->model->positions; i++) {
		char text[XHC_POSITION_TEXT];

		xhc_format_position(xhc_dro_want(xhc)->position[i], text, sizeof(text));
		len += sysfs_emit_at(buf, len, "%s%s", i ? " " : "", text);
	}
	return len + sysfs_emit_at(buf, len, "\n");
}

static ssize_t position_store(struct device *dev, struct device_attribute *attr,
			      const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	s32 units[XHC_POSITIONS];
	char *rest;

	char *text __free(kfree) = kstrdup(buf, GFP_KERNEL);
	if (!text)
		return -ENOMEM;

	rest = strim(text);
	for (unsigned int i = 0; i < xhc->model->positions; i++) {
		char *word = strsep(&rest, " \t");
		int err;

		if (!word)
			return -EINVAL;
		err = xhc_parse_position(xhc->model, word, &units[i]);
		if (err)
			return err;
		if (rest)
			rest = skip_spaces(rest);
	}
	if (rest)
		return -EINVAL;

	guard(mutex)(&xhc->dro.lock);
	memcpy(xhc_dro_want(xhc)->position, units, xhc->model->positions * sizeof(units[0]));
	xhc_dro_changed(xhc);
	return count;
}
static DEVICE_ATTR_RW(position);
XHC_ATTR_RW(rows, position_show, position_store, 0);

static ssize_t number_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	guard(mutex)(&xhc->dro.lock);
	return sysfs_emit(buf, "%u\n", xhc_dro_want(xhc)->number[xhc_attr_index(attr)]);
}

static ssize_t number_store(struct device *dev, struct device_attribute *attr,
			    const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	int err, number;

	err = xhc_parse_number(buf, 0, U16_MAX, &number);
	if (err)
		return err;

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->number[xhc_attr_index(attr)] = number;
	xhc_dro_changed(xhc);
	return count;
}

XHC_ATTR_RW(feedrate_override, number_show, number_store, XHC_FEEDRATE_OVERRIDE);
XHC_ATTR_RW(spindle_override, number_show, number_store, XHC_SPINDLE_OVERRIDE);
XHC_ATTR_RW(feedrate, number_show, number_store, XHC_FEEDRATE);
XHC_ATTR_RW(spindle_speed, number_show, number_store, XHC_SPINDLE_SPEED);

static ssize_t step_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	int multiplier;

	guard(mutex)(&xhc->dro.lock);
	multiplier = xhc_step_multiplier(xhc_dro_want(xhc)->step);
	if (multiplier < 0)
		return sysfs_emit(buf, "0x%02x\n", xhc_dro_want(xhc)->step);
	return sysfs_emit(buf, "%d\n", multiplier);
}

static ssize_t step_store(struct device *dev, struct device_attribute *attr,
			  const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	int code = xhc_parse_step(buf);

	if (code < 0)
		return code;

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->step = code;
	xhc_dro_changed(xhc);
	return count;
}
static DEVICE_ATTR_RW(step);

static ssize_t step_available_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	ssize_t len = 0;
	int multiplier;

	for (unsigned int code = 0; (multiplier = xhc_step_multiplier(code)) >= 0; code++)
		len += sysfs_emit_at(buf, len, "%s%d", code ? " " : "", multiplier);
	return len + sysfs_emit_at(buf, len, "\n");
}
static DEVICE_ATTR_RO(step_available);

static ssize_t icon_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	guard(mutex)(&xhc->dro.lock);
	return sysfs_emit(buf, "%u\n", xhc_dro_want(xhc)->icon);
}

static ssize_t icon_store(struct device *dev, struct device_attribute *attr,
			  const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	int err, icon;

	err = xhc_parse_number(buf, 0, XHC_ICON_MAX, &icon);
	if (err)
		return err;

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->icon = icon;
	xhc_dro_changed(xhc);
	return count;
}
static DEVICE_ATTR_RW(icon);

static ssize_t state_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	char text[XHC_STATE_TEXT];

	guard(mutex)(&xhc->dro.lock);
	xhc_format_state(xhc->model, xhc_dro_want(xhc)->state, text, sizeof(text));
	return sysfs_emit(buf, "%s\n", text);
}

static ssize_t state_store(struct device *dev, struct device_attribute *attr,
			   const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	u8 state;
	int err;

	err = xhc_parse_state(xhc->model, buf, &state);
	if (err)
		return err;

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->state = state;
	xhc_dro_changed(xhc);
	return count;
}
static DEVICE_ATTR_RW(state);

static ssize_t day_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	guard(mutex)(&xhc->dro.lock);
	if (!xhc_dro_want(xhc)->day)
		return sysfs_emit(buf, "auto\n");
	return sysfs_emit(buf, "%u\n", xhc_dro_want(xhc)->day);
}

static ssize_t day_store(struct device *dev, struct device_attribute *attr,
			 const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	int day = 0;

	if (!sysfs_streq(buf, "auto")) {
		int err = xhc_parse_number(buf, 1, XHC_DAY_MAX, &day);

		if (err)
			return err;
	}

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->day = day;
	xhc_dro_changed(xhc);
	return count;
}
static DEVICE_ATTR_RW(day);

static const char * const xhc_modes[XHC_MODES] = {
	[XHC_MODE_CONTINUOUS] = "continuous",
	[XHC_MODE_STEP] = "step",
	[XHC_MODE_MPG] = "mpg",
	[XHC_MODE_PERCENT] = "percent",
};

static ssize_t mode_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	guard(mutex)(&xhc->dro.lock);
	return sysfs_emit(buf, "%s\n", xhc_modes[xhc_dro_want(xhc)->mode]);
}

static ssize_t mode_store(struct device *dev, struct device_attribute *attr,
			  const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	int mode = sysfs_match_string(xhc_modes, buf);

	if (mode < 0)
		return mode;

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->mode = mode;
	xhc_dro_changed(xhc);
	return count;
}
static DEVICE_ATTR_RW(mode);

static const char * const xhc_coordinates[] = { "machine", "work" };

static ssize_t coordinates_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	guard(mutex)(&xhc->dro.lock);
	return sysfs_emit(buf, "%s\n", xhc_coordinates[xhc_dro_want(xhc)->work]);
}

static ssize_t coordinates_store(struct device *dev, struct device_attribute *attr,
				 const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	int work = sysfs_match_string(xhc_coordinates, buf);

	if (work < 0)
		return work;

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->work = work;
	xhc_dro_changed(xhc);
	return count;
}
static DEVICE_ATTR_RW(coordinates);

static ssize_t reset_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	guard(mutex)(&xhc->dro.lock);
	return sysfs_emit(buf, "%d\n", xhc_dro_want(xhc)->reset);
}

static ssize_t reset_store(struct device *dev, struct device_attribute *attr,
			   const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	int err, reset;

	err = xhc_parse_number(buf, 0, 1, &reset);
	if (err)
		return err;

	guard(mutex)(&xhc->dro.lock);
	xhc_dro_want(xhc)->reset = reset;
	xhc_dro_changed(xhc);
	return count;
}
static DEVICE_ATTR_RW(reset);

static ssize_t refresh_ms_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	guard(mutex)(&xhc->dro.lock);
	return sysfs_emit(buf, "%u\n", xhc->dro.refresh_ms);
}

static ssize_t refresh_ms_store(struct device *dev, struct device_attribute *attr,
				const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	int err, refresh_ms;

	err = xhc_parse_number(buf, XHC_REFRESH_MIN_MS, XHC_REFRESH_MAX_MS, &refresh_ms);
	if (err)
		return err;

	/* takes effect with the next frame */
	guard(mutex)(&xhc->dro.lock);
	xhc->dro.refresh_ms = refresh_ms;
	return count;
}
static DEVICE_ATTR_RW(refresh_ms);

static ssize_t flush_store(struct device *dev, struct device_attribute *attr,
			   const char *buf, size_t count)
{
	int err = xhc_dro_flush(dev_get_drvdata(dev));

	return err ?: count;
}
static DEVICE_ATTR_WO(flush);

static struct attribute *xhc_dro_attrs[] = {
	&xhc_attr_work_x.attr.attr,
	&xhc_attr_work_y.attr.attr,
	&xhc_attr_work_z.attr.attr,
	&xhc_attr_machine_x.attr.attr,
	&xhc_attr_machine_y.attr.attr,
	&xhc_attr_machine_z.attr.attr,
	&dev_attr_position.attr,
	&xhc_attr_feedrate_override.attr.attr,
	&xhc_attr_spindle_override.attr.attr,
	&xhc_attr_feedrate.attr.attr,
	&xhc_attr_spindle_speed.attr.attr,
	&dev_attr_step.attr,
	&dev_attr_step_available.attr,
	&dev_attr_icon.attr,
	&dev_attr_state.attr,
	&dev_attr_day.attr,
	&xhc_attr_row1.attr.attr,
	&xhc_attr_row2.attr.attr,
	&xhc_attr_row3.attr.attr,
	&xhc_attr_rows.attr.attr,
	&dev_attr_mode.attr,
	&dev_attr_coordinates.attr,
	&dev_attr_reset.attr,
	&dev_attr_refresh_ms.attr,
	&dev_attr_flush.attr,
	NULL
};

/* Attributes of all displays, and of the transfer */
static const struct attribute * const xhc_common_attrs[] = {
	&xhc_attr_feedrate_override.attr.attr,
	&xhc_attr_spindle_override.attr.attr,
	&dev_attr_refresh_ms.attr,
	&dev_attr_flush.attr,
};

/* Attributes of displays with rows */
static const struct attribute * const xhc_rows_attrs[] = {
	&xhc_attr_row1.attr.attr,
	&xhc_attr_row2.attr.attr,
	&xhc_attr_row3.attr.attr,
	&xhc_attr_rows.attr.attr,
	&dev_attr_mode.attr,
	&dev_attr_coordinates.attr,
	&dev_attr_reset.attr,
};

static bool xhc_attr_in(const struct attribute * const *attrs, size_t n,
			const struct attribute *attr)
{
	for (size_t i = 0; i < n; i++)
		if (attrs[i] == attr)
			return true;
	return false;
}

static umode_t xhc_dro_is_visible(struct kobject *kobj, struct attribute *attr, int n)
{
	struct xhc_device *xhc = dev_get_drvdata(kobj_to_dev(kobj));
	bool of_rows = xhc_attr_in(xhc_rows_attrs, ARRAY_SIZE(xhc_rows_attrs), attr);
	bool common = xhc_attr_in(xhc_common_attrs, ARRAY_SIZE(xhc_common_attrs), attr);

	return common || of_rows == xhc->model->rows ? attr->mode : 0;
}

static const struct attribute_group xhc_dro_group = {
	.name = "dro",
	.attrs = xhc_dro_attrs,
	.is_visible = xhc_dro_is_visible,
};

static ssize_t stat_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	return sysfs_emit(buf, "%lld\n", atomic64_read(&xhc->stat[xhc_attr_index(attr)]));
}

XHC_ATTR_RO(reports, stat_show, XHC_REPORTS);
XHC_ATTR_RO(bad_reports, stat_show, XHC_BAD_REPORTS);
XHC_ATTR_RO(xor_mismatches, stat_show, XHC_XOR_MISMATCHES);
XHC_ATTR_RO(unknown_keys, stat_show, XHC_UNKNOWN_KEYS);
XHC_ATTR_RO(frames_sent, stat_show, XHC_FRAMES_SENT);
XHC_ATTR_RO(frame_errors, stat_show, XHC_FRAME_ERRORS);

static struct attribute *xhc_stats_attrs[] = {
	&xhc_attr_reports.attr.attr,
	&xhc_attr_bad_reports.attr.attr,
	&xhc_attr_xor_mismatches.attr.attr,
	&xhc_attr_unknown_keys.attr.attr,
	&xhc_attr_frames_sent.attr.attr,
	&xhc_attr_frame_errors.attr.attr,
	NULL
};

static const struct attribute_group xhc_stats_group = {
	.name = "stats",
	.attrs = xhc_stats_attrs,
};

static ssize_t model_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	return sysfs_emit(buf, "%s\n", xhc->model->name);
}
static DEVICE_ATTR_RO(model);

static ssize_t awake_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	return sysfs_emit(buf, "%d\n", READ_ONCE(xhc->evdev.awake));
}
static DEVICE_ATTR_RO(awake);

static ssize_t swap_feed_spindle_show(struct device *dev, struct device_attribute *attr,
				      char *buf)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);

	return sysfs_emit(buf, "%d\n", READ_ONCE(xhc->swap_feed_spindle));
}

static ssize_t swap_feed_spindle_store(struct device *dev, struct device_attribute *attr,
				       const char *buf, size_t count)
{
	struct xhc_device *xhc = dev_get_drvdata(dev);
	bool swap;
	int err;

	err = kstrtobool(buf, &swap);
	if (err)
		return err;

	/* takes effect with the next report */
	WRITE_ONCE(xhc->swap_feed_spindle, swap);
	return count;
}
static DEVICE_ATTR_RW(swap_feed_spindle);

static struct attribute *xhc_attrs[] = {
	&dev_attr_model.attr,
	&dev_attr_swap_feed_spindle.attr,
	&dev_attr_awake.attr,
	NULL
};

/* A model with axes B and C has no feed and spindle to swap */
static umode_t xhc_is_visible(struct kobject *kobj, struct attribute *attr, int n)
{
	struct xhc_device *xhc = dev_get_drvdata(kobj_to_dev(kobj));

	if (attr == &dev_attr_swap_feed_spindle.attr && xhc->model->rows)
		return 0;
	return attr->mode;
}

static const struct attribute_group xhc_group = {
	.attrs = xhc_attrs,
	.is_visible = xhc_is_visible,
};

static const struct attribute_group *xhc_groups[] = {
	&xhc_group,
	&xhc_dro_group,
	&xhc_stats_group,
	NULL
};

/**
 * xhc_sysfs_add() - create the attributes
 * @xhc: the pendant, ready to be used
 *
 * The driver core would create dev_groups after probe, when programs may already look for
 * the attributes, as the input device was announced to them.
 *
 * Return: 0 on success, a negative errno otherwise.
 */
int xhc_sysfs_add(struct xhc_device *xhc)
{
	struct kobject *kobj = &xhc->hdev->dev.kobj;
	struct kernfs_node *awake;
	int err;

	err = sysfs_create_groups(kobj, xhc_groups);
	if (err)
		return err;

	awake = sysfs_get_dirent(kobj->sd, dev_attr_awake.attr.name);
	guard(spinlock_irqsave)(&xhc->evdev.lock);
	xhc_evdev(xhc)->awake_node = awake;
	return 0;
}

/**
 * xhc_sysfs_remove() - remove the attributes
 * @xhc: the pendant
 *
 * Context: sleeps until every show and store in progress has returned.
 */
void xhc_sysfs_remove(struct xhc_device *xhc)
{
	struct kernfs_node *awake;

	scoped_guard(spinlock_irqsave, &xhc->evdev.lock) {
		awake = xhc_evdev(xhc)->awake_node;
		xhc_evdev(xhc)->awake_node = NULL;
	}
	sysfs_remove_groups(&xhc->hdev->dev.kobj, xhc_groups);
	/* removing a file does not wake its pollers */
	if (awake)
		sysfs_notify_dirent(awake);
	sysfs_put(awake);
}
