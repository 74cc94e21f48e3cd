// SPDX-License-Identifier: GPL-2.0-only
/*
 * libxy3: a gate that rises and falls earlier or later than its scans ask for
 *
 * A scan that was put in at place p asks for the gate when g(p) is 1. With delays of on and off
 * scans the gate is high at place k when a stretch of scans that ask for it has begun at k - on or
 * before, and has not ended at k - off. If on <= off that is any of g(k - off) ... g(k - on), else
 * all of g(k - on) ... g(k - off). The ring holds as many scans as that needs.
 */

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include <linux/minmax.h>

#include "libxy3.h"

#define XY3_GATE_DELAY_MAX	1000000

/**
 * struct xy3_gate - a gate that is shifted
 * @columns: numbers of a scan; the last is the gate
 * @on: scans from the one that asks for the gate to that in which it rises
 * @off: the same for its fall
 * @ahead: scans that have to be known before one comes out
 * @size: scans of the ring
 * @ring: the last scans that were put in
 * @count: how many were put in
 */
struct xy3_gate {
	unsigned int columns;
	int on;
	int off;
	unsigned int ahead;
	size_t size;
	uint32_t *ring;
	int64_t count;
};

int xy3_gate_new(struct xy3_gate **gate, unsigned int axes, int on_delay, int off_delay)
{
	int behind = max(max(on_delay, off_delay), 0), ahead = -min(min(on_delay, off_delay), 0);
	struct xy3_gate *g;

	if (!axes || axes > XY3_AXES || behind > XY3_GATE_DELAY_MAX || ahead > XY3_GATE_DELAY_MAX)
		return -EINVAL;
	g = calloc(1, sizeof(*g));
	if (!g)
		return -ENOMEM;
	g->columns = axes + 1;
	g->on = on_delay;
	g->off = off_delay;
	g->ahead = ahead;
	g->size = (size_t)behind + ahead + 1;
	g->ring = calloc(g->size, g->columns * sizeof(*g->ring));
	if (!g->ring) {
		free(g);
		return -ENOMEM;
	}
	*gate = g;
	return 0;
}

void xy3_gate_free(struct xy3_gate *gate)
{
	if (!gate)
		return;
	free(gate->ring);
	free(gate);
}

size_t xy3_gate_rest(const struct xy3_gate *gate)
{
	return gate->size - 1;
}

static uint32_t *xy3_gate_at(const struct xy3_gate *gate, int64_t place)
{
	return gate->ring + place % gate->size * gate->columns;
}

/* Whether the gate is high at a place of those that come out */
static bool xy3_gate_is_high(const struct xy3_gate *gate, int64_t place)
{
	bool any = gate->on <= gate->off;
	int64_t first = place - max(gate->on, gate->off), last = place - min(gate->on, gate->off);

	for (int64_t at = first; at <= last; at++) {
		bool asked = at >= 0 && xy3_gate_at(gate, at)[gate->columns - 1];

		if (asked == any)
			return any;
	}
	return !any;
}

void xy3_gate_next(struct xy3_gate *gate, const uint32_t *scan, uint32_t *out)
{
	size_t size = gate->columns * sizeof(*out);
	uint32_t *in = xy3_gate_at(gate, gate->count);
	int64_t place = gate->count - gate->ahead;

	if (scan) {
		memcpy(in, scan, size);
	} else {
		if (gate->count)
			memmove(in, xy3_gate_at(gate, gate->count - 1), size);
		in[gate->columns - 1] = 0;
	}
	gate->count++;
	memcpy(out, xy3_gate_at(gate, max_t(int64_t, place, 0)), size);
	out[gate->columns - 1] = xy3_gate_is_high(gate, place);
}
