# SPDX-License-Identifier: GPL-2.0-only
"""Transmission faults between the head and the host; each kind is set and counted separately."""

import random

from . import wire

# kind -> its effect, in the order in which they are applied to a packet. --help prints this table,
# and the manual page describes it.
KINDS = {
    'silence': 'the packet is not sent',
    'noise': '1 to 16 random bytes precede the packet',
    'unknown': 'a packet of a random unknown type precedes the packet',
    'false-sync': 'a debug packet with 48 41 00 48 in its payload precedes the packet',
    'trap': 'the same without its first byte, so that a receiver finds a sync in it',
    'lost': 'one byte is missing',
    'doubled': 'one byte is repeated',
    'flipped': 'one bit is wrong',
    'torn': 'the packet is truncated',
    'length': 'the length byte is wrong; for known types, it is an invalid length',
    'burst': 'the packet is sent fifty times',
    'wrong-rate': 'the packet is sent at a rate other than that of the UART',
}
BURST = 50
MOST_NOISE = 16

# Kinds of data sent. The first is an undamaged packet.
PACKET, DAMAGED, NOISE, SWALLOWED, GARBLED = 'packet', 'damaged', 'noise', 'swallowed', 'garbled'

# Bytes that a UART at another rate receives: never a 48h, so that no sync is found in them.
GARBAGE = bytes((0x00, 0x00, 0x80, 0xC0, 0xE0, 0xF0, 0xF8, 0xFC, 0xFE, 0xFF, 0x78, 0x1C, 0x66,
                 0x98, 0xE6, 0x86))

# The bytes after the false sync are parsed as the start of a packet with an invalid length.
FALSE_SYNC = wire.debug(b'on ' + wire.RESYNC + bytes((wire.TEMPERATURES, 0xFF)) + b' off')


def parse_how(text):
    """'off', 'once', 'always', 'N' (packets) or '1/N' (at random) -> (packets left, chance)

    Packets left are None if unlimited. ValueError for any other text.
    """
    if text == 'off':
        return 0, 1.0
    if text == 'once':
        return 1, 1.0
    if text == 'always':
        return None, 1.0
    left, chance = text, 1
    if text.startswith('1/'):
        left, chance = None, _positive(text[2:])
    return (None if left is None else _positive(left)), 1.0 / chance


def _positive(text):
    if not (text.isascii() and text.isdigit()) or int(text) == 0:
        raise ValueError('off, once, always, a number of packets or 1/N required, not "%s"' % text)
    return int(text)


class Faults:
    """The faults of one head; the seed makes them repeatable."""

    def __init__(self, seed=0):
        self.rng = random.Random(seed)
        self.counts = dict.fromkeys(KINDS, 0)       # the number of times that each occurred
        self._armed = {}                            # kind -> [packets left, chance]

    def set(self, kind, how):
        """how: as for parse_how(), or a number of packets"""
        if kind not in KINDS:
            raise ValueError('unknown fault "%s", must be one of: %s' % (kind, ' '.join(KINDS)))
        left, chance = parse_how(str(how))
        self._armed.pop(kind, None)
        if left != 0:
            self._armed[kind] = [left, chance]

    def clear(self):
        self._armed.clear()

    @property
    def active(self):
        """The kinds that are enabled."""
        return [kind for kind in KINDS if kind in self._armed]

    def meet(self, packet):
        """-> [(kind of data, bytes), ...] to send in this order"""
        if not self._armed:
            return [(PACKET, packet)]
        if self._happens('silence'):
            return [(SWALLOWED, packet)]
        pieces = []
        if self._happens('noise'):
            pieces.append((NOISE, self._noise()))
        if self._happens('unknown'):
            pieces.append((PACKET, self._unknown()))
        if self._happens('false-sync'):
            pieces.append((PACKET, FALSE_SYNC))
        if self._happens('trap'):
            pieces.append((DAMAGED, FALSE_SYNC[1:]))
        what, data = PACKET, packet
        for kind in ('lost', 'doubled', 'flipped', 'torn', 'length'):
            if self._happens(kind):
                what, data = DAMAGED, getattr(self, '_' + kind)(data)
        pieces += [(what, data)] * (BURST if self._happens('burst') else 1)
        if self._happens('wrong-rate'):
            pieces = [(GARBLED, self.garble(data)) for _, data in pieces]
        return pieces

    def _happens(self, kind):
        armed = self._armed.get(kind)
        if armed is None or (armed[1] < 1 and self.rng.random() >= armed[1]):
            return False
        if armed[0] is not None:
            armed[0] -= 1
            if armed[0] == 0:
                del self._armed[kind]
        self.counts[kind] += 1
        return True

    def garble(self, data, ratio=0.5):
        """What a UART with ratio times the rate of these bytes receives."""
        count = max(1, round(len(data) * min(ratio, 2.0)))
        return bytes(self.rng.choices(GARBAGE, k=count))

    # --- one function for each kind -------------------------------------------------------

    def _noise(self):
        data = self.rng.randbytes(self.rng.randint(1, MOST_NOISE))
        return data if data[0] != wire.START else b'\0' + data[1:]

    def _unknown(self):
        kind = self.rng.choice([kind for kind in range(256) if kind not in wire.LENGTHS])
        return wire.packet(kind, self.rng.randbytes(self.rng.randint(0, wire.MAX_PAYLOAD)))

    def _lost(self, data):
        at = self.rng.randrange(len(data))
        return data[:at] + data[at + 1:]

    def _doubled(self, data):
        at = self.rng.randrange(len(data))
        return data[:at] + data[at:at + 1] + data[at:]

    def _flipped(self, data):
        at = self.rng.randrange(len(data))
        return data[:at] + bytes((data[at] ^ 1 << self.rng.randrange(8),)) + data[at + 1:]

    def _torn(self, data):
        return data[:self.rng.randrange(1, len(data))] if len(data) > 1 else b''

    def _length(self, data):
        if len(data) < wire.HEADER:         # truncated by another fault
            return data
        legal = wire.LENGTHS.get(data[1], (data[2],))
        wrong = self.rng.choice([length for length in range(256) if length not in legal])
        return data[:2] + bytes((wrong,)) + data[3:]
