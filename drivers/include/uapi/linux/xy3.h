/* SPDX-License-Identifier: GPL-2.0-only WITH Linux-syscall-note */
/*
 * XY3-100 compatible laser scanheads: what programs read from and write to /dev/xy3-<n>
 *
 * A read gives packets of the backchannel, whole and one after another:
 *
 *   byte  0    1     2       3 ...
 *         48h  type  length  payload of length bytes
 *
 * A write takes command frames of 3 or 4 bytes, most significant byte first.
 */
#ifndef _UAPI_LINUX_XY3_H
#define _UAPI_LINUX_XY3_H

#include <linux/types.h>

/* ---- packets ---- */

#define XY3_PACKET_START	0x48	/* first byte of every packet */
#define XY3_PACKET_HEADER	3	/* bytes before the payload */
#define XY3_PACKET_MAX		(XY3_PACKET_HEADER + 255)

/**
 * struct xy3_packet_header - the first three bytes of a packet
 * @start: XY3_PACKET_START
 * @type: enum xy3_packet_type, or a type that is newer than this header
 * @length: bytes of payload that follow
 */
struct xy3_packet_header {
	__u8 start;
	__u8 type;
	__u8 length;
};

/**
 * enum xy3_packet_type - what a packet carries
 * @XY3_PACKET_VENDOR: text: who made the head
 * @XY3_PACKET_MODEL: text: which model it is
 * @XY3_PACKET_FIRMWARE: text: version of its firmware
 * @XY3_PACKET_SERIAL: text: its serial number
 * @XY3_PACKET_TEMPERATURES: signed 16 bit a component, 1/100 degree Celsius
 * @XY3_PACKET_FRAME_ERRORS: unsigned 32 bit an axis: frames with bad parity since power-up
 * @XY3_PACKET_ERRORS: 8 bit a component, enum xy3_error
 * @XY3_PACKET_DEBUG: text for the head's developers
 * @XY3_PACKET_HOURS: unsigned 32 bit a component: hours of work
 * @XY3_PACKET_SYNC: no payload; lets a receiver find the start of the next packet
 *
 * Arrays begin with component or axis 0 and may end early. Numbers of several bytes are little
 * endian unless the head's byte_order attribute says otherwise.
 */
enum xy3_packet_type {
	XY3_PACKET_VENDOR	= 0x01,
	XY3_PACKET_MODEL	= 0x02,
	XY3_PACKET_FIRMWARE	= 0x03,
	XY3_PACKET_SERIAL	= 0x04,
	XY3_PACKET_TEMPERATURES	= 0x05,
	XY3_PACKET_FRAME_ERRORS	= 0x06,
	XY3_PACKET_ERRORS	= 0x07,
	XY3_PACKET_DEBUG	= 0x08,
	XY3_PACKET_HOURS	= 0x09,
	XY3_PACKET_SYNC		= 0x41
};

/* Payload of a text packet, in bytes */
#define XY3_TEXT_MIN		3
#define XY3_TEXT_MAX		200

#define XY3_TEMPERATURE_NONE	(-32767)	/* the component has no thermometer */
#define XY3_HOURS_NONE		0xffffffffU	/* the component has no hour counter */

/**
 * enum xy3_component - parts of a scanhead, index into the arrays of several packets
 * @XY3_HEAD: the head as a whole
 * @XY3_DSP: the processor
 * @XY3_DAC_X: digital-analog converter of axis X
 * @XY3_DAC_Y: the same of Y
 * @XY3_DAC_Z: the same of Z
 * @XY3_DAC_U: the same of U
 * @XY3_DAC_W: the same of W
 * @XY3_DRIVER_X: power stage of axis X
 * @XY3_DRIVER_Y: the same of Y
 * @XY3_DRIVER_Z: the same of Z
 * @XY3_DRIVER_U: the same of U
 * @XY3_DRIVER_W: the same of W
 * @XY3_GALVO_X: galvanometer or actuator of axis X
 * @XY3_GALVO_Y: the same of Y
 * @XY3_GALVO_Z: the same of Z
 * @XY3_GALVO_U: the same of U
 * @XY3_GALVO_W: the same of W
 * @XY3_MIRROR_X: mirror or optics of axis X
 * @XY3_MIRROR_Y: the same of Y
 * @XY3_MIRROR_Z: the focus optics
 * @XY3_MIRROR_U: optics of axis U
 * @XY3_MIRROR_W: optics of axis W
 * @XY3_COMPONENTS: how many they are
 */
