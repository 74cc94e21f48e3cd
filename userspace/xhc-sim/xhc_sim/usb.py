# SPDX-License-Identifier: GPL-2.0-only
"""The pendant on USB, without hardware: vhci_hcd fed over a socket pair.

The kernel's usbip virtual host controller uses a connected stream socket for the USB/IP protocol.
An AF_UNIX pair is sufficient: no network, no usbip tools, no gadget driver.  The host side is the
real one, from enumeration through usbhid.  Requires root and the module vhci-hcd.

    pendant = UsbPendant('HB04')
    pendant.plug()                        # enumeration runs in the background
    pendant.report(bytes([4, 1, 0, 0x11, 0, 1]))
    pendant.wait_frames(1)
    pendant.set_reports[0].wvalue         # 0x0306
    pendant.fault = 'stall'
    pendant.unplug()                      # unplugs without notice; detach() is orderly
"""

import errno
import os
import socket
import struct
import threading
import time

from .pendant import NoDevice, VirtualPendant
from .wire import INPUT_ID, MANUFACTURER, VENDOR

VHCI = '/sys/devices/platform/vhci_hcd.0'
FULL_SPEED = 2
PORT_FREE = 4                               # VDEV_ST_NULL in the status file

CMD_SUBMIT, CMD_UNLINK, RET_SUBMIT, RET_UNLINK = 1, 2, 3, 4
HEADER = struct.Struct('>IIIII28s')         # command, seqnum, devid, direction, ep, the rest
SUBMIT = struct.Struct('>IiiiI8s')          # flags, length, start, packets, interval, setup
ANSWER = struct.Struct('>IIIIIiiiii8x')     # ... status, actual length, start, packets, errors
UNLINKED = struct.Struct('>IIIIIi24x')      # ... status

SETUP = struct.Struct('<BBHHH')             # bmRequestType, bRequest, wValue, wIndex, wLength

ENDPOINT_IN = 0x81


def usb_string(text):
    data = text.encode('utf-16-le')
    return bytes([len(data) + 2, 3]) + data


class UsbDevice(VirtualPendant):
    """Descriptors and control requests of the pendant, independent of the transport.

    `descriptors` may be changed before plug(), to test the host: 'device', 'config', 'hid',
    'report', and 'strings' (a dict by index).  None: stalled.
    """

    def __init__(self, model='HB04', report_descriptor=None):
        super().__init__(model, report_descriptor)
        self.requests = []                  # the eight setup bytes of all control requests
        self.interface = 0                  # number of the HID interface in `descriptors`
        report = self.report_descriptor
        hid = struct.pack('<BBHBBBH', 9, 0x21, 0x0110, 0, 1, 0x22, len(report))
        interface = bytes([9, 4, 0, 0, 1, 3, 0, 0, 0])
        endpoint = struct.pack('<BBBBHB', 7, 5, ENDPOINT_IN, 3,
                               self.model.packet_size, self.model.interval)
        body = interface + hid + endpoint
        self.endpoint_descriptor = endpoint
        self.descriptors = {
            'device': struct.pack('<BBHBBBBHHHBBBB', 18, 1, 0x0110, 0, 0, 0, 64, VENDOR,
                                  self.model.product, 0x0100, 1, 0, 0, 1),
            'config': struct.pack('<BBHBBBBB', 9, 2, 9 + len(body), 1, 1, 0, 0x80, 50) + body,
            'hid': hid,
            'report': report,
            'strings': {0: bytes([4, 3, 0x09, 0x04]), 1: usb_string(MANUFACTURER)},
        }

    def control(self, setup, data=b''):
        """-> bytes (data of an IN request, or b''), or None for a stall.

        SET_REPORT is not answered here: see is_set_report().
        """
        kind, request, value, _, _ = SETUP.unpack(setup)
        self.requests.append(bytes(setup))
        if kind == 0x80 and request == 6:
            return self._descriptor(value >> 8, value & 0xFF)
        if kind == 0x81 and request == 6:
            return self.descriptors.get({0x21: 'hid', 0x22: 'report'}.get(value >> 8))
        if kind & 0x60 == 0 and not kind & 0x80:
            # clear and set feature, configuration, interface
            if request == 9:
                self.forget()           # the host configures a device again after a reset
            return b'' if request in (1, 3, 9, 11) else None
        if kind & 0xE0 == 0x80:
            # get status, configuration, interface
            return {0: b'\0\0', 8: b'\1', 10: b'\0'}.get(request)
        if kind == 0x21 and request in (0x0A, 0x0B):
            return b''                      # SET_IDLE, SET_PROTOCOL
        if kind == 0xA1 and request == 1 and value == 0x0100 | INPUT_ID:
            return self.pendant.report()[:self.model.input_size]
        return None

    @staticmethod
    def is_set_report(setup):
        return setup[0] == 0x21 and setup[1] == 0x09

    def _descriptor(self, kind, index):
        if kind == 1:
            return self.descriptors['device']
        if kind == 2:
            return self.descriptors['config']
        if kind == 3:
            return self.descriptors['strings'].get(index)
        return None


