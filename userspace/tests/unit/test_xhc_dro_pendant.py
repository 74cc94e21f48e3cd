# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of reading a pendant in xhc-dro, and of writing to its display."""

import errno
import math
import os
import shutil
import struct
from unittest import mock

import pytest
from planted_linuxcnc import Case
from xhc_dro import component, display, events
from xhc_sim.models import STEPS

PINS = {**dict.fromkeys(component.FLOATS_IN, 0.0),
        **dict.fromkeys((*component.BITS_IN, 'select-a'), False), 'fourth': 'a'}


class TestTexts:
    @pytest.mark.parametrize('value, text', [
        (0, '0.0000'), (-220.334, '-220.3340'), (1e9, '65535.9900'), (-1e9, '-65535.9900'),
        (math.inf, '65535.9900'), (math.nan, '0.0000'), (1.99999, '2.0000')])
    def test_coordinate(self, value, text):
        assert display.coordinate(value) == text

    @pytest.mark.parametrize('value, text', [
        (0, '0'), (-1, '0'), (99.6, '100'), (7e4, '65535'), (math.inf, '65535'), (math.nan, '0')])
    def test_number(self, value, text):
        assert display.number(value) == text

    @pytest.mark.parametrize('step, unit, text', [
        (0.001, 0.001, '1'), (0.01, 0.001, '10'), (0.1, 0.001, '100'), (1, 0.001, '1000'),
        (0.0001, 0.0001, '1'), (0.002, 0.001, '0'), (0.0011, 0.001, '0'), (0, 0.001, '0'),
        (-0.001, 0.001, '0'), (math.nan, 0.001, '0'), (math.inf, 0.001, '0')])
    def test_multiplier(self, step, unit, text):
        assert display.multiplier(step, unit, sorted(STEPS.values())) == text

    @pytest.mark.parametrize('on, text', [
        ('', 'idle'), ('running', 'run'), ('paused', 'pause'), ('running paused', 'pause'),
        ('inch', 'inch'), ('running inch', 'run+inch')])
    def test_state(self, on, text):
        assert display.state({**PINS, **dict.fromkeys(on.split(), True)}) == text

    def test_all(self):
        pins = {**PINS, 'work-x': 1.5, 'machine-z': -2, 'feed-override': 1.2, 'velocity': -20,
                'spindle-override': 0.5, 'spindle-speed': -18000, 'step': 0.01}
        assert display.texts(pins, 0.001, [10]) == {
            'position': '1.5000 0.0000 0.0000 0.0000 0.0000 -2.0000', 'feedrate_override': '120',
            'spindle_override': '50', 'feedrate': '1200', 'spindle_speed': '18000', 'step': '10',
            'state': 'idle'}


class TestFind(Case):
    def test_it(self):
        models = ('HB03', 'HB04')
        assert display.find(models, driver=self.driver + '/none') is None
        os.makedirs(self.driver + '/module')
        assert display.find(models, driver=self.driver) is None
        first = self.plug()
        second = self.plug('0003:10CE:EB70.0002', 'usb-2/input0')
        assert display.find(models, driver=self.driver) == first
        assert display.find(models, 'usb-2/input0', self.driver) == second
        assert display.find(models, 'usb-3/input0', self.driver) is None

    def test_other_models(self):
        """The order in the folder of the driver has no effect; a clone is bound as a model."""
        hb04 = self.plug()
        assert display.find(('WHB04B',), driver=self.driver) is None
        assert display.find(('WHB04B',), 'usb-1/input0', self.driver) is None
        whb04b = self.plug('0003:10CE:EB93.0002')
        clone = self.plug('0003:10CE:%s.0003' % 'EB00', 'usb-3/input0', 'HB03')
        assert display.find(('HB03', 'HB04'), driver=self.driver) == clone
        assert display.find(('HB04',), driver=self.driver) == hb04
        assert display.find(('WHB04B',), driver=self.driver) == whb04b


