// SPDX-License-Identifier: GPL-2.0-only
/*
 * XHC pendant: keys, selector and wheel as an input device
 *
 * Each report becomes one SYN_REPORT, in the order selector, second rotary switch, keys,
 * wheel. A jog key or a selector that stays active when the pendant is gone moves an axis: the
 * sleep report releases all of them, and so does xhc_input_release() on suspend, on removal
 * and when streaming reports stop.
 */

#include <linux/hid.h>
#include <linux/input.h>
#include <linux/jiffies.h>
#include <linux/lockdep.h>
#include <linux/string.h>
#include <linux/sysfs.h>
#include <linux/timer.h>

#include "xhc.h"

/*
 * evdev keeps eight times this for each reader. A pendant may report every 2 ms, and a turn
 * of the wheel makes two events: a reader that is busy for a second loses no detent.
 */
#define XHC_EVENTS_HINT		128

/*
 * A WHB04B sends reports continuously while an axis is selected, so the loss of its radio link
 * can be detected then. Its rate is unknown; this is long for any rate.
 */
#define XHC_SILENCE_MS		1000

/**
 * xhc_evdev() - the evdev side of a pendant
 * @xhc: the pendant, with the lock of its evdev side held
 *
 * Return: the state of its keys, selector and wheel.
 */
struct xhc_evdev *xhc_evdev(struct xhc_device *xhc)
{
	lockdep_assert_held(&xhc->evdev.lock);
	return &xhc->evdev;
}

static u16 xhc_keycode(const struct xhc_evdev *evdev, unsigned int scan)
{
	return READ_ONCE(evdev->keymap[scan]);
}

/*
 * A key keeps the key code that it was pressed with: a remapping while it is held applies from
 * its next press on, and the release matches the press.
 */
static void xhc_new_keycodes(const struct xhc_evdev *evdev, const struct xhc_input_state *in,
			     u8 key_max, u16 keycode[XHC_KEY_SLOTS])
{
	for (size_t i = 0; i < XHC_KEY_SLOTS; i++) {
		u8 code = in->key[i];

		if (!code || code > key_max)
			keycode[i] = KEY_RESERVED;
		else if (code == evdev->last.key[0])
			keycode[i] = evdev->keycode[0];
		else if (code == evdev->last.key[1])
			keycode[i] = evdev->keycode[1];
		else
			keycode[i] = xhc_keycode(evdev, code);
	}
}

/* A key code is down while any key or the selector holds it down */
static void xhc_emit_keycode(struct xhc_evdev *evdev, u16 keycode)
{
	bool down = keycode == evdev->selector_keycode;

	for (size_t i = 0; i < XHC_KEY_SLOTS; i++)
		down |= keycode == evdev->keycode[i];
	input_report_key(evdev->dev, keycode, down);
}

/*
 * Always report the selector. The input core drops what is not a change, and it has dropped
 * events while the device was inhibited.
 */
static void xhc_emit_selector(struct xhc_evdev *evdev, const struct xhc_input_state *in,
			      u16 was)
{
	input_report_abs(evdev->dev, ABS_MISC, in->selector);
	if (was != evdev->selector_keycode)
		xhc_emit_keycode(evdev, was);
	xhc_emit_keycode(evdev, evdev->selector_keycode);
}

/* Return: number of keys that went down with a scan code outside the known range */
static unsigned int xhc_emit_keys(struct xhc_evdev *evdev, const struct xhc_input_state *in,
				  u8 key_max, const u16 was[XHC_KEY_SLOTS])
{
	struct xhc_key_change change[XHC_KEY_CHANGES_MAX];
	unsigned int n = xhc_key_changes(evdev->last.key, in->key, change);
	unsigned int unknown = 0;

	for (unsigned int i = 0; i < n; i++) {
		const u8 *key = change[i].down ? in->key : evdev->last.key;
		const u16 *keycode = change[i].down ? evdev->keycode : was;
		bool known = change[i].code <= key_max;

		if (known || change[i].down)
			input_event(evdev->dev, EV_MSC, MSC_SCAN, change[i].code);
		if (known)
			xhc_emit_keycode(evdev, keycode[change[i].code == key[0] ? 0 : 1]);
		else
			unknown += change[i].down;
	}
	return unknown;
}

