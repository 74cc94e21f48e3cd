# SPDX-License-Identifier: GPL-2.0-only
"""Reports, display frame and LCD of the WHB04B-4 and -6.

Input report, 8 bytes:

    04 | r 1 | first key 1 | second key 1 | feed 1 | axis 1 | wheel 1 | check 1

r changes with each report; feed is the second rotary switch, axis the first one.  check is computed
from r, the first key and byte 2 of the last display frame, the seed.

Display frame, 21 bytes (all numbers little-endian):

    FE FD | seed 1 | flags 1 | three rows: integer 2, fraction 2 | feed override 2 |
    spindle override 2 | 00

A row has the format of an HB04 coordinate.  Flags: bits 0..1 mode, bit 6 RESET, bit 7 work
coordinates.
"""

from . import hands, lcd
from .wire import INPUT_ID

OFF, X, C = 0x06, 0x11, 0x16            # codes of the axis rotary
LEAD, LEAD_ON_OTHERS = 0x1C, 0x9B       # codes of the second rotary; a unit has one of them
SEED = 0xFE                             # other seeds are not verified
SEED_AT_POWER_ON = 0x01
# The interval of reports while an axis is selected is not known; the endpoint is polled every 2 ms.
STREAM_PERIOD = 0.01

MODES = ('continuous', 'step', 'mpg', 'percent')
RESET, WORK, UNKNOWN_FLAGS = 0x40, 0x80, 0x3C
ROWS = ('row1', 'row2', 'row3')
NUMBERS = ('feedrate_override', 'spindle_override')
# Meaning of the second rotary in the mode "step". It is not fully known which units have 5.0 and
# 10.0 (those named -B have).
STEPS = {0x0D: '0.001', 0x0E: '0.01', 0x0F: '0.1', 0x10: '1.0', 0x1A: '5.0', 0x1B: '10.0'}


def check_byte(r, first_key, seed):
    inverse = ~r & 0xFF
    return ((inverse + first_key) & 0xFF) ^ (seed | inverse)


class Pendant(hands.Pendant):
    """Two key slots, two rotaries, a wheel, the seed last received, sleep.

    random        r of the next report
    lead          the code that this unit has for Lead
    check_error   XORed into the check byte: 0 except in tests
    trailing      the report after that of sleep: 'empty', with only r and the check byte, or
                  'positions', with the positions of the rotary switches. Real units send one; it
                  has no meaning, and its contents are not known.
    """

    def __init__(self, model):
        super().__init__(model)
        self.feed = model.feed['2%']
        self.lead = LEAD
        self.seed = SEED_AT_POWER_ON
        self.random = 0x5A
        self.check_error = 0
        self.trailing = 'empty'

    def report(self, wheel=0):
        self.awake = True
        return self._report(self._feed_code(), self.selector, wheel)

    def _feed_code(self):
        return self.lead if self.feed == LEAD else self.feed

    def _report(self, feed, axis, wheel=0):
        r, (first, second) = self.random, self.slots
        self.random = (r * 5 + 0x3B) & 0xFF             # takes each value once in 256 reports
        check = check_byte(r, first, self.seed) ^ self.check_error
        return bytes([INPUT_ID, r, first, second, feed, axis, wheel & 0xFF, check])

    def turn_feed(self, code):
        self._touched()
        self.feed = code
        return self.report()

    def sleep(self):
        self.awake = False
        self.slots = [0, 0]
        return self._report(0, 0)

    def after_sleep(self):
        if self.trailing == 'positions':
            return [self._report(self._feed_code(), self.selector)]
        return [self._report(0, 0)]

    def receive(self, picture):
        """It is not known whether the unit or its receiver computes the check byte: here the seed
        is used even if the unit sleeps."""
        self.seed = picture.seed

    def power_on(self):
        """A wired unit, or the receiver of a wireless unit, was without power; it is not known what
        the LCD of a wireless unit shows then."""
        self.seed = SEED_AT_POWER_ON
        return True

    def forget(self):
        self.seed = SEED_AT_POWER_ON

    def streaming(self):
        return self.awake and X <= self.selector <= C

    def hears(self):
        """A wireless unit loses frames while it sleeps."""
        return self.awake

    def refreshes(self):
        """The LCD is not updated while the axis rotary is off."""
        return self.awake and self.selector != OFF

    def marks(self):
        return self.model.selector_name(self.selector), self._feed_code()


class Picture(lcd.Picture):
    """The contents of the LCD after one frame."""

    POSITIONS, GROUP = ROWS, 'rows'
    FIELDS = ROWS + NUMBERS + ('rows', 'mode', 'coordinates', 'reset', 'flags', 'seed', 'faults')

    def _decode(self):
        self._check_frame()
        self.seed, self.flags = self.frame[2:4]
        self.mode = MODES[self.flags & 3]
        self.reset = bool(self.flags & RESET)
        self.work = bool(self.flags & WORK)
        if self.seed != SEED:
            self.faults.append('seed %#04x' % self.seed)
        if self.flags & UNKNOWN_FLAGS:
            self.faults.append('flags %#04x' % (self.flags & UNKNOWN_FLAGS))
        at = 4
        for name in ROWS:
            self.coordinates[name] = self._coordinate(name, self.frame[at:at + 4])
            at += 4
        for name in NUMBERS:
            self.numbers[name] = int.from_bytes(self.frame[at:at + 2], 'little')
            at += 2
        if any(self.frame[at:]):
            self.faults.append('last byte is not zero')

    def as_dict(self):
        fields = dict(self.coordinates)
        fields.update(self.numbers)
        fields.update(mode=self.mode, coordinates='work' if self.work else 'machine',
                      reset=int(self.reset), flags=self.flags, seed=self.seed,
                      faults=list(self.faults))
        return fields

    def lines(self, awake=True, selector='x', feed=0x0D):
        """The LCD as eight lines of text.

        The radio transmits only one of the two overrides, and it is not known which: both are shown
        here, and one of them may be outdated on a real unit.
        """
        rows = ['%-12s %12s %16s' % (self.mode.upper(), self._feed_text(feed),
                                     'RESET' if self.reset else ''), '']
        names = 'ABC' if selector in ('a', 'b', 'c') else 'XYZ'
        for name, field in zip(names, ROWS):
            rows.append('%s%s%s %14s' % ('>' if selector == name.lower() else ' ', name,
                                         '1' if self.work else ' ', self.coordinates[field]))
        rows.append(' F %5d%%   S %5d%%' % tuple(self.numbers[name] for name in NUMBERS))
        return lcd.box(self.model, awake, 'seed %02X' % self.seed, rows)

    def _feed_text(self, code):
        if code in (LEAD, LEAD_ON_OTHERS):
            return 'LEAD'
        if self.mode == 'step' and code in STEPS:
            return STEPS[code]
        return self.model.feed_name(code)


def blank(model, awake=True):
    """The LCD after power-on; the contents of the rows are not known."""
    return lcd.box(model, awake, 'no frame yet', ['%42s' % 'RESET'] + [''] * 5)
