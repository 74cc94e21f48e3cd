// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of XHC pendants, display frames
 * See xhc_hid_test.c.
 */

#include <linux/delay.h>
#include <linux/kmsg_dump.h>
#include <linux/module.h>
#include <linux/string.h>

#include "xhc_hid_rig.h"

/* ---- frames that fail ---- */

static void retry_test(struct kunit *test)
{
	struct pendant *pendant = pendant_plug(test, 0xeb70, good_desc, sizeof(good_desc));
	unsigned int chunks;

	KUNIT_ASSERT_TRUE(test, pendant_bound(pendant));
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, FRAME_CHUNKS));
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));

	/* stalled: the frame ends with its first chunk, and is not retried immediately */
	pendant_fail(pendant, -EPIPE, UINT_MAX);
	chunks = pendant_chunks(pendant);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, chunks + 1));
	msleep(500);
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), chunks + 1);

	/* but after a second, from its start, until it succeeds */
	pendant_fail(pendant, 0, 0);
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, chunks + 1 + FRAME_CHUNKS));
	KUNIT_EXPECT_EQ(test, pendant->chunk[chunks + 1][1], 0xfe);
	msleep(1500);
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), chunks + 1 + FRAME_CHUNKS);
}

/* A transfer of only a part of the report is an error, too */
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

/* ---- unknown content of the display ---- */

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
	/* it has missed that frame: the next one is sent after a second, not for each report */
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

/* A report that was sent before the pendant received another day does not cause a frame */
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

	/* nor does one that is received while the frame is being sent */
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

/* Minimum time in microseconds from the end of a frame to the start of the next */
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

/* refresh_ms is the minimum time, for any length of jiffies and any time of a change */
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

/* It is also kept by a frame that a report causes */
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

/* The first of two frames fails: each caller gets the result of its frame */
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
	/* the failed frame, up to its first chunk, and the one after it */
	KUNIT_EXPECT_EQ(test, pendant_chunks(pendant), 2 * FRAME_CHUNKS + 1);
}

struct error_row {
	int transfer;
	int flush;
};

static const struct error_row error_rows[] = {
	{ -EPIPE, -EPIPE },
	{ -ETIMEDOUT, -ETIMEDOUT },
	{ -ENOMEM, -ENOMEM },
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

/* Number of lines of the kernel log with this text */
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

/* After a frame that was interrupted by suspend, the next failure is logged */
static void failure_after_resume_test(struct kunit *test)
{
	struct pendant *pendant = pendant_good(test);
	unsigned int before;

	WRITE_ONCE(pendant->hold, true);
	KUNIT_ASSERT_EQ(test, 0, pendant_show(test, pendant, "feedrate", "1"));
	KUNIT_ASSERT_NE(test, 0, wait_for_completion_timeout(&pendant->held, 5 * HZ));
	pendant_release_later(pendant);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_suspend(pendant->hdev, PMSG_SUSPEND));
	flush_delayed_work(&later.work);
	WRITE_ONCE(pendant->hold, false);

	before = log_count(test, "display frame not taken");
	pendant_fail(pendant, -EPIPE, 2);
	KUNIT_ASSERT_EQ(test, 0, hid_driver_resume(pendant->hdev));
	KUNIT_ASSERT_TRUE(test, pendant_wait_chunks(pendant, FRAME_CHUNKS + 3));
	KUNIT_EXPECT_EQ(test, log_count(test, "display frame not taken"), before + 1);
}

static int xhc_display_init(struct kunit_suite *suite)
{
	return input_register_handler(&user);
}

static void xhc_display_exit(struct kunit_suite *suite)
{
	input_unregister_handler(&user);
}

static struct kunit_case xhc_display_cases[] = {
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
	{}
};

static struct kunit_suite xhc_display_suite = {
	.name = "hid_xhc_display",
	.suite_init = xhc_display_init,
	.suite_exit = xhc_display_exit,
	.test_cases = xhc_display_cases,
};

kunit_test_suite(xhc_display_suite);

MODULE_DESCRIPTION("KUnit tests of the XHC pendant's driver: its display");
MODULE_LICENSE("GPL");
