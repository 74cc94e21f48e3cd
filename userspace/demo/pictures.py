#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""pictures.py FOLDER: draw the pictures of the first page, pendant.png and scanhead.png.

pendant.png is the LCD that README.md shows as text, dot by dot. scanhead.png shows the letters of
figure.py, drawn by a head with the gate. Tests compare both with the virtual devices.
"""

import os
import re
import sys

TOP = os.path.join(os.path.dirname(os.path.realpath(__file__)), '..', '..')
sys.dont_write_bytecode = True
sys.path.insert(0, TOP + '/userspace/examples')

import draw  # noqa: E402 (needs the path)
import figure  # noqa: E402

# Letters of 5 x 7 dots: a row is two hexadecimal digits, the leftmost dot its highest of 5 bits
FONT = {letter: bytes.fromhex(rows) for letter, rows in {
    ' ': '00000000000000', '-': '0000001F000000', '.': '00000000000C0C', '+': '0004041F040400',
    '%': '18190204081303', '>': '10080402040810', '0': '0E11131519110E', '1': '040C040404040E',
    '2': '0E11010204081F', '3': '1F02040201110E', '4': '02060A121F0202', '5': '1F101E0101110E',
    '6': '0608101E11110E', '7': '1F010204080808', '8': '0E11110E11110E', '9': '0E11110F01020C',
    'A': '0E1111111F1111', 'B': '1E11111E11111E', 'C': '0E11101010110E', 'D': '1C12111111121C',
    'E': '1F10101E10101F', 'F': '1F10101E101010', 'H': '1111111F111111', 'I': '0E04040404040E',
    'K': '11121418141211', 'M': '111B1515111111', 'N': '11111915131111', 'O': '0E11111111110E',
    'R': '1E11111E141211', 'S': '0F10100E01011E', 'U': '1111111111110E', 'W': '1111111515150A',
    'X': '11110A040A1111', 'Y': '1111110A040404', 'Z': '1F01020408101F', 'c': '00000E1010110E',
    'i': '04000C0404040E', 'n': '00001619111111', 'o': '00000E1111110E', 'x': '0000110A040A11',
}.items()}

DOT = 3                                     # pixels, the last of which is a gap
MARGIN = 8                                  # dots around the LCD
PAPER, OFF, ON, BEZEL = range(4)            # of the palette
PALETTE = bytes.fromhex('B4C864 AABE5A 1E2814 282828')


def lcd_lines():
    """The rows of the first page's LCD, without the frame around them"""
    with open(TOP + '/README.md', encoding='utf-8') as file:
        box = re.search(r'^\+- HB04 .*?\n(.*?)^\+-', file.read(), re.DOTALL | re.MULTILINE).group(1)
    return [line[2:42] for line in box.splitlines()]


def lcd(lines):
    """-> rows of dots"""
    width = 6 * len(lines[0]) - 1
    rows = [[BEZEL] * (width + 2 * MARGIN) for _ in range(9 * len(lines) - 2 + 2 * MARGIN)]
    for line, text in enumerate(lines):
        for column, letter in enumerate(text):
            for y, bits in enumerate(FONT[letter]):
                for x in range(5):
                    rows[MARGIN + 9 * line + y][MARGIN + 6 * column + x] = \
                        ON if bits >> (4 - x) & 1 else OFF
    for row in rows[4:-4]:                  # the glass between and around the letters
        row[4:-4] = [PAPER if dot == BEZEL else dot for dot in row[4:-4]]
    return rows


def as_png(rows):
    pixels = b''
    for row in rows:
        line = b''.join(bytes([dot] * (DOT - 1) + [dot if dot == BEZEL else PAPER]) for dot in row)
        gap = bytes(dot if dot == BEZEL else PAPER for dot in line)
        pixels += (b'\0' + line) * (DOT - 1) + b'\0' + gap
    return draw.png(len(rows[0]) * DOT, len(rows) * DOT, pixels, PALETTE)


def letters():
    """The positions with a high gate, in the format of draw.py"""
    return [((x + 1) / 2, (y + 1) / 2) for x, y, gate in figure.letters() if gate]


def main():
    folder, = sys.argv[1:]
    for name, picture in (('pendant', as_png(lcd(lcd_lines()))),
                          ('scanhead', draw.as_png(letters()))):
        with open('%s/%s.png' % (folder, name), 'wb') as file:
            file.write(picture)


if __name__ == '__main__':
    main()
