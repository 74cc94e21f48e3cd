// SPDX-License-Identifier: GPL-2.0-only
/*
 * libxy3: scans through /dev/spidevB.C
 *
 * spidev returns when a message has been sent, so there is a pause between messages. If SYNC is a
 * line a message is one transfer of a gap and many scans: the level at which the controller has
 * left the line before is unknown. If it is the chip select each scan is a transfer with cs_change;
 * spidev leaves the delay to the SPI core, which uses 10 us.
 *
 * The size of a message is limited by spidev's parameter bufsiz; but spidev rounds each transfer up
 * to what DMA requires on this processor, and a controller may have a limit, too. A message that is
 * too long is refused before anything is sent, so the size is halved until it is accepted.
 */

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <linux/minmax.h>
#include <linux/spi/spi.h>
#include <linux/spi/spidev.h>

#include "libxy3.h"
#include "scans.h"
#include "xy3-lines.h"

#define XY3_BUFSIZ		"/sys/module/spidev/parameters/bufsiz"
#define XY3_BUFSIZ_DEFAULT	4096
#define XY3_BUFSIZ_MAX		(1024 * 1024)

#define XY3_RATE_USUAL		100000

/* Limit of the size field of an ioctl number */
#define XY3_TRANSFERS_MAX	(((1 << _IOC_SIZEBITS) - 1) / sizeof(struct spi_ioc_transfer))

/* The only mode bit that depends on the board: the active level of the chip select */
#define XY3_MODE_KEPT		SPI_CS_HIGH

/**
 * struct xy3_spidev - an open device
 * @map: the signal of each line
 * @fd: the device
 * @rate: frames per second
 * @speed: the clock in Hz
 * @block: maximum number of scans per message
 * @sent: @last is valid
 * @last: the last position scan that was sent, encoded
 * @message: the bytes of a message: a gap if SYNC is a line, then scans
 * @bytes: the scans in @message
 * @transfers: the transfers of a message
 */
struct xy3_spidev {
	struct xy3_line_map map;
	int fd;
	unsigned int rate;
	uint32_t speed;
	unsigned int block;
	bool sent;
	uint8_t last[XY3_SCAN_SIZE_MAX];
	uint8_t *message;
	uint8_t *bytes;
	struct spi_ioc_transfer *transfers;
};

/* ---- messages ---- */

static bool xy3_cs_is_sync(const struct xy3_spidev *s)
{
	return s->map.sync_line < 0;
}

/* Send the first scans of @bytes */
static int xy3_send(struct xy3_spidev *s, unsigned int scans)
{
	unsigned int count = xy3_cs_is_sync(s) ? scans : 1;
	size_t size = (size_t)scans / count * s->map.scan_size;
	size_t gap = xy3_gap_size(&s->map);

	for (unsigned int i = 0; i < count; i++)
		s->transfers[i] = (struct spi_ioc_transfer) {
			.tx_buf = (uintptr_t)(s->message + i * size),
			.len = gap + size,
			.speed_hz = s->speed,
			.bits_per_word = 8,
			.tx_nbits = s->map.lines,
			/* on the last transfer it would leave the chip select active */
			.cs_change = i + 1 < count,
		};
	if (ioctl(s->fd, _IOC(_IOC_WRITE, SPI_IOC_MAGIC, 0, count * sizeof(*s->transfers)),
		  s->transfers) < 0)
		return -errno;
	return 0;
}

/* A controller keeps the lines at their last levels after a message: the gate must be low */
static unsigned int xy3_closing(const struct xy3_spidev *s)
{
	return s->map.gate_line >= 0;
}

static void xy3_fill(struct xy3_spidev *s, const uint32_t *codes, unsigned int scans)
{
	if (codes) {
		xy3_encode_scans(&s->map, codes, scans, s->bytes);
		return;
	}
	for (unsigned int i = 0; i < scans; i++)
		memcpy(s->bytes + i * s->map.scan_size, s->last, s->map.scan_size);
}

/*
 * A message has failed, and the gate may be at any level: try once to lower it, with the last scan
 * sent, or the first one of the message if none was.
 */
static void xy3_close_after_error(struct xy3_spidev *s)
{
	if (s->sent)
		memcpy(s->bytes, s->last, s->map.scan_size);
	xy3_lower_gate(&s->map, s->bytes);
	xy3_send(s, 1);
}

/* Send @codes, or the last scan again if NULL. Return the number of scans sent, or an error. */
static ssize_t xy3_send_scans(struct xy3_spidev *s, const uint32_t *codes, size_t scans)
{
	unsigned int part, closing = xy3_closing(s);
	size_t done = 0;
	uint8_t *last;
	int err;

	while (done < scans) {
		part = min((size_t)s->block, scans - done);
		xy3_fill(s, codes ? codes + done * s->map.columns : NULL, part);
		last = s->bytes + (part - 1) * s->map.scan_size;
		if (closing) {
			memcpy(last + s->map.scan_size, last, s->map.scan_size);
			last += s->map.scan_size;
			xy3_lower_gate(&s->map, last);
		}
		err = xy3_send(s, part + closing);
		if (err == -EMSGSIZE && part > 1) {
			s->block = part / 2;
			continue;
		}
		if (err) {
			if (closing)
				xy3_close_after_error(s);
			return done ? (ssize_t)done : err;
		}
		memcpy(s->last, last, s->map.scan_size);
		s->sent = true;
		done += part;
	}
	return done;
}

