/* SPDX-License-Identifier: GPL-2.0-only */
/* Byte by byte, so that the host's own byte order cannot matter. */
#ifndef HOST_LINUX_UNALIGNED_H
#define HOST_LINUX_UNALIGNED_H

#include <linux/types.h>

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

static inline void put_unaligned_le16(u16 val, void *to)
{
	u8 *b = to;

	b[0] = (u8)val;
	b[1] = (u8)(val >> 8);
}

static inline void put_unaligned_be16(u16 val, void *to)
{
	u8 *b = to;

	b[0] = (u8)(val >> 8);
	b[1] = (u8)val;
}

static inline void put_unaligned_le32(u32 val, void *to)
{
	u8 *b = to;

	put_unaligned_le16((u16)val, b);
	put_unaligned_le16((u16)(val >> 16), b + 2);
}

static inline void put_unaligned_be32(u32 val, void *to)
{
	u8 *b = to;

	put_unaligned_be16((u16)(val >> 16), b);
	put_unaligned_be16((u16)val, b + 2);
}

static inline void put_unaligned_be24(u32 val, void *to)
{
	u8 *b = to;

	b[0] = (u8)(val >> 16);
	put_unaligned_be16((u16)val, b + 1);
}

#endif
