/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Kernels before 6.12 have the unaligned accessors in <asm/unaligned.h> only. This folder
 * stands behind the kernel's own in the search path: where <linux/unaligned.h> exists,
 * this file is not seen.
 */
#include <asm/unaligned.h>
