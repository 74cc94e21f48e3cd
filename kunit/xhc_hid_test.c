// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of XHC pendants, from the bus to the events
 *
 * hid-xhc.ko is loaded like by users, between the two ends of xhc_hid_rig.h. No symbol of the
 * driver is used.
 */

#include <linux/delay.h>
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
	/* and it gets a report, bound or not */
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

/* When the input device is registered, reports are processed, and the display is writable */
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
	/* this was before the user: neither its keys nor its detents are reported later */
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
	/* 21h is a scan code of the keymap, but not a key of the pendant */
	REPORT(test, pendant, 4, 0x21, 0x05, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(0x21), SYN);
	REPORT(test, pendant, 4, 0xff, 0x05, 0, 0, 1);
	EXPECT_EVENTS(test, SCAN(0xff), SYN);
	/* an unknown selector code is off, and releases the axis */
	REPORT(test, pendant, 4, 0, 0x05, 0x13, 0, 1);
	EXPECT_EVENTS(test, SELECT(3), ONE_HOT(3, 1), SYN);
	REPORT(test, pendant, 4, 0, 0x05, 0x19, 0, 1);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(3, 0), SYN);
}

/* Each unknown code is counted once when it appears, also after another one */
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

/* The input core drops the events of an inhibited device; the next report corrects the state */
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

	/* turned on in the meantime, and not changed after that */
	inhibit(test, input, "1");
	REPORT(test, pendant, 4, 0, 0, 0x12, 0, 1);
	inhibit(test, input, "0");
	forget_events();
	REPORT(test, pendant, 4, 0, 0, 0x12, 0, 1);
	EXPECT_EVENTS(test, SELECT(2), ONE_HOT(2, 1), SYN);
}

/* A report only changes keys that are in it or in the one before */
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
	/* and awake again, immediately with the wheel */
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

/* An invalid report changes nothing: pressed keys stay pressed */
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
	/* the same codes: a separate press, and the code of the selector as for HB03 */
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

	/* scan codes of no key are an error, and so are those beyond the table */
	KUNIT_EXPECT_NE(test, 0, remap(input, 0x27, BTN_1));
	KUNIT_EXPECT_NE(test, 0, remap(input, 0xff, BTN_1));
}

/* Two scan codes with one key code: it is pressed while either is */
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

/* A key is held while its code changes: the old one must not stay pressed */
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

	/* a key with the code of a selector, set back: the selector keeps its code */
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
	/* the transport still delivers a pending report: it must not press the key again */
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

/* The driver waits for the transfer in flight, and starts no other */
static void unplug_in_frame_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	unsigned int chunks;

	pendant->hold = true;
	chunks = pendant_chunks(pendant);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	KUNIT_ASSERT_NE(test, 0, wait_for_completion_timeout(&pendant->held, 5 * HZ));

	pendant_release_later(pendant);
	pendant_unplug(pendant);
	flush_delayed_work(&later.work);
	KUNIT_EXPECT_EQ(test, pendant->chunks, chunks + 1);
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
