# SPDX-License-Identifier: GPL-2.0-only
"""Debian's LinuxCNC with a WHB04B: the wheel moves the axis that the selector is at, the second
rotary changes the step, and the display's rows follow. See test_linuxcnc.py.
"""

import glob
import os
import shutil
import subprocess
import time

import case
from halcmd import USER, Halcmd
import rig
import test_linuxcnc
from test_linuxcnc import DIALOUT, ENVIRONMENT, HOME, NEAR, PATIENCE, is_at, is_true, pin, position

CONFIG = test_linuxcnc.CONFIG
INI = CONFIG + '/xhc-whb04b.ini'
AXES = 'xyzabc'
PINS = (*test_linuxcnc.PINS, 'xhc-dro.rotary', 'xhc-dro.step', 'xhc.on-a.and',
        'halui.axis.a.pos-feedback', 'halui.joint.5.is-homed', 'xhc-dro.mode-step',
        'xhc-dro.mode-continuous', 'xhc-dro.mode-mpg')

setup_module = test_linuxcnc.setup_module


def teardown_module():
    if Case.mill:
        Case.mill.end()
        Case.pendant.unplug()
    subprocess.run(['umount', '--lazy', '/tmp'], check=True)


class Mill(test_linuxcnc.Mill):
    def __init__(self):
        shutil.rmtree(HOME, ignore_errors=True)
        shutil.copytree(test_linuxcnc.COPY, CONFIG)
        with open(INI, encoding='ascii') as file:
            text = file.read()
        assert text.count('DISPLAY = axis') == 1
        with open(INI, 'w', encoding='ascii') as file:
            file.write(text.replace('DISPLAY = axis', 'DISPLAY = dummy'))
        subprocess.run(['chown', '-R', 'nobody:dialout', HOME], check=True)
        self.log = open(HOME + '/log', 'w+', encoding='utf-8', errors='replace')
        self.process = subprocess.Popen([*USER, 'linuxcnc', '-r', INI], env=ENVIRONMENT, cwd=HOME,
                                        stdin=subprocess.PIPE, stdout=self.log,
                                        stderr=subprocess.STDOUT)
        self.halcmd = None
        self.wait(lambda: 'DUMMY DISPLAY' in self.said())
        self.halcmd = Halcmd(env=ENVIRONMENT)

    def ready(self):
        """Out of the emergency stop, on, at home"""
        self.switch_on()
        self.home(5)


class Case(rig.Case):
    """All share one mill and one pendant."""

    mill = None
    pendant = None

    @classmethod
    def setup_class(cls):
        if Case.mill:
            return
        # its helpers ask the mill of the other file's class
        Case.mill = test_linuxcnc.Case.mill = Mill()
        Case.pendant = test_linuxcnc.Case.pendant = rig.Rig('WHB04B')
        pendant = Case.pendant.plug()
        for node in [pendant.event_node, *glob.glob(pendant.path + '/dro/*')]:
            if os.stat(node).st_mode & 0o200:
                os.chown(node, 0, DIALOUT)
                os.chmod(node, 0o660)
        pendant.device.wake()
        cls.mill.wait(lambda: is_true('xhc.ok.and'))
        cls.mill.ready()
        # a busy machine may be late; what a stop does is tested with the HB04
        test_linuxcnc.set_pin('xhc.alive.width', PATIENCE)
        test_linuxcnc.set_pin('xhc-dro.patience', PATIENCE)

    @property
    def device(self):
        return self.pendant.device

    def select(self, name):
        self.device.select(self.device.model.selector[name])
        for axis in AXES:
            self.mill.wait(lambda: is_true('xhc.on-%s.and' % axis) == (axis == name))
        self.finish_cycle()
        self.mill.wait(lambda: not is_true('xhc.off.or'))

    def finish_cycle(self):
        test_linuxcnc.Case.finish_cycle(self)

    def rotary(self, name, scale):
        self.device.turn_feed(self.device.model.feed[name])
        self.mill.wait(lambda: abs(float(pin('xhc-dro.step')) - scale) < 1e-9)
        self.finish_cycle()

    def assert_at(self, axis, wanted):
        def rests():
            return not is_true('motion.jog-is-active') and float(pin('motion.current-vel')) == 0

        self.mill.wait(lambda: is_at(axis, wanted) and rests())

    def press(self, name, done):
        """Holds a key, or Fn and a key, down until it has done its work."""
        codes = self.device.model.key_codes(name)
        for code in codes:
            self.device.press(code)
        self.mill.wait(done)
        for code in reversed(codes):
            self.device.release(code)
        self.mill.wait(lambda: not test_linuxcnc.keys_down())
        self.finish_cycle()

    def shows(self, **wanted):
        for name, value in wanted.items():
            assert self.device.wait_for(
                lambda: self.device.lcd and self.device.lcd.as_dict()[name] == value, PATIENCE), (
                    name, value, self.device.lcd and self.device.lcd.as_dict())


