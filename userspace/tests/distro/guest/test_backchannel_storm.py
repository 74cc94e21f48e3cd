# SPDX-License-Identifier: GPL-2.0-only
"""Attaching, detaching and unplugging without any waiting, while other threads use the head.

For a guest with two processors. It tests for races: mostly by the kernel log, but a head must also
work afterwards.
"""

import fcntl
import glob
import hashlib
import os
import random
import signal
import struct
import subprocess
import termios
import threading
import time

import pytest
from harness import BIND_TIME, command, read_file, wait_for, write_file
from head_rig import error_name
from serial_head import (CLASS, DEVICES, LDISC, STICK, TIOCSETD, UART, Cat, heads, module, peer,
                         plug, unplug)
from virtual_head import DRIVER, VirtualHead

ATTACH_ROUNDS = 15      # each takes seconds: the line floods the emulated machine
UNPLUG_ROUNDS = 6
MODULE_ROUNDS = 8
ABORT_ROUNDS = 100
SEED = 4711
N_TTY = 0

pytestmark = pytest.mark.timeout(900)   # udevd is slow with this number of events


class Users:
    """Threads that read and write files of heads, whether these exist or not."""

    def __init__(self):
        self.bytes = 0
        self.looks = 0
        self.changes = 0
        self.ended = threading.Event()
        self.threads = [threading.Thread(target=self._again, args=(work,), daemon=True)
                        for work in (self._read, self._look, self._change, self._set_speed)]

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        for thread in self.threads:
            thread.join(30)
        assert not any(thread.is_alive() for thread in self.threads), 'a user hangs'
        print('# %d bytes read, %d attributes, %d changes' % (self.bytes, self.looks,
                                                              self.changes))

    def _again(self, work):
        while not self.ended.is_set():
            try:
                work()
            except (OSError, termios.error):
                pass                    # there is no head, or it was removed
            time.sleep(0.005)

    def _read(self):
        fd = os.open('/dev/xy3-0', os.O_RDONLY | os.O_NONBLOCK)
        try:
            while not self.ended.is_set():
                try:
                    data = os.read(fd, 4096)
                except BlockingIOError:
                    time.sleep(0.005)
                    continue
                if not data:
                    break
                self.bytes += len(data)
        finally:
            os.close(fd)

    def _look(self):
        head = CLASS + '/xy3-0'
        for group in ('', '/errors', '/hours', '/frame_errors', '/stats'):
            for name in os.listdir(head + group):
                try:
                    with open('%s%s/%s' % (head, group, name), 'rb') as file:
                        file.read()
                except OSError:
                    continue            # a folder, write-only, or no data yet
                self.looks += 1

    def _change(self):
        for name, value in (('autobaud', 1), ('rate', 57600), ('byte_order', 'big'),
                            ('autobaud', 0), ('rate', 115200), ('byte_order', 'little')):
            write_file('%s/xy3-0/%s' % (CLASS, name), '%s\n' % value)
            self.changes += 1

    def _set_speed(self):
        fd = os.open('/dev/xy3-0', os.O_RDONLY | os.O_NONBLOCK)
        try:
            for speed in (termios.B57600, termios.B115200):
                modes = termios.tcgetattr(fd)
                modes[4:6] = [speed, speed]
                termios.tcsetattr(fd, termios.TCSANOW, modes)
                self.changes += 1
        finally:
            os.close(fd)


def set_discipline(fd, number):
    fcntl.ioctl(fd, TIOCSETD, struct.pack('i', number))


def open_line(port):
    return os.open(DEVICES[port], os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)


def test_attach_storm():
    """Data are received during all of it."""
    chance = random.Random(SEED)
    module.load()
    plug(UART)
    fd = open_line(UART)
    try:
        with Users():
            for _ in range(ATTACH_ROUNDS):
                peer.send_request(UART, 'stream_until_next_request')
                set_discipline(fd, LDISC)
                time.sleep(chance.choice((0, 0, 0.01, 0.05)))
                set_discipline(fd, N_TTY)
                termios.tcflush(fd, termios.TCIFLUSH)
                peer.send_request(UART, 'mark')
                peer.receive()
                peer.receive()
    finally:
        os.close(fd)
        unplug(UART)
    assert heads() == []
    module.unload()


