// SPDX-License-Identifier: GPL-2.0-only
/*
 * XHC pendant wire formats: reports, display frames and their text forms
 *
 * Source: "XHC xHB03 & xHB04 INTERNALS", 13/01/2014, and where that is unclear or
 * contradicted, programs that run on real units.
 */

#include <linux/bitfield.h>
#include <linux/bits.h>
#include <linux/ctype.h>
#include <linux/errno.h>
#include <linux/kernel.h>
#include <linux/limits.h>
#include <linux/math.h>
#include <linux/string.h>
#include <linux/unaligned.h>

#include "xhc-codec.h"

/*
 * Display frame of HB03 and HB04, cut into chunks of seven bytes, each sent as feature report
 * 06h; the unused tail of the last chunk is zero. All numbers are little-endian:
 *
 *   FE FD  day  6 x { integer, fraction }  4 x number  step  state
 *    2      1        2     1 or 2              2        1     1
 *
 * integer is that of the magnitude; fraction is one byte (two decimals, HB03) or two (four
 * decimals, HB04), with the sign in its top bit.
 */
#define XHC_MAGIC_0		0xfe
#define XHC_MAGIC_1		0xfd
#define XHC_FRAME_SIZE(frac)	(2 + 1 + XHC_POSITIONS * (2 + (frac)) + XHC_NUMBERS * 2 + 1 + 1)
#define XHC_FRAME_CHUNKS(frac)	DIV_ROUND_UP(XHC_FRAME_SIZE(frac), XHC_CHUNK_PAYLOAD)

static_assert(XHC_FRAME_SIZE(1) == 31 && XHC_FRAME_CHUNKS(1) == 5);
static_assert(XHC_FRAME_SIZE(2) == XHC_PAYLOAD_MAX && XHC_FRAME_CHUNKS(2) == XHC_CHUNKS_MAX);

/*
 * Display frame of WHB04B, cut and sent likewise:
 *
 *   FE FD  seed  flags  3 x { integer, fraction }  feed override  spindle override  00
 *    2      1      1           2        2                2                2          1
 *
 * flags: bits 0..1 mode, bit 6 RESET, bit 7 work coordinates; the others are not known and sent
 * as 0. Rows are as the positions of HB04, the overrides are percentages. The check byte of the
 * input reports is proven for this seed only.
 */
#define XHC_WHB_SEED		0xfe
#define XHC_WHB_FRAME_SIZE	(2 + 1 + 1 + XHC_ROWS * (2 + 2) + 2 * 2 + 1)
#define XHC_WHB_FRAME_CHUNKS	DIV_ROUND_UP(XHC_WHB_FRAME_SIZE, XHC_CHUNK_PAYLOAD)

static_assert(XHC_WHB_FRAME_SIZE == 21 && XHC_WHB_FRAME_CHUNKS == 3);

/* multiplier of each step code; 0Bh exists, but its meaning is unknown */
static const u16 xhc_steps[] = { 0, 1, 5, 10, 20, 30, 40, 50, 100, 500, 1000 };

static const struct {
	u8 bit;
	const char *name;
} xhc_states[] = {
	{ XHC_STATE_RUN, "run" },
	{ XHC_STATE_PAUSE, "pause" },
	{ XHC_STATE_INCH, "inch" },
};

/* Return: the position of a rotary switch for @code, 0 if the table does not have it */
static u8 xhc_rotary_position(const struct xhc_rotary_code *table, size_t rows, u8 code)
{
	for (size_t i = 0; i < rows; i++)
		if (table[i].code && table[i].code == code)
			return table[i].position;
	return 0;
}

static bool xhc_decode_selector(const struct xhc_model *model, u8 code, bool swap_feed_spindle,
				u8 *position)
{
	*position = xhc_rotary_position(model->selector, ARRAY_SIZE(model->selector), code);

	if (swap_feed_spindle && *position == XHC_SEL_FEED)
		*position = XHC_SEL_SPINDLE;
	else if (swap_feed_spindle && *position == XHC_SEL_SPINDLE)
		*position = XHC_SEL_FEED;

	return *position != XHC_SEL_OFF || !code || code == model->selector_off;
}

