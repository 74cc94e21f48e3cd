// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: what the head reports, and how user space is told of it
 *
 * Packets change the state at once. A worker tells of it: it wakes pollers, sends uevents and
 * lets hwmon have new thermometers. It does so at most once in 100 ms, whatever the head does.
 */

#include <linux/bitops.h>
#include <linux/jiffies.h>
#include <linux/kobject.h>
#include <linux/minmax.h>
#include <linux/string.h>
#include <linux/sysfs.h>

#include "xy3.h"

#define XY3_NEWS_MS	100

/* ---- state ---- */

static void xy3_take_text(struct xy3_head *head, enum xy3_text which,
			  const struct xy3_packet *packet)
{
	char text[XY3_TEXT_MAX + 1];

	xy3_packet_text(packet, text, sizeof(text));
	if (!strcmp(text, head->telemetry.text[which]))
		return;
	strscpy(head->telemetry.text[which], text, sizeof(head->telemetry.text[which]));
	head->news.identity = true;
}

static void xy3_take_temperatures(struct xy3_head *head, const struct xy3_packet *packet)
{
	struct xy3_telemetry *now = &head->telemetry;

	now->temperatures = xy3_packet_temperatures(packet, head->order, now->temperature);
	for (unsigned int i = 0; i < now->temperatures; i++)
		if (now->temperature[i] != XY3_TEMPERATURE_NONE)
			head->news.thermometers |= BIT(i);
}

/*
 * What the newest packet leaves out keeps its error, which the head has not called over; it is no
 * longer shown. That is a change of a component that has an error, as is the end of it.
 */
static void xy3_set_errors(struct xy3_head *head, unsigned int count, const u8 *error)
{
	struct xy3_telemetry *now = &head->telemetry;

	for (unsigned int i = 0; i < XY3_COMPONENTS; i++) {
		bool had_error = now->error[i] != XY3_ERROR_NONE;

		if (i >= count) {
			if (i < now->errors && had_error)
				head->news.errors |= BIT(i);
			continue;
		}
		if (now->error[i] != error[i] || (i >= now->errors && had_error))
			head->news.errors |= BIT(i);
		now->error[i] = error[i];
	}
	now->errors = count;
}

static void xy3_take_errors(struct xy3_head *head, const struct xy3_packet *packet)
{
	u8 error[XY3_COMPONENTS];
	unsigned int count = xy3_packet_errors(packet, error);

	xy3_set_errors(head, count, error);
}

/**
 * xy3_telemetry_packet() - take in what a packet says
 * @head: the head; its lock is held
 * @packet: the packet
 */
void xy3_telemetry_packet(struct xy3_head *head, const struct xy3_packet *packet)
{
	struct xy3_telemetry *now = &head->telemetry;
	u32 thermometers = head->news.thermometers;

	switch (packet->type) {
	case XY3_PACKET_VENDOR:
		xy3_take_text(head, XY3_VENDOR, packet);
		break;
	case XY3_PACKET_MODEL:
		xy3_take_text(head, XY3_MODEL, packet);
		break;
	case XY3_PACKET_FIRMWARE:
		xy3_take_text(head, XY3_FIRMWARE, packet);
		break;
	case XY3_PACKET_SERIAL:
		xy3_take_text(head, XY3_SERIAL, packet);
		break;
	case XY3_PACKET_TEMPERATURES:
		xy3_take_temperatures(head, packet);
		break;
	case XY3_PACKET_FRAME_ERRORS:
		now->frame_error_counts =
			xy3_packet_frame_errors(packet, head->order, now->frame_errors);
		break;
	case XY3_PACKET_ERRORS:
		xy3_take_errors(head, packet);
		break;
	case XY3_PACKET_HOURS:
		now->hour_counts = xy3_packet_hours(packet, head->order, now->hours);
		break;
	default:
		return;
	}
	if (head->news.identity || head->news.errors || head->news.thermometers != thermometers)
		xy3_news_later(head);
}

/**
 * xy3_telemetry_forget_numbers() - forget what was read in another byte order
 * @head: the head; its lock is held
 */
void xy3_telemetry_forget_numbers(struct xy3_head *head)
{
	head->telemetry.temperatures = 0;
	head->telemetry.hour_counts = 0;
	head->telemetry.frame_error_counts = 0;
}

