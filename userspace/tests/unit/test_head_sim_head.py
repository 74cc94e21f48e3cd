# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xy3-head-sim, the head: telemetry, times, faults, counts, streams."""

import math
import os
import sys
import pytest
from case import Case, row


sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)),
                                '..', '..', 'xy3-head-sim'))

from xy3_head_sim import faults, head, wire  # noqa: E402 (the path has to be set first)

PACKETS = {
    'vendor': wire.vendor('abcdef'), 'temperatures': wire.temperatures([1, 2, 3]),
    'errors': wire.errors([1]), 'hours': wire.hours([1, 2]), 'debug': wire.debug('x' * 200),
    'frame_errors': wire.frame_errors([1, 2, 3, 4, 5]), 'sync': wire.sync(),
    'unknown': wire.packet(0x20, b'12345'), 'empty unknown': wire.packet(0x21),
}
END = wire.errors([7] * 22)         # sent after a fault, to check whether it is received


class Ear(head.NoLine):
    """A line that records the data sent."""

    def __init__(self, uart=None):
        self.heard = b''
        self.uart = uart

    def send(self, data):
        self.heard += data

    def uart_rate(self):
        return self.uart

    def take(self):
        heard, self.heard = self.heard, b''
        return heard


def quiet_head(**options):
    """A head that sends nothing by itself, and its line."""
    ear = Ear()
    return head.Head(ear, interval=0, sync_interval=0, **options), ear


def decode(data):
    decoder = wire.Decoder()
    return decoder.feed(data), decoder


class TestTelemetry(Case):
    def set_up(self):
        self.head, self.ear = quiet_head()

    def say(self, *names):
        self.head.report(*names)
        return self.ear.take()

    def test_a_round(self):
        packets, decoder = decode(self.say())
        assert [wire.TYPE_NAMES[kind] for kind, _ in packets] == [
            'sync', 'vendor', 'model', 'firmware', 'serial', 'temperatures', 'errors', 'hours',
            'frame_errors', 'sync']
        assert (decoder.dropped, decoder.kept) == (0, 0)
        values = {wire.TYPE_NAMES[kind]: wire.unpack(kind, payload) for kind, payload in packets}
        assert values['serial'] == b'SIM-0001'
        assert values['temperatures'][:3] + values['temperatures'][-2:] == \
                         [3150, 4425, None, 3675, 3650]
        assert values['errors'] == [0] * 22
        assert (values['hours'][0], values['hours'][2]) == (1200, None)
        assert values['frame_errors'] == [0] * 5

    def test_identity(self):
        self.head.set_text('vendor', 'Other')
        self.head.set_text('serial', None)
        assert self.say('vendor', 'serial') == wire.vendor('Other')

    def test_temperature(self):
        self.head.set_temperature('mirror_w', -40.125)
        values = wire.unpack(wire.TEMPERATURES, self.say('temperatures')[3:])
        assert (len(values), values[21]) == (22, -4012)

    def test_error(self):
        self.head.set_error('dac_y', 'temperature')
        self.head.set_error('mirror_w', 255)
        values = self.say('errors')[3:]
        assert (values[3], values[21], sum(values)) == (1, 255, 256)

    def test_absent_ones_shorten_an_array(self):
        for name in wire.COMPONENTS[2:]:
            self.head.set_temperature(name, None)
            self.head.set_hours(name, None)
            self.head.set_error(name, None)
        self.head.set_error('head', None)
        assert self.say('temperatures')[2] == 4
        assert self.say('hours')[2] == 8
        assert self.say('errors') == wire.errors([0, 0])

    def test_nothing_to_report(self):
        for name in wire.COMPONENTS:
            self.head.set_temperature(name, None)
        self.head.frame_errors = None
        assert self.say('temperatures', 'frame_errors') == b''
        self.head.set_frame_errors('w', 5)
        assert self.say('frame_errors') == wire.frame_errors([0, 0, 0, 0, 5])

    def test_big_endian(self):
        self.head.set_order('big')
        self.head.set_hours('head', 258)
        assert self.say('hours')[3:7] == b'\0\0\1\2'
        assert self.say('temperatures')[3:5] == (3150).to_bytes(2, 'big')
        self.head.set_frame_errors('x', 1)
        assert self.say('frame_errors')[3:7] == b'\0\0\0\1'

    def test_wrong_values(self):
        for name, call in (
                ('component', lambda: self.head.set_temperature('galvo', 1)),
                ('degrees', lambda: self.head.set_temperature('head', 327.68)),
                ('code', lambda: self.head.set_error('head', 256)),
                ('name', lambda: self.head.set_error('head', 'fire')),
                ('hours', lambda: self.head.set_hours('head', -1)),
                ('axis', lambda: self.head.set_frame_errors('v', 1)),
                ('count', lambda: self.head.set_frame_errors('x', 1 << 32)),
                ('text', lambda: self.head.set_text('model', 'ab')),
                ('order', lambda: self.head.set_order('middle')),
                ('rate', lambda: self.head.set_rate(9600))):
            with row(name), pytest.raises(ValueError):
                call()


