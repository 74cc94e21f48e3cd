// SPDX-License-Identifier: GPL-2.0-only
/* Every change from one pair of keys to another, against sets of keys. */
#include <kunit/test.h>

#include "../../../../drivers/hid-xhc/xhc-codec.c"

struct key_set { bool has[256]; };

static void set_of(const u8 *slots, struct key_set *set)
{
	memset(set, 0, sizeof(*set));
	for (int i = 0; i < 2; i++)
		if (slots[i])
			set->has[slots[i]] = true;
}

/* The changes must turn the old set into the new one, and each must change the set. */
static void check(struct kunit *test, const u8 *was, const u8 *now)
{
	struct xhc_key_change change[XHC_KEY_CHANGES_MAX];
	struct key_set before, after;
	bool pressed = false;
	unsigned int n;

	set_of(was, &before);
	set_of(now, &after);
	n = xhc_key_changes(was, now, change);
	KUNIT_ASSERT_LE(test, n, ARRAY_SIZE(change));
	for (unsigned int i = 0; i < n; i++) {
		KUNIT_ASSERT_NE(test, before.has[change[i].code], change[i].down);
		KUNIT_ASSERT_FALSE_MSG(test, pressed && !change[i].down,
				       "a release after a press: %02x %02x to %02x %02x",
				       was[0], was[1], now[0], now[1]);
		pressed |= change[i].down;
		before.has[change[i].code] = change[i].down;
	}
	KUNIT_ASSERT_MEMEQ_MSG(test, before.has, after.has, sizeof(after.has),
			       "%02x %02x to %02x %02x", was[0], was[1], now[0], now[1]);
}

static void every_pair_to_every_pair(struct kunit *test)
{
	for (u32 n = 0; n < 24 * 24 * 24 * 24; n++) {
		const u8 was[2] = { n % 24, n / 24 % 24 };
		const u8 now[2] = { n / (24 * 24) % 24, n / (24 * 24 * 24) };

		check(test, was, now);
	}
}

static void every_code_in_every_slot(struct kunit *test)
{
	for (u32 n = 0; n < 4 * 256 * 16; n++) {
		u8 slots[4] = { n / 4 & 1, n / 4 & 2, n / 4 & 4, n / 4 & 8 };

		slots[n % 4] = n / 64;
		check(test, slots, slots + 2);
	}
}

static struct kunit_case cases[] = {
	KUNIT_CASE(every_pair_to_every_pair),
	KUNIT_CASE(every_code_in_every_slot),
	{}
};

static struct kunit_suite suite = { .name = "exhaustive_keys", .test_cases = cases };
kunit_test_suite(suite);
