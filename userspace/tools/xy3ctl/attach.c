// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl attach, xy3ctl detach: make a UART the backchannel of a scanhead, like ldattach.
 *
 * A line discipline is active while a program has the tty open: attach keeps running.
 */
#include <errno.h>
#include <fcntl.h>
#include <json-c/json.h>
#include <libxy3.h>
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "cli.h"
#include "head.h"
#include "number.h"
#include "sysfs.h"
#include "verbs.h"

#define LDISC_DEFAULT 29	/* N_DEVELOPMENT */
#define LOOK_MS 500		/* interval of checking whether it was detached */
#define LEAVE_MS 3000		/* for the program that attached it to release the UART */

struct settings {
	struct cli_common common;
	const char *device;
	unsigned int rate;
	bool daemon;
};

static const struct argp_option attach_options[] = {
	{ "rate", 'r', "RATE", 0, "Present bit rate of the head (115200)", 0 },
	{ "daemon", 'b', NULL, 0, "Continue in the background", 0 },
	{ 0 }
};

static error_t parse(int key, char *argument, struct argp_state *state)
{
	struct settings *settings = state->input;

	switch (key) {
	case ARGP_KEY_INIT:
		state->child_inputs[0] = &settings->common;
		return 0;
	case 'r':
		settings->rate = option_whole("--rate", argument, 0, UINT_MAX, state);
		if (xy3_rate_command(settings->rate) < 0)
			argp_error(state, "--rate: a head has no rate '%s'", argument);
		return 0;
	case 'b':
		settings->daemon = true;
		return 0;
	case ARGP_KEY_ARG:
		if (settings->device)
			argp_error(state, "only one UART is possible");
		settings->device = argument;
		return 0;
	case ARGP_KEY_NO_ARGS:
		argp_error(state, "missing UART");
		return 0;
	}
	return ARGP_ERR_UNKNOWN;
}

static const struct argp attach_argp = {
	.options = attach_options, .parser = parse, .children = cli_children, .args_doc = "UART",
	.doc = "Make a UART, such as /dev/ttyUSB0, the backchannel of a scanhead."
	       "\v"
	       "Prints the name of the head, which exists while this runs: until it is "
	       "interrupted, `xy3ctl detach' is used, or the UART is removed; the exit status is "
	       "then 3. It requires root. To attach at every start and plug-in, see "
	       "xy3-attach@.service.\n\n"
	       "  xy3ctl attach /dev/ttyUSB0\n"
	       "  xy3ctl attach --rate 921600 --daemon /dev/ttyUSB0",
};

static const struct argp detach_argp = {
	.parser = parse, .children = cli_children, .args_doc = "{UART|HEAD}",
	.doc = "Detach a UART that `xy3ctl attach' or ldattach has attached."
	       "\v"
	       "ldattach keeps the UART open until it is stopped. Detaching requires root.",
};

static const struct {
	unsigned int rate;
	speed_t speed;
} speeds[] = {
	{ 57600, B57600 }, { 115200, B115200 }, { 230400, B230400 }, { 460800, B460800 },
	{ 921600, B921600 },
};

static speed_t speed_of(unsigned int rate)
{
	for (size_t i = 0; i < ARRAY_SIZE(speeds); i++) {
		if (speeds[i].rate == rate)
			return speeds[i].speed;
	}
	return B115200;
}

static int our_ldisc(void)
{
	long long number;

	return sysfs_read_number(&number, "/sys/module/xy3/parameters/ldisc") ? LDISC_DEFAULT :
										(int)number;
}

/* A bit for each head that has a backchannel */
static uint32_t heads_with_back(void)
{
	struct head heads[HEADS_MAX];
	size_t count = head_list(heads);
	uint32_t found = 0;
	char text[16];

	for (size_t i = 0; i < count; i++) {
		if (head_read(&heads[i], "rate", text, sizeof(text)) > 0)
			found |= 1u << atoi(heads[i].name + strlen("xy3-"));
	}
	return found;
}

