# SPDX-License-Identifier: GPL-2.0-only
"""The device itself: what is pressed and turned -> input reports; feature reports -> the LCD.

`Pendant` is the state machine, free of any bus.  `VirtualPendant` adds what every bus needs: the
record of what the host sent, the faults, and somewhere to wait.  uhid.py and usb.py complete it.
"""

import errno
import threading
import time
from collections import deque

from .lcd import Assembler, Picture, blank
from .models import CHUNK_SIZE, FEATURE_ID, INPUT_ID, INPUT_SIZE, get_model

SLEEP_AFTER = 30.0          # seconds without a key, then the radio goes to sleep
SLEEP_REPORT = bytes([INPUT_ID]) + bytes(INPUT_SIZE - 1)
FEATURE_WVALUE = 0x0300 | FEATURE_ID
HISTORY = 8192              # feature reports and frames that are remembered


class NoDevice(OSError):
    """This kernel lacks what the pendant would be plugged into, or we may not use it."""


class Pendant:
    """Two key slots, a selector, a wheel, the day last received, sleep."""

    def __init__(self, model):
        self.model = model
        self.slots = [0, 0]
        self.selector = 0
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

    def wake(self):
        self._touched()
        return self.report()

    def sleepy(self, now=None):
        """True once nothing has been touched for SLEEP_AFTER seconds."""
        now = time.monotonic() if now is None else now
        return self.awake and not any(self.slots) and now - self.quiet_since >= SLEEP_AFTER

    def _touched(self):
        self.quiet_since = time.monotonic()


class SetReport:
    """One SET_REPORT request as it came from the host."""

    __slots__ = ('time', 'wvalue', 'windex', 'data', 'status')

    def __init__(self, wvalue, windex, data):
        self.time = time.monotonic()
        self.wvalue = wvalue
        self.windex = windex
        self.data = bytes(data)
        self.status = 0             # what the host got: 0, or a negative errno

    def __repr__(self):
        return 'SetReport(wvalue=%#06x, windex=%d, data=%s, status=%d)' % (
            self.wvalue, self.windex, self.data.hex(' '), self.status)


class Fault:
    """What happens to a SET_REPORT request: "none", or KIND or KIND:ARGUMENT as below.

    stall       refused (-EPIPE on USB, -EIO over uhid)
    timeout     never answered
    slow:MS     answered after MS milliseconds
    unplug      the cable is cut instead of an answer
    """

    KINDS = ('none', 'stall', 'timeout', 'slow', 'unplug')

    def __init__(self, text='none', skip=0, count=None):
        self.kind, _, argument = text.partition(':')
        if self.kind not in self.KINDS or bool(argument) != (self.kind == 'slow'):
            raise ValueError('unknown fault: %s' % text)
        self.seconds = int(argument) / 1000 if argument else 0.0
        self.skip = skip            # this many requests go well first
        self.count = count          # then this many are hit; None: all

    def strike(self):
        """-> the kind to apply to the request at hand"""
        if self.kind == 'none' or self.count == 0:
            return 'none'
        if self.skip > 0:
            self.skip -= 1
            return 'none'
        if self.count is not None:
            self.count -= 1
        return self.kind


class VirtualPendant:
    """A pendant with a memory of what the host sent to it.  Subclasses bring the bus:
    plug(), unplug(), report(data), and the calls of set_report().

    lcd           the last Picture, None before the first frame
    set_reports   every SetReport, oldest first
    frames        (time, frame) of every whole frame
    on_frame      called with each new Picture, in the bus's thread
    """

    def __init__(self, model='HB04', report_descriptor=None):
        self.model = get_model(model) if isinstance(model, str) else model
        self.report_descriptor = (self.model.report_descriptor if report_descriptor is None
                                  else bytes(report_descriptor))
        self.pendant = Pendant(self.model)
        self.changed = threading.Condition()
        self.set_reports = deque(maxlen=HISTORY)
        self.frames = deque(maxlen=HISTORY)
        self.frame_count = 0
        self.assembler = Assembler(self.model)
        self.lcd = None
        self.on_frame = None
        self.plugged = False
        self._fault = Fault()

    # --- faults ---------------------------------------------------------------------------

    @property
    def fault(self):
        return self._fault.kind

    @fault.setter
    def fault(self, text):
        self._fault = Fault(text or 'none')

    def set_fault(self, text, skip=0, count=None):
        """Let `skip` SET_REPORT requests pass, then hit `count` of them (None: all)."""
        self._fault = Fault(text, skip, count)

    # --- what the host sends --------------------------------------------------------------

    def set_report(self, wvalue, windex, data):
        """For the bus: records a request and says what to do with it.

        -> (kind, seconds): kind of Fault, and how long to hold the answer back
        """
        request = SetReport(wvalue, windex, data)
        picture = None
        with self.changed:
            fault = self._fault
            kind = fault.strike()
            if kind == 'stall':
                request.status = -errno.EPIPE
            elif kind == 'timeout':
                request.status = -errno.ETIMEDOUT
            elif kind == 'unplug':
                request.status = -errno.ENODEV
            elif wvalue == FEATURE_WVALUE:
                picture = self._chunk(request.data)
            self.set_reports.append(request)
            self.changed.notify_all()
        if picture and self.on_frame:
            self.on_frame(picture)
        return kind, fault.seconds if kind == 'slow' else 0.0

    def _chunk(self, data):
        if len(data) != 1 + CHUNK_SIZE or data[0] != FEATURE_ID:
            self.assembler.stray += 1
            return None
        frame = self.assembler.feed(data[1:])
        if frame is None:
            return None
        self.lcd = Picture(self.model, frame)
        self.pendant.day = self.lcd.day
        self.frames.append((time.monotonic(), frame))
        self.frame_count += 1
        return self.lcd

    # --- the bus --------------------------------------------------------------------------

    def plug(self):
        raise NotImplementedError

    def unplug(self):
        raise NotImplementedError

    def report(self, data):
        raise NotImplementedError

    # --- hands ----------------------------------------------------------------------------

    def press(self, code):
        self.report(self.pendant.press(code))

    def release(self, code):
        self.report(self.pendant.release(code))

    def select(self, code):
        self.report(self.pendant.select(code))

    def turn(self, detents):
        self.report(self.pendant.turn(detents))

    def sleep(self):
        self.report(self.pendant.sleep())

    def wake(self):
        self.report(self.pendant.wake())

    # --- waiting --------------------------------------------------------------------------

    def wait_for(self, predicate, timeout=5.0):
        """Waits until predicate() holds, looked at after each request; -> its last value"""
        with self.changed:
            return self.changed.wait_for(predicate, timeout)

    def wait_frames(self, count, timeout=5.0):
        """Waits until `count` frames have come since the device was made."""
        return self.wait_for(lambda: self.frame_count >= count, timeout)

    def screen(self):
        """The LCD as lines of text."""
        if self.lcd is None:
            return blank(self.model, self.pendant.awake)
        return self.lcd.lines(self.pendant.awake,
                              self.model.selector_name(self.pendant.selector))
