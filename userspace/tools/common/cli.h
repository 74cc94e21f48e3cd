/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Common command line of xhcctl and xy3ctl: TOOL VERB [OPTION...] [ARGUMENT...]
 *
 * Results go to standard output, as text or with --json as JSON; error messages go to
 * standard error, with the tool's name before them. The exit status is one of enum cli_status.
 * Help is glibc's argp: each verb has a struct argp, whose text is also the source of the manual
 * page and of the completions (see ../generate).
 */
#ifndef CLI_H
#define CLI_H

#include <argp.h>
#include <stdbool.h>
#include <stddef.h>

#define ARRAY_SIZE(array) (sizeof(array) / sizeof((array)[0]))

struct json_object;

enum cli_status {
	CLI_OK = 0,
	CLI_FAILURE = 1,	/* it has failed, or doctor has found something */
	CLI_USAGE = 2,		/* invalid usage; nothing was done */
	CLI_NO_DEVICE = 3,	/* there is no such device, or no device */
	CLI_INTERRUPTED = 130,	/* ended by SIGINT, as shells count it; verbs return CLI_OK */
};

/* Options of all verbs. Zero before it is set by the parser of the verb. */
struct cli_common {
	bool json;
	const char *device;	/* argument of --device, or NULL */
};

struct cli_verb {
	const char *name;
	const char *summary;	/* for the list of verbs: lower case, no full stop */
	/* argv[0] is "TOOL VERB". Return an enum cli_status. */
	int (*run)(int argc, char **argv);
};

struct cli_tool {
	const char *name;
	const char *summary;	/* one line, for NAME of the manual page */
	const char *text;	/* paragraphs after the list of verbs, or NULL */
	const char *const *modules;	/* for --version, terminated by NULL */
	const struct cli_verb *verbs;	/* terminated by an empty one */
};

/* The running tool, for messages and documents */
const char *cli_tool_name(void);

/* Find the verb and run it. What main() returns. */
int cli_main(const struct cli_tool *tool, int argc, char **argv);

/*
 * For the struct argp of a verb: .children = cli_children. Its parser must pass a pointer to a
 * struct cli_common: state->child_inputs[0] = ..., at ARGP_KEY_INIT.
 */
extern const struct argp_child cli_children[];
/* The same separately, for a verb that also has other children */
extern const struct argp cli_common_argp;

/*
 * For a verb that only has the common options and arguments: parse these.
 * text: that of `TOOL VERB --help`. Return the common options.
 */
struct cli_common cli_parse_common(const char *text, int argc, char **argv);

/* "TOOL: ..." to standard error. Return CLI_FAILURE. */
int cli_error(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* The same, followed by the text of an errno (positive or negative). Return CLI_FAILURE. */
int cli_errno(int error, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The same. Return CLI_NO_DEVICE. */
int cli_no_device(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* The same, with a hint to --help. Return CLI_USAGE. */
int cli_usage(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* The last of these messages, to be freed; NULL if there is none. The next call returns NULL. */
char *cli_take_message(void);

/*
 * JSON. Every document is an object whose first members are "schema" (CLI_SCHEMA), "tool" and
 * "verb"; a verb that runs until interrupted prints one such object per line. CLI_SCHEMA changes
 * when a member is removed or changes its meaning, but not when one is added.
 */
#define CLI_SCHEMA 1

struct json_object *cli_json_new(const char *verb);
/*
 * Print the document on a separate line, immediately, and free it. If there was an error message
 * since the last document, it is the member "error". A verb that fails without a document does not
 * have to print one for the error: cli_main() prints it. Return CLI_OK or CLI_FAILURE.
 */
int cli_json_print(struct json_object *document);
/* Shortcuts; a NULL text is null */
void cli_json_text(struct json_object *object, const char *key, const char *value);
void cli_json_number(struct json_object *object, const char *key, long long value);
/* With millisecond resolution */
void cli_json_seconds(struct json_object *object, const char *key, double seconds);
void cli_json_bool(struct json_object *object, const char *key, bool value);

/* Whether this descriptor is a terminal that supports colour and progress */
bool cli_is_terminal(int fd);

/* For cli_colour() */
enum cli_colour { CLI_PLAIN, CLI_BOLD, CLI_DIM, CLI_RED, CLI_GREEN, CLI_YELLOW, CLI_CYAN };

/* The sequence that starts a colour on standard output; "" if it is not a terminal */
const char *cli_colour(enum cli_colour colour);

/*
 * For verbs that run until they are interrupted: SIGINT, SIGTERM or SIGHUP once received
 * since cli_catch_signals(), or 0. A read() or poll() in progress returns EINTR then.
 */
void cli_catch_signals(void);
/* These signals end the program again, for calls that cannot be ended otherwise */
void cli_release_signals(void);
int cli_interrupted(void);

#endif /* CLI_H */