class TestTimes(Case):
    def test_intervals(self):
        ear = Ear()
        one = head.Head(ear, interval=1.0, sync_interval=0.25)
        now, calls = 100.0, 0
        while now < 110:
            now = one.tick(now)
            calls += 1
        counts = one.counts()['by_type']
        assert counts['vendor'] == 10
        assert counts['sync'] == 10 * 2 + 40
        assert calls < 60

    def test_no_intervals(self):
        one, ear = quiet_head()
        assert one.tick(100.0) == math.inf
        assert ear.heard == b''

    def test_a_host_that_does_not_read(self):
        ear = Ear()
        ear.pending = head.BACKLOG
        one = head.Head(ear, interval=1.0)
        one.tick(100.0)
        assert (ear.heard, one.counts()['held_back']) == (b'', 2)

    def test_nobody_listens(self):
        one, ear = quiet_head()
        ear.is_open = False
        one.report('vendor')
        one.send_raw(b'1')
        assert one.tick(100.0) == math.inf
        assert (ear.heard, one.counts()['unheard_packets'], one.counts()['bytes']) == \
                         (b'', 1, 0)

    def test_silence(self):
        one, ear = quiet_head()
        one.silence(math.inf)
        one.report('vendor', 'model')
        one.send_raw(b'1')
        assert (ear.heard, one.counts()['swallowed_packets']) == (b'', 2)
        one.silence(0)
        one.report('vendor')
        assert ear.heard == wire.vendor('Virtual')


class TestFaultModes(Case):
    def happened(self, how, packets=1000):
        one, _ = quiet_head()
        one.faults.set('lost', how)
        for _ in range(packets):
            one.report('vendor')
        return one.faults.counts['lost'], one.faults.active

    def test_modes(self):
        for how, count, active in (('once', 1, []), ('always', 1000, ['lost']), ('5', 5, []),
                                   (7, 7, []), ('off', 0, []), ('1/1', 1000, ['lost'])):
            with row(how):
                assert self.happened(how) == (count, active)

    def test_at_random(self):
        count, active = self.happened('1/10')
        assert 50 < count < 200, count
        assert active == ['lost']

    def test_off_and_clear(self):
        one, ear = quiet_head()
        one.faults.set('lost', 'always')
        one.faults.set('noise', 'always')
        one.faults.set('lost', 'off')
        assert one.faults.active == ['noise']
        one.faults.clear()
        one.report('vendor')
        assert ear.heard == wire.vendor('Virtual')

    def test_wrong(self):
        for kind, how in (('fire', 'once'), ('lost', ''), ('lost', '0'), ('lost', '-1'),
                          ('lost', '1/0'), ('lost', '1/x'), ('lost', '2/3'), ('lost', '1.5')):
            with row(kind=kind, how=how), pytest.raises(ValueError):
                quiet_head()[0].faults.set(kind, how)

    def test_seed(self):
        def heard(seed):
            one, ear = quiet_head(seed=seed)
            for kind in faults.KINDS:
                one.faults.set(kind, '1/3')
            for _ in range(50):
                one.report()
            return ear.heard
        assert heard(1) == heard(1)
        assert heard(1) != heard(2)