static void xhc_hb_decode(const struct xhc_model *model, const u8 *data, bool swap_feed_spindle,
			  struct xhc_input_state *in)
{
	const struct xhc_input_report *report = (const void *)data;

	for (size_t i = 0; i < XHC_KEY_SLOTS; i++)
		in->key[i] = report->key[i];
	in->selector_ok = xhc_decode_selector(model, report->selector, swap_feed_spindle,
					      &in->selector);
	in->selector_code = report->selector;
	in->feed = XHC_FEED_UNKNOWN;
	in->feed_code = 0;
	in->feed_ok = true;
	in->wheel = report->wheel;
	in->day = report->day_xor ^ report->key[0];
	/* an idle pendant with the selector off still sends its day, which is never 0 */
	in->asleep = !memchr_inv(data + 1, 0, sizeof(*report) - 1);
}

static void xhc_whb_decode(const struct xhc_model *model, const u8 *data,
			   bool swap_feed_spindle, struct xhc_input_state *in)
{
	const struct xhc_whb_report *report = (const void *)data;

	for (size_t i = 0; i < XHC_KEY_SLOTS; i++)
		in->key[i] = report->key[i];
	in->selector_ok = xhc_decode_selector(model, report->selector, swap_feed_spindle,
					      &in->selector);
	in->selector_code = report->selector;
	in->feed = xhc_rotary_position(model->feed, ARRAY_SIZE(model->feed), report->feed);
	in->feed_code = report->feed;
	in->feed_ok = in->feed != XHC_FEED_UNKNOWN || !report->feed;
	in->wheel = report->wheel;
	in->day = 0;
	in->asleep = !report->feed && !report->selector && !report->key[0] && !report->key[1];
}

static bool xhc_hb_matches(const u8 *data, u8 seed)
{
	const struct xhc_input_report *report = (const void *)data;

	return report->day_xor == (seed ^ report->key[0]);
}

static bool xhc_whb_matches(const u8 *data, u8 seed)
{
	const struct xhc_whb_report *report = (const void *)data;
	u8 inverse = ~report->random;
	u8 sum = inverse + report->key[0];

	return report->check == (sum ^ (seed | inverse));
}

static u32 xhc_pow10(unsigned int n)
{
	u32 p = 1;

	while (n--)
		p *= 10;
	return p;
}

/* Absolute value; correct for S32_MIN, too */
static u32 xhc_magnitude(s32 units)
{
	return units < 0 ? -(u32)units : (u32)units;
}

/*
 * Round half away from zero to what the display can show, then split into integer and
 * fraction: in this order, so that a carry reaches the integer.
 */
int xhc_encode_position(const struct xhc_model *model, s32 units, u8 *p)
{
	u32 scale = xhc_pow10(model->decimals);
	u32 step = xhc_pow10(XHC_UNITS_DECIMALS - model->decimals);
	u32 magnitude = xhc_magnitude(units);
	bool negative;
	u32 fraction;

	magnitude = magnitude / step + (magnitude % step >= (step + 1) / 2);
	if (magnitude / scale > U16_MAX)
		return -ERANGE;

	negative = units < 0 && magnitude;
	fraction = magnitude % scale;
	put_unaligned_le16(magnitude / scale, p);
	if (model->fraction_size == 1)
		p[2] = fraction | (negative ? BIT(7) : 0);
	else
		put_unaligned_le16(fraction | (negative ? BIT(15) : 0), p + 2);
	return 0;
}

/* Return: bytes written, or -ERANGE */
static int xhc_encode_positions(const struct xhc_model *model, const struct xhc_display *display,
				u8 *p)
{
	size_t size = 2 + model->fraction_size;

	for (size_t i = 0; i < model->positions; i++) {
		int err = xhc_encode_position(model, display->position[i], p + i * size);

		if (err)
			return err;
	}
	return model->positions * size;
}

