# SPDX-License-Identifier: GPL-2.0-only
"""What a WHB04B has instead of an HB04's display: pins, the text that its attributes take, and the
modes of its wheel.
"""

from .display import coordinate, number
from .macros import ACTIONS

AXES = 'xyzabc'
SECOND = 'abc'              # the axes that have the rows while the selector is at one of them
SYSTEMS = ('work', 'machine')

FLOATS = tuple('%s-%s' % (system, axis) for system in SYSTEMS for axis in AXES) + (
    'feed-override', 'spindle-override')
SELECTED = tuple('select-' + axis for axis in AXES)
BITS = SELECTED + ('show-machine', 'reset', 'fn', 'key-continuous', 'key-step')
WITHOUT_FN = ACTIONS + ('probe-z', 'rewind', 'macro-10')

LIMITS = ('max-velocity', 'max-angular-velocity')
NUMBERS = ('wheel', 'rotary')
MODES = ('step', 'continuous', 'mpg')
JOGS = tuple('%s-%s' % (way, axis) for axis in AXES for way in ('plus', 'minus'))
JOG_BITS = JOGS + tuple('mode-' + mode for mode in MODES) + ('detents',)
PERCENT = {1: 2, 2: 5, 3: 10, 4: 30, 5: 60, 6: 100}     # of the second rotary's positions
GOES_ON = 0.25              # seconds from one detent to the next in which the wheel is turning


class Wheel:
    """The modes, and the mode continuous: an axis moves as long as the wheel turns."""

    def __init__(self):
        self.mode = 'step'
        self.keys = {'key-step': True, 'key-continuous': True}
        self.axes = []
        self.counts = None
        self.way = 0
        self.ends = 0.0

    def turn(self, pins, works, now):
        """One round -> {pin: value}"""
        self._look_at_keys(pins, works)
        self._look_at_wheel(pins['wheel'], now)
        axes = [axis for axis in AXES if pins['select-' + axis]]
        if axes != self.axes:
            self.way = 0        # what was turned for one axis moves no other
        self.axes = axes
        percent = PERCENT.get(pins['rotary'], 0)
        found = dict.fromkeys(JOGS, False)
        found.update({'mode-' + mode: mode == self.mode for mode in MODES})
        found['detents'] = self.mode != 'continuous'
        found['jog-speed'] = 0.0
        if axes:
            limit = LIMITS[axes[0] in SECOND]
            found['jog-speed'] = 60 * pins[limit] * percent / 100
        if works and self.mode == 'continuous' and len(axes) == 1 and percent and self.way:
            found['%s-%s' % ('plus' if self.way > 0 else 'minus', axes[0])] = True
        return found

    def _look_at_keys(self, pins, works):
        pressed = [name for name, was in self.keys.items() if pins[name] and not was]
        self.keys = {name: bool(pins[name]) for name in self.keys}
        if not works or pins['fn']:
            return
        if 'key-step' in pressed:
            self.mode = 'step'
        elif 'key-continuous' in pressed:
            self.mode = 'mpg' if self.mode == 'continuous' else 'continuous'

    def _look_at_wheel(self, counts, now):
        """Which way it turns; one that is turned back stands still first."""
        turned = 0 if self.counts is None else counts - self.counts
        self.counts = counts
        if turned:
            way = 1 if turned > 0 else -1
            self.way = way if self.way in (0, way) else 0
            self.ends = now + GOES_ON
        elif now >= self.ends:
            self.way = 0


def texts(pins, _options, _display):
    """-> attribute: text; `pins` are by name."""
    second = any(pins['select-' + axis] for axis in SECOND)
    system = 'machine' if pins['show-machine'] else 'work'
    return {
        'rows': ' '.join(coordinate(pins['%s-%s' % (system, axis)])
                         for axis in (SECOND if second else 'xyz')),
        'coordinates': system,
        'mode': next(mode for mode in MODES if pins['mode-' + mode]),
        'reset': str(int(pins['reset'])),
        'feedrate_override': number(100 * pins['feed-override']),
        'spindle_override': number(100 * pins['spindle-override']),
    }


def runs(name, pins):
    """Most keys are a macro together with Fn; one is a macro without it."""
    return bool(pins['fn']) != (name in WITHOUT_FN)
