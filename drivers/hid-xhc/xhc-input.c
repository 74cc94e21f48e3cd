// SPDX-License-Identifier: GPL-2.0-only
/*
 * XHC pendant: keys, selector and wheel as an input device
 *
 * One report makes one SYN_REPORT, in the order selector, keys, wheel. What the machine
 * does depends on it: a jog key or a selector that stays down when the pendant is gone
 * moves an axis, so every way out of here goes through xhc_input_release().
 */

#include <linux/hid.h>
#include <linux/input.h>
#include <linux/lockdep.h>
#include <linux/string.h>
#include <linux/sysfs.h>

#include "xhc.h"

/*
 * evdev keeps eight times this for each reader. A pendant may report every 2 ms, and a turn
 * of the wheel makes two events: a reader that is busy for a second loses no detent.
 */
#define XHC_EVENTS_HINT		128

static u16 xhc_keycode(const struct xhc_buttons *buttons, unsigned int scan)
{
	return READ_ONCE(buttons->keymap[scan]);
}

/*
 * A key keeps the key code that it went down with: a remapping while it is held changes what
 * its next press means, and the release ends what the press began.
 */
static void xhc_new_keycodes(const struct xhc_buttons *buttons, const struct xhc_input *in,
			     u16 keycode[XHC_KEY_SLOTS])
{
	for (size_t i = 0; i < XHC_KEY_SLOTS; i++) {
		u8 code = in->key[i];

		if (!code || code > XHC_KEY_MAX)
			keycode[i] = KEY_RESERVED;
		else if (code == buttons->last.key[0])
			keycode[i] = buttons->keycode[0];
		else if (code == buttons->last.key[1])
			keycode[i] = buttons->keycode[1];
		else
			keycode[i] = xhc_keycode(buttons, code);
	}
}

/* A key code is down while any key or the selector holds it down */
static void xhc_report_keycode(struct xhc_buttons *buttons, u16 keycode)
{
	bool down = keycode == buttons->selector_keycode;

	for (size_t i = 0; i < XHC_KEY_SLOTS; i++)
		down |= keycode == buttons->keycode[i];
	input_report_key(buttons->dev, keycode, down);
}

/*
 * The selector is reported always. The input core drops what is no change, and it has dropped
 * what came while the device was inhibited.
 */
static void xhc_report_selector(struct xhc_buttons *buttons, const struct xhc_input *in,
				u16 was)
{
	input_report_abs(buttons->dev, ABS_MISC, in->selector);
	if (was != buttons->selector_keycode)
		xhc_report_keycode(buttons, was);
	xhc_report_keycode(buttons, buttons->selector_keycode);
}

/* Return: number of keys that went down with a scan code outside the known range */
static unsigned int xhc_report_keys(struct xhc_buttons *buttons, const struct xhc_input *in,
				    const u16 was[XHC_KEY_SLOTS])
{
	struct xhc_key_change change[XHC_KEY_CHANGES_MAX];
	unsigned int n = xhc_key_changes(buttons->last.key, in->key, change);
	unsigned int unknown = 0;

	for (unsigned int i = 0; i < n; i++) {
		const u8 *key = change[i].down ? in->key : buttons->last.key;
		const u16 *keycode = change[i].down ? buttons->keycode : was;
		bool known = change[i].code <= XHC_KEY_MAX;

		if (known || change[i].down)
			input_event(buttons->dev, EV_MSC, MSC_SCAN, change[i].code);
		if (known)
			xhc_report_keycode(buttons, keycode[change[i].code == key[0] ? 0 : 1]);
		else
			unknown += change[i].down;
	}
	return unknown;
}

/* Return: number of codes in the report that the model does not know */
static unsigned int xhc_report_all(struct xhc_buttons *buttons, const struct xhc_input *in)
{
	unsigned int unknown = !in->selector_ok && in->selector_code != buttons->last.selector_code;
	u16 selector_was = buttons->selector_keycode;
	u16 was[XHC_KEY_SLOTS], now[XHC_KEY_SLOTS];

	lockdep_assert_held(&buttons->lock);

	xhc_new_keycodes(buttons, in, now);
	memcpy(was, buttons->keycode, sizeof(was));
	memcpy(buttons->keycode, now, sizeof(now));
	buttons->selector_keycode = in->selector ?
		xhc_keycode(buttons, XHC_SCAN_SELECTOR + in->selector) : KEY_RESERVED;

	xhc_report_selector(buttons, in, selector_was);
	unknown += xhc_report_keys(buttons, in, was);
	if (in->wheel)
		input_report_rel(buttons->dev, REL_DIAL, in->wheel);
	input_sync(buttons->dev);

	buttons->last = *in;
	return unknown;
}

/* All keys up, selector off */
static void xhc_input_release(struct xhc_buttons *buttons)
{
	static const struct xhc_input released = { .selector_ok = true };

	xhc_report_all(buttons, &released);
}

