// SPDX-License-Identifier: GPL-2.0-only
/*
 * The public functions that require no device, with only the installed header and shared library.
 * Expected values are written in bytes, or computed bit by bit.
 */

#include <errno.h>
#include <libxy3.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"

/* ---- names, rates and axes ---- */

static void names(void)
{
	CHECK(!strcmp(xy3_component_name(XY3_HEAD), "head"));
	CHECK(!strcmp(xy3_component_name(XY3_MIRROR_W), "mirror_w"));
	CHECK(!xy3_component_name(XY3_COMPONENTS));
	CHECK(!strcmp(xy3_axis_name(XY3_AXIS_U), "u"));
	CHECK(!xy3_axis_name(XY3_AXES));
	CHECK(!strcmp(xy3_error_name(XY3_ERROR_MECHANICAL), "mechanical"));
	CHECK(!xy3_error_name(XY3_ERROR_VENDOR));
}

static void rates(void)
{
	static const unsigned int want[] = { 57600, 115200, 230400, 460800, 921600, 0, 0 };

	for (unsigned int i = 0; i < 7; i++)
		CHECK(xy3_rate(i) == want[i]);
	CHECK(xy3_rate_command(921600) == XY3_COMMAND_RATE_921600);
	CHECK(xy3_rate_command(9600) == -EINVAL);
}

static void axes(void)
{
	uint32_t mask = 99;
	bool on = false;

	CHECK(xy3_parse_axes(" wX ", &mask) == 0 && mask == 0x11);
	CHECK(xy3_parse_axes("all", &mask) == 0 && mask == 0);
	CHECK(xy3_parse_axes("xq", &mask) == -EINVAL);
	CHECK(xy3_parse_axes("\xa0y\xa0", &mask) == 0 && mask == 2);
	CHECK(xy3_parse_switch("on z", &on, &mask) == 0 && on && mask == 4);
	CHECK(xy3_parse_switch("off", &on, &mask) == 0 && !on && mask == 0);
	CHECK(xy3_parse_switch("of", &on, &mask) == -EINVAL);
}

/* ---- backchannel ---- */

/* Whether the next packet is of this type, and all of @data is consumed */
static bool receive(struct xy3_receiver *r, const uint8_t *data, size_t size, uint8_t type)
{
	bool found = xy3_receiver_next(r, &data, &size);

	return found && !size && xy3_receiver_type(r) == type;
}

static struct xy3_receiver *in_sync(void)
{
	static const uint8_t start[] = { 0x48, 0x41, 0x00, 0x48, 0x41, 0x00 };
	struct xy3_receiver *r = xy3_receiver_new();
	const uint8_t *data = start;
	size_t size = sizeof(start);

	CHECK(r && !xy3_receiver_in_sync(r));
	CHECK(xy3_receiver_next(r, &data, &size) && xy3_receiver_type(r) == XY3_PACKET_SYNC);
	CHECK(xy3_receiver_next(r, &data, &size) && xy3_receiver_type(r) == XY3_PACKET_SYNC);
	CHECK(!xy3_receiver_next(r, &data, &size) && xy3_receiver_in_sync(r));
	return r;
}

