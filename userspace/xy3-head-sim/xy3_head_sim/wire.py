# SPDX-License-Identifier: GPL-2.0-only
"""The format of the backchannel, from its description only: tables, packets, and a decoder.

    byte  0    1     2       3 ...
          48h  type  length  payload of length bytes

It shares no code with the driver, so that each can be tested against the other.
"""

import struct

START = 0x48
HEADER = 3                      # bytes before the payload
MAX_PAYLOAD = 255
RESYNC = b'\x48\x41\x00\x48'    # a sync packet and the start of the next one

VENDOR, MODEL, FIRMWARE, SERIAL = 0x01, 0x02, 0x03, 0x04
TEMPERATURES, FRAME_ERRORS, ERRORS, DEBUG, HOURS = 0x05, 0x06, 0x07, 0x08, 0x09
SYNC = 0x41

TYPES = {
    'vendor': VENDOR, 'model': MODEL, 'firmware': FIRMWARE, 'serial': SERIAL,
    'temperatures': TEMPERATURES, 'frame_errors': FRAME_ERRORS, 'errors': ERRORS,
    'debug': DEBUG, 'hours': HOURS, 'sync': SYNC,
}
TYPE_NAMES = {number: name for name, number in TYPES.items()}
TEXT_TYPES = (VENDOR, MODEL, FIRMWARE, SERIAL, DEBUG)

# Valid lengths of known types. Other types may have any length.
LENGTHS = {
    VENDOR: range(3, 201), MODEL: range(3, 201), FIRMWARE: range(3, 201),
    SERIAL: range(3, 201), DEBUG: range(3, 201),
    TEMPERATURES: range(2, 45, 2),
    FRAME_ERRORS: range(20, 21),
    ERRORS: range(1, 23),
    HOURS: range(4, 89, 4),
    SYNC: range(0, 1),
}

AXES = ('x', 'y', 'z', 'u', 'w')
COMPONENTS = ('head', 'dsp') + tuple(
    '%s_%s' % (part, axis) for part in ('dac', 'driver', 'galvo', 'mirror') for axis in AXES)

ERROR_NAMES = ('none', 'temperature', 'data', 'range', 'power', 'electrical', 'adjustment',
               'mechanical')
FIRST_VENDOR_ERROR = 100

NO_TEMPERATURE = -32767         # the component has no thermometer
NO_HOURS = 0xFFFFFFFF           # the component has no hour counter

RATES = (57600, 115200, 230400, 460800, 921600)
DEFAULT_RATE = 115200

# The twenty bits of a command frame. AXIS_COMMANDS accept a mask of axes, bit 0 = X; a mask of 0
# selects all axes.
COMMANDS = {
    'autocalib on': 0x80000, 'autocalib off': 0x40000,
    'calibrate': 0xC0000, 'reference': 0x20000,
    'temp_comp on': 0x88000, 'temp_comp off': 0x48000,
    'rate 57600': 0xA0000, 'rate 115200': 0xE0000, 'rate 230400': 0x10000,
    'rate 460800': 0x90000, 'rate 921600': 0xD0000,
}
AXIS_COMMANDS = ('autocalib on', 'autocalib off', 'calibrate', 'reference', 'temp_comp on',
                 'temp_comp off')

_ORDERS = {'little': '<', 'big': '>'}


def axis_mask(axes):
    """'xz' -> 5; '' and 'all' select all axes and give 0"""
    if axes == 'all':
        return 0
    return sum(1 << AXES.index(axis) for axis in set(axes))


# --- packets ---------------------------------------------------------------------------------

def packet(kind, payload=b''):
    """A packet of any type, a name of TYPES or a number; its length may be invalid."""
    if isinstance(kind, str):
        kind = TYPES[kind]
    return bytes((START, kind, len(payload))) + payload


def _checked(kind, payload):
    if len(payload) not in LENGTHS[kind]:
        raise ValueError('%d bytes are not a valid length of a %s packet'
                         % (len(payload), TYPE_NAMES[kind]))
    return packet(kind, payload)


def _text(kind, text):
    return _checked(kind, text.encode('latin-1') if isinstance(text, str) else bytes(text))


def vendor(text):
    return _text(VENDOR, text)


def model(text):
    return _text(MODEL, text)


def firmware(text):
    return _text(FIRMWARE, text)


def serial(text):
    return _text(SERIAL, text)


def debug(text):
    return _text(DEBUG, text)


def sync():
    return packet(SYNC)


def _array(kind, values, letter, order):
    try:
        payload = struct.pack('%s%d%s' % (_ORDERS[order], len(values), letter), *values)
    except struct.error as error:
        raise ValueError('%s: %s' % (TYPE_NAMES[kind], error)) from None
    return _checked(kind, payload)


def temperatures(values, order='little'):
    """values: 1/100 degree Celsius, None if there is no thermometer"""
    return _array(TEMPERATURES, [NO_TEMPERATURE if value is None else value for value in values],
                  'h', order)


def frame_errors(values, order='little'):
    """values: a count for each of the five axes"""
    return _array(FRAME_ERRORS, values, 'I', order)


def errors(codes):
    """codes: numbers, or names of ERROR_NAMES"""
    return _array(ERRORS, [error_code(code) for code in codes], 'B', 'little')


