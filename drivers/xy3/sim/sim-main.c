// SPDX-License-Identifier: GPL-2.0-only
/*
 * Virtual XY3-100 compatible scanhead: the module, and its first heads
 */

#include <linux/err.h>
#include <linux/init.h>
#include <linux/module.h>
#include <linux/platform_device.h>

#include "sim.h"

static unsigned int heads = 1;
module_param(heads, uint, 0444);
MODULE_PARM_DESC(heads, "Number of heads to begin with, 0 to 4 (default: 1)");

static struct platform_device *sim_devices[XY3_SIM_HEADS_MAX];

static void sim_remove_heads(void)
{
	for (unsigned int i = 0; i < XY3_SIM_HEADS_MAX && sim_devices[i]; i++) {
		xy3_sim_remove(sim_devices[i]);
		xy3_sim_free_number(i);
	}
}

static struct platform_device * __init sim_add_head(void)
{
	struct platform_device *pdev;
	int number;

	number = xy3_sim_new_number();
	if (number < 0)
		return ERR_PTR(number);
	pdev = xy3_sim_add(&xy3_sim_defaults, number);
	if (IS_ERR(pdev))
		xy3_sim_free_number(number);
	return pdev;
}

/* Fail loading the module without the requested heads */
static int __init sim_add_heads(void)
{
	struct platform_device *pdev;

	for (unsigned int i = 0; i < heads; i++) {
		pdev = sim_add_head();
		if (IS_ERR(pdev)) {
			sim_remove_heads();
			return PTR_ERR(pdev);
		}
		sim_devices[i] = pdev;
	}
	return 0;
}

static int __init sim_module_init(void)
{
	int err;

	if (heads > XY3_SIM_HEADS_MAX)
		return -EINVAL;
	err = xy3_sim_tty_init();
	if (err)
		return err;
	xy3_sim_debugfs_init();
	err = sim_add_heads();
	if (err)
		goto no_heads;
	err = xy3_sim_configfs_init();
	if (!err)
		return 0;
	sim_remove_heads();
no_heads:
	xy3_sim_debugfs_exit();
	xy3_sim_tty_exit();
	return err;
}

static void __exit sim_module_exit(void)
{
	xy3_sim_configfs_exit();
	sim_remove_heads();
	xy3_sim_debugfs_exit();
	xy3_sim_tty_exit();
}

module_init(sim_module_init);
module_exit(sim_module_exit);

MODULE_DESCRIPTION("XY3-100 compatible laser scanheads: a virtual one");
MODULE_AUTHOR("xhc-xy3 developers");
MODULE_LICENSE("GPL");
MODULE_VERSION("0.1.0");
