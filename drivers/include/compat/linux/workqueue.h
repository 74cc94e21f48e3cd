/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_WORKQUEUE_H
#define COMPAT_WORKQUEUE_H

#include_next <linux/workqueue.h>

/*
 * The system workqueues had other names. These still work, but 7.2 prints a message if a queue is
 * used by one of them.
 */
#ifndef KERNEL_HAS_SYSTEM_PERCPU_WQ
#define system_percpu_wq	system_wq
#endif
#ifndef KERNEL_HAS_SYSTEM_DFL_WQ
#define system_dfl_wq		system_unbound_wq
#endif

#endif /* COMPAT_WORKQUEUE_H */
