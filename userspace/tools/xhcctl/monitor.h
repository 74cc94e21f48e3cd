/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * xhcctl monitor: common declarations of its files
 */
#ifndef MONITOR_H
#define MONITOR_H

#include "events.h"
#include "fields.h"
#include "layout.h"
#include "model.h"
#include "stats.h"

struct monitor {
	struct pendant pendant;
	struct layout layout;
	struct events events;
	struct values values;	/* of the display */
	long long stat[STATS];
	int awake_fd;
	bool awake;
	/* Report an event immediately. Return an enum cli_status. */
	int (*tell)(const struct monitor *monitor, const struct event *event);
	/* Called periodically, and after events. NULL: nothing to do. */
	void (*look)(struct monitor *monitor);
};

/* An event as a line of text, without newline */
void event_line(FILE *stream, const struct monitor *monitor, const struct event *event);

/* Lines and JSON, for tell */
int tell_line(const struct monitor *monitor, const struct event *event);
int tell_json(const struct monitor *monitor, const struct event *event);

/* The picture on a terminal, for tell and look */
void screen_begin(void);
void screen_end(void);
int screen_tell(const struct monitor *monitor, const struct event *event);
void screen_look(struct monitor *monitor);

#endif /* MONITOR_H */
