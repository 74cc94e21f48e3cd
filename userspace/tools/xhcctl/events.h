/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * What is done with a pendant, out of its event node: keys by scan code, selector, wheel
 */
#ifndef EVENTS_H
#define EVENTS_H

#include <stdbool.h>
#include <sys/time.h>

#include "layout.h"

struct libevdev;

enum event_kind {
	EVENT_START,	/* what was so before anything happened */
	EVENT_KEY,
	EVENT_UNKNOWN,	/* a scan code that no pendant has */
	EVENT_SELECTOR,
	EVENT_ROTARY,	/* the second one */
	EVENT_WHEEL,
	EVENT_LOST,	/* the kernel has dropped events; what they changed follows */
	EVENT_AWAKE,
	EVENT_DISPLAY,
	EVENT_GONE,
};

struct event {
	enum event_kind kind;
	struct timeval time;
	unsigned int scan;	/* of a key */
	unsigned int code;	/* its key code, as it is mapped now */
	int value;		/* down, position, detents, awake */
	bool fn;		/* the key was pressed while Fn was down */
};

struct events {
	struct libevdev *device;
	int fd;
	bool syncing;
	unsigned int scan;	/* MSC_SCAN of the key that comes next */
	unsigned int held[LAYOUT_KEYS + 1];	/* key code by scan code while it is down */
	bool with_fn[LAYOUT_KEYS + 1];		/* it was pressed while Fn was down */
	unsigned int fn_scan;			/* of the key Fn, 0: there is none; by the caller */
	unsigned int selector, rotary;
};

/* Return 0 or a negative errno. */
int events_open(struct events *events, const char *node);
void events_close(struct events *events);

/* Return 1: there is an event; 0: no more for now; a negative errno: -ENODEV, it has gone. */
int events_next(struct events *events, struct event *event);

/*
 * A pendant that has gone releases everything: the kernel reports it, but not to a late reader.
 * Return 1 as long as there is an event to make up.
 */
int events_release(struct events *events, struct event *event);

#endif /* EVENTS_H */
