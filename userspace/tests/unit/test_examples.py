# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of the examples for scanheads: a known path, and the picture of a known record."""

import contextlib
import io
import math
import os
import struct
import subprocess
import sys
import tempfile
from unittest import mock

import png
import pytest
from case import Case

EXAMPLES = os.path.realpath(os.path.join(os.path.dirname(os.path.realpath(__file__)),
                                         '..', '..', 'examples'))
sys.path.insert(0, EXAMPLES)

import draw  # noqa: E402 (needs the path)
import figure  # noqa: E402
import stream  # noqa: E402

TOP20, TOP26 = (1 << 20) - 1, (1 << 26) - 1
NONE = 0xFFFFFFFF


class TestFigures(Case):
    def lines(self, *names):
        out = io.StringIO()
        with contextlib.redirect_stdout(out), mock.patch('sys.argv', ['figure.py', *names]):
            figure.main()
        return [tuple(map(float, line.split())) for line in out.getvalue().splitlines()]

    def test_one_follows_another_without_a_jump(self):
        path = self.lines('circle', 'square', 'grid', 'circle')
        assert max(map(math.dist, path, path[1:])) < 0.0021
        assert path[0] == path[-1]

    def test_circle(self):
        path = self.lines('circle')
        for point in path:
            assert round(abs(math.hypot(*point)-0.9), 4) == 0
        assert {(x > 0, y > 0) for x, y in path} == \
                         {(True, True), (False, True), (False, False), (True, False)}

    def test_square(self):
        for x, y in self.lines('square'):
            assert round(abs(max(abs(x), abs(y))-0.9 / math.sqrt(2)), 4) == 0

    def test_grid(self):
        path = self.lines('grid')
        for axis in 0, 1:       # of places where much is, there are five
            counts = {}
            for point in path:
                counts[point[axis]] = counts.get(point[axis], 0) + 1
            assert sum(count > 500 for count in counts.values()) == 5

    def test_a_gate_for_all(self):
        """Only letters have a gate; with other figures it is low."""
        assert {len(point) for point in self.lines('circle', 'square')} == {2}
        path = self.lines('circle', 'letters')
        assert {len(point) for point in path} == {3}
        assert not any(point[2] for point in path[:len(self.lines('circle'))])

    def test_letters(self):
        """The gate is only high on strokes, and no stroke contains a jump."""
        path = self.lines('letters')
        for a, b in zip(path, path[1:]):
            assert math.dist(a[:2], b[:2]) < (0.0021 if b[2] else 0.0101)
        strokes = sum(a[2] < b[2] for a, b in zip(path, path[1:])) + int(path[0][2])
        assert strokes == len(figure.STROKES)

    def test_reader_that_leaves(self):
        done = subprocess.run(['sh', '-c', '"$@" | head -n 1', 'sh', sys.executable, '-B',
                               EXAMPLES + '/figure.py', 'grid', 'grid'],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=True)
        assert (done.stdout.count(b'\n'), done.stderr) == (1, b'')

    def test_no_such_figure(self):
        with contextlib.redirect_stderr(io.StringIO()) as err, pytest.raises(SystemExit):
            self.lines('hexagon')
        assert 'hexagon' in err.getvalue()


class Folder(Case):
    """A folder with the files of a head of xy3-sim."""

    def set_up(self):
        folder = tempfile.TemporaryDirectory()
        self.add_cleanup(folder.cleanup)
        self.folder = folder.name

    def put(self, name, text):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, 'wb') as file:
            file.write(text.encode() if isinstance(text, str) else text)

    def record(self, axes, bits, *scans):
        self.put('positions', ''.join('%s 0 %d\n' % (axis, bits) for axis in axes))
        self.put('record.bin', b''.join(struct.pack('=%dI' % len(axes), *scan)
                                        for scan in scans))

    def picture(self):
        return draw.as_text(draw.read(self.folder)).splitlines()


