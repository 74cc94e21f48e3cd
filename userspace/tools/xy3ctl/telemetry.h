/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * Reports of a head, as a list of facts: a name and a value each, in a fixed order. Names are
 * those of the attributes in sysfs; temperatures are temperature/<component>, in degrees.
 */
#ifndef TELEMETRY_H
#define TELEMETRY_H

#include "head.h"

#define FACT_TEXTS 4		/* vendor, model, firmware, serial */
/* in_sync and rate; three of each component, one of each axis */
#define FACTS (FACT_TEXTS + 2 + 3 * XY3_COMPONENTS + XY3_AXES)

struct fact {
	char name[32];
	char value[XY3_TEXT_MAX + 1];	/* "" while it was not reported */
	bool is_number;
};

struct telemetry {
	struct fact facts[FACTS];
};

/* Read all facts. Return 0, or -ENODEV if the head was removed. */
int telemetry_read(const struct head *head, struct telemetry *telemetry);

/* The value of a fact; "" if there is none of this name */
const char *telemetry_get(const struct telemetry *telemetry, const char *format, ...)
	__attribute__((format(printf, 2, 3)));

/* A dash for a value that was not reported */
const char *or_dash(const char *value);

struct json_object;

/* The value of a fact: null, a number or a text */
struct json_object *fact_json(const struct fact *fact);
/* All facts, and the devices of the head, as members of an object */
void telemetry_json(struct json_object *object, const struct head *head,
		    const struct telemetry *telemetry);

/* Counters of the head and of its stream, as text and as members of an object */
void statistics_print(const struct head *head);
void statistics_json(struct json_object *object, const struct head *head);

/* The picture: at most 22 lines of at most 79 characters. Return the number of lines. */
int telemetry_print(const struct head *head, const struct telemetry *telemetry);

#endif /* TELEMETRY_H */
