# SPDX-License-Identifier: GPL-2.0-only
"""The pendant on USB (vhci_hcd): real enumeration, real usbhid, all control transfers recorded."""

import fcntl
import glob
import os
import struct
import threading
import time

from case import row
import rig
from descriptors import REFUSED
from driven import MODELS
from rig import Case, pressed, read_file, released, selected, turned
from xhc_sim import find
from xhc_sim.lcd import COORDINATES
from xhc_sim.usb import VHCI, UsbPendant

SET_REPORT = (0x21, 0x09)


def usb_device(path):
    """The directory of the USB device of a HID device."""
    return os.path.dirname(os.path.dirname(path))


class TestIdentity(Case):
    def test_every_model(self):
        for model in MODELS.values():
            with row(model.name):
                pendant = self.plug_usb(model.name)
                device = usb_device(pendant.path)
                for name, text in (('idVendor', '10ce'), ('idProduct', '%04x' % model.product),
                                   ('speed', '12'), ('manufacturer', 'KTURT.LTD'),
                                   ('bNumInterfaces', ' 1'), ('bNumConfigurations', '1')):
                    assert read_file(os.path.join(device, name)) == text + '\n'
                for name in ('product', 'serial'):
                    assert not os.path.exists(os.path.join(device, name))
                assert pendant.reader.device.name == 'XHC %s Pendant' % model.name
                assert pendant.reader.device.phys == pendant.device.phys
                pendant.unplug()

    def test_endpoint(self):
        for model, size in (('HB04', '0040'), ('WHB04B', '0008')):
            pendant = self.plug_usb(model)
            interface = os.path.dirname(pendant.path)
            endpoints = [name for name in os.listdir(interface) if name.startswith('ep_')]
            assert endpoints == ['ep_81']
            for name, text in (('wMaxPacketSize', size), ('type', 'Interrupt'),
                               ('bInterval', '02')):
                assert read_file(os.path.join(interface, 'ep_81', name)) == text + '\n'

    def test_modalias(self):
        pendant = self.plug_usb()
        assert read_file(pendant.path + '/modalias') == \
                         'hid:b0003g0001v000010CEp0000EB70\n'


class TestEvents(Case):
    def test_reports(self):
        pendant = self.plug_usb()
        pendant.report(1, 2, 0x11, -3)
        self.assert_packet(pendant, selected(0, 1) + pressed(1) + pressed(2) + turned(-3))
        pendant.asleep()
        self.assert_packet(pendant, selected(1, 0) + released(1) + released(2))

    def test_reports_in_a_row(self):
        pendant = self.plug_usb()
        for number in range(300):
            pendant.report(wheel=1 + number % 10)
            self.assert_packet(pendant, turned(1 + number % 10))

    def test_wrong_length(self):
        pendant = self.plug_usb()
        for size in (1, 2, 3, 4, 5):        # usbhid requests at most six bytes
            pendant.device.report(bytes([4, 1, 2, 0x11, 5])[:size])
        pendant.device.report(b'')
        self.assert_silent(pendant)
        pendant.report(3)
        self.assert_packet(pendant, pressed(3))
        assert pendant.stat('bad_reports') == 5


