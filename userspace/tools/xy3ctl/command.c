// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl command: send a command to the head. Commands: <linux/xy3.h>.
 */
#include <errno.h>
#include <json-c/json.h>
#include <libxy3.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "forward.h"
#include "head.h"
#include "number.h"
#include "verbs.h"

struct settings {
	struct cli_common common;
	struct forward_settings forward;
	int count;
	const char *words[3];
};

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct settings *settings = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[FORWARD_CHILD_COMMON] = &settings->common;
		state->child_inputs[FORWARD_CHILD_FORWARD] = &settings->forward;
		return 0;
	case ARGP_KEY_ARG:
		if (settings->count == 3)
			argp_error(state, "too many arguments");
		settings->words[settings->count++] = argument;
		return 0;
	case ARGP_KEY_NO_ARGS:
		argp_error(state, "missing command");
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static const struct argp argp = {
	.parser = parse, .children = forward_children,
	.args_doc = "autocalib {on|off} [AXES]\ntemp-comp {on|off} [AXES]\ncalibrate [AXES]\n"
		    "reference [AXES]\nrate {57600|115200|230400|460800|921600}",
	.doc = "Send a command to a scanhead."
	       "\v"
	       "autocalib: switch automatic calibration on or off. temp-comp: switch temperature "
	       "compensation on or off. calibrate: calibrate once. reference: perform a reference "
	       "run. AXES are letters out of xyzuw, by default all. A head that does not support a "
	       "command ignores it. rate: set the bit rate of the backchannel, at the head and at "
	       "the UART; if the head is not received at the new rate within 3 seconds, both "
	       "return to the old rate, and the command fails. Without a forward channel only the "
	       "UART is set, with --spidev only the head.\n\n"
	       "  xy3ctl command autocalib on xy\n"
	       "  xy3ctl command rate 921600",
};

/* ---- the table of commands ---- */

enum kind { SWITCHED, AXES, RATE };

static const struct command {
	const char *name;	/* here */
	const char *attribute;	/* in the folder of the head */
	enum kind kind;
	uint32_t on, off;
} commands[] = {
	{ "autocalib", "autocalib", SWITCHED,
	  XY3_COMMAND_AUTOCALIB_ON_AXES, XY3_COMMAND_AUTOCALIB_OFF_AXES },
	{ "temp-comp", "temp_comp", SWITCHED,
	  XY3_COMMAND_TEMP_COMP_ON_AXES, XY3_COMMAND_TEMP_COMP_OFF_AXES },
	{ "calibrate", "calibrate", AXES, XY3_COMMAND_CALIBRATE_AXES, 0 },
	{ "reference", "reference", AXES, XY3_COMMAND_REFERENCE_AXES, 0 },
	{ "rate", "rate", RATE, 0, 0 },
};

static const struct command *find(const char *name)
{
	for (size_t i = 0; i < ARRAY_SIZE(commands); i++) {
		if (!strcmp(commands[i].name, name))
			return &commands[i];
	}
	return NULL;
}

/* The 20 bits of a command. Return an enum cli_status. */
static int code_of(const struct command *command, const char *argument, uint32_t *code)
{
	unsigned long rate;
	uint32_t axes = 0;
	bool on = true;
	int error = 0;

	switch (command->kind) {
	case SWITCHED:
		error = xy3_parse_switch(argument, &on, &axes);
		break;
	case AXES:
		error = xy3_parse_axes(argument, &axes);
		break;
	case RATE:
		error = number_whole(argument, 0, UINT_MAX, &rate);
		if (!error)
			error = xy3_rate_command(rate);
		*code = error;
		return error < 0 ? cli_usage("a head has no rate '%s'", argument) : CLI_OK;
	}
	if (error && command->kind == SWITCHED)
		return cli_usage("%s: '%s' is not on or off, then a list of axes (letters out of "
				 "xyzuw)", command->name, argument);
	if (error)
		return cli_usage("%s: '%s' is not a list of axes (letters out of xyzuw)",
				 command->name, argument);
	*code = (on ? command->on : command->off) | axes;
	return CLI_OK;
}

static int failed(const struct head *head, const struct command *command, const char *argument,
		  int error)
{
	switch (error) {
	case -ENOENT:
		return cli_no_device("%s has gone", head->name);
	case -ENODEV:
		return cli_error("%s has no %s", head->name,
				 command->kind == RATE ? "backchannel" : "forward channel");
	case -EACCES:
		return cli_error("%s: permission denied: join the group dialout",
				 head->name);
	case -EINVAL:
		return cli_error("%s: the UART does not support %s bit/s", head->name, argument);
	case -ETIMEDOUT:
		return cli_error("%s: no sync at %s bit/s; the old rate was restored",
				 head->name, argument);
	}
	return cli_errno(error, "%s: %s", head->name, command->name);
}

/* Two words as one: "on" and "xy". No word means all axes: sysfs accepts no empty text. */
static void join(char *text, size_t size, const struct settings *settings)
{
	if (settings->count == 1)
		snprintf(text, size, "all");
	else
		snprintf(text, size, "%s%s%s", settings->words[1],
			 settings->count > 2 ? " " : "",
			 settings->count > 2 ? settings->words[2] : "");
}

static int by_head(const struct settings *settings, const struct command *command,
		   const char *argument, const char **name)
{
	static struct head head;
	int status, error;

	status = head_find(&head, settings->common.device);
	if (status)
		return status;
	*name = head.name;
	if (command->kind == RATE && head.back[0] && !head.forward[0])
		cli_error("%s has no forward channel: only its UART is set", head.name);
	error = head_write(&head, command->attribute, argument);
	return error ? failed(&head, command, argument, error) : CLI_OK;
}

static int by_spidev(const struct settings *settings, uint32_t code, const char **name)
{
	struct forward *forward;
	int status;

	status = forward_open(&forward, &settings->forward, NULL);
	if (status)
		return status;
	*name = settings->forward.spidev;
	status = forward_command(forward, code);
	forward_close(forward);
	return status;
}

int command_verb(int argc, char **argv)
{
	struct settings settings = { 0 };
	const struct command *command;
	struct json_object *document;
	char argument[64];
	const char *name = NULL;
	uint32_t code = 0;
	int status;

	argp_parse(&argp, argc, argv, 0, NULL, &settings);
	command = find(settings.words[0]);
	if (!command)
		return cli_usage("unknown command '%s'", settings.words[0]);
	if (settings.count == 1 && command->kind != AXES)
		return cli_usage("%s: missing %s", command->name,
				 command->kind == RATE ? "rate" : "on or off");
	join(argument, sizeof(argument), &settings);
	status = code_of(command, argument, &code);
	if (status)
		return status;
	status = settings.forward.spidev ? by_spidev(&settings, code, &name) :
					   by_head(&settings, command, argument, &name);
	if (status || !settings.common.json)
		return status;
	document = cli_json_new("command");
	cli_json_text(document, "head", name);
	cli_json_text(document, "command", command->name);
	cli_json_text(document, "argument", argument);
	cli_json_number(document, "code", code);
	return cli_json_print(document);
}
