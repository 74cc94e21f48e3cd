/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The verbs of xhcctl, each in a file of its name
 */
#ifndef VERBS_H
#define VERBS_H

#include "cli.h"

int list_verb(int argc, char **argv);
int monitor_verb(int argc, char **argv);
int show_verb(int argc, char **argv);
int set_verb(int argc, char **argv);
int layout_verb(int argc, char **argv);
int record_verb(int argc, char **argv);
int replay_verb(int argc, char **argv);
int doctor_verb(int argc, char **argv);

#endif /* VERBS_H */
