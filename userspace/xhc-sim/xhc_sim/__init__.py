# SPDX-License-Identifier: GPL-2.0-only
"""xhc-sim: virtual XHC HB03, HB04 and WHB04B pendants.

models    differences between the models
wire      constants common to all models
hands     keys, selector, wheel, sleep -> input reports
lcd       display chunks -> frame -> contents of the LCD
whb04b    reports, frames and LCD of the WHB04B
pendant   the device, independent of the bus: reports, frames, faults
uhid      the pendant as a HID device of /dev/uhid
usb       the pendant as a USB device on vhci_hcd
"""

VERSION = '0.1.0'
