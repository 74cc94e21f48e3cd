#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""draw.py [-a] [-o PNG] [FOLDER]: draw what a virtual scanhead has received.

FOLDER has the files record.bin, positions and signals of xy3-sim; without it, it is that of the
first head. The picture is printed, or goes to a file PNG. X is to the right, Y up. With a gate
among the signals only scans with the gate high are drawn; with -a all are.
"""

import argparse
import array
import math
import os
import struct
import sys
import zlib

FOLDER = '/sys/kernel/debug/xy3-sim/0'
NO_CODE = 0xFFFFFFFF                # of an axis that has received nothing

COLUMNS, ROWS = 40, 20              # letters of the printed picture
BRAILLE = 0x2800                    # a letter is 2 dots wide and 4 high; their bits:
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))

PIXELS = 512                        # of the PNG's sides
SPOT = 2                            # radius of the laser's spot in pixels
COLOUR = (80, 255, 140)


def has_gate(folder):
    try:
        with open(os.path.join(folder, 'signals'), encoding='ascii') as file:
            return 'gate' in file.read().split()
    except FileNotFoundError:
        return False


def read(folder, hide=True):
    """-> [(x, y), ...], each from 0 to 1"""
    with open(os.path.join(folder, 'positions'), encoding='ascii') as file:
        axes = [line.split() for line in file]
    with open(os.path.join(folder, 'record.bin'), 'rb') as file:
        codes = array.array('I', file.read())
    names = [axis[0] for axis in axes]
    places, gate = [], has_gate(folder)
    for name in 'xy':
        if name in names:
            at = names.index(name)
            places.append([None if code == NO_CODE else code / ((1 << int(axes[at][2])) - 1)
                           for code in codes[at::len(axes) + gate]])
    if len(places) == 1:            # a head with one axis draws a line
        places.append([0.5] * len(places[0]))
    high = [1] * len(places[0])
    if gate and hide:               # it is behind the codes of a scan
        high = codes[len(axes)::len(axes) + 1]
    return [place for place, shown in zip(zip(*places), high) if shown and None not in place]


def as_text(places):
    cells = [[0] * COLUMNS for _ in range(ROWS)]
    width, height = 2 * COLUMNS - 1, 4 * ROWS - 1
    for x, y in places:
        column, row = round(x * width), height - round(y * height)
        cells[row // 4][column // 2] |= DOTS[row % 4][column % 2]
    lines = ['│' + ''.join(chr(BRAILLE + cell) for cell in row) + '│' for row in cells]
    return '\n'.join(['┌' + '─' * COLUMNS + '┐', *lines, '└' + '─' * COLUMNS + '┘'])


def shine(places):
    """Light on each pixel: a scan is a spot, bright in the middle."""
    light = [[0.0] * PIXELS for _ in range(PIXELS)]
    for x, y in places:
        column, row = x * (PIXELS - 1), (1 - y) * (PIXELS - 1)
        for i in range(max(round(row) - SPOT, 0), min(round(row) + SPOT + 1, PIXELS)):
            for j in range(max(round(column) - SPOT, 0), min(round(column) + SPOT + 1, PIXELS)):
                light[i][j] += math.exp(-(i - row) ** 2 - (j - column) ** 2)
    return light


def chunk(kind, data):
    """A part of a PNG file."""
    return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))


def png(width, height, pixels, palette=b''):
    """pixels: for each row a 0, then a byte per pixel that counts colours of the palette, or RGB"""
    header = struct.pack('>IIBBBBB', width, height, 8, 3 if palette else 2, 0, 0, 0)
    colours = chunk(b'PLTE', palette) if palette else b''
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', header) + colours +
            chunk(b'IDAT', zlib.compress(pixels, 9)) + chunk(b'IEND', b''))


def as_png(places):
    rows = []
    for row in shine(places):
        rows.append(b'\0' + bytes(round(part * (1 - math.exp(-light)))
                                  for light in row for part in COLOUR))
    return png(PIXELS, PIXELS, b''.join(rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('-a', '--all', action='store_true', help='also what the gate hides')
    parser.add_argument('-o', '--output', metavar='PNG', help='a file for the picture')
    parser.add_argument('folder', nargs='?', default=FOLDER, metavar='FOLDER')
    options = parser.parse_args()
    places = read(options.folder, not options.all)
    if not places:
        sys.exit('draw.py: nothing was recorded')
    if options.output:
        with open(options.output, 'wb') as file:
            file.write(as_png(places))
    else:
        sys.stdout.reconfigure(encoding='utf-8')
        print(as_text(places))


if __name__ == '__main__':
    main()
