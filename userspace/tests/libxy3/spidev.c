// SPDX-License-Identifier: GPL-2.0-only
/*
 * xy3_spidev_*() with a simulated spidev: the linker replaces the functions of libc by
 * __wrap_ioctl() and __wrap_open(). So spidev can have any bufsiz and any alignment, and
 * controllers can have any limits that exist.
 */

#include <errno.h>
#include <fcntl.h>
#include <libxy3.h>
#include <linux/spi/spi.h>
#include <linux/spi/spidev.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>

#include "check.h"

#define RECEIVED_MAX	65536

/* The device. With zeros it can do little; device_new() initializes one without faults. */
static struct device {
	uint32_t mode, mode_bits;	/* mode_bits: what the controller can do */
	uint32_t max_speed;
	const char *bufsiz;		/* the file of the parameter of spidev */
	size_t room, align;		/* actual size in spidev, and its alignment */
	size_t max_transfer;		/* of the controller; 0: any */
	unsigned int fail_in;		/* the message of this number fails */
	int error;			/* returned by all calls */
	bool gap;			/* a message begins with SYNC, line 0 of four */

	unsigned int messages, transfers;
	size_t longest;			/* message, in bytes */
	struct spi_ioc_transfer last;	/* transfer */
	uint8_t received[RECEIVED_MAX];
	size_t size;
} device;

static void device_new(void)
{
	device = (struct device) {
		.mode_bits = SPI_MODE_X_MASK | SPI_CS_HIGH | SPI_TX_DUAL | SPI_TX_QUAD |
			     SPI_TX_OCTAL,
		.max_speed = 50000000, .bufsiz = "/nonexistent", .room = 4096, .align = 8,
	};
}

static int failed(int error)
{
	errno = -error;
	return -1;
}

/* Check for messages that spidev and the controller refuse, before anything is sent */
static int check_message(const struct spi_ioc_transfer *transfer, unsigned int count)
{
	size_t total = 0;

	for (unsigned int i = 0; i < count; i++) {
		total += (transfer[i].len + device.align - 1) / device.align * device.align;
		if (total > device.room)
			return -EMSGSIZE;
	}
	for (unsigned int i = 0; i < count; i++)
		if (device.max_transfer && transfer[i].len > device.max_transfer)
			return -EMSGSIZE;
	return 0;
}

static void receive(const uint8_t *bytes, size_t size, size_t gap)
{
	CHECK(size > gap && (!gap || bytes[0] == 0x11));
	CHECK(device.size + size <= RECEIVED_MAX);
	memcpy(device.received + device.size, bytes + gap, size - gap);
	device.size += size - gap;
}

static int message(const struct spi_ioc_transfer *transfer, unsigned int count)
{
	int error = check_message(transfer, count);
	size_t total = 0;

	if (error)
		return failed(error);
	if (device.fail_in && !--device.fail_in)
		return failed(-EIO);
	for (unsigned int i = 0; i < count; i++) {
		/* SYNC rises after each transfer, and is high at the end of the message */
		CHECK(transfer[i].cs_change == (i + 1 < count));
		CHECK(!transfer[i].rx_buf && !transfer[i].delay_usecs);
		CHECK(!transfer[i].word_delay_usecs && transfer[i].bits_per_word == 8);
		CHECK(transfer[i].speed_hz && transfer[i].speed_hz <= device.max_speed);
		receive((const void *)(uintptr_t)transfer[i].tx_buf, transfer[i].len,
			device.gap && !i);
		total += transfer[i].len;
	}
	device.last = transfer[count - 1];
	device.messages++;
	device.transfers += count;
	device.longest = total > device.longest ? total : device.longest;
	return total;
}

/* Like spi_setup(): unsupported bits are an error, except for lines, which are dropped */
static int set_mode(uint32_t mode)
{
	uint32_t lines = SPI_TX_DUAL | SPI_TX_QUAD | SPI_TX_OCTAL;

	if (mode & ~device.mode_bits & ~lines)
		return failed(-EINVAL);
	device.mode = mode & device.mode_bits;
	return 0;
}

int __wrap_ioctl(int fd, unsigned long request, ...)
{
	va_list arguments;
	void *value;

	(void)fd;
	va_start(arguments, request);
	value = va_arg(arguments, void *);
	va_end(arguments);
	if (device.error)
		return failed(device.error);
	switch (request) {
	case SPI_IOC_RD_MODE32:
		*(uint32_t *)value = device.mode;
		return 0;
	case SPI_IOC_WR_MODE32:
		return set_mode(*(uint32_t *)value);
	case SPI_IOC_RD_MAX_SPEED_HZ:
		*(uint32_t *)value = device.max_speed;
		return 0;
	}
	CHECK(_IOC_TYPE(request) == SPI_IOC_MAGIC && _IOC_NR(request) == 0);
	CHECK(_IOC_DIR(request) == _IOC_WRITE && _IOC_SIZE(request) % sizeof(device.last) == 0);
	return message(value, _IOC_SIZE(request) / sizeof(device.last));
}

