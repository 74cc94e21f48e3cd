// SPDX-License-Identifier: GPL-2.0-only
/*
 * HAL files of LinuxCNC refer to keys by codes: check that pendants send these codes.
 */
#include <limits.h>
#include <linux/input-event-codes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "doctor.h"

#define PENDANTS "/sys/bus/hid/drivers/hid-xhc/0003:*"
#define PIN "btn-trigger-happy"
#define KEYS 23			/* scan codes; those of the selector have higher numbers */

static struct {
	bool sent[KEYS + 1];	/* by any of the pendants */
	unsigned int pendants, lines, wrong;
} wired;

/* Words of a bitmap in hexadecimal, the highest first */
static bool test_bit(const char *bitmap, unsigned int bit)
{
	const unsigned int size = 8 * sizeof(long);
	unsigned int skip = bit / size;
	const char *word = bitmap + strlen(bitmap);

	do {
		while (word > bitmap && word[-1] != ' ')
			word--;
		if (!skip)
			return strtoul(word, NULL, 16) >> bit % size & 1;
		if (word > bitmap)
			word--;
	} while (word > bitmap && skip--);
	return false;
}

static void look_keys(struct doctor *doctor, const char *path)
{
	char bitmap[512];

	if (doctor_read(doctor, bitmap, sizeof(bitmap), path) <= 0)
		return;
	wired.pendants++;
	for (unsigned int i = 1; i <= KEYS; i++)
		wired.sent[i] |= test_bit(bitmap, BTN_TRIGGER_HAPPY1 + i - 1);
}

static void look_hal_file(struct doctor *doctor, const char *path)
{
	FILE *file = fopen(doctor_path(doctor, "%s", path), "re");
	unsigned long missing = 0;
	char *line = NULL;
	size_t room = 0;

	if (!file)
		return;
	while (getline(&line, &room, file) >= 0) {
		char *pin = line[0] == '#' ? NULL : strstr(line, PIN);
		unsigned long number = pin ? strtoul(pin + strlen(PIN), NULL, 10) : 0;

		if (!number || number > KEYS)
			continue;
		wired.lines++;
		if (!wired.sent[number])
			missing = number;
	}
	free(line);
	fclose(file);
	if (!missing)
		return;
	wired.wrong++;
	doctor_found(doctor, "sudo xhcctl layout default --apply   # or use names of keys in HAL",
		     "%s uses " PIN "%lu, which no pendant sends, as a layout has other codes",
		     path, missing);
}

void look_linuxcnc(struct doctor *doctor)
{
	unsigned int found;

	memset(&wired, 0, sizeof(wired));
	doctor_each(doctor, PENDANTS "/input/input*/capabilities/key", look_keys);
	if (!wired.pendants) {
		doctor_skip(doctor, "no pendant to compare HAL files with");
		return;
	}
	found = doctor_each(doctor, "/home/*/linuxcnc/configs/*/*.hal", look_hal_file);
	found += doctor_each(doctor, "/root/linuxcnc/configs/*/*.hal", look_hal_file);
	if (!wired.lines)
		doctor_skip(doctor, "%u HAL files, none of which has a key of a pendant", found);
	else if (!wired.wrong)
		doctor_ok(doctor, "%u lines of HAL files were compared with the keys", wired.lines);
}
