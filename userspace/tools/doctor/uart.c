// SPDX-License-Identifier: GPL-2.0-only
/*
 * Serial ports of scanheads: other users of a port, and whether it is suitable for a head.
 *
 * Nothing distinguishes a port with a head. While a head is attached, only its port is checked;
 * otherwise all ports, as any of them may be for a head.
 */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

#include "cli.h"
#include "doctor.h"

#define TTYS "/sys/class/tty/tty*"

struct port {
	char name[32];
	bool attached;
	bool console, getty;
};

static struct {
	bool attached;		/* whether there is a head */
	bool modem_manager;	/* whether it runs */
	char uart[32];		/* of the head that is compared */
	bool is_uart;
	unsigned int free;	/* ports that nothing uses */
	unsigned int good;	/* those of them without trouble */
	char first_free[32];	/* a good one, if there is one */
} ports;

static void read_file_of(struct doctor *doctor, const char *name, const char *file, char *text,
			 size_t size)
{
	char path[PATH_MAX];

	snprintf(path, sizeof(path), "/sys/class/tty/%s/%s", name, file);
	doctor_read(doctor, text, size, path);
}

static void compare_uart(struct doctor *doctor, const char *path)
{
	char name[32];

	doctor_link(doctor, name, sizeof(name), path);
	ports.is_uart |= name[0] && !strcmp(name, ports.uart);
}

/* A pseudo terminal has no link, but it has a rate */
static void look_rate(struct doctor *doctor, const char *path)
{
	ports.attached |= doctor_number(doctor, path) > 0;
}

static bool is_attached(struct doctor *doctor, const char *name)
{
	snprintf(ports.uart, sizeof(ports.uart), "%s", name);
	ports.is_uart = false;
	doctor_each(doctor, "/sys/class/xy3/xy3-*/back", compare_uart);
	return ports.is_uart;
}

/* The console of the kernel, a word in console/active */
static bool is_console(struct doctor *doctor, const char *name)
{
	char text[128];

	read_file_of(doctor, "console", "active", text, sizeof(text));
	for (char *word = strtok(text, " "); word; word = strtok(NULL, " ")) {
		if (!strcmp(word, name))
			return true;
	}
	return false;
}

static bool has_getty(struct doctor *doctor, const char *name)
{
	char node[64], holder[64];
	pid_t pid;

	snprintf(node, sizeof(node), "/dev/%s", name);
	return doctor_holder(doctor, node, holder, sizeof(holder), &pid) && strstr(holder, "getty");
}

/* Return false if the tty is not a serial port: without a device, or the driver found no UART. */
static bool read_port(struct doctor *doctor, const char *path, struct port *port)
{
	char file[PATH_MAX], type[16];

	snprintf(port->name, sizeof(port->name), "%s", strrchr(path, '/') + 1);
	snprintf(file, sizeof(file), "%s/device", path);
	read_file_of(doctor, port->name, "type", type, sizeof(type));
	if (!doctor_exists(doctor, file) || !strcmp(type, "0"))
		return false;
	port->attached = is_attached(doctor, port->name);
	port->console = is_console(doctor, port->name);
	port->getty = has_getty(doctor, port->name);
	return true;
}

/* ---- trouble that another port may not have ---- */

/* Whether a udev rule makes ModemManager ignore it */
static bool is_ignored(struct doctor *doctor, const char *name)
{
	char number[16], path[64], text[4096];

	read_file_of(doctor, name, "dev", number, sizeof(number));
	snprintf(path, sizeof(path), "/run/udev/data/c%s", number);
	return doctor_read(doctor, text, sizeof(text), path) > 0 &&
	       strstr(text, "E:ID_MM_PORT_IGNORE=1");
}

/* The USB interface of a tty, as KERNELS in a rule; false: it is not on USB */
static bool usb_interface(struct doctor *doctor, const char *name, char *interface, size_t size)
{
	char path[PATH_MAX];

	if (!realpath(doctor_path(doctor, "/sys/class/tty/%s/device", name), path))
		return false;
	for (char *part = strtok(path, "/"); part; part = strtok(NULL, "/")) {
		int bus, end = 0;

		if (sscanf(part, "%d-%*[0-9.]:%*d.%*d%n", &bus, &end) == 1 && end &&
		    !part[end]) {
			snprintf(interface, size, "%s", part);
			return true;
		}
	}
	return false;
}

