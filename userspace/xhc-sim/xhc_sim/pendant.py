# SPDX-License-Identifier: GPL-2.0-only
"""The device: operation -> input reports; feature reports -> the LCD.

The model's row names the state machine of the reports (`Pendant`, independent of the bus) and the
decoder of frames.  `VirtualPendant` adds what all buses require: a record of received requests,
faults, streamed reports, and waiting.  uhid.py and usb.py derive from it.
"""

import errno
import threading
import time
from collections import deque

from .hands import SLEEP_REPORT, Pendant
from .lcd import Assembler
from .models import get_model
from .wire import CHUNK_SIZE, FEATURE_ID

__all__ = ['Fault', 'NoDevice', 'Pendant', 'SLEEP_REPORT', 'SetReport', 'VirtualPendant']

FEATURE_WVALUE = 0x0300 | FEATURE_ID
HISTORY = 8192              # number of recorded feature reports and frames


class NoDevice(OSError):
    """The kernel lacks the interface for the virtual pendant, or permission is denied."""


class SetReport:
    """One SET_REPORT request as received from the host."""

    __slots__ = ('time', 'wvalue', 'windex', 'data', 'status')

    def __init__(self, wvalue, windex, data):
        self.time = time.monotonic()
        self.wvalue = wvalue
        self.windex = windex
        self.data = bytes(data)
        self.status = 0             # answer to the host: 0, or a negative errno

    def __repr__(self):
        return 'SetReport(wvalue=%#06x, windex=%d, data=%s, status=%d)' % (
            self.wvalue, self.windex, self.data.hex(' '), self.status)


class Fault:
    """Fault of a SET_REPORT request: "none", or KIND or KIND:ARGUMENT as below.

    stall       refused (-EPIPE on USB, -EIO over uhid)
    timeout     never answered
    slow:MS     answered after MS milliseconds
    unplug      unplugged instead of answered
    """

    KINDS = ('none', 'stall', 'timeout', 'slow', 'unplug')

    def __init__(self, text='none', skip=0, count=None):
        self.kind, _, argument = text.partition(':')
        if self.kind not in self.KINDS or bool(argument) != (self.kind == 'slow'):
            raise ValueError('unknown fault: %s' % text)
        self.seconds = int(argument) / 1000 if argument else 0.0
        self.skip = skip            # number of requests before the first fault
        self.count = count          # number of requests with the fault; None: all

    def strike(self):
        """-> the kind to apply to the current request"""
        if self.kind == 'none' or self.count == 0:
            return 'none'
        if self.skip > 0:
            self.skip -= 1
            return 'none'
        if self.count is not None:
            self.count -= 1
        return self.kind


