/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * XY3-100 forward channel: what the files of xy3-spi share
 *
 *   IIO buffer -> xy3-buffer -> xy3-lines -> xy3-writer -> xy3-queue -> xy3-block -> SPI
 *   xy3.ko (tty, sysfs) -> xy3-spi-core -> xy3-command -----^              ^
 *   IIO channel -> xy3-iio -> xy3-stream, one scan ------------------------'
 *
 * Only xy3-spi-core, xy3-controller and xy3-block know the bus.
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

/* Time of a block on the wire, and its scans at least and at most */
#define XY3_BLOCK_US		2560
#define XY3_BLOCK_SCANS_MIN	32
#define XY3_BLOCK_SCANS_MAX	512
/* The same for one that repeats the last position: a new one waits for two of these at most */
#define XY3_REPEAT_US		750
#define XY3_REPEAT_SCANS_MAX	256
/* Blocks that the controller has at any time while there is a stream */
#define XY3_BLOCKS_QUEUED	3
#define XY3_COMMANDS_QUEUED	64

/* Bits of a position's code in frames of 24 and of 32 bits */
#define XY3_CODE24_BITS		20
#define XY3_CODE32_BITS		26

/* How many bits codes are short of those of the longest frames */
static inline unsigned int xy3_code_shift(const struct xy3_line_map *map)
{
	return map->frame_bits == 32 ? 0 : XY3_CODE32_BITS - XY3_CODE24_BITS;
}

/* Bytes of the longest scan on @lines data lines, with the gap that follows where SYNC is a line */
#define XY3_SCAN_ROOM(lines)	DIV_ROUND_UP((32 + XY3_GAP_CLOCKS) * (lines), 8)

/* Of the gap in front of the first one */
#define XY3_GAP_ROOM(lines)	DIV_ROUND_UP(XY3_GAP_CLOCKS * (lines), 8)

/* For what is written there are twice the blocks that a write of the buffer's length needs */
#define XY3_BLOCKS_MIN		4
#define XY3_BLOCKS_MAX		8192
/* Scans that are taken whole, at most */
#define XY3_WRITE_MAX		131072
#define XY3_WRITE_DEFAULT	1024

/**
 * struct xy3_block - scans that are sent as one message
 * @node: in one of the stream's lists
 * @stream: whose it is
 * @scans_max: how many scans it can hold
 * @scans: how many it holds now
 * @repeats: one of those that repeat the last position
 * @buffer: their bytes, behind the gap in front of the first one
 * @data: their bytes
 * @position: of a block that was written, its last scan: a code for each axis, then 0 for a gate
 * @prepared: scans of @message, which the controller has been shown; 0 when it has not
 * @message: the SPI message
 * @transfers: its transfers: one for all scans, or one for each where the chip select is SYNC
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
 * @node: among those that wait, or are free
 * @users: the stream until it is sent, and as long as it is the last; a waiter. Protected by
 *	   the stream's lock.
 * @code: its 20 bits
 * @err: 0, or why it was not sent
 * @done: it was sent, or is not going to be
 */
struct xy3_command {
	struct list_head node;
	unsigned int users;
	u32 code;
	int err;
	struct completion done;
};

