// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the XHC pendant's driver, from the bus to the events
 *
 * hid-xhc.ko is loaded as users load it, between the two ends of xhc_hid_rig.h. No symbol
 * of the driver is used.
 */

#include <linux/delay.h>
#include <linux/kmsg_dump.h>
#include <linux/module.h>
#include <linux/string.h>

#include "xhc_hid_rig.h"

/* ---- probe ---- */

static void probe_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	struct input_dev *input = pendant_input(pendant);
	struct hid_device *hdev = pendant->hdev;

	KUNIT_ASSERT_NOT_NULL(test, input);
	KUNIT_EXPECT_STREQ(test, input->name, "XHC HB04 Pendant");
	KUNIT_EXPECT_STREQ(test, input->phys, "kunit/input0");
	KUNIT_EXPECT_EQ(test, input->id.vendor, 0x10ce);
	KUNIT_EXPECT_EQ(test, input->id.product, 0xeb70);
	KUNIT_EXPECT_EQ(test, input->id.bustype, BUS_USB);
	KUNIT_EXPECT_EQ(test, input_abs_get_max(input, ABS_MISC), 6);
	KUNIT_EXPECT_EQ(test, input_abs_get_fuzz(input, ABS_MISC), 0);
	KUNIT_EXPECT_EQ(test, input_abs_get_flat(input, ABS_MISC), 0);
	KUNIT_EXPECT_EQ(test, pendant->started, 1);
	KUNIT_EXPECT_EQ(test, pendant->opened, 1);
	KUNIT_EXPECT_EQ(test, pendant->power, 1);
	KUNIT_EXPECT_TRUE(test, hdev->claimed & HID_CLAIMED_HIDRAW);
	KUNIT_EXPECT_FALSE(test, hdev->claimed & HID_CLAIMED_INPUT);

	pendant_unplug(pendant);
	KUNIT_EXPECT_EQ(test, pendant->started, 0);
	KUNIT_EXPECT_EQ(test, pendant->opened, 0);
	KUNIT_EXPECT_EQ(test, pendant->power, 0);
}

static void probe_frame_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	KUNIT_EXPECT_EQ(test, pendant->chunk[0][0], 0x06);
	KUNIT_EXPECT_EQ(test, pendant->chunk[0][1], 0xfe);
	KUNIT_EXPECT_EQ(test, pendant->chunk[0][2], 0xfd);
	KUNIT_EXPECT_GE(test, pendant->chunk[0][3], 1);
	KUNIT_EXPECT_LE(test, pendant->chunk[0][3], 31);
	for (unsigned int i = 4; i < 8; i++)
		KUNIT_EXPECT_EQ(test, pendant->chunk[0][i], 0);
	for (unsigned int c = 1; c < FRAME_CHUNKS; c++) {
		KUNIT_EXPECT_EQ(test, pendant->chunk[c][0], 0x06);
		for (unsigned int i = 1; i < 8; i++)
			KUNIT_EXPECT_EQ(test, pendant->chunk[c][i], 0);
	}
	/* nothing changes, so nothing more is sent */
	msleep(300);
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), FRAME_CHUNKS);
}

struct desc_row {
	const char *name;
	bool good;
	const u8 *desc;
	unsigned int size;
};

#define DESC_ROW(_name, _good, ...)							\
	{ .name = _name, .good = _good,							\
	  .desc = (const u8[]){ __VA_ARGS__ }, .size = sizeof((const u8[]){ __VA_ARGS__ }) }

static const struct desc_row desc_rows[] = {
	DESC_ROW("control: the good one", true, DESC_INPUT(4, 5), DESC_FEATURE(6, 7)),
	DESC_ROW("feature report longer than needed", true, DESC_INPUT(4, 5), DESC_FEATURE(6, 63)),
	DESC_ROW("further reports", true, DESC_INPUT(4, 5), DESC_FEATURE(6, 7), DESC_INPUT(9, 30)),
	DESC_ROW("no input report 4", false, DESC_INPUT(5, 5), DESC_FEATURE(6, 7)),
	DESC_ROW("no feature report 6", false, DESC_INPUT(4, 5), DESC_FEATURE(7, 7)),
	DESC_ROW("no feature report at all", false, DESC_INPUT(4, 5)),
	DESC_ROW("no input report at all", false, DESC_FEATURE(6, 7)),
	DESC_ROW("feature report too short", false, DESC_INPUT(4, 5), DESC_FEATURE(6, 6)),
	DESC_ROW("input report too short", false, DESC_INPUT(4, 4), DESC_FEATURE(6, 7)),
	DESC_ROW("input report too long", false, DESC_INPUT(4, 200), DESC_FEATURE(6, 7)),
	DESC_ROW("4 is a feature, 6 is an input", false, DESC_FEATURE(4, 5), DESC_INPUT(6, 7)),
};

static void desc_row_name(const struct desc_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(desc, desc_rows, desc_row_name);

static void desc_test(struct kunit *test)
{
	const struct desc_row *row = test->param_value;
	struct pendant *pendant = pendant_plug(test, 0xeb70, row->desc, row->size);

	KUNIT_EXPECT_EQ(test, pendant_bound(pendant), row->good);
	KUNIT_EXPECT_EQ(test, pendant->started, row->good);
	KUNIT_EXPECT_EQ(test, !!pendant_input(pendant), row->good);
	/* and a report to it, bound or not */
	REPORT(test, pendant, 4, 1, 0, 0x11, 1, 0);
}

/* ---- registration ---- */

static struct {
	struct pendant *pendant;
	bool opened;
	bool has_display;
} at_registration;

static void meet(struct input_dev *dev)
{
	static const u8 report[] = { 4, 5, 0, 0x11, 3, 0 };
	struct hid_device *hdev = to_hid_device(dev->dev.parent);
	struct pendant *pendant = hdev->driver_data;
	struct kernfs_node *display = sysfs_get_dirent(hdev->dev.kobj.sd, "dro");
	u8 copy[sizeof(report)];

	at_registration.opened = pendant->opened;
	at_registration.has_display = display;
	sysfs_put(display);
	memcpy(copy, report, sizeof(report));
	hid_input_report(hdev, HID_INPUT_REPORT, copy, sizeof(copy), 1);
}

/* When the input device appears, reports count, and there is a display to write to */
static void registration_test(struct kunit *test)
{
	struct pendant *pendant;
	struct input_dev *input;

	forget_events();
	user_meets = meet;
	pendant = pendant_good(test);
	user_meets = NULL;
	input = pendant_input(pendant);
	KUNIT_ASSERT_NOT_NULL(test, input);
	KUNIT_EXPECT_TRUE(test, at_registration.opened);
	KUNIT_EXPECT_TRUE(test, at_registration.has_display);
	KUNIT_EXPECT_EQ(test, input_abs_get_val(input, ABS_MISC), 1);
	KUNIT_EXPECT_TRUE(test, test_bit(BTN_TRIGGER_HAPPY31, input->key));
	KUNIT_EXPECT_TRUE(test, test_bit(BTN_TRIGGER_HAPPY5, input->key));
	/* that was before the user was there: neither its keys nor its detents come late */
	expect_no_event(test);
	REPORT(test, pendant, 4, 0, 0, 0x11, 1, 0);
	EXPECT_EVENTS(test, SCAN(5), KEY(5, 0), WHEEL(1), SYN);
}

/* ---- events ---- */

static void order_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	forget_events();
	REPORT(test, pendant, 4, 0x05, 0x16, 0x11, 3, 0);
	EXPECT_EVENTS(test, SELECT(1), ONE_HOT(1, 1), SCAN(5), KEY(5, 1), SCAN(0x16), KEY(0x16, 1),
		      WHEEL(3), SYN);
	REPORT(test, pendant, 4, 0x16, 0x07, 0x12, 0xf6, 0);
	EXPECT_EVENTS(test, SELECT(2), ONE_HOT(1, 0), ONE_HOT(2, 1), SCAN(5), KEY(5, 0),
		      SCAN(7), KEY(7, 1), WHEEL(-10), SYN);
	REPORT(test, pendant, 4, 0x00, 0x00, 0x00, 0, 1);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(2, 0), SCAN(0x16), KEY(0x16, 0), SCAN(7), KEY(7, 0),
		      SYN);
}

