// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: /sys/kernel/debug/xy3-sim/<n>/
 *
 * One table of files; each shows text, accepts text, or both. Faults are numbers in faults/.
 */

#include <linux/atomic.h>
#include <linux/cleanup.h>
#include <linux/debugfs.h>
#include <linux/err.h>
#include <linux/fs.h>
#include <linux/kernel.h>
#include <linux/kstrtox.h>
#include <linux/platform_device.h>
#include <linux/seq_file.h>
#include <linux/slab.h>
#include <linux/spi/spi.h>
#include <linux/string.h>

#include "sim.h"

/* Length of written text: an array of 22 numbers, or a packet in hex */
#define SIM_WRITE_MAX		1024

/* Maximum time for which the bus can be locked */
#define SIM_LOCK_MAX_MS		10000

static struct dentry *sim_root;

/* ---- the receiver ---- */

static const char sim_axes[] = "xyzuw";

static void sim_positions_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	for (unsigned int i = 0; i < XY3_SIM_AXES; i++) {
		const struct xy3_sim_axis *axis = &sim->head.axis[i];

		if (axis->line < 0)
			continue;
		if (axis->bits)
			seq_printf(seq, "%c %u %u\n", sim_axes[i], axis->code, axis->bits);
		else
			seq_printf(seq, "%c -\n", sim_axes[i]);
	}
}

/* A count of each axis; index is its offset in struct xy3_sim_axis */
static void sim_axis_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	for (unsigned int i = 0; i < XY3_SIM_AXES; i++)
		if (sim->head.axis[i].line >= 0)
			seq_printf(seq, "%c %llu\n", sim_axes[i],
				   *(u64 *)((u8 *)&sim->head.axis[i] + index));
}

static void sim_letters(struct seq_file *seq, u32 axes)
{
	for (unsigned int i = 0; i < XY3_SIM_AXES; i++)
		if (axes >> i & 1)
			seq_putc(seq, sim_axes[i]);
	if (!axes)
		seq_putc(seq, '-');
}

static void sim_commands_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	const struct xy3_sim_head *head = &sim->head;
	u64 first = head->commands > XY3_SIM_COMMANDS ? head->commands - XY3_SIM_COMMANDS : 0;

	for (u64 at = first; at < head->commands; at++) {
		const struct xy3_sim_command *command = &head->log[at % XY3_SIM_COMMANDS];
		bool axes;
		const char *name = xy3_sim_command_name(command->code, &axes);

		seq_printf(seq, "%llu %05x %s", command->scan, command->code, name ?: "unknown");
		if (axes) {
			seq_putc(seq, ' ');
			sim_letters(seq, command->code & 0x1f ?: 0x1f);
		}
		seq_putc(seq, '\n');
	}
}

static void sim_state_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	const struct xy3_sim_head *head = &sim->head;
	const struct {
		const char *name;
		u32 axes;
	} rows[] = {
		{ "autocalib", head->autocalib },
		{ "temp_comp", head->temp_comp },
		{ "calibrated", head->calibrated },
		{ "referenced", head->referenced },
	};

	for (unsigned int i = 0; i < ARRAY_SIZE(rows); i++) {
		seq_printf(seq, "%s ", rows[i].name);
		sim_letters(seq, rows[i].axes);
		seq_putc(seq, '\n');
	}
}

static void sim_stats_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	const struct xy3_sim_head *head = &sim->head;

	seq_printf(seq, "scans %llu\ncommands %llu\nunknown_commands %llu\nshort_gaps %llu\n"
		   "stalled_frames %llu\nstray_clocks %llu\nrecorded %u\nrecord_room %u\n",
		   head->scans, head->commands, head->unknown_commands, head->short_gaps,
		   head->stalled_frames, head->stray_clocks, sim->record.count, sim->record.room);
}

static void sim_gate_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	const struct xy3_sim_head *head = &sim->head;

	seq_printf(seq, "high %d\nscans %llu\ntorn %llu\ncommands %llu\n", head->gate_high,
		   head->gate_scans, head->gate_torn, head->gate_commands);
}

static void sim_signals_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	for (unsigned int i = 0; i < sim->head.lines; i++)
		seq_printf(seq, "%s%s", i ? " " : "", xy3_sim_signal_name(sim->head.signal[i]));
	seq_putc(seq, '\n');
}

static int sim_signals_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	u8 signal[XY3_SIM_LINES_MAX];
	int err = xy3_sim_parse_signals(text, sim->head.lines, signal);

	if (err)
		return err;
	xy3_sim_head_wire(sim, sim->head.lines, signal);
	/* other axes, other columns */
	return xy3_sim_record_start(sim, 0, false);
}