class TestDisplay(Case):
    def set_up(self):
        super().set_up()
        self.path = self.plug()
        self.display = display.Display(self.path, self.said.append)
        self.add_cleanup(self.display.close)

    def test_only_what_changes_is_written(self):
        self.display.show({'feedrate': '1', 'state': 'run'})
        self.put(self.path + '/dro/state', 'else')
        self.display.show({'feedrate': '2', 'state': 'run'})
        assert (self.get(self.path, 'feedrate'), self.get(self.path, 'state')) == \
                         ('2', 'else')

    def test_each_is_opened_once(self):
        with mock.patch.object(display.os, 'open', wraps=os.open) as opened:
            for number in range(5):
                self.display.show({'feedrate': str(number)})
        assert opened.call_count == 1

    def test_an_error_is_said_once_and_tried_again(self):
        os.unlink(self.path + '/dro/feedrate')
        for _ in range(3):
            self.display.show({'feedrate': '5', 'state': 'run'})
        assert self.said == ['feedrate: 5: No such file or directory']
        assert self.get(self.path, 'state') == 'run'
        self.put(self.path + '/dro/feedrate', '')
        self.display.show({'feedrate': '5'})
        assert self.get(self.path, 'feedrate') == '5'

    def test_udevd_is_waited_for(self):
        """Before that only root may write, which is not an error."""
        denied = PermissionError(errno.EACCES, 'Permission denied')
        with mock.patch.object(display.os, 'open', side_effect=denied), \
                mock.patch.object(display.time, 'monotonic') as clock:
            clock.return_value = self.display.born + display.UDEV_TIME - 0.1
            self.display.show({'feedrate': '5'})
            assert self.said == []
            clock.return_value += 0.2
            for _ in range(3):
                self.display.show({'feedrate': '5'})
            assert self.said == ['feedrate: 5: Permission denied']
        self.display.show({'feedrate': '5'})
        assert self.display.shown == {'feedrate': '5'}

    def test_a_pendant_that_goes_is_no_trouble(self):
        shutil.rmtree(self.path)
        self.display.show({'feedrate': '5'})
        assert (self.said, self.display.there()) == ([], False)