/* Return: number of codes in the report that the model does not know */
static unsigned int xhc_emit_all(struct xhc_device *xhc, const struct xhc_input_state *in)
{
	const struct xhc_model *model = xhc->model;
	struct xhc_evdev *evdev = &xhc->evdev;
	u16 selector_was = evdev->selector_keycode;
	u16 was[XHC_KEY_SLOTS], now[XHC_KEY_SLOTS];
	unsigned int unknown;

	lockdep_assert_held(&evdev->lock);

	unknown = !in->selector_ok && in->selector_code != evdev->last.selector_code;
	unknown += !in->feed_ok && in->feed_code != evdev->last.feed_code;

	xhc_new_keycodes(evdev, in, model->key_max, now);
	memcpy(was, evdev->keycode, sizeof(was));
	memcpy(evdev->keycode, now, sizeof(now));
	evdev->selector_keycode = in->selector ?
		xhc_keycode(evdev, XHC_SCAN_SELECTOR + in->selector) : KEY_RESERVED;

	xhc_emit_selector(evdev, in, selector_was);
	/* dropped by the input core for a model without it */
	input_report_abs(evdev->dev, ABS_THROTTLE, in->feed);
	unknown += xhc_emit_keys(evdev, in, model->key_max, was);
	if (in->wheel)
		input_report_rel(evdev->dev, REL_DIAL, in->wheel);
	input_sync(evdev->dev);

	evdev->last = *in;
	return unknown;
}

/* All keys up, selector off */
static void xhc_input_release(struct xhc_device *xhc)
{
	static const struct xhc_input_state released = { .selector_ok = true, .feed_ok = true };

	xhc_emit_all(xhc, &released);
}

/* Return: true if it has changed */
static bool xhc_set_awake(struct xhc_evdev *evdev, bool awake)
{
	lockdep_assert_held(&evdev->lock);

	if (evdev->awake == awake)
		return false;
	WRITE_ONCE(evdev->awake, awake);
	if (evdev->awake_node)
		sysfs_notify_dirent(evdev->awake_node);
	return true;
}

/* Is an axis selected, and has the report nothing new? */
static bool xhc_is_streamed(const struct xhc_evdev *evdev, const struct xhc_input_state *in)
{
	const struct xhc_input_state *last = &evdev->last;

	return in->selector && !in->wheel && in->selector == last->selector &&
	       in->feed == last->feed && !memcmp(in->key, last->key, sizeof(in->key));
}

/* Reports have streamed, and none was received for a while although an axis is selected */
static void xhc_input_silence(struct timer_list *timer)
{
	struct xhc_evdev *evdev = container_of(timer, struct xhc_evdev, silence);
	struct xhc_device *xhc = container_of(evdev, struct xhc_device, evdev);

	guard(spinlock_irqsave)(&evdev->lock);
	if (!evdev->running || !evdev->last.selector || timer_pending(&evdev->silence))
		return;

	xhc_input_release(xhc);
	xhc_set_awake(evdev, false);
}

/**
 * xhc_input_trailing() - check for the report without a meaning that follows the sleep report
 * @xhc: the pendant
 * @in: the decoded report
 *
 * Its content is unknown: it must neither press a key nor select an axis.
 *
 * Context: any, the report may come from an interrupt.
 *
 * Return: true if @in is that report.
 */
bool xhc_input_trailing(struct xhc_device *xhc, const struct xhc_input_state *in)
{
	struct xhc_evdev *evdev;
	bool trailing;

	guard(spinlock_irqsave)(&xhc->evdev.lock);
	evdev = xhc_evdev(xhc);
	trailing = evdev->trailing;
	evdev->trailing = xhc->model->trailing_report && in->asleep && !trailing;
	return trailing;
}

/**
 * xhc_input_emit() - emit the events of a report
 * @xhc: the pendant
 * @in: the decoded report
 *
 * Context: any, the report may come from an interrupt.
 *
 * Return: true if the pendant wakes up with this report.
 */
bool xhc_input_emit(struct xhc_device *xhc, const struct xhc_input_state *in)
{
	struct xhc_evdev *evdev = &xhc->evdev;
	unsigned int unknown;

	/*
	 * Reports come one at a time, but suspend runs concurrently: a late report must not
	 * press again what xhc_input_stop() has released.
	 */
	guard(spinlock_irqsave)(&evdev->lock);
	if (!evdev->running)
		return false;

	evdev->streams |= xhc->model->streams && xhc_is_streamed(evdev, in);
	if (evdev->streams && in->selector)
		mod_timer(&evdev->silence, jiffies + msecs_to_jiffies(XHC_SILENCE_MS));

	unknown = xhc_emit_all(xhc, in);
	atomic64_add(unknown, &xhc->stat[XHC_UNKNOWN_KEYS]);
	return xhc_set_awake(evdev, !in->asleep) && !in->asleep;
}

