// SPDX-License-Identifier: GPL-2.0-only
/*
 * KUnit: the driver of scanheads - the search for the rate (autobaud), with a UART of
 * xy3_rig_serdev.h, in time-travel mode: minutes of listening take a second
 */

#include <linux/delay.h>
#include <linux/module.h>

#include "xy3_rig_serdev.h"

/* Each turn: the rate of the UART, and the time of listening */
struct turn {
	u32 rate;
	unsigned int ms;
};

static const struct turn turns[] = {
	{ 230400, 500 }, { 460800, 500 }, { 921600, 500 }, { 57600, 500 },
	{ 115200, 1000 }, { 230400, 1000 }, { 460800, 1000 }, { 921600, 1000 }, { 57600, 1000 },
	{ 115200, 2000 }, { 230400, 2000 }, { 460800, 2000 }, { 921600, 2000 }, { 57600, 2000 },
	{ 115200, 4000 }, { 230400, 4000 }, { 460800, 4000 }, { 921600, 4000 }, { 57600, 4000 },
	{ 115200, 4000 }, { 230400, 4000 },
};

/* The first turn of 4 s: long enough to detect that it was ended early */
#define LONG_TURN	14

#define JIFFY_MS	(1000 / HZ + 1)

static void expect_time(struct kunit *test, s64 ms, s64 want, unsigned int turn)
{
	KUNIT_EXPECT_GE_MSG(test, ms, want - JIFFY_MS, "turn %u", turn);
	KUNIT_EXPECT_LT_MSG(test, ms, want * 2, "turn %u", turn);
}

static s64 now_ms(void)
{
	return ktime_to_ms(ktime_get());
}

/* All five are tried in each round, the current one first; no command is sent */
static void search_order_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	struct call *got = kunit_kzalloc(test, sizeof(call_log), GFP_KERNEL);
	s64 begin;

	KUNIT_ASSERT_NOT_NULL(test, got);
	forward_come(test);
	EXPECT_SHOWS(test, head, "autobaud", "0");
	msleep(10000);
	expect_no_call(test);

	begin = now_ms();
	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1\n"), 0);
	EXPECT_SHOWS(test, head, "autobaud", "1");
	KUNIT_ASSERT_TRUE(test, wait_calls(ARRAY_SIZE(turns)));
	scoped_guard(spinlock_irqsave, &call_log_lock)
		memcpy(got, call_log, sizeof(call_log));

	expect_time(test, got[0].ms - begin, 500, 0);
	for (unsigned int i = 0; i < ARRAY_SIZE(turns); i++) {
		KUNIT_EXPECT_EQ_MSG(test, got[i].event, UART, "turn %u", i + 1);
		KUNIT_EXPECT_EQ_MSG(test, got[i].value, turns[i].rate, "turn %u", i + 1);
		if (i)
			expect_time(test, got[i].ms - got[i - 1].ms, turns[i - 1].ms, i);
	}
	EXPECT_SHOWS(test, head, "rate", "230400");
}

static void search_end_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	KUNIT_ASSERT_TRUE(test, wait_calls(2));
	msleep(SETTLED_MS);
	SEND(test, uart, SYNC, SYNC);
	msleep(20000);
	EXPECT_CALLS(test, { UART, 230400 }, { UART, 460800 });
	EXPECT_SHOWS(test, head, "rate", "460800");
	EXPECT_SHOWS(test, head, "in_sync", "1");

	/* sync is lost: the current rate is tried first, and a new search starts after it */
	SEND(test, uart, 0x99);
	KUNIT_ASSERT_TRUE(test, wait_calls(1));
	EXPECT_CALLS(test, { UART, 921600 });
	KUNIT_ASSERT_TRUE(test, wait_calls(1));
	EXPECT_CALLS(test, { UART, 57600 });
	msleep(SETTLED_MS);
	SEND(test, uart, SYNC, SYNC);

	/* lost and found again in that first turn */
	SEND(test, uart, 0x99);
	msleep(100);
	SEND(test, uart, SYNC, SYNC);
	msleep(20000);
	expect_no_call(test);
}

