/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Virtual XY3-100 compatible scanhead: common declarations of its files
 *
 *   SPI device -> sim-bus -> clocks -> sim-head -> positions, commands -> sim-record, debugfs
 *                    |                    |
 *               bus time, gaps      rate, bad frames
 *                                         v
 *             tty <- sim-uart <- sim-telemetry
 *
 * It shares no code with the drivers that it tests: it is written only from the description of the
 * format.
 */
#ifndef XY3_SIM_H
#define XY3_SIM_H

#include <linux/atomic.h>
#include <linux/jiffies.h>
#include <linux/mutex.h>
#include <linux/prandom.h>
#include <linux/property.h>
#include <linux/tty.h>
#include <linux/types.h>
#include <linux/workqueue.h>

#include "sim-config.h"
#include "sim-head.h"

#define XY3_SIM_HEADS_MAX	4
#define XY3_SIM_COMPONENTS	22
#define XY3_SIM_TEXT_MAX	200
#define XY3_SIM_NODES		40	/* maximum number of text files in debugfs */

struct dentry;
struct platform_device;
struct seq_file;
struct spi_controller;
struct spi_message;
struct xy3_sim;

/**
 * struct xy3_sim_bus - time on the wire
 * @started: a message has been sent
 * @dry: the controller had no other message when the last one ended
 * @until: when the last message ends, in ns of the monotonic clock
 * @messages: sent
 * @failed_messages: not sent
 * @transfers: sent
 * @clocks: sent
 * @busy_ns: time of these clocks
 * @delay_ns: requested delays in messages
 * @stalled_ns: time for which the fault spi_stall_ms delayed messages
 * @gaps: number of times that the bus had nothing to send
 * @gap_ns: total time of gaps
 * @longest_gap_ns: the longest of them
 * @turnaround_ns: time that the controller requires between messages
 * @longest_silence_ns: the longest time between two messages, for any reason
 */
struct xy3_sim_bus {
	bool started;
	bool dry;
	u64 until;
	u64 messages;
	u64 failed_messages;
	u64 transfers;
	u64 clocks;
	u64 busy_ns;
	u64 delay_ns;
	u64 stalled_ns;
	u64 gaps;
	u64 gap_ns;
	u64 longest_gap_ns;
	u64 turnaround_ns;
	u64 longest_silence_ns;
};

/**
 * enum xy3_sim_text - texts that the head reports
 * @XY3_SIM_VENDOR: packet 01h; model, firmware and serial follow
 * @XY3_SIM_TEXTS: number of texts
 */
enum xy3_sim_text {
	XY3_SIM_VENDOR,
	XY3_SIM_TEXTS = 4
};

/**
 * enum xy3_sim_array - numbers that the head reports, one for each component
 * @XY3_SIM_TEMPERATURES: 1/100 degree
 * @XY3_SIM_ERRORS: error codes
 * @XY3_SIM_HOURS: hours of work
 * @XY3_SIM_ARRAYS: number of arrays
 */
enum xy3_sim_array {
	XY3_SIM_TEMPERATURES,
	XY3_SIM_ERRORS,
	XY3_SIM_HOURS,
	XY3_SIM_ARRAYS
};

/**
 * struct xy3_sim_array_kind - format of an array
 * @type: of its packet
 * @size: bytes of a number
 * @min: the lowest number
 * @max: the highest number
 * @none: the number that is sent for a component without a value
 */
struct xy3_sim_array_kind {
	u8 type;
	u8 size;
	s64 min;
	s64 max;
	s64 none;
};

/**
 * struct xy3_sim_telemetry - values that the head reports
 * @interval_ms: between rounds, 0 for none
 * @sync_ms: between sync packets, 0 for none
 * @next_round: jiffies of the next round
 * @next_sync: jiffies of the next sync packet
 * @big_endian: byte order of numbers
 * @text: by enum xy3_sim_text; empty ones are not sent
 * @count: by enum xy3_sim_array: how many numbers; if 0, the array is not sent
 * @value: the numbers
 */
struct xy3_sim_telemetry {
	unsigned int interval_ms;
	unsigned int sync_ms;
	unsigned long next_round;
	unsigned long next_sync;
	bool big_endian;
	char text[XY3_SIM_TEXTS][XY3_SIM_TEXT_MAX + 1];
	unsigned int count[XY3_SIM_ARRAYS];
	s64 value[XY3_SIM_ARRAYS][XY3_SIM_COMPONENTS];
};

