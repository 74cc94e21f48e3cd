/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Both ends of the driver of a pendant, for its KUnit suite
 *
 *   struct pendant   a HID transport (struct hid_ll_driver) with a pendant on it: sends any
 *                    report, records received feature reports, stalls, waits
 *   user             an input handler that records all events
 *
 * Included by one file only, so all of it is static.
 */
#ifndef XHC_HID_RIG_H
#define XHC_HID_RIG_H

#include <kunit/test.h>
#include <linux/completion.h>
#include <linux/hid.h>
#include <linux/input.h>
#include <linux/ktime.h>
#include <linux/slab.h>
#include <linux/spinlock.h>
#include <linux/sysfs.h>
#include <linux/wait.h>
#include <linux/workqueue.h>

#define FRAME_CHUNKS	6		/* HB04 */
#define CHUNKS_MAX	256
#define EVENTS_MAX	64

/* As in units in the field: input report 4 with 5 bytes, feature report 6 with 7 */
#define DESC_INPUT(id, bytes)								\
	0x06, 0x00, 0xff, 0x09, 0x01, 0xa1, 0x01, 0x85, (id), 0x09, 0x01, 0x15, 0x00,	\
	0x26, 0xff, 0x00, 0x95, (bytes), 0x75, 0x08, 0x81, 0x02, 0xc0
#define DESC_FEATURE(id, bytes)								\
	0x06, 0x00, 0xff, 0x09, 0x01, 0xa1, 0x01, 0x85, (id), 0x09, 0x01, 0x15, 0x00,	\
	0x26, 0xff, 0x00, 0x95, (bytes), 0x75, 0x08, 0xb1, 0x06, 0xc0

static const u8 good_desc[] = { DESC_INPUT(4, 5), DESC_FEATURE(6, 7) };

/**
 * struct pendant - a pendant on a mock transport
 * @hdev: its HID device
 * @desc: its report descriptor
 * @desc_size: bytes in @desc
 * @power: power requests of the transport, FULLON minus NORMAL
 * @opened: opens of the transport minus closes
 * @started: starts of the transport minus stops
 * @lock: protects the following members
 * @chunk: received feature reports
 * @at: time of each of them
 * @chunks: number of feature reports
 * @error: result of a feature report while @errors is not 0
 * @errors: number of further feature reports that fail with @error
 * @hold: feature reports wait for @release
 * @held: completed when a feature report starts to wait
 * @release: lets it continue
 * @came: woken for each feature report
 */
struct pendant {
	struct hid_device *hdev;
	const u8 *desc;
	unsigned int desc_size;
	int power;
	int opened;
	int started;
	spinlock_t lock;	/* all following members except @held, @release and @came */
	u8 chunk[CHUNKS_MAX][8];
	ktime_t at[CHUNKS_MAX];
	unsigned int chunks;
	int error;
	unsigned int errors;
	bool hold;
	struct completion held;
	struct completion release;
	wait_queue_head_t came;
};

/* ---- the transport ---- */

static int pendant_parse(struct hid_device *hdev)
{
	struct pendant *pendant = hdev->driver_data;

	return hid_parse_report(hdev, (u8 *)pendant->desc, pendant->desc_size);
}

static int pendant_start(struct hid_device *hdev)
{
	((struct pendant *)hdev->driver_data)->started++;
	return 0;
}

static void pendant_stop(struct hid_device *hdev)
{
	((struct pendant *)hdev->driver_data)->started--;
}

static int pendant_open(struct hid_device *hdev)
{
	((struct pendant *)hdev->driver_data)->opened++;
	return 0;
}

static void pendant_close(struct hid_device *hdev)
{
	((struct pendant *)hdev->driver_data)->opened--;
}

static int pendant_power(struct hid_device *hdev, int level)
{
	((struct pendant *)hdev->driver_data)->power += level == PM_HINT_FULLON ? 1 : -1;
	return 0;
}

