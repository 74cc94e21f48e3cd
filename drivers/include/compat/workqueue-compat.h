/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * The system workqueues by the names that they have since 6.17. The old names go on to work, but
 * 7.2 prints a line when a queue is used by one of them. One reason a line.
 */
#ifndef WORKQUEUE_COMPAT_H
#define WORKQUEUE_COMPAT_H

#include <linux/version.h>
#include <linux/workqueue.h>

#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 17, 0)
/* what was only system_wq has its CPU in the name */
#define system_percpu_wq	system_wq
/* what was system_unbound_wq is the default */
#define system_dfl_wq		system_unbound_wq
#endif

#endif /* WORKQUEUE_COMPAT_H */
