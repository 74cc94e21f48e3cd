# SPDX-License-Identifier: GPL-2.0-only
"""The pictures in README.md are those that the script creates."""

import os
import subprocess
import sys

import png
import pytest

TOP = os.path.realpath(os.path.join(os.path.dirname(os.path.realpath(__file__)), '..', '..', '..'))
SCRIPT = TOP + '/userspace/demo/pictures.py'
FOLDER = 'userspace/doc/pictures'
NAMES = ('pendant', 'scanhead')
sys.path.insert(0, os.path.dirname(SCRIPT))

import pictures  # noqa: E402 (needs the path)


@pytest.mark.parametrize('name', NAMES)
def test_as_the_script_makes_it(name, tmp_path):
    """Compares pixels: the compressed data depend on the version of zlib."""
    subprocess.run([sys.executable, '-B', SCRIPT, str(tmp_path)], check=True)
    shown = '%s/%s.png' % (FOLDER, name)
    assert png.read('%s/%s' % (TOP, shown)) == png.read('%s/%s.png' % (tmp_path, name))
    assert os.path.getsize('%s/%s' % (TOP, shown)) < 40000
    with open(TOP + '/README.md', encoding='utf-8') as file:
        assert '](%s)' % shown in file.read()


def test_letters_differ():
    assert len(set(pictures.FONT.values())) == len(pictures.FONT)
    assert {len(rows) for rows in pictures.FONT.values()} == {7}
    assert all(row < 32 for rows in pictures.FONT.values() for row in rows)


def test_lcd_dot_by_dot():
    """A letter is at its position in the text, and upright."""
    rows = pictures.lcd(['  ', ' F'])
    at = [(x, y) for y, row in enumerate(rows) for x, dot in enumerate(row) if dot == pictures.ON]
    left, top = pictures.MARGIN + 6, pictures.MARGIN + 9
    assert at == [(left + x, top + y) for y, width in enumerate((5, 1, 1, 4, 1, 1, 1))
                  for x in range(width)]
    assert pictures.lcd_lines()[2].split() == ['>X', '135.1700', '-220.3340']
    assert {len(line) for line in pictures.lcd_lines()} == {40}
