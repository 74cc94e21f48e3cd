/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef HOST_LINUX_UNALIGNED_H
#define HOST_LINUX_UNALIGNED_H

#include <asm/byteorder.h>
#include <linux/types.h>

/* Byte by byte, so that the host's own byte order cannot matter */
static inline u16 get_unaligned_le16(const void *from)
{
	const u8 *b = from;

	return (u16)(b[0] | b[1] << 8);
}

static inline u16 get_unaligned_be16(const void *from)
{
	const u8 *b = from;

	return (u16)(b[0] << 8 | b[1]);
}

static inline u32 get_unaligned_le32(const void *from)
{
	const u8 *b = from;

	return get_unaligned_le16(b) | (u32)get_unaligned_le16(b + 2) << 16;
}

static inline u32 get_unaligned_be32(const void *from)
{
	const u8 *b = from;

	return (u32)get_unaligned_be16(b) << 16 | get_unaligned_be16(b + 2);
}

static inline u32 get_unaligned_le24(const void *from)
{
	const u8 *b = from;

	return get_unaligned_le16(b) | (u32)b[2] << 16;
}

static inline u32 get_unaligned_be24(const void *from)
{
	const u8 *b = from;

	return (u32)b[0] << 16 | get_unaligned_be16(b + 1);
}

/* Not byte by byte, out of which gcc does not always make one store: benchmarks are built with it */
#define HOST_PUT_UNALIGNED(type, order)						\
	static inline void put_unaligned_##order(type val, void *to)		\
	{									\
		type swapped = (__force type)cpu_to_##order(val);		\
										\
		__builtin_memcpy(to, &swapped, sizeof(swapped));		\
	}

HOST_PUT_UNALIGNED(u16, le16)
HOST_PUT_UNALIGNED(u32, le32)
HOST_PUT_UNALIGNED(u16, be16)
HOST_PUT_UNALIGNED(u32, be32)
HOST_PUT_UNALIGNED(u64, be64)

static inline void put_unaligned_be24(u32 val, void *to)
{
	u8 *b = to;

	b[0] = (u8)(val >> 16);
	b[1] = (u8)(val >> 8);
	b[2] = (u8)val;
}

#endif