static void packets_in_pieces(void)
{
	static const uint8_t stream[] = { 0xff, 0x00, 0x48, 0x41, 0x00,
					  0x48, 0x01, 0x03, 'A', 'b', 0x07,
					  0x48, 0x7e, 0x01, 0x55 };
	unsigned int texts = 0, unknown = 0, syncs = 0;
	struct xy3_receiver *r = xy3_receiver_new();
	char text[8];

	for (size_t i = 0; i < sizeof(stream); i++) {
		uint8_t *one = malloc(1);	/* to detect reads beyond it */
		const uint8_t *data = one;
		size_t size = 1;

		*one = stream[i];
		while (xy3_receiver_next(r, &data, &size)) {
			size_t length;
			const uint8_t *raw = xy3_receiver_packet(r, &length);

			syncs += xy3_receiver_type(r) == XY3_PACKET_SYNC && length == 3;
			if (xy3_receiver_type(r) == XY3_PACKET_VENDOR) {
				texts++;
				CHECK(length == 6 && !memcmp(raw, stream + 5, 6));
				CHECK(xy3_receiver_text(r, text, sizeof(text)) == 3);
				CHECK(!strcmp(text, "Ab?"));
				CHECK(xy3_receiver_text(r, text, 2) == 1 && !strcmp(text, "A"));
				CHECK(xy3_receiver_text(r, NULL, 0) == 0);
			}
			if (!xy3_receiver_is_known(r)) {
				unknown++;
				CHECK(xy3_receiver_type(r) == 0x7e);
				CHECK(length == 4 && raw[3] == 0x55);
			}
		}
		CHECK(!size && data == one + 1);
		free(one);
	}
	CHECK(texts == 1 && unknown == 1 && syncs == 1);
	xy3_receiver_free(r);
}

static void no_packet(void)
{
	struct xy3_receiver *r = xy3_receiver_new();
	int16_t degrees[XY3_COMPONENTS];
	char text[4] = "abc";
	size_t size = 9;

	CHECK(!xy3_receiver_packet(r, &size) && !size);
	CHECK(xy3_receiver_type(r) == 0 && !xy3_receiver_is_known(r));
	CHECK(xy3_receiver_text(r, text, sizeof(text)) == 0 && !*text);
	CHECK(xy3_receiver_temperatures(r, degrees) == 0);
	CHECK(degrees[XY3_MIRROR_W] == XY3_TEMPERATURE_NONE);
	xy3_receiver_free(r);
	xy3_receiver_free(NULL);

	/* a packet is only valid until the next call */
	r = in_sync();
	CHECK(!xy3_receiver_packet(r, &size) && !size);
	xy3_receiver_free(r);
}

static void temperatures(void)
{
	static const uint8_t packet[] = { 0x48, 0x05, 6, 0x10, 0x0e, 0x9c, 0xff, 0x01, 0x80 };
	struct xy3_receiver *r = in_sync();
	int16_t degrees[XY3_COMPONENTS];

	CHECK(receive(r, packet, sizeof(packet), XY3_PACKET_TEMPERATURES));
	CHECK(xy3_receiver_temperatures(r, degrees) == 3);
	CHECK(degrees[XY3_HEAD] == 3600 && degrees[XY3_DSP] == -100);
	CHECK(degrees[XY3_DAC_X] == XY3_TEMPERATURE_NONE);
	CHECK(degrees[XY3_DAC_Y] == XY3_TEMPERATURE_NONE);
	xy3_receiver_set_big_endian(r, true);
	CHECK(xy3_receiver_temperatures(r, degrees) == 3 && degrees[XY3_HEAD] == 0x100e);
	xy3_receiver_free(r);
}

static void errors_hours_frame_errors(void)
{
	static const uint8_t errors[] = { 0x48, 0x07, 2, 0, 101 };
	static const uint8_t hours[] = { 0x48, 0x09, 4, 0x12, 0x34, 0x56, 0x78 };
	uint8_t frames[3 + 20] = { 0x48, 0x06, 20, [3 + 4 * XY3_AXIS_W] = 7 };
	struct xy3_receiver *r = in_sync();
	uint32_t value[XY3_COMPONENTS];
	uint8_t error[XY3_COMPONENTS];

	CHECK(receive(r, errors, sizeof(errors), XY3_PACKET_ERRORS));
	CHECK(xy3_receiver_errors(r, error) == 2 && error[XY3_DSP] == 101 && !error[XY3_DAC_X]);
	CHECK(xy3_receiver_hours(r, value) == 0 && value[XY3_HEAD] == XY3_HOURS_NONE);
	CHECK(receive(r, hours, sizeof(hours), XY3_PACKET_HOURS));
	CHECK(xy3_receiver_hours(r, value) == 1 && value[XY3_HEAD] == 0x78563412);
	CHECK(value[XY3_DSP] == XY3_HOURS_NONE);
	xy3_receiver_set_big_endian(r, true);
	CHECK(xy3_receiver_hours(r, value) == 1 && value[XY3_HEAD] == 0x12345678);
	xy3_receiver_set_big_endian(r, false);
	CHECK(receive(r, frames, sizeof(frames), XY3_PACKET_FRAME_ERRORS));
	CHECK(xy3_receiver_frame_errors(r, value) == XY3_AXES);
	CHECK(value[XY3_AXIS_X] == 0 && value[XY3_AXIS_W] == 7);
	xy3_receiver_free(r);
}

