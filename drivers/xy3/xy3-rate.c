// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: the rate of the backchannel - sync, a change of the rate, the search for it
 */

#include <linux/delay.h>
#include <linux/device.h>
#include <linux/jiffies.h>
#include <linux/kernel.h>
#include <linux/lockdep.h>
#include <linux/math.h>

#include "trace.h"
#include "xy3.h"

/* Time at each rate in the first round; doubled in each further one */
#define XY3_SEARCH_MS		500
#define XY3_SEARCH_MS_MAX	4000
/* Pause before skipping a rate that the UART refuses; it may refuse all of them */
#define XY3_SEARCH_SKIP_MS	100
/* Number of bytes without sync, or of damaged ones, that prove a rate wrong */
#define XY3_SEARCH_BYTES	1024
#define XY3_SEARCH_ERRORS	4

/* Time limit for sync with a head at a new rate */
#define XY3_RESYNC_MS		3000
/* Packets that prove a new rate; a sync packet alone may still be one of the old rate */
#define XY3_RESYNC_PACKETS	2
/* Bytes received at the old rate may still be in flight for this long */
#define XY3_SETTLE_MS		20
/* Time limit for a command that is not sent, when the head is to be detached */
#define XY3_DRAIN_MS		50

/* ---- the rate ---- */

/**
 * xy3_rate_close() - check whether a UART's rate is close enough to the requested one
 * @rate: rate that the UART has, in bit/s
 * @requested: rate that was requested, in bit/s
 *
 * Return: true if they differ by 2.5 percent at most.
 */
bool xy3_rate_close(unsigned int rate, unsigned int requested)
{
	return abs((int)(rate - requested)) <= (int)requested / 40;
}

/**
 * xy3_back_rate_changed() - the UART has a new rate
 * @back: the backchannel
 * @rate: in bit/s
 *
 * May be called while the UART's settings are locked.
 */
void xy3_back_rate_changed(struct xy3_back *back, unsigned int rate)
{
	WRITE_ONCE(back->head->rate, rate);
	queue_work(system_dfl_wq, back->head->show_rate);
}

/**
 * xy3_sync_changed() - sync was found or lost
 * @head: the head; its lock is held
 */
void xy3_sync_changed(struct xy3_head *head)
{
	lockdep_assert_held(&head->lock);
	trace_xy3_sync(head->number, head->parser.in_sync, head->parser.dropped_bytes);
	head->events.sync = true;
	xy3_notify_schedule(head);
	if (!head->parser.in_sync)
		xy3_autobaud_start(head);
}

/* Data received so far prove nothing about the present rate */
static void xy3_forget_proof(struct xy3_autobaud *search)
{
	search->line_errors = 0;
	search->bytes = 0;
}

/* Data received from now on are another stream */
static void xy3_lose_sync(struct xy3_head *head)
{
	guard(mutex)(&head->lock);
	if (head->parser.in_sync) {
		xy3_parse_lost(&head->parser, 0);
		xy3_sync_changed(head);
	}
	head->packets_before = head->parser.packets;
	xy3_forget_proof(&head->autobaud);
}

/* Change the rate of the UART; on error it keeps its rate */
static int xy3_move_uart(struct xy3_head *head, struct xy3_back *back, unsigned int rate)
{
	int err;

	err = back->ops->set_rate(back, head->rate, rate);
	if (err)
		return err;
	xy3_back_rate_changed(back, rate);
	xy3_lose_sync(head);
	return 0;
}

/* Wait until the head has been sent all commands, or is to be detached */
static int xy3_wait_sent(struct xy3_head *head)
{
	const struct xy3_forward_ops *ops = head->forward->ops;
	int err;

	if (!ops->drain)
		return 0;
	do {
		err = ops->drain(head->forward, msecs_to_jiffies(XY3_DRAIN_MS));
	} while (err > 0 && !READ_ONCE(head->detaching));
	return err > 0 ? -ENODEV : err;
}

