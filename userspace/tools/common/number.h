/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Numbers as people type them: in options, arguments and files
 *
 * A whole number is decimal digits. A real number may have a sign, a decimal point and an exponent.
 * Blanks, a decimal comma, hexadecimal digits, "nan" and "inf" are not numbers.
 * Functions return 0, -EINVAL, or -ERANGE for a number out of the range.
 */
#ifndef NUMBER_H
#define NUMBER_H

#include <argp.h>

int number_whole(const char *text, unsigned long min, unsigned long max, unsigned long *number);
int number_real(const char *text, double min, double max, double *number);
/* A whole number that may have a sign, or be hexadecimal after 0x */
int number_code(const char *text, long min, long max, long *number);

/* The same for the value of an option; anything else is a usage error and ends the program */
unsigned long option_whole(const char *option, const char *text, unsigned long min,
			   unsigned long max, const struct argp_state *state);
double option_real(const char *option, const char *text, double min, double max,
		   const struct argp_state *state);

#endif /* NUMBER_H */
