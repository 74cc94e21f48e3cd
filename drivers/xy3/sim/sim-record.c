// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: the record of received scans
 *
 *   record       a line of text for each scan, with a code for each axis, or - if it had none; with
 *                a gate followed by 1 or 0
 *   record.bin   the same in 32-bit numbers in native byte order, FFFFFFFFh for -
 */

#include <linux/cleanup.h>
#include <linux/debugfs.h>
#include <linux/fs.h>
#include <linux/kstrtox.h>
#include <linux/mm.h>
#include <linux/seq_file.h>
#include <linux/slab.h>
#include <linux/string.h>
#include <linux/uaccess.h>

#include "sim.h"

/**
 * xy3_sim_record_start() - record the next scans, and delete the old record
 * @sim: the head; its lock is held
 * @scans: number of scans
 * @changes: leave out scans that are the same as the one before
 *
 * Return: 0, -ERANGE or -ENOMEM.
 */
int xy3_sim_record_start(struct xy3_sim *sim, u32 scans, bool changes)
{
	struct xy3_sim_record *record = &sim->record;
	unsigned int axes = 0;
	u32 *codes = NULL;

	if (scans > XY3_SIM_RECORD_MAX)
		return -ERANGE;
	for (unsigned int i = 0; i < XY3_SIM_AXES; i++)
		axes += sim->head.axis[i].line >= 0;
	axes += sim->head.gate >= 0;
	if (scans && axes) {
		codes = kvmalloc_array(scans, axes * sizeof(*codes), GFP_KERNEL);
		if (!codes)
			return -ENOMEM;
	}
	kvfree(record->codes);
	*record = (struct xy3_sim_record) {
		.codes = codes,
		.axes = axes,
		.room = codes ? scans : 0,
		.changes = changes,
	};
	return 0;
}

/**
 * xy3_sim_record_scan() - a scan has been received
 * @sim: the head; its lock is held
 * @codes: of all axes
 * @gate: whether the gate was high
 */
void xy3_sim_record_scan(struct xy3_sim *sim, const u32 *codes, bool gate)
{
	struct xy3_sim_record *record = &sim->record;
	size_t size = record->axes * sizeof(*codes);
	u32 *at;

	if (record->count == record->room)
		return;
	at = record->codes + (size_t)record->count * record->axes;
	for (unsigned int i = 0, to = 0; i < XY3_SIM_AXES; i++)
		if (sim->head.axis[i].line >= 0)
			at[to++] = codes[i];
	if (sim->head.gate >= 0)
		at[record->axes - 1] = gate;
	if (record->changes && record->count && !memcmp(at, at - record->axes, size))
		return;
	record->count++;
}

/* ---- as text ---- */

static void *sim_record_seq_start(struct seq_file *seq, loff_t *pos)
{
	struct xy3_sim *sim = seq->private;

	mutex_lock(&sim->lock);
	return *pos < sim->record.count ? pos : NULL;
}

static void *sim_record_seq_next(struct seq_file *seq, void *v, loff_t *pos)
{
	struct xy3_sim *sim = seq->private;

	++*pos;
	return *pos < sim->record.count ? pos : NULL;
}

static void sim_record_seq_stop(struct seq_file *seq, void *v)
{
	struct xy3_sim *sim = seq->private;

	mutex_unlock(&sim->lock);
}

static int sim_record_seq_show(struct seq_file *seq, void *v)
{
	struct xy3_sim *sim = seq->private;
	const struct xy3_sim_record *record = &sim->record;
	const u32 *codes = record->codes + *(loff_t *)v * record->axes;

	for (unsigned int i = 0; i < record->axes; i++) {
		if (i)
			seq_putc(seq, ' ');
		if (codes[i] == XY3_SIM_NO_CODE)
			seq_putc(seq, '-');
		else
			seq_printf(seq, "%u", codes[i]);
	}
	seq_putc(seq, '\n');
	return 0;
}

static const struct seq_operations sim_record_seq_ops = {
	.start = sim_record_seq_start,
	.next = sim_record_seq_next,
	.stop = sim_record_seq_stop,
	.show = sim_record_seq_show,
};

static int sim_record_open(struct inode *inode, struct file *file)
{
	int err = seq_open(file, &sim_record_seq_ops);

	if (!err)
		((struct seq_file *)file->private_data)->private = inode->i_private;
	return err;
}

/* "1000" or "1000 changes" */
static ssize_t sim_record_write(struct file *file, const char __user *user, size_t size,
				loff_t *pos)
{
	struct xy3_sim *sim = ((struct seq_file *)file->private_data)->private;
	char text[32], *rest = text, *word;
	bool changes = false;
	u32 scans;
	int err;

	if (size >= sizeof(text))
		return -EINVAL;
	if (copy_from_user(text, user, size))
		return -EFAULT;
	text[size] = '\0';
	rest = strim(text);
	word = strsep(&rest, " ");
	err = kstrtou32(word, 0, &scans);
	if (err)
		return err;
	if (rest) {
		if (strcmp(skip_spaces(rest), "changes"))
			return -EINVAL;
		changes = true;
	}
	scoped_guard(mutex, &sim->lock)
		err = xy3_sim_record_start(sim, scans, changes);
	return err ?: size;
}

static const struct file_operations sim_record_fops = {
	.owner = THIS_MODULE,
	.open = sim_record_open,
	.read = seq_read,
	.write = sim_record_write,
	.llseek = seq_lseek,
	.release = seq_release,
};

/* ---- as numbers ---- */

static ssize_t sim_record_bin_read(struct file *file, char __user *user, size_t size, loff_t *pos)
{
	struct xy3_sim *sim = file->private_data;
	const struct xy3_sim_record *record = &sim->record;

	guard(mutex)(&sim->lock);
	return simple_read_from_buffer(user, size, pos, record->codes,
				       (size_t)record->count * record->axes * sizeof(u32));
}

static const struct file_operations sim_record_bin_fops = {
	.owner = THIS_MODULE,
	.open = simple_open,
	.read = sim_record_bin_read,
	.llseek = default_llseek,
};

/**
 * xy3_sim_record_debugfs() - create the files
 * @sim: the head, whose directory exists
 */
void xy3_sim_record_debugfs(struct xy3_sim *sim)
{
	debugfs_create_file("record", 0644, sim->debugfs, sim, &sim_record_fops);
	debugfs_create_file("record.bin", 0444, sim->debugfs, sim, &sim_record_bin_fops);
}