static int xhc_hb_encode(const struct xhc_model *model, const struct xhc_display *display,
			 u8 *payload)
{
	u8 *p = payload;
	int size;

	if (display->day < 1 || display->day > XHC_DAY_MAX)
		return -EINVAL;

	*p++ = XHC_MAGIC_0;
	*p++ = XHC_MAGIC_1;
	*p++ = display->day;
	size = xhc_encode_positions(model, display, p);
	if (size < 0)
		return size;
	p += size;
	for (size_t i = 0; i < XHC_NUMBERS; i++) {
		put_unaligned_le16(display->number[i], p);
		p += 2;
	}
	*p++ = FIELD_PREP(XHC_STEP_ICON, display->icon) | FIELD_PREP(XHC_STEP_CODE, display->step);
	*p++ = display->state;
	return p - payload;
}

static int xhc_whb_encode(const struct xhc_model *model, const struct xhc_display *display,
			  u8 *payload)
{
	u8 *p = payload;
	int size;

	*p++ = XHC_MAGIC_0;
	*p++ = XHC_MAGIC_1;
	*p++ = model->seed;
	*p++ = FIELD_PREP(XHC_FLAG_MODE, display->mode) |
	       FIELD_PREP(XHC_FLAG_RESET, display->reset) |
	       FIELD_PREP(XHC_FLAG_WORK, display->work);
	size = xhc_encode_positions(model, display, p);
	if (size < 0)
		return size;
	p += size;
	put_unaligned_le16(display->number[XHC_FEEDRATE_OVERRIDE], p);
	put_unaligned_le16(display->number[XHC_SPINDLE_OVERRIDE], p + 2);
	p[4] = 0;
	return p + 5 - payload;
}

static const struct xhc_model xhc_models[] = {
	{
		.name = "HB03",
		.product = XHC_PRODUCT_HB03,
		.report_size = sizeof(struct xhc_input_report),
		.key_max = XHC_KEY_MAX,
		.decimals = 2,
		.fraction_size = 1,
		.positions = XHC_POSITIONS,
		.chunks = XHC_FRAME_CHUNKS(1),
		.named_states = XHC_STATE_RUN | XHC_STATE_PAUSE,
		.selector_max = XHC_SEL_SPINDLE,
		.selector = {
			{ 0x11, XHC_SEL_X }, { 0x12, XHC_SEL_Y }, { 0x13, XHC_SEL_Z },
			{ 0x18, XHC_SEL_A },
			{ 0x14, XHC_SEL_FEED }, { 0x15, XHC_SEL_SPINDLE },
		},
		.decode = xhc_hb_decode,
		.matches = xhc_hb_matches,
		.encode = xhc_hb_encode,
	},
	{
		.name = "HB04",
		.product = XHC_PRODUCT_HB04,
		.report_size = sizeof(struct xhc_input_report),
		.key_max = XHC_KEY_MAX,
		.decimals = 4,
		.fraction_size = 2,
		.positions = XHC_POSITIONS,
		.chunks = XHC_FRAME_CHUNKS(2),
		.named_states = XHC_STATE_RUN | XHC_STATE_PAUSE | XHC_STATE_INCH,
		.selector_max = XHC_SEL_SPINDLE,
		.selector = {
			{ 0x11, XHC_SEL_X }, { 0x12, XHC_SEL_Y }, { 0x13, XHC_SEL_Z },
			{ 0x18, XHC_SEL_A },
			/* swapped in the document, but not in real units */
			{ 0x15, XHC_SEL_FEED }, { 0x14, XHC_SEL_SPINDLE },
		},
		.decode = xhc_hb_decode,
		.matches = xhc_hb_matches,
		.encode = xhc_hb_encode,
	},
	{
		.name = "WHB04B",
		.product = XHC_PRODUCT_WHB04B,
		.report_size = sizeof(struct xhc_whb_report),
		.key_max = 0x10,
		.decimals = 4,
		.fraction_size = 2,
		.positions = XHC_ROWS,
		.rows = true,
		.chunks = XHC_WHB_FRAME_CHUNKS,
		.seed = XHC_WHB_SEED,
		.streams = true,
		.trailing_report = true,
		.selector_off = 0x06,
		.selector_max = XHC_SEL_C,
		.selector = {
			{ 0x11, XHC_SEL_X }, { 0x12, XHC_SEL_Y }, { 0x13, XHC_SEL_Z },
			{ 0x14, XHC_SEL_A }, { 0x15, XHC_SEL_B }, { 0x16, XHC_SEL_C },
		},
		.feed = {
			{ 0x0d, XHC_FEED_2 }, { 0x0e, XHC_FEED_5 }, { 0x0f, XHC_FEED_10 },
			{ 0x10, XHC_FEED_30 }, { 0x1a, XHC_FEED_60 }, { 0x1b, XHC_FEED_100 },
			/* by unit */
			{ 0x1c, XHC_FEED_LEAD }, { 0x9b, XHC_FEED_LEAD },
		},
		.decode = xhc_whb_decode,
		.matches = xhc_whb_matches,
		.encode = xhc_whb_encode,
	},
};

