# SPDX-License-Identifier: GPL-2.0-only
"""The pendant as a HID device of /dev/uhid: no USB, works on every kernel with CONFIG_UHID.

    pendant = UhidPendant('HB04')
    pendant.plug()
    pendant.press(0x02)
    pendant.wait_frames(1)
    pendant.unplug()
"""

import errno
import os
import select
import struct
import threading

from .pendant import NoDevice, VirtualPendant
from .wire import MANUFACTURER, VENDOR

UHID = '/dev/uhid'
EVENT_SIZE = 4380                       # sizeof(struct uhid_event)
REPORT_MAX = 4096

DESTROY, START, STOP, OPEN, CLOSE, OUTPUT = 1, 2, 3, 4, 5, 6
GET_REPORT, GET_REPORT_REPLY, CREATE2, INPUT2, SET_REPORT, SET_REPORT_REPLY = 9, 10, 11, 12, 13, 14
EVENT_NAMES = {START: 'start', STOP: 'stop', OPEN: 'open', CLOSE: 'close', OUTPUT: 'output',
               GET_REPORT: 'get_report', SET_REPORT: 'set_report'}
BUS_USB = 3

# type, name, phys, uniq, descriptor's size, bus, vendor, product, version, country, descriptor
CREATE2_EVENT = struct.Struct('<I128s64s64sHHIIII%ds' % REPORT_MAX)
# uhid's report types -> the high byte of a SET_REPORT's wValue
WVALUE_TYPE = {0: 0x0300, 1: 0x0200, 2: 0x0100}


class UhidPendant(VirtualPendant):
    """The pendant as a uhid device.

    events    names of the events of uhid: start, stop, open, close, set_report, ...
    opened    the driver receives reports (between open and close)
    """

    _serial = 0

    def __init__(self, model='HB04', report_descriptor=None, product=None, phys=None):
        super().__init__(model, report_descriptor)
        self.product = self.model.product if product is None else product
        UhidPendant._serial += 1
        self.phys = phys or 'xhc-sim-%d.%d/input0' % (os.getpid(), UhidPendant._serial)
        self.events = []
        self.opened = False
        self._lock = threading.Lock()       # fd, against its closing
        self._fd = None
        self._stop = None                   # closing this wakes the reader
        self._reader = None

    # --- cable ----------------------------------------------------------------------------

    def create_event(self):
        """The UHID_CREATE2 message that creates this device."""
        return CREATE2_EVENT.pack(
            CREATE2, MANUFACTURER.encode(), self.phys.encode(), b'', len(self.report_descriptor),
            BUS_USB, VENDOR, self.product, 0x0100, 0, self.report_descriptor)

    def plug(self):
        if self.plugged:
            return
        try:
            fd = os.open(UHID, os.O_RDWR | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError as error:
            raise NoDevice(error.errno, os.strerror(error.errno), UHID) from None
        self.power_on()
        try:
            os.write(fd, self.create_event())
        except OSError:
            os.close(fd)
            raise
        wake, self._stop = os.pipe()
        with self._lock:
            self.opened = False
            self._fd = fd
            self.plugged = True
        self._reader = threading.Thread(target=self._serve, args=(fd, wake), daemon=True)
        try:
            self._reader.start()
        except RuntimeError as error:           # no memory for a thread
            self.plugged = False
            for each in (fd, wake, self._stop):
                os.close(each)
            raise OSError(errno.ENOMEM, str(error)) from None
        self.start_stream()

    def unplug(self):
        """Removes the device, at any time."""
        with self._lock:
            if not self.plugged:
                return
            self.plugged = False
            os.close(self._stop)
            try:
                os.write(self._fd, struct.pack('<I', DESTROY))
            except OSError:
                pass                    # was not created completely
        if threading.current_thread() is not self._reader:
            self._reader.join()

    def crash(self):
        """As if the program that created the device had died: only closes the file."""
        with self._lock:
            if not self.plugged:
                return
            self.plugged = False
            os.close(self._stop)
        if threading.current_thread() is not self._reader:
            self._reader.join()

    detach = unplug

    # --- to the host ----------------------------------------------------------------------

    def report(self, data):
        """Sends one input report, of any length."""
        self._write(struct.pack('<IH', INPUT2, len(data)) + bytes(data))

    def _write(self, message):
        with self._lock:
            if not self.plugged:
                raise OSError(errno.ENODEV, 'the pendant is unplugged')
            os.write(self._fd, message)

    # --- from the host --------------------------------------------------------------------

    def _serve(self, fd, wake):
        poll = select.poll()
        poll.register(fd, select.POLLIN)
        poll.register(wake, 0)              # closing the other end is POLLHUP
        while self.plugged:
            ready = [which for which, _ in poll.poll()]
            if wake in ready:
                break
            try:
                event = os.read(fd, EVENT_SIZE)
            except BlockingIOError:
                continue
            except OSError:
                break
            self._event(event)
        with self._lock:
            if self._fd == fd:          # else it has been plugged in again
                self.plugged = False
                self.opened = False
        os.close(wake)
        os.close(fd)
        with self.changed:
            self.changed.notify_all()

    def _event(self, event):
        kind = int.from_bytes(event[:4], 'little')
        with self.changed:
            self.events.append(EVENT_NAMES.get(kind, str(kind)))
            if kind in (OPEN, CLOSE):
                self.opened = kind == OPEN
            self.changed.notify_all()
        if kind == SET_REPORT:
            self._set_report(event)
        elif kind == GET_REPORT:
            token, = struct.unpack_from('<I', event, 4)
            self._reply(struct.pack('<IIHH', GET_REPORT_REPLY, token, errno.EIO, 0))

    def _set_report(self, event):
        token, number, kind, size = struct.unpack_from('<IBBH', event, 4)
        data = event[12:12 + size]
        wvalue = WVALUE_TYPE.get(kind, 0) | number
        action, seconds = self.set_report(wvalue, 0, data)
        if action == 'unplug':
            self.unplug()
        elif action == 'slow':
            timer = threading.Timer(seconds, self._reply_status, (token, 0))
            timer.daemon = True
            timer.start()
        elif action != 'timeout':
            self._reply_status(token, errno.EIO if action == 'stall' else 0)

    def _reply_status(self, token, status):
        self._reply(struct.pack('<IIH', SET_REPORT_REPLY, token, status))

    def _reply(self, message):
        try:
            self._write(message)
        except OSError:
            pass                            # unplugged meanwhile
