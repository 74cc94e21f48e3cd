// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl: XY3-100 compatible laser scanheads on the command line.
 */
#include <stddef.h>

#include "cli.h"
#include "verbs.h"

static const struct cli_verb verbs[] = {
	{ "list", "list scanheads", list_verb },
	{ "show", "show all that a head has reported", show_verb },
	{ "watch", "watch its telemetry", watch_verb },
	{ "packets", "print the packets of its backchannel", packets_verb },
	{ "command", "send a command: calibrate, rate, ...", command_verb },
	{ "goto", "move its mirrors to a position", goto_verb },
	{ "stream", "stream scans to it: shapes, or a file", stream_verb },
	{ "attach", "attach a UART as the backchannel of a head", attach_verb },
	{ "detach", "detach a UART from its head", detach_verb },
	{ "doctor", "diagnose problems and suggest fixes", doctor_verb },
	{ 0 }
};

static const char *const modules[] = { "xy3", "xy3_spi", NULL };

static const struct cli_tool tool = {
	.name = "xy3ctl",
	.summary = "Show, move and command XY3-100 compatible laser scanheads.",
	.text = "DEVICE is xy3-<n>, as `xy3ctl list' names it; without it the first head is used. "
		"Members of the group dialout may use all verbs but attach and detach. "
		"Exit status: 0 success, 1 failure, 2 invalid usage, 3 no such device, 130 "
		"interrupted by SIGINT.\n\n"
		"  sudo xy3ctl attach /dev/ttyUSB0 --daemon\n"
		"  xy3ctl watch --count 1 --timeout 10 --json   # wait for a change\n"
		"  xy3ctl goto --unit x=0.5 y=-0.25\n"
		"  xy3ctl stream circle --repeat 3",
	.modules = modules,
	.verbs = verbs,
};

int main(int argc, char **argv)
{
	return cli_main(&tool, argc, argv);
}