static void slots_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	forget_events();
	REPORT(test, pendant, 4, 0, 0x09, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(9), KEY(9, 1), SYN);
	REPORT(test, pendant, 4, 0x09, 0x09, 0, 0, 1);
	expect_no_event(test);
	REPORT(test, pendant, 4, 0x0a, 0x09, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(10), KEY(10, 1), SYN);
	REPORT(test, pendant, 4, 0x09, 0x0a, 0, 0, 1);
	expect_no_event(test);
	REPORT(test, pendant, 4, 0, 0x0a, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(9), KEY(9, 0), SYN);
	REPORT(test, pendant, 4, 0, 0, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(10), KEY(10, 0), SYN);
}

static void unknown_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	forget_events();
	REPORT(test, pendant, 4, 0x18, 0x05, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(0x18), SCAN(5), KEY(5, 1), SYN);
	/* 21h is a scan code of the keymap, but no key of the pendant */
	REPORT(test, pendant, 4, 0x21, 0x05, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(0x21), SYN);
	REPORT(test, pendant, 4, 0xff, 0x05, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(0xff), SYN);
	/* a selector that nobody knows is off, and lets the axis go */
	REPORT(test, pendant, 4, 0, 0x05, 0x13, 0, 1);
	EXPECT_EVENTS(test, SELECT(3), ONE_HOT(3, 1), SYN);
	REPORT(test, pendant, 4, 0, 0x05, 0x19, 0, 1);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(3, 0), SYN);
}

/* Each code that the model does not know counts once as it appears, also after another one */
static void unknown_count_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	REPORT(test, pendant, 4, 0, 0, 0x16, 0, 1);
	REPORT(test, pendant, 4, 0, 0, 0x16, 0, 1);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "unknown_keys"), 1);
	REPORT(test, pendant, 4, 0, 0, 0x19, 0, 1);
	REPORT(test, pendant, 4, 0, 0, 0x1a, 0, 1);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "unknown_keys"), 3);
	REPORT(test, pendant, 4, 0x18, 0x19, 0x1a, 0, 1);
	REPORT(test, pendant, 4, 0x19, 0x18, 0x1a, 0, 1);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "unknown_keys"), 5);
}

static void inhibit(struct kunit *test, struct input_dev *input, const char *text)
{
	KUNIT_ASSERT_EQ(test, 0, attribute_set(test, &input->dev, NULL, "inhibited", text));
}

/* The input core drops the events of an inhibited device; the next report makes up for them */
static void inhibited_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	struct input_dev *input = pendant_input(pendant);

	KUNIT_ASSERT_NOT_NULL(test, input);
	REPORT(test, pendant, 4, 7, 0, 0x11, 0, 1);
	inhibit(test, input, "1");
	REPORT(test, pendant, 4, 0, 0, 0, 0, 1);
	inhibit(test, input, "0");
	forget_events();
	REPORT(test, pendant, 4, 0, 0, 0, 0, 1);
	EXPECT_EVENTS(test, SELECT(0), SYN);
	KUNIT_EXPECT_FALSE(test, test_bit(BTN_TRIGGER_HAPPY7, input->key));
	KUNIT_EXPECT_FALSE(test, test_bit(BTN_TRIGGER_HAPPY31, input->key));

	/* turned on meanwhile, and left where it is */
	inhibit(test, input, "1");
	REPORT(test, pendant, 4, 0, 0, 0x12, 0, 1);
	inhibit(test, input, "0");
	forget_events();
	REPORT(test, pendant, 4, 0, 0, 0x12, 0, 1);
	EXPECT_EVENTS(test, SELECT(2), ONE_HOT(2, 1), SYN);
}

/* A report speaks of the keys in it and of those in the one before, of no others */
static void other_keys_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	struct input_dev *input = pendant_input(pendant);

	KUNIT_ASSERT_NOT_NULL(test, input);
	input_report_key(input, BTN_TRIGGER_HAPPY20, 1);
	input_sync(input);
	forget_events();
	REPORT(test, pendant, 4, 1, 0, 0x11, 1, 1);
	EXPECT_EVENTS(test, SELECT(1), ONE_HOT(1, 1), SCAN(1), KEY(1, 1), WHEEL(1), SYN);
	KUNIT_EXPECT_TRUE(test, test_bit(BTN_TRIGGER_HAPPY20, input->key));
}

static void sleep_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	REPORT(test, pendant, 4, 0x0d, 0x0e, 0x14, 0, 1);
	forget_events();
	REPORT(test, pendant, 4, 0, 0, 0, 0, 0);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(6, 0), SCAN(13), KEY(13, 0), SCAN(14), KEY(14, 0),
		      SYN);
	REPORT(test, pendant, 4, 0, 0, 0, 0, 0);
	expect_no_event(test);
	/* and awake again, with the wheel at once */
	REPORT(test, pendant, 4, 0, 0, 0x14, 1, 1);
	EXPECT_EVENTS(test, SELECT(6), ONE_HOT(6, 1), WHEEL(1), SYN);
}

struct bad_row {
	const char *name;
	u8 size;
	u8 data[8];
};

static const struct bad_row bad_rows[] = {
	{ "id alone", 1, { 4 } },
	{ "one byte short", 5, { 4, 0, 0, 0, 0 } },
	{ "one byte long", 7, { 4, 0, 0, 0, 0, 0, 0 } },
	{ "two bytes long", 8, { 4, 2, 0, 0x12, 1 } },
	{ "the feature report's id", 6, { 6, 2, 0, 0x12, 1 } },
	{ "id 0", 6, { 0, 2, 0, 0x12, 1 } },
	{ "id 255", 6, { 0xff, 2, 0, 0x12, 1 } },
	{ "another input report", 6, { 9, 2, 0, 0x12, 1 } },
};

