# SPDX-License-Identifier: GPL-2.0-only
"""The line of a head: a pseudo terminal, a socket, a file or a real tty.

A line loses no byte while the other end is connected: data that cannot be written at once are
queued. Bytes received from the other end are counted and discarded.
"""

import collections
import contextlib
import errno
import math
import os
import select
import socket
import stat
import termios
import time

from . import wire

LOOK_AGAIN = 0.05           # seconds between polls of a pseudo terminal that is not open
PACE_TICK = 0.01            # seconds between portions on a paced line
RETRY = 0.1                 # seconds between attempts to connect

SPEEDS = {getattr(termios, name): int(name[1:]) for name in dir(termios)
          if name[0] == 'B' and name[1:].isdigit()}
SPEED_NUMBERS = {rate: number for number, rate in SPEEDS.items()}

GONE = (errno.EPIPE, errno.ECONNRESET, errno.EIO, errno.ENXIO, errno.ENODEV, errno.ENOTCONN)


class LineError(Exception):
    """The line cannot be opened, or is lost permanently."""


class Line:
    """An open file descriptor as a line; the base of the others.

    on_open and on_close are called when the other end connects and disconnects.
    """

    comes_back = False          # whether another end may connect after this one

    def __init__(self, fd=None, name='', pace=False):
        self.name = name
        self.fd = fd
        self.is_open = fd is not None
        self.openings = int(self.is_open)
        self.pending = 0                    # queued bytes
        self.unsent = 0                     # bytes that were queued at disconnects
        self.received = 0
        self.rate = wire.DEFAULT_RATE
        self.pace = pace
        self.on_open = self.on_close = lambda: None
        self._forced_rate = None
        self._queue = collections.deque()
        self._credit = 0.0                  # bytes that may be sent now, if paced
        self._credit_time = time.monotonic()
        if fd is not None:
            os.set_blocking(fd, False)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # --- for the head ---------------------------------------------------------------------

    def send(self, data):
        if self.is_open and data:
            self._queue.append(memoryview(data))
            self.pending += len(data)
            if len(self._queue) == 1:
                self._write()

    def set_rate(self, rate):
        """Sets the rate at which the head sends."""
        self.rate = rate

    def uart_rate(self):
        """The rate of the host, None if the line does not provide it."""
        return self._forced_rate

    def force_uart_rate(self, rate):
        """Sets the rate of the host for lines that do not provide it; None resets it."""
        self._forced_rate = rate

    # --- for the loop ---------------------------------------------------------------------

    def watch(self):
        """-> {fd: poll events}"""
        if not self.is_open:
            return {}
        blocked = self.pending and not self._paced_out()
        return {self.fd: select.POLLIN | (select.POLLOUT if blocked else 0)}

    def tick(self, now):
        """Timed actions. -> time of the next call, math.inf for never"""
        if self.is_open and self.pending and self.pace:
            self._write()
            return now + PACE_TICK
        return math.inf

    def handle(self, fd, events):
        """fd is one of those of watch()"""
        if self.is_open and events & select.POLLIN:
            self._read()
        if self.is_open and events & select.POLLOUT:
            self._write()
        if self.is_open and events & (select.POLLHUP | select.POLLERR) \
                and not events & select.POLLIN:
            self._gone()

    def close(self):
        if self.fd is not None:
            os.close(self.fd)
            self.fd = None
        self.is_open = False

    # --- internal -------------------------------------------------------------------------

    def _paced_out(self):
        return self.pace and self._credit < 1

    def _earn(self):
        """A byte has ten bits; the credit is limited to a tenth of a second."""
        now = time.monotonic()
        self._credit = min(self._credit + (now - self._credit_time) * self.rate / 10,
                           self.rate / 100)
        self._credit_time = now

    def _write(self):
        if self.pace:
            self._earn()
        while self._queue and not self._paced_out():
            data = self._queue[0]
            portion = data[:int(self._credit)] if self.pace else data
            try:
                count = os.write(self.fd, portion)
            except BlockingIOError:
                return
            except OSError as error:
                self._failed(error)
                return
            self.pending -= count
            self._credit -= count
            if count == len(data):
                self._queue.popleft()
            else:
                self._queue[0] = data[count:]
            if count < len(portion):
                return

    def _read(self):
        try:
            data = os.read(self.fd, 65536)
        except BlockingIOError:
            return
        except OSError as error:
            self._failed(error)
            return
        if data:
            self.received += len(data)
        else:
            self._gone()

    def _failed(self, error):
        if error.errno not in GONE:
            raise LineError('%s: %s' % (self.name, error.strerror)) from None
        self._gone()

    def _come(self):
        self.is_open = True
        self.openings += 1
        self.on_open()

    def _gone(self):
        self.is_open = False
        self.unsent += self.pending
        self.pending = 0
        self._queue.clear()
        self.on_close()


