// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of XHC pendants with a WHB04B
 * See xhc_hid_test.c.
 */

#include <linux/delay.h>
#include <linux/module.h>

#include "xhc_hid_rig.h"

#define WHB_CHUNKS	3
#define THROTTLE(position)	{ EV_ABS, ABS_THROTTLE, (position) }

/* From a replacement firmware, which reportedly copied it from a unit */
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

	/* with this bit all seeds in use are distinguishable */
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

/* For a time that is too short to be silence for the driver */
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

	/* HB03 and HB04 have no second rotary switch, and neither B nor C */
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

/* Streamed reports cause no events, except for detents in them */
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

/* One report follows that of sleep: its content has no meaning */
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

		/* and awake again, immediately with the wheel */
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

/* The radio link is lost while reports are streamed */
static void whb_silence_test(struct kunit *test)
{
	struct pendant *pendant = whb_good(test);

	for (unsigned int i = 0; i < 5; i++) {
		whb_report(test, pendant, 0x04, 0, 0x0e, 0x14, 0);
		msleep(400);
	}
	/* reports were received all the time */
	KUNIT_EXPECT_EQ(test, attribute_get(test, &pendant->hdev->dev, NULL, "awake"), 1);
	whb_wait_frames(test, pendant, 2);
	forget_events();
	msleep(1200);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(4, 0), THROTTLE(0), SCAN(4), KEY(4, 0), SYN);
	KUNIT_EXPECT_EQ(test, attribute_get(test, &pendant->hdev->dev, NULL, "awake"), 0);
	msleep(3000);
	expect_no_event(test);
	whb_no_more_frames(test, pendant, 2);

	/* reports again: it has missed frames sent in the meantime */
	whb_report(test, pendant, 0, 0, 0x0e, 0x14, 0);
	EXPECT_EVENTS(test, SELECT(4), ONE_HOT(4, 1), THROTTLE(2), SYN);
	whb_wait_frames(test, pendant, 3);
	whb_no_more_frames(test, pendant, 3);
	forget_events();
	msleep(1500);
	EXPECT_EVENTS(test, SELECT(0), ONE_HOT(4, 0), THROTTLE(0), SYN);
}

/* Expected silence changes nothing: the selector off, no stream received, another model */
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

/* Stopped while waiting for the next report of a stream */
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

/* After a reset, or a frame by another writer: its check byte has another seed */
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

	/* it misses the frame: one per second, although all check bytes differ */
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

/* A clone without this check byte costs one frame, for any number of reports */
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

/* While the first frame is being sent, its seed is not used */
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
	/* the HID core pads a report that is too short, but the driver gets it as received */
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

static int xhc_whb_init(struct kunit_suite *suite)
{
	return input_register_handler(&user);
}

static void xhc_whb_exit(struct kunit_suite *suite)
{
	input_unregister_handler(&user);
}

static struct kunit_case xhc_whb_cases[] = {
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

static struct kunit_suite xhc_whb_suite = {
	.name = "hid_xhc_whb",
	.suite_init = xhc_whb_init,
	.suite_exit = xhc_whb_exit,
	.test_cases = xhc_whb_cases,
};

kunit_test_suite(xhc_whb_suite);

MODULE_DESCRIPTION("KUnit tests of the XHC pendant's driver: WHB04B");
MODULE_LICENSE("GPL");
