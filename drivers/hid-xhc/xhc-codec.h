/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XHC pendant wire formats: reports, display frames and their text forms
 *
 * Pure functions over bytes, without allocation, sleeping or a device, so that the same
 * source is compiled into the driver and into user-space tests.
 */
#ifndef XHC_CODEC_H
#define XHC_CODEC_H

#include <linux/build_bug.h>
#include <linux/types.h>

#define XHC_VENDOR_ID		0x10ce

#define XHC_INPUT_ID		0x04
#define XHC_FEATURE_ID		0x06

#define XHC_KEY_MAX		0x17	/* keys have the scan codes 01h..17h at most */
#define XHC_KEY_SLOTS		2

#define XHC_CHUNK_PAYLOAD	7
#define XHC_CHUNK_SIZE		(1 + XHC_CHUNK_PAYLOAD)
#define XHC_CHUNKS_MAX		6
#define XHC_PAYLOAD_MAX		37

/* positions are kept in units of 1/10000 of what the display shows (mm, inch, degree) */
#define XHC_UNITS_DECIMALS	4
#define XHC_POSITION_TEXT	16	/* "-65535.9999" and its NUL */
#define XHC_STATE_TEXT		32	/* "run+pause+inch+0x7c" and its NUL */

/**
 * enum xhc_selector - position of the pendant's rotary switch
 * @XHC_SEL_OFF: off, or a code that the model does not know
 * @XHC_SEL_X: axis X
 * @XHC_SEL_Y: axis Y
 * @XHC_SEL_Z: axis Z
 * @XHC_SEL_A: axis A (HB03: processing speed)
 * @XHC_SEL_FEED: feed rate
 * @XHC_SEL_SPINDLE: spindle speed
 * @XHC_SEL_B: axis B
 * @XHC_SEL_C: axis C
 * @XHC_SEL_COUNT: number of positions
 *
 * The numbers are those that user space sees as ABS_MISC.
 */
enum xhc_selector {
	XHC_SEL_OFF,
	XHC_SEL_X,
	XHC_SEL_Y,
	XHC_SEL_Z,
	XHC_SEL_A,
	XHC_SEL_FEED,
	XHC_SEL_SPINDLE,
	XHC_SEL_B,
	XHC_SEL_C,
	XHC_SEL_COUNT
};

/**
 * enum xhc_feed - position of the second rotary switch (WHB04B)
 * @XHC_FEED_UNKNOWN: not known
 * @XHC_FEED_2: 2 %, in step mode 0.001
 * @XHC_FEED_5: 5 %, in step mode 0.01
 * @XHC_FEED_10: 10 %, in step mode 0.1
 * @XHC_FEED_30: 30 %, in step mode 1.0
 * @XHC_FEED_60: 60 %, in step mode 5.0 on units named -B
 * @XHC_FEED_100: 100 %, in step mode 10.0 on units named -B
 * @XHC_FEED_LEAD: Lead
 *
 * The numbers are those that user space sees as ABS_THROTTLE.
 */
enum xhc_feed {
	XHC_FEED_UNKNOWN,
	XHC_FEED_2,
	XHC_FEED_5,
	XHC_FEED_10,
	XHC_FEED_30,
	XHC_FEED_60,
	XHC_FEED_100,
	XHC_FEED_LEAD,
};

/* Codes of the second rotary switch; Lead has two of them, by unit */
#define XHC_FEED_CODES	8

/**
 * struct xhc_rotary_code - one row of the table of a rotary switch
 * @code: its byte of the input report, 00h in an unused row
 * @position: enum xhc_selector or enum xhc_feed
 */
struct xhc_rotary_code {
	u8 code;
	u8 position;
};

struct xhc_display;
struct xhc_input_state;

/**
 * struct xhc_model - properties of a model of pendant
 * @name: as printed on the unit
 * @product: USB product id
 * @report_size: bytes of an input report with its id
 * @key_max: highest scan code of a key
 * @decimals: decimals that the display shows
 * @fraction_size: bytes of a position's fraction on the wire, its top bit is the sign
 * @positions: positions of a display frame
 * @rows: they are rows that the unit labels itself, and the frame has flags
 * @chunks: feature reports of a display frame
 * @seed: byte 2 of each display frame, 0 if that is the day of the month
 * @named_states: bits of the state byte that have a name on this model
 * @streams: reports are sent continuously while the selector is not off
 * @trailing_report: one more report, without a meaning, follows the sleep report
 * @selector_off: code of the selector for off, beside 00h
 * @selector_max: the highest of its positions, enum xhc_selector
 * @selector: codes of the other positions
 * @feed: codes of the second rotary switch, none on a model without one
 * @decode: xhc_decode_report() of a report of the right size and id
 * @matches: xhc_report_matches()
 * @encode: xhc_encode_payload()
 */
