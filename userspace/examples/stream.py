#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""stream.py [-r RATE] [DEVICE]: stream positions to a scanhead, by its IIO buffer.

Standard input has one position per line: for each axis a number from -1 to 1, X first, with blanks
or commas between them; all lines have as many. Axes that the lines leave out are in the middle. If
the head has a gate, a number after those of all axes is 1 or 0 for it, by default 0; it is not an
interlock. Empty lines, and comments from # on, are ignored. DEVICE is iio:device<n>, by default the
first scanhead.
"""

import argparse
import glob
import os
import struct
import sys

DEVICES = '/sys/bus/iio/devices'
CODE_BITS = {24: 20, 32: 26}        # by bits of a frame


class Scanhead:
    def __init__(self, device):
        self.folder = os.path.join(DEVICES, device)
        self.node = os.path.join('/dev', device)
        self.axes = len(glob.glob(self.folder + '/out_angl*_raw'))
        self.gate = os.path.exists(self.folder + '/out_voltage0_label')
        self.highest = (1 << CODE_BITS[self.get('frame_bits')]) - 1

    def get(self, name):
        with open(os.path.join(self.folder, name), encoding='ascii') as file:
            return int(file.read())

    def set(self, name, value):
        with open(os.path.join(self.folder, name), 'w', encoding='ascii') as file:
            file.write(str(value))

    def scan(self, position):
        """Bytes: a number of 32 bits for each axis, and for the gate."""
        gate = [int(word) for word in position[self.axes:]][:self.gate]
        places = (position + [0.0] * self.axes)[:self.axes]
        if not all(-1 <= place <= 1 for place in places) or not set(gate) <= {0, 1}:
            raise ValueError('a place that is not from -1 to 1, or a gate that is not 0 or 1')
        codes = [round((place + 1) / 2 * self.highest) for place in places]
        codes += (gate + [0])[:self.gate]
        return struct.pack('<%dI' % len(codes), *codes)

    def stream(self, data):
        for axis in range(self.axes):
            self.set('scan_elements/out_angl%d_en' % axis, 1)
        if self.gate:
            self.set('scan_elements/out_voltage0_en', 1)
        self.set('buffer/length', 4096)
        self.set('buffer/enable', 1)
        try:
            with open(self.node, 'wb', buffering=0) as node:
                while data:
                    data = data[node.write(data):]
        finally:
            self.set('buffer/enable', 0)    # returns when the last scan has been sent


def find():
    """The first scanhead's name."""
    for path in sorted(glob.glob(DEVICES + '/iio:device*/name')):
        with open(path, encoding='ascii') as file:
            if file.read() == 'xy3-100\n':
                return path.split('/')[-2]
    sys.exit('stream.py: no scanhead: is xy3-spi loaded, and bound to an SPI device?')


def scans_of(head, lines):
    """Their bytes; what is wrong in a line ends the program before anything is sent."""
    columns = None
    for number, line in enumerate(lines, 1):
        text = line.partition('#')[0]
        if not text.strip():
            continue
        words = text.split(',' if ',' in text else None)
        columns = columns or len(words)
        try:
            if len(words) != columns:
                raise ValueError('%d numbers, where the lines before have %d' %
                                 (len(words), columns))
            if columns > head.axes + 1:
                raise ValueError('%d numbers, for %d axes and a gate' % (columns, head.axes))
            yield head.scan([float(word) for word in words])
        except ValueError as error:
            sys.exit('stream.py: line %d: %s' % (number, error))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('-r', '--rate', type=int, help='frames per second')
    parser.add_argument('device', nargs='?', metavar='DEVICE')
    options = parser.parse_args()
    head = Scanhead(options.device or find())
    if options.rate:
        head.set('sampling_frequency', options.rate)
    scans = list(scans_of(head, sys.stdin))
    before = head.get('underruns')
    head.stream(memoryview(b''.join(scans)))
    print('%d scans sent, %d underruns' % (len(scans), head.get('underruns') - before))


if __name__ == '__main__':
    main()