int __wrap_open(const char *path, int flags, ...)
{
	if (!strcmp(path, "/sys/module/spidev/parameters/bufsiz"))
		path = device.bufsiz;
	return openat(AT_FDCWD, path, flags);
}

/* ---- helpers ---- */

static struct xy3_line_map *a_map(unsigned int lines, unsigned int bits, const char *signals)
{
	struct xy3_line_map *map = NULL;

	CHECK(xy3_line_map_new(&map, lines, bits, signals) == 0);
	return map;
}

static int try_open(unsigned int lines, const char *signals, unsigned int rate,
		    struct xy3_spidev **spidev)
{
	struct xy3_line_map *map = a_map(lines, 24, signals);
	int err = xy3_spidev_open(spidev, "/dev/null", map, rate);

	device.gap = signals && !strncmp(signals, "sync ", 5);
	xy3_line_map_free(map);
	return err;
}

static struct xy3_spidev *opened(unsigned int lines, const char *signals)
{
	struct xy3_spidev *spidev = NULL;

	CHECK(try_open(lines, signals, 0, &spidev) == 0);
	return spidev;
}

static void count_up(uint32_t *codes, size_t count)
{
	for (size_t i = 0; i < count; i++)
		codes[i] = i * 7 & 0xfffff;
}

/* Whether exactly these scans were received, in this order */
static bool received(unsigned int lines, const char *signals, const uint32_t *codes, size_t scans)
{
	struct xy3_line_map *map = a_map(lines, 24, signals);
	size_t size = scans * xy3_line_map_scan_size(map);
	uint8_t *want = malloc(size + 1);
	bool same;

	CHECK(xy3_line_map_encode(map, codes, scans, want) == 0);
	same = device.size == size && !memcmp(device.received, want, size);
	free(want);
	xy3_line_map_free(map);
	return same;
}

/* ---- to open ---- */

static void mode_and_lines(void)
{
	static const struct {
		unsigned int lines;
		uint32_t mode;
	} rows[] = { { 1, 0 }, { 2, SPI_TX_DUAL }, { 4, SPI_TX_QUAD }, { 8, SPI_TX_OCTAL } };

	for (int i = 0; i < 4; i++) {
		struct xy3_spidev *spidev;
		uint32_t code[5] = { };

		device_new();
		device.mode = SPI_MODE_2 | SPI_CS_HIGH;	/* set by the board, and must be kept */
		spidev = opened(rows[i].lines, NULL);
		CHECK(device.mode == (SPI_MODE_1 | SPI_CS_HIGH | rows[i].mode));
		CHECK(xy3_spidev_write(spidev, code, 1) == 1);
		CHECK(device.last.tx_nbits == rows[i].lines);
		CHECK(device.last.len == rows[i].lines * 3);
		xy3_spidev_close(spidev);
	}
}

static void refused(void)
{
	struct xy3_spidev *spidev = NULL;
	struct xy3_line_map *map = a_map(1, 24, NULL);

	device_new();
	device.mode_bits &= ~SPI_TX_QUAD;
	device.mode = SPI_MODE_3 | SPI_TX_DUAL;
	CHECK(try_open(4, "sync x y z", 0, &spidev) == -EOPNOTSUPP);
	CHECK(device.mode == (SPI_MODE_3 | SPI_TX_DUAL) && !spidev);

	device_new();
	device.mode_bits &= ~SPI_CPHA;
	CHECK(try_open(1, NULL, 0, &spidev) == -EINVAL && device.mode == 0);

	device_new();
	device.error = -ENOTTY;
	CHECK(try_open(1, NULL, 0, &spidev) == -ENOTTY);

	CHECK(xy3_spidev_open(&spidev, "/nonexistent", map, 0) == -ENOENT);
	CHECK(!spidev);
	xy3_spidev_close(NULL);
	xy3_line_map_free(map);
}

static void rates(void)
{
	struct xy3_spidev *spidev = opened(1, NULL);
	uint32_t code[3] = { };

	CHECK(xy3_spidev_rate(spidev) == 100000);
	CHECK(xy3_spidev_write(spidev, code, 1) == 1 && device.last.speed_hz == 2400000);
	xy3_spidev_close(spidev);

	device_new();
	device.max_speed = 2600000;	/* 26 clocks a frame: 24 and the gap */
	CHECK(try_open(4, "sync x y z", 100000, &spidev) == 0);
	CHECK(xy3_spidev_write(spidev, code, 1) == 1 && device.last.speed_hz == 2600000);
	xy3_spidev_close(spidev);
	spidev = NULL;
	device.mode = 0;
	CHECK(try_open(4, "sync x y z", 100001, &spidev) == -ERANGE);
	device.max_speed = 2599999;
	CHECK(try_open(4, "sync x y z", 100000, &spidev) == -ERANGE);
	CHECK(device.mode == 0 && !spidev);
	spidev = opened(4, "sync x y z");
	CHECK(xy3_spidev_rate(spidev) == 99999);
	xy3_spidev_close(spidev);
	device.max_speed = 20;
	CHECK(try_open(1, NULL, 0, &spidev) == -ERANGE);
}

