// SPDX-License-Identifier: GPL-2.0-only
/*
 * Features for terminals only, and signals that stop a verb. See cli.h.
 */
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"

static volatile sig_atomic_t interrupted;	/* the signal; 0: none */

bool cli_is_terminal(int fd)
{
	const char *type = getenv("TERM");

	return isatty(fd) && type && strcmp(type, "dumb");
}

const char *cli_colour(enum cli_colour colour)
{
	static const char *const sequences[] = {
		[CLI_PLAIN] = "\033[0m", [CLI_BOLD] = "\033[1m", [CLI_DIM] = "\033[2m",
		[CLI_RED] = "\033[31m", [CLI_GREEN] = "\033[32m", [CLI_YELLOW] = "\033[33m",
		[CLI_CYAN] = "\033[36m",
	};
	const char *no_colour = getenv("NO_COLOR");	/* https://no-color.org */

	if (!cli_is_terminal(STDOUT_FILENO) || (no_colour && *no_colour))
		return "";
	return sequences[colour];
}

static void take_signal(int signal)
{
	interrupted = signal;
}

void cli_catch_signals(void)
{
	/* without SA_RESTART: a waiting call returns */
	const struct sigaction action = { .sa_handler = take_signal };

	sigaction(SIGINT, &action, NULL);
	sigaction(SIGTERM, &action, NULL);
	sigaction(SIGHUP, &action, NULL);
}

void cli_release_signals(void)
{
	signal(SIGINT, SIG_DFL);
	signal(SIGTERM, SIG_DFL);
	signal(SIGHUP, SIG_DFL);
}

int cli_interrupted(void)
{
	return interrupted;
}
