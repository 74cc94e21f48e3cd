# SPDX-License-Identifier: GPL-2.0-only
"""Common to tests of the forward channel of scanheads: virtual heads (xy3-sim), and their IIO
devices of xy3-spi.
"""

import fcntl
import glob
import os
import struct
import subprocess
import termios
import tty
import case

import head_rig
import kernel
from kernel import read_file, wait, write_file

FOLDER = os.path.dirname(os.environ.get('XY3_MODULE', ''))
DEBUGFS = '/sys/kernel/debug/xy3-sim/'
CONFIG = '/sys/kernel/config'
CONFIGFS = CONFIG + '/xy3-sim/'
DRIVER = '/sys/bus/spi/drivers/xy3-spi/'
COUNTERS = '/sys/kernel/debug/xy3-spi/'
# lines, framing, the controller has SPI_CS_WORD
ARRANGEMENTS = ((1, 'cs', 0), (1, 'cs', 1), (2, 'cs', 0), (4, 'cs', 0), (8, 'cs', 0),
                (4, 'line', 0), (8, 'line', 0))


def load_driver():
    kernel.load_module(FOLDER + '/spi/xy3-spi.ko')


def load():
    head_rig.load()
    load_driver()


def unload():
    kernel.remove_module('xy3_spi')
    head_rig.unload()


def load_sim(lines=4, framing='line', cs_word=0, more=''):
    """In time-travel mode transfers take time, unless `more` disables that: a stream repeats its
    last position forever, and if transfers took no time, no time would ever pass.
    """
    kernel.load_module(FOLDER + '/sim/xy3-sim.ko',
                       'lines=%d framing=%s cs_word=%d realtime=%d %s'
                       % (lines, framing, cs_word, kernel.TIME_TRAVEL, more))


def unload_sim():
    """Unloads it if it is loaded."""
    if kernel.is_loaded('xy3_sim'):
        kernel.remove_module('xy3_sim')


class Group:
    """A folder in configfs: a virtual head, when it is live."""

    def __init__(self, name, **settings):
        if not os.path.ismount(CONFIG):
            subprocess.run(['mount', '-t', 'configfs', 'configfs', CONFIG], check=True)
        self.path = CONFIGFS + name + '/'
        os.mkdir(self.path)
        for setting, value in settings.items():
            self.set(setting, value)

    def get(self, name):
        return read_file(self.path + name).rstrip('\n')

    def set(self, name, value):
        write_file(self.path + name, '%s\n' % value)

    def error(self, name, value):
        return head_rig.error_name(self.set, name, value)

    @property
    def number(self):
        return int(self.get('number'))

    def remove(self):
        """Removes it if it exists."""
        if os.path.isdir(self.path):
            os.rmdir(self.path)


class Stream:
    """The IIO device of a forward channel, open for writing."""

    def __init__(self, forward, flags=0):
        self.forward = forward
        self.fd = os.open('/dev/' + os.path.basename(forward.iio.rstrip('/')),
                          os.O_WRONLY | flags)

    def close(self):
        if self.fd is not None:
            os.close(self.fd)
            self.fd = None

    def write(self, data):
        """-> number of bytes written"""
        return os.write(self.fd, data)

    def write_all(self, data, piece):
        """Writes in pieces, whose sizes are returned by piece()."""
        data = memoryview(data)
        while data:
            data = data[self.write(data[:piece()]):]

    def finish(self):
        """Sends pending data and disables the buffer; an error fails the test."""
        try:
            write_file(self.forward.iio + 'buffer/enable', '0')
        finally:
            self.close()