class Kernel:
    """Results of ioctls of an event node, which a FIFO as its replacement does not support."""

    def __init__(self):
        self.down = set()
        self.selector = 0
        self.rotary = None
        self.layout = {}            # number: key code, for keys changed by hwdb

    def ioctl(self, _file, number, room):
        if number == events.EVIOCGKEY:
            state = bytearray(events.KEY_STATE)
            for each in self.down:
                code = self.layout.get(each, 0x2bf + each)
                state[code // 8] |= 1 << code % 8
            return bytes(state)
        if number == 0x80284504:    # EVIOCGKEYCODE_V2; the scan code has four bytes
            flags, length, _, _, scan = struct.unpack_from('BBHII', room)
            assert (flags, length, len(room)) == (0, 4, 40)
            return struct.pack('BBHI32s', 0, 4, scan, self.layout.get(scan, 0x2bf + scan), room[8:])
        position = self.selector if number == events.EVIOCGABS[0x28] else self.rotary
        if position is None:
            raise OSError(errno.EINVAL, 'Invalid argument')
        return struct.pack('6i', position, 0, 7, 0, 0, 0)


def key(number, value, code=None):
    """MSC_SCAN, and the code, which is BTN_TRIGGER_HAPPY without a layout"""
    return (4, 4, number), (1, code or 0x2c0 + number - 1, value), REPORT


def selector(position):
    """ABS_MISC, and the button of the position"""
    return (3, 0x28, position), (1, 0x2c0 + 29 + position, 1), REPORT


def detent(count):
    return 2, 7, count                          # EV_REL, REL_DIAL


REPORT = (0, 0, 0)                              # EV_SYN, SYN_REPORT


class TestEvents(Case):
    def set_up(self):
        super().set_up()
        self.path = self.plug()
        os.makedirs(self.path + '/input/input5/event7')
        os.mkfifo(self.driver + '/event7')
        self.kernel = Kernel()
        patch = mock.patch.object(events.fcntl, 'ioctl', self.kernel.ioctl)
        patch.start()
        self.add_cleanup(patch.stop)

    def opened(self):
        made = events.Events(self.path, self.driver)
        self.add_cleanup(made.close)
        self.writer = os.open(self.driver + '/event7', os.O_WRONLY)
        self.add_cleanup(os.close, self.writer)
        return made

    def send(self, *sent):
        for each in sent:
            os.write(self.writer, struct.pack('llHHi', 0, 0, *each))

    def test_no_node(self):
        shutil.rmtree(self.path + '/input')
        with pytest.raises(FileNotFoundError):
            events.Events(self.path, self.driver)

    def test_what_is_down_at_first(self):
        self.kernel.down = {1, 23, 31, 40}
        self.kernel.selector = 8
        made = self.opened()
        assert (made.down, made.selector, made.rotary) == ({1, 23}, 8, 0)

    def test_rotary(self):
        self.kernel.rotary = 4
        made = self.opened()
        assert made.rotary == 4
        self.send((3, 6, 7), REPORT)
        made.read()
        assert made.rotary == 7

    def test_wheel_and_keys(self):
        made = self.opened()
        self.send(*key(3, 1), detent(5), REPORT, detent(-2), REPORT)
        assert (made.read(), made.down) == (3, {3})
        self.send(*key(3, 0), *selector(2))
        assert (made.read(), made.down, made.selector) == (0, set(), 2)
        assert made.read() == 0

    def test_a_layout_changes_nothing(self):
        made = self.opened()
        self.send(*key(22, 1, 128))
        made.read()
        assert made.down == {22}
        self.send(*key(22, 0, 128))
        made.read()
        assert made.down == set()

    def test_what_is_down_with_a_layout(self):
        """Stop is KEY_STOP, Reset has no code; initially, and after events were lost."""
        self.kernel.layout, self.kernel.down = {22: 128, 23: 0}, {3, 22}
        made = self.opened()
        assert made.down == {3, 22}
        self.kernel.down = {22, 23}
        self.send((0, 3, 0))
        made.read()
        assert made.down == {22}

    def test_two_keys_with_one_code(self):
        """It is released with the last of them; none stays pressed, and Stop works again."""
        made = self.opened()
        for _ in range(2):
            self.send(*key(22, 1, 128), (4, 4, 3), REPORT)
            made.read()
            assert made.down == {22}
            self.send((4, 4, 22), REPORT, *key(3, 0, 128))
            made.read()
            assert made.down == set()

    def test_a_short_press_is_seen(self):
        """Stop, pressed for less than one round"""
        made = self.opened()
        self.send(*2 * (*key(22, 1), *key(22, 0)))
        seen = []
        for _ in range(4):
            made.read()
            seen.append(made.down == {22})
        assert seen == [True, True, False, False]

    def test_detents_are_those_before_the_selector_moves(self):
        made = self.opened()
        self.send(detent(4), REPORT, *selector(1), detent(2), REPORT)
        assert (made.read(), made.selector) == (4, 0)
        assert (made.read(), made.selector) == (2, 1)

    @pytest.mark.parametrize('sent, after', [
        (((3, 6, 6), REPORT), 'rotary'), (key(13, 1), 'down')])
    def test_detents_are_those_before_another_step(self, sent, after):
        """Changed by the rotary, or by a key"""
        made = self.opened()
        before = getattr(made, after)
        before = before if after == 'rotary' else set(before)
        self.send(detent(4), REPORT, *sent, detent(2), REPORT)
        assert (made.read(), getattr(made, after)) == (4, before)
        assert (made.read(), getattr(made, after)) == (2, 6 if after == 'rotary' else {13})

    def test_events_were_lost(self):
        made = self.opened()
        self.send(*key(2, 1))
        made.read()
        self.kernel.down, self.kernel.selector = {5}, 3
        self.send((0, 3, 0), *key(7, 1))
        made.read()
        assert (made.down, made.selector) == ({5}, 3)

    def test_a_scan_code_without_its_key(self):
        """When the state is read, the kernel drops the key, and only the key, from the queue."""
        made = self.opened()
        self.send((4, 4, 2), REPORT, *selector(1))
        made.read()
        assert made.down == set()
        self.send((4, 4, 2), (0, 3, 0))
        made.read()
        self.send(*selector(2))
        made.read()
        assert (made.down, made.selector) == (set(), 2)

    def test_touched(self):
        """All keys pressed since the last call, independent of the number of pending events"""
        made = self.opened()
        self.send(*key(22, 1), *key(22, 0), *selector(2), *key(2, 1), *key(2, 0), *key(5, 1))
        made.read()
        assert made.down == {22} and made.touched() == {2, 5, 22}

    def test_it_goes(self):
        made = self.opened()
        with mock.patch.object(events.os, 'read', side_effect=OSError(errno.ENODEV, '')):
            with pytest.raises(OSError):
                made.read()