/* The rate of a Raspberry Pi's second UART changes with its clock */
static bool is_mini_uart(struct doctor *doctor, const char *name)
{
	char text[64];

	read_file_of(doctor, name, "device/of_node/compatible", text, sizeof(text));
	return !strcmp(text, "brcm,bcm2835-aux-uart");
}

/* ModemManager may open it. interface: as for usb_interface() */
static bool has_modem_manager(struct doctor *doctor, const char *name, char *interface,
			      size_t size)
{
	return ports.modem_manager && !is_ignored(doctor, name) &&
	       usb_interface(doctor, name, interface, size);
}

/* ---- processes ---- */

static void look_process(struct doctor *doctor, const char *path)
{
	char name[32];

	if (doctor_read(doctor, name, sizeof(name), path) > 0)
		ports.modem_manager |= !strcmp(name, "ModemManager");
}

static void count_port(struct doctor *doctor, const char *path)
{
	char interface[64];
	struct port port;
	bool good;

	if (!read_port(doctor, path, &port) || port.console || port.getty || port.attached)
		return;
	good = !is_mini_uart(doctor, port.name) &&
	       !has_modem_manager(doctor, port.name, interface, sizeof(interface));
	if (!ports.free || (good && !ports.good))
		snprintf(ports.first_free, sizeof(ports.first_free), "%s", port.name);
	ports.free++;
	ports.good += good;
}

static void count_ports(struct doctor *doctor)
{
	memset(&ports, 0, sizeof(ports));
	doctor_each(doctor, "/sys/class/xy3/xy3-*/rate", look_rate);
	doctor_each(doctor, "/proc/[0-9]*/comm", look_process);
	doctor_each(doctor, TTYS, count_port);
}

const char *doctor_free_port(struct doctor *doctor)
{
	count_ports(doctor);
	return ports.free ? ports.first_free : NULL;
}

/* ---- one port ---- */

static void look_modem_manager(struct doctor *doctor, const struct port *port)
{
	char fix[512], interface[64];

	if (!has_modem_manager(doctor, port->name, interface, sizeof(interface)))
		return;
	snprintf(fix, sizeof(fix), "echo 'SUBSYSTEM==\"tty\", KERNELS==\"%s\", "
		 "ENV{XY3_BACKCHANNEL}=\"1\"' | sudo tee /etc/udev/rules.d/69-my-heads.rules && "
		 "sudo udevadm control --reload && sudo udevadm trigger /dev/%s   # if this is the "
		 "port of the head", interface, port->name);
	doctor_found(doctor, fix, "ModemManager may open %s and write to it, as no rule marks it "
		     "as a head's", port->name);
}

static void look_port(struct doctor *doctor, const char *path)
{
	char fix[256], text[64];
	struct port port;

	if (!read_port(doctor, path, &port) || (ports.attached && !port.attached))
		return;
	/* irrelevant if there is another port */
	if (port.console && (port.attached || !ports.free)) {
		snprintf(fix, sizeof(fix), "remove it from the kernel's command line (Raspberry "
			 "Pi: `console=serial0,...' in /boot/firmware/cmdline.txt; others: "
			 "/etc/default/grub), then restart");
		doctor_found(doctor, fix, "%s is the kernel's console", port.name);
	}
	if (port.getty && (port.attached || !ports.free)) {
		snprintf(fix, sizeof(fix), "sudo systemctl disable --now serial-getty@%s.service",
			 port.name);
		doctor_found(doctor, fix, "%s has a login prompt (getty)", port.name);
	}
	if (is_mini_uart(doctor, port.name) && (port.attached || !ports.good))
		doctor_found(doctor, "write dtoverlay=disable-bt to /boot/firmware/config.txt and "
			     "restart; the port is ttyAMA0 then",
			     "%s is the mini-UART: its rate changes with the core clock",
			     port.name);
	if (port.attached || !ports.good)
		look_modem_manager(doctor, &port);
	read_file_of(doctor, port.name, "device/latency_timer", text, sizeof(text));
	if (port.attached && atoi(text) > 1) {
		snprintf(fix, sizeof(fix), "echo 1 | sudo tee /sys/class/tty/%s/device/"
			 "latency_timer", port.name);
		doctor_found(doctor, fix, "%s delays bytes by up to %d ms (FTDI's latency timer)",
			     port.name, atoi(text));
	}
}

