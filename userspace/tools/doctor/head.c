// SPDX-License-Identifier: GPL-2.0-only
/*
 * Checks of scanheads by xy3ctl. See userspace/abi/sysfs-class-xy3.
 */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "doctor.h"

#define HEADS "/sys/class/xy3/xy3-*"
#define LDISC 29	/* N_DEVELOPMENT, which all documents use for ldattach */

static const char *name_of(const char *path)
{
	return strrchr(path, '/') + 1;
}

static long long number_of(struct doctor *doctor, const char *path, const char *name)
{
	char file[PATH_MAX];

	snprintf(file, sizeof(file), "%s/%s", path, name);
	return doctor_number(doctor, file);
}

static bool has(struct doctor *doctor, const char *path, const char *name)
{
	char file[PATH_MAX];

	snprintf(file, sizeof(file), "%s/%s", path, name);
	return doctor_exists(doctor, file);
}

/* A pseudo terminal has no link, but it has a rate */
static bool has_back(struct doctor *doctor, const char *path)
{
	return number_of(doctor, path, "rate") > 0;
}

/* ---- the number of the line discipline ---- */

/* The owner of a number, from /proc/tty/ldiscs; "" if it has none */
static void ldisc_owner(struct doctor *doctor, int wanted, char *name, size_t size)
{
	FILE *file = fopen(doctor_path(doctor, "/proc/tty/ldiscs"), "re");
	char found[32];
	int number;

	name[0] = '\0';
	if (!file)
		return;
	while (fscanf(file, "%31s %d", found, &number) == 2) {
		if (number == wanted)
			snprintf(name, size, "%s", found);
	}
	fclose(file);
}

static void look_ldisc(struct doctor *doctor)
{
	long long number = doctor_number(doctor, "/sys/module/xy3/parameters/ldisc");
	char owner[32], fix[128];

	ldisc_owner(doctor, LDISC, owner, sizeof(owner));
	if (number >= 0 && number != LDISC) {
		snprintf(fix, sizeof(fix), "sudo ldattach -s 115200 -8 -n -1 %lld UART   # or: "
			 "sudo xy3ctl attach UART", number);
		doctor_found(doctor, fix, "xy3 was loaded with the number %lld instead of %d%s%s",
			     number, LDISC, owner[0] ? ", which is that of " : "", owner);
	} else if (owner[0] && strcmp(owner, "xy3")) {
		doctor_found(doctor, "echo options xy3 ldisc=28 | sudo tee "
			"/etc/modprobe.d/xy3.conf && "
			     "sudo modprobe xy3", "number %d is that of %s: xy3 cannot be loaded",
			     LDISC, owner);
	} else {
		doctor_ok(doctor, "number %d is xy3's%s", LDISC, owner[0] ? "" : ", when it is "
			"loaded");
	}
}

/* ---- heads ---- */

static unsigned int only_back, only_forward;
static char lonely[2][32];

static void count_halves(struct doctor *doctor, const char *path)
{
	bool back = has_back(doctor, path), forward = has(doctor, path, "forward");

	if (back && !forward) {
		only_back++;
		snprintf(lonely[0], sizeof(lonely[0]), "%s", name_of(path));
	}
	if (forward && !back) {
		only_forward++;
		snprintf(lonely[1], sizeof(lonely[1]), "%s", name_of(path));
	}
}

static void look_heads(struct doctor *doctor)
{
	char fix[160];
	int count;

	only_back = 0;
	only_forward = 0;
	count = doctor_each(doctor, HEADS, count_halves);
	if (!count) {
		const char *port = doctor_free_port(doctor);

		if (port)
			snprintf(fix, sizeof(fix), "sudo xy3ctl attach /dev/%s   # the UART of the "
				 "head; see `man xy3'", port);
		else
			snprintf(fix, sizeof(fix), "plug in the adapter of the head's UART: there "
				 "is no serial port that is free");
		doctor_found(doctor, fix, "no head: nothing is attached");
	} else if (only_back && only_forward) {
		snprintf(fix, sizeof(fix), "echo %s | sudo tee /sys/class/xy3/attach   # if they "
			 "are one head; then attach the UART again", lonely[1]);
		doctor_found(doctor, fix, "%s has only a backchannel, and %s only a forward "
			     "channel", lonely[0], lonely[1]);
	} else {
		doctor_ok(doctor, count == 1 ? "%d is attached" : "%d are attached", count);
	}
}