/**
 * struct xy3_sim_uart - the UART at the end of the backchannel
 * @port: its tty port; the head is freed with it
 * @speed: of the tty in bit/s; written by the tty, read by the worker
 * @open: the tty is open
 * @openings: number of times it was opened
 * @packets: packets sent unchanged
 * @bytes: bytes in them
 * @damaged_packets: sent with a fault
 * @garbled_packets: sent while the tty had another speed than the head
 * @silenced_packets: not sent because of the fault uart_silence
 * @held_back: rounds and sync packets that were not sent as the reader was slow
 * @lost_bytes: bytes without room in the buffer
 * @written_bytes: bytes that the host has sent to the head, which does not receive them
 */
struct xy3_sim_uart {
	struct tty_port port;
	unsigned int speed;
	bool open;
	u64 openings;
	u64 packets;
	u64 bytes;
	u64 damaged_packets;
	u64 garbled_packets;
	u64 silenced_packets;
	u64 held_back;
	u64 lost_bytes;
	atomic64_t written_bytes;
};

/**
 * enum xy3_sim_fault - faults that can be injected
 * @XY3_SIM_SPI_FLIP: frames in which one bit will be wrong
 * @XY3_SIM_SPI_FLIP_EVERY: one bit is wrong in one frame of this number
 * @XY3_SIM_SPI_FLIP_LINE: on this line, counted from 1; 0: on any line with an axis
 * @XY3_SIM_SPI_FLIP_CLOCK: in this clock, counted from 1; 0: in any
 * @XY3_SIM_SPI_CLOCK: frames whose last clock will be lost
 * @XY3_SIM_SPI_ERROR_IN: the message that fails, 1 is the next one
 * @XY3_SIM_SPI_ERROR_EVERY: one message of this number fails
 * @XY3_SIM_SPI_STALL_MS: the next message takes longer by this time
 * @XY3_SIM_UART_SILENCE: packets that are not sent
 * @XY3_SIM_UART_NOISE: packets with noise before them
 * @XY3_SIM_UART_LOST: packets that lose a byte
 * @XY3_SIM_UART_DOUBLED: packets with a byte that is sent twice
 * @XY3_SIM_UART_FLIPPED: packets with a wrong bit
 * @XY3_SIM_UART_TORN: packets that end in the middle
 * @XY3_SIM_UART_LENGTH: packets with a wrong length byte
 * @XY3_SIM_UART_LINE_ERROR: packets in which a byte has a framing error
 * @XY3_SIM_FAULTS: number of faults
 */
enum xy3_sim_fault {
	XY3_SIM_SPI_FLIP,
	XY3_SIM_SPI_FLIP_EVERY,
	XY3_SIM_SPI_FLIP_LINE,
	XY3_SIM_SPI_FLIP_CLOCK,
	XY3_SIM_SPI_CLOCK,
	XY3_SIM_SPI_ERROR_IN,
	XY3_SIM_SPI_ERROR_EVERY,
	XY3_SIM_SPI_STALL_MS,
	XY3_SIM_UART_SILENCE,
	XY3_SIM_UART_NOISE,
	XY3_SIM_UART_LOST,
	XY3_SIM_UART_DOUBLED,
	XY3_SIM_UART_FLIPPED,
	XY3_SIM_UART_TORN,
	XY3_SIM_UART_LENGTH,
	XY3_SIM_UART_LINE_ERROR,
	XY3_SIM_FAULTS
};

/**
 * struct xy3_sim_file - a text file
 * @name: its name
 * @show: prints its content, or NULL
 * @store: gets the written text, without surrounding blanks, or NULL
 * @index: distinguishes several files
 *
 * Both are called with the lock of the head held.
 */
struct xy3_sim_file {
	const char *name;
	void (*show)(struct seq_file *seq, struct xy3_sim *sim, unsigned int index);
	int (*store)(struct xy3_sim *sim, char *text, unsigned int index);
	unsigned int index;
};

/**
 * struct xy3_sim_node - data of a debugfs file
 * @sim: its head
 * @file: its description
 */
struct xy3_sim_node {
	struct xy3_sim *sim;
	const struct xy3_sim_file *file;
};

/**
 * struct xy3_sim - a virtual scanhead
 * @pdev: its platform device
 * @number: 0 for the first one
 * @config: its settings
 * @controller: its SPI controller
 * @spi_name: name of the SPI device
 * @properties: of the SPI device
 * @line_map: one of them, a word for each line
 * @lane_widths: a bus width for each lane
 * @bus_lock: locks the bus, for another device
 * @bus_lock_ms: duration of that lock
 * @swnode: software node of the SPI device
 * @node_name: its name
 * @setup_hz: clock of the device when it was set up
 * @prepared: messages that the controller has prepared, and not unprepared yet
 * @fault: faults to inject; written at any time
 * @fault_count: number of times that each has occurred
 * @debugfs: its directory
 * @nodes: data of its text files
 * @node_count: number of text files
 * @lock: protects all following members, and @uart except where documented otherwise
 * @gone: being removed: no work is queued any more
 * @realtime: transfers take as long as on a wire
 * @head: the receiver
 * @record: the record of received scans
 * @bus: the wire
 * @telemetry: the values that it reports
 * @uart: the UART that it reports them to
 * @random: for faults
 * @frames: of SPI since the last one with a wrong bit
 * @message: of SPI since the last one that failed
 * @work: sends telemetry
 */