/**
 * xhc_model_find() - find a model by its USB product id
 * @product: USB product id
 *
 * Return: a row of the table of models, or NULL.
 */
const struct xhc_model *xhc_model_find(u32 product)
{
	for (size_t i = 0; i < ARRAY_SIZE(xhc_models); i++)
		if (xhc_models[i].product == product)
			return &xhc_models[i];
	return NULL;
}

/**
 * xhc_decode_report() - decode an input report
 * @model: the pendant's model
 * @data: the report with its id
 * @size: bytes in @data
 * @swap_feed_spindle: the unit has the codes of feed and spindle swapped
 * @in: content of the report; untouched on error
 *
 * Return: 0, or -EINVAL for a report of another size or id.
 */
int xhc_decode_report(const struct xhc_model *model, const u8 *data, size_t size,
		      bool swap_feed_spindle, struct xhc_input_state *in)
{
	if (size != model->report_size || data[0] != XHC_INPUT_ID)
		return -EINVAL;

	model->decode(model, data, swap_feed_spindle, in);
	return 0;
}

/**
 * xhc_report_matches() - check whether a report was made with a seed
 * @model: the pendant's model
 * @data: a report that xhc_decode_report() has accepted
 * @seed: byte 2 of a display frame: the day, or the model's seed
 *
 * Return: true if a pendant that was sent @seed last sends this report.
 */
bool xhc_report_matches(const struct xhc_model *model, const u8 *data, u8 seed)
{
	return model->matches(data, seed);
}

/**
 * xhc_encode_payload() - encode the payload of a display frame
 * @model: the pendant's model
 * @display: values to be shown
 * @payload: the destination
 *
 * Return: bytes written. On error @payload is undefined: -EINVAL if the frame has a day outside
 * 1..31 (with day 0 a sleeping pendant looks like an idle one), -ERANGE if the integer part of a
 * position does not fit 16 bits.
 */
int xhc_encode_payload(const struct xhc_model *model, const struct xhc_display *display,
		       u8 payload[XHC_PAYLOAD_MAX])
{
	return model->encode(model, display, payload);
}

static bool xhc_key_in(u8 code, const u8 keys[XHC_KEY_SLOTS])
{
	return code == keys[0] || code == keys[1];
}

/* The keys of @from that are not in @other, each once */
static unsigned int xhc_keys_only_in(const u8 from[XHC_KEY_SLOTS], const u8 other[XHC_KEY_SLOTS],
				     bool down, struct xhc_key_change *change)
{
	unsigned int n = 0;

	for (size_t i = 0; i < XHC_KEY_SLOTS; i++) {
		if (!from[i] || xhc_key_in(from[i], other))
			continue;
		if (i > 0 && from[i] == from[0])
			continue;
		change[n++] = (struct xhc_key_change){ .code = from[i], .down = down };
	}
	return n;
}

/**
 * xhc_key_changes() - find the keys that went up or down between two reports
 * @was: scan codes in the slots before, 0 for an empty one
 * @now: scan codes in the slots now
 * @change: the changes, releases first
 *
 * A key is down while its code is in either slot. Codes are compared, not slots: a pendant
 * may move a key from one slot to the other.
 *
 * Return: number of changes.
 */
