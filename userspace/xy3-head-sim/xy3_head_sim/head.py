# SPDX-License-Identifier: GPL-2.0-only
"""The simulated head: its state, its packets and their schedule, and exact counts."""

import math
import time

from . import faults, wire

TEXTS = ('vendor', 'model', 'firmware', 'serial')
ROUND = ('sync',) + TEXTS + ('temperatures', 'errors', 'hours', 'frame_errors', 'sync')
BLOCK = 65536               # bytes that are built in advance for streams
BACKLOG = 32768             # telemetry is skipped while the host has not read this many bytes

# A head with two axes, in degrees and hours.
TWO_AXES = {'head': 31.5, 'dsp': 44.25, 'driver_x': 38.0, 'driver_y': 38.5,
            'galvo_x': 36.75, 'galvo_y': 36.5}
TWO_AXES_HOURS = {'head': 1200, 'dsp': 1200, 'galvo_x': 1150, 'galvo_y': 1150}


class NoLine:
    """The line of a head without one: always open, discards all data."""

    is_open, pending, unsent, openings = True, 0, 0, 0

    def send(self, data):
        pass

    def uart_rate(self):
        return None

    def set_rate(self, rate):
        pass


class Head:
    """A scanhead's backchannel.

    line           one of line.py, or None
    interval       seconds between rounds of telemetry, 0 to disable
    sync_interval  seconds between sync packets, 0 to disable
    Texts are None if the head does not report them. temperatures (in 1/100 degree), errors
    (codes) and hours have a value for each component, None for "absent": absent ones at the end
    of an array are not sent, others are sent as "not supported" or, for errors, as 0.
    frame_errors has a value for each axis; it is not sent if it is None.
    """

    def __init__(self, line=None, vendor='Virtual', model='Head-2D', firmware='1.0.0',
                 serial='SIM-0001', order='little', rate=wire.DEFAULT_RATE, interval=1.0,
                 sync_interval=0.1, seed=0):
        self.line = NoLine() if line is None else line
        self.faults = faults.Faults(seed)
        self.order = order
        self.interval = interval
        self.sync_interval = sync_interval
        self.temperatures = [None] * len(wire.COMPONENTS)
        self.errors = [0] * len(wire.COMPONENTS)
        self.hours = [None] * len(wire.COMPONENTS)
        self.frame_errors = [0] * len(wire.AXES)
        for name, degrees in TWO_AXES.items():
            self.set_temperature(name, degrees)
        for name, hours in TWO_AXES_HOURS.items():
            self.set_hours(name, hours)
        for name, text in zip(TEXTS, (vendor, model, firmware, serial)):
            self.set_text(name, text)
        self._silent_until = 0.0
        self._due_sync = self._due_round = 0.0
        self.set_rate(rate)
        self.receiver = wire.Decoder()              # a correct receiver of the sent data
        self.forget_counts()

    # --- state ----------------------------------------------------------------------------

    def set_text(self, name, text):
        """name: one of TEXTS"""
        if text is not None:
            getattr(wire, name)(text)               # ValueError if it is too short or too long
        setattr(self, name, text)

    def set_temperature(self, component, degrees):
        value = None if degrees is None else round(degrees * 100)
        if value is not None and not -32768 <= value <= 32767:
            raise ValueError('a temperature must be -327.68 to 327.67 degrees')
        self.temperatures[_component(component)] = value

    def set_error(self, component, code):
        """code: 0..255, a name of wire.ERROR_NAMES, or None"""
        value = None if code is None else wire.error_code(code)
        if value is not None and not 0 <= value <= 255:
            raise ValueError('an error code must be 0 to 255')
        self.errors[_component(component)] = value

    def set_hours(self, component, hours):
        if hours is not None and not 0 <= hours <= 0xFFFFFFFF:
            raise ValueError('hours must be 0 to 4294967295')
        self.hours[_component(component)] = hours

    def set_frame_errors(self, axis, count):
        if not 0 <= count <= 0xFFFFFFFF:
            raise ValueError('a count must be 0 to 4294967295')
        if self.frame_errors is None:
            self.frame_errors = [0] * len(wire.AXES)
        self.frame_errors[wire.AXES.index(axis)] = count

    def set_order(self, order):
        if order not in ('little', 'big'):
            raise ValueError('the order must be little or big')
        self.order = order

    def set_rate(self, rate):
        if rate not in wire.RATES:
            raise ValueError('a rate must be one of: %s' % ' '.join(map(str, wire.RATES)))
        self.rate = rate
        self.line.set_rate(rate)

    # --- packets --------------------------------------------------------------------------

    def packet(self, name):
        """The packet of this name as the head would send it now; None if there is no data."""
        if name == 'sync':
            return wire.sync()
        value = getattr(self, name)
        if name in TEXTS:
            return None if value is None else getattr(wire, name)(value)
        if name == 'frame_errors':
            return None if value is None else wire.frame_errors(value, self.order)
        while value and value[-1] is None:
            value = value[:-1]
        if not value:
            return None
        if name == 'errors':
            return wire.errors([code or 0 for code in value])
        return getattr(wire, name)(value, self.order)

    def packets(self):
        """One round of telemetry, between two sync packets."""
        return [packet for packet in map(self.packet, ROUND) if packet is not None]

    def report(self, *names):
        """Sends the packets of these names, or the whole round."""
        for packet in map(self.packet, names or ROUND):
            if packet is not None:
                self.send(packet)

    def debug(self, text):
        self.send(wire.debug(text))

    def silence(self, seconds):
        """Sends nothing for that time; 0 ends the silence, math.inf is unlimited."""
        self._silent_until = time.monotonic() + seconds if seconds else 0.0

    @property
    def silent(self):
        return time.monotonic() < self._silent_until

    # --- schedule -------------------------------------------------------------------------

    def begin(self):
        """The host has opened the line: a new receiver, and a round of telemetry is due."""
        self.receiver = wire.Decoder()
        self.reschedule()

    def reschedule(self):
        """Restarts the intervals."""
        self._due_sync = self._due_round = 0.0

    def tick(self, now):
        """Sends packets that are due. -> time of the next call, math.inf for never"""
        if not self.line.is_open:
            return math.inf
        if self.interval and now >= self._due_round:
            self._due_round = now + self.interval
            if self.line.pending < BACKLOG:
                self.report()
            else:
                self.held_back += 1
        if self.sync_interval and now >= self._due_sync:
            self._due_sync = now + self.sync_interval
            if self.line.pending < BACKLOG:
                self.report('sync')
            else:
                self.held_back += 1
        return min(self._due_round if self.interval else math.inf,
                   self._due_sync if self.sync_interval else math.inf)

    # --- sending and counting -------------------------------------------------------------

    def forget_counts(self):
        """Resets the counts, except those of the receiver."""
        self.by_type = dict.fromkeys((*wire.TYPES, 'unknown'), 0)
        self.packet_count = self.damaged_count = self.garbled_count = 0
        self.swallowed_count = self.unheard_count = self.held_back = 0
        self.bytes = dict.fromkeys((faults.PACKET, faults.DAMAGED, faults.NOISE,
                                    faults.GARBLED), 0)
        self.faults.counts = dict.fromkeys(faults.KINDS, 0)

    def send(self, packet):
        """Sends a packet, subject to faults."""
        if not self.line.is_open:
            self.unheard_count += 1
        elif self.silent:
            self.swallowed_count += 1
        else:
            for what, data in self.faults.meet(packet):
                self._put(what, data)

    def send_raw(self, data):
        """Sends bytes that are not a packet; faults do not apply."""
        if self.line.is_open and not self.silent:
            self._put(faults.NOISE, data)

    def _put(self, what, data):
        if what == faults.SWALLOWED:
            self.swallowed_count += 1
            return
        uart = self.line.uart_rate()
        if what != faults.GARBLED and uart not in (None, self.rate):
            what, data = faults.GARBLED, self.faults.garble(data, uart / self.rate)
        if what == faults.PACKET:
            self.packet_count += 1
            self.by_type[wire.TYPE_NAMES.get(data[1], 'unknown')] += 1
        elif what == faults.DAMAGED:
            self.damaged_count += 1
        elif what == faults.GARBLED:
            self.garbled_count += 1
        self.bytes[what] += len(data)
        self.receiver.feed(data)
        self.line.send(data)

    def counts(self):
        """All counts, as a dictionary."""
        return {
            'packets': self.packet_count,
            'by_type': dict(self.by_type),
            'bytes': sum(self.bytes.values()),
            'packet_bytes': self.bytes[faults.PACKET],
            'damaged_packets': self.damaged_count,
            'damaged_bytes': self.bytes[faults.DAMAGED],
            'noise_bytes': self.bytes[faults.NOISE],
            'garbled_packets': self.garbled_count,
            'garbled_bytes': self.bytes[faults.GARBLED],
            'swallowed_packets': self.swallowed_count,
            'unheard_packets': self.unheard_count,
            'held_back': self.held_back,
            'faults': dict(self.faults.counts),
            'rate': self.rate,
            'uart_rate': self.line.uart_rate(),
            'queued': self.line.pending,
            'unsent': self.line.unsent,
            'openings': self.line.openings,
            'receiver': self.receiver.counts(),
        }

    # --- streams --------------------------------------------------------------------------

    def stream(self, packets=0, size=0):
        """Sends a number of packets, or the least number of packets with a number of bytes.

        A generator: it yields wherever the caller may wait for the line. It repeats a round of
        telemetry that includes a debug packet.
        """
        one = self.packets()
        one.insert(1, wire.debug('simulated traffic'))
        block = _Block(one)
        sent_packets = sent_bytes = 0

        def more(count, length):
            """Whether count more packets, with length bytes, do not exceed the stream."""
            if packets:
                return sent_packets + count <= packets
            return sent_bytes + length <= size

        while more(1, 1):
            if self._clear() and more(block.packets, block.size):
                self._put_block(block)
                sent_packets += block.packets
                sent_bytes += block.size
            else:
                for packet in one:
                    if not more(1, 1):
                        break
                    self.send(packet)
                    sent_packets += 1
                    sent_bytes += len(packet)
            yield

    def _clear(self):
        """Whether packets are sent and received unchanged."""
        return (not self.faults.active and self.line.is_open and not self.silent and
                self.line.uart_rate() in (None, self.rate) and
                self.receiver.in_sync and not self.receiver.kept)

    def _put_block(self, block):
        for name, count in block.by_type.items():
            self.by_type[name] += count
        self.packet_count += block.packets
        self.bytes[faults.PACKET] += block.size
        self.receiver.packets += block.packets
        self.receiver.syncs += block.by_type['sync']
        self.receiver.packet_bytes += block.size
        self.line.send(block.data)


class _Block:
    """Repeated packets in one buffer, and their counts."""

    def __init__(self, packets):
        data = b''.join(packets)
        times = BLOCK // len(data) + 1
        self.data = data * times
        self.size = len(self.data)
        self.packets = len(packets) * times
        self.by_type = dict.fromkeys(wire.TYPES, 0)
        for packet in packets:
            self.by_type[wire.TYPE_NAMES[packet[1]]] += times


def _component(name):
    if name not in wire.COMPONENTS:
        raise ValueError('unknown component "%s"' % name)
    return wire.COMPONENTS.index(name)
