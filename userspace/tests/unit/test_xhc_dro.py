# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xhc-dro with a HAL and a sysfs that are not there: what it reads and writes, what
it reports of errors, how it follows a pendant; and that its HAL files, tables, page and the layouts
agree.
"""

import errno
import math
import os
import re
import shutil
import struct
import sys
import tempfile
import types
from unittest import mock

import pytest

import case

PRODUCT = os.path.join(os.path.dirname(os.path.realpath(__file__)), '..', '..', 'linuxcnc')
sys.path.insert(0, PRODUCT)

from xhc_dro import cli, component, display, events, keys, macros, wheel  # noqa: E402
from xhc_sim.models import STEPS  # noqa: E402

ATTRIBUTES = ('position', 'feedrate_override', 'spindle_override', 'feedrate', 'spindle_speed',
              'step', 'state')
PINS = {**dict.fromkeys(component.FLOATS_IN, 0.0),
        **dict.fromkeys((*component.BITS_IN, 'select-a', 'has-a'), False)}


def product(name):
    with open(os.path.join(PRODUCT, name), encoding='utf-8') as file:
        return file.read()


class Hal(types.SimpleNamespace):
    """The module `hal`: one component, and a list of those that exist."""

    HAL_FLOAT, HAL_BIT, HAL_S32, HAL_IN, HAL_OUT = 'float', 'bit', 's32', 'in', 'out'
    error = RuntimeError

    def __init__(self):
        super().__init__(existing=set(), pins={}, kinds={}, is_ready=False, ended=False)

    def component(self, name):
        hal = self

        class Pins(dict):
            def newpin(self, pin, kind, direction):
                self[pin] = {hal.HAL_FLOAT: 0.0, hal.HAL_S32: 0}.get(kind, False)
                hal.kinds[pin] = (kind, direction)

            def ready(self):
                hal.is_ready = True

            def exit(self):
                hal.ended = True

        self.existing.add(name)
        self.pins = Pins()
        return self.pins

    def component_exists(self, name):
        return name in self.existing


class Linuxcnc(types.SimpleNamespace):
    """The module `linuxcnc`: a mill that is ready, and a list of what it is asked to do."""

    error = OSError
    STATE_ON, INTERP_IDLE, RCS_DONE, RCS_EXEC, RCS_ERROR = 4, 1, 1, 2, 3
    MODE_MANUAL, MODE_AUTO, MODE_MDI = 1, 2, 3

    def __init__(self, **state):
        super().__init__(asked=[], serial=0, texts={})
        self.now = types.SimpleNamespace(**{
            'poll': lambda: None, 'task_state': 4, 'interp_state': 1, 'task_mode': 1, 'state': 1,
            'joints': 3, 'homed': (1, 1, 1, 0), 'inpos': True, 'axis_mask': 7,
            # the line number comes first, and may be that of a code
            'gcodes': (910, 0, 170, 400, 210, 900), 'linear_units': 1.0, 'rotation_xy': 0.0,
            'position': (1.0, 2.0, -5.0, 0.0, 0.0, 0.0),
            'g5x_offset': (10.0, 20.0, 30.0, 0.0, 0.0, 0.0),
            'g92_offset': (0.0,) * 6, 'tool_offset': (0.0,) * 6, 'echo_serial_number': 0, **state})

    def stat(self):
        return self.now

    def command(self):
        return self

    def ini(self, _path):
        return types.SimpleNamespace(
            findall=lambda section, name: {'MACRO_1': ['G4 P1', 'M8']}.get(name)
            if section == 'XHC' else None,
            find=lambda section, name: self.texts.get((section, name)))

    def _ask(self, what):
        self.asked.append(what)
        self.serial += 1
        self.now.echo_serial_number = self.serial

    def error_msg(self, text):
        self._ask(text)

    def mdi(self, line):
        self._ask(line)

    def mode(self, mode):
        self._ask(mode)
        self.now.task_mode = mode


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


class Case(case.Case):
    """A driver's directory in sysfs, made of files."""

    def set_up(self):
        self.driver = tempfile.mkdtemp()
        self.add_cleanup(shutil.rmtree, self.driver)
        self.said = []

    def plug(self, name='0003:10CE:EB70.0001', phys='usb-1/input0'):
        path = os.path.join(self.driver, name)
        os.makedirs(path + '/dro')
        for attribute in ATTRIBUTES:
            self.put(path + '/dro/' + attribute, '')
        self.put(path + '/dro/step_available', ' '.join(map(str, STEPS.values())) + '\n')
        self.put(path + '/uevent', 'HID_NAME=x\nHID_PHYS=%s\n' % phys)
        return path

    @staticmethod
    def put(path, text):
        with open(path, 'w', encoding='ascii') as file:
            file.write(text)

    @staticmethod
    def get(path, name):
        with open('%s/dro/%s' % (path, name), encoding='ascii') as file:
            return file.read()