static void counters(void)
{
	/* a bad length, sync again, an unknown type, and the start of one more */
	static const uint8_t stream[] = { 0x48, 0x06, 0x13, 0x48, 0x41, 0x00, 0x48, 0x7e, 0x00,
					  0x48, 0x01 };
	struct xy3_receiver *r = in_sync();
	const uint8_t *data = stream;
	size_t size = sizeof(stream);

	while (xy3_receiver_next(r, &data, &size))
		;
	CHECK(xy3_receiver_count(r, XY3_COUNT_PACKETS) == 4);
	CHECK(xy3_receiver_count(r, XY3_COUNT_PACKET_BYTES) == 12);
	CHECK(xy3_receiver_count(r, XY3_COUNT_DROPPED_BYTES) == 3);
	CHECK(xy3_receiver_count(r, XY3_COUNT_WAITING_BYTES) == 2);
	CHECK(xy3_receiver_count(r, XY3_COUNT_RESYNCS) == 1);
	CHECK(xy3_receiver_count(r, XY3_COUNT_BAD_LENGTHS) == 1);
	CHECK(xy3_receiver_count(r, XY3_COUNT_UNKNOWN) == 1);
	xy3_receiver_lost(r, 5);
	CHECK(!xy3_receiver_in_sync(r));
	CHECK(xy3_receiver_count(r, XY3_COUNT_DROPPED_BYTES) == 10);
	CHECK(xy3_receiver_count(r, XY3_COUNT_WAITING_BYTES) == 0);
	xy3_receiver_free(r);
}

/* ---- frames ---- */

/* A frame bit by bit, its first bit at the top of 32 */
static uint32_t frame_bits_of(unsigned int bits, bool position, uint32_t data)
{
	unsigned int parity = bits == 32 ? 4 : 2, ones = 0;
	uint32_t frame = bits == 32;

	frame = frame << 1 | position;
	for (int i = bits - 2 - parity - 1; i >= 0; i--) {
		ones += data >> i & 1;
		frame = frame << 1 | (data >> i & 1);
	}
	frame = frame << parity | (ones & ((1 << parity) - 1));
	return frame << (32 - bits);
}

static void frames(void)
{
	for (unsigned int bits = 24; bits <= 32; bits += 8) {
		for (uint32_t n = 0; n < 200000; n++) {
			bool position = n & 1, was_position = !position;
			uint32_t top = bits == 32 && position ? (1 << 26) - 1 : (1 << 20) - 1;
			uint32_t data = n * 2654435761u & top, was = ~data;
			uint32_t want = frame_bits_of(bits, position, data);
			uint8_t raw[4] = { };

			CHECK(xy3_frame_encode(bits, position, data, raw) == (int)bits / 8);
			for (unsigned int i = 0; i < bits / 8; i++)
				CHECK(raw[i] == (uint8_t)(want >> (24 - 8 * i)));
			CHECK(xy3_frame_size(raw[0]) == bits / 8);
			CHECK(xy3_frame_decode(raw, 4, &was_position, &was) == (int)bits / 8);
			CHECK(was_position == position && was == data);
			if (check_bad)
				return;
		}
	}
}

