// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl: XHC pendants from the command line
 */
#include "verbs.h"

static const char *const modules[] = { "hid_xhc", NULL };

static const struct cli_verb verbs[] = {
	{ "list", "list pendants", list_verb },
	{ "monitor", "show keys, wheel, selector and display as they change", monitor_verb },
	{ "show", "show all attributes of a pendant", show_verb },
	{ "set", "set values of the display", set_verb },
	{ "layout", "choose the labels of the keys", layout_verb },
	{ "record", "record the reports of a pendant", record_verb },
	{ "replay", "replay a recording by a virtual pendant", replay_verb },
	{ "doctor", "diagnose problems and suggest fixes", doctor_verb },
	{ 0 }
};

static const struct cli_tool tool = {
	.name = "xhcctl",
	.summary = "Show, monitor and configure XHC pendants.",
	.text = "Name a pendant as list does: by its number (0), the name of its HID device "
		"(0003:10CE:EB70.0001), its nodes (event3, /dev/input/xhc-hb04, hidraw0) or the port "
		"it is plugged into (its phys). No name is needed if there is only one.\n\n"
		"Exit status: 0 success, 1 failure, 2 invalid usage, 3 no such pendant, "
		"130 interrupted by SIGINT.",
	.modules = modules,
	.verbs = verbs,
};

int main(int argc, char **argv)
{
	return cli_main(&tool, argc, argv);
}
