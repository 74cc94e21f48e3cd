// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: notification of user space
 *
 * A worker wakes up pollers, sends uevents and adds temperature sensors to hwmon. Notifications are
 * limited to one round per 100 ms, whatever the head sends.
 */

#include <linux/bitops.h>
#include <linux/device.h>
#include <linux/jiffies.h>
#include <linux/kernel.h>
#include <linux/kobject.h>
#include <linux/lockdep.h>
#include <linux/string.h>
#include <linux/sysfs.h>

#include "xy3.h"

#define XY3_NOTIFY_MS	100

static void xy3_uevent(struct xy3_head *head, char *properties[])
{
	kobject_uevent_env(&head->dev.kobj, KOBJ_CHANGE, properties);
}

static void xy3_notify_sync(struct xy3_head *head, bool in_sync)
{
	char *properties[] = {
		"XY3_EVENT=sync", in_sync ? "XY3_IN_SYNC=1" : "XY3_IN_SYNC=0", NULL
	};

	sysfs_notify(&head->dev.kobj, NULL, "in_sync");
	xy3_uevent(head, properties);
}

static void xy3_notify_error(struct xy3_head *head, unsigned int component, bool known, u8 error)
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
	xy3_uevent(head, properties);
}

static void xy3_notify_identity(struct xy3_head *head)
{
	char *properties[] = { "XY3_EVENT=identity", NULL };

	xy3_uevent(head, properties);
	/* udev names links by this */
	kobject_uevent(&head->tty->kobj, KOBJ_CHANGE);
}

static void xy3_notify_work(struct work_struct *work)
{
	struct xy3_head *head = container_of(to_delayed_work(work), struct xy3_head, events.work);
	u8 error[XY3_COMPONENTS];
	unsigned int known;
	u32 errors, thermometers;
	bool sync, in_sync, identity;

	scoped_guard(mutex, &head->lock) {
		const struct xy3_telemetry *now = xy3_telemetry(head);
		struct xy3_events *events = &head->events;

		errors = events->errors;
		sync = events->sync;
		identity = events->identity;
		thermometers = events->thermometers;
		in_sync = head->parser.in_sync;
		memcpy(error, now->error, sizeof(error));
		known = now->errors;
		events->errors = 0;
		events->sync = false;
		events->identity = false;
		events->next = get_jiffies_64() + msecs_to_jiffies(XY3_NOTIFY_MS);
	}

	if (sync)
		xy3_notify_sync(head, in_sync);
	if (identity)
		xy3_notify_identity(head);
	for (unsigned int i = 0; i < XY3_COMPONENTS; i++)
		if (errors & BIT(i))
			xy3_notify_error(head, i, i < known, error[i]);
	xy3_hwmon_update(head, thermometers);
}

/**
 * xy3_notify_schedule() - schedule notification of user space
 * @head: the head; its lock is held
 */
void xy3_notify_schedule(struct xy3_head *head)
{
	u64 now = get_jiffies_64();
	unsigned long delay = head->events.next > now ? head->events.next - now : 0;

	lockdep_assert_held(&head->lock);
	if (head->gone)
		return;
	queue_delayed_work(system_percpu_wq, &head->events.work, delay);
}

/**
 * xy3_notify_removal() - remove the device of a head, and wake up pollers of its attributes
 * @head: the head; its worker does not run
 *
 * device_del() does not wake them, and before it they would find nothing changed, and wait again.
 */
void xy3_notify_removal(struct xy3_head *head)
{
	struct kernfs_node *folder = head->dev.kobj.sd;
	struct kernfs_node *errors = sysfs_get_dirent(folder, "errors");
	struct kernfs_node *pollable[XY3_COMPONENTS + 1];

	for (unsigned int i = 0; i < XY3_COMPONENTS; i++)
		pollable[i] = sysfs_get_dirent(errors, xy3_component_name(i));
	pollable[XY3_COMPONENTS] = sysfs_get_dirent(folder, "in_sync");
	device_del(&head->dev);
	for (unsigned int i = 0; i < ARRAY_SIZE(pollable); i++) {
		sysfs_notify_dirent(pollable[i]);
		sysfs_put(pollable[i]);
	}
	sysfs_put(errors);
}

/**
 * xy3_notify_init() - prepare a new head
 * @head: the head
 */
void xy3_notify_init(struct xy3_head *head)
{
	INIT_DELAYED_WORK(&head->events.work, xy3_notify_work);
}
