# SPDX-License-Identifier: GPL-2.0-only
"""The component: its pins, and what it does over and over."""

import time

from . import whb04b
from .display import AXES, Display, find
from .display import texts as hb_texts
from .input import Input
from .macros import ACTIONS, OWNERS, Macros
from . import steps

TURN = 0.05             # seconds: twenty times a second, as often as the display takes frames
SEARCH = 0.25           # seconds between two looks for a pendant that is not there

POSITIONS = tuple('%s-%s' % (system, axis) for system in ('work', 'machine') for axis in AXES)
FLOATS = POSITIONS + ('feed-override', 'spindle-override', 'velocity', 'spindle-speed')
SELECTED = tuple('select-' + axis for axis in AXES + 'a')
BITS = ('running', 'paused', 'inch') + steps.KEYS + SELECTED
KEYS = ACTIONS + OWNERS
RESULTS = ('connected', 'heartbeat')


def texts(values, options, display):
    return hb_texts(values, options.unit or values['unit'], display.available)


def runs(_name, _values):
    return True


# Of a model: pins that are floats, pins that are bits, the text that attributes take, whether a key
# runs its macro, and what makes a jog of the wheel's counts
MODELS = {'hb04': (FLOATS, BITS, texts, runs, None),
          'whb04b': (whb04b.FLOATS + whb04b.LIMITS, whb04b.BITS, whb04b.texts, whb04b.runs,
                     whb04b.Wheel)}


class Component:
    """Made of the modules `hal` and `linuxcnc`, so that a test can bring its own."""

    def __init__(self, hal, linuxcnc, options, say, **where):
        self.hal = hal
        self.options = options
        self.say = say
        self.where = where
        self.floats, self.bits, self.texts, self.runs, wheel = MODELS[options.model]
        self.wheel = wheel() if wheel else None
        self.steps = None if wheel else steps.Steps(linuxcnc)
        self.pins = hal.component('xhc-dro')
        for name in self.floats:
            self.pins.newpin(name, hal.HAL_FLOAT, hal.HAL_IN)
        for name in self.bits + KEYS:
            self.pins.newpin(name, hal.HAL_BIT, hal.HAL_IN)
        for name in RESULTS:
            self.pins.newpin(name, hal.HAL_BIT, hal.HAL_OUT)
        if self.steps:
            self.pins.newpin('step', hal.HAL_FLOAT, hal.HAL_OUT)
            self.pins['step'] = self.steps.lengths[0]
        if self.wheel:
            for name in whb04b.NUMBERS:
                self.pins.newpin(name, hal.HAL_S32, hal.HAL_IN)
            self.pins.newpin('jog-speed', hal.HAL_FLOAT, hal.HAL_OUT)
            for name in whb04b.JOG_BITS:
                self.pins.newpin(name, hal.HAL_BIT, hal.HAL_OUT)
        self.input = Input(options.input, hal, say) if options.input else None
        self.macros = Macros(linuxcnc, say)
        self.down = dict.fromkeys(KEYS, True)       # a key that is down at the start runs nothing
        self.display = None
        self.next_search = 0.0
        self.pins.ready()

    def turn(self):
        """One round. The pin `connected` comes first: a wheel that is gone must not jog."""
        self._look_for_pendant()
        path = self.display.path if self.display else None
        works = self.input.works_for(path) if self.input else path is not None
        self.pins['connected'] = works
        self.pins['heartbeat'] = not self.pins['heartbeat']
        # keys before Fn, which is down first
        down = {name: bool(self.pins[name]) for name in KEYS}
        values = {name: self.pins[name] for name in self.floats + self.bits}
        self._look_at_keys(down, values, works)
        if self.steps:
            self.pins['step'] = values['step'] = self.steps.turn(values, works)
            values['unit'] = self.steps.unit
            values['inch'] = values['inch'] or self.steps.inch
        if self.wheel:
            values.update({name: self.pins[name] for name in whb04b.NUMBERS})
            values.update(self.wheel.turn(values, works, time.monotonic()))
            for name in ('jog-speed', *whb04b.JOG_BITS):
                self.pins[name] = values[name]
        if self.display:
            self.display.show(self.texts(values, self.options, self.display))

    def _look_at_keys(self, down, values, works):
        axis = next((name[-1].upper() for name in values
                     if name.startswith('select-') and values[name]), None)
        for name in KEYS:
            if works and down[name] and not self.down[name] and self.runs(name, values):
                self.macros.start(name, axis)
        self.down = down
        if not works:
            self.macros.drop()
        self.macros.turn()

    def _look_for_pendant(self):
        if self.display and not self.display.there():
            self.display.close()
            self.display = None
        if not self.display and time.monotonic() >= self.next_search:
            self.next_search = time.monotonic() + SEARCH
            path = find(self.options.phys, **self.where)
            if path:
                self.display = Display(path, self.say)

    def run(self):
        while True:
            self.turn()
            time.sleep(TURN)

    def end(self):
        """Whatever happens, nothing is left that says the pendant may jog."""
        self.pins['connected'] = False
        if self.wheel:
            for name in whb04b.JOGS:
                self.pins[name] = False
        if self.display:
            self.display.close()
        self.pins.exit()
