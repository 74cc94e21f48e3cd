// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: the receiver of its forward channel
 *
 * It gets the levels of all data lines clock by clock, and decodes them like a head: a frame lasts
 * as long as SYNC is low, each axis has one on its line, the first bit determines its length.
 *
 *   24 clocks   0 P D19..D0 p1 p0
 *   32 clocks   1 P D25..D0 p3 p2 p1 p0
 *
 * P is 1 for a position, 0 for a command, which is in D19..D0; p is the number of ones in D.
 */

#include <linux/bitops.h>
#include <linux/bits.h>
#include <linux/minmax.h>
#include <linux/string.h>
#include <linux/unaligned.h>

#include "sim.h"

#define SIM_SHORT_CLOCKS	24
#define SIM_LONG_CLOCKS		32

/* A command without axes is for all axes */
#define SIM_ALL_AXES		GENMASK(XY3_SIM_AXES - 1, 0)

/**
 * enum sim_verdict - result of decoding a frame
 * @SIM_IDLE: the line was low all the time
 * @SIM_POSITION: a position
 * @SIM_COMMAND: a command
 * @SIM_BAD_LENGTH: the number of clocks does not match the first bit
 * @SIM_BAD_PARITY: the number of ones does not match the last bits
 */
enum sim_verdict {
	SIM_IDLE,
	SIM_POSITION,
	SIM_COMMAND,
	SIM_BAD_LENGTH,
	SIM_BAD_PARITY
};

/* ---- commands ---- */

/**
 * enum sim_action - the action of a command
 * @SIM_AUTOCALIB: automatic calibration
 * @SIM_TEMP_COMP: temperature compensation
 * @SIM_CALIBRATE: calibrate once
 * @SIM_REFERENCE: reference run
 * @SIM_RATE: another rate of the backchannel
 */
enum sim_action {
	SIM_AUTOCALIB,
	SIM_TEMP_COMP,
	SIM_CALIBRATE,
	SIM_REFERENCE,
	SIM_RATE
};

static const struct sim_command {
	u32 code;
	const char *name;
	enum sim_action action;
	unsigned int value;
} sim_commands[] = {
	{ 0x80000, "autocalib on", SIM_AUTOCALIB, 1 },
	{ 0x40000, "autocalib off", SIM_AUTOCALIB, 0 },
	{ 0x88000, "temp_comp on", SIM_TEMP_COMP, 1 },
	{ 0x48000, "temp_comp off", SIM_TEMP_COMP, 0 },
	{ 0xc0000, "calibrate", SIM_CALIBRATE },
	{ 0x20000, "reference", SIM_REFERENCE },
	{ 0xa0000, "rate 57600", SIM_RATE, 57600 },
	{ 0xe0000, "rate 115200", SIM_RATE, 115200 },
	{ 0x10000, "rate 230400", SIM_RATE, 230400 },
	{ 0x90000, "rate 460800", SIM_RATE, 460800 },
	{ 0xd0000, "rate 921600", SIM_RATE, 921600 },
};

static const struct sim_command *sim_find_command(u32 code)
{
	for (unsigned int i = 0; i < ARRAY_SIZE(sim_commands); i++) {
		const struct sim_command *command = &sim_commands[i];
		u32 axes = command->action == SIM_RATE ? 0 : SIM_ALL_AXES;

		if ((code & ~axes) == command->code)
			return command;
	}
	return NULL;
}

/**
 * xy3_sim_command_name() - name of a command
 * @code: its 20 bits
 * @axes: whether it can be for some axes only
 *
 * Return: its name, or NULL if it is unknown.
 */
const char *xy3_sim_command_name(u32 code, bool *axes)
{
	const struct sim_command *command = sim_find_command(code);

	*axes = command && command->action != SIM_RATE;
	return command ? command->name : NULL;
}

static void sim_switch(u32 *axes, u32 which, bool on)
{
	if (on)
		*axes |= which;
	else
		*axes &= ~which;
}

