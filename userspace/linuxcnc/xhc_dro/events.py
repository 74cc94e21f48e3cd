# SPDX-License-Identifier: GPL-2.0-only
"""The pendant's wheel, rotary, selector and keys, from its event node."""

import fcntl
import glob
import os
import struct

from .keys import LAST

EVENT = struct.Struct('llHHi')              # struct input_event
KEYMAP = struct.Struct('BBHII28x')          # struct input_keymap_entry, scan code of four bytes
EV_SYN, EV_KEY, EV_REL, EV_ABS, EV_MSC = 0, 1, 2, 3, 4
SYN_DROPPED = 3
REL_DIAL, ABS_THROTTLE, ABS_MISC, MSC_SCAN = 7, 6, 0x28, 4
KEY_STATE = 0x300 // 8                      # bytes


def ask(number, size):
    """The number of an ioctl that reads"""
    return 2 << 30 | size << 16 | ord('E') << 8 | number


EVIOCGKEYCODE = ask(0x04, KEYMAP.size)      # the second version
EVIOCGKEY = ask(0x18, KEY_STATE)
EVIOCGABS = {axis: ask(0x40 + axis, 24) for axis in (ABS_THROTTLE, ABS_MISC)}


class Events:
    """An open node. `down` has the numbers of the keys that are down; `selector` and `rotary` are
    positions. The numbers are those of the scan codes, whatever key codes a layout has for them.
    """

    def __init__(self, path, where='/dev/input'):
        """`path` is the pendant's in sysfs; OSError while udevd has not come to the node."""
        nodes = glob.glob(path + '/input/input*/event*')
        if not nodes:
            raise FileNotFoundError(2, 'no event node')
        self.file = os.open(os.path.join(where, os.path.basename(nodes[0])),
                            os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        self.down = set()
        self.codes = {}                 # number: key code, as it was when the key went down
        self.selector = self.rotary = 0
        self.scan = None                # of the next key
        self.waiting = []               # events still to be looked at
        try:
            self._look_at_all()
        except OSError:
            self.close()
            raise

    def _look_at_all(self):
        state = fcntl.ioctl(self.file, EVIOCGKEY, bytes(KEY_STATE))
        self.codes = {number: self._keycode(number) for number in range(1, LAST + 1)}
        self.down = {number for number, code in self.codes.items()
                     if code and state[code // 8] >> code % 8 & 1}
        self.selector = self._position(ABS_MISC)
        try:
            self.rotary = self._position(ABS_THROTTLE)
        except OSError:
            self.rotary = 0             # this model has none

    def _keycode(self, number):
        """What a layout has for a scan code; 0 is nothing."""
        try:
            entry = fcntl.ioctl(self.file, EVIOCGKEYCODE, KEYMAP.pack(0, 4, 0, 0, number))
        except OSError:
            return 0                    # this model has fewer keys
        return KEYMAP.unpack(entry)[3]

    def _position(self, axis):
        return struct.unpack_from('i', fcntl.ioctl(self.file, EVIOCGABS[axis], bytes(24)))[0]

    def read(self):
        """-> detents since the last time, but none from after the selector or the rotary has moved,
        or a key has gone down, which may change what a detent does; OSError when the pendant has
        gone. A button that goes down and up again is down once before it is up.
        """
        self._fill()
        detents = 0
        pressed = set()
        while self.waiting:
            _, _, kind, code, value = self.waiting[0]
            if kind == EV_KEY and not value and self.scan in pressed:
                break
            if detents and (kind == EV_ABS or (kind == EV_KEY and value)):
                break
            del self.waiting[0]
            if kind == EV_SYN and code == SYN_DROPPED:
                self.waiting.clear()
                self.scan = None
                self._look_at_all()
            elif kind == EV_SYN:
                self.scan = None        # its key came in the same report, or never comes
            elif (kind, code) == (EV_MSC, MSC_SCAN):
                self.scan = value
            elif kind == EV_KEY and value and self.scan:
                self.down.add(self.scan)
                self.codes[self.scan] = code
                pressed.add(self.scan)
                self.scan = None
            elif kind == EV_KEY and not value:      # the selector's have no scan code
                self.down -= {number for number in self.down
                              if code == self.codes[number] or number == self.scan}
                self.scan = None
            elif (kind, code) == (EV_REL, REL_DIAL):
                detents += value
            elif (kind, code) == (EV_ABS, ABS_MISC):
                self.selector = value
            elif (kind, code) == (EV_ABS, ABS_THROTTLE):
                self.rotary = value
        return detents

    def touched(self):
        """-> the numbers of the keys that are down, or go down or up in the events that wait"""
        return self.down | {value for _, _, kind, code, value in self.waiting
                            if (kind, code) == (EV_MSC, MSC_SCAN)}

    def _fill(self):
        while True:
            try:
                data = os.read(self.file, 64 * EVENT.size)
            except BlockingIOError:
                return
            self.waiting += EVENT.iter_unpack(data)

    def close(self):
        os.close(self.file)