/* ---- to write ---- */

static void one_transfer_a_scan(void)
{
	struct xy3_spidev *spidev;
	uint32_t codes[2 * 2000];

	device_new();
	spidev = opened(2, "y x");
	count_up(codes, 4000);
	CHECK(xy3_spidev_write(spidev, codes, 2000) == 2000);
	CHECK(received(2, "y x", codes, 2000));
	CHECK(device.transfers == 2000 && device.messages == 4);	/* maximum: 511 */
	xy3_spidev_close(spidev);
}

static void one_transfer_a_message(void)
{
	struct xy3_spidev *spidev;
	uint32_t codes[3 * 1000];

	device_new();
	spidev = opened(4, "sync x y z");
	count_up(codes, 3000);
	CHECK(xy3_spidev_write(spidev, codes, 1000) == 1000);
	CHECK(received(4, "sync x y z", codes, 1000));
	/* 315 scans of 13 bytes each, and a gap */
	CHECK(device.messages == 4 && device.transfers == 4);
	CHECK(xy3_spidev_write(spidev, codes, 0) == 0 && device.messages == 4);
	xy3_spidev_close(spidev);
}

static void transfers_are_rounded_up(void)
{
	struct xy3_spidev *spidev;
	uint32_t codes[2000];

	device_new();
	device.align = 128;
	spidev = opened(1, NULL);
	count_up(codes, 2000);
	CHECK(xy3_spidev_write(spidev, codes, 2000) == 2000);
	CHECK(received(1, NULL, codes, 2000));
	CHECK(xy3_spidev_block(spidev) <= 32 && xy3_spidev_block(spidev) > 16);
	xy3_spidev_close(spidev);
}

static void bufsiz_is_another(void)
{
	char name[] = "/tmp/xy3-bufsiz-XXXXXX";
	struct xy3_spidev *spidev;
	uint32_t codes[2000];
	int fd = mkstemp(name);
	FILE *file = fdopen(fd, "w");

	fputs("32\n", file);
	fclose(file);
	device_new();
	device.room = 32;	/* 27 bytes, rounded up */
	device.bufsiz = name;
	spidev = opened(4, "sync x - -");	/* scans of 13 bytes */
	CHECK(xy3_spidev_block(spidev) == 2);
	count_up(codes, 99);
	CHECK(xy3_spidev_write(spidev, codes, 99) == 99);
	CHECK(received(4, "sync x - -", codes, 99) && device.longest == 27);
	xy3_spidev_close(spidev);
	remove(name);
}

static void not_one_scan_fits(void)
{
	struct xy3_spidev *spidev;
	uint32_t codes[300];

	device_new();
	device.max_transfer = 13;
	spidev = opened(4, "sync x y z");
	count_up(codes, 300);
	CHECK(xy3_spidev_write(spidev, codes, 100) == -EMSGSIZE);
	CHECK(xy3_spidev_command(spidev, 0xc0000) == -EMSGSIZE);
	CHECK(!device.size && xy3_spidev_repeat(spidev, 1) == -ENODATA);
	device.max_transfer = 14;
	CHECK(xy3_spidev_write(spidev, codes, 100) == 100 && device.longest == 14);
	CHECK(received(4, "sync x y z", codes, 100));
	xy3_spidev_close(spidev);
}

static void error_in_the_middle(void)
{
	struct xy3_spidev *spidev;
	uint32_t codes[1600];
	unsigned int block;

	device_new();
	spidev = opened(1, NULL);
	block = xy3_spidev_block(spidev);
	count_up(codes, 1600);
	device.fail_in = 3;
	CHECK(xy3_spidev_write(spidev, codes, 1600) == 2 * block);
	CHECK(received(1, NULL, codes, 2 * block));
	device.fail_in = 1;
	CHECK(xy3_spidev_write(spidev, codes + 2 * block, 1600 - 2 * block) == -EIO);
	CHECK(xy3_spidev_write(spidev, codes + 2 * block, 1600 - 2 * block) == 1600 - 2 * block);
	CHECK(received(1, NULL, codes, 1600));
	device.error = -ESHUTDOWN;
	CHECK(xy3_spidev_write(spidev, codes, 1) == -ESHUTDOWN);
	CHECK(xy3_spidev_repeat(spidev, 1) == -ESHUTDOWN);
	CHECK(xy3_spidev_command(spidev, 0) == -ESHUTDOWN);
	xy3_spidev_close(spidev);
}

