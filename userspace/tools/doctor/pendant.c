// SPDX-License-Identifier: GPL-2.0-only
/*
 * Checks of pendants by xhcctl. See userspace/abi/sysfs-driver-hid-xhc.
 */
#include <ctype.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "doctor.h"

#define VENDOR "10ce"
#define OURS "/sys/bus/hid/drivers/hid-xhc/0003:*"

enum kind {
	SUPPORTED,	/* the driver binds it */
	CLONE,		/* supported after a command */
	UNKNOWN,	/* may be a pendant */
	NO_PENDANT,
};

/* Known devices of the vendor. The driver only binds to exact ids. */
static const struct product {
	const char *id;		/* as in sysfs */
	enum kind kind;
	const char *name;
	const char *todo;
} products[] = {
	{ "eb6e", SUPPORTED, "an HB03", NULL },
	{ "eb70", SUPPORTED, "an HB04", NULL },
	{ "eb93", SUPPORTED, "a WHB04B-4 or WHB04B-6", NULL },
	{ "eb91", CLONE, "a clone of the WHB04B", "sudo modprobe hid-xhc; echo 3 10ce eb91 eb93 | "
	  "sudo tee /sys/bus/hid/drivers/hid-xhc/new_id" },
	{ "eb71", UNKNOWN, "perhaps a pendant, but its reports are not known", "report the "
	  "output of `lsusb -v -d 10ce:eb71' and a recording by hid-recorder (package hid-tools)" },
	{ "ea6a", NO_PENDANT, "a serial bridge", "use it as /dev/ttyUSB0, by the kernel's driver "
	  "cp210x" },
	{ "eb73", NO_PENDANT, "a motion card", "use it with its maker's program" },
};

static const char *name_of(const char *path)
{
	return strrchr(path, '/') + 1;
}

/* NULL: it is not in the table */
static const struct product *find_product(const char *id)
{
	for (size_t i = 0; i < ARRAY_SIZE(products); i++) {
		if (!strcmp(products[i].id, id))
			return &products[i];
	}
	return NULL;
}

static void ignore(struct doctor *doctor, const char *path)
{
	(void)doctor;
	(void)path;
}

/* The id of a USB device of the vendor. Return false for devices of other vendors. */
static bool read_product(struct doctor *doctor, const char *path, char *id, size_t size)
{
	char file[PATH_MAX], vendor[8];

	snprintf(file, sizeof(file), "%s/idVendor", path);
	if (doctor_read(doctor, vendor, sizeof(vendor), file) < 0 || strcmp(vendor, VENDOR))
		return false;
	snprintf(file, sizeof(file), "%s/idProduct", path);
	return doctor_read(doctor, id, size, file) >= 0;
}

/* ---- USB: the model ---- */

/* HID devices of this id in a folder of their bus. Their names have capitals. */
static void hid_devices(char *pattern, size_t size, const char *folder, const char *id)
{
	snprintf(pattern, size, "/sys/bus/hid/%s/0003:10CE:%c%c%c%c.*", folder, toupper(id[0]),
		 toupper(id[1]), toupper(id[2]), toupper(id[3]));
}

/* Whether this id was added to the driver */
static bool is_driven(struct doctor *doctor, const char *id)
{
	char pattern[64];

	hid_devices(pattern, sizeof(pattern), "drivers/hid-xhc", id);
	return doctor_each(doctor, pattern, ignore) > 0;
}

static void look_model_of(struct doctor *doctor, const char *path)
{
	const char *usb = name_of(path);
	const struct product *product;
	char id[8];

	if (!read_product(doctor, path, id, sizeof(id)))
		return;
	product = find_product(id);
	if (!product)
		doctor_skip(doctor, "%s (10ce:%s) is not known; hid-xhc ignores it", usb, id);
	else if (product->kind == SUPPORTED)
		doctor_ok(doctor, "%s (10ce:%s) is %s, supported", usb, id, product->name);
	else if (product->kind == NO_PENDANT)
		doctor_skip(doctor, "%s (10ce:%s) is not a pendant but %s: %s", usb, id,
			    product->name, product->todo);
	else if (product->kind == CLONE && is_driven(doctor, id))
		doctor_ok(doctor, "%s (10ce:%s) is %s, and hid-xhc drives it", usb, id,
			  product->name);
	else
		doctor_found(doctor, product->todo, "%s (10ce:%s) is %s: hid-xhc ignores it",
			     usb, id, product->name);
}

