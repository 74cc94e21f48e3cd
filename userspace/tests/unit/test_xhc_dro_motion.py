# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of keys and the wheel in xhc-dro: tables, steps, modes and macros."""

import os
from unittest import mock

import pytest
from planted_linuxcnc import Case, Linuxcnc
from xhc_dro import keys, macros, wheel


class TestKeys:
    TABLE = {1: ('reset', 'reset'), 3: ('start', 'macro-13'), 12: ('fn', 'fn'), 5: ('-', '-')}

    def test_fn(self):
        """The function of a key does not change until it is released."""
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
    def made(has_rotary=True, mode='step', filtered='', **texts):
        mill = Linuxcnc()
        sections = {'LINEAR_UNITS': 'TRAJ', 'MAX_VELOCITY': 'AXIS_Y'}
        mill.texts = {(sections.get(name, 'XHC'), name): text for name, text in texts.items()}
        with mock.patch.dict(os.environ, INI_FILE_NAME='mill.ini'):
            made = wheel.Wheel(mill, has_rotary, filtered)
        made.mode = mode
        return made

    def at(self, made, now=0.0, detents=0, axis='x', rotary=4, limits=(50.0, 20.0)):
        """-> the jog pins that are on"""
        self.found = made.turn(detents, axis, rotary, limits, now)
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
        ({'filtered': 'xz'}, 'z', 0.001), ({'filtered': 'y', 'SCALE_Y': '-1'}, 'y', -0.001),
        # filters are selected by xhc.tcl, which reads the ini in another way
        ({'FILTER': '0.1'}, 'x', 1)])
    def test_scale(self, texts, axis, length):
        self.at(self.made(**texts))
        assert self.found['step'] == 1
        assert self.found['step-' + axis] == pytest.approx(length)

    @pytest.mark.parametrize('rotary, step, mpg, inches, mpg_inches', [
        (1, 0.001, 0.002, 0.001, 0.00008), (2, 0.01, 0.005, 0.01, 0.0002),
        (3, 0.1, 0.01, 0.1, 0.0004), (4, 1, 0.03, 0, 0.0012), (5, 5, 0.06, 0, 0.0024),
        (6, 10, 0.1, 0, 0.004), (7, 0, 0, 0, 0), (0, 0, 0, 0, 0)])
    def test_rotary(self, rotary, step, mpg, inches, mpg_inches):
        """In an inch machine no detent moves farther than 0.1 inches; degrees stay degrees."""
        for unit, mode, length, angle in (('mm', 'step', step, step), ('mm', 'mpg', mpg, mpg),
                                          ('inch', 'step', inches, step),
                                          ('inch', 'mpg', mpg_inches, mpg)):
            for axis, wanted in (('x', length), ('b', angle)):
                self.at(self.made(mode=mode, LINEAR_UNITS=unit), axis=axis, rotary=rotary)
                assert self.found['step'] == pytest.approx(wanted)
                assert self.found['step-x'] == pytest.approx(length)
                assert self.found['step-b'] == pytest.approx(angle)

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

    @pytest.mark.parametrize('mode, presses', [('step', 1), ('mpg', 1), ('continuous', 2)])
    def test_another_mode(self, mode, presses):
        """Detents turned in one mode move nothing in the next."""
        made = self.made(mode=mode)
        self.at(made, 1, 1)
        for _ in range(presses):
            made.press('mode')
        assert made.mode == 'continuous'
        assert self.at(made, 1.1) == set()
        assert self.at(made, 1.2, 1) == {'plus-x'}

    @pytest.mark.parametrize('at', [{'axis': None}, {'rotary': 7}, {'rotary': 0}])
    def test_no_jog(self, at):
        """Neither at that time nor later"""
        made = self.made(mode='continuous')
        assert self.at(made, 1, 1, **at) == set()
        assert self.at(made, 1.1) == set()

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

    @pytest.mark.parametrize('limits, axis, speed', [
        ((50, 0), 'y', 3000), ((0, 0), 'y', 1800), ((0, 0), 'x', 0)])
    def test_speed_of_the_axis(self, limits, axis, speed):
        """[AXIS_Y]MAX_VELOCITY is for an ini without MAX_LINEAR_VELOCITY."""
        self.at(self.made(mode='continuous', MAX_VELOCITY='30'), axis=axis, rotary=6, limits=limits)
        assert self.found['jog-speed'] == speed

    def test_speed_without_a_rotary(self):
        """Proportional to the position of the step among all steps"""
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
        ('safe-z', None, {'interp_state': 2}, 'a program is running'),
        ('safe-z', None, {'task_mode': 2}, 'not in auto mode'),
        ('zero', 'X', {'homed': (1, 0, 1)}, 'the machine is not homed'),
        ('macro-1', None, {'inpos': False}, 'the machine is moving'),
        ('macro-2', None, {}, '[XHC]MACRO_2 is not in the ini'),
        ('zero', None, {}, 'no axis is selected'), ('zero', 'A', {}, 'no axis is selected'),
        ('safe-z', None, {'axis_mask': 3}, 'the machine has no axis Z'),
        ('goto-zero-selected', None, {}, 'no axis is selected'),
        ('goto-zero-a', None, {}, 'the machine has no axis A'),
        ('zero-b', 'X', {}, 'the machine has no axis B'),
        *(('goto-zero', None, {'gcodes': (0, 0, code)},
           'not with cutter compensation (G41, G42)') for code in (410, 411, 420, 421))])
    def test_refused(self, name, axis, state, reason):
        assert self.asked(name, axis, **state) == ['pendant: %s: %s' % (name, reason)]

    def test_another_runs(self):
        mill = Linuxcnc()
        made = self.made(mill)
        made.start('goto-zero')
        made.start('safe-z')
        assert mill.asked == [3, 'pendant: safe-z: another macro is running']

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
