# SPDX-License-Identifier: GPL-2.0-only
"""The pendant as the HID gadget of the kernel (configfs, f_hid) over dummy_hcd.

For system suspend: on resume the host requests the status of the device while all of user space
is still frozen, so the gadget must be in the kernel.  f_hid only keeps the last SET_REPORT and
drops its wValue; therefore the requests are read from usbmon.
"""

import errno
import os
import re
import select
import struct
import subprocess
import threading

from xhc_sim import find
from xhc_sim.models import MANUFACTURER, VENDOR
from xhc_sim.pendant import NoDevice, VirtualPendant

CONFIGFS = '/sys/kernel/config/usb_gadget'
USBMON = '/dev/usbmon%d'
REPORT_LENGTH = 8

# An event as returned by read() of usbmon, then the data (Documentation/usb/usbmon.rst):
# id, type, transfer, endpoint, device, bus, flags of setup and data, seconds, microseconds, status,
# length, captured length, setup packet
EVENT = struct.Struct('=QcBBBHccqiiII8s')
SUBMITTED, CONTROL, PRESENT = b'S', 2, b'\0'
SET_REPORT = 0x21, 0x09
SETUP = struct.Struct('<BBHHH')
PAUSE = 0.05                # seconds until unplug() is detected


def load_controllers():
    """Loads dummy_hcd and the others if they are modules: a controller per model, and a spare."""
    subprocess.run(['modprobe', 'dummy_hcd', 'num=3'], check=True)
    subprocess.run(['modprobe', '-a', 'libcomposite', 'usbmon'], check=True)
    if not os.path.isdir(CONFIGFS):
        subprocess.run(['mount', '-t', 'configfs', 'configfs', '/sys/kernel/config'], check=True)


def _write(path, text):
    data = text if isinstance(text, bytes) else text.encode()
    fd = os.open(path, os.O_WRONLY)
    try:
        os.write(fd, data)
    finally:
        os.close(fd)


class HidGadgetPendant(VirtualPendant):
    """A pendant on its own dummy_hcd: HB03 on the second, HB04 on the third.

    It supports no faults such as stalls or delays.  The gadget is created once and stays connected;
    plug() and unplug() control whether the host uses it.  (f_hid leaks a request whenever it is
    unbound, which the leak scan would report.)
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
        if not built:
            _write(self.root + '/UDC', self.controller)
        # unplug() undoes what enumeration has set up
        if not find.wait(lambda: os.path.exists(self._authorized()), 30, PAUSE):
            raise NoDevice(errno.ENODEV, 'the host does not enumerate the gadget')
        self._authorize('1')
        self._gadget = os.open('/dev/hidg%d' % self._minor(), os.O_RDWR | os.O_NONBLOCK)

    def unplug(self):
        if not self.plugged:
            return
        self._authorize('0')
        self.plugged = False
        os.close(self._gadget)
        self._reader.join()

    detach = unplug

    def _authorized(self):
        return '/sys/bus/usb/devices/%d-1/authorized' % self._bus()

    def _authorize(self, text):
        _write(self._authorized(), text)

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
        """Number of the /dev/hidg node of the function."""
        with open(self.root + '/functions/hid.usb0/dev', encoding='ascii') as dev:
            return int(dev.read().split(':')[1])

    def _bus(self):
        """Number of the bus of the controller."""
        root = '/sys/devices/platform/dummy_hcd.%d' % self.number
        return next(int(name[3:]) for name in os.listdir(root) if re.fullmatch(r'usb\d+', name))

    # --- towards the host -----------------------------------------------------------------

    def report(self, data):
        """Waits until the host has fetched the previous report."""
        def once():
            try:
                return os.write(self._gadget, bytes(data))
            except BlockingIOError:
                return 0
        if not find.wait(once, 5, 0.002):
            raise OSError(errno.ETIMEDOUT, 'the host does not fetch reports')

    # --- from the host --------------------------------------------------------------------

    def _listen(self, mon):
        while self.plugged:
            if select.select([mon], [], [], PAUSE)[0]:
                self._request(os.read(mon, 4096))
        os.close(mon)

    def _request(self, event):
        _, kind, transfer, _, _, _, no_setup, no_data, *_, length, setup = EVENT.unpack_from(event)
        if (kind, transfer, no_setup) != (SUBMITTED, CONTROL, PRESENT):
            return
        request_type, request, value, index, _ = SETUP.unpack(setup)
        if (request_type, request) == SET_REPORT:
            data = event[EVENT.size:EVENT.size + length] if no_data == PRESENT else b''
            self.set_report(value, index, data)