/* ---- the backchannel ---- */

static void look_back_of(struct doctor *doctor, const char *path)
{
	long long bytes = number_of(doctor, path, "stats/rx_bytes");
	const char *name = name_of(path);
	long long rate = number_of(doctor, path, "rate");
	char fix[160];

	if (!doctor_wants(doctor, name))
		return;
	if (!has_back(doctor, path)) {
		doctor_skip(doctor, "%s has no backchannel", name);
	} else if (!bytes) {
		doctor_found(doctor, "check the wires BACK- and BACK+, the head's supply, and "
			     "whether it has a backchannel", "%s: no byte was received", name);
	} else if (!number_of(doctor, path, "in_sync")) {
		snprintf(fix, sizeof(fix), "echo 1 | sudo tee %s/autobaud", path);
		doctor_found(doctor, fix, "%s: the bytes received at %lld bit/s are not packets: "
			     "the head is at another rate, or - and + are swapped", name, rate);
	} else if (number_of(doctor, path, "stats/line_errors") * 100 > bytes) {
		doctor_found(doctor, "check GND, and the 120 ohms between BACK- and BACK+",
			     "%s: more than 1 %% of its bytes are damaged", name);
	} else {
		doctor_ok(doctor, "%s is in sync at %lld bit/s", name, rate);
	}
}

static void look_back(struct doctor *doctor)
{
	doctor_each(doctor, HEADS, look_back_of);
}

/* Not programs that hold it on purpose */
static bool may_hold(const char *process)
{
	return !strcmp(process, "ldattach") || !strcmp(process, "xy3ctl");
}

static void look_uart_of(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX], uart[64], node[80], holder[64], fix[128];
	const char *name = name_of(path);
	pid_t pid;

	if (!doctor_wants(doctor, name))
		return;
	snprintf(file, sizeof(file), "%s/back", path);
	doctor_link(doctor, uart, sizeof(uart), file);
	if (!uart[0])
		return;
	snprintf(node, sizeof(node), "/dev/%s", uart);
	if (doctor_holder(doctor, node, holder, sizeof(holder), &pid) && !may_hold(holder)) {
		snprintf(fix, sizeof(fix), "sudo kill %d   # for good: disable its service",
			 (int)pid);
		doctor_found(doctor, fix, "%s: %s also has %s open (process %d), and may change "
			     "its settings", name, holder, node, (int)pid);
	} else {
		doctor_ok(doctor, "%s: no other program uses %s", name, node);
	}
}

static void look_uart(struct doctor *doctor)
{
	doctor_each(doctor, HEADS, look_uart_of);
}

static bool strange;

/* -40 to 150 degrees is the range for electronics and motors */
static void look_temperature(struct doctor *doctor, const char *path)
{
	long long millidegrees;
	char text[16];

	if (doctor_read(doctor, text, sizeof(text), path) <= 0)
		return;
	millidegrees = atoll(text);
	strange |= millidegrees < -40000 || millidegrees > 150000;
}

static void look_order_of(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX], order[16], fix[160];
	const char *name = name_of(path);

	if (!doctor_wants(doctor, name))
		return;
	strange = false;
	snprintf(file, sizeof(file), "%s/hwmon*/temp*_input", path);
	if (!doctor_each(doctor, file, look_temperature)) {
		doctor_skip(doctor, "%s has reported no temperature", name);
		return;
	}
	snprintf(file, sizeof(file), "%s/byte_order", path);
	doctor_read(doctor, order, sizeof(order), file);
	if (!strange) {
		doctor_ok(doctor, "%s: temperatures are plausible in %s endian", name, order);
		return;
	}
	snprintf(fix, sizeof(fix), "echo %s | sudo tee %s/byte_order",
		 strcmp(order, "big") ? "big" : "little", path);
	doctor_found(doctor, fix, "%s: temperatures are not plausible in %s endian", name, order);
}

