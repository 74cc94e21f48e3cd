# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xhc-dro with a HAL and a sysfs that are not there: what it writes, what it says
of errors, how it follows a pendant and hal_input; and that its HAL files, page and driver agree.
"""

import errno
import math
import os
import re
import shutil
import sys
import tempfile
import types
from unittest import mock

import pytest

import case
from busless_pendant import HB04, WHB04B

PRODUCT = os.path.join(os.path.dirname(os.path.realpath(__file__)), '..', '..', 'linuxcnc')
sys.path.insert(0, PRODUCT)

from xhc_dro import (  # noqa: E402
    cli, component, display, macros, steps, whb04b, input as hal_input)
from xhc_sim.models import STEPS  # noqa: E402

ATTRIBUTES = ('position', 'feedrate_override', 'spindle_override', 'feedrate', 'spindle_speed',
              'step', 'state')
PINS = {**dict.fromkeys(component.FLOATS, 0.0), **dict.fromkeys(component.BITS, False)}


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


class TestComponent(Case):
    def start(self, *words):
        self.hal = Hal()
        self.mill = Linuxcnc()
        made = component.Component(self.hal, self.mill, cli.parser().parse_args(words),
                                   self.said.append, driver=self.driver)
        self.add_cleanup(made.end)
        return made

    def turn(self, made):
        made.next_search = 0.0
        made.turn()
        return made.pins['connected']

    def test_pins(self):
        self.start()
        assert self.hal.is_ready
        assert {pin for pin, kind in self.hal.kinds.items() if kind == ('bit', 'out')} == \
                         {'connected', 'heartbeat'}

    def test_it_follows_the_pendant(self):
        made = self.start()
        assert not self.turn(made)
        made.pins['work-y'] = 7.25
        for name in ('0003:10CE:EB70.0001', '0003:10CE:EB70.0002'):
            path = self.plug(name)
            assert self.turn(made)
            assert self.get(path, 'position').split()[1] == '7.2500'
            shutil.rmtree(path)
            assert not self.turn(made)
        assert self.said == []

    def test_no_further_line_when_the_pendant_is_gone(self):
        """It has the key Stop."""
        made = self.start()
        path = self.plug()
        assert self.turn(made)
        made.pins['goto-zero'] = True
        assert self.turn(made)
        assert self.mill.asked == [3, 'G53 G0 Z0.0000000']
        shutil.rmtree(path)
        for _ in range(3):
            assert not self.turn(made)
        assert self.mill.asked == [3, 'G53 G0 Z0.0000000', 1]

    def test_heartbeat(self):
        made = self.start()
        beats = []
        for _ in range(4):
            made.turn()
            beats.append(made.pins['heartbeat'])
        assert beats == [True, False, True, False]

    def test_the_end(self):
        made = self.start()
        self.plug()
        assert self.turn(made)
        made.end()
        assert (made.pins['connected'], self.hal.ended) == (False, True)


    def test_whb04b(self):
        """Its rows are those of the axes that the selector is among."""
        made = self.start('--model', 'whb04b')
        assert 'step' not in made.pins
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
        for axis in 'abc':
            made.pins['select-' + axis] = True
            made.turn()
            assert self.get(path, 'rows') == '4.5000 5.5000 6.5000'
            made.pins['select-' + axis] = False
            made.turn()
            assert self.get(path, 'rows') == '1.5000 2.5000 3.5000'
        made.pins.update({'show-machine': True, 'reset': True})
        for mode in ('continuous', 'mpg', 'continuous'):
            made.pins['key-continuous'] = True
            made.turn()
            made.pins['key-continuous'] = False
            made.turn()
            assert self.get(path, 'mode')[:len(mode)] == mode
        assert self.get(path, 'rows') == '-1.0000 -2.0000 -3.0000'
        assert self.get(path, 'coordinates').startswith('machine')
        assert self.get(path, 'reset') == '1'
        assert self.said == []


class TestWheel:
    """The mode continuous: a jog as long as the wheel turns"""

    PINS = {**dict.fromkeys(whb04b.BITS, False), 'max-velocity': 50.0,
            'max-angular-velocity': 20.0, 'wheel': 7, 'rotary': 4}

    def made(self, mode='continuous'):
        made = whb04b.Wheel()
        made.mode = mode
        self.at(made)
        return made

    def at(self, made, now=0.0, works=True, **pins):
        """-> which pins that jog are on"""
        self.found = made.turn({**self.PINS, 'select-x': True,
                                **{name.replace('_', '-'): pins[name] for name in pins}},
                               works, now)
        return {name for name in whb04b.JOGS if self.found[name]}

    def test_as_long_as_it_turns(self):
        made = self.made()
        assert self.at(made, 1) == set()
        assert self.at(made, 2, wheel=8) == {'plus-x'}
        assert self.at(made, 2.2, wheel=8) == {'plus-x'}
        assert self.at(made, 2.2, wheel=9) == {'plus-x'}
        assert self.at(made, 2.44, wheel=9) == {'plus-x'}
        assert self.at(made, 2.46, wheel=9) == set()
        assert self.at(made, 3, wheel=7) == {'minus-x'}

    def test_turned_back_it_stops_first(self):
        made = self.made()
        assert self.at(made, 1, wheel=8) == {'plus-x'}
        assert self.at(made, 1.1, wheel=7) == set()
        assert self.at(made, 1.2, wheel=6) == {'minus-x'}

    def test_another_axis(self):
        made = self.made()
        assert self.at(made, 1, wheel=8) == {'plus-x'}
        assert self.at(made, 1.1, wheel=9, select_x=False, select_y=True) == set()
        assert self.at(made, 1.2, wheel=10, select_x=False, select_y=True) == {'plus-y'}

    @pytest.mark.parametrize('pins', [
        {'works': False}, {'select_x': False}, {'rotary': 7}, {'rotary': 0}, {'select_y': True}])
    def test_no_jog(self, pins):
        assert self.at(self.made(), 1, wheel=8, **pins) == set()

    @pytest.mark.parametrize('mode', ['step', 'mpg'])
    def test_other_modes(self, mode):
        assert self.at(self.made(mode), 1, wheel=8) == set()
        assert self.found['detents'] and self.found['mode-' + mode]
        assert not self.found['mode-continuous']

    @pytest.mark.parametrize('pins, speed', [
        ({}, 900), ({'rotary': 1}, 60), ({'rotary': 6}, 3000), ({'rotary': 7}, 0),
        ({'select_x': False, 'select_b': True}, 360), ({'select_x': False}, 0)])
    def test_speed(self, pins, speed):
        self.at(self.made(), **pins)
        assert self.found['jog-speed'] == speed
        assert not self.found['detents']

    def test_keys(self):
        """Not with Fn, not while nothing works, and once each time that one is pressed."""
        made = whb04b.Wheel()
        for pins, mode in (({'key_continuous': True}, 'step'), ({}, 'step'),
                           ({'key_continuous': True}, 'continuous'),
                           ({'key_continuous': True}, 'continuous'), ({}, 'continuous'),
                           ({'key_continuous': True, 'fn': True}, 'continuous'),
                           ({}, 'continuous'),
                           ({'key_continuous': True, 'works': False}, 'continuous'),
                           ({}, 'continuous'), ({'key_continuous': True}, 'mpg'),
                           ({'key_step': True}, 'step')):
            self.at(made, **pins)
            assert made.mode == mode


class TestSteps:
    @staticmethod
    def made(**texts):
        mill = Linuxcnc()
        mill.texts = {('XHC' if name == 'STEPS' else 'TRAJ', name): texts[name] for name in texts}
        with mock.patch.dict(os.environ, INI_FILE_NAME='mill.ini'):
            return steps.Steps(mill)

    @pytest.mark.parametrize('texts, lengths, unit', [
        ({}, (0.001, 0.01, 0.1, 1), 0.001), ({'LINEAR_UNITS': 'mm'}, (0.001, 0.01, 0.1, 1), 0.001),
        *(({'LINEAR_UNITS': name}, (0.0001, 0.001, 0.01, 0.1), 0.0001)
          for name in ('inch', 'in', 'Imperial')),
        ({'STEPS': '0.005 0.05'}, (0.005, 0.05), 0.001)])
    def test_lengths(self, texts, lengths, unit):
        made = self.made(**texts)
        assert (made.lengths, made.unit) == (lengths, unit)

    def test_keys(self):
        """Round and round, up and down, once for each press, and not while nothing works"""
        made = self.made()
        made.turn({'step-up': False, 'step-down': False}, True)
        for up, down, works, length in (
                (1, 0, True, 0.01), (1, 0, True, 0.01), (0, 0, True, 0.01), (1, 0, False, 0.01),
                (0, 0, True, 0.01), (0, 1, True, 0.001), (0, 0, True, 0.001), (0, 1, True, 1),
                (1, 0, True, 0.001)):
            assert made.turn({'step-up': up, 'step-down': down}, works) == length


class TestInput(Case):
    """halcmd is a status here, or None while it runs."""

    def set_up(self):
        self.hal = Hal()
        self.said = []
        self.started = []
        self.status = None
        self.now = 100.0
        self.input = hal_input.Input('file', self.hal, self.said.append)
        patches = (mock.patch.object(hal_input.subprocess, 'Popen', self.popen),
                   mock.patch.object(hal_input.time, 'monotonic', lambda: self.now))
        for patch in patches:
            patch.start()
            self.add_cleanup(patch.stop)

    def popen(self, words, **_):
        self.started.append(words)
        return types.SimpleNamespace(poll=lambda: self.status)

    def loaded(self):
        self.hal.existing.add('hal_input')
        self.status = 0

    def works(self, path, seconds=0.0):
        self.now += seconds
        return self.input.works_for(path)

    def test_without_a_pendant_nothing_is_started(self):
        assert not self.works(None)
        assert self.started == []

    def test_it_works_when_halcmd_has_ended(self):
        assert not self.works('a')
        self.hal.existing.add('hal_input')
        assert not self.works('a')
        self.loaded()
        assert self.works('a')
        assert self.works('a', 10)
        assert self.started == [['halcmd', '-f', 'file']]

    def test_another_pendant_waits_for_the_end_of_the_old_one(self):
        self.works('a')
        self.loaded()
        assert self.works('a')
        assert not self.works(None)
        assert not self.works('b', 5)
        assert len(self.started) == 1
        self.hal.existing.clear()
        self.status = None
        assert not self.works('b', 5)
        self.loaded()
        assert self.works('b')
        assert len(self.started) == 2

    def test_the_pendant_goes_while_halcmd_runs(self):
        self.works('a')
        assert not self.works(None)
        self.loaded()
        assert not self.works(None)
        assert not self.works('b')

    def test_not_at_once_when_hal_input_ends(self):
        """LinuxCNC may be about to end us, too."""
        self.works('a')
        self.loaded()
        self.works('a')
        self.hal.existing.clear()
        self.status = None
        for seconds, started in ((0, 1), (0.5, 1), (1, 2)):
            assert not self.works('a', seconds)
            assert len(self.started) == started

    def test_failure_is_said_once_and_tried_again(self):
        self.status = 1
        for _ in range(6):
            assert not self.works('a', 2)
        assert len(self.started) == 3
        assert self.said == ['halcmd -f file: status 1']
        self.works('a', 2)
        self.loaded()
        assert self.works('a')
        assert len(self.said) == 1

    def test_without_halcmd(self):
        with mock.patch.object(hal_input.subprocess, 'Popen', side_effect=FileNotFoundError(
                2, 'No such file or directory')):
            assert not self.works('a')
        assert self.said == ['halcmd -f file: No such file or directory']


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
        ((0, 800), 'G80'), ((0, 10), 'G53 G1 Z0'), ((0, 10, 910), 'G1 Z0')])
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
    def test_keys_are_those_of_the_model(self):
        captions = {'goto-zero': 'Goto zero', 'start': 'Start/Pause', 'safe-z': 'Safe-Z',
                    'step': 'STEP++', 'step-down': 'MPG/MODE', 'stop': 'Stop', 'reset': 'Reset',
                    'probe-z': 'Probe-Z', 'rewind': 'Rewind', 'zero': '0=',
                    'half': '1/2=', **{'macro-%d' % number: 'Macro %d' % number
                                       for number in (1, 2, 3, 6, 7)}}
        wired = re.findall(r'^net xhc\.key-(\S+) input\.0\.btn-trigger-happy(\d+)$',
                           product('xhc-input.hal'), re.M)
        assert {name: HB04.keys[int(code)] for name, code in wired} == captions

    def test_what_hal_input_has_left_is_cleared(self):
        """All it is wired to, but the counts"""
        text = product('xhc-input.hal')
        wired = re.findall(r'^net (\S+) input\.', text, re.M)
        cleared = re.findall(r'^sets (\S+) 0$', text, re.M)
        assert sorted(wired) == sorted(cleared + ['xhc.wheel'])
        assert text.index('net ') > text.rindex('sets ')
        assert set(wired) - set(re.findall(
            r'xhc\.\S+', product('xhc-jog.hal') + product('xhc-dro.hal'))) == set()

    def test_whb04b(self):
        """Keys, selector, what is cleared, and pins, as for the HB04"""
        text = product('xhc-whb04b-input.hal')
        captions = {
            'reset': 'Reset', 'stop': 'Stop', 'start': 'Start/Pause', 'feed-plus': 'Feed+',
            'feed-minus': 'Feed-', 'spindle-plus': 'Spindle+', 'spindle-minus': 'Spindle-',
            'm-home': 'M-Home', 'safe-z': 'Safe-Z', 'w-home': 'W-Home',
            'spindle': 'Spindle on/off', 'fn': 'Fn', 'probe-z': 'Probe-Z',
            'continuous': 'Continuous/MPG', 'step': 'Step', 'macro-10': 'Macro 10'}
        wired = dict(re.findall(r'^net xhc\.(\S+) input\.0\.btn-trigger-happy(\d+)$', text, re.M))
        assert {name: WHB04B.keys[int(code)] for name, code in wired.items()
                if name.startswith('key-')} == {'key-' + name: caption
                                                for name, caption in captions.items()}
        assert {name: code for name, code in wired.items() if name.startswith('select-')} == {
            'select-' + axis: str(30 + value) for axis, value in zip('xyzabc', (1, 2, 3, 4, 7, 8))}
        signals = re.findall(r'^net (\S+) input\.', text, re.M)
        cleared = re.findall(r'^sets (\S+) 0$', text, re.M)
        assert sorted(signals) == sorted(cleared + ['xhc.wheel'])
        assert set(signals) - set(re.findall(
            r'xhc\.\S+', product('xhc-whb04b-jog.hal') + product('xhc-whb04b-dro.hal'))) == set()
        pins = re.findall(r'xhc-dro\.(\S+)', product('xhc-whb04b-dro.hal'))
        assert sorted(pins) == sorted(
            set(whb04b.FLOATS + whb04b.BITS + component.RESULTS + component.KEYS +
                whb04b.LIMITS + whb04b.NUMBERS + whb04b.JOG_BITS + ('jog-speed',)) -
            {'show-machine', 'zero', 'half', 'rewind', 'macro-11', 'macro-12', 'mode-step',
             'mode-continuous'})

    def test_no_component_has_more_names_than_it_takes(self):
        for name in ('xhc-jog.hal', 'xhc-whb04b-jog.hal'):
            for line in re.findall(r'^loadrt \S+ names=(\S+)', product(name), re.M):
                names = line.split(',')
                assert len(names) <= 16
                for each in names:
                    assert re.search(r'^addf %s servo-thread$' % re.escape(each), product(name),
                                     re.M), each

    def test_every_input_pin_but_inch_is_wired(self):
        wired = re.findall(r'xhc-dro\.(\S+)', product('xhc-dro.hal'))
        assert sorted(wired) == sorted(
            set(component.FLOATS + component.BITS + component.RESULTS + component.KEYS +
                ('step',)) -
            {'inch'} - {'macro-%d' % number for number in (4, 5, *range(8, 17))})

    def test_no_key_runs_a_command_by_its_number(self):
        for name in os.listdir(PRODUCT):
            if name.endswith('.hal'):
                assert 'mdi-command' not in product(name)

    def test_steps_are_on_the_display(self):
        for unit, lengths in ((0.001, steps.MILLIMETRES), (0.0001, steps.INCHES)):
            shown = [display.multiplier(step, unit, list(STEPS.values())) for step in lengths]
            assert shown == ['1', '10', '100', '1000']

    def test_the_page_has_all_options_and_pins(self):
        page = product('xhc-dro.1')
        for action in cli.parser()._actions:
            for option in action.option_strings:
                assert 'Fl ' + option[1:] in page
        for pin in (component.FLOATS + component.BITS + component.RESULTS + whb04b.FLOATS +
                    whb04b.BITS + component.KEYS + whb04b.LIMITS + whb04b.NUMBERS +
                    whb04b.JOG_BITS + ('jog-speed',)):
            assert re.search(r'\b%s\b' % pin, page)
