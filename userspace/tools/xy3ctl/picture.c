// SPDX-License-Identifier: GPL-2.0-only
/*
 * The telemetry of a head as a picture. See telemetry.h.
 *
 * Components are the head and its processor, and four parts of each axis, shown as a table.
 */
#include <libxy3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "telemetry.h"

#define KINDS ((XY3_COMPONENTS - XY3_DAC_X) / XY3_AXES)

const char *or_dash(const char *value)
{
	return value[0] ? value : "-";
}

static int print_title(const struct head *head, const struct telemetry *telemetry)
{
	const char *rate = telemetry_get(telemetry, "rate");
	bool in_sync = atoi(telemetry_get(telemetry, "in_sync"));

	printf("%s%s%s  %.20s %.20s  firmware %.12s  serial %.12s\n", cli_colour(CLI_BOLD),
	       head->name, cli_colour(CLI_PLAIN), or_dash(telemetry_get(telemetry, "vendor")),
	       or_dash(telemetry_get(telemetry, "model")),
	       or_dash(telemetry_get(telemetry, "firmware")),
	       or_dash(telemetry_get(telemetry, "serial")));
	if (rate[0])
		printf("%s%s%s at %s bit/s", cli_colour(in_sync ? CLI_GREEN : CLI_YELLOW),
		       in_sync ? "in sync" : "no sync", cli_colour(CLI_PLAIN), rate);
	else
		printf("no backchannel");
	if (head->back[0])
		printf("  back %.20s", head->back);
	if (head->forward[0])
		printf("  forward %.12s, %s", head->forward, head->iio);
	putchar('\n');
	return 2;
}

/* The value in red if the component has an error */
static void print_cell(const struct telemetry *telemetry, const char *what, const char *component)
{
	const char *error = telemetry_get(telemetry, "errors/%s", component);
	bool bad = error[0] && strcmp(error, "none");

	printf("%s%10s%s", bad ? cli_colour(CLI_RED) : "",
	       or_dash(telemetry_get(telemetry, "%s/%s", what, component)),
	       bad ? cli_colour(CLI_PLAIN) : "");
}

static int print_table(const struct telemetry *telemetry, const char *what, const char *title)
{
	printf("\n%s%-9s", cli_colour(CLI_DIM), title);
	for (unsigned int axis = 0; axis < XY3_AXES; axis++)
		printf("%10s", xy3_axis_name(axis));
	printf("%10s%10s%s\n", "head", "dsp", cli_colour(CLI_PLAIN));
	for (unsigned int kind = 0; kind < KINDS; kind++) {
		unsigned int first = XY3_DAC_X + kind * XY3_AXES;
		const char *name = xy3_component_name(first);

		printf("%-9.*s", (int)strcspn(name, "_"), name);
		for (unsigned int axis = 0; axis < XY3_AXES; axis++)
			print_cell(telemetry, what, xy3_component_name(first + axis));
		if (!kind) {
			print_cell(telemetry, what, xy3_component_name(XY3_HEAD));
			print_cell(telemetry, what, xy3_component_name(XY3_DSP));
		}
		putchar('\n');
	}
	return 2 + KINDS;
}

static int print_frame_errors(const struct telemetry *telemetry)
{
	/* the name is wider than those of the table above by 3 */
	printf("\nframe errors");
	for (unsigned int axis = 0; axis < XY3_AXES; axis++) {
		const char *errors = telemetry_get(telemetry, "frame_errors/%s",
						   xy3_axis_name(axis));

		printf("%*s", axis ? 10 : 7, or_dash(errors));
	}
	putchar('\n');
	return 2;
}

/* Errors that are not "none", in two columns; more than four lines are replaced by dots */
static int print_errors(const struct telemetry *telemetry)
{
	unsigned int known = 0, bad = 0;

	for (unsigned int i = 0; i < XY3_COMPONENTS; i++) {
		const char *name = xy3_component_name(i);
		const char *error = telemetry_get(telemetry, "errors/%s", name);

		known += error[0] != '\0';
		if (!error[0] || !strcmp(error, "none"))
			continue;
		if (bad % 2 == 0)
			printf("%s%-9s", bad ? "\n" : "", bad ? "" : "errors");
		if (bad == 8) {
			printf("...");
			bad += 2;
			break;
		}
		printf("  %s%-8s %-22s%s", cli_colour(CLI_RED), name, error, cli_colour(CLI_PLAIN));
		bad++;
	}
	if (!bad)
		printf("%-9s  %s", "errors", known ? "none" : "-");
	putchar('\n');
	return bad ? (int)(bad + 1) / 2 : 1;
}

int telemetry_print(const struct head *head, const struct telemetry *telemetry)
{
	int lines = print_title(head, telemetry);

	lines += print_table(telemetry, "temperature", "degrees C");
	lines += print_table(telemetry, "hours", "hours");
	lines += print_frame_errors(telemetry);
	return lines + print_errors(telemetry);
}