class UsbPendant(UsbDevice):
    """The pendant at a port of vhci_hcd."""

    def __init__(self, model='HB04', report_descriptor=None):
        super().__init__(model, report_descriptor)
        self.port = None
        self.polled = threading.Event()     # the host waits for an input report
        self._socket = None
        self._lock = threading.Lock()       # the socket's write side, _waiting and _queue
        self._waiting = {}                  # seqnum -> (endpoint, length) of URBs not answered
        self._queue = []                    # input reports without a URB yet

    @property
    def phys(self):
        """The HID_PHYS of the HID device."""
        return 'usb-vhci_hcd.0-%d/input%d' % (self.port + 1, self.interface)

    # --- cable ----------------------------------------------------------------------------

    def plug(self, timeout=5.0):
        """Connects; NoDevice without vhci_hcd.  Waits while all ports are in use."""
        if self.plugged:
            return
        if not os.path.exists(VHCI + '/attach'):
            raise NoDevice(errno.ENODEV, 'no vhci_hcd: modprobe vhci-hcd')
        self.power_on()
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        with theirs:
            self.port = self._attach(theirs, time.monotonic() + timeout)
        with self._lock:
            self._socket = ours
            self._waiting.clear()
            self._queue.clear()
        self.polled.clear()
        self.plugged = True
        threading.Thread(target=self._serve, args=(ours,), daemon=True).start()
        self.start_stream()

    @staticmethod
    def _attach(end, deadline):
        while True:
            for port in _free_ports():
                order = '%d %d %d %d' % (port, end.fileno(), (1 << 16) | (port + 1), FULL_SPEED)
                try:
                    with open(VHCI + '/attach', 'w', encoding='ascii') as attach:
                        attach.write(order)
                    return port
                except OSError as error:        # used by another process meanwhile
                    if error.errno not in (errno.EBUSY, errno.EAGAIN):
                        raise
            if time.monotonic() >= deadline:
                raise NoDevice(errno.EBUSY, 'no free port in vhci_hcd')
            time.sleep(0.02)

    def unplug(self):
        """Unplugs without notice: the kernel finds that the socket is closed."""
        with self._lock:
            self._hang_up()

    def _hang_up(self):
        self.plugged = False
        if self._socket is not None:
            try:
                self._socket.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass                            # closed by the kernel meanwhile
            self._socket = None

    def detach(self):
        """Unplugs in order: the host controller is requested to drop the port."""
        if self.plugged:
            with open(VHCI + '/detach', 'w', encoding='ascii') as detach:
                detach.write(str(self.port))
        self.unplug()

    # --- interrupt endpoint ---------------------------------------------------------------

    def report(self, data):
        """Sends one input report, as soon as the host polls for it."""
        with self._lock:
            for seqnum, (endpoint, length) in self._waiting.items():
                if endpoint == ENDPOINT_IN & 0x0F:
                    del self._waiting[seqnum]
                    self._answer(seqnum, 0, bytes(data)[:length])
                    return
            self._queue.append(bytes(data))

    def pending(self):
        """Number of input reports that the host has not fetched yet."""
        with self._lock:
            return len(self._queue)

    # --- USB/IP ---------------------------------------------------------------------------

    def _serve(self, sock):
        try:
            while True:
                command, seqnum, _, direction, endpoint, rest = HEADER.unpack(_read(sock, 48))
                if command == CMD_SUBMIT:
                    _, length, _, _, _, setup = SUBMIT.unpack(rest)
                    data = _read(sock, length) if direction == 0 and length > 0 else b''
                    if endpoint == 0:
                        self._control(seqnum, setup, data)
                    else:
                        self._poll(seqnum, endpoint, length)
                elif command == CMD_UNLINK:
                    self._unlink(seqnum, int.from_bytes(rest[:4], 'big'))
        except (EOFError, OSError):
            pass
        with self._lock:
            if self._socket is sock:            # not yet replaced by a new plug()
                self._hang_up()
        sock.close()
        with self.changed:
            self.changed.notify_all()

    def _poll(self, seqnum, endpoint, length):
        with self._lock:
            if endpoint == ENDPOINT_IN & 0x0F and self._queue:
                self._answer(seqnum, 0, self._queue.pop(0)[:length])
            else:
                self._waiting[seqnum] = (endpoint, length)
        self.polled.set()

    def _unlink(self, seqnum, victim):
        with self._lock:
            known = self._waiting.pop(victim, None)
            status = 0 if known is None else -errno.ECONNRESET
            self._send(UNLINKED.pack(RET_UNLINK, seqnum, 0, 0, 0, status))

    def _control(self, seqnum, setup, data):
        if self.is_set_report(setup):
            self.requests.append(bytes(setup))
            self._set_report(seqnum, setup, data)
            return
        answer = self.control(setup, data)
        length = int.from_bytes(setup[6:8], 'little')
        with self._lock:
            if answer is None:
                self._answer(seqnum, -errno.EPIPE)
            elif setup[0] & 0x80:
                self._answer(seqnum, 0, answer[:length])
            else:
                self._answer(seqnum, 0, actual=len(data))

    def _set_report(self, seqnum, setup, data):
        _, _, value, index, _ = SETUP.unpack(setup)
        kind, seconds = self.set_report(value, index, data)
        with self._lock:
            if kind == 'unplug':
                self._hang_up()
            elif kind == 'stall':
                self._answer(seqnum, -errno.EPIPE)
            elif kind in ('timeout', 'slow'):
                self._waiting[seqnum] = (0, len(data))
            else:
                self._answer(seqnum, 0, actual=len(data))
        if kind == 'slow':
            timer = threading.Timer(seconds, self._late, (seqnum, len(data)))
            timer.daemon = True
            timer.start()

    def _late(self, seqnum, length):
        with self._lock:
            if self._waiting.pop(seqnum, None):     # else the host gave up on it
                self._answer(seqnum, 0, actual=length)

    def _answer(self, seqnum, status, data=b'', actual=None):
        length = len(data) if actual is None else actual
        self._send(ANSWER.pack(RET_SUBMIT, seqnum, 0, 0, 0, status, length, 0, 0, 0) + data)

    def _send(self, data):
        if self._socket is not None:
            try:
                self._socket.sendall(data)
            except OSError:
                pass                            # unplugged; _serve() detects it, too


def _read(sock, size):
    data = b''
    while len(data) < size:
        more = sock.recv(size - len(data))
        if not more:
            raise EOFError
        data += more
    return data


def _free_ports():
    """Unused ports of the high-speed hub, which also serves full speed."""
    with open(VHCI + '/status', encoding='ascii') as status:
        for line in status.readlines()[1:]:
            field = line.split()
            if field[0] == 'hs' and int(field[2]) == PORT_FREE:
                yield int(field[1])
