// SPDX-License-Identifier: GPL-2.0-only
/*
 * XHC pendant: the display (digital read-out), and the one worker that sends its frames
 *
 * Users change @want and go; the worker takes the newest values when a frame is due. So
 * a burst of changes costs one frame and a slow pendant blocks nobody. A frame is sent
 * whole, chunk after chunk, because the pendant starts over at each chunk that begins
 * with the magic.
 */

#include <linux/hid.h>
#include <linux/jiffies.h>
#include <linux/ktime.h>
#include <linux/slab.h>
#include <linux/time.h>

#include "xhc.h"
#include "trace.h"

/* How long the first change of a burst waits for the rest of it, so that they go in one frame */
#define XHC_BURST_MS		5
/* How long after a frame that was not taken the next one is tried */
#define XHC_RETRY_MS		1000
/* How often to look at the calendar: the clock may be set at any time */
#define XHC_CALENDAR_SEC	60

static int xhc_day_of_month(void)
{
	struct tm tm;

	time64_to_tm(ktime_get_real_seconds(), 0, &tm);
	return tm.tm_mday;
}

static unsigned long xhc_calendar_delay(void)
{
	struct tm tm;
	long left;

	time64_to_tm(ktime_get_real_seconds(), 0, &tm);
	left = 86400 - (tm.tm_hour * 3600 + tm.tm_min * 60 + tm.tm_sec);
	return min_t(long, left, XHC_CALENDAR_SEC) * HZ;
}

/* Let the worker run after @delay jiffies, whatever was planned before */
static void xhc_dro_schedule(struct xhc_dro *dro, unsigned long delay)
{
	lockdep_assert_held(&dro->lock);

	if (!dro->running)
		return;
	cancel_delayed_work(&dro->work);
	schedule_delayed_work(&dro->work, delay);
}

/* A frame that somebody waits for is due at once: a change beside it must not put it off */
static void xhc_dro_schedule_frame(struct xhc_dro *dro)
{
	bool awaited = dro->flush_wanted != dro->flush_done;
	unsigned long now = jiffies;

	xhc_dro_schedule(dro, !awaited && time_after(dro->next, now) ? dro->next - now : 0);
}

static int xhc_dro_send(struct xhc_pendant *pendant, const u8 *payload, size_t size)
{
	struct xhc_dro *dro = &pendant->dro;

	for (unsigned int i = 0; i < pendant->model->chunks; i++) {
		int err;

		/* on the way out, not one transfer more than the one that is in flight */
		if (!READ_ONCE(dro->running))
			return -ENODEV;

		xhc_encode_chunk(payload, size, i, dro->report);
		err = xhc_send_report(pendant, dro->report);
		if (err)
			return err;
	}
	return 0;
}

/* Return: 0, also when there was nothing to send, or the error of the transfer */
static int xhc_dro_frame(struct xhc_pendant *pendant, const struct xhc_display *display,
			 bool force)
{
	struct xhc_dro *dro = &pendant->dro;
	u8 payload[XHC_PAYLOAD_MAX];
	int size, err;

	size = xhc_encode_payload(pendant->model, display, payload);
	if (size < 0)
		return size;
	if (!force && size == dro->shown_size && !memcmp(payload, dro->shown, size))
		return 0;

	dro->shown_size = 0;
	WRITE_ONCE(dro->day_on_its_way, display->day);
	err = xhc_dro_send(pendant, payload, size);
	trace_frame(pendant->hdev, payload, size, err);
	if (err) {
		xhc_count(pendant, XHC_FRAME_ERRORS);
		if (!dro->failing && err != -ENODEV)
			hid_warn_ratelimited(pendant->hdev, "display frame not taken: %d\n", err);
		dro->failing = true;
		return err;
	}

	xhc_count(pendant, XHC_FRAMES_SENT);
	WRITE_ONCE(dro->day, display->day);
	memcpy(dro->shown, payload, size);
	dro->shown_size = size;
	dro->failing = false;
	return 0;
}

static void xhc_dro_work(struct work_struct *work)
{
	struct xhc_dro *dro = container_of(to_delayed_work(work), struct xhc_dro, work);
	struct xhc_pendant *pendant = container_of(dro, struct xhc_pendant, dro);
	struct xhc_display display;
	unsigned long ticket;
	bool force;
	int err;

	scoped_guard(mutex, &dro->lock) {
		display = dro->want;
		ticket = dro->flush_wanted;
		force = ticket != dro->flush_done;
		dro->changed = false;
	}
	if (!display.day)
		display.day = xhc_day_of_month();

	err = xhc_dro_frame(pendant, &display, force);

	guard(mutex)(&dro->lock);
	dro->next = jiffies + msecs_to_jiffies(err ? XHC_RETRY_MS : dro->refresh_ms);
	dro->flush_done = ticket;
	dro->flush_result = err;
	wake_up_all(&dro->flushed);

	if (err || dro->changed || dro->flush_wanted != dro->flush_done)
		xhc_dro_schedule_frame(dro);
	else if (!dro->want.day)
		xhc_dro_schedule(dro, xhc_calendar_delay());
}

