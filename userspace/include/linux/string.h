/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef HOST_LINUX_STRING_H
#define HOST_LINUX_STRING_H

#include <string.h>
#include <linux/ctype.h>
#include <linux/types.h>

/* Three arguments only: the two-argument form does not exist on 6.1. */
ssize_t strscpy(char *dst, const char *src, size_t size);
char *strim(char *str);
bool sysfs_streq(const char *a, const char *b);
int match_string(const char * const *array, size_t n, const char *string);
int __sysfs_match_string(const char * const *array, size_t n, const char *str);
#define sysfs_match_string(array, str)	__sysfs_match_string(array, ARRAY_SIZE(array), str)
void *memchr_inv(const void *start, int c, size_t bytes);

static inline char *skip_spaces(const char *str)
{
	while (isspace(*str))
		str++;
	return (char *)str;
}

/* The length of @prefix when @str starts with it, or 0. */
static inline size_t str_has_prefix(const char *str, const char *prefix)
{
	size_t len = strlen(prefix);

	return strncmp(str, prefix, len) == 0 ? len : 0;
}

static inline bool strstarts(const char *str, const char *prefix)
{
	return strncmp(str, prefix, strlen(prefix)) == 0;
}

#endif
