# SPDX-License-Identifier: GPL-2.0-only
"""libxy3 with the kernel's spidev: the virtual head receives what is written, scan by scan; if
spidev or its controller does not support it, that is an error, not a loss.

The library is the shared one, XY3_LIBRARY; SPIDEV_MODULE is the path of spidev.ko.
"""

import ctypes
import errno
import fcntl
import os
import random
import struct
import pytest
import case

import kernel
from kernel import read_file, wait, write_file

SIM = os.path.dirname(os.environ.get('XY3_MODULE', '')) + '/sim/xy3-sim.ko'
DEBUGFS = '/sys/kernel/debug/xy3-sim/0/'
SPI_IOC_RD_MODE32, SPI_IOC_WR_MODE32 = 0x80046b05, 0x40046b05
SPI_IOC_MESSAGE_1 = 0x40206b00
SPI_MODE_1, SPI_MODE_3, SPI_TX_QUAD = 1, 3, 0x200
CALIBRATE, REFERENCE = 0xc0000, 0x20000
# lines, framing, signals as the library requires them
ARRANGEMENTS = ((1, 'cs', None), (2, 'cs', 'y x'), (4, 'cs', None), (8, 'cs', None),
                (4, 'line', 'sync x y z'), (8, 'line', 'sync x y z u w'))

library = ctypes.CDLL(os.environ.get('XY3_LIBRARY'))
library.xy3_line_map_new.argtypes = [ctypes.POINTER(ctypes.c_void_p), ctypes.c_uint, ctypes.c_uint,
                                     ctypes.c_char_p]
library.xy3_line_map_free.argtypes = [ctypes.c_void_p]
library.xy3_line_map_axes.argtypes = [ctypes.c_void_p]
library.xy3_code_max.argtypes = [ctypes.c_void_p]
library.xy3_code_max.restype = ctypes.c_uint32
library.xy3_spidev_open.argtypes = [ctypes.POINTER(ctypes.c_void_p), ctypes.c_char_p,
                                    ctypes.c_void_p, ctypes.c_uint]
library.xy3_spidev_close.argtypes = [ctypes.c_void_p]
library.xy3_spidev_write.argtypes = [ctypes.c_void_p, ctypes.POINTER(ctypes.c_uint32),
                                     ctypes.c_size_t]
library.xy3_spidev_write.restype = ctypes.c_ssize_t
library.xy3_spidev_repeat.argtypes = [ctypes.c_void_p, ctypes.c_size_t]
library.xy3_spidev_repeat.restype = ctypes.c_ssize_t
library.xy3_spidev_command.argtypes = [ctypes.c_void_p, ctypes.c_uint32]
library.xy3_spidev_block.argtypes = [ctypes.c_void_p]


def checked(result):
    """OSError for a negative errno"""
    if result < 0:
        raise OSError(-result, os.strerror(-result))
    return result


class Spidev:
    """An open device of the library."""

    def __init__(self, path, lines=1, signals=None, bits=24, rate=0):
        line_map = ctypes.c_void_p()
        checked(library.xy3_line_map_new(line_map, lines, bits, signals and signals.encode()))
        self.handle = ctypes.c_void_p()
        self.axes = library.xy3_line_map_axes(line_map)
        self.code_max = library.xy3_code_max(line_map)
        error = library.xy3_spidev_open(self.handle, path.encode(), line_map, rate)
        library.xy3_line_map_free(line_map)
        checked(error)

    def close(self):
        library.xy3_spidev_close(self.handle)

    def write(self, scans):
        codes = [code for scan in scans for code in scan]
        return checked(library.xy3_spidev_write(
            self.handle, (ctypes.c_uint32 * len(codes))(*codes), len(scans)))

    def repeat(self, scans):
        return checked(library.xy3_spidev_repeat(self.handle, scans))

    def command(self, code):
        return checked(library.xy3_spidev_command(self.handle, code))

    def block(self):
        return library.xy3_spidev_block(self.handle)