struct xhc_model {
	const char *name;
	u16 product;
	u8 report_size;
	u8 key_max;
	u8 decimals;
	u8 fraction_size;
	u8 positions;
	bool rows;
	u8 chunks;
	u8 seed;
	u8 named_states;
	bool streams;
	bool trailing_report;
	u8 selector_off;
	u8 selector_max;
	struct xhc_rotary_code selector[XHC_SEL_COUNT - 1];
	struct xhc_rotary_code feed[XHC_FEED_CODES];
	void (*decode)(const struct xhc_model *model, const u8 *data, bool swap_feed_spindle,
		       struct xhc_input_state *in);
	bool (*matches)(const u8 *data, u8 seed);
	int (*encode)(const struct xhc_model *model, const struct xhc_display *display,
		      u8 *payload);
};

/* Models, by their product id */
#define XHC_PRODUCT_HB03	0xeb6e
#define XHC_PRODUCT_HB04	0xeb70
#define XHC_PRODUCT_WHB04B	0xeb93

const struct xhc_model *xhc_model_find(u32 product);

/*
 * Input report 04h of HB03 and HB04, as received:
 *
 *   byte  0     1      2      3         4      5
 *         04h   key 1  key 2  selector  wheel  day XOR key 1
 *
 * Keys are 00h if none is down; the wheel is signed, clockwise positive. All zero
 * after the id: the pendant falls asleep.
 */
struct xhc_input_report {
	u8 id;
	u8 key[XHC_KEY_SLOTS];
	u8 selector;
	s8 wheel;
	u8 day_xor;
} __packed;
static_assert(sizeof(struct xhc_input_report) == 6);

/*
 * Input report 04h of WHB04B, as received:
 *
 *   byte  0     1       2      3      4     5         6      7
 *         04h   random  key 1  key 2  feed  selector  wheel  check
 *
 *   check = (~random + key 1) XOR (seed OR ~random), all in 8 bits
 *
 * random changes from report to report and has no meaning of its own; seed is byte 2 of the
 * last display frame. Keys and wheel are those of HB04; feed is the second rotary switch.
 * feed, selector and both keys 00h: the pendant falls asleep.
 */
struct xhc_whb_report {
	u8 id;
	u8 random;
	u8 key[XHC_KEY_SLOTS];
	u8 feed;
	u8 selector;
	s8 wheel;
	u8 check;
} __packed;
static_assert(sizeof(struct xhc_whb_report) == 8);

/**
 * struct xhc_input_state - content of an input report
 * @key: scan codes of the keys that are down, 0 for an empty slot
 * @selector: enum xhc_selector
 * @feed: enum xhc_feed
 * @wheel: detents since the last report, clockwise positive
 * @asleep: the report that is sent when the pendant falls asleep
 * @day: the day that byte 5 returns (HB03, HB04)
 * @selector_code: code of @selector, as received
 * @selector_ok: the model knows that code
 * @feed_code: code of @feed, as received
 * @feed_ok: the model knows that code
 */
struct xhc_input_state {
	u8 key[XHC_KEY_SLOTS];
	u8 selector;
	u8 feed;
	s8 wheel;
	bool asleep;
	u8 day;
	u8 selector_code;
	bool selector_ok;
	u8 feed_code;
	bool feed_ok;
};

int xhc_decode_report(const struct xhc_model *model, const u8 *data, size_t size,
		      bool swap_feed_spindle, struct xhc_input_state *in);
bool xhc_report_matches(const struct xhc_model *model, const u8 *data, u8 seed);

/**
 * struct xhc_key_change - a key that went down or up between two reports
 * @code: scan code
 * @down: true if the key is down now
 */
struct xhc_key_change {
	u8 code;
	bool down;
};

#define XHC_KEY_CHANGES_MAX	(2 * XHC_KEY_SLOTS)

unsigned int xhc_key_changes(const u8 was[XHC_KEY_SLOTS], const u8 now[XHC_KEY_SLOTS],
			     struct xhc_key_change change[XHC_KEY_CHANGES_MAX]);

/**
 * enum xhc_position - the six coordinates of HB03 and HB04, in the order of the wire
 * @XHC_WORK_X: X in the coordinate system of the workpiece
 * @XHC_WORK_Y: Y in the coordinate system of the workpiece
 * @XHC_WORK_Z: Z in the coordinate system of the workpiece
 * @XHC_MACHINE_X: X in the coordinate system of the machine
 * @XHC_MACHINE_Y: Y in the coordinate system of the machine
 * @XHC_MACHINE_Z: Z in the coordinate system of the machine
 * @XHC_POSITIONS: number of coordinates
 */
