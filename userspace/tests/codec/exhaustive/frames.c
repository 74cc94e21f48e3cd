// SPDX-License-Identifier: GPL-2.0-only
/*
 * Every 24-bit frame, every command and position of 20 bits, and of 32-bit frames every command
 * with every parity and every value of the bits above it, against a receiver that reads them bit
 * by bit. Encoding the content of a good frame results in the same frame.
 */
#include "../../../../drivers/xy3/xy3-frame.c"
#include <kunit/test.h>

struct receiver {
	u32 data;
	unsigned int ones;
	unsigned int parity;
	bool position;
};

static unsigned int bit_of(const u8 *raw, unsigned int n)
{
	return raw[n / 8] >> (7 - n % 8) & 1;
}

static struct receiver receive(const u8 *raw)
{
	bool is_32 = bit_of(raw, 0);
	unsigned int data_bits = is_32 ? 26 : 20, bits = is_32 ? 32 : 24;
	struct receiver r = { .position = bit_of(raw, 1) };

	for (unsigned int n = 2; n < 2 + data_bits; n++) {
		r.data = r.data << 1 | bit_of(raw, n);
		r.ones += bit_of(raw, n);
	}
	for (unsigned int n = 2 + data_bits; n < bits; n++)
		r.parity = r.parity << 1 | bit_of(raw, n);
	r.ones &= is_32 ? 15 : 3;
	return r;
}

static u32 word_of(const u8 *raw, size_t size)
{
	u32 word = raw[0] << 16 | raw[1] << 8 | raw[2];

	return size == 4 ? word << 8 | raw[3] : word;
}

static u32 made(const struct receiver *r, size_t size)
{
	if (size == 4)
		return xy3_frame32(r->data) | (r->position ? XY3_FRAME32_POSITION : 0);
	return xy3_frame24(r->data) | (r->position ? XY3_FRAME24_POSITION : 0);
}

static void check(struct kunit *test, const u8 *raw, size_t size)
{
	struct receiver want = receive(raw);
	struct xy3_frame frame;
	int verdict = want.ones != want.parity ? XY3_FRAME_BAD_PARITY :
		      want.position ? XY3_FRAME_POSITION : XY3_FRAME_COMMAND;

	xy3_decode_frame(raw, size, &frame);
	if (frame.size != size || frame.verdict != verdict ||
	    frame.data != (want.position ? want.data : want.data & 0xfffff) ||
	    (verdict != XY3_FRAME_BAD_PARITY && made(&want, size) != word_of(raw, size)))
		KUNIT_FAIL_AND_ABORT(test, "%02x %02x %02x of %zu: verdict %d, data %#x",
				     raw[0], raw[1], raw[2], size, frame.verdict, frame.data);
}

static void every_24_bit_frame(struct kunit *test)
{
	for (u32 bits = 0; bits < 1U << 23; bits++) {
		const u8 raw[3] = { bits >> 16, bits >> 8, bits };

		check(test, raw, 3);
	}
}

static void every_command_in_32_bits(struct kunit *test)
{
	for (u32 bits = 0; bits < 1U << 26; bits += 0x1001)
		for (u32 parity = 0; parity < 16; parity++)
			for (u32 kind = 2; kind < 4; kind++) {
				u32 word = kind << 30 | bits << 4 | parity;
				const u8 raw[4] = { word >> 24, word >> 16, word >> 8, word };

				check(test, raw, 4);
			}
	for (u32 command = 0; command < 1U << 20; command++) {
		u32 word = 2U << 30 | command << 4 | (__builtin_popcount(command) & 15);
		const u8 raw[4] = { word >> 24, word >> 16, word >> 8, word };

		check(test, raw, 4);
	}
}

static void every_command_made(struct kunit *test)
{
	for (u32 command = 0; command < 1U << 20; command++) {
		struct receiver got;
		u8 raw[3];

		xy3_encode_command(command, raw);
		got = receive(raw);
		if (bit_of(raw, 0) || got.position || got.data != command ||
		    got.ones != got.parity)
			KUNIT_FAIL_AND_ABORT(test, "%#x: %02x %02x %02x", command, raw[0], raw[1],
					     raw[2]);
	}
}

/* All positions of 20 bits; of 26 bits every 53rd, with all bits above them set */
static void every_position_made(struct kunit *test)
{
	for (u32 code = 0; code < 1U << 26; code += code < 1U << 20 ? 1 : 53) {
		u32 word = xy3_frame32(code | 0xfc000000) | XY3_FRAME32_POSITION;
		const u8 raw[4] = { word >> 24, word >> 16, word >> 8, word };
		struct receiver got = receive(raw);

		if (!bit_of(raw, 0) || !got.position || got.data != code || got.ones != got.parity)
			KUNIT_FAIL_AND_ABORT(test, "%#x: %#x", code, word);
		check(test, raw, 4);
	}
	for (u32 code = 0; code < 1U << 20; code++) {
		u32 word = xy3_frame24(code | 0xfff00000) | XY3_FRAME24_POSITION;
		const u8 raw[3] = { word >> 16, word >> 8, word };
		struct receiver got = receive(raw);

		if (bit_of(raw, 0) || !got.position || got.data != code || got.ones != got.parity)
			KUNIT_FAIL_AND_ABORT(test, "%#x: %#x", code, word);
		check(test, raw, 3);
	}
}

/* Every text of up to four bytes, from those with a meaning, and some without */
static void every_short_text(struct kunit *test)
{
	static const char bytes[] = "xyzuwalXv\n ";
	static const char letters[] = "xyzuw";
	size_t n = sizeof(bytes) - 1;

	for (size_t which = 0; which < n * n * n * n; which++) {
		char text[5] = { bytes[which % n], bytes[which / n % n], bytes[which / n / n % n],
				 bytes[which / n / n / n], 0 };
		u32 axes = 0, want = 0;
		int err = xy3_parse_axes(text, &axes);
		bool good = true;
		char *word = text;

		/* another way: remove the white space, then parse */
		while (*word == ' ' || *word == '\n')
			word++;
		for (size_t end = strlen(word); end && strchr("\n ", word[end - 1]); end--)
			word[end - 1] = 0;
		for (const char *p = word; strcmp(word, "all") && *p; p++) {
			const char *letter = strchr(letters, *p == 'X' ? 'x' : *p);

			good &= !!letter;
			if (letter)
				want |= 1U << (letter - letters);
		}
		KUNIT_ASSERT_EQ_MSG(test, err, good ? 0 : -EINVAL, "\"%s\"", word);
		if (good)
			KUNIT_ASSERT_EQ_MSG(test, axes, want, "\"%s\"", word);
	}
}

static struct kunit_case cases[] = {
	KUNIT_CASE(every_24_bit_frame),
	KUNIT_CASE(every_command_in_32_bits),
	KUNIT_CASE(every_command_made),
	KUNIT_CASE(every_position_made),
	KUNIT_CASE(every_short_text),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_frames", .test_cases = cases };
kunit_test_suite(suite);
