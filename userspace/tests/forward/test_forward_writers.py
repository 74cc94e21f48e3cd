# SPDX-License-Identifier: GPL-2.0-only
"""Writers of a stream: blocking and nonblocking, with poll(), two at a time, killed, disconnected;
and the rate of the backchannel with a head that does not change it.
"""

import fcntl
import os
import select
import signal
import struct
import threading
import time

import pytest
import forward_rig
import head_rig
import kernel
from forward_rig import Case
from head_rig import error_name, polled
from kernel import read_file, wait, write_file

# real time of the wire: 100 k scans per second
SLOW = 'realtime=1 max_speed_hz=2600000'
IIO_BUFFER_GET_FD = 0xc0046991
IIO_BUFFER_DMABUF_ATTACH = 0x40046992


def scans(first, count, axes=3):
    """Each is identified by its first code."""
    return b''.join(struct.pack('<I', n) + bytes(4 * axes - 4)
                    for n in range(first, first + count))


class Writer(threading.Thread):
    """Writes until it gets an error."""

    def __init__(self, stream, piece):
        super().__init__(daemon=True)
        self.stream = stream
        self.piece = piece
        self.written = 0
        self.error = None
        self.start()

    def run(self):
        while self.error is None:
            self.error = error_name(self.write)

    def write(self):
        self.written += self.stream.write(self.piece)


class TestWaiting(Case):
    def check_record(self, forward, count):
        got, want = forward.recorded(), scans(1, count)
        assert len(got) // 12 == count
        assert got == want

    def test_nobody_waits(self):
        """A write without free space writes nothing; all that was written is sent."""
        forward = self.forward(4, 'line', more=SLOW)
        forward.record(100000)
        forward.set('sampling_frequency', 20000)
        stream = forward.stream(os.O_NONBLOCK, length=1024)
        taken = refused = 0
        while taken < 20000:
            try:
                written = stream.write(scans(taken + 1, 100))
                assert written % 12 == 0
                taken += written // 12
            except BlockingIOError:
                refused += 1
                assert polled(stream.fd, select.POLLOUT, 60) == select.POLLOUT
        stream.finish()
        assert refused > 5
        self.check_record(forward, taken)

    def test_no_room_no_event(self):
        forward = self.forward(4, 'line', more=SLOW)
        forward.set('sampling_frequency', 400)      # a block takes more than half a second
        stream = forward.stream(os.O_NONBLOCK, length=1024)
        assert polled(stream.fd, select.POLLOUT, 0) == select.POLLOUT
        with pytest.raises(BlockingIOError):
            while True:
                stream.write(bytes(12 * 256))
        assert polled(stream.fd, select.POLLOUT, 0) == 0
        assert polled(stream.fd, select.POLLOUT, 60) == select.POLLOUT

    @pytest.mark.parametrize('count', (1, 2, 255, 256, 257, 1023, 1024, 5000))
    def test_all_that_was_written_is_sent(self, count):
        """The buffer is disabled after the last write, while it is full."""
        forward = self.forward(4, 'line', more=SLOW)
        forward.record(10000)
        stream = forward.stream(length=1024)
        assert stream.write(scans(1, count)) == 12 * count
        stream.finish()
        self.check_record(forward, count)
        assert forward.x_of('positions') == str(count)

    def test_a_part_of_a_scan(self):
        """After an error a writer may write all of it again: nothing has been sent."""
        forward = self.forward(4, 'line')
        forward.record(1000)
        stream = forward.stream()
        assert error_name(stream.write, scans(1, 300) + b'more') == 'EINVAL'
        assert stream.write(scans(1, 300)) == 12 * 300
        stream.finish()
        self.check_record(forward, 300)

    def test_signals(self):
        """A write interrupted by a signal is tried again, and no scan is sent twice."""
        forward = self.forward(4, 'line', more=SLOW)
        forward.record(100000)
        caught = []
        before = signal.signal(signal.SIGALRM, lambda *_: caught.append(True))
        self.add_cleanup(signal.signal, signal.SIGALRM, before)
        stream = forward.stream(length=4096)
        signal.setitimer(signal.ITIMER_REAL, 0.003, 0.003)
        try:
            for first in range(1, 60001, 1500):
                assert stream.write(scans(first, 1500)) == 12 * 1500
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
        stream.finish()
        assert len(caught) > 20
        self.check_record(forward, 60000)