static void bad_row_name(const struct bad_row *row, char *name)
{
	strscpy(name, row->name, KUNIT_PARAM_DESC_SIZE);
}

KUNIT_ARRAY_PARAM(bad, bad_rows, bad_row_name);

/* A report that cannot be read changes nothing: what is down stays down */
static void bad_report_test(struct kunit *test)
{
	static const u8 desc[] = { DESC_INPUT(4, 5), DESC_FEATURE(6, 7), DESC_INPUT(9, 5) };
	const struct bad_row *row = test->param_value;
	struct pendant *pendant = pendant_plug(test, 0xeb70, desc, sizeof(desc));

	KUNIT_ASSERT_TRUE(test, pendant_bound(pendant));
	REPORT(test, pendant, 4, 1, 0, 0x11, 0, 0);
	forget_events();
	pendant_report(test, pendant, row->data, row->size);
	expect_no_event(test);
	REPORT(test, pendant, 4, 1, 0, 0x11, 5, 0);
	EXPECT_EVENTS(test, WHEEL(5), SYN);
}

static void two_pendants_test(struct kunit *test)
{
	static const u8 hb03_desc[] = { DESC_INPUT(4, 5), DESC_FEATURE(6, 7) };
	struct pendant *one = pendant_good(test);
	struct pendant *two = pendant_plug(test, 0xeb6e, hb03_desc, sizeof(hb03_desc));

	KUNIT_ASSERT_TRUE(test, pendant_bound(two));
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(two, FRAME_CHUNKS - 1));
	KUNIT_EXPECT_STREQ(test, pendant_input(two)->name, "XHC HB03 Pendant");

	forget_events();
	REPORT(test, one, 4, 1, 0, 0x14, 0, 1);
	EXPECT_EVENTS(test, SELECT(6), ONE_HOT(6, 1), SCAN(1), KEY(1, 1), SYN);
	/* the same codes: a press of its own, and the selector's code as HB03 has it */
	REPORT(test, two, 4, 1, 0, 0x14, 0, 1);
	EXPECT_EVENTS(test, SELECT(5), ONE_HOT(5, 1), SCAN(1), KEY(1, 1), SYN);

	pendant_unplug(two);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(5, 0), SCAN(1), KEY(1, 0), SYN);
	REPORT(test, one, 4, 0, 0, 0x14, 0, 1);
	EXPECT_EVENTS(test, SCAN(1), KEY(1, 0), SYN);
}

/* ---- remapping ---- */

static int remap(struct input_dev *input, u8 scan, u16 keycode)
{
	struct input_keymap_entry entry = { .len = 1, .keycode = keycode, .scancode = { scan } };

	return input_set_keycode(input, &entry);
}

static void remap_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	struct input_dev *input = pendant_input(pendant);

	KUNIT_ASSERT_NOT_NULL(test, input);
	KUNIT_ASSERT_EQ(test, 0, remap(input, 0x17, KEY_STOP));
	forget_events();
	REPORT(test, pendant, 4, 0x17, 0, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(0x17), { EV_KEY, KEY_STOP, 1 }, SYN);
	REPORT(test, pendant, 4, 0, 0, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(0x17), { EV_KEY, KEY_STOP, 0 }, SYN);

	/* the selector's buttons, too */
	KUNIT_ASSERT_EQ(test, 0, remap(input, 0x21, BTN_0));
	REPORT(test, pendant, 4, 0, 0, 0x11, 0, 1);
	EXPECT_EVENTS(test, SELECT(1), { EV_KEY, BTN_0, 1 }, SYN);

	/* scan codes that are no key's are as good as none; beyond the table is an error */
	KUNIT_EXPECT_NE(test, 0, remap(input, 0x27, BTN_1));
	KUNIT_EXPECT_NE(test, 0, remap(input, 0xff, BTN_1));
}

/* Two scan codes on one key code: it is down while either is */
static void remap_shared_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	struct input_dev *input = pendant_input(pendant);

	KUNIT_ASSERT_NOT_NULL(test, input);
	KUNIT_ASSERT_EQ(test, 0, remap(input, 1, BTN_0));
	KUNIT_ASSERT_EQ(test, 0, remap(input, 2, BTN_0));
	forget_events();
	REPORT(test, pendant, 4, 1, 0, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(1), { EV_KEY, BTN_0, 1 }, SYN);
	REPORT(test, pendant, 4, 1, 2, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(2), SYN);
	REPORT(test, pendant, 4, 0, 2, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(1), SYN);
	REPORT(test, pendant, 4, 0, 0, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(2), { EV_KEY, BTN_0, 0 }, SYN);
}

/* A key is held while its code changes: the old one must not stay down */
static void remap_held_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	struct input_dev *input = pendant_input(pendant);

	KUNIT_ASSERT_NOT_NULL(test, input);
	KUNIT_ASSERT_EQ(test, 0, remap(input, 1, BTN_0));
	KUNIT_ASSERT_EQ(test, 0, remap(input, 2, BTN_0));
	REPORT(test, pendant, 4, 1, 0, 0, 0, 1);
	KUNIT_EXPECT_TRUE(test, test_bit(BTN_0, input->key));
	KUNIT_ASSERT_EQ(test, 0, remap(input, 1, BTN_1));
	REPORT(test, pendant, 4, 0, 0, 0, 0, 1);
	KUNIT_EXPECT_FALSE(test, test_bit(BTN_0, input->key));
	KUNIT_EXPECT_FALSE(test, test_bit(BTN_1, input->key));

	/* a key's code given to a selector's and taken back leaves the selector its own */
	KUNIT_ASSERT_EQ(test, 0, remap(input, 3, BTN_TRIGGER_HAPPY31));
	KUNIT_ASSERT_EQ(test, 0, remap(input, 3, BTN_TRIGGER_HAPPY3));
	forget_events();
	REPORT(test, pendant, 4, 0, 0, 0x11, 0, 1);
	EXPECT_EVENTS(test, SELECT(1), ONE_HOT(1, 1), SYN);
}

/* ---- suspend, unplug ---- */

static void suspend_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	unsigned int chunks;

	REPORT(test, pendant, 4, 2, 0, 0x11, 0, 1);
	forget_events();
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(1, 0), SCAN(2), KEY(2, 0), SYN);
	/* the transport still brings what was on its way: it must not press the key again */
	REPORT(test, pendant, 4, 2, 0, 0x11, 1, 1);
	expect_no_event(test);

	chunks = pendant_chunks(pendant);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	KUNIT_EXPECT_TRUE(test, pendant_wait_chunks(pendant, chunks + FRAME_CHUNKS));
	REPORT(test, pendant, 4, 2, 0, 0x11, 1, 1);
	EXPECT_EVENTS(test, SELECT(1), ONE_HOT(1, 1), SCAN(2), KEY(2, 1), WHEEL(1), SYN);

	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	chunks = pendant_chunks(pendant);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_reset_resume(pendant->hdev));
	KUNIT_EXPECT_TRUE(test, pendant_wait_chunks(pendant, chunks + FRAME_CHUNKS));
}