enum xhc_position {
	XHC_WORK_X,
	XHC_WORK_Y,
	XHC_WORK_Z,
	XHC_MACHINE_X,
	XHC_MACHINE_Y,
	XHC_MACHINE_Z,
	XHC_POSITIONS
};

/* The three rows of WHB04B use the first three coordinates */
#define XHC_ROW_1		0
#define XHC_ROW_2		1
#define XHC_ROW_3		2
#define XHC_ROWS		3

/**
 * enum xhc_number - the four plain numbers of the display, in the order of the wire
 * @XHC_FEEDRATE_OVERRIDE: feed rate override
 * @XHC_SPINDLE_OVERRIDE: spindle speed override
 * @XHC_FEEDRATE: feed rate
 * @XHC_SPINDLE_SPEED: spindle speed
 * @XHC_NUMBERS: number of plain numbers
 *
 * WHB04B shows the overrides only.
 */
enum xhc_number {
	XHC_FEEDRATE_OVERRIDE,
	XHC_SPINDLE_OVERRIDE,
	XHC_FEEDRATE,
	XHC_SPINDLE_SPEED,
	XHC_NUMBERS
};

/**
 * enum xhc_mode - what the wheel of WHB04B does, as its display shows it
 * @XHC_MODE_CONTINUOUS: moves while it turns
 * @XHC_MODE_STEP: moves by steps, and the second rotary switch is shown as one
 * @XHC_MODE_MPG: moves as a handwheel
 * @XHC_MODE_PERCENT: the second rotary switch is shown as a percentage, without a mode
 * @XHC_MODES: number of modes
 */
enum xhc_mode {
	XHC_MODE_CONTINUOUS,
	XHC_MODE_STEP,
	XHC_MODE_MPG,
	XHC_MODE_PERCENT,
	XHC_MODES
};

#define XHC_FLAG_MODE		0x03	/* flags byte: enum xhc_mode */
#define XHC_FLAG_RESET		0x40	/* flags byte: RESET is shown */
#define XHC_FLAG_WORK		0x80	/* flags byte: work coordinates, "X1" for "X" */

#define XHC_STATE_RUN		0x01
#define XHC_STATE_PAUSE		0x02
#define XHC_STATE_INCH		0x80	/* HB04 */

#define XHC_STEP_CODE		0x0f	/* step byte: low nibble, index of the multiplier */
#define XHC_STEP_CODE_MAX	0x0f
#define XHC_STEP_ICON		0xf0	/* step byte: high nibble, an icon */
#define XHC_ICON_MAX		0x0f

#define XHC_DAY_MAX		31

#define XHC_SEED_AT		2	/* byte of a frame that check bytes are made from */

/**
 * struct xhc_display - values to be shown on the display
 * @position: by enum xhc_position, in units of 1/10000
 * @number: by enum xhc_number
 * @day: day of the month, 1..31; the pendant's key for byte 5 of its reports (HB03, HB04)
 * @step: code of the step multiplier, see xhc_parse_step() (HB03, HB04)
 * @icon: 0..15 (HB03, HB04)
 * @state: XHC_STATE_* and bits without a name (HB03, HB04)
 * @mode: enum xhc_mode (WHB04B)
 * @work: the rows are work coordinates, not machine coordinates (WHB04B)
 * @reset: RESET is shown (WHB04B)
 */
struct xhc_display {
	s32 position[XHC_POSITIONS];
	u16 number[XHC_NUMBERS];
	u8 day;
	u8 step;
	u8 icon;
	u8 state;
	u8 mode;
	bool work;
	bool reset;
};

int xhc_encode_position(const struct xhc_model *model, s32 units, u8 *p);
int xhc_encode_payload(const struct xhc_model *model, const struct xhc_display *display,
		       u8 payload[XHC_PAYLOAD_MAX]);
void xhc_encode_chunk(const u8 *payload, size_t size, unsigned int index,
		      u8 report[XHC_CHUNK_SIZE]);

int xhc_parse_position(const struct xhc_model *model, const char *text, s32 *units);
int xhc_format_position(s32 units, char *text, size_t size);

int xhc_parse_step(const char *text);
int xhc_step_code(unsigned int multiplier);
int xhc_step_multiplier(unsigned int code);

int xhc_parse_state(const struct xhc_model *model, const char *text, u8 *state);
int xhc_format_state(const struct xhc_model *model, u8 state, char *text, size_t size);

#endif /* XHC_CODEC_H */
