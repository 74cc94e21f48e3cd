// SPDX-License-Identifier: GPL-2.0-only
/*
 * The table of models. See model.h.
 */
#include <string.h>

#include "cli.h"
#include "model.h"

#define FIELDS_HB	(BIT(WORK_X) | BIT(WORK_Y) | BIT(WORK_Z) | BIT(MACHINE_X) |		\
			 BIT(MACHINE_Y) | BIT(MACHINE_Z) | BIT(FEEDRATE_OVERRIDE) |		\
			 BIT(SPINDLE_OVERRIDE) | BIT(FEEDRATE) | BIT(SPINDLE_SPEED) |		\
			 BIT(STEP) | BIT(ICON) | BIT(STATE) | BIT(DAY) | BIT(REFRESH_MS))
#define FIELDS_WHB04B	(BIT(ROW1) | BIT(ROW2) | BIT(ROW3) | BIT(FEEDRATE_OVERRIDE) |		\
			 BIT(SPINDLE_OVERRIDE) | BIT(MODE) | BIT(COORDINATES) | BIT(RESET) |	\
			 BIT(REFRESH_MS))

static const struct model models[] = {
	{
		.name = "HB03",
		.layout = "hb03",
		.fields = FIELDS_HB,
		.group = POSITION, .first = WORK_X, .last = MACHINE_Z,
		.decimals = 2,
		.states = "idle, run, pause",
		.selector = { "off", "X", "Y", "Z", "speed", "feed", "spindle" },
		.draw = lcd_draw_hb,
		.line = lcd_line_hb,
	},
	{
		.name = "HB04",
		.layout = "hb04-18",
		.fields = FIELDS_HB,
		.group = POSITION, .first = WORK_X, .last = MACHINE_Z,
		.decimals = 4,
		.states = "idle, run, pause, inch",
		.selector = { "off", "X", "Y", "Z", "A", "feed", "spindle" },
		.draw = lcd_draw_hb,
		.line = lcd_line_hb,
	},
	{
		.name = "WHB04B",
		.layout = "whb04b",
		.fields = FIELDS_WHB04B,
		.group = ROWS, .first = ROW1, .last = ROW3,
		.decimals = 4,
		.selector = { "off", "X", "Y", "Z", "A", [7] = "B", "C" },
		.rotary = { "unknown", "2%", "5%", "10%", "30%", "60%", "100%", "Lead" },
		.draw = lcd_draw_whb04b,
		.line = lcd_line_whb04b,
	},
};

static const struct model unknown = {
	.layout = "none",
	.selector = { "off" },
	.draw = lcd_draw_unknown,
	.line = lcd_line_unknown,
};

const struct model *model_find(const char *name)
{
	for (size_t i = 0; i < ARRAY_SIZE(models); i++) {
		if (!strcmp(models[i].name, name))
			return &models[i];
	}
	return &unknown;
}

bool model_has(const struct model *model, enum field_index field)
{
	if (field < FIELDS)
		return model->fields & BIT(field);
	return model->fields && field == model->group;
}

const char *selector_name(const struct model *model, unsigned int selector)
{
	return selector < SELECTOR_POSITIONS ? model->selector[selector] ?: "?" : "?";
}

const char *rotary_name(const struct model *model, unsigned int rotary)
{
	return rotary < ROTARY_POSITIONS ? model->rotary[rotary] ?: "?" : "?";
}

bool model_has_rotary(const struct model *model)
{
	return model->rotary[0];
}