class TestFaultKinds(Case):
    """Each kind, on each of PACKETS, many times: the data sent, and the result of a receiver."""

    at = 'no row'

    def sent(self, kind, packet, seed):
        """-> the data sent instead of the packet, the decoder after it, the counts"""
        one, ear = quiet_head(seed=seed)
        decoder = wire.Decoder()
        one.report('sync', 'vendor')
        decoder.feed(ear.take())
        one.faults.set(kind, 'once')
        one.send(packet)
        data = ear.take()
        self.got = decoder.feed(data)
        counts = one.counts()
        assert counts['faults'] == {name: int(name == kind) for name in faults.KINDS}
        assert counts['receiver'] == decoder.counts()
        one.send(packet)
        assert ear.take() == packet        # the next one is correct again
        return data, decoder, counts

    def every(self, kind):
        for name, packet in PACKETS.items():
            for seed in range(40):
                self.at = '%s, seed %d' % (name, seed)
                yield (packet, *self.sent(kind, packet, seed))

    def damaged(self, counts, size):
        assert (counts['damaged_packets'], counts['damaged_bytes']) == (1, size)

    def test_every_kind_is_here(self):
        names = {name[len('test_'):].replace('_', '-') for name in dir(self)}
        assert set(faults.KINDS) <= names

    def test_none(self):
        """Counterpart: without a fault all packets are received."""
        for name, packet in PACKETS.items():
            packets, decoder = decode(wire.sync() + packet + END)
            assert (len(packets), decoder.dropped, decoder.kept) == (3, 0, 0), name

    def test_lost(self):
        for packet, data, _, counts in self.every('lost'):
            assert data in [packet[:at] + packet[at + 1:] for at in range(len(packet))]
            self.damaged(counts, len(packet) - 1)

    def test_doubled(self):
        for packet, data, _, counts in self.every('doubled'):
            assert data in [packet[:at + 1] + packet[at:] for at in range(len(packet))]
            self.damaged(counts, len(packet) + 1)

    def test_flipped(self):
        bits = set()
        for packet, data, _, counts in self.every('flipped'):
            assert len(data) == len(packet)
            changes = [a ^ b for a, b in zip(packet, data) if a != b]
            bits.update(changes)
            assert [bin(change).count('1') for change in changes] == [1]
            self.damaged(counts, len(packet))
        assert bits == {1 << bit for bit in range(8)}

    def test_torn(self):
        for packet, data, decoder, counts in self.every('torn'):
            assert packet.startswith(data) and 0 < len(data) < len(packet)
            assert (decoder.kept, decoder.dropped) == (len(data), 0)
            self.damaged(counts, len(data))

    def test_length(self):
        for packet, data, decoder, counts in self.every('length'):
            assert (data[:2], data[3:]) == (packet[:2], packet[3:])
            assert data[2] != packet[2]
            assert (decoder.bad_lengths > 0) == (packet[1] in wire.LENGTHS)
            self.damaged(counts, len(packet))

    def test_noise(self):
        for packet, data, decoder, counts in self.every('noise'):
            assert data.endswith(packet)
            assert 1 <= counts['noise_bytes'] == len(data) - len(packet) <= 16
            assert not (decoder.in_sync and not decoder.resyncs)
            assert counts['damaged_packets'] == 0
        for seed in range(2000):                        # it always breaks sync
            assert faults.Faults(seed)._noise()[0] != wire.START

    def test_unknown(self):
        kinds = set()
        for packet, data, decoder, counts in self.every('unknown'):
            kinds.add(data[1])
            assert data[1] not in wire.LENGTHS
            assert data[3 + data[2]:] == packet
            assert (counts['packets'], len(self.got), decoder.dropped) == (4, 2, 0)
        assert len(kinds) > 25

    def test_false_sync(self):
        for packet, data, decoder, counts in self.every('false-sync'):
            assert wire.RESYNC in data[3:-len(packet)]
            assert (len(self.got), decoder.dropped, decoder.resyncs) == (2, 0, 0)
            assert counts['by_type']['debug'] == 1 + (packet[1] == wire.DEBUG)

    def test_trap(self):
        for packet, data, decoder, counts in self.every('trap'):
            assert data.endswith(packet)
            assert (decoder.resyncs, decoder.bad_lengths) == (1, 1)    # lost sync, and recovered
            assert decoder.syncs == 2
            assert counts['by_type']['sync'] == 1 + (packet[1] == wire.SYNC)
            self.damaged(counts, len(data) - len(packet))

    def test_silence(self):
        for _, data, _, counts in self.every('silence'):
            assert (data, counts['swallowed_packets']) == (b'', 1)

    def test_burst(self):
        for packet, data, decoder, counts in self.every('burst'):
            assert data == packet * 50
            assert (counts['packets'], len(self.got), decoder.dropped) == (52, 50, 0)

    def test_wrong_rate(self):
        for _, data, decoder, counts in self.every('wrong-rate'):
            assert wire.START not in data
            assert (decoder.in_sync, decoder.dropped) == (False, len(data))
            assert (counts['garbled_packets'], counts['garbled_bytes']) == (1, len(data))

    def test_sync_heals_each(self):
        """Two syncs after a fault a receiver is in sync, unless the fault starts a long packet."""
        for kind in faults.KINDS:
            for packet, data, decoder, _ in self.every(kind):
                decoder.feed(bytes(256))            # ends any packet that was started
                assert decoder.feed(wire.sync() + END)[-1] == (wire.ERRORS, END[3:])


