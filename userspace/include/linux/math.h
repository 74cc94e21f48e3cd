/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef HOST_LINUX_MATH_H
#define HOST_LINUX_MATH_H

#include <stdlib.h>	/* before its abs() is taken over */
#include <linux/types.h>

#undef abs
#define abs(x)		({ __auto_type x_ = (x); x_ < 0 ? -x_ : x_; })

#define DIV_ROUND_UP(n, d)	(((n) + (d) - 1) / (d))
#define roundup(x, y)		(DIV_ROUND_UP(x, y) * (y))
#define DIV_ROUND_CLOSEST(x, divisor) ({						\
	typeof(x) x_ = (x);								\
	typeof(divisor) d_ = (divisor);							\
											\
	((x_ > 0) == (d_ > 0)) ? (x_ + d_ / 2) / d_ : (x_ - d_ / 2) / d_;		\
})

#endif
