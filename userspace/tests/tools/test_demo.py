# SPDX-License-Identifier: GPL-2.0-only
"""The examples that README.md names, as a reader would run them: a path is streamed to a virtual
head, and what it has received is drawn.
"""

import glob
import os
import subprocess
import pytest
from case import Case

import head_rig
import kernel
from kernel import read_file, write_file

FOLDER = os.path.dirname(os.environ.get('XY3_MODULE', ''))
EXAMPLES = os.path.realpath(os.path.join(head_rig.HERE, '..', '..', 'examples'))
DEBUGFS = '/sys/kernel/debug/xy3-sim/0/'


def example(name, *arguments, text=None):
    """-> what it prints"""
    return subprocess.run(['/usr/bin/python3', '-B', '%s/%s.py' % (EXAMPLES, name), *arguments],
                          input=text, stdout=subprocess.PIPE, text=True, check=True,
                          encoding='utf-8', timeout=120).stdout


class TestExamples(Case):
    def head(self, parameters):
        kernel.load_module(FOLDER + '/sim/xy3-sim.ko', parameters)
        self.add_cleanup(kernel.unload_module, 'xy3_sim')

    def check(self, top, axes):
        """The head receives what was to be streamed, and nothing else."""
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
        for row in drawn[1:-1]:                                 # as far to the left as to the right
            assert abs(row[0] + row[-1]-39) < 1
        assert (drawn[9][0], drawn[9][-1]) == (2, 37)

    def test_long_frames_and_two_axes(self):
        self.head('lines=2')
        write_file('/sys/bus/iio/devices/iio:device0/frame_bits', '32')
        self.check((1 << 26) - 1, 2)

    def test_gate(self):
        """Letters, of which the jumps between strokes do not show"""
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
        want.append([*want[-1][:2], 0])         # the gate falls behind the last
        got = [list(map(int, line.split())) for line in read_file(DEBUGFS + 'record').splitlines()]
        assert got == want
        assert 'high 0\n' in read_file(DEBUGFS + 'gate')
        strokes = {self.letter(x, y, top) for x, y, gate in want if gate}
        jumps = {self.letter(x, y, top) for x, y, gate in want if not gate}
        assert len(jumps - strokes) > 20
        assert self.shown('draw') == strokes
        assert self.shown('draw', '--all') == strokes | jumps

    @staticmethod
    def letter(x, y, top):
        """-> row and column of the printed picture"""
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

    def test_no_head(self):
        with pytest.raises(subprocess.CalledProcessError):
            example('stream', text='0 0\n')


def setup_module():
    head_rig.load()
    kernel.load_module(FOLDER + '/spi/xy3-spi.ko')


def teardown_module():
    kernel.unload_module('xy3_spi')
    head_rig.unload()