class Pty(Line):
    """A new pseudo terminal; link is the path of a symbolic link to create.

    The line is open while another program has the terminal open. The speed set by that program is
    the rate of the UART: if it differs from the rate of the head, garbage is received.
    """

    comes_back = True

    def __init__(self, link=None, pace=False):
        master, slave = os.openpty()
        super().__init__(master, os.ttyname(slave), pace)
        self.is_open, self.openings = False, 0
        self._set_up(wire.DEFAULT_RATE)
        os.close(slave)                     # from here on the kernel reports POLLHUP
        self._link = link
        self._poll = select.poll()
        self._poll.register(master, 0)
        if link is not None:
            try:
                _remove(link, stat.S_ISLNK)
                os.symlink(self.name, link)
            except OSError as error:
                self._link = None
                self.close()
                raise LineError('%s: %s' % (link, error.strerror)) from None

    def _set_up(self, rate=None):
        """Sets raw mode, as a line discipline expects it; a hangup resets it."""
        modes = termios.tcgetattr(self.fd)
        modes[0:4] = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0]
        if rate is not None:
            modes[4:6] = [SPEED_NUMBERS[rate]] * 2
        termios.tcsetattr(self.fd, termios.TCSANOW, modes)

    def set_uart_rate(self, rate):
        """As if the other program had set its speed."""
        self._set_up(rate)

    def uart_rate(self):
        if self._forced_rate is not None or self.fd is None:
            return self._forced_rate
        return SPEEDS.get(termios.tcgetattr(self.fd)[5], 0)

    def tick(self, now):
        if self.is_open:
            return super().tick(now)
        if any(events & select.POLLHUP for _, events in self._poll.poll(0)):
            return now + LOOK_AGAIN
        self._come()
        return now

    def _gone(self):
        self._set_up()
        self._flush()
        super()._gone()

    def _flush(self):
        """Drops old bytes before the next open, which requires the slave side."""
        try:
            slave = os.open(self.name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError:
            return                          # another program has exclusive access (TIOCEXCL)
        with contextlib.suppress(termios.error):
            termios.tcflush(slave, termios.TCIFLUSH)
        os.close(slave)

    def close(self):
        if self._link is not None:
            _remove(self._link, stat.S_ISLNK)
            self._link = None
        super().close()


class Client(Line):
    """A socket that connects to an address; wait: seconds for which it retries."""

    def __init__(self, address, wait=5.0, pace=False):
        super().__init__(None, address, pace)
        self._socket = None
        deadline = time.monotonic() + wait
        while True:
            family, place = _parse_address(address)
            self._socket = socket.socket(family, socket.SOCK_STREAM)
            try:
                self._socket.connect(place)
                break
            except OSError as error:
                self._socket.close()
                if time.monotonic() >= deadline:
                    raise LineError('%s: %s' % (address, error.strerror)) from None
            time.sleep(RETRY)
        self._socket.setblocking(False)
        self.fd = self._socket.fileno()
        self.is_open, self.openings = True, 1

    def close(self):
        self.fd, self.is_open = None, False
        self._socket.close()


class Server(Line):
    """A socket that listens at an address, for one connection at a time."""

    comes_back = True

    def __init__(self, address, pace=False):
        super().__init__(None, address, pace)
        self._peer = self._path = None
        family, place = _parse_address(address)
        self._listener = socket.socket(family, socket.SOCK_STREAM)
        try:
            if family == socket.AF_UNIX:
                _remove_stale(place)
            else:
                self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            self._listener.bind(place)
            self._listener.listen(1)
        except OSError as error:
            self._listener.close()
            raise LineError('%s: %s' % (address, error.strerror)) from None
        if family == socket.AF_UNIX:
            self._path = place
        else:
            self.name = 'tcp:%d' % self._listener.getsockname()[1]
        self._listener.setblocking(False)

    def watch(self):
        return {self._listener.fileno(): select.POLLIN, **super().watch()}

    def handle(self, fd, events):
        if fd != self._listener.fileno():
            super().handle(fd, events)
            return
        try:
            peer, _ = self._listener.accept()
        except OSError:
            return                          # disconnected meanwhile
        if self.is_open:
            peer.close()
            return
        peer.setblocking(False)
        self._peer, self.fd = peer, peer.fileno()
        self._come()

    def _gone(self):
        self._peer.close()
        self._peer = self.fd = None
        super()._gone()

    def close(self):
        if self._peer is not None:
            self._peer.close()
        self._peer, self.fd, self.is_open = None, None, False
        self._listener.close()
        if self._path is not None:
            _remove(self._path, stat.S_ISSOCK)
            self._path = None


class File(Line):
    """A file, a FIFO or a real tty; a tty is set to raw mode and to the rate of the head."""

    def __init__(self, path, pace=False):
        super().__init__(None, path, pace)
        self._is_tty = False
        try:
            self.fd = os.open(path, self._flags(path), 0o666)
        except OSError as error:
            raise LineError('%s: %s' % (path, error.strerror)) from None
        self._is_tty = os.isatty(self.fd)
        self.is_open, self.openings = True, 1
        self.set_rate(self.rate)

    @staticmethod
    def _flags(path):
        flags = os.O_NOCTTY | os.O_NONBLOCK
        if os.path.exists(path) and stat.S_ISCHR(os.stat(path).st_mode):
            return flags | os.O_RDWR
        return flags | os.O_WRONLY | os.O_CREAT | os.O_TRUNC

    def watch(self):
        reads = select.POLLIN if self._is_tty else 0
        return {fd: events & (select.POLLOUT | reads) for fd, events in super().watch().items()}

    def set_rate(self, rate):
        super().set_rate(rate)
        if self._is_tty:
            modes = termios.tcgetattr(self.fd)
            modes[0:4] = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL, 0]
            modes[4:6] = [SPEED_NUMBERS[rate]] * 2
            termios.tcsetattr(self.fd, termios.TCSADRAIN, modes)


def _parse_address(text):
    """'unix:PATH', 'tcp:PORT' or 'tcp:HOST:PORT' (of this machine) -> family, address"""
    kind, _, rest = text.partition(':')
    if kind == 'unix' and rest:
        return socket.AF_UNIX, rest
    host, _, port = rest.rpartition(':')
    host = host or '127.0.0.1'
    if kind == 'tcp' and port.isascii() and port.isdigit() and int(port) < 65536:
        if host == 'localhost' or host.startswith('127.'):
            return socket.AF_INET, (host, int(port))
        raise LineError('%s: not an address of this machine' % text)
    raise LineError('%s: not unix:PATH, tcp:PORT or tcp:HOST:PORT' % text)


def check_address(text):
    """LineError if the address is invalid."""
    _parse_address(text)


def _remove(path, is_kind):
    """Removes a file of that kind, and keeps any other."""
    try:
        if is_kind(os.lstat(path).st_mode):
            os.unlink(path)
    except FileNotFoundError:
        pass


def _remove_stale(path):
    """Removes a socket that no program listens on."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        try:
            probe.connect(path)
        except ConnectionRefusedError:
            _remove(path, stat.S_ISSOCK)
        except OSError:
            pass
