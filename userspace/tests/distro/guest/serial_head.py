# SPDX-License-Identifier: GPL-2.0-only
"""Heads at the far ends of the guest's serial lines, and readers of their data."""

import fcntl
import glob
import hashlib
import json
import os
import select
import signal
import struct
import subprocess

from harness import (BIND_TIME, EVENT_TIME, Module, command, find, is_running, read_file, wait_for,
                     write_file)
from head_rig import CLASS, LDISC

UART = 'uart'           # the 8250
STICK = 'stick'         # the FTDI adapter
PORTS = (UART, STICK)
DEVICES = {UART: '/dev/ttyS1', STICK: '/dev/ttyUSB0'}

TIOCSETD = 0x5423
TIOCGSERIAL, TIOCSSERIAL = 0x541E, 0x541F
SERIAL_STRUCT = 72      # size of struct serial_struct on amd64
BAUD_BASE = 28          # its offset


class Peer:
    """The heads at the far ends; distro/serial-peer lists the requests."""

    def __init__(self):
        self.control = None
        self._text = b''

    def send_request(self, port, name, *values, **settings):
        """Does not wait for the answer: receive() returns it."""
        if not self.control:
            self.control = open('/dev/virtio-ports/control', 'r+b', buffering=0)
        text = json.dumps({'do': name, 'port': port, 'values': values, **settings})
        self.control.write(text.encode() + b'\n')

    def receive(self):
        while b'\n' not in self._text:
            self._text += self.control.read(65536)
        text, self._text = self._text.split(b'\n', 1)
        answer = json.loads(text)
        if 'error' in answer:
            raise AssertionError('peer: %s' % answer['error'])
        return answer['value']

    def request(self, port, name, *values, **settings):
        self.send_request(port, name, *values, **settings)
        return self.receive()

    def receive_all(self):
        """Receives pending answers. -> their number"""
        count = 1
        self.receive()
        while b'\n' in self._text:
            self.receive()
            count += 1
        return count


peer = Peer()


def plug(port, **settings):
    """A head on the line, and for the adapter the adapter itself."""
    if port == STICK:
        command('modprobe', 'xhci-pci')
    peer.request(port, 'plug', **settings)
    if port == STICK:
        wait_for(lambda: os.path.exists(DEVICES[STICK]), 'stick', BIND_TIME)


def unplug(port):
    peer.request(port, 'unplug')
    if port == STICK:
        wait_for(lambda: not os.path.exists(DEVICES[STICK]), 'end of the stick', BIND_TIME)


