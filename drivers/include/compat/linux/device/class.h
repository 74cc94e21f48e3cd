/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef COMPAT_CLASS_H
#define COMPAT_CLASS_H

#include_next <linux/device/class.h>
#include "../../callback.h"

#ifndef KERNEL_HAS_CLASS_ATTR_CONST
/* class_attribute.show, .store: class and attribute were not const */
#define attach_show(...)							\
	COMPAT_CALLBACK(ssize_t, attach_show, ssize_t,				\
			(struct class *class, struct class_attribute *attr, char *buf), \
			(class, attr, buf), (__VA_ARGS__))
#define attach_store(...)							\
	COMPAT_CALLBACK(ssize_t, attach_store, ssize_t,				\
			(struct class *class, struct class_attribute *attr,	\
			 const char *buf, size_t count),			\
			(class, attr, buf, count), (__VA_ARGS__))
#endif

#endif /* COMPAT_CLASS_H */
