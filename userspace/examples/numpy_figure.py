#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""numpy_figure.py [-r RATE] [DEVICE]: stream a figure from a numpy array to a scanhead.

Requires python3-numpy. The array has a row per scan and a column per axis, X first, from -1 to 1:
replace rose() by a figure of yours. Opening and streaming is that of stream.py.
"""

import argparse

import numpy
import stream

PETALS = 5
SCANS = 2000


def rose(count=SCANS):
    """A flower: the distance from the middle follows a cosine of the angle."""
    angle = numpy.linspace(0, 2 * numpy.pi, count)
    radius = 0.9 * numpy.cos(PETALS * angle)
    return numpy.column_stack((radius * numpy.cos(angle), radius * numpy.sin(angle)))


def codes(head, places):
    """Rows of what a head takes: a number of 32 bits for each axis, and for the gate"""
    if numpy.isnan(places).any() or numpy.abs(places).max() > 1:
        raise ValueError('a place that is not from -1 to 1')
    scans = numpy.zeros((len(places), head.axes), float)    # axes without a column: the middle
    columns = min(places.shape[1], head.axes)
    scans[:, :columns] = places[:, :columns]
    scans = numpy.rint((scans + 1) / 2 * head.highest).astype('<u4')
    if head.gate:                                           # high, and low for the last scan
        gate = numpy.ones((len(scans), 1), '<u4')
        gate[-1] = 0
        scans = numpy.hstack((scans, gate))
    return scans


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('-r', '--rate', type=int, help='frames per second')
    parser.add_argument('device', nargs='?', metavar='DEVICE')
    options = parser.parse_args()
    head = stream.Scanhead(options.device or stream.find())
    if options.rate:
        head.set('sampling_frequency', options.rate)
    scans = codes(head, rose())
    before = head.get('underruns')
    head.stream(memoryview(scans.tobytes()))
    print('%d scans sent, %d underruns' % (len(scans), head.get('underruns') - before))


if __name__ == '__main__':
    main()
