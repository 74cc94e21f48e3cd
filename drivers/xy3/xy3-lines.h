/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XY3-100 forward channel: scans as a stream of bits over one to eight data lines
 *
 * A scan is one position frame for each axis, all sent simultaneously, each on a line of its own
 * with a common clock. A controller with several lines sends the bits of a byte in parallel: each
 * clock sends one bit on every line, the most significant one on the highest line.
 *
 *   4 lines:   bit  7    6    5    4    3    2    1    0
 *                   IO3  IO2  IO1  IO0  IO3  IO2  IO1  IO0
 *                   first clock         second clock
 *
 * SYNC is either the chip select, which then toggles for each scan, or a line of its own: low
 * during a frame, high for the two clocks between frames, so that scans follow one another
 * without a pause. The stream begins with a gap as well: the level of idle lines depends on the
 * controller, and the head must see SYNC fall.
 *
 * A spare line can carry a gate for the laser: high in all clocks of a scan that requests it,
 * including those of the gap after it, so that it has no dips between consecutive scans that
 * request it. It is not an interlock: a line keeps its last level when a controller hangs.
 *
 * A controller may have lanes, each a line with a shift register of its own, from Linux 7.2 on. A
 * scan is then a word for each lane, and SYNC is the chip select. A single line whose controller
 * toggles the chip select for each word is the same with one lane.
 *
 * Pure functions, without allocation, sleeping or a device.
 */
#ifndef XY3_LINES_H
#define XY3_LINES_H

#include <linux/types.h>
#include <linux/xy3.h>

#define XY3_LINES_MAX		8
#define XY3_GAP_CLOCKS		2	/* between frames when SYNC is a line */

/* The longest scan: 32 bits and the gap on 8 lines */
#define XY3_SCAN_SIZE_MAX	((32 + XY3_GAP_CLOCKS) * XY3_LINES_MAX / 8)

/* Maximum numbers of a scan: those of all axes, and the gate */
#define XY3_COLUMNS_MAX		(XY3_AXES + 1)

/**
 * enum xy3_signal - signal of a data line
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
 * struct xy3_line_map - signals of the data lines
 * @lines: 1, 2, 4 or 8; with @words 1 to XY3_LINES_MAX
 * @frame_bits: 24 or 32
 * @words: a scan is a number of @frame_bits for each line, in the byte order of the processor
 * @signal: enum xy3_signal for each line
 * @axes: number of axes that have a line
 * @axis: these axes, enum xy3_axis, in ascending order; X is always present
 * @axis_line: line of each of these axes
 * @sync_line: line of SYNC, or -1 if it is the chip select
 * @gate_line: line of the gate, or -1 without one
 * @columns: numbers of a scan: a code for each axis, and after them 1 or 0 for the gate
 * @scan_size: bytes of one scan
 */
struct xy3_line_map {
	u8 lines;
	u8 frame_bits;
	bool words;
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
int xy3_word_map_init(struct xy3_line_map *map, unsigned int lanes, unsigned int frame_bits,
		      const u8 *signal);

/* A line map of words or of lines, see there */
static inline int xy3_map_init(struct xy3_line_map *map, bool words, unsigned int lines,
			       unsigned int frame_bits, const u8 *signal)
{
	return words ? xy3_word_map_init(map, lines, frame_bits, signal) :
		       xy3_line_map_init(map, lines, frame_bits, signal);
}

const u8 *xy3_default_signals(unsigned int lines, bool sync_is_line);

size_t xy3_gap_size(const struct xy3_line_map *map);
void xy3_encode_gap(const struct xy3_line_map *map, u8 *out);
void xy3_encode_scans(const struct xy3_line_map *map, const u32 *codes, size_t scans, u8 *out);
void xy3_lower_gate(const struct xy3_line_map *map, u8 *scan);
void xy3_lower_gate_behind(const struct xy3_line_map *map, u8 *scan);
void xy3_encode_command_scan(const struct xy3_line_map *map, u32 command, u8 *out);
u32 xy3_code_max(const struct xy3_line_map *map);

#endif /* XY3_LINES_H */