class TestCutOff(Case):
    def blocked(self, forward):
        """-> a thread that waits in write()"""
        writer = Writer(forward.stream(length=1024), bytes(12 * 4000))
        assert wait(lambda: writer.written > 12 * 20000)
        return writer

    def returned(self, writer):
        writer.join(60)
        assert not writer.is_alive(), 'write() does not return'
        return writer.error

    def test_unbind(self):
        forward = self.forward(4, 'line', more=SLOW)
        for _ in range(5):
            writer = self.blocked(forward)
            forward.unbind()
            # EINVAL: the stream has ended before the device
            assert self.returned(writer) in ('ENODEV', 'EINVAL')
            forward.bind()
            forward.find()

    def test_disabled(self):
        forward = self.forward(4, 'line', more=SLOW)
        writer = self.blocked(forward)
        assert forward.stop() is None
        assert self.returned(writer) == 'EINVAL'

    def test_controller(self):
        forward = self.forward(4, 'line', more=SLOW)
        writer = self.blocked(forward)
        forward.set_sim('faults/spi_error_in', 1)
        assert self.returned(writer) == 'EIO'
        assert forward.stop() is None

    def test_killed(self):
        """Only one program can open the device: the next one can open it, and it works."""
        forward = self.forward(4, 'line', more=SLOW)
        assert forward.start(length=1024) is None
        for round_ in range(1, 6):
            child = os.fork()
            if not child:
                try:
                    stream = forward.open()
                    while True:
                        stream.write(scans(round_, 1) * 4000)
                finally:
                    os._exit(1)
            assert wait(lambda: forward.x_of('positions') == str(round_))
            os.kill(child, signal.SIGKILL)
            assert os.waitpid(child, 0) == (child, signal.SIGKILL)
        stream = forward.open()
        assert stream.write(scans(777, 1)) == 12
        stream.finish()
        assert forward.x_of('positions') == '777'

    def test_module_goes_before_the_buffer_is_closed(self):
        """A descriptor of the buffer does not hold a reference to the module."""
        forward = self.forward(4, 'line')
        device = forward.open()
        number = bytearray(4)
        fcntl.ioctl(device.fd, IIO_BUFFER_GET_FD, number)
        fd = struct.unpack('i', number)[0]
        device.close()
        assert forward.start() is None
        assert os.write(fd, scans(1, 10)) == 120
        kernel.remove_module('xy3_spi')
        try:
            assert error_name(os.write, fd, bytes(12)) == 'ENODEV'
            assert polled(fd, select.POLLOUT, 0) == 0
            dmabuf = struct.pack('i', -1)
            assert error_name(fcntl.ioctl, fd, IIO_BUFFER_DMABUF_ATTACH, dmabuf) == 'EPERM'
            os.close(fd)
        finally:
            forward_rig.load_driver()
        forward.find()
        assert forward.set('out_angl0_raw', 5) is None


class TestTwoHeads(Case):
    def test_streams(self):
        """Each gets only its scans, independent of other writers."""
        self.sim(4, 'line', more='heads=2')
        both = [self.channel(0), self.channel(1)]
        streams = []
        for forward in both:
            forward.record(30000)
            streams.append(forward.stream())
        for part in range(20):
            for number, stream in enumerate(streams):
                stream.write(scans(1 + number * 100000 + part * 1000, 1000))
            write_file(both[part % 2].head + 'calibrate', 'x')
        for number, (forward, stream) in enumerate(zip(both, streams)):
            stream.finish()
            assert forward.recorded() == scans(1 + number * 100000, 20000)
            # the end of the stream does not wait for the last command
            assert wait(lambda head=forward: head.sim_number('stats', 'commands') == 10)
            assert forward.bad_frames() == []

    def test_one_goes(self):
        self.sim(4, 'line', more='heads=2')
        one, other = self.channel(0), self.channel(1)
        stream = other.stream()
        other.record(1000)
        stream.write(scans(1, 300))
        one.unbind()
        assert head_rig.heads() == ['xy3-1']
        stream.write(scans(301, 300))
        stream.finish()
        assert other.recorded() == scans(1, 600)
        one.bind()
        assert head_rig.heads() == ['xy3-0', 'xy3-1']