static void look_model(struct doctor *doctor)
{
	doctor_each(doctor, "/sys/bus/usb/devices/*-*", look_model_of);
}

/* ---- USB: the driver of the interface ---- */

static unsigned int plugged, taken;	/* supported devices; those used by libusb */
static unsigned int ignored;		/* clones, and perhaps pendants: found by model */
static char unknown[8];			/* id of a device that is not in the table */

static void look_interface(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX], driver[64], node[64], holder[64] = "", fix[256];
	const char *name = name_of(path);
	long long bus, device;
	pid_t pid = 0;

	snprintf(file, sizeof(file), "%s/driver", path);
	doctor_link(doctor, driver, sizeof(driver), file);
	if (!strcmp(driver, "usbhid")) {
		doctor_ok(doctor, "%s is bound to usbhid", name);
		return;
	}
	snprintf(file, sizeof(file), "%s/../busnum", path);
	taken++;
	bus = doctor_number(doctor, file);
	snprintf(file, sizeof(file), "%s/../devnum", path);
	device = doctor_number(doctor, file);
	snprintf(node, sizeof(node), "/dev/bus/usb/%03lld/%03lld", bus, device);
	snprintf(fix, sizeof(fix), "echo %s | sudo tee /sys/bus/usb/drivers/usbhid/bind", name);
	if (doctor_holder(doctor, node, holder, sizeof(holder), &pid)) {
		/* the second line is for the program: it holds the interface until it exits */
		snprintf(fix, sizeof(fix), "sudo kill %d && sleep 1 && echo %s | "
			 "sudo tee /sys/bus/usb/drivers/usbhid/bind", (int)pid, name);
		doctor_found(doctor, fix, "%s has detached %s from its driver by libusb (process "
			     "%d)", holder, name, (int)pid);
	} else {
		doctor_found(doctor, fix, "%s has %s%s: a program has detached it from usbhid by "
			     "libusb, such as LinuxCNC's xhc-hb04", name,
			     driver[0] ? "the driver " : "no driver", driver);
	}
}

/* USB devices; for others only their attributes are checked */
static void look_usb_device(struct doctor *doctor, const char *path)
{
	const struct product *product;
	char file[PATH_MAX], id[8];

	if (!read_product(doctor, path, id, sizeof(id)))
		return;
	product = find_product(id);
	if (!product)
		snprintf(unknown, sizeof(unknown), "%s", id);
	else if (product->kind == CLONE || product->kind == UNKNOWN)
		ignored++;
	if (!product || product->kind > CLONE)
		return;
	plugged += product->kind == SUPPORTED;
	snprintf(file, sizeof(file), "%s/%s:*.0", path, name_of(path));
	doctor_each(doctor, file, look_interface);
}

static void look_holder(struct doctor *doctor)
{
	plugged = 0;
	taken = 0;
	ignored = 0;
	unknown[0] = '\0';
	doctor_each(doctor, "/sys/bus/usb/devices/*-*", look_usb_device);
}

/* ---- HID: the driver ---- */

static void look_driver_of(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX], driver[64], fix[320];
	const char *name = name_of(path);

	if (!doctor_wants(doctor, name))
		return;
	snprintf(file, sizeof(file), "%s/driver", path);
	doctor_link(doctor, driver, sizeof(driver), file);
	if (!strcmp(driver, "hid-xhc")) {
		doctor_ok(doctor, "%s is bound to hid-xhc", name);
	} else if (driver[0]) {
		snprintf(fix, sizeof(fix), "sudo modprobe hid-xhc; echo %s | sudo tee "
			 "/sys/bus/hid/drivers/%s/unbind /sys/bus/hid/drivers/hid-xhc/bind", name,
			 driver);
		doctor_found(doctor, fix, "%s has the driver %s instead of hid-xhc", name, driver);
	} else {
		snprintf(fix, sizeof(fix), "sudo modprobe hid-xhc; echo %s | sudo tee "
			 "/sys/bus/hid/drivers/hid-xhc/bind", name);
		doctor_found(doctor, fix, "%s has no driver", name);
	}
}

