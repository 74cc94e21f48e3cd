// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 forward channel: counters, which are in debugfs, and the achieved rate
 */

#include <linux/debugfs.h>
#include <linux/jiffies.h>
#include <linux/ktime.h>
#include <linux/math64.h>
#include <linux/workqueue.h>

#include "xy3-spi.h"

/* the achieved rate is the mean of this time */
#define XY3_MEASURE_NS		(NSEC_PER_SEC / 2)

/* Minimum interval of notifying user space of underruns */
#define XY3_NOTIFY_MS		100

/**
 * xy3_underrun_begins() - count an underrun, and notify user space
 * @stream: the stream
 */
void xy3_underrun_begins(struct xy3_stream *stream)
{
	struct xy3_queue *queue = xy3_queue(stream);
	u64 now = get_jiffies_64();
	unsigned long delay = queue->notify_at > now ? queue->notify_at - now : 0;

	queue->stat[XY3_UNDERRUNS]++;
	if (!queue->leaving)
		queue_delayed_work(system_percpu_wq, &stream->underrun, delay);
}

/**
 * xy3_measure() - measure the rate
 * @stream: the stream
 * @scans: number of scans that have just been sent
 */
void xy3_measure(struct xy3_stream *stream, unsigned int scans)
{
	struct xy3_queue *queue = xy3_queue(stream);
	u64 now = ktime_get_ns();
	u64 passed = now - queue->measured_from;

	queue->measured_scans += scans;
	if (passed < XY3_MEASURE_NS)
		return;
	queue->achieved = div64_u64(queue->measured_scans * NSEC_PER_SEC, passed);
	queue->measured_from = now;
	queue->measured_scans = 0;
}

/**
 * xy3_stream_stat() - read a counter
 * @stream: the stream
 * @stat: the counter
 *
 * Return: what it has counted so far.
 */
u64 xy3_stream_stat(struct xy3_stream *stream, enum xy3_stream_stat stat)
{
	guard(spinlock_irqsave)(&stream->lock);
	return xy3_queue(stream)->stat[stat];
}

/**
 * xy3_stream_notified() - user space is notified of underruns now
 * @stream: the stream
 */
void xy3_stream_notified(struct xy3_stream *stream)
{
	guard(spinlock_irqsave)(&stream->lock);
	xy3_queue(stream)->notify_at = get_jiffies_64() + msecs_to_jiffies(XY3_NOTIFY_MS);
}

/**
 * xy3_stream_count_clamped() - count codes that were out of the field
 * @stream: the stream
 * @count: number of codes
 */
void xy3_stream_count_clamped(struct xy3_stream *stream, u64 count)
{
	guard(spinlock_irqsave)(&stream->lock);
	xy3_queue(stream)->stat[XY3_CLAMPED] += count;
}

/**
 * xy3_stream_achieved() - the achieved rate
 * @stream: the stream
 *
 * Return: frames per second in the last half second; 0 if no stream runs, or none were sent.
 */
unsigned int xy3_stream_achieved(struct xy3_stream *stream)
{
	struct xy3_queue *queue;

	guard(spinlock_irqsave)(&stream->lock);
	queue = xy3_queue(stream);
	return queue->running && !queue->error ? queue->achieved : 0;
}

/* ---- debugfs ---- */

static struct dentry *xy3_debugfs;

#define XY3_COUNTER(_name, _stat)							\
static int xy3_##_name##_get(void *stream, u64 *value)					\
{											\
	*value = xy3_stream_stat(stream, _stat);					\
	return 0;									\
}											\
DEFINE_DEBUGFS_ATTRIBUTE(xy3_##_name##_fops, xy3_##_name##_get, NULL, "%llu\n")

XY3_COUNTER(scans, XY3_SCANS);
XY3_COUNTER(repeated, XY3_REPEATED);
XY3_COUNTER(commands, XY3_COMMANDS);
XY3_COUNTER(bus_errors, XY3_ERRORS);
XY3_COUNTER(clamped_codes, XY3_CLAMPED);

/**
 * xy3_stream_show_counters() - create the files of the counters of a stream
 * @stream: the stream
 */
void xy3_stream_show_counters(struct xy3_stream *stream)
{
	struct dentry *dir = debugfs_create_dir(dev_name(&stream->spi->dev), xy3_debugfs);

	debugfs_create_file("scans", 0444, dir, stream, &xy3_scans_fops);
	debugfs_create_file("repeated", 0444, dir, stream, &xy3_repeated_fops);
	debugfs_create_file("commands", 0444, dir, stream, &xy3_commands_fops);
	debugfs_create_file("bus_errors", 0444, dir, stream, &xy3_bus_errors_fops);
	debugfs_create_file("clamped_codes", 0444, dir, stream, &xy3_clamped_codes_fops);
	stream->debugfs = dir;
}

/**
 * xy3_stream_hide_counters() - remove the files of the counters of a stream
 * @stream: the stream
 */
void xy3_stream_hide_counters(struct xy3_stream *stream)
{
	debugfs_remove(stream->debugfs);
}

/**
 * xy3_debugfs_init() - create the directory of the driver in debugfs
 */
void xy3_debugfs_init(void)
{
	xy3_debugfs = debugfs_create_dir("xy3-spi", NULL);
}

/**
 * xy3_debugfs_exit() - remove the directory of the driver in debugfs
 */
void xy3_debugfs_exit(void)
{
	debugfs_remove(xy3_debugfs);
}