class TestRates(Case):
    def in_sync(self, forward):
        return wait(lambda: read_file(forward.head + 'in_sync') == '1\n')

    def test_while_a_stream_runs(self):
        """All five, several times, without errors in scans."""
        forward = self.forward(4, 'line')
        assert forward.attach()
        forward.record(100000)
        stream = forward.stream()
        first, commands = 1, 0
        for rate in (57600, 921600, 115200, 230400, 460800) * 3:
            stream.write(scans(first, 1000))
            first += 1000
            write_file(forward.head + 'rate', str(rate))
            commands += 1
            assert forward.sim('rate') == str(rate)
            assert read_file(forward.head + 'rate') == '%d\n' % rate
            assert self.in_sync(forward), rate
        stream.finish()
        assert forward.recorded() == scans(1, first - 1)
        assert forward.sim_number('stats', 'commands') == commands
        assert forward.bad_frames() == []

    def still(self, forward, rate, error):
        """The rate cannot be changed, and the state is as before."""
        assert error_name(write_file, forward.head + 'rate', str(rate)) == error
        assert read_file(forward.head + 'rate') == '115200\n'
        assert forward.sim('rate') == '115200'
        assert self.in_sync(forward)

    def not_understood(self, forward):
        """The next command is received with a wrong bit."""
        forward.set_sim('faults/spi_flip_line', 2)      # of X
        forward.set_sim('faults/spi_flip_clock', 10)    # one of the bits of the command
        forward.set_sim('faults/spi_flip', 1)

    def test_a_head_that_has_not_understood(self):
        forward = self.forward(4, 'line')
        assert forward.attach()
        self.not_understood(forward)
        self.still(forward, 230400, 'ETIMEDOUT')
        write_file(forward.head + 'rate', '230400')
        assert forward.sim('rate') == '230400'

    def test_a_head_that_is_silent(self):
        """It changes the rate, but its packets are lost: it is set back."""
        forward = self.forward(4, 'line')
        assert forward.attach()
        forward.set_sim('faults/uart_silence', 1 << 30)
        began = time.monotonic()
        assert error_name(write_file, forward.head + 'rate', '57600') == \
            'ETIMEDOUT'
        assert time.monotonic() - began < 60
        forward.set_sim('faults/uart_silence', 0)
        codes = [code for code, *_ in forward.commands()]
        assert len(codes) == 2
        self.still(forward, 1200, 'EINVAL')

    def test_by_the_tty(self):
        forward = self.forward(4, 'line')
        assert forward.attach()
        self.not_understood(forward)
        fd = os.open('/dev/xy3-0', os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
        self.add_cleanup(os.close, fd)
        began = time.monotonic()
        head_rig.set_speed(fd, 460800)
        assert head_rig.get_speed(fd) == 460800     # requested
        assert time.monotonic() - began < 1
        assert wait(lambda: head_rig.get_speed(fd) == 115200)
        assert read_file(forward.head + 'rate') == '115200\n'
        head_rig.set_speed(fd, 460800)
        assert wait(lambda: read_file(forward.head + 'rate') == '460800\n')
        assert head_rig.get_speed(fd) == 460800

    def test_controller_error(self):
        """The command could not be sent: the rate of the UART is not changed."""
        forward = self.forward(4, 'line')
        assert forward.attach()
        forward.set_sim('faults/spi_error_in', 1)
        self.still(forward, 921600, 'EIO')


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