static void frames_that_are_none(void)
{
	uint8_t raw[4] = { 1, 2, 3, 4 };
	bool position = true;
	uint32_t data = 5;

	CHECK(xy3_frame_encode(28, true, 0, raw) == -EINVAL);
	CHECK(xy3_frame_encode(24, true, 1 << 20, raw) == -ERANGE);
	CHECK(xy3_frame_encode(32, true, 1 << 26, raw) == -ERANGE);
	CHECK(xy3_frame_encode(32, false, 1 << 20, raw) == -ERANGE);
	CHECK(!memcmp(raw, "\1\2\3\4", 4));

	CHECK(xy3_frame_decode(raw, 0, &position, &data) == -EMSGSIZE);
	CHECK(xy3_frame_encode(32, true, 0xabcde, raw) == 4);
	CHECK(xy3_frame_decode(raw, 3, &position, &data) == -EMSGSIZE);
	raw[2] ^= 4;
	CHECK(xy3_frame_decode(raw, 4, &position, &data) == -EBADMSG);
	CHECK(position && data == 5);
}

/* ---- line maps ---- */

static void maps_that_are_none(void)
{
	static const struct {
		unsigned int lines, bits;
		const char *signals;
	} bad[] = {
		{ 3, 24, NULL }, { 0, 24, NULL }, { 16, 24, NULL }, { 4, 25, NULL },
		{ 1, 24, "y" }, { 1, 24, "" }, { 1, 24, "x y" }, { 2, 24, "x x" }, { 2, 24, "x q" },
		{ 2, 24, "x sync" }, { 4, 24, "sync y z u" }, { 4, 24, "xy" }, { 4, 24, "x syn" },
		{ 4, 24, "sync sync x" },
	};
	struct xy3_line_map *map = NULL;

	for (size_t i = 0; i < sizeof(bad) / sizeof(*bad); i++)
		if (xy3_line_map_new(&map, bad[i].lines, bad[i].bits, bad[i].signals) != -EINVAL) {
			printf("    %u lines: %s\n", bad[i].lines, bad[i].signals);
			CHECK(!"refused");
		}
	CHECK(!map);
	xy3_line_map_free(NULL);
}

static void map_of_own_order(void)
{
	struct xy3_line_map *map;

	CHECK(xy3_line_map_new(&map, 8, 32, " w,-, sync\tx  ") == 0);
	CHECK(xy3_line_map_axes(map) == 2);
	CHECK(xy3_line_map_axis(map, 0) == XY3_AXIS_X && xy3_line_map_axis(map, 1) == XY3_AXIS_W);
	CHECK(xy3_line_map_axis(map, 2) == -EINVAL);
	CHECK(xy3_line_map_scan_size(map) == 34);
	CHECK(xy3_code_max(map) == (1 << 26) - 1);
	xy3_line_map_free(map);
	CHECK(xy3_line_map_new(&map, 8, 24, NULL) == 0);
	CHECK(xy3_line_map_axes(map) == 5 && xy3_line_map_scan_size(map) == 24);
	CHECK(xy3_code_max(map) == (1 << 20) - 1);
	xy3_line_map_free(map);
}

/* Check an encoded scan, clock by clock and line by line */
static void check_scan(const uint8_t *out, unsigned int lines, unsigned int bits, int sync_line,
		       const uint32_t frame[8])
{
	unsigned int clocks = bits + (sync_line >= 0 ? 2 : 0);

	for (unsigned int clock = 0; clock < clocks; clock++)
		for (unsigned int line = 0; line < lines; line++) {
			unsigned int at = clock * lines + lines - 1 - line;
			bool is = out[at / 8] >> (7 - at % 8) & 1;
			bool want = clock < bits ? frame[line] << clock >> 31 :
						   (int)line == sync_line;

			CHECK(is == want);
		}
}