static void look_order(struct doctor *doctor)
{
	doctor_each(doctor, HEADS, look_order_of);
}

/* ---- the forward channel ---- */

static void look_spi_device(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX], modalias[64], driver[32];

	snprintf(file, sizeof(file), "%s/modalias", path);
	if (doctor_read(doctor, modalias, sizeof(modalias), file) < 0 ||
	    (strcmp(modalias, "spi:xy3-100") && !strstr(modalias, "lasia,xy3-100")))
		return;
	snprintf(file, sizeof(file), "%s/driver", path);
	doctor_link(doctor, driver, sizeof(driver), file);
	if (driver[0])
		doctor_ok(doctor, "%s has %s", name_of(path), driver);
	else
		doctor_found(doctor, "sudo modprobe xy3-spi; sudo dmesg | grep xy3-spi   # says "
			"which "
			     "data lines or line map are wrong", "%s has no driver: xy3-spi is not "
			     "loaded, or has refused its controller", name_of(path));
}

static void look_spi(struct doctor *doctor)
{
	if (!doctor_each(doctor, "/sys/bus/spi/devices/*", look_spi_device))
		doctor_skip(doctor, "this machine has no SPI device");
}

static void look_frames_of(struct doctor *doctor, const char *path)
{
	static const char *const axes[] = { "x", "y", "z", "u", "w" };
	const char *name = name_of(path);
	long long bad = 0, number;
	char file[32];

	if (!doctor_wants(doctor, name) || !has(doctor, path, "forward"))
		return;
	for (size_t i = 0; i < ARRAY_SIZE(axes); i++) {
		snprintf(file, sizeof(file), "frame_errors/%s", axes[i]);
		number = number_of(doctor, path, file);
		bad += number > 0 ? number : 0;
	}
	if (bad)
		doctor_found(doctor, "check the wires of SYNC and CLK, which are easily "
			     "swapped, and - and + of each pair",
			     "%s: the head could not read %lld frames", name, bad);
	else
		doctor_ok(doctor, "%s: the head has read all frames", name);
}

static void look_frames(struct doctor *doctor)
{
	doctor_each(doctor, HEADS, look_frames_of);
}

/* ---- access ---- */

static void look_access_of(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX];
	const char *name = name_of(path);

	if (!doctor_wants(doctor, name))
		return;
	snprintf(file, sizeof(file), "/dev/%s", name);
	doctor_access(doctor, file, true, name);
	snprintf(file, sizeof(file), "%s/calibrate", path);
	doctor_access(doctor, file, false, name);
}

static void look_access(struct doctor *doctor)
{
	doctor_each(doctor, HEADS, look_access_of);
}

static const struct doctor_driver drivers[] = {
	{ "xy3", "xy3" },
	{ 0 }
};

static const struct doctor_check checks[] = {
	{ "ldisc", "the number of the line discipline", look_ldisc },
	{ "head", "a head is attached, with both channels", look_heads },
	{ "back", "bytes, sync and rate of the backchannel", look_back },
	{ "uart", "other programs that have the UART open", look_uart },
	{ "port", "the UART is suitable, and has no other use", look_ports },
	{ "adapter", "USB adapters without a serial port", look_adapters },
	{ "order", "byte order", look_order },
	{ "spi", "an SPI device without its driver", look_spi },
	{ "frames", "those that the head could not read", look_frames },
	{ "access", "permissions of the group dialout, and of the user", look_access },
	{ 0 }
};

const struct doctor_tool doctor_head = {
	.drivers = drivers, .rules = "70-xy3.rules", .checks = checks,
	.what = "scanhead", .devices = HEADS,
};