class TestDisplay(Case):
    def test_wire(self):
        """All parts of a frame, in order, as defined by the protocol."""
        for model in MODELS.values():
            pendant = self.plug_usb(model.name)
            if model.feed:
                pendant.set('rows', '1 2 3')
                start = b'\xfe\x00\x01\x00'
            else:
                pendant.set('position', '1 2 3 4 5 6')
                start = bytes([time.gmtime().tm_mday, 1, 0])
            pendant.settle()
            known = len(pendant.device.set_reports)
            pendant.flush()
            sent = list(pendant.device.set_reports)[known:]
            assert [(r.wvalue, r.windex, len(r.data), r.data[0]) for r in sent] == \
                             [(0x0306, 0, 8, 6)] * model.chunks
            frame = b''.join(r.data[1:] for r in sent)
            assert frame.startswith(b'\xfe\xfd' + start)
            assert not any(frame[model.frame_size:])
            setups = [s for s in pendant.device.requests if (s[0], s[1]) == SET_REPORT]
            assert {s[2:] for s in setups} == {bytes.fromhex('0603 0000 0800')}
            pendant.unplug()

    def test_lcd(self):
        pendant = self.plug_usb()
        pendant.set('position', '135.17 -77.89 -0.5 -220.334 0 65535.9999')
        pendant.set('state', 'run+inch')
        shown = pendant.flush()
        assert [shown[name] for name in COORDINATES] == \
                         ['135.1700', '-77.8900', '-0.5000', '-220.3340', '0.0000', '65535.9999']
        assert (shown['state'], shown['faults']) == ('run+inch', [])

    def test_interface_other_than_0(self):
        """wIndex is the number of the HID interface."""
        device = UsbPendant('HB04')
        config = device.descriptors['config']
        vendor = bytes([9, 4, 0, 0, 0, 0xFF, 0, 0, 0])
        hid = bytearray(config[9:])
        hid[2] = 1
        body = vendor + bytes(hid)
        device.descriptors['config'] = struct.pack('<BBHBBBBB', 9, 2, 9 + len(body), 2, 1, 0,
                                                   0x80, 50) + body
        device.interface = 1
        pendant = self.plug_rig(rig.Rig(device=device))
        assert {r.windex for r in device.set_reports} == {1}
        pendant.report(1)
        self.assert_packet(pendant, pressed(1))

    def test_stall(self):
        pendant = self.plug_usb()
        pendant.settle()
        for skip in range(6):
            with row(skip=skip):
                pendant.device.set_fault('stall', skip=skip, count=1)
                assert pendant.set_error('flush', '1') == 'EPIPE'
        assert pendant.stat('frame_errors') == 6
        pendant.set('work_x', '1')
        assert pendant.shows('work_x', '1.0000')

    def test_no_answer(self):
        pendant = self.plug_usb()
        pendant.settle()
        pendant.device.set_fault('timeout', count=1)
        start = time.monotonic()
        assert pendant.set_error('flush', '1') == 'ETIMEDOUT'
        assert time.monotonic() - start < 9         # one timeout of five seconds, not two
        assert pendant.set_error('flush', '1') is None

    def test_slow(self):
        pendant = self.plug_usb()
        pendant.settle()
        pendant.device.fault = 'slow:100'
        start = time.monotonic()
        pendant.flush()
        assert time.monotonic() - start > 0.55

    def test_no_answer_blocks_no_writer_and_no_event(self):
        pendant = self.plug_usb()
        pendant.settle()
        pendant.device.fault = 'timeout'
        sent = len(pendant.device.set_reports)
        pendant.set('work_x', '1')
        assert pendant.device.wait_for(lambda: len(pendant.device.set_reports) > sent)
        for number in range(1, 20):
            pendant.set('work_y', str(number))
            pendant.report(wheel=number)
            self.assert_packet(pendant, turned(number))
        assert len(pendant.device.set_reports) == sent + 1  # its transfer is still in flight


class TestUnplug(Case):
    def test_in_mid_transfer(self):
        for chunk in range(6):
            with row(chunk=chunk):
                pendant = self.plug_usb()
                pendant.settle()
                pendant.device.set_fault('unplug', skip=chunk)
                pendant.set('work_x', '1')
                pendant.wait_gone()
                assert len(pendant.device.set_reports) == 6 + chunk + 1
                pendant.unplug()

    def flush_and(self, cut):
        """A flush waits for an answer when the device is unplugged.

        It ends with the timeout of the transfer at the latest: five seconds on vhci_hcd, which only
        then returns a control transfer; real controllers return it at once.
        """
        pendant = self.plug_usb()
        pendant.settle()
        pendant.device.fault = 'timeout'
        known, results = len(pendant.device.set_reports), []
        flusher = threading.Thread(
            target=lambda: results.append(pendant.set_error('flush', '1')))
        flusher.start()
        assert pendant.device.wait_for(lambda: len(pendant.device.set_reports) > known)
        start = time.monotonic()
        cut(pendant.device)
        flusher.join(rig.PATIENCE)
        assert time.monotonic() - start < 9         # one timeout, not two
        assert results != [None]
        assert len(results) == 1
        pendant.wait_gone()

    def test_cable_cut_during_a_flush(self):
        self.flush_and(lambda device: device.unplug())

    def test_detach_during_a_flush(self):
        self.flush_and(lambda device: device.detach())

    def test_deauthorized_during_a_flush(self):
        def deauthorize(device):
            path = usb_device(find.hid_directory(device.phys))
            rig.write_file(path + '/authorized', '0')
        self.flush_and(deauthorize)

    def test_keys_go_up(self):
        for way in ('unplug', 'detach'):
            with row(way):
                pendant = self.plug_usb()
                self.assert_lets_go(pendant, getattr(pendant.device, way))

    def test_plugged_again(self):
        pendant = self.plug_usb()
        for number in range(1, 4):
            with row(number):
                pendant.set('feedrate', str(number))
                assert pendant.flush()['feedrate'] == number
                pendant.report(3)
                self.assert_packet(pendant, pressed(3))
                pendant.unplug()
                pendant.plug()

    def test_unbound_from_usbhid(self):
        pendant = self.plug_usb()
        interface = os.path.basename(os.path.dirname(pendant.path))
        rig.write_file('/sys/bus/usb/drivers/usbhid/unbind', interface)
        pendant.wait_gone()
        rig.write_file('/sys/bus/usb/drivers/usbhid/bind', interface)
        assert rig.wait(lambda: find.hid_directory(pendant.device.phys))


