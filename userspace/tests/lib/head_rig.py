# SPDX-License-Identifier: GPL-2.0-only
"""Fixtures for the tests of the scanhead's backchannel: the module, a UART whose other end is
controlled by the test, and access to all files of the head.

The tests run as root of the test kernel (uml/run-uml), never on the machine itself; XY3_MODULE
is the path of xy3.ko. They run in time-travel mode: no time passes while anything can run, so a
pause without data means that nothing is in progress, regardless of the load of the host.
"""

import errno
import fcntl
import glob
import os
import re
import select
import socket
import struct
import subprocess
import sys
import termios
import threading
import time
import tty
import case

import kernel
from kernel import read_file, wait, write_file

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, '..', '..', 'xy3-head-sim'))

from xy3_head_sim import wire  # noqa: E402

MODULE = 'xy3'
MODULE_FILE = os.environ.get('XY3_MODULE', '')
CLASS = '/sys/class/xy3'
LDISC, N_TTY = 29, 0
HEADS_MAX = 32
SPEEDS = {rate: getattr(termios, 'B%d' % rate) for rate in wire.RATES + (9600, 38400)}
SPEEDS[0] = termios.B0
STATS = ('rx_bytes', 'rx_packets', 'syncs', 'resyncs', 'dropped_bytes', 'bad_lengths',
         'unknown_packets', 'line_errors', 'lost_packets')
GOOD = wire.sync() * 2          # two packets that bring a receiver into sync


def load(parameters=''):
    kernel.load_module(MODULE_FILE, parameters)


def unload():
    kernel.remove_module(MODULE)


def heads():
    """-> ['xy3-0', ...] by number"""
    found = [name for name in os.listdir(CLASS) if name.startswith('xy3-')]
    return sorted(found, key=lambda name: int(name[4:]))


def set_ldisc(fd, number):
    fcntl.ioctl(fd, termios.TIOCSETD, struct.pack('i', number))


def get_speed(fd):
    """-> bit/s"""
    number = termios.tcgetattr(fd)[5]
    return next(rate for rate, speed in SPEEDS.items() if speed == number)


def set_speed(fd, rate):
    modes = termios.tcgetattr(fd)
    modes[4] = modes[5] = SPEEDS[rate]
    termios.tcsetattr(fd, termios.TCSANOW, modes)


def error_name(call, *arguments):
    """-> name of the error that the call ends with, or None"""
    try:
        call(*arguments)
    except OSError as error:
        return errno.errorcode[error.errno]
    return None


def polled(fd, events, timeout=2.0):
    """-> the pending poll events, 0 after the timeout"""
    poll = select.poll()
    poll.register(fd, events)
    return dict(poll.poll(timeout * 1000)).get(fd, 0)


class Background(threading.Thread):
    """A call that may block, in a separate thread."""

    def __init__(self, call, *arguments):
        super().__init__(daemon=True)
        self.call = call
        self.arguments = arguments
        self.returned = self.raised = None
        self.start()

    def run(self):
        try:
            self.returned = self.call(*self.arguments)
        except Exception as error:
            self.raised = error

    def result(self, timeout=60):
        """-> the return value of the call, which must return in time"""
        self.join(timeout)
        if self.is_alive():
            raise AssertionError('%s does not return' % self.call)
        if self.raised:
            raise self.raised
        return self.returned


def split(data):
    """The packets in data that were read; anything but complete packets is an error."""
    found = []
    at = 0
    while at < len(data):
        if data[at] != wire.START or len(data) < at + 3 or len(data) < at + 3 + data[at + 2]:
            raise AssertionError('byte %d of %d is no whole packet: %s'
                                 % (at, len(data), data[at:at + 16].hex(' ')))
        found.append(data[at:at + 3 + data[at + 2]])
        at += len(found[-1])
    return found