class Case(case.Case):
    def head(self, lines=1, framing='cs', more=''):
        """Creates a virtual head on a controller whose lines float between messages -> the path of
        its spidev
        """
        kernel.load_module(SIM, 'modalias=spidev idle=float lines=%d framing=%s %s' % (
            lines, framing, more))
        self.add_cleanup(kernel.remove_module, 'xy3_sim')
        self.spi = self.sim('devices')['spi']
        path = '/dev/' + self.sim('devices')['spidev']
        assert wait(lambda: os.path.exists(path)), path
        write_file(DEBUGFS + 'record', '100000')
        return path

    def spidev(self, *arguments, **keywords):
        spidev = Spidev(*arguments, **keywords)
        self.add_cleanup(spidev.close)
        return spidev

    def reload_spidev(self, parameters):
        kernel.remove_module('spidev')
        kernel.load_module(os.environ['SPIDEV_MODULE'], parameters)

    def sim(self, name):
        """{name: value}"""
        return dict(line.split()[:2] for line in read_file(DEBUGFS + name).splitlines())

    def scans(self, spidev, count, seed=1):
        chance = random.Random(seed)
        return [tuple(chance.randint(0, spidev.code_max) for _ in range(spidev.axes))
                for _ in range(count)]

    def assert_received(self, scans):
        """Checks that exactly these scans were received, in this order, without errors"""
        assert int(self.sim('stats')['scans']) == len(scans)
        received = read_file(DEBUGFS + 'record').splitlines()
        assert received == [' '.join(map(str, scan)) for scan in scans]
        for name in ('parity_errors', 'length_errors', 'mode_errors'):
            assert set(self.sim(name).values()) == {'0'}, name
        for name in ('unknown_commands', 'short_gaps', 'stray_clocks'):
            assert self.sim('stats')[name] == '0', name

    def assert_error(self, code, function, *arguments, **keywords):
        with pytest.raises(OSError) as caught:
            function(*arguments, **keywords)
        assert caught.value.errno == getattr(errno, code), caught.value


class TestClosedLoop(Case):
    @pytest.mark.parametrize('bits', (24, 32))
    @pytest.mark.parametrize('lines, framing, signals', ARRANGEMENTS)
    def test_every_scan(self, lines, framing, signals, bits):
        path = self.head(lines, framing, 'signals=' + signals.replace(' ', ',') if signals else '')
        spidev = self.spidev(path, lines, signals, bits)
        chance = random.Random(lines * 100 + bits)
        scans = self.scans(spidev, 3000, seed=bits)
        done = 0
        while done < len(scans):
            part = scans[done:done + chance.choice((1, 2, 100, 511, 512, 1500))]
            assert spidev.write(part) == len(part)
            done += len(part)
        self.assert_received(scans)
        bus = self.sim('bus')
        assert int(bus['transfers']) == (int(bus['messages']) if framing == 'line' else 3000)
        assert int(bus['messages']) < 1000

    def test_commands_between_scans(self):
        path = self.head(4, 'line')
        spidev = self.spidev(path, 4, 'sync x y z')
        scans = self.scans(spidev, 1000)
        for n in range(10):
            assert spidev.write(scans[n * 100:n * 100 + 100]) == 100
            spidev.command((REFERENCE if n % 2 else CALIBRATE) | n)
        self.assert_received(scans)
        commands = [line.split()[:2] for line in read_file(DEBUGFS + 'commands').splitlines()]
        assert commands == [['%d' % (n * 100 + 100),
                             '%05x' % ((REFERENCE if n % 2 else CALIBRATE) | n)]
                            for n in range(10)]
        self.assert_error('ERANGE', spidev.command, 1 << 20)

    def test_repeat(self):
        spidev = self.spidev(self.head(2, 'cs'), 2)
        self.assert_error('ENODATA', spidev.repeat, 1)
        spidev.write([(1, 2), (3, 4)])
        spidev.command(CALIBRATE)
        assert spidev.repeat(1200) == 1200
        self.assert_received([(1, 2)] + [(3, 4)] * 1201)

    def test_code_out_of_range(self):
        spidev = self.spidev(self.head(2, 'cs'), 2)
        self.assert_error('ERANGE', spidev.write, [(1, 2), (3, 1 << 20)])
        self.assert_received([])

    def test_rate(self):
        path = self.head(4, 'line', 'max_speed_hz=2600000')
        self.assert_error('ERANGE', Spidev, path, 4, 'sync x y z', rate=100001)
        self.assert_error('ERANGE', Spidev, path, 4, 'sync x y z', bits=32, rate=100000)
        spidev = self.spidev(path, 4, 'sync x y z', rate=100000)
        spidev.write(self.scans(spidev, 1000))
        # a frame every 10 us, and before each message a gap of two of its 26 clocks
        bus = {name: int(value) for name, value in self.sim('bus').items()}
        assert bus['clocks'] == 1000 * 26 + 2 * bus['messages']
        assert abs(bus['busy_ns'] - bus['clocks'] * 10000 / 26) <= bus['messages']