static void sim_obey(struct xy3_sim_head *head, u32 code)
{
	const struct sim_command *command = sim_find_command(code);
	u32 axes = code & SIM_ALL_AXES ?: SIM_ALL_AXES;

	head->log[head->commands++ % XY3_SIM_COMMANDS] =
		(struct xy3_sim_command) { .scan = head->scans, .code = code };
	if (!command) {
		head->unknown_commands++;
		return;
	}
	switch (command->action) {
	case SIM_AUTOCALIB:
		sim_switch(&head->autocalib, axes, command->value);
		break;
	case SIM_TEMP_COMP:
		sim_switch(&head->temp_comp, axes, command->value);
		break;
	case SIM_CALIBRATE:
		head->calibrated |= axes;
		break;
	case SIM_REFERENCE:
		head->referenced |= axes;
		break;
	case SIM_RATE:
		head->rate = command->value;
		break;
	}
}

/* ---- a frame of one axis ---- */

/* The levels of a line in eight clocks, the first one as the most significant bit */
static u8 sim_eight_clocks(const u8 *symbol, unsigned int line)
{
	u64 levels = (get_unaligned_le64(symbol) >> line) & 0x0101010101010101ULL;

	/* moves bit 8 i to bit 63 - i; no two products have the same bit, so there is no carry */
	return (levels * 0x8040201008040201ULL) >> 56;
}

/* The levels of a line in the frame, the first one as bit 31 */
static u32 sim_gather(const u8 *symbol, unsigned int line)
{
	u32 raw = 0;

	for (unsigned int at = 0; at < XY3_SIM_CLOCKS_MAX; at += 8)
		raw = raw << 8 | sim_eight_clocks(symbol + at, line);
	return raw;
}

static enum sim_verdict sim_judge(u32 raw, unsigned int clocks, u32 *data)
{
	bool is_long = raw & BIT(31);
	u32 parity;

	/* in 32 clocks this is a frame whose first bit means 24 */
	if (!raw && clocks == SIM_SHORT_CLOCKS)
		return SIM_IDLE;
	if (clocks != (is_long ? SIM_LONG_CLOCKS : SIM_SHORT_CLOCKS))
		return SIM_BAD_LENGTH;
	if (is_long) {
		*data = raw >> 4 & GENMASK(25, 0);
		parity = (hweight32(*data) ^ raw) & GENMASK(3, 0);
	} else {
		*data = raw >> 10 & GENMASK(19, 0);
		parity = (hweight32(*data) ^ raw >> 8) & GENMASK(1, 0);
	}
	if (parity)
		return SIM_BAD_PARITY;
	return raw & BIT(30) ? SIM_POSITION : SIM_COMMAND;
}

/* Whether it is a good position */
static bool sim_take(struct xy3_sim_head *head, unsigned int which, unsigned int clocks)
{
	struct xy3_sim_axis *axis = &head->axis[which];
	u32 data;

	if (head->wrong_mode) {
		axis->mode_errors++;
		return false;
	}
	switch (sim_judge(sim_gather(head->symbol, axis->line), clocks, &data)) {
	case SIM_IDLE:
		axis->idle++;
		return false;
	case SIM_BAD_LENGTH:
		axis->length_errors++;
		return false;
	case SIM_BAD_PARITY:
		axis->parity_errors++;
		return false;
	case SIM_COMMAND:
		axis->frames++;
		if (which == XY3_SIM_X)
			sim_obey(head, data & GENMASK(19, 0));
		return false;
	case SIM_POSITION:
		break;
	}
	axis->frames++;
	axis->code = data;
	axis->bits = clocks == SIM_LONG_CLOCKS ? 26 : 20;
	return true;
}

/**
 * xy3_sim_bad_frames() - number of erroneous frames
 * @axis: the axis
 *
 * Return: frames with a wrong parity, length or mode, since the counts were reset.
 */
u64 xy3_sim_bad_frames(const struct xy3_sim_axis *axis)
{
	return axis->parity_errors + axis->length_errors + axis->mode_errors;
}

/* ---- faults ---- */

static unsigned int sim_random_line(struct xy3_sim *sim)
{
	u8 lines[XY3_SIM_AXES];
	unsigned int count = 0;

	for (unsigned int i = 0; i < XY3_SIM_AXES; i++)
		if (sim->head.axis[i].line >= 0)
			lines[count++] = sim->head.axis[i].line;
	return count ? lines[xy3_sim_random(sim, count)] : 0;
}

