// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: packets of its backchannel, and faults in them
 *
 *   byte  0    1     2       3 ...
 *         48h  type  length  payload of length bytes
 */

#include <linux/jiffies.h>
#include <linux/kernel.h>
#include <linux/minmax.h>
#include <linux/string.h>
#include <linux/unaligned.h>

#include "sim.h"

#define SIM_START		0x48
#define SIM_HEADER		3
#define SIM_PAYLOAD_MAX		255
#define SIM_TYPE_SYNC		0x41
#define SIM_TYPE_VENDOR		0x01	/* model, firmware and serial number follow */
#define SIM_TYPE_FRAME_ERRORS	0x06
#define SIM_TEXT_MIN		3
#define SIM_NOISE_MAX		16

/* no packet of a known type is that long */
#define SIM_WRONG_LENGTH	255

/* Numbers of a head with two axes */
static const s64 sim_temperatures[] = { 3150, 4425, -32767, -32767, -32767, -32767, -32767,
	3800, 3850, -32767, -32767, -32767, 3675, 3650 };
static const s64 sim_hours[] = { 1200, 1200 };

const struct xy3_sim_array_kind xy3_sim_array_kinds[XY3_SIM_ARRAYS] = {
	[XY3_SIM_TEMPERATURES] = { 0x05, 2, S16_MIN, S16_MAX, -32767 },
	[XY3_SIM_ERRORS] = { 0x07, 1, 0, U8_MAX, 0 },
	[XY3_SIM_HOURS] = { 0x09, 4, 0, U32_MAX, U32_MAX },
};

/* ---- faults ---- */

static void sim_noise(struct xy3_sim *sim)
{
	u8 noise[SIM_NOISE_MAX];
	unsigned int size = 1 + xy3_sim_random(sim, SIM_NOISE_MAX);

	for (unsigned int i = 0; i < size; i++)
		noise[i] = xy3_sim_random(sim, 256);
	xy3_sim_uart_send(sim, noise, size, -1);
}

/* Whether the packet is still unchanged */
static bool sim_damage(struct xy3_sim *sim, u8 *packet, size_t *size, int *line_error)
{
	bool whole = true;
	size_t at;

	if (xy3_sim_fault(sim, XY3_SIM_UART_LOST)) {
		at = xy3_sim_random(sim, *size);
		memmove(packet + at, packet + at + 1, --*size - at);
		whole = false;
	}
	if (xy3_sim_fault(sim, XY3_SIM_UART_DOUBLED)) {
		at = xy3_sim_random(sim, *size);
		memmove(packet + at + 1, packet + at, (*size)++ - at);
		whole = false;
	}
	if (xy3_sim_fault(sim, XY3_SIM_UART_FLIPPED)) {
		packet[xy3_sim_random(sim, *size)] ^= BIT(xy3_sim_random(sim, 8));
		whole = false;
	}
	if (xy3_sim_fault(sim, XY3_SIM_UART_LENGTH)) {
		packet[SIM_HEADER - 1] = SIM_WRONG_LENGTH;
		whole = false;
	}
	if (xy3_sim_fault(sim, XY3_SIM_UART_TORN)) {
		*size = (*size + 1) / 2;
		whole = false;
	}
	if (xy3_sim_fault(sim, XY3_SIM_UART_LINE_ERROR)) {
		*line_error = xy3_sim_random(sim, *size);
		whole = false;
	}
	return whole;
}

/* ---- packets ---- */

static void sim_packet(struct xy3_sim *sim, u8 type, const void *payload, size_t length)
{
	u8 packet[SIM_HEADER + SIM_PAYLOAD_MAX + 1] = { SIM_START, type, length };
	size_t size = SIM_HEADER + length;
	int line_error = -1;

	if (xy3_sim_fault(sim, XY3_SIM_UART_SILENCE)) {
		sim->uart.silenced_packets++;
		return;
	}
	if (xy3_sim_fault(sim, XY3_SIM_UART_NOISE))
		sim_noise(sim);
	if (length)
		memcpy(packet + SIM_HEADER, payload, length);
	if (!sim_damage(sim, packet, &size, &line_error)) {
		sim->uart.damaged_packets++;
	} else if (READ_ONCE(sim->uart.speed) == sim->head.rate) {
		sim->uart.packets++;
		sim->uart.bytes += size;
	}
	xy3_sim_uart_send(sim, packet, size, line_error);
}

static void sim_put_number(const struct xy3_sim *sim, u8 *to, s64 value, unsigned int size)
{
	for (unsigned int i = 0; i < size; i++)
		to[sim->telemetry.big_endian ? size - 1 - i : i] = value >> 8 * i;
}

static void sim_report_text(struct xy3_sim *sim, unsigned int which)
{
	const char *text = sim->telemetry.text[which];
	size_t length = strlen(text);

	if (length >= SIM_TEXT_MIN)
		sim_packet(sim, SIM_TYPE_VENDOR + which, text, length);
}

