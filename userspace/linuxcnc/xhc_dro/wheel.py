# SPDX-License-Identifier: GPL-2.0-only
"""What the wheel does: its modes, the length of a step, and the mode continuous, in which an axis
moves as long as the wheel turns.
"""

import os

from .settings import number

AXES = 'xyzabc'
ANGULAR = 'abc'
MODES = ('step', 'continuous', 'mpg')
JOGS = tuple('%s-%s' % (way, axis) for axis in AXES for way in ('plus', 'minus'))
MILLIMETRES = (0.001, 0.01, 0.1, 1.0)
INCHES = (0.0001, 0.001, 0.01, 0.1)
GOES_ON = 0.25              # seconds from one detent to the next in which the wheel is turning
# Of a WHB04B's second rotary, in millimetres or degrees; at Lead nothing moves. In inches a step is
# what the position's label shows, up to 0.1; 1, 5 and 10 inches per detent are a hazard.
ROTARY_STEPS = {1: 0.001, 2: 0.01, 3: 0.1, 4: 1.0, 5: 5.0, 6: 10.0}
ROTARY_INCHES = {1: 0.001, 2: 0.01, 3: 0.1}
ROTARY_PERCENT = {1: 2, 2: 5, 3: 10, 4: 30, 5: 60, 6: 100}
MPG_LENGTH = 0.1            # of a detent at 100 percent
MPG_INCHES = 0.004
FILTERED = 1000             # counts of a detent behind a filter, see xhc.tcl


class Wheel:
    """From the ini: the machine's unit, and [XHC]STEPS, if they are not those of the unit; of each
    axis SCALE_X and so on, a factor of its steps. `filtered` are the axes behind a filter.
    """

    def __init__(self, linuxcnc, has_rotary, filtered=''):
        self.has_rotary = has_rotary
        path = os.environ.get('INI_FILE_NAME')
        find = linuxcnc.ini(path).find if path else lambda section, name: None
        unit = find('TRAJ', 'LINEAR_UNITS') or ''
        self.inch = unit.strip().lower() in ('inch', 'in', 'imperial')
        self.unit = 0.0001 if self.inch else 0.001
        self.lengths = INCHES if self.inch else MILLIMETRES
        words = find('XHC', 'STEPS')
        if words:
            self.lengths = tuple(number('STEPS', word) for word in words.split())
            if min(self.lengths) <= 0:
                raise ValueError('[XHC]STEPS: a step must be above 0')
        self.fourth = self._fourth(find)
        self.velocities = {}    # where the ini has no greatest velocity of all linear axes
        self.scales = {}
        self.signs = {}
        for axis in AXES:
            self.velocities[axis] = float(find('AXIS_' + axis.upper(), 'MAX_VELOCITY') or 0)
            scale = 1.0
            for name in ('SCALE', 'SCALE_' + axis.upper()):
                scale = number(name, find('XHC', name) or scale)
            self.scales[axis] = scale / FILTERED if axis in filtered else scale
            self.signs[axis] = -1 if scale < 0 else 1
        self.index = 0
        self.mode = find('XHC', 'MODE') or 'step'
        if self.mode not in MODES:
            raise ValueError('[XHC]MODE is %s, and none of %s' % (self.mode, ', '.join(MODES)))
        self.axis = None
        self.way = 0
        self.ends = 0.0

    @staticmethod
    def _fourth(find):
        """The axis at A of an HB04's selector: the first of A, B and C that the machine has, unless
        the ini names another; '' if it has none
        """
        coordinates = (find('TRAJ', 'COORDINATES') or '').lower()
        there = [axis for axis in ANGULAR if axis in coordinates]
        name = find('XHC', 'SELECTOR_A')
        if name is None:
            return there[0] if there else ''
        if name.strip().lower() not in there:
            raise ValueError('[XHC]SELECTOR_A: %s is none of %s' % (
                name.strip() or 'it', ' '.join(there).upper() or "the machine's axes A B C"))
        return name.strip().lower()

    def press(self, name):
        if name in ('step-up', 'step-down'):
            self.index = (self.index + (1 if name == 'step-up' else -1)) % len(self.lengths)
        elif name == 'step':
            self.mode = 'step'
        elif name == 'mode':
            following = {'step': 'continuous', 'continuous': 'mpg',
                         'mpg': 'continuous' if self.has_rotary else 'step'}
            self.mode = following[self.mode]
        if name in ('step', 'mode'):
            self.way = 0        # what was turned in one mode moves nothing in the next

    def _step(self, rotary, axis):
        if not self.has_rotary:
            return self.lengths[self.index]
        inches = self.inch and axis not in ANGULAR
        if self.mode == 'mpg':
            length = MPG_INCHES if inches else MPG_LENGTH
            return length * ROTARY_PERCENT.get(rotary, 0) / 100
        return (ROTARY_INCHES if inches else ROTARY_STEPS).get(rotary, 0.0)

    def _percent(self, rotary):
        if self.has_rotary:
            return ROTARY_PERCENT.get(rotary, 0)
        return 100 * (self.index + 1) / len(self.lengths)

    def turn(self, detents, axis, rotary, limits, now):
        """One round -> {pin: value}. `axis` is the selected one, or None; `limits` are the greatest
        velocities of linear and angular axes, 0 where the ini has none.
        """
        if axis != self.axis:
            self.way = 0        # what was turned for one axis moves no other
        self.axis = axis
        if detents:
            way = 1 if detents > 0 else -1
            self.way = way if self.way in (0, way) else 0   # turned back it stands still first
            self.ends = now + GOES_ON
        elif now >= self.ends:
            self.way = 0
        percent = self._percent(rotary)
        if not percent:
            self.way = 0
        found = dict.fromkeys(JOGS, False)
        found.update({'mode-' + mode: mode == self.mode for mode in MODES})
        found['detents'] = self.mode != 'continuous'
        found['step'] = self._step(rotary, axis or 'x')
        found.update({'step-' + each: self._step(rotary, each) * self.scales[each]
                      for each in AXES})
        found['jog-speed'] = 0.0
        if axis:
            limit = limits[axis in ANGULAR] or self.velocities[axis]
            found['jog-speed'] = 60 * limit * percent / 100
        if self.mode == 'continuous' and axis and percent and self.way:
            found['%s-%s' % ('plus' if self.way * self.signs[axis] > 0 else 'minus', axis)] = True
        return found