static bool sim_flips(struct xy3_sim *sim)
{
	unsigned int every = xy3_sim_fault_value(sim, XY3_SIM_SPI_FLIP_EVERY);

	if (xy3_sim_fault(sim, XY3_SIM_SPI_FLIP))
		return true;
	if (!every || ++sim->frames < every)
		return false;
	sim->frames = 0;
	atomic_inc(&sim->fault_count[XY3_SIM_SPI_FLIP_EVERY]);
	return true;
}

static void sim_flip(struct xy3_sim *sim, unsigned int clocks)
{
	unsigned int line = xy3_sim_fault_value(sim, XY3_SIM_SPI_FLIP_LINE);
	unsigned int clock = xy3_sim_fault_value(sim, XY3_SIM_SPI_FLIP_CLOCK);

	clocks = min_t(unsigned int, clocks, XY3_SIM_CLOCKS_MAX);
	line = line ? line - 1 : sim_random_line(sim);
	clock = clock ? clock - 1 : xy3_sim_random(sim, clocks);
	if (line < XY3_SIM_LINES_MAX && clock < clocks)
		sim->head.symbol[clock] ^= BIT(line);
}

/* ---- a frame of all axes ---- */

/* Whether the gate was high in all clocks of the frame; in only some of them is an error */
static bool sim_judge_gate(struct xy3_sim_head *head, unsigned int clocks)
{
	unsigned int high = 0;

	if (head->gate < 0)
		return false;
	clocks = min_t(unsigned int, clocks, XY3_SIM_CLOCKS_MAX);
	for (unsigned int i = 0; i < clocks; i++)
		high += head->symbol[i] >> head->gate & 1;
	head->gate_torn += high && high < clocks;
	return high;
}

static void sim_end_frame(struct xy3_sim *sim)
{
	struct xy3_sim_head *head = &sim->head;
	unsigned int clocks = head->clocks;
	u32 codes[XY3_SIM_AXES];
	u64 commands = head->commands;
	bool scan = false, gate;

	head->inside = false;
	head->clocks = 0;
	head->gap = 0;
	if (head->stalled) {
		head->stalled = false;
		head->stalled_frames += !!clocks;
		return;
	}
	if (clocks && xy3_sim_fault(sim, XY3_SIM_SPI_CLOCK))
		clocks--;
	if (!clocks)
		return;
	if (clocks < XY3_SIM_CLOCKS_MAX)
		memset(head->symbol + clocks, 0, XY3_SIM_CLOCKS_MAX - clocks);
	if (sim_flips(sim))
		sim_flip(sim, clocks);

	for (unsigned int i = 0; i < XY3_SIM_AXES; i++) {
		bool good = head->axis[i].line >= 0 && sim_take(head, i, clocks);

		codes[i] = good ? head->axis[i].code : XY3_SIM_NO_CODE;
		scan |= good;
	}
	gate = sim_judge_gate(head, clocks);
	head->gate_commands += gate && head->commands != commands;
	if (scan) {
		head->scans++;
		head->gate_scans += gate;
		xy3_sim_record_scan(sim, codes, gate);
	}
}

static void sim_begin_frame(struct xy3_sim *sim)
{
	struct xy3_sim_head *head = &sim->head;

	if (head->sync >= 0 && head->gap < XY3_SIM_GAP_CLOCKS)
		head->short_gaps++;
	head->inside = true;
}

/* ---- clocks ---- */

static __always_inline void sim_clock(struct xy3_sim *sim, u8 symbol)
{
	struct xy3_sim_head *head = &sim->head;

	if (head->gate >= 0)
		head->gate_high = symbol >> head->gate & 1;
	if (head->sync >= 0) {
		if (symbol >> head->sync & 1) {
			if (head->inside)
				sim_end_frame(sim);
			head->gap++;
			return;
		}
		if (!head->inside)
			sim_begin_frame(sim);
	} else if (!head->inside) {
		head->stray_clocks++;
		return;
	}
	if (head->clocks < XY3_SIM_CLOCKS_MAX)
		head->symbol[head->clocks] = symbol;
	head->clocks++;
}

