#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xy3-head-sim, the head: telemetry, times, faults, counts, streams."""

import math
import os
import sys
import unittest


sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)),
                                '..', '..', 'xy3-head-sim'))

from xy3_head_sim import faults, head, wire  # noqa: E402 (the path has to be set first)

PACKETS = {
    'vendor': wire.vendor('abcdef'), 'temperatures': wire.temperatures([1, 2, 3]),
    'errors': wire.errors([1]), 'hours': wire.hours([1, 2]), 'debug': wire.debug('x' * 200),
    'frame_errors': wire.frame_errors([1, 2, 3, 4, 5]), 'sync': wire.sync(),
    'unknown': wire.packet(0x20, b'12345'), 'empty unknown': wire.packet(0x21),
}
END = wire.errors([7] * 22)         # sent after a fault, to see whether it is seen


class Ear(head.NoLine):
    """A line that keeps what is sent on it."""

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
    """A head that says nothing by itself, and its line."""
    ear = Ear()
    return head.Head(ear, interval=0, sync_interval=0, **options), ear


def decode(data):
    decoder = wire.Decoder()
    return decoder.feed(data), decoder


class Telemetry(unittest.TestCase):
    def setUp(self):
        self.head, self.ear = quiet_head()

    def say(self, *names):
        self.head.report(*names)
        return self.ear.take()

    def test_a_round(self):
        packets, decoder = decode(self.say())
        self.assertEqual([wire.TYPE_NAMES[kind] for kind, _ in packets], [
            'sync', 'vendor', 'model', 'firmware', 'serial', 'temperatures', 'errors', 'hours',
            'frame_errors', 'sync'])
        self.assertEqual((decoder.dropped, decoder.kept), (0, 0))
        values = {wire.TYPE_NAMES[kind]: wire.unpack(kind, payload) for kind, payload in packets}
        self.assertEqual(values['serial'], b'SIM-0001')
        self.assertEqual(values['temperatures'][:3] + values['temperatures'][-2:],
                         [3150, 4425, None, 3675, 3650])
        self.assertEqual(values['errors'], [0] * 22)
        self.assertEqual((values['hours'][0], values['hours'][2]), (1200, None))
        self.assertEqual(values['frame_errors'], [0] * 5)

    def test_identity(self):
        self.head.set_text('vendor', 'Other')
        self.head.set_text('serial', None)
        self.assertEqual(self.say('vendor', 'serial'), wire.vendor('Other'))

    def test_temperature(self):
        self.head.set_temperature('mirror_w', -40.125)
        values = wire.unpack(wire.TEMPERATURES, self.say('temperatures')[3:])
        self.assertEqual((len(values), values[21]), (22, -4012))

    def test_error(self):
        self.head.set_error('dac_y', 'temperature')
        self.head.set_error('mirror_w', 255)
        values = self.say('errors')[3:]
        self.assertEqual((values[3], values[21], sum(values)), (1, 255, 256))

    def test_absent_ones_shorten_an_array(self):
        for name in wire.COMPONENTS[2:]:
            self.head.set_temperature(name, None)
            self.head.set_hours(name, None)
            self.head.set_error(name, None)
        self.head.set_error('head', None)
        self.assertEqual(self.say('temperatures')[2], 4)
        self.assertEqual(self.say('hours')[2], 8)
        self.assertEqual(self.say('errors'), wire.errors([0, 0]))

    def test_nothing_to_report(self):
        for name in wire.COMPONENTS:
            self.head.set_temperature(name, None)
        self.head.frame_errors = None
        self.assertEqual(self.say('temperatures', 'frame_errors'), b'')
        self.head.set_frame_errors('w', 5)
        self.assertEqual(self.say('frame_errors'), wire.frame_errors([0, 0, 0, 0, 5]))

    def test_big_endian(self):
        self.head.set_order('big')
        self.head.set_hours('head', 258)
        self.assertEqual(self.say('hours')[3:7], b'\0\0\1\2')
        self.assertEqual(self.say('temperatures')[3:5], (3150).to_bytes(2, 'big'))
        self.head.set_frame_errors('x', 1)
        self.assertEqual(self.say('frame_errors')[3:7], b'\0\0\0\1')

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
            with self.subTest(name), self.assertRaises(ValueError):
                call()


