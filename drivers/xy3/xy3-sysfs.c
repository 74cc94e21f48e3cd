// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: sysfs, as userspace/abi/sysfs-class-xy3 describes it
 *
 * Values that the head has not reported return -ENODATA, invalid text -EINVAL, and a missing
 * channel -ENODEV.
 */

#include <linux/device.h>
#include <linux/errno.h>
#include <linux/init.h>
#include <linux/kstrtox.h>
#include <linux/lockdep.h>
#include <linux/sysfs.h>

#include "xy3.h"

/* One of several attributes that differ only by a number */
struct xy3_attribute {
	struct device_attribute attr;
	unsigned int index;
};

#define XY3_ATTR_RO(_name, _show, _index)						\
	static struct xy3_attribute xy3_attr_##_name = {				\
		.attr = __ATTR(_name, 0444, _show, NULL), .index = (_index),		\
	}

static unsigned int xy3_attr_index(const struct device_attribute *attr)
{
	return container_of(attr, struct xy3_attribute, attr)->index;
}

/* ---- identity ---- */

static ssize_t text_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_head *head = to_xy3_head(dev);
	const char *text;

	guard(mutex)(&head->lock);
	text = xy3_telemetry(head)->text[xy3_attr_index(attr)];
	return *text ? sysfs_emit(buf, "%s\n", text) : -ENODATA;
}

XY3_ATTR_RO(vendor, text_show, XY3_VENDOR);
XY3_ATTR_RO(model, text_show, XY3_MODEL);
XY3_ATTR_RO(firmware, text_show, XY3_FIRMWARE);
XY3_ATTR_RO(serial, text_show, XY3_SERIAL);

/* ---- connection ---- */

static ssize_t in_sync_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_head *head = to_xy3_head(dev);

	guard(mutex)(&head->lock);
	return sysfs_emit(buf, "%d\n", head->parser.in_sync);
}
static DEVICE_ATTR_RO(in_sync);

static ssize_t rate_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	unsigned int rate = xy3_get_rate(to_xy3_head(dev));

	return rate ? sysfs_emit(buf, "%u\n", rate) : -ENODEV;
}

static ssize_t rate_store(struct device *dev, struct device_attribute *attr, const char *buf,
			  size_t count)
{
	unsigned int rate;
	int err;

	err = kstrtouint(buf, 10, &rate);
	if (!err)
		err = xy3_set_rate(to_xy3_head(dev), rate);
	return err ?: count;
}
static DEVICE_ATTR_RW(rate);

static ssize_t autobaud_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_head *head = to_xy3_head(dev);

	guard(mutex)(&head->lock);
	return sysfs_emit(buf, "%d\n", head->autobaud.on);
}

static ssize_t autobaud_store(struct device *dev, struct device_attribute *attr,
			      const char *buf, size_t count)
{
	bool on;
	int err;

	err = kstrtobool(buf, &on);
	if (err)
		return err;
	xy3_set_autobaud(to_xy3_head(dev), on);
	return count;
}
static DEVICE_ATTR_RW(autobaud);

static const char * const xy3_byte_orders[] = {
	[XY3_LITTLE_ENDIAN] = "little",
	[XY3_BIG_ENDIAN] = "big",
};

static ssize_t byte_order_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_head *head = to_xy3_head(dev);

	guard(mutex)(&head->lock);
	return sysfs_emit(buf, "%s\n", xy3_byte_orders[head->order]);
}

static ssize_t byte_order_store(struct device *dev, struct device_attribute *attr,
				const char *buf, size_t count)
{
	struct xy3_head *head = to_xy3_head(dev);
	int order = sysfs_match_string(xy3_byte_orders, buf);

	if (order < 0)
		return order;
	guard(mutex)(&head->lock);
	if (order != head->order)
		xy3_telemetry_forget_numbers(head);
	head->order = order;
	return count;
}
static DEVICE_ATTR_RW(byte_order);

/* ---- commands ---- */

static ssize_t xy3_store_switch(struct device *dev, const char *buf, size_t count, u32 on_command,
				u32 off_command)
{
	u32 axes;
	bool on;
	int err;

	err = xy3_parse_switch(buf, &on, &axes);
	if (!err)
		err = xy3_send_command(to_xy3_head(dev), (on ? on_command : off_command) | axes);
	return err ?: count;
}

static ssize_t xy3_store_axes(struct device *dev, const char *buf, size_t count, u32 command)
{
	u32 axes;
	int err;

	err = xy3_parse_axes(buf, &axes);
	if (!err)
		err = xy3_send_command(to_xy3_head(dev), command | axes);
	return err ?: count;
}

