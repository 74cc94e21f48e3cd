# SPDX-License-Identifier: GPL-2.0-only
"""The bytes of scans, bit by bit, for comparison with our driver; and functions to send them."""
import array
import ctypes
import fcntl
import os
import struct

GAP_CLOCKS = 2


class Arrangement:
    """Data lines and their signals.

    framing: cs (SYNC is the chip select), word (the same, toggled by the controller after each
    word), or line (SYNC is the lowest data line).
    """

    def __init__(self, lines, framing, frame_bits):
        self.lines, self.framing, self.frame_bits = lines, framing, frame_bits
        self.first = int(framing == 'line')     # the line of X
        self.axes = min(lines - self.first, 5)
        self.clocks = frame_bits + GAP_CLOCKS * self.first
        self.code_bits = 26 if frame_bits == 32 else 20
        sync = {'cs': '', 'word': ', CS word', 'line': ' with SYNC'}[framing]
        self.name = f"{frame_bits} bits, {lines} line{'s' * (lines > 1)}{sync}"

    def module_parameters(self):
        return f"lines={self.lines} framing={'line' if self.first else 'cs'} " \
               f"cs_word={int(self.framing == 'word')} interval_ms=0 sync_ms=0"

    def frame(self, code):
        parity_bits = 4 if self.frame_bits == 32 else 2
        parity = bin(code).count('1') % (1 << parity_bits)
        head = 3 if self.frame_bits == 32 else 1
        return (head << self.code_bits | code) << parity_bits | parity

    def scan(self, codes):
        """The bytes of one scan."""
        frames = [self.frame(code) for code in codes]
        if self.framing == 'word':
            return struct.pack('=I', frames[0])
        value = 0
        for clock in reversed(range(self.frame_bits)):
            group = 0
            for axis, frame in enumerate(frames):
                group |= (frame >> clock & 1) << self.first + axis
            value = value << self.lines | group
        for _ in range(self.clocks - self.frame_bits):
            value = value << self.lines | 1
        return value.to_bytes(self.clocks * self.lines // 8, 'big')


class Spidev:
    """Sends prepared bytes with the kernel's spidev, in messages of a number of scans."""

    def __init__(self, node, arrangement, codes, rate, scans):
        axes = arrangement.axes
        each = [arrangement.scan(codes[i:i + axes]) for i in range(0, len(codes), axes)]
        self.fd = os.open(node, os.O_RDWR)
        self.keep = []
        self.messages = []
        for at in range(0, len(each), scans):
            data = each[at:at + scans]
            if arrangement.framing != 'cs':
                data = [b''.join(data)]
            bits = arrangement.frame_bits if arrangement.framing == 'word' else 8
            self.messages.append(self.message(data, rate * arrangement.clocks, bits,
                                              arrangement.lines))
        # _IOW('k', 0, transfers)
        self.request = 1 << 30 | len(self.messages[0]) << 16 | ord('k') << 8

    def message(self, transfers, speed, bits, lines):
        message = b''
        for i, data in enumerate(transfers):
            buffer = ctypes.create_string_buffer(data, len(data))
            self.keep.append(buffer)
            # tx_buf rx_buf len speed_hz delay_usecs bits_per_word cs_change tx_nbits
            message += struct.pack('=QQIIHBBB3x', ctypes.addressof(buffer), 0, len(data), speed, 0,
                                   bits, i + 1 < len(transfers), lines)
        return bytearray(message)   # ioctl() only accepts a longer one if it is writable

    def send(self):
        for message in self.messages:
            fcntl.ioctl(self.fd, self.request, message)

    def finish(self):
        os.close(self.fd)


class Stream:
    """Writes codes to the IIO device of our driver."""

    def __init__(self, folder, arrangement, codes, rate, length):
        self.folder = folder
        self.codes = array.array('I', codes)
        self.set('frame_bits', arrangement.frame_bits)
        self.set('sampling_frequency', rate)
        for axis in range(arrangement.axes):
            self.set(f'scan_elements/out_angl{axis}_en', 1)
        self.set('buffer/length', length)
        self.set('buffer/enable', 1)
        self.fd = os.open('/dev/' + os.path.basename(folder), os.O_WRONLY)

    def set(self, name, value):
        with open(f'{self.folder}/{name}', 'w', encoding='ascii') as file:
            file.write(str(value))

    def get(self, name):
        """The value of an attribute, or of a counter in debugfs."""
        device = os.path.basename(os.path.dirname(os.path.realpath(self.folder)))
        for folder in (self.folder, f'/sys/kernel/debug/xy3-spi/{device}'):
            if os.path.exists(f'{folder}/{name}'):
                with open(f'{folder}/{name}', encoding='ascii') as file:
                    return int(file.read())
        raise FileNotFoundError(name)

    def send(self):
        left = memoryview(self.codes).cast('B')
        while left:
            left = left[os.write(self.fd, left):]

    def finish(self):
        self.set('buffer/enable', 0)    # returns after all has been sent
        os.close(self.fd)
