// SPDX-License-Identifier: GPL-2.0-only
/*
 * xhcctl doctor: find out why a pendant does not work.
 */
#include "doctor.h"
#include "verbs.h"

int doctor_verb(int argc, char **argv)
{
	return doctor_run(&doctor_pendant, argc, argv);
}
