// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl monitor: the picture on a terminal of 80 columns and 24 lines
 *
 *   title, layout | the LCD, and beside it selector, wheel, keys, counters | the last events
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"
#include "monitor.h"

#define EVENTS		10	/* lines of them */
#define COLUMNS		80

static struct screen {
	char event[EVENTS][COLUMNS];	/* a ring, the next one goes to .count % EVENTS */
	unsigned int count;
	long long wheel;		/* counts since the start */
	int detents;			/* of the last turn */
	char *shown;			/* the last picture */
} screen;

void screen_begin(void)
{
	fputs("\033[?25l\033[2J", stdout);
	fflush(stdout);
}

void screen_end(void)
{
	fputs("\033[?25h", stdout);
	fflush(stdout);
	free(screen.shown);
	screen.shown = NULL;
}

int screen_tell(const struct monitor *monitor, const struct event *event)
{
	char *line = screen.event[screen.count % EVENTS];
	FILE *stream;

	if (event->kind == EVENT_WHEEL) {
		screen.detents = event->value;
		screen.wheel += event->value;
	}
	if (event->kind == EVENT_DISPLAY)
		return CLI_OK;
	stream = fmemopen(line, COLUMNS, "w");
	if (!stream)
		return CLI_OK;
	/* truncated to the room */
	setvbuf(stream, NULL, _IOFBF, 1024);
	event_line(stream, monitor, event);
	fclose(stream);
	line[COLUMNS - 1] = '\0';
	screen.count++;
	return CLI_OK;
}

static const char *key_text(const struct monitor *monitor, unsigned int wanted)
{
	static char text[32];

	for (unsigned int scan = 1; scan <= LAYOUT_KEYS; scan++) {
		const char *caption = layout_caption(&monitor->layout, scan,
						     monitor->events.with_fn[scan]);

		if (!monitor->events.held[scan] || wanted--)
			continue;
		if (caption)
			return caption;
		snprintf(text, sizeof(text), "%02xh", scan);
		return text;
	}
	return "-";
}

/* The text beside a line of the LCD */
static void print_beside(FILE *stream, const struct monitor *monitor, unsigned int line)
{
	const struct model *model = monitor->pendant.model_row;
	const char *bold = cli_colour(CLI_BOLD), *plain = cli_colour(CLI_PLAIN);
	const long long *stat = monitor->stat;

	switch (line) {
	case 0:
		fprintf(stream, "  selector  %s%s%s", bold,
			selector_name(model, monitor->events.selector), plain);
		if (model_has_rotary(model))
			fprintf(stream, ", rotary %s%s%s", bold,
				rotary_name(model, monitor->events.rotary), plain);
		break;
	case 1:
		fprintf(stream, "  wheel     %s%+lld%s, last %+d", bold, screen.wheel, plain,
			screen.detents);
		break;
	case 2:
		fprintf(stream, "  keys      %s%s%s", bold, key_text(monitor, 0), plain);
		break;
	case 3:
		fprintf(stream, "            %s%s%s", bold, key_text(monitor, 1), plain);
		break;
	case 5:
		fprintf(stream, "  reports   %lld, %lld bad", stat[REPORTS], stat[BAD_REPORTS]);
		break;
	case 6:
		fprintf(stream, "  frames    %lld, %s%lld failed%s", stat[FRAMES_SENT],
			stat[FRAME_ERRORS] ? cli_colour(CLI_RED) : "", stat[FRAME_ERRORS],
			plain);
		break;
	}
}

static void print_lcd(FILE *stream, const struct monitor *monitor)
{
	const struct lcd_view view = {
		.model = monitor->pendant.model_row, .values = &monitor->values,
		.awake = monitor->awake, .selector = monitor->events.selector,
		.rotary = monitor->events.rotary,
	};
	struct lcd lcd;

	view.model->draw(&lcd, &view);
	for (unsigned int i = 0; i < LCD_LINES; i++) {
		fprintf(stream, "%s%s%s", cli_colour(monitor->awake ? CLI_CYAN : CLI_DIM),
			lcd.line[i], cli_colour(CLI_PLAIN));
		print_beside(stream, monitor, i);
		fputs("\033[K\n", stream);
	}
}

static void draw(FILE *stream, const struct monitor *monitor)
{
	unsigned int first = screen.count > EVENTS ? screen.count - EVENTS : 0;

	fprintf(stream, "\033[H%sXHC %s Pendant%s  %s  %s\033[K\n", cli_colour(CLI_BOLD),
		monitor->pendant.model, cli_colour(CLI_PLAIN), monitor->pendant.name,
		monitor->pendant.event);
	fprintf(stream, "%s, layout %s\033[K\n\033[K\n", monitor->pendant.phys,
		*monitor->layout.name ? monitor->layout.name : "none");
	print_lcd(stream, monitor);
	fputs("\033[K\n", stream);
	for (unsigned int i = first; i < first + EVENTS; i++)
		fprintf(stream, "%s\033[K\n", i < screen.count ? screen.event[i % EVENTS] : "");
	fprintf(stream, "%sCtrl-C ends%s\033[K\n", cli_colour(CLI_DIM),
		cli_colour(CLI_PLAIN));
}

void screen_look(struct monitor *monitor)
{
	char *picture = NULL;
	size_t size = 0;
	FILE *stream = open_memstream(&picture, &size);

	if (!stream)
		return;
	draw(stream, monitor);
	fclose(stream);
	if (screen.shown && !strcmp(screen.shown, picture)) {
		free(picture);
		return;
	}
	/* by one write: incomplete pictures flicker */
	fputs(picture, stdout);
	fflush(stdout);
	free(screen.shown);
	screen.shown = picture;
}
