# SPDX-License-Identifier: GPL-2.0-only
"""What is pressed and turned -> input reports: a state machine that knows no bus.

Report of the HB03 and HB04: id, key, key, selector, wheel, day XOR first key.
"""

import time

from .wire import INPUT_ID

SLEEP_AFTER = 30.0          # seconds without a key, then the radio goes to sleep
SLEEP_REPORT = bytes([INPUT_ID, 0, 0, 0, 0, 0])


class Pendant:
    """Two key slots, a selector, a wheel, the day last received, sleep: the HB03 and HB04.

    Other models derive from it what they have in another way.
    """

    def __init__(self, model):
        self.model = model
        self.slots = [0, 0]
        self.selector = model.selector['off']
        self.day = 0
        self.awake = True
        self.quiet_since = time.monotonic()

    def report(self, wheel=0):
        """The input report for the present state; any use of a sleeping pendant wakes it."""
        self.awake = True
        first, second = self.slots
        return bytes([INPUT_ID, first, second, self.selector, wheel & 0xFF, self.day ^ first])

    def press(self, code):
        """A third key is not seen: the report has two slots."""
        self._touched()
        if code not in self.slots and 0 in self.slots:
            self.slots[self.slots.index(0)] = code
        return self.report()

    def release(self, code):
        """The other key, if one is held, moves to the first slot."""
        self._touched()
        held = [key for key in self.slots if key not in (0, code)]
        self.slots = (held + [0, 0])[:2]
        return self.report()

    def select(self, code):
        self._touched()
        self.selector = code
        return self.report()

    def turn(self, detents):
        if not -128 <= detents <= 127:
            raise ValueError('the wheel reports -128..127, not %d' % detents)
        self._touched()
        return self.report(detents)

    def sleep(self):
        """Goes to sleep; what is held is forgotten, as by the real one."""
        self.awake = False
        self.slots = [0, 0]
        return SLEEP_REPORT

    def after_sleep(self):
        """The reports that follow sleep() without being asked for."""
        return []

    def wake(self):
        self._touched()
        return self.report()

    def sleepy(self, now=None):
        """True once nothing has been touched for SLEEP_AFTER seconds."""
        now = time.monotonic() if now is None else now
        return self.awake and not any(self.slots) and now - self.quiet_since >= SLEEP_AFTER

    def receive(self, picture):
        """A frame has come in."""
        self.day = picture.day

    def power_on(self):
        """Power has come; -> whether the LCD shows what it does after power-on"""
        return False

    def forget(self):
        """What was received is lost."""
        self.day = 0

    def streaming(self):
        """Whether reports go on although nothing is touched."""
        return False

    def hears(self):
        """Whether a frame gets as far as the LCD."""
        return True

    def refreshes(self):
        """Whether the LCD follows what it is told."""
        return True

    def marks(self):
        """What the LCD shows of the pendant's own state."""
        return (self.model.selector_name(self.selector),)

    def _touched(self):
        self.quiet_since = time.monotonic()
