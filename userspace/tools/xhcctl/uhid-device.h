/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * A virtual HID device, by /dev/uhid
 */
#ifndef UHID_DEVICE_H
#define UHID_DEVICE_H

#include <stdbool.h>

#include "recording.h"

struct uhid_device {
	int fd;
	bool open;	/* a driver listens for reports */
};

/* All return 0 or a negative errno. */
int uhid_create(struct uhid_device *device, const struct recording *recording);
void uhid_destroy(struct uhid_device *device);
int uhid_send(struct uhid_device *device, const uint8_t *data, size_t size);
/* Answer requests of the kernel for this time; ends early on a signal */
int uhid_serve(struct uhid_device *device, int ms);

#endif /* UHID_DEVICE_H */
