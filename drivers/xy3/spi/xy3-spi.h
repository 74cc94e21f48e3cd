/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XY3-100 forward channel: common declarations of the files of xy3-spi
 *
 *   IIO buffer -> xy3-buffer -> xy3-lines -> xy3-writer -> xy3-queue -> xy3-block -> SPI
 *   xy3.ko (tty, sysfs) -> xy3-spi-core -> xy3-command -----^              ^
 *   IIO channel -> xy3-iio -> xy3-stream, one scan ------------------------'
 *
 * Only xy3-spi-core, xy3-controller and xy3-block use the SPI bus.
 */
#ifndef XY3_SPI_H
#define XY3_SPI_H

#include <linux/completion.h>
#include <linux/iio/buffer_impl.h>
#include <linux/iio/iio.h>
#include <linux/list.h>
#include <linux/lockdep.h>
#include <linux/mutex.h>
#include <linux/spi/spi.h>
#include <linux/spinlock.h>
#include <linux/wait.h>
#include <linux/workqueue.h>

#include "xy3.h"
#include "xy3-lines.h"

/* Time of a block on the wire, and its minimum and maximum number of scans */
#define XY3_BLOCK_US		2560
#define XY3_BLOCK_SCANS_MIN	4
#define XY3_BLOCK_SCANS_MAX	512
/* The same for one that repeats the last position: a new position waits for at most two of these */
#define XY3_REPEAT_US		750
#define XY3_REPEAT_SCANS_MAX	256
/* Blocks that the controller has at any time while there is a stream */
#define XY3_BLOCKS_QUEUED	3
#define XY3_COMMANDS_QUEUED	64

/* Bits of the code of a position in frames of 24 and of 32 bits */
#define XY3_CODE24_BITS		20
#define XY3_CODE32_BITS		26

/* Number of bits that codes have less than those of the longest frames */
static inline unsigned int xy3_code_shift(const struct xy3_line_map *map)
{
	return map->frame_bits == 32 ? 0 : XY3_CODE32_BITS - XY3_CODE24_BITS;
}

/* Bytes of the longest scan on @lines data lines, with the gap after it if SYNC is a line */
#define XY3_SCAN_ROOM(lines)	DIV_ROUND_UP((32 + XY3_GAP_CLOCKS) * (lines), 8)

/* Bytes of the gap before the first one */
#define XY3_GAP_ROOM(lines)	DIV_ROUND_UP(XY3_GAP_CLOCKS * (lines), 8)

/* Number of blocks for writers: twice those that a write of the length of the buffer requires */
#define XY3_BLOCKS_MIN		4
#define XY3_BLOCKS_MAX		8192
/* Maximum scans of a write that is accepted completely */
#define XY3_WRITE_MAX		131072
#define XY3_WRITE_DEFAULT	1024

/**
 * struct xy3_block - scans that are sent as one message
 * @node: in one of the lists of the stream
 * @stream: its stream
 * @scans_max: maximum number of scans
 * @scans: current number of scans
 * @repeats: it is one of those that repeat the last position
 * @buffer: the gap before the first scan, then @data
 * @data: bytes of the scans
 * @position: last scan of a written block: a code for each axis, then 0 for a gate
 * @prepared: scans of @message, if the controller has prepared it; 0 otherwise
 * @message: the SPI message
 * @transfers: its transfers: one for all scans, or one for each if the chip select is SYNC
 */
struct xy3_block {
	struct list_head node;
	struct xy3_stream *stream;
	unsigned int scans_max;
	unsigned int scans;
	bool repeats;
	u8 *buffer;
	u8 *data;
	u32 position[XY3_COLUMNS_MAX];
	unsigned int prepared;
	struct spi_message message;
	struct spi_transfer *transfers;
};

/**
 * struct xy3_command - a command
 * @node: in the list of pending or free ones
 * @users: the stream until it is sent, and as long as it is the last; a waiter. Protected by
 *	   the lock of the stream.
 * @code: its 20 bits
 * @err: 0, or the error if it was not sent
 * @done: it was sent, or has failed
 */
struct xy3_command {
	struct list_head node;
	unsigned int users;
	u32 code;
	int err;
	struct completion done;
};

