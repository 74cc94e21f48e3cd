/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The file of udev's hwdb that selects a key layout
 */
#ifndef HWDB_H
#define HWDB_H

/* sorts after systemd's 60-keyboard.hwdb, which it overrides */
#define HWDB_FILE	"/etc/udev/hwdb.d/61-xhc-pendant.hwdb"

/* Where it is below a root (NULL: the running system's); to be freed. NULL: no memory. */
char *hwdb_path(const char *root);

/* Return an enum cli_status; what is wrong has been said. */
int hwdb_write(const char *path, const char *entry);	/* whole or not at all */
int hwdb_remove(const char *path);			/* also when there is none */
int hwdb_apply(void);					/* to what is plugged in, at once */

/* Print how to activate the file */
void hwdb_say(const char *root);

#endif /* HWDB_H */
