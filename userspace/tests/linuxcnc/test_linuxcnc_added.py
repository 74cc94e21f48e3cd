# SPDX-License-Identifier: GPL-2.0-only
"""A pendant added by one HALFILE line to configurations that others made: Debian's samples, and
those that its stepconf and pncconf write. The wheel moves the joints before homing, and the axes
afterwards. And what [XHC] of the ini changes. See test_linuxcnc.py.
"""

import os
import re
import shutil
import subprocess
import sys
import time

import pytest

from case import row
from halcmd import USER, Halcmd
import rig
from rig import find
import test_linuxcnc
from test_linuxcnc import ENVIRONMENT, HOME, NEAR, PATIENCE, is_true, pin

SAMPLES = '/usr/share/doc/linuxcnc/examples/sample-configs/sim'
with open(os.path.join(os.path.dirname(os.path.realpath(__file__)), 'wizard.py'),
          encoding='ascii') as wizard_file:
    WIZARD = wizard_file.read()     # see setup_module
CONFIG = HOME + '/machine'
ADDED = 'HALFILE = %s/xhc-%%s.tcl\n' % test_linuxcnc.COPY
XYZ = {'x': (0,), 'y': (1,), 'z': (2,)}
XYZAC = {**XYZ, 'a': (3,), 'c': (5,)}      # that sample locks B
SECOND = 'usb-of-the-second/input0'
# Instead of a screen: runs the POSTGUI_HALFILEs as Axis does, then waits like the display `dummy`
POSTGUI_DISPLAY = '''#!/bin/sh -e
number=1
while file=$(inivar -ini "$INI_FILE_NAME" -sec HAL -var POSTGUI_HALFILE -num $number); do
	case $file in
	*.tcl)	haltcl -i "$INI_FILE_NAME" "$file" ;;
	*)	halcmd -i "$INI_FILE_NAME" -f "$file" ;;
	esac
	number=$((number + 1))
done
echo DUMMY DISPLAY
read -r line
'''

setup_module = test_linuxcnc.setup_module


def teardown_module():
    subprocess.run(['umount', '--lazy', '/tmp'], check=True)


def written_by(wizard):
    """-> the folder of a configuration by stepconf or pncconf"""
    home = '/run/' + wizard
    shutil.rmtree(home, ignore_errors=True)
    os.makedirs(home)
    subprocess.run([sys.executable, '-c', WIZARD, wizard], env={**ENVIRONMENT, 'HOME': home},
                   cwd=home, check=True)
    return home + '/linuxcnc/configs/mill'