/**
 * struct xy3_commands - queue of commands; protected by the lock of the stream
 * @block: block for one command
 * @held: @block is being changed, and none must be sent
 * @waiting: pending commands
 * @count: number of pending commands
 * @sending: the one being sent, or NULL
 * @last: the one that was queued last, or NULL
 * @free: unused ones
 * @pool: all: the maximum number of pending ones, @sending, @last, and the one waited for
 */
struct xy3_commands {
	struct xy3_block *block;
	bool held;
	struct list_head waiting;
	unsigned int count;
	struct xy3_command *sending;
	struct xy3_command *last;
	struct list_head free;
	struct xy3_command pool[XY3_COMMANDS_QUEUED + 3];
};

/**
 * enum xy3_stream_stat - counters of a stream
 * @XY3_SCANS: scans that the controller has sent, including repeated ones and commands
 * @XY3_REPEATED: scans that repeated the last position
 * @XY3_UNDERRUNS: number of times that there was nothing to send and repeating started
 * @XY3_COMMANDS: commands sent
 * @XY3_ERRORS: messages that the controller has not sent
 * @XY3_CLAMPED: codes that were out of the field, and were clamped to its edge
 * @XY3_STREAM_STATS: number of counters
 */
enum xy3_stream_stat {
	XY3_SCANS,
	XY3_REPEATED,
	XY3_UNDERRUNS,
	XY3_COMMANDS,
	XY3_ERRORS,
	XY3_CLAMPED,
	XY3_STREAM_STATS
};

/**
 * struct xy3_queue - blocks and state of a stream; see xy3_queue()
 * @running: the stream runs: if there is nothing to send, the last position is repeated
 * @primed: a scan has been sent since the start
 * @repeating: the block that was queued last repeats a position
 * @notify_at: user space must not be notified of an underrun before this time, in jiffies
 * @leaving: it ends permanently: written data are dropped, and no more are accepted
 * @aborted: the rest of the write in progress is dropped; it may be one to the previous stream
 * @cancelled: the task whose write() was in progress when written data were dropped, or NULL
 * @error: of the controller; nothing more is sent until the stream is started again
 * @wanted: scans of the write that has found no room
 * @empty: blocks for the writer
 * @empties: number of blocks in @empty
 * @full: blocks to be sent, in this order; there is no room left in them
 * @fulls: number of blocks in @full
 * @filling: the partially filled block, while no writer fills it
 * @spare: blocks that repeat the last position
 * @commands: commands, and the block for one
 * @closed: the closing block of the stream was sent for the current error
 * @queued: number of blocks that the controller has, including @refused
 * @refused: a block that waits until another driver unlocks the bus, or NULL
 * @last: the last scan passed to the controller, with the gate low
 * @position: by column, the code sent last, independent of unsent ones after it; 0 for a gate
 * @stat: counters, by enum xy3_stream_stat
 * @measured_from: start of measuring the rate, in ns
 * @measured_scans: scans sent since then
 * @achieved: frames per second measured last
 */
struct xy3_queue {
	bool running;
	bool primed;
	bool repeating;
	u64 notify_at;
	bool leaving;
	bool aborted;
	struct task_struct *cancelled;
	int error;
	size_t wanted;
	struct list_head empty;
	unsigned int empties;
	struct list_head full;
	unsigned int fulls;
	struct xy3_block *filling;
	struct list_head spare;
	struct xy3_commands commands;
	bool closed;
	unsigned int queued;
	struct xy3_block *refused;
	u8 last[XY3_SCAN_SIZE_MAX] __aligned(sizeof(u32));	/* a scan may be words */
	u32 position[XY3_COLUMNS_MAX];
	u64 stat[XY3_STREAM_STATS];
	u64 measured_from;
	u64 measured_scans;
	unsigned int achieved;
};