static ssize_t autocalib_store(struct device *dev, struct device_attribute *attr,
			       const char *buf, size_t count)
{
	return xy3_store_switch(dev, buf, count, XY3_COMMAND_AUTOCALIB_ON_AXES,
				XY3_COMMAND_AUTOCALIB_OFF_AXES);
}
static DEVICE_ATTR_WO(autocalib);

static ssize_t temp_comp_store(struct device *dev, struct device_attribute *attr,
			       const char *buf, size_t count)
{
	return xy3_store_switch(dev, buf, count, XY3_COMMAND_TEMP_COMP_ON_AXES,
				XY3_COMMAND_TEMP_COMP_OFF_AXES);
}
static DEVICE_ATTR_WO(temp_comp);

static ssize_t calibrate_store(struct device *dev, struct device_attribute *attr,
			       const char *buf, size_t count)
{
	return xy3_store_axes(dev, buf, count, XY3_COMMAND_CALIBRATE_AXES);
}
static DEVICE_ATTR_WO(calibrate);

static ssize_t reference_store(struct device *dev, struct device_attribute *attr,
			       const char *buf, size_t count)
{
	return xy3_store_axes(dev, buf, count, XY3_COMMAND_REFERENCE_AXES);
}
static DEVICE_ATTR_WO(reference);

static struct attribute *xy3_head_attrs[] = {
	&xy3_attr_vendor.attr.attr,
	&xy3_attr_model.attr.attr,
	&xy3_attr_firmware.attr.attr,
	&xy3_attr_serial.attr.attr,
	&dev_attr_in_sync.attr,
	&dev_attr_rate.attr,
	&dev_attr_autobaud.attr,
	&dev_attr_byte_order.attr,
	&dev_attr_autocalib.attr,
	&dev_attr_temp_comp.attr,
	&dev_attr_calibrate.attr,
	&dev_attr_reference.attr,
	NULL
};

static const struct attribute_group xy3_head_group = {
	.attrs = xy3_head_attrs,
};

/* ---- counters ---- */

enum xy3_stat {
	XY3_RX_BYTES,
	XY3_RX_PACKETS,
	XY3_SYNCS,
	XY3_RESYNCS,
	XY3_DROPPED_BYTES,
	XY3_BAD_LENGTHS,
	XY3_UNKNOWN_PACKETS,
	XY3_LINE_ERRORS,
	XY3_LOST_PACKETS
};

static u64 xy3_stat(const struct xy3_head *head, enum xy3_stat stat)
{
	const struct xy3_parser *parser = &head->parser;

	lockdep_assert_held(&head->lock);
	switch (stat) {
	case XY3_RX_BYTES:
		return parser->packet_bytes + parser->dropped_bytes + parser->kept;
	case XY3_RX_PACKETS:
		return parser->packets;
	case XY3_SYNCS:
		return head->syncs;
	case XY3_RESYNCS:
		return parser->resyncs;
	case XY3_DROPPED_BYTES:
		return parser->dropped_bytes;
	case XY3_BAD_LENGTHS:
		return parser->bad_lengths;
	case XY3_UNKNOWN_PACKETS:
		return parser->unknown;
	case XY3_LINE_ERRORS:
		return head->line_errors;
	case XY3_LOST_PACKETS:
		return head->lost_packets;
	}
	return 0;
}

static ssize_t stat_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_head *head = to_xy3_head(dev);

	guard(mutex)(&head->lock);
	return sysfs_emit(buf, "%llu\n", xy3_stat(head, xy3_attr_index(attr)));
}

XY3_ATTR_RO(rx_bytes, stat_show, XY3_RX_BYTES);
XY3_ATTR_RO(rx_packets, stat_show, XY3_RX_PACKETS);
XY3_ATTR_RO(syncs, stat_show, XY3_SYNCS);
XY3_ATTR_RO(resyncs, stat_show, XY3_RESYNCS);
XY3_ATTR_RO(dropped_bytes, stat_show, XY3_DROPPED_BYTES);
XY3_ATTR_RO(bad_lengths, stat_show, XY3_BAD_LENGTHS);
XY3_ATTR_RO(unknown_packets, stat_show, XY3_UNKNOWN_PACKETS);
XY3_ATTR_RO(line_errors, stat_show, XY3_LINE_ERRORS);
XY3_ATTR_RO(lost_packets, stat_show, XY3_LOST_PACKETS);

static struct attribute *xy3_stat_attrs[] = {
	&xy3_attr_rx_bytes.attr.attr,
	&xy3_attr_rx_packets.attr.attr,
	&xy3_attr_syncs.attr.attr,
	&xy3_attr_resyncs.attr.attr,
	&xy3_attr_dropped_bytes.attr.attr,
	&xy3_attr_bad_lengths.attr.attr,
	&xy3_attr_unknown_packets.attr.attr,
	&xy3_attr_line_errors.attr.attr,
	&xy3_attr_lost_packets.attr.attr,
	NULL
};