static void unplug_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	REPORT(test, pendant, 4, 0x10, 0x0c, 0x18, 0, 1);
	forget_events();
	pendant_unplug(pendant);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(4, 0), SCAN(0x10), KEY(0x10, 0),
		      SCAN(0x0c), KEY(0x0c, 0), SYN);
}

static struct {
	struct delayed_work work;
	struct pendant *pendant;
} later;

static void release_work(struct work_struct *work)
{
	complete_all(&later.pendant->release);
}

/* The driver waits for the transfer in flight, and begins no other */
static void unplug_in_frame_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	unsigned int chunks;

	pendant->hold = true;
	chunks = pendant_chunks(pendant);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	KUNIT_ASSERT_NE(test, 0, wait_for_completion_timeout(&pendant->held, 5 * HZ));

	later.pendant = pendant;
	INIT_DELAYED_WORK(&later.work, release_work);
	schedule_delayed_work(&later.work, HZ / 5);
	pendant_unplug(pendant);
	flush_delayed_work(&later.work);
	KUNIT_EXPECT_EQ(test, pendant->chunks, chunks + 1);
}

/* ---- frames that are not taken ---- */

static void retry_test(struct kunit *test)
{
	struct pendant *pendant = pendant_plug(test, 0xeb70, good_desc, sizeof(good_desc));
	unsigned int chunks;

	KUNIT_ASSERT_TRUE(test, pendant_bound(pendant));
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, FRAME_CHUNKS));
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));

	/* stalled: the frame ends with its first chunk, and is not tried again at once */
	pendant_fail(pendant, -EPIPE, UINT_MAX);
	chunks = pendant_chunks(pendant);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, chunks + 1));
	msleep(500);
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), chunks + 1);

	/* but after a second, from its beginning, until it is taken */
	pendant_fail(pendant, 0, 0);
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, chunks + 1 + FRAME_CHUNKS));
	KUNIT_EXPECT_EQ(test, pendant->chunk[chunks + 1][1], 0xfe);
	msleep(1500);
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), chunks + 1 + FRAME_CHUNKS);
}

/* A transfer that took only a part of the report is an error like any other */
static void short_transfer_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	unsigned int chunks;

	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	pendant_fail(pendant, 7, UINT_MAX);
	chunks = pendant_chunks(pendant);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, chunks + 1));
	msleep(500);
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), chunks + 1);
}

/* ---- what the display shows is not known ---- */

static void wait_frames(struct kunit *test, struct pendant *pendant, unsigned int frames)
{
	KUNIT_ASSERT_TRUE_MSG(test, pendant_wait_chunks(pendant, frames * FRAME_CHUNKS),
			      "%u chunks have come, not %u frames", pendant_chunks(pendant),
			      frames);
}

static void expect_no_more_frames(struct kunit *test, struct pendant *pendant,
				  unsigned int frames)
{
	msleep(700);
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), frames * FRAME_CHUNKS);
}

/* Plugged in, awake, and its display known: two frames */
static struct pendant *pendant_awake(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	pendant_report_day(test, pendant, 0x11, pendant_day(pendant));
	wait_frames(test, pendant, 2);
	expect_no_more_frames(test, pendant, 2);
	return pendant;
}

/* A pendant that has slept may have missed all frames */
static void wake_up_test(struct kunit *test)
{
	struct pendant *pendant = pendant_awake(test);
	u8 day = pendant_day(pendant);

	for (unsigned int frames = 3; frames < 5; frames++) {
		REPORT(test, pendant, 4, 0, 0, 0, 0, 0);
		expect_no_more_frames(test, pendant, frames - 1);
		pendant_report_day(test, pendant, 0x11, day);
		pendant_report_day(test, pendant, 0x12, day);
		wait_frames(test, pendant, frames);
		expect_no_more_frames(test, pendant, frames);
	}
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 0);
}

/* A USB reset in place: the driver is not called, the pendant returns day 0 */
static void forgotten_day_test(struct kunit *test)
{
	struct pendant *pendant = pendant_awake(test);
	u8 day = pendant_day(pendant);

	pendant_report_day(test, pendant, 0x11, 0);
	wait_frames(test, pendant, 3);
	pendant_report_day(test, pendant, 0x11, day);
	expect_no_more_frames(test, pendant, 3);

	/* a second writer, by hidraw */
	pendant_report_day(test, pendant, 0x11, day ^ 1);
	wait_frames(test, pendant, 4);
	/* it has missed that frame: the next one comes after a second, not for each report */
	for (unsigned int i = 0; i < 50; i++)
		pendant_report_day(test, pendant, 0x11, day ^ 1);
	expect_no_more_frames(test, pendant, 4);
	msleep(500);
	for (unsigned int i = 0; i < 50; i++)
		pendant_report_day(test, pendant, 0x11, day ^ 1);
	wait_frames(test, pendant, 5);
	pendant_report_day(test, pendant, 0x11, day);
	expect_no_more_frames(test, pendant, 5);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 102);
}

/* A clone that never returns the day costs a frame for each new byte, not for each report */
static void clone_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	unsigned int frames = 1;

	for (u8 day = 0x40; day < 0x43; day++) {
		for (unsigned int i = 0; i < 4; i++) {
			pendant_report_day(test, pendant, 0x11, day);
			if (!i)
				wait_frames(test, pendant, ++frames);
			expect_no_more_frames(test, pendant, frames);
		}
	}
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 12);
}

/* A report that was on its way while the pendant took another day is no reason for a frame */
static void late_report_test(struct kunit *test)
{
	struct pendant *pendant = pendant_awake(test);
	u8 day = pendant_day(pendant);

	pendant_report_day(test, pendant, 0x11, day);
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "day", day == 5 ? "6" : "5"));
	wait_frames(test, pendant, 3);
	pendant_report_day(test, pendant, 0x11, day);
	pendant_report_day(test, pendant, 0x11, pendant_day(pendant));
	expect_no_more_frames(test, pendant, 3);

	/* nor is one that comes while the frame is on its way */
	WRITE_ONCE(pendant->hold, true);
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "day", "7"));
	KUNIT_ASSERT_NE(test, 0, wait_for_completion_timeout(&pendant->held, 5 * HZ));
	pendant_report_day(test, pendant, 0x11, 0);
	pendant_report_day(test, pendant, 0x11, 7);
	WRITE_ONCE(pendant->hold, false);
	complete_all(&pendant->release);
	wait_frames(test, pendant, 4);
	expect_no_more_frames(test, pendant, 4);
}

/* ---- times ---- */

/* Least time in microseconds from the end of a frame to the beginning of the next */
static s64 least_pause(struct kunit *test, struct pendant *pendant, unsigned int from,
		       unsigned int frames)
{
	s64 least = S64_MAX;

	KUNIT_ASSERT_LE(test, frames * FRAME_CHUNKS, CHUNKS_MAX);
	for (unsigned int i = from; i < frames; i++)
		least = min(least, ktime_us_delta(pendant->at[i * FRAME_CHUNKS],
						  pendant->at[i * FRAME_CHUNKS - 1]));
	return least;
}

