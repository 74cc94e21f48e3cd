// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl: XHC pendants from the command line
 */
#include "verbs.h"

static const char *const modules[] = { "hid_xhc", NULL };

static const struct cli_verb verbs[] = {
	{ "list", "the pendants that are there", list_verb },
	{ "monitor", "keys, wheel and selector as they are worked, and the display", monitor_verb },
	{ "show", "everything that the driver knows of a pendant", show_verb },
	{ "set", "put values on the display", set_verb },
	{ "layout", "what is printed on the keys", layout_verb },
	{ "record", "write what a pendant sends to a file", record_verb },
	{ "replay", "make a virtual pendant that sends what was recorded", replay_verb },
	{ "doctor", "look for what keeps one from working", doctor_verb },
	{ 0 }
};

static const struct cli_tool tool = {
	.name = "xhcctl",
	.summary = "control XHC pendants",
	.text = "A pendant is named as list does it: by its number (0), the name of its HID device "
		"(0003:10CE:EB70.0001), its nodes (event3, /dev/input/xhc-hb04, hidraw0) or where it "
		"is plugged in (its phys). A single one needs no name.\n\n"
		"Exit status: 0 success, 1 something failed, 2 wrong usage, 3 no such pendant, "
		"130 interrupted by SIGINT.",
	.modules = modules,
	.verbs = verbs,
};

int main(int argc, char **argv)
{
	return cli_main(&tool, argc, argv);
}