class Pty:
    """A UART: the head sends at the master, the slave is the tty."""

    def __init__(self, rate=wire.DEFAULT_RATE):
        self.master, self.slave = os.openpty()
        os.set_blocking(self.master, False)
        tty.setraw(self.slave)
        set_speed(self.slave, rate)
        self.node = os.ttyname(self.slave)

    def write(self, data, timeout=20.0):
        """Writes all data, or raises an error."""
        data = memoryview(data)
        while data:
            try:
                data = data[os.write(self.master, data):]
            except BlockingIOError:
                if not polled(self.master, select.POLLOUT, timeout):
                    raise AssertionError('the line takes no more') from None

    def cut(self):
        """Closes the master: the tty of the slave is hung up."""
        if self.master is not None:
            os.close(self.master)
            self.master = None

    def close_slave(self):
        if self.slave is not None:
            os.close(self.slave)
            self.slave = None

    def close(self):
        self.cut()
        self.close_slave()


class Reader:
    """/dev/xy3-<n>, open."""

    def __init__(self, node, flags=os.O_RDONLY):
        self.fd = os.open(node, flags | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)

    def close(self):
        if self.fd is not None:
            os.close(self.fd)
            self.fd = None

    def read(self, size=65536, timeout=2.0):
        """-> the result of one read(), b'' after a hangup, None after the timeout"""
        if not polled(self.fd, select.POLLIN, timeout):
            return None
        return os.read(self.fd, size)

    def rest(self, quiet=0.2, size=65536):
        """Reads until nothing is received for some time, or the tty is hung up."""
        data = b''
        while True:
            more = self.read(size, quiet)
            if not more:
                return data
            data += more

    def take(self, size, timeout=5.0):
        """Reads this number of bytes, or fewer after the timeout."""
        data = b''
        while len(data) < size:
            more = self.read(size - len(data), timeout)
            if not more:
                break
            data += more
        return data


class Head:
    """A UART with the line discipline attached, and its head."""

    def __init__(self, uart=None, **options):
        self.uart = uart or Pty(**options)
        self.name = self.path = self.node = None
        self.sent = 0                       # bytes since the line discipline was attached
        self.readers = []

    def attach(self):
        before = heads()
        set_ldisc(self.uart.slave, LDISC)
        new = [name for name in heads() if name not in before]
        if len(new) != 1:
            raise AssertionError('new heads: %s' % new)
        self.name = new[0]
        self.path = '%s/%s' % (CLASS, self.name)
        self.node = '/dev/' + self.name
        self.sent = 0
        return self

    def detach(self):
        set_ldisc(self.uart.slave, N_TTY)

    def gone(self):
        return wait(lambda: not os.path.exists(self.path) and not os.path.exists(self.node))

    def close(self):
        for reader in self.readers:
            reader.close()
        self.uart.close()
        if self.path and not self.gone():
            raise AssertionError('%s does not go away' % self.name)

    # --- the line -------------------------------------------------------------------------

    def send(self, *pieces):
        """Sends each piece by a separate write(); waits until the driver has processed it."""
        for data in pieces:
            self.uart.write(data)
            self.sent += len(data)
            if not wait(lambda: self.stat('rx_bytes') == self.sent):
                raise AssertionError('of %d bytes %d were taken'
                                     % (self.sent, self.stat('rx_bytes')))

    def sync(self):
        self.send(GOOD)
        return self

    def open(self, flags=os.O_RDONLY):
        reader = Reader(self.node, flags)
        self.readers.append(reader)
        return reader

    # --- sysfs ----------------------------------------------------------------------------

    def get(self, name):
        """The text of an attribute, which must be one line, or the name of the error."""
        try:
            text = read_file('%s/%s' % (self.path, name))
        except OSError as error:
            return errno.errorcode[error.errno]
        if not text.endswith('\n') or '\n' in text[:-1]:
            raise AssertionError('%s: not one line: %r' % (name, text))
        return text[:-1]

    def all(self, folder):
        """-> {file of errors/, hours/ or frame_errors/: text}"""
        return {name: self.get('%s/%s' % (folder, name))
                for name in os.listdir('%s/%s' % (self.path, folder))}

    def stat(self, name):
        return int(self.get('stats/' + name))

    def stats(self):
        return {name: self.stat(name) for name in STATS}

    def set(self, name, text):
        """-> name of the error that the write ends with, or None"""
        return error_name(write_file, '%s/%s' % (self.path, name), text)

    def hwmon_path(self):
        """-> folder of its hwmon device, None if there is none"""
        return next(iter(glob.glob(self.path + '/hwmon[0-9]*')), None)

    def hwmon(self):
        """-> {file: text} of its hwmon device, {} if there is none"""
        folder = self.hwmon_path()
        if not folder:
            return {}
        files = [name for name in os.listdir(folder) if re.fullmatch(r'name|temp\d+_.*', name)]
        return {name: self.get('%s/%s' % (os.path.basename(folder), name)) for name in files}