static int open_uart(const char *name, int *fd)
{
	/* without O_NONBLOCK, open() waits for the carrier of a UART */
	*fd = open(name, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
	if (*fd < 0 && (errno == ENOENT || errno == ENXIO || errno == ENODEV))
		return cli_no_device("%s: %s", name, strerror(errno));
	if (*fd < 0)
		return cli_errno(errno, "%s", name);
	if (!isatty(*fd)) {
		close(*fd);
		return cli_error("%s is not a serial port", name);
	}
	return CLI_OK;
}

/*
 * The attaching process holds a lock on the UART, so that the detaching one can wait until it is
 * free: the next command may use it, or unload the module. ldattach has none. Return whether the
 * lock was taken.
 */
static bool lock_uart(int fd, int ms)
{
	while (flock(fd, LOCK_EX | LOCK_NB)) {
		if (ms <= 0)
			return false;
		poll(NULL, 0, 10);
		ms -= 10;
	}
	return true;
}

static int set_ldisc(int fd, const char *name, int number)
{
	if (!ioctl(fd, TIOCSETD, &number))
		return CLI_OK;
	switch (errno) {
	case EINVAL:
		return cli_error("%s: no line discipline %d: is xy3 installed? `xy3ctl doctor' "
			"looks",
				 name, number);
	case EPERM:
		return cli_error("%s: attaching a head requires root", name);
	}
	return cli_errno(errno, "%s", name);
}

static int set_up(int fd, const char *name, unsigned int rate)
{
	struct termios modes;

	if (tcgetattr(fd, &modes))
		return cli_errno(errno, "%s", name);
	cfmakeraw(&modes);
	modes.c_cflag |= CLOCAL | CREAD;
	modes.c_cflag &= ~(CRTSCTS | CSTOPB);
	cfsetspeed(&modes, speed_of(rate));
	if (tcsetattr(fd, TCSANOW, &modes) || tcgetattr(fd, &modes))
		return cli_errno(errno, "%s", name);
	if (cfgetispeed(&modes) != speed_of(rate))
		return cli_error("%s does not support %u bit/s", name, rate);
	return CLI_OK;
}

static int say_head(const struct settings *settings, uint32_t before)
{
	uint32_t after = heads_with_back() & ~before;
	struct json_object *document;
	char name[16] = "";

	if (after)
		snprintf(name, sizeof(name), "xy3-%d", __builtin_ctz(after));
	if (settings->common.json) {
		document = cli_json_new("attach");
		cli_json_text(document, "head", after ? name : NULL);
		cli_json_text(document, "uart", settings->device);
		return cli_json_print(document);
	}
	puts(name);
	return fflush(stdout) ? CLI_FAILURE : CLI_OK;
}

/* Run until interrupted. Return an enum cli_status. */
static int stay(int fd, const char *name)
{
	struct pollfd file = { .fd = fd };
	int number, ours = our_ldisc();

	while (!cli_interrupted()) {
		if (poll(&file, 1, LOOK_MS) > 0)
			return cli_no_device("%s has gone", name);
		if (ioctl(fd, TIOCGETD, &number))
			return cli_no_device("%s has gone", name);
		if (number != ours)
			break;
	}
	return CLI_OK;
}

int attach_verb(int argc, char **argv)
{
	struct settings settings = { .rate = XY3_RATE_DEFAULT };
	uint32_t before;
	int fd, status;

	argp_parse(&attach_argp, argc, argv, 0, NULL, &settings);
	status = open_uart(settings.device, &fd);
	if (status)
		return status;
	cli_catch_signals();
	if (!lock_uart(fd, 0)) {
		close(fd);
		return cli_error("%s: xy3ctl has attached it already", settings.device);
	}
	status = set_up(fd, settings.device, settings.rate);
	before = heads_with_back();
	if (!status)
		status = set_ldisc(fd, settings.device, our_ldisc());
	if (!status)
		status = say_head(&settings, before);
	if (!status && settings.daemon && daemon(0, 0))
		status = cli_errno(errno, "background");
	if (!status)
		status = stay(fd, settings.device);
	close(fd);
	return status;
}

/* The UART of a head by its name, otherwise the name itself */
static int uart_of(const char *name, char *path, size_t size)
{
	struct head head;
	int status;

	snprintf(path, size, "%s", name);
	if (strncmp(name, "xy3-", 4))
		return CLI_OK;
	status = head_find(&head, name);
	if (!status && !head.back[0])
		return cli_no_device("%s: its UART is not known", name);
	snprintf(path, size, "/dev/%s", head.back);
	return status;
}

int detach_verb(int argc, char **argv)
{
	struct settings settings = { 0 };
	int fd, status, number = 0;
	char path[256];

	argp_parse(&detach_argp, argc, argv, 0, NULL, &settings);
	status = uart_of(settings.device, path, sizeof(path));
	if (!status)
		status = open_uart(path, &fd);
	if (status)
		return status;
	if (ioctl(fd, TIOCGETD, &number) || number != our_ldisc())
		status = cli_error("%s has no head", path);
	else
		status = set_ldisc(fd, path, N_TTY);
	if (!status && !lock_uart(fd, LEAVE_MS))
		status = cli_error("%s: detached, but another program is using it", path);
	close(fd);
	return status;
}
