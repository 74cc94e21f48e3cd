// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 scanhead: reports of the head
 */

#include <linux/bitops.h>
#include <linux/lockdep.h>
#include <linux/string.h>

#include "xy3.h"

static void xy3_update_text(struct xy3_head *head, enum xy3_text which,
			    const struct xy3_packet *packet)
{
	char text[XY3_TEXT_MAX + 1];

	xy3_packet_text(packet, text, sizeof(text));
	if (!strcmp(text, head->telemetry.text[which]))
		return;
	strscpy(head->telemetry.text[which], text, sizeof(head->telemetry.text[which]));
	head->events.identity = true;
}

static void xy3_update_temperatures(struct xy3_head *head, const struct xy3_packet *packet)
{
	struct xy3_telemetry *now = &head->telemetry;

	now->temperatures = xy3_packet_temperatures(packet, head->order, now->temperature);
	for (unsigned int i = 0; i < now->temperatures; i++)
		if (now->temperature[i] != XY3_TEMPERATURE_NONE)
			head->events.thermometers |= BIT(i);
}

/*
 * A component that the newest packet leaves out keeps its error, which the head has not revoked,
 * but the attribute no longer shows it. If the component has an error, that is a change, and so is
 * its reappearance.
 */
static void xy3_set_errors(struct xy3_head *head, unsigned int count, const u8 *error)
{
	struct xy3_telemetry *now = &head->telemetry;

	for (unsigned int i = 0; i < XY3_COMPONENTS; i++) {
		bool had_error = now->error[i] != XY3_ERROR_NONE;

		if (i >= count) {
			if (i < now->errors && had_error)
				head->events.errors |= BIT(i);
			continue;
		}
		if (now->error[i] != error[i] || (i >= now->errors && had_error))
			head->events.errors |= BIT(i);
		now->error[i] = error[i];
	}
	now->errors = count;
}

static void xy3_update_errors(struct xy3_head *head, const struct xy3_packet *packet)
{
	u8 error[XY3_COMPONENTS];
	unsigned int count = xy3_packet_errors(packet, error);

	xy3_set_errors(head, count, error);
}

/**
 * xy3_telemetry_packet() - update the state from a packet
 * @head: the head; its lock is held
 * @packet: the packet
 */
void xy3_telemetry_packet(struct xy3_head *head, const struct xy3_packet *packet)
{
	struct xy3_telemetry *now = &head->telemetry;
	u32 thermometers = head->events.thermometers;

	lockdep_assert_held(&head->lock);
	switch (packet->type) {
	case XY3_PACKET_VENDOR:
		xy3_update_text(head, XY3_VENDOR, packet);
		break;
	case XY3_PACKET_MODEL:
		xy3_update_text(head, XY3_MODEL, packet);
		break;
	case XY3_PACKET_FIRMWARE:
		xy3_update_text(head, XY3_FIRMWARE, packet);
		break;
	case XY3_PACKET_SERIAL:
		xy3_update_text(head, XY3_SERIAL, packet);
		break;
	case XY3_PACKET_TEMPERATURES:
		xy3_update_temperatures(head, packet);
		break;
	case XY3_PACKET_FRAME_ERRORS:
		now->frame_error_counts =
			xy3_packet_frame_errors(packet, head->order, now->frame_errors);
		break;
	case XY3_PACKET_ERRORS:
		xy3_update_errors(head, packet);
		break;
	case XY3_PACKET_HOURS:
		now->hour_counts = xy3_packet_hours(packet, head->order, now->hours);
		break;
	default:
		return;
	}
	if (head->events.identity || head->events.errors ||
	    head->events.thermometers != thermometers)
		xy3_notify_schedule(head);
}

/**
 * xy3_telemetry_forget_numbers() - forget numbers read in another byte order
 * @head: the head; its lock is held
 */
void xy3_telemetry_forget_numbers(struct xy3_head *head)
{
	lockdep_assert_held(&head->lock);
	head->telemetry.temperatures = 0;
	head->telemetry.hour_counts = 0;
	head->telemetry.frame_error_counts = 0;
}

/**
 * xy3_telemetry_forget() - forget all: the backchannel was removed, and sync is lost
 * @head: the head; its lock is held
 */
void xy3_telemetry_forget(struct xy3_head *head)
{
	struct xy3_telemetry *now = &head->telemetry;

	lockdep_assert_held(&head->lock);
	head->events.sync |= head->parser.in_sync;
	xy3_parse_lost(&head->parser, 0);
	xy3_set_errors(head, 0, NULL);
	for (unsigned int i = 0; i < XY3_TEXTS; i++)
		head->events.identity |= now->text[i][0] != '\0';
	memset(now->text, 0, sizeof(now->text));
	xy3_telemetry_forget_numbers(head);
	xy3_notify_schedule(head);
}
