/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * A recording of a HID device, in the format of hid-recorder (hid-tools):
 *
 *	# anything
 *	R: 46 06 00 ff ...		report descriptor: its size, and each byte
 *	N: KTURT.LTD XHC		name
 *	P: usb-0000:00:14.0-2/input0	phys
 *	I: 3 10ce eb70			bus, vendor, product
 *	E: 000001.250000 6 04 01 ...	an input report: seconds since the first, bytes, each byte
 *
 * A line `D: 0' (the one device) is read, too. It is not written: hid-replay 0.12 stops at it.
 */
#ifndef RECORDING_H
#define RECORDING_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define DESCRIPTOR_MAX	4096	/* of HID and uhid in the kernel */
#define REPORT_MAX	4096

struct recorded_report {
	uint64_t us;		/* since the first one, or since the time 0 of the recording */
	size_t size;
	uint8_t *data;
};

struct recording {
	char name[128];
	char phys[64];
	unsigned int bus, vendor, product;
	uint8_t descriptor[DESCRIPTOR_MAX];
	size_t descriptor_size;
	size_t count;
	struct recorded_report *report;
};

/* Return an enum cli_status; errors have been reported, with the line. */
int recording_read(FILE *stream, const char *path, struct recording *recording);
void recording_free(struct recording *recording);

void recording_write_head(FILE *stream, const struct recording *recording);
void recording_write_report(FILE *stream, uint64_t us, const uint8_t *data, size_t size);

#endif /* RECORDING_H */
