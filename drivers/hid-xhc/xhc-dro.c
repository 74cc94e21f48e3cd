// SPDX-License-Identifier: GPL-2.0-only
/*
 * XHC pendant: the display (digital read-out) and the worker that sends its frames
 *
 * A write to an attribute changes @want and returns; the worker takes the newest values when
 * a frame is due. So a burst of changes costs one frame, and a slow pendant does not block
 * writers. A frame is sent whole, chunk after chunk, because the pendant starts over at each
 * chunk that begins with the magic.
 */

#include <linux/completion.h>
#include <linux/hid.h>
#include <linux/jiffies.h>
#include <linux/ktime.h>
#include <linux/lockdep.h>
#include <linux/slab.h>
#include <linux/time.h>

#include "xhc.h"
#include "trace.h"

/* Delay of the first change of a burst, so that the whole burst is sent in one frame */
#define XHC_BURST_MS		5
/* Delay of the next frame after one that has failed */
#define XHC_RETRY_MS		1000

/**
 * struct xhc_flush - a caller that waits for a frame
 * @node: in the list of the display, or in that of the worker while the frame is in flight;
 *	  under the lock of the display
 * @done: completed under the display's lock, with @node in no list
 * @result: of the frame: 0 or an error
 */
struct xhc_flush {
	struct list_head node;
	struct completion done;
	int result;
};

/*
 * The day of the month. The timer goes off at its end, or when the clock is set to a time behind
 * that, also while the frame is on its way.
 */
static int xhc_dro_today(struct xhc_dro *dro)
{
	time64_t now = ktime_get_real_seconds();
	time64_t midnight;
	struct tm tm;

	time64_to_tm(now, 0, &tm);
	midnight = now + 86400 - (tm.tm_hour * 3600 + tm.tm_min * 60 + tm.tm_sec);
	hrtimer_start(&dro->midnight, ktime_set(midnight, 0), HRTIMER_MODE_ABS);
	return tm.tm_mday;
}

/* Let the worker run after @delay jiffies; a transfer may take seconds */
static void xhc_dro_schedule(struct xhc_dro *dro, unsigned long delay)
{
	if (READ_ONCE(dro->running))
		mod_delayed_work(system_long_wq, &dro->work, delay);
}

/* A pending flush overrides the rate limit */
static bool xhc_dro_due(struct xhc_dro *dro, ktime_t now)
{
	lockdep_assert_held(&dro->lock);

	return !list_empty(&dro->flushes) || !ktime_before(now, dro->next);
}

static void xhc_dro_schedule_frame(struct xhc_dro *dro)
{
	ktime_t now = ktime_get();
	unsigned long delay = 0;

	/* one more: the current jiffy is partly over */
	if (!xhc_dro_due(dro, now))
		delay = usecs_to_jiffies(ktime_us_delta(dro->next, now)) + 1;
	xhc_dro_schedule(dro, delay);
}

static void xhc_dro_end_flushes(struct xhc_dro *dro, struct list_head *flushes, int result)
{
	struct xhc_flush *flush, *next;

	lockdep_assert_held(&dro->lock);

	list_for_each_entry_safe(flush, next, flushes, node) {
		list_del(&flush->node);
		flush->result = result;
		complete(&flush->done);
	}
}

static int xhc_dro_send(struct xhc_device *xhc, const u8 *payload, size_t size)
{
	struct xhc_dro *dro = &xhc->dro;

	for (unsigned int i = 0; i < xhc->model->chunks; i++) {
		int err;

		/* stopping: do not start another transfer */
		if (i && !READ_ONCE(dro->running))
			return -ENODEV;

		xhc_encode_chunk(payload, size, i, dro->report);
		err = dro->send(xhc, dro->report);
		if (err)
			return err;
	}
	return 0;
}

