// SPDX-License-Identifier: GPL-2.0-only
/*
 * Numbers as people type them. See number.h.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "number.h"

#define DIGITS "0123456789"

int number_whole(const char *text, unsigned long min, unsigned long max, unsigned long *number)
{
	unsigned long value;

	if (!*text || text[strspn(text, DIGITS)])
		return -EINVAL;
	errno = 0;
	value = strtoul(text, NULL, 10);
	if (errno || value < min || value > max)
		return -ERANGE;
	*number = value;
	return 0;
}

int number_real(const char *text, double min, double max, double *number)
{
	double value;
	char *end;

	/* strtod() also accepts blanks, hexadecimal digits, and words */
	if (!*text || text[strspn(text, DIGITS "+-.eE")])
		return -EINVAL;
	value = strtod(text, &end);
	if (end == text || *end)
		return -EINVAL;
	if (!(value >= min && value <= max))
		return -ERANGE;
	*number = value;
	return 0;
}

int number_code(const char *text, long min, long max, long *number)
{
	const char *digits = text + strspn(text, "+-");
	int base = 10;
	long value;
	char *end;

	if (digits > text + 1)
		return -EINVAL;
	if (digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X')) {
		base = 16;
		digits += 2;
	}
	if (!*digits || digits[strspn(digits, base == 16 ? DIGITS "abcdefABCDEF" : DIGITS)])
		return -EINVAL;
	errno = 0;
	value = strtol(text, &end, base);
	if (errno || value < min || value > max)
		return -ERANGE;
	*number = value;
	return 0;
}

unsigned long option_whole(const char *option, const char *text, unsigned long min,
			   unsigned long max, const struct argp_state *state)
{
	unsigned long number = min;

	if (number_whole(text, min, max, &number))
		argp_error(state, "%s: '%s' is not a whole number from %lu to %lu", option, text,
			   min, max);
	return number;
}

double option_real(const char *option, const char *text, double min, double max,
		   const struct argp_state *state)
{
	double number = min;

	if (number_real(text, min, max, &number))
		argp_error(state, "%s: '%s' is not a number from %.10g to %.10g", option, text, min,
			   max);
	return number;
}
