# SPDX-License-Identifier: GPL-2.0-only
#
# An XHC HB03 or HB04 for any machine: in its ini, after all other HALFILEs,
#
#	[HAL]
#	HALFILE = /usr/share/xhc-xy3/linuxcnc/xhc-hb04.tcl
#
# or, if there are POSTGUI_HALFILEs that link the same pins, after all of these as POSTGUI_HALFILE

source [file join [file dirname [file normalize [info script]]] xhc.tcl]
xhc::add hb04 0.01
