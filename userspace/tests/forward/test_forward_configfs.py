# SPDX-License-Identifier: GPL-2.0-only
"""Virtual heads by configfs: of different kinds, created and removed while the others run."""

import glob
import os
import struct

import forward_rig
import head_rig
from forward_rig import CONFIGFS, Case
from kernel import read_file, wait

PARAMETERS = '/sys/module/xy3_sim/parameters/'


def scans(first, count, axes=3):
    return b''.join(struct.pack('<I', first + i) * axes for i in range(count))


class TestGroups(Case):
    def set_up(self):
        self.sim(more='heads=0')

    def test_settings(self):
        """Each module parameter is a setting of a group, and its initial value."""
        group = self.group('a')
        names = set(os.listdir(group.path)) - {'live', 'number'}
        assert names == set(os.listdir(PARAMETERS)) - {'heads'}
        for name in names:
            assert group.get(name) == read_file(PARAMETERS + name).rstrip('\n'), name
        for name, value in (('lines', '8'), ('cs_word', '1'), ('modes', '0,3'), ('idle', 'high'),
                            ('signals', 'sync x y'), ('signals', ''), ('max_transfer', '100')):
            group.set(name, value)
            assert group.get(name) == value
        for name, value in (('lines', '0'), ('lines', '9'), ('lines', 'x'), ('cs_word', '2'),
                            ('modes', '1'), ('idle', ''), ('signals', 48 * 'x'),
                            ('driver', 32 * 'x'), ('turnaround_us', '1000001')):
            before = group.get(name)
            assert group.error(name, value) == 'EINVAL', name
            assert group.get(name) == before

    def test_life(self):
        """If live, it has a number, a tty and a folder in debugfs, and its settings are fixed."""
        group = self.group('a', lines=1, framing='cs')
        assert (group.get('live'), group.get('number')) == ('0', '0')
        assert not os.path.exists(forward_rig.DEBUGFS + '0')
        for _ in range(3):
            group.set('live', 1)
            assert group.get('live') == '1'
            assert os.path.exists('/dev/ttyXY3SIM0')
            forward = self.channel(0)
            assert forward.set('out_angl0_raw', 77) is None
            assert forward.x_of('positions') == '77'
            assert group.error('live', 1) == 'EBUSY'
            assert group.error('lines', 2) == 'EBUSY'
            assert group.get('lines') == '1'
            group.set('live', 0)
            group.set('live', 0)
            assert not os.path.exists('/dev/ttyXY3SIM0')
            assert not os.path.exists(forward_rig.DEBUGFS + '0')
            assert glob.glob('/sys/bus/iio/devices/iio:device*') == []
            assert head_rig.heads() == []
        group.set('live', 1)
        group.remove()
        assert head_rig.heads() == []

    def test_settings_that_do_not_fit(self):
        for settings in ({'lines': 3}, {'lines': 4, 'driven_lines': 8}, {'device_lines': 5},
                         {'word_bits': 24}, {'lines': 1, 'framing': 'line'}, {'driver': ''},
                         {'lines': 1, 'signals': 'x y', 'framing': 'cs'},
                         {'signals': 'sync y z'}, {'signals': 'x x'}, {'signals': 'x v'}):
            group = self.group('a', **settings)
            assert group.error('live', 1) == 'EINVAL', settings
            assert group.get('live') == '0'
            group.remove()
        assert head_rig.heads() == []

    def test_numbers(self):
        """There are four, and the lowest free one is used."""
        groups = [self.group(name) for name in 'abcd']
        assert [group.number for group in groups] == [0, 1, 2, 3]
        assert head_rig.error_name(os.mkdir, CONFIGFS + 'e') == 'ENOSPC'
        groups[1].remove()
        assert self.group('e').number == 1

    def test_module_stays(self):
        """The module is in use as long as there is a group."""
        group = self.group('a')
        assert head_rig.error_name(forward_rig.kernel.unload_module, 'xy3_sim') == 'EAGAIN'
        group.remove()


class TestKinds(Case):
    def test_two_kinds(self):
        """At the same time as one of the module: each has the features of its controller."""
        self.sim(1, 'cs', more='modalias=spidev')
        # two of mainline, for example: only quad and flash modes; one line, words of 32 bits
        _, quad = self.head('quad', lines=4, framing='line', modes='0,3', clock_inverted=1,
                            idle='low', modalias='xy3-100')
        _, word = self.head('word', lines=1, framing='cs', cs_word=1, idle='high',
                            modalias='xy3-100')
        assert (quad.axes, word.axes) == (3, 1)
        streams = []
        for forward in (quad, word):
            forward.record(30000)
            streams.append(forward.stream())
        for part in range(20):
            streams[0].write(scans(1 + part * 1000, 1000))
            streams[1].write(scans(100001 + part * 1000, 1000, axes=1))
        for forward, stream in zip((quad, word), streams):
            stream.finish()
            assert forward.bad_frames() == []
        assert quad.recorded() == scans(1, 20000)
        assert word.recorded() == scans(100001, 20000, axes=1)

    def test_same_driver(self):
        """Two heads may have the same driver name, which is unregistered with the last one."""
        self.sim(more='heads=0')
        one = self.group('one', driver='tegra-qspi')
        other = self.group('other', driver='tegra-qspi')
        folder = '/sys/bus/platform/drivers/tegra-qspi'
        assert not os.path.exists(folder)
        one.set('live', 1)
        other.set('live', 1)
        one.set('live', 0)
        assert os.path.exists(folder)
        forward = self.channel(other.number)
        assert forward.set('out_angl0_raw', 77) is None
        assert forward.x_of('positions') == '77'
        other.set('live', 0)
        assert not os.path.exists(folder)

    def test_backchannel(self):
        """Each has a UART with a separate speed and packet rate."""
        self.sim(more='heads=0')
        self.group('none')
        _, forward = self.head('uart', uart_max=230400, sync_ms=50)
        assert forward.number_of_tty == 1
        forward.head = '/sys/class/xy3/xy3-0/'
        assert forward.attach()
        assert wait(lambda: read_file(forward.head + 'rate') == '115200\n')


class TestRemoval(Case):
    def gone(self, forward, stream):
        assert head_rig.error_name(stream.write, bytes(12)) == 'ENODEV'
        stream.close()
        assert not os.path.exists(forward.iio)

    def test_while_a_stream_runs(self):
        """Its file returns errors; the stream of the other head loses nothing."""
        self.sim(more='heads=0')
        group, forward = self.head('a', lines=4, framing='line')
        _, other = self.head('b', lines=4, framing='line', turnaround_us=50)
        stream, others = forward.stream(), other.stream()
        other.record(10000)
        stream.write(scans(1, 1000))
        others.write(scans(1, 1000))
        group.set('live', 0)
        self.gone(forward, stream)
        others.write(scans(1001, 1000))
        group.set('live', 1)
        again = self.channel(group.number)
        stream = again.stream()
        again.record(10000)
        stream.write(scans(1, 100))
        stream.finish()
        assert again.recorded() == scans(1, 100)
        stream = again.stream()
        stream.write(scans(1, 1000))
        group.remove()
        self.gone(again, stream)
        others.finish()
        assert other.recorded() == scans(1, 2000)

    def test_while_the_bus_is_locked(self):
        """Another device has the bus locked while the head is removed."""
        self.sim(more='heads=0')
        group, forward = self.head('a', lines=4, framing='line')
        stream = forward.stream()
        stream.write(scans(1, 1000))
        forward.set_sim('bus_lock_ms', 200)
        group.set('live', 0)
        self.gone(forward, stream)


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
