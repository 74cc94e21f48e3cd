// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: heads, and how their two channels are joined
 *
 * A head exists as long as it has a backchannel, a forward channel, or both. Firmware may define
 * which two belong together: the property lasia,forward of the backchannel points to the forward
 * channel. Otherwise a new channel joins the head chosen by the class attribute "attach": by
 * default the lowest-numbered head that lacks it, or a new head.
 */

#include <linux/err.h>
#include <linux/kernel.h>
#include <linux/list.h>
#include <linux/module.h>
#include <linux/property.h>
#include <linux/slab.h>
#include <linux/sysfs.h>

#include "xy3.h"

static bool autobaud;
module_param(autobaud, bool, 0644);
MODULE_PARM_DESC(autobaud, "New heads search for the rate of their backchannel (default: N)");

/* Protects the head of each forward channel while that reports room */
static DEFINE_SPINLOCK(xy3_room_lock);

/* Serialises attaching and detaching; protects the list and the choice */
static DEFINE_MUTEX(xy3_join_lock);
static LIST_HEAD(xy3_heads);	/* in ascending order of numbers */

static enum xy3_choice {
	XY3_CHOICE_AUTO,
	XY3_CHOICE_NEW,
	XY3_CHOICE_HEAD
} xy3_choice;
static unsigned int xy3_chosen_number;

enum xy3_side {
	XY3_BACK,
	XY3_FORWARD
};

static struct class xy3_class = {
	.name = "xy3",
	.class_groups = xy3_class_groups,
	.dev_groups = xy3_head_groups,
};

/* ---- the choice ---- */

/**
 * xy3_choice_show() - show the head of the next channel
 * @buf: a page for the text
 *
 * Return: length of the text.
 */
int xy3_choice_show(char *buf)
{
	guard(mutex)(&xy3_join_lock);
	switch (xy3_choice) {
	case XY3_CHOICE_NEW:
		return sysfs_emit(buf, "new\n");
	case XY3_CHOICE_HEAD:
		return sysfs_emit(buf, "xy3-%u\n", xy3_chosen_number);
	default:
		return sysfs_emit(buf, "auto\n");
	}
}

/**
 * xy3_choice_store() - choose the head of the next channel, unless firmware defines it
 * @buf: auto, new, or xy3-<n>
 *
 * Return: 0, or -EINVAL for anything else.
 */
int xy3_choice_store(const char *buf)
{
	enum xy3_choice choice;
	unsigned int number = 0;

	if (sysfs_streq(buf, "auto")) {
		choice = XY3_CHOICE_AUTO;
	} else if (sysfs_streq(buf, "new")) {
		choice = XY3_CHOICE_NEW;
	} else {
		if (strncmp(buf, "xy3-", 4) || kstrtouint(buf + 4, 10, &number) ||
		    number >= XY3_HEADS_MAX)
			return -EINVAL;
		choice = XY3_CHOICE_HEAD;
	}

	guard(mutex)(&xy3_join_lock);
	xy3_choice = choice;
	xy3_chosen_number = number;
	return 0;
}

static bool xy3_lacks(const struct xy3_head *head, enum xy3_side side)
{
	return side == XY3_BACK ? !head->back : !head->forward;
}

/* Firmware has assigned the forward channel of this head to another one */
static bool xy3_reserved(const struct xy3_head *head, enum xy3_side side)
{
	return side == XY3_FORWARD && head->back && head->back->partner;
}

/* The head that a channel joins unless firmware defines one; NULL for a new one */
static struct xy3_head *xy3_choose(enum xy3_side side)
{
	enum xy3_choice choice = xy3_choice;
	struct xy3_head *head;

	xy3_choice = XY3_CHOICE_AUTO;
	if (choice == XY3_CHOICE_NEW)
		return NULL;

	list_for_each_entry(head, &xy3_heads, node) {
		if (choice == XY3_CHOICE_HEAD && head->number == xy3_chosen_number)
			return xy3_lacks(head, side) ? head : ERR_PTR(-EBUSY);
		if (choice == XY3_CHOICE_AUTO && xy3_lacks(head, side) &&
		    !xy3_reserved(head, side))
			return head;
	}
	return choice == XY3_CHOICE_HEAD ? ERR_PTR(-ENODEV) : NULL;
}

/* ---- the life of a head ---- */

static void xy3_head_release(struct device *dev)
{
	kfree(to_xy3_head(dev));
}

static void xy3_head_insert(struct xy3_head *head)
{
	struct xy3_head *other;

	list_for_each_entry(other, &xy3_heads, node)
		if (other->number > head->number)
			break;
	list_add_tail(&head->node, &other->node);
}