void look_ports(struct doctor *doctor)
{
	count_ports(doctor);
	if (!doctor_each(doctor, TTYS, look_port))
		doctor_skip(doctor, "there is no serial port");
}

/* ---- USB adapters without a port ---- */

static const struct {
	const char *id, *driver;
} adapters[] = {
	{ "1a86:7523", "ch341" }, { "1a86:5523", "ch341" }, { "10c4:ea60", "cp210x" },
	{ "10c4:ea70", "cp210x" }, { "0403:6001", "ftdi_sio" }, { "0403:6010", "ftdi_sio" },
	{ "0403:6014", "ftdi_sio" }, { "0403:6015", "ftdi_sio" }, { "067b:2303", "pl2303" },
	{ "067b:23a3", "pl2303" },
};

static const char *adapter_driver(struct doctor *doctor, const char *path, char *id, size_t size)
{
	char file[PATH_MAX], vendor[8], product[8];

	snprintf(file, sizeof(file), "%s/idVendor", path);
	doctor_read(doctor, vendor, sizeof(vendor), file);
	snprintf(file, sizeof(file), "%s/idProduct", path);
	doctor_read(doctor, product, sizeof(product), file);
	snprintf(id, size, "%s:%s", vendor, product);
	for (size_t i = 0; i < ARRAY_SIZE(adapters); i++) {
		if (!strcmp(adapters[i].id, id))
			return adapters[i].driver;
	}
	return NULL;
}

static void ignore(struct doctor *doctor, const char *path)
{
	(void)doctor;
	(void)path;
}

/* It claims adapters by udev rules, with or without a braille display. */
static bool has_brltty(struct doctor *doctor)
{
	return doctor_each(doctor, "/usr/lib/udev/rules.d/*brltty*.rules", ignore) ||
	       doctor_each(doctor, "/lib/udev/rules.d/*brltty*.rules", ignore);
}

static void look_adapter(struct doctor *doctor, const char *path)
{
	const char *name = strrchr(path, '/') + 1, *driver;
	char file[PATH_MAX], id[16], fix[256], bound[64];

	driver = adapter_driver(doctor, path, id, sizeof(id));
	if (!driver)
		return;
	snprintf(file, sizeof(file), "%s/%s:1.0/driver", path, name);
	doctor_link(doctor, bound, sizeof(bound), file);
	if (!strcmp(bound, driver)) {
		doctor_ok(doctor, "%s (%s) has %s", name, id, driver);
	} else if (has_brltty(doctor)) {
		doctor_package_fix(doctor, "remove", "brltty", fix, sizeof(fix));
		snprintf(fix + strlen(fix), sizeof(fix) - strlen(fix), "   # unless you have a "
			 "braille display; then plug the adapter in again");
		doctor_found(doctor, fix, "%s (%s) is a serial adapter without a serial port: "
			     "brltty has claimed it as a braille display", name, id);
	} else if (bound[0]) {
		doctor_found(doctor, "end the program that uses it by libusb, then plug it in "
			     "again",
			     "%s (%s) is a serial adapter, but has the driver %s", name, id, bound);
	} else {
		snprintf(fix, sizeof(fix), "sudo modprobe %s", driver);
		doctor_found(doctor, fix, "%s (%s) is a serial adapter without a driver", name, id);
	}
}

void look_adapters(struct doctor *doctor)
{
	doctor_each(doctor, "/sys/bus/usb/devices/*-*", look_adapter);
}