static void scans(void)
{
	static const struct {
		unsigned int lines, bits;
		const char *signals;
		int axis_line[5], sync_line;	/* by code of a scan; -1 for none */
	} rows[] = {
		{ 1, 24, NULL, { 0, -1, -1, -1, -1 }, -1 },
		{ 1, 32, NULL, { 0, -1, -1, -1, -1 }, -1 },
		{ 2, 24, "y x", { 1, 0, -1, -1, -1 }, -1 },
		{ 4, 32, NULL, { 0, 1, 2, 3, -1 }, -1 },
		{ 4, 24, "sync x y z", { 1, 2, 3, -1, -1 }, 0 },
		{ 4, 32, "x y - sync", { 0, 1, -1, -1, -1 }, 3 },
		{ 8, 24, "sync x y z u w", { 1, 2, 3, 4, 5 }, 0 },
		{ 8, 32, "w u z y x", { 4, 3, 2, 1, 0 }, -1 },
	};

	for (size_t i = 0; i < sizeof(rows) / sizeof(*rows); i++) {
		uint32_t codes[2][5], frame[2][8] = { }, flat[10];
		struct xy3_line_map *map;
		uint8_t out[2 * 34];
		unsigned int axes;
		size_t size;

		CHECK(xy3_line_map_new(&map, rows[i].lines, rows[i].bits, rows[i].signals) == 0);
		axes = xy3_line_map_axes(map);
		size = xy3_line_map_scan_size(map);
		for (unsigned int scan = 0; scan < 2; scan++)
			for (unsigned int k = 0; k < axes; k++) {
				codes[scan][k] = xy3_code_max(map) / (scan + 2) + 12345 * k;
				frame[scan][rows[i].axis_line[k]] =
					frame_bits_of(rows[i].bits, true, codes[scan][k]);
				flat[scan * axes + k] = codes[scan][k];
			}
		CHECK(xy3_line_map_encode(map, flat, 2, out) == 0);
		for (unsigned int scan = 0; scan < 2; scan++)
			check_scan(out + scan * size, rows[i].lines, rows[i].bits,
				   rows[i].sync_line, frame[scan]);

		/* the other axes get a command with all bits 0 */
		memset(frame, 0, sizeof(frame));
		for (unsigned int k = 0; k < axes; k++)
			frame[0][rows[i].axis_line[k]] =
				frame_bits_of(rows[i].bits, false, k ? 0 : 0xc0003);
		CHECK(xy3_line_map_encode_command(map, 0xc0003, out) == 0);
		check_scan(out, rows[i].lines, rows[i].bits, rows[i].sync_line, frame[0]);
		xy3_line_map_free(map);
	}
}

/* X at 0, and the gate: the higher one of the two bits of each clock */
static void map_with_a_gate(void)
{
	static const uint8_t want[12] = { 0xba, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0x10 };
	uint32_t codes[] = { 0, 1, 0, 0 };
	struct xy3_line_map *map;
	uint8_t out[12];

	CHECK(xy3_line_map_new(&map, 2, 24, "gate") == -EINVAL);
	CHECK(xy3_line_map_new(&map, 4, 24, "x gate gate") == -EINVAL);
	CHECK(xy3_line_map_new(&map, 2, 24, "x y") == 0);
	CHECK(!xy3_line_map_has_gate(map));
	xy3_line_map_free(map);
	CHECK(xy3_line_map_new(&map, 2, 24, "x gate") == 0);
	CHECK(xy3_line_map_has_gate(map) && xy3_line_map_axes(map) == 1);
	CHECK(xy3_line_map_encode(map, codes, 2, out) == 0);
	CHECK(!memcmp(out, want, sizeof(want)));
	codes[3] = 2;
	CHECK(xy3_line_map_encode(map, codes, 2, out) == -ERANGE);
	codes[3] = 0;
	codes[2] = 1 << 20;
	CHECK(xy3_line_map_encode(map, codes, 2, out) == -ERANGE);
	xy3_line_map_free(map);
}

/* A letter for each resulting scan: its position, in upper case if the gate is high */
static void shifted(int on, int off, const char *in, const char *want)
{
	size_t count = strlen(in), n = 0;
	struct xy3_gate *gate;
	uint32_t out[2];
	char got[64];

	CHECK(xy3_gate_new(&gate, 1, on, off) == 0);
	for (size_t i = 0; i < count + xy3_gate_rest(gate); i++) {
		uint32_t scan[] = { i, i < count && in[i] == '#' };

		xy3_gate_next(gate, i < count ? scan : NULL, out);
		got[n++] = (out[1] ? 'A' : 'a') + out[0];
	}
	got[n] = '\0';
	if (strcmp(got, want))
		printf("    %d %d: %s, not %s\n", on, off, got, want);
	CHECK(!strcmp(got, want));
	xy3_gate_free(gate);
}

