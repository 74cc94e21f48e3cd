# SPDX-License-Identifier: GPL-2.0-only
"""An HB04 added by one HALFILE line to configurations that others made: Debian's samples, and those
that its stepconf and pncconf write. The wheel moves the joints before homing, and the axes
afterwards. See test_linuxcnc.py.
"""

import os
import re
import shutil
import subprocess
import sys

import pytest

from case import row
from halcmd import USER, Halcmd
import rig
from rig import find
import test_linuxcnc
from test_linuxcnc import ENVIRONMENT, HOME, PATIENCE, is_true, pin

SAMPLES = '/usr/share/doc/linuxcnc/examples/sample-configs/sim'
with open(os.path.join(os.path.dirname(os.path.realpath(__file__)), 'wizard.py'),
          encoding='ascii') as wizard_file:
    WIZARD = wizard_file.read()     # see setup_module
CONFIG = HOME + '/machine'
ADDED = 'HALFILE = %s/xhc-hb04.tcl\n' % test_linuxcnc.COPY
XYZ = {'x': (0,), 'y': (1,), 'z': (2,)}

setup_module = test_linuxcnc.setup_module


def teardown_module():
    subprocess.run(['umount', '--lazy', '/tmp'], check=True)


def written_by(wizard):
    """-> the folder of a configuration by stepconf or pncconf"""
    home = '/run/' + wizard
    os.makedirs(home)
    subprocess.run([sys.executable, '-c', WIZARD, wizard], env={**ENVIRONMENT, 'HOME': home},
                   cwd=home, check=True)
    return home + '/linuxcnc/configs/mill'


class Machine(test_linuxcnc.Mill):
    """LinuxCNC with a copy of `folder`, whose `ini` gets one line more."""

    def __init__(self, folder, ini, more=''):
        shutil.rmtree(HOME, ignore_errors=True)
        shutil.copytree(folder, CONFIG, ignore_dangling_symlinks=True)
        with open(CONFIG + '/more.hal', 'w', encoding='ascii') as file:
            file.write(more)
        path = '%s/%s' % (CONFIG, ini)
        with open(path, encoding='utf-8') as file:
            text = file.read()
        text = re.sub(r'(?m)^ *DISPLAY *=.*', 'DISPLAY = dummy', text)
        text = re.sub(r'(?m)^ *(POSTGUI_HALFILE|APP) *=.*', '', text)
        # hal_manualtoolchange ends at once without a screen, at times before it is wired
        text = re.sub(r'(?m)^( *HALFILE *= *LIB:basic_sim.tcl) *$',
                      r'\1 -no_use_hal_manualtoolchange', text)
        text = re.sub(r'(?m)^ *HALFILE *= *axis_manualtoolchange.hal *\n', '', text)
        last = [match.end() for match in re.finditer(r'(?m)^ *HALFILE *=.*\n', text)][-1]
        with open(path, 'w', encoding='utf-8') as file:
            file.write(text[:last] + 'HALFILE = more.hal\n' + ADDED + text[last:])
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
    def of_our_own(cls, more):
        """The simulated mill without a pendant, and without halui"""
        folder = '/run/own'
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(test_linuxcnc.COPY, folder)
        with open(folder + '/xhc-hb04.ini', encoding='ascii') as file:
            text = file.read()
        for line in ('HALFILE = xhc-hb04.tcl\n', 'HALUI = halui\n'):
            assert text.count(line) == 1
            text = text.replace(line, '')
        with open(folder + '/xhc-hb04.ini', 'w', encoding='ascii') as file:
            file.write(text)
        return cls(folder, 'xhc-hb04.ini', more)


class Case(test_linuxcnc.Case):
    @classmethod
    def setup_class(cls):
        """Each case has its own machine."""

    def set_up(self):
        rig.Case.set_up(self)

    def start(self, machine):
        assert machine.halcmd, machine.said()
        # its helpers ask the mill of the other file's class
        Case.mill = test_linuxcnc.Case.mill = machine
        Case.pendant = rig.Rig()
        self.add_cleanup(self.end)
        self.come()
        self.be_patient()

    def select(self, name):
        super().select(name)
        self.mill.wait(lambda: is_true('xhc.on-a.and') == (name == 'a'))

    def moves(self, axis, pins):
        """The wheel moves these pins, and no other joint"""
        self.select(axis)
        joints = ['joint.%d.pos-fb' % number for number in range(9)
                  if not self.missing('joint.%d.pos-fb' % number)]
        watched = {*pins, *joints}
        before = {name: float(pin(name)) for name in watched}
        detents = -3 if axis == 'z' else 3      # Z may be at its top
        self.turn(detents)

        def came():
            way = {name: float(pin(name)) - before[name] for name in watched}
            return all(abs(way[name] - (0.1 * detents if name in pins else 0)) < 1e-3
                       for name in watched)

        self.mill.wait(came)
        self.select('off')

    @staticmethod
    def missing(name):
        return test_linuxcnc.seen([name])[name] is None

    def works(self, joints, step='0.001'):
        """`joints`: {axis: numbers}. LinuxCNC lets no wheel move joints that are homed together
        before they are.
        """
        self.mill.switch_on()
        assert pin('xhc-dro.step') == step
        self.step('0.1')
        for axis, numbers in joints.items():
            if len(numbers) == 1:
                with row(axis=axis):
                    self.moves(axis, {'joint.%d.pos-fb' % number for number in numbers})
        last = max(number for numbers in joints.values() for number in numbers)
        self.mill.click('home-all', 'joint.%d.is-homed' % last, seconds=PATIENCE)
        self.mill.wait(lambda: is_true('halui.mode.is-teleop'))
        for axis, numbers in joints.items():
            with row(homed=axis):
                self.moves(axis, {'joint.%d.pos-fb' % number for number in numbers})


class TestAdded(Case):
    @pytest.mark.parametrize('name, joints', [
        ('axis/axis_mm.ini', XYZ), ('axis/axis.ini', XYZ), ('axis/minimal_xyz.ini', XYZ),
        ('axis/axis_9axis.ini', {**XYZ, 'a': (3,)}), ('gmoccapy/gmoccapy.ini', XYZ),
        ('axis/lathe.ini', {'x': (0,), 'z': (1,)}),
        ('axis/gantry/gantry_mm.ini', {'x': (0,), 'y': (1, 2), 'z': (3,)})])
    def test_samples(self, name, joints):
        folder, _, ini = name.rpartition('/')
        self.start(Machine(SAMPLES + '/' + folder, ini))
        millimetres = ini in ('axis_mm.ini', 'gmoccapy.ini', 'gantry_mm.ini')
        self.works(joints, '0.001' if millimetres else '0.0001')

    @pytest.mark.parametrize('name, step', [('stepconf', '0.001'), ('pncconf', '0.0001')])
    def test_wizard(self, name, step):
        self.start(Machine(written_by(name), 'mill.ini'))
        self.works(XYZ, step)

    def test_what_is_wired_already(self):
        machine = Machine.of_our_own('net mpg => axis.x.jog-counts\n')
        assert find.wait(lambda: machine.process.poll() is not None, PATIENCE)
        assert 'axis.x.jog-counts is wired to mpg already' in machine.said()