class Times(unittest.TestCase):
    def test_intervals(self):
        ear = Ear()
        one = head.Head(ear, interval=1.0, sync_interval=0.25)
        now, calls = 100.0, 0
        while now < 110:
            now = one.tick(now)
            calls += 1
        counts = one.counts()['by_type']
        self.assertEqual(counts['vendor'], 10)
        self.assertEqual(counts['sync'], 10 * 2 + 40)
        self.assertLess(calls, 60)

    def test_no_intervals(self):
        one, ear = quiet_head()
        self.assertEqual(one.tick(100.0), math.inf)
        self.assertEqual(ear.heard, b'')

    def test_a_host_that_does_not_read(self):
        ear = Ear()
        ear.pending = head.BACKLOG
        one = head.Head(ear, interval=1.0)
        one.tick(100.0)
        self.assertEqual((ear.heard, one.counts()['held_back']), (b'', 2))

    def test_nobody_listens(self):
        one, ear = quiet_head()
        ear.is_open = False
        one.report('vendor')
        one.send_raw(b'1')
        self.assertEqual(one.tick(100.0), math.inf)
        self.assertEqual((ear.heard, one.counts()['unheard_packets'], one.counts()['bytes']),
                         (b'', 1, 0))

    def test_silence(self):
        one, ear = quiet_head()
        one.silence(math.inf)
        one.report('vendor', 'model')
        one.send_raw(b'1')
        self.assertEqual((ear.heard, one.counts()['swallowed_packets']), (b'', 2))
        one.silence(0)
        one.report('vendor')
        self.assertEqual(ear.heard, wire.vendor('Virtual'))


class FaultModes(unittest.TestCase):
    def happened(self, how, packets=1000):
        one, _ = quiet_head()
        one.faults.set('lost', how)
        for _ in range(packets):
            one.report('vendor')
        return one.faults.counts['lost'], one.faults.active

    def test_modes(self):
        for how, count, active in (('once', 1, []), ('always', 1000, ['lost']), ('5', 5, []),
                                   (7, 7, []), ('off', 0, []), ('1/1', 1000, ['lost'])):
            with self.subTest(how):
                self.assertEqual(self.happened(how), (count, active))

    def test_at_random(self):
        count, active = self.happened('1/10')
        self.assertTrue(50 < count < 200, count)
        self.assertEqual(active, ['lost'])

    def test_off_and_clear(self):
        one, ear = quiet_head()
        one.faults.set('lost', 'always')
        one.faults.set('noise', 'always')
        one.faults.set('lost', 'off')
        self.assertEqual(one.faults.active, ['noise'])
        one.faults.clear()
        one.report('vendor')
        self.assertEqual(ear.heard, wire.vendor('Virtual'))

    def test_wrong(self):
        for kind, how in (('fire', 'once'), ('lost', ''), ('lost', '0'), ('lost', '-1'),
                          ('lost', '1/0'), ('lost', '1/x'), ('lost', '2/3'), ('lost', '1.5')):
            with self.subTest(kind=kind, how=how), self.assertRaises(ValueError):
                quiet_head()[0].faults.set(kind, how)

    def test_seed(self):
        def heard(seed):
            one, ear = quiet_head(seed=seed)
            for kind in faults.KINDS:
                one.faults.set(kind, '1/3')
            for _ in range(50):
                one.report()
            return ear.heard
        self.assertEqual(heard(1), heard(1))
        self.assertNotEqual(heard(1), heard(2))


