// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl stream: send scans at a steady rate.
 */
#include <errno.h>
#include <json-c/json.h>
#include <libxy3.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "cli.h"
#include "forward.h"
#include "number.h"
#include "scans.h"
#include "shape.h"
#include "verbs.h"

#define SPEED 0.002		/* from one scan of a shape to the next, as in figure.py */
#define COUNT_MAX 1000000000UL
#define SPEED_MIN 0.001		/* half the field in this many seconds */
#define SPEED_MAX 1e6
#define DELAY_MAX 1e6		/* microseconds */
#define PIECE 1024		/* scans of a write: 10 ms at 100 000 frames/s */

struct settings {
	struct cli_common common;
	struct forward_settings forward;
	const char *source;
	double size;
	unsigned long points;
	unsigned long repeat;
	bool repeat_for_ever;
	bool raw;
	bool codes;
	bool gate;
	double gate_on_us;
	double gate_off_us;
	double jump_speed;	/* of half the field per second; 0: FILE has scans */
	double mark_speed;
	double jump_delay_us;
	double mark_delay_us;
};

enum {
	KEY_SIZE = 0x100, KEY_POINTS, KEY_REPEAT, KEY_RAW, KEY_CODES, KEY_GATE, KEY_GATE_ON,
	KEY_GATE_OFF, KEY_JUMP_SPEED, KEY_MARK_SPEED, KEY_JUMP_DELAY, KEY_MARK_DELAY
};

