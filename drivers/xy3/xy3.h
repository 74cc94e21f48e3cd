/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XY3-100 scanhead driver: internal interfaces
 *
 *   UART -> xy3-ldisc or xy3-serdev -> xy3-back -> xy3-packet -> xy3-tty       -> /dev/xy3-<n>
 *                                                             -> xy3-telemetry -> xy3-sysfs,
 *                                                                xy3-notify -> uevents, xy3-hwmon
 *   /dev/xy3-<n> -> xy3-tty, xy3-sysfs -> xy3-frame -> xy3-forward -> SPI
 *   xy3-back, xy3-tty, xy3-sysfs -> xy3-rate -> the UART, and commands to the head
 *
 * Only xy3-ldisc and xy3-serdev access UARTs. xy3-head joins the two channels.
 */
#ifndef XY3_H
#define XY3_H

#include <linux/device.h>
#include <linux/lockdep.h>
#include <linux/mutex.h>
#include <linux/spinlock.h>
#include <linux/wait.h>
#include <linux/workqueue.h>

#include "xy3-frame.h"
#include "xy3-packet.h"

struct fwnode_handle;
struct tty_driver;
struct xy3_back;
struct xy3_forward;
struct xy3_head;

#define XY3_HEADS_MAX	32

/* ---- channels ---- */

/**
 * struct xy3_back_ops - operations of a UART
 * @set_rate: change the UART from one rate to another, in bit/s; may sleep. -EINVAL if it does not
 *	      support that; then the rate is unchanged.
 */
struct xy3_back_ops {
	int (*set_rate)(struct xy3_back *back, unsigned int old_rate, unsigned int rate);
};

/**
 * struct xy3_back - a backchannel: one UART
 * @ops: its operations
 * @dev: its device, or NULL; its firmware node may refer to the forward channel of the same head
 * @rate: bit/s that it receives at when it is attached
 * @head: its head, between xy3_back_attach() and xy3_back_detach()
 * @partner: firmware node of the forward channel that it belongs to, or NULL
 */
struct xy3_back {
	const struct xy3_back_ops *ops;
	struct device *dev;
	unsigned int rate;
	struct xy3_head *head;
	struct fwnode_handle *partner;
};

int xy3_back_attach(struct xy3_back *back);
void xy3_back_detach(struct xy3_back *back);

/**
 * struct xy3_forward_ops - operations of a forward channel
 * @command: queue a command frame, 3 or 4 bytes long, to be sent after earlier ones; called in any
 *	     context, must not sleep. -EAGAIN if there is no room for it;
 *	     xy3_forward_has_room() is called when there is.
 * @room: number of frames that there is room for, at least 1 if sending one would fail; in any
 *	  context. NULL if there is always room
 * @drain: wait until all of them have been sent, for @timeout jiffies at most. 0, the error if the
 *	   last of them was not sent, or 1 after @timeout; may be NULL
 */
struct xy3_forward_ops {
	int (*command)(struct xy3_forward *forward, const u8 *frame, size_t size);
	unsigned int (*room)(struct xy3_forward *forward);
	int (*drain)(struct xy3_forward *forward, unsigned long timeout);
};

/**
 * struct xy3_forward - a forward channel: positions and commands to the head
 * @ops: its operations
 * @dev: its device; the firmware node of the backchannel may refer to its node
 * @head: its head, between xy3_forward_attach() and xy3_forward_detach()
 */
struct xy3_forward {
	const struct xy3_forward_ops *ops;
	struct device *dev;
	struct xy3_head *head;
};

int xy3_forward_attach(struct xy3_forward *forward);
void xy3_forward_detach(struct xy3_forward *forward);
void xy3_forward_has_room(struct xy3_forward *forward);
u32 xy3_forward_unpack(const u8 *frame, size_t size);

/* ---- the head ---- */

/**
 * enum xy3_text - identity of a head, as it reports it
 * @XY3_VENDOR: vendor
 * @XY3_MODEL: model
 * @XY3_FIRMWARE: version of its firmware
 * @XY3_SERIAL: its serial number
 * @XY3_TEXTS: number of texts
 */
