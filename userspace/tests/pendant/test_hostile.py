# SPDX-License-Identifier: GPL-2.0-only
"""Devices that send invalid data, abort, or never answer.  A good pendant runs during each test."""

import errno
import os
import threading
import time

import pytest
from case import row
import rig
from descriptors import ACCEPTED, REFUSED
from driven import MODELS
from kernel import KernelLog
from rig import Case, pressed, selected, turned
from xhc_sim import find
from xhc_sim.models import REPORT_DESCRIPTOR
from xhc_sim.uhid import UhidPendant


class TestDescriptors(Case):
    def refused(self, descriptor, product=None):
        """-> whether the driver refuses a device with this descriptor"""
        device = UhidPendant('HB04', report_descriptor=descriptor, product=product)
        try:
            device.plug()
        except OSError:
            return True                     # refused by uhid
        try:
            path = rig.wait(lambda: find.hid_directory(device.phys))
            assert path, 'no HID device'
            return not rig.takes(path)
        finally:
            device.unplug()
            assert rig.wait(lambda: find.hid_directory(device.phys) is None)

    @pytest.mark.parametrize('name', REFUSED)
    def test_refused(self, name):
        assert self.refused(REFUSED[name])

    def test_one_line_for_a_refusal(self):
        log = KernelLog()
        self.add_cleanup(log.close)
        device = UhidPendant('HB04', report_descriptor=REFUSED['no feature report'])
        lines = []

        def refused():
            lines.extend(line for line in log.lines() if 'hid-xhc' in line)
            return lines

        device.plug()
        assert rig.wait(refused)
        assert find.driver(find.hid_directory(device.phys)) != 'hid-generic'
        assert not device.opened
        device.unplug()         # waits for the probe
        assert len(refused()) == 1, lines

    @pytest.mark.parametrize('name', ACCEPTED)
    def test_accepted(self, name):
        pendant = self.plug(report_descriptor=ACCEPTED[name])
        pendant.report(1)
        self.assert_packet(pendant, pressed(1))
        pendant.set('work_x', '1.5')
        assert pendant.flush()['work_x'] == '1.5000'
        assert {len(r.data) for r in pendant.device.set_reports} == {8}

    def test_cut_at_every_byte(self):
        """Each of these is refused or works, without side effects."""
        for size in range(len(REPORT_DESCRIPTOR)):
            with row(size=size):
                self.refused(REPORT_DESCRIPTOR[:size])
        self.plug()

    def test_each_byte_changed(self):
        for at in range(len(REPORT_DESCRIPTOR)):
            for value in (0x00, 0x7F, 0xFF, REPORT_DESCRIPTOR[at] ^ 1):
                changed = bytearray(REPORT_DESCRIPTOR)
                changed[at] = value
                self.refused(bytes(changed))
        self.plug()

    @pytest.mark.parametrize('product', [0xEA6A, 0xEB73, 0xEB6D, 0xEB71, 0xEB91, 0x0000], ids=hex)
    def test_ids_of_others_are_left_alone(self, product):
        assert self.refused(REPORT_DESCRIPTOR, product)

    @pytest.mark.parametrize('model', MODELS)
    def test_ids_of_ours_are_taken(self, model):
        assert not self.refused(MODELS[model].report_descriptor, MODELS[model].product)


