#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""figure.py FIGURE...: print paths for a scanhead, one position per line: X and Y, from -1 to 1.

The square is in the circle, and the grid in the square. Each begins and ends at the same corner, so
that one can follow another without a jump of the mirrors. The letters have jumps: behind X and Y is
1 for the laser's gate, or 0 on the way from one stroke to the next.
"""

import argparse
import math
import signal

RADIUS = 0.9
CORNER = RADIUS * math.sqrt(0.5)
GRID_LINES = 5                      # an odd number: then the path ends where it began
SPEED = 0.002                       # from one position to the next
JUMP = 0.01                         # the same with the gate low
STROKES = (((-0.85, 0.6), (-0.35, -0.6)), ((-0.85, -0.6), (-0.35, 0.6)),            # X
           ((-0.2, 0.6), (0.05, 0.0)), ((0.3, 0.6), (0.05, 0.0), (0.05, -0.6)),     # Y
           ((0.45, 0.6), (0.85, 0.6), (0.6, 0.1), (0.85, -0.1), (0.85, -0.5), (0.45, -0.6)))


def line(start, end, speed=SPEED):
    """Positions from start to end, without start."""
    count = math.ceil(math.dist(start, end) / speed)
    for i in range(1, count + 1):
        yield tuple(a + (b - a) * i / count for a, b in zip(start, end))


def polygon(*corners):
    yield corners[0]
    for start, end in zip(corners, corners[1:]):
        yield from line(start, end)


def circle():
    count = math.ceil(2 * math.pi * RADIUS / SPEED)
    for i in range(count + 1):
        angle = math.pi / 4 + 2 * math.pi * i / count
        yield RADIUS * math.cos(angle), RADIUS * math.sin(angle)


def square():
    return polygon((CORNER, CORNER), (-CORNER, CORNER), (-CORNER, -CORNER), (CORNER, -CORNER),
                   (CORNER, CORNER))


def grid():
    """Along all rows, to and fro, then along all columns."""
    places = [CORNER - 2 * CORNER * i / (GRID_LINES - 1) for i in range(GRID_LINES)]
    corners = []
    for i, place in enumerate(places):
        side = CORNER if i % 2 == 0 else -CORNER
        corners += [(side, place), (-side, place)]
    for i, place in enumerate(reversed(places)):
        side = CORNER if i % 2 else -CORNER
        corners += [(place, side), (place, -side)]
    return polygon(*corners)


def letters():
    """With the gate"""
    place = STROKES[0][0]
    for start, *corners in STROKES:
        for x, y in line(place, start, JUMP):
            yield x, y, 0
        place = start
        for corner in corners:
            for x, y in line(place, corner):
                yield x, y, 1
            place = corner


FIGURES = {'circle': circle, 'square': square, 'grid': grid, 'letters': letters}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('figures', nargs='+', choices=FIGURES, metavar='FIGURE',
                        help=', '.join(FIGURES))
    names = parser.parse_args().figures
    low = [0] * ('letters' in names)        # all lines have as many numbers
    for name in names:
        for x, y, *gate in FIGURES[name]():
            print('%.6f %.6f' % (x, y), *(gate or low))


if __name__ == '__main__':
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)       # for `figure.py circle | head'
    main()
