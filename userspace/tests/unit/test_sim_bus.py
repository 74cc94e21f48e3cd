# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of the two buses of xhc-sim: USB through vhci_hcd, and uhid, without a kernel."""

import errno
import os
import socket
import struct
import threading
import time

import pytest

from busless_pendant import HB04, chunks, frame
from case import Case
from xhc_sim import models, pendant, uhid, usb

LIMIT = 20                  # timeout in seconds for expected events


class FakeKernel(usb.UsbPendant):
    """UsbPendant whose port is a socket of the test."""

    def plug(self, timeout=5.0):
        self.host, theirs = socket.socketpair()
        self.port = 0
        self._socket = theirs
        self.plugged = True
        threading.Thread(target=self._serve, args=(theirs,), daemon=True).start()

    def submit(self, seqnum, setup=bytes(8), data=b'', endpoint=0, length=None, inbound=None):
        inbound = bool(setup[0] & 0x80) if inbound is None else inbound
        length = len(data) if length is None else length
        self.host.sendall(usb.HEADER.pack(usb.CMD_SUBMIT, seqnum, 1, inbound, endpoint,
                                          usb.SUBMIT.pack(0, length, 0, 0, 0, setup)) + data)

    def unlink(self, seqnum, victim):
        self.host.sendall(usb.HEADER.pack(usb.CMD_UNLINK, seqnum, 1, 0, 0,
                                          struct.pack('>I24x', victim)))

    def answer(self, inbound=False):
        """-> (command, seqnum, status, actual length, data)"""
        self.host.settimeout(LIMIT)
        head = usb._read(self.host, 48)
        command, seqnum, _, _, _, status, actual = struct.unpack('>IIIIIii20x', head)
        data = usb._read(self.host, actual) if inbound and actual > 0 else b''
        return command, seqnum, status, actual, data


def control(kind, request, value=0, index=0, length=0):
    return usb.SETUP.pack(kind, request, value, index, length)


SET_CHUNK = control(0x21, 9, 0x0306, 0, 8)