/**
 * xy3_sim_head_idle() - the controller has sent a message, and its clock has stopped
 * @sim: the head; its lock is held
 * @levels: levels of the data lines
 *
 * SYNC begins and ends frames without a clock, too. A frame that begins in this way does not
 * continue within the time of a frame: the head drops it, and waits for SYNC to fall again.
 */
void xy3_sim_head_idle(struct xy3_sim *sim, u8 levels)
{
	struct xy3_sim_head *head = &sim->head;

	if (head->gate >= 0)
		head->gate_high = levels >> head->gate & 1;
	if (head->sync < 0)
		return;
	if (levels >> head->sync & 1) {
		if (head->inside)
			sim_end_frame(sim);
		return;
	}
	head->inside = true;
	head->stalled = true;
}

/**
 * xy3_sim_head_bytes() - the controller sends bytes
 * @sim: the head; its lock is held
 * @data: the bytes, or NULL: all lines are low
 * @size: number of bytes
 * @nbits: data lines that are used: 1, 2, 4 or 8; the others are low
 */
void xy3_sim_head_bytes(struct xy3_sim *sim, const u8 *data, size_t size, unsigned int nbits)
{
	u8 mask = GENMASK(nbits - 1, 0);

	for (size_t i = 0; i < size; i++) {
		u8 byte = data ? data[i] : 0;

		for (int shift = 8 - nbits; shift >= 0; shift -= nbits)
			sim_clock(sim, byte >> shift & mask);
	}
}

/**
 * xy3_sim_head_word() - the controller sends a word
 * @sim: the head; its lock is held
 * @word: the word
 * @bits: of the word, a multiple of 8
 * @nbits: data lines that are used: 1, 2, 4 or 8; the others are low
 */
void xy3_sim_head_word(struct xy3_sim *sim, u32 word, unsigned int bits, unsigned int nbits)
{
	u8 bytes[sizeof(word)];

	put_unaligned_be32(word << (32 - bits), bytes);
	xy3_sim_head_bytes(sim, bytes, bits / 8, nbits);
}

/**
 * xy3_sim_head_lanes() - the controller sends a word on each of its lanes at the same time
 * @sim: the head; its lock is held
 * @words: the words
 * @lanes: number of lanes; the other lines are low
 * @bits: of a word
 */
void xy3_sim_head_lanes(struct xy3_sim *sim, const u32 *words, unsigned int lanes,
			unsigned int bits)
{
	while (bits--) {
		u8 levels = 0;

		for (unsigned int lane = 0; lane < lanes; lane++)
			levels |= (words[lane] >> bits & 1) << lane;
		sim_clock(sim, levels);
	}
}

/**
 * xy3_sim_head_select() - the controller changes the chip select
 * @sim: the head; its lock is held
 * @active: SYNC is low
 */
void xy3_sim_head_select(struct xy3_sim *sim, bool active)
{
	struct xy3_sim_head *head = &sim->head;

	if (head->sync >= 0 || active == head->inside)
		return;
	if (active)
		sim_begin_frame(sim);
	else
		sim_end_frame(sim);
}

/**
 * xy3_sim_head_wire() - connect the head to the lines of the controller
 * @sim: the head; its lock is held
 * @lines: number of lines
 * @signal: the signal of each
 */
void xy3_sim_head_wire(struct xy3_sim *sim, unsigned int lines, const u8 *signal)
{
	struct xy3_sim_head *head = &sim->head;

	head->lines = lines;
	head->sync = -1;
	head->gate = -1;
	head->gate_high = false;
	head->inside = false;
	head->stalled = false;
	head->clocks = 0;
	head->gap = XY3_SIM_GAP_CLOCKS;
	for (unsigned int i = 0; i < XY3_SIM_AXES; i++)
		head->axis[i].line = -1;
	for (unsigned int i = 0; i < lines; i++) {
		head->signal[i] = signal[i];
		if (signal[i] < XY3_SIM_AXES)
			head->axis[signal[i]].line = i;
		else if (signal[i] == XY3_SIM_SYNC)
			head->sync = i;
		else if (signal[i] == XY3_SIM_GATE)
			head->gate = i;
	}
}
