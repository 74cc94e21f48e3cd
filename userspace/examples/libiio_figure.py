#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""libiio_figure.py [-u URI] [-r RATE]: stream a circle to a scanhead by libiio, or over a network.

Requires python3-libiio. URI is that of a libiio context, such as ip:raspberrypi.local for a machine
that runs iiod; the default is this machine.
"""

import argparse
import math
import struct
import sys

import iio

CODE_BITS = {24: 20, 32: 26}        # by bits of a frame
SCANS = 2000


def positions(count=SCANS):
    """X and Y, from -1 to 1"""
    for i in range(count):
        angle = 2 * math.pi * i / (count - 1)
        yield 0.9 * math.cos(angle), 0.9 * math.sin(angle)


def find(context):
    for device in context.devices:
        if device.name == 'xy3-100':
            return device
    sys.exit('libiio_figure.py: no scanhead: is xy3-spi loaded, and bound to an SPI device?')


def circle(device):
    """-> bytes: a number of 32 bits for X and for Y"""
    highest = (1 << CODE_BITS[int(device.attrs['frame_bits'].value)]) - 1
    return b''.join(struct.pack('<2I', *(round((place + 1) / 2 * highest) for place in position))
                    for position in positions())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('-u', '--uri', default='local:', help='of a libiio context')
    parser.add_argument('-r', '--rate', type=int, help='frames per second')
    options = parser.parse_args()
    device = find(iio.Context(options.uri))
    if options.rate:
        device.attrs['sampling_frequency'].value = str(options.rate)
    for channel in device.channels:     # those that are left out keep their position
        channel.enabled = channel.id in ('angl0', 'angl1')
    data = circle(device)
    buffer = iio.Buffer(device, SCANS)
    buffer.write(bytearray(data))
    buffer.push()
    del buffer                          # disables it, once the last scan has been sent
    print('%d scans sent, %s underruns since the driver was loaded' %
          (SCANS, device.attrs['underruns'].value))


if __name__ == '__main__':
    main()