/**
 * struct xy3_stream - sends all frames to the head
 * @spi: the SPI device
 * @map: signals of the lines; like all up to @block_scans only changed while nothing is sent
 * @rate: frames per second; like @map also changed under @lock, for attributes that show it
 * @write_max: scans that are accepted completely, or not at all; they fit in half of all blocks
 * @block_scans: maximum scans of a block for writers
 * @forward: the forward channel, which is notified when there is room for commands
 * @debugfs: the directory of its counters
 * @writers: wait queue of writers, for an empty block
 * @closing: has the last position with the gate low, sent after all others; in no list
 * @underrun: notifies user space of underruns
 * @retry: sends a refused block
 * @lock: protects @queue; taken when a message is done, in any context
 * @queue: blocks to be sent and state; accessed by xy3_queue() if a stream may run
 * @done: woken when a block is done
 */
struct xy3_stream {
	struct spi_device *spi;
	struct xy3_line_map map;
	unsigned int rate;
	size_t write_max;
	size_t block_scans;
	struct xy3_forward *forward;
	struct dentry *debugfs;
	wait_queue_head_t *writers;
	struct xy3_block *closing;
	struct delayed_work underrun;
	struct delayed_work retry;

	spinlock_t lock;	/* see above */
	struct xy3_queue queue;

	wait_queue_head_t done;
};

/**
 * xy3_queue() - the queue of a stream
 * @stream: the stream; its lock is held
 *
 * Return: all that the lock protects.
 */
static inline struct xy3_queue *xy3_queue(struct xy3_stream *stream)
{
	lockdep_assert_held(&stream->lock);
	return &stream->queue;
}

/**
 * struct xy3_kept - state that an IIO device passes to the next one
 * @frame_bits: 24 or 32
 * @rate: frames per second
 * @position: position of each axis, by enum xy3_axis, as codes of 26 bits
 * @stat: counters, by enum xy3_stream_stat
 */
struct xy3_kept {
	unsigned int frame_bits;
	unsigned int rate;
	u32 position[XY3_AXES];
	u64 stat[XY3_STREAM_STATS];
};

/* xy3-block.c */
unsigned int xy3_scan_clocks(const struct xy3_stream *stream);
unsigned int xy3_scans_max(const struct xy3_stream *stream, unsigned int wished);
unsigned int xy3_scans_in(const struct xy3_stream *stream, unsigned int us);
struct xy3_block *xy3_block_new(struct xy3_stream *stream, unsigned int scans);
void xy3_block_free(struct xy3_block *block);
int xy3_blocks_new(struct xy3_stream *stream, struct list_head *list, unsigned int count,
		   unsigned int scans);
void xy3_blocks_free(struct list_head *list);
int xy3_blocks_prepare(struct list_head *list, unsigned int scans);
void xy3_blocks_unprepare(struct list_head *list);
int xy3_block_prepare(struct xy3_block *block);
void xy3_block_unprepare(struct xy3_block *block);
int xy3_block_send(struct xy3_block *block, void (*done)(void *context));
int xy3_block_send_now(struct xy3_block *block);
int xy3_block_status(const struct xy3_block *block);

/* xy3-stream.c */
int xy3_stream_init(struct xy3_stream *stream);
void xy3_stream_exit(struct xy3_stream *stream);
unsigned int xy3_stream_rate_min(const struct xy3_stream *stream);
unsigned int xy3_stream_rate_max(const struct xy3_stream *stream);
void xy3_stream_position(struct xy3_stream *stream, u32 *position);
int xy3_stream_send_position(struct xy3_stream *stream, const u32 *position);
int xy3_stream_start(struct xy3_stream *stream);
void xy3_stream_end(struct xy3_stream *stream);
void xy3_stream_stop(struct xy3_stream *stream);
void xy3_stream_abort(struct xy3_stream *stream);
void xy3_stream_leave(struct xy3_stream *stream);
void xy3_stream_suspend(struct xy3_stream *stream);
int xy3_stream_resize(struct xy3_stream *stream, unsigned int frame_bits);
int xy3_stream_set_rate(struct xy3_stream *stream, unsigned int rate);

/* xy3-writer.c */
int xy3_stream_blocks(struct xy3_stream *stream, unsigned int scans);
void xy3_stream_no_blocks(struct xy3_stream *stream);
void xy3_stream_begin_write(struct xy3_stream *stream);
void xy3_stream_end_write(struct xy3_stream *stream);
size_t xy3_stream_write_max(const struct xy3_stream *stream);
size_t xy3_stream_room(struct xy3_stream *stream);
size_t xy3_stream_waiting(struct xy3_stream *stream);
struct xy3_block *xy3_stream_take(struct xy3_stream *stream, size_t scans);
void xy3_stream_give(struct xy3_stream *stream, struct xy3_block *block);

