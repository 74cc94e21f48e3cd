// SPDX-License-Identifier: GPL-2.0-only
/*
 * The command line: verbs, common options, messages. See cli.h.
 */
#include <errno.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "sysfs.h"

#ifndef VERSION
#error "VERSION comes from the Makefile"
#endif

static const struct cli_tool *cli_tool;
static bool cli_json;		/* --json was given */
static char *last_message;	/* since the last document */

/* ---- options of all verbs ---- */

static const struct argp_option common_options[] = {
	{ "device", 'd', "DEVICE", 0, "Device to use, by a name shown by list", 10 },
	{ "json", 'j', NULL, 0, "Print JSON", 10 },
	{ NULL, 'h', NULL, OPTION_HIDDEN, NULL, 0 },	/* that of argp is -? */
	{ 0 }
};

static error_t parse_common(int key, char *argument, struct argp_state *state)
{
	struct cli_common *common = state->input;

	switch (key) {
	case 'd':
		common->device = argument;
		return 0;
	case 'j':
		common->json = true;
		cli_json = true;
		return 0;
	case 'h':
		argp_state_help(state, state->out_stream, ARGP_HELP_STD_HELP);
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

const struct argp cli_common_argp = { .options = common_options, .parser = parse_common };

const struct argp_child cli_children[] = {
	{ &cli_common_argp, 0, NULL, 0 },
	{ 0 }
};

static error_t parse_only_common(int key, char *argument, struct argp_state *state)
{
	(void)argument;
	if (key == ARGP_KEY_INIT) {
		state->child_inputs[0] = state->input;
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

struct cli_common cli_parse_common(const char *text, int argc, char **argv)
{
	const struct argp argp = {
		.parser = parse_only_common, .doc = text, .children = cli_children,
	};
	struct cli_common common = { 0 };

	argp_parse(&argp, argc, argv, 0, NULL, &common);
	return common;
}

/* ---- the tool itself ---- */

struct choice {
	int verb;	/* index in argv, 0 if there is none */
};

static void print_version(FILE *stream, struct argp_state *state)
{
	char version[64];

	(void)state;
	fprintf(stream, "%s %s\n", cli_tool->name, VERSION);
	for (const char *const *module = cli_tool->modules; *module; module++) {
		if (sysfs_read(version, sizeof(version), "/sys/module/%s/version", *module) < 0)
			snprintf(version, sizeof(version), "not loaded");
		fprintf(stream, "driver %s: %s\n", *module, version);
	}
}

static error_t parse_tool(int key, char *argument, struct argp_state *state)
{
	struct choice *choice = state->input;

	(void)argument;
	switch (key) {
	case 'h':
		argp_state_help(state, state->out_stream, ARGP_HELP_STD_HELP);
		return 0;
	case ARGP_KEY_ARG:
		/* the rest is for the verb */
		choice->verb = state->next - 1;
		state->next = state->argc;
		return 0;
	case ARGP_KEY_NO_ARGS:
		argp_error(state, "missing verb");
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

/* The text of --help: summary, verbs, further paragraphs */
static char *tool_doc(const struct cli_tool *tool)
{
	char *doc = NULL;
	size_t size = 0;
	FILE *stream = open_memstream(&doc, &size);

	if (!stream)
		exit(cli_errno(errno, "no help"));
	fprintf(stream, "%s\n\nVerbs:\n", tool->summary);
	for (const struct cli_verb *verb = tool->verbs; verb->name; verb++)
		fprintf(stream, "  %-10s %s\n", verb->name, verb->summary);
	fprintf(stream, "\nSee `%s VERB --help' for details.\v%s", tool->name, tool->text ?: "");
	fclose(stream);
	return doc;
}

static const struct cli_verb *find_verb(const struct cli_tool *tool, const char *name)
{
	for (const struct cli_verb *verb = tool->verbs; verb->name; verb++) {
		if (!strcmp(verb->name, name))
			return verb;
	}
	return NULL;
}

static int run_verb(const struct cli_verb *verb, int argc, char **argv)
{
	char *name;
	int status;

	/* usage and messages of argp start with it */
	if (asprintf(&name, "%s %s", cli_tool->name, verb->name) < 0)
		return cli_errno(ENOMEM, "%s", verb->name);
	argv[0] = name;
	status = verb->run(argc, argv);
	free(name);
	/* an error that no document reports; usage errors have none, as nothing was done */
	if (cli_json && last_message && (status == CLI_FAILURE || status == CLI_NO_DEVICE))
		cli_json_print(cli_json_new(verb->name));
	free(cli_take_message());
	/* a full disk, a closed pipe: the output is incomplete */
	if (fflush(stdout) || ferror(stdout))
		return cli_errno(errno, "standard output");
	if (status == CLI_OK && cli_interrupted() == SIGINT)
		return CLI_INTERRUPTED;
	return status;
}

int cli_main(const struct cli_tool *tool, int argc, char **argv)
{
	static const struct argp_option options[] = {
		{ NULL, 'h', NULL, OPTION_HIDDEN, NULL, 0 },
		{ 0 }
	};
	struct argp argp = {
		.options = options, .parser = parse_tool, .args_doc = "VERB [ARGUMENT...]",
	};
	struct choice choice = { 0 };
	const struct cli_verb *verb;

	cli_tool = tool;
	argv[0] = (char *)tool->name;	/* not the path, also in messages of getopt */
	argp_err_exit_status = CLI_USAGE;
	argp_program_version_hook = print_version;
	argp.doc = tool_doc(tool);
	argp_parse(&argp, argc, argv, ARGP_IN_ORDER, NULL, &choice);
	free((char *)argp.doc);
	/* --version is only for the tool */
	argp_program_version_hook = NULL;

	verb = find_verb(tool, argv[choice.verb]);
	if (!verb)
		return cli_usage("unknown verb '%s'", argv[choice.verb]);
	return run_verb(verb, argc - choice.verb, argv + choice.verb);
}

const char *cli_tool_name(void)
{
	return cli_tool->name;
}

/* ---- messages ---- */

static void say(int error, const char *format, va_list arguments)
{
	char *message = NULL, *text;

	/* earlier output also precedes it on a terminal */
	fflush(stdout);
	if (vasprintf(&text, format, arguments) < 0)
		return;
	if (error && asprintf(&message, "%s: %s", text, strerror(abs(error))) >= 0)
		free(text);
	else
		message = text;
	fprintf(stderr, "%s: %s\n", cli_tool->name, message);
	free(last_message);
	last_message = message;
}

char *cli_take_message(void)
{
	char *message = last_message;

	last_message = NULL;
	return message;
}

int cli_error(const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	say(0, format, arguments);
	va_end(arguments);
	return CLI_FAILURE;
}

int cli_errno(int error, const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	say(error, format, arguments);
	va_end(arguments);
	return CLI_FAILURE;
}

int cli_no_device(const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	say(0, format, arguments);
	va_end(arguments);
	return CLI_NO_DEVICE;
}

int cli_usage(const char *format, ...)
{
	va_list arguments;

	va_start(arguments, format);
	say(0, format, arguments);
	va_end(arguments);
	fprintf(stderr, "Try `%s --help'.\n", cli_tool->name);
	return CLI_USAGE;
}