def hours(values, order='little'):
    """values: hours, None if they are not counted"""
    return _array(HOURS, [NO_HOURS if value is None else value for value in values], 'I', order)


def error_code(code):
    """'temperature' or 1 -> 1"""
    return ERROR_NAMES.index(code) if isinstance(code, str) else code


def error_name(code):
    """1 -> 'temperature'; a code without a name -> its number as text"""
    return ERROR_NAMES[code] if code < len(ERROR_NAMES) else str(code)


def unpack(kind, payload, order='little'):
    """The contents of a payload of a known type: text as bytes, arrays as a list, None for sync.

    Temperatures and hours that the head does not support are None.
    """
    if kind in TEXT_TYPES:
        return payload
    if kind == SYNC:
        return None
    letter, size, missing = {
        TEMPERATURES: ('h', 2, NO_TEMPERATURE), FRAME_ERRORS: ('I', 4, None),
        ERRORS: ('B', 1, None), HOURS: ('I', 4, NO_HOURS)}[kind]
    values = struct.unpack('%s%d%s' % (_ORDERS[order], len(payload) // size, letter), payload)
    return [None if value == missing else value for value in values]


# --- frames of the forward channel -----------------------------------------------------------

def _frame(bits, position, data, width, parity_bits):
    if not 0 <= data < 1 << width:
        raise ValueError('%#x has more than %d bits' % (data, width))
    parity = bin(data).count('1') & ((1 << parity_bits) - 1)
    word = (bits == 32) << (bits - 1) | position << (bits - 2) | data << parity_bits | parity
    return word.to_bytes(bits // 8, 'big')


def command_frame(code, axes='', bits=24):
    """code: twenty bits, or a name of COMMANDS"""
    if isinstance(code, str):
        code = COMMANDS[code]
    code |= axis_mask(axes)
    return _frame(24, 0, code, 20, 2) if bits == 24 else _frame(32, 0, code, 26, 4)


def position_frame(position, bits=32):
    """position: 20 bits of a 24-bit frame, 26 of a 32-bit frame"""
    return _frame(24, 1, position, 20, 2) if bits == 24 else _frame(32, 1, position, 26, 4)


# --- receiver --------------------------------------------------------------------------------

class Decoder:
    """A receiver of the backchannel: keeps incomplete packets, and continues with them.

    packets       returned packets, including sync packets and unknown types
    syncs         sync packets among them
    unknown       packets of an unknown type among them
    packet_bytes  bytes in those packets
    dropped       bytes that were not part of a packet
    kept          bytes that are neither yet
    bad_lengths   known types with an invalid length
    resyncs       number of times that sync was found again after it was lost
    in_sync       whether the next byte is known to be in, or to start, a packet

    At any time: bytes fed = packet_bytes + dropped + kept.
    """

    __slots__ = ('packets', 'syncs', 'unknown', 'packet_bytes', 'dropped', 'bad_lengths',
                 'resyncs', 'in_sync', '_had_sync', '_buffer')

    def __init__(self):
        self.packets = self.syncs = self.unknown = self.packet_bytes = 0
        self.dropped = self.bad_lengths = self.resyncs = 0
        self.in_sync = self._had_sync = False
        self._buffer = b''

    @property
    def kept(self):
        return len(self._buffer)

    def feed(self, data):
        """-> [(type, payload), ...] of the packets that these bytes complete"""
        buffer = self._buffer + data
        size = len(buffer)
        at = 0                              # all bytes before it are processed
        found = []
        while at < size:
            if not self.in_sync:
                start = buffer.find(RESYNC, at)
                if start < 0:
                    end = size - _begun(buffer, size - at)
                    self.dropped += end - at
                    at = end
                    break
                self.dropped += start - at
                found.append((SYNC, b''))
                at = start + HEADER
                self.in_sync = True
                if self._had_sync:
                    self.resyncs += 1
                self._had_sync = True
                continue
            if buffer[at] != START:
                self._lose(1)
                at += 1
                continue
            if size - at < HEADER:
                break
            kind, length = buffer[at + 1], buffer[at + 2]
            legal = LENGTHS.get(kind)
            if legal is not None and length not in legal:
                self.bad_lengths += 1
                self._lose(1)
                at += 1
                continue
            end = at + HEADER + length
            if end > size:
                break
            found.append((kind, buffer[at + HEADER:end]))
            at = end
        self._buffer = buffer[at:]
        self._count(found)
        return found

    def lost(self, count):
        """count damaged bytes were received: a line error"""
        self._lose(len(self._buffer) + count)
        self._buffer = b''

    def _lose(self, count):
        self.in_sync = False
        self.dropped += count

    def _count(self, found):
        self.packets += len(found)
        for kind, payload in found:
            self.packet_bytes += HEADER + len(payload)
            if kind == SYNC:
                self.syncs += 1
            elif kind not in LENGTHS:
                self.unknown += 1

    def counts(self):
        """The counters, as a dictionary."""
        names = ('packets', 'syncs', 'unknown', 'packet_bytes', 'dropped', 'kept',
                 'bad_lengths', 'resyncs', 'in_sync')
        return {name: getattr(self, name) for name in names}


def _begun(buffer, available):
    """Number of bytes at the end that may be the start of RESYNC."""
    for length in (3, 2, 1):
        if length <= available and buffer.endswith(RESYNC[:length]):
            return length
    return 0
