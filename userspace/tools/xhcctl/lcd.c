// SPDX-License-Identifier: GPL-2.0-only
/*
 * The display as a picture. See lcd.h.
 */
#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "lcd.h"

const char *selector_name(const char *model, unsigned int selector)
{
	static const char *const names[SELECTOR_COUNT] = {
		"off", "X", "Y", "Z", "A", "feed", "spindle"
	};

	if (selector == SELECTOR_A && !strcmp(model, "HB03"))
		return "speed";
	return selector < SELECTOR_COUNT ? names[selector] : "?";
}

unsigned int lcd_decimals(const char *model)
{
	return strcmp(model, "HB03") ? 4 : 2;
}

static void print_to(char *to, size_t size, const char *format, ...)
	__attribute__((format(printf, 3, 4)));

/* What has no room is cut: the values come from a file, and could be anything */
static void print_to(char *to, size_t size, const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	vsnprintf(to, size, format, arguments);
	va_end(arguments);
}

/* With all decimals: the driver leaves zeros at the end away */
static const char *coordinate(char *to, size_t size, const char *text, unsigned int decimals)
{
	size_t whole = strcspn(text, "."), fraction = strlen(text + whole);

	if (fraction)
		fraction--;
	if (fraction > decimals)
		fraction = decimals;
	print_to(to, size, "%.*s.%.*s%.*s", (int)whole, text, (int)fraction,
		 text[whole] ? text + whole + 1 : "", (int)(decimals - fraction), "0000");
	return to;
}

/* run+pause -> RUN PAUSE */
static void state_words(char *to, size_t size, const char *state)
{
	print_to(to, size, "%s", state);
	for (; *to; to++)
		*to = *to == '+' ? ' ' : toupper((unsigned char)*to);
}

/* The day that the driver sends when it is left to it */
static int day_of(const char *text)
{
	time_t now = time(NULL);
	struct tm tm;

	return isdigit((unsigned char)*text) ? atoi(text) : gmtime_r(&now, &tm)->tm_mday;
}

static char mark(unsigned int selector, unsigned int row)
{
	return selector == row ? '>' : ' ';
}

static void set_line(struct lcd *lcd, unsigned int number, const char *text)
{
	print_to(lcd->line[number], sizeof(lcd->line[number]), "| %-*.*s |", LCD_WIDTH - 4,
		 LCD_WIDTH - 4, text);
}

static void draw_frame(struct lcd *lcd, const char *left, const char *right)
{
	static const char dashes[] = "----------------------------------------------";
	int rest = LCD_WIDTH - 8 - strlen(left) - strlen(right);

	print_to(lcd->line[0], sizeof(lcd->line[0]), "+- %s %.*s %s -+", left,
		 rest > 0 ? rest : 0, dashes, right);
	print_to(lcd->line[LCD_LINES - 1], sizeof(lcd->line[0]), "+%.*s+", LCD_WIDTH - 2, dashes);
}

void lcd_draw(struct lcd *lcd, const char *model, const struct values *values, bool awake,
	      unsigned int selector)
{
	unsigned int decimals = lcd_decimals(model);
	char text[256], left[32], right[32], step[FIELD_TEXT + 1];

	print_to(left, sizeof(left), "%s%s", model, awake ? "" : " asleep");
	print_to(right, sizeof(right), "day %d", day_of(values->text[DAY]));
	draw_frame(lcd, left, right);

	state_words(left, sizeof(left), values->text[STATE]);
	print_to(step, sizeof(step), "x%s", values->text[STEP]);
	print_to(text, sizeof(text), "%-16s icon %-2s %10s", left, values->text[ICON], step);
	set_line(lcd, 1, text);
	print_to(text, sizeof(text), "      %12s %16s", "WORK", "MACHINE");
	set_line(lcd, 2, text);
	for (unsigned int axis = 0; axis < 3; axis++) {
		print_to(text, sizeof(text), "%c%c  %14s %16s", mark(selector, SELECTOR_X + axis),
			 'X' + axis,
			 coordinate(left, sizeof(left), values->text[WORK_X + axis], decimals),
			 coordinate(right, sizeof(right), values->text[MACHINE_X + axis],
				    decimals));
		set_line(lcd, 3 + axis, text);
	}
	print_to(text, sizeof(text), "%cF %6s %5s%%   %cS %6s %5s%%",
		 mark(selector, SELECTOR_FEED), values->text[FEEDRATE],
		 values->text[FEEDRATE_OVERRIDE], mark(selector, SELECTOR_SPINDLE),
		 values->text[SPINDLE_SPEED], values->text[SPINDLE_OVERRIDE]);
	set_line(lcd, 6, text);
}
