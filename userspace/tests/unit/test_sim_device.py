# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xhc-sim, the device: its models, its LCD, its keys, its faults.

Rows marked "seed" are examples or tables of the document "XHC xHB03 & xHB04 internals".
"""

import errno
import pytest
from case import Case

from busless_pendant import HB03, HB04, Bench, chunks, frame
from xhc_sim import lcd, models, pendant


class TestModels(Case):
    def test_ids(self):
        assert [(m.name, m.product) for m in (HB03, HB04)] == \
                         [('HB03', 0xEB6E), ('HB04', 0xEB70)]
        assert models.VENDOR == 0x10CE

    def test_frame_sizes_seed(self):
        assert (HB03.frame_size, HB03.chunks) == (31, 5)
        assert (HB04.frame_size, HB04.chunks) == (37, 6)

    def test_report_descriptor(self):
        data = models.REPORT_DESCRIPTOR
        assert len(data) == 46
        assert data.count(b'\xa1\x01') == 2
        assert data.count(b'\xc0') == 2
        assert bytes.fromhex('8504') in data
        assert bytes.fromhex('95057508 8102') in data
        assert bytes.fromhex('8506') in data
        assert bytes.fromhex('95077508 b106') in data

    def test_key_tables_seed(self):
        for model in (HB03, HB04):
            assert sorted(model.keys) == list(range(1, 0x11)) + [0x16, 0x17]
        rows = {0x17: ('Yes', 'Reset'), 0x16: ('No', 'Stop'), 0x01: ('Stop', 'Goto zero'),
                0x02: ('Start/Pause', 'Start/Pause'), 0x0C: ('Goto zero', 'Spindle'),
                0x05: ('Goto home', 'Macro 3'), 0x0D: ('Step left', 'STEP++'),
                0x10: ('Spindle', 'Macro 7')}
        for code, names in rows.items():
            assert (HB03.keys[code], HB04.keys[code]) == names

    def test_keycaps_are_distinct(self):
        for model in (HB03, HB04):
            names = [name.lower() for name in model.keys.values()]
            assert len(names) == len(set(names))

    def test_key_code(self):
        assert HB04.key_code('start/pause') == 2
        assert HB04.key_code('0x17') == 0x17
        assert HB04.key_code('200') == 200
        for bad in ('nothing', '256', '-1', ''):
            with pytest.raises(ValueError):
                HB04.key_code(bad)

    def test_selector_codes(self):
        assert [HB03.selector_code(p) for p in ('off', 'x', 'y', 'z', 'feed',
                                                          'spindle', 'speed')] == \
                         [0, 0x11, 0x12, 0x13, 0x14, 0x15, 0x18]
        assert [HB04.selector_code(p) for p in ('off', 'x', 'y', 'z', 'feed',
                                                          'spindle', 'a')] == \
                         [0, 0x11, 0x12, 0x13, 0x15, 0x14, 0x18]
        with pytest.raises(ValueError):
            HB03.selector_code('a')
        assert HB04.selector_name(0x99) == '0x99'

    def test_get_model(self):
        assert models.get_model('hb03') is HB03
        with pytest.raises(ValueError):
            models.get_model('HB05')


class TestFrames(Case):
    def shown(self, model, *fields):
        coordinates = list(fields) + [(0, 0)] * (6 - len(fields))
        return lcd.Picture(model, frame(model, coordinates))

    def test_135_17_seed(self):
        assert self.shown(HB03, (135, 17)).coordinates['work_x'] == '135.17'
        assert self.shown(HB04, (135, 1700)).coordinates['work_x'] == '135.1700'

    def test_minus_77_89_seed(self):
        assert self.shown(HB03, (77, 89 | 0x80)).coordinates['work_x'] == '-77.89'
        assert self.shown(HB04, (77, 8900 | 0x8000)).coordinates['work_x'] == '-77.8900'

    def test_minus_117_33_on_hb03_seed(self):
        assert self.shown(HB03, (117, 33 | 0x80)).coordinates['work_x'] == '-117.33'

    def test_minus_220_334_on_hb04_seed(self):
        assert self.shown(HB04, (220, 3340 | 0x8000)).coordinates['work_x'] == \
                         '-220.3340'

    def test_minus_one_half_on_hb04(self):
        data = bytearray(frame(HB04))
        data[3:7] = bytes.fromhex('00 00 88 93')
        assert lcd.Picture(HB04, data).coordinates['work_x'] == '-0.5000'

    def test_bytes_of_a_whole_hb04_frame(self):
        data = bytes.fromhex('fefd 16 8700a406 4d00c4a2 00008893 ffff0f27 00000000 01000080'
                             '6400 3200 e803 e02e 38 81').ljust(42, b'\0')
        picture = lcd.Picture(HB04, data)
        assert picture.as_dict() == {
            'work_x': '135.1700', 'work_y': '-77.8900', 'work_z': '-0.5000',
            'machine_x': '65535.9999', 'machine_y': '0.0000', 'machine_z': '-1.0000',
            'feedrate_override': 100, 'spindle_override': 50, 'feedrate': 1000,
            'spindle_speed': 12000, 'day': 22, 'step': 100, 'step_code': 8, 'icon': 3,
            'state': 'run+inch', 'state_byte': 0x81, 'faults': []}

    def test_bytes_of_a_whole_hb03_frame(self):
        data = bytes.fromhex('fefd 01 870011 4d00d9 7500a1 000000 ffff63 000081'
                             '0100 0200 0300 0400 05 42').ljust(35, b'\0')
        fields = lcd.Picture(HB03, data).as_dict()
        assert [fields[name] for name in lcd.COORDINATES] == \
                         ['135.17', '-77.89', '-117.33', '0.00', '65535.99', '-0.01']
        assert [fields[name] for name in lcd.NUMBERS] == [1, 2, 3, 4]
        assert (fields['step'], fields['icon'], fields['state']) == (30, 0, 'pause+0x40')

    def test_step_table_seed(self):
        values = [lcd.Picture(HB04, frame(HB04, step=code)).step for code in range(0x0B)]
        assert values == [0, 1, 5, 10, 20, 30, 40, 50, 100, 500, 1000]
        unknown = lcd.Picture(HB04, frame(HB04, step=0x0B))
        assert unknown.step is None
        assert unknown.faults == ['step code 0xb']

    def test_state_words(self):
        rows = [(HB04, 0, 'idle'), (HB04, 1, 'run'), (HB04, 2, 'pause'), (HB04, 0x80, 'inch'),
                (HB03, 0x80, '0x80'), (HB04, 0x43, 'run+pause+0x40'), (HB04, 0x20, '0x20')]
        for model, byte, text in rows:
            picture = lcd.Picture(model, frame(model, state=byte))
            assert picture.state_text() == text

    def test_faults_are_named(self):
        rows = [(dict(day=0), 'day 0'), (dict(day=32), 'day 32'),
                (dict(coordinates=[(0, 0x8000)] + [(0, 0)] * 5), 'work_x: minus zero'),
                (dict(coordinates=[(0, 0)] * 5 + [(0, 10000)]), 'machine_z: fraction 10000')]
        for fields, fault in rows:
            assert lcd.Picture(HB04, frame(HB04, **fields)).faults == [fault]
        data = bytearray(frame(HB04))
        data[-1] = 1
        assert lcd.Picture(HB04, data).faults == ['padding is not zero']
        assert lcd.Picture(HB04, b'\0\0' + bytes(frame(HB04))[2:]).faults == ['no magic']

    def test_short_frame(self):
        with pytest.raises(ValueError):
            lcd.Picture(HB04, bytes(36))

    def test_screen_shape(self):
        for model in (HB03, HB04):
            worst = frame(model, [(65535, 99 | 0x80 if model is HB03 else 9999 | 0x8000)] * 6,
                          (65535,) * 4, step=0xFA, state=0xFF)
            for lines in (lcd.Picture(model, worst).lines(False, 'x'), lcd.blank(model, False)):
                assert {len(line) for line in lines} == {lcd.WIDTH}
                assert len(lines) == 8

    def test_screen_shows_all(self):
        fields = [(135, 1700), (77, 8900 | 0x8000), (3, 0), (4, 1), (5, 2), (6, 3)]
        text = lcd.Picture(HB04, frame(HB04, fields, (110, 90, 1500, 24000), step=0x24,
                                       state=1)).text(True, 'y')
        for part in ('RUN', 'icon 2', 'x20', '135.1700', '-77.8900', '3.0000', '4.0001', '5.0002',
                     '6.0003', '110%', '90%', '1500', '24000', '>Y', 'day 22'):
            assert part in text

    def test_normal_number(self):
        for text, plain in (('-220.3340', '-220.334'), ('007.50', '7.5'), ('-0.000', '0'),
                            ('5.', '5'), ('.5', '0.5'), ('+1', '1')):
            assert lcd.normal_number(text) == plain
        for bad in ('', 'x', '1e3', '.', '-'):
            with pytest.raises(ValueError):
                lcd.normal_number(bad)


class TestChunks(Case):
    def test_whole_frame(self):
        for model in (HB03, HB04):
            assembler = lcd.Assembler(model)
            data = frame(model)
            parts = chunks(data)
            assert len(parts) == model.chunks
            assert [assembler.feed(part) for part in parts[:-1]] == \
                             [None] * (model.chunks - 1)
            assert assembler.feed(parts[-1]) == data
            assert (assembler.stray, assembler.torn) == (0, 0)

    def test_restart_in_mid_frame(self):
        assembler = lcd.Assembler(HB04)
        first, second = chunks(frame(HB04, day=1)), chunks(frame(HB04, day=2))
        for part in first[:3]:
            assert assembler.feed(part) is None
        done = [assembler.feed(part) for part in second]
        assert done[-1][2] == 2
        assert assembler.torn == 1

    def test_chunks_without_a_beginning(self):
        assembler = lcd.Assembler(HB04)
        for part in chunks(frame(HB04))[1:]:
            assert assembler.feed(part) is None
        assert assembler.stray == 5

    def test_swapped_magic_is_not_a_beginning(self):
        assembler = lcd.Assembler(HB04)
        assert assembler.feed(bytes.fromhex('fdfe0100000000')) is None
        assert assembler.stray == 1

    def test_wrong_size(self):
        assembler = lcd.Assembler(HB04)
        for size in (0, 6, 8):
            assert assembler.feed(bytes(size)) is None
        assert assembler.stray == 3


class TestHands(Case):
    def set_up(self):
        self.pendant = pendant.Pendant(HB04)
        self.pendant.day = 22

    def test_idle_differs_from_sleep(self):
        assert self.pendant.wake().hex(' ') == '04 00 00 00 00 16'
        assert self.pendant.sleep().hex(' ') == '04 00 00 00 00 00'

    def test_xor_byte_seed(self):
        assert self.pendant.press(0x17).hex(' ') == '04 17 00 00 00 01'

    def test_two_slots(self):
        self.pendant.press(1)
        assert self.pendant.press(2)[1:3] == bytes([1, 2])
        assert self.pendant.press(3)[1:3] == bytes([1, 2])
        assert self.pendant.release(1)[1:3] == bytes([2, 0])
        assert self.pendant.release(2)[1:3] == bytes([0, 0])

    def test_wheel_is_signed(self):
        assert [self.pendant.turn(n)[4] for n in (1, 10, -1, -10, 127, -128)] == \
                         [1, 10, 0xFF, 0xF6, 0x7F, 0x80]
        assert self.pendant.report()[4] == 0
        for bad in (128, -129):
            with pytest.raises(ValueError):
                self.pendant.turn(bad)

    def test_selector_stays(self):
        assert self.pendant.select(0x12)[3] == 0x12
        assert self.pendant.turn(1)[3] == 0x12

    def test_sleep_forgets_keys(self):
        self.pendant.press(5)
        assert self.pendant.sleep() == bytes([4, 0, 0, 0, 0, 0])
        assert not self.pendant.awake
        assert self.pendant.wake()[1:3] == b'\0\0'
        assert self.pendant.awake

    def test_sleepy_after_30_seconds_seed(self):
        start = self.pendant.quiet_since
        assert not self.pendant.sleepy(start + 29.9)
        assert self.pendant.sleepy(start + 30)
        self.pendant.press(1)
        assert not self.pendant.sleepy(self.pendant.quiet_since + 60)


class TestFaults(Case):
    def test_kinds(self):
        assert pendant.Fault('stall').strike() == 'stall'
        assert pendant.Fault('slow:250').seconds == 0.25
        for bad in ('broken', 'slow', 'slow:x', 'stall:1', ''):
            with pytest.raises(ValueError):
                pendant.Fault(bad)

    def test_skip_and_count(self):
        fault = pendant.Fault('stall', skip=2, count=1)
        assert [fault.strike() for _ in range(5)] == \
                         ['none', 'none', 'stall', 'none', 'none']

    def test_stalled_chunk_is_not_shown(self):
        bench = Bench()
        bench.fault = 'stall'
        bench.send(frame(HB04))
        assert bench.lcd is None
        assert [r.status for r in bench.set_reports] == [-errno.EPIPE] * 6
        bench.fault = 'none'
        bench.send(frame(HB04))
        assert bench.lcd.day == 22
        assert bench.pendant.day == 22

    def test_only_feature_report_6_reaches_the_display(self):
        bench = Bench()
        for part in chunks(frame(HB04)):
            bench.set_report(0x0206, 0, b'\x06' + part)
        assert bench.lcd is None
        assert bench.set_reports[0].wvalue == 0x0206