static const unsigned int refresh_rows[] = { 10, 11, 19, 50, 200 };

static void refresh_row_name(const unsigned int *row, char *name)
{
	snprintf(name, KUNIT_PARAM_DESC_SIZE, "%u ms", *row);
}

KUNIT_ARRAY_PARAM(refresh, refresh_rows, refresh_row_name);

/* refresh_ms is the least time, whatever a jiffy is and whenever in it a change comes */
static void refresh_test(struct kunit *test)
{
	unsigned int refresh_ms = *(const unsigned int *)test->param_value;
	struct pendant *pendant = pendant_good(test);
	unsigned int frames = 0;
	char text[8];

	snprintf(text, sizeof(text), "%u", refresh_ms);
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "refresh_ms", text));
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "flush", "1"));
	for (unsigned int n = 1; frames < 12; n++) {
		snprintf(text, sizeof(text), "%u", n % 60000);
		KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "feedrate", text));
		usleep_range(700, 800);
		frames = pendant_chunks(pendant) / FRAME_CHUNKS;
	}
	KUNIT_EXPECT_GE(test, least_pause(test, pendant, 2, frames), refresh_ms * 1000);
	KUNIT_EXPECT_LT(test, least_pause(test, pendant, 2, frames), refresh_ms * 1000 + 30000);
}

/* A frame that a report asks for keeps to it as well */
static void refresh_of_wake_up_test(struct kunit *test)
{
	struct pendant *pendant = pendant_awake(test);
	u8 day = pendant_day(pendant);

	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "refresh_ms", "400"));
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "flush", "1"));
	for (unsigned int frames = 4; frames < 7; frames++) {
		REPORT(test, pendant, 4, 0, 0, 0, 0, 0);
		pendant_report_day(test, pendant, 0x11, day);
		wait_frames(test, pendant, frames);
	}
	KUNIT_EXPECT_GE(test, least_pause(test, pendant, 3, 6), 400000);
}

/* ---- flush ---- */

static struct flusher {
	struct work_struct work;
	struct kunit *test;
	struct pendant *pendant;
	int result;
} flushers[2];

static void flush_work_fn(struct work_struct *work)
{
	struct flusher *flusher = container_of(work, struct flusher, work);

	flusher->result = pendant_show(flusher->test, flusher->pendant, "flush", "1");
}

static void start_flusher(struct kunit *test, struct pendant *pendant, struct flusher *flusher)
{
	flusher->test = test;
	flusher->pendant = pendant;
	flusher->result = 1;
	INIT_WORK(&flusher->work, flush_work_fn);
	schedule_work(&flusher->work);
}

/* The first of two frames fails: each caller gets the result of its own */
static void flush_results_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);

	WRITE_ONCE(pendant->hold, true);
	start_flusher(test, pendant, &flushers[0]);
	KUNIT_ASSERT_NE(test, 0, wait_for_completion_timeout(&pendant->held, 5 * HZ));
	start_flusher(test, pendant, &flushers[1]);
	msleep(100);			/* now it waits for the frame after this one */
	pendant_fail(pendant, -EPIPE, 1);
	WRITE_ONCE(pendant->hold, false);
	complete_all(&pendant->release);
	flush_work(&flushers[0].work);
	flush_work(&flushers[1].work);
	KUNIT_EXPECT_EQ(test, flushers[0].result, -EPIPE);
	KUNIT_EXPECT_EQ(test, flushers[1].result, 0);
	/* the frame that failed, up to its first chunk, and the one after it */
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), 2 * FRAME_CHUNKS + 1);
}

struct error_row {
	int transfer;
	int flush;
};

static const struct error_row error_rows[] = {
	{ -EPIPE, -EPIPE },
	{ -ETIMEDOUT, -ETIMEDOUT },
	{ -EIO, -EIO },
	{ -EPROTO, -EIO },
	{ -EILSEQ, -EIO },
	{ 7, -EIO },
	{ -ENODEV, -ENODEV },
	{ -ESHUTDOWN, -ENODEV },
	{ -EHOSTUNREACH, -ENODEV },
	{ -ENOENT, -ENODEV },
};

static void error_row_name(const struct error_row *row, char *name)
{
	snprintf(name, KUNIT_PARAM_DESC_SIZE, "transfer: %d", row->transfer);
}

KUNIT_ARRAY_PARAM(error, error_rows, error_row_name);

static void flush_error_test(struct kunit *test)
{
	const struct error_row *row = test->param_value;
	struct pendant *pendant = pendant_good(test);

	pendant_fail(pendant, row->transfer, 1);
	KUNIT_EXPECT_EQ(test, pendant_show(test, pendant, "flush", "1"), row->flush);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "frame_errors"), 1);
	KUNIT_EXPECT_EQ(test, pendant_show(test, pendant, "flush", "1"), 0);
}

/* Number of lines of the kernel's log with this text */
static unsigned int log_count(struct kunit *test, const char *text)
{
	char *line = kunit_kzalloc(test, SZ_1K, GFP_KERNEL);
	struct kmsg_dump_iter iter;
	unsigned int count = 0;
	size_t len;

	KUNIT_ASSERT_NOT_NULL(test, line);
	kmsg_dump_rewind(&iter);
	while (kmsg_dump_get_line(&iter, false, line, SZ_1K, &len))
		count += !!strnstr(line, text, len);
	kunit_kfree(test, line);
	return count;
}

/* A frame that the suspend broke off does not keep the next failure out of the log */
static void failure_after_resume_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	unsigned int before;

	WRITE_ONCE(pendant->hold, true);
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "feedrate", "1"));
	KUNIT_ASSERT_NE(test, 0, wait_for_completion_timeout(&pendant->held, 5 * HZ));
	later.pendant = pendant;
	INIT_DELAYED_WORK(&later.work, release_work);
	schedule_delayed_work(&later.work, HZ / 5);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	flush_delayed_work(&later.work);
	WRITE_ONCE(pendant->hold, false);

	before = log_count(test, "display frame not taken");
	pendant_fail(pendant, -EPIPE, 2);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, FRAME_CHUNKS + 3));
	KUNIT_EXPECT_EQ(test, log_count(test, "display frame not taken"), before + 1);
}

/* ---- WHB04B ---- */

#define WHB_CHUNKS	3
#define THROTTLE(position)	{ EV_ABS, ABS_THROTTLE, (position) }

/* As a replacement firmware has it, which is said to have it from a unit */
static const u8 whb_desc[] = {
	0x06, 0x00, 0xff, 0x09, 0x01, 0xa1, 0x01, 0x85, 0x04, 0x09, 0x01, 0x15, 0x00,
	0x26, 0x00, 0xff, 0x75, 0x08, 0x95, 0x07, 0x81, 0x02, 0xc0,
	0x06, 0x00, 0xff, 0x09, 0x01, 0xa1, 0x01, 0x85, 0x06, 0x09, 0x01, 0x15, 0x00,
	0x26, 0x00, 0xff, 0x75, 0x08, 0x95, 0x07, 0xb1, 0x06, 0xc0,
};