static const struct argp_option options[] = {
	{ "size", KEY_SIZE, "PART", 0, "Radius of a shape's circle, from 0 to 1 (0.9)", 0 },
	{ "points", KEY_POINTS, "NUMBER", 0, "Scans of a shape; fewer are faster and rougher", 0 },
	{ "repeat", KEY_REPEAT, "NUMBER", 0,
	  "Times to draw a shape; 0: until interrupted (1)", 0 },
	{ "codes", KEY_CODES, NULL, 0, "Numbers of FILE are codes, not -1 to 1", 1 },
	{ "raw", KEY_RAW, NULL, 0,
	  "FILE has codes of 32 bits, least significant byte first, one for each axis", 1 },
	{ "gate", KEY_GATE, NULL, 0, "Drive the laser's gate while a shape is drawn", 2 },
	{ "gate-on-delay", KEY_GATE_ON, "US", 0,
	  "The gate rises later by this number of microseconds; earlier when negative", 2 },
	{ "gate-off-delay", KEY_GATE_OFF, "US", 0, "The same for the falling edge", 2 },
	{ "jump-speed", KEY_JUMP_SPEED, "UNITS", 0,
	  "FILE has the vertices of a path: units per second (the field is 2 wide) to one whose "
	  "gate is 0", 3 },
	{ "mark-speed", KEY_MARK_SPEED, "UNITS", 0, "The same for a vertex whose gate is 1", 3 },
	{ "jump-delay", KEY_JUMP_DELAY, "US", 0,
	  "Wait this long after each jump, in microseconds", 3 },
	{ "mark-delay", KEY_MARK_DELAY, "US", 0,
	  "Wait this long after the last mark before a jump, in microseconds", 3 },
	{ 0 }
};

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct settings *settings = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[FORWARD_CHILD_COMMON] = &settings->common;
		state->child_inputs[FORWARD_CHILD_FORWARD] = &settings->forward;
		return 0;
	case KEY_SIZE:
		settings->size = option_real("--size", argument, 0, 1, state);
		return 0;
	case KEY_POINTS:
		settings->points = option_whole("--points", argument, 1, COUNT_MAX, state);
		return 0;
	case KEY_REPEAT:
		settings->repeat = option_whole("--repeat", argument, 0, COUNT_MAX, state);
		settings->repeat_for_ever = !settings->repeat;
		return 0;
	case KEY_RAW:
		settings->raw = true;
		return 0;
	case KEY_CODES:
		settings->codes = true;
		return 0;
	case KEY_GATE:
		settings->gate = true;
		return 0;
	case KEY_GATE_ON:
		settings->gate_on_us = option_real("--gate-on-delay", argument, -DELAY_MAX,
						   DELAY_MAX, state);
		return 0;
	case KEY_GATE_OFF:
		settings->gate_off_us = option_real("--gate-off-delay", argument, -DELAY_MAX,
						    DELAY_MAX, state);
		return 0;
	case KEY_JUMP_SPEED:
		settings->jump_speed = option_real("--jump-speed", argument, SPEED_MIN, SPEED_MAX,
						   state);
		return 0;
	case KEY_MARK_SPEED:
		settings->mark_speed = option_real("--mark-speed", argument, SPEED_MIN, SPEED_MAX,
						   state);
		return 0;
	case KEY_JUMP_DELAY:
		settings->jump_delay_us = option_real("--jump-delay", argument, 0, DELAY_MAX,
						      state);
		return 0;
	case KEY_MARK_DELAY:
		settings->mark_delay_us = option_real("--mark-delay", argument, 0, DELAY_MAX,
						      state);
		return 0;
	case ARGP_KEY_END:
		if (!settings->jump_speed != !settings->mark_speed)
			argp_error(state, "--jump-speed and --mark-speed require each other");
		if (!settings->jump_speed && (settings->jump_delay_us || settings->mark_delay_us))
			argp_error(state, "--jump-delay and --mark-delay require speeds");
		return 0;
	case ARGP_KEY_ARG:
		if (settings->source)
			argp_error(state, "only one FILE or shape is possible");
		settings->source = argument;
		return 0;
	case ARGP_KEY_NO_ARGS:
		argp_error(state, "missing FILE or shape");
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static const struct argp argp = {
	.options = options, .parser = parse, .children = forward_children,
	.args_doc = "{circle|square|grid|FILE}",
	.doc = "Stream a shape, or scans from a file, to a scanhead."
	       "\v"
	       "FILE, or standard input when it is -, has one scan on each line: numbers from -1 "
	       "to 1, X first. They are separated by blanks, by commas or by semicolons, and have a "
	       "decimal point. Each line has as many of them as the first; axes without a number "
	       "are in the middle. If the line map has a gate, its value, 1 or 0, follows those of "
	       "all axes. Empty lines and lines that begin with # are ignored. A regular file is "
	       "checked before anything is sent; from a pipe, everything before an invalid line is "
	       "sent."
	       "\n\nWith --jump-speed and --mark-speed the lines are vertices of a path, each with "
	       "its gate. A vertex with 1 is marked to, with the gate high all the way; a vertex "
	       "with 0 is jumped to. The first vertex is reached at once, with the gate low."
	       "\n\nThe stream ends when the last scan has been sent. When it is interrupted, it is "
	       "aborted: scans that have not been passed to the controller are dropped. The "
	       "mirrors stay where they are, with the gate low. At the end the program reports how many scans have been "
	       "sent, and how often it was late (underruns). None of this is an interlock for a laser.\n\n"
	       "  xy3ctl stream circle --rate 20000 --repeat 10\n"
	       "  xy3ctl stream scans.csv --gate-on-delay=-20\n"
	       "  xy3ctl stream letters.csv --jump-speed 500 --mark-speed 100 --jump-delay 200\n"
	       "  ./program | xy3ctl stream --codes -",
};

static double now(void)
{
	struct timespec time;

	clock_gettime(CLOCK_MONOTONIC, &time);
	return time.tv_sec + time.tv_nsec / 1e9;
}

/* ---- progress, on a terminal ---- */

struct progress {
	bool wanted;
	double total;		/* 0: not known */
	double next;		/* when to show it again */
};

static void progress_show(struct progress *progress, double done, unsigned long scans, long rate)
{
	static const char bar[] = "########################################";
	int width = sizeof(bar) - 1;

	if (!progress->wanted || now() < progress->next)
		return;
	progress->next = now() + 0.1;
	if (progress->total > 0)
		fprintf(stderr, "\r[%-*.*s] %3.0f %%  ", width,
			(int)(width * fmin(done / progress->total, 1)), bar,
			100 * fmin(done / progress->total, 1));
	else
		fputc('\r', stderr);
	fprintf(stderr, "%lu scans, %ld frames/s ", scans, rate);
}

static void progress_end(const struct progress *progress)
{
	if (progress->wanted)
		fprintf(stderr, "\r\033[K");
}

