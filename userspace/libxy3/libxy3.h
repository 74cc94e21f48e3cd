/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * libxy3: the wire formats of XY3-100 compatible laser scanheads, for programs
 *
 * The codec is the one of the Linux drivers. With the drivers a program needs no library: it reads
 * packets from /dev/xy3 and streams scans to an IIO device. This is for where they cannot be used:
 * a receiver takes packets out of any stream of bytes, a line map makes scans into bytes, and
 * xy3_spidev_*() sends them through a plain /dev/spidevB.C.
 *
 * Functions that can fail return a negative errno. Pointers must be good: of them only those that
 * are freed, and signals, may be NULL. One object is for one thread at a time; different objects
 * have nothing in common. Names of packets, components, axes, errors and commands are those of
 * <linux/xy3.h>.
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

/* "head", "galvo_x" ... of an enum xy3_component; NULL when there is no such component */
const char *xy3_component_name(unsigned int component);
/* The letter of an enum xy3_axis; NULL when there is no such axis */
const char *xy3_axis_name(unsigned int axis);
/* "none", "temperature" ... of an enum xy3_error; NULL for a code without a name */
const char *xy3_error_name(unsigned int error);

/* The rates of the backchannel in bit/s, rising, by index from 0 on; 0 behind the last */
unsigned int xy3_rate(unsigned int index);
/* The command that sets a rate; -EINVAL when the backchannel cannot have it */
int xy3_rate_command(unsigned int rate);

/*
 * Letters out of xyzuw as XY3_COMMAND_AXIS() by |; nothing or "all" is 0, which means all axes.
 * Return 0, or -EINVAL for anything else.
 */
int xy3_parse_axes(const char *text, uint32_t *axes);
/* "on" or "off", and behind it axes as above. Return 0, or -EINVAL for anything else. */
int xy3_parse_switch(const char *text, bool *on, uint32_t *axes);

/* ---- backchannel: packets out of a stream ---- */

/* What is known of one stream of bytes. It holds one packet at a time. */
struct xy3_receiver;

/* What a receiver counts. Bytes received are those of packets, dropped and waiting ones. */
enum xy3_counter {
	XY3_COUNT_PACKETS,		/* packets of all types */
	XY3_COUNT_PACKET_BYTES,		/* bytes of these packets */
	XY3_COUNT_DROPPED_BYTES,	/* bytes that are part of no packet */
	XY3_COUNT_WAITING_BYTES,	/* bytes of a packet, or of a sync, that is not complete */
	XY3_COUNT_RESYNCS,		/* how often sync was lost and found again */
	XY3_COUNT_BAD_LENGTHS,		/* known types with a length that they cannot have */
	XY3_COUNT_UNKNOWN		/* packets of a type that is not known */
};

/* A receiver that is not in sync yet; NULL when there is no memory */
struct xy3_receiver *xy3_receiver_new(void);
void xy3_receiver_free(struct xy3_receiver *receiver);
/* Order of numbers of several bytes; least significant byte first unless this was called */
void xy3_receiver_set_big_endian(struct xy3_receiver *receiver, bool big_endian);

/*
 * Take the next packet. *data are the stream's next *size bytes, in pieces as they come; both are
 * moved past what was taken. Call it again until it returns false: then all data are taken.
 */
bool xy3_receiver_next(struct xy3_receiver *receiver, const uint8_t **data, size_t *size);
/* Bytes came damaged, behind all that were given: sync is lost, what waited is dropped */
void xy3_receiver_lost(struct xy3_receiver *receiver, size_t size);
bool xy3_receiver_in_sync(const struct xy3_receiver *receiver);
uint64_t xy3_receiver_count(const struct xy3_receiver *receiver, enum xy3_counter counter);

/*
 * The packet that xy3_receiver_next() has found, until it is called again. Without one the type
 * is 0 and there are no bytes.
 */
