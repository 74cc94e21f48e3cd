/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Both ends of the driver of scanheads, for its KUnit suites: the common part
 *
 *   the call log     all calls of the forward channel and the UART, in order
 *   struct forward   a forward channel that accepts command frames, or refuses them
 *   struct sync_source  sends sync packets to a UART that listens at its rate
 *   heads            found by name, as for users; their attributes, called like by sysfs
 *
 * Included by one file of a module only, so all of it is static. Of the symbols of the driver only
 * the two for forward channels are used; its structures are read where no attribute shows them.
 */
#ifndef XY3_RIG_H
#define XY3_RIG_H

#include <kunit/device.h>
#include <kunit/test.h>
#include <linux/device.h>
#include <linux/ktime.h>
#include <linux/of.h>
#include <linux/slab.h>
#include <linux/spinlock.h>
#include <linux/sysfs.h>
#include <linux/tty.h>
#include <linux/wait.h>

#include "xy3.h"

#define CALLS_MAX	64

/* Bytes of a stream */
#define SYNC		0x48, 0x41, 0x00
#define TEXT_PACKET(type, length)	0x48, (type), (length)

/* ---- the call log ---- */

enum event {
	NOTHING,
	FRAME,		/* the forward channel got this frame */
	NO_FRAME,	/* ... and refused it */
	UART,		/* the UART was set to this rate */
	NO_UART		/* the UART does not support this requested rate */
};

struct call {
	enum event event;
	u32 value;
	s64 ms;
};

static DEFINE_SPINLOCK(call_log_lock);
static struct call call_log[CALLS_MAX];
static unsigned int call_log_count;
static DECLARE_WAIT_QUEUE_HEAD(call_logged);

static void log_call(enum event event, u32 value)
{
	scoped_guard(spinlock_irqsave, &call_log_lock) {
		if (call_log_count < CALLS_MAX)
			call_log[call_log_count] = (struct call){ event, value,
								 ktime_to_ms(ktime_get()) };
		call_log_count++;
	}
	wake_up(&call_logged);
}

static inline unsigned int call_count(void)
{
	guard(spinlock_irqsave)(&call_log_lock);
	return call_log_count;
}

/* After a change of the rate in a search: data from now on were received at the new rate */
#define SETTLED_MS	100

/* Wait until there are @n entries */
static inline bool wait_calls(unsigned int n)
{
	return wait_event_timeout(call_logged, call_count() >= n, 200 * HZ);
}

static void clear_call_log(void)
{
	guard(spinlock_irqsave)(&call_log_lock);
	call_log_count = 0;
}

static void expect_calls(struct kunit *test, const struct call *want, unsigned int n)
{
	struct call got[CALLS_MAX];
	unsigned int count;

	scoped_guard(spinlock_irqsave, &call_log_lock) {
		memcpy(got, call_log, sizeof(got));
		count = call_log_count;
		call_log_count = 0;
	}
	KUNIT_EXPECT_EQ(test, count, n);
	for (unsigned int i = 0; i < min3(count, n, CALLS_MAX); i++)
		KUNIT_EXPECT_TRUE_MSG(test, got[i].event == want[i].event &&
				      got[i].value == want[i].value,
				      "entry %u is %d/%u (%xh), not %d/%u (%xh)", i,
				      got[i].event, got[i].value, got[i].value,
				      want[i].event, want[i].value, want[i].value);
}

#define EXPECT_CALLS(test, ...) do {							\
	static const struct call __want[] = { __VA_ARGS__ };				\
											\
	expect_calls(test, __want, ARRAY_SIZE(__want));				\
} while (0)

static inline void expect_no_call(struct kunit *test)
{
	expect_calls(test, NULL, 0);
}

/* ---- forward channels ---- */

/**
 * struct forward - a forward channel
 * @xy3: its structure in the driver
 * @error: error for all frames, if not 0
 * @limited: it only accepts @room frames
 * @room: decremented by each frame
 * @stuck: it accepts frames but does not send them
 * @unsent: result of drain() otherwise
 */