class Machine(test_linuxcnc.Mill):
    """LinuxCNC with a copy of `folder`, whose `ini` gets one line more: a HALFILE; or, if the owner
    has a POSTGUI_HALFILE with the lines `postgui`, another of these after it.
    """

    def __init__(self, folder, ini, more='', model='hb04', postgui=None):
        shutil.rmtree(HOME, ignore_errors=True)
        shutil.copytree(folder, CONFIG, ignore_dangling_symlinks=True)
        line = ADDED % model
        if postgui is not None:
            line = 'POSTGUI_HALFILE = postgui.hal\nPOSTGUI_' + line
            with open(CONFIG + '/postgui.hal', 'w', encoding='ascii') as file:
                file.write(postgui)
            with open(CONFIG + '/display', 'w', encoding='ascii') as file:
                file.write(POSTGUI_DISPLAY)
            os.chmod(CONFIG + '/display', 0o755)
        with open(CONFIG + '/more.hal', 'w', encoding='ascii') as file:
            file.write(more)
        path = '%s/%s' % (CONFIG, ini)
        with open(path, encoding='utf-8') as file:
            text = file.read()
        text = re.sub(r'(?m)^ *DISPLAY *=.*',
                      'DISPLAY = ' + ('dummy' if postgui is None else './display'), text)
        text = re.sub(r'(?m)^ *(POSTGUI_HALFILE|APP) *=.*', '', text)
        # hal_manualtoolchange ends at once without a screen, at times before it is wired
        text = re.sub(r'(?m)^( *HALFILE *= *LIB:basic_sim.tcl) *$',
                      r'\1 -no_use_hal_manualtoolchange', text)
        text = re.sub(r'(?m)^ *HALFILE *= *axis_manualtoolchange.hal *\n', '', text)
        # of which LinuxCNC lets no wheel move one before homing
        self.homed_together = {int(number) for number in re.findall(
            r'(?m)^ *\[JOINT_(\d+)\](?:\n(?! *\[).*)*?\n *HOME_SEQUENCE *= *-', text)}
        last = [match.end() for match in re.finditer(r'(?m)^ *HALFILE *=.*\n', text)][-1]
        with open(path, 'w', encoding='utf-8') as file:
            file.write(text[:last] + 'HALFILE = more.hal\n' + line + text[last:])
        subprocess.run(['chown', '-R', 'nobody:dialout', HOME], check=True)
        self.log = open(HOME + '/log', 'w+', encoding='utf-8', errors='replace')
        environment = {**ENVIRONMENT, 'PATH': '%s:%s' % (test_linuxcnc.COPY, ENVIRONMENT['PATH'])}
        self.process = subprocess.Popen([*USER, 'linuxcnc', '-r', path], env=environment, cwd=HOME,
                                        stdin=subprocess.PIPE, stdout=self.log,
                                        stderr=subprocess.STDOUT)
        self.halcmd = None
        self.wait(lambda: self.process.poll() is not None or 'DUMMY DISPLAY' in self.said())
        if self.process.poll() is None:
            self.halcmd = Halcmd(env=environment)

    @classmethod
    def of_our_own(cls, more='', settings='', postgui=None, **texts):
        """The simulated mill without a pendant, and without halui; with `settings` in [XHC]"""
        folder = '/run/own'
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(test_linuxcnc.COPY, folder)
        with open(folder + '/xhc-hb04.ini', encoding='ascii') as file:
            text = file.read()
        for old, new in (('HALFILE = xhc-hb04.tcl\n', ''), ('HALUI = halui\n', ''),
                         ('[XHC]\n', '[XHC]\n' + settings), *texts.items()):
            assert text.count(old) == 1
            text = text.replace(old, new)
        with open(folder + '/xhc-hb04.ini', 'w', encoding='ascii') as file:
            file.write(text)
        return cls(folder, 'xhc-hb04.ini', more, postgui=postgui)


class Case(test_linuxcnc.Case):
    @classmethod
    def setup_class(cls):
        """Each case has its own machine."""

    def set_up(self):
        rig.Case.set_up(self)

    def start(self, machine, pendant=None):
        assert machine.halcmd, machine.said()
        # its helpers ask the mill of the other file's class
        Case.mill = test_linuxcnc.Case.mill = machine
        Case.pendant = test_linuxcnc.Case.pendant = pendant or rig.Rig()
        self.add_cleanup(self.end)
        self.come()
        self.be_patient()

    def select(self, name):
        super().select(name)
        for axis in 'abc':
            self.mill.wait(lambda: is_true('xhc.on-%s.and' % axis) == (name == axis))

    def moves(self, axis, pins, length=0.1):
        """The wheel moves these pins by this for each detent, and no other joint"""
        self.select(axis)
        joints = ['joint.%d.pos-fb' % number for number in range(9)
                  if not self.missing('joint.%d.pos-fb' % number)]
        watched = {*pins, *joints}
        before = {name: float(pin(name)) for name in watched}
        detents = -3 if axis == 'z' else 3      # Z may be at its top
        self.turn(detents)

        def came():
            way = {name: float(pin(name)) - before[name] for name in watched}
            return all(abs(way[name] - (length * detents if name in pins else 0)) < 1e-3
                       for name in watched)

        self.mill.wait(came)
        self.select('off')

    @staticmethod
    def missing(name):
        return test_linuxcnc.seen([name])[name] is None

    def works(self, joints, step='0.001'):
        """`joints`: {axis: numbers}; `step`: the first of an HB04"""
        self.mill.switch_on()
        if step:
            assert pin('xhc-dro.step') == step
            self.step('0.1')
        for axis, numbers in joints.items():
            if not self.mill.homed_together & set(numbers):
                with row(axis=axis):
                    self.moves(axis, {'joint.%d.pos-fb' % number for number in numbers})
        last = max(number for numbers in joints.values() for number in numbers)
        self.mill.home(last)
        for axis, numbers in joints.items():
            with row(homed=axis):
                self.moves(axis, {'joint.%d.pos-fb' % number for number in numbers})