class Forward:
    """A virtual head, and the IIO device of its forward channel."""

    def __init__(self, number=0):
        self.debugfs = '%s%d/' % (DEBUGFS, number)
        self.device = self.sim('devices').split()[1]
        self.spi = '/sys/bus/spi/devices/%s/' % self.device
        self.counters = '%s%s/' % (COUNTERS, self.device)
        self.head = '/sys/class/xy3/xy3-%d/' % number
        self.number_of_tty = number
        self.uart = None
        self.streams = []
        self.find()

    def find(self):
        """Finds the IIO device, which is created again by another line map."""
        found = wait(lambda: glob.glob(self.spi + 'iio:device*'))
        if not found:
            raise AssertionError('%s has no IIO device' % self.device)
        self.iio = found[0] + '/'
        self.axes = len(glob.glob(self.iio + 'out_angl*_raw'))

    def close(self):
        for stream in self.streams:
            stream.close()
        if self.uart is not None:
            os.close(self.uart)
            self.uart = None

    def get(self, name):
        return read_file(self.iio + name).strip()

    def number(self, name):
        """The value of an attribute, or of a counter in debugfs."""
        if os.path.exists(self.counters + name):
            return int(read_file(self.counters + name))
        return int(self.get(name))

    def written(self):
        """-> number of scans sent that do not repeat a position"""
        while True:
            repeated = self.number('repeated')
            scans = self.number('scans')
            if self.number('repeated') == repeated:
                return scans - repeated

    def set(self, name, value):
        return head_rig.error_name(write_file, self.iio + name, str(value))

    def sim(self, name):
        return read_file(self.debugfs + name).strip()

    def set_sim(self, name, value):
        write_file(self.debugfs + name, str(value))

    def sim_number(self, file, name):
        """The number in a line of a file."""
        return int(dict(line.split(' ', 1) for line in self.sim(file).splitlines())[name])

    def x_of(self, name):
        return self.sim(name).split()[1]

    def bad_frames(self):
        """-> the head's counts of erroneous frames, if they are not 0"""
        found = ['%s: %s' % (name, line) for name in ('parity_errors', 'length_errors',
                                                      'mode_errors')
                 for line in self.sim(name).splitlines() if line.split()[1] != '0']
        return found + [name for name in ('short_gaps', 'stalled_frames')
                        if self.sim_number('stats', name)]

    def record(self, scans, changes=True):
        """Records scans from now on, or only those that differ from the one before."""
        self.set_sim('record', '%d%s' % (scans, ' changes' * changes))

    def recorded(self):
        """-> bytes, in the format of the buffer"""
        with open(self.debugfs + 'record.bin', 'rb', buffering=0) as file:
            return file.read()

    def start(self, axes=None, length=4096):
        for axis in range(self.axes):
            self.set('scan_elements/out_angl%d_en' % axis, int(axes is None or axis in axes))
        self.set('buffer/length', length)
        return self.set('buffer/enable', 1)

    def stop(self):
        return self.set('buffer/enable', 0)

    def open(self, flags=0):
        """-> Stream, which is closed after the test at the latest"""
        self.streams.append(Stream(self, flags))
        return self.streams[-1]

    def stream(self, flags=0, **options):
        """Enables the buffer with the options of start(). -> Stream"""
        error = self.start(**options)
        if error:
            raise AssertionError('the stream does not start: %s' % error)
        return self.open(flags)

    def bind(self):
        write_file(DRIVER + 'bind', self.device)

    def unbind(self):
        write_file(DRIVER + 'unbind', self.device)

    def commands(self):
        """-> [(code, name and axes), ...]"""
        return [tuple(line.split(' ', 2)[1:]) for line in self.sim('commands').splitlines()]

    def codes(self):
        """-> codes of the commands received"""
        return [code for code, *_ in self.commands()]

    def attach(self):
        self.uart = os.open('/dev/ttyXY3SIM%d' % self.number_of_tty, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self.uart)
        head_rig.set_speed(self.uart, 115200)
        fcntl.ioctl(self.uart, termios.TIOCSETD, struct.pack('i', head_rig.LDISC))
        return wait(lambda: read_file(self.head + 'in_sync') == '1\n')


class Case(case.Case):
    def sim(self, *arguments, **keywords):
        load_sim(*arguments, **keywords)
        self.add_cleanup(unload_sim)

    def channel(self, number=0):
        """The forward channel of a virtual head that exists already."""
        forward = Forward(number)
        self.add_cleanup(forward.close)
        return forward

    def group(self, name, **settings):
        """The group of a head that is not live yet."""
        group = Group(name, **settings)
        self.add_cleanup(group.remove)
        return group

    def head(self, name, **settings):
        """-> the group of a virtual head that is live, its forward channel"""
        group = self.group(name, **settings)
        group.set('live', 1)
        return group, self.channel(group.number)

    def forward(self, *arguments, **keywords):
        """The forward channel of the only virtual head."""
        self.sim(*arguments, **keywords)
        return self.channel()
