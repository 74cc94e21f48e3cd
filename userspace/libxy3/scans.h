/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * libxy3: internal declarations for scans
 */
#ifndef SCANS_H
#define SCANS_H

#include <stddef.h>
#include <stdint.h>

struct xy3_line_map;

/* Return 0, or -ERANGE for a code with too many bits or a gate that is neither 0 nor 1 */
int xy3_check_scans(const struct xy3_line_map *map, const uint32_t *codes, size_t scans);

#endif /* SCANS_H */