static int pendant_raw_request(struct hid_device *hdev, unsigned char id, __u8 *buf, size_t len,
			       unsigned char rtype, int reqtype)
{
	struct pendant *pendant = hdev->driver_data;
	int error = 0;

	if (rtype != HID_FEATURE_REPORT || reqtype != HID_REQ_SET_REPORT || id != 6 || len != 8)
		return -EPROTO;

	if (READ_ONCE(pendant->hold)) {
		complete(&pendant->held);
		wait_for_completion(&pendant->release);
	}

	scoped_guard(spinlock, &pendant->lock) {
		if (pendant->chunks < CHUNKS_MAX) {
			memcpy(pendant->chunk[pendant->chunks], buf, 8);
			pendant->at[pendant->chunks] = ktime_get();
		}
		pendant->chunks++;
		if (pendant->errors) {
			pendant->errors--;
			error = pendant->error;
		}
	}
	wake_up(&pendant->came);
	return error ?: (int)len;
}

static const struct hid_ll_driver pendant_ll_driver = {
	.parse = pendant_parse,
	.start = pendant_start,
	.stop = pendant_stop,
	.open = pendant_open,
	.close = pendant_close,
	.power = pendant_power,
	.raw_request = pendant_raw_request,
};

static unsigned int pendant_chunks(struct pendant *pendant)
{
	guard(spinlock)(&pendant->lock);
	return pendant->chunks;
}

/* Make the next @errors feature reports fail with @error */
static __maybe_unused void pendant_fail(struct pendant *pendant, int error, unsigned int errors)
{
	guard(spinlock)(&pendant->lock);
	pendant->error = error;
	pendant->errors = errors;
}

static bool pendant_wait_chunks(struct pendant *pendant, unsigned int n)
{
	return wait_event_timeout(pendant->came, pendant_chunks(pendant) >= n, 5 * HZ);
}

/* A held transfer continues in 200 ms */
static struct {
	struct delayed_work work;
	struct pendant *pendant;
} later;

static inline void release_work(struct work_struct *work)
{
	complete_all(&later.pendant->release);
}

static inline void pendant_release_later(struct pendant *pendant)
{
	later.pendant = pendant;
	INIT_DELAYED_WORK(&later.work, release_work);
	schedule_delayed_work(&later.work, HZ / 5);
}

static void pendant_unplug(void *data)
{
	struct pendant *pendant = data;

	if (pendant->hdev)
		hid_destroy_device(pendant->hdev);
	pendant->hdev = NULL;
}

static struct pendant *pendant_plug(struct kunit *test, u32 product, const u8 *desc,
				    unsigned int desc_size)
{
	struct pendant *pendant = kunit_kzalloc(test, sizeof(*pendant), GFP_KERNEL);
	struct hid_device *hdev;

	KUNIT_ASSERT_NOT_NULL(test, pendant);
	spin_lock_init(&pendant->lock);
	init_waitqueue_head(&pendant->came);
	init_completion(&pendant->held);
	init_completion(&pendant->release);
	pendant->desc = desc;
	pendant->desc_size = desc_size;

	hdev = hid_allocate_device();
	KUNIT_ASSERT_NOT_ERR_OR_NULL(test, hdev);
	hdev->driver_data = pendant;
	hdev->ll_driver = (struct hid_ll_driver *)&pendant_ll_driver;
	hdev->bus = BUS_USB;
	hdev->vendor = 0x10ce;
	hdev->product = product;
	strscpy(hdev->name, "KUnit pendant", sizeof(hdev->name));
	strscpy(hdev->phys, "kunit/input0", sizeof(hdev->phys));
	pendant->hdev = hdev;
	KUNIT_ASSERT_EQ(test, 0, kunit_add_action_or_reset(test, pendant_unplug, pendant));
	KUNIT_ASSERT_EQ(test, 0, hid_add_device(hdev));
	return pendant;
}

static bool pendant_bound(struct pendant *pendant)
{
	return pendant->hdev->dev.driver &&
		!strcmp(pendant->hdev->dev.driver->name, "hid-xhc");
}