ssize_t xy3_spidev_write(struct xy3_spidev *spidev, const uint32_t *codes, size_t scans)
{
	int err = xy3_check_scans(&spidev->map, codes, scans);

	return err ? err : xy3_send_scans(spidev, codes, scans);
}

ssize_t xy3_spidev_repeat(struct xy3_spidev *spidev, size_t scans)
{
	return spidev->sent ? xy3_send_scans(spidev, NULL, scans) : -ENODATA;
}

int xy3_spidev_command(struct xy3_spidev *spidev, uint32_t command)
{
	int err = xy3_line_map_encode_command(&spidev->map, command, spidev->bytes);

	return err ? err : xy3_send(spidev, 1);
}

/* ---- open and close ---- */

static uint32_t xy3_lines_mode(unsigned int lines)
{
	switch (lines) {
	case 8:
		return SPI_TX_OCTAL;
	case 4:
		return SPI_TX_QUAD;
	case 2:
		return SPI_TX_DUAL;
	}
	return 0;
}

/* Set mode 1 and the lines. The kernel silently drops lines that the controller lacks. */
static int xy3_set_mode(struct xy3_spidev *s)
{
	uint32_t was, wanted, got;

	if (ioctl(s->fd, SPI_IOC_RD_MODE32, &was) < 0)
		return -errno;
	wanted = (was & XY3_MODE_KEPT) | SPI_MODE_1 | xy3_lines_mode(s->map.lines);
	if (ioctl(s->fd, SPI_IOC_WR_MODE32, &wanted) < 0 ||
	    ioctl(s->fd, SPI_IOC_RD_MODE32, &got) < 0)
		return -errno;
	if (got == wanted)
		return 0;
	ioctl(s->fd, SPI_IOC_WR_MODE32, &was);
	return -EOPNOTSUPP;
}

static int xy3_set_rate(struct xy3_spidev *s, unsigned int rate)
{
	unsigned int clocks = s->map.scan_size * 8 / s->map.lines;
	uint32_t max;

	if (ioctl(s->fd, SPI_IOC_RD_MAX_SPEED_HZ, &max) < 0)
		return -errno;
	s->rate = rate ? rate : min((unsigned int)XY3_RATE_USUAL, max / clocks);
	if (!s->rate || s->rate > max / clocks)
		return -ERANGE;
	s->speed = s->rate * clocks;
	return 0;
}

static size_t xy3_bufsiz(void)
{
	int fd = open(XY3_BUFSIZ, O_RDONLY | O_CLOEXEC);
	char text[16] = "";
	long size = 0;

	if (fd >= 0) {
		if (read(fd, text, sizeof(text) - 1) > 0)
			size = strtol(text, NULL, 10);
		close(fd);
	}
	return size > 0 ? min(size, (long)XY3_BUFSIZ_MAX) : XY3_BUFSIZ_DEFAULT;
}

/* Allocate a message of the maximum size */
static int xy3_make_room(struct xy3_spidev *s)
{
	size_t gap = xy3_gap_size(&s->map), room = max(xy3_bufsiz(), gap) - gap;
	size_t least = 1 + xy3_closing(s), scans = max(room / s->map.scan_size, least);

	if (xy3_cs_is_sync(s))
		scans = min(scans, XY3_TRANSFERS_MAX);
	s->block = scans - xy3_closing(s);
	s->message = malloc(gap + scans * s->map.scan_size);
	s->transfers = calloc(xy3_cs_is_sync(s) ? scans : 1, sizeof(*s->transfers));
	if (!s->message || !s->transfers)
		return -ENOMEM;
	xy3_encode_gap(&s->map, s->message);
	s->bytes = s->message + gap;
	return 0;
}

int xy3_spidev_open(struct xy3_spidev **spidev, const char *path, const struct xy3_line_map *map,
		    unsigned int rate)
{
	struct xy3_spidev *s = calloc(1, sizeof(*s));
	int err;

	if (!s)
		return -ENOMEM;
	s->map = *map;
	s->fd = open(path, O_RDWR | O_CLOEXEC);
	err = s->fd < 0 ? -errno : xy3_make_room(s);
	if (!err)
		err = xy3_set_rate(s, rate);
	/* as the last step, so that no failure changes the device */
	if (!err)
		err = xy3_set_mode(s);
	if (err) {
		xy3_spidev_close(s);
		return err;
	}
	*spidev = s;
	return 0;
}

void xy3_spidev_close(struct xy3_spidev *spidev)
{
	if (!spidev)
		return;
	if (spidev->fd >= 0)
		close(spidev->fd);
	free(spidev->transfers);
	free(spidev->message);
	free(spidev);
}

unsigned int xy3_spidev_rate(const struct xy3_spidev *spidev)
{
	return spidev->rate;
}

unsigned int xy3_spidev_block(const struct xy3_spidev *spidev)
{
	return spidev->block;
}