class TestCounts(Case):
    def check(self, one, ear):
        """The counts equal the data on the wire, with any faults."""
        counts = one.counts()
        assert counts['bytes'] == len(ear.heard)
        assert counts['bytes'] == counts['packet_bytes'] + counts['damaged_bytes'] + \
                         counts['noise_bytes'] + counts['garbled_bytes']
        assert counts['packets'] == sum(counts['by_type'].values())
        assert counts['receiver'] == decode(ear.heard)[1].counts()
        return counts

    def test_all_faults_at_once(self):
        one, ear = quiet_head()
        for kind in faults.KINDS:
            one.faults.set(kind, '1/20')
        for _ in range(300):
            one.report()
        one.send_raw(b'rubbish')
        counts = self.check(one, ear)
        for kind in faults.KINDS:
            assert counts['faults'][kind] > 10, kind

    def test_zero(self):
        one, ear = quiet_head()
        one.report()
        one.forget_counts()
        one.report('vendor')
        counts = one.counts()
        assert (counts['packets'], counts['bytes']) == (1, 10)
        assert counts['receiver'] == decode(ear.heard)[1].counts()

    def test_rate_of_the_uart(self):
        one, ear = quiet_head()
        for uart, garbled in ((None, 0), (115200, 0), (57600, 1), (921600, 2), (0, 3), (115200, 3)):
            ear.uart = uart
            one.report('vendor')
            assert one.counts()['garbled_packets'] == garbled
        one.set_rate(57600)
        one.report('vendor')
        assert self.check(one, ear)['garbled_packets'] == 4

    def test_streams(self):
        for name, packets, size in (('one', 1, 0), ('a few', 13, 0), ('many', 100001, 0),
                                    ('one byte', 0, 1), ('bytes', 0, 999983)):
            with row(name):
                one, ear = quiet_head()
                for _ in one.stream(packets, size):
                    pass
                counts = self.check(one, ear)
                if packets:
                    assert counts['packets'] == packets
                else:
                    assert size <= counts['bytes'] < size + 258
                assert counts['receiver']['packets'] + (counts['receiver']['kept'] > 0) == \
                                 counts['packets']
                assert counts['receiver']['dropped'] == 0

    def test_a_stream_has_all_types(self):
        one, ear = quiet_head()
        for _ in one.stream(11):
            pass
        assert {kind for kind, _ in decode(ear.heard)[0]} == set(wire.LENGTHS)

    def test_blocks_are_what_single_packets_are(self):
        one, ear = quiet_head()
        other, other_ear = quiet_head()
        other._clear = lambda: False
        for a_head in (one, other):
            for _ in a_head.stream(20000):
                pass
        assert ear.heard == other_ear.heard
        assert one.counts() == other.counts()

    def test_a_stream_with_faults(self):
        one, ear = quiet_head()
        one.faults.set('lost', '1/100')
        one.faults.set('noise', '1/100')
        for _ in one.stream(20000):
            pass
        counts = self.check(one, ear)
        assert counts['packets'] + counts['damaged_packets'] == 20000
        assert counts['receiver']['resyncs'] > 100

    def test_a_fault_in_the_middle_of_a_stream(self):
        one, ear = quiet_head()
        for step, _ in enumerate(one.stream(50000)):
            if step == 5:
                one.faults.set('torn', 'once')
        counts = self.check(one, ear)
        assert (counts['packets'], counts['damaged_packets']) == (49999, 1)
