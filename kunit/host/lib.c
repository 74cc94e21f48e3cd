// SPDX-License-Identifier: GPL-2.0-only
/*
 * The few kernel library functions that pure code uses, for user space. They accept, refuse and
 * return the same as in the kernel, which kunit/host/selftest/shim_test.c checks.
 */
#include <linux/ctype.h>
#include <linux/kernel.h>
#include <linux/string.h>

/* ---- numbers ---- */

static unsigned int digit_value(char c)
{
	if (isdigit(c))
		return c - '0';
	if (isxdigit(c))
		return tolower(c) - 'a' + 10;
	return UINT_MAX;
}

static unsigned int detect_base(const char **s, unsigned int base)
{
	bool hex = (*s)[0] == '0' && tolower((*s)[1]) == 'x';

	if (base == 0) {
		if ((*s)[0] != '0')
			base = 10;
		else
			base = hex && isxdigit((*s)[2]) ? 16 : 8;
	}
	if (base == 16 && hex)
		*s += 2;
	return base;
}

static int parse_magnitude(const char *s, unsigned int base, unsigned long long *res)
{
	unsigned long long value = 0;
	bool overflow = false;
	const char *start;

	base = detect_base(&s, base);
	for (start = s; digit_value(*s) < base; s++)
		overflow |= __builtin_mul_overflow(value, base, &value) ||
			    __builtin_add_overflow(value, digit_value(*s), &value);
	if (overflow)
		return -ERANGE;
	if (s == start)
		return -EINVAL;
	if (*s == '\n')
		s++;
	if (*s)
		return -EINVAL;
	*res = value;
	return 0;
}

int kstrtoull(const char *s, unsigned int base, unsigned long long *res)
{
	return parse_magnitude(*s == '+' ? s + 1 : s, base, res);
}

int kstrtoll(const char *s, unsigned int base, long long *res)
{
	bool negative = *s == '-';
	unsigned long long value;
	int ret;

	ret = negative ? parse_magnitude(s + 1, base, &value) : kstrtoull(s, base, &value);
	if (ret)
		return ret;
	if (value > (unsigned long long)LLONG_MAX + negative)
		return -ERANGE;
	*res = negative ? (long long)-value : (long long)value;
	return 0;
}

static int parse_unsigned(const char *s, unsigned int base, unsigned long long most,
			  unsigned long long *value)
{
	int ret = kstrtoull(s, base, value);

	return ret ? ret : *value > most ? -ERANGE : 0;
}

static int parse_signed(const char *s, unsigned int base, long long least, long long most,
			long long *value)
{
	int ret = kstrtoll(s, base, value);

	return ret ? ret : *value < least || *value > most ? -ERANGE : 0;
}

int kstrtouint(const char *s, unsigned int base, unsigned int *res)
{
	unsigned long long value;
	int ret = parse_unsigned(s, base, UINT_MAX, &value);

	if (!ret)
		*res = (unsigned int)value;
	return ret;
}

int kstrtou16(const char *s, unsigned int base, u16 *res)
{
	unsigned long long value;
	int ret = parse_unsigned(s, base, U16_MAX, &value);

	if (!ret)
		*res = (u16)value;
	return ret;
}

int kstrtou8(const char *s, unsigned int base, u8 *res)
{
	unsigned long long value;
	int ret = parse_unsigned(s, base, U8_MAX, &value);

	if (!ret)
		*res = (u8)value;
	return ret;
}

int kstrtoint(const char *s, unsigned int base, int *res)
{
	long long value;
	int ret = parse_signed(s, base, INT_MIN, INT_MAX, &value);

	if (!ret)
		*res = (int)value;
	return ret;
}

int kstrtos16(const char *s, unsigned int base, s16 *res)
{
	long long value;
	int ret = parse_signed(s, base, S16_MIN, S16_MAX, &value);

	if (!ret)
		*res = (s16)value;
	return ret;
}

int kstrtos8(const char *s, unsigned int base, s8 *res)
{
	long long value;
	int ret = parse_signed(s, base, S8_MIN, S8_MAX, &value);

	if (!ret)
		*res = (s8)value;
	return ret;
}

int kstrtobool(const char *s, bool *res)
{
	char first = (char)tolower(s[0]);
	char second = first ? (char)tolower(s[1]) : '\0';

	if (strchr("y1t", first) && first)
		*res = true;
	else if (strchr("n0f", first) && first)
		*res = false;
	else if (first == 'o' && (second == 'n' || second == 'f'))
		*res = second == 'n';
	else
		return -EINVAL;
	return 0;
}

/* ---- text ---- */

int vscnprintf(char *buf, size_t size, const char *fmt, va_list args)
{
	int len = vsnprintf(buf, size, fmt, args);

	if (size == 0)
		return 0;
	return (size_t)len < size ? len : (int)size - 1;
}

int scnprintf(char *buf, size_t size, const char *fmt, ...)
{
	va_list args;
	int len;

	va_start(args, fmt);
	len = vscnprintf(buf, size, fmt, args);
	va_end(args);
	return len;
}

ssize_t strscpy(char *dst, const char *src, size_t size)
{
	size_t len;

	if (size == 0)
		return -E2BIG;
	len = strnlen(src, size);
	if (len == size) {
		memcpy(dst, src, size - 1);
		dst[size - 1] = '\0';
		return -E2BIG;
	}
	memcpy(dst, src, len + 1);
	return (ssize_t)len;
}

char *strim(char *str)
{
	size_t len = strlen(str);

	while (len > 0 && isspace(str[len - 1]))
		len--;
	str[len] = '\0';
	return skip_spaces(str);
}

/* Equal, except for a newline at the end of either. */
bool sysfs_streq(const char *a, const char *b)
{
	while (*a && *a == *b) {
		a++;
		b++;
	}
	if (*a == *b)
		return true;
	if (!*a && *b == '\n' && !b[1])
		return true;
	return *a == '\n' && !a[1] && !*b;
}

int match_string(const char * const *array, size_t n, const char *string)
{
	for (size_t i = 0; i < n && array[i]; i++)
		if (!strcmp(array[i], string))
			return (int)i;
	return -EINVAL;
}

int __sysfs_match_string(const char * const *array, size_t n, const char *str)
{
	for (size_t i = 0; i < n && array[i]; i++)
		if (sysfs_streq(array[i], str))
			return (int)i;
	return -EINVAL;
}

void *memchr_inv(const void *start, int c, size_t bytes)
{
	const u8 *byte = start;

	for (; bytes; byte++, bytes--)
		if (*byte != (u8)c)
			return (void *)byte;
	return NULL;
}