struct forward {
	struct xy3_forward xy3;
	int error;
	bool limited;
	unsigned int room;
	bool stuck;
	int unsent;
};

static unsigned int rig_numbers;	/* names of devices and nodes must differ */

static int forward_command(struct xy3_forward *xy3, const u8 *raw, size_t size)
{
	struct forward *forward = container_of(xy3, struct forward, xy3);
	u32 frame = 0;

	lockdep_assert_held(&xy3->head->forward_lock);
	if (forward->limited && !forward->room)
		return -EAGAIN;
	forward->room--;
	for (size_t i = 0; i < size; i++)
		frame = frame << 8 | raw[i];
	log_call(forward->error ? NO_FRAME : FRAME, frame);
	return forward->error;
}

static unsigned int forward_room(struct xy3_forward *xy3)
{
	struct forward *forward = container_of(xy3, struct forward, xy3);

	lockdep_assert_held(&xy3->head->forward_lock);
	return forward->limited ? forward->room : 1000;
}

static int forward_drain(struct xy3_forward *xy3, unsigned long timeout)
{
	struct forward *forward = container_of(xy3, struct forward, xy3);

	lockdep_assert_held(&xy3->head->rate_lock);
	if (!forward->stuck)
		return forward->unsent;
	schedule_timeout_uninterruptible(timeout);
	return 1;
}

static const struct xy3_forward_ops forward_ops = {
	.command = forward_command,
	.room = forward_room,
	.drain = forward_drain,
};

static bool forward_attached(const struct forward *forward)
{
	return forward->xy3.head;
}

static void forward_leave(void *data)
{
	struct forward *forward = data;

	if (forward_attached(forward))
		xy3_forward_detach(&forward->xy3);
}

/* A forward channel that is not attached yet; @np is its firmware node, or NULL */
static struct forward *forward_make(struct kunit *test, struct device_node *np)
{
	struct forward *forward = kunit_kzalloc(test, sizeof(*forward), GFP_KERNEL);
	char name[32];

	KUNIT_ASSERT_NOT_NULL(test, forward);
	snprintf(name, sizeof(name), "xy3-rig-forward%u", rig_numbers++);
	forward->xy3.ops = &forward_ops;
	forward->xy3.dev = kunit_device_register(test, name);
	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, forward->xy3.dev);
	if (np)
		device_set_node(forward->xy3.dev, of_fwnode_handle(np));
	KUNIT_ASSERT_EQ(test, 0, kunit_add_action_or_reset(test, forward_leave, forward));
	return forward;
}

static inline struct forward *forward_come(struct kunit *test)
{
	struct forward *forward = forward_make(test, NULL);

	KUNIT_ASSERT_EQ(test, 0, xy3_forward_attach(&forward->xy3));
	return forward;
}

/* ---- a head that sends ---- */

/**
 * struct sync_source - sends sync packets periodically
 * @send: sends them to @data, if it listens at the rate
 * @data: a UART
 * @rate: in bit/s
 * @work: calls @send
 */
struct sync_source {
	void (*send)(void *data, unsigned int rate);
	void *data;
	unsigned int rate;
	struct delayed_work work;
};

static void sync_source_work(struct work_struct *work)
{
	struct sync_source *source = container_of(to_delayed_work(work), struct sync_source, work);

	source->send(source->data, READ_ONCE(source->rate));
	schedule_delayed_work(&source->work, HZ / 10);
}

static void sync_source_stop(void *data)
{
	struct sync_source *source = data;

	cancel_delayed_work_sync(&source->work);
}

static inline struct sync_source *
sync_source_start(struct kunit *test, void (*send)(void *data, unsigned int rate), void *data,
		  unsigned int rate)
{
	struct sync_source *source = kunit_kzalloc(test, sizeof(*source), GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, source);
	source->send = send;
	source->data = data;
	source->rate = rate;
	INIT_DELAYED_WORK(&source->work, sync_source_work);
	schedule_delayed_work(&source->work, 0);
	KUNIT_ASSERT_EQ(test, 0, kunit_add_action_or_reset(test, sync_source_stop, source));
	return source;
}