unsigned int xhc_key_changes(const u8 was[XHC_KEY_SLOTS], const u8 now[XHC_KEY_SLOTS],
			     struct xhc_key_change change[XHC_KEY_CHANGES_MAX])
{
	unsigned int n = xhc_keys_only_in(was, now, false, change);

	return n + xhc_keys_only_in(now, was, true, change + n);
}

/**
 * xhc_encode_chunk() - encode one feature report of a display frame
 * @payload: the frame, from xhc_encode_payload()
 * @size: bytes in @payload
 * @index: which chunk, from 0
 * @report: the feature report with its id; unused bytes are zero
 */
void xhc_encode_chunk(const u8 *payload, size_t size, unsigned int index,
		      u8 report[XHC_CHUNK_SIZE])
{
	size_t start = index * XHC_CHUNK_PAYLOAD;

	report[0] = XHC_FEATURE_ID;
	for (size_t i = 0; i < XHC_CHUNK_PAYLOAD; i++)
		report[1 + i] = start + i < size ? payload[start + i] : 0;
}

/**
 * xhc_parse_position() - read a decimal number, rounded as the display shows it
 * @model: the pendant's model: its decimals are kept, the rest is rounded half away from zero
 * @text: optional sign, digits, optional point and digits; white space around is ignored
 * @units: the number in units of 1/10000; untouched on error
 *
 * The text is rounded once, not a value rounded before: 0.00496 is 0.00 on HB03.
 *
 * Return: 0, -EINVAL when @text is not such a number, -ERANGE when its magnitude,
 * rounded, does not fit the 16-bit integer part of the wire.
 */
int xhc_parse_position(const struct xhc_model *model, const char *text, s32 *units)
{
	const char *s = skip_spaces(text);
	u32 scale = xhc_pow10(model->decimals);
	unsigned int places = 0, digits = 0;
	u32 whole = 0, fraction = 0;
	bool negative = *s == '-';
	bool up = false;

	if (*s == '-' || *s == '+')
		s++;

	for (; isdigit(*s); s++, digits++)
		if (whole <= U16_MAX)	/* once over the limit is enough */
			whole = whole * 10 + (*s - '0');

	if (*s == '.') {
		for (s++; isdigit(*s); s++, digits++, places++) {
			if (places < model->decimals)
				fraction = fraction * 10 + (*s - '0');
			else if (places == model->decimals)
				up = *s >= '5';
		}
	}
	if (!digits || *skip_spaces(s))
		return -EINVAL;
	if (whole > U16_MAX)
		return -ERANGE;

	for (; places < model->decimals; places++)
		fraction *= 10;
	whole = whole * scale + fraction + up;
	if (whole / scale > U16_MAX)
		return -ERANGE;

	*units = whole * xhc_pow10(XHC_UNITS_DECIMALS - model->decimals);
	if (negative)
		*units = -*units;
	return 0;
}

/**
 * xhc_format_position() - write a position as the shortest decimal number
 * @units: the position in units of 1/10000
 * @text: receives the number, such as "-220.334"
 * @size: bytes in @text, XHC_POSITION_TEXT is enough
 *
 * Return: length of the text.
 */
int xhc_format_position(s32 units, char *text, size_t size)
{
	u32 scale = xhc_pow10(XHC_UNITS_DECIMALS);
	u32 magnitude = xhc_magnitude(units);
	u32 fraction = magnitude % scale;
	int places = XHC_UNITS_DECIMALS;
	const char *sign = units < 0 ? "-" : "";

	if (!fraction)
		return scnprintf(text, size, "%s%u", sign, magnitude / scale);

	for (; fraction % 10 == 0; places--)
		fraction /= 10;
	return scnprintf(text, size, "%s%u.%0*u", sign, magnitude / scale, places, fraction);
}

/**
 * xhc_step_code() - wire code of a step multiplier
 * @multiplier: one of 0 1 5 10 20 30 40 50 100 500 1000
 *
 * Return: the code, or -ERANGE for any other multiplier.
 */