class TestReports(Case):
    def test_wrong_length(self):
        pendant = self.plug()
        pendant.report(1, 0, 0x11)
        self.assert_packet(pendant, selected(0, 1) + pressed(1))
        bad = [size for size in (1, 2, 3, 4, 5, 7, 8, 64, 255, 4096)]
        for size in bad:
            pendant.device.report(bytes([4, 2, 3, 0x12, 1, 0]).ljust(size, b'\x05')[:size])
        self.assert_silent(pendant)
        assert pendant.stat('bad_reports') == len(bad)
        assert pendant.stat('reports') == len(bad) + 2     # with the turn of the wheel
        assert pendant.stat('unknown_keys') == 0
        pendant.report(1, 2, 0x11)
        self.assert_packet(pendant, pressed(2))

    def test_empty(self):
        pendant = self.plug()
        pendant.device.report(b'')
        pendant.report(1)
        self.assert_packet(pendant, pressed(1))

    def test_wrong_id(self):
        """The HID core drops ids that are not in the descriptor."""
        pendant = self.plug()
        for number in (0, 1, 3, 5, 6, 0x84, 0xFF):
            pendant.device.report(bytes([number, 1, 2, 0x11, 5, 0]))
        self.assert_silent(pendant)
        pendant.report(3)
        self.assert_packet(pendant, pressed(3))

    def test_another_report_of_its_own(self):
        descriptor = ACCEPTED['more reports']
        pendant = self.plug(report_descriptor=descriptor)
        pendant.device.report(bytes([5, 1, 2, 0x11, 5, 0]))
        pendant.device.report(bytes([5]) + bytes(60))
        self.assert_silent(pendant)
        assert pendant.stat('bad_reports') == 2
        pendant.report(3)
        self.assert_packet(pendant, pressed(3))

    def test_short_sleep_is_no_sleep(self):
        pendant = self.plug()
        pendant.report(1)
        pendant.packet()
        for size in (1, 2, 5):
            pendant.device.report(bytes([4]) + bytes(size - 1))
        self.assert_silent(pendant)
        assert pendant.get('awake') == '1'

    def test_every_byte_everywhere(self):
        """All values of all fields: the driver keeps working, a sleep report clears the state."""
        pendant = self.plug()
        pendant.close_reader()
        for at in range(1, 6):
            for value in range(256):
                report = bytearray([4, 1, 2, 0x11, 1, 0])
                report[at] = value
                pendant.device.report(report)
        pendant.asleep()
        pendant.report(3)
        pendant.look_again()
        assert pendant.reader.keys_down() == ['BTN_TRIGGER_HAPPY3']

    def test_a_flood_says_little(self):
        pendant = self.plug()
        log = KernelLog()
        self.add_cleanup(log.close)
        for number in range(2000):
            pendant.device.report(bytes([4, number & 0xFF]) * (1 + number % 4))
        lines = [line for line in log.lines() if 'hid-xhc' in line]
        assert len(lines) <= 10        # of the HID core, rate-limited
        assert [line for line in lines if 'Event data for report' not in line] == []


class TestSilent(Case):
    """Devices that do not answer SET_REPORT: uhid gives up after five seconds.

    The limits are shorter if nothing may wait for the answer, else shorter than twice that time.
    """

    def test_from_the_beginning(self):
        device = UhidPendant('HB04')
        device.fault = 'timeout'
        pendant = self.plug_rig(rig.Rig(device=device), first_frame=False)
        pendant.report(1)
        self.assert_packet(pendant, pressed(1))      # input is not affected
        assert rig.wait(lambda: pendant.stat('frame_errors') >= 2)
        pendant.device.fault = 'none'
        assert pendant.device.wait_frames(1, rig.PATIENCE)
        assert rig.wait(lambda: pendant.stat('frames_sent') == 1)

    def timed(self, call):
        start = time.monotonic()
        call()
        return time.monotonic() - start

    def silent(self):
        pendant = self.plug()
        pendant.settle()
        sent = len(pendant.device.set_reports)
        pendant.device.fault = 'timeout'
        pendant.set('work_x', '1')
        assert pendant.device.wait_for(lambda: len(pendant.device.set_reports) > sent)
        return pendant

    def test_unplug_while_it_waits(self):
        pendant = self.silent()
        assert self.timed(pendant.unplug) < 3

    def test_unbind_while_it_waits(self):
        pendant = self.silent()
        assert self.timed(pendant.unbind) < 9
        assert os.path.isdir(pendant.path)

    def test_module_removal_while_it_waits(self):
        pendant = self.silent()
        self.add_cleanup(rig.load)
        assert self.timed(rig.unload) < 9
        assert os.path.isdir(pendant.path)

    def test_unplug_during_a_flush(self):
        pendant = self.plug()
        pendant.settle()
        pendant.device.fault = 'timeout'
        results = []
        flusher = threading.Thread(
            target=lambda: results.append(pendant.set_error('flush', '1')))
        sent = len(pendant.device.set_reports)
        flusher.start()
        assert pendant.device.wait_for(lambda: len(pendant.device.set_reports) > sent)
        pendant.unplug()
        flusher.join(rig.PATIENCE)
        assert len(results) == 1
        assert results[0] in ('ENODEV', 'EIO')

    def test_signal_ends_a_flush(self):
        pendant = self.plug()
        pendant.settle()
        pendant.device.fault = 'timeout'
        path, sent = pendant.file('flush'), len(pendant.device.set_reports)
        start = time.monotonic()
        child = os.fork()
        if child == 0:
            try:
                rig.write_file(path, '1')
            finally:
                os._exit(1)
        assert pendant.device.wait_for(lambda: len(pendant.device.set_reports) > sent)
        os.kill(child, 15)
        _, status = os.waitpid(child, 0)
        assert status == 15
        assert time.monotonic() - start < 3