/* Reset all counts to 0, and stop recording scans */
static void sim_reset_counts(struct xy3_sim *sim)
{
	struct xy3_sim_head *head = &sim->head;
	struct xy3_sim_uart *uart = &sim->uart;

	for (unsigned int i = 0; i < XY3_SIM_AXES; i++) {
		struct xy3_sim_axis *axis = &head->axis[i];

		*axis = (struct xy3_sim_axis) {
			.line = axis->line, .bits = axis->bits, .code = axis->code,
		};
	}
	head->scans = 0;
	head->short_gaps = 0;
	head->stalled_frames = 0;
	head->stray_clocks = 0;
	head->gate_scans = 0;
	head->gate_torn = 0;
	head->gate_commands = 0;
	head->commands = 0;
	head->unknown_commands = 0;
	sim->bus = (struct xy3_sim_bus) { };
	uart->openings = 0;
	uart->packets = 0;
	uart->bytes = 0;
	uart->damaged_packets = 0;
	uart->garbled_packets = 0;
	uart->silenced_packets = 0;
	uart->held_back = 0;
	uart->lost_bytes = 0;
	atomic64_set(&uart->written_bytes, 0);
	for (unsigned int i = 0; i < XY3_SIM_FAULTS; i++)
		atomic_set(&sim->fault_count[i], 0);
	sim->frames = 0;
	sim->message = 0;
	xy3_sim_record_start(sim, 0, false);
}

/* The head loses its state and its counts */
static void sim_power_cycle(struct xy3_sim *sim)
{
	struct xy3_sim_head *head = &sim->head;

	sim_reset_counts(sim);
	for (unsigned int i = 0; i < XY3_SIM_AXES; i++) {
		head->axis[i].bits = 0;
		head->axis[i].code = 0;
	}
	head->inside = false;
	head->stalled = false;
	head->clocks = 0;
	head->gap = XY3_SIM_GAP_CLOCKS;
	head->autocalib = 0;
	head->temp_comp = 0;
	head->calibrated = 0;
	head->referenced = 0;
	head->rate = XY3_SIM_RATE_DEFAULT;
	xy3_sim_telemetry_soon(sim);
}

static int sim_reset_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	if (!strcmp(text, "counts"))
		sim_reset_counts(sim);
	else if (!strcmp(text, "power"))
		sim_power_cycle(sim);
	else
		return -EINVAL;
	return 0;
}

/* ---- the bus ---- */

static void sim_bus_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	const struct xy3_sim_bus *bus = &sim->bus;

	seq_printf(seq, "messages %llu\nfailed_messages %llu\ntransfers %llu\nclocks %llu\n"
		   "busy_ns %llu\ndelay_ns %llu\nstalled_ns %llu\ngaps %llu\ngap_ns %llu\n"
		   "longest_gap_ns %llu\nturnaround_ns %llu\nlongest_silence_ns %llu\n"
		   "prepared %d\n",
		   bus->messages, bus->failed_messages, bus->transfers, bus->clocks,
		   bus->busy_ns, bus->delay_ns, bus->stalled_ns, bus->gaps, bus->gap_ns,
		   bus->longest_gap_ns, bus->turnaround_ns, bus->longest_silence_ns,
		   atomic_read(&sim->prepared));
}

static void sim_realtime_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	seq_printf(seq, "%d\n", sim->realtime);
}

static int sim_realtime_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	int err = kstrtobool(text, &sim->realtime);

	/* a sender may be far ahead of the wire */
	if (!err)
		sim->bus.started = false;
	return err;
}

static int sim_bus_lock_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	unsigned int ms;
	int err = kstrtouint(text, 10, &ms);

	if (err)
		return err;
	if (ms > SIM_LOCK_MAX_MS)
		return -ERANGE;
	WRITE_ONCE(sim->bus_lock_ms, ms);
	schedule_work(&sim->bus_lock);
	return 0;
}

static void sim_devices_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	seq_printf(seq, "spi %s\nspidev spidev%d.0\ntty ttyXY3SIM%u\n", sim->spi_name,
		   sim->controller->bus_num, sim->number);
}

/* ---- all of them ---- */

