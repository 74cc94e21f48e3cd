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

#include "fields.h"
#include "lcd.h"
#include "model.h"

/* Positions of the selector that a picture marks */
enum { SELECTOR_X = 1, SELECTOR_A = 4, SELECTOR_FEED, SELECTOR_SPINDLE, SELECTOR_B, SELECTOR_C };
/* Of the second rotary */
enum { ROTARY_LEAD = 7 };

static void print_to(char *to, size_t size, const char *format, ...)
	__attribute__((format(printf, 3, 4)));

/* Text that does not fit is truncated: the values are read from files, and could be anything */
static void print_to(char *to, size_t size, const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	vsnprintf(to, size, format, arguments);
	va_end(arguments);
}

/* With all decimals: the driver omits trailing zeros */
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
static void upper_case(char *to, size_t size, const char *words)
{
	print_to(to, size, "%s", words);
	for (; *to; to++)
		*to = *to == '+' ? ' ' : toupper((unsigned char)*to);
}

/* The day that the driver sends by default */
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

static void draw_frame(struct lcd *lcd, const struct lcd_view *view, const char *right)
{
	static const char dashes[] = "----------------------------------------------";
	char left[32];
	int rest;

	print_to(left, sizeof(left), "%s%s", view->model->name ?: "?",
		 view->awake ? "" : " asleep");
	rest = LCD_WIDTH - 8 - strlen(left) - strlen(right);
	print_to(lcd->line[0], sizeof(lcd->line[0]), "+- %s %.*s %s -+", left,
		 rest > 0 ? rest : 0, dashes, right);
	print_to(lcd->line[LCD_LINES - 1], sizeof(lcd->line[0]), "+%.*s+", LCD_WIDTH - 2, dashes);
}

void lcd_draw_hb(struct lcd *lcd, const struct lcd_view *view)
{
	const char (*value)[FIELD_TEXT] = view->values->text;
	unsigned int decimals = view->model->decimals;
	char text[256], left[32], right[32], step[FIELD_TEXT + 1];

	print_to(right, sizeof(right), "day %d", day_of(value[DAY]));
	draw_frame(lcd, view, right);

	upper_case(left, sizeof(left), value[STATE]);
	print_to(step, sizeof(step), "x%s", value[STEP]);
	print_to(text, sizeof(text), "%-16s icon %-2s %10s", left, value[ICON], step);
	set_line(lcd, 1, text);
	print_to(text, sizeof(text), "      %12s %16s", "WORK", "MACHINE");
	set_line(lcd, 2, text);
	for (unsigned int axis = 0; axis < 3; axis++) {
		print_to(text, sizeof(text), "%c%c  %14s %16s",
			 mark(view->selector, SELECTOR_X + axis), 'X' + axis,
			 coordinate(left, sizeof(left), value[WORK_X + axis], decimals),
			 coordinate(right, sizeof(right), value[MACHINE_X + axis], decimals));
		set_line(lcd, 3 + axis, text);
	}
	print_to(text, sizeof(text), "%cF %6s %5s%%   %cS %6s %5s%%",
		 mark(view->selector, SELECTOR_FEED), value[FEEDRATE], value[FEEDRATE_OVERRIDE],
		 mark(view->selector, SELECTOR_SPINDLE), value[SPINDLE_SPEED],
		 value[SPINDLE_OVERRIDE]);
	set_line(lcd, 6, text);
}

void lcd_line_hb(FILE *stream, const struct values *values)
{
	const char (*text)[FIELD_TEXT] = values->text;

	fprintf(stream, "work %s %s %s machine %s %s %s F %s %s%% S %s %s%% x%s icon %s %s",
		text[WORK_X], text[WORK_Y], text[WORK_Z], text[MACHINE_X], text[MACHINE_Y],
		text[MACHINE_Z], text[FEEDRATE], text[FEEDRATE_OVERRIDE], text[SPINDLE_SPEED],
		text[SPINDLE_OVERRIDE], text[STEP], text[ICON], text[STATE]);
}

/* The unit prints the meaning of its second rotary in the current mode */
static void rotary_text(char *to, size_t size, const struct lcd_view *view)
{
	static const char *const steps[ROTARY_POSITIONS] = {
		"?", "0.001", "0.01", "0.1", "1.0", "5.0", "10.0", "LEAD"
	};

	if (!strcmp(view->values->text[MODE], "step") && view->rotary < ROTARY_POSITIONS)
		print_to(to, size, "%s", steps[view->rotary]);
	else if (!view->rotary)
		print_to(to, size, "?");
	else
		upper_case(to, size, rotary_name(view->model, view->rotary));
}

/* The unit names the rows, by its selector */
static char row_name(unsigned int selector, unsigned int row)
{
	bool second = selector == SELECTOR_A || selector == SELECTOR_B || selector == SELECTOR_C;

	return (second ? 'A' : 'X') + row;
}

static bool row_is_selected(unsigned int selector, unsigned int row)
{
	if (selector == SELECTOR_A)
		return !row;
	if (selector == SELECTOR_B || selector == SELECTOR_C)
		return selector - SELECTOR_B + 1 == row;
	return selector == SELECTOR_X + row;
}

void lcd_draw_whb04b(struct lcd *lcd, const struct lcd_view *view)
{
	const char (*value)[FIELD_TEXT] = view->values->text;
	char text[256], left[32], right[32];
	bool work = !strcmp(value[COORDINATES], "work"), reset = !strcmp(value[RESET], "1");

	draw_frame(lcd, view, "seed FE");	/* the only one that the driver sends */

	upper_case(left, sizeof(left), value[MODE]);
	rotary_text(right, sizeof(right), view);
	print_to(text, sizeof(text), "%-12s %12s %16s", left, right, reset ? "RESET" : "");
	set_line(lcd, 1, text);
	set_line(lcd, 2, "");
	for (unsigned int row = 0; row < 3; row++) {
		print_to(text, sizeof(text), "%c%c%c %14s",
			 row_is_selected(view->selector, row) ? '>' : ' ',
			 row_name(view->selector, row), work ? '1' : ' ',
			 coordinate(left, sizeof(left), value[ROW1 + row], view->model->decimals));
		set_line(lcd, 3 + row, text);
	}
	print_to(text, sizeof(text), " F %5s%%   S %5s%%", value[FEEDRATE_OVERRIDE],
		 value[SPINDLE_OVERRIDE]);
	set_line(lcd, 6, text);
}

void lcd_line_whb04b(FILE *stream, const struct values *values)
{
	const char (*text)[FIELD_TEXT] = values->text;

	fprintf(stream, "rows %s %s %s %s F %s%% S %s%% %s%s", text[ROW1], text[ROW2], text[ROW3],
		text[COORDINATES], text[FEEDRATE_OVERRIDE], text[SPINDLE_OVERRIDE], text[MODE],
		strcmp(text[RESET], "1") ? "" : " RESET");
}

/* A model of a later driver: its display is unknown */
void lcd_draw_unknown(struct lcd *lcd, const struct lcd_view *view)
{
	draw_frame(lcd, view, "no picture");
	for (unsigned int number = 1; number < LCD_LINES - 1; number++)
		set_line(lcd, number, "");
}

void lcd_line_unknown(FILE *stream, const struct values *values)
{
	(void)values;
	fputc('?', stream);
}
