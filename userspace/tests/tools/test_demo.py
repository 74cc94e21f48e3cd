# SPDX-License-Identifier: GPL-2.0-only
"""The examples for scanheads, as documented: a path is streamed to a virtual head, and the received
data are drawn.
"""

import glob
import math
import os
import subprocess
import sys

import numpy
import pytest
from case import Case

import head_rig
import kernel
from kernel import read_file, write_file

FOLDER = os.path.dirname(os.environ.get('XY3_MODULE', ''))
EXAMPLES = os.path.realpath(os.path.join(head_rig.HERE, '..', '..', 'examples'))
DEBUGFS = '/sys/kernel/debug/xy3-sim/0/'
sys.path[:0] = [EXAMPLES, os.path.join(EXAMPLES, '..', 'demo')]

import draw  # noqa: E402 (needs the path)
import numpy_figure  # noqa: E402
import pictures  # noqa: E402
import stream  # noqa: E402


def example(name, *arguments, text=None):
    """-> the output"""
    return subprocess.run(['/usr/bin/python3', '-B', '%s/%s.py' % (EXAMPLES, name), *arguments],
                          input=text, stdout=subprocess.PIPE, text=True, check=True,
                          encoding='utf-8', timeout=120).stdout


class TestExamples(Case):
    def head(self, parameters):
        kernel.load_module(FOLDER + '/sim/xy3-sim.ko', parameters)
        self.add_cleanup(kernel.unload_module, 'xy3_sim')

    def check(self, top, axes):
        """The head receives exactly the streamed scans."""
        path = example('figure', 'circle')
        write_file(DEBUGFS + 'record', '10000 changes')
        assert '%d scans sent' % len(path.splitlines()) in example('stream', text=path)
        want = [[round((float(place) + 1) / 2 * top) for place in line.split()] +
                [round(top / 2)] * (axes - 2) for line in path.splitlines()]
        got = [list(map(int, line.split())) for line in read_file(DEBUGFS + 'record').splitlines()]
        assert got == want

    def test_circle(self):
        self.head('lines=4 framing=line')
        self.check((1 << 20) - 1, 3)
        rows = [line[1:-1] for line in example('draw').splitlines()[1:-1]]
        drawn = [[at for at, letter in enumerate(row) if letter != '\u2800'] for row in rows]
        assert len(drawn) == 20
        assert (drawn[0], drawn[-1]) == ([], [])       # its radius is 0.9
        for row in drawn[1:-1]:                                 # symmetric
            assert abs(row[0] + row[-1]-39) < 1
        assert (drawn[9][0], drawn[9][-1]) == (2, 37)

    def test_long_frames_and_two_axes(self):
        self.head('lines=2')
        write_file('/sys/bus/iio/devices/iio:device0/frame_bits', '32')
        self.check((1 << 26) - 1, 2)

    def test_gate(self):
        """Letters, without the jumps between strokes"""
        self.head('lines=4 framing=line')
        write_file(DEBUGFS + 'signals', 'sync x y gate')
        spi, = glob.glob('/sys/bus/spi/devices/spi*.0')
        write_file(spi + '/line_map', 'sync x y gate')
        path = example('figure', 'letters')
        write_file(DEBUGFS + 'record', '10000 changes')
        assert '%d scans sent' % len(path.splitlines()) in example('stream', text=path)
        top = (1 << 20) - 1
        want = [[round((float(x) + 1) / 2 * top), round((float(y) + 1) / 2 * top), int(gate)]
                for x, y, gate in map(str.split, path.splitlines())]
        want.append([*want[-1][:2], 0])         # the gate falls after the last one
        got = [list(map(int, line.split())) for line in read_file(DEBUGFS + 'record').splitlines()]
        assert got == want
        assert 'high 0\n' in read_file(DEBUGFS + 'gate')
        strokes = {self.letter(x, y, top) for x, y, gate in want if gate}
        jumps = {self.letter(x, y, top) for x, y, gate in want if not gate}
        assert len(jumps - strokes) > 20
        assert self.shown('draw') == strokes
        assert self.shown('draw', '--all') == strokes | jumps
        # the picture in README.md is of these, except for rounding of the codes
        drawn, shown = draw.read(DEBUGFS), pictures.letters()
        assert len(drawn) == len(shown)
        assert all(math.dist(one, two) < 2 / top for one, two in zip(drawn, shown))

    @staticmethod
    def letter(x, y, top):
        """-> row and column in the printed picture"""
        return (79 - round(y / top * 79)) // 4, round(x / top * 79) // 2

    @staticmethod
    def shown(*words):
        rows = [line[1:-1] for line in example(*words).splitlines()[1:-1]]
        return {(row, column) for row, text in enumerate(rows)
                for column, letter in enumerate(text) if letter != '\u2800'}

    def test_rate(self):
        self.head('lines=4 framing=line')
        example('stream', '--rate', '12345', text='0 0\n')
        assert read_file('/sys/bus/iio/devices/iio:device0/sampling_frequency') == \
                         '12345\n'

    @staticmethod
    def received(name, *arguments):
        """-> [(code, ...), ...] of the stream"""
        write_file(DEBUGFS + 'record', '10000 changes')
        assert '2000 scans sent' in example(name, *arguments)
        rows = read_file(DEBUGFS + 'record').splitlines()
        return [tuple(map(int, row.split())) for row in rows]

    @staticmethod
    def near(got, want, top):
        """Whether these are the codes of positions from -1 to 1, except for rounding"""
        return len(got) == len(want) and all(
            abs(code - (place + 1) / 2 * top) < 1 for codes, places in zip(got, want)
            for code, place in zip(codes, places))

    ROSE = [(0.9 * math.cos(10 * math.pi * i / 1999) * math.cos(2 * math.pi * i / 1999),
             0.9 * math.cos(10 * math.pi * i / 1999) * math.sin(2 * math.pi * i / 1999))
            for i in range(2000)]

    def test_numpy(self):
        self.head('lines=4 framing=line')
        got = self.received('numpy_figure', '--rate', '12345')
        assert self.near(got, [(*place, 0) for place in self.ROSE], (1 << 20) - 1)
        assert read_file('/sys/bus/iio/devices/iio:device0/sampling_frequency') == '12345\n'
        head = stream.Scanhead(stream.find())
        for wrong in 1.001, -1.001, math.nan, math.inf:
            with pytest.raises(ValueError, match='from -1 to 1'):
                numpy_figure.codes(head, numpy.array([[0, 0], [0, wrong]]))

    def test_numpy_with_a_gate_and_long_frames(self):
        self.head('lines=4 framing=line')
        write_file(DEBUGFS + 'signals', 'sync x y gate')
        spi, = glob.glob('/sys/bus/spi/devices/spi*.0')
        write_file(spi + '/line_map', 'sync x y gate')
        write_file('/sys/bus/iio/devices/iio:device0/frame_bits', '32')
        got = self.received('numpy_figure')
        assert self.near(got, self.ROSE, (1 << 26) - 1)
        assert [scan[2] for scan in got] == [1] * 1999 + [0]

    def test_libiio(self):
        """An omitted axis keeps its position."""
        self.head('lines=4 framing=line')
        write_file('/sys/bus/iio/devices/iio:device0/out_angl2_raw', '77')
        got = self.received('libiio_figure', '--rate', '12345')
        angles = [2 * math.pi * i / 1999 for i in range(2000)]
        assert self.near(got, [(0.9 * math.cos(angle), 0.9 * math.sin(angle)) for angle in angles],
                         (1 << 20) - 1)
        assert {scan[2] for scan in got} == {77}
        assert read_file('/sys/bus/iio/devices/iio:device0/sampling_frequency') == '12345\n'

    @pytest.mark.parametrize('name', ('stream', 'numpy_figure', 'libiio_figure'))
    def test_no_head(self, name):
        done = subprocess.run(['/usr/bin/python3', '-B', '%s/%s.py' % (EXAMPLES, name)], text=True,
                              input='0 0\n', stderr=subprocess.PIPE, timeout=120, check=False)
        assert (done.returncode, done.stderr.count('\n')) == (1, 1), done.stderr
        assert 'no scanhead' in done.stderr


def setup_module():
    head_rig.load()
    kernel.load_module(FOLDER + '/spi/xy3-spi.ko')


def teardown_module():
    kernel.unload_module('xy3_spi')
    head_rig.unload()
