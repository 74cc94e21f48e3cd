/* SPDX-License-Identifier: GPL-2.0-only */
/* The verbs of xy3ctl, one file each; see cli.h for verbs. */
#ifndef VERBS_H
#define VERBS_H

int list_verb(int argc, char **argv);
int show_verb(int argc, char **argv);
int watch_verb(int argc, char **argv);
int packets_verb(int argc, char **argv);
int command_verb(int argc, char **argv);
int goto_verb(int argc, char **argv);
int stream_verb(int argc, char **argv);
int attach_verb(int argc, char **argv);
int detach_verb(int argc, char **argv);
int doctor_verb(int argc, char **argv);

#endif /* VERBS_H */