static void look_driver(struct doctor *doctor)
{
	char fix[128] = "plug in the pendant's receiver, or its cable; `lsusb -d 10ce:' must show "
			"it";
	int count = 0;

	for (size_t i = 0; i < ARRAY_SIZE(products); i++) {
		const char *id = products[i].id;
		char pattern[64];

		if (products[i].kind == SUPPORTED || is_driven(doctor, id)) {
			hid_devices(pattern, sizeof(pattern), "devices", id);
			count += doctor_each(doctor, pattern, look_driver_of);
		}
	}
	if (count)
		return;
	if (taken) {
		doctor_skip(doctor, "no HID device: another program holds the pendant, see "
			    "holder");
	} else if (plugged) {
		doctor_found(doctor, "look for `usbhid.quirks' in /proc/cmdline and for its "
			     "errors in `sudo dmesg'; then plug the receiver in again",
			     "a pendant is plugged in, but usbhid has made no HID device of it");
	} else if (ignored) {
		doctor_skip(doctor, "hid-xhc ignores the device that is plugged in, see model");
	} else {
		if (unknown[0])
			snprintf(fix, sizeof(fix), "plug in the pendant's receiver; or if this is "
				 "a pendant, report the output of `lsusb -v -d 10ce:%s'", unknown);
		doctor_found(doctor, fix, "no HB03, HB04 or WHB04B is plugged in");
	}
}

/* ---- its attributes ---- */

static void look_state_of(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX];
	const char *name = name_of(path);
	long long number;

	if (!doctor_wants(doctor, name))
		return;
	snprintf(file, sizeof(file), "%s/awake", path);
	if (!doctor_number(doctor, file))
		doctor_skip(doctor, "%s is asleep: press a key to wake it", name);
	snprintf(file, sizeof(file), "%s/stats/frame_errors", path);
	number = doctor_number(doctor, file);
	if (number > 0)
		doctor_found(doctor, "sudo dmesg | grep -i usb   # a bad cable or hub; then plug "
			"in "
			     "again", "%s has not accepted %lld display frames", name, number);
	else
		doctor_ok(doctor, "%s accepts display frames", name);
	snprintf(file, sizeof(file), "%s/stats/unknown_keys", path);
	number = doctor_number(doctor, file);
	if (number > 0)
		doctor_found(doctor, "sudo evtest   # and report its MSC_SCAN",
			     "%s has sent %lld key codes that the driver does not know", name,
			     number);
}

static void look_state(struct doctor *doctor)
{
	doctor_each(doctor, OURS, look_state_of);
}

/* ---- access ---- */

static void look_node(struct doctor *doctor, const char *path)
{
	char node[64];

	snprintf(node, sizeof(node), "/dev/input/%s", name_of(path));
	doctor_access(doctor, node, true, name_of(path));
}

static void look_access_of(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX];

	if (!doctor_wants(doctor, name_of(path)))
		return;
	snprintf(file, sizeof(file), "%s/input/input*/event*", path);
	doctor_each(doctor, file, look_node);
	snprintf(file, sizeof(file), "%s/dro/flush", path);	/* every model has it */
	doctor_access(doctor, file, false, name_of(path));
}

static void look_access(struct doctor *doctor)
{
	doctor_each(doctor, OURS, look_access_of);
}

static const struct doctor_driver drivers[] = {
	{ "hid-xhc", "hid_xhc" },
	{ 0 }
};

static const struct doctor_check checks[] = {
	{ "model", "which of the vendor's devices it is", look_model },
	{ "holder", "a program that holds the pendant by libusb", look_holder },
	{ "driver", "of the HID device: hid-xhc", look_driver },
	{ "state", "asleep, frames that were lost, keys that are not known", look_state },
	{ "linuxcnc", "keys in its HAL files that no pendant sends", look_linuxcnc },
	{ "access", "permissions of the group dialout, and of the user", look_access },
	{ 0 }
};

const struct doctor_tool doctor_pendant = {
	.drivers = drivers, .rules = "70-xhc-pendant.rules", .checks = checks,
	.what = "pendant", .devices = "/sys/bus/hid/devices/0003:10CE:*", .bound = OURS,
};
