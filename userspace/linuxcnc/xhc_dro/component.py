# SPDX-License-Identifier: GPL-2.0-only
"""The component: its pins, and what it does over and over."""

import os
import time

from . import keys, whb04b
from .display import Display, find
from .display import texts as hb_texts
from .events import Events
from .macros import ACTIONS, OWNERS, Macros
from .wheel import AXES, JOGS, MODES, Wheel

TURN = 0.02             # seconds
SEARCH = 0.25           # seconds between two looks for a pendant that is not there
UDEV_TIME = 5.0         # seconds until the group may read, at the latest
PATIENCE = 0.5          # seconds, see the pin
SHORTEST = 0.1          # seconds that a key is down for HAL: halui looks every 20 ms, or less often

FLOATS_IN = tuple('%s-%s' % (system, axis) for system in ('work', 'machine') for axis in AXES) + (
    'feed-override', 'spindle-override', 'velocity', 'spindle-speed', 'max-velocity',
    'max-angular-velocity', 'patience')
BITS_IN = ('running', 'paused', 'inch', 'reset', 'show-machine')
SELECTOR = ('x', 'y', 'z', 'a', 'feed', 'spindle', 'b', 'c')        # position 0 is off
POSITIONS = (None, *SELECTOR)
POSITIONS_HB03 = (None, 'x', 'y', 'z', None, 'feed', 'spindle')     # its fourth is a speed, not A
BITS_OUT = ('connected', 'heartbeat', 'detents') + JOGS + tuple(
    'mode-' + mode for mode in MODES) + tuple('select-' + name for name in SELECTOR)
FLOATS_OUT = ('step', 'jog-speed') + tuple('step-' + axis for axis in AXES)
NUMBERS_OUT = ('wheel', 'rotary') + tuple('wheel-' + name for name in SELECTOR)


def texts(values, options, display):
    return hb_texts(values, options.unit or values['unit'], display.available)


# Of --model: the text that attributes take, whether a second rotary has the steps, and the models
# of the driver
MODELS = {'hb04': (texts, False, ('HB03', 'HB04')), 'whb04b': (whb04b.texts, True, ('WHB04B',))}


