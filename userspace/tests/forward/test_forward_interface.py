# SPDX-License-Identifier: GPL-2.0-only
"""The interface of a forward channel besides scans: the places of counters, and the state that is
kept with another line map.
"""

import os
import struct

import forward_rig
from forward_rig import Case
from head_rig import error_name
from kernel import read_file, wait, write_file

COUNTERS = ('scans', 'repeated', 'commands', 'bus_errors', 'clamped_codes')


class TestCounters(Case):
    def test_where_they_are(self):
        """In debugfs, except those that users poll or require to check a stream."""
        forward = self.forward(4, 'line')
        for name in COUNTERS:
            assert not os.path.exists(forward.iio + name), name
        assert sorted(os.listdir(forward.counters)) == sorted(COUNTERS)
        for name in ('underruns', 'achieved_frequency'):
            assert forward.get(name) == '0', name

    def test_they_count(self):
        forward = self.forward(4, 'line')
        stream = forward.stream()
        stream.write(struct.pack('<9I', 1, 2, 3, 1 << 20, 2, 3, 4, 5, 6))
        assert wait(lambda: forward.number('repeated') > 0)
        stream.finish()
        assert forward.number('scans') == 3 + forward.number('repeated')
        assert forward.number('clamped_codes') == 1
        assert forward.number('commands') == forward.number('bus_errors') == 0

    def test_two_heads(self):
        """Each has separate ones, which are removed with it."""
        self.sim(4, 'line', more='heads=2')
        one, two = self.channel(0), self.channel(1)
        assert two.set('out_angl0_raw', 5) is None
        assert (one.number('scans'), two.number('scans')) == (0, 1)
        one.unbind()
        assert not os.path.exists(one.counters)
        assert two.number('scans') == 1
        one.bind()
        one.find()
        assert one.number('scans') == 0


class TestWaiting(Case):
    """Written scans that the controller does not have yet. At one frame per second it has three
    blocks of 32 scans, and sends the first of them all the time.
    """

    SCAN = struct.pack('<3I', 7, 8, 9)

    def test_scans_that_wait(self):
        forward = self.forward(4, 'line', more='realtime=1')
        assert forward.set('sampling_frequency', 1) is None
        stream = forward.stream(length=1024, flags=os.O_NONBLOCK)
        for _ in range(3):
            waiting = 0
            while not error_name(stream.write, self.SCAN * 10):
                waiting += 10
            # space for twice the length, including the controller; the rest is too short
            assert 2048 - 3 * 32 - 10 < waiting <= 2048 + 3 * 32
            assert waiting - 3 * 32 <= forward.number('buffer/data_available') <= waiting
            assert forward.set('abort', 1) is None
            assert forward.number('buffer/data_available') == 0
        stream.finish()


class TestScale(Case):
    def places(self, forward, codes):
        """-> position of X for each code, by offset and scale"""
        found = []
        for code in codes:
            assert forward.set('out_angl0_raw', code) is None
            found.append((forward.number('out_angl0_raw') + forward.number('out_angl_offset')) *
                         float(forward.get('out_angl_scale')))
        return found

    def test_places(self):
        """Exact, and the same for both sizes of frames."""
        forward = self.forward(4, 'line')
        assert self.places(forward, (0, 1 << 19, (1 << 19) + 1, (1 << 20) - 1)) == \
            [-524288, 0, 1, 524287]
        assert forward.set('frame_bits', 32) is None
        assert self.places(forward, (0, 1 << 25, (1 << 25) + 1, (1 << 25) + 64, (1 << 26) - 1)) == \
            [-524288, 0, 1 / 64, 1, 524288 - 1 / 64]

    def test_not_to_be_written(self):
        forward = self.forward(4, 'line')
        for name in ('out_angl_offset', 'out_angl_scale'):
            was = forward.get(name)
            assert forward.set(name, '2') == 'EINVAL'
            assert forward.get(name) == was


class TestLineMap(Case):
    """Another line map creates another IIO device, which keeps the state of the last one."""

    STAYS = ('frame_bits', 'sampling_frequency', 'underruns')

    def map(self, forward, words):
        """-> the name of the error, or None"""
        error = error_name(write_file, forward.spi + 'line_map', words)
        forward.find()
        return error

    def used(self):
        """A channel with settings, positions and counters other than the defaults."""
        forward = self.forward(4, 'line')
        assert forward.set('frame_bits', 32) is None
        assert forward.set('sampling_frequency', 1234) is None
        stream = forward.stream()
        stream.write(struct.pack('<6I', 1, 2, 3, 4, 1 << 26, 6))
        assert wait(lambda: forward.number('underruns') > 0)
        stream.finish()
        write_file(forward.head + 'calibrate', 'x')
        assert wait(lambda: forward.number('commands') == 1)
        return forward

    def state(self, forward):
        return [forward.iio] + [forward.get(name) for name in self.STAYS] + \
            [forward.number(name) for name in COUNTERS]

    def positions(self, forward):
        return {forward.get('out_angl%d_label' % i): forward.number('out_angl%d_raw' % i)
                for i in range(forward.axes)}

    def test_what_stays(self):
        """Including the number of the device."""
        forward = self.used()
        state, top = self.state(forward), (1 << 26) - 1
        assert self.positions(forward) == {'x': 4, 'y': top, 'z': 6}
        for words, positions in (('z - x sync', {'x': 4, 'z': 6}),
                                 ('x y u w', {'x': 4, 'y': top, 'u': 1 << 25, 'w': 1 << 25}),
                                 ('sync x y gate', {'x': 4, 'y': top}),
                                 ('sync x y z', {'x': 4, 'y': top, 'z': 6})):
            assert self.map(forward, words) is None, words
            assert self.state(forward) == state, words
            assert self.positions(forward) == positions, words
        stream = forward.stream()
        stream.write(struct.pack('<3I', 7, 8, 9))
        stream.finish()
        assert self.positions(forward) == {'x': 7, 'y': 8, 'z': 9}
        assert forward.number('underruns') >= int(state[3])
        assert forward.number('scans') > state[4]

    def test_open_node(self):
        """The old device keeps its number while a program has it open."""
        forward = self.used()
        state, stream = self.state(forward), forward.open()
        assert self.map(forward, 'sync x z -') is None
        assert self.state(forward)[1:] == state[1:]
        assert error_name(stream.write, bytes(8)) == 'ENODEV'
        stream.close()
        assert self.map(forward, 'sync x y z') is None
        assert self.map(forward, 'sync x z y') is None
        assert self.state(forward)[1:] == state[1:]

    def test_not_while_a_stream_runs(self):
        """The stream continues."""
        forward = self.used()
        stream = forward.stream()
        assert self.map(forward, 'sync x z -') == 'EBUSY'
        assert read_file(forward.spi + 'line_map') == 'sync x y z\n'
        stream.write(struct.pack('<3I', 7, 8, 9))
        stream.finish()
        assert self.positions(forward) == {'x': 7, 'y': 8, 'z': 9}


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
