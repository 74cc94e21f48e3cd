# SPDX-License-Identifier: GPL-2.0-only
"""The virtual head of xy3-sim, and its IIO device of xy3-spi."""

import contextlib
import glob
import os

from harness import (BIND_TIME, check_no_allocations, command, jiffies, live_allocations,
                     module_addresses, module_loaded, read_file, unload_modules, wait_for,
                     write_file)
from serial_head import CLASS, LDISC, stop_ldattach

SIM = '/sys/kernel/debug/xy3-sim/0/'
IIO = '/sys/bus/iio/devices/'
COUNTERS = '/sys/kernel/debug/xy3-spi/'
DRIVER = '/sys/bus/spi/drivers/xy3-spi'
UART = '/dev/ttyXY3SIM0'
MODULES = ('xy3_sim', 'xy3_spi', 'xy3')


def sim(name):
    """Data received by the head, or its state."""
    return read_file(SIM + name).strip()


class Footprint:
    """Addresses of our modules: leaks are looked for at the end."""

    def __init__(self):
        self.since = None               # jiffies before the first one was loaded
        self.places = {name: set() for name in MODULES}

    def will_come(self):
        if self.since is None:
            self.since = jiffies()

    def note(self):
        for name, places in self.places.items():
            if module_loaded(name):
                places.add(module_addresses(name))

    def left(self):
        return live_allocations(self.places, self.since)

    def check(self):
        check_no_allocations(self.places, 'the modules have gone', self.since)


footprint = Footprint()


class VirtualHead:
    """A virtual head, by modprobe; keywords are parameters of the module.

        with VirtualHead(lines=4, framing='line') as head:
            head.set('out_angl0_raw', 5)
            assert head.positions(20)[0] == 5

    driver=None: no driver is expected to bind to the SPI device.
    controller: name of the driver that the controller appears to have
    """

    def __init__(self, driver='xy3-spi', controller='xy3-sim', **parameters):
        self.driver = driver
        parameters['driver'] = controller
        self.parameters = ['%s=%s' % one for one in parameters.items()]
        self.spi = self.iio = self.buffer = self.axes = None
        self.node = '/dev/xy3-0'

    def __enter__(self):
        footprint.will_come()
        command('modprobe', 'xy3-sim', *self.parameters)
        try:
            self.spi = '/sys/bus/spi/devices/' + sim('devices').split()[1]
            if self.driver:
                self.wait_bound()
            return self
        except BaseException:
            self.__exit__()
            raise

    def __exit__(self, *_):
        footprint.note()
        unload_modules('xy3-sim')

    def wait_bound(self):
        self.iio = wait_for(self._find_iio, 'the IIO device', BIND_TIME)
        self.buffer = '/dev/' + os.path.basename(self.iio)
        for node in (self.buffer, self.node):
            wait_for(lambda node=node: os.path.exists(node), node, BIND_TIME)
        self.axes = len(glob.glob(self.iio + '/out_angl*_raw'))

    def _find_iio(self):
        for path in glob.glob(IIO + 'iio:device*'):
            if read_file(path + '/name') == 'xy3-100\n':
                return path
        return None

    # --- the IIO device ----------------------------------------------------------------------

    def set(self, name, value):
        write_file('%s/%s' % (self.iio, name), str(value))

    def number(self, name):
        """A counter of the driver."""
        return int(read_file('%s%s/%s' % (COUNTERS, os.path.basename(self.spi), name)))

    def start(self):
        for axis in range(self.axes):
            self.set('scan_elements/out_angl%d_en' % axis, 1)
        self.set('buffer/enable', 1)

    @contextlib.contextmanager
    def streaming(self):
        self.start()
        try:
            yield
        finally:
            self.set('buffer/enable', 0)

    # --- what the head has received ----------------------------------------------------------

    def positions(self, bits):
        """All positions, which must have been received in frames of `bits` bits."""
        rows = [line.split() for line in sim('positions').splitlines()]
        assert {row[2] for row in rows} == {str(bits)}
        return [int(row[1]) for row in rows]

    def counts(self, name):
        """Counts by axis"""
        return [int(line.split()[1]) for line in sim(name).splitlines()]

    def record(self, scans):
        """Records the next scans, and one more, except repetitions of the previous one."""
        write_file(SIM + 'record', '%d changes' % (scans + 1))

    def check_record(self, data):
        with open(SIM + 'record.bin', 'rb') as file:
            found = file.read()
        assert len(found) == len(data)
        if found != data:
            at = [a == b for a, b in zip(found, data)].index(False) // (4 * self.axes)
            assert found[4 * self.axes * at:][:16] == data[4 * self.axes * at:][:16], 'scan %d' % at
        for name in ('parity_errors', 'length_errors', 'mode_errors'):
            assert self.counts(name) == [0] * self.axes, name

    # --- the head's backchannel --------------------------------------------------------------

    def path(self, name):
        return '%s/xy3-0/%s' % (CLASS, name)

    @contextlib.contextmanager
    def attached(self):
        command('ldattach', '-s', '115200', '-8', '-n', '-1', str(LDISC), UART)
        try:
            wait_for(lambda: read_file(self.path('in_sync')) == '1\n', 'sync', BIND_TIME)
            yield
        finally:
            stop_ldattach(UART)
