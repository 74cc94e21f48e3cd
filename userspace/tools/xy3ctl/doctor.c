// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3ctl doctor: find out why a scanhead does not work.
 */
#include "doctor.h"
#include "verbs.h"

int doctor_verb(int argc, char **argv)
{
	return doctor_run(&doctor_head, argc, argv);
}