/* Return: 0, also if there was nothing to send, or the error of the transfer */
static int xhc_dro_frame(struct xhc_device *xhc, const struct xhc_display *display,
			 bool force)
{
	struct xhc_dro *dro = &xhc->dro;
	u8 payload[XHC_PAYLOAD_MAX];
	int size, err;

	size = xhc_encode_payload(xhc->model, display, payload);
	if (size < 0)
		return size;
	if (!force && size == dro->shown_size && !memcmp(payload, dro->shown, size))
		return 0;

	dro->shown_size = 0;
	WRITE_ONCE(dro->seed_on_its_way, payload[XHC_SEED_AT]);
	WRITE_ONCE(dro->sending, true);
	err = xhc_dro_send(xhc, payload, size);
	if (!err)
		WRITE_ONCE(dro->seed, payload[XHC_SEED_AT]);
	WRITE_ONCE(dro->sending, false);
	trace_xhc_frame(xhc->hdev, payload, size, err);
	if (err) {
		xhc_count(xhc, XHC_FRAME_ERRORS);
		if (!dro->failing && err != -ENODEV)
			hid_warn_ratelimited(xhc->hdev, "display frame not taken: %d\n", err);
		dro->failing = err != -ENODEV;
		return err;
	}

	xhc_count(xhc, XHC_FRAMES_SENT);
	memcpy(dro->shown, payload, size);
	dro->shown_size = size;
	dro->failing = false;
	return 0;
}

static void xhc_dro_work(struct work_struct *work)
{
	struct xhc_dro *dro = container_of(to_delayed_work(work), struct xhc_dro, work);
	struct xhc_device *xhc = container_of(dro, struct xhc_device, dro);
	struct xhc_display display;
	LIST_HEAD(flushes);
	bool force;
	int err;

	scoped_guard(mutex, &dro->lock) {
		if (!dro->running)
			return;
		if (!xhc_dro_due(dro, ktime_get())) {
			xhc_dro_schedule_frame(dro);
			return;
		}
		display = *xhc_dro_want(xhc);
		list_splice_init(&dro->flushes, &flushes);
		force = !list_empty(&flushes);
		dro->changed = false;
		if (!display.day && !xhc->model->seed)
			display.day = xhc_dro_today(dro);
	}

	/* cleared first: the frame covers all that was lost before it was started */
	if (READ_ONCE(dro->lost)) {
		WRITE_ONCE(dro->lost, false);
		dro->shown_size = 0;
	}
	err = xhc_dro_frame(xhc, &display, force);

	guard(mutex)(&dro->lock);
	dro->next = ktime_add_ms(ktime_get(), err ? XHC_RETRY_MS : dro->refresh_ms);
	xhc_dro_end_flushes(dro, &flushes, err);

	if (!dro->running)
		return;
	if (err || dro->changed || !list_empty(&dro->flushes))
		xhc_dro_schedule_frame(dro);
}

/* Midnight, or the clock was set to a time after it */
static enum hrtimer_restart xhc_dro_midnight(struct hrtimer *timer)
{
	xhc_dro_schedule(container_of(timer, struct xhc_dro, midnight), 0);
	return HRTIMER_NORESTART;
}

/**
 * xhc_dro_want() - the values that the display is to show
 * @xhc: the pendant, with the lock of its display held
 *
 * Return: the values; xhc_dro_changed() sends what is changed in them.
 */
struct xhc_display *xhc_dro_want(struct xhc_device *xhc)
{
	lockdep_assert_held(&xhc->dro.lock);
	return &xhc->dro.want;
}

/**
 * xhc_dro_changed() - schedule a frame with changed values
 * @xhc: the pendant, with the lock of its display held and new values in it
 */
void xhc_dro_changed(struct xhc_device *xhc)
{
	ktime_t soon = ktime_add_ms(ktime_get(), XHC_BURST_MS);
	struct xhc_dro *dro = &xhc->dro;

	if (!dro->changed && ktime_before(dro->next, soon))
		dro->next = soon;
	dro->changed = true;
	xhc_dro_schedule_frame(dro);
}

/**
 * xhc_dro_flush() - send a frame now, also when nothing has changed, and wait for it
 * @xhc: the pendant
 *
 * Context: sleeps as long as the transfer takes.
 *
 * Return: 0 if the pendant has accepted the frame, otherwise the error of its transfer,
 * -ENODEV if it is removed or suspended, -ERESTARTSYS on a signal.
 */
int xhc_dro_flush(struct xhc_device *xhc)
{
	struct xhc_dro *dro = &xhc->dro;
	struct xhc_flush flush;
	int err;

	init_completion(&flush.done);
	scoped_guard(mutex, &dro->lock) {
		if (!dro->running)
			return -ENODEV;
		list_add_tail(&flush.node, &dro->flushes);
		xhc_dro_schedule_frame(dro);
	}

	err = wait_for_completion_interruptible(&flush.done);

	guard(mutex)(&dro->lock);
	if (!err || completion_done(&flush.done))
		return flush.result;
	list_del(&flush.node);
	return err;
}

