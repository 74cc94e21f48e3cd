// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: the UART at the end of its backchannel, a tty
 *
 * If the speed of the tty is not that of the head, it receives the same as a UART that samples the
 * line at another rate: garbage, with framing errors.
 */

#include <linux/cleanup.h>
#include <linux/err.h>
#include <linux/math64.h>
#include <linux/mm.h>
#include <linux/platform_device.h>
#include <linux/slab.h>
#include <linux/tty.h>
#include <linux/tty_driver.h>
#include <linux/tty_flip.h>

#include "sim.h"

/* Start bit, eight data bits, stop bit */
#define SIM_BYTE_BITS		10
#define SIM_STOP_BIT		9

/* Time on the line, in 1/65536 of the bits of the head */
#define SIM_BIT			65536ULL

/* With less room nothing more is sent: the reader is slow */
#define SIM_ROOM_MIN		4096

static struct tty_driver *sim_tty_driver;

/* Protects the table below against an open while a head is removed */
static DEFINE_MUTEX(sim_table_lock);
static struct xy3_sim *sim_table[XY3_SIM_HEADS_MAX];

/* ---- received data ---- */

static void sim_receive(struct xy3_sim *sim, u8 byte, bool good)
{
	if (!tty_insert_flip_char(&sim->uart.port, byte, good ? TTY_NORMAL : TTY_FRAME))
		sim->uart.lost_bytes++;
}

/* The level of the line while these bytes are sent; it is high otherwise */
static bool sim_level(const u8 *data, size_t size, u64 time)
{
	u64 bit = div_u64(time, SIM_BIT);
	u32 in_byte;
	u64 byte = div_u64_rem(bit, SIM_BYTE_BITS, &in_byte);

	if (byte >= size || in_byte == SIM_STOP_BIT)
		return true;
	return in_byte && data[byte] >> (in_byte - 1) & 1;
}

/* After a start bit: the byte that the UART receives, and when it looks for the next one */
static u64 sim_sample(struct xy3_sim *sim, const u8 *data, size_t size, u64 time, u64 step)
{
	u8 byte = 0;

	time += step / 2;
	if (sim_level(data, size, time))
		return time;
	for (unsigned int i = 0; i < 8; i++) {
		time += step;
		byte |= sim_level(data, size, time) << i;
	}
	time += step;
	sim_receive(sim, byte, sim_level(data, size, time));
	return time;
}

static void sim_garble(struct xy3_sim *sim, const u8 *data, size_t size, unsigned int speed)
{
	u64 step = div_u64(sim->head.rate * SIM_BIT, speed);
	u64 end = size * SIM_BYTE_BITS * SIM_BIT;
	u64 time = 0;

	while (time < end) {
		if (sim_level(data, size, time))
			time = (time | (SIM_BIT - 1)) + 1;
		else
			time = sim_sample(sim, data, size, time, step);
	}
}

/**
 * xy3_sim_uart_send() - send bytes at the rate of the head
 * @sim: the head; its lock is held
 * @data: the bytes
 * @size: number of bytes
 * @line_error: index of the byte with a framing error, or -1
 */
void xy3_sim_uart_send(struct xy3_sim *sim, const u8 *data, size_t size, int line_error)
{
	unsigned int speed = READ_ONCE(sim->uart.speed);

	if (!sim->uart.open || !speed)
		return;
	if (speed != sim->head.rate) {
		sim->uart.garbled_packets++;
		sim_garble(sim, data, size, speed);
		return;
	}
	for (size_t i = 0; i < size; i++)
		sim_receive(sim, data[i], line_error < 0 || i != line_error);
}

/**
 * xy3_sim_uart_push() - pass data to the reader
 * @sim: the head; its lock is held
 */
void xy3_sim_uart_push(struct xy3_sim *sim)
{
	tty_flip_buffer_push(&sim->uart.port);
}

/**
 * xy3_sim_uart_room() - check for a reader that is fast enough
 * @sim: the head; its lock is held
 *
 * Return: true if the tty is open, and its buffer is not almost full.
 */
bool xy3_sim_uart_room(struct xy3_sim *sim)
{
	return sim->uart.open && tty_buffer_space_avail(&sim->uart.port) >= SIM_ROOM_MIN;
}

/* ---- the port ---- */

static struct xy3_sim *sim_of_port(struct tty_port *port)
{
	return container_of(port, struct xy3_sim, uart.port);
}

static int sim_port_activate(struct tty_port *port, struct tty_struct *tty)
{
	struct xy3_sim *sim = sim_of_port(port);

	guard(mutex)(&sim->lock);
	WRITE_ONCE(sim->uart.speed, tty_get_baud_rate(tty));
	sim->uart.open = true;
	sim->uart.openings++;
	xy3_sim_telemetry_soon(sim);
	return 0;
}

static void sim_port_shutdown(struct tty_port *port)
{
	struct xy3_sim *sim = sim_of_port(port);

	guard(mutex)(&sim->lock);
	sim->uart.open = false;
}

static void sim_port_destruct(struct tty_port *port)
{
	struct xy3_sim *sim = sim_of_port(port);

	kvfree(sim->record.codes);
	kfree(sim);
}

static const struct tty_port_operations sim_port_ops = {
	.activate = sim_port_activate,
	.shutdown = sim_port_shutdown,
	.destruct = sim_port_destruct,
};

/* ---- the tty ---- */

