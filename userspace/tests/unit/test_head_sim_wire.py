# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xy3-head-sim, the format: tables, packets, frames, and the decoder."""

import os
import random
import sys
import pytest
import case


sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)),
                                '..', '..', 'xy3-head-sim'))

from xy3_head_sim import wire  # noqa: E402 (the path has to be set first)

SYNC = bytes.fromhex('484100')
# type, minimum, maximum and step of its length
LENGTHS = (
    ('vendor', 0x01, 3, 200, 1), ('model', 0x02, 3, 200, 1), ('firmware', 0x03, 3, 200, 1),
    ('serial', 0x04, 3, 200, 1), ('temperatures', 0x05, 2, 44, 2),
    ('frame_errors', 0x06, 20, 20, 1), ('errors', 0x07, 1, 22, 1), ('debug', 0x08, 3, 200, 1),
    ('hours', 0x09, 4, 88, 4), ('sync', 0x41, 0, 0, 1),
)


class TestTables(case.Case):
    def test_types(self):
        assert wire.TYPES == {name: number for name, number, *_ in LENGTHS}

    def test_lengths(self):
        for name, number, least, most, step in LENGTHS:
            legal = {length for length in range(256)
                     if least <= length <= most and (length - least) % step == 0}
            assert {length for length in range(256) if length in wire.LENGTHS[number]} == \
                             legal, name

    def test_components(self):
        assert len(wire.COMPONENTS) == 22
        for index, name in ((0, 'head'), (1, 'dsp'), (2, 'dac_x'), (6, 'dac_w'),
                            (7, 'driver_x'), (12, 'galvo_x'), (14, 'galvo_z'),
                            (17, 'mirror_x'), (21, 'mirror_w')):
            assert wire.COMPONENTS[index] == name

    def test_errors(self):
        for code, name in enumerate(('none', 'temperature', 'data', 'range', 'power',
                                     'electrical', 'adjustment', 'mechanical')):
            assert (wire.error_code(name), wire.error_name(code)) == (code, name)
        assert [wire.error_name(code) for code in (8, 100, 255)] == ['8', '100', '255']

    def test_axes(self):
        assert [wire.axis_mask(axes) for axes in ('x', 'w', 'xz', 'xx', '', 'all')] == \
                         [1, 16, 5, 1, 0, 0]

    def test_rates_have_commands(self):
        assert {name for name in wire.COMMANDS if name.startswith('rate')} == \
                         {'rate %d' % rate for rate in wire.RATES}


class TestPackets(case.Case):
    def check(self, packet, wanted):
        assert packet.hex(' ') == wanted

    def test_by_hand(self):
        self.check(wire.vendor('abc'), '48 01 03 61 62 63')
        self.check(wire.model(b'a\0\xff'), '48 02 03 61 00 ff')
        self.check(wire.firmware('1.0'), '48 03 03 31 2e 30')
        self.check(wire.serial('123'), '48 04 03 31 32 33')
        self.check(wire.temperatures([2550, None, -1]), '48 05 06 f6 09 01 80 ff ff')
        self.check(wire.temperatures([2550, None], 'big'), '48 05 04 09 f6 80 01')
        self.check(wire.frame_errors([1, 0, 0, 0, 0x01020304]),
                   '48 06 14 01 00 00 00' + ' 00' * 12 + ' 04 03 02 01')
        self.check(wire.errors(['none', 'mechanical', 200]), '48 07 03 00 07 c8')
        self.check(wire.debug('dbg'), '48 08 03 64 62 67')
        self.check(wire.hours([258, None], 'big'), '48 09 08 00 00 01 02 ff ff ff ff')
        self.check(wire.sync(), '48 41 00')
        self.check(wire.packet(0x20), '48 20 00')
        self.check(wire.packet('errors', bytes(23)), '48 07 17' + ' 00' * 23)

    def test_illegal(self):
        for name, call in (
                ('short text', lambda: wire.vendor('ab')),
                ('long text', lambda: wire.debug('x' * 201)),
                ('no temperature', lambda: wire.temperatures([])),
                ('too many temperatures', lambda: wire.temperatures([0] * 23)),
                ('temperature too high', lambda: wire.temperatures([32768])),
                ('four axes', lambda: wire.frame_errors([0] * 4)),
                ('six axes', lambda: wire.frame_errors([0] * 6)),
                ('no error', lambda: wire.errors([])), ('code', lambda: wire.errors([256])),
                ('name', lambda: wire.errors(['fire'])), ('hours', lambda: wire.hours([-1])),
                ('payload', lambda: wire.packet(1, bytes(256))),
                ('type', lambda: wire.packet(256))):
            with case.row(name), pytest.raises(ValueError):
                call()

    def test_unpack_reverses(self):
        for order in ('little', 'big'):
            for kind, build, values in (
                    (wire.TEMPERATURES, wire.temperatures, [0, None, 32767, -32768]),
                    (wire.HOURS, wire.hours, [0, None, 0xFFFFFFFE]),
                    (wire.FRAME_ERRORS, wire.frame_errors, [1, 2, 3, 4, 0xFFFFFFFF])):
                packet = build(values, order)
                assert wire.unpack(kind, packet[3:], order) == values
        assert wire.unpack(wire.ERRORS, b'\0\7\xc8') == [0, 7, 200]
        assert wire.unpack(wire.SERIAL, b'123') == b'123'
        assert wire.unpack(wire.SYNC, b'') is None