struct xy3_sim {
	struct platform_device *pdev;
	unsigned int number;
	struct xy3_sim_config config;
	struct spi_controller *controller;
	char spi_name[32];
	struct property_entry properties[4];
	u32 lane_widths[XY3_SIM_LINES_MAX];
	const char *line_map[XY3_SIM_LINES_MAX];
	struct work_struct bus_lock;
	unsigned int bus_lock_ms;
	struct software_node swnode;
	char node_name[16];
	u32 setup_hz;
	atomic_t prepared;
	atomic_t fault[XY3_SIM_FAULTS];
	atomic_t fault_count[XY3_SIM_FAULTS];
	struct dentry *debugfs;
	struct xy3_sim_node nodes[XY3_SIM_NODES];
	unsigned int node_count;

	struct mutex lock;	/* see above */
	bool gone;
	bool realtime;
	struct xy3_sim_head head;
	struct xy3_sim_record record;
	struct xy3_sim_bus bus;
	struct xy3_sim_telemetry telemetry;
	struct xy3_sim_uart uart;
	struct rnd_state random;
	unsigned int frames;
	unsigned int message;
	struct delayed_work work;
};

/* Whether a fault that is counted down occurs now */
static inline bool xy3_sim_fault(struct xy3_sim *sim, enum xy3_sim_fault fault)
{
	if (atomic_dec_if_positive(&sim->fault[fault]) < 0)
		return false;
	atomic_inc(&sim->fault_count[fault]);
	return true;
}

/* The setting of a fault, 0 for off */
static inline unsigned int xy3_sim_fault_value(struct xy3_sim *sim, enum xy3_sim_fault fault)
{
	int value = atomic_read(&sim->fault[fault]);

	return value > 0 ? value : 0;
}

/* The lock is held */
static inline unsigned int xy3_sim_random(struct xy3_sim *sim, unsigned int below)
{
	return prandom_u32_state(&sim->random) % below;
}

/* If firmware describes more lanes than the controller has lines, there are none */
static inline bool xy3_sim_has_lanes(const struct xy3_sim *sim)
{
	return sim->config.lanes && sim->config.lanes <= sim->config.lines;
}

/* Start the intervals of telemetry now. The lock is held. */
static inline void xy3_sim_telemetry_soon(struct xy3_sim *sim)
{
	sim->telemetry.next_round = jiffies;
	sim->telemetry.next_sync = jiffies;
	if (!sim->gone)
		mod_delayed_work(system_percpu_wq, &sim->work, 0);
}

/* sim-core.c */
int xy3_sim_new_number(void);
void xy3_sim_free_number(unsigned int number);
struct platform_device *xy3_sim_add(const struct xy3_sim_config *config, unsigned int number);
void xy3_sim_remove(struct platform_device *pdev);

/* sim-bus.c */
int xy3_sim_message(struct spi_controller *controller, struct spi_message *message);
void xy3_sim_idle(struct xy3_sim *sim);

/* sim-spi.c */
int xy3_sim_spi_add(struct xy3_sim *sim);

/* sim-uart.c */
int xy3_sim_tty_init(void);
void xy3_sim_tty_exit(void);
int xy3_sim_uart_add(struct xy3_sim *sim);
void xy3_sim_uart_remove(void *data);
void xy3_sim_uart_send(struct xy3_sim *sim, const u8 *data, size_t size, int line_error);
void xy3_sim_uart_push(struct xy3_sim *sim);
bool xy3_sim_uart_room(struct xy3_sim *sim);

/* sim-telemetry.c */
extern const struct xy3_sim_array_kind xy3_sim_array_kinds[XY3_SIM_ARRAYS];
void xy3_sim_telemetry_init(struct xy3_sim *sim);
void xy3_sim_report(struct xy3_sim *sim);
void xy3_sim_telemetry_work(struct work_struct *work);

/* sim-files.c */
extern const struct xy3_sim_file xy3_sim_uart_files[];
extern const unsigned int xy3_sim_uart_file_count;

/* sim-debugfs.c */
void xy3_sim_debugfs_init(void);
void xy3_sim_debugfs_exit(void);
int xy3_sim_debugfs_add(struct xy3_sim *sim);

#endif /* XY3_SIM_H */