#define SIM_AXIS_COUNT(count) \
	{ #count, sim_axis_show, NULL, offsetof(struct xy3_sim_axis, count) }

static const struct xy3_sim_file sim_files[] = {
	{ "devices", sim_devices_show },
	{ "signals", sim_signals_show, sim_signals_store },
	{ "reset", NULL, sim_reset_store },
	{ "positions", sim_positions_show },
	SIM_AXIS_COUNT(frames),
	SIM_AXIS_COUNT(parity_errors),
	SIM_AXIS_COUNT(length_errors),
	SIM_AXIS_COUNT(mode_errors),
	SIM_AXIS_COUNT(idle),
	{ "stats", sim_stats_show },
	{ "gate", sim_gate_show },
	{ "commands", sim_commands_show },
	{ "state", sim_state_show },
	{ "bus", sim_bus_show },
	{ "realtime", sim_realtime_show, sim_realtime_store },
	{ "bus_lock_ms", NULL, sim_bus_lock_store },
};

static const char * const sim_fault_names[XY3_SIM_FAULTS] = {
	[XY3_SIM_SPI_FLIP] = "spi_flip",
	[XY3_SIM_SPI_FLIP_EVERY] = "spi_flip_every",
	[XY3_SIM_SPI_FLIP_LINE] = "spi_flip_line",
	[XY3_SIM_SPI_FLIP_CLOCK] = "spi_flip_clock",
	[XY3_SIM_SPI_CLOCK] = "spi_clock",
	[XY3_SIM_SPI_ERROR_IN] = "spi_error_in",
	[XY3_SIM_SPI_ERROR_EVERY] = "spi_error_every",
	[XY3_SIM_SPI_STALL_MS] = "spi_stall_ms",
	[XY3_SIM_UART_SILENCE] = "uart_silence",
	[XY3_SIM_UART_NOISE] = "uart_noise",
	[XY3_SIM_UART_LOST] = "uart_lost",
	[XY3_SIM_UART_DOUBLED] = "uart_doubled",
	[XY3_SIM_UART_FLIPPED] = "uart_flipped",
	[XY3_SIM_UART_TORN] = "uart_torn",
	[XY3_SIM_UART_LENGTH] = "uart_length",
	[XY3_SIM_UART_LINE_ERROR] = "uart_line_error",
};

static int sim_file_show(struct seq_file *seq, void *data)
{
	struct xy3_sim_node *node = seq->private;

	/* root can ignore permissions */
	if (!node->file->show)
		return -EINVAL;
	guard(mutex)(&node->sim->lock);
	node->file->show(seq, node->sim, node->file->index);
	return 0;
}

static int sim_file_open(struct inode *inode, struct file *file)
{
	return single_open(file, sim_file_show, inode->i_private);
}

static ssize_t sim_file_write(struct file *file, const char __user *user, size_t size,
			      loff_t *pos)
{
	struct xy3_sim_node *node = ((struct seq_file *)file->private_data)->private;
	char *text;
	int err;

	if (!node->file->store || size > SIM_WRITE_MAX)
		return -EINVAL;
	text = memdup_user_nul(user, size);
	if (IS_ERR(text))
		return PTR_ERR(text);
	scoped_guard(mutex, &node->sim->lock)
		err = node->file->store(node->sim, strim(text), node->file->index);
	kfree(text);
	return err ?: size;
}

static const struct file_operations sim_file_fops = {
	.owner = THIS_MODULE,
	.open = sim_file_open,
	.read = seq_read,
	.write = sim_file_write,
	.llseek = seq_lseek,
	.release = single_release,
};

static int sim_injected_show(struct seq_file *seq, void *data)
{
	struct xy3_sim *sim = seq->private;

	for (unsigned int i = 0; i < XY3_SIM_FAULTS; i++)
		seq_printf(seq, "%s %d\n", sim_fault_names[i], atomic_read(&sim->fault_count[i]));
	return 0;
}
DEFINE_SHOW_ATTRIBUTE(sim_injected);

static void sim_debugfs_remove(void *data)
{
	struct xy3_sim *sim = data;

	debugfs_remove(sim->debugfs);
}

static void sim_add_files(struct xy3_sim *sim, const struct xy3_sim_file *files,
			  unsigned int count)
{
	for (const struct xy3_sim_file *file = files; file < files + count; file++) {
		umode_t mode = (file->show ? 0444 : 0) | (file->store ? 0200 : 0);
		struct xy3_sim_node *node;

		if (WARN_ON_ONCE(sim->node_count == XY3_SIM_NODES))
			return;
		node = &sim->nodes[sim->node_count++];
		*node = (struct xy3_sim_node) { .sim = sim, .file = file };
		debugfs_create_file(file->name, mode, sim->debugfs, node, &sim_file_fops);
	}
}

/**
 * xy3_sim_debugfs_add() - create the directory of a head
 * @sim: the head
 *
 * It is removed with the platform device.
 *
 * Return: 0 or -ENOMEM.
 */
int xy3_sim_debugfs_add(struct xy3_sim *sim)
{
	struct dentry *faults;
	char name[12];

	snprintf(name, sizeof(name), "%u", sim->number);
	sim->debugfs = debugfs_create_dir(name, sim_root);
	sim_add_files(sim, sim_files, ARRAY_SIZE(sim_files));
	sim_add_files(sim, xy3_sim_uart_files, xy3_sim_uart_file_count);
	xy3_sim_record_debugfs(sim);
	faults = debugfs_create_dir("faults", sim->debugfs);
	for (unsigned int i = 0; i < XY3_SIM_FAULTS; i++)
		debugfs_create_atomic_t(sim_fault_names[i], 0644, faults, &sim->fault[i]);
	debugfs_create_file("injected", 0444, sim->debugfs, sim, &sim_injected_fops);
	return devm_add_action_or_reset(&sim->pdev->dev, sim_debugfs_remove, sim);
}

/**
 * xy3_sim_debugfs_init() - create the directory of all heads
 */
void xy3_sim_debugfs_init(void)
{
	sim_root = debugfs_create_dir("xy3-sim", NULL);
}

/**
 * xy3_sim_debugfs_exit() - remove the directory of all heads
 */
void xy3_sim_debugfs_exit(void)
{
	debugfs_remove(sim_root);
}