/**
 * xhc_input_start() - start turning reports into events
 * @xhc: the pendant
 */
void xhc_input_start(struct xhc_device *xhc)
{
	guard(spinlock_irqsave)(&xhc->evdev.lock);
	xhc_evdev(xhc)->running = true;
}

/**
 * xhc_input_stop() - release all keys and the selector, and ignore further reports
 * @xhc: the pendant
 *
 * Context: sleeps.
 */
void xhc_input_stop(struct xhc_device *xhc)
{
	struct xhc_evdev *evdev = &xhc->evdev;

	scoped_guard(spinlock_irqsave, &evdev->lock) {
		evdev->running = false;
		evdev->trailing = false;
		evdev->streams = false;
		xhc_input_release(xhc);
		xhc_set_awake(evdev, false);
	}
	timer_delete_sync(&evdev->silence);
}

static void xhc_init_keymap(struct xhc_evdev *evdev, const struct xhc_model *model)
{
	struct input_dev *dev = evdev->dev;

	for (unsigned int code = 1; code <= model->key_max; code++)
		evdev->keymap[code] = BTN_TRIGGER_HAPPY1 + code - 1;
	for (size_t i = 0; i < ARRAY_SIZE(model->selector); i++) {
		u8 position = model->selector[i].position;

		if (position != XHC_SEL_OFF)
			evdev->keymap[XHC_SCAN_SELECTOR + position] =
				BTN_TRIGGER_HAPPY31 + position - 1;
	}

	dev->keycode = evdev->keymap;
	dev->keycodesize = sizeof(evdev->keymap[0]);
	dev->keycodemax = XHC_SCAN_SELECTOR + model->selector_max + 1;
	for (unsigned int scan = 0; scan < dev->keycodemax; scan++)
		if (evdev->keymap[scan] != KEY_RESERVED)
			input_set_capability(dev, EV_KEY, evdev->keymap[scan]);
}

/**
 * xhc_input_init() - initialise the input device in the stopped state
 * @xhc: the pendant; @xhc->hdev and @xhc->model are set
 *
 * Return: 0 on success, a negative errno otherwise.
 */
int xhc_input_init(struct xhc_device *xhc)
{
	const struct xhc_model *model = xhc->model;
	struct xhc_evdev *evdev = &xhc->evdev;
	struct hid_device *hdev = xhc->hdev;
	struct input_dev *dev;

	spin_lock_init(&evdev->lock);
	timer_setup(&evdev->silence, xhc_input_silence, 0);

	dev = devm_input_allocate_device(&hdev->dev);
	if (!dev)
		return -ENOMEM;
	evdev->dev = dev;

	dev->name = devm_kasprintf(&hdev->dev, GFP_KERNEL, "XHC %s Pendant",
				   model->name);
	if (!dev->name)
		return -ENOMEM;
	dev->phys = hdev->phys;
	dev->uniq = hdev->uniq;
	dev->id.bustype = hdev->bus;
	dev->id.vendor = hdev->vendor;
	dev->id.product = hdev->product;
	dev->id.version = hdev->version;

	/* otherwise events before the registration would be kept, and delivered after it */
	__set_bit(EV_SYN, dev->evbit);
	xhc_init_keymap(evdev, model);
	input_set_capability(dev, EV_MSC, MSC_SCAN);
	input_set_capability(dev, EV_REL, REL_DIAL);
	input_set_abs_params(dev, ABS_MISC, XHC_SEL_OFF, model->selector_max, 0, 0);
	if (model->feed[0].code)
		input_set_abs_params(dev, ABS_THROTTLE, XHC_FEED_UNKNOWN, XHC_FEED_LEAD, 0, 0);
	/* events arrive before the registration, which would be the first to refuse this */
	if (!dev->absinfo)
		return -ENOMEM;
	input_set_events_per_packet(dev, XHC_EVENTS_HINT);

	return 0;
}

/**
 * xhc_input_register() - register the input device
 * @xhc: the pendant; reports flow already
 *
 * Earlier reports have set the state that the first reader sees; without one all keys are up
 * and the selector is off. A wired pendant at rest sends no report, so probe does not wait
 * for one. The input device is unregistered by devres.
 *
 * Return: 0 on success, a negative errno otherwise.
 */
int xhc_input_register(struct xhc_device *xhc)
{
	return input_register_device(xhc->evdev.dev);
}