uint8_t xy3_receiver_type(const struct xy3_receiver *receiver);	/* enum xy3_packet_type */
/* false: newer than this library; its length is accepted as received */
bool xy3_receiver_is_known(const struct xy3_receiver *receiver);
/* All its bytes, of which the first XY3_PACKET_HEADER are the header */
const uint8_t *xy3_receiver_packet(const struct xy3_receiver *receiver, size_t *size);

/*
 * What it says. Return how many components or axes are in it, 0 when it is another packet; the
 * rest of the array is filled up with what says that nothing is known.
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
 * The payload, of any packet, as printable ASCII, with ? for all else and a NUL behind it; what
 * has no room in size bytes is left out. Return the length of the text.
 */
size_t xy3_receiver_text(const struct xy3_receiver *receiver, char *text, size_t size);

/* ---- forward channel: frames ---- */

/*
 * Make a frame of 24 or 32 bits: a position of 20 or 26 bits, or a command of 20.
 * Return its bytes, 3 or 4; -EINVAL for another frame_bits, -ERANGE for data with more bits.
 */
int xy3_frame_encode(unsigned int frame_bits, bool position, uint32_t data,
		     uint8_t raw[XY3_FRAME32_SIZE]);
/*
 * Read the frame at the start of some bytes. Return its bytes, 3 or 4; -EMSGSIZE when there are
 * fewer than its first bit says, -EBADMSG when its parity is wrong; then nothing is stored.
 */
int xy3_frame_decode(const uint8_t *raw, size_t size, bool *position, uint32_t *data);
/* Bytes of a frame, by its first one */
size_t xy3_frame_size(uint8_t first);

/* ---- forward channel: scans over several data lines ---- */

/*
 * Which data line carries what. A scan is one position for each axis that is on a line, in the
 * order x y z u w, and behind them 1 or 0 for the gate where a line carries one.
 */
struct xy3_line_map;

/*
 * lines: 1, 2, 4 or 8, in SPI single, dual, quad or octal mode; frame_bits: 24 or 32.
 * signals: a word for each line from IO0 on, blanks or commas between: x y z u w, sync, gate, or -
 * for none; lines without a word carry nothing. Without sync SYNC is the chip select, which goes up
 * and down for each scan; with it, on 4 or 8 lines, SYNC is part of one unbroken stream of bits.
 * NULL is as many of "x y z u w" as there are lines.
 * Return 0, -ENOMEM, or -EINVAL when there is no such arrangement.
 */
int xy3_line_map_new(struct xy3_line_map **map, unsigned int lines, unsigned int frame_bits,
		     const char *signals);
void xy3_line_map_free(struct xy3_line_map *map);

/*
 * Codes of a scan, without the gate, and which axis the one of this index is for; -EINVAL behind
 * the last
 */
unsigned int xy3_line_map_axes(const struct xy3_line_map *map);
int xy3_line_map_axis(const struct xy3_line_map *map, unsigned int index);
/*
 * A line carries a laser's gate: it is high in all clocks of scans with 1, and low with commands.
 * It is no interlock.
 */
bool xy3_line_map_has_gate(const struct xy3_line_map *map);
/* Bytes of a scan on the wire, with the gap behind it when SYNC is a line */
size_t xy3_line_map_scan_size(const struct xy3_line_map *map);
/* The highest position code: 2^20 - 1 or 2^26 - 1 */
uint32_t xy3_code_max(const struct xy3_line_map *map);

/*
 * The bytes of scans, and of a scan that carries a command on the line of x.
 * Return 0, or -ERANGE for a code or command that has more bits, or a gate that is neither 0 nor 1;
 * then nothing is stored.
 */
int xy3_line_map_encode(const struct xy3_line_map *map, const uint32_t *codes, size_t scans,
			uint8_t *out);
int xy3_line_map_encode_command(const struct xy3_line_map *map, uint32_t command, uint8_t *out);

/* ---- forward channel: the laser's gate, earlier or later than its scans ---- */

/*
 * A laser takes its time to go on and off, and mirrors to follow: the gate's edges are shifted
 * against the positions, by scans, which may be negative. It is no interlock.
 */