/**
 * xhc_dro_lost() - schedule a frame because the display contents are unknown
 * @xhc: the pendant
 *
 * Context: any.
 */
void xhc_dro_lost(struct xhc_device *xhc)
{
	struct xhc_dro *dro = &xhc->dro;

	WRITE_ONCE(dro->lost, true);
	xhc_dro_schedule(dro, 0);
}

/**
 * xhc_dro_report() - check whether a report was made with the seed last sent
 * @xhc: the pendant
 * @data: the report
 * @day: the day that it returns, if the seed is the day
 *
 * While a frame is in flight it is not known which of two seeds is correct. Otherwise a pendant
 * that returns another day than before, and not the one that it was sent, has been reset or has
 * received a frame from another writer: send a frame. If it continues, and has returned the
 * correct day before, the frame was lost on the radio: send another one each second. There are
 * clones that never return the day.
 *
 * A check byte differs from report to report, and does not reveal the seed it was made from: all
 * wrong ones count as the same.
 *
 * Context: any, but one report at a time.
 *
 * Return: true if it is the seed of the last accepted frame or of one in flight.
 */
bool xhc_dro_report(struct xhc_device *xhc, const u8 *data, u8 day)
{
	const struct xhc_model *model = xhc->model;
	struct xhc_dro *dro = &xhc->dro;
	u8 sent = READ_ONCE(dro->seed);
	ktime_t now = ktime_get();
	bool match = xhc_report_matches(model, data, sent) ||
		     xhc_report_matches(model, data, READ_ONCE(dro->seed_on_its_way));
	u8 returned = day;

	if (!sent || READ_ONCE(dro->sending))
		return match;

	if (model->seed)
		returned = match ? model->seed : 0;
	if (match) {
		dro->returns_seed = true;
		dro->answered = now;
	} else if (returned != dro->returned ||
		   (dro->returns_seed && ktime_ms_delta(now, dro->answered) >= XHC_RETRY_MS)) {
		dro->answered = now;
		xhc_dro_lost(xhc);
	}
	dro->returned = returned;
	return match;
}

/**
 * xhc_dro_start() - start sending frames
 * @xhc: the pendant
 *
 * The display contents are unknown, so a first frame is always sent.
 */
void xhc_dro_start(struct xhc_device *xhc)
{
	struct xhc_dro *dro = &xhc->dro;

	guard(mutex)(&dro->lock);
	WRITE_ONCE(dro->running, true);
	dro->shown_size = 0;
	dro->failing = false;
	dro->next = ktime_get();
	dro->changed = true;
	xhc_dro_schedule_frame(dro);
}

/**
 * xhc_dro_stop() - stop sending frames; a pending flush ends with -ENODEV
 * @xhc: the pendant
 *
 * Context: sleeps until the transfer in flight is over.
 */
void xhc_dro_stop(struct xhc_device *xhc)
{
	struct xhc_dro *dro = &xhc->dro;

	scoped_guard(mutex, &dro->lock)
		WRITE_ONCE(dro->running, false);
	hrtimer_cancel(&dro->midnight);
	cancel_delayed_work_sync(&dro->work);
	scoped_guard(mutex, &dro->lock)
		xhc_dro_end_flushes(dro, &dro->flushes, -ENODEV);
}

/**
 * xhc_dro_init() - initialise the display in the stopped state, with all values zero
 * @xhc: the pendant
 * @send: sends a feature report, see struct xhc_dro
 *
 * Return: 0 on success, -ENOMEM otherwise.
 */
int xhc_dro_init(struct xhc_device *xhc, int (*send)(struct xhc_device *xhc, u8 *report))
{
	struct xhc_dro *dro = &xhc->dro;

	dro->send = send;
	mutex_init(&dro->lock);
	INIT_LIST_HEAD(&dro->flushes);
	INIT_DELAYED_WORK(&dro->work, xhc_dro_work);
	hrtimer_setup(&dro->midnight, xhc_dro_midnight, CLOCK_REALTIME, HRTIMER_MODE_ABS);
	dro->refresh_ms = XHC_REFRESH_DEFAULT_MS;
	dro->returned = -1;

	/* a separate allocation, as the bus does DMA from it */
	dro->report = devm_kmalloc(&xhc->hdev->dev, XHC_CHUNK_SIZE, GFP_KERNEL);
	return dro->report ? 0 : -ENOMEM;
}
