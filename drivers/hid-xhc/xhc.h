/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XHC pendant driver: internal interfaces
 *
 *   HID bus -> xhc-core -> xhc-codec -> xhc-input -> evdev
 *   HID bus <- xhc-core <- xhc-codec <- xhc-dro <- xhc-sysfs <- sysfs
 *
 * Only xhc-core calls the HID core.
 */
#ifndef XHC_H
#define XHC_H

#include <linux/atomic.h>
#include <linux/hrtimer.h>
#include <linux/input.h>
#include <linux/ktime.h>
#include <linux/list.h>
#include <linux/mutex.h>
#include <linux/notifier.h>
#include <linux/spinlock.h>
#include <linux/timer.h>
#include <linux/workqueue.h>

#include "xhc-codec.h"

struct hid_device;
struct kernfs_node;

/**
 * enum xhc_stat - the counters of stats/
 * @XHC_REPORTS: input reports received, good and bad
 * @XHC_BAD_REPORTS: reports of another size or id, which are dropped
 * @XHC_XOR_MISMATCHES: the last byte was not made with the day or seed last sent
 * @XHC_UNKNOWN_KEYS: key or selector codes unknown for the model, counted once when they appear
 * @XHC_FRAMES_SENT: display frames that the pendant has accepted
 * @XHC_FRAME_ERRORS: display frames that have failed, or were sent in part
 * @XHC_STATS: number of counters
 */
enum xhc_stat {
	XHC_REPORTS,
	XHC_BAD_REPORTS,
	XHC_XOR_MISMATCHES,
	XHC_UNKNOWN_KEYS,
	XHC_FRAMES_SENT,
	XHC_FRAME_ERRORS,
	XHC_STATS
};

/*
 * Scan codes of the keymap: 01h..17h are the pendant's keys. The one-hot buttons of the
 * selector have 20h + enum xhc_selector, so that they can be remapped as well.
 */
#define XHC_SCAN_SELECTOR	0x20
#define XHC_SCAN_COUNT		(XHC_SCAN_SELECTOR + XHC_SEL_COUNT)

/**
 * struct xhc_evdev - the evdev side of a pendant
 * @dev: the input device
 * @lock: protects all but @keymap, and keeps the events of one report together
 * @running: false while suspended or going away: reports are not turned into events
 * @trailing: the next report follows that of sleep and has no meaning
 * @streams: reports have been seen to stream while an axis is chosen
 * @silence: releases all keys when they stop
 * @awake: the last report was not the sleep report
 * @awake_node: the attribute that shows @awake, NULL while there is none
 * @last: state reported last
 * @keycode: key codes that the keys of @last were pressed with, KEY_RESERVED for none
 * @selector_keycode: key code that the selector of @last holds down, KEY_RESERVED for none
 * @keymap: key code by scan code, changed by the input core under its own lock
 */
struct xhc_evdev {
	struct input_dev *dev;
	spinlock_t lock;	/* all but @keymap, and the order of events */
	bool running;
	bool trailing;
	bool streams;
	struct timer_list silence;
	bool awake;
	struct kernfs_node *awake_node;
	struct xhc_input_state last;
	u16 keycode[XHC_KEY_SLOTS];
	u16 selector_keycode;
	u16 keymap[XHC_SCAN_COUNT];
};

#define XHC_REFRESH_MIN_MS	10
#define XHC_REFRESH_MAX_MS	1000
#define XHC_REFRESH_DEFAULT_MS	50

struct xhc_device;

/**
 * struct xhc_dro - the display side of a pendant
 * @send: sends report 06h with its id, in memory fit for DMA, and waits until the pendant has
 *	  accepted it
 * @lock: protects all up to @flushes; never held while a frame is in flight
 * @running: false while suspended or going away: no frame is sent
 * @changed: @want may differ from what was sent
 * @want: values requested by users; day 0 stands for the present one
 * @refresh_ms: minimum time between frames
 * @next: when the next frame is due
 * @flushes: struct xhc_flush of the callers that wait for the next frame
 * @work: the only sender of frames
 * @midnight: queues it when the day changes
 * @report: the worker's buffer for a feature report, fit for DMA
 * @shown: worker only: payload of the last frame that the pendant has accepted
 * @shown_size: worker only: bytes in @shown; 0 if the contents of the LCD are unknown
 * @failing: worker only: the last frame has failed, and that was logged
 * @sending: a frame is in flight, read without a lock
 * @lost: the contents of the LCD are unknown, set without a lock and cleared by the worker
 * @seed: of the last frame that the pendant has accepted, read without a lock; 0 before the first
 * @seed_on_its_way: of the last frame that was started, read likewise; the same as @seed unless
 *		     that frame is still in flight or has failed
 * @returned: reports only: the seed that the last report returned, -1 before the first
 * @returns_seed: reports only: a report has returned the seed that the pendant was sent
 * @answered: reports only: when a report last returned the right seed, or caused a frame
 */
struct xhc_dro {
	int (*send)(struct xhc_device *xhc, u8 *report);
	struct mutex lock;	/* all up to @flushes */
	bool running;
	bool changed;
	struct xhc_display want;
	unsigned int refresh_ms;
	ktime_t next;
	struct list_head flushes;

	struct delayed_work work;
	struct hrtimer midnight;
	u8 *report;
	u8 shown[XHC_PAYLOAD_MAX];
	size_t shown_size;
	bool failing;
	bool sending;
	bool lost;
	u8 seed;
	u8 seed_on_its_way;

	int returned;
	bool returns_seed;
	ktime_t answered;
};

/**
 * struct xhc_device - a pendant
 * @hdev: its HID device
 * @model: what kind of pendant it is
 * @swap_feed_spindle: the unit has these two positions of the selector swapped
 * @evdev: keys, selector and wheel
 * @dro: the display
 * @pm_nb: called for a system suspend before any device is
 * @stat: counters, by enum xhc_stat
 */
struct xhc_device {
	struct hid_device *hdev;
	const struct xhc_model *model;
	bool swap_feed_spindle;
	struct xhc_evdev evdev;
	struct xhc_dro dro;
	struct notifier_block pm_nb;
	atomic64_t stat[XHC_STATS];
};

static inline void xhc_count(struct xhc_device *xhc, enum xhc_stat stat)
{
	atomic64_inc(&xhc->stat[stat]);
}

/* xhc-input.c */
int xhc_input_init(struct xhc_device *xhc);
int xhc_input_register(struct xhc_device *xhc);
struct xhc_evdev *xhc_evdev(struct xhc_device *xhc);
bool xhc_input_trailing(struct xhc_device *xhc, const struct xhc_input_state *in);
bool xhc_input_emit(struct xhc_device *xhc, const struct xhc_input_state *in);
void xhc_input_start(struct xhc_device *xhc);
void xhc_input_stop(struct xhc_device *xhc);

/* xhc-dro.c */
int xhc_dro_init(struct xhc_device *xhc, int (*send)(struct xhc_device *xhc, u8 *report));
void xhc_dro_start(struct xhc_device *xhc);
void xhc_dro_stop(struct xhc_device *xhc);
struct xhc_display *xhc_dro_want(struct xhc_device *xhc);
void xhc_dro_changed(struct xhc_device *xhc);
int xhc_dro_flush(struct xhc_device *xhc);
bool xhc_dro_report(struct xhc_device *xhc, const u8 *data, u8 day);
void xhc_dro_lost(struct xhc_device *xhc);

/* xhc-sysfs.c */
int xhc_sysfs_add(struct xhc_device *xhc);
void xhc_sysfs_remove(struct xhc_device *xhc);

#endif /* XHC_H */
