# SPDX-License-Identifier: GPL-2.0-only
"""The display: chunks -> frame -> contents of the LCD of an HB03 or HB04.

Frame layout (all numbers little-endian; F = 1 byte on the HB03, 2 bytes on the HB04):

    FE FD | day 1 | work x y z: 2+F each | machine x y z: 2+F each |
    feed override 2 | spindle override 2 | feed 2 | spindle speed 2 | step 1 | state 1

A coordinate is the integer part without sign, then the fraction in units of the last displayed
digit; the top bit of the fraction is the sign.  Step: low nibble = code of the multiplier,
high nibble = icon.
"""

from .wire import CHUNK_SIZE

MAGIC = b'\xfe\xfd'
COORDINATES = ('work_x', 'work_y', 'work_z', 'machine_x', 'machine_y', 'machine_z')
NUMBERS = ('feedrate_override', 'spindle_override', 'feedrate', 'spindle_speed')
WIDTH = 46

# Low nibble of the step byte -> multiplier.  0Bh exists on the HB04, its meaning is unknown.
STEPS = {0x0: 0, 0x1: 1, 0x2: 5, 0x3: 10, 0x4: 20, 0x5: 30, 0x6: 40, 0x7: 50, 0x8: 100,
         0x9: 500, 0xA: 1000}


class Assembler:
    """Collects 7-byte chunks into frames, as the device does."""

    def __init__(self, model):
        self.model = model
        self.stray = 0          # chunks outside of frames
        self.torn = 0           # incomplete frames
        self.buffer = None      # None: waiting for the magic bytes

    def feed(self, chunk):
        """Takes one chunk; returns the whole frame with its last one, otherwise None."""
        if len(chunk) != CHUNK_SIZE:
            self.stray += 1
            return None
        if chunk.startswith(MAGIC):
            if self.buffer is not None:
                self.torn += 1
            self.buffer = b''
        elif self.buffer is None:
            self.stray += 1
            return None
        self.buffer += chunk
        if len(self.buffer) < self.model.chunks * CHUNK_SIZE:
            return None
        frame, self.buffer = self.buffer, None
        return frame


class Picture:
    """The contents of the LCD after one frame.  `faults` lists invalid values in the frame.

    POSITIONS   the decimal fields; GROUP is the name of all of them together
    FIELDS      names of the fields that scripts can expect
    """

    POSITIONS, GROUP = COORDINATES, 'position'
    FIELDS = COORDINATES + NUMBERS + ('position', 'step', 'step_code', 'icon', 'state', 'day',
                                      'faults')

    def __init__(self, model, frame):
        self.model = model
        self.frame = bytes(frame)
        self.faults = []
        self.coordinates = {}
        self.numbers = {}
        self._decode()

    def _decode(self):
        self._check_frame()
        if any(self.frame[self.model.frame_size:]):
            self.faults.append('padding is not zero')

        self.day = self.frame[2]
        if not 1 <= self.day <= 31:
            self.faults.append('day %d' % self.day)

        at = 3
        for name in COORDINATES:
            end = at + 2 + self.model.fraction_size
            self.coordinates[name] = self._coordinate(name, self.frame[at:end])
            at = end
        for name in NUMBERS:
            self.numbers[name] = int.from_bytes(self.frame[at:at + 2], 'little')
            at += 2

        self.step_code = self.frame[at] & 0x0F
        self.icon = self.frame[at] >> 4
        self.step = STEPS.get(self.step_code)
        if self.step is None:
            self.faults.append('step code %#x' % self.step_code)
        self.state = self.frame[at + 1]

    def _check_frame(self):
        size = self.model.frame_size
        if len(self.frame) < size:
            raise ValueError('a frame of the %s has %d bytes, not %d'
                             % (self.model.name, size, len(self.frame)))
        if not self.frame.startswith(MAGIC):
            self.faults.append('no magic')

    def _coordinate(self, name, field):
        """-> the text on the LCD, sign and all decimals"""
        digits = self.model.decimals
        whole = int.from_bytes(field[:2], 'little')
        raw = int.from_bytes(field[2:], 'little')
        sign_bit = 1 << (8 * len(field[2:]) - 1)
        fraction = raw & (sign_bit - 1)
        negative = bool(raw & sign_bit)
        if fraction >= 10 ** digits:
            self.faults.append('%s: fraction %d' % (name, fraction))
        if negative and not whole and not fraction:
            self.faults.append('%s: minus zero' % name)
        return '%s%d.%0*d' % ('-' if negative else '', whole, digits, fraction)

    def state_text(self):
        """The lit words joined by +, other bits as a number; "idle" if nothing is lit."""
        words, rest = [], self.state
        for bit, word in self.model.states.items():
            if rest & bit:
                words.append(word)
                rest &= ~bit
        if rest:
            words.append('0x%02x' % rest)
        return '+'.join(words) or 'idle'

    def as_dict(self):
        """All fields of the LCD; the names are those of the driver's dro/ attributes."""
        fields = dict(self.coordinates)
        fields.update(self.numbers)
        fields.update(day=self.day, step=self.step, step_code=self.step_code, icon=self.icon,
                      state=self.state_text(), state_byte=self.state, faults=list(self.faults))
        return fields

    def lines(self, awake=True, selector='off'):
        """The LCD as eight lines of text."""
        model, point, number = self.model, self.coordinates, self.numbers
        step = '?' if self.step is None else self.step
        rows = [
            '%-16s icon %-2d %10s' % (self.state_text().upper().replace('+', ' '), self.icon,
                                      'x%s' % step),
            '      %12s %16s' % ('WORK', 'MACHINE'),
        ]
        for axis in 'xyz':
            mark = '>' if selector == axis else ' '
            rows.append('%s%s  %14s %16s' % (mark, axis.upper(), point['work_' + axis],
                                             point['machine_' + axis]))
        rows.append('%sF %6d %5d%%   %sS %6d %5d%%' % (
            '>' if selector == 'feed' else ' ', number['feedrate'], number['feedrate_override'],
            '>' if selector == 'spindle' else ' ', number['spindle_speed'],
            number['spindle_override']))
        return box(model, awake, 'day %d' % self.day, rows)

    def text(self, awake=True, selector='off'):
        return '\n'.join(self.lines(awake, selector))


def blank(model, awake=True):
    """The LCD before the first frame: eight lines of text."""
    return box(model, awake, 'no frame yet', [''] * 6)


def box(model, awake, right, rows):
    """A frame around six rows."""
    left = model.name + ('' if awake else ' asleep')
    top = '+- %s %s %s -+' % (left, '-' * (WIDTH - 8 - len(left) - len(right)), right)
    body = ['| %-*s |' % (WIDTH - 4, row) for row in rows]
    return [top] + body + ['+%s+' % ('-' * (WIDTH - 2))]


def normal_number(text):
    """Decimal text -> a canonical form, so that -220.334 and -220.3340 compare equal."""
    text = text.strip()
    negative = text.startswith('-')
    whole, _, fraction = text.lstrip('+-').partition('.')
    if not (whole + fraction).isdecimal():
        raise ValueError('not a number: %s' % text)
    whole, fraction = whole.lstrip('0') or '0', fraction.rstrip('0')
    plain = whole + ('.' + fraction if fraction else '')
    return '-' + plain if negative and plain != '0' else plain