static struct pendant *whb_good(struct kunit *test)
{
	struct pendant *pendant = pendant_plug(test, 0xeb93, whb_desc, sizeof(whb_desc));

	KUNIT_ASSERT_TRUE_MSG(test, pendant_bound(pendant), "is hid-xhc loaded?");
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, WHB_CHUNKS));
	return pendant;
}

static void whb_report_of(struct kunit *test, struct pendant *pendant, u8 seed, u8 key1, u8 key2,
			  u8 feed, u8 axis, s8 wheel)
{
	static u8 random;
	u8 inverse, report[8] = { 4, random += 0x3b, key1, key2, feed, axis, wheel };

	/* with this bit each two of the seeds in use differ */
	report[1] |= 0x80;
	inverse = ~report[1];
	report[7] = (u8)(inverse + key1) ^ (seed | inverse);
	pendant_report(test, pendant, report, sizeof(report));
}

static void whb_report(struct kunit *test, struct pendant *pendant, u8 key1, u8 key2, u8 feed,
		       u8 axis, s8 wheel)
{
	whb_report_of(test, pendant, 0xfe, key1, key2, feed, axis, wheel);
}

static void whb_wait_frames(struct kunit *test, struct pendant *pendant, unsigned int frames)
{
	KUNIT_ASSERT_TRUE_MSG(test, pendant_wait_chunks(pendant, frames * WHB_CHUNKS),
			      "%u chunks have come, not %u frames", pendant_chunks(pendant),
			      frames);
}

/* Not for so long that the driver takes it for silence */
static void whb_no_more_frames(struct kunit *test, struct pendant *pendant, unsigned int frames)
{
	msleep(500);
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), frames * WHB_CHUNKS);
}

static void whb_probe_test(struct kunit *test)
{
	static const u8 first[8] = { 0x06, 0xfe, 0xfd, 0xfe };
	struct pendant *pendant = whb_good(test);
	struct input_dev *input = pendant_input(pendant);

	KUNIT_ASSERT_NOT_NULL(test, input);
	KUNIT_EXPECT_STREQ(test, input->name, "XHC WHB04B Pendant");
	KUNIT_EXPECT_EQ(test, input_abs_get_max(input, ABS_MISC), 8);
	KUNIT_EXPECT_EQ(test, input_abs_get_max(input, ABS_THROTTLE), 7);
	KUNIT_EXPECT_EQ(test, input_abs_get_fuzz(input, ABS_THROTTLE), 0);
	for (unsigned int code = BTN_TRIGGER_HAPPY1; code <= BTN_TRIGGER_HAPPY40; code++) {
		unsigned int button = code - BTN_TRIGGER_HAPPY1 + 1;
		bool has = button <= 16 || (button >= 31 && button <= 34) ||
			   button == 37 || button == 38;

		KUNIT_EXPECT_EQ_MSG(test, !!test_bit(code, input->keybit), has, "button %u",
				    button);
	}
	KUNIT_EXPECT_MEMEQ(test, pendant->chunk[0], first, sizeof(first));
	whb_no_more_frames(test, pendant, 1);

	/* HB03 and HB04 are without the second rotary switch, and without B and C */
	pendant = pendant_good(test);
	input = pendant_input(pendant);
	KUNIT_ASSERT_NOT_NULL(test, input);
	KUNIT_EXPECT_FALSE(test, test_bit(ABS_THROTTLE, input->absbit));
	KUNIT_EXPECT_FALSE(test, test_bit(BTN_TRIGGER_HAPPY37, input->keybit));
}

static void whb_descriptor_test(struct kunit *test)
{
	/* each with the descriptor of the other */
	KUNIT_EXPECT_FALSE(test, pendant_bound(pendant_plug(test, 0xeb93, good_desc,
							    sizeof(good_desc))));
	KUNIT_EXPECT_FALSE(test, pendant_bound(pendant_plug(test, 0xeb70, whb_desc,
							    sizeof(whb_desc))));
}

static void whb_order_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	forget_events();
	whb_report(test, pendant, 0x0c, 0x10, 0x0e, 0x15, 3);
	EXPECT_EVENTS(test, SELECT(7), ONE_HOT(7, 1), THROTTLE(2), SCAN(0x0c), KEY(0x0c, 1),
		      SCAN(0x10), KEY(0x10, 1), WHEEL(3), SYN);
	whb_report(test, pendant, 0x10, 0, 0x1c, 0x16, -10);
	EXPECT_EVENTS(test, SELECT(8), ONE_HOT(7, 0), ONE_HOT(8, 1), THROTTLE(7), SCAN(0x0c),
		      KEY(0x0c, 0), WHEEL(-10), SYN);
	/* the other code of Lead is the same position */
	whb_report(test, pendant, 0x10, 0, 0x9b, 0x16, 0);
	expect_no_event(test);
	whb_report(test, pendant, 0, 0, 0x0d, 0x06, 0);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(8, 0), THROTTLE(1), SCAN(0x10), KEY(0x10, 0), SYN);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "unknown_keys"), 0);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 0);
}

static void whb_unknown_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	whb_report(test, pendant, 0, 0, 0x0d, 0x11, 0);
	forget_events();
	/* 11h and 17h are keys of HB04 */
	whb_report(test, pendant, 0x11, 0x17, 0x0d, 0x11, 0);
	EXPECT_EVENTS(test, SCAN(0x11), SCAN(0x17), SYN);
	whb_report(test, pendant, 0, 0, 0x0d, 0x18, 0);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(1, 0), SYN);
	whb_report(test, pendant, 0, 0, 0x11, 0x18, 0);
	EXPECT_EVENTS(test, THROTTLE(0), SYN);
	whb_report(test, pendant, 0, 0, 0x11, 0x18, 0);
	whb_report(test, pendant, 0, 0, 0x12, 0x06, 0);
	expect_no_event(test);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "unknown_keys"), 5);
}

/* Reports that stream make no event at all, but detents among them do */
static void whb_stream_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	whb_report(test, pendant, 0, 0, 0x0d, 0x11, 0);
	forget_events();
	for (unsigned int i = 0; i < 1000; i++)
		whb_report(test, pendant, 0, 0, 0x0d, 0x11, 0);
	expect_no_event(test);
	whb_report(test, pendant, 0, 0, 0x0d, 0x11, -1);
	EXPECT_EVENTS(test, WHEEL(-1), SYN);
	whb_report(test, pendant, 0, 0, 0x0d, 0x11, 0);
	expect_no_event(test);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "reports"), 1003);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 0);
	whb_wait_frames(test, pendant, 2);		/* it woke up */
	whb_no_more_frames(test, pendant, 2);
}

