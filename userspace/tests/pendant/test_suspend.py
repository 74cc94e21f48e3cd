# SPDX-License-Identifier: GPL-2.0-only
"""System suspend and resume; the pendant is a gadget on dummy_hcd (vhci_hcd refuses to suspend
while a device is plugged in).

pm_test stops suspend after the devices have been suspended, waits a second, and resumes: for the
drivers this is a real suspend to idle.
"""

import errno
import os
import threading
import time

from case import row
import rig
from hid_gadget import HidGadgetPendant
from raw_gadget import GadgetPendant
from rig import Case, pressed, read_file, released, selected, turned, write_file


def suspend(level='devices'):
    write_file('/sys/module/suspend/parameters/pm_test_delay', '1')
    write_file('/sys/power/pm_test', level)
    write_file('/sys/power/state', 'freeze')


def usb_device(pendant):
    return os.path.dirname(os.path.dirname(pendant.path))


class TestGadgets(Case):
    """Both kinds of gadget work."""

    def works(self, make):
        for model in ('HB03', 'HB04'):
            pendant = self.plug_rig(rig.Rig(device=make(model)))
            pendant.report(1, 0, 0x11, -1)
            self.assert_packet(pendant, selected(0, 1) + pressed(1) + turned(-1))
            pendant.set('work_x', '-1.5')
            assert float(pendant.flush()['work_x']) == -1.5
            assert {r.wvalue for r in pendant.device.set_reports} == {0x0306}
            pendant.unplug()

    def test_hid_gadget(self):
        self.works(HidGadgetPendant)

    def test_raw_gadget(self):
        self.works(GadgetPendant)

    def test_stall(self):
        pendant = self.plug_rig(rig.Rig(device=GadgetPendant()))
        pendant.settle()
        pendant.device.set_fault('stall', count=1)
        assert pendant.set_error('flush', '1') == 'EPIPE'


class TestSuspend(Case):
    def plug_gadget(self):
        return self.plug_rig(rig.Rig(device=HidGadgetPendant()))

    def test_all_up_and_a_frame_again(self):
        pendant = self.plug_gadget()
        pendant.set('work_x', '5')
        pendant.report(1, 2, 0x12)
        self.assert_packet(pendant, selected(0, 2) + pressed(1) + pressed(2))
        frames = pendant.settle()
        assert pendant.get('awake') == '1'
        suspend()
        assert os.path.isdir(pendant.path)
        self.assert_packet(pendant, selected(2, 0) + released(1) + released(2))
        assert pendant.device.wait_frames(frames + 1)
        assert pendant.device.lcd.as_dict()['work_x'] == '5.0000'
        assert pendant.no_more_frames(frames + 1)
        assert pendant.get('awake') == '0'
        # keys that are still held are reported again
        pendant.report(1, 0, 0x12)
        self.assert_packet(pendant, selected(0, 2) + pressed(1))
        assert pendant.get('awake') == '1'

    def test_again_and_again(self):
        pendant = self.plug_gadget()
        for turn in range(1, 6):
            pendant.report(turn)
            self.assert_packet(pendant, pressed(turn))
            frames = pendant.settle()
            suspend()
            self.assert_packet(pendant, released(turn))
            assert pendant.device.wait_frames(frames + 1)

    def test_deeper_levels(self):
        for level in ('freezer', 'devices', 'platform'):
            with row(level):
                pendant = self.plug_gadget()
                pendant.report(3)
                self.assert_packet(pendant, pressed(3))
                frames = pendant.settle()
                suspend(level)
                # released before programs are frozen, thus even if no device is suspended
                self.assert_packet(pendant, released(3))
                if level != 'freezer':
                    assert pendant.device.wait_frames(frames + 1)
                pendant.set('work_x', '2')
                assert pendant.shows('work_x', '2.0000')
                pendant.report(3)
                self.assert_packet(pendant, pressed(3))
                pendant.unplug()

    def test_with_writers_at_work(self):
        pendant = self.plug_gadget()
        stop, errors = threading.Event(), []

        def write():
            number = 0
            while not stop.is_set():
                number += 1
                try:
                    pendant.set('feedrate', str(number % 1000))
                    pendant.set('flush', '1')
                except OSError as error:
                    errors.append(error.errno)
                time.sleep(0.002)

        writer = threading.Thread(target=write)
        writer.start()
        try:
            for _ in range(5):
                suspend()
                time.sleep(0.1)
        finally:
            stop.set()
            writer.join(rig.PATIENCE)
        assert not writer.is_alive()
        assert set(errors) <= {errno.ENODEV}
        pendant.set('work_x', '1')
        assert pendant.shows('work_x', '1.0000')
        assert pendant.device.lcd.faults == []

    def test_day_changes_meanwhile(self):
        pendant = self.plug_gadget()
        wall, steady = time.time(), time.monotonic()
        self.add_cleanup(lambda: time.clock_settime(
            time.CLOCK_REALTIME, wall + time.monotonic() - steady))
        tomorrow = time.gmtime(time.time() + 86400)
        frames = pendant.settle()
        write_file('/sys/power/pm_test', 'devices')
        time.clock_settime(time.CLOCK_REALTIME, time.time() + 86400)
        suspend()
        assert pendant.device.wait_frames(frames + 1)
        assert pendant.device.lcd.day == tomorrow.tm_mday


class TestAutosuspend(Case):
    def idle(self):
        """A pendant that supports remote wakeup, with power/control set to auto."""
        device = GadgetPendant()
        config = bytearray(device.descriptors['config'])
        config[7] |= 0x20
        device.descriptors['config'] = bytes(config)
        pendant = self.plug_rig(rig.Rig(device=device))
        power = usb_device(pendant) + '/power/'
        write_file(power + 'autosuspend_delay_ms', '100')
        write_file(power + 'control', 'auto')
        return pendant, lambda: read_file(power + 'runtime_status').strip()

    def test_never_while_driven(self):
        """A detent that wakes the pendant would be lost."""
        pendant, status = self.idle()
        time.sleep(5)
        assert status() == 'active'
        assert 'suspend' not in pendant.device.gadget_events
        pendant.report(wheel=1)
        self.assert_packet(pendant, turned(1))

    def test_without_the_driver_it_happens(self):
        """Counterpart of the previous test: without readers the bus suspends the pendant."""
        pendant, status = self.idle()
        pendant.unbind()
        assert rig.wait(lambda: status() == 'suspended')
        pendant.bind()
        assert rig.wait(lambda: status() == 'active')