class FaultKinds(unittest.TestCase):
    """Each kind, on each of PACKETS, many times: what is sent, and what a receiver makes of it."""

    at = 'no row'

    def sent(self, kind, packet, seed):
        """-> what is sent instead of the packet, the decoder when it has got it, the counts"""
        one, ear = quiet_head(seed=seed)
        decoder = wire.Decoder()
        one.report('sync', 'vendor')
        decoder.feed(ear.take())
        one.faults.set(kind, 'once')
        one.send(packet)
        data = ear.take()
        self.got = decoder.feed(data)
        counts = one.counts()
        self.assertEqual(counts['faults'], {name: int(name == kind) for name in faults.KINDS})
        self.assertEqual(counts['receiver'], decoder.counts())
        one.send(packet)
        self.assertEqual(ear.take(), packet)        # the next one is sound again
        return data, decoder, counts

    def every(self, kind):
        for name, packet in PACKETS.items():
            for seed in range(40):
                self.at = '%s, seed %d' % (name, seed)
                yield (packet, *self.sent(kind, packet, seed))

    def _formatMessage(self, msg, standard):        # unittest calls it for every failure
        return '%s: %s' % (self.at, super()._formatMessage(msg, standard))

    def damaged(self, counts, size):
        self.assertEqual((counts['damaged_packets'], counts['damaged_bytes']), (1, size))

    def test_every_kind_is_here(self):
        names = {name[len('test_'):].replace('_', '-') for name in dir(self)}
        self.assertLessEqual(set(faults.KINDS), names)

    def test_none(self):
        """The control: without a fault every packet arrives."""
        for name, packet in PACKETS.items():
            packets, decoder = decode(wire.sync() + packet + END)
            self.assertEqual((len(packets), decoder.dropped, decoder.kept), (3, 0, 0), name)

    def test_lost(self):
        for packet, data, _, counts in self.every('lost'):
            self.assertIn(data, [packet[:at] + packet[at + 1:] for at in range(len(packet))])
            self.damaged(counts, len(packet) - 1)

    def test_doubled(self):
        for packet, data, _, counts in self.every('doubled'):
            self.assertIn(data, [packet[:at + 1] + packet[at:] for at in range(len(packet))])
            self.damaged(counts, len(packet) + 1)

    def test_flipped(self):
        bits = set()
        for packet, data, _, counts in self.every('flipped'):
            self.assertEqual(len(data), len(packet))
            changes = [a ^ b for a, b in zip(packet, data) if a != b]
            bits.update(changes)
            self.assertEqual([bin(change).count('1') for change in changes], [1])
            self.damaged(counts, len(packet))
        self.assertEqual(bits, {1 << bit for bit in range(8)})

    def test_torn(self):
        for packet, data, decoder, counts in self.every('torn'):
            self.assertTrue(packet.startswith(data) and 0 < len(data) < len(packet))
            self.assertEqual((decoder.kept, decoder.dropped), (len(data), 0))
            self.damaged(counts, len(data))

    def test_length(self):
        for packet, data, decoder, counts in self.every('length'):
            self.assertEqual((data[:2], data[3:]), (packet[:2], packet[3:]))
            self.assertNotEqual(data[2], packet[2])
            self.assertEqual(decoder.bad_lengths > 0, packet[1] in wire.LENGTHS)
            self.damaged(counts, len(packet))

    def test_noise(self):
        for packet, data, decoder, counts in self.every('noise'):
            self.assertTrue(data.endswith(packet))
            self.assertTrue(1 <= counts['noise_bytes'] == len(data) - len(packet) <= 16)
            self.assertFalse(decoder.in_sync and not decoder.resyncs)
            self.assertEqual(counts['damaged_packets'], 0)
        for seed in range(2000):                        # it always breaks sync
            self.assertNotEqual(faults.Faults(seed)._noise()[0], wire.START)

    def test_unknown(self):
        kinds = set()
        for packet, data, decoder, counts in self.every('unknown'):
            kinds.add(data[1])
            self.assertNotIn(data[1], wire.LENGTHS)
            self.assertEqual(data[3 + data[2]:], packet)
            self.assertEqual((counts['packets'], len(self.got), decoder.dropped), (4, 2, 0))
        self.assertGreater(len(kinds), 25)

    def test_false_sync(self):
        for packet, data, decoder, counts in self.every('false-sync'):
            self.assertIn(wire.RESYNC, data[3:-len(packet)])
            self.assertEqual((len(self.got), decoder.dropped, decoder.resyncs), (2, 0, 0))
            self.assertEqual(counts['by_type']['debug'], 1 + (packet[1] == wire.DEBUG))

    def test_trap(self):
        for packet, data, decoder, counts in self.every('trap'):
            self.assertTrue(data.endswith(packet))
            self.assertEqual((decoder.resyncs, decoder.bad_lengths), (1, 1))    # fell, and healed
            self.assertEqual(decoder.syncs, 2)
            self.assertEqual(counts['by_type']['sync'], 1 + (packet[1] == wire.SYNC))
            self.damaged(counts, len(data) - len(packet))

    def test_silence(self):
        for _, data, _, counts in self.every('silence'):
            self.assertEqual((data, counts['swallowed_packets']), (b'', 1))

    def test_burst(self):
        for packet, data, decoder, counts in self.every('burst'):
            self.assertEqual(data, packet * 50)
            self.assertEqual((counts['packets'], len(self.got), decoder.dropped), (52, 50, 0))

    def test_wrong_rate(self):
        for _, data, decoder, counts in self.every('wrong-rate'):
            self.assertNotIn(wire.START, data)
            self.assertEqual((decoder.in_sync, decoder.dropped), (False, len(data)))
            self.assertEqual((counts['garbled_packets'], counts['garbled_bytes']), (1, len(data)))

    def test_sync_heals_each(self):
        """Two syncs after a fault a receiver is back, if the fault has not opened a long packet."""
        for kind in faults.KINDS:
            for packet, data, decoder, _ in self.every(kind):
                decoder.feed(bytes(256))            # ends any packet that was opened
                self.assertEqual(decoder.feed(wire.sync() + END)[-1], (wire.ERRORS, END[3:]))


