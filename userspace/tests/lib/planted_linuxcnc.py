# SPDX-License-Identifier: GPL-2.0-only
"""A simulated HAL, LinuxCNC and pendant in sysfs, for the unit tests of xhc-dro."""

import os
import shutil
import sys
import tempfile
import types

import case

PRODUCT = os.path.join(os.path.dirname(os.path.realpath(__file__)), '..', '..', 'linuxcnc')
sys.path.insert(0, PRODUCT)

from xhc_sim.models import STEPS  # noqa: E402

MODELS = {'EB6E': 'HB03', 'EB70': 'HB04', 'EB93': 'WHB04B'}     # by product
ATTRIBUTES = ('position', 'feedrate_override', 'spindle_override', 'feedrate', 'spindle_speed',
              'step', 'state')


class Hal(types.SimpleNamespace):
    """The module `hal`: one component, and a set of existing ones."""

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
    """The module `linuxcnc`: a mill that is ready, and a list of its commands."""

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


class Case(case.Case):
    """A driver directory in sysfs, made of files."""

    def set_up(self):
        self.driver = tempfile.mkdtemp()
        self.add_cleanup(shutil.rmtree, self.driver)
        self.said = []

    def plug(self, name='0003:10CE:EB70.0001', phys='usb-1/input0', model=None):
        """`model` is that of a clone, whose product has none."""
        path = os.path.join(self.driver, name)
        os.makedirs(path + '/dro')
        for attribute in ATTRIBUTES:
            self.put(path + '/dro/' + attribute, '')
        self.put(path + '/dro/step_available', ' '.join(map(str, STEPS.values())) + '\n')
        self.put(path + '/uevent', 'HID_NAME=x\nHID_PHYS=%s\n' % phys)
        self.put(path + '/model', (model or MODELS[name[10:14]]) + '\n')
        return path

    @staticmethod
    def put(path, text):
        with open(path, 'w', encoding='ascii') as file:
            file.write(text)

    @staticmethod
    def get(path, name):
        with open('%s/dro/%s' % (path, name), encoding='ascii') as file:
            return file.read()
