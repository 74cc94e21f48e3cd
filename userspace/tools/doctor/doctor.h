/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The verb doctor of both tools: diagnose a device and suggest a fix.
 *
 * It only reads. A check examines one thing and reports, once or for each device, the result: by
 * doctor_ok(), doctor_found() or doctor_skip(). All paths are below a root, so that a test can pass
 * a prepared tree.
 */
#ifndef DOCTOR_H
#define DOCTOR_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

struct doctor;

struct doctor_check {
	const char *id;		/* stable: scripts may use it */
	const char *what;	/* for the list in --help */
	void (*look)(struct doctor *doctor);
};

/* A driver whose installation is checked */
struct doctor_driver {
	const char *module;	/* as for modprobe: hid-xhc */
	const char *sysfs;	/* as in /sys/module: hid_xhc */
};

struct doctor_tool {
	const struct doctor_driver *drivers;	/* terminated by an empty one */
	const char *rules;			/* file of udev */
	const char *what;			/* a device of the tool: "pendant" */
	const char *devices;			/* their folders in sysfs, as a pattern */
	const char *bound;			/* numbered in list; NULL: by their names */
	const struct doctor_check *checks;	/* of this tool; terminated by an empty one */
};

/* Called by main() with the arguments. Return an enum cli_status: CLI_FAILURE for findings. */
int doctor_run(const struct doctor_tool *tool, int argc, char **argv);

/* ---- for checks ---- */

const struct doctor_tool *doctor_tool_of(const struct doctor *doctor);
/* The release of the running kernel */
const char *doctor_kernel(const struct doctor *doctor);
/* Whether device is the one named by --device, or none was named */
bool doctor_wants(const struct doctor *doctor, const char *device);

void doctor_ok(struct doctor *doctor, const char *format, ...)
	__attribute__((format(printf, 2, 3)));
void doctor_skip(struct doctor *doctor, const char *format, ...)
	__attribute__((format(printf, 2, 3)));
/* fix: lines for a shell, or text for manual work */
void doctor_found(struct doctor *doctor, const char *fix, const char *format, ...)
	__attribute__((format(printf, 3, 4)));

/* A path below the root, valid until the eighth next call */
const char *doctor_path(struct doctor *doctor, const char *format, ...)
	__attribute__((format(printf, 2, 3)));
bool doctor_exists(struct doctor *doctor, const char *path);
/* The first bytes of a file, without a final newline. Return the length, or a negative errno. */
int doctor_read(struct doctor *doctor, char *text, size_t size, const char *path);
/* A number in a file; -1 if there is none */
long long doctor_number(struct doctor *doctor, const char *path);
/* The last component of the target of a link; "" if it is not a link */
void doctor_link(struct doctor *doctor, char *name, size_t size, const char *path);

/* Call look(doctor, path) for each path that matches the pattern. Return their number. */
int doctor_each(struct doctor *doctor, const char *pattern,
		void (*look)(struct doctor *doctor, const char *path));

/*
 * Another process that has a device node open: name and number of the first one, as far as /proc
 * shows it. Return whether there is one.
 */
bool doctor_holder(struct doctor *doctor, const char *node, char *name, size_t size, pid_t *pid);

/* Whether the group dialout may read and write: a node, or with write alone an attribute */
void doctor_access(struct doctor *doctor, const char *path, bool read, const char *device);

/* ---- advice by distribution (distro.c) ---- */

#define DOCTOR_IMAGE "not here: the system is an image, into which DKMS cannot install modules"

/* Is /usr read-only, such as with rpm-ostree? */
bool doctor_is_image(struct doctor *doctor);
/* How to install the headers of the running kernel */
void doctor_headers_fix(struct doctor *doctor, char *fix, size_t size);
/* The key that DKMS signs with */
const char *doctor_key(struct doctor *doctor);
/* A command that installs or removes a package; text if none is known */
void doctor_package_fix(struct doctor *doctor, const char *verb, const char *package, char *fix,
			size_t size);

/* Checks of serial ports (uart.c); and a port that a head can be attached to, NULL: none */
void look_ports(struct doctor *doctor);
void look_adapters(struct doctor *doctor);
const char *doctor_free_port(struct doctor *doctor);

/* A check of pendants (linuxcnc.c) */
void look_linuxcnc(struct doctor *doctor);

/* The checks of installation of both tools; terminated by an empty one */
extern const struct doctor_check doctor_install_checks[];
extern const struct doctor_tool doctor_pendant;
extern const struct doctor_tool doctor_head;

#endif /* DOCTOR_H */