static struct pendant *pendant_good(struct kunit *test)
{
	struct pendant *pendant = pendant_plug(test, 0xeb70, good_desc, sizeof(good_desc));

	KUNIT_ASSERT_TRUE_MSG(test, pendant_bound(pendant), "is hid-xhc loaded?");
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, FRAME_CHUNKS));
	return pendant;
}

/* Memory of exactly @size bytes: KASAN detects that the driver reads beyond it */
static void pendant_report(struct kunit *test, struct pendant *pendant, const u8 *data, size_t size)
{
	u8 *copy = kunit_kmalloc(test, size, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, copy);
	memcpy(copy, data, size);
	hid_input_report(pendant->hdev, HID_INPUT_REPORT, copy, size, 1);
	kunit_kfree(test, copy);
}

#define REPORT(test, pendant, ...) do {							\
	static const u8 __report[] = { __VA_ARGS__ };					\
											\
	pendant_report(test, pendant, __report, sizeof(__report));			\
} while (0)

/* The day that the pendant was sent last */
static __maybe_unused u8 pendant_day(struct pendant *pendant)
{
	guard(spinlock)(&pendant->lock);
	for (unsigned int i = min(pendant->chunks, CHUNKS_MAX); i-- > 0;)
		if (pendant->chunk[i][1] == 0xfe && pendant->chunk[i][2] == 0xfd)
			return pendant->chunk[i][3];
	return 0;
}

/* A report without a key, by which the pendant returns @day */
static inline void pendant_report_day(struct kunit *test, struct pendant *pendant, u8 selector,
				      u8 day)
{
	u8 report[6] = { 4, 0, 0, selector, 0, day };

	pendant_report(test, pendant, report, sizeof(report));
}

/* ---- attributes ---- */

static struct device_attribute *attribute(struct device *dev, const char *folder,
					  const char *name, struct kernfs_node **node)
{
	struct kernfs_node *in = NULL;

	if (folder) {
		in = sysfs_get_dirent(dev->kobj.sd, folder);
		if (!in)
			return NULL;
	}
	*node = sysfs_get_dirent(in ?: dev->kobj.sd, name);
	sysfs_put(in);
	return *node ? container_of((struct attribute *)(*node)->priv,
				    struct device_attribute, attr) : NULL;
}

/* -> the number that an attribute shows, or an error */
static int attribute_get(struct kunit *test, struct device *dev, const char *folder,
			 const char *name)
{
	struct device_attribute *attr;
	struct kernfs_node *node;
	int err, number;
	char *page;

	attr = attribute(dev, folder, name, &node);
	KUNIT_ASSERT_NOT_NULL_MSG(test, attr, "there is no attribute %s", name);
	page = kunit_kzalloc(test, PAGE_SIZE, GFP_KERNEL);
	KUNIT_ASSERT_NOT_NULL(test, page);
	err = attr->show(dev, attr, page);
	sysfs_put(node);
	if (err >= 0)
		err = kstrtoint(page, 10, &number);
	kunit_kfree(test, page);
	return err ?: number;
}

static int attribute_set(struct kunit *test, struct device *dev, const char *folder,
			 const char *name, const char *text)
{
	struct device_attribute *attr;
	struct kernfs_node *node;
	ssize_t ret;

	attr = attribute(dev, folder, name, &node);
	KUNIT_ASSERT_NOT_NULL_MSG(test, attr, "there is no attribute %s", name);
	ret = attr->store(dev, attr, text, strlen(text));
	sysfs_put(node);
	return ret < 0 ? ret : 0;
}

static int pendant_stat(struct kunit *test, struct pendant *pendant, const char *name)
{
	return attribute_get(test, &pendant->hdev->dev, "stats", name);
}

static inline int pendant_show(struct kunit *test, struct pendant *pendant, const char *name,
			       const char *text)
{
	return attribute_set(test, &pendant->hdev->dev, "dro", name, text);
}