class TestAdded(Case):
    @pytest.mark.parametrize('name, joints', [
        ('axis/axis_mm.ini', XYZ), ('axis/axis.ini', XYZ), ('axis/minimal_xyz.ini', XYZ),
        ('axis/axis_9axis.ini', {**XYZ, 'a': (3,)}), ('gmoccapy/gmoccapy.ini', XYZ),
        ('axis/wrapped_rotary/wrapped_rotary.ini', {**XYZ, 'a': (3,)}),
        ('axis/lathe.ini', {'x': (0,), 'z': (1,)}),
        ('axis/gantry/gantry_mm.ini', {'x': (0,), 'y': (1, 2), 'z': (3,)})])
    def test_samples(self, name, joints):
        folder, _, ini = name.rpartition('/')
        self.start(Machine(SAMPLES + '/' + folder, ini))
        millimetres = ini in ('axis_mm.ini', 'gmoccapy.ini', 'gantry_mm.ini', 'wrapped_rotary.ini')
        self.works(joints, '0.001' if millimetres else '0.0001')

    @pytest.mark.parametrize('name, step', [('stepconf', '0.001'), ('pncconf', '0.0001')])
    def test_wizard(self, name, step):
        self.start(Machine(written_by(name), 'mill.ini'))
        self.works(XYZ, step)

    def whb04b(self, machine, joints):
        """The second rotary has the step."""
        pendant = rig.Rig('WHB04B')
        self.start(machine, pendant)
        pendant.device.turn_feed(pendant.device.model.feed['10%'])
        self.mill.wait(lambda: pin('xhc-dro.step') == '0.1')
        self.works(joints, None)

    @pytest.mark.parametrize('name', ['stepconf', 'pncconf'])
    def test_whb04b_and_wizard(self, name):
        """pncconf links pins of halui to signals that nothing writes."""
        self.whb04b(Machine(written_by(name), 'mill.ini', model='whb04b'), XYZ)

    @pytest.mark.parametrize('name, joints', [('axis/axis_9axis.ini', XYZAC),
                                              ('axis/lathe.ini', {'x': (0,), 'z': (1,)})])
    def test_whb04b_and_samples(self, name, joints):
        folder, _, ini = name.rpartition('/')
        self.whb04b(Machine(SAMPLES + '/' + folder, ini, model='whb04b'), joints)

    def test_other_kinematics(self):
        """Two motors move X and Y together: nothing moves before homing, and then the axis."""
        self.start(Machine.of_our_own(**{'KINEMATICS = trivkins': 'KINEMATICS = corexykins'}))
        self.mill.switch_on()
        self.step('0.1')
        self.select('x')
        self.before = int(pin('xhc-dro.wheel'))
        self.turn(3)
        self.counted(3)
        self.finish_cycle()
        assert all(float(pin('joint.%d.pos-fb' % number)) == 0 for number in range(3))
        self.mill.home(2)
        self.moves('x', {'joint.0.pos-fb', 'joint.1.pos-fb'})

    def test_what_is_wired_already(self):
        machine = Machine.of_our_own(
            'net mpg iocontrol.0.tool-prep-number => axis.x.jog-counts\n')
        assert find.wait(lambda: machine.process.poll() is not None, PATIENCE)
        assert 'axis.x.jog-counts is already connected to the signal mpg' in machine.said()

    def test_after_the_screen(self):
        """POSTGUI_HALFILEs of Debian's samples link these pins; ours is the last of them."""
        names = {'halui.program.is-paused': 'E:paused', 'halui.program.is-idle': 'enable-buttons',
                 'halui.estop.is-activated': 'estop', 'spindle.0.speed-out': 'spindle-speed-cmd',
                 'motion.current-vel': 'thc-cur-vel', 'halui.feed-override.value': 'fo-value',
                 'halui.spindle.0.override.value': 'so-value'}
        self.start(Machine.of_our_own(
            postgui=''.join('net %s %s\n' % (name, each) for each, name in names.items()),
            **{'HALFILE = xhc-sim-mill.hal\n': 'HALFILE = xhc-sim-mill.hal\nHALUI = halui\n'}))
        wired = self.mill.halcmd.run('show pin')
        for each, name in names.items():
            assert re.search(r'%s ==> %s\b' % (re.escape(each), re.escape(name)), wired)
        self.works(XYZ)

    def test_what_is_loaded_already(self):
        machine = Machine.of_our_own('loadrt edge names=mine\n')
        assert find.wait(lambda: machine.process.poll() is not None, PATIENCE)
        assert 'another HAL file loads edge: add these names there' in machine.said()


