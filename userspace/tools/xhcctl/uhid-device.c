// SPDX-License-Identifier: GPL-2.0-only
/*
 * A virtual HID device. See uhid-device.h.
 */
#include <errno.h>
#include <fcntl.h>
#include <linux/uhid.h>
#include <poll.h>
#include <string.h>
#include <unistd.h>

#include "uhid-device.h"

static int send_event(struct uhid_device *device, const struct uhid_event *event)
{
	return write(device->fd, event, sizeof(*event)) < 0 ? -errno : 0;
}

int uhid_create(struct uhid_device *device, const struct recording *recording)
{
	struct uhid_event event = { .type = UHID_CREATE2 };
	struct uhid_create2_req *request = &event.u.create2;
	int err;

	*device = (struct uhid_device){
		.fd = open("/dev/uhid", O_RDWR | O_NONBLOCK | O_CLOEXEC),
	};
	if (device->fd < 0)
		return -errno;
	memcpy(request->name, recording->name, sizeof(recording->name));
	memcpy(request->phys, recording->phys, sizeof(recording->phys));
	request->rd_size = recording->descriptor_size;
	memcpy(request->rd_data, recording->descriptor, recording->descriptor_size);
	request->bus = recording->bus;
	request->vendor = recording->vendor;
	request->product = recording->product;
	err = send_event(device, &event);
	if (err)
		close(device->fd);
	return err;
}

void uhid_destroy(struct uhid_device *device)
{
	/* closing it removes the device */
	close(device->fd);
}

int uhid_send(struct uhid_device *device, const uint8_t *data, size_t size)
{
	struct uhid_event event = { .type = UHID_INPUT2, .u.input2.size = size };

	memcpy(event.u.input2.data, data, size);
	return send_event(device, &event);
}

/* Any display frame is accepted; there is nothing to read. */
static int answer(struct uhid_device *device, const struct uhid_event *event)
{
	struct uhid_event reply = { 0 };

	switch (event->type) {
	case UHID_OPEN:
		device->open = true;
		return 0;
	case UHID_CLOSE:
		device->open = false;
		return 0;
	case UHID_SET_REPORT:
		reply.type = UHID_SET_REPORT_REPLY;
		reply.u.set_report_reply.id = event->u.set_report.id;
		return send_event(device, &reply);
	case UHID_GET_REPORT:
		reply.type = UHID_GET_REPORT_REPLY;
		reply.u.get_report_reply.id = event->u.get_report.id;
		reply.u.get_report_reply.err = EIO;
		return send_event(device, &reply);
	}
	return 0;
}

int uhid_serve(struct uhid_device *device, int ms)
{
	struct pollfd poll_fd = { .fd = device->fd, .events = POLLIN };
	struct uhid_event event;
	int ready;

	ready = poll(&poll_fd, 1, ms);
	if (ready < 0)
		return errno == EINTR ? 0 : -errno;
	while (ready && read(device->fd, &event, sizeof(event)) > 0) {
		int err = answer(device, &event);

		if (err)
			return err;
	}
	return 0;
}