class Counts(unittest.TestCase):
    def check(self, one, ear):
        """Whatever happened: the counts are what was on the wire."""
        counts = one.counts()
        self.assertEqual(counts['bytes'], len(ear.heard))
        self.assertEqual(counts['bytes'], counts['packet_bytes'] + counts['damaged_bytes'] +
                         counts['noise_bytes'] + counts['garbled_bytes'])
        self.assertEqual(counts['packets'], sum(counts['by_type'].values()))
        self.assertEqual(counts['receiver'], decode(ear.heard)[1].counts())
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
            self.assertGreater(counts['faults'][kind], 10, kind)

    def test_zero(self):
        one, ear = quiet_head()
        one.report()
        one.forget_counts()
        one.report('vendor')
        counts = one.counts()
        self.assertEqual((counts['packets'], counts['bytes']), (1, 10))
        self.assertEqual(counts['receiver'], decode(ear.heard)[1].counts())

    def test_rate_of_the_uart(self):
        one, ear = quiet_head()
        for uart, garbled in ((None, 0), (115200, 0), (57600, 1), (921600, 2), (0, 3), (115200, 3)):
            ear.uart = uart
            one.report('vendor')
            self.assertEqual(one.counts()['garbled_packets'], garbled)
        one.set_rate(57600)
        one.report('vendor')
        self.assertEqual(self.check(one, ear)['garbled_packets'], 4)

    def test_streams(self):
        for name, packets, size in (('one', 1, 0), ('a few', 13, 0), ('many', 100001, 0),
                                    ('one byte', 0, 1), ('bytes', 0, 999983)):
            with self.subTest(name):
                one, ear = quiet_head()
                for _ in one.stream(packets, size):
                    pass
                counts = self.check(one, ear)
                if packets:
                    self.assertEqual(counts['packets'], packets)
                else:
                    self.assertTrue(size <= counts['bytes'] < size + 258)
                self.assertEqual(counts['receiver']['packets'] + (counts['receiver']['kept'] > 0),
                                 counts['packets'])
                self.assertEqual(counts['receiver']['dropped'], 0)

    def test_a_stream_has_all_types(self):
        one, ear = quiet_head()
        for _ in one.stream(11):
            pass
        self.assertEqual({kind for kind, _ in decode(ear.heard)[0]}, set(wire.LENGTHS))

    def test_blocks_are_what_single_packets_are(self):
        one, ear = quiet_head()
        other, other_ear = quiet_head()
        other._clear = lambda: False
        for a_head in (one, other):
            for _ in a_head.stream(20000):
                pass
        self.assertEqual(ear.heard, other_ear.heard)
        self.assertEqual(one.counts(), other.counts())

    def test_a_stream_with_faults(self):
        one, ear = quiet_head()
        one.faults.set('lost', '1/100')
        one.faults.set('noise', '1/100')
        for _ in one.stream(20000):
            pass
        counts = self.check(one, ear)
        self.assertEqual(counts['packets'] + counts['damaged_packets'], 20000)
        self.assertGreater(counts['receiver']['resyncs'], 100)

    def test_a_fault_in_the_middle_of_a_stream(self):
        one, ear = quiet_head()
        for step, _ in enumerate(one.stream(50000)):
            if step == 5:
                one.faults.set('torn', 'once')
        counts = self.check(one, ear)
        self.assertEqual((counts['packets'], counts['damaged_packets']), (49999, 1))