/* There is sync at the rate that the UART was set to last; read without a lock */
static bool xy3_rate_is_right(const struct xy3_head *head)
{
	return READ_ONCE(head->parser.in_sync) &&
	       READ_ONCE(head->parser.packets) - head->packets_before >= XY3_RESYNC_PACKETS;
}

/* Wait for sync at the new rate. Return true if there is. */
static bool xy3_wait_resync(struct xy3_head *head)
{
	/* sync left over from the old rate would prove nothing */
	msleep(XY3_SETTLE_MS);
	xy3_lose_sync(head);
	wait_event_timeout(head->resync, xy3_rate_is_right(head) || READ_ONCE(head->detaching),
			   msecs_to_jiffies(XY3_RESYNC_MS));
	return xy3_rate_is_right(head);
}

/* Set both ends, the head first; return to the old rate if there is no sync */
static int xy3_move_both(struct xy3_head *head, unsigned int rate)
{
	unsigned int old_rate = head->rate;
	int err;

	err = xy3_send_command(head, xy3_rate_command(rate));
	if (err)
		return err;
	/* until it is sent the head uses its old rate */
	err = xy3_wait_sent(head);
	if (!err)
		err = xy3_move_uart(head, head->back, rate);
	if (!err && xy3_wait_resync(head))
		return 0;

	/* the UART may have had a rate that heads do not support */
	if (xy3_is_rate(old_rate))
		xy3_send_command(head, xy3_rate_command(old_rate));
	if (err)
		return err;
	xy3_wait_sent(head);
	if (xy3_move_uart(head, head->back, old_rate))
		dev_warn(&head->dev, "the UART stays at %u bit/s\n", head->rate);
	return READ_ONCE(head->detaching) ? -ENODEV : -ETIMEDOUT;
}

/**
 * xy3_set_rate() - change the rate of the backchannel, at both ends
 * @head: the head
 * @rate: one of the five, in bit/s
 *
 * With a forward channel the head gets the command first, then the UART is set, and there must be
 * sync within XY3_RESYNC_MS. Without one the caller knows the rate of the head.
 *
 * Return: 0; -EINVAL for another rate or one that the UART does not support; -ETIMEDOUT if there
 * is no sync at the new rate; -ENODEV without a backchannel; or the error of the forward channel.
 * On error the UART is back at the old rate, unless it does not support that any more, and the head
 * was sent the command for it, if the forward channel accepts commands.
 */
int xy3_set_rate(struct xy3_head *head, unsigned int rate)
{
	if (!xy3_is_rate(rate))
		return -EINVAL;

	guard(mutex)(&head->rate_lock);
	if (!head->back)
		return -ENODEV;
	/* a head that has restarted may have another rate: send the command again then */
	if (head->rate == rate && (!head->forward || READ_ONCE(head->parser.in_sync)))
		return 0;

	if (head->forward)
		return xy3_move_both(head, rate);
	return xy3_move_uart(head, head->back, rate);
}

static void xy3_rate_request_work(struct work_struct *work)
{
	struct xy3_head *head = container_of(work, struct xy3_head, rate_request);
	unsigned int rate;

	scoped_guard(mutex, &head->lock)
		rate = head->requested_rate;
	xy3_set_rate(head, rate);
	/* in any case, as the settings of the tty are those requested */
	queue_work(system_dfl_wq, head->show_rate);
}

/**
 * xy3_request_rate() - schedule a change of the rate, as by xy3_set_rate()
 * @head: the head
 * @rate: in bit/s
 *
 * Does not wait. Of several requests the last one takes effect. show_rate of the head is queued
 * when the change has succeeded or failed.
 */
void xy3_request_rate(struct xy3_head *head, unsigned int rate)
{
	guard(mutex)(&head->lock);
	if (head->gone)
		return;
	head->requested_rate = rate;
	queue_work(system_dfl_wq, &head->rate_request);
}

/**
 * xy3_get_rate() - the rate in force
 * @head: the head
 *
 * Return: in bit/s; 0 without a backchannel.
 */
unsigned int xy3_get_rate(const struct xy3_head *head)
{
	return READ_ONCE(head->rate);
}

