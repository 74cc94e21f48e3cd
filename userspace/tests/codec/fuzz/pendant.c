// SPDX-License-Identifier: GPL-2.0-only
/*
 * libFuzzer target: the codec of the pendants.
 *
 * The first byte of an input selects the model (low two bits), swap_feed_spindle (bit 2) and the
 * meaning of the rest (bits 3 and 4):
 *
 *   0  reports, each preceded by its size, 0..15
 *   1  a text, which may be a position, a step or a state
 *   2  values of a display frame
 *
 * FAULT, if defined, plants a fault that must be found (see run-fuzz).
 */
#include "../../../../drivers/hid-xhc/xhc-codec.c"
#include "fuzz.h"

static const u32 products[] = { 0xeb6e, 0xeb70, 0xeb93 };

/* In memory of the exact size, for ASan */
static void *copy(const void *data, size_t size)
{
	void *exact = malloc(size);

	must(exact);
	memcpy(exact, data, size);
	return exact;
}

/* ---- reports ---- */

static bool has(const u8 *keys, u8 code)
{
	return keys[0] == code || keys[1] == code;
}

/* The changes turn one set of keys into the other, each key once, releases first */
static void check_changes(const u8 *was, const u8 *now)
{
	struct xhc_key_change change[XHC_KEY_CHANGES_MAX];
	unsigned int count = xhc_key_changes(was, now, change);
	bool down[256] = {};

	must(count <= XHC_KEY_CHANGES_MAX);
	for (int i = 0; i < 2; i++)
		down[was[i]] = true;
	for (unsigned int i = 0; i < count; i++) {
		must(change[i].code && down[change[i].code] != change[i].down);
		must(!i || change[i].down >= change[i - 1].down);
		down[change[i].code] = change[i].down;
	}
	for (int code = 1; code < 256; code++)
		must(down[code] == has(now, code));
}

static void check_report(const struct xhc_model *model, const u8 *data, size_t size, bool swap,
			 u8 *keys)
{
	struct xhc_input_state in, untouched;
	int err;

	memset(&in, 0x5a, sizeof(in));
	untouched = in;
	err = xhc_decode_report(model, data, size, swap, &in);
	if (size != model->report_size || data[0] != 4) {
		must(err == -EINVAL && !memcmp(&in, &untouched, sizeof(in)));
		return;
	}
	must(!err);
	must(in.selector < XHC_SEL_COUNT && in.feed <= XHC_FEED_LEAD);
	must(in.selector <= model->selector_max);
	must(in.selector_ok || !in.selector);
	must(in.feed_ok || !in.feed);
	must(in.wheel == (s8)data[size - 2]);
	if (in.asleep)
		must(!in.key[0] && !in.key[1] && !in.selector && !in.feed);
	for (unsigned int seed = 0; seed < 256; seed += 37)
		xhc_report_matches(model, data, seed);
	check_changes(keys, in.key);
	memcpy(keys, in.key, sizeof(in.key));
}

static void reports(const struct xhc_model *model, const u8 *data, size_t size, bool swap)
{
	u8 keys[XHC_KEY_SLOTS] = {};

	while (size) {
		size_t n = min((size_t)(*data & 15), size - 1);
		u8 *report = copy(data + 1, n);

		check_report(model, report, n + (FAULT == 1), swap, keys);
		free(report);
		data += 1 + n;
		size -= 1 + n;
	}
}

/* ---- texts ---- */

static void texts(const struct xhc_model *model, const u8 *data, size_t size)
{
	char *text = malloc(size + 1), *again;
	char out[64];
	s32 units, units_again;
	u8 state, state_again;
	int step;

	must(text);
	memcpy(text, data, size);
	text[size] = 0;
	if (!xhc_parse_position(model, text, &units)) {
		must(xhc_format_position(units, out, sizeof(out)) < XHC_POSITION_TEXT);
		again = copy(out, strlen(out) + 1);
		must(!xhc_parse_position(model, again, &units_again));
		must(units_again == units + (FAULT == 2));
		free(again);
	}
	step = xhc_parse_step(text);
	must(step <= XHC_STEP_CODE_MAX);
	if (step >= 0 && xhc_step_multiplier(step) >= 0)
		must(xhc_step_code(xhc_step_multiplier(step)) == step);
	if (!xhc_parse_state(model, text, &state)) {
		must(xhc_format_state(model, state, out, sizeof(out)) < XHC_STATE_TEXT);
		again = copy(out, strlen(out) + 1);
		must(!xhc_parse_state(model, again, &state_again) && state_again == state);
		if (FAULT != 3)
			free(again);
	}
	free(text);
}

/* ---- frames ---- */

static void frames(const struct xhc_model *model, const u8 *data, size_t size)
{
	struct xhc_display display = {};
	int frame = model->rows ? 21 : model->fraction_size == 2 ? 37 : 31;
	u8 *payload = malloc(frame);
	u8 joined[XHC_CHUNKS_MAX * XHC_CHUNK_PAYLOAD] = {};
	int length;

	must(payload);
	memcpy(display.position, data, min(size, sizeof(display.position)));
	if (size > sizeof(display.position) + 16) {
		data += sizeof(display.position);
		memcpy(display.number, data, sizeof(display.number));
		display.day = data[8];
		display.step = data[9] & XHC_STEP_CODE_MAX;
		display.icon = data[10] & XHC_ICON_MAX;
		display.state = data[11];
		display.mode = data[12] % XHC_MODES;
		display.work = data[13] & 1;
		display.reset = data[14] & 1;
	}
	length = xhc_encode_payload(model, &display, payload);
	must(length == frame || length == -EINVAL || length == -ERANGE);
	if (length < 0) {
		free(payload);
		return;
	}
	must(payload[0] == 0xfe && payload[1] == 0xfd);
	must(payload[2] == (model->seed ?: display.day));
	must(model->chunks * XHC_CHUNK_PAYLOAD >= length);
	for (unsigned int i = 0; i < model->chunks; i++) {
		u8 report[XHC_CHUNK_SIZE];

		xhc_encode_chunk(payload, length, i, report);
		must(report[0] == 6);
		memcpy(joined + i * XHC_CHUNK_PAYLOAD, report + 1, XHC_CHUNK_PAYLOAD);
	}
	must(!memcmp(joined, payload, length));
	for (int i = length; i < model->chunks * XHC_CHUNK_PAYLOAD; i++)
		must(!joined[i]);
	free(payload);
}

int LLVMFuzzerTestOneInput(const u8 *data, size_t size)
{
	const struct xhc_model *model;

	if (!size)
		return 0;
	model = xhc_model_find(products[(data[0] & 3) % ARRAY_SIZE(products)]);
	must(model);
	switch (data[0] >> 3 & 3) {
	case 0:
		reports(model, data + 1, size - 1, data[0] & 4);
		break;
	case 1:
		texts(model, data + 1, size - 1);
		break;
	case 2:
		frames(model, data + 1, size - 1);
		break;
	}
	return 0;
}