class TestSettings(Case):
    def test_scale_filter_and_acceleration(self):
        """Also in a second section [XHC], which only HAL reads"""
        self.start(Machine.of_our_own(settings=(
            'SCALE_X = -2\n[XHC]\nFILTER = 0.02\nFILTER_Y = 0.5\nACCELERATION_Z = 0.25\n'
            '[DISPLAY]\nMAX_ANGULAR_VELOCITY = 30\n')))
        # as stepconf writes it, which has none in [TRAJ]
        assert float(pin('xhc-dro.max-angular-velocity')) == 30
        assert float(pin('xhc-dro.max-velocity')) == 50
        for name, value in (('axis.z.jog-accel-fraction', 0.25), ('axis.x.jog-accel-fraction', 1),
                            ('joint.2.jog-accel-fraction', 0.25)):
            assert float(pin(name)) == value
        assert float(self.mill.halcmd.run('getp xhc.smooth-y.gain')) == 0.5
        assert float(self.mill.halcmd.run('getp xhc.smooth-z.gain')) == 0.02
        self.mill.switch_on()
        self.step('0.1')
        for _ in range(2):
            self.moves('x', {'joint.0.pos-fb'}, -0.2)
            self.moves('y', {'joint.1.pos-fb'})
            self.moves('z', {'joint.2.pos-fb'})
            self.mill.home(2)

    @pytest.mark.parametrize('setting', ['FILTER = 1.5', 'FILTER_Y = nan', 'ACCELERATION = 0'])
    def test_no_part_of_one(self, setting):
        machine = Machine.of_our_own(settings=setting + '\n')
        assert find.wait(lambda: machine.process.poll() is not None, PATIENCE)
        assert ', but must be above 0 and up to 1' in machine.said()

    def test_a_filter_moves_no_other_axis(self):
        """It goes on for seconds after the wheel; what was turned elsewhere moves no other axis."""
        self.start(Machine.of_our_own(settings='FILTER = 0.0003\nSTEPS = 1\n'))
        self.mill.switch_on()
        self.mill.home(2)
        for name, other in (('off', 'x'), ('x', 'y')):
            self.before = int(pin('xhc-dro.wheel'))
            self.select(name)
            self.turn(20)
            self.counted(20)
            self.select(other)
            joint = 'joint.%d.pos-fb' % 'xy'.index(other)
            before = pin(joint)
            time.sleep(2)
            assert pin(joint) == before
        self.turn(2)
        self.mill.wait(lambda: abs(float(pin('joint.1.pos-fb')) - 2) < 0.01)

    @pytest.mark.parametrize('velocities', ['all', 'axes'])
    def test_velocity_and_continuous(self, velocities):
        """MPG: motion ends with the wheel's. Continuous: it goes on while the wheel turns, also if
        the ini has only the velocities of axes.
        """
        lacks = {'\nMAX_LINEAR_VELOCITY = 50\nINCREMENTS': '\nINCREMENTS',
                 'degree\nMAX_LINEAR_VELOCITY = 50\n': 'degree\n',
                 '[AXIS_Y]\nMAX_VELOCITY = 50\n': '[AXIS_Y]\n'} if velocities == 'axes' else {}
        with open('/run/mine.keys', 'w', encoding='ascii') as file:
            file.write('03 mode\n09 home\n0d step-up\n')
        self.start(Machine.of_our_own(
            settings='MODE = mpg\nSTEPS = 1 10\nKEYS = /run/mine.keys\n', **lacks))
        assert self.mill.said().count('in the mode continuous axis') == (velocities == 'axes')
        assert ('axis Y does not move: the ini has neither [TRAJ]MAX_LINEAR_VELOCITY nor '
                '[AXIS_Y]MAX_VELOCITY' in self.mill.said()) == (velocities == 'axes')
        self.mill.switch_on()
        self.mill.home(2)
        assert all(is_true(name + '.jog-vel-mode') for name in ('axis.x', 'joint.2', 'axis.z'))
        self.select('x')
        self.step('10')
        start = float(pin('joint.0.pos-fb'))
        self.turn(15)               # 150 mm, were it not for the mode
        self.mill.wait(lambda: float(pin('joint.0.pos-fb')) > start)
        self.rests()
        assert float(pin('joint.0.pos-fb')) < start + 100
        self.press('Rewind', lambda: is_true('xhc-dro.mode-step'))
        self.press('Rewind', lambda: is_true('xhc-dro.mode-continuous'))
        assert not is_true('axis.x.jog-vel-mode')
        self.step('1')
        before = float(pin('joint.0.pos-fb'))

        def fast():
            self.turn(-1)
            return abs(float(pin('motion.current-vel')) - 25) < 0.01     # half of 50

        self.mill.wait(fast)
        self.rests()
        assert float(pin('joint.0.pos-fb')) < before

    def test_modal_codes_of_macros(self):
        """They stay as a macro leaves them, unless it begins with M70 and ends with M72."""
        self.start(Machine.of_our_own(**{
            'MACRO_1 = (': 'MACRO_1 = M70\nMACRO_1 = G91 G20\nMACRO_1 = M72\nMACRO_1 = (',
            'MACRO_2 = (': 'MACRO_2 = G91 G20\nMACRO_2 = ('}))
        self.mill.switch_on()
        self.mill.home(2)
        screen = test_linuxcnc.Screen()
        screen.mdi('G90 G21')
        for name, codes in (('Macro 1', {900, 210}), ('Macro 2', {910, 200})):
            said = []
            self.press(name, lambda: said or said.append(screen.message()))
            assert said == [name.lower()]
            self.mill.wait(lambda: is_true('halui.mode.is-manual'))
            assert set(screen.codes()) & {900, 910, 200, 210} == codes

    def rests(self):
        def same():
            place = pin('joint.0.pos-fb')
            self.finish_cycle()
            return self.still() and pin('joint.0.pos-fb') == place

        self.mill.wait(same)

    @pytest.mark.parametrize('model, settings, step_key', [
        ('HB04', 'KEYS = hb04-16.keys\n', 13), ('HB03', '', 14)])
    def test_keys_by_a_table(self, model, settings, step_key):
        """An HB04 with 16 keys, and an HB03, which is found out: Home, step, X/2= and X=0"""
        self.start(Machine.of_our_own(settings=settings), rig.Rig(model))
        self.mill.switch_on()
        self.hold(5, lambda: is_true('halui.joint.2.is-homed'))
        self.mill.wait(lambda: is_true('halui.mode.is-teleop'))
        self.hold(step_key, lambda: pin('xhc-dro.step') == '0.01')
        self.moves('x', {'joint.0.pos-fb'}, 0.01)
        for number, place in ((6, 0.015), (9, 0)):
            self.hold(number, lambda: abs(float(
                pin('halui.axis.x.pos-relative')) - place) < NEAR)
            self.mill.wait(lambda: is_true('halui.mode.is-manual'))
        assert abs(float(pin('joint.0.pos-fb')) - 0.03) < NEAR

    def hold(self, number, done):
        device = self.pendant.device
        device.press(number)
        self.mill.wait(done)
        device.release(number)
        self.mill.wait(lambda: not test_linuxcnc.keys_down())
        self.finish_cycle()

    def test_two_pendants(self):
        """The first moves nothing and shows nothing; the second does."""
        first = rig.Rig()
        self.plug_rig(first)
        self.start(Machine.of_our_own(settings='PHYS = %s\n' % SECOND), rig.Rig(phys=SECOND))
        self.mill.switch_on()
        self.mill.home(2)
        self.step('0.1')
        device = first.device
        device.select(device.model.selector_code('y'))
        before = first.shown('machine_x')
        device.turn(5)
        self.moves('x', {'joint.0.pos-fb'})
        assert self.pendant.shows('machine_x', '0.3000', PATIENCE)
        assert first.shown('machine_x') == before != self.pendant.shown('machine_x')