class TestMode(Case):
    def mode(self, path, new=None):
        """-> the mode of the device; new: sets it"""
        fd = os.open(path, os.O_RDWR)
        try:
            if new is not None:
                fcntl.ioctl(fd, SPI_IOC_WR_MODE32, struct.pack('I', new))
            return struct.unpack('I', fcntl.ioctl(fd, SPI_IOC_RD_MODE32, b'\0' * 4))[0]
        finally:
            os.close(fd)

    def test_controller_without_so_many_lines(self):
        path = self.head(2, 'cs', 'signals=x,y')
        assert self.mode(path, SPI_MODE_3) == SPI_MODE_3
        self.assert_error('EOPNOTSUPP', Spidev, path, 4, 'sync x y z')
        self.assert_error('EOPNOTSUPP', Spidev, path, 8)
        assert self.mode(path) == SPI_MODE_3       # unchanged
        self.assert_received([])
        spidev = self.spidev(path, 2)
        spidev.write([(5, 6)])
        self.assert_received([(5, 6)])

    def test_wrong_mode(self):
        path = self.head(4, 'cs')
        self.mode(path, SPI_MODE_3)
        spidev = self.spidev(path, 4)
        assert self.mode(path) == SPI_MODE_1 | SPI_TX_QUAD
        spidev.write([(1, 2, 3, 4)])
        self.assert_received([(1, 2, 3, 4)])
        # the head detects it
        self.mode(path, SPI_MODE_3 | SPI_TX_QUAD)
        spidev.write([(5, 6, 7, 8)])
        assert set(self.sim('mode_errors').values()) == {'1'}

    def test_no_spidev(self):
        self.assert_error('ENOTTY', Spidev, '/dev/null')
        self.assert_error('ENOENT', Spidev, '/dev/spidev99.9')


class TestLimits(Case):
    def with_bufsiz(self, size, lines, framing, signals, count):
        """-> the device, after it has sent some scans through spidev with another bufsiz"""
        self.reload_spidev('bufsiz=%d' % size)
        self.add_cleanup(self.reload_spidev, '')
        spidev = self.spidev(self.head(lines, framing), lines, signals)
        scans = self.scans(spidev, count)
        assert spidev.write(scans) == count
        self.assert_received(scans)
        return spidev

    def test_large_bufsiz(self):
        self.with_bufsiz(65536, 4, 'line', 'sync x y z', 10000)
        assert int(self.sim('bus')['messages']) == 2

    def test_small_bufsiz(self):
        spidev = self.with_bufsiz(32, 4, 'line', 'sync x y z', 99)
        assert spidev.block() == 2
        spidev.command(CALIBRATE)
        assert self.sim('stats')['commands'] == '1'

    def test_small_bufsiz_for_many_transfers(self):
        # each transfer is rounded up: fewer scans than the number of bytes suggests
        spidev = self.with_bufsiz(64, 1, 'cs', None, 99)
        assert int(self.sim('bus')['transfers']) == 99
        assert spidev.block() >= 4

    def test_not_one_scan_fits(self):
        self.reload_spidev('bufsiz=8')
        self.add_cleanup(self.reload_spidev, '')
        spidev = self.spidev(self.head(4, 'line'), 4, 'sync x y z')
        self.assert_error('EMSGSIZE', spidev.write, [(1, 2, 3)] * 5)
        self.assert_error('EMSGSIZE', spidev.command, CALIBRATE)
        self.assert_received([])

    def test_controller_with_short_transfers(self):
        spidev = self.spidev(self.head(4, 'line', 'max_transfer=100'), 4, 'sync x y z')
        scans = self.scans(spidev, 1000)
        assert spidev.write(scans) == 1000
        self.assert_received(scans)
        # the SPI core has split messages into transfers that the controller supports
        assert int(self.sim('bus')['transfers']) >= 1000 * 13 // 100


