/* SPDX-License-Identifier: GPL-2.0-only */
#ifndef HOST_KUNIT_VISIBILITY_H
#define HOST_KUNIT_VISIBILITY_H

#define VISIBLE_IF_KUNIT
#define EXPORT_SYMBOL_IF_KUNIT(symbol)

#endif