static const struct attribute_group xy3_stat_group = {
	.name = "stats",
	.attrs = xy3_stat_attrs,
};

/* ---- one attribute for each component or axis; their names come from the codec ---- */

static ssize_t error_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_head *head = to_xy3_head(dev);
	unsigned int component = xy3_attr_index(attr);
	const struct xy3_telemetry *now;
	const char *name;
	u8 error;

	guard(mutex)(&head->lock);
	now = xy3_telemetry(head);
	if (component >= now->errors)
		return -ENODATA;
	error = now->error[component];
	name = xy3_error_name(error);
	return name ? sysfs_emit(buf, "%s\n", name) : sysfs_emit(buf, "%u\n", error);
}

static ssize_t hours_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_head *head = to_xy3_head(dev);
	unsigned int component = xy3_attr_index(attr);
	const struct xy3_telemetry *now;

	guard(mutex)(&head->lock);
	now = xy3_telemetry(head);
	if (component >= now->hour_counts || now->hours[component] == XY3_HOURS_NONE)
		return -ENODATA;
	return sysfs_emit(buf, "%u\n", now->hours[component]);
}

static ssize_t frame_errors_show(struct device *dev, struct device_attribute *attr, char *buf)
{
	struct xy3_head *head = to_xy3_head(dev);
	unsigned int axis = xy3_attr_index(attr);
	const struct xy3_telemetry *now;

	guard(mutex)(&head->lock);
	now = xy3_telemetry(head);
	if (axis >= now->frame_error_counts)
		return -ENODATA;
	return sysfs_emit(buf, "%u\n", now->frame_errors[axis]);
}

/* filled in by xy3_sysfs_init() */
static struct xy3_attribute xy3_error_attributes[XY3_COMPONENTS];
static struct attribute *xy3_error_attrs[XY3_COMPONENTS + 1];
static struct xy3_attribute xy3_hours_attributes[XY3_COMPONENTS];
static struct attribute *xy3_hours_attrs[XY3_COMPONENTS + 1];
static struct xy3_attribute xy3_frame_error_attributes[XY3_AXES];
static struct attribute *xy3_frame_error_attrs[XY3_AXES + 1];

static const struct attribute_group xy3_error_group = {
	.name = "errors",
	.attrs = xy3_error_attrs,
};

static const struct attribute_group xy3_hours_group = {
	.name = "hours",
	.attrs = xy3_hours_attrs,
};

static const struct attribute_group xy3_frame_error_group = {
	.name = "frame_errors",
	.attrs = xy3_frame_error_attrs,
};

const struct attribute_group *xy3_head_groups[] = {
	&xy3_head_group,
	&xy3_stat_group,
	&xy3_error_group,
	&xy3_hours_group,
	&xy3_frame_error_group,
	NULL
};

static void __init xy3_fill(struct xy3_attribute *attributes, struct attribute **attrs,
			    unsigned int count, const char *(*name)(unsigned int index),
			    ssize_t (*show)(struct device *dev, struct device_attribute *attr,
					    char *buf))
{
	for (unsigned int i = 0; i < count; i++) {
		attributes[i].index = i;
		attributes[i].attr.attr.name = name(i);
		attributes[i].attr.attr.mode = 0444;
		attributes[i].attr.show = show;
		attrs[i] = &attributes[i].attr.attr;
	}
}

/**
 * xy3_sysfs_init() - create the attributes of components and axes
 */
void __init xy3_sysfs_init(void)
{
	xy3_fill(xy3_error_attributes, xy3_error_attrs, XY3_COMPONENTS, xy3_component_name,
		 error_show);
	xy3_fill(xy3_hours_attributes, xy3_hours_attrs, XY3_COMPONENTS, xy3_component_name,
		 hours_show);
	xy3_fill(xy3_frame_error_attributes, xy3_frame_error_attrs, XY3_AXES, xy3_axis_name,
		 frame_errors_show);
}

/* ---- the class ---- */

static ssize_t attach_show(const struct class *class, const struct class_attribute *attr,
			   char *buf)
{
	return xy3_choice_show(buf);
}

static ssize_t attach_store(const struct class *class, const struct class_attribute *attr,
			    const char *buf, size_t count)
{
	return xy3_choice_store(buf) ?: count;
}
static CLASS_ATTR_RW(attach);

static struct attribute *xy3_class_attrs[] = {
	&class_attr_attach.attr,
	NULL
};

static const struct attribute_group xy3_class_group = {
	.attrs = xy3_class_attrs,
};

const struct attribute_group *xy3_class_groups[] = {
	&xy3_class_group,
	NULL
};
