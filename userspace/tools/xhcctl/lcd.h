/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The display as a picture of text, the same that xhc-sim draws from what it has received
 */
#ifndef LCD_H
#define LCD_H

#include "fields.h"

#define LCD_WIDTH	46
#define LCD_LINES	8

struct lcd {
	char line[LCD_LINES][LCD_WIDTH + 1];
};

/* Positions of the selector, as ABS_MISC has them */
enum selector { OFF, SELECTOR_X, SELECTOR_Y, SELECTOR_Z, SELECTOR_A, SELECTOR_FEED,
		SELECTOR_SPINDLE, SELECTOR_COUNT };

/* Its name; HB03 has the processing speed where HB04 has axis A */
const char *selector_name(const char *model, unsigned int selector);

/* Decimals that the model shows */
unsigned int lcd_decimals(const char *model);

void lcd_draw(struct lcd *lcd, const char *model, const struct values *values, bool awake,
	      unsigned int selector);

#endif /* LCD_H */