/* One report follows that of sleep: whatever is in it, it has no meaning */
static void whb_sleep_test(struct kunit *test)
{
	static const u8 trailing[][5] = {
		{ 0, 0, 0, 0, 0 }, { 0, 0, 0x0d, 0x11, 0 }, { 0x01, 0x02, 0x0d, 0x11, 5 },
	};
	struct pendant *pendant = whb_good(test);

	for (size_t i = 0; i < ARRAY_SIZE(trailing); i++) {
		const u8 *last = trailing[i];

		whb_report(test, pendant, 0x04, 0x0c, 0x0e, 0x13, 0);
		whb_wait_frames(test, pendant, i + 2);
		KUNIT_EXPECT_EQ(test, attribute_get(test, &pendant->hdev->dev, NULL, "awake"), 1);
		forget_events();
		whb_report(test, pendant, 0, 0, 0, 0, 0);
		EXPECT_EVENTS(test, SELECT(0), ONE_HOT(3, 0), THROTTLE(0), SCAN(4), KEY(4, 0),
			      SCAN(0x0c), KEY(0x0c, 0), SYN);
		whb_report_of(test, pendant, 0x01, last[0], last[1], last[2], last[3], last[4]);
		expect_no_event(test);
		KUNIT_EXPECT_EQ(test, attribute_get(test, &pendant->hdev->dev, NULL, "awake"), 0);

		/* and awake again, with the wheel at once */
		whb_report(test, pendant, 0, 0, 0x0e, 0x13, 1);
		EXPECT_EVENTS(test, SELECT(3), ONE_HOT(3, 1), THROTTLE(2), WHEEL(1), SYN);
		whb_report(test, pendant, 0, 0, 0x0d, 0x06, 0);
		whb_wait_frames(test, pendant, i + 3);
	}
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 0);
}

/* The report after that of sleep was expected before the suspend, not after it */
static void whb_sleep_suspend_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	whb_report(test, pendant, 0, 0, 0, 0, 0);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	forget_events();
	whb_report(test, pendant, 0x02, 0, 0x0d, 0x11, 0);
	EXPECT_EVENTS(test, SELECT(1), ONE_HOT(1, 1), THROTTLE(1), SCAN(2), KEY(2, 1), SYN);
}

/* The radio is lost while reports stream */
static void whb_silence_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	for (unsigned int i = 0; i < 5; i++) {
		whb_report(test, pendant, 0x04, 0, 0x0e, 0x14, 0);
		msleep(400);
	}
	/* it was heard all the time */
	KUNIT_EXPECT_EQ(test, attribute_get(test, &pendant->hdev->dev, NULL, "awake"), 1);
	whb_wait_frames(test, pendant, 2);
	forget_events();
	msleep(1200);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(4, 0), THROTTLE(0), SCAN(4), KEY(4, 0), SYN);
	KUNIT_EXPECT_EQ(test, attribute_get(test, &pendant->hdev->dev, NULL, "awake"), 0);
	msleep(3000);
	expect_no_event(test);
	whb_no_more_frames(test, pendant, 2);

	/* heard again: it has missed what was sent meanwhile */
	whb_report(test, pendant, 0, 0, 0x0e, 0x14, 0);
	EXPECT_EVENTS(test, SELECT(4), ONE_HOT(4, 1), THROTTLE(2), SYN);
	whb_wait_frames(test, pendant, 3);
	whb_no_more_frames(test, pendant, 3);
	forget_events();
	msleep(1500);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(4, 0), THROTTLE(0), SYN);
}

/* What is silent by nature stays as it is: the selector off, no stream seen, another model */
static void whb_no_silence_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	whb_report(test, pendant, 0x04, 0, 0x0e, 0x11, 0);
	forget_events();
	msleep(5000);
	expect_no_event(test);

	whb_report(test, pendant, 0x04, 0, 0x0e, 0x11, 0);
	whb_report(test, pendant, 0x04, 0, 0x0e, 0x06, 0);
	forget_events();
	msleep(5000);
	expect_no_event(test);

	pendant = pendant_good(test);
	for (unsigned int i = 0; i < 3; i++)
		REPORT(test, pendant, 4, 5, 0, 0x11, 0, 0);
	forget_events();
	msleep(5000);
	expect_no_event(test);
}

/* Stopped while it waits for the next report of a stream */
static void whb_silence_unplug_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	for (unsigned int i = 0; i < 3; i++)
		whb_report(test, pendant, 0x04, 0, 0x0e, 0x11, 0);
	forget_events();
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(1, 0), THROTTLE(0), SCAN(4), KEY(4, 0), SYN);
	msleep(2000);
	expect_no_event(test);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	for (unsigned int i = 0; i < 3; i++)
		whb_report(test, pendant, 0x04, 0, 0x0e, 0x11, 0);
	forget_events();
	pendant_unplug(pendant);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(1, 0), THROTTLE(0), SCAN(4), KEY(4, 0), SYN);
	msleep(2000);
}

/* Reset, or sent a frame by another writer: its check byte is of another seed */
static void whb_seed_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	whb_report(test, pendant, 0, 0, 0x0d, 0x06, 0);
	whb_wait_frames(test, pendant, 2);
	whb_no_more_frames(test, pendant, 2);

	whb_report_of(test, pendant, 0x01, 0, 0, 0x0d, 0x06, 0);
	whb_wait_frames(test, pendant, 3);
	whb_report(test, pendant, 0, 0, 0x0d, 0x06, 0);
	whb_no_more_frames(test, pendant, 3);

	/* it misses the frame: one each second, though no two check bytes are the same */
	whb_report_of(test, pendant, 0x16, 0, 0, 0x0d, 0x06, 0);
	whb_wait_frames(test, pendant, 4);
	for (unsigned int i = 0; i < 50; i++)
		whb_report_of(test, pendant, 0x16, 0, 0, 0x0d, 0x06, 0);
	whb_no_more_frames(test, pendant, 4);
	msleep(600);
	for (unsigned int i = 0; i < 50; i++)
		whb_report_of(test, pendant, 0x16, 0, 0, 0x0d, 0x06, 0);
	whb_wait_frames(test, pendant, 5);
	whb_report(test, pendant, 0, 0, 0x0d, 0x06, 0);
	whb_no_more_frames(test, pendant, 5);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 102);
}

/* A clone that has no such check byte costs one frame, however often it reports */
static void whb_clone_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	for (unsigned int i = 0; i < 20; i++) {
		const u8 report[8] = { 4, 0xff, 0, 0, 0x0d, 0x06, 0, i };

		pendant_report(test, pendant, report, sizeof(report));
		whb_wait_frames(test, pendant, 2);
		whb_no_more_frames(test, pendant, 2);
	}
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 20);
}