class TestUsb(Case):
    def set_up(self):
        self.pendant = FakeKernel('HB04')
        self.pendant.plug()
        self.add_cleanup(self.pendant.host.close)
        self.add_cleanup(self.pendant.unplug)

    def ask(self, request):
        self.pendant.submit(1, request, length=int.from_bytes(request[6:8], 'little'))
        return self.pendant.answer(inbound=True)

    def test_device_descriptor(self):
        _, _, status, actual, data = self.ask(control(0x80, 6, 0x0100, 0, 64))
        assert (status, actual) == (0, 18)
        assert struct.unpack_from('<HH', data, 8) == (0x10CE, 0xEB70)
        assert tuple(data[14:18]) == (1, 0, 0, 1)      # manufacturer only
        assert self.ask(control(0x80, 6, 0x0100, 0, 8))[4] == data[:8]

    def test_configuration(self):
        data = self.ask(control(0x80, 6, 0x0200, 0, 255))[4]
        assert len(data) == int.from_bytes(data[2:4], 'little')
        assert data[4] == 1                            # one interface
        assert data[9:18].hex() == '090400000103000000'
        assert int.from_bytes(data[25:27], 'little') == 46
        assert data[27:].hex() == '07058103400002'     # one endpoint, 0x81

    def test_strings(self):
        assert self.ask(control(0x80, 6, 0x0300, 0, 255))[4].hex() == '04030904'
        data = self.ask(control(0x80, 6, 0x0301, 0x0409, 255))[4]
        assert data[2:].decode('utf-16-le') == 'KTURT.LTD'
        assert self.ask(control(0x80, 6, 0x0302, 0x0409, 255))[2] == -errno.EPIPE

    def test_report_descriptor(self):
        data = self.ask(control(0x81, 6, 0x2200, 0, 46))[4]
        assert data == models.REPORT_DESCRIPTOR

    def test_unknown_requests_stall(self):
        for request in (control(0x80, 6, 0x0600, 0, 10), control(0xC0, 1, 0, 0, 8),
                        control(0xA1, 1, 0x0306, 0, 8)):
            assert self.ask(request)[2] == -errno.EPIPE

    def test_input_report_after_poll(self):
        self.pendant.submit(5, endpoint=1, inbound=True, length=64)
        assert self.pendant.polled.wait(LIMIT)
        self.pendant.report(b'\x04\x01\x00\x11\x00\x17')
        assert self.pendant.answer(True) == (3, 5, 0, 6, b'\x04\x01\x00\x11\x00\x17')

    def test_input_report_before_poll(self):
        self.pendant.report(b'123456')
        self.pendant.report(b'abcdef')
        assert self.pendant.pending() == 2
        for seqnum, data in ((6, b'123456'), (7, b'abcdef')):
            self.pendant.submit(seqnum, endpoint=1, inbound=True, length=64)
            assert self.pendant.answer(True) == (3, seqnum, 0, 6, data)

    def test_unlink_of_a_poll(self):
        self.pendant.submit(8, endpoint=1, inbound=True, length=64)
        assert self.pendant.polled.wait(LIMIT)
        self.pendant.unlink(9, 8)
        assert self.pendant.answer()[:3] == (4, 9, -errno.ECONNRESET)
        self.pendant.unlink(10, 8)
        assert self.pendant.answer()[:3] == (4, 10, 0)

    def chunk(self, seqnum, part=bytes(7)):
        self.pendant.submit(seqnum, SET_CHUNK, b'\x06' + part)

    def test_set_report(self):
        for seqnum, part in enumerate(chunks(frame(HB04, day=9)), 20):
            self.chunk(seqnum, part)
            assert self.pendant.answer() == (3, seqnum, 0, 8, b'')
        assert self.pendant.wait_frames(1, LIMIT)
        assert self.pendant.lcd.day == 9
        assert {(r.wvalue, r.windex, len(r.data)) for r in self.pendant.set_reports} == \
                         {(0x0306, 0, 8)}

    def test_stall(self):
        self.pendant.fault = 'stall'
        self.chunk(30)
        assert self.pendant.answer()[:3] == (3, 30, -errno.EPIPE)

    def test_slow(self):
        self.pendant.fault = 'slow:100'
        start = time.monotonic()
        self.chunk(31)
        assert self.pendant.answer()[:4] == (3, 31, 0, 8)
        assert time.monotonic() - start >= 0.09

    def test_timeout_and_unlink(self):
        self.pendant.fault = 'timeout'
        self.chunk(32)
        self.pendant.unlink(33, 32)
        assert self.pendant.answer()[:3] == (4, 33, -errno.ECONNRESET)

    def test_slow_answer_after_unlink_is_dropped(self):
        self.pendant.fault = 'slow:100'
        self.chunk(34)
        self.pendant.unlink(35, 34)
        assert self.pendant.answer()[:2] == (4, 35)
        self.chunk(36)                  # equally slow, and after it
        assert self.pendant.answer()[:3] == (3, 36, 0)

    def test_cable_cut_in_mid_transfer(self):
        self.pendant.set_fault('unplug', skip=2)
        for seqnum in (40, 41):
            self.chunk(seqnum)
            assert self.pendant.answer()[:3] == (3, seqnum, 0)
        self.chunk(42)
        with pytest.raises(EOFError):
            self.pendant.answer()
        assert not self.pendant.plugged

    def test_no_controller(self):
        if not os.path.exists(usb.VHCI):
            with pytest.raises(pendant.NoDevice):
                usb.UsbPendant().plug()


class TestUhid(Case):
    def test_create_event(self):
        event = uhid.UhidPendant('HB03').create_event()
        assert len(event) == 4 + 128 + 64 + 64 + 2 + 2 + 4 * 4 + 4096
        assert struct.unpack_from('<HHII', event, 260) == (46, 3, 0x10CE, 0xEB6E)
        assert event[280:280 + 46] == models.REPORT_DESCRIPTOR

    def test_phys_tells_pendants_apart(self):
        assert uhid.UhidPendant().phys != uhid.UhidPendant().phys

    def test_report_while_unplugged(self):
        with pytest.raises(OSError):
            uhid.UhidPendant().report(b'\4')
