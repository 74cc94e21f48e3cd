// SPDX-License-Identifier: GPL-2.0-only
/*
 * XY3-100 compatible laser scanheads: the module
 *
 * A head reports its identity, temperatures and errors on a UART, which is attached by a line
 * discipline or as a serdev; /dev/xy3-<n>, sysfs, hwmon and uevents show what it reports.
 */

#include <linux/init.h>
#include <linux/module.h>

#include "xy3.h"

#define CREATE_TRACE_POINTS
#include "trace.h"

static int __init xy3_init(void)
{
	int err;

	xy3_sysfs_init();
	err = xy3_head_init();
	if (err)
		return err;
	err = xy3_tty_init();
	if (err)
		goto no_tty;
	err = xy3_ldisc_init();
	if (err)
		goto no_ldisc;
	err = xy3_serdev_init();
	if (err)
		goto no_serdev;
	return 0;

no_serdev:
	xy3_ldisc_exit();
no_ldisc:
	xy3_tty_exit();
no_tty:
	xy3_head_exit();
	return err;
}
module_init(xy3_init);

static void __exit xy3_exit(void)
{
	xy3_serdev_exit();
	xy3_ldisc_exit();
	xy3_tty_exit();
	xy3_head_exit();
}
module_exit(xy3_exit);

MODULE_DESCRIPTION("XY3-100 compatible laser scanheads: backchannel");
MODULE_AUTHOR("xhc-xy3 developers");
MODULE_LICENSE("GPL");
MODULE_VERSION("0.1.0");