static void shifted_gate(void)
{
	struct xy3_gate *gate;
	uint32_t out[2];

	shifted(0, 0, ".##.#", "aBCdE");
	shifted(2, 2, ".##..", "abcDEee");
	shifted(-1, -1, ".##..", "aABcde");
	shifted(1, 2, "##..", "aBCDdd");
	shifted(2, 1, "###.#...", "abCDefghhh");
	shifted(-1, 2, "..#..", "aaBCDEee");
	shifted(3, 3, "..##", "abcddDD");
	/* as in the driver, nothing but 1 raises it */
	CHECK(xy3_gate_new(&gate, 1, 0, 0) == 0);
	xy3_gate_next(gate, (const uint32_t []) { 5, 2 }, out);
	CHECK(out[0] == 5 && out[1] == 0);
	xy3_gate_next(gate, (const uint32_t []) { 6, UINT32_MAX }, out);
	CHECK(out[0] == 6 && out[1] == 0);
	xy3_gate_free(gate);
	CHECK(xy3_gate_new(&gate, 0, 0, 0) == -EINVAL);
	CHECK(xy3_gate_new(&gate, 6, 0, 0) == -EINVAL);
	CHECK(xy3_gate_new(&gate, 1, -2000000, 0) == -EINVAL);
	xy3_gate_free(NULL);
}

static void codes_out_of_range(void)
{
	uint32_t codes[] = { 1, 1 << 20 };
	struct xy3_line_map *map;
	uint8_t out[6] = { 9, 9, 9, 9, 9, 9 };

	CHECK(xy3_line_map_new(&map, 1, 24, NULL) == 0);
	CHECK(xy3_line_map_encode(map, codes, 2, out) == -ERANGE);
	CHECK(xy3_line_map_encode_command(map, 1 << 20, out) == -ERANGE);
	CHECK(!memcmp(out, "\t\t\t\t\t\t", 6));
	xy3_line_map_free(map);
}

/* X of each scan, with ! if the gate is high, for vertices of X and the gate, the end last */
static void path_of(const struct xy3_path_settings *settings, const uint32_t (*vertices)[2],
		    size_t count, const char *want)
{
	struct xy3_path *path;
	char got[256] = "";
	uint32_t scan[2];

	CHECK(xy3_path_new(&path, 1, settings) == 0);
	CHECK(!xy3_path_next(path, scan));
	for (size_t i = 0; i <= count; i++) {
		xy3_path_to(path, i < count ? vertices[i] : NULL);
		while (xy3_path_next(path, scan))
			sprintf(got + strlen(got), "%u%s ", scan[0], scan[1] ? "!" : "");
		CHECK(!xy3_path_next(path, scan));
	}
	if (strcmp(got, want))
		printf("    %s, not %s\n", got, want);
	CHECK(!strcmp(got, want));
	xy3_path_free(path);
}

