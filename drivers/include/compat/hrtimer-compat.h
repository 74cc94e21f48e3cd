/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * hrtimers as they are set up today, for kernels where they were not. One reason a line.
 */
#ifndef HRTIMER_COMPAT_H
#define HRTIMER_COMPAT_H

#include <linux/hrtimer.h>
#include <linux/version.h>

#if LINUX_VERSION_CODE < KERNEL_VERSION(6, 13, 0)
/* the function is given along with the clock since 6.13 */
static inline void hrtimer_setup(struct hrtimer *timer,
				 enum hrtimer_restart (*function)(struct hrtimer *),
				 clockid_t clock, enum hrtimer_mode mode)
{
	hrtimer_init(timer, clock, mode);
	timer->function = function;
}
#endif

#endif /* HRTIMER_COMPAT_H */
