// SPDX-License-Identifier: GPL-2.0-only
/*
 * The examples of userspace/doc/protocol-xhc.md, converted by the codec of the driver
 */
#include "../../../../drivers/hid-xhc/xhc-codec.c"
#include "example.h"

static const char * const selectors[] = { "off", "x", "y", "z", "a", "feed", "spindle" };

/* In the order on the wire */
static const char * const positions[] = {
	"work_x", "work_y", "work_z", "machine_x", "machine_y", "machine_z"
};

static const char * const numbers[] = {
	"feedrate_override", "spindle_override", "feedrate", "spindle_speed"
};

static const struct xhc_model *model_of(const struct example *example)
{
	u32 product = strcmp(example->about, "HB03") ? XHC_PRODUCT_HB04 : XHC_PRODUCT_HB03;

	return xhc_model_find(product);
}

static void report(struct example *example)
{
	struct xhc_input_state in;

	example->words[0] = '\0';
	if (xhc_decode_report(model_of(example), example->bytes, example->size, false, &in)) {
		example_add(example, "", "no report");
		return;
	}
	if (in.asleep) {
		example_add(example, "", "asleep");
		return;
	}
	for (size_t i = 0; i < XHC_KEY_SLOTS; i++)
		if (in.key[i])
			example_add(example, ", ", "key %02x", in.key[i]);
	example_add(example, ", ", "selector %s",
		    in.selector_ok ? selectors[in.selector] : "unknown");
	if (in.wheel)
		example_add(example, ", ", "wheel %+d", in.wheel);
	example_add(example, ", ", "day %u", in.day);
}

static void selector(struct example *example)
{
	const u8 raw[] = { XHC_INPUT_ID, 0, 0, example->bytes[0], 0, 1 };
	struct xhc_input_state in = { };

	if (example->size != 1 ||
	    xhc_decode_report(model_of(example), raw, sizeof(raw), false, &in))
		return;
	snprintf(example->words, EXAMPLE_WORDS, "%s",
		 in.selector_ok ? selectors[in.selector] : "unknown");
}

/* The number as written; the pendant determines how it is displayed */
static void position(struct example *example)
{
	const struct xhc_model *model = model_of(example);
	char written[32];
	s32 units;

	example->size = 0;
	if (sscanf(example->words, "%31s", written) != 1 ||
	    xhc_parse_position(model, written, &units) ||
	    xhc_encode_position(model, units, example->bytes))
		return;
	example->size = 2 + model->fraction_size;
}

static void step(struct example *example)
{
	u8 byte = example->bytes[0];
	int multiplier = xhc_step_multiplier(FIELD_GET(XHC_STEP_CODE, byte));

	example->words[0] = '\0';
	if (multiplier < 0)
		example_add(example, "", "step unknown");
	else
		example_add(example, "", "step %d", multiplier);
	example_add(example, ", ", "icon %u", (unsigned int)FIELD_GET(XHC_STEP_ICON, byte));
}

static void state(struct example *example)
{
	xhc_format_state(model_of(example), example->bytes[0], example->words, EXAMPLE_WORDS);
}

/* "NAME VALUE". Return false if there is no such field, or it cannot have this value. */
static bool set_field(const struct xhc_model *model, struct xhc_display *display, char *text)
{
	char *name = strsep(&text, " ");
	int code;

	if (!text)
		return false;
	for (size_t i = 0; i < ARRAY_SIZE(positions); i++)
		if (!strcmp(name, positions[i]))
			return !xhc_parse_position(model, text, &display->position[i]);
	for (size_t i = 0; i < ARRAY_SIZE(numbers); i++)
		if (!strcmp(name, numbers[i])) {
			display->number[i] = strtoul(text, NULL, 10);
			return true;
		}
	if (!strcmp(name, "state"))
		return !xhc_parse_state(model, text, &display->state);
	if (!strcmp(name, "step")) {
		code = xhc_step_code(strtoul(text, NULL, 10));
		display->step = code;
		return code >= 0;
	}
	if (!strcmp(name, "icon"))
		display->icon = strtoul(text, NULL, 10);
	else if (!strcmp(name, "day"))
		display->day = strtoul(text, NULL, 10);
	else
		return false;
	return true;
}

static void picture(struct example *example)
{
	const struct xhc_model *model = model_of(example);
	struct xhc_display display = { };
	char words[EXAMPLE_WORDS], *rest = words, *field;
	u8 payload[XHC_PAYLOAD_MAX];
	int size;

	memcpy(words, example->words, sizeof(words));
	example->size = 0;
	while ((field = strsep(&rest, ","))) {
		if (!set_field(model, &display, field + strspn(field, " ")))
			return;
	}
	size = xhc_encode_payload(model, &display, payload);
	for (unsigned int i = 0; size > 0 && i < model->chunks; i++) {
		xhc_encode_chunk(payload, size, i, example->bytes + example->size);
		example->size += XHC_CHUNK_SIZE;
	}
}

static const struct example_kind kinds[] = {
	{ "report", report },
	{ "selector", selector },
	{ "position", position },
	{ "step", step },
	{ "state", state },
	{ "picture", picture },
};

int main(void)
{
	return example_main(kinds, ARRAY_SIZE(kinds));
}
