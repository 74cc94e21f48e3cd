// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: the files of its backchannel in debugfs
 */

#include <linux/errno.h>
#include <linux/kernel.h>
#include <linux/kstrtox.h>
#include <linux/seq_file.h>
#include <linux/string.h>

#include "sim.h"

/* Maximum bytes of one write to send */
#define SIM_SEND_MAX		512

static void sim_uart_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	const struct xy3_sim_uart *uart = &sim->uart;

	seq_printf(seq, "open %d\nspeed %u\nopenings %llu\npackets %llu\nbytes %llu\n"
		   "damaged_packets %llu\ngarbled_packets %llu\nsilenced_packets %llu\n"
		   "held_back %llu\nlost_bytes %llu\nwritten_bytes %lld\n",
		   uart->open, READ_ONCE(uart->speed), uart->openings, uart->packets, uart->bytes,
		   uart->damaged_packets, uart->garbled_packets, uart->silenced_packets,
		   uart->held_back, uart->lost_bytes, atomic64_read(&uart->written_bytes));
}

static void sim_rate_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	seq_printf(seq, "%u\n", sim->head.rate);
}

/* As if the head had kept this rate over a restart */
static int sim_rate_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	unsigned int rate;
	int err = kstrtouint(text, 0, &rate);

	if (err)
		return err;
	switch (rate) {
	case 57600:
	case 115200:
	case 230400:
	case 460800:
	case 921600:
		sim->head.rate = rate;
		return 0;
	}
	return -EINVAL;
}

static unsigned int *sim_ms(struct xy3_sim *sim, unsigned int index)
{
	return index ? &sim->telemetry.sync_ms : &sim->telemetry.interval_ms;
}

static void sim_ms_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	seq_printf(seq, "%u\n", *sim_ms(sim, index));
}

static int sim_ms_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	int err = kstrtouint(text, 0, sim_ms(sim, index));

	if (!err)
		xy3_sim_telemetry_soon(sim);
	return err;
}

static void sim_order_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	seq_printf(seq, "%s\n", sim->telemetry.big_endian ? "big" : "little");
}

static int sim_order_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	static const char * const orders[] = { "little", "big" };
	int order = match_string(orders, ARRAY_SIZE(orders), text);

	if (order < 0)
		return -EINVAL;
	sim->telemetry.big_endian = order;
	return 0;
}

static void sim_text_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	seq_printf(seq, "%s\n", sim->telemetry.text[index]);
}

static int sim_text_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	size_t length = strlen(text);

	if (length > XY3_SIM_TEXT_MAX || (length && length < 3))
		return -EINVAL;
	strscpy(sim->telemetry.text[index], text, sizeof(sim->telemetry.text[index]));
	return 0;
}

static void sim_array_show(struct seq_file *seq, struct xy3_sim *sim, unsigned int index)
{
	const struct xy3_sim_telemetry *telemetry = &sim->telemetry;

	for (unsigned int i = 0; i < telemetry->count[index]; i++) {
		s64 value = telemetry->value[index][i];

		if (i)
			seq_putc(seq, ' ');
		if (value == xy3_sim_array_kinds[index].none && value)
			seq_putc(seq, '-');
		else
			seq_printf(seq, "%lld", value);
	}
	seq_putc(seq, '\n');
}

static int sim_array_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	const struct xy3_sim_array_kind *kind = &xy3_sim_array_kinds[index];
	s64 value[XY3_SIM_COMPONENTS];
	unsigned int count = 0;
	char *word;

	while ((word = strsep(&text, " \t\n"))) {
		if (!*word)
			continue;
		if (count == ARRAY_SIZE(value))
			return -EINVAL;
		if (!strcmp(word, "-"))
			value[count] = kind->none;
		else if (kstrtos64(word, 0, &value[count]))
			return -EINVAL;
		if (value[count] < kind->min || value[count] > kind->max)
			return -ERANGE;
		count++;
	}
	memcpy(sim->telemetry.value[index], value, count * sizeof(*value));
	sim->telemetry.count[index] = count;
	return 0;
}

static int sim_can_send(struct xy3_sim *sim)
{
	if (!sim->uart.open)
		return -ENOTCONN;
	return xy3_sim_uart_room(sim) ? 0 : -ENOBUFS;
}

static int sim_report_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	int err = sim_can_send(sim);

	if (err)
		return err;
	xy3_sim_report(sim);
	return 0;
}

/* Any bytes, in hex, separated by blanks */
static int sim_send_store(struct xy3_sim *sim, char *text, unsigned int index)
{
	u8 bytes[SIM_SEND_MAX];
	size_t size = 0;
	char *word;
	int err;

	while ((word = strsep(&text, " \t\n"))) {
		if (!*word)
			continue;
		if (size == sizeof(bytes) || kstrtou8(word, 16, &bytes[size++]))
			return -EINVAL;
	}
	err = sim_can_send(sim);
	if (err)
		return err;
	xy3_sim_uart_send(sim, bytes, size, -1);
	xy3_sim_uart_push(sim);
	return 0;
}

const struct xy3_sim_file xy3_sim_uart_files[] = {
	{ "uart", sim_uart_show },
	{ "rate", sim_rate_show, sim_rate_store },
	{ "interval_ms", sim_ms_show, sim_ms_store, 0 },
	{ "sync_ms", sim_ms_show, sim_ms_store, 1 },
	{ "byte_order", sim_order_show, sim_order_store },
	{ "vendor", sim_text_show, sim_text_store, XY3_SIM_VENDOR },
	{ "model", sim_text_show, sim_text_store, XY3_SIM_VENDOR + 1 },
	{ "firmware", sim_text_show, sim_text_store, XY3_SIM_VENDOR + 2 },
	{ "serial", sim_text_show, sim_text_store, XY3_SIM_VENDOR + 3 },
	{ "temperatures", sim_array_show, sim_array_store, XY3_SIM_TEMPERATURES },
	{ "errors", sim_array_show, sim_array_store, XY3_SIM_ERRORS },
	{ "hours", sim_array_show, sim_array_store, XY3_SIM_HOURS },
	{ "report", NULL, sim_report_store },
	{ "send", NULL, sim_send_store },
};

const unsigned int xy3_sim_uart_file_count = ARRAY_SIZE(xy3_sim_uart_files);