class TestResetInPlace(Case):
    """usbhid resets a port after a second of errors, and so does usbreset: the device stays, and
    no callback of the driver runs. The pendant restarts, with day 0 and an empty LCD."""

    @staticmethod
    def reset(pendant):
        device = usb_device(pendant.path)
        node = '/dev/bus/usb/%03d/%03d' % (int(read_file(device + '/busnum')),
                                           int(read_file(device + '/devnum')))
        fd = os.open(node, os.O_RDWR)
        try:
            fcntl.ioctl(fd, 0x5514)             # USBDEVFS_RESET
        finally:
            os.close(fd)
        assert pendant.device.lcd is None

    def test_display(self):
        """The driver detects it by the first report, which returns day 0."""
        pendant = self.plug_usb()
        pendant.set('work_x', '1.5')
        pendant.report(1)
        self.assert_packet(pendant, pressed(1))
        assert pendant.device.wait_frames(2)
        for scan in (2, 3):
            frames, sent = pendant.settle(), pendant.stat('frames_sent')
            self.reset(pendant)
            assert pendant.stat('frames_sent') == sent      # the device is the same
            pendant.report(scan)
            assert pendant.shows('work_x', '1.5000')
            pendant.report()                                # returns the day of that frame
            assert pendant.no_more_frames(frames + 1)

    def test_keys_and_selector(self):
        """They are those of the last report until the next one."""
        pendant = self.plug_usb()
        pendant.report(1, 2, 0x12)
        self.assert_packet(pendant, selected(0, 2) + pressed(1) + pressed(2))
        self.reset(pendant)
        assert pendant.packet(1) is None
        pendant.report(2, 0, 0x11, 1)
        self.assert_packet(pendant, selected(2, 1) + released(1) + turned(1))


class TestHostile(Case):
    def endure(self, change=None, report_descriptor=None):
        """Plugs in a bad device, waits until the kernel has handled it, and unplugs it.

        -> whether the kernel has created a HID device for it, and hid-xhc was bound
        """
        device = UsbPendant('HB04', report_descriptor)
        if change:
            change(device.descriptors)
        device.plug()
        assert rig.wait(lambda: device.requests), 'the kernel does not look at it'
        # the hub driver holds the lock of the hub from the first request to the last probe
        for hub in glob.glob(VHCI + '/usb*/bConfigurationValue'):
            read_file(hub)
        path = find.hid_directory(device.phys)
        taken = rig.takes(path) if path else False
        device.detach()
        assert rig.wait(lambda: find.hid_directory(device.phys) is None)
        return bool(path), taken

    def good(self):
        pendant = self.plug_usb()
        pendant.report(1)
        self.assert_packet(pendant, pressed(1))
        pendant.flush()
        pendant.unplug()

    def test_report_descriptors(self):
        for name in ('no input report', 'no feature report', 'feature of 6 bytes',
                     'input of 1000 bytes', 'zeros', 'larger than HID allows'):
            with row(name):
                assert self.endure(report_descriptor=REFUSED[name]) == (True, False)
        self.good()

    def test_descriptors_that_lie(self):
        def patch(which, at, value):
            def change(descriptors):
                changed = bytearray(descriptors[which])
                changed[at:at + len(value)] = value
                descriptors[which] = bytes(changed)
            return change

        def missing(which):
            return lambda descriptors: descriptors.update({which: None})

        def cut(which, size):
            return lambda descriptors: descriptors.update({which: descriptors[which][:size]})

        hid = 9 + 9
        changes = {
            'no report descriptor': missing('report'),
            'no configuration': missing('config'),
            'no device descriptor': missing('device'),
            'no strings': lambda d: d.update(strings={}),
            'a string that lies': lambda d: d.update(strings={
                0: b'\x04\x03\x09\x04', 1: b'\xff\x03ab'}),
            'half a report descriptor': cut('report', 20),
            'half a configuration': cut('config', 20),
            'report descriptor of 0 bytes': patch('config', hid + 7, b'\x00\x00'),
            'report descriptor of 64 KiB': patch('config', hid + 7, b'\xff\xff'),
            'report descriptor of 10 bytes': patch('config', hid + 7, b'\x0a\x00'),
            'many HID descriptors': patch('config', hid + 5, b'\xff'),
            'HID descriptor too long': patch('config', hid, b'\xff'),
            'endpoint 1 out': patch('config', 9 + 9 + 9 + 2, b'\x01'),
            'bulk endpoint': patch('config', 9 + 9 + 9 + 3, b'\x02'),
            'packets of 0 bytes': patch('config', 9 + 9 + 9 + 4, b'\x00\x00'),
            'packets of 1 byte': patch('config', 9 + 9 + 9 + 4, b'\x01\x00'),
            'two endpoints, one there': patch('config', 9 + 4, b'\x02'),
            'no endpoint': patch('config', 9 + 4, b'\x00'),
            'boot mouse': patch('config', 9 + 6, b'\x01\x02'),
            'not HID': patch('config', 9 + 5, b'\xff'),
        }
        for name, change in changes.items():
            with row(name):
                self.endure(change)
        self.good()

    def test_two_pendants(self):
        one, two = self.plug_usb(), self.plug_usb()
        assert one.reader.device.phys != two.reader.device.phys
        for number, pendant in ((1, one), (2, two)):
            pendant.set('work_x', str(number))
            pendant.report(number)
        for number, pendant in ((1, one), (2, two)):
            self.assert_packet(pendant, pressed(number))
            assert pendant.flush()['work_x'] == '%d.0000' % number
