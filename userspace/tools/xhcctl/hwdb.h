/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The file of udev's hwdb that selects a key layout
 */
#ifndef HWDB_H
#define HWDB_H

/* sorts after systemd's 60-keyboard.hwdb, which it overrides */
#define HWDB_FILE	"/etc/udev/hwdb.d/61-xhc-pendant.hwdb"

/* Its path below a root (NULL: of the running system); to be freed. NULL: out of memory. */
char *hwdb_path(const char *root);

/* Return an enum cli_status; errors have been reported. */
int hwdb_write(const char *path, const char *entry);	/* atomically */
int hwdb_remove(const char *path);			/* also if there is none */
int hwdb_apply(void);					/* to plugged in pendants, immediately */

/* Print how to activate the file */
void hwdb_say(const char *root);

#endif /* HWDB_H */
