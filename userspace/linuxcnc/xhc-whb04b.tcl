# SPDX-License-Identifier: GPL-2.0-only
#
# An XHC WHB04B for any machine: in its ini, after all other HALFILEs,
#
#	[HAL]
#	HALFILE = /usr/share/xhc-xy3/linuxcnc/xhc-whb04b.tcl
#
# or, if there are POSTGUI_HALFILEs that link the same pins, after all of these as POSTGUI_HALFILE

source [file join [file dirname [file normalize [info script]]] xhc.tcl]
xhc::add whb04b 0.05
