// SPDX-License-Identifier: GPL-2.0-only
/*
 * Events of a pendant. See events.h.
 */
#include <errno.h>
#include <fcntl.h>
#include <libevdev/libevdev.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "events.h"
#include "model.h"

/* The key code that a scan code is mapped to, 0 for none. It may be remapped at any time. */
static unsigned int mapped(const struct events *events, unsigned int scan)
{
	struct input_keymap_entry entry = { .len = sizeof(scan) };

	memcpy(entry.scancode, &scan, sizeof(scan));
	return ioctl(events->fd, EVIOCGKEYCODE_V2, &entry) ? 0 : entry.keycode;
}

static bool is_selector(const struct events *events, unsigned int code)
{
	for (unsigned int i = 1; i <= LAYOUT_POSITIONS; i++) {
		if (mapped(events, LAYOUT_SELECTOR + i) == code)
			return true;
	}
	return false;
}

/* The key of an event without a scan code, after events were dropped. 0: none. */
static unsigned int find_scan(const struct events *events, unsigned int code, bool down)
{
	for (unsigned int scan = 1; scan <= LAYOUT_KEYS; scan++) {
		if (down ? mapped(events, scan) == code : events->held[scan] == code)
			return scan;
	}
	return 0;
}

int events_open(struct events *events, const char *node)
{
	int err;

	*events = (struct events){
		.fd = open(node, O_RDONLY | O_NONBLOCK | O_CLOEXEC),
		.fn_scan = events->fn_scan,
	};
	if (events->fd < 0)
		return -errno;
	err = libevdev_new_from_fd(events->fd, &events->device);
	if (err) {
		close(events->fd);
		return err;
	}
	/* libevdev keeps to itself what the device could not do as it was opened: a new mapping */
	for (unsigned int code = 1; code < KEY_MAX; code++)
		libevdev_enable_event_code(events->device, EV_KEY, code, NULL);
	events->selector = libevdev_get_event_value(events->device, EV_ABS, ABS_MISC);
	events->rotary = libevdev_get_event_value(events->device, EV_ABS, ABS_THROTTLE);
	for (unsigned int scan = 1; scan <= LAYOUT_KEYS; scan++) {
		unsigned int code = mapped(events, scan);

		if (code && libevdev_get_event_value(events->device, EV_KEY, code))
			events->held[scan] = code;
	}
	return 0;
}

void events_close(struct events *events)
{
	libevdev_free(events->device);
	close(events->fd);
}

static int take_scan(struct events *events, struct event *event, unsigned int scan)
{
	events->scan = scan;
	event->kind = EVENT_UNKNOWN;
	event->scan = scan;
	return scan > LAYOUT_KEYS;
}

static int take_key(struct events *events, struct event *event, const struct input_event *raw)
{
	unsigned int scan = events->scan;

	events->scan = 0;
	if (raw->value > 1)
		return 0;
	if (!scan || scan > LAYOUT_KEYS)
		scan = is_selector(events, raw->code) ? 0 :
		       find_scan(events, raw->code, raw->value);
	if (!scan)
		return 0;
	events->held[scan] = raw->value ? raw->code : 0;
	if (raw->value)
		events->with_fn[scan] = scan != events->fn_scan && events->held[events->fn_scan];
	event->kind = EVENT_KEY;
	event->scan = scan;
	event->code = raw->code;
	event->fn = events->with_fn[scan];
	event->value = raw->value;
	return 1;
}

static int take_position(struct events *events, struct event *event,
			 const struct input_event *raw)
{
	switch (raw->code) {
	case ABS_MISC:
		events->selector = raw->value;
		event->kind = EVENT_SELECTOR;
		return 1;
	case ABS_THROTTLE:
		events->rotary = raw->value;
		event->kind = EVENT_ROTARY;
		return 1;
	}
	return 0;
}

static int take(struct events *events, struct event *event, const struct input_event *raw)
{
	*event = (struct event){
		.time = { .tv_sec = raw->input_event_sec, .tv_usec = raw->input_event_usec },
		.value = raw->value,
	};
	switch (raw->type) {
	case EV_MSC:
		return raw->code == MSC_SCAN ? take_scan(events, event, raw->value) : 0;
	case EV_KEY:
		return take_key(events, event, raw);
	case EV_ABS:
		return take_position(events, event, raw);
	case EV_REL:
		event->kind = EVENT_WHEEL;
		return raw->code == REL_DIAL;
	case EV_SYN:
		events->scan = 0;
		event->kind = EVENT_LOST;
		return raw->code == SYN_DROPPED;
	}
	return 0;
}

int events_next(struct events *events, struct event *event)
{
	for (;;) {
		struct input_event raw;
		int result;

		result = libevdev_next_event(events->device, events->syncing ?
					     LIBEVDEV_READ_FLAG_SYNC : LIBEVDEV_READ_FLAG_NORMAL,
					     &raw);
		if (result == -EAGAIN && !events->syncing)
			return 0;
		if (result == -EAGAIN) {
			events->syncing = false;
			continue;
		}
		if (result < 0 && result != -EINTR)
			return result;
		if (result == -EINTR)
			return 0;
		if (result == LIBEVDEV_READ_STATUS_SYNC)
			events->syncing = true;
		if (take(events, event, &raw))
			return 1;
	}
}

int events_release(struct events *events, struct event *event)
{
	*event = (struct event){ .kind = EVENT_KEY };
	gettimeofday(&event->time, NULL);
	for (unsigned int scan = 1; scan <= LAYOUT_KEYS; scan++) {
		if (!events->held[scan])
			continue;
		event->scan = scan;
		event->code = events->held[scan];
		event->fn = events->with_fn[scan];
		events->held[scan] = 0;
		return 1;
	}
	if (events->selector) {
		events->selector = 0;
		event->kind = EVENT_SELECTOR;
		return 1;
	}
	if (!events->rotary)
		return 0;
	events->rotary = 0;
	event->kind = EVENT_ROTARY;
	return 1;
}