class VirtualPendant:
    """A pendant that records all requests of the host.  Subclasses implement the bus:
    plug(), unplug(), report(data), and the calls of set_report().

    lcd           the last Picture, None before the first frame
    seen          the Picture that the LCD shows, which is not always the last one
    streams       False: no streamed reports, which is easier for a driver than hardware
    radio         False: out of range.  The receiver answers the host; reports and frames are lost
    set_reports   all SetReports, oldest first
    frames        (time, frame) of all complete frames
    on_frame      called with each new Picture, in the thread of the bus
    """

    def __init__(self, model='HB04', report_descriptor=None):
        self.model = get_model(model) if isinstance(model, str) else model
        self.report_descriptor = (self.model.report_descriptor if report_descriptor is None
                                  else bytes(report_descriptor))
        self.pendant = self.model.hands(self.model)
        self.changed = threading.Condition()
        self.set_reports = deque(maxlen=HISTORY)
        self.frames = deque(maxlen=HISTORY)
        self.frame_count = 0
        self.assembler = Assembler(self.model)
        self.lcd = None
        self.seen = None
        self.on_frame = None
        self.plugged = False
        self.streams = True
        self.radio = True
        self._fault = Fault()
        self._heard = None          # the last Picture that reached the LCD
        self._marks = ()            # what the LCD shows of the pendant's own state
        self._moving = threading.RLock()    # reports leave in the order in which they were made
        self._streamer = None

    # --- faults ---------------------------------------------------------------------------

    @property
    def fault(self):
        return self._fault.kind

    @fault.setter
    def fault(self, text):
        self._fault = Fault(text or 'none')

    def set_fault(self, text, skip=0, count=None):
        """Skip `skip` SET_REPORT requests, then apply the fault to `count` (None: all)."""
        self._fault = Fault(text, skip, count)

    # --- requests of the host -------------------------------------------------------------

    def set_report(self, wvalue, windex, data):
        """For the bus: records a request and returns how to answer it.

        -> (kind, seconds): kind of Fault, and the delay of the answer
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
        self.lcd = self.model.picture(self.model, frame)
        self.pendant.receive(self.lcd)
        if self.radio and self.pendant.hears():
            self._heard = self.lcd
        self._refresh()
        self.frames.append((time.monotonic(), frame))
        self.frame_count += 1
        return self.lcd

    def forget(self):
        """Possible effect of a reset: no day, an empty LCD, no incomplete frame."""
        with self.changed:
            self.pendant.forget()
            self.lcd = self.seen = self._heard = None
            self.assembler = Assembler(self.model)

    # --- the bus --------------------------------------------------------------------------

    def plug(self):
        raise NotImplementedError

    def unplug(self):
        raise NotImplementedError

    def report(self, data):
        raise NotImplementedError

    def pending(self):
        """Number of input reports that the host has not fetched yet, if known."""
        return 0

    # --- hands ----------------------------------------------------------------------------

    def press(self, code):
        self._move(self.pendant.press, code)

    def release(self, code):
        self._move(self.pendant.release, code)

    def select(self, code):
        self._move(self.pendant.select, code)

    def turn_feed(self, code):
        """Turns the second rotary switch; only for models that have one."""
        self._move(self.pendant.turn_feed, code)

    def turn(self, detents):
        self._move(self.pendant.turn, detents)

    def sleep(self):
        with self._moving:
            self._transmit(self.pendant.sleep())
            for data in self.pendant.after_sleep():
                self._transmit(data)
        self._moved()

    def wake(self):
        self._move(self.pendant.wake)

    def _transmit(self, data):
        if self.radio:
            self.report(data)

    def _move(self, move, *arguments):
        with self._moving:
            self._transmit(move(*arguments))
        self._moved()

    def _moved(self):
        with self.changed:
            self._refresh()
            self.changed.notify_all()

    # --- streamed reports -----------------------------------------------------------------

    def power_on(self):
        """For the bus, before the host detects the pendant."""
        with self.changed:
            if self.pendant.power_on():
                self._heard = self.seen = None

    def start_stream(self):
        """For the bus, once the pendant is plugged in."""
        if self.model.stream_period:
            self._streamer = threading.Thread(target=self._stream, daemon=True)
            try:
                self._streamer.start()
            except RuntimeError as error:       # no memory for a thread
                self.unplug()
                raise OSError(errno.ENOMEM, str(error)) from None

    def _stream(self):
        """Streams reports until the pendant is unplugged."""
        def ended():
            return not self.plugged or self._streamer is not threading.current_thread()

        while True:
            with self.changed:
                self.changed.wait_for(
                    lambda: ended() or self.streams and self.pendant.streaming())
            if ended():
                return
            with self._moving:
                if self.pendant.streaming() and not self.pending():
                    try:
                        self._transmit(self.pendant.report())
                    except OSError:
                        pass                # unplugged meanwhile
            time.sleep(self.model.stream_period)

    def _refresh(self):
        if self.pendant.refreshes():
            self.seen, self._marks = self._heard, self.pendant.marks()

    # --- waiting --------------------------------------------------------------------------

    def wait_for(self, predicate, timeout=5.0):
        """Waits until predicate() is true, checked after each request; -> its last value"""
        with self.changed:
            return self.changed.wait_for(predicate, timeout)

    def wait_frames(self, count, timeout=5.0):
        """Waits until `count` frames have been received since creation."""
        return self.wait_for(lambda: self.frame_count >= count, timeout)

    def screen(self):
        """The LCD as lines of text."""
        self._refresh()
        if self.seen is None:
            return self.model.blank(self.model, self.pendant.awake)
        return self.seen.lines(self.pendant.awake, *self._marks)
