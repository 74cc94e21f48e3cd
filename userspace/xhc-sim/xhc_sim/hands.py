# SPDX-License-Identifier: GPL-2.0-only
"""Keys, wheel and selector -> input reports: a state machine independent of the bus.

Report of the HB03 and HB04: id, key, key, selector, wheel, day XOR first key.
"""

import time

from .wire import INPUT_ID

SLEEP_AFTER = 30.0          # seconds without operation until the radio falls asleep
SLEEP_REPORT = bytes([INPUT_ID, 0, 0, 0, 0, 0])


class Pendant:
    """Two key slots, a selector, a wheel, the day last received, sleep: the HB03 and HB04.

    Base class for other models.
    """

    def __init__(self, model):
        self.model = model
        self.slots = [0, 0]
        self.selector = model.selector['off']
        self.day = 0
        self.awake = True
        self.quiet_since = time.monotonic()

    def report(self, wheel=0):
        """The input report for the current state; any operation wakes a sleeping pendant."""
        self.awake = True
        first, second = self.slots
        return bytes([INPUT_ID, first, second, self.selector, wheel & 0xFF, self.day ^ first])

    def press(self, code):
        """A third key is ignored: the report has two slots."""
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
        """Falls asleep; held keys are forgotten, as by real pendants."""
        self.awake = False
        self.slots = [0, 0]
        return SLEEP_REPORT

    def after_sleep(self):
        """The reports that follow that of sleep()."""
        return []

    def wake(self):
        self._touched()
        return self.report()

    def sleepy(self, now=None):
        """True after SLEEP_AFTER seconds without operation."""
        now = time.monotonic() if now is None else now
        return self.awake and not any(self.slots) and now - self.quiet_since >= SLEEP_AFTER

    def receive(self, picture):
        """A frame was received."""
        self.day = picture.day

    def power_on(self):
        """At power-on; -> whether the LCD then shows its power-on contents"""
        return False

    def forget(self):
        """Received data are lost."""
        self.day = 0

    def streaming(self):
        """Whether reports are sent without operation."""
        return False

    def hears(self):
        """Whether a frame reaches the LCD."""
        return True

    def refreshes(self):
        """Whether the LCD is updated."""
        return True

    def marks(self):
        """What the LCD shows of the pendant's own state."""
        return (self.model.selector_name(self.selector),)

    def _touched(self):
        self.quiet_since = time.monotonic()
