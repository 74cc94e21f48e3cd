/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef HOST_LINUX_BITFIELD_H
#define HOST_LINUX_BITFIELD_H

#include <linux/bits.h>
#include <linux/types.h>

#define FIELD_SHIFT(mask)	__builtin_ctzll(mask)
#define FIELD_MAX(mask)		((typeof(mask))((mask) >> FIELD_SHIFT(mask)))
#define FIELD_FIT(mask, val) \
	(!((((typeof(mask))(val)) << FIELD_SHIFT(mask)) & ~(mask)))
#define FIELD_PREP(mask, val) \
	((typeof(mask))(((typeof(mask))(val) << FIELD_SHIFT(mask)) & (mask)))
#define FIELD_PREP_CONST(mask, val)	FIELD_PREP(mask, val)
#define FIELD_GET(mask, reg)	((typeof(mask))(((reg) & (mask)) >> FIELD_SHIFT(mask)))

#endif
