/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef HOST_LINUX_BUILD_BUG_H
#define HOST_LINUX_BUILD_BUG_H

#undef static_assert
#define static_assert(expr, ...)	static_assert_msg(expr, ##__VA_ARGS__, #expr)
#define static_assert_msg(expr, msg, ...)	_Static_assert(expr, msg)

#define BUILD_BUG_ON(condition)		_Static_assert(!(condition), #condition)
#define BUILD_BUG_ON_MSG(condition, msg)	_Static_assert(!(condition), msg)

#endif