static int sim_install(struct tty_driver *driver, struct tty_struct *tty)
{
	struct xy3_sim *sim;
	int err;

	scoped_guard(mutex, &sim_table_lock) {
		sim = sim_table[tty->index];
		if (sim)
			tty_port_get(&sim->uart.port);
	}
	if (!sim)
		return -ENODEV;
	err = tty_port_install(&sim->uart.port, driver, tty);
	if (err) {
		tty_port_put(&sim->uart.port);
		return err;
	}
	tty->driver_data = sim;
	return 0;
}

static void sim_cleanup(struct tty_struct *tty)
{
	struct xy3_sim *sim = tty->driver_data;

	tty_port_put(&sim->uart.port);
}

static int sim_open(struct tty_struct *tty, struct file *file)
{
	return tty_port_open(tty->port, tty, file);
}

static void sim_close(struct tty_struct *tty, struct file *file)
{
	tty_port_close(tty->port, tty, file);
}

static void sim_hangup(struct tty_struct *tty)
{
	tty_port_hangup(tty->port);
}

/* The head does not receive */
static ssize_t sim_write(struct tty_struct *tty, const u8 *data, size_t size)
{
	struct xy3_sim *sim = tty->driver_data;

	atomic64_add(size, &sim->uart.written_bytes);
	return size;
}

static unsigned int sim_write_room(struct tty_struct *tty)
{
	return PAGE_SIZE;
}

/* Any speed up to the highest one; always 8 bits, no parity, one stop bit */
static void sim_set_termios(struct tty_struct *tty, const struct ktermios *old)
{
	struct xy3_sim *sim = tty->driver_data;
	unsigned int speed = tty_get_baud_rate(tty);

	tty->termios.c_cflag &= ~(CSIZE | CSTOPB | PARENB | CRTSCTS);
	tty->termios.c_cflag |= CS8;
	if (speed > sim->config.uart_max) {
		speed = old ? tty_termios_baud_rate(old) : sim->config.uart_max;
		tty_encode_baud_rate(tty, speed, speed);
	}
	WRITE_ONCE(sim->uart.speed, speed);
}

static const struct tty_operations sim_tty_ops = {
	.install = sim_install,
	.cleanup = sim_cleanup,
	.open = sim_open,
	.close = sim_close,
	.hangup = sim_hangup,
	.write = sim_write,
	.write_room = sim_write_room,
	.set_termios = sim_set_termios,
};

/* ---- adding and removing ---- */

/**
 * xy3_sim_uart_add() - create the tty
 * @sim: the head, which from now on is freed with the last reference to its tty port
 *
 * Return: 0 or an error.
 */
int xy3_sim_uart_add(struct xy3_sim *sim)
{
	struct device *dev;

	tty_port_init(&sim->uart.port);
	sim->uart.port.ops = &sim_port_ops;
	scoped_guard(mutex, &sim_table_lock)
		sim_table[sim->number] = sim;
	dev = tty_port_register_device(&sim->uart.port, sim_tty_driver, sim->number,
				       &sim->pdev->dev);
	if (!IS_ERR(dev))
		return 0;
	scoped_guard(mutex, &sim_table_lock)
		sim_table[sim->number] = NULL;
	tty_port_put(&sim->uart.port);
	return PTR_ERR(dev);
}

/**
 * xy3_sim_uart_remove() - remove the tty, and the head with it
 * @data: the head
 */
void xy3_sim_uart_remove(void *data)
{
	struct xy3_sim *sim = data;

	scoped_guard(mutex, &sim_table_lock)
		sim_table[sim->number] = NULL;
	scoped_guard(mutex, &sim->lock)
		sim->gone = true;
	cancel_delayed_work_sync(&sim->work);
	tty_port_tty_vhangup(&sim->uart.port);
	tty_unregister_device(sim_tty_driver, sim->number);
	tty_port_put(&sim->uart.port);
}

/**
 * xy3_sim_tty_init() - register the tty driver
 *
 * Return: 0 or an error.
 */
int xy3_sim_tty_init(void)
{
	struct tty_driver *driver;
	int err;

	driver = tty_alloc_driver(XY3_SIM_HEADS_MAX, TTY_DRIVER_REAL_RAW |
				  TTY_DRIVER_DYNAMIC_DEV);
	if (IS_ERR(driver))
		return PTR_ERR(driver);
	driver->driver_name = "xy3-sim";
	driver->name = "ttyXY3SIM";
	driver->type = TTY_DRIVER_TYPE_SERIAL;
	driver->subtype = SERIAL_TYPE_NORMAL;
	driver->init_termios = tty_std_termios;
	driver->init_termios.c_iflag = 0;
	driver->init_termios.c_oflag = 0;
	driver->init_termios.c_lflag = 0;
	driver->init_termios.c_cflag = B115200 | CS8 | CREAD | CLOCAL;
	driver->init_termios.c_ispeed = 115200;
	driver->init_termios.c_ospeed = 115200;
	tty_set_operations(driver, &sim_tty_ops);
	err = tty_register_driver(driver);
	if (err) {
		tty_driver_kref_put(driver);
		return err;
	}
	sim_tty_driver = driver;
	return 0;
}

/**
 * xy3_sim_tty_exit() - unregister the tty driver, which has no heads any more
 */
void xy3_sim_tty_exit(void)
{
	tty_unregister_driver(sim_tty_driver);
	tty_driver_kref_put(sim_tty_driver);
}