/* ---- heads ---- */

static const struct class *xy3_class;
static char *rig_page;		/* the page for attributes */

/* The head of this number, or NULL; it exists as long as one of its transports */
static inline struct xy3_head *head_of_number(unsigned int number)
{
	struct device *dev;
	char name[16];

	snprintf(name, sizeof(name), "xy3-%u", number);
	dev = class_find_device_by_name(xy3_class, name);
	put_device(dev);
	return dev ? to_xy3_head(dev) : NULL;
}

static int count_head(struct device *dev, void *data)
{
	++*(unsigned int *)data;
	return 0;
}

static unsigned int heads(void)
{
	unsigned int count = 0;

	class_for_each_device(xy3_class, NULL, &count, count_head);
	return count;
}

/* @path is relative to the directory of the head: NAME or GROUP/NAME */
static struct attribute *find_attribute(const struct attribute_group *const *groups,
					const char *path)
{
	const char *slash = strchr(path, '/');
	size_t length = slash ? slash - path : 0;

	for (; *groups; groups++) {
		const char *group = (*groups)->name ?: "";

		if (strlen(group) != length || strncmp(group, path, length))
			continue;
		for (struct attribute **attr = (*groups)->attrs; *attr; attr++)
			if (!strcmp((*attr)->name, slash ? slash + 1 : path))
				return *attr;
	}
	return NULL;
}

static ssize_t show_in(struct device *dev, const struct attribute_group *const *groups,
		       const char *path)
{
	struct attribute *attr = find_attribute(groups, path);
	struct device_attribute *device_attr;

	rig_page[0] = '\0';
	if (!attr)
		return -ENOENT;
	device_attr = container_of(attr, struct device_attribute, attr);
	if (!device_attr->show)
		return -EACCES;
	return device_attr->show(dev, device_attr, rig_page);
}

static ssize_t show(struct xy3_head *head, const char *path)
{
	return show_in(&head->dev, head->dev.class->dev_groups, path);
}

/* 0 if all of @text was accepted, or the error */
static int store(struct xy3_head *head, const char *path, const char *text)
{
	struct attribute *attr = find_attribute(head->dev.class->dev_groups, path);
	struct device_attribute *device_attr;
	ssize_t taken;

	if (!attr)
		return -ENOENT;
	device_attr = container_of(attr, struct device_attribute, attr);
	if (!device_attr->store)
		return -EACCES;
	taken = device_attr->store(&head->dev, device_attr, text, strlen(text));
	return taken < 0 ? taken : taken != strlen(text) ? -EIO : 0;
}

#define EXPECT_SHOWS(test, head, path, text) do {					\
	ssize_t __length = show(head, path);						\
											\
	KUNIT_EXPECT_GT_MSG(test, __length, 0, "%s", path);				\
	KUNIT_EXPECT_STREQ_MSG(test, rig_page, text "\n", "%s", path);			\
} while (0)

#define EXPECT_SHOWS_ERROR(test, head, path, error)					\
	KUNIT_EXPECT_EQ_MSG(test, show(head, path), (ssize_t)(error), "%s", path)

/* ---- the suite ---- */

static int rig_suite_init(void)
{
	struct forward forward = { .xy3 = { .ops = &forward_ops } };
	struct device *parent = root_device_register("xy3-rig");
	int err;

	if (IS_ERR(parent))
		return PTR_ERR(parent);
	rig_page = (char *)get_zeroed_page(GFP_KERNEL);
	if (!rig_page) {
		root_device_unregister(parent);
		return -ENOMEM;
	}
	/* the class can only be accessed by a head */
	forward.xy3.dev = parent;
	err = xy3_forward_attach(&forward.xy3);
	if (!err) {
		xy3_class = forward.xy3.head->dev.class;
		xy3_forward_detach(&forward.xy3);
	}
	root_device_unregister(parent);
	if (err)
		free_page((unsigned long)rig_page);
	return err;
}

static void rig_suite_exit(void)
{
	free_page((unsigned long)rig_page);
	rig_page = NULL;
}

#endif /* XY3_RIG_H */
