/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XY3-100 forward channel: scans as a stream of bits over one to eight data lines
 *
 * A scan is one position frame for each axis, all at the same time, each on a line of its own
 * under one clock. A controller with several lines sends a byte's bits side by side: each clock
 * takes one bit of every line, the highest line's bit is the most significant one.
 *
 *   4 lines:   bit  7    6    5    4    3    2    1    0
 *                   IO3  IO2  IO1  IO0  IO3  IO2  IO1  IO0
 *                   first clock         second clock
 *
 * SYNC is either the chip select, which then goes up and down for each scan, or a line of its
 * own: low during a frame, high for the two clocks between frames, so that scans follow one
 * another in one unbroken stream. It begins with a gap as well: where a controller leaves its lines
 * meanwhile is its own affair, and SYNC must be seen to fall.
 *
 * A line that is left can carry a gate for the laser: high in all clocks of a scan that asks for
 * it, those of the gap behind it among them, so that it has no dips while scans ask for it one
 * after another. It is no interlock: a line keeps its last level when a controller hangs.
 *
 * Pure functions: nothing here allocates, sleeps or knows a device.
 */
#ifndef XY3_LINES_H
#define XY3_LINES_H

#include <linux/types.h>
#include <linux/xy3.h>

#define XY3_LINES_MAX		8
#define XY3_GAP_CLOCKS		2	/* between frames when SYNC is a line */

/* The longest scan: 32 bits and the gap on 8 lines */
#define XY3_SCAN_SIZE_MAX	((32 + XY3_GAP_CLOCKS) * XY3_LINES_MAX / 8)

/* Numbers of a scan at most: those of all axes, and the gate */
#define XY3_COLUMNS_MAX		(XY3_AXES + 1)

/**
 * enum xy3_signal - what a data line carries
 * @XY3_SIGNAL_X: frames of axis X
 * @XY3_SIGNAL_Y: of Y
 * @XY3_SIGNAL_Z: of Z
 * @XY3_SIGNAL_U: of U
 * @XY3_SIGNAL_W: of W
 * @XY3_SIGNAL_SYNC: SYNC
 * @XY3_SIGNAL_GATE: the laser's gate
 * @XY3_SIGNAL_NONE: nothing, always low
 */
enum xy3_signal {
	XY3_SIGNAL_X	= XY3_AXIS_X,
	XY3_SIGNAL_Y	= XY3_AXIS_Y,
	XY3_SIGNAL_Z	= XY3_AXIS_Z,
	XY3_SIGNAL_U	= XY3_AXIS_U,
	XY3_SIGNAL_W	= XY3_AXIS_W,
	XY3_SIGNAL_SYNC	= XY3_AXES,
	XY3_SIGNAL_GATE,
	XY3_SIGNAL_NONE
};

/**
 * struct xy3_line_map - which line carries what
 * @lines: 1, 2, 4 or 8
 * @frame_bits: 24 or 32
 * @signal: enum xy3_signal for each line
 * @axes: how many axes are on a line
 * @axis: which ones, by enum xy3_axis, in rising order; X is always there
 * @axis_line: the line of each of them
 * @sync_line: the line of SYNC, or -1 when it is the chip select
 * @gate_line: the line of the gate, or -1 without one
 * @columns: numbers of a scan: a code for each axis, and behind them 1 or 0 for the gate
 * @scan_size: bytes of one scan on the wire
 */
struct xy3_line_map {
	u8 lines;
	u8 frame_bits;
	u8 signal[XY3_LINES_MAX];
	u8 axes;
	u8 axis[XY3_AXES];
	u8 axis_line[XY3_AXES];
	s8 sync_line;
	s8 gate_line;
	u8 columns;
	u8 scan_size;
};

int xy3_line_map_init(struct xy3_line_map *map, unsigned int lines, unsigned int frame_bits,
		      const u8 *signal);
const u8 *xy3_default_signals(unsigned int lines, bool sync_is_line);

size_t xy3_gap_size(const struct xy3_line_map *map);
void xy3_encode_gap(const struct xy3_line_map *map, u8 *out);
void xy3_encode_scans(const struct xy3_line_map *map, const u32 *codes, size_t scans, u8 *out);
void xy3_lower_gate(const struct xy3_line_map *map, u8 *scan);
void xy3_lower_gate_behind(const struct xy3_line_map *map, u8 *scan);
u32 xy3_position_word(const struct xy3_line_map *map, u32 code);
u32 xy3_command_word(const struct xy3_line_map *map, u32 command);
void xy3_encode_command_scan(const struct xy3_line_map *map, u32 command, u8 *out);
u32 xy3_code_max(const struct xy3_line_map *map);

#endif /* XY3_LINES_H */
