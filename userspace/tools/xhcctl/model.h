/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * All differences of the models, for all verbs: one row per model
 */
#ifndef MODEL_H
#define MODEL_H

#include <stdint.h>

#include "fields.h"
#include "lcd.h"

/* Positions of the selector, as in ABS_MISC: 0 is off */
#define SELECTOR_POSITIONS	9
/* Positions of the second rotary, as in ABS_THROTTLE: 0 is unknown */
#define ROTARY_POSITIONS	8

struct model {
	const char *name;	/* as in the attribute of the driver; NULL: of a later driver */
	const char *layout;	/* whose captions are shown if none was chosen */
	uint32_t fields;	/* BIT() of its fields; without the group */
	enum field_index group, first, last;	/* the coordinates, and all of them as one */
	unsigned int decimals;	/* that its display shows */
	const char *states;	/* words of the field state */
	const char *selector[SELECTOR_POSITIONS];
	const char *rotary[ROTARY_POSITIONS];	/* all NULL: it has no second rotary */
	void (*draw)(struct lcd *lcd, const struct lcd_view *view);
	void (*line)(FILE *stream, const struct values *values);
};

#define BIT(field)	(UINT32_C(1) << (field))

/* Never NULL: an unknown name has the row without fields. */
const struct model *model_find(const char *name);

bool model_has(const struct model *model, enum field_index field);

/* Their names; "?" for a position that the model does not have */
const char *selector_name(const struct model *model, unsigned int selector);
const char *rotary_name(const struct model *model, unsigned int rotary);
bool model_has_rotary(const struct model *model);

#endif /* MODEL_H */