def set_clock(highest):
    """The highest rate of the 8250, which its driver cannot detect: setserial's baud_base."""
    fd = os.open(DEVICES[UART], os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        data = bytearray(SERIAL_STRUCT)
        fcntl.ioctl(fd, TIOCGSERIAL, data)
        struct.pack_into('<i', data, BAUD_BASE, highest)
        fcntl.ioctl(fd, TIOCSSERIAL, bytes(data))
    finally:
        os.close(fd)
    peer.request(UART, 'clock', highest)


def heads():
    """Names of all heads."""
    return sorted(os.path.basename(path) for path in glob.glob(CLASS + '/xy3-*'))


def by_id():
    """{name: node} of heads, by the links of udev"""
    return {os.path.basename(path): os.path.realpath(path)
            for path in glob.glob('/dev/serial/by-id/xy3-*')}


def ldattach_pids(device):
    found = []
    for path in glob.glob('/proc/[0-9]*/cmdline'):
        try:
            words = read_file(path).split('\0')
        except OSError:
            continue                    # it has exited
        if words[0].endswith('ldattach') and device in words:
            found.append(int(path.split('/')[2]))
    return found


module = Module('xy3')


def stop_ldattach(device):
    """Waits until it has closed the device: the command line of a process ends before its files."""
    pids = ldattach_pids(device)
    for pid in pids:
        os.kill(pid, signal.SIGTERM)
    wait_for(lambda: not any(is_running(pid) for pid in pids), 'end of ldattach', BIND_TIME)


class SerialHead:
    """A head at the far end of a port, attached by ldattach like by a user.

    settings are those of the virtual head. Tests use the fixture `attach`.
    """

    def __init__(self, port, rate=115200, **settings):
        self.port = port
        self.device = DEVICES[port]
        self.rate = rate
        self.settings = {'rate': rate, **settings}
        self.name = None

    def plug(self):
        plug(self.port, **self.settings)

    def attach(self):
        before = heads()
        module.will_come()
        command('ldattach', '-s', str(self.rate), '-8', '-n', '-1', str(LDISC), self.device)
        new = wait_for(lambda: set(heads()) - set(before), 'head', BIND_TIME)
        self.name = new.pop()
        wait_for(lambda: os.path.exists(self.node), 'node', BIND_TIME)

    def detach(self):
        stop_ldattach(self.device)
        wait_for(lambda: self.name not in heads(), 'end of the head')
        wait_for(lambda: not os.path.exists(self.node), 'end of the node')

    def close(self):
        self.detach()
        unplug(self.port)

    # --- the far side ------------------------------------------------------------------------

    def request(self, name, *values, **settings):
        return peer.request(self.port, name, *values, **settings)

    def send_request(self, name, *values, **settings):
        peer.send_request(self.port, name, *values, **settings)

    def sync(self):
        """Waits until the driver is in sync."""
        self.request('report', 'sync', 'sync')
        in_sync = find.wait(lambda: self.get('in_sync') == '1', EVENT_TIME)
        assert in_sync, 'no sync; %s' % self.state()

    def state(self):
        """The counts of both sides, for the message of a failure."""
        names = ('rx_bytes', 'rx_packets', 'dropped_bytes', 'resyncs', 'line_errors',
                 'lost_packets')
        return '%s; the head: %s' % ({name: self.stat(name) for name in names},
                                     self.request('counts'))

    # --- this side ---------------------------------------------------------------------------

    @property
    def node(self):
        return '/dev/' + self.name

    def path(self, name):
        return '%s/%s/%s' % (CLASS, self.name, name)

    def get(self, name):
        return read_file(self.path(name)).rstrip('\n')

    def set(self, name, value):
        write_file(self.path(name), '%s\n' % value)

    def stat(self, name):
        return int(self.get('stats/' + name))


def has_open(pid, node):
    """Whether a process has a file open. Files come and go while it starts."""
    for fd in glob.glob('/proc/%d/fd/*' % pid):
        try:
            if os.readlink(fd) == node:
                return True
        except OSError:
            continue
    return False


class Cat:
    """cat NODE > FILE; the file is in memory."""

    PLACE = '/tmp/cat'

    def __init__(self, node):
        self._file = open(self.PLACE, 'wb')
        self._process = subprocess.Popen(['cat', node], stdout=self._file)
        # the packets of a head are passed to open files
        wait_for(lambda: has_open(self._process.pid, node), 'cat has opened ' + node, BIND_TIME)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        self._file.close()

    def wait_end(self):
        """-> the status of cat at the end of the file"""
        return self._process.wait(BIND_TIME)

    def wait_size(self, size):
        """-> all received data, which must be `size` bytes"""
        wait_for(lambda: os.path.getsize(self.PLACE) >= size, '%d bytes of cat' % size, BIND_TIME)
        data = self.data()
        assert len(data) == size
        return data

    def data(self):
        with open(self.PLACE, 'rb') as file:
            return file.read()


class Reader:
    """Reads the tty of a head, and only keeps a checksum."""

    PIECE = 70000           # bytes per request
    WINDOW = 3 * PIECE      # bytes in flight

    def __init__(self, head):
        self.head = head
        self.bytes = 0
        self.digest = hashlib.sha1()

    def __enter__(self):
        self._fd = os.open(self.head.node, os.O_RDONLY)
        return self

    def __exit__(self, *_):
        os.close(self._fd)

    def take_stream(self, size):
        """Requests `size` bytes from the head, and reads them. -> bytes sent since the last mark

        Bytes in flight are limited to what a tty can buffer: on a busy host the emulated lines are
        sometimes faster than any reader.
        """
        asked = answers = 0
        while self.bytes < size or answers:
            while asked < size and asked - self.bytes < self.WINDOW:
                self.head.send_request('stream', size=min(self.PIECE, size - asked))
                asked += self.PIECE
                answers += 1
            ready = self._wait([self._fd, peer.control])
            if peer.control in ready:
                answers -= peer.receive_all()
            if self._fd in ready:
                self._read()
        sent = self.head.request('sent')['bytes']
        while self.bytes < sent:
            self._wait([self._fd])
            self._read()
        return sent

    def _wait(self, files):
        ready = select.select(files, [], [], BIND_TIME)[0]
        assert ready, 'no more than %d bytes; %s' % (self.bytes, self.head.state())
        return ready

    def _read(self):
        data = os.read(self._fd, 65536)
        assert data, 'the file has ended'
        self.bytes += len(data)
        self.digest.update(data)


def whole_packets(data, cut=False):
    """-> [(type, payload)] of data that must be complete packets; cut: except for the last one."""
    found, at = [], 0
    while at < len(data):
        assert data[at] == 0x48, 'no packet starts at byte %d' % at
        end = at + 3 + data[at + 2] if len(data) - at >= 3 else len(data) + 1
        if end > len(data) and cut:
            break
        assert end <= len(data), 'a packet is torn at byte %d' % at
        found.append((data[at + 1], data[at + 3:end]))
        at = end
    return found