static void repeat_and_command(void)
{
	uint32_t codes[] = { 3, 4, 1, 2 }, want[2 * 703];
	struct xy3_spidev *spidev;
	struct xy3_line_map *map = a_map(2, 24, NULL);
	uint8_t command[6];

	device_new();
	spidev = opened(2, NULL);
	CHECK(xy3_spidev_repeat(spidev, 1) == -ENODATA);
	CHECK(xy3_spidev_write(spidev, codes, 2) == 2);
	CHECK(xy3_spidev_command(spidev, 0xc0001) == 0);
	CHECK(xy3_line_map_encode_command(map, 0xc0001, command) == 0);
	CHECK(device.size == 18 && !memcmp(device.received + 12, command, 6));
	device.size = 12;
	CHECK(xy3_spidev_repeat(spidev, 701) == 701);	/* the position, not the command */
	for (int i = 0; i < 2 * 703; i++)
		want[i] = codes[i < 2 ? i : 2 + i % 2];
	CHECK(received(2, NULL, want, 703));
	CHECK(xy3_spidev_command(spidev, 1 << 20) == -ERANGE);
	codes[3] = 1 << 20;
	CHECK(xy3_spidev_write(spidev, codes, 2) == -ERANGE);
	CHECK(received(2, NULL, want, 703));
	xy3_spidev_close(spidev);
	xy3_line_map_free(map);
}

/* For any length of messages: the last scan of each has the gate low, the others are unchanged */
static void gate_is_low_behind_each_message(void)
{
	static const uint8_t high[6] = { 0xba, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa };
	struct xy3_spidev *spidev;
	struct xy3_line_map *map;
	uint32_t codes[2 * 1000];
	unsigned int lows = 0;

	for (unsigned int i = 0; i < 2 * 1000; i++)
		codes[i] = i % 2;
	device_new();
	CHECK(xy3_line_map_new(&map, 2, 24, "x gate") == 0);
	CHECK(xy3_spidev_open(&spidev, "/dev/null", map, 0) == 0);
	CHECK(xy3_spidev_write(spidev, codes, 1000) == 1000);
	CHECK(device.size == (1000 + device.messages) * 6);
	for (size_t at = 0; at < device.size; at += 6) {
		lows += device.received[at] == 0x10;
		CHECK(device.received[at] == 0x10 || !memcmp(device.received + at, high, 6));
	}
	CHECK(device.messages > 1 && lows == device.messages);
	CHECK(device.received[device.size - 6] == 0x10);
	device.size = 0;
	CHECK(xy3_spidev_repeat(spidev, 5) == 5);
	for (size_t at = 0; at < device.size; at += 6)
		CHECK(device.received[at] == 0x10);
	xy3_spidev_close(spidev);
	xy3_line_map_free(map);
}

/* Once, at the last position known to be sent, or else at the first one of the message */
static void gate_is_low_after_an_error(void)
{
	const uint32_t codes[] = { 5, 1, 6, 1, 7, 1 };
	const uint32_t lows[] = { 5, 0, 5, 1, 6, 1, 6, 0, 6, 0 };
	struct xy3_spidev *spidev;
	struct xy3_line_map *map;
	uint8_t want[5 * 6];

	device_new();
	CHECK(xy3_line_map_new(&map, 2, 24, "x gate") == 0);
	CHECK(xy3_spidev_open(&spidev, "/dev/null", map, 0) == 0);
	device.fail_in = 1;
	CHECK(xy3_spidev_write(spidev, codes, 2) == -EIO);
	CHECK(xy3_spidev_write(spidev, codes, 2) == 2);
	device.fail_in = 1;
	CHECK(xy3_spidev_write(spidev, codes + 2, 2) == -EIO);
	CHECK(xy3_line_map_encode(map, lows, 5, want) == 0);
	CHECK(device.size == sizeof(want) && !memcmp(device.received, want, sizeof(want)));
	device.error = -ESHUTDOWN;
	CHECK(xy3_spidev_write(spidev, codes, 1) == -ESHUTDOWN);
	xy3_spidev_close(spidev);
	xy3_line_map_free(map);
}

int main(void)
{
	RUN(mode_and_lines);
	RUN(refused);
	device_new();
	RUN(rates);
	RUN(one_transfer_a_scan);
	RUN(one_transfer_a_message);
	RUN(transfers_are_rounded_up);
	RUN(bufsiz_is_another);
	RUN(not_one_scan_fits);
	RUN(error_in_the_middle);
	RUN(repeat_and_command);
	RUN(gate_is_low_behind_each_message);
	RUN(gate_is_low_after_an_error);
	return check_end("spidev");
}