static void search_off_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	KUNIT_EXPECT_EQ(test, store(head, "autobaud", "2"), -EINVAL);
	KUNIT_EXPECT_EQ(test, store(head, "autobaud", ""), -EINVAL);
	KUNIT_EXPECT_EQ(test, store(head, "autobaud", "maybe"), -EINVAL);
	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	KUNIT_ASSERT_TRUE(test, wait_calls(1));
	EXPECT_CALLS(test, { UART, 230400 });
	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "0"), 0);
	msleep(20000);
	expect_no_call(test);
	EXPECT_SHOWS(test, head, "rate", "230400");

	/* in sync there is no search */
	SEND(test, uart, SYNC, SYNC);
	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	msleep(20000);
	expect_no_call(test);
}

static void search_send(struct kunit *test, struct uart *uart, size_t size)
{
	u8 *data = kunit_kmalloc(test, size, GFP_KERNEL);

	KUNIT_ASSERT_NOT_NULL(test, data);
	memset(data, 0x99, size);
	uart_send(test, uart, data, size);
	kunit_kfree(test, data);
}

/* 1 KiB without sync proves that the rate is wrong */
static void search_give_up_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);
	s64 begin;

	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	KUNIT_ASSERT_TRUE(test, wait_calls(LONG_TURN + 1));
	clear_call_log();
	msleep(SETTLED_MS);

	search_send(test, uart, 1000);
	search_send(test, uart, 23);
	msleep(1000);
	expect_no_call(test);
	begin = now_ms();
	search_send(test, uart, 1);
	KUNIT_ASSERT_TRUE(test, wait_calls(1));
	KUNIT_EXPECT_LT(test, now_ms() - begin, 1000);
	EXPECT_CALLS(test, { UART, 230400 });

	/* counted from 0 at each rate; more than enough in one piece is one step */
	msleep(SETTLED_MS);
	search_send(test, uart, 1023);
	msleep(1000);
	expect_no_call(test);
	begin = now_ms();
	search_send(test, uart, 4096);
	KUNIT_ASSERT_TRUE(test, wait_calls(1));
	KUNIT_EXPECT_LT(test, now_ms() - begin, 1000);
	msleep(1000);
	EXPECT_CALLS(test, { UART, 460800 });

	/* 1 KiB with sync proves nothing */
	msleep(SETTLED_MS);
	search_send(test, uart, 600);
	SEND(test, uart, SYNC, SYNC);
	for (unsigned int i = 0; i < 300; i++)
		SEND(test, uart, SYNC);
	msleep(20000);
	expect_no_call(test);
}

/*
 * Bytes that were received before the rate was changed are delivered after it, and prove nothing
 * about the new rate: damaged or not, they do not end its turn.
 */
static void search_stale_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	for (unsigned int turn = 1; turn <= LONG_TURN; turn++) {
		KUNIT_ASSERT_TRUE(test, wait_calls(turn));
		search_send(test, uart, 4096);
	}
	KUNIT_ASSERT_TRUE(test, wait_calls(LONG_TURN + 1));
	search_send(test, uart, 4096);
	clear_call_log();
	msleep(1000);
	expect_no_call(test);

	SEND(test, uart, SYNC, SYNC);
	EXPECT_SHOWS(test, head, "in_sync", "1");
	EXPECT_SHOWS(test, head, "rate", "115200");
}

static bool can_115200_and_57600(unsigned int rate)
{
	return rate == 115200 || rate == 57600;
}

static bool can_nothing(unsigned int rate)
{
	return false;
}