int xhc_step_code(unsigned int multiplier)
{
	for (size_t i = 0; i < ARRAY_SIZE(xhc_steps); i++)
		if (xhc_steps[i] == multiplier)
			return i;
	return -ERANGE;
}

/**
 * xhc_step_multiplier() - step multiplier of a code
 * @code: low nibble of the step byte
 *
 * Return: the multiplier, or -ERANGE for a code that has none.
 */
int xhc_step_multiplier(unsigned int code)
{
	return code < ARRAY_SIZE(xhc_steps) ? xhc_steps[code] : -ERANGE;
}

/**
 * xhc_parse_step() - read a step multiplier, or the wire code of one that has no number
 * @text: a multiplier in decimal, or a code 0..15 as 0x and hexadecimal
 *
 * Return: the code, -EINVAL when @text is not such a number, -ERANGE for another multiplier
 * or a code over 15.
 */
int xhc_parse_step(const char *text)
{
	bool is_code = str_has_prefix(text, "0x");
	int err, number;

	err = kstrtoint(text, is_code ? 16 : 10, &number);
	if (err)
		return err;
	if (number < 0 || (is_code && number > XHC_STEP_CODE_MAX))
		return -ERANGE;
	return is_code ? number : xhc_step_code(number);
}

static int xhc_parse_state_word(const struct xhc_model *model, const char *word, u8 *bits)
{
	int err, number;

	if (!strcmp(word, "idle")) {
		*bits = 0;
		return 0;
	}
	for (size_t i = 0; i < ARRAY_SIZE(xhc_states); i++) {
		if (model->named_states & xhc_states[i].bit && !strcmp(word, xhc_states[i].name)) {
			*bits = xhc_states[i].bit;
			return 0;
		}
	}

	err = kstrtoint(word, str_has_prefix(word, "0x") ? 16 : 10, &number);
	if (err)
		return err;
	if (number < 0 || number > U8_MAX)
		return -ERANGE;
	*bits = number;
	return 0;
}

/**
 * xhc_parse_state() - read the state byte from names and numbers
 * @model: the pendant's model
 * @text: names of the model's states and numbers 0..255 (decimal, or 0x and hexadecimal),
 *	joined by "+"; white space around is ignored
 * @state: all of them together; untouched on error
 *
 * Return: 0, -EINVAL for a word that is neither, -ERANGE for a number over a byte.
 */
int xhc_parse_state(const struct xhc_model *model, const char *text, u8 *state)
{
	const char *s = skip_spaces(text);
	u8 all = 0;

	for (;;) {
		size_t len = strcspn(s, "+ \t\n");
		char word[XHC_STATE_TEXT];
		u8 bits;
		int err;

		if (len >= sizeof(word))
			return -EINVAL;
		memcpy(word, s, len);
		word[len] = '\0';

		err = xhc_parse_state_word(model, word, &bits);
		if (err)
			return err;
		all |= bits;

		s += len;
		if (*s != '+')
			break;
		s++;
	}
	if (*skip_spaces(s))
		return -EINVAL;

	*state = all;
	return 0;
}

/**
 * xhc_format_state() - write the state byte as names, and bits without a name as a number
 * @model: the pendant's model
 * @state: the state byte
 * @text: receives the words, joined by "+", such as "run+0x40"; "idle" for 0
 * @size: bytes in @text, XHC_STATE_TEXT is enough
 *
 * Return: length of the text.
 */
int xhc_format_state(const struct xhc_model *model, u8 state, char *text, size_t size)
{
	u8 rest = state & ~model->named_states;
	const char *join = "";
	int len = 0;

	if (!state)
		return scnprintf(text, size, "idle");

	for (size_t i = 0; i < ARRAY_SIZE(xhc_states); i++) {
		if (!(state & model->named_states & xhc_states[i].bit))
			continue;
		len += scnprintf(text + len, size - len, "%s%s", join, xhc_states[i].name);
		join = "+";
	}
	if (rest)
		len += scnprintf(text + len, size - len, "%s0x%02x", join, rest);
	return len;
}