class TestPictures(Folder):
    BLANK = ['│' + '\u2800' * 40 + '│'] * 20

    def test_corners(self):
        self.record('xyz', 20, (0, 0, 1), (TOP20, 0, 2), (0, TOP20, 3), (TOP20, TOP20, 4))
        lines = self.picture()
        assert lines[0] == '┌' + '─' * 40 + '┐'
        assert lines[-1] == '└' + '─' * 40 + '┘'
        assert lines[1] == '│⠁' + '\u2800' * 38 + '⠈│'
        assert lines[-2] == '│⡀' + '\u2800' * 38 + '⢀│'
        assert lines[2:-2] == self.BLANK[2:]

    def test_up_is_up_and_right_is_right(self):
        self.record('xyz', 26, *((TOP26 * 3 // 4, y * TOP26 // 79, 0) for y in range(40, 80)))
        lines = [line[1:-1] for line in self.picture()[1:-1]]
        assert [line.strip('\u2800') for line in lines] == ['⢸'] * 10 + [''] * 10
        assert {line.index('⢸') for line in lines[:10]} == {29}

    def test_axes_in_another_order(self):
        self.record('yx', 20, (TOP20, 0))
        assert self.picture()[1][1] == '⠁'

    def test_one_axis(self):
        self.record('x', 20, (0,), (TOP20,))
        lines = [line for line in self.picture() if line not in self.BLANK]
        assert lines[1] == '│⡀' + '\u2800' * 38 + '⢀│'
        assert len(lines) == 3

    def test_scans_without_a_code(self):
        self.record('xy', 20, (NONE, 0), (0, NONE))
        assert self.picture()[1:-1] == self.BLANK
        done = subprocess.run([sys.executable, '-B', EXAMPLES + '/draw.py', self.folder],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
        assert (done.returncode, done.stdout) == (1, b'')
        assert b'nothing' in done.stderr

    def test_what_the_gate_hides(self):
        self.put('positions', 'x 0 20\ny 0 20\n')
        self.put('record.bin', struct.pack('=9I', 0, TOP20, 1, TOP20, TOP20, 0, 0, 0, 0))
        self.put('signals', 'sync x y gate\n')
        assert self.picture()[1:-1] == ['│⠁' + '\u2800' * 39 + '│'] + self.BLANK[1:]
        assert draw.read(self.folder, hide=False) == [(0, 1), (1, 1), (0, 0)]

    def test_printed_in_any_locale(self):
        self.record('xy', 20, (0, 0))
        plain = {'LC_ALL': 'POSIX', 'PYTHONUTF8': '0', 'PYTHONCOERCECLOCALE': '0'}
        done = subprocess.run([sys.executable, '-B', EXAMPLES + '/draw.py', self.folder],
                              stdout=subprocess.PIPE, check=True, env=plain)
        assert done.stdout.decode().splitlines() == self.picture()

    def pixels(self):
        path = os.path.join(self.folder, 'picture.png')
        subprocess.run([sys.executable, '-B', EXAMPLES + '/draw.py', '-o', path, self.folder],
                       check=True)
        rows = png.read(path)
        assert (len(rows), len(rows[0])) == (512, 512)
        return rows

    def test_png(self):
        self.record('xyz', 20, *((x * TOP20 // 511, TOP20 * 3 // 4, 0) for x in range(512)))
        rows = self.pixels()
        bright = {number for number, row in enumerate(rows) if row[256][1] > 100}
        assert bright <= set(range(126, 131)) and 128 in bright, bright
        assert len({bytes(pixel) for pixel in rows[128][3:-3]}) == 1
        assert {bytes(pixel) for pixel in rows[300]} == {b'\0\0\0'}


class TestStreams(Folder):
    """The files of an IIO device."""

    def set_up(self):
        super().set_up()
        patch = mock.patch.object(stream, 'DEVICES', self.folder)
        patch.start()
        self.add_cleanup(patch.stop)

    def device(self, name='iio:device0', bits=24, axes=3):
        self.put(name + '/name', 'xy3-100\n')
        self.put(name + '/frame_bits', '%d\n' % bits)
        for axis in range(axes):
            self.put(name + '/out_angl%d_raw' % axis, '0\n')

    def test_codes(self):
        for bits, top in ((24, TOP20), (32, TOP26)):
            self.device(bits=bits)
            head = stream.Scanhead('iio:device0')
            assert head.scan([-1.0, 0.0, 1.0]) == \
                             struct.pack('<3I', 0, round(top / 2), top)

    def test_gate(self):
        self.device(axes=2)
        self.put('iio:device0/out_voltage0_label', 'gate\n')
        head = stream.Scanhead('iio:device0')
        for position, gate in (([-1.0, 1.0, 1.0], 1), ([-1.0, 1.0, 0.0], 0), ([-1.0, 1.0], 0)):
            assert head.scan(position) == struct.pack('<3I', 0, TOP20, gate)

    def test_out_of_range(self):
        """Values out of range are refused with their line number, and nothing is sent."""
        self.device(axes=2)
        self.put('iio:device0/out_voltage0_label', 'gate\n')
        head = stream.Scanhead('iio:device0')
        for wrong in ('2 2', '0 -1.01', 'nan 0', 'inf 0', '0 0 2', '0 0 -1', '0,5 0,5', 'x', '0,,0',
                      '0 0 0 1'):
            with pytest.raises(SystemExit, match='line 1: '):
                list(stream.scans_of(head, [wrong + '\n']))

    def test_lines(self):
        """Empty lines and comments are no scans; numbers may have commas between them."""
        self.device(axes=2)
        head = stream.Scanhead('iio:device0')
        lines = ['# x, y\n', '1 -1\n', '\n', ' \t\n', '1, -1   # a corner\n', '1,-1']
        assert list(stream.scans_of(head, lines)) == [struct.pack('<2I', TOP20, 0)] * 3

    def test_another_number_of_columns(self):
        self.device(axes=3)
        head = stream.Scanhead('iio:device0')
        for first, second in (('0 0', '0 0 0'), ('0 0 0', '0 0'), ('0 0', '0')):
            with pytest.raises(SystemExit, match='line 3: [123] numbers, where the lines before'):
                list(stream.scans_of(head, [first, '', second]))

    def test_axes_that_are_not_there(self):
        self.device(axes=2)
        head = stream.Scanhead('iio:device0')
        middle = struct.pack('<I', round(TOP20 / 2))
        assert head.scan([1.0]) == struct.pack('<I', TOP20) + middle
        assert head.scan([0.0, 0.0, 1.0]) == middle * 2

    def test_finds_the_scanhead(self):
        self.put('iio:device0/name', 'thermometer\n')
        self.device('iio:device1')
        assert stream.find() == 'iio:device1'

    def test_no_scanhead(self):
        with pytest.raises(SystemExit, match='no scanhead'):
            stream.find()
