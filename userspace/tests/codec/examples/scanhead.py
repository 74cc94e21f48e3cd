# SPDX-License-Identifier: GPL-2.0-only
"""The examples of userspace/doc/protocol-xy3.md, converted by the virtual head

Each function takes (about, bytes, words) and returns bytes and words of the simulator.
"""

from xy3_head_sim import wire

GAP = 2                 # clocks between frames when SYNC is a line


# --- forward channel -------------------------------------------------------------------------

def command(words, bits, unread=0):
    """'calibrate xy' -> a frame; unread: the value of six bits that are ignored"""
    name, axes = words, ''
    if words not in wire.COMMANDS:
        name, _, axes = words.rpartition(' ')
    return wire.command_frame(wire.COMMANDS[name] | unread << 20, axes, bits)


def frame(_, data, words):
    """The words as a frame of this size; for an erroneous frame, check that it is one."""
    bits = 8 * len(data)
    if words == 'torn':
        return data, words if bits != (32 if data[0] & 0x80 else 24) else 'whole'
    if words == 'bad parity':
        value = int.from_bytes(data, 'big')
        code = value >> (2 if bits == 24 else 4) & ((1 << (20 if bits == 24 else 26)) - 1)
        made = (wire.position_frame(code, bits), wire.command_frame(code, '', bits))
        return data, 'good' if data in made else words
    kind, _, rest = words.partition(' ')
    if bits not in (24, 32):
        return b'', words
    if kind == 'position':
        return wire.position_frame(int(rest), bits), words
    return command(rest, bits, data[0] & 0x3f if bits == 32 else 0), words


def scan(about, _, words):
    """The frames clock by clock, the highest line first"""
    bits, *signals = about.split()
    bits, codes = int(bits), words.split()
    levels = {'-': '0' * bits, 'sync': '0' * bits + '1' * GAP}
    for axis in (axis for axis in wire.AXES if axis in signals):
        if words.startswith('command '):
            made = command(words[8:], bits) if axis == 'x' else bytes(bits // 8)
        else:
            made = wire.position_frame(int(codes.pop(0)), bits)
        levels[axis] = '{:0{}b}'.format(int.from_bytes(made, 'big'), bits)
    clocks = bits + GAP * ('sync' in signals)
    levels['gate'] = (codes.pop(0) if codes else '0') * clocks
    stream = ''.join(levels[signal].ljust(clocks, '0')[clock]
                     for clock in range(clocks) for signal in reversed(signals))
    return int(stream, 2).to_bytes(len(stream) // 8, 'big'), words


# --- backchannel -----------------------------------------------------------------------------

def name_of(kind):
    return wire.TYPE_NAMES.get(kind, 'unknown %02x' % kind)


def content(kind, payload, order):
    if kind == wire.SYNC:
        return ''
    if kind not in wire.LENGTHS or kind in wire.TEXT_TYPES:
        return ' "%s"' % ''.join(chr(byte) if 0x20 <= byte <= 0x7e else '?' for byte in payload)
    values = wire.unpack(kind, payload, order)
    if kind == wire.ERRORS:
        texts = [wire.error_name(value) for value in values]
    elif kind == wire.TEMPERATURES:
        texts = ['-' if value is None else '%.2f' % (value / 100) for value in values]
    else:
        texts = ['-' if value is None else str(value) for value in values]
    return ' ' + ' '.join(texts)


def packet(about, data, _):
    decoder = wire.Decoder()
    found = decoder.feed(wire.sync() + data)
    if len(found) != 2 or decoder.kept or decoder.dropped:
        return data, 'no packet'
    kind, payload = found[1]
    return data, name_of(kind) + content(kind, payload, about or 'little')


def stream(_, data, __):
    decoder = wire.Decoder()
    parts = [name_of(kind) for kind, _ in decoder.feed(data)]
    if decoder.dropped:
        parts.append('%d dropped' % decoder.dropped)
    if decoder.kept:
        parts.append('%d kept' % decoder.kept)
    return data, ', '.join(parts + ['in sync' if decoder.in_sync else 'out of sync'])


KINDS = {'frame': frame, 'scan': scan, 'packet': packet, 'stream': stream}
