/* SPDX-License-Identifier: GPL-2.0-only */
#ifdef KERNEL_HAS_UNALIGNED
#include_next <linux/unaligned.h>
#else
/* the header had another path */
#include <asm/unaligned.h>
#endif