class TestWhb04b(Case):
    def test_the_wheel_moves_the_axis_and_the_rotary_is_the_step(self):
        for axis, name, step, detents in (('a', '10%', 0.1, 5), ('a', '30%', 1, -2),
                                          ('x', '2%', 0.001, 7), ('c', '60%', 5, 1),
                                          ('z', '5%', 0.01, -3), ('b', '100%', 10, 1)):
            self.rotary(name, step)
            self.select(axis)
            others = {other: position(other) for other in AXES if other != axis}
            start = position(axis)
            self.device.turn(detents)
            self.assert_at(axis, start + detents * step)
            assert all(is_at(other, place) for other, place in others.items())

    def test_the_rows_follow_the_selector(self):
        self.rotary('10%', 0.1)
        for axis, detents in (('y', 12), ('b', -7), ('y', 1)):
            self.select(axis)
            start = position(axis)
            self.device.turn(detents)
            self.assert_at(axis, start + detents * 0.1)
            rows = AXES[3:] if axis in AXES[3:] else AXES[:3]
            for row, each in enumerate(rows, 1):
                self.shows(**{'row%d' % row: '%.4f' % round(position(each), 4)})
        self.shows(coordinates='work', mode='step', reset=0, faults=[])

    def test_lead_moves_nothing(self):
        self.rotary('lead', 0)
        self.select('x')
        start = position('x')
        before = int(pin('xhc-dro.wheel'))
        self.device.turn(3)
        self.mill.wait(lambda: int(pin('xhc-dro.wheel')) == before + 3)
        self.finish_cycle()
        assert is_at('x', start)

    def test_mpg(self):
        self.press('Continuous/MPG', lambda: is_true('xhc-dro.mode-continuous'))
        self.press('Continuous/MPG', lambda: is_true('xhc-dro.mode-mpg'))
        self.add_cleanup(self.press, 'Step', lambda: is_true('xhc-dro.mode-step'))
        self.shows(mode='mpg')
        self.rotary('100%', 0.1)
        self.select('x')
        start = position('x')
        self.device.turn(2)
        self.mill.wait(lambda: abs(position('x') - start) > NEAR)

    def turn_on(self, detents, condition):
        def turned():
            self.device.turn(detents)
            return condition()

        self.mill.wait(turned)

    def rest(self, axis):
        """Until it has stopped: on a busy machine some detents come late, and move it once more."""
        def rests():
            place = position(axis)
            time.sleep(1)
            return position(axis) == place and not is_true('motion.jog-is-active')

        self.mill.wait(rests)

    def test_continuous(self):
        """As long as the wheel turns, with a part of the greatest velocity, and no longer."""
        self.press('Continuous/MPG', lambda: is_true('xhc-dro.mode-continuous'))
        self.add_cleanup(self.press, 'Step', lambda: is_true('xhc-dro.mode-step'))
        self.shows(mode='continuous')
        for axis, name, detents, percent in (('x', '30%', 1, 30), ('b', '10%', -1, 10),
                                             ('x', '5%', -1, 5)):
            with case.row(axis=axis, rotary=name, detents=detents):
                self.device.turn_feed(self.device.model.feed[name])
                self.select(axis)
                start = position(axis)
                self.turn_on(detents, lambda: abs(
                    float(pin('motion.current-vel')) - 50 * percent / 100) < 0.01)
                self.rest(axis)
                assert (position(axis) - start) * detents > 0
        self.turn_on(1, lambda: is_true('motion.jog-is-active'))
        self.select('y')
        self.rest('y')
        place = position('y')
        self.device.turn_feed(self.device.model.feed['lead'])
        self.mill.wait(lambda: int(pin('xhc-dro.rotary')) == 7)
        before = int(pin('xhc-dro.wheel'))
        self.device.turn(5)
        self.mill.wait(lambda: int(pin('xhc-dro.wheel')) == before + 5)
        self.assert_at('y', place)

    def test_feed_and_fn(self):
        """With Fn a key is a macro, and nothing else."""
        before = float(pin('halui.feed-override.value'))
        self.press('Feed+', lambda: abs(
            float(pin('halui.feed-override.value')) - before - 0.05) < NEAR)
        self.shows(feedrate_override=round(100 * before + 5))
        screen = test_linuxcnc.Screen()
        fn = {'Feed+': 1, 'Feed-': 2, 'Spindle+': 3, 'Spindle-': 4, 'M-Home': 5, 'Safe-Z': 6,
              'W-Home': 7, 'Spindle on/off': 8, 'Probe-Z': 9, 'Start/Pause': 13, 'Macro 10': 14,
              'Continuous/MPG': 15, 'Step': 16}
        screen.mdi('G53 G0 Z-3')
        for name, number in (('Macro 10', 10), *(('Fn+' + each, fn[each]) for each in fn)):
            said = []
            self.press(name, lambda: said or said.append(screen.message()))
            assert said == ['macro %d' % number]
            self.mill.wait(lambda: is_true('halui.mode.is-manual'))
        assert is_at('z', -3) and not is_true('halui.spindle.0.is-on')
        assert is_true('xhc-dro.mode-step')
        assert abs(float(pin('halui.feed-override.value')) - before - 0.05) < NEAR
        self.press('Feed-', lambda: abs(float(pin('halui.feed-override.value')) - before) < NEAR)

    def test_reset_is_on_the_display(self):
        self.press('Reset', lambda: is_true('halui.estop.is-activated'))
        self.shows(reset=1)
        self.mill.ready()
        self.shows(reset=0)