/* While the first frame is on its way, its seed is as good as none */
static void whb_seed_in_flight_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	whb_report(test, pendant, 0, 0, 0x0d, 0x06, 0);
	whb_wait_frames(test, pendant, 2);
	WRITE_ONCE(pendant->hold, true);
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "row1", "1"));
	KUNIT_ASSERT_NE(test, 0, wait_for_completion_timeout(&pendant->held, 5 * HZ));
	whb_report(test, pendant, 0, 0, 0x0d, 0x06, 0);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 0);
	whb_report_of(test, pendant, 0x01, 0, 0, 0x0d, 0x06, 0);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, pendant, "xor_mismatches"), 1);
	WRITE_ONCE(pendant->hold, false);
	complete_all(&pendant->release);
	whb_wait_frames(test, pendant, 3);
	whb_no_more_frames(test, pendant, 3);
}

static void whb_crossed_test(struct kunit *test)
{
	struct pendant *whb = whb_good(test), *hb = pendant_good(test);

	forget_events();
	/* the HID core fills up a report that is too short, but the driver gets it as it came */
	REPORT(test, whb, 4, 0x01, 0x02, 0x11, 1, 0);
	REPORT(test, hb, 4, 0x5a, 0x01, 0x02, 0x0d, 0x11, 1, 0);
	expect_no_event(test);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, whb, "bad_reports"), 1);
	KUNIT_EXPECT_EQ(test, pendant_stat(test, hb, "bad_reports"), 1);
	whb_report(test, whb, 1, 0, 0x0d, 0x11, 0);
	EXPECT_EVENTS(test, SELECT(1), ONE_HOT(1, 1), THROTTLE(1), SCAN(1), KEY(1, 1), SYN);
	REPORT(test, hb, 4, 1, 0, 0x11, 0, 0);
	EXPECT_EVENTS(test, SELECT(1), ONE_HOT(1, 1), SCAN(1), KEY(1, 1), SYN);
}

static void whb_display_test(struct kunit *test)
{
	static const u8 want[WHB_CHUNKS][8] = {
		{ 0x06, 0xfe, 0xfd, 0xfe, 0xc1, 0x0c, 0x00, 0x7a },
		{ 0x06, 0x0d, 0x06, 0x00, 0xd2, 0x9e, 0x00, 0x00 },
		{ 0x06, 0x0a, 0x00, 0x64, 0x00, 0x50, 0x00, 0x00 },
	};
	struct pendant *pendant = whb_good(test);
	unsigned int chunks;

	KUNIT_EXPECT_EQ(test, 0, pendant_show(test, pendant, "rows", "12.345 -6.789 0.001"));
	KUNIT_EXPECT_EQ(test, 0, pendant_show(test, pendant, "mode", "step"));
	KUNIT_EXPECT_EQ(test, 0, pendant_show(test, pendant, "coordinates", "work"));
	KUNIT_EXPECT_EQ(test, 0, pendant_show(test, pendant, "reset", "1"));
	KUNIT_EXPECT_EQ(test, 0, pendant_show(test, pendant, "feedrate_override", "100"));
	KUNIT_EXPECT_EQ(test, 0, pendant_show(test, pendant, "spindle_override", "80"));
	KUNIT_EXPECT_EQ(test, -EINVAL, pendant_show(test, pendant, "mode", "steps"));
	KUNIT_EXPECT_EQ(test, -EINVAL, pendant_show(test, pendant, "coordinates", "x1"));
	KUNIT_EXPECT_EQ(test, -ERANGE, pendant_show(test, pendant, "reset", "2"));
	KUNIT_EXPECT_EQ(test, -EINVAL, pendant_show(test, pendant, "rows", "1 2"));
	KUNIT_EXPECT_EQ(test, -EINVAL, pendant_show(test, pendant, "rows", "1 2 3 4"));
	KUNIT_EXPECT_EQ(test, -ERANGE, pendant_show(test, pendant, "rows", "1 65536 3"));
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "flush", "1"));
	chunks = pendant_chunks(pendant);
	KUNIT_ASSERT_GE(test, chunks, WHB_CHUNKS);
	KUNIT_EXPECT_MEMEQ(test, pendant->chunk[chunks - WHB_CHUNKS], want, sizeof(want));
}

static int xhc_driver_init(struct kunit_suite *suite)
{
	return input_register_handler(&user);
}

static void xhc_driver_exit(struct kunit_suite *suite)
{
	input_unregister_handler(&user);
}

static struct kunit_case xhc_driver_cases[] = {
	KUNIT_CASE(probe_test),
	KUNIT_CASE(probe_frame_test),
	KUNIT_CASE_PARAM(desc_test, desc_gen_params),
	KUNIT_CASE(registration_test),
	KUNIT_CASE(order_test),
	KUNIT_CASE(slots_test),
	KUNIT_CASE(unknown_test),
	KUNIT_CASE(unknown_count_test),
	KUNIT_CASE(inhibited_test),
	KUNIT_CASE(other_keys_test),
	KUNIT_CASE(sleep_test),
	KUNIT_CASE_PARAM(bad_report_test, bad_gen_params),
	KUNIT_CASE(two_pendants_test),
	KUNIT_CASE(remap_test),
	KUNIT_CASE(remap_shared_test),
	KUNIT_CASE(remap_held_test),
	KUNIT_CASE(suspend_test),
	KUNIT_CASE(unplug_test),
	KUNIT_CASE(unplug_in_frame_test),
	KUNIT_CASE(retry_test),
	KUNIT_CASE(short_transfer_test),
	KUNIT_CASE(wake_up_test),
	KUNIT_CASE(forgotten_day_test),
	KUNIT_CASE(clone_test),
	KUNIT_CASE(late_report_test),
	KUNIT_CASE_PARAM(refresh_test, refresh_gen_params),
	KUNIT_CASE(refresh_of_wake_up_test),
	KUNIT_CASE(flush_results_test),
	KUNIT_CASE_PARAM(flush_error_test, error_gen_params),
	KUNIT_CASE(failure_after_resume_test),
	KUNIT_CASE(whb_probe_test),
	KUNIT_CASE(whb_descriptor_test),
	KUNIT_CASE(whb_order_test),
	KUNIT_CASE(whb_unknown_test),
	KUNIT_CASE(whb_stream_test),
	KUNIT_CASE(whb_sleep_test),
	KUNIT_CASE(whb_sleep_suspend_test),
	KUNIT_CASE(whb_silence_test),
	KUNIT_CASE(whb_no_silence_test),
	KUNIT_CASE(whb_silence_unplug_test),
	KUNIT_CASE(whb_seed_test),
	KUNIT_CASE(whb_clone_test),
	KUNIT_CASE(whb_seed_in_flight_test),
	KUNIT_CASE(whb_crossed_test),
	KUNIT_CASE(whb_display_test),
	{}
};

static struct kunit_suite xhc_driver_suite = {
	.name = "hid_xhc_driver",
	.suite_init = xhc_driver_init,
	.suite_exit = xhc_driver_exit,
	.test_cases = xhc_driver_cases,
};

kunit_test_suite(xhc_driver_suite);

MODULE_DESCRIPTION("KUnit tests of the XHC pendant's driver");
MODULE_LICENSE("GPL");