class Uevents:
    """The uevents of the kernel, as udev receives them."""

    NETLINK_KOBJECT_UEVENT = 15

    def __init__(self, subsystems=('xy3',)):
        self.subsystems = subsystems
        self.socket = socket.socket(socket.AF_NETLINK, socket.SOCK_DGRAM,
                                    self.NETLINK_KOBJECT_UEVENT)
        self.socket.setsockopt(socket.SOL_SOCKET, 33, 1 << 23)      # SO_RCVBUFFORCE
        self.socket.bind((0, 1))

    def close(self):
        self.socket.close()

    def take(self, quiet=0.4):
        """-> received uevents, each as {property: text}, until none is received for some time"""
        found = []
        while polled(self.socket.fileno(), select.POLLIN, quiet):
            words = self.socket.recv(65536).decode().split('\0')
            event = dict(word.split('=', 1) for word in words[1:] if word)
            if event.get('SUBSYSTEM') in self.subsystems:
                found.append(event)
        return found

    def properties(self, quiet=0.4):
        """-> the XY3_ properties of each event that has any, without the prefix"""
        found = [{name[4:]: text for name, text in event.items() if name.startswith('XY3_')}
                 for event in self.take(quiet)]
        return [event for event in found if event]


class AttributePoller:
    """Polls an attribute for changes."""

    def __init__(self, path):
        self.fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        self.read()

    def close(self):
        os.close(self.fd)

    def read(self):
        """-> its text, or the name of the error: an unreadable attribute can still be polled"""
        try:
            return os.pread(self.fd, 4096, 0).decode()
        except OSError as error:
            return errno.errorcode[error.errno]

    def changed(self, timeout=1.0):
        """Whether it has changed since the last read; reads it."""
        events = polled(self.fd, select.POLLPRI, timeout)
        self.read()
        return bool(events & select.POLLPRI)

    def removed(self, timeout=60.0):
        """Polls and reads until the attribute is removed. -> whether poll() has woken then

        At its timeout poll() checks again and finds the file removed, so the time is measured.
        """
        while self.read() != 'ENODEV':
            began = time.monotonic()
            polled(self.fd, select.POLLPRI, timeout)
            if time.monotonic() - began > timeout / 2:
                return False
        return True


class Case(case.Case):
    """A test with the module loaded; attached UARTs are detached after it."""

    def set_up(self):
        if not kernel.is_loaded(MODULE):
            load()
        if not wait(lambda: not heads()):
            raise AssertionError('heads of another test: %s' % heads())

    def closing(self, thing):
        self.add_cleanup(thing.close)
        return thing

    def attach(self, uart=None, **options):
        return self.closing(Head(uart, **options)).attach()

    def synced(self, **options):
        return self.attach(**options).sync()

    def uevents(self, *subsystems):
        """Receives uevents from now on."""
        listener = self.closing(Uevents(subsystems or ('xy3',)))
        listener.take(0.2)
        return listener

    def poller(self, head, name):
        return self.closing(AttributePoller('%s/%s' % (head.path, name)))

    def opened(self, path, flags=os.O_RDONLY):
        """-> fd, which is closed after the test"""
        fd = os.open(path, flags)
        self.add_cleanup(os.close, fd)
        return fd

    def assert_counts(self, head, decoder, lost=0):
        """The counters of the driver equal those of an independent decoder."""
        assert head.stats() == {
            'rx_bytes': decoder.packet_bytes + decoder.dropped + decoder.kept,
            'rx_packets': decoder.packets, 'syncs': decoder.syncs, 'resyncs': decoder.resyncs,
            'dropped_bytes': decoder.dropped, 'bad_lengths': decoder.bad_lengths,
            'unknown_packets': decoder.unknown, 'line_errors': 0, 'lost_packets': lost}
        assert head.get('in_sync') == '%d' % decoder.in_sync


def run(*words, timeout=20):
    """-> (status, output) of a program"""
    done = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=timeout, check=False)
    return done.returncode, done.stdout