enum xy3_text {
	XY3_VENDOR,
	XY3_MODEL,
	XY3_FIRMWARE,
	XY3_SERIAL,
	XY3_TEXTS
};

/**
 * struct xy3_telemetry - latest reports of a head
 * @text: by enum xy3_text; empty until reported
 * @temperatures: components in the newest temperature packet
 * @temperature: by enum xy3_component, in 1/100 degree Celsius, or XY3_TEMPERATURE_NONE
 * @errors: components in the newest error state packet
 * @error: by enum xy3_component: enum xy3_error, which the head has reported last; the component
 *	   need not be in the newest packet
 * @hour_counts: components in the newest hours packet
 * @hours: by enum xy3_component, or XY3_HOURS_NONE
 * @frame_error_counts: axes in the newest frame error packet: all or none
 * @frame_errors: by enum xy3_axis
 */
struct xy3_telemetry {
	char text[XY3_TEXTS][XY3_TEXT_MAX + 1];
	unsigned int temperatures;
	s16 temperature[XY3_COMPONENTS];
	unsigned int errors;
	u8 error[XY3_COMPONENTS];
	unsigned int hour_counts;
	u32 hours[XY3_COMPONENTS];
	unsigned int frame_error_counts;
	u32 frame_errors[XY3_AXES];
};

/**
 * struct xy3_events - changes for which user space is still to be notified
 * @errors: components whose error has changed, by bit
 * @sync: in_sync has changed
 * @identity: a text has changed
 * @thermometers: components that have reported a temperature, by bit
 * @next: earliest time of the next notification, in jiffies
 * @work: notifies user space
 */
struct xy3_events {
	u32 errors;
	bool sync;
	bool identity;
	u32 thermometers;
	u64 next;
	struct delayed_work work;
};

/**
 * struct xy3_autobaud - the search for a head's rate
 * @on: search whenever sync is lost
 * @moved: the rate of the UART was changed since sync was lost
 * @refused: the UART does not support the rate being tried
 * @index: of the rate being tried, for xy3_rate()
 * @first: index of the first rate of a round
 * @round: number of times that all rates have been tried
 * @line_errors: line errors since the last change of the rate
 * @bytes: bytes since the last change of the rate
 * @work: switches to the next rate
 */
struct xy3_autobaud {
	bool on;
	bool moved;
	bool refused;
	unsigned int index;
	unsigned int first;
	unsigned int round;
	unsigned int line_errors;
	size_t bytes;
	struct delayed_work work;
};

/**
 * struct xy3_head - a scanhead
 * @dev: its device, of class xy3
 * @number: n of xy3-<n>
 * @node: in the list of heads, under the lock of xy3-head.c
 *
 * @rate_lock: held while the rate is changed, and while @back or @forward is set. Taken before
 *	the other two locks, and never where the settings of a tty are locked
 * @back: its backchannel, or NULL
 * @rate: bit/s that @back receives at, 0 without one; read without a lock
 * @detaching: a channel is to be detached, which requires @rate_lock: do not wait for the head
 * @resync: wait queue of a change of the rate, for sync or for @detaching
 *
 * @forward_lock: protects @forward
 * @forward: its forward channel, or NULL
 *
 * @lock: protects all that follows up to @lost_packets; taken for each piece of data received,
 *	never held while the rate of the UART is changed or a device is registered
 * @gone: being removed: no more work is queued
 * @parser: parser of the stream
 * @order: byte order of numbers
 * @telemetry: what was reported
 * @events: what has changed
 * @autobaud: the search for the rate
 * @syncs: sync packets
 * @packets_before: packets of the parser at the last change of the rate
 * @requested_rate: bit/s that @rate_request is to change to
 * @line_errors: bytes that the UART has flagged
 * @lost_packets: packets that found no room in the tty
 *
 * @rate_request: changes the rate for a program that has set the tty's speed
 * @tty: the device of its tty
 * @show_rate: queued when the rate has changed; belongs to the tty, and outlives the head
 * @hwmon: worker of @events only, and its last user: the hwmon device, or NULL
 * @hwmon_thermometers: likewise: components that @hwmon shows, by bit
 */
struct xy3_head {
	struct device dev;
	unsigned int number;
	struct list_head node;

