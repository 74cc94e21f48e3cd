/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * libxy3: the wire formats of XY3-100 compatible laser scanheads, for programs
 *
 * The codec is that of the Linux drivers. Programs that use the drivers do not need it: they read
 * packets from /dev/xy3 and write scans to an IIO device. The library is for cases where the
 * drivers cannot be used: a receiver extracts packets from any stream of bytes, a line map encodes
 * scans, and xy3_spidev_*() sends them through a plain /dev/spidevB.C.
 *
 * Functions that can fail return a negative errno. Pointers must be valid; only those to be freed,
 * signals, scan and vertex may be NULL. An object may be used by one thread at a time; different
 * objects are independent. Packets, components, axes, errors and commands are defined in
 * <linux/xy3.h>; its comments and protocol-xy3.md describe the wire format.
 */
#ifndef LIBXY3_H
#define LIBXY3_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include <linux/xy3.h>

#ifdef __cplusplus
extern "C" {
#endif

/* ---- names, rates and axes ---- */

/* Name of an enum xy3_component: "head", "galvo_x" ...; NULL if there is no such component */
const char *xy3_component_name(unsigned int component);
/* Letter of an enum xy3_axis; NULL if there is no such axis */
const char *xy3_axis_name(unsigned int axis);
/* Name of an enum xy3_error: "none", "temperature" ...; NULL for a code without a name */
const char *xy3_error_name(unsigned int error);

/* Rates of the backchannel in bit/s, in ascending order, by index from 0 on; 0 after the last */
unsigned int xy3_rate(unsigned int index);
/* The command that sets a rate in bit/s; -EINVAL if the backchannel does not support it */
int xy3_rate_command(unsigned int rate);

/*
 * Parse letters of xyzuw into XY3_COMMAND_AXIS() bits; "" and "all" give 0, which means all axes.
 * Return 0, or -EINVAL for any other text.
 */
int xy3_parse_axes(const char *text, uint32_t *axes);
/* Parse "on" or "off", followed by axes as above. Return 0, or -EINVAL for any other text. */
int xy3_parse_switch(const char *text, bool *on, uint32_t *axes);

/* ---- backchannel: packets of a stream ---- */

/* State of one stream of bytes. It holds one packet at a time. */
struct xy3_receiver;

/* Counters of a receiver. Bytes received are the sum of packet, dropped and waiting bytes. */
enum xy3_counter {
	XY3_COUNT_PACKETS,		/* packets of all types */
	XY3_COUNT_PACKET_BYTES,		/* bytes of these packets */
	XY3_COUNT_DROPPED_BYTES,	/* bytes that are part of no packet */
	XY3_COUNT_WAITING_BYTES,	/* bytes of an incomplete packet or sync */
	XY3_COUNT_RESYNCS,		/* number of times that sync was lost and found again */
	XY3_COUNT_BAD_LENGTHS,		/* known types with an invalid length */
	XY3_COUNT_UNKNOWN		/* packets of unknown types */
};

/* A receiver that is not in sync yet; NULL if out of memory */
struct xy3_receiver *xy3_receiver_new(void);
void xy3_receiver_free(struct xy3_receiver *receiver);
/* Byte order of 16 and 32 bit numbers; the default is little endian */
void xy3_receiver_set_big_endian(struct xy3_receiver *receiver, bool big_endian);

/*
 * Consume the next packet. *data are the next *size bytes of the stream, in pieces of any size;
 * both are advanced past the consumed bytes. Call it until it returns false: then all bytes are
 * consumed.
 */
bool xy3_receiver_next(struct xy3_receiver *receiver, const uint8_t **data, size_t *size);
/* Report damaged bytes after those passed so far: sync is lost, waiting bytes are dropped */
void xy3_receiver_lost(struct xy3_receiver *receiver, size_t size);
bool xy3_receiver_in_sync(const struct xy3_receiver *receiver);
uint64_t xy3_receiver_count(const struct xy3_receiver *receiver, enum xy3_counter counter);

/*
 * The packet that xy3_receiver_next() has found, until it is called again. Without a packet the
 * type is 0 and there are no bytes.
 */
uint8_t xy3_receiver_type(const struct xy3_receiver *receiver);	/* enum xy3_packet_type */
/* false: a type newer than this library; any length is accepted */
bool xy3_receiver_is_known(const struct xy3_receiver *receiver);
/* All bytes of the packet; the first XY3_PACKET_HEADER are the header */
const uint8_t *xy3_receiver_packet(const struct xy3_receiver *receiver, size_t *size);

/*
 * Contents of the packet: temperatures in 1/100 degree Celsius, numbers of frames, enum xy3_error,
 * and hours. Return the number of components or axes in it, 0 if it is another packet; the
 * remaining elements are XY3_TEMPERATURE_NONE, 0, XY3_ERROR_NONE or XY3_HOURS_NONE.
 */
unsigned int xy3_receiver_temperatures(const struct xy3_receiver *receiver,
				       int16_t centidegrees[XY3_COMPONENTS]);
unsigned int xy3_receiver_frame_errors(const struct xy3_receiver *receiver,
				       uint32_t frames[XY3_AXES]);
unsigned int xy3_receiver_errors(const struct xy3_receiver *receiver,
				 uint8_t error[XY3_COMPONENTS]);
unsigned int xy3_receiver_hours(const struct xy3_receiver *receiver,
				uint32_t hours[XY3_COMPONENTS]);
/*
 * The payload of any packet as printable ASCII, with ? for other bytes, NUL-terminated and
 * truncated to size bytes. Return the length of the text.
 */
size_t xy3_receiver_text(const struct xy3_receiver *receiver, char *text, size_t size);

/* ---- forward channel: frames ---- */

/*
 * Encode a frame of 24 or 32 bits: a position of 20 or 26 bits, or a command of 20 bits, most
 * significant byte first.
 * Return its size in bytes, 3 or 4; -EINVAL for any other frame_bits, -ERANGE if data has more
 * bits.
 */
int xy3_frame_encode(unsigned int frame_bits, bool position, uint32_t data,
		     uint8_t raw[XY3_FRAME32_SIZE]);
/*
 * Decode the frame at the start of a buffer. Its first bit determines its size.
 * Return the size in bytes, 3 or 4; -EMSGSIZE if the frame is truncated, -EBADMSG if its parity is
 * wrong; on error nothing is stored.
 */
int xy3_frame_decode(const uint8_t *raw, size_t size, bool *position, uint32_t *data);
/* Size of a frame in bytes, 3 or 4, by its first byte */
size_t xy3_frame_size(uint8_t first);

/* ---- forward channel: scans over several data lines ---- */

/*
 * The signal of each data line. A scan consists of one position code for each axis that is on a
 * line, in the order x y z u w, followed by 1 or 0 for the gate if a line carries it. An array of
 * scans is stored scan by scan.
 */
struct xy3_line_map;

/*
 * lines: 1, 2, 4 or 8, in SPI single, dual, quad or octal mode; frame_bits: 24 or 32.
 * signals: a word for each line from IO0 on, separated by blanks or commas: x y z u w, sync, gate,
 * or - for unused; lines without a word are unused. Without sync SYNC is the chip select, which
 * changes with each scan; with it, on 4 or 8 lines, SYNC is part of a continuous stream of bits.
 * NULL selects the first of "x y z u w", one for each line.
 * Return 0, -ENOMEM, or -EINVAL if the combination is invalid.
 */
int xy3_line_map_new(struct xy3_line_map **map, unsigned int lines, unsigned int frame_bits,
		     const char *signals);
void xy3_line_map_free(struct xy3_line_map *map);

/* Number of codes of a scan without the gate, and enum xy3_axis of each; -EINVAL past the end */
unsigned int xy3_line_map_axes(const struct xy3_line_map *map);
int xy3_line_map_axis(const struct xy3_line_map *map, unsigned int index);
/*
 * True if a line carries the gate of a laser: high during all clocks of scans with 1, low with
 * commands. It is not a safety interlock.
 */
bool xy3_line_map_has_gate(const struct xy3_line_map *map);
/* Size of an encoded scan in bytes, including the gap after it if SYNC is a line */
size_t xy3_line_map_scan_size(const struct xy3_line_map *map);
/* The highest position code: 2^20 - 1 or 2^26 - 1 */
uint32_t xy3_code_max(const struct xy3_line_map *map);

/*
 * Encode scans, or one scan with a command on the line of x, into xy3_line_map_scan_size() bytes
 * each.
 * Return 0, or -ERANGE if a code or command has too many bits, or a gate is neither 0 nor 1; then
 * nothing is stored.
 */
int xy3_line_map_encode(const struct xy3_line_map *map, const uint32_t *codes, size_t scans,
			uint8_t *out);
int xy3_line_map_encode_command(const struct xy3_line_map *map, uint32_t command, uint8_t *out);

/* ---- forward channel: gate delays ---- */

/*
 * Lasers switch on and off with a delay, and mirrors lag: the edges of the gate are shifted
 * relative to the positions, by numbers of scans that may be negative. It is not an interlock.
 */
struct xy3_gate;

/* For scans of axes codes and the gate. Return 0, -EINVAL or -ENOMEM. */
int xy3_gate_new(struct xy3_gate **gate, unsigned int axes, int on_delay, int off_delay);
void xy3_gate_free(struct xy3_gate *gate);
/*
 * Pass a scan in, and get one out. With negative delays the first position is repeated at the
 * start. After the last scan, call it xy3_gate_rest() more times with NULL as scan.
 */
void xy3_gate_next(struct xy3_gate *gate, const uint32_t *scan, uint32_t *out);
size_t xy3_gate_rest(const struct xy3_gate *gate);

/* ---- forward channel: paths of jumps and marks ---- */

/* Speeds are in codes per scan along the path, delays in scans. */
struct xy3_path_settings {
	double jump_speed;
	double mark_speed;
	unsigned int jump_delay;	/* after each jump */
	unsigned int mark_delay;	/* after the last of several marks */
};

struct xy3_path;

/*
 * For vertices of axes codes and the gate. Return 0, -ENOMEM, or -EINVAL for a number of axes or a
 * speed that is out of range; a speed must be 0.001 to 10^9.
 */
int xy3_path_new(struct xy3_path **path, unsigned int axes,
		 const struct xy3_path_settings *settings);
void xy3_path_free(struct xy3_path *path);
/*
 * Start a segment to a vertex, which has the format of a scan: its codes are followed by 1 to mark
 * or 0 to jump. The first vertex is reached with one scan, with the gate low, as the position
 * before it is unknown. NULL ends the path.
 */
void xy3_path_to(struct xy3_path *path, const uint32_t *vertex);
/* Store the next scan, with its gate. false: the segment is complete, pass the next vertex. */
bool xy3_path_next(struct xy3_path *path, uint32_t *scan);

/* ---- forward channel: through /dev/spidevB.C ---- */

struct xy3_spidev;

/*
 * Open a device, and set SPI mode 1 and the lines of the map, which is copied. rate: frames per
 * second, each with its gap if SYNC is a line; 0 selects 100000, or less if the bus is slower.
 * Return 0; an error of open(); -ENOTTY: not a spidev device; -EINVAL: the controller does not
 * support the mode; -EOPNOTSUPP: the controller has fewer lines; -ERANGE: the rate requires more
 * than the highest clock. On error the former mode is restored; after close the new one is kept.
 */
int xy3_spidev_open(struct xy3_spidev **spidev, const char *path, const struct xy3_line_map *map,
		    unsigned int rate);
void xy3_spidev_close(struct xy3_spidev *spidev);

/*
 * Send scans, and return when they have been sent. If they do not fit into one message several are
 * sent, with pauses in which the head keeps its position. With a gate each message ends with a
 * repetition of the last position with the gate low.
 * Return the number of scans sent. If that is less, call again with the remaining scans to get the
 * error: -ERANGE: a code has too many bits, nothing was sent; -ESHUTDOWN: the device was removed;
 * -EMSGSIZE: a single scan does not fit into a message; -EINVAL: the kernel does not support this
 * number of lines (8 lines require Linux 6.12); other errors are the controller's. If a message
 * fails, an unknown part of it may have been sent.
 */
ssize_t xy3_spidev_write(struct xy3_spidev *spidev, const uint32_t *codes, size_t scans);
/* Send the last scan again, scans times, the gate low. As above; -ENODATA if there was none. */
ssize_t xy3_spidev_repeat(struct xy3_spidev *spidev, size_t scans);
/* Send a command, XY3_COMMAND_*. Return 0, -ERANGE, or an error as above. */
int xy3_spidev_command(struct xy3_spidev *spidev, uint32_t command);

/* The rate in frames per second that the clock is set for */
unsigned int xy3_spidev_rate(const struct xy3_spidev *spidev);
/* Maximum number of scans per message; reduced if the kernel refuses a message */
unsigned int xy3_spidev_block(const struct xy3_spidev *spidev);

#ifdef __cplusplus
}
#endif

#endif /* LIBXY3_H */