class Component:
    """Made of the modules `hal` and `linuxcnc`, so that a test can bring its own."""

    def __init__(self, hal, linuxcnc, options, say, **where):
        self.options = options
        self.say = say
        self.where = where
        self.texts, has_rotary, self.models = MODELS[options.model]
        self.tables = keys.shipped()
        self.table = self._owners_table(linuxcnc)
        self.wheel = Wheel(linuxcnc, has_rotary, options.filtered)
        self.macros = Macros(linuxcnc, say)
        self.display = None
        self.events = None
        self.keys = None
        self.positions = POSITIONS
        self.pressed_at = {}        # name: time
        self.next_search = 0.0
        self.found_at = None
        self.key_names = keys.names([*self.tables.values(), self.table or {}])
        self.pins = hal.component(options.name)
        for kind, direction, names in (
                (hal.HAL_FLOAT, hal.HAL_IN, FLOATS_IN), (hal.HAL_BIT, hal.HAL_IN, BITS_IN),
                (hal.HAL_BIT, hal.HAL_OUT, BITS_OUT), (hal.HAL_FLOAT, hal.HAL_OUT, FLOATS_OUT),
                (hal.HAL_S32, hal.HAL_OUT, NUMBERS_OUT),
                (hal.HAL_BIT, hal.HAL_OUT, ['key-' + name for name in self.key_names])):
            for name in names:
                self.pins.newpin(name, kind, direction)
        self.pins['step'] = self.wheel.lengths[0]
        self.pins['patience'] = PATIENCE
        self.last_turn = time.monotonic()
        self.pins.ready()

    @staticmethod
    def _owners_table(linuxcnc):
        """[XHC]KEYS of the ini; None without it"""
        ini = os.environ.get('INI_FILE_NAME')
        name = linuxcnc.ini(ini).find('XHC', 'KEYS') if ini else None
        if not name:
            return None
        try:
            return keys.read(keys.find(name, os.path.dirname(ini)))
        except OSError as error:
            raise ValueError('[XHC]KEYS: %s: %s' % (name, error.strerror)) from error

    def turn(self):
        """One round. The pin `connected` comes first: a wheel that is gone must not jog."""
        self._look_for_pendant()
        detents = self._read()
        now = time.monotonic()
        if now - self.last_turn > self.pins['patience']:
            # HAL has stopped what moved: what was turned and pressed meanwhile does nothing,
            # but for the keys that stop: a program may be running
            detents = 0
            if self.events:
                stops = self.keys.stops(self.events.touched())
                self.pressed_at.update(dict.fromkeys(stops, now))
            self._close_events()
            self.next_search = now
            self._look_for_pendant()
        self.last_turn = now
        works = self.events is not None
        lost = self.pins['connected'] and not works
        self.pins['connected'] = works
        self.pins['heartbeat'] = not self.pins['heartbeat']
        selected = self.positions[self.events.selector] if works else None
        axis = selected if selected in tuple(AXES) else None
        pressed = self._look_at_keys(now)
        rotary = self.events.rotary if works else 0
        found = self.wheel.turn(detents, axis, rotary, (
            self.pins['max-velocity'], self.pins['max-angular-velocity']), now)
        found['rotary'] = rotary
        found.update({'select-' + name: name == selected for name in SELECTOR})
        for name, value in found.items():
            self.pins[name] = value
        self.pins['wheel'] += detents
        if selected and (found['detents'] or not axis):
            self.pins['wheel-' + selected] += detents
        # only now what LinuxCNC may keep waiting
        self._run_macros(pressed, axis)
        if lost:
            self.macros.report('unplugged')
        if self.display:
            values = {name: self.pins[name] for name in FLOATS_IN + BITS_IN}
            values.update(found)
            values['unit'] = self.wheel.unit
            values['fourth'] = self.wheel.fourth
            values['inch'] = values['inch'] or self.wheel.inch
            self.display.show(self.texts(values, self.options, self.display))

    def _look_at_keys(self, now):
        """-> [name] of what has gone down"""
        pressed = self.keys.turn(self.events.down) if self.events else []
        self.pressed_at.update(dict.fromkeys(pressed, now))
        for name in self.key_names:
            self.pins['key-' + name] = bool(self.events) and (
                self.keys.is_down(name) or now < self.pressed_at.get(name, 0) + SHORTEST)
        for name in pressed:
            self.wheel.press(name)
        return pressed

    def _run_macros(self, pressed, axis):
        if not self.events:
            self.macros.drop()
        for name in pressed:
            if name in ACTIONS + OWNERS:
                self.macros.start(name, axis and axis.upper())
        self.macros.turn()

    def _look_for_pendant(self):
        if self.display and not self.display.there():
            self._lose()
        if (self.display and self.events) or time.monotonic() < self.next_search:
            return
        self.next_search = time.monotonic() + SEARCH
        if not self.display:
            path = find(self.models, self.options.phys, **self.where)
            if not path:
                return
            self.display = Display(path, self.say)
            self.found_at = time.monotonic()
        self._open_events()

    def _open_events(self):
        try:
            self.events = Events(self.display.path)
        except OSError as error:
            if self.found_at and time.monotonic() > self.found_at + UDEV_TIME:
                self.say('%s: %s' % (self.display.path, error.strerror))
                self.found_at = None        # once
            return
        default = 'whb04b' if self.wheel.has_rotary else 'hb04-18'
        name = keys.TABLES.get(self.display.model, default)
        self.positions = POSITIONS_HB03 if name == 'hb03' else POSITIONS
        if self.wheel.fourth and self.display.model == 'HB04':
            self.positions = tuple(self.wheel.fourth if each == 'a' else each
                                   for each in POSITIONS)
        table = self.tables[name] if self.table is None else self.table
        self.keys = keys.Keys(table, self.events.down)

    def _read(self):
        """-> detents"""
        if not self.events:
            return 0
        try:
            return self.events.read()
        except OSError:
            self._close_events()
            return 0

    def _close_events(self):
        if self.events:
            self.events.close()
            self.events = None

    def _lose(self):
        self._close_events()
        self.display.close()
        self.display = None

    def run(self):
        while True:
            self.turn()
            time.sleep(TURN)

    def end(self):
        """Whatever happens, nothing is left that shows the pendant may jog."""
        self.pins['connected'] = False
        for name in JOGS:
            self.pins[name] = False
        if self.display:
            self._lose()
        self.pins.exit()
