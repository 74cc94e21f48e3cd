# SPDX-License-Identifier: GPL-2.0-only
"""The pendant's wheel, rotary, selector and keys, from its event node."""

import fcntl
import glob
import os
import struct

EVENT = struct.Struct('llHHi')              # struct input_event
EV_SYN, EV_KEY, EV_REL, EV_ABS = 0, 1, 2, 3
SYN_DROPPED = 3
REL_DIAL, ABS_THROTTLE = 7, 6
BUTTONS = 0x2bf                             # BTN_TRIGGER_HAPPY1 is number 1
SELECTOR = 30                               # its positions have the numbers from 31 on
LAST = 40
KEY_STATE = 0x300 // 8                      # bytes


def ask(number, size):
    """The number of an ioctl that reads"""
    return 2 << 30 | size << 16 | ord('E') << 8 | number


EVIOCGKEY = ask(0x18, KEY_STATE)
EVIOCGABS_THROTTLE = ask(0x40 + ABS_THROTTLE, 24)


class Events:
    """An open node. `down` has the numbers of the buttons that are down, keys and selector."""

    def __init__(self, path, where='/dev/input'):
        """`path` is the pendant's in sysfs; OSError while udevd has not come to the node."""
        nodes = glob.glob(path + '/input/input*/event*')
        if not nodes:
            raise FileNotFoundError(2, 'no event node')
        self.file = os.open(os.path.join(where, os.path.basename(nodes[0])),
                            os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        self.down = set()
        self.rotary = 0
        self.waiting = []               # events still to be looked at
        try:
            self._look_at_all()
        except OSError:
            self.close()
            raise

    def _look_at_all(self):
        state = fcntl.ioctl(self.file, EVIOCGKEY, bytes(KEY_STATE))
        self.down = {number for number in range(1, LAST + 1)
                     if state[(BUTTONS + number) // 8] >> (BUTTONS + number) % 8 & 1}
        try:
            self.rotary, = struct.unpack_from(
                'i', fcntl.ioctl(self.file, EVIOCGABS_THROTTLE, bytes(24)))
        except OSError:
            self.rotary = 0             # this model has none

    def read(self):
        """-> detents since the last time, but none from after the selector has moved; OSError when
        the pendant has gone. A button that goes down and up again is down once before it is up.
        """
        self._fill()
        detents = 0
        pressed = set()
        while self.waiting:
            _, _, kind, code, value = self.waiting[0]
            number = code - BUTTONS
            if kind == EV_KEY and (not value and number in pressed or
                                   detents and number > SELECTOR):
                break
            del self.waiting[0]
            if kind == EV_SYN and code == SYN_DROPPED:
                self.waiting.clear()
                self._look_at_all()
            elif kind == EV_KEY and value and 1 <= number <= LAST:
                self.down.add(number)
                pressed.add(number)
            elif kind == EV_KEY:
                self.down.discard(number)
            elif (kind, code) == (EV_REL, REL_DIAL):
                detents += value
            elif (kind, code) == (EV_ABS, ABS_THROTTLE):
                self.rotary = value
        return detents

    def _fill(self):
        while True:
            try:
                data = os.read(self.file, 64 * EVENT.size)
            except BlockingIOError:
                return
            self.waiting += EVENT.iter_unpack(data)

    def close(self):
        os.close(self.file)