static bool xy3_number_is_free(unsigned int number)
{
	struct xy3_head *head;

	list_for_each_entry(head, &xy3_heads, node)
		if (head->number == number)
			return false;
	return xy3_tty_is_free(number);
}

/* The lowest free number */
static int xy3_new_number(void)
{
	for (unsigned int number = 0; number < XY3_HEADS_MAX; number++)
		if (xy3_number_is_free(number))
			return number;
	return -ENOSPC;
}

/* Remove the interfaces of a head to user space, and stop what was started through them */
static void xy3_head_unregister(struct xy3_head *head)
{
	scoped_guard(mutex, &head->lock)
		head->gone = true;

	cancel_delayed_work_sync(&head->events.work);
	xy3_hwmon_remove(head);
	xy3_tty_remove(head);
	xy3_notify_removal(head);
	/* without the attributes and the tty, nothing can queue these again */
	cancel_delayed_work_sync(&head->autobaud.work);
	cancel_work_sync(&head->rate_request);
	put_device(&head->dev);
}

static struct xy3_head *xy3_head_new(void)
{
	struct xy3_head *head;
	int number, err;

	number = xy3_new_number();
	if (number < 0)
		return ERR_PTR(number);
	head = kzalloc(sizeof(*head), GFP_KERNEL);
	if (!head)
		return ERR_PTR(-ENOMEM);
	head->number = number;
	mutex_init(&head->rate_lock);
	spin_lock_init(&head->forward_lock);
	mutex_init(&head->lock);
	xy3_notify_init(head);
	xy3_rate_init(head);
	head->autobaud.on = autobaud;

	head->dev.class = &xy3_class;
	head->dev.release = xy3_head_release;
	device_initialize(&head->dev);
	err = dev_set_name(&head->dev, "xy3-%u", head->number);
	if (!err)
		err = device_add(&head->dev);
	if (err) {
		put_device(&head->dev);
		return ERR_PTR(err);
	}
	err = xy3_tty_add(head);
	if (err) {
		xy3_head_unregister(head);
		return ERR_PTR(err);
	}
	xy3_head_insert(head);
	return head;
}

/* The last channel was removed */
static void xy3_head_remove(struct xy3_head *head)
{
	list_del(&head->node);
	xy3_head_unregister(head);
}

/* ---- transports ---- */

/* A channel is about to be detached, under rate_lock, which a change of the rate may hold */
static void xy3_interrupt_rate_change(struct xy3_head *head)
{
	WRITE_ONCE(head->detaching, true);
	wake_up_all(&head->resync);
}

/*
 * The directory of the head has links to the devices of its channels. They are for tools only: if
 * there is no memory for a link, continue without.
 */
static void xy3_link(struct xy3_head *head, struct device *dev, const char *name)
{
	if (dev && sysfs_create_link(&head->dev.kobj, &dev->kobj, name))
		dev_dbg(&head->dev, "no link %s\n", name);
}

/* The forward channel that firmware defines for a backchannel */
static struct fwnode_handle *xy3_back_partner(const struct xy3_back *back)
{
	struct fwnode_handle *partner;

	if (!back->dev)
		return NULL;
	partner = fwnode_find_reference(dev_fwnode(back->dev), "lasia,forward", 0);
	return IS_ERR(partner) ? NULL : partner;
}

/* Set by firmware; otherwise the user has set the order */
static bool xy3_back_big_endian(const struct xy3_back *back)
{
	return back->dev && device_property_read_bool(back->dev, "big-endian");
}

static struct xy3_head *xy3_head_for_back(const struct xy3_back *back)
{
	struct xy3_head *head;

	if (!back->partner)
		return xy3_choose(XY3_BACK);
	list_for_each_entry(head, &xy3_heads, node)
		if (head->forward && dev_fwnode(head->forward->dev) == back->partner)
			return head->back ? ERR_PTR(-EBUSY) : head;
	return NULL;
}

static struct xy3_head *xy3_head_for_forward(const struct xy3_forward *forward)
{
	struct fwnode_handle *fwnode = dev_fwnode(forward->dev);
	struct xy3_head *head;

	if (fwnode)
		list_for_each_entry(head, &xy3_heads, node)
			if (head->back && head->back->partner == fwnode)
				return head->forward ? ERR_PTR(-EBUSY) : head;
	return xy3_choose(XY3_FORWARD);
}

/**
 * xy3_back_attach() - attach a backchannel to a head
 * @back: the backchannel; ops, dev and rate are filled in
 *
 * From now on its data may be passed to xy3_back_receive().
 *
 * Return: 0; -ENODEV or -EBUSY if the chosen head does not exist or has a backchannel; -ENOSPC
 * if there are XY3_HEADS_MAX heads; or another error of creating a head.
 */
