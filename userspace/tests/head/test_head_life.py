# SPDX-License-Identifier: GPL-2.0-only
"""Creation and removal of heads."""

import ctypes
import fcntl
import os
import select
import signal
import subprocess
import termios
import time

import pytest

import head_rig
import kernel
from acm_cable import AcmCable
from head_rig import (CLASS, HEADS_MAX, LDISC, N_TTY, Background, Case, Head, Pty, error_name,
                      get_speed, heads, polled, set_ldisc, wait)
from kernel import read_file, write_file
from xy3_head_sim import wire

ATTACH = CLASS + '/attach'
CAP_SYS_ADMIN = 21
TIOCVHANGUP = 0x5437
SYS_CAPGET, SYS_CAPSET = 125, 126       # x86_64


def drop_capability(number):
    """Drops them permanently for this thread."""
    header = (ctypes.c_uint32 * 2)(0x20080522, 0)       # version 3
    sets = (ctypes.c_uint32 * 6)()                      # effective, permitted, inheritable; twice
    kernel.syscall(SYS_CAPGET, header, sets)
    for at in range(number // 32 * 3, number // 32 * 3 + 3):
        sets[at] &= ~(1 << number % 32)
    kernel.syscall(SYS_CAPSET, header, sets)


def in_child(call):
    """-> name of the error that call() ends with in a child process, or None"""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.write(writer, (error_name(call) or '').encode())
        finally:
            os._exit(0)
    os.close(writer)
    result = os.read(reader, 99).decode()
    os.close(reader)
    os.waitpid(child, 0)
    return result or None


def processes(name):
    """-> pids of the processes of that name"""
    found = []
    for pid in filter(str.isdigit, os.listdir('/proc')):
        try:
            if read_file('/proc/%s/comm' % pid) == name + '\n':
                found.append(int(pid))
        except (FileNotFoundError, ProcessLookupError):     # it has exited meanwhile
            pass
    return found


class TestAttach(Case):
    def test_and_detach(self):
        for _ in range(3):
            head = self.attach()
            assert heads() == ['xy3-0']
            head.sync()
            head.detach()
            assert head.gone()
            assert heads() == []

    def test_close_of_the_uart(self):
        """On USB, as the slave of a pty does not change while the master is open.

        The next program that opens it finds the former input modes, and the rate of the head.
        """
        uart = self.closing(AcmCable())
        flags = termios.IGNBRK | termios.IGNPAR | termios.IXANY
        for rate in (230400, 57600):
            modes = termios.tcgetattr(uart.slave)
            modes[0] = flags
            termios.tcsetattr(uart.slave, termios.TCSANOW, modes)
            head = self.attach(uart).sync()
            assert termios.tcgetattr(uart.slave)[0] == \
                termios.BRKINT | termios.INPCK | termios.IXANY
            assert head.set('rate', str(rate)) is None
            uart.close_slave()
            assert head.gone()
            uart.slave = os.open(uart.node, os.O_RDWR | os.O_NOCTTY)
            assert termios.tcgetattr(uart.slave)[0] == flags
            assert get_speed(uart.slave) == rate

    def test_capability(self):
        uart = self.closing(Pty())

        def without():
            drop_capability(CAP_SYS_ADMIN)
            set_ldisc(uart.slave, LDISC)

        assert in_child(without) == 'EPERM'
        assert heads() == []
        # control: the same child with all its capabilities
        assert in_child(lambda: set_ldisc(uart.slave, LDISC)) is None
        assert heads() == ['xy3-0']

    def test_not_on_our_own_tty(self):
        head = self.synced()
        reader = head.open(os.O_RDWR)
        assert error_name(set_ldisc, reader.fd, LDISC) == 'EINVAL'
        head.send(wire.vendor('ACME'))
        assert reader.rest() == wire.vendor('ACME')
        assert heads() == ['xy3-0']

    def test_twice_on_the_same_tty(self):
        head = self.synced()
        set_ldisc(head.uart.slave, LDISC)
        assert heads() == ['xy3-0']
        head.send(wire.vendor('ACME'))
        assert head.get('vendor') == 'ACME'

    def test_on_the_master(self):
        """The master has no settings to change, and is refused; the slave is not."""
        uart = self.closing(Pty())
        assert error_name(set_ldisc, uart.master, LDISC) == 'EINVAL'
        assert heads() == []
        set_ldisc(uart.slave, LDISC)
        assert heads() == ['xy3-0']

    def test_what_came_before(self):
        """Data that were unread before attaching are not treated as the head's."""
        uart = self.closing(Pty())
        uart.write(head_rig.GOOD)
        assert polled(uart.slave, select.POLLIN) == select.POLLIN
        head = self.attach(uart)
        assert head.stat('rx_bytes') == 0
        head.sync()

    def test_two(self):
        one, two = self.synced(), self.synced()
        assert heads() == ['xy3-0', 'xy3-1']
        readers = [head.open() for head in (one, two)]
        one.send(wire.vendor('one'))
        two.send(wire.vendor('two'))
        assert [head.get('vendor') for head in (one, two)] == ['one', 'two']
        assert [reader.rest() for reader in readers] == \
            [wire.vendor('one'), wire.vendor('two')]
        one.uart.cut()
        assert one.gone()
        two.send(wire.model('still there'))
        assert readers[1].rest() == wire.model('still there')
        third = self.attach()
        assert third.name == 'xy3-0'       # the lowest free number

    def test_many(self):
        for number in range(HEADS_MAX):
            assert self.synced().name == 'xy3-%d' % number
        uart = self.closing(Pty())
        assert error_name(set_ldisc, uart.slave, LDISC) == 'ENOSPC'
        assert len(heads()) == HEADS_MAX
        os.write(uart.slave, b'a tty as before')
        assert os.read(uart.master, 99) == b'a tty as before'

    def ldattach(self, uart):
        """Runs ldattach of util-linux as described in the manual. -> its pid"""
        uart.close_slave()
        subprocess.run(['ldattach', '-s', '115200', '-8', '-n', '-1', str(LDISC), uart.node],
                       check=True, timeout=20)
        assert wait(heads)
        pid, = processes('ldattach')
        assert read_file(CLASS + '/xy3-0/rate') == '115200\n'
        uart.write(head_rig.GOOD + wire.vendor('ACME'))
        assert wait(lambda: read_file(CLASS + '/xy3-0/in_sync') == '1\n')
        assert read_file(CLASS + '/xy3-0/vendor') == 'ACME\n'
        return pid

    def end(self, pid):
        """Ends an ldattach."""
        os.kill(pid, signal.SIGTERM)
        assert wait(lambda: not os.path.exists('/proc/%d' % pid))

    def test_ldattach_ends(self):
        self.end(self.ldattach(self.closing(AcmCable(9600))))
        assert wait(lambda: not heads())

    def test_ldattach_and_hangup(self):
        uart = self.closing(Pty(9600))
        pid = self.ldattach(uart)
        uart.cut()
        assert wait(lambda: not heads())
        self.end(pid)


class TestChoice(Case):
    def choose(self, text):
        return error_name(write_file, ATTACH, text)

    def chosen(self):
        return read_file(ATTACH)

    def refused(self):
        uart = self.closing(Pty())
        error = error_name(set_ldisc, uart.slave, LDISC)
        os.write(uart.slave, b'x')
        assert os.read(uart.master, 9) == b'x'     # an ordinary tty as before
        return error

    def test_show_and_store(self):
        assert self.chosen() == 'auto\n'
        for text in ('new', 'xy3-0', 'xy3-31\n', 'auto\n'):
            assert self.choose(text) is None
            assert self.chosen() == text.strip() + '\n'
        self.choose('new')
        for text in ('\n', 'xy3-', 'xy3-32', 'xy3--1', 'xy3-0x', 'xy4-0', 'newer', '0', 'xy3-1 2'):
            assert self.choose(text) == 'EINVAL', text
        assert self.chosen() == 'new\n'
        assert self.choose('auto') is None

    def test_new(self):
        assert self.choose('new') is None
        assert self.attach().name == 'xy3-0'
        assert self.chosen() == 'auto\n'

    def test_a_head_that_is_not_there(self):
        assert self.choose('xy3-5') is None
        assert self.refused() == 'ENODEV'
        assert self.chosen() == 'auto\n'           # one use
        assert self.attach().name == 'xy3-0'

    def test_a_head_that_has_one(self):
        head = self.synced()
        assert self.choose('xy3-0') is None
        assert self.refused() == 'EBUSY'
        assert self.attach().name == 'xy3-1'
        head.send(wire.vendor('ACME'))


class TestHangup(Case):
    """The head is removed while its tty is open."""

    def test_in_the_middle_of_a_packet(self):
        head = self.synced()
        readers = [head.open(os.O_RDWR), head.open(os.O_RDWR)]
        for reader in readers:
            os.set_blocking(reader.fd, True)
        reads = [Background(os.read, reader.fd, 100) for reader in readers]
        poller = head.open(os.O_RDWR)
        poll = Background(polled, poller.fd, select.POLLPRI, 30)
        head.send(wire.debug('cut in the middle')[:9])
        time.sleep(0.1)
        assert all(thread.is_alive() for thread in (*reads, poll))
        head.uart.cut()
        assert [read.result() for read in reads] == [b'', b'']
        assert poll.result() & select.POLLHUP
        for reader in (*readers, poller):
            assert os.read(reader.fd, 100) == b''
            assert polled(reader.fd, select.POLLIN) & select.POLLHUP
            assert error_name(os.write, reader.fd, b'\x40\0\0') == 'EIO'
        assert head.gone()

    @pytest.mark.parametrize('way', (Head.detach, lambda head: head.uart.close_slave()),
                             ids=('detach', 'close'))
    def test_backchannel_goes(self, way):
        head = self.attach(self.closing(AcmCable())).sync()
        reader = head.open(os.O_RDWR)
        way(head)
        assert head.gone()
        assert reader.read() == b''
        assert error_name(os.write, reader.fd, b'\x40\0\0') == 'EIO'

    def test_of_the_tty_alone(self):
        """vhangup(): the head stays, and its tty can be opened again."""
        head = self.synced()
        reader = head.open()
        fcntl.ioctl(reader.fd, TIOCVHANGUP)
        assert reader.read() == b''
        fresh = head.open()
        head.send(wire.vendor('ACME'))
        assert fresh.rest() == wire.vendor('ACME')
        assert reader.read() == b''

    def test_uart_that_was_hung_up(self):
        uart = self.closing(Pty())
        uart.cut()
        assert error_name(set_ldisc, uart.slave, LDISC) == 'EIO'
        assert heads() == []

    def test_files_that_are_still_open(self):
        head = self.synced()
        head.send(wire.vendor('ACME'), wire.temperatures([2500]))
        assert wait(head.hwmon)
        paths = [head.path + '/' + name for name in
                 ('vendor', 'rate', 'stats/rx_bytes', 'errors/head', 'hours/dsp')]
        fds = [self.opened(path) for path in (*paths, head.hwmon_path() + '/temp1_input')]
        command = self.opened(head.path + '/calibrate', os.O_WRONLY)
        head.uart.cut()
        assert head.gone()
        for fd in fds:
            assert error_name(os.read, fd, 10) == 'ENODEV'
        assert error_name(os.write, command, b'x') == 'ENODEV'

    def test_the_same_number_again(self):
        """While the hung up file is still open: a new one works, the old one stays unusable."""
        old = []
        for number in range(4):
            head = self.synced()
            assert head.name == 'xy3-0'
            reader = head.open(os.O_RDWR)
            head.send(wire.vendor('%03d' % number))
            assert reader.rest(0.05) == wire.vendor('%03d' % number)
            for dead in old:
                assert dead.read(timeout=0) == b''
                assert error_name(os.write, dead.fd, b'x') == 'EIO'
            assert get_speed(reader.fd) == 115200
            assert termios.tcgetattr(reader.fd)[3] == 0        # raw, as the first time
            old.append(reader)
            head.uart.cut()
            assert head.gone()

    def test_same_number_at_once(self):
        """The new head is attached while the hangup of the old one's tty is still in progress."""
        for _ in range(50):
            head = self.synced()
            reader = head.open()
            head.detach()
            head.attach()
            assert head.name == 'xy3-0'
            fresh = head.open()
            head.send(head_rig.GOOD)
            assert fresh.take(6) == head_rig.GOOD
            assert reader.read() == b''
            head.close()

    @pytest.mark.parametrize('size', (100, 4000, 20000))
    def test_what_the_last_head_has_left(self, size):
        """Data that were unread before the hangup are not passed to the reader of the next head."""
        head = self.synced()
        reader = head.open()
        head.send(wire.debug('x' * 97) * (size // 100))
        head.uart.cut()
        assert head.gone()
        head = self.synced()
        fresh = head.open()
        head.send(wire.vendor('ACME'))
        assert fresh.rest() == wire.vendor('ACME')
        assert reader.read() == b''

    def test_open_that_is_too_late(self):
        head = self.synced()
        head.uart.cut()
        assert head.gone()
        assert error_name(os.open, head.node, os.O_RDWR) == 'ENOENT'


class TestUnload(Case):
    def traces(self):
        """Objects that the module has left in the system."""
        found = [line.split()[0] for path in ('/proc/tty/ldiscs', '/proc/tty/drivers',
                                              '/proc/modules')
                 for line in read_file(path).splitlines() if 'xy3' in line]
        for folder in ('/sys/class', '/sys/module', '/sys/bus/serial/drivers', '/dev',
                       '/sys/devices/virtual', '/sys/devices/virtual/tty', '/sys/class/hwmon',
                       '/sys/kernel/tracing/events'):
            if os.path.isdir(folder):
                found += [name for name in os.listdir(folder) if 'xy3' in name or
                          name.startswith('hwmon') and folder.endswith('hwmon')]
        return found

    def test_refused_while_attached(self):
        head = self.synced()
        assert error_name(kernel.unload_module, 'xy3') == 'EAGAIN'
        assert head_rig.run('rmmod', 'xy3')[0] != 0
        head.send(wire.vendor('ACME'))
        assert head.get('vendor') == 'ACME'

    def test_refused_while_only_the_tty_is_open(self):
        head = self.synced()
        reader = head.open()
        head.uart.cut()
        assert head.gone()
        assert error_name(kernel.unload_module, 'xy3') == 'EAGAIN'
        reader.close()
        head_rig.unload()
        assert self.traces() == []

    def test_nothing_is_left(self):
        before = self.traces()
        assert len(before) > 5
        for head in (self.synced(), self.synced()):
            head.send(wire.vendor('ACME'), wire.temperatures([2500] * 22))
            assert wait(head.hwmon)
            head.open().close()
            head.uart.cut()
            assert head.gone()
        head_rig.unload()
        assert self.traces() == []
        head_rig.load()
        assert self.traces() == before

    def test_parameters(self):
        head_rig.unload()
        head_rig.load('ldisc=28 autobaud=1')
        self.add_cleanup(head_rig.unload)       # the next test must not have these parameters
        uart = self.closing(Pty())
        # no module has this number; the kernel would request one
        assert error_name(set_ldisc, uart.slave, LDISC) == 'EINVAL'
        set_ldisc(uart.slave, 28)
        assert read_file(CLASS + '/xy3-0/autobaud') == '1\n'
        assert wait(lambda: read_file(CLASS + '/xy3-0/rate') != '115200\n')
        set_ldisc(uart.slave, N_TTY)
        assert wait(lambda: not heads())

    @pytest.mark.parametrize('number', (-1, 0, 31, 1000))
    def test_number_of_no_line_discipline(self, number):
        head_rig.unload()
        assert error_name(head_rig.load, 'ldisc=%d' % number) == 'EINVAL'
        assert self.traces() == []
        head_rig.load()
        assert self.attach().get('autobaud') == '0'
