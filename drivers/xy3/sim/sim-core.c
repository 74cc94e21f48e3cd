// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: its devices
 *
 * Each head is a platform device with an SPI controller, an SPI device on it, and a tty.
 */

#include <linux/cleanup.h>
#include <linux/device.h>
#include <linux/err.h>
#include <linux/idr.h>
#include <linux/platform_device.h>
#include <linux/slab.h>
#include <linux/string.h>

#include "sim.h"

static DEFINE_IDA(sim_numbers);

/* ---- a head ---- */

static void sim_init(struct xy3_sim *sim)
{
	mutex_init(&sim->lock);
	sim->realtime = sim->config.realtime;
	prandom_seed_state(&sim->random, sim->config.seed + sim->number);
	xy3_sim_head_wire(sim, sim->config.lines, sim->config.signal);
	sim->head.rate = XY3_SIM_RATE_DEFAULT;
	xy3_sim_telemetry_init(sim);
}

static int sim_probe(struct platform_device *pdev)
{
	const struct xy3_sim_config *config = dev_get_platdata(&pdev->dev);
	struct device *dev = &pdev->dev;
	struct xy3_sim *sim;
	int err;

	if (!config)
		return -ENODEV;
	sim = kzalloc(sizeof(*sim), GFP_KERNEL);
	if (!sim)
		return -ENOMEM;
	sim->pdev = pdev;
	sim->number = pdev->id;
	sim->config = *config;
	sim_init(sim);

	/* from now on it is freed by the port of the tty */
	err = xy3_sim_uart_add(sim);
	if (err)
		return dev_err_probe(dev, err, "no tty\n");
	err = devm_add_action_or_reset(dev, xy3_sim_uart_remove, sim);
	if (err)
		return err;
	err = xy3_sim_debugfs_add(sim);
	if (err)
		return err;
	/* last, as its driver may send something immediately */
	err = xy3_sim_spi_add(sim);
	if (!err)
		platform_set_drvdata(pdev, sim);
	return err;
}

/* ---- drivers: those of heads may have the names of other drivers ---- */

/**
 * struct sim_driver - a platform driver
 * @driver: the driver
 * @name: its name
 * @users: number of heads with this driver; if 0, it is not registered
 */
struct sim_driver {
	struct platform_driver driver;
	char name[XY3_SIM_NAME_MAX];
	unsigned int users;
};

/* Protects the table */
static DEFINE_MUTEX(sim_drivers_lock);
static struct sim_driver sim_drivers[XY3_SIM_HEADS_MAX];

static struct sim_driver *sim_find_driver(const char *name)
{
	for (unsigned int i = 0; i < ARRAY_SIZE(sim_drivers); i++)
		if (sim_drivers[i].users && !strcmp(sim_drivers[i].name, name))
			return &sim_drivers[i];
	return NULL;
}

/* There is one for each possible head: one is free */
static struct sim_driver *sim_free_driver(void)
{
	struct sim_driver *driver = sim_drivers;

	while (driver->users)
		driver++;
	return driver;
}

static int sim_get_driver(const char *name)
{
	struct sim_driver *driver;
	int err;

	guard(mutex)(&sim_drivers_lock);
	driver = sim_find_driver(name);
	if (!driver) {
		driver = sim_free_driver();
		*driver = (struct sim_driver) {
			.driver = {
				.driver = {
					.name = driver->name,
					.probe_type = PROBE_FORCE_SYNCHRONOUS,
				},
				.probe = sim_probe,
			},
		};
		strscpy(driver->name, name, sizeof(driver->name));
		err = platform_driver_register(&driver->driver);
		if (err)
			return err;
	}
	driver->users++;
	return 0;
}

static void sim_put_driver(const char *name)
{
	struct sim_driver *driver;

	guard(mutex)(&sim_drivers_lock);
	driver = sim_find_driver(name);
	if (driver && !--driver->users)
		platform_driver_unregister(&driver->driver);
}

/* ---- creating and removing heads ---- */

/**
 * xy3_sim_new_number() - allocate a number for a head
 *
 * Return: the lowest free one, or an error.
 */
int xy3_sim_new_number(void)
{
	return ida_alloc_max(&sim_numbers, XY3_SIM_HEADS_MAX - 1, GFP_KERNEL);
}

/**
 * xy3_sim_free_number() - free the number of a head
 * @number: the number
 */
void xy3_sim_free_number(unsigned int number)
{
	ida_free(&sim_numbers, number);
}

/**
 * xy3_sim_add() - create a head
 * @config: its settings
 * @number: its number
 *
 * Return: its device, or an error.
 */
struct platform_device *xy3_sim_add(const struct xy3_sim_config *config, unsigned int number)
{
	struct xy3_sim_config resolved = *config;
	struct platform_device *pdev;
	int err;

	err = xy3_sim_config_resolve(&resolved);
	if (err)
		return ERR_PTR(err);
	err = sim_get_driver(resolved.driver);
	if (err)
		return ERR_PTR(err);
	pdev = platform_device_register_data(NULL, resolved.driver, number, &resolved,
					     sizeof(resolved));
	if (!IS_ERR(pdev) && !platform_get_drvdata(pdev)) {
		/* the reason is in the log */
		platform_device_unregister(pdev);
		pdev = ERR_PTR(-ENXIO);
	}
	if (IS_ERR(pdev))
		sim_put_driver(resolved.driver);
	return pdev;
}

/**
 * xy3_sim_remove() - remove a head
 * @pdev: its device
 */
void xy3_sim_remove(struct platform_device *pdev)
{
	const struct xy3_sim_config *config = dev_get_platdata(&pdev->dev);
	char name[XY3_SIM_NAME_MAX];

	strscpy(name, config->driver, sizeof(name));
	platform_device_unregister(pdev);
	sim_put_driver(name);
}