/* ---- the stream ---- */

struct result {
	unsigned long scans;
	long achieved;		/* the highest one in half a second; 0: unknown */
	double seconds;
};

/* Progress of the source, in the unit of its total */
static double done_of(const struct scans *scans)
{
	return scans->shape ? (double)scans->done : (double)ftell(scans->file);
}

/* Return an enum cli_status */
static int write_piece(struct forward *forward, const uint32_t *codes, size_t count,
		       struct result *result)
{
	size_t written;
	int status;

	for (; count && !cli_interrupted(); count -= written) {
		status = forward_write(forward, codes, count, &written);
		if (status)
			return status;
		codes += written * (forward_axes(forward) + forward_gate(forward));
		result->scans += written;
	}
	return CLI_OK;
}

/* The next scans, with the gate shifted; at the end those that are still delayed by it */
static long next_piece(struct scans *scans, struct xy3_gate *gate, size_t *rest, uint32_t *codes)
{
	long count = scans_next(scans, codes, PIECE);
	bool end = !count;

	if (!gate || count < 0)
		return count;
	if (end) {
		count = *rest < PIECE ? *rest : PIECE;
		*rest -= count;
	}
	for (long i = 0; i < count; i++, codes += scans->axes + 1)
		xy3_gate_next(gate, end ? NULL : codes, codes);
	return count;
}

static int pump(struct forward *forward, struct scans *scans, struct xy3_gate *gate,
		struct progress *progress, struct result *result)
{
	static uint32_t codes[PIECE * FORWARD_COLUMNS_MAX];
	size_t rest = gate ? xy3_gate_rest(gate) : 0;
	int status = CLI_OK;
	long count, rate;

	while (!status && !cli_interrupted()) {
		count = next_piece(scans, gate, &rest, codes);
		if (count <= 0)
			return count ? CLI_FAILURE : CLI_OK;
		status = write_piece(forward, codes, count, result);
		rate = forward_achieved(forward);
		if (rate > result->achieved)
			result->achieved = rate;
		progress_show(progress, done_of(scans), result->scans, rate);
	}
	return status;
}

static int report(const struct settings *settings, const struct forward *forward,
		  const struct result *result)
{
	long underruns = forward_underruns(forward);
	struct json_object *document;

	if (settings->common.json) {
		document = cli_json_new("stream");
		cli_json_text(document, "head", forward_name(forward));
		cli_json_number(document, "scans", result->scans);
		cli_json_seconds(document, "seconds", result->seconds);
		cli_json_number(document, "rate", forward_rate(forward));
		json_object_object_add(document, "achieved", result->achieved ?
				       json_object_new_int64(result->achieved) : NULL);
		json_object_object_add(document, "underruns", underruns < 0 ? NULL :
				       json_object_new_int64(underruns));
		return cli_json_print(document);
	}
	printf("%lu scans in %.2f s", result->scans, result->seconds);
	if (result->achieved)
		printf(", %ld of %ld frames/s", result->achieved, forward_rate(forward));
	if (underruns >= 0)
		printf(", %ld underruns", underruns);
	putchar('\n');
	return CLI_OK;
}

static int stream(const struct settings *settings, struct forward *forward, struct scans *scans,
		  struct xy3_gate *gate, struct progress *progress)
{
	struct result result = { 0 };
	double start;
	int status, end;
	bool aborted;

	status = forward_start(forward);
	if (status)
		return status;
	cli_catch_signals();
	start = now();
	status = pump(forward, scans, gate, progress, &result);
	/* after a stop the driver sends the rest; if we are killed in the meantime, it drops it */
	cli_release_signals();
	aborted = cli_interrupted();
	end = status;
	if (status != CLI_NO_DEVICE) {
		/* also after an error, so that nothing continues */
		end = aborted ? forward_abort(forward) : CLI_OK;
		end = forward_stop(forward) ?: end;
	}
	if (aborted)
		result.scans = forward_sent(forward, result.scans);
	result.seconds = now() - start;
	progress_end(progress);
	if (end)
		return end;
	report(settings, forward, &result);
	return status;
}

/* ---- the source ---- */

static int open_file(const struct settings *settings, struct scans *scans,
		     struct progress *progress)
{
	struct stat about;