class TestUnplug(Case):
    def test_at_each_chunk(self):
        for model in ('HB03', 'HB04'):
            for chunk in range(MODELS[model].chunks):
                for way in ('unplug', 'crash'):
                    with row(model=model, chunk=chunk, way=way):
                        pendant = self.plug(model)
                        pendant.settle()
                        self.cut(pendant, chunk, way)
                        pendant.unplug()

    @staticmethod
    def cut(pendant, chunk, way):
        device = pendant.device
        sent = len(device.set_reports)
        device.set_fault('unplug' if way == 'unplug' else 'timeout', skip=chunk)
        try:
            pendant.set('work_x', '1')
        except OSError as error:
            if error.errno not in (errno.ENODEV, errno.ENOENT):
                raise
        assert device.wait_for(lambda: len(device.set_reports) > sent + chunk)
        if way == 'crash':
            device.crash()

    def test_before_the_first_frame(self):
        for chunk in range(6):
            device = UhidPendant('HB04')
            device.set_fault('unplug', skip=chunk)
            device.plug()
            assert device.wait_for(lambda: not device.plugged, rig.PATIENCE)
            assert rig.wait(lambda: find.hid_directory(device.phys) is None)

    def test_at_any_moment(self):
        """From 0 to 40 ms after plugging in: during probe, the first frame, and later."""
        for step in range(80):
            device = UhidPendant('HB04')
            device.plug()
            time.sleep(step / 2000)
            device.unplug() if step % 2 else device.crash()
            assert rig.wait(lambda: find.hid_directory(device.phys) is None)

    def test_files_that_are_still_open(self):
        pendant = self.plug()
        event = os.open(pendant.event_node, os.O_RDONLY | os.O_NONBLOCK)
        raw = os.open(pendant.hidraw_node, os.O_RDWR | os.O_NONBLOCK)
        attribute = os.open(pendant.file('work_x'), os.O_RDWR)
        flush = os.open(pendant.file('flush'), os.O_WRONLY)
        awake = os.open(pendant.file('awake'), os.O_RDONLY)
        pendant.unplug()
        calls = {
            'event': lambda: os.read(event, 24), 'raw': lambda: os.read(raw, 64),
            'raw write': lambda: os.write(raw, b'\x06' + bytes(7)),
            'read': lambda: os.read(attribute, 64), 'write': lambda: os.write(attribute, b'1'),
            'flush': lambda: os.write(flush, b'1'), 'awake': lambda: os.read(awake, 64)}
        for name, call in calls.items():
            with row(name), pytest.raises(OSError) as caught:
                call()
            assert name == 'raw' or caught.value.errno == errno.ENODEV, (name, caught.value)
        for fd in (event, raw, attribute, flush, awake):
            os.close(fd)


class TestTwo(Case):
    def test_side_by_side(self):
        one, two, three = self.plug('HB04'), self.plug('HB04'), self.plug('HB03')
        for number, pendant in enumerate((one, two, three), 1):
            pendant.set('work_x', str(number))
            pendant.report(number)
        for number, pendant in enumerate((one, two, three), 1):
            self.assert_packet(pendant, pressed(number))
            assert float(pendant.flush()['work_x']) == number
            assert pendant.get('work_x') == str(number)

    def test_a_bad_one_does_not_disturb_a_good_one(self):
        good, bad = self.plug(), self.plug()
        bad.settle()
        bad.device.fault = 'timeout'
        sent = len(bad.device.set_reports)
        bad.set('work_x', '1')
        assert bad.device.wait_for(lambda: len(bad.device.set_reports) > sent)
        for number in range(1, 6):
            good.set('work_x', str(number))
            good.flush()
            good.report(wheel=number)
            self.assert_packet(good, turned(number))
        assert len(bad.device.set_reports) == sent + 1     # its transfer is still in flight

    def test_one_goes_the_other_stays(self):
        one, two = self.plug(), self.plug()
        two.report(1)
        self.assert_packet(two, pressed(1))
        one.unplug()
        self.assert_silent(two)
        two.set('work_x', '5')
        assert two.flush()['work_x'] == '5.0000'


class TestRebind(Case):
    def test_unbind_and_bind(self):
        pendant = self.plug()
        pendant.set('work_x', '5')
        pendant.flush()
        pendant.unbind()
        assert not os.path.exists(pendant.path + '/dro')
        frames = pendant.device.frame_count
        pendant.bind()
        assert pendant.device.wait_frames(frames + 1)
        assert pendant.get('work_x') == '0'

    def test_load_after_plug(self):
        """hid-generic is bound to the device until the driver is loaded."""
        rig.unload()
        device = UhidPendant('HB04')
        device.plug()
        self.add_cleanup(device.unplug)
        path = rig.wait(lambda: find.hid_directory(device.phys))
        assert rig.wait(lambda: find.driver(path) == 'hid-generic')
        rig.load()
        assert find.driver(path) == 'hid-xhc'
        assert device.wait_frames(1)
        assert device.events.count('stop') == 1