	struct mutex rate_lock;		/* protects @back; serialises changes of the rate */
	struct xy3_back *back;
	unsigned int rate;
	bool detaching;
	wait_queue_head_t resync;

	spinlock_t forward_lock;	/* protects @forward */
	struct xy3_forward *forward;

	struct mutex lock;		/* protects @gone to @lost_packets */
	bool gone;
	struct xy3_parser parser;
	enum xy3_byte_order order;
	struct xy3_telemetry telemetry;
	struct xy3_events events;
	struct xy3_autobaud autobaud;
	u64 syncs;
	u64 packets_before;
	unsigned int requested_rate;
	u64 line_errors;
	u64 lost_packets;

	struct work_struct rate_request;
	struct device *tty;
	struct work_struct *show_rate;
	struct device *hwmon;
	u32 hwmon_thermometers;
};

static inline struct xy3_head *to_xy3_head(struct device *dev)
{
	return container_of(dev, struct xy3_head, dev);
}

/**
 * xy3_telemetry() - what a head has reported
 * @head: the head; its lock is held
 *
 * Return: the latest values.
 */
static inline const struct xy3_telemetry *xy3_telemetry(const struct xy3_head *head)
{
	lockdep_assert_held(&head->lock);
	return &head->telemetry;
}

/* xy3-head.c */
int xy3_head_init(void);
void xy3_head_exit(void);
int xy3_choice_show(char *buf);
int xy3_choice_store(const char *buf);

/* xy3-back.c */
void xy3_back_receive(struct xy3_back *back, const u8 *data, const u8 *flags, size_t size);

/* xy3-rate.c */
void xy3_back_rate_changed(struct xy3_back *back, unsigned int rate);
void xy3_sync_changed(struct xy3_head *head);
int xy3_set_rate(struct xy3_head *head, unsigned int rate);
void xy3_request_rate(struct xy3_head *head, unsigned int rate);
unsigned int xy3_get_rate(const struct xy3_head *head);
void xy3_set_autobaud(struct xy3_head *head, bool on);
void xy3_rate_init(struct xy3_head *head);
void xy3_autobaud_start(struct xy3_head *head);
void xy3_rate_data(struct xy3_head *head);
bool xy3_rate_close(unsigned int rate, unsigned int requested);

/* xy3-forward.c */
size_t xy3_whole_frames(const u8 *frames, size_t size);
ssize_t xy3_send_frames(struct xy3_head *head, const u8 *frames, size_t size);
unsigned int xy3_forward_room(struct xy3_head *head);
int xy3_send_command(struct xy3_head *head, u32 command);

/* xy3-telemetry.c */
void xy3_telemetry_packet(struct xy3_head *head, const struct xy3_packet *packet);
void xy3_telemetry_forget(struct xy3_head *head);
void xy3_telemetry_forget_numbers(struct xy3_head *head);

/* xy3-notify.c */
void xy3_notify_init(struct xy3_head *head);
void xy3_notify_schedule(struct xy3_head *head);
void xy3_notify_removal(struct xy3_head *head);

/* xy3-hwmon.c */
void xy3_hwmon_update(struct xy3_head *head, u32 thermometers);
void xy3_hwmon_remove(struct xy3_head *head);

/* xy3-sysfs.c */
extern const struct attribute_group *xy3_head_groups[];
extern const struct attribute_group *xy3_class_groups[];
void xy3_sysfs_init(void);

/* xy3-tty.c */
int xy3_tty_init(void);
void xy3_tty_exit(void);
void xy3_tty_wait_hung(void);
bool xy3_tty_is_free(unsigned int number);
int xy3_tty_add(struct xy3_head *head);
void xy3_tty_remove(struct xy3_head *head);
void xy3_tty_wakeup(struct xy3_head *head);
bool xy3_tty_is_ours(const struct tty_driver *driver);
bool xy3_tty_put(struct xy3_head *head, const u8 *packet, size_t size);

/* xy3-ldisc.c, xy3-serdev.c */
int xy3_ldisc_init(void);
void xy3_ldisc_exit(void);
int xy3_serdev_init(void);
void xy3_serdev_exit(void);

#endif /* XY3_H */