	scans->name = settings->source;
	scans->raw = settings->raw;
	scans->codes = settings->codes;
	scans->file = strcmp(settings->source, "-") ? fopen(settings->source, "re") : stdin;
	if (!scans->file)
		return cli_errno(errno, "%s", settings->source);
	if (!fstat(fileno(scans->file), &about) && S_ISREG(about.st_mode)) {
		scans->is_regular = true;
		progress->total = about.st_size;
	}
	return CLI_OK;
}

static int open_shape(const struct settings *settings, struct scans *scans,
		      struct progress *progress)
{
	if (settings->raw || settings->codes)
		return cli_usage("--raw and --codes require a FILE");
	if (settings->jump_speed)
		return cli_usage("--jump-speed and --mark-speed require a FILE");
	scans->size = settings->size;
	scans->points = settings->points ?:
			ceil(scans->shape->length * settings->size / SPEED) ?: 1;
	/* and the start once more */
	scans->left = settings->repeat_for_ever ? ULONG_MAX : settings->repeat * scans->points + 1;
	progress->total = settings->repeat_for_ever ? 0 : scans->left;
	return CLI_OK;
}

/* Return an enum cli_status */
static int make_gate(const struct settings *settings, const struct forward *forward,
		     struct xy3_gate **gate)
{
	double each = 1e6 / forward_rate(forward);
	int error;

	if (!settings->gate && !settings->gate_on_us && !settings->gate_off_us)
		return CLI_OK;
	if (!forward_gate(forward))
		return cli_usage("%s has no gate in its line map", forward_name(forward));
	error = xy3_gate_new(gate, forward_axes(forward), lrint(settings->gate_on_us / each),
			     lrint(settings->gate_off_us / each));
	return error ? cli_errno(error, "gate") : CLI_OK;
}

/* Return an enum cli_status */
static int make_path(const struct settings *settings, const struct forward *forward,
		     struct xy3_path **path)
{
	double rate = forward_rate(forward), unit = forward_top(forward) / 2.0;
	const struct xy3_path_settings path_settings = {
		.jump_speed = settings->jump_speed * unit / rate,
		.mark_speed = settings->mark_speed * unit / rate,
		.jump_delay = lrint(settings->jump_delay_us * rate / 1e6),
		.mark_delay = lrint(settings->mark_delay_us * rate / 1e6),
	};
	int error;

	if (!settings->jump_speed)
		return CLI_OK;
	if (!forward_gate(forward))
		return cli_usage("%s has no gate in its line map", forward_name(forward));
	error = xy3_path_new(path, forward_axes(forward), &path_settings);
	return error ? cli_errno(error, "path") : CLI_OK;
}

int stream_verb(int argc, char **argv)
{
	struct settings settings = { .size = 0.9, .repeat = 1 };
	struct progress progress = { 0 };
	struct scans scans = { 0 };
	struct xy3_gate *gate = NULL;
	struct forward *forward;
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &settings);
	progress.wanted = cli_is_terminal(STDERR_FILENO) && !settings.common.json;
	scans.shape = shape_find(settings.source);
	status = scans.shape ? open_shape(&settings, &scans, &progress) :
			       open_file(&settings, &scans, &progress);
	if (status)
		return status;
	status = forward_open(&forward, &settings.forward, settings.common.device);
	if (status)
		return status;
	scans.axes = forward_axes(forward);
	scans.top = forward_top(forward);
	for (unsigned int axis = 0; axis < XY3_AXES; axis++)
		scans.index_of[axis] = -1;
	for (unsigned int i = 0; i < scans.axes; i++)
		scans.index_of[forward_axis(forward, i)] = i;
	scans.gate = forward_gate(forward);
	scans.shape_gate = settings.gate;
	status = scans_check(&scans);
	if (!status)
		status = forward_apply(forward);
	if (!status)
		status = make_gate(&settings, forward, &gate);
	if (!status)
		status = make_path(&settings, forward, &scans.path);
	if (!status)
		status = stream(&settings, forward, &scans, gate, &progress);
	xy3_gate_free(gate);
	xy3_path_free(scans.path);
	forward_close(forward);
	return status;
}
