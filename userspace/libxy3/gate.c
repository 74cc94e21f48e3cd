// SPDX-License-Identifier: GPL-2.0-only
/*
 * libxy3: gate delays
 *
 * g(p) is the gate of input scan p. With delays of on and off scans the gate of output scan k is
 * high if a pulse of g has begun at k - on or before, and has not ended at k - off. If on <= off
 * that is any of g(k - off) ... g(k - on), else all of g(k - on) ... g(k - off). The ring holds the
 * number of scans that this requires.
 */

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include <linux/minmax.h>

#include "libxy3.h"

#define XY3_GATE_DELAY_MAX	1000000

/**
 * struct xy3_gate - state of a delayed gate
 * @columns: numbers per scan; the last is the gate
 * @on: delay of the rising edge in scans
 * @off: delay of the falling edge in scans
 * @ahead: input scans that are required ahead of an output scan
 * @size: size of the ring in scans
 * @ring: the last input scans
 * @count: number of input scans
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

/* Whether the gate of the output scan @place is high */
static bool xy3_gate_is_high(const struct xy3_gate *gate, int64_t place)
{
	bool any = gate->on <= gate->off;
	int64_t first = place - max(gate->on, gate->off), last = place - min(gate->on, gate->off);

	for (int64_t at = first; at <= last; at++) {
		bool asked = at >= 0 && xy3_gate_at(gate, at)[gate->columns - 1] == 1;

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
