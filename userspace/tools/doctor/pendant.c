// SPDX-License-Identifier: GPL-2.0-only
/*
 * What keeps a pendant from working: checks of xhcctl. See userspace/abi/sysfs-driver-hid-xhc.
 */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "doctor.h"

#define VENDOR "10ce"
#define PRODUCTS "eb6e eb70"	/* HB03, HB04 */
#define HID_DEVICES "/sys/bus/hid/devices/0003:10CE:EB[67][E0].*"

static const char *name_of(const char *path)
{
	return strrchr(path, '/') + 1;
}

/* ---- USB: is anybody else at it ---- */

static void look_interface(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX], driver[64], node[64], holder[64] = "", mend[256];
	const char *name = name_of(path);
	long long bus, device;
	pid_t pid = 0;

	snprintf(file, sizeof(file), "%s/driver", path);
	doctor_link(doctor, driver, sizeof(driver), file);
	if (!strcmp(driver, "usbhid")) {
		doctor_ok(doctor, "the kernel has %s", name);
		return;
	}
	snprintf(file, sizeof(file), "%s/../busnum", path);
	bus = doctor_number(doctor, file);
	snprintf(file, sizeof(file), "%s/../devnum", path);
	device = doctor_number(doctor, file);
	snprintf(node, sizeof(node), "/dev/bus/usb/%03lld/%03lld", bus, device);
	snprintf(mend, sizeof(mend), "echo %s | sudo tee /sys/bus/usb/drivers/usbhid/bind", name);
	if (doctor_holder(doctor, node, holder, sizeof(holder), &pid)) {
		/* the second is for the program: it holds the interface until it has ended */
		snprintf(mend, sizeof(mend), "sudo kill %d && sleep 1 && echo %s | "
			 "sudo tee /sys/bus/usb/drivers/usbhid/bind", (int)pid, name);
		doctor_found(doctor, mend, "%s has taken %s from the kernel by libusb (process %d)",
			     holder, name, (int)pid);
	} else {
		doctor_found(doctor, mend, "%s has %s%s: a program has taken it from the kernel by "
			     "libusb, such as LinuxCNC's xhc-hb04", name,
			     driver[0] ? "the driver " : "no driver", driver);
	}
}

/* USB devices; of the others only what is theirs is looked at */
static void look_usb_device(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX], vendor[8], product[8];

	snprintf(file, sizeof(file), "%s/idVendor", path);
	if (doctor_read(doctor, vendor, sizeof(vendor), file) < 0 || strcmp(vendor, VENDOR))
		return;
	snprintf(file, sizeof(file), "%s/idProduct", path);
	if (doctor_read(doctor, product, sizeof(product), file) < 0 || !strstr(PRODUCTS, product))
		return;
	snprintf(file, sizeof(file), "%s/%s:*.0", path, name_of(path));
	doctor_each(doctor, file, look_interface);
}

static void look_holder(struct doctor *doctor)
{
	doctor_each(doctor, "/sys/bus/usb/devices/*-*", look_usb_device);
}

/* ---- HID: is it ours ---- */

static void look_driver_of(struct doctor *doctor, const char *path)
{
	char file[PATH_MAX], driver[64], mend[320];
	const char *name = name_of(path);

	if (!doctor_wants(doctor, name))
		return;
	snprintf(file, sizeof(file), "%s/driver", path);
	doctor_link(doctor, driver, sizeof(driver), file);
	if (!strcmp(driver, "hid-xhc")) {
		doctor_ok(doctor, "%s has hid-xhc", name);
	} else if (driver[0]) {
		snprintf(mend, sizeof(mend), "sudo modprobe hid-xhc; echo %s | sudo tee "
			 "/sys/bus/hid/drivers/%s/unbind /sys/bus/hid/drivers/hid-xhc/bind", name,
			 driver);
		doctor_found(doctor, mend, "%s has the driver %s instead of hid-xhc", name, driver);
	} else {
		snprintf(mend, sizeof(mend), "sudo modprobe hid-xhc; echo %s | sudo tee "
			 "/sys/bus/hid/drivers/hid-xhc/bind", name);
		doctor_found(doctor, mend, "%s has no driver", name);
	}
}

static void look_driver(struct doctor *doctor)
{
	if (!doctor_each(doctor, HID_DEVICES, look_driver_of))
		doctor_found(doctor, "plug in the pendant's receiver, or its cable; `lsusb -d "
			"10ce:' "
			     "must show it", "no HB03 or HB04 is plugged in");
}

/* ---- what it says of itself ---- */

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
			     "again", "%s has not taken %lld frames for its display", name, number);
	else
		doctor_ok(doctor, "%s takes what it is to show", name);
	snprintf(file, sizeof(file), "%s/stats/unknown_keys", path);
	number = doctor_number(doctor, file);
	if (number > 0)
		doctor_found(doctor, "sudo evtest /dev/input/xhc-hb04   # and tell us of its "
			"MSC_SCAN",
			     "%s has keys that the driver does not know: pressed %lld times", name,
			     number);
}

static void look_state(struct doctor *doctor)
{
	doctor_each(doctor, "/sys/bus/hid/drivers/hid-xhc/0003:*", look_state_of);
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
	snprintf(file, sizeof(file), "%s/dro/position", path);
	doctor_access(doctor, file, false, name_of(path));
}

static void look_access(struct doctor *doctor)
{
	doctor_each(doctor, "/sys/bus/hid/drivers/hid-xhc/0003:*", look_access_of);
}

static const struct doctor_driver drivers[] = {
	{ "hid-xhc", "hid_xhc" },
	{ 0 }
};

static const struct doctor_check checks[] = {
	{ "holder", "a program that holds the pendant by libusb", look_holder },
	{ "driver", "is it hid-xhc", look_driver },
	{ "state", "asleep, frames that were lost, keys that are not known", look_state },
	{ "access", "of the group dialout, and of you", look_access },
	{ 0 }
};

const struct doctor_tool doctor_pendant = {
	.drivers = drivers, .rules = "70-xhc-pendant.rules", .checks = checks,
};
