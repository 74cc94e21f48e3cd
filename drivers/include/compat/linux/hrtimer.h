/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_HRTIMER_H
#define COMPAT_HRTIMER_H

#include_next <linux/hrtimer.h>

#ifndef KERNEL_HAS_HRTIMER_SETUP
/* the function was set separately */
static inline void hrtimer_setup(struct hrtimer *timer,
				 enum hrtimer_restart (*function)(struct hrtimer *),
				 clockid_t clock, enum hrtimer_mode mode)
{
	hrtimer_init(timer, clock, mode);
	timer->function = function;
}
#endif

#endif /* COMPAT_HRTIMER_H */