class TestFind(Case):
    def test_it(self):
        assert display.find(driver=self.driver + '/none') is None
        os.makedirs(self.driver + '/module')
        assert display.find(driver=self.driver) is None
        first = self.plug()
        second = self.plug('0003:10CE:EB70.0002', 'usb-2/input0')
        assert display.find(driver=self.driver) == first
        assert display.find('usb-2/input0', self.driver) == second
        assert display.find('usb-3/input0', self.driver) is None


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
        """Until then nobody but root may write, and that is no trouble."""
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
    """What an event node answers to ioctls, which a FIFO in its place cannot."""

    def __init__(self):
        self.down = set()
        self.selector = 0
        self.rotary = None

    def ioctl(self, _file, number, _room):
        if number == events.EVIOCGKEY:
            state = bytearray(events.KEY_STATE)
            for each in self.down:
                code = events.BUTTONS + each
                state[code // 8] |= 1 << code % 8
            return bytes(state)
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

    def test_a_short_press_is_seen(self):
        """Stop, which is down for less than a turn"""
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

    def test_events_were_lost(self):
        made = self.opened()
        self.send(*key(2, 1))
        made.read()
        self.kernel.down, self.kernel.selector = {5}, 3
        self.send((0, 3, 0), *key(7, 1))
        made.read()
        assert (made.down, made.selector) == ({5}, 3)

    def test_it_goes(self):
        made = self.opened()
        with mock.patch.object(events.os, 'read', side_effect=OSError(errno.ENODEV, '')):
            with pytest.raises(OSError):
                made.read()


class Hands:
    """In the place of Events: what hands do to a pendant"""

    def __init__(self):
        self.down = set()
        self.selector = 0
        self.rotary = 0
        self.detents = 0
        self.trouble = None
        self.paths = []             # of those that have been opened
        self.open = 0

    def __call__(self, path):
        if self.trouble:
            raise self.trouble
        self.paths.append(path)
        self.open += 1
        return self

    def read(self):
        if self.trouble:
            raise self.trouble
        detents, self.detents = self.detents, 0
        return detents

    def close(self):
        self.open -= 1


class TestComponent(Case):
    def start(self, *words, **texts):
        self.hal = Hal()
        self.mill = Linuxcnc()
        self.mill.texts = {('TRAJ' if name == 'COORDINATES' else 'XHC', name): text
                           for name, text in texts.items()}
        self.hands = Hands()
        patch = mock.patch.object(component, 'Events', self.hands)
        patch.start()
        self.add_cleanup(patch.stop)
        with mock.patch.dict(os.environ, INI_FILE_NAME=self.driver + '/mill.ini'):
            made = component.Component(self.hal, self.mill, cli.parser().parse_args(words),
                                       self.said.append, driver=self.driver)
        self.add_cleanup(made.end)
        self.made = made
        return made

    def turn(self, made):
        made.next_search = 0.0
        made.turn()
        return made.pins['connected']

    def on(self):
        """-> which pins of keys and selector are on"""
        return {name for name, value in self.made.pins.items()
                if value is True and name.startswith(('key-', 'select-'))}

    def test_pins(self):
        made = self.start('--name', 'other')
        assert self.hal.is_ready and self.hal.existing == {'other'}
        assert made.pins['step'] == 0.001
        assert self.hal.kinds['key-stop'] == self.hal.kinds['plus-c'] == ('bit', 'out')

    def test_it_follows_the_pendant(self):
        made = self.start()
        assert not self.turn(made)
        made.pins['work-y'] = 7.25
        for name in ('0003:10CE:EB70.0001', '0003:10CE:EB70.0002'):
            path = self.plug(name)
            assert self.turn(made)
            assert self.get(path, 'position').split()[1] == '7.2500'
            assert self.hands.paths[-1] == path
            shutil.rmtree(path)
            assert not self.turn(made)
        assert (self.said, self.hands.open) == ([], 0)

    def test_each_wheel_with_its_own_display(self):
        """Two pendants: the other's wheel is not read, and its display not written."""
        first = self.plug()
        second = self.plug('0003:10CE:EB70.0002', 'usb-2/input0')
        made = self.start('--phys', 'usb-2/input0')
        made.pins['velocity'] = 2
        assert self.turn(made)
        assert self.hands.paths == [second]
        assert (self.get(first, 'feedrate'), self.get(second, 'feedrate')) == ('', '120')

    def test_what_it_was_is_gone_with_it(self):
        """Keys, selector and jogs, in whichever order the kernel shows that it goes"""
        for of_the_node in (True, False):
            made = self.start()
            path = self.plug()
            self.turn(made)
            self.hands.down, self.hands.selector = {22}, 1
            assert self.turn(made) and self.on() == {'key-stop', 'select-x'}
            if of_the_node:
                self.hands.trouble = OSError(errno.ENODEV, 'No such device')
            else:
                shutil.rmtree(path)
            for _ in range(2):
                assert not self.turn(made) and self.on() == set()
            shutil.rmtree(path, ignore_errors=True)

    def test_a_key_that_is_down_at_first_does_nothing(self):
        """But for those that stop"""
        made = self.start()
        self.plug()
        self.hands.down, self.hands.selector = {2, 22}, 3
        for _ in range(2):
            assert self.turn(made) and self.on() == {'key-stop', 'select-z'}
        self.hands.down = set()
        self.turn(made)
        self.hands.down = {2}
        self.turn(made)
        assert self.on() == {'key-start', 'select-z'}

    def test_the_screen_names_the_loss(self):
        """Once, and not for a pendant that has never come"""
        made = self.start()
        self.turn(made)
        path = self.plug()
        self.turn(made)
        assert self.mill.asked == []
        shutil.rmtree(path)
        for _ in range(2):
            self.turn(made)
        assert self.mill.asked == ['pendant: it is gone']
        self.plug()
        self.turn(made)
        assert len(self.mill.asked) == 1

    def test_a_loss_while_linuxcnc_ends(self):
        made = self.start()
        path = self.plug()
        self.turn(made)
        shutil.rmtree(path)
        with mock.patch.object(self.mill, 'error_msg', side_effect=Linuxcnc.error('no channel')):
            assert not self.turn(made)
        assert self.said == ['no channel']

    @pytest.mark.parametrize('coordinates, position, first', [
        ('X Y Z A', 4, '4.5000'), ('xyza', 1, '1.5000'), ('XYZ', 4, '1.5000')])
    def test_axis_a(self, coordinates, position, first):
        """An HB04 has rows for three axes: A has that of X while it is selected."""
        made = self.start(COORDINATES=coordinates)
        path = self.plug()
        for number, axis in enumerate('xyza', 1):
            made.pins['work-' + axis] = made.pins['machine-' + axis] = number + 0.5
        self.hands.selector = position
        self.turn(made)
        rows = self.get(path, 'position').split()
        assert rows == [first, '2.5000', '3.5000'] * 2

    def test_a_late_round(self):
        """What was done to the pendant meanwhile does nothing."""
        with mock.patch.object(component.time, 'monotonic') as clock:
            clock.return_value = 100.0
            made = self.start()
            self.plug()
            self.turn(made)
            for late, opened in ((0.4, 1), (0.6, 2), (0.4, 2), (0.6, 3)):
                clock.return_value += late
                self.turn(made)
                assert len(self.hands.paths) == opened
            assert self.hands.open == 1
            made.pins['patience'] = 1
            clock.return_value += 0.9
            self.turn(made)
            assert len(self.hands.paths) == 3

    def test_udevd_is_waited_for(self):
        made = self.start()
        self.plug()
        self.hands.trouble = PermissionError(errno.EACCES, 'Permission denied')
        with mock.patch.object(component.time, 'monotonic') as clock:
            clock.return_value = 100.0
            assert not self.turn(made)
            clock.return_value += component.UDEV_TIME - 0.1
            assert not self.turn(made) and self.said == []
            for _ in range(3):
                clock.return_value += 0.2
                assert not self.turn(made)
            assert len(self.said) == 1 and self.said[0].endswith(': Permission denied')
            self.hands.trouble = None
            clock.return_value += 0.2
            assert self.turn(made)

    def test_wheel(self):
        made = self.start()
        self.plug()
        for detents, counts in ((3, 3), (0, 3), (-5, -2)):
            self.hands.detents = detents
            self.turn(made)
            assert made.pins['wheel'] == counts

    def test_steps(self):
        """An HB04's two keys, and a factor of an axis"""
        made = self.start(SCALE_Y='-2')
        path = self.plug()
        self.turn(made)
        for number, step in ((13, 0.01), (14, 0.001), (14, 1), (13, 0.001)):
            self.hands.down = {number}
            self.turn(made)
            self.hands.down = set()
            self.turn(made)
            assert made.pins['step'] == made.pins['step-x'] == step
            assert made.pins['step-y'] == -2 * step
            assert self.get(path, 'step').startswith(str(round(1000 * step)))

    def test_no_further_line_when_the_pendant_is_gone(self):
        """It has the key Stop."""
        made = self.start()
        path = self.plug()
        assert self.turn(made)
        self.hands.down = {1}
        assert self.turn(made)
        assert self.mill.asked == [3, 'G53 G0 Z0.0000000']
        shutil.rmtree(path)
        for _ in range(3):
            assert not self.turn(made)
        assert self.mill.asked == [3, 'G53 G0 Z0.0000000', 'pendant: it is gone', 1]

    @pytest.mark.parametrize('product_id, number, text, name', [
        ('EB70', 7, {}, 'key-zero'), ('EB6E', 9, {}, 'key-zero-x'), ('EB6E', 7, {}, 'key-half-y'),
        ('EB70', 9, {'KEYS': 'hb04-16.keys'}, 'key-zero-x'),
        ('EB70', 9, {'KEYS': 'mine.keys'}, 'key-lamp')])
    def test_tables(self, product_id, number, text, name):
        self.put(self.driver + '/mine.keys', '09 lamp   # on and off\n')
        made = self.start(**text)
        self.plug('0003:10CE:%s.0001' % product_id)
        self.turn(made)
        self.hands.down = {number}
        self.turn(made)
        assert self.on() == {name}

    def test_keys_that_run_macros(self):
        made = self.start()
        self.plug('0003:10CE:EB6E.0001')
        self.turn(made)
        self.hands.down = {11}
        self.turn(made)
        assert self.mill.asked[:2] == [3, 'G10 L20 P0 Z0.0000000']

    @pytest.mark.parametrize('selector, number, asked', [
        (2, 7, [3, 'G10 L20 P0 Y0.0000000']), (1, 6, [3, 'G10 L20 P0 X-4.5000000']),
        (5, 7, ['pendant: zero: no axis is selected']),
        (0, 7, ['pendant: zero: no axis is selected'])])
    def test_keys_for_the_selected_axis(self, selector, number, asked):
        made = self.start()
        self.plug()
        self.hands.selector = selector
        self.turn(made)
        self.hands.down = {number}
        self.turn(made)
        assert self.mill.asked == asked

    @pytest.mark.parametrize('text', ['9 lamp', '09', '09 a b c', '00 lamp', '1f lamp', '09 Lamp',
                                      '09 lamp\n09 lamp'])
    def test_a_table_that_is_none(self, text):
        self.put(self.driver + '/mine.keys', text + '\n')
        with pytest.raises(ValueError, match=r'mine.keys:\d: not a key'):
            self.start(KEYS='mine.keys')

    def test_heartbeat(self):
        made = self.start()
        beats = []
        for _ in range(4):
            made.turn()
            beats.append(made.pins['heartbeat'])
        assert beats == [True, False, True, False]

    def test_the_end(self):
        made = self.start(MODE='continuous')
        self.plug()
        self.hands.selector = self.hands.detents = 1
        assert self.turn(made)
        made.pins['plus-x'] = True
        made.end()
        assert (made.pins['connected'], made.pins['plus-x'], self.hal.ended) == (
            False, False, True)

    def test_whb04b(self):
        """Its rows are those of the axes that the selector is among."""
        made = self.start('--model', 'whb04b')
        path = os.path.join(self.driver, '0003:10CE:EB93.0001')
        os.makedirs(path + '/dro')
        for attribute in ('rows', 'mode', 'coordinates', 'reset', 'feedrate_override',
                          'spindle_override'):
            self.put(path + '/dro/' + attribute, '')
        for number, axis in enumerate('xyzabc', 1):
            made.pins['work-' + axis] = number + 0.5
            made.pins['machine-' + axis] = -number
        made.pins['feed-override'] = 1.05
        assert self.turn(made)
        assert [self.get(path, name) for name in (
            'rows', 'mode', 'coordinates', 'reset', 'feedrate_override', 'spindle_override')] == \
            ['1.5000 2.5000 3.5000', 'step', 'work', '0', '105', '0']
        for position in (4, 7, 8):
            self.hands.selector = position
            self.turn(made)
            assert self.get(path, 'rows') == '4.5000 5.5000 6.5000'
            self.hands.selector = 1
            self.turn(made)
            assert self.get(path, 'rows') == '1.5000 2.5000 3.5000'
        made.pins.update({'show-machine': True, 'reset': True})
        for mode in ('continuous', 'mpg', 'continuous'):
            self.hands.down = {14}
            self.turn(made)
            self.hands.down = set()
            self.turn(made)
            assert self.get(path, 'mode')[:len(mode)] == mode
        assert self.get(path, 'rows') == '-1.0000 -2.0000 -3.0000'
        assert self.get(path, 'coordinates').startswith('machine')
        assert self.get(path, 'reset') == '1'
        assert self.said == []


class TestProgram:
    @staticmethod
    def main(*words, **of_the_mill):
        """-> exit status, what is reported"""
        said = []
        mill = Linuxcnc()
        vars(mill).update({'version': '2.9.4', **of_the_mill})
        with mock.patch.dict(sys.modules, hal=Hal(), linuxcnc=mill), \
                mock.patch.object(cli, 'say', said.append), \
                mock.patch.object(cli.signal, 'signal'), \
                mock.patch.object(component.Component, 'run', lambda self: None):
            return cli.main(words), said

    @pytest.mark.parametrize('version, named', [
        ('2.9.0~pre1+git', False), ('2.9.4', False), ('2.9.5', True), ('2.9.6-2', True),
        ('2.9.9', False), ('2.9.50', False)])
    def test_a_halui_that_dies(self, version, named):
        status, said = self.main(version=version)
        assert status == 0 and len(said) == named
        assert not named or version in said[0]

    def test_an_ini_that_is_wrong(self):
        with mock.patch.dict(os.environ, INI_FILE_NAME='/none/mill.ini'):
            for name, text in (('KEYS', 'none.keys'), ('MODE', 'fast'), ('STEPS', 'one')):
                status, said = self.main(texts={('XHC', name): text})
                assert status == 1 and len(said) == 1


class TestKeys:
    TABLE = {1: ('reset', 'reset'), 3: ('start', 'macro-13'), 12: ('fn', 'fn'), 5: ('-', '-')}

    def test_fn(self):
        """What a key is, it stays until it is up."""
        made = keys.Keys(self.TABLE)
        for down, pressed, is_down in (
                ({3}, ['start'], 'start'), ({3, 12}, ['fn'], 'start'), (set(), [], None),
                ({3, 12}, ['fn', 'macro-13'], 'macro-13'), ({3}, [], 'macro-13'),
                ({1}, ['reset'], 'reset'), ({1, 12}, ['fn'], 'reset'), ({12}, [], 'fn'),
                ({1, 12}, ['reset'], 'reset'), (set(), [], None), ({5}, [], None),
                ({6}, [], None)):
            assert made.turn(down) == pressed
            assert is_down is None or made.is_down(is_down)
        assert not any(made.is_down(name) for name in ('reset', 'start', 'macro-13', 'fn', '-'))

    def test_down_at_first(self):
        made = keys.Keys(self.TABLE, {3, 1})
        assert made.turn({3, 1}) == ['reset'] and not made.is_down('start')
        assert made.turn(set()) == []
        assert made.turn({3}) == ['start'] and made.is_down('start')


class TestWheel:
    @staticmethod
    def made(has_rotary=True, mode='step', **texts):
        mill = Linuxcnc()
        mill.texts = {('TRAJ' if name == 'LINEAR_UNITS' else 'XHC', name): text
                      for name, text in texts.items()}
        with mock.patch.dict(os.environ, INI_FILE_NAME='mill.ini'):
            made = wheel.Wheel(mill, has_rotary)
        made.mode = mode
        return made

    def at(self, made, now=0.0, detents=0, axis='x', rotary=4):
        """-> which pins that jog are on"""
        self.found = made.turn(detents, axis, rotary, (50.0, 20.0), now)
        return {name for name in wheel.JOGS if self.found[name]}

    @pytest.mark.parametrize('texts, lengths, unit', [
        ({}, (0.001, 0.01, 0.1, 1), 0.001), ({'LINEAR_UNITS': 'mm'}, (0.001, 0.01, 0.1, 1), 0.001),
        *(({'LINEAR_UNITS': name}, (0.0001, 0.001, 0.01, 0.1), 0.0001)
          for name in ('inch', 'in', 'Imperial')),
        ({'STEPS': '0.005 0.05'}, (0.005, 0.05), 0.001)])
    def test_lengths(self, texts, lengths, unit):
        made = self.made(**texts)
        assert (made.lengths, made.unit) == (lengths, unit)

    @pytest.mark.parametrize('texts, axis, length', [
        ({}, 'x', 1), ({'SCALE': '-1'}, 'x', -1), ({'SCALE_A': '10'}, 'a', 10),
        ({'SCALE_A': '10'}, 'x', 1), ({'SCALE': '2', 'SCALE_Z': '-0.5'}, 'z', -0.5),
        ({'FILTER': '0.1'}, 'x', 0.001), ({'FILTER_Y': '0.1', 'SCALE_Y': '-1'}, 'y', -0.001)])
    def test_scale(self, texts, axis, length):
        self.at(self.made(**texts))
        assert self.found['step'] == 1
        assert self.found['step-' + axis] == pytest.approx(length)

    @pytest.mark.parametrize('rotary, step, mpg', [
        (1, 0.001, 0.002), (2, 0.01, 0.005), (3, 0.1, 0.01), (4, 1, 0.03), (5, 5, 0.06),
        (6, 10, 0.1), (7, 0, 0), (0, 0, 0)])
    def test_rotary(self, rotary, step, mpg):
        for mode, length in (('step', step), ('mpg', mpg)):
            self.at(self.made(mode=mode), rotary=rotary)
            assert self.found['step-x'] == pytest.approx(length)

    def test_as_long_as_it_turns(self):
        made = self.made(mode='continuous')
        for now, detents, jogs in ((1, 0, set()), (2, 1, {'plus-x'}), (2.2, 0, {'plus-x'}),
                                   (2.2, 1, {'plus-x'}), (2.44, 0, {'plus-x'}), (2.46, 0, set()),
                                   (3, -2, {'minus-x'})):
            assert self.at(made, now, detents) == jogs

    def test_against_the_scale(self):
        made = self.made(mode='continuous', SCALE_X='-1')
        assert self.at(made, 1, 1) == {'minus-x'}
        assert self.at(made, 2) == set()
        assert self.at(made, 3, -1) == {'plus-x'}

    def test_turned_back_it_stops_first(self):
        made = self.made(mode='continuous')
        assert self.at(made, 1, 1) == {'plus-x'}
        assert self.at(made, 1.1, -1) == set()
        assert self.at(made, 1.2, -1) == {'minus-x'}

    def test_another_axis(self):
        made = self.made(mode='continuous')
        assert self.at(made, 1, 1) == {'plus-x'}
        assert self.at(made, 1.1, 0, 'y') == set()
        assert self.at(made, 1.2, 1, 'y') == {'plus-y'}

    @pytest.mark.parametrize('at', [{'axis': None}, {'rotary': 7}, {'rotary': 0}])
    def test_no_jog(self, at):
        assert self.at(self.made(mode='continuous'), 1, 1, **at) == set()

    @pytest.mark.parametrize('mode', ['step', 'mpg'])
    def test_other_modes(self, mode):
        assert self.at(self.made(mode=mode), 1, 1) == set()
        assert self.found['detents'] and self.found['mode-' + mode]
        assert not self.found['mode-continuous']

    @pytest.mark.parametrize('at, speed', [
        ({}, 900), ({'rotary': 1}, 60), ({'rotary': 6}, 3000), ({'rotary': 7}, 0),
        ({'axis': 'b'}, 360), ({'axis': None}, 0)])
    def test_speed(self, at, speed):
        self.at(self.made(mode='continuous'), **at)
        assert self.found['jog-speed'] == speed
        assert not self.found['detents']

    def test_speed_without_a_rotary(self):
        """The part that the step is of all steps"""
        made = self.made(False, 'continuous')
        for speed in (750, 1500, 2250, 3000):
            assert self.at(made, 1, 1, rotary=0) == {'plus-x'}
            assert self.found['jog-speed'] == speed
            made.press('step-up')

    @pytest.mark.parametrize('has_rotary, modes', [
        (True, ('continuous', 'mpg', 'continuous', 'mpg')),
        (False, ('continuous', 'mpg', 'step', 'continuous'))])
    def test_mode_keys(self, has_rotary, modes):
        made = self.made(has_rotary)
        for mode in modes:
            made.press('mode')
            assert made.mode == mode
        made.press('step')
        assert made.mode == 'step'

    @pytest.mark.parametrize('mode', wheel.MODES)
    def test_the_mode_at_first(self, mode):
        mill = Linuxcnc()
        mill.texts = {('XHC', 'MODE'): mode}
        with mock.patch.dict(os.environ, INI_FILE_NAME='mill.ini'):
            assert wheel.Wheel(mill, False).mode == mode
        mill.texts = {('XHC', 'MODE'): 'fast'}
        with mock.patch.dict(os.environ, INI_FILE_NAME='mill.ini'), pytest.raises(ValueError):
            wheel.Wheel(mill, False)


class TestMacros(Case):
    @staticmethod
    def made(mill):
        with mock.patch.dict(os.environ, INI_FILE_NAME='mill.ini'):
            return macros.Macros(mill, pytest.fail)

    def asked(self, name='goto-zero', axis=None, **state):
        mill = Linuxcnc(**state)
        made = self.made(mill)
        made.start(name, axis)
        for _ in range(8):
            made.turn()
        return mill.asked

    def test_the_mode_is_as_it_was(self):
        assert self.asked('safe-z') == [3, 'G53 G0 Z0.0000000', 1]
        assert self.asked('safe-z', task_mode=3) == [3, 'G53 G0 Z0.0000000', 3]

    @pytest.mark.parametrize('state, x, y', [
        ({}, 10, 20), ({'g92_offset': (1, 2, 3)}, 11, 22), ({'tool_offset': (1, 2, 3)}, 11, 22),
        ({'g92_offset': (1, 2, 3), 'rotation_xy': 90}, 8, 21),
        ({'gcodes': (0, 0, 200)}, 10 / 25.4, 20 / 25.4), ({'gcodes': (0, 0, 70)}, 20, 20),
        ({'gcodes': (0, 0, 200), 'linear_units': 1 / 25.4}, 10, 20),
        ({'gcodes': (0, 0, 210), 'linear_units': 1 / 25.4}, 254, 508)])
    def test_goto_zero(self, state, x, y):
        assert self.asked(**state) == [
            3, 'G53 G0 Z0.0000000', 'G53 G0 X%.7f Y%.7f' % (x, y), 1]

    @pytest.mark.parametrize('state, x, y', [
        ({}, 9, 18), ({'rotation_xy': 90}, 18, -9), ({'gcodes': (0, 0, 910, 70)}, 18, 18)])
    def test_goto_zero_in_g91(self, state, x, y):
        """LinuxCNC refuses G53 then."""
        assert self.asked(**{'gcodes': (0, 0, 910), **state}) == [
            3, 'G0 Z5.0000000', 'G0 X%.7f Y%.7f' % (x, y), 1]

    @pytest.mark.parametrize('codes, line', [
        ((0, 800), 'G80'), ((0, 10), 'G53 G1 Z0.0000000'), ((0, 10, 910), 'G1 Z0')])
    def test_the_motion_mode_is_as_it_was(self, codes, line):
        assert self.asked('safe-z', gcodes=codes)[2:] == [line, 1]

    def test_a_lathe_has_no_y(self):
        assert self.asked(axis_mask=5) == [3, 'G53 G0 Z0.0000000', 'G53 G0 X10.0000000', 1]

    @pytest.mark.parametrize('name, axis, state, line', [
        ('zero', 'Y', {}, 'Y0.0000000'), ('half', 'X', {}, 'X-4.5000000'),
        ('half', 'X', {'gcodes': (0, 0, 70)}, 'X-9.0000000'),
        ('half', 'Z', {'g92_offset': (0, 0, 1, 0, 0, 0)}, 'Z-18.0000000'),
        ('half', 'X', {'rotation_xy': 90}, 'X-9.0000000'),
        ('half', 'A', {'axis_mask': 15, 'gcodes': (0, 0, 200), 'position': (0, 0, 0, 9, 0, 0)},
         'A4.5000000')])
    def test_offsets(self, name, axis, state, line):
        assert self.asked(name, axis, **state) == [3, 'G10 L20 P0 ' + line, 1]

    @pytest.mark.parametrize('name, axis, state, line', [
        ('goto-zero-x', 'Z', {}, 'G53 G0 X10.0000000 Y2.0000000'),
        ('goto-zero-selected', 'Z', {}, 'G53 G0 Z30.0000000'),
        ('goto-zero-selected', 'Y', {}, 'G53 G0 X1.0000000 Y20.0000000'),
        ('goto-zero-x', None, {'rotation_xy': 90}, 'G53 G0 X1.0000000 Y20.0000000'),
        ('goto-zero-y', None, {'rotation_xy': 90}, 'G53 G0 X10.0000000 Y2.0000000'),
        ('goto-zero-x', None, {'g92_offset': (3, 4, 0, 0, 0, 0)}, 'G53 G0 X13.0000000 Y2.0000000'),
        ('goto-zero-z', None, {'gcodes': (0, 0, 910)}, 'G0 Z35.0000000'),
        ('goto-zero-a', None, {'axis_mask': 15, 'g5x_offset': (0, 0, 0, 7, 0, 0),
                               'gcodes': (0, 0, 200)}, 'G53 G0 A7.0000000')])
    def test_goto_zero_of_an_axis(self, name, axis, state, line):
        assert self.asked(name, axis, **state) == [3, line, 1]

    def test_goto_zero_of_an_axis_in_g1(self):
        assert self.asked('goto-zero-z', gcodes=(0, 10)) == [
            3, 'G53 G0 Z30.0000000', 'G53 G1 Z30.0000000', 1]
        assert self.asked('goto-zero-z', gcodes=(0, 10, 910)) == [
            3, 'G0 Z35.0000000', 'G1 Z0', 1]

    def test_the_owners(self):
        assert self.asked('macro-1') == [3, 'G4 P1', 'M8', 1]

    @pytest.mark.parametrize('name, axis, state, reason', [
        ('safe-z', None, {'task_state': 1}, 'the machine is not on'),
        ('safe-z', None, {'interp_state': 2}, 'a program runs'),
        ('safe-z', None, {'task_mode': 2}, 'not in auto mode'),
        ('zero', 'X', {'homed': (1, 0, 1)}, 'the machine is not homed'),
        ('macro-1', None, {'inpos': False}, 'the machine moves'),
        ('macro-2', None, {}, '[XHC]MACRO_2 is not in the ini'),
        ('zero', None, {}, 'no axis is selected'), ('zero', 'A', {}, 'no axis is selected'),
        ('safe-z', None, {'axis_mask': 3}, 'there is no axis Z'),
        ('goto-zero-selected', None, {}, 'no axis is selected'),
        ('goto-zero-a', None, {}, 'there is no axis A'),
        ('zero-b', 'X', {}, 'there is no axis B'),
        *(('goto-zero', None, {'gcodes': (0, 0, code)},
           'not with cutter compensation (G41, G42)') for code in (410, 411, 420, 421))])
    def test_refused(self, name, axis, state, reason):
        assert self.asked(name, axis, **state) == ['pendant: %s: %s' % (name, reason)]

    def test_another_runs(self):
        mill = Linuxcnc()
        made = self.made(mill)
        made.start('goto-zero')
        made.start('safe-z')
        assert mill.asked == [3, 'pendant: safe-z: another one runs']

    @pytest.mark.parametrize('state, after', [
        ({'task_mode': 1}, []), ({'task_state': 1}, []), ({'state': Linuxcnc.RCS_ERROR}, [1]),
        ({'echo_serial_number': 9}, [1]), ({'echo_serial_number': 1}, []),
        ({'state': Linuxcnc.RCS_EXEC}, []), ({'inpos': False}, []), ({'interp_state': 2}, [])])
    def test_no_move_while_or_after_something_else(self, state, after):
        """Another command may have been Stop."""
        mill = Linuxcnc()
        made = self.made(mill)
        made.start('goto-zero')
        made.turn()
        vars(mill.now).update(state)
        for _ in range(3):
            made.turn()
        assert mill.asked == [3, 'G53 G0 Z0.0000000', *after]


class TestFiles(Case):
    # By caption; what no table has is left to the owner.
    MEANT = {'Start/Pause': 'start', '0=': 'zero', '1/2=': 'half', 'X=0': 'zero-x', 'Y=0': 'zero-y',
             'Z=0': 'zero-z', 'X/2=': 'half-x', 'Y/2=': 'half-y', 'Goto home': 'home',
             'Home': 'home', 'M-Home': 'home', 'W-Home': 'goto-zero', 'Spindle on/off': 'spindle',
             'STEP++': 'step-up', 'Step right': 'step-up', 'Step left': 'step-down',
             'MPG/MODE': 'step-down', 'Mode': 'step-down', 'Fine xyz': 'mode',
             'Continuous/MPG': 'mode', 'Feed+': 'feed-plus', 'Feed-': 'feed-minus',
             'Spindle+': 'spindle-plus', 'Spindle-': 'spindle-minus', 'Yes': '-', 'No': '-'}

    @staticmethod
    def layout(name):
        """-> {number: (caption, caption with Fn or None)} of the file for hwdb"""
        path = os.path.join(PRODUCT, '..', 'hwdb', 'layouts', name + '.layout')
        with open(path, encoding='utf-8') as file:
            rows = [line.rstrip('\n').split('\t') for line in file]
        return {int(row[0], 16): (row[1], row[3] if len(row) > 3 else None)
                for row in rows if re.fullmatch('[0-9a-f]{2}', row[0])}

    @pytest.mark.parametrize('name', ['hb03', 'hb04-16', 'hb04-18', 'whb04b'])
    def test_tables_are_those_of_the_layouts(self, name):
        def meant(caption):
            default = 'step-up' if name == 'hb04-16' and caption == 'Step' else \
                caption.lower().replace(' ', '-')
            return self.MEANT.get(caption, default)

        wanted = {number: (meant(caption), meant(with_fn or caption))
                  for number, (caption, with_fn) in self.layout(name).items()}
        if name == 'whb04b':        # these do their work with Fn, too
            wanted.update({1: ('reset', 'reset'), 2: ('stop', 'stop')})
        assert keys.shipped()[name] == wanted

    def test_every_name_does_something(self):
        """By MDI, by the wheel, or by a net of xhc-jog.hal"""
        wired = re.findall(r'^net xhc\.key-(\S+) xhc-dro\.key-\1$', product('xhc-dro.hal'), re.M)
        assert set(re.findall(r'xhc\.key-(\S+)', product('xhc-jog.hal'))) == set(wired)
        others = {'step-up', 'step-down', 'step', 'mode', 'fn', *macros.ACTIONS, *macros.OWNERS}
        assert set(keys.names(keys.shipped().values())) - others == set(wired)

    def test_every_pin_is_wired(self):
        """But those for a display of the owner's taste, and what is not for HAL files"""
        wired = {name for name in re.findall(r'xhc-dro\.(\S+)', product('xhc-dro.hal'))
                 if not name.startswith('key-')}
        assert wired == set(component.FLOATS_IN + component.BITS_IN + component.BITS_OUT +
                            component.FLOATS_OUT + component.NUMBERS_OUT) - {
            'inch', 'show-machine', 'max-velocity', 'max-angular-velocity', 'patience', 'step',
            'rotary', 'mode-step', 'mode-continuous'}

    def test_no_component_has_more_names_than_it_takes(self):
        for line in re.findall(r'^loadrt \S+ names=(\S+)', product('xhc-jog.hal'), re.M):
            names = line.split(',')
            assert len(names) <= 16
            for each in names:
                assert re.search(r'^addf %s servo-thread$' % re.escape(each),
                                 product('xhc-jog.hal'), re.M), each

    def test_no_key_runs_a_command_by_its_number(self):
        for name in os.listdir(PRODUCT):
            if name.endswith(('.hal', '.tcl')):
                assert 'mdi-command' not in product(name)

    def test_steps_are_on_the_display(self):
        for unit, lengths in ((0.001, wheel.MILLIMETRES), (0.0001, wheel.INCHES)):
            shown = [display.multiplier(step, unit, list(STEPS.values())) for step in lengths]
            assert shown == ['1', '10', '100', '1000']

    def test_the_page_has_all_options_and_pins(self):
        page = product('xhc-dro.1')
        for action in cli.parser()._actions:
            for option in action.option_strings:
                assert 'Fl ' + option[1:] in page
        for pin in (component.FLOATS_IN + component.BITS_IN + component.BITS_OUT +
                    component.FLOATS_OUT + component.NUMBERS_OUT +
                    tuple(keys.names(keys.shipped().values()))):
            assert re.search(r'(?<![\w-])%s(?![\w-])' % pin, page), pin