static void sim_report_array(struct xy3_sim *sim, enum xy3_sim_array which)
{
	const struct xy3_sim_array_kind *kind = &xy3_sim_array_kinds[which];
	unsigned int count = sim->telemetry.count[which];
	u8 payload[XY3_SIM_COMPONENTS * sizeof(u32)];

	for (unsigned int i = 0; i < count; i++)
		sim_put_number(sim, payload + i * kind->size, sim->telemetry.value[which][i],
			       kind->size);
	if (count)
		sim_packet(sim, kind->type, payload, count * kind->size);
}

static void sim_report_frame_errors(struct xy3_sim *sim)
{
	u8 payload[XY3_SIM_AXES * sizeof(u32)];

	for (unsigned int i = 0; i < XY3_SIM_AXES; i++)
		sim_put_number(sim, payload + i * sizeof(u32),
			       xy3_sim_bad_frames(&sim->head.axis[i]), sizeof(u32));
	sim_packet(sim, SIM_TYPE_FRAME_ERRORS, payload, sizeof(payload));
}

static void sim_report_sync(struct xy3_sim *sim)
{
	sim_packet(sim, SIM_TYPE_SYNC, NULL, 0);
}

/**
 * xy3_sim_report() - send a round of all packets, between two sync packets
 * @sim: the head; its lock is held
 */
void xy3_sim_report(struct xy3_sim *sim)
{
	sim_report_sync(sim);
	for (unsigned int i = 0; i < XY3_SIM_TEXTS; i++)
		sim_report_text(sim, i);
	for (unsigned int i = 0; i < XY3_SIM_ARRAYS; i++)
		sim_report_array(sim, i);
	sim_report_frame_errors(sim);
	sim_report_sync(sim);
	xy3_sim_uart_push(sim);
}

/* ---- intervals ---- */

/* Whether something is due; limits the ms to wait to the next time that something is due */
static bool sim_due(unsigned int ms, unsigned long now, unsigned long *next, unsigned long *wait)
{
	bool due;

	if (!ms)
		return false;
	due = time_after_eq(now, *next);
	if (due)
		*next = now + msecs_to_jiffies(ms);
	*wait = min(*wait, *next - now);
	return due;
}

/**
 * xy3_sim_telemetry_work() - send packets that are due
 * @work: of a head
 */
void xy3_sim_telemetry_work(struct work_struct *work)
{
	struct xy3_sim *sim = container_of(to_delayed_work(work), struct xy3_sim, work);
	struct xy3_sim_telemetry *telemetry = &sim->telemetry;
	unsigned long now = jiffies;
	unsigned long wait = MAX_JIFFY_OFFSET;
	bool round, sync;

	guard(mutex)(&sim->lock);
	round = sim_due(telemetry->interval_ms, now, &telemetry->next_round, &wait);
	sync = sim_due(telemetry->sync_ms, now, &telemetry->next_sync, &wait);
	if (!sim->uart.open || sim->gone)
		return;
	if ((round || sync) && !xy3_sim_uart_room(sim)) {
		sim->uart.held_back++;
	} else if (round) {
		xy3_sim_report(sim);
	} else if (sync) {
		sim_report_sync(sim);
		xy3_sim_uart_push(sim);
	}
	if (wait < MAX_JIFFY_OFFSET)
		queue_delayed_work(system_percpu_wq, &sim->work, wait);
}

static void sim_set_array(struct xy3_sim *sim, enum xy3_sim_array which, const s64 *value,
			  unsigned int count)
{
	memcpy(sim->telemetry.value[which], value, count * sizeof(*value));
	sim->telemetry.count[which] = count;
}

/**
 * xy3_sim_telemetry_init() - set the values that a new head reports
 * @sim: the head
 */
void xy3_sim_telemetry_init(struct xy3_sim *sim)
{
	struct xy3_sim_telemetry *telemetry = &sim->telemetry;
	static const char * const texts[XY3_SIM_TEXTS - 1] = { "Virtual", "Head-Sim", "1.0.0" };

	for (unsigned int i = 0; i < ARRAY_SIZE(texts); i++)
		strscpy(telemetry->text[i], texts[i], sizeof(telemetry->text[i]));
	snprintf(telemetry->text[XY3_SIM_TEXTS - 1], sizeof(telemetry->text[0]), "SIM-%04u",
		 sim->number + 1);
	sim_set_array(sim, XY3_SIM_TEMPERATURES, sim_temperatures, ARRAY_SIZE(sim_temperatures));
	sim_set_array(sim, XY3_SIM_HOURS, sim_hours, ARRAY_SIZE(sim_hours));
	telemetry->count[XY3_SIM_ERRORS] = XY3_SIM_COMPONENTS;
	telemetry->interval_ms = sim->config.interval_ms;
	telemetry->sync_ms = sim->config.sync_ms;
	INIT_DELAYED_WORK(&sim->work, xy3_sim_telemetry_work);
}