int xy3_back_attach(struct xy3_back *back)
{
	struct xy3_head *head;

	xy3_tty_wait_hung();
	guard(mutex)(&xy3_join_lock);
	back->partner = xy3_back_partner(back);
	head = xy3_head_for_back(back);
	if (!head)
		head = xy3_head_new();
	if (IS_ERR(head)) {
		fwnode_handle_put(back->partner);
		return PTR_ERR(head);
	}

	back->head = head;
	scoped_guard(mutex, &head->rate_lock) {
		head->back = back;
		WRITE_ONCE(head->rate, back->rate);
	}
	scoped_guard(mutex, &head->lock) {
		if (xy3_back_big_endian(back))
			head->order = XY3_BIG_ENDIAN;
		xy3_autobaud_start(head);
		queue_work(system_dfl_wq, head->show_rate);
	}
	xy3_link(head, back->dev, "back");
	return 0;
}

/**
 * xy3_back_detach() - detach a backchannel
 * @back: the backchannel; xy3_back_receive() is not running for it
 */
void xy3_back_detach(struct xy3_back *back)
{
	struct xy3_head *head = back->head;

	guard(mutex)(&xy3_join_lock);
	sysfs_remove_link(&head->dev.kobj, "back");
	xy3_interrupt_rate_change(head);
	scoped_guard(mutex, &head->rate_lock) {
		WRITE_ONCE(head->detaching, false);
		head->back = NULL;
		WRITE_ONCE(head->rate, 0);
	}
	back->head = NULL;
	fwnode_handle_put(back->partner);
	if (!head->forward) {
		xy3_head_remove(head);
		return;
	}
	scoped_guard(mutex, &head->lock) {
		if (xy3_back_big_endian(back))
			head->order = XY3_LITTLE_ENDIAN;
		xy3_telemetry_forget(head);
	}
}

/**
 * xy3_forward_attach() - attach a forward channel to a head
 * @forward: the forward channel; ops and dev are filled in
 *
 * Return: 0, or an error of xy3_back_attach().
 */
int xy3_forward_attach(struct xy3_forward *forward)
{
	struct xy3_head *head;

	xy3_tty_wait_hung();
	guard(mutex)(&xy3_join_lock);
	head = xy3_head_for_forward(forward);
	if (!head)
		head = xy3_head_new();
	if (IS_ERR(head))
		return PTR_ERR(head);

	scoped_guard(spinlock_irqsave, &xy3_room_lock)
		forward->head = head;
	guard(mutex)(&head->rate_lock);
	scoped_guard(spinlock_irqsave, &head->forward_lock)
		head->forward = forward;
	xy3_link(head, forward->dev, "forward");
	return 0;
}
EXPORT_SYMBOL_GPL(xy3_forward_attach);

/**
 * xy3_forward_detach() - detach a forward channel
 * @forward: the forward channel; its ops are no longer called after return
 */
void xy3_forward_detach(struct xy3_forward *forward)
{
	struct xy3_head *head = forward->head;

	guard(mutex)(&xy3_join_lock);
	sysfs_remove_link(&head->dev.kobj, "forward");
	xy3_interrupt_rate_change(head);
	scoped_guard(mutex, &head->rate_lock) {
		WRITE_ONCE(head->detaching, false);
		scoped_guard(spinlock_irqsave, &head->forward_lock)
			head->forward = NULL;
	}
	scoped_guard(spinlock_irqsave, &xy3_room_lock)
		forward->head = NULL;
	/* a write() that waits for room fails now */
	xy3_tty_wakeup(head);
	if (!head->back)
		xy3_head_remove(head);
}
EXPORT_SYMBOL_GPL(xy3_forward_detach);

/**
 * xy3_forward_has_room() - report room for command frames
 * @forward: the forward channel; it need not be attached
 *
 * Call it when there is room after command() has returned -EAGAIN, and whenever there is more
 * room.
 *
 * Context: any.
 */
void xy3_forward_has_room(struct xy3_forward *forward)
{
	guard(spinlock_irqsave)(&xy3_room_lock);
	if (forward->head)
		xy3_tty_wakeup(forward->head);
}
EXPORT_SYMBOL_GPL(xy3_forward_has_room);

/**
 * xy3_head_init() - register the class
 *
 * Return: 0 or an error.
 */
int __init xy3_head_init(void)
{
	return class_register(&xy3_class);
}

/**
 * xy3_head_exit() - unregister the class; no heads are left
 */
void xy3_head_exit(void)
{
	class_unregister(&xy3_class);
}