/**
 * struct xy3_commands - commands on their way; protected by the stream's lock
 * @block: carries one
 * @held: @block is being changed, and none is to be sent
 * @waiting: those that wait
 * @count: how many
 * @sending: the one on its way, or NULL
 * @last: the one that was taken last, or NULL
 * @free: those that are not in use
 * @pool: all: as many as may wait, @sending, @last, and the one that is waited for
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
 * enum xy3_stream_stat - what a stream counts
 * @XY3_SCANS: scans that the controller has sent, repeated ones and commands among them
 * @XY3_REPEATED: scans that repeated the last position
 * @XY3_UNDERRUNS: how often there was nothing to send and repeating began
 * @XY3_COMMANDS: commands sent
 * @XY3_ERRORS: messages that the controller has not sent
 * @XY3_CLAMPED: codes that were out of the field, and went to its edge
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
 * struct xy3_queue - what a stream sends, and how far it is; see xy3_queue()
 * @running: a stream: when nothing is there to send, the last position is repeated
 * @primed: a scan has been sent since it runs
 * @repeating: the block that was queued last repeats a position
 * @notify_at: user space is not to be notified of an underrun before that, in jiffies
 * @leaving: it ends for good: what is written is dropped, and no more is taken
 * @aborted: the rest of the write that is going on is dropped; it may be one to the stream before
 * @cancelled: the task whose write() was going on when what was written was dropped, or NULL
 * @error: of the controller; nothing more is sent until the stream is started anew
 * @wanted: scans of the write that has found no room
 * @empty: blocks for the writer
 * @empties: how many
 * @full: blocks to be sent, in this order; there is no room left in them
 * @fulls: how many
 * @filling: the block that the writer has begun, while it is not at it
 * @spare: blocks that repeat the last position
 * @commands: commands, and the block that carries one
 * @closed: the stream's closing block was sent for the error there is
 * @queued: blocks that the controller has, @refused among them
 * @refused: a block that waits until another driver unlocks the bus, or NULL
 * @last: the last scan that was given to the controller, with the gate low
 * @position: by column, the code that was sent last, whatever was not sent behind it; 0 for a gate
 * @stat: counters, by enum xy3_stream_stat
 * @measured_from: when the measuring of the rate began, in ns
 * @measured_scans: scans sent since then
 * @achieved: frames per second that were measured last
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
 * struct xy3_stream - the way of all frames to the head
 * @spi: the SPI device
 * @map: which line carries what; like all up to @block_scans changed while nothing is sent only
 * @rate: frames per second; like @map changed under @lock, too, for those that show it
 * @write_max: scans that are taken whole, or not at all; half of all blocks have room for them
 * @block_scans: scans that a block of the writer's can hold
 * @forward: the forward channel, which is notified when there is room for commands
 * @debugfs: the directory of its counters
 * @writers: where writers wait for an empty block
 * @closing: carries the last position with the gate low, when nothing else is sent; in no list
 * @underrun: notifies user space of underruns
 * @retry: sends what was refused
 * @lock: protects @queue; taken when a message is done, in any context
 * @queue: what is to be sent, and how far it is; by xy3_queue() where a stream may run
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
 * xy3_queue() - what a stream sends
 * @stream: the stream; its lock is held
 *
 * Return: its queue.
 */
static inline struct xy3_queue *xy3_queue(struct xy3_stream *stream)
{
	lockdep_assert_held(&stream->lock);
	return &stream->queue;
}

/**
 * struct xy3_kept - what an IIO device leaves to the one that follows it
 * @frame_bits: 24 or 32
 * @rate: frames per second
 * @position: where each axis is, by enum xy3_axis, as codes of 26 bits
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
struct xy3_block *xy3_next_command(struct xy3_stream *stream);
void xy3_command_done(struct xy3_stream *stream, int err);
void xy3_commands_fail(struct xy3_stream *stream, int err);
int xy3_stream_command(struct xy3_stream *stream, u32 command);
unsigned int xy3_stream_command_room(struct xy3_stream *stream);
int xy3_stream_drain(struct xy3_stream *stream);

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
 * struct xy3_iio - the IIO device: what user space sees of a stream
 * @dev: the IIO device
 * @buffer: what is written to it goes into blocks
 * @access: what @buffer can do; its files may outlive the module
 * @stream: the stream
 * @writer: held by one write() at a time, over page faults, too; protects @input
 * @lock: held while blocks are filled, and while settings are changed; inside of @writer
 * @rates: the lowest rate, a step, and the highest rate, as user space asks for them
 * @channels: one for each axis of the line map, and one for its gate
 * @input: what user space has written, before it is encoded
 * @codes: the same with the channels that are no part of the buffer
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
