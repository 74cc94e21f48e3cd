# SPDX-License-Identifier: GPL-2.0-only
"""The steps of an HB04's wheel, which two keys go through."""

import os

KEYS = ('step-up', 'step-down')
MILLIMETRES = (0.001, 0.01, 0.1, 1.0)
INCHES = (0.0001, 0.001, 0.01, 0.1)


class Steps:
    """From the ini: the machine's unit, and [XHC]STEPS, if they are not those of the unit"""

    def __init__(self, linuxcnc):
        path = os.environ.get('INI_FILE_NAME')
        unit, words = '', None
        if path:
            ini = linuxcnc.ini(path)
            unit = ini.find('TRAJ', 'LINEAR_UNITS') or ''
            words = ini.find('XHC', 'STEPS')
        self.inch = unit.strip().lower() in ('inch', 'in', 'imperial')
        self.unit = 0.0001 if self.inch else 0.001
        self.lengths = INCHES if self.inch else MILLIMETRES
        if words:
            self.lengths = tuple(float(word) for word in words.split())
        self.index = 0
        self.down = dict.fromkeys(KEYS, True)

    def turn(self, pins, works):
        """One round -> the length of a step"""
        for name, way in zip(KEYS, (1, -1)):
            if works and pins[name] and not self.down[name]:
                self.index = (self.index + way) % len(self.lengths)
            self.down[name] = bool(pins[name])
        return self.lengths[self.index]