/* Unsupported rates of the UART are skipped, with a pause if there is no other */
static void search_refused_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	uart->can = can_115200_and_57600;
	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	KUNIT_ASSERT_TRUE(test, wait_calls(8));
	EXPECT_CALLS(test, { NO_UART, 230400 }, { UART, 115200 }, { NO_UART, 460800 },
		     { UART, 115200 }, { NO_UART, 921600 }, { UART, 115200 },
		       { UART, 57600 }, { UART, 115200 });
	EXPECT_SHOWS(test, head, "rate", "115200");

	uart->can = can_nothing;
	clear_call_log();
	msleep(10000);
	KUNIT_EXPECT_LE(test, call_count(), 2 * 10 * 10);
	KUNIT_EXPECT_GE(test, call_count(), 2 * 5);
}

/* There is also a pause if the UART supports no rate and the head sends a lot */
static void search_refused_loud_test(struct kunit *test)
{
	struct uart *uart = uart_come(test, NULL);

	uart->can = can_nothing;
	uart->rate = 126720;	/* the actual rate: 10 % too fast */
	KUNIT_ASSERT_EQ(test, store(uart_head(uart), "autobaud", "1"), 0);
	KUNIT_ASSERT_TRUE(test, wait_calls(2));
	clear_call_log();
	for (unsigned int i = 0; i < 200; i++) {
		search_send(test, uart, 1024);
		msleep(20);
	}
	/* two calls per attempt, and ten attempts per second, for at least four seconds */
	KUNIT_EXPECT_LE(test, call_count(), 2 * 10 * 4 * 2);
	KUNIT_EXPECT_GE(test, call_count(), 2 * 5);
}

/* The backchannel is removed during the search */
static void search_leave_test(struct kunit *test)
{
	struct forward *forward = forward_come(test);
	struct uart *uart = uart_come(test, NULL);
	struct xy3_head *head = uart_head(uart);

	KUNIT_ASSERT_EQ(test, store(head, "autobaud", "1"), 0);
	KUNIT_ASSERT_TRUE(test, wait_calls(1));
	uart_unplug(uart);
	clear_call_log();
	msleep(10000);
	expect_no_call(test);

	/* and another one is added: a new search */
	uart = uart_come(test, NULL);
	KUNIT_ASSERT_PTR_EQ(test, uart_head(uart), head);
	EXPECT_SHOWS(test, head, "autobaud", "1");
	KUNIT_ASSERT_TRUE(test, wait_calls(2));
	EXPECT_CALLS(test, { UART, 230400 }, { UART, 460800 });

	/* the last one is removed during a search */
	forward_leave(forward);
	uart_unplug(uart);
	KUNIT_EXPECT_EQ(test, heads(), 0);
	clear_call_log();
	msleep(10000);
	expect_no_call(test);
}

static struct kunit_case xy3_search_cases[] = {
	KUNIT_CASE_SLOW(search_order_test),
	KUNIT_CASE_SLOW(search_end_test),
	KUNIT_CASE_SLOW(search_off_test),
	KUNIT_CASE_SLOW(search_give_up_test),
	KUNIT_CASE_SLOW(search_stale_test),
	KUNIT_CASE_SLOW(search_refused_test),
	KUNIT_CASE_SLOW(search_refused_loud_test),
	KUNIT_CASE_SLOW(search_leave_test),
	{}
};

static int xy3_search_suite_init(struct kunit_suite *suite)
{
	return rig_suite_init();
}

static void xy3_search_suite_exit(struct kunit_suite *suite)
{
	rig_suite_exit();
}

static int xy3_search_init(struct kunit *test)
{
	KUNIT_EXPECT_EQ(test, heads(), 0);
	clear_call_log();
	return 0;
}

static struct kunit_suite xy3_search_suite = {
	.name = "xy3_search",
	.suite_init = xy3_search_suite_init,
	.suite_exit = xy3_search_suite_exit,
	.init = xy3_search_init,
	.test_cases = xy3_search_cases,
};

kunit_test_suite(xy3_search_suite);

MODULE_DESCRIPTION("KUnit tests of the scanhead's driver: the search for the rate");
MODULE_LICENSE("GPL");
