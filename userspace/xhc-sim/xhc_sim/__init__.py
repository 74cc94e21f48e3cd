# SPDX-License-Identifier: GPL-2.0-only
"""xhc-sim: virtual XHC HB03, HB04 and WHB04B pendants.

models    what differs between the models
wire      what they have in common
hands     keys, selector, wheel, sleep -> input reports
lcd       display chunks -> frame -> what the LCD shows
whb04b    what the WHB04B has in another shape
pendant   the device on no bus: reports, frames, faults
uhid      the pendant as a HID device of /dev/uhid
usb       the pendant as a USB device on vhci_hcd
"""

VERSION = '0.1.0'