class TestFrames(case.Case):
    def test_by_hand(self):
        for name, frame, wanted in (
                ('autocalib of X and Z', wire.command_frame('autocalib on', 'xz'), '200017'),
                ('all axes', wire.command_frame('reference', 'all'), '080001'),
                ('compensation off', wire.command_frame('temp_comp off', 'w'), '120043'),
                ('rate, 32 bit', wire.command_frame('rate 921600', bits=32), '80d00003'),
                ('position 0', wire.position_frame(0), 'c0000000'),
                ('last position', wire.position_frame((1 << 26) - 1), 'fffffffa'),
                ('24 bit', wire.position_frame(1, bits=24), '400005')):
            with case.row(name):
                assert frame.hex() == wanted

    def test_too_wide(self):
        for call in (lambda: wire.command_frame(1 << 20), lambda: wire.position_frame(1 << 26),
                     lambda: wire.position_frame(1 << 20, bits=24)):
            with pytest.raises(ValueError):
                call()


# Bytes from the start, and the expected packets, dropped, kept, bad lengths, resyncs, in sync.
ROWS = (
    ('nothing', '', [], 0, 0, 0, 0, False),
    ('sync and the next start', '48 41 00 48', ['41'], 0, 1, 0, 0, True),
    ('three bytes of it', '48 41 00', [], 0, 3, 0, 0, False),
    ('a sync that nothing follows', '48 41 00 00', [], 4, 0, 0, 0, False),
    ('rubbish before', '00 ff 41 00 48 41 00 48', ['41'], 4, 1, 0, 0, True),
    ('48 twice', '48 48 41 00 48', ['41'], 1, 1, 0, 0, True),
    ('48 41 twice', '48 41 48 41 00 48', ['41'], 2, 1, 0, 0, True),
    ('48 41 00 twice', '48 41 00 48 41 00 48', ['41', '41'], 0, 1, 0, 0, True),
    ('half of it, then rubbish', '48 41 01 48 41 00 48', ['41'], 3, 1, 0, 0, True),
    ('a packet before the first sync', '48 07 01 00 48 41 00 48', ['41'], 4, 1, 0, 0, True),
    ('sync and a packet', '48 41 00 48 07 01 05', ['41', '07 05'], 0, 0, 0, 0, True),
    ('half a packet', '48 41 00 48 07 02 05', ['41'], 0, 4, 0, 0, True),
    ('no start after a packet', '48 41 00 48 07 01 05 00', ['41', '07 05'], 1, 0, 0, 0, False),
    ('the sequence follows the byte that broke sync',
     '48 41 00 48 07 01 05 00 48 41 00 48', ['41', '07 05', '41'], 1, 1, 0, 1, True),
    ('an illegal length', '48 41 00 48 07 17', ['41'], 3, 0, 1, 0, False),
    ('sync with a payload', '48 41 00 48 41 01', ['41'], 3, 0, 1, 0, False),
    ('sync found in type and length', '48 41 00 48 07 48 41 00 48', ['41', '41'], 2, 1, 1, 1, True),
    ('48 twice in sync is an unknown type', '48 41 00 48 48 02 aa bb 48', ['41', '48 aa bb'],
     0, 1, 0, 0, True),
    ('an odd number of bytes', '48 41 00 48 05 03 01 02 03', ['41'], 6, 0, 1, 0, False),
    ('unknown type, no payload', '48 41 00 48 20 00 48', ['41', '20'], 0, 1, 0, 0, True),
    ('unknown type with sync in it', '48 41 00 48 20 04 48 41 00 48 48 41 00',
     ['41', '20 48 41 00 48', '41'], 0, 0, 0, 0, True),
    ('known type with sync in it', '48 41 00 48 08 04 48 41 00 48 48 41 00',
     ['41', '08 48 41 00 48', '41'], 0, 0, 0, 0, True),
    ('false sync, out of sync', '08 04 48 41 00 48 05 ff 48 41 00 48',
     ['41', '41'], 5, 1, 1, 1, True),
    ('unknown type of 255 bytes', '48 41 00 48 0a ff' + ' 48' * 255 + ' 48 41 00',
     ['41', '0a' + ' 48' * 255, '41'], 0, 0, 0, 0, True),
)