static void path_of_jumps_and_marks(void)
{
	static const uint32_t figure[][2] = {
		{ 100, 0 }, { 130, 1 }, { 115, 1 }, { 215, 0 }, { 225, 1 },
	};
	static const uint32_t dots[][2] = { { 7, 1 }, { 7, 1 }, { 7, 0 }, { 9, 0 } };

	path_of(&(struct xy3_path_settings) { 50, 10, 0, 0 }, figure, 5,
		"100 110! 120! 130! 123! 115! 165 215 225! ");
	path_of(&(struct xy3_path_settings) { 50, 10, 2, 0 }, figure, 5,
		"100 100 100 110! 120! 130! 123! 115! 165 215 215 215 225! ");
	/* not between two marks; at the end, too */
	path_of(&(struct xy3_path_settings) { 50, 10, 0, 2 }, figure, 5,
		"100 110! 120! 130! 123! 115! 115 115 165 215 225! 225 225 ");
	/* a path may be longer by a code: its ends are rounded */
	path_of(&(struct xy3_path_settings) { 50, 10, 0, 0 },
		(const uint32_t [][2]) { { 0, 0 }, { 21, 1 }, { 43, 1 }, { 94, 0 } }, 4,
		"0 11! 21! 28! 36! 43! 94 ");
	/* a vertex at the current position is one scan; the first one has no path to mark */
	path_of(&(struct xy3_path_settings) { 50, 10, 1, 1 }, dots, 4, "7 7 7! 7 7 7 9 9 ");
	path_of(&(struct xy3_path_settings) { 50, 10, 1, 1 }, dots, 0, "");
	/* as in the driver, nothing but 1 raises the gate */
	path_of(&(struct xy3_path_settings) { 50, 10, 0, 0 },
		(const uint32_t [][2]) { { 0, 0 }, { 50, 2 }, { 100, UINT32_MAX } }, 3,
		"0 50 100 ");
}

/* Over the whole field, in five axes: steps of one length, none above the speed, the end exact */
static void path_in_steps(void)
{
	const struct xy3_path_settings settings = { 1e9, 12345.6, 0, 0 };
	const uint32_t top = (1 << 26) - 1;
	const uint32_t ends[2][6] = { { 0, top, 5, top / 3, 0, 0 }, { top, 0, 5, 0, top, 1 } };
	uint32_t scan[6], before[6];
	struct xy3_path *path;
	size_t count = 0;

	CHECK(xy3_path_new(&path, 5, &settings) == 0);
	xy3_path_to(path, ends[0]);
	CHECK(xy3_path_next(path, before) && !memcmp(before, ends[0], sizeof(before)));
	CHECK(!xy3_path_next(path, scan));
	xy3_path_to(path, ends[1]);
	for (; xy3_path_next(path, scan); count++, memcpy(before, scan, sizeof(before))) {
		double square = 0;

		for (unsigned int i = 0; i < 5; i++) {
			double way = (double)scan[i] - before[i];

			square += way * way;
		}
		CHECK(square < 12348. * 12348. && square > 12340. * 12340. && scan[5] == 1);
	}
	/* sqrt(3 + 1/9) * (2^26 - 1) / 12345.6 is 9587.9 */
	CHECK(count == 9588);
	CHECK(!memcmp(before, ends[1], sizeof(before)));
	xy3_path_free(path);
}

static void path_refused(void)
{
	struct xy3_path *path;

	CHECK(xy3_path_new(&path, 0, &(struct xy3_path_settings) { 1, 1, 0, 0 }) == -EINVAL);
	CHECK(xy3_path_new(&path, 6, &(struct xy3_path_settings) { 1, 1, 0, 0 }) == -EINVAL);
	CHECK(xy3_path_new(&path, 1, &(struct xy3_path_settings) { 0, 1, 0, 0 }) == -EINVAL);
	CHECK(xy3_path_new(&path, 1, &(struct xy3_path_settings) { 1, -1, 0, 0 }) == -EINVAL);
	CHECK(xy3_path_new(&path, 1, &(struct xy3_path_settings) { 1, 1e10, 0, 0 }) == -EINVAL);
	xy3_path_free(NULL);
}

int main(void)
{
	RUN(names);
	RUN(rates);
	RUN(axes);
	RUN(packets_in_pieces);
	RUN(no_packet);
	RUN(temperatures);
	RUN(errors_hours_frame_errors);
	RUN(counters);
	RUN(frames);
	RUN(frames_that_are_none);
	RUN(maps_that_are_none);
	RUN(map_of_own_order);
	RUN(scans);
	RUN(codes_out_of_range);
	RUN(map_with_a_gate);
	RUN(shifted_gate);
	RUN(path_of_jumps_and_marks);
	RUN(path_in_steps);
	RUN(path_refused);
	return check_end("api");
}