/* Return: true if that is a change */
static bool xhc_set_awake(struct xhc_buttons *buttons, bool awake)
{
	lockdep_assert_held(&buttons->lock);

	if (buttons->awake == awake)
		return false;
	WRITE_ONCE(buttons->awake, awake);
	if (buttons->awake_node)
		sysfs_notify_dirent(buttons->awake_node);
	return true;
}

/**
 * xhc_input_report() - turn a report into events
 * @pendant: the pendant
 * @in: the report, decoded
 *
 * Context: any, the report may come from an interrupt.
 *
 * Return: true if the pendant wakes up with this report.
 */
bool xhc_input_report(struct xhc_pendant *pendant, const struct xhc_input *in)
{
	struct xhc_buttons *buttons = &pendant->buttons;
	unsigned int unknown;

	/*
	 * The bus brings reports one at a time, but suspend runs beside it: a report that
	 * passes it must not press again what it has let go.
	 */
	guard(spinlock_irqsave)(&buttons->lock);
	if (!buttons->running)
		return false;

	unknown = xhc_report_all(buttons, in);
	atomic64_add(unknown, &pendant->stat[XHC_UNKNOWN_KEYS]);
	return xhc_set_awake(buttons, !in->asleep) && !in->asleep;
}

/**
 * xhc_input_start() - let reports through
 * @pendant: the pendant
 */
void xhc_input_start(struct xhc_pendant *pendant)
{
	guard(spinlock_irqsave)(&pendant->buttons.lock);
	pendant->buttons.running = true;
}

/**
 * xhc_input_stop() - let all keys go, turn the selector off, and keep it so
 * @pendant: the pendant
 */
void xhc_input_stop(struct xhc_pendant *pendant)
{
	struct xhc_buttons *buttons = &pendant->buttons;

	guard(spinlock_irqsave)(&buttons->lock);
	buttons->running = false;
	xhc_input_release(buttons);
	xhc_set_awake(buttons, false);
}

static void xhc_init_keymap(struct xhc_buttons *buttons)
{
	struct input_dev *dev = buttons->dev;

	for (unsigned int code = 1; code <= XHC_KEY_MAX; code++)
		buttons->keymap[code] = BTN_TRIGGER_HAPPY1 + code - 1;
	for (unsigned int position = 1; position < XHC_SEL_COUNT; position++)
		buttons->keymap[XHC_SCAN_SELECTOR + position] =
			BTN_TRIGGER_HAPPY31 + position - 1;

	dev->keycode = buttons->keymap;
	dev->keycodesize = sizeof(buttons->keymap[0]);
	dev->keycodemax = ARRAY_SIZE(buttons->keymap);
	for (unsigned int scan = 0; scan < XHC_SCAN_COUNT; scan++)
		if (buttons->keymap[scan] != KEY_RESERVED)
			input_set_capability(dev, EV_KEY, buttons->keymap[scan]);
}

/**
 * xhc_input_init() - make the input device
 * @pendant: the pendant; @pendant->hdev and @pendant->model are set
 *
 * It starts stopped.
 *
 * Return: 0 or an error.
 */
int xhc_input_init(struct xhc_pendant *pendant)
{
	struct xhc_buttons *buttons = &pendant->buttons;
	struct hid_device *hdev = pendant->hdev;
	struct input_dev *dev;

	spin_lock_init(&buttons->lock);

	dev = devm_input_allocate_device(&hdev->dev);
	if (!dev)
		return -ENOMEM;
	buttons->dev = dev;

	dev->name = devm_kasprintf(&hdev->dev, GFP_KERNEL, "XHC %s Pendant",
				   pendant->model->name);
	if (!dev->name)
		return -ENOMEM;
	dev->phys = hdev->phys;
	dev->uniq = hdev->uniq;
	dev->id.bustype = hdev->bus;
	dev->id.vendor = hdev->vendor;
	dev->id.product = hdev->product;
	dev->id.version = hdev->version;

	/* else the events of reports before registration would be kept, and delivered after it */
	__set_bit(EV_SYN, dev->evbit);
	xhc_init_keymap(buttons);
	input_set_capability(dev, EV_MSC, MSC_SCAN);
	input_set_capability(dev, EV_REL, REL_DIAL);
	input_set_abs_params(dev, ABS_MISC, XHC_SEL_OFF, XHC_SEL_COUNT - 1, 0, 0);
	input_set_events_per_packet(dev, XHC_EVENTS_HINT);

	return 0;
}

/**
 * xhc_input_register() - register the input device
 * @pendant: the pendant; reports flow already
 *
 * What reports have said before is the state that its first user sees; without a report all
 * keys are up and the selector is off. A wired pendant at rest sends none, so there is no
 * waiting for one. The device goes when the driver lets the HID device go.
 *
 * Return: 0 on success, a negative errno otherwise.
 */
int xhc_input_register(struct xhc_pendant *pendant)
{
	return input_register_device(pendant->buttons.dev);
}