/* xy3-queue.c */
void xy3_command_put(struct xy3_stream *stream, struct xy3_command *command);
void xy3_put_empty(struct xy3_block *block);
void xy3_drop_written(struct xy3_stream *stream);
void xy3_stream_fail(struct xy3_stream *stream, int err);
bool xy3_make_closing(struct xy3_stream *stream);
void xy3_close_after_error(struct xy3_stream *stream);
void xy3_pump(struct xy3_stream *stream, bool late);
void xy3_retry(struct work_struct *work);

/* xy3-command.c */
int xy3_commands_init(struct xy3_stream *stream);
void xy3_commands_exit(struct xy3_stream *stream);
int xy3_commands_new_block(struct xy3_stream *stream);
void xy3_commands_hold(struct xy3_stream *stream);
void xy3_commands_release(struct xy3_stream *stream);
int xy3_stream_command(struct xy3_stream *stream, u32 command);
unsigned int xy3_stream_command_room(struct xy3_stream *stream);
int xy3_stream_drain(struct xy3_stream *stream, unsigned long timeout);

/* xy3-counter.c */
void xy3_underrun_begins(struct xy3_stream *stream);
void xy3_measure(struct xy3_stream *stream, unsigned int scans);
u64 xy3_stream_stat(struct xy3_stream *stream, enum xy3_stream_stat stat);
void xy3_stream_notified(struct xy3_stream *stream);
void xy3_stream_count_clamped(struct xy3_stream *stream, u64 count);
unsigned int xy3_stream_achieved(struct xy3_stream *stream);
void xy3_stream_show_counters(struct xy3_stream *stream);
void xy3_stream_hide_counters(struct xy3_stream *stream);
void xy3_debugfs_init(void);
void xy3_debugfs_exit(void);

/**
 * struct xy3_iio - the IIO device: the interface of a stream for user space
 * @dev: the IIO device
 * @buffer: data written to it are encoded in blocks
 * @access: functions of @buffer; its files may outlive the module
 * @stream: the stream
 * @writer: held by one write() at a time, also during page faults; protects @input
 * @lock: held while blocks are filled, and while settings are changed; inside of @writer
 * @rates: the lowest rate, a step, and the highest rate, in the format for user space
 * @channels: one for each axis of the line map, and one for its gate
 * @input: data written by user space, before they are encoded
 * @codes: the same with the channels that are not part of the buffer
 */
struct xy3_iio {
	struct device *dev;
	struct iio_buffer buffer;
	struct iio_buffer_access_funcs access;
	struct xy3_stream stream;
	struct mutex writer;	/* see above */
	struct mutex lock;	/* see above */
	int rates[3];
	struct iio_chan_spec channels[XY3_COLUMNS_MAX];
	__le32 input[XY3_BLOCK_SCANS_MAX * XY3_COLUMNS_MAX];
	u32 codes[XY3_BLOCK_SCANS_MAX * XY3_COLUMNS_MAX];
};

/* xy3-buffer.c */
void xy3_buffer_init(struct xy3_iio *iio);

/* xy3-controller.c */
int xy3_controller_setup(struct spi_device *spi, unsigned int *lines, bool *words);
void xy3_controller_warn_of_map(const struct spi_device *spi, const struct xy3_line_map *map);

/* xy3-iio.c */
struct iio_dev *xy3_iio_register(struct spi_device *spi, const struct xy3_line_map *map,
				 const struct xy3_kept *kept, struct xy3_forward *forward);
bool xy3_iio_retire(struct iio_dev *indio_dev);
void xy3_iio_unregister(struct iio_dev *indio_dev, struct xy3_kept *kept);

static inline struct xy3_stream *xy3_iio_stream(struct iio_dev *indio_dev)
{
	struct xy3_iio *iio = iio_priv(indio_dev);

	return &iio->stream;
}

#endif /* XY3_SPI_H */
