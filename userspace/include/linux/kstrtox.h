/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Numbers as the kernel reads them: the whole text or nothing. One '+' (signed also '-') may lead,
 * one newline may follow; base 0 takes 0x and 0 as C does. -ERANGE as soon as the digits do not
 * fit, even when junk follows; -EINVAL for everything else. The bodies are in kernel.c.
 */
#ifndef HOST_LINUX_KSTRTOX_H
#define HOST_LINUX_KSTRTOX_H

#include <linux/compiler_types.h>
#include <linux/types.h>

int __must_check kstrtoull(const char *s, unsigned int base, unsigned long long *res);
int __must_check kstrtoll(const char *s, unsigned int base, long long *res);
int __must_check kstrtouint(const char *s, unsigned int base, unsigned int *res);
int __must_check kstrtoint(const char *s, unsigned int base, int *res);
int __must_check kstrtou16(const char *s, unsigned int base, u16 *res);
int __must_check kstrtos16(const char *s, unsigned int base, s16 *res);
int __must_check kstrtou8(const char *s, unsigned int base, u8 *res);
int __must_check kstrtos8(const char *s, unsigned int base, s8 *res);
int __must_check kstrtobool(const char *s, bool *res);

#endif