enum xy3_component {
	XY3_HEAD,
	XY3_DSP,
	XY3_DAC_X,
	XY3_DAC_Y,
	XY3_DAC_Z,
	XY3_DAC_U,
	XY3_DAC_W,
	XY3_DRIVER_X,
	XY3_DRIVER_Y,
	XY3_DRIVER_Z,
	XY3_DRIVER_U,
	XY3_DRIVER_W,
	XY3_GALVO_X,
	XY3_GALVO_Y,
	XY3_GALVO_Z,
	XY3_GALVO_U,
	XY3_GALVO_W,
	XY3_MIRROR_X,
	XY3_MIRROR_Y,
	XY3_MIRROR_Z,
	XY3_MIRROR_U,
	XY3_MIRROR_W,
	XY3_COMPONENTS
};

/**
 * enum xy3_axis - axes of a scanhead, index into the array of frame errors
 * @XY3_AXIS_X: X
 * @XY3_AXIS_Y: Y
 * @XY3_AXIS_Z: Z
 * @XY3_AXIS_U: U
 * @XY3_AXIS_W: W
 * @XY3_AXES: how many they are
 */
enum xy3_axis {
	XY3_AXIS_X,
	XY3_AXIS_Y,
	XY3_AXIS_Z,
	XY3_AXIS_U,
	XY3_AXIS_W,
	XY3_AXES
};

/**
 * enum xy3_error - state of a component
 * @XY3_ERROR_NONE: it works
 * @XY3_ERROR_TEMPERATURE: too hot or too cold
 * @XY3_ERROR_DATA: bad data
 * @XY3_ERROR_RANGE: out of range
 * @XY3_ERROR_POWER: power supply
 * @XY3_ERROR_ELECTRICAL: another electrical error
 * @XY3_ERROR_ADJUSTMENT: out of adjustment
 * @XY3_ERROR_MECHANICAL: another mechanical error
 * @XY3_ERROR_VENDOR: the first of the vendor's own codes, up to 255
 */
enum xy3_error {
	XY3_ERROR_NONE		= 0,
	XY3_ERROR_TEMPERATURE	= 1,
	XY3_ERROR_DATA		= 2,
	XY3_ERROR_RANGE		= 3,
	XY3_ERROR_POWER		= 4,
	XY3_ERROR_ELECTRICAL	= 5,
	XY3_ERROR_ADJUSTMENT	= 6,
	XY3_ERROR_MECHANICAL	= 7,
	XY3_ERROR_VENDOR	= 100
};

/* ---- commands: 20 bits of a command frame ---- */

#define XY3_COMMAND_BITS	20
#define XY3_COMMAND_MAX		0xfffffU

/*
 * Those that end in _AXES take XY3_COMMAND_AXIS() of one or more axes, added by |; without any
 * they mean all axes.
 */
#define XY3_COMMAND_AUTOCALIB_ON_AXES	0x80000U	/* calibrate by itself from now on */
#define XY3_COMMAND_AUTOCALIB_OFF_AXES	0x40000U
#define XY3_COMMAND_CALIBRATE_AXES	0xc0000U	/* calibrate once */
#define XY3_COMMAND_REFERENCE_AXES	0x20000U	/* reference run */
#define XY3_COMMAND_TEMP_COMP_ON_AXES	0x88000U	/* make up for the temperature */
#define XY3_COMMAND_TEMP_COMP_OFF_AXES	0x48000U
#define XY3_COMMAND_RATE_57600		0xa0000U	/* bit/s of the backchannel */
#define XY3_COMMAND_RATE_115200		0xe0000U
#define XY3_COMMAND_RATE_230400		0x10000U
#define XY3_COMMAND_RATE_460800		0x90000U
#define XY3_COMMAND_RATE_921600		0xd0000U

#define XY3_COMMAND_AXIS(axis)		(1U << (axis))	/* enum xy3_axis */
#define XY3_COMMAND_AXES		0x1fU

/* ---- frames ---- */

#define XY3_FRAME24_SIZE	3	/* bytes of a frame with 20 data bits */
#define XY3_FRAME32_SIZE	4	/* bytes of a frame with 26 data bits */

#define XY3_RATE_DEFAULT	115200	/* bit/s of the backchannel after power-up */

#endif /* _UAPI_LINUX_XY3_H */
