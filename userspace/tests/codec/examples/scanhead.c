// SPDX-License-Identifier: GPL-2.0-only
/*
 * The examples of userspace/doc/protocol-xy3.md, converted by the codec of the driver
 */
#include "../../../../drivers/xy3/xy3-frame.c"
#include "../../../../drivers/xy3/xy3-lines.c"
#include "../../../../drivers/xy3/xy3-packet.c"
#include "example.h"

/* ---- forward channel ---- */

static const struct {
	const char *name;
	u32 code;
	bool takes_axes;
} commands[] = {
	{ "autocalib on", XY3_COMMAND_AUTOCALIB_ON_AXES, true },
	{ "autocalib off", XY3_COMMAND_AUTOCALIB_OFF_AXES, true },
	{ "calibrate", XY3_COMMAND_CALIBRATE_AXES, true },
	{ "reference", XY3_COMMAND_REFERENCE_AXES, true },
	{ "temp_comp on", XY3_COMMAND_TEMP_COMP_ON_AXES, true },
	{ "temp_comp off", XY3_COMMAND_TEMP_COMP_OFF_AXES, true },
	{ "rate 57600", XY3_COMMAND_RATE_57600 },
	{ "rate 115200", XY3_COMMAND_RATE_115200 },
	{ "rate 230400", XY3_COMMAND_RATE_230400 },
	{ "rate 460800", XY3_COMMAND_RATE_460800 },
	{ "rate 921600", XY3_COMMAND_RATE_921600 },
};

static void add_command(struct example *example, u32 data)
{
	for (size_t i = 0; i < ARRAY_SIZE(commands); i++) {
		u32 axes = data ^ commands[i].code;

		if (axes && (!commands[i].takes_axes || axes & ~XY3_COMMAND_AXES))
			continue;
		example_add(example, "", "command %s%s", commands[i].name, axes ? " " : "");
		for (unsigned int axis = 0; axis < XY3_AXES; axis++)
			if (axes & XY3_COMMAND_AXIS(axis))
				example_add(example, "", "%s", xy3_axis_name(axis));
		return;
	}
	example_add(example, "", "command %05x", data);
}

static void frame(struct example *example)
{
	struct xy3_frame frame;

	xy3_decode_frame(example->bytes, example->size, &frame);
	example->words[0] = '\0';
	if (frame.verdict == XY3_FRAME_TORN || frame.size != example->size)
		example_add(example, "", "torn");
	else if (frame.verdict == XY3_FRAME_BAD_PARITY)
		example_add(example, "", "bad parity");
	else if (frame.verdict == XY3_FRAME_POSITION)
		example_add(example, "", "position %u", frame.data);
	else
		add_command(example, frame.data);
}

static u32 command_code(const char *words)
{
	for (size_t i = 0; i < ARRAY_SIZE(commands); i++) {
		size_t length = strlen(commands[i].name);
		u32 axes;

		if (strncmp(words, commands[i].name, length) == 0 &&
		    xy3_parse_axes(words + length, &axes) == 0)
			return commands[i].code | axes;
	}
	return 0;
}

/* The signals of the lines: a word for each, from IO0 on. Return their number. */
static unsigned int read_signals(char *about, u8 *signal)
{
	unsigned int lines = 0;
	char *word;

	while (lines < XY3_LINES_MAX && (word = strsep(&about, " "))) {
		signal[lines] = XY3_SIGNAL_NONE;
		for (unsigned int axis = 0; axis < XY3_AXES; axis++)
			if (!strcmp(word, xy3_axis_name(axis)))
				signal[lines] = axis;
		if (!strcmp(word, "sync"))
			signal[lines] = XY3_SIGNAL_SYNC;
		if (!strcmp(word, "gate"))
			signal[lines] = XY3_SIGNAL_GATE;
		lines++;
	}
	return lines;
}

/*
 * About: bits of a frame, and the signals. The words: a code for each axis and 1 or 0 for the
 * gate, or a command.
 */
static void scan(struct example *example)
{
	char *about = example->about;
	unsigned int frame_bits = strtoul(strsep(&about, " "), NULL, 10);
	u8 signal[XY3_LINES_MAX];
	struct xy3_line_map map;
	u32 codes[XY3_COLUMNS_MAX] = { };
	char *at = example->words;

	example->size = 0;
	if (xy3_line_map_init(&map, read_signals(about, signal), frame_bits, signal))
		return;
	example->size = map.scan_size;
	if (str_has_prefix(at, "command ")) {
		xy3_encode_command_scan(&map, command_code(at + strlen("command ")),
					example->bytes);
		return;
	}
	for (unsigned int i = 0; i < map.columns; i++)
		codes[i] = strtoul(at, &at, 10);
	xy3_encode_scans(&map, codes, 1, example->bytes);
}

/* ---- backchannel ---- */

