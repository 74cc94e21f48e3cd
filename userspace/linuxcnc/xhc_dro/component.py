# SPDX-License-Identifier: GPL-2.0-only
"""The component: its pins, and what it does over and over."""

import time

from . import whb04b
from .display import AXES, Display, find
from .display import texts as hb_texts
from .input import Input

TURN = 0.05             # seconds: twenty times a second, as often as the display takes frames
SEARCH = 0.25           # seconds between two looks for a pendant that is not there

POSITIONS = tuple('%s-%s' % (system, axis) for system in ('work', 'machine') for axis in AXES)
FLOATS = POSITIONS + ('feed-override', 'spindle-override', 'velocity', 'spindle-speed', 'step')
BITS = ('running', 'paused', 'inch')
RESULTS = ('connected', 'heartbeat')


def texts(values, options, display):
    return hb_texts(values, options.unit, display.available)


# Of a model: pins that are floats, pins that are bits, and the text that attributes take
MODELS = {'hb04': (FLOATS, BITS, texts), 'whb04b': (whb04b.FLOATS, whb04b.BITS, whb04b.texts)}


class Component:
    """Made of the module `hal`, so that a test can bring its own."""

    def __init__(self, hal, options, say, **where):
        self.hal = hal
        self.options = options
        self.say = say
        self.where = where
        self.floats, self.bits, self.texts = MODELS[options.model]
        self.pins = hal.component('xhc-dro')
        for name in self.floats:
            self.pins.newpin(name, hal.HAL_FLOAT, hal.HAL_IN)
        for name in self.bits:
            self.pins.newpin(name, hal.HAL_BIT, hal.HAL_IN)
        for name in RESULTS:
            self.pins.newpin(name, hal.HAL_BIT, hal.HAL_OUT)
        self.input = Input(options.input, hal, say) if options.input else None
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
        if self.display:
            values = {name: self.pins[name] for name in self.floats + self.bits}
            self.display.show(self.texts(values, self.options, self.display))

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
        if self.display:
            self.display.close()
        self.pins.exit()