struct xy3_gate;

/* For scans of @axes axes and the gate. Return 0, -EINVAL or -ENOMEM. */
int xy3_gate_new(struct xy3_gate **gate, unsigned int axes, int on_delay, int off_delay);
void xy3_gate_free(struct xy3_gate *gate);
/*
 * Put a scan in, and get one out. With negative delays the first place comes out some times more.
 * When all are put in, the rest comes out with NULL in place of a scan, xy3_gate_rest() times.
 */
void xy3_gate_next(struct xy3_gate *gate, const uint32_t *scan, uint32_t *out);
size_t xy3_gate_rest(const struct xy3_gate *gate);

/* ---- forward channel: a path of jumps and marks ---- */

/* Speeds are codes from one scan to the next, along the way; delays are scans. */
struct xy3_path_settings {
	double jump_speed;
	double mark_speed;
	unsigned int jump_delay;	/* at the end of each jump */
	unsigned int mark_delay;	/* at the end of marks, before a jump and at the end */
};

struct xy3_path;

/* For vertices of @axes axes and the gate. Return 0, -ENOMEM, or -EINVAL, for a speed of 0, too. */
int xy3_path_new(struct xy3_path **path, unsigned int axes,
		 const struct xy3_path_settings *settings);
void xy3_path_free(struct xy3_path *path);
/*
 * Go on to a vertex: as a scan, with 1 behind its codes to mark the way to it, or 0 to jump. The
 * first one is one scan, with the gate low: nothing tells from where. NULL is the end.
 */
void xy3_path_to(struct xy3_path *path, const uint32_t *vertex);
/* The next scan, with its gate. false: the vertex is reached, and the next one is to be given. */
bool xy3_path_next(struct xy3_path *path, uint32_t *scan);

/* ---- forward channel: through /dev/spidevB.C ---- */

struct xy3_spidev;

/*
 * Open a device, and set SPI mode 1 and the lines of the map, which is copied. rate: frames per
 * second, each with its gap when SYNC is a line; 0 is 100000, or less where the bus is slower.
 * Return 0; what open() says; -ENOTTY: no spidev; -EINVAL: the controller refuses the mode;
 * -EOPNOTSUPP: it has taken the mode, but has fewer lines; -ERANGE: the rate is above the
 * highest clock. When it fails the device has its former mode; after close it keeps the new one.
 */
int xy3_spidev_open(struct xy3_spidev **spidev, const char *path, const struct xy3_line_map *map,
		    unsigned int rate);
void xy3_spidev_close(struct xy3_spidev *spidev);

/*
 * Send scans, and return when they have been sent. Where one message cannot hold them there are
 * several, with pauses between; meanwhile the head stays where it is. With a gate each message ends
 * with its last position once more and the gate low.
 * Return how many have been sent. When that is less, calling again with the rest tells why:
 * -ERANGE: a code has more bits, nothing was sent; -ESHUTDOWN: the device has gone; -EMSGSIZE:
 * not one scan fits into a message; -EINVAL: the kernel cannot send over these lines (8 lines:
 * before Linux 6.12); others are the controller's. Of a message that failed an unknown part may
 * have been sent.
 */
ssize_t xy3_spidev_write(struct xy3_spidev *spidev, const uint32_t *codes, size_t scans);
/* Send the last scan @scans more times, the gate low. As above; -ENODATA when there was none. */
ssize_t xy3_spidev_repeat(struct xy3_spidev *spidev, size_t scans);
/* Send a command, XY3_COMMAND_*. Return 0, -ERANGE, or an error as above. */
int xy3_spidev_command(struct xy3_spidev *spidev, uint32_t command);

/* Frames per second that the clock is set for */
unsigned int xy3_spidev_rate(const struct xy3_spidev *spidev);
/* Scans of a message; less after the kernel has refused a longer one */
unsigned int xy3_spidev_block(const struct xy3_spidev *spidev);

#ifdef __cplusplus
}
#endif

#endif /* LIBXY3_H */
