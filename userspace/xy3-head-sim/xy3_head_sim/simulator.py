# SPDX-License-Identifier: GPL-2.0-only
"""A head on its line: one event loop for both."""

import math
import select
import time

from .line import LineError

AHEAD = 262144              # bytes of a stream that may be queued


class Timeout(Exception):
    """An event has not occurred in time."""


class Simulator:
    """Runs a Head on a Line; say(event, **members) is called for events of the line."""

    def __init__(self, head, line, say=lambda event, **members: None):
        self.head = head
        self.line = line
        self.say = say
        self._streaming = False
        self._readers = {}
        self._uart_rate = line.uart_rate()
        head.line = line
        line.set_rate(head.rate)
        line.on_open, line.on_close = self._opened, self._closed
        if line.is_open:
            head.begin()

    def read_also(self, fd, call):
        """Calls call() when fd can be read; None stops this."""
        if call is None:
            self._readers.pop(fd, None)
        else:
            self._readers[fd] = call

    def run(self, until=lambda: False, timeout=math.inf):
        """Runs until until() is true or the timeout expires. -> whether it is true"""
        deadline = time.monotonic() + timeout
        while not until():
            if time.monotonic() >= deadline:
                return False
            self._step(deadline)
        return True

    def wait_open(self, timeout=math.inf):
        self._wait(lambda: self.line.is_open, timeout, 'the line was not opened')

    def wait_closed(self, timeout=math.inf):
        self._wait(lambda: not self.line.is_open, timeout, 'the line is still open')

    def flush(self, timeout=math.inf):
        """Waits until all data are in the buffers of the other end."""
        self._wait(lambda: not self.line.pending, timeout, 'the other end does not read')

    def stream(self, packets=0, size=0, timeout=math.inf):
        """Sends a number of packets or bytes as fast as possible, and nothing else."""
        deadline = time.monotonic() + timeout
        self._streaming = True
        try:
            self.wait_open(timeout)
            opening = self.line.openings
            for _ in self.head.stream(packets, size):
                if time.monotonic() >= deadline:
                    raise Timeout('the stream takes too long')
                self._wait(lambda: self.line.pending < AHEAD or self._ended(opening),
                           deadline - time.monotonic(), 'the other end does not read')
                if self._ended(opening):
                    break
            self.flush(deadline - time.monotonic())
        finally:
            self._streaming = False
        if self._ended(opening):
            raise LineError('%s: the other end disconnected during the stream' % self.line.name)

    # --- internal -------------------------------------------------------------------------

    def _ended(self, opening):
        return not self.line.is_open or self.line.openings != opening

    def _wait(self, until, timeout, complaint):
        if not self.run(until, max(timeout, 0)):
            raise Timeout(complaint)

    def _step(self, deadline):
        """Performs timed actions, and waits for the next event."""
        now = time.monotonic()
        wake = min(deadline, self.line.tick(now))
        if not self._streaming:
            wake = min(wake, self.head.tick(now))
        self._watch_rate()
        poll = select.poll()
        watched = self.line.watch()
        for fd, events in watched.items():
            poll.register(fd, events)
        for fd in self._readers:
            poll.register(fd, select.POLLIN)
        left = max(wake - time.monotonic(), 0)
        for fd, events in poll.poll(None if math.isinf(left) else math.ceil(left * 1000)):
            if fd in self._readers:
                self._readers[fd]()
            else:
                self.line.handle(fd, events)

    def _watch_rate(self):
        rate = self.line.uart_rate()
        if rate != self._uart_rate:
            self._uart_rate = rate
            self.say('uart', rate=rate)

    def _opened(self):
        self.say('opened')
        self.head.begin()

    def _closed(self):
        self.say('closed')
        if not self.line.comes_back:
            raise LineError('%s: the other end has disconnected' % self.line.name)
