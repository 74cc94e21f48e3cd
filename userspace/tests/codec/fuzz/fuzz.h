/* SPDX-License-Identifier: GPL-2.0-only */
/* Common to the targets. FAULT, if defined, plants a fault (see run-fuzz). */
#ifndef FUZZ_H
#define FUZZ_H

#include <stdio.h>
#include <stdlib.h>

#ifndef FAULT
#define FAULT	0
#endif

#define must(condition)	do {							\
	if (!(condition)) {							\
		fprintf(stderr, "broken: %s, line %d\n", #condition, __LINE__);	\
		abort();							\
	}									\
} while (0)

int LLVMFuzzerTestOneInput(const u8 *data, size_t size);

#endif