/* ---- the user: an input handler that records all events of pendants ---- */

struct event {
	u16 type;
	u16 code;
	s32 value;
};

static DEFINE_SPINLOCK(seen_lock);
static struct event seen[EVENTS_MAX];
static unsigned int seen_count;

static void user_event(struct input_handle *handle, unsigned int type, unsigned int code,
		       int value)
{
	guard(spinlock_irqsave)(&seen_lock);
	if (seen_count < EVENTS_MAX)
		seen[seen_count] = (struct event){ type, code, value };
	seen_count++;
}

/* Called for each input device that is registered, before the user opens it */
static void (*user_meets)(struct input_dev *dev);

static int user_connect(struct input_handler *handler, struct input_dev *dev,
			const struct input_device_id *id)
{
	struct input_handle *handle = kzalloc(sizeof(*handle), GFP_KERNEL);
	int err;

	if (!handle)
		return -ENOMEM;
	if (user_meets)
		user_meets(dev);
	handle->dev = dev;
	handle->handler = handler;
	handle->name = "xhc_hid_test";
	err = input_register_handle(handle);
	if (err)
		goto free;
	err = input_open_device(handle);
	if (err)
		goto unregister;
	return 0;

unregister:
	input_unregister_handle(handle);
free:
	kfree(handle);
	return err;
}

static void user_disconnect(struct input_handle *handle)
{
	input_close_device(handle);
	input_unregister_handle(handle);
	kfree(handle);
}

static const struct input_device_id user_ids[] = {
	{ .flags = INPUT_DEVICE_ID_MATCH_VENDOR, .vendor = 0x10ce },
	{ }
};

static struct input_handler user = {
	.name = "xhc_hid_test",
	.event = user_event,
	.connect = user_connect,
	.disconnect = user_disconnect,
	.id_table = user_ids,
};

static __maybe_unused void forget_events(void)
{
	guard(spinlock_irqsave)(&seen_lock);
	seen_count = 0;
}

static void expect_events(struct kunit *test, const struct event *want, unsigned int n)
{
	guard(spinlock_irqsave)(&seen_lock);
	KUNIT_EXPECT_EQ(test, seen_count, n);
	for (unsigned int i = 0; i < min(seen_count, n); i++)
		KUNIT_EXPECT_TRUE_MSG(test, seen[i].type == want[i].type &&
				      seen[i].code == want[i].code &&
				      seen[i].value == want[i].value,
				      "event %u is %u/%03x/%d, not %u/%03x/%d", i,
				      seen[i].type, seen[i].code, seen[i].value,
				      want[i].type, want[i].code, want[i].value);
	seen_count = 0;
}

#define EXPECT_EVENTS(test, ...) do {							\
	static const struct event __want[] = { __VA_ARGS__ };				\
											\
	expect_events(test, __want, ARRAY_SIZE(__want));				\
} while (0)

static inline void expect_no_event(struct kunit *test)
{
	expect_events(test, NULL, 0);
}

#define KEY(scan, down)		{ EV_KEY, BTN_TRIGGER_HAPPY1 + (scan) - 1, (down) }
#define SCAN(scan)		{ EV_MSC, MSC_SCAN, (scan) }
#define SELECT(position)	{ EV_ABS, ABS_MISC, (position) }
#define ONE_HOT(position, down)	{ EV_KEY, BTN_TRIGGER_HAPPY31 + (position) - 1, (down) }
#define WHEEL(detents)		{ EV_REL, REL_DIAL, (detents) }
#define SYN			{ EV_SYN, SYN_REPORT, 0 }

static inline struct input_dev *pendant_input(struct pendant *pendant)
{
	struct input_handle *handle;

	list_for_each_entry(handle, &user.h_list, h_node)
		if (handle->dev->dev.parent == &pendant->hdev->dev)
			return handle->dev;
	return NULL;
}

#endif /* XHC_HID_RIG_H */