/**
 * xy3_telemetry_forget() - forget all: the backchannel has gone, and sync with it
 * @head: the head; its lock is held
 */
void xy3_telemetry_forget(struct xy3_head *head)
{
	struct xy3_telemetry *now = &head->telemetry;

	head->news.sync |= head->parser.in_sync;
	xy3_parse_lost(&head->parser, 0);
	xy3_set_errors(head, 0, NULL);
	for (unsigned int i = 0; i < XY3_TEXTS; i++)
		head->news.identity |= now->text[i][0] != '\0';
	memset(now->text, 0, sizeof(now->text));
	xy3_telemetry_forget_numbers(head);
	xy3_news_later(head);
}

/* ---- news ---- */

static void xy3_tell(struct xy3_head *head, char *properties[])
{
	kobject_uevent_env(&head->dev.kobj, KOBJ_CHANGE, properties);
}

static void xy3_tell_sync(struct xy3_head *head, bool in_sync)
{
	char *properties[] = {
		"XY3_EVENT=sync", in_sync ? "XY3_IN_SYNC=1" : "XY3_IN_SYNC=0", NULL
	};

	sysfs_notify(&head->dev.kobj, NULL, "in_sync");
	xy3_tell(head, properties);
}

static void xy3_tell_error(struct xy3_head *head, unsigned int component, bool known, u8 error)
{
	char part[32], name[32], code[32];
	char *properties[] = { "XY3_EVENT=error", part, name, known ? code : NULL, NULL };

	snprintf(part, sizeof(part), "XY3_COMPONENT=%s", xy3_component_name(component));
	if (!known)
		strscpy(name, "XY3_ERROR=unknown", sizeof(name));
	else if (xy3_error_name(error))
		snprintf(name, sizeof(name), "XY3_ERROR=%s", xy3_error_name(error));
	else
		snprintf(name, sizeof(name), "XY3_ERROR=%u", error);
	snprintf(code, sizeof(code), "XY3_ERROR_CODE=%u", error);

	sysfs_notify(&head->dev.kobj, "errors", xy3_component_name(component));
	xy3_tell(head, properties);
}

static void xy3_tell_identity(struct xy3_head *head)
{
	char *properties[] = { "XY3_EVENT=identity", NULL };

	xy3_tell(head, properties);
	/* links that udev makes to it are named by this */
	kobject_uevent(&head->tty->kobj, KOBJ_CHANGE);
}

static void xy3_news_work(struct work_struct *work)
{
	struct xy3_head *head = container_of(to_delayed_work(work), struct xy3_head, news.work);
	u8 error[XY3_COMPONENTS];
	unsigned int known;
	u32 errors, thermometers;
	bool sync, in_sync, identity;

	scoped_guard(mutex, &head->lock) {
		struct xy3_news *news = &head->news;

		errors = news->errors;
		sync = news->sync;
		identity = news->identity;
		thermometers = news->thermometers;
		in_sync = head->parser.in_sync;
		memcpy(error, head->telemetry.error, sizeof(error));
		known = head->telemetry.errors;
		news->errors = 0;
		news->sync = false;
		news->identity = false;
		news->next = jiffies + msecs_to_jiffies(XY3_NEWS_MS);
	}

	if (sync)
		xy3_tell_sync(head, in_sync);
	if (identity)
		xy3_tell_identity(head);
	for (unsigned int i = 0; i < XY3_COMPONENTS; i++)
		if (errors & BIT(i))
			xy3_tell_error(head, i, i < known, error[i]);
	xy3_hwmon_update(head, thermometers);
}

/**
 * xy3_news_later() - have user space told of what has changed
 * @head: the head; its lock is held
 */
void xy3_news_later(struct xy3_head *head)
{
	unsigned long delay = 0;

	if (head->gone)
		return;
	if (time_before(jiffies, head->news.next))
		delay = head->news.next - jiffies;
	queue_delayed_work(system_percpu_wq, &head->news.work, delay);
}

/**
 * xy3_telemetry_init() - prepare a new head
 * @head: the head
 */
void xy3_telemetry_init(struct xy3_head *head)
{
	head->news.next = jiffies;
	INIT_DELAYED_WORK(&head->news.work, xy3_news_work);
}
