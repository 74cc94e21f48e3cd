# SPDX-License-Identifier: GPL-2.0-only
"""xy3ctl with a scanhead in an artificial /sys and /dev, for tests that require no kernel.

The tool runs in a mount namespace in which these trees are /sys and /dev. The files accept
all writes: refusals of the drivers are tested in tools/test_xy3ctl.py. The scans of a
stream are in /dev/iio:device0 afterwards.
"""

import os
import struct
import subprocess
import tempfile

from tool import Running, Tool, build_sanitized

MIDDLE = 0x80000
TOP = 0xfffff
SCRIPT = 'mount --bind "$0" /sys && mount --bind "$1" /dev && shift && exec "$@"'


class PlantedTool(Tool):
    def __init__(self, folder):
        super().__init__('xy3ctl')
        self.path = 'unshare'
        self.words = ['--user', '--map-root-user', '--mount', 'sh', '-c', SCRIPT,
                      folder + '/sys', folder + '/dev',
                      os.path.join(build_sanitized(), 'xy3ctl')]
        self.environment = {
            **os.environ, 'TZ': 'UTC', 'ASAN_OPTIONS': 'exitcode=99:detect_leaks=1',
            'UBSAN_OPTIONS': 'halt_on_error=1:exitcode=99'}

    def run(self, *words, text='', timeout=60):
        stdin = {'stdin': text} if hasattr(text, 'read') else {
            'input': text.encode() if isinstance(text, str) else text}
        done = subprocess.run([self.path, *self.words, *words], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, timeout=timeout, check=False,
                              env=self.environment, **stdin)
        return done.returncode, done.stdout.decode(), done.stderr.decode()

    def start(self, *words, **options):
        return Running(self, (*self.words, *words), env=self.environment, **options)


class PlantedHead:
    """One head with both channels, frames of 24 bits, and axes; with a gate also its channel."""

    def __init__(self, axes='xyz', gate=False):
        self._folder = tempfile.TemporaryDirectory()
        self.folder = self._folder.name
        self.axes, self.gate = axes, gate
        self.xy3ctl = PlantedTool(self.folder)
        self.iio = self.folder + '/sys/devices/spi/iio:device0'
        self.counters = self.folder + '/sys/kernel/debug/xy3-spi/spi'
        self.head = self.folder + '/sys/class/xy3/xy3-0'
        self.node = self.folder + '/dev/iio:device0'
        for name in ('sys', 'dev'):
            os.mkdir('%s/%s' % (self.folder, name))

    def close(self):
        self._folder.cleanup()

    def plant(self):
        for name, text in (('in_sync', '1'), ('rate', '115200')):
            self.write('%s/%s' % (self.head, name), text)
        for name, text in (('frame_bits', '24'), ('sampling_frequency', '100000'),
                           ('achieved_frequency', '0'), ('underruns', '0'), ('abort', ''),
                           ('buffer/length', '0'), ('buffer/enable', '0'),
                           ('buffer/data_available', '0')):
            self.write('%s/%s' % (self.iio, name), text)
        for name in ('scans', 'repeated', 'commands'):
            self.write('%s/%s' % (self.counters, name), '0')
        channels = [('out_angl%d' % i, axis) for i, axis in enumerate(self.axes)]
        for channel, label in channels + [('out_voltage0', 'gate')] * self.gate:
            self.write('%s/scan_elements/%s_en' % (self.iio, channel), '0')
            self.write('%s/%s_label' % (self.iio, channel), label)
            if label != 'gate':
                self.write('%s/%s_raw' % (self.iio, channel), str(MIDDLE))
        os.makedirs(self.folder + '/sys/bus/iio/devices')
        os.symlink('../../../devices/spi/iio:device0',
                   self.folder + '/sys/bus/iio/devices/iio:device0')
        os.symlink('../../../devices/spi', self.head + '/forward')
        self.forget()

    def write(self, path, text):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, 'w', encoding='ascii') as file:
            file.write(text + '\n')

    def read(self, name):
        """An attribute of the IIO device. It is a plain file: longer old text is not truncated."""
        with open('%s/%s' % (self.iio, name), encoding='ascii') as file:
            return file.read()

    def forget(self):
        with open(self.node, 'wb'):
            pass

    def scans(self):
        """-> the data streamed since forget()"""
        with open(self.node, 'rb') as file:
            data = file.read()
        columns = len(self.axes) + self.gate
        return list(struct.iter_unpack('<%dI' % columns, data))
