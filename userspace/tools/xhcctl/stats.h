/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * A pendant's counters, stats/
 */
#ifndef STATS_H
#define STATS_H

#include "pendant.h"

enum stat_index {
	REPORTS, BAD_REPORTS, XOR_MISMATCHES, UNKNOWN_KEYS, FRAMES_SENT, FRAME_ERRORS, STATS
};

extern const char *const stat_names[STATS];

/* Return 0 or a negative errno. */
int stats_read(const struct pendant *pendant, long long stat[STATS]);

#endif /* STATS_H */
