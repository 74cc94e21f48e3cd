/* SPDX-License-Identifier: GPL-2.0-only */
/*
 * A callback whose prototype has changed is written with the newer one. For a kernel with the older
 * one a macro with the callback's name and parameters stands before its definition,
 *
 *	static ssize_t xy3_write(struct tty_struct *tty, const u8 *data, size_t size)
 *
 * and puts two functions in its place: xy3_write(), which has the kernel's prototype, and the one
 * that is defined, as xy3_write_now(), which the other one calls. The table of operations has the
 * name without parameters, so the macro leaves it alone, and it gets the kernel's prototype.
 *
 * @type: what the definition begins with: its storage class and the type that it returns
 * @old_type: what the older prototype returns
 * @old: the parameters of the older prototype, in parentheses
 * @arguments: their names, in parentheses
 * @parameters: those of the definition, in parentheses
 */
#ifndef COMPAT_CALLBACK_H
#define COMPAT_CALLBACK_H

#define COMPAT_CALLBACK(type, name, old_type, old, arguments, parameters)	\
	name ## _now parameters;						\
	static old_type name old						\
	{									\
		return name ## _now arguments;					\
	}									\
	static type name ## _now parameters

#endif /* COMPAT_CALLBACK_H */