/* ---- the search for the rate ---- */

/* The next rate to try; a round starts with the initial rate */
static unsigned int xy3_next_rate(struct xy3_autobaud *search)
{
	if (!xy3_rate(++search->index))
		search->index = 0;
	if (search->moved && search->index == search->first)
		search->round++;
	search->moved = true;
	return xy3_rate(search->index);
}

static void xy3_autobaud_work(struct work_struct *work)
{
	struct xy3_head *head =
		container_of(to_delayed_work(work), struct xy3_head, autobaud.work);
	struct xy3_autobaud *search = &head->autobaud;
	unsigned int rate, ms;
	int err;

	/* before head->lock; a change of the rate in progress may find the head */
	guard(mutex)(&head->rate_lock);
	if (!head->back)
		return;
	scoped_guard(mutex, &head->lock) {
		if (!search->on || head->parser.in_sync || head->gone)
			return;
		rate = xy3_next_rate(search);
		ms = min(XY3_SEARCH_MS << min(search->round, 3U), XY3_SEARCH_MS_MAX);
	}

	/* without a command: the search is for the rate of the head */
	err = xy3_move_uart(head, head->back, rate);
	msleep(XY3_SETTLE_MS);

	guard(mutex)(&head->lock);
	xy3_forget_proof(search);
	search->refused = err;
	if (!head->gone)
		mod_delayed_work(system_percpu_wq, &search->work,
				 msecs_to_jiffies(err ? XY3_SEARCH_SKIP_MS : ms));
}

/**
 * xy3_rate_init() - prepare a new head
 * @head: the head
 */
void xy3_rate_init(struct xy3_head *head)
{
	init_waitqueue_head(&head->resync);
	INIT_WORK(&head->rate_request, xy3_rate_request_work);
	INIT_DELAYED_WORK(&head->autobaud.work, xy3_autobaud_work);
}

/**
 * xy3_autobaud_start() - start a search, if it is enabled and there is no sync
 * @head: the head; its lock is held
 *
 * The present rate is tried first.
 */
void xy3_autobaud_start(struct xy3_head *head)
{
	struct xy3_autobaud *search = &head->autobaud;
	unsigned int index = 0;

	lockdep_assert_held(&head->lock);
	if (!search->on || head->parser.in_sync || head->gone)
		return;
	while (xy3_rate(index) && xy3_rate(index) != xy3_get_rate(head))
		index++;
	search->index = index;
	/* past the last: none of the five rates, so it is not tried in the next round */
	search->first = xy3_rate(index) ? index : 0;
	search->round = 0;
	search->moved = false;
	search->refused = false;
	mod_delayed_work(system_percpu_wq, &search->work, msecs_to_jiffies(XY3_SEARCH_MS));
}

/* Out of sync at a rate that is being tried, which is proven to be wrong */
static bool xy3_rate_is_wrong(const struct xy3_head *head)
{
	const struct xy3_autobaud *search = &head->autobaud;

	return search->on && search->moved && !search->refused && !head->parser.in_sync &&
	       (search->line_errors >= XY3_SEARCH_ERRORS || search->bytes >= XY3_SEARCH_BYTES);
}

/**
 * xy3_rate_data() - evaluate new data, which may prove the present rate right or wrong
 * @head: the head; its lock is held
 */
void xy3_rate_data(struct xy3_head *head)
{
	lockdep_assert_held(&head->lock);
	wake_up_all(&head->resync);
	/* leave a wrong rate at once */
	if (xy3_rate_is_wrong(head) && !head->gone)
		mod_delayed_work(system_percpu_wq, &head->autobaud.work, 0);
}

/**
 * xy3_set_autobaud() - enable or disable the search
 * @head: the head
 * @on: search whenever sync is lost
 *
 * When it is disabled, the rate stays at the one being tried.
 */
void xy3_set_autobaud(struct xy3_head *head, bool on)
{
	guard(mutex)(&head->lock);
	if (head->autobaud.on == on)
		return;
	head->autobaud.on = on;
	xy3_autobaud_start(head);
}