def test_unplug_storm():
    """While the adapter streams; every second time its tty is still open at the next plug."""
    chance = random.Random(SEED)
    command('modprobe', 'xhci-pci')
    module.load()
    kept = []
    with Users():
        for number in range(UNPLUG_ROUNDS):
            peer.request(STICK, 'plug')
            node = wait_for(lambda: glob.glob('/dev/ttyUSB*'), 'stick', BIND_TIME)[0]
            fd = os.open(node, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            kept.append(fd)
            set_discipline(fd, LDISC)
            peer.send_request(STICK, 'stream_until_next_request')
            time.sleep(chance.uniform(0, 0.3))
            peer.send_request(STICK, 'unplug')
            peer.receive()
            peer.receive()
            if number % 2:
                wait_for(lambda: not heads(), 'end of the head', BIND_TIME)
                while kept:
                    os.close(kept.pop())
            wait_for(lambda: not glob.glob('/dev/ttyUSB*'), 'end of the stick', BIND_TIME)
    for fd in kept:
        os.close(fd)
    assert heads() == []
    module.unload()


def test_module_storm_of_heads():
    """The module is unloaded and loaded while heads are used."""
    plug(UART)
    fd = open_line(UART)
    try:
        with Users() as users:
            for _ in range(MODULE_ROUNDS):
                set_discipline(fd, LDISC)
                looks = users.looks
                wait_for(lambda: users.looks > looks, 'a look', BIND_TIME)
                set_discipline(fd, N_TTY)
                # the reader may have the tty open, and detects its end at once
                wait_for(unloaded, 'end of the module', BIND_TIME)
    finally:
        os.close(fd)
        unplug(UART)


def unloaded():
    return subprocess.run(['modprobe', '-r', 'xy3'], stderr=subprocess.DEVNULL,
                          check=False).returncode == 0


def test_a_head_works_after_all(attach):
    head = attach(UART)
    with Cat(head.node) as cat:
        head.request('mark')
        head.request('stream', packets=200)
        sent = head.request('sent')
        data = cat.wait_size(sent['bytes'])
        assert hashlib.sha1(data).hexdigest() == sent['sha1']


def test_unbound_while_it_streams():
    """The driver of the forward channel is unbound while another processor writes scans."""
    with VirtualHead(lines=4, framing='line', realtime=1) as head:
        head.start()
        fd = os.open(head.buffer, os.O_WRONLY)
        errors = []

        def write():
            while not errors:
                error = error_name(os.write, fd, bytes(4 * head.axes * 1000))
                if error:
                    errors.append(error)

        writer = threading.Thread(target=write, daemon=True)
        writer.start()
        wait_for(lambda: head.number('scans') > 10000, 'scans')
        write_file(DRIVER + '/unbind', os.path.basename(head.spi))
        writer.join(BIND_TIME)
        # the writer may detect the end of the stream before the removal of the device
        assert errors in (['EINVAL'], ['ENODEV'])
        assert error_name(os.write, fd, bytes(4 * head.axes)) == 'ENODEV'
        os.close(fd)
        assert heads() == []
        write_file(DRIVER + '/bind', os.path.basename(head.spi))
        head.wait_bound()
        head.set('out_angl0_raw', 77)
        assert head.positions(20)[0] == 77
        for name in ('parity_errors', 'length_errors'):
            assert head.counts(name) == [0] * head.axes


def test_abort_while_enabled_and_disabled():
    """`abort` takes no lock of the IIO device: the number of empty blocks remains correct."""
    with VirtualHead(lines=4, framing='line') as head:
        head.start()
        head.set('buffer/enable', 0)
        child = os.fork()
        if not child:
            while True:
                write_file(head.iio + '/abort', '1')
        try:
            length = int(read_file(head.iio + '/buffer/length'))
            scans = bytes(4 * head.axes * length)
            for _ in range(ABORT_ROUNDS):
                head.set('buffer/enable', 1)
                fd = os.open(head.buffer, os.O_WRONLY | os.O_NONBLOCK)
                assert os.write(fd, scans) == len(scans)
                os.close(fd)
                head.set('buffer/enable', 0)
        finally:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)
