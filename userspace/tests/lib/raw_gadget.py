# SPDX-License-Identifier: GPL-2.0-only
"""The pendant as a USB gadget: /dev/raw-gadget over dummy_hcd.

Used in addition to vhci_hcd, which refuses a system suspend while a device is plugged in.
dummy_hcd suspends, and resumes the device like hardware.
"""

import errno
import fcntl
import os
import signal
import struct
import threading
import time

from xhc_sim.usb import FULL_SPEED, SETUP, UsbDevice

NODE = '/dev/raw-gadget'

INIT = 0x41015500                   # ioctls of <linux/usb/raw_gadget.h>
RUN = 0x5501
EVENT_FETCH = 0x80085502
EP0_WRITE = 0x40085503
EP0_READ = 0xC0085504
EP_ENABLE = 0x40095505
EP_WRITE = 0x40085507
CONFIGURE = 0x5509
VBUS_DRAW = 0x4004550A
EP0_STALL = 0x550C

CONNECT, CONTROL, SUSPEND, RESUME, RESET, DISCONNECT = 1, 2, 3, 4, 5, 6
EVENT_NAMES = {CONNECT: 'connect', SUSPEND: 'suspend', RESUME: 'resume', RESET: 'reset',
               DISCONNECT: 'disconnect'}
WAKE = signal.SIGUSR1               # interrupts an ioctl of a thread


def transfer(endpoint, data):
    """struct usb_raw_ep_io"""
    return struct.pack('<HHI', endpoint, 0, len(data)) + bytes(data)


class GadgetPendant(UsbDevice):
    """One pendant on the first dummy_hcd.

    gadget_events   names of bus events: connect, reset, suspend, resume, disconnect
    """

    phys = 'usb-dummy_hcd.0-1/input0'

    def __init__(self, model='HB04', report_descriptor=None, controller='dummy_udc.0'):
        super().__init__(model, report_descriptor)
        self.controller = controller
        self.gadget_events = []
        self.configured = threading.Event()
        self._fd = None
        self._endpoint = None
        self._thread = None
        signal.signal(WAKE, lambda *_: None)

    # --- cable ----------------------------------------------------------------------------

    def plug(self):
        if self.plugged:
            return
        self.configured.clear()
        self._fd = os.open(NODE, os.O_RDWR | os.O_CLOEXEC)
        fcntl.ioctl(self._fd, INIT, struct.pack('128s128sB', b'dummy_udc',
                                                self.controller.encode(), FULL_SPEED))
        fcntl.ioctl(self._fd, RUN)
        self.power_on()
        self.plugged = True
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()
        self.start_stream()

    def unplug(self):
        """The gadget is removed when the file is closed, after the threads have ended."""
        if not self.plugged:
            return
        with self.changed:
            self.plugged = False
            self.changed.notify_all()
        for thread in filter(None, (self._thread, self._streamer)):
            while thread.is_alive():
                signal.pthread_kill(thread.ident, WAKE)
                thread.join(0.05)
        os.close(self._fd)

    detach = unplug

    # --- towards the host -----------------------------------------------------------------

    def report(self, data):
        """Returns once the host has fetched it."""
        if not self.configured.wait(5):
            raise OSError(errno.ENODEV, 'the host has not configured the pendant')
        fcntl.ioctl(self._fd, EP_WRITE, transfer(self._endpoint, data))

    # --- from the host --------------------------------------------------------------------

    def _serve(self):
        while self.plugged:
            event = bytearray(struct.pack('<II8x', 0, 8))
            try:
                fcntl.ioctl(self._fd, EVENT_FETCH, event)
                kind = int.from_bytes(event[:4], 'little')
                if kind == CONTROL:
                    self._request(bytes(event[8:16]))
                else:
                    with self.changed:
                        self.gadget_events.append(EVENT_NAMES.get(kind, str(kind)))
                        self.changed.notify_all()
            except InterruptedError:
                continue
            except OSError:
                time.sleep(0.001)           # reset or disconnected during the transfer

    def _request(self, setup):
        kind, request, _, _, length = SETUP.unpack(setup)
        if self.is_set_report(setup):
            self._set_report(setup, length)
            return
        answer = self.control(setup)
        if answer is None:
            fcntl.ioctl(self._fd, EP0_STALL)
        elif kind & 0x80:
            fcntl.ioctl(self._fd, EP0_WRITE, transfer(0, answer[:length]))
        else:
            if (kind, request) == (0x00, 0x09):     # SET_CONFIGURATION
                self._configure()
            fcntl.ioctl(self._fd, EP0_READ, bytearray(transfer(0, bytes(length))))

    def _configure(self):
        if self._endpoint is None or not self.configured.is_set():
            # a bytearray: only then fcntl returns the value of the ioctl
            self._endpoint = fcntl.ioctl(self._fd, EP_ENABLE,
                                         bytearray(self.endpoint_descriptor + bytes(2)))
            fcntl.ioctl(self._fd, VBUS_DRAW, struct.pack('<I', 50))
            fcntl.ioctl(self._fd, CONFIGURE)
        self.configured.set()

    def _set_report(self, setup, length):
        """The data stage precedes the decision; a stall is only possible before it."""
        if self._fault.kind == 'stall':
            _, _, value, index, _ = SETUP.unpack(setup)
            action, _ = self.set_report(value, index, b'')
            if action == 'stall':
                fcntl.ioctl(self._fd, EP0_STALL)
                return
        data = bytearray(transfer(0, bytes(length)))
        count = fcntl.ioctl(self._fd, EP0_READ, data)
        _, _, value, index, _ = SETUP.unpack(setup)
        self.set_report(value, index, data[8:8 + count])
