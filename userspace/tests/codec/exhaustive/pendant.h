/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The two pendants as in the tables of the document "XHC xHB03 & xHB04 INTERNALS": offsets are
 * copied from there, independent of the tables of the driver.
 */
#ifndef EXHAUSTIVE_PENDANT_H
#define EXHAUSTIVE_PENDANT_H

#include <kunit/test.h>
#include "../../../../drivers/hid-xhc/xhc-codec.h"

struct pendant {
	const char *name;
	u32 product;
	size_t frame_size;
	size_t day_at;
	size_t position_at[6];
	size_t number_at[4];
	size_t step_at;
	size_t state_at;
	int decimals;
	long long units_shown;	/* smallest step of the display, in 1/10000 */
};

static const struct pendant pendants[] = {
	{
		.name = "HB03", .product = 0xeb6e, .frame_size = 31, .day_at = 0x02,
		.position_at = { 0x03, 0x06, 0x09, 0x0c, 0x0f, 0x12 },
		.number_at = { 0x15, 0x17, 0x19, 0x1b },
		.step_at = 0x1d, .state_at = 0x1e, .decimals = 2, .units_shown = 100,
	},
	{
		.name = "HB04", .product = 0xeb70, .frame_size = 37, .day_at = 0x02,
		.position_at = { 0x03, 0x07, 0x0b, 0x0f, 0x13, 0x17 },
		.number_at = { 0x1b, 0x1d, 0x1f, 0x21 },
		.step_at = 0x23, .state_at = 0x24, .decimals = 4, .units_shown = 1,
	},
};

KUNIT_ARRAY_PARAM_DESC(pendants, pendants, name);

static inline const struct xhc_model *pendant_model(struct kunit *test)
{
	const struct pendant *p = test->param_value;
	const struct xhc_model *model = xhc_model_find(p->product);

	KUNIT_ASSERT_NOT_NULL(test, model);
	return model;
}

#endif
