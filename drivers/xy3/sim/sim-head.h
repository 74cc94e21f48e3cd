/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Virtual XY3-100 compatible scanhead: the receiver, and its record
 */
#ifndef XY3_SIM_HEAD_H
#define XY3_SIM_HEAD_H

#include <linux/limits.h>
#include <linux/types.h>

#include "sim-config.h"

#define XY3_SIM_RATE_DEFAULT	115200	/* of the backchannel in bit/s */
#define XY3_SIM_CLOCKS_MAX	32	/* stored clocks of a frame */
#define XY3_SIM_GAP_CLOCKS	2	/* minimum clocks of SYNC between frames if it is a line */
#define XY3_SIM_COMMANDS	16	/* commands in the log */
#define XY3_SIM_RECORD_MAX	(4 * 1024 * 1024)
#define XY3_SIM_NO_CODE		U32_MAX	/* in a record: the axis had no good position */

struct xy3_sim;

/**
 * struct xy3_sim_axis - one axis of the head
 * @line: its data line, or -1
 * @bits: of the last position, 0 before the first one
 * @code: the last position
 * @frames: good frames, positions and commands
 * @parity_errors: frames whose count of ones is wrong
 * @length_errors: frames whose number of clocks does not match their first bit
 * @mode_errors: frames in another SPI mode than 1
 * @idle: frames in which the line was low all the time
 */
struct xy3_sim_axis {
	s8 line;
	u8 bits;
	u32 code;
	u64 frames;
	u64 parity_errors;
	u64 length_errors;
	u64 mode_errors;
	u64 idle;
};

/**
 * struct xy3_sim_command - a command that was received
 * @scan: number of scans received before
 * @code: its 20 bits
 */
struct xy3_sim_command {
	u64 scan;
	u32 code;
};

/**
 * struct xy3_sim_head - the receiver
 * @lines: data lines that it is wired to
 * @signal: the signal of each
 * @sync: the line of SYNC, -1 if it is the chip select
 * @gate: the line of the gate of the laser, or -1
 * @gate_high: its level in the last clock
 * @gate_scans: scans in which it was high in all clocks
 * @gate_torn: frames in which it was high in only some of the clocks
 * @gate_commands: commands in which it was high
 * @axis: the axes
 * @inside: SYNC is low: a frame is being received
 * @stalled: SYNC has fallen while there was no clock: the head does not wait for this frame
 * @wrong_mode: data change at the edge of CLK at which the head samples them
 * @clocks: of the frame so far
 * @gap: clocks since the last one, if SYNC is a line
 * @symbol: the levels of the lines in each clock of the frame
 * @scans: frames with a good position on at least one axis
 * @short_gaps: frames that began too soon after the one before
 * @stalled_frames: frames that are lost as SYNC fell while there was no clock
 * @stray_clocks: clocks outside of a frame, with the chip select not active
 * @commands: received in good frames on X
 * @unknown_commands: number of unknown ones among them
 * @log: the last of them, at their number modulo the size
 * @rate: of the backchannel in bit/s
 * @autocalib: axes with automatic calibration
 * @temp_comp: axes with temperature compensation
 * @calibrated: axes that have been calibrated
 * @referenced: axes that have made a reference run
 */
struct xy3_sim_head {
	unsigned int lines;
	u8 signal[XY3_SIM_LINES_MAX];
	s8 sync;
	s8 gate;
	bool gate_high;
	u64 gate_scans;
	u64 gate_torn;
	u64 gate_commands;
	struct xy3_sim_axis axis[XY3_SIM_AXES];
	bool inside;
	bool stalled;
	bool wrong_mode;
	u32 clocks;
	u32 gap;
	u8 symbol[XY3_SIM_CLOCKS_MAX];
	u64 scans;
	u64 short_gaps;
	u64 stalled_frames;
	u64 stray_clocks;
	u64 commands;
	u64 unknown_commands;
	struct xy3_sim_command log[XY3_SIM_COMMANDS];
	unsigned int rate;
	u32 autocalib;
	u32 temp_comp;
	u32 calibrated;
	u32 referenced;
};

/**
 * struct xy3_sim_record - recorded scans
 * @codes: for each scan the codes of the axes that are on a line, and 1 or 0 for a gate
 * @axes: number of codes per scan
 * @room: maximum number of scans
 * @count: scans recorded so far
 * @changes: do not record a scan that is the same as the one before
 */
struct xy3_sim_record {
	u32 *codes;
	unsigned int axes;
	u32 room;
	u32 count;
	bool changes;
};

/* sim-head.c */
void xy3_sim_head_wire(struct xy3_sim *sim, unsigned int lines, const u8 *signal);
void xy3_sim_head_select(struct xy3_sim *sim, bool active);
void xy3_sim_head_idle(struct xy3_sim *sim, u8 levels);
void xy3_sim_head_bytes(struct xy3_sim *sim, const u8 *data, size_t size, unsigned int nbits);
void xy3_sim_head_word(struct xy3_sim *sim, u32 word, unsigned int bits, unsigned int nbits);
void xy3_sim_head_lanes(struct xy3_sim *sim, const u32 *words, unsigned int lanes,
			unsigned int bits);
const char *xy3_sim_command_name(u32 code, bool *axes);
u64 xy3_sim_bad_frames(const struct xy3_sim_axis *axis);

/* sim-record.c */
int xy3_sim_record_start(struct xy3_sim *sim, u32 scans, bool changes);
void xy3_sim_record_scan(struct xy3_sim *sim, const u32 *codes, bool gate);
void xy3_sim_record_debugfs(struct xy3_sim *sim);

#endif /* XY3_SIM_HEAD_H */