class TestWords(Case):
    """Without the library: sizes of words that it does not use."""

    def send(self, fd, data, bits=8, speed=1000000):
        """A transfer on IO0."""
        buffer = ctypes.create_string_buffer(data, len(data))
        fcntl.ioctl(fd, SPI_IOC_MESSAGE_1,
                    struct.pack('QQIIHBBBBBB', ctypes.addressof(buffer), 0, len(data), speed, 0,
                                bits, 0, 1, 0, 0, 0))

    def open(self, more):
        fd = os.open(self.head(2, 'cs', more), os.O_RDWR)
        self.add_cleanup(os.close, fd)
        return fd

    def test_slower_than_the_clock_can_be_halved(self):
        fd = self.open('clock=halved realtime=0')
        self.send(fd, bytes(3), speed=1)
        assert self.sim('bus')['clocks'] == '24'

    @pytest.mark.parametrize('bits, code', ((8, 'I'), (16, 'H'), (32, 'I')))
    def test_sizes(self, bits, code):
        """In memory a word has native byte order, on the wire its highest bit is first."""
        fd = self.open('cs_word=1')
        for position in (1, 0x155aa33, 0x2aa55cc):
            frame = 0xc0000000 | position << 4 | bin(position).count('1') & 15
            words = [frame >> at & (1 << bits) - 1 for at in range(32 - bits, -1, -bits)]
            self.send(fd, bytes(words) if bits == 8 else struct.pack('%d%s' % (32 // bits, code),
                                                                     *words), bits)
            assert read_file(DEBUGFS + 'positions').split()[:3] == ['x', str(position), '26']

    def test_zeros(self):
        """24 clocks of zeros are an idle line, 32 a frame that is too long."""
        fd = self.open('')
        self.send(fd, bytes(3))
        assert (self.sim('idle')['x'], self.sim('length_errors')['x']) == ('1', '0')
        self.send(fd, bytes(4))
        assert (self.sim('idle')['x'], self.sim('length_errors')['x']) == ('1', '1')


class TestErrors(Case):
    def test_controller_error(self):
        spidev = self.spidev(self.head(4, 'line'), 4, 'sync x y z')
        scans = self.scans(spidev, 1000)
        write_file(DEBUGFS + 'faults/spi_error_in', '3')
        sent = spidev.write(scans)
        assert sent == 2 * spidev.block()
        write_file(DEBUGFS + 'faults/spi_error_in', '1')
        self.assert_error('EIO', spidev.write, scans[sent:])
        self.assert_received(scans[:sent])
        assert spidev.write(scans[sent:]) == 1000 - sent
        self.assert_received(scans)

    def test_device_goes(self):
        spidev = self.spidev(self.head(1, 'cs'))
        assert spidev.write([(7,)]) == 1
        write_file('/sys/bus/spi/drivers/spidev/unbind', self.spi)
        self.assert_error('ESHUTDOWN', spidev.write, [(8,)])
        self.assert_error('ESHUTDOWN', spidev.repeat, 1)
        self.assert_error('ESHUTDOWN', spidev.command, CALIBRATE)
        self.assert_received([(7,)])


def setup_module():
    kernel.load_module(os.environ['SPIDEV_MODULE'])


def teardown_module():
    kernel.remove_module('spidev')
