# SPDX-License-Identifier: GPL-2.0-only
"""The pendant as the kernel's own HID gadget (configfs, f_hid) over dummy_hcd.

For system suspend: on the way back the host asks the device for its status while all of user
space is still frozen, so the gadget must live in the kernel.  f_hid keeps the last SET_REPORT
only and drops its wValue; the requests are therefore seen by usbmon.
"""

import errno
import os
import re
import threading
import time

from xhc_sim import find
from xhc_sim.models import MANUFACTURER, VENDOR
from xhc_sim.pendant import VirtualPendant

CONFIGFS = '/sys/kernel/config/usb_gadget'
USBMON = '/sys/kernel/debug/usb/usbmon/%du'
REPORT_LENGTH = 8


def _write(path, text):
    data = text if isinstance(text, bytes) else text.encode()
    fd = os.open(path, os.O_WRONLY)
    try:
        os.write(fd, data)
    finally:
        os.close(fd)


class HidGadgetPendant(VirtualPendant):
    """A pendant on a dummy_hcd of its own: HB03 on the second, HB04 on the third.

    It cannot stall or be slow: faults are for the other transports.  The gadget is made once and
    stays connected; plug() and unplug() let the host use it or not.  (f_hid loses a request
    whenever it is unbound, and the leak scan would find it.)
    """

    CONTROLLERS = {'HB03': 1, 'HB04': 2}

    def __init__(self, model='HB04'):
        super().__init__(model)
        self.number = self.CONTROLLERS[self.model.name]
        self.controller = 'dummy_udc.%d' % self.number
        self.phys = 'usb-dummy_hcd.%d-1/input0' % self.number
        self.root = '%s/%s' % (CONFIGFS, self.model.name)
        self._gadget = None
        self._reader = None

    # --- cable ----------------------------------------------------------------------------

    def plug(self):
        if self.plugged:
            return
        built = os.path.isdir(self.root)
        if not built:
            self._build()
        mon = os.open(USBMON % self._bus(), os.O_RDONLY | os.O_NONBLOCK)
        self.plugged = True
        self._reader = threading.Thread(target=self._listen, args=(mon,), daemon=True)
        self._reader.start()
        if built:
            self._authorize('1')
        else:
            _write(self.root + '/UDC', self.controller)
        self._gadget = os.open('/dev/hidg%d' % self._minor(), os.O_RDWR | os.O_NONBLOCK)

    def unplug(self):
        if not self.plugged:
            return
        self._authorize('0')
        self.plugged = False
        os.close(self._gadget)
        self._reader.join()

    detach = unplug

    def _authorize(self, text):
        _write('/sys/bus/usb/devices/%d-1/authorized' % self._bus(), text)

    def _build(self):
        root = self.root
        for folder in ('', '/strings/0x409', '/configs/c.1', '/functions/hid.usb0'):
            os.mkdir(root + folder)
        _write(root + '/idVendor', '%#06x' % VENDOR)
        _write(root + '/idProduct', '%#06x' % self.model.product)
        _write(root + '/max_speed', 'full-speed')
        _write(root + '/strings/0x409/manufacturer', MANUFACTURER)
        function = root + '/functions/hid.usb0'
        _write(function + '/no_out_endpoint', '1')
        _write(function + '/report_length', str(REPORT_LENGTH))
        _write(function + '/report_desc', self.report_descriptor)
        os.symlink(function, root + '/configs/c.1/hid.usb0')

    def _minor(self):
        """Number of the function's /dev/hidg node."""
        with open(self.root + '/functions/hid.usb0/dev', encoding='ascii') as dev:
            return int(dev.read().split(':')[1])

    def _bus(self):
        """Number of the controller's bus."""
        root = '/sys/devices/platform/dummy_hcd.%d' % self.number
        return next(int(name[3:]) for name in os.listdir(root) if re.fullmatch(r'usb\d+', name))

    # --- towards the host -----------------------------------------------------------------

    def report(self, data):
        """Waits until the host has fetched the one before."""
        def once():
            try:
                return os.write(self._gadget, bytes(data))
            except BlockingIOError:
                return 0
        if not find.wait(once, 5, 0.002):
            raise OSError(errno.ETIMEDOUT, 'the host does not fetch reports')

    # --- from the host --------------------------------------------------------------------

    def _listen(self, mon):
        """usbmon's text files cannot be polled for."""
        text = ''
        while self.plugged:
            try:
                text += os.read(mon, 4096).decode()
            except BlockingIOError:
                time.sleep(0.002)
                continue
            *lines, text = text.split('\n')
            for line in lines:
                self._request(line.split())
        os.close(mon)

    def _request(self, words):
        """TAG TIME S Co:BUS:DEVICE:0 s 21 09 0306 0000 0008 8 = 06fefd16 00000000"""
        if words[2:3] != ['S'] or words[4:7] != ['s', '21', '09']:
            return
        data = bytes.fromhex(''.join(words[words.index('=') + 1:])) if '=' in words else b''
        self.set_report(int(words[7], 16), int(words[8], 16), data)
