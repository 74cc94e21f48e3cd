// SPDX-License-Identifier: GPL-2.0-only
/* bench: the pendant's display frames, cut into feature reports, against memcpy */
#include <stdlib.h>
#include <linux/kernel.h>
#include <linux/string.h>

#include "../../../../drivers/hid-xhc/xhc-codec.h"
#include "bench.h"

#define DISPLAYS	64	/* in a block */
#define FRAME_MAX	(XHC_CHUNKS_MAX * XHC_CHUNK_SIZE)

struct display_job {
	const struct xhc_model *model;
	size_t size;
	bool failed;
	struct xhc_display display[DISPLAYS];
	u8 frames[DISPLAYS * FRAME_MAX];
	u8 other[DISPLAYS * FRAME_MAX];
};

static void codec_block(void *data)
{
	struct display_job *job = data;
	u8 payload[XHC_PAYLOAD_MAX], *out = job->frames;

	for (unsigned int i = 0; i < DISPLAYS; i++) {
		int size = xhc_encode_payload(job->model, &job->display[i], payload);

		if (size < 0) {
			job->failed = true;
			return;
		}
		for (unsigned int chunk = 0; chunk < job->model->chunks; chunk++) {
			xhc_encode_chunk(payload, size, chunk, out);
			out += XHC_CHUNK_SIZE;
		}
	}
}

static void memcpy_block(void *data)
{
	struct display_job *job = data;

	memcpy(job->other, job->frames, job->size);
}

/* The chunks, when joined, start with the magic and have the given X */
static bool display_good(void *data)
{
	struct display_job *job = data;
	bool good = true;

	memset(job->frames, 0x11, sizeof(job->frames));
	job->failed = false;
	codec_block(job);
	memcpy_block(job);
	for (unsigned int i = 0; i < DISPLAYS; i++) {
		const u8 *frame = job->frames + i * job->model->chunks * XHC_CHUNK_SIZE;
		unsigned int x = abs(job->display[i].position[XHC_WORK_X]) / 10000;

		for (unsigned int chunk = 0; chunk < job->model->chunks; chunk++)
			good &= frame[chunk * XHC_CHUNK_SIZE] == XHC_FEATURE_ID;
		good &= frame[1] == 0xfe && frame[2] == 0xfd &&
			frame[3] == job->display[i].day && (frame[4] | frame[5] << 8) == x;
	}
	return good && !job->failed && !memcmp(job->frames, job->other, job->size);
}

static void add_model(struct display_job *job, const char *name, u32 product)
{
	u32 random = 0x7654321;

	job->model = xhc_model_find(product);
	if (!job->model)
		abort();
	job->size = DISPLAYS * job->model->chunks * XHC_CHUNK_SIZE;
	for (unsigned int i = 0; i < DISPLAYS; i++) {
		struct xhc_display *display = &job->display[i];

		/* from -200 to 200 mm, in hundredths, which both models display alike */
		for (unsigned int k = 0; k < XHC_POSITIONS; k++)
			display->position[k] = ((s32)(next_random(&random) % 40000) - 20000) * 100;
		for (unsigned int k = 0; k < XHC_NUMBERS; k++)
			display->number[k] = next_random(&random);
		display->day = 1 + next_random(&random) % XHC_DAY_MAX;
		display->step = next_random(&random) % 11;
		display->state = XHC_STATE_RUN;
	}
	add_contest(&(struct contest) {
		.table = "display frames made",
		.name = name,
		.unit = "frame",
		.units = DISPLAYS,
		.bytes = job->size,
		.job = job,
		.good = display_good,
		.contender = {
			{ "codec", codec_block },
			{ "memcpy", memcpy_block },
		},
	});
}

void add_display(void)
{
	static struct display_job hb03, hb04;

	add_model(&hb03, "HB03, 5 reports", XHC_PRODUCT_HB03);
	add_model(&hb04, "HB04, 6 reports", XHC_PRODUCT_HB04);
}