/**
 * xhc_dro_changed() - have a frame sent when one is due
 * @pendant: the pendant, with the lock of its display held and new values in it
 */
void xhc_dro_changed(struct xhc_pendant *pendant)
{
	/* one more: the tick that runs now is over soon */
	unsigned long soon = jiffies + msecs_to_jiffies(XHC_BURST_MS) + 1;
	struct xhc_dro *dro = &pendant->dro;

	if (!dro->changed && time_before(dro->next, soon))
		dro->next = soon;
	dro->changed = true;
	xhc_dro_schedule_frame(dro);
}

/**
 * xhc_dro_flush() - send a frame now, also when nothing has changed, and wait for it
 * @pendant: the pendant
 *
 * Context: sleeps as long as the transfer takes.
 *
 * Return: 0 when the pendant has taken the frame, the transfer's error when it has not,
 * -ENODEV when it goes away or is suspended, -ERESTARTSYS on a signal.
 */
int xhc_dro_flush(struct xhc_pendant *pendant)
{
	struct xhc_dro *dro = &pendant->dro;
	unsigned long ticket;
	int err;

	scoped_guard(mutex, &dro->lock) {
		ticket = ++dro->flush_wanted;
		xhc_dro_schedule_frame(dro);
	}

	err = wait_event_interruptible(dro->flushed,
				       !READ_ONCE(dro->running) ||
				       (long)(READ_ONCE(dro->flush_done) - ticket) >= 0);
	if (err)
		return err;

	guard(mutex)(&dro->lock);
	return (long)(dro->flush_done - ticket) >= 0 ? dro->flush_result : -ENODEV;
}

/**
 * xhc_dro_day_sent() - may a pendant go by this day
 * @pendant: the pendant
 * @day: the day, as a report says it
 *
 * It goes by the day of the last frame that it has taken. While one is on its way nobody knows
 * whether it has: the report that it sends next may be here before the end of the transfer.
 *
 * Context: any.
 *
 * Return: true for that day or, while a frame is on its way, that one's; 0 before the first.
 */
bool xhc_dro_day_sent(struct xhc_pendant *pendant, u8 day)
{
	return day == READ_ONCE(pendant->dro.day) || day == READ_ONCE(pendant->dro.day_on_its_way);
}

/**
 * xhc_dro_start() - begin to send frames, with one at once: who knows what is shown
 * @pendant: the pendant
 */
void xhc_dro_start(struct xhc_pendant *pendant)
{
	struct xhc_dro *dro = &pendant->dro;

	guard(mutex)(&dro->lock);
	dro->running = true;
	dro->shown_size = 0;
	dro->next = jiffies;
	dro->changed = true;
	xhc_dro_schedule_frame(dro);
}

/**
 * xhc_dro_stop() - send no more frames; those who wait for one are told -ENODEV
 * @pendant: the pendant
 *
 * Context: sleeps until the transfer in flight is over.
 */
void xhc_dro_stop(struct xhc_pendant *pendant)
{
	struct xhc_dro *dro = &pendant->dro;

	scoped_guard(mutex, &dro->lock)
		WRITE_ONCE(dro->running, false);
	wake_up_all(&dro->flushed);
	cancel_delayed_work_sync(&dro->work);
}

/**
 * xhc_dro_init() - make a display that shows zeros; it starts stopped
 * @pendant: the pendant
 *
 * Return: 0 or -ENOMEM.
 */
int xhc_dro_init(struct xhc_pendant *pendant)
{
	struct xhc_dro *dro = &pendant->dro;

	mutex_init(&dro->lock);
	init_waitqueue_head(&dro->flushed);
	INIT_DELAYED_WORK(&dro->work, xhc_dro_work);
	dro->refresh_ms = XHC_REFRESH_DEFAULT_MS;

	/* memory of its own: the bus does DMA from it */
	dro->report = devm_kmalloc(&pendant->hdev->dev, XHC_CHUNK_SIZE, GFP_KERNEL);
	return dro->report ? 0 : -ENOMEM;
}
