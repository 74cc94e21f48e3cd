/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The display as a picture of text, the same that xhc-sim draws from received frames
 */
#ifndef LCD_H
#define LCD_H

#include <stdbool.h>
#include <stdio.h>

#define LCD_WIDTH	46
#define LCD_LINES	8

struct model;
struct values;

struct lcd {
	char line[LCD_LINES][LCD_WIDTH + 1];
};

/* The data for a picture */
struct lcd_view {
	const struct model *model;
	const struct values *values;
	bool awake;
	unsigned int selector, rotary;
};

/* Pictures, by model */
void lcd_draw_hb(struct lcd *lcd, const struct lcd_view *view);
void lcd_draw_whb04b(struct lcd *lcd, const struct lcd_view *view);
void lcd_draw_unknown(struct lcd *lcd, const struct lcd_view *view);

/* The same in one line of text, without newline */
void lcd_line_hb(FILE *stream, const struct values *values);
void lcd_line_whb04b(FILE *stream, const struct values *values);
void lcd_line_unknown(FILE *stream, const struct values *values);

#endif /* LCD_H */
