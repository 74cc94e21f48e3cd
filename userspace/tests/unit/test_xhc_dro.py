# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xhc-dro with a simulated HAL and sysfs: finding a pendant, messages; and that its
HAL files, tables, page and the layouts agree.
"""

import errno
import os
import re
import shutil
import sys
import time
from unittest import mock

import pytest
from planted_linuxcnc import PRODUCT, Case, Hal, Linuxcnc
from xhc_dro import cli, component, display, keys, macros, wheel
from xhc_sim.models import STEPS


def product(name):
    with open(os.path.join(PRODUCT, name), encoding='utf-8') as file:
        return file.read()


class Hands:
    """A replacement of Events: operation of a pendant"""

    def __init__(self):
        self.down = set()
        self.selector = 0
        self.rotary = 0
        self.detents = 0
        self.was_touched = set()
        self.trouble = None
        self.paths = []             # of opened nodes
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

    def touched(self):
        return self.was_touched | self.down

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
        """-> the pins of keys and selector that are on"""
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
        """Two pendants: the wheel of the other one is not read, its display is not written."""
        first = self.plug()
        second = self.plug('0003:10CE:EB70.0002', 'usb-2/input0')
        made = self.start('--phys', 'usb-2/input0')
        made.pins['velocity'] = 2
        assert self.turn(made)
        assert self.hands.paths == [second]
        assert (self.get(first, 'feedrate'), self.get(second, 'feedrate')) == ('', '120')

    @pytest.mark.parametrize('model, used', [('hb04', 0), ('whb04b', 1)])
    def test_of_the_model(self, model, used):
        paths = self.plug(), self.plug('0003:10CE:EB93.0002', 'usb-2/input0')
        assert self.turn(self.start('--model', model))
        assert self.hands.paths == [paths[used]]

    def test_what_it_was_is_gone_with_it(self):
        """Keys, selector and jogs, for any order in which the kernel removes its nodes"""
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
        """Except for those that stop"""
        made = self.start()
        self.plug()
        self.hands.down, self.hands.selector = {2, 22}, 3
        for _ in range(2):
            assert self.turn(made) and self.on() == {'key-stop', 'select-z'}
        self.hands.down = set()
        time.sleep(component.SHORTEST)
        self.turn(made)
        assert self.on() == {'select-z'}
        self.hands.down = {2}
        self.turn(made)
        assert self.on() == {'key-start', 'select-z'}

    def test_the_screen_names_the_loss(self):
        """Once, and not for a pendant that was never plugged in"""
        made = self.start()
        self.turn(made)
        path = self.plug()
        self.turn(made)
        assert self.mill.asked == []
        shutil.rmtree(path)
        for _ in range(2):
            self.turn(made)
        assert self.mill.asked == ['pendant: unplugged']
        self.plug()
        self.turn(made)
        assert len(self.mill.asked) == 1

    def test_the_loss_stops_before_it_is_reported(self):
        """LinuxCNC may take seconds to accept a message."""
        made = self.start(MODE='continuous')
        path = self.plug()
        self.hands.selector = self.hands.detents = 1
        assert self.turn(made) and made.pins['plus-x']
        shutil.rmtree(path)
        pins = {}
        with mock.patch.object(self.mill, 'error_msg', lambda text: pins.update(made.pins)):
            self.turn(made)
        assert {pins[name] for name in ('connected', 'plus-x', 'select-x')} == {False}

    def test_a_macro_is_refused_after_the_pins(self):
        made = self.start(MODE='continuous')
        self.plug()
        self.hands.selector = self.hands.detents = 1
        self.mill.now.inpos = False
        assert self.turn(made) and made.pins['plus-x']
        self.hands.selector, self.hands.down = 2, {1}
        pins = {}
        with mock.patch.object(self.mill, 'error_msg', lambda text: pins.update(made.pins)):
            self.turn(made)
        assert not pins['plus-x'] and pins['select-y']

    def test_a_loss_while_linuxcnc_ends(self):
        made = self.start()
        path = self.plug()
        self.turn(made)
        shutil.rmtree(path)
        with mock.patch.object(self.mill, 'error_msg', side_effect=Linuxcnc.error('no channel')):
            assert not self.turn(made)
        assert self.said == ['no channel']

    @pytest.mark.parametrize('coordinates, settings, position, selected, first', [
        ('X Y Z A', {}, 4, 'a', '4.5000'), ('xyza', {}, 1, 'x', '1.5000'),
        ('XYZ', {}, 4, 'a', '1.5000'), ('X Y Z B', {}, 4, 'b', '5.5000'),
        ('xzc', {}, 4, 'c', '6.5000'), ('XYZABC', {}, 4, 'a', '4.5000'),
        ('XYZBC', {'SELECTOR_A': 'C'}, 4, 'c', '6.5000'),
        ('XYZABC', {'SELECTOR_A': 'b'}, 4, 'b', '5.5000'),
        ('XYZABC', {'SELECTOR_A': 'b'}, 2, 'y', '1.5000')])
    def test_the_fourth_axis(self, coordinates, settings, position, selected, first):
        """Of an HB04, at A of its selector; it has rows for three axes: the fourth replaces X."""
        made = self.start(COORDINATES=coordinates, **settings)
        path = self.plug()
        for number, axis in enumerate('xyzabc', 1):
            made.pins['work-' + axis] = made.pins['machine-' + axis] = number + 0.5
        self.hands.selector, self.hands.detents = position, 3
        self.turn(made)
        assert self.on() == {'select-' + selected}
        assert {axis for axis in 'xyzabc' if made.pins['wheel-' + axis]} == {selected}
        rows = self.get(path, 'position').split()
        assert rows == [first, '2.5000', '3.5000'] * 2

    @pytest.mark.parametrize('name', ['D', 'X', 'B', 'AC', ''])
    def test_a_fourth_axis_that_is_none(self, name):
        with pytest.raises(ValueError, match=r'\[XHC\]SELECTOR_A: .* is none of A C'):
            self.start(COORDINATES='XYZAC', SELECTOR_A=name or ' ')

    @pytest.mark.parametrize('product_id, model, on', [
        ('EB70', None, {'select-a'}), ('EB6E', None, set()), ('EB00', 'HB03', set())])
    def test_the_speed_of_an_hb03(self, product_id, model, on):
        """It is at the position of A on an HB04, and must not move A."""
        made = self.start(COORDINATES='XYZA', MODE='continuous')
        self.plug('0003:10CE:%s.0001' % product_id, model=model)
        self.hands.selector, self.hands.detents = 4, 1
        self.turn(made)
        assert self.on() == on and made.pins['plus-a'] == bool(on)

    def test_a_late_round(self):
        """Operation of the pendant in the meantime has no effect."""
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

    @pytest.mark.parametrize('place', ['there', 'read'])
    def test_a_round_that_is_held_up(self, place):
        """Delayed before it reads what was turned in the meantime; the next round works."""
        with mock.patch.object(component.time, 'monotonic') as clock:
            clock.return_value = 100.0
            made = self.start()
            self.plug()
            self.turn(made)
            self.hands.detents, self.hands.down = 50, {2}
            of = {'there': made.display, 'read': self.hands}[place]
            at_once = getattr(of, place)

            def late():
                clock.return_value = 101.0
                return at_once()

            with mock.patch.object(of, place, late):
                self.turn(made)
            assert made.pins['wheel'] == 0 and self.on() == set()
            self.hands.detents, self.hands.down = 2, set()
            assert self.turn(made) and made.pins['wheel'] == 2

    def test_stop_in_a_late_round(self):
        """It is the only key that works, even if it was released in the meantime."""
        with mock.patch.object(component.time, 'monotonic') as clock:
            clock.return_value = 100.0
            made = self.start()
            self.plug()
            self.turn(made)
            clock.return_value += 1
            self.hands.was_touched = {2, 22}
            self.turn(made)
            assert self.on() == {'key-stop'}
            self.hands.was_touched = set()
            clock.return_value += component.SHORTEST
            self.turn(made)
            assert self.on() == set()

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

    def test_counts_are_those_of_the_selected(self):
        """Components connected to them, for example a filter, move no other axis."""
        made = self.start()
        self.plug()
        for selector, name in enumerate((None, *component.SELECTOR)):
            self.hands.selector, self.hands.detents = selector, 3
            self.turn(made)
            assert {each for each in component.SELECTOR if made.pins['wheel-' + each]} == (
                {name} if name else set())
            if name:
                assert made.pins['wheel-' + name] == 3
                made.pins['wheel-' + name] = 0

    def test_no_counts_of_an_axis_in_the_mode_continuous(self):
        made = self.start(MODE='continuous')
        self.plug()
        for selector, counts in ((1, 0), (5, 2)):
            self.hands.selector, self.hands.detents = selector, 2
            self.turn(made)
            assert made.pins['wheel-' + component.SELECTOR[selector - 1]] == counts

    def test_steps(self):
        """Two keys of an HB04, and a scale of an axis"""
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

    def test_filtered(self):
        made = self.start('--filtered', 'yz')
        self.plug()
        self.turn(made)
        assert [made.pins['step-' + axis] for axis in 'xyz'] == [0.001, 1e-6, 1e-6]
        assert '{*}$phys {*}$filtered' in product('xhc.tcl')

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
        assert self.mill.asked == [3, 'G53 G0 Z0.0000000', 1, 'pendant: unplugged']

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

    def test_a_table_of_nothing(self):
        """No key has a function then, instead of the default."""
        self.put(self.driver + '/mine.keys', '# none\n')
        made = self.start(KEYS='mine.keys')
        self.plug()
        self.turn(made)
        self.hands.down = {2, 22}
        self.turn(made)
        assert self.on() == set()

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

    def test_a_short_press_is_long_enough(self):
        """For halui, which polls every 20 ms, and less often while it waits for LinuxCNC"""
        with mock.patch.object(component.time, 'monotonic') as clock:
            clock.return_value = 100.0
            made = self.start()
            self.plug()
            self.turn(made)
            for later, down, on in ((0, {22}, {'key-stop'}), (0.02, set(), {'key-stop'}),
                                    (0.07, set(), {'key-stop'}), (0.02, set(), set())):
                clock.return_value += later
                self.hands.down = down
                self.turn(made)
                assert self.on() == on

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
        """Its rows show the group of axes with the selected one."""
        made = self.start('--model', 'whb04b')
        path = os.path.join(self.driver, '0003:10CE:EB93.0001')
        os.makedirs(path + '/dro')
        for attribute in ('rows', 'mode', 'coordinates', 'reset', 'feedrate_override',
                          'spindle_override'):
            self.put(path + '/dro/' + attribute, '')
        self.put(path + '/model', 'WHB04B\n')
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
        """-> exit status, messages"""
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

    @pytest.mark.parametrize('name, text, message', [
        ('KEYS', 'none.keys', '[XHC]KEYS: none.keys: No such file or directory'),
        ('MODE', 'fast', '[XHC]MODE is fast, and none of step, continuous, mpg'),
        ('STEPS', '0,005', '[XHC]STEPS: 0,005 is not a number'),
        ('STEPS', '0.1 nan', '[XHC]STEPS: nan is not a number'),
        ('STEPS', 'inf', '[XHC]STEPS: inf is not a number'),
        ('STEPS', '0.1 0', '[XHC]STEPS: a step must be above 0'),
        ('STEPS', '-0.1', '[XHC]STEPS: a step must be above 0'),
        ('SCALE', 'nan', '[XHC]SCALE: nan is not a number'),
        ('SCALE_Z', '-inf', '[XHC]SCALE_Z: -inf is not a number')])
    def test_an_ini_that_is_wrong(self, name, text, message):
        with mock.patch.dict(os.environ, INI_FILE_NAME='/dev/null'):
            assert self.main(texts={('XHC', name): text}) == (1, [message])

    @pytest.mark.parametrize('name', ['KEYS', 'MODE', 'STEPS', 'SCALE', 'SCALE_X', 'SELECTOR_A',
                                      'PROBE_Z', 'REWIND', 'MACRO_12'])
    def test_a_second_section(self, name, tmp_path):
        """xhc-dro reads only the first of the name; xhc.tcl reads FILTER and others from all."""
        ini = tmp_path / 'mill.ini'
        ini.write_text('[XHC]\n%s = 1\n[TRAJ]\n%s = 2\n [XHC] # more\nFILTER = 0.1\nPHYS = x\n'
                       '#%s = 3\n' % (name, name, name), encoding='ascii')
        with mock.patch.dict(os.environ, INI_FILE_NAME=str(ini)):
            assert self.main() == (0, [])
            with ini.open('a', encoding='ascii') as file:
                file.write(' %s=4\n' % name)
            assert self.main() == (1, [
                '[XHC]%s is in a second section [XHC]: move it to the first' % name])


class TestFiles(Case):
    # By caption; keys that are in no table are left to the user.
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
        if name == 'whb04b':        # these have their functions with Fn, too
            wanted.update({1: ('reset', 'reset'), 2: ('stop', 'stop')})
        assert keys.shipped()[name] == wanted

    def test_every_name_does_something(self):
        """By MDI, by the wheel, or by a net of xhc-jog.hal"""
        wired = re.findall(r'^net xhc\.key-(\S+) xhc-dro\.key-\1$', product('xhc-dro.hal'), re.M)
        assert set(re.findall(r'xhc\.key-(\S+)', product('xhc-jog.hal'))) == set(wired)
        others = {'step-up', 'step-down', 'step', 'mode', 'fn', *macros.ACTIONS, *macros.OWNERS}
        assert set(keys.names(keys.shipped().values())) - others == set(wired)

    def test_every_pin_is_wired(self):
        """Except those for a custom display, and those that are not for HAL files"""
        wired = {name for name in re.findall(r'xhc-dro\.(\S+)', product('xhc-dro.hal'))
                 if not name.startswith('key-')}
        assert wired == set(component.FLOATS_IN + component.BITS_IN + component.BITS_OUT +
                            component.FLOATS_OUT + component.NUMBERS_OUT) - {
            'wheel', 'inch', 'show-machine', 'max-velocity', 'max-angular-velocity', 'patience',
            'step', 'rotary', 'mode-step', 'mode-continuous'}

    def test_each_input_has_counts_of_its_own(self):
        jog = product('xhc-jog.hal')
        for name in wheel.AXES:
            assert re.search(r'^net xhc\.wheel-%s => axis\.%s\.jog-counts joint\.\d\.jog-counts$' %
                             (name, name), jog, re.M)
        assert 'net xhc.wheel-feed => halui.feed-override.counts\n' in jog
        assert 'net xhc.wheel-spindle => halui.spindle.0.override.counts\n' in jog
        assert not re.search(r'xhc\.wheel(?!-)', jog + product('xhc-dro.hal') + product('xhc.tcl'))

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
