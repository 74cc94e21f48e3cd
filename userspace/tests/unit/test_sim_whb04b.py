# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xhc-sim's WHB04B: its reports, its display frame, its LCD, its two buses.

CAPTURES are reports of real units. FRAMES are sent by a program that works with real units.
"""

import errno
import os
import socket
import struct
import threading
import time

import pytest

from busless_pendant import HB04, WHB04B, Bench, chunks, whb04b_frame
from case import Case, row
from xhc_sim import find, lcd, models, pendant, uhid, usb, whb04b

LIMIT = 20                  # timeout in seconds for expected events

CAPTURES = ['04 ba 00 00 0e 11 00 ba', '04 82 01 00 0e 12 00 81', '04 9d 00 00 0e 12 01 9c',
            '04 47 03 00 10 12 00 45', '04 10 00 00 1b 11 00 10']       # after frames with seed FEh

FRAMES = {
    'init_cleared': (
        ['06 fe fd fe 42 00 00 00', '06 00 00 00 00 00 00 00', '06 00 00 00 00 00 00 00'],
        ('0.0000', '0.0000', '0.0000', 0, 0, 'mpg', 1, 'machine')),
    'typical_machine_step': (
        ['06 fe fd fe 01 0c 00 7a', '06 0d 06 00 d2 9e 00 00', '06 0a 00 64 00 50 00 00'],
        ('12.3450', '-6.7890', '0.0010', 100, 80, 'step', 0, 'machine')),
    'minus_half': (
        ['06 fe fd fe 81 00 00 88', '06 93 00 00 88 13 00 00', '06 04 80 64 00 64 00 00'],
        ('-0.5000', '0.5000', '-0.0004', 100, 100, 'step', 0, 'work')),
    'four_decimals_kept': (
        ['06 fe fd fe 03 01 00 29', '06 09 01 00 29 89 02 00', '06 00 00 78 00 32 00 00'],
        ('1.2345', '-1.2345', '2.0000', 120, 50, 'percent', 0, 'machine')),
}
FIELDS = ('row1', 'row2', 'row3', 'feedrate_override', 'spindle_override', 'mode', 'reset',
          'coordinates')

AXES = {'x': 0x11, 'y': 0x12, 'z': 0x13, 'a': 0x14, 'b': 0x15, 'c': 0x16}
FEEDS = {'2%': 0x0D, '5%': 0x0E, '10%': 0x0F, '30%': 0x10, '60%': 0x1A, '100%': 0x1B}


def check(r, key, seed):
    """(~r + key1) XOR (s OR ~r), with complements as subtractions, and no OR."""
    return ((key - r - 1) % 256) ^ (255 - (r & (255 - seed)))


class TestModel(Case):
    def test_row(self):
        assert models.get_model('whb04b') is WHB04B
        assert (WHB04B.product, WHB04B.frame_size, WHB04B.chunks) == (0xEB93, 21, 3)
        assert (WHB04B.input_size, WHB04B.packet_size, WHB04B.interval) == (8, 8, 2)

    def test_report_descriptor(self):
        assert WHB04B.report_descriptor.hex() == (
            '0600ff0901a1018504090115002600ff750895078102c0'
            '0600ff0901a1018506090115002600ff75089507b106c0')

    def test_keys(self):
        assert sorted(WHB04B.keys) == list(range(0x01, 0x11))
        for code, name in ((1, 'Reset'), (3, 'Start/Pause'), (4, 'Feed+'), (5, 'Feed-'),
                           (0x0B, 'Spindle on/off'), (0x0C, 'Fn'), (0x0F, 'Step'),
                           (0x10, 'Macro 10')):
            assert WHB04B.key_code(name) == code

    def test_keys_with_fn(self):
        assert WHB04B.key_codes('Fn+Stop') == [0x0C, 2]
        assert WHB04B.key_codes('fn + feed+') == [0x0C, 4]
        assert WHB04B.key_codes('Feed+') == [4]
        assert WHB04B.key_codes('Fn') == [0x0C]
        assert HB04.key_codes('Stop') == [0x16]
        for model, bad in ((WHB04B, 'Fn+'), (WHB04B, 'Stop+Fn'), (HB04, 'Fn+Stop')):
            with pytest.raises(ValueError):
                model.key_codes(bad)

    def test_rotaries(self):
        assert WHB04B.selector == {'off': 0x06, **AXES}
        assert WHB04B.feed == {**FEEDS, 'lead': 0x1C}
        assert WHB04B.feed_code('30%') == 0x10
        assert WHB04B.feed_code('0x9b') == 0x9B
        assert (WHB04B.feed_name(0x1A), WHB04B.feed_name(0x9A)) == ('60%', '0x9a')
        for model, bad in ((WHB04B, '7%'), (WHB04B, '256'), (HB04, '2%')):
            with pytest.raises(ValueError):
                model.feed_code(bad)


class TestReports(Case):
    def set_up(self):
        self.bench = Bench('WHB04B')
        self.bench.plug()
        self.add_cleanup(self.bench.unplug)
        self.pendant = self.bench.pendant

    def last(self):
        return self.bench.reports[-1]

    @pytest.mark.parametrize('capture', CAPTURES)
    def test_captures(self, capture):
        wanted = bytes.fromhex(capture)
        _, r, first, second, feed, axis, wheel, _ = wanted
        self.bench.send(whb04b_frame(seed=0xFE))
        self.bench.turn_feed(feed)
        self.bench.select(axis)
        for key in (first, second):
            if key:
                self.bench.press(key)
        self.pendant.random = r
        self.bench.turn(wheel)
        assert self.last() == wanted

    def test_id_and_length(self):
        for act in (lambda: self.bench.press(1), lambda: self.bench.turn(1), self.bench.wake,
                    lambda: self.bench.select(0x11), lambda: self.bench.turn_feed(0x0E),
                    lambda: self.bench.release(1)):
            act()
            assert (self.last()[0], len(self.last())) == (4, 8)

    def test_r_changes_and_takes_every_value(self):
        seen = [self.pendant.report()[1] for _ in range(256)]
        assert sorted(seen) == list(range(256))
        assert [seen.index(value) for value in range(3)] != [0, 1, 2]
        other = Bench('WHB04B').pendant         # the same in each run
        assert [other.report()[1] for _ in range(256)] == seen

    def test_r_can_be_set(self):
        self.pendant.random = 0xBA
        assert self.pendant.report()[1] == 0xBA
        assert self.pendant.report()[1] != 0xBA

    def test_key_bytes(self):
        for key in range(1, 0x11):
            self.bench.press(key)
            assert self.last()[2:4] == bytes([key, 0])
            self.bench.release(key)
            assert self.last()[2:4] == b'\0\0'

    def test_fn_and_another_key(self):
        for act, slots in ((lambda: self.bench.press(0x0C), (0x0C, 0)),
                           (lambda: self.bench.press(2), (0x0C, 2)),
                           (lambda: self.bench.press(3), (0x0C, 2)),
                           (lambda: self.bench.release(0x0C), (2, 0)),
                           (lambda: self.bench.release(2), (0, 0))):
            act()
            assert tuple(self.last()[2:4]) == slots

    def test_second_rotary(self):
        assert self.pendant.report()[4] == 0x0D
        for code in FEEDS.values():
            self.bench.turn_feed(code)
            assert self.last()[4] == code
        self.bench.turn(1)
        assert self.last()[4] == 0x1B           # unchanged

    @pytest.mark.parametrize('lead', [0x1C, 0x9B])
    def test_lead_by_unit(self, lead):
        self.pendant.lead = lead
        self.bench.turn_feed(WHB04B.feed_code('lead'))
        assert self.last()[4] == lead
        self.bench.turn_feed(0x9B)
        assert self.last()[4] == 0x9B

    def test_axis_rotary(self):
        assert self.pendant.report()[5] == 0x06
        for code in (*AXES.values(), 0x06, 0x00, 0xFF):
            self.bench.select(code)
            assert self.last()[5] == code

    def test_wheel_is_signed_and_is_not_repeated(self):
        for detents, byte in ((1, 1), (-1, 0xFF), (127, 0x7F), (-128, 0x80)):
            self.bench.turn(detents)
            assert self.last()[6] == byte
            assert self.pendant.report()[6] == 0
        with pytest.raises(ValueError):
            self.bench.turn(128)

    def test_check_byte_for_all_seeds(self):
        for seed in range(256):
            for r in range(256):
                assert whb04b.check_byte(r, 0, seed) == r & seed        # simplified
                for key in (*range(0x12), 0x7F, 0x80, 0xFF):
                    assert whb04b.check_byte(r, key, seed) == check(r, key, seed)

    def test_check_byte_is_that_of_the_first_key_and_the_last_seed(self):
        self.bench.press(3)
        self.bench.press(7)
        for seed in range(256):
            self.bench.send(whb04b_frame(seed=seed))
            self.bench.turn(5)
            assert self.last()[7] == check(self.last()[1], 3, seed)

    def test_seed_before_the_first_frame(self):
        for r in range(256):
            self.pendant.random = r
            self.bench.wake()
            assert self.last()[7] == check(r, 0, 0x01)

    def test_seed_is_that_of_whole_frames(self):
        self.bench.send(whb04b_frame(seed=0x77)[:14])
        self.bench.wake()
        assert self.last()[7] == check(self.last()[1], 0, 0x01)

    def test_seed_after_power_on(self):
        self.bench.send(whb04b_frame())
        self.bench.unplug()
        self.bench.plug()
        self.bench.wake()
        assert self.last()[7] == check(self.last()[1], 0, 0x01)

    def test_wrong_check_byte(self):
        self.bench.send(whb04b_frame())
        for error in (0x01, 0x80, 0xFF):
            self.pendant.check_error = error
            self.bench.press(1)
            assert self.last()[7] == check(self.last()[1], 1, 0xFE) ^ error
        self.pendant.check_error = 0
        self.bench.wake()
        assert self.last()[7] == check(self.last()[1], 1, 0xFE)


class TestSleep(Case):
    def set_up(self):
        self.bench = Bench('WHB04B')
        self.bench.plug()
        self.add_cleanup(self.bench.unplug)
        self.bench.send(whb04b_frame())
        self.bench.select(0x12)
        self.bench.turn_feed(0x0F)
        self.bench.press(5)
        self.bench.reports.clear()

    @staticmethod
    def fields(report):
        _, r, first, second, feed, axis, wheel, given = report
        assert given == check(r, first, 0xFE)
        return first, second, feed, axis, wheel

    def test_two_reports(self):
        self.bench.sleep()
        assert [self.fields(report) for report in self.bench.reports] == [(0, 0, 0, 0, 0)] * 2
        one, two = (report[1] for report in self.bench.reports)
        assert one != two
        assert not self.bench.pendant.awake

    def test_second_report_with_positions(self):
        self.bench.pendant.trailing = 'positions'
        self.bench.sleep()
        assert [self.fields(report) for report in self.bench.reports] == \
            [(0, 0, 0, 0, 0), (0, 0, 0x0F, 0x12, 0)]
        assert not self.bench.pendant.awake

    def test_waking_up(self):
        self.bench.sleep()
        self.bench.reports.clear()
        self.bench.wake()
        assert [self.fields(report) for report in self.bench.reports] == [(0, 0, 0x0F, 0x12, 0)]
        assert self.bench.pendant.awake

    def test_any_use_wakes(self):
        for act in (lambda: self.bench.press(1), lambda: self.bench.turn(1),
                    lambda: self.bench.select(0x11), lambda: self.bench.turn_feed(0x0E)):
            self.bench.sleep()
            act()
            assert self.bench.pendant.awake

    def test_idle_with_the_axis_off_is_not_asleep(self):
        self.bench.release(5)
        self.bench.select(0x06)
        assert self.fields(self.bench.reports[-1]) == (0, 0, 0x0F, 0x06, 0)
        assert self.bench.pendant.awake


class TestStream(Case):
    def set_up(self):
        self.bench = Bench('WHB04B')
        self.bench.streams = True
        self.bench.plug()
        self.add_cleanup(self.bench.unplug)

    def more(self, count=5):
        """-> reports sent without operation"""
        start = len(self.bench.reports)
        assert find.wait(lambda: len(self.bench.reports) >= start + count, LIMIT)
        return self.bench.reports[start:]

    def silent(self):
        start = len(self.bench.reports)
        time.sleep(10 * WHB04B.stream_period)
        return len(self.bench.reports) == start

    def test_hardware_is_not_kind(self):
        assert models.get_model('WHB04B').stream_period
        assert usb.UsbPendant('WHB04B').streams
        assert uhid.UhidPendant('WHB04B').streams

    def test_while_an_axis_is_chosen(self):
        assert self.silent()
        for code in AXES.values():
            self.bench.select(code)
            assert {report[5:7] for report in self.more()} == {bytes([code, 0])}
        self.bench.select(0x06)
        assert self.silent()

    def test_reports_differ_and_are_right(self):
        self.bench.send(whb04b_frame())
        self.bench.select(0x11)
        self.bench.press(3)
        reports = self.more()
        assert len({report[1] for report in reports}) == len(reports)
        assert all(report[7] == check(report[1], 3, 0xFE) for report in reports)

    def test_does_not_keep_awake(self):
        self.bench.select(0x11)
        quiet_since = self.bench.pendant.quiet_since
        self.more()
        assert self.bench.pendant.quiet_since == quiet_since

    def test_not_asleep(self):
        self.bench.select(0x11)
        self.more()
        self.bench.sleep()
        assert self.silent()
        assert not self.bench.pendant.awake
        self.bench.wake()
        self.more()

    def test_not_while_reports_wait_to_be_fetched(self):
        self.bench.pending = lambda: 1
        self.bench.select(0x11)
        assert self.silent()
        self.bench.pending = lambda: 0
        self.more()

    def test_ends_with_the_cable_and_begins_with_it(self):
        self.bench.select(0x11)
        self.more()
        thread = self.bench._streamer
        self.bench.unplug()
        thread.join(LIMIT)
        assert not thread.is_alive()
        self.bench.plug()
        self.more()

    def test_no_memory_for_its_thread(self, monkeypatch):
        class NoThread(threading.Thread):
            def start(self):
                raise RuntimeError("can't start new thread")
        self.bench.unplug()
        monkeypatch.setattr(pendant.threading, 'Thread', NoThread)
        with pytest.raises(OSError) as refusal:
            self.bench.plug()
        assert refusal.value.errno == errno.ENOMEM
        assert not self.bench.plugged

    def test_kindness(self):
        self.bench.streams = False
        self.bench.select(0x11)
        assert self.silent()

    def test_other_models_do_not_stream(self):
        bench = Bench('HB04')
        bench.streams = True
        bench.plug()
        bench.select(0x11)
        assert bench._streamer is None
        assert not bench.pendant.streaming()


class TestFrames(Case):
    @pytest.mark.parametrize('name', FRAMES)
    def test_frames(self, name):
        reports, values = FRAMES[name]
        bench = Bench('WHB04B')
        for report in reports:
            bench.set_report(0x0306, 0, bytes.fromhex(report))
        assert bench.frame_count == 1
        fields = bench.lcd.as_dict()
        assert tuple(fields[field] for field in FIELDS) == values
        assert fields['faults'] == []
        assert fields['seed'] == 0xFE
        assert not bench.assembler.stray

    def test_names_are_those_of_the_fields(self):
        picture = whb04b.Picture(WHB04B, whb04b_frame())
        assert set(picture.as_dict()) | {'rows'} == set(whb04b.Picture.FIELDS)

    def test_every_row_and_number(self):
        picture = whb04b.Picture(WHB04B, whb04b_frame(
            [(65535, 9999), (1, 0x8001), (0, 0x8000 | 9999)], (65535, 258)))
        assert picture.coordinates == {'row1': '65535.9999', 'row2': '-1.0001', 'row3': '-0.9999'}
        assert picture.numbers == {'feedrate_override': 65535, 'spindle_override': 258}
        assert picture.faults == []

    def test_flags(self):
        modes = ['continuous', 'step', 'mpg', 'percent']
        for flags in range(256):
            with row(flags=flags):
                picture = whb04b.Picture(WHB04B, whb04b_frame(flags=flags))
                fields = picture.as_dict()
                assert fields['mode'] == modes[flags % 4]
                assert fields['reset'] == flags // 64 % 2
                assert fields['coordinates'] == ['machine', 'work'][flags // 128]
                unknown = flags & 0x3C
                assert picture.faults == (['flags 0x%02x' % unknown] if unknown else [])

    @pytest.mark.parametrize('at', range(3))
    def test_negative_zero(self, at):
        rows = [(0, 0)] * 3
        rows[at] = (0, 0x8000)
        picture = whb04b.Picture(WHB04B, whb04b_frame(rows))
        assert picture.faults == ['row%d: minus zero' % (at + 1)]

    def test_other_faults(self):
        def faults(data):
            return whb04b.Picture(WHB04B, data).faults
        assert faults(whb04b_frame([(0, 10000)] + [(0, 0)] * 2)) == ['row1: fraction 10000']
        assert faults(whb04b_frame(seed=0x16)) == ['seed 0x16']
        assert faults(whb04b_frame()[:20] + b'\1') == ['last byte is not zero']
        assert faults(b'\0\0' + whb04b_frame()[2:]) == ['no magic']
        with pytest.raises(ValueError):
            whb04b.Picture(WHB04B, whb04b_frame()[:20])

    def test_a_frame_of_the_other_models_is_not_one(self):
        """Its first three chunks are treated as a frame, and the others are stray."""
        bench = Bench('WHB04B')
        bench.send(bytes([0xFE, 0xFD, 22]).ljust(42, b'\0'))
        assert (bench.frame_count, bench.assembler.stray) == (1, 3)
        assert bench.lcd.faults == ['seed 0x16']


class TestLcd(Case):
    """The contents of the LCD."""

    def set_up(self):
        self.bench = Bench('WHB04B')
        self.bench.plug()
        self.add_cleanup(self.bench.unplug)

    def text(self):
        return '\n'.join(self.bench.screen())

    def show(self, **fields):
        self.bench.send(whb04b_frame(**fields))
        return self.text()

    def test_shape(self):
        worst = whb04b_frame([(65535, 9999 | 0x8000)] * 3, (65535, 65535), flags=0xC2)
        picture = whb04b.Picture(WHB04B, worst)
        for lines in (picture.lines(False, 'c', 0x99), whb04b.blank(WHB04B, False)):
            assert {len(line) for line in lines} == {lcd.WIDTH}
            assert len(lines) == 8

    def test_reset_until_told_otherwise(self):
        assert 'RESET' in self.text()
        self.bench.select(0x11)
        assert 'RESET' in self.text()
        assert 'RESET' in self.show(flags=0x40)
        assert 'RESET' not in self.show(flags=0x00)
        self.bench.unplug()
        self.bench.plug()
        assert 'RESET' in self.text()

    def test_rows_and_overrides(self):
        self.bench.select(0x12)
        text = self.show(rows=[(12, 3450), (6, 7890 | 0x8000), (0, 10)], overrides=(110, 80))
        for part in ('12.3450', '-6.7890', '0.0010', '110%', '80%', '>Y', 'seed FE'):
            assert part in text

    @pytest.mark.parametrize('axis', AXES)
    def test_names_of_the_rows(self, axis):
        self.bench.select(AXES[axis])
        for flags, suffix in ((0x00, ' '), (0x80, '1')):
            lines = self.show(flags=flags).split('\n')[3:6]
            names = 'XYZ' if axis in 'xyz' else 'ABC'
            assert [line[3:5] for line in lines] == [name + suffix for name in names]
            assert [line[2] == '>' for line in lines] == [name == axis.upper() for name in names]

    def test_rows_follow_the_rotary(self):
        self.bench.select(0x11)
        self.show(rows=[(1, 0), (2, 0), (3, 0)])
        assert 'X' in self.text() and 'A ' not in self.text()
        self.bench.select(0x14)
        assert 'A ' in self.text() and 'X' not in self.text()

    @pytest.mark.parametrize('mode, words', [
        (0, ('CONTINUOUS', '10%')), (1, ('STEP', '0.1 ')), (2, ('MPG', '10%')),
        (3, ('PERCENT', '10%'))])
    def test_mode_and_second_rotary(self, mode, words):
        self.bench.select(0x11)
        self.bench.turn_feed(0x0F)
        text = self.show(flags=mode)
        for word in words:
            assert word in text

    def test_steps(self):
        self.bench.select(0x11)
        self.show(flags=1)
        for code, step in ((0x0D, '0.001'), (0x0E, '0.01'), (0x0F, '0.1'), (0x10, '1.0'),
                           (0x1A, '5.0'), (0x1B, '10.0'), (0x1C, 'LEAD'), (0x9B, 'LEAD'),
                           (0x77, '0x77')):
            self.bench.turn_feed(code)
            assert step in self.bench.screen()[1].split()

    def test_still_while_the_rotary_is_off(self):
        self.bench.select(0x14)
        before = self.show(rows=[(1, 0)] * 3)
        self.bench.select(0x06)
        assert self.text() == before
        assert self.show(rows=[(2, 0)] * 3) == before
        assert self.bench.lcd.coordinates['row1'] == '2.0000'       # it was received
        assert self.bench.seen.coordinates['row1'] == '1.0000'
        self.bench.turn_feed(0x10)
        assert self.text() == before
        self.bench.select(0x11)
        assert '2.0000' in self.text() and 'X' in self.text() and '30%' in self.text()

    def test_a_frame_during_sleep_is_missed(self):
        self.bench.select(0x11)
        self.show(rows=[(1, 0)] * 3)
        self.bench.sleep()
        assert 'asleep' in self.show(rows=[(2, 0)] * 3)
        assert '1.0000' in self.text()
        self.bench.wake()
        assert '1.0000' in self.text()
        assert '2.0000' in self.show(rows=[(2, 0)] * 3)

    def test_other_models_always_show_the_last_frame(self):
        bench = Bench('HB04')
        bench.plug()
        bench.sleep()
        bench.send(bytes([0xFE, 0xFD, 22, 7]).ljust(42, b'\0'))
        assert bench.seen is bench.lcd
        assert '7.0000' in '\n'.join(bench.screen())


class TestBuses(Case):
    def test_usb_descriptors(self):
        device = usb.UsbPendant('WHB04B')
        whole = device.control(usb.SETUP.pack(0x80, 6, 0x0100, 0, 64))
        assert struct.unpack_from('<HH', whole, 8) == (0x10CE, 0xEB93)
        config = device.control(usb.SETUP.pack(0x80, 6, 0x0200, 0, 255))
        assert config[4] == 1                                   # one interface
        assert config[9:18].hex() == '090400000103000000'
        assert int.from_bytes(config[25:27], 'little') == 46
        assert config[27:].hex() == '07058103080002'            # one endpoint, 81h, 8 bytes, 2 ms
        report = device.control(usb.SETUP.pack(0x81, 6, 0x2200, 0, 46))
        assert report == WHB04B.report_descriptor

    def test_usb_get_report(self):
        device = usb.UsbPendant('WHB04B')
        data = device.control(usb.SETUP.pack(0xA1, 1, 0x0104, 0, 8))
        assert len(data) == 8
        assert (data[0], data[4:7]) == (4, bytes([0x0D, 0x06, 0]))

    def test_uhid_create_event(self):
        event = uhid.UhidPendant('WHB04B').create_event()
        assert struct.unpack_from('<HHII', event, 260) == (46, 3, 0x10CE, 0xEB93)
        assert event[280:280 + 46] == WHB04B.report_descriptor

    def turn_to_x_and_again(self, device, wait_for_stream):
        """Duties of plug(): the seed after power-on, and the stream."""
        for _ in range(2):
            device.pendant.seed = 0xFE
            device.plug()
            self.add_cleanup(device.unplug)
            assert device.pendant.seed == 0x01
            device.select(0x11)
            wait_for_stream()
            device.unplug()
            device._streamer.join(LIMIT)
            assert not device._streamer.is_alive()

    def test_stream_on_usb(self, monkeypatch, tmp_path):
        """As if the kernel had accepted the socket, and requested one report after another."""
        (tmp_path / 'attach').touch()
        monkeypatch.setattr(usb, 'VHCI', str(tmp_path))
        device = usb.UsbPendant('WHB04B')
        host = []

        def attach(end, _):
            host.append(socket.socket(fileno=os.dup(end.fileno())))
            self.add_cleanup(host[-1].close)
            return 0

        def wait_for_stream():
            host[-1].settimeout(LIMIT)
            for seqnum in range(1, 6):
                host[-1].sendall(usb.HEADER.pack(usb.CMD_SUBMIT, seqnum, 1, 1, 1, usb.SUBMIT.pack(
                    0, 8, 0, 0, 0, bytes(8))))
                answer = usb._read(host[-1], 48 + 8)
                assert answer[48:49] + answer[53:55] == bytes([4, 0x11, 0])
                assert device.pending() <= 1

        monkeypatch.setattr(device, '_attach', attach)
        self.turn_to_x_and_again(device, wait_for_stream)

    def test_stream_on_uhid(self, monkeypatch, tmp_path):
        """A pipe instead of /dev/uhid returns the data written to it."""
        monkeypatch.setattr(uhid, 'UHID', str(tmp_path / 'uhid'))
        os.mkfifo(uhid.UHID)
        device = uhid.UhidPendant('WHB04B')
        sent = []
        monkeypatch.setattr(device, '_write', sent.append)

        def wait_for_stream():
            start = len(sent)
            assert find.wait(lambda: len(sent) >= start + 5, LIMIT)
            assert {message[:7] + message[11:13] for message in sent[start:]} == {
                struct.pack('<IHBBB', uhid.INPUT2, 8, 4, 0x11, 0)}

        self.turn_to_x_and_again(device, wait_for_stream)

    def test_faults(self):
        bench = Bench('WHB04B')
        bench.plug()
        self.add_cleanup(bench.unplug)
        for kind in ('stall', 'timeout', 'unplug'):
            bench.set_fault(kind, skip=1, count=1)
            bench.send(whb04b_frame())
            assert bench.lcd is None
            assert [request.status == 0 for request in bench.set_reports] == [True, False, True]
            bench.set_reports.clear()
        bench.send(whb04b_frame())
        assert bench.frame_count == 1
        assert [len(request.data) for request in bench.set_reports] == \
            [1 + len(chunk) for chunk in chunks(whb04b_frame())]