static const char * const names[] = {
	[XY3_PACKET_VENDOR] = "vendor",
	[XY3_PACKET_MODEL] = "model",
	[XY3_PACKET_FIRMWARE] = "firmware",
	[XY3_PACKET_SERIAL] = "serial",
	[XY3_PACKET_TEMPERATURES] = "temperatures",
	[XY3_PACKET_FRAME_ERRORS] = "frame_errors",
	[XY3_PACKET_ERRORS] = "errors",
	[XY3_PACKET_DEBUG] = "debug",
	[XY3_PACKET_HOURS] = "hours",
	[XY3_PACKET_SYNC] = "sync",
};

static void add_temperatures(struct example *example, const struct xy3_packet *packet,
			     enum xy3_byte_order order)
{
	s16 value[XY3_COMPONENTS];
	unsigned int count = xy3_packet_temperatures(packet, order, value);

	for (unsigned int i = 0; i < count; i++) {
		if (value[i] == XY3_TEMPERATURE_NONE)
			example_add(example, " ", "-");
		else
			example_add(example, " ", "%.2f", value[i] / 100.0);
	}
}

static void add_hours(struct example *example, const struct xy3_packet *packet,
		      enum xy3_byte_order order)
{
	u32 value[XY3_COMPONENTS];
	unsigned int count = xy3_packet_hours(packet, order, value);

	for (unsigned int i = 0; i < count; i++) {
		if (value[i] == XY3_HOURS_NONE)
			example_add(example, " ", "-");
		else
			example_add(example, " ", "%u", value[i]);
	}
}

static void add_frame_errors(struct example *example, const struct xy3_packet *packet,
			     enum xy3_byte_order order)
{
	u32 value[XY3_AXES];
	unsigned int count = xy3_packet_frame_errors(packet, order, value);

	for (unsigned int i = 0; i < count; i++)
		example_add(example, " ", "%u", value[i]);
}

static void add_errors(struct example *example, const struct xy3_packet *packet)
{
	u8 value[XY3_COMPONENTS];
	unsigned int count = xy3_packet_errors(packet, value);

	for (unsigned int i = 0; i < count; i++) {
		if (xy3_error_name(value[i]))
			example_add(example, " ", "%s", xy3_error_name(value[i]));
		else
			example_add(example, " ", "%u", value[i]);
	}
}

static void add_content(struct example *example, const struct xy3_packet *packet,
			enum xy3_byte_order order)
{
	char text[XY3_PACKET_MAX];

	switch (packet->type) {
	case XY3_PACKET_TEMPERATURES:
		return add_temperatures(example, packet, order);
	case XY3_PACKET_FRAME_ERRORS:
		return add_frame_errors(example, packet, order);
	case XY3_PACKET_ERRORS:
		return add_errors(example, packet);
	case XY3_PACKET_HOURS:
		return add_hours(example, packet, order);
	case XY3_PACKET_SYNC:
		return;
	default:
		xy3_packet_text(packet, text, sizeof(text));
		return example_add(example, " ", "\"%s\"", text);
	}
}

static void add_name(struct example *example, const struct xy3_packet *packet)
{
	if (packet->known)
		example_add(example, ", ", "%s", names[packet->type]);
	else
		example_add(example, ", ", "unknown %02x", packet->type);
}

/* A single packet, after a sync packet */
static void packet(struct example *example)
{
	enum xy3_byte_order order = strcmp(example->about, "big") ? XY3_LITTLE_ENDIAN :
								    XY3_BIG_ENDIAN;
	static const u8 sync[] = { 0x48, 0x41, 0x00 };
	struct xy3_parser parser = { };
	struct xy3_packet packet;
	const u8 *data = sync;
	size_t size = sizeof(sync);

	example->words[0] = '\0';
	xy3_parse(&parser, &data, &size, &packet);
	data = example->bytes;
	size = example->size;
	if (!xy3_parse(&parser, &data, &size, &packet) ||	/* the sync packet */
	    !xy3_parse(&parser, &data, &size, &packet) || size) {
		example_add(example, "", "no packet");
		return;
	}
	add_name(example, &packet);
	add_content(example, &packet, order);
}

/* A whole stream, at once: its packets, and the counts of other bytes */
static void stream(struct example *example)
{
	struct xy3_parser parser = { };
	struct xy3_packet packet;
	const u8 *data = example->bytes;
	size_t size = example->size;

	example->words[0] = '\0';
	while (xy3_parse(&parser, &data, &size, &packet))
		add_name(example, &packet);
	if (parser.dropped_bytes)
		example_add(example, ", ", "%u dropped", (unsigned int)parser.dropped_bytes);
	if (parser.kept)
		example_add(example, ", ", "%u kept", parser.kept);
	example_add(example, ", ", parser.in_sync ? "in sync" : "out of sync");
}

static const struct example_kind kinds[] = {
	{ "frame", frame },
	{ "scan", scan },
	{ "packet", packet },
	{ "stream", stream },
};

int main(void)
{
	return example_main(kinds, ARRAY_SIZE(kinds));
}