def texts(packets):
    return [bytes((kind, *payload)).hex(' ') for kind, payload in packets]


class TestDecoding(case.Case):
    def check(self, decoder, packets, row):
        _, text, wanted, dropped, kept, bad, resyncs, in_sync = row
        assert texts(packets) == wanted
        assert (decoder.dropped, decoder.kept, decoder.bad_lengths, decoder.resyncs,
                          decoder.in_sync) == (dropped, kept, bad, resyncs, in_sync)
        assert decoder.packets == len(wanted)
        assert decoder.packet_bytes + decoder.dropped + decoder.kept == \
                         len(bytes.fromhex(text))

    def test_rows(self):
        for row in ROWS:
            with case.row(row[0]):
                decoder = wire.Decoder()
                self.check(decoder, decoder.feed(bytes.fromhex(row[1])), row)

    def test_rows_at_every_split(self):
        for row in ROWS:
            data = bytes.fromhex(row[1])
            for at in range(len(data) + 1):
                with case.row(row[0], at=at):
                    decoder = wire.Decoder()
                    packets = decoder.feed(data[:at]) + decoder.feed(data[at:])
                    self.check(decoder, packets, row)

    def test_rows_byte_by_byte(self):
        for row in ROWS:
            with case.row(row[0]):
                decoder = wire.Decoder()
                packets = [packet for byte in bytes.fromhex(row[1])
                           for packet in decoder.feed(bytes((byte,)))]
                self.check(decoder, packets, row)

    def test_every_length_of_every_type(self):
        for kind in range(256):
            for length in range(256):
                decoder = wire.Decoder()
                packet = bytes((0x48, kind, length)) + bytes(length)
                packets = decoder.feed(SYNC + packet)
                if length in wire.LENGTHS.get(kind, range(256)):
                    assert packets[1:] == [(kind, bytes(length))]
                    assert (decoder.dropped, decoder.kept) == (0, 0)
                    assert decoder.unknown == (kind not in wire.LENGTHS)
                else:
                    assert packets[1:] == []
                    assert (decoder.bad_lengths, decoder.in_sync) == (1, False)

    def test_line_error(self):
        decoder = wire.Decoder()
        decoder.feed(SYNC + wire.errors([1]) + wire.errors([1, 2])[:4])
        decoder.lost(2)
        assert (decoder.dropped, decoder.kept, decoder.in_sync) == (6, 0, False)
        assert decoder.feed(wire.errors([3])) == []
        assert len(decoder.feed(SYNC + wire.errors([3]))) == 2
        assert (decoder.dropped, decoder.resyncs) == (10, 1)

    def test_line_error_in_the_sequence(self):
        decoder = wire.Decoder()
        decoder.feed(b'\x48\x41')
        decoder.lost(0)
        assert decoder.feed(b'\0\x48') == []
        assert (decoder.dropped, decoder.kept, decoder.resyncs) == (3, 1, 0)

    def test_lost_before_the_first_sync_is_no_resync(self):
        decoder = wire.Decoder()
        decoder.lost(1)
        decoder.feed(SYNC + SYNC)
        assert (decoder.resyncs, decoder.in_sync, decoder.syncs) == (0, True, 2)

    def test_random_streams(self):
        """The invariant, and the same result for all ways to split the bytes."""
        rng = random.Random(3)
        for number in range(3000):
            data = b''.join(rng.choice((
                SYNC, SYNC + b'\x48', wire.vendor('abc'), wire.errors([1, 2]), b'\x48\x41', b'\x48',
                wire.packet(0x20, SYNC + b'\x48'), rng.randbytes(rng.randrange(8)),
                wire.packet(rng.randrange(256), bytes(rng.randrange(5)))))
                for _ in range(rng.randrange(20)))
            whole, pieces = wire.Decoder(), wire.Decoder()
            wanted, got, at = whole.feed(data), [], 0
            while at < len(data):
                size = rng.randint(1, 9)
                got += pieces.feed(data[at:at + size])
                at += size
                assert pieces.packet_bytes + pieces.dropped + pieces.kept == \
                                 min(at, len(data))
            assert (got, pieces.counts()) == (wanted, whole.counts()), number

    def test_a_long_stream_loses_nothing(self):
        packets = [wire.sync(), wire.vendor('abc'), wire.temperatures([1] * 22),
                   wire.packet(0xFF, bytes(255)), wire.hours([4] * 22)]
        decoder = wire.Decoder()
        decoder.feed(b''.join(packets) * 5000)
        assert (decoder.packets, decoder.dropped, decoder.unknown, decoder.syncs) == \
                         (25000, 0, 5000, 5000)
