# SPDX-License-Identifier: GPL-2.0-only
"""What each key does: a table, which an owner may replace."""

import os
import re

HERE = os.path.dirname(os.path.realpath(__file__))
TABLES = {'HB03': 'hb03', 'HB04': 'hb04-18', 'WHB04B': 'whb04b'}    # of a model
LAST = 0x1e
NOTHING = '-'
STOPS = ('stop', 'reset')


def read(path):
    """-> {number: (name, name with Fn)}; ValueError where the file is no table"""
    table = {}
    with open(path, encoding='utf-8') as file:
        for at, line in enumerate(file, 1):
            words = line.partition('#')[0].split()
            if not words:
                continue
            number = int(words[0], 16) if re.fullmatch('[0-9a-f]{2}', words[0]) else 0
            if not 1 <= number <= LAST or number in table or len(words) not in (2, 3) or not all(
                    re.fullmatch('-|[a-z][a-z0-9-]*', word) for word in words[1:]):
                raise ValueError('%s:%d: not a key and what it does' % (path, at))
            table[number] = words[1], words[-1]
    return table


def find(name, folder):
    """The path of a table: in `folder`, or one of ours"""
    path = os.path.join(folder, name)
    return path if os.path.exists(path) else os.path.join(HERE, name)


def shipped():
    """-> {name: table}"""
    return {name[:-5]: read(os.path.join(HERE, name))
            for name in sorted(os.listdir(HERE)) if name.endswith('.keys')}


def names(tables):
    """All that keys do in these tables"""
    return sorted({name for table in tables for row in table.values() for name in row} -
                  {NOTHING})


class Keys:
    """Which are down, by what they do; Fn decides when a key goes down."""

    def __init__(self, table, down=()):
        """A key that is down now does nothing before it has been up, but for those that stop."""
        self.table = table
        self.held = {number: None for number in down        # number: name, or None
                     if self.table.get(number, ('',))[0] not in STOPS}

    def turn(self, down):
        """-> [name] of what has gone down"""
        self.held = {number: name for number, name in self.held.items() if number in down}
        pressed = []
        # Fn first
        for number in sorted(down - self.held.keys(),
                             key=lambda each: self.table.get(each, ('', ''))[0] != 'fn'):
            with_fn = 'fn' in self.held.values()
            name = self.table.get(number, (None, None))[with_fn]
            self.held[number] = None if name == NOTHING else name
            if self.held[number]:
                pressed.append(name)
        return pressed

    def stops(self, numbers):
        """-> [name] of those of these keys that stop"""
        names = {self.table.get(number, ('',))[0] for number in numbers}
        return [name for name in STOPS if name in names]

    def is_down(self, name):
        return name in self.held.values()
