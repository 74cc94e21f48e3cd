# SPDX-License-Identifier: GPL-2.0-only
"""The display: values written to dro/ are read back, checked, sent, and shown on the LCD."""

import os
import random
import threading
import time

import pytest
from case import row
import rig
from kernel import KernelLog
from rig import Case, read_file
from xhc_sim.lcd import COORDINATES, NUMBERS

# Written, read back, on the LCD.  "seed": examples of the seed document.
COORDINATES_HB04 = (
    ('135.17', '135.17', '135.1700'),           # seed
    ('-77.89', '-77.89', '-77.8900'),           # seed
    ('-220.334', '-220.334', '-220.3340'),      # seed
    ('-0.5', '-0.5', '-0.5000'),
    ('0', '0', '0.0000'),
    ('-0', '0', '0.0000'),
    ('-0.0000', '0', '0.0000'),
    ('.5', '0.5', '0.5000'),
    ('5.', '5', '5.0000'),
    ('-.25', '-0.25', '-0.2500'),
    ('007.50', '7.5', '7.5000'),
    ('1.2345', '1.2345', '1.2345'),
    ('1.00010000', '1.0001', '1.0001'),
    ('1.99994', '1.9999', '1.9999'),
    ('1.99995', '2', '2.0000'),
    ('1.99999', '2', '2.0000'),
    ('-1.99995', '-2', '-2.0000'),
    ('0.00004999', '0', '0.0000'),
    ('-0.00004999', '0', '0.0000'),
    ('0.00005', '0.0001', '0.0001'),
    ('-0.00005', '-0.0001', '-0.0001'),
    ('0.' + '3' * 60, '0.3333', '0.3333'),
    ('0' * 60 + '1', '1', '1.0000'),
    ('65535.9999', '65535.9999', '65535.9999'),
    ('-65535.9999', '-65535.9999', '-65535.9999'),
    ('65535.99994', '65535.9999', '65535.9999'),
)
COORDINATES_HB03 = (
    ('135.17', '135.17', '135.17'),             # seed
    ('-77.89', '-77.89', '-77.89'),             # seed
    ('-117.33', '-117.33', '-117.33'),          # seed
    ('-220.334', '-220.33', '-220.33'),
    ('1.994', '1.99', '1.99'),
    ('1.995', '2', '2.00'),
    ('-1.995', '-2', '-2.00'),
    ('0.0049999', '0', '0.00'),
    ('-0.004', '0', '0.00'),
    ('-0.005', '-0.01', '-0.01'),
    ('0.1', '0.1', '0.10'),
    ('65535.994', '65535.99', '65535.99'),
    ('-65535.99', '-65535.99', '-65535.99'),
)
NOT_NUMBERS = ('\n', 'x', '1e3', '0x1', '1,5', '1.2.3', '--1', '-', '.', '-.', '1 2', '1.5x',
               'nan', 'inf', '1-', '+-1', '- 1', '1. 5', '\u0661', '1.5\n\n2')
TOO_LARGE = ('65536', '-65536', '65535.99995', '-65535.99995', '429496.7296', '4294967296',
             '42949672960000', '18446744073709551616', '1' + '0' * 60)


class TestShape(Case):
    def test_files_and_modes(self):
        pendant = self.plug()
        read_write, read_only, write_only = 0o644, 0o444, 0o200
        wanted = dict.fromkeys(COORDINATES + NUMBERS + (
            'position', 'step', 'icon', 'state', 'day', 'refresh_ms'), read_write)
        wanted.update(step_available=read_only, flush=write_only)
        assert self.modes(pendant.path + '/dro') == wanted
        assert self.modes(pendant.path + '/stats') == dict.fromkeys(
            ('reports', 'bad_reports', 'xor_mismatches', 'unknown_keys', 'frames_sent',
             'frame_errors'), read_only)
        for name in ('model', 'awake'):
            assert os.stat(pendant.file(name)).st_mode & 0o777 == read_only
        assert os.stat(pendant.file('swap_feed_spindle')).st_mode & 0o777 == read_write

    @staticmethod
    def modes(folder):
        return {name: os.stat(os.path.join(folder, name)).st_mode & 0o777
                for name in os.listdir(folder)}

    def test_read_only_and_write_only(self):
        pendant = self.plug()
        for name in ('step_available', 'model', 'awake', 'frames_sent'):
            with pytest.raises(OSError):
                pendant.set(name, '1')
        with pytest.raises(OSError):
            pendant.get('flush')

    def test_values_at_the_beginning(self):
        for model in ('HB03', 'HB04'):
            pendant = self.plug(model)
            for name in COORDINATES + NUMBERS + ('step', 'icon'):
                assert pendant.get(name) == '0', name
            assert pendant.get('position') == '0 0 0 0 0 0'
            assert pendant.get('state') == 'idle'
            assert pendant.get('day') == 'auto'
            assert pendant.get('refresh_ms') == '50'
            assert pendant.get('step_available') == '0 1 5 10 20 30 40 50 100 500 1000'

    def test_first_frame(self):
        for model, chunks in (('HB03', 5), ('HB04', 6)):
            pendant = self.plug(model)
            assert pendant.no_more_frames(1)
            sent = pendant.device.set_reports
            assert [(r.wvalue, len(r.data), r.data[0]) for r in sent] == \
                             [(0x0306, 8, 6)] * chunks
            shown = pendant.device.lcd.as_dict()
            assert shown['faults'] == []
            assert shown['day'] == time.gmtime().tm_mday
            assert {float(shown[name]) for name in COORDINATES + NUMBERS} == {0.0}
            assert pendant.stat('frames_sent') == 1


class TestValues(Case):
    def refused(self, pendant, name, texts, error):
        """Each text is refused with this error; nothing is changed or sent."""
        before, frames = pendant.get(name), pendant.settle()
        for text in texts:
            with row(name, text=text[:70], error=error):
                assert pendant.set_error(name, text) == error
                assert pendant.get(name) == before
        assert pendant.no_more_frames(frames)

    def accepted(self, pendant, name, rows):
        """rows: (written, read back, on the LCD)"""
        for written, read, shown in rows:
            with row(name, written=written):
                pendant.set(name, written + '\n')
                assert pendant.get(name) == read
                assert pendant.flush()[name] == shown
                assert pendant.device.lcd.faults == []

    def test_coordinates_hb04(self):
        pendant = self.plug('HB04')
        self.accepted(pendant, 'work_x', COORDINATES_HB04)
        for name in COORDINATES[1:]:
            self.accepted(pendant, name, COORDINATES_HB04[:3])

    def test_coordinates_hb03(self):
        pendant = self.plug('HB03')
        self.accepted(pendant, 'work_x', COORDINATES_HB03)
        for name in COORDINATES[1:]:
            self.accepted(pendant, name, COORDINATES_HB03[:3])

    def test_coordinate_errors(self):
        for model in ('HB03', 'HB04'):
            pendant = self.plug(model)
            pendant.set('work_x', '-1.25')
            pendant.set('machine_z', '7')
            self.refused(pendant, 'work_x', NOT_NUMBERS, 'EINVAL')
            self.refused(pendant, 'work_x', TOO_LARGE, 'ERANGE')
            self.refused(pendant, 'machine_z', NOT_NUMBERS[:3], 'EINVAL')
            self.refused(pendant, 'machine_z', TOO_LARGE[:3], 'ERANGE')
        self.refused(self.plug('HB03'), 'work_y', ['65535.995', '-65535.995'], 'ERANGE')

    def test_without_a_newline(self):
        pendant = self.plug()
        pendant.set('work_x', '12.5')
        assert pendant.get('work_x') == '12.5'

    def test_numbers(self):
        pendant = self.plug()
        for name in NUMBERS:
            self.accepted(pendant, name, [(str(n), str(n), n) for n in (1, 255, 256, 65535, 0)])
            pendant.set(name, '42')
            self.refused(pendant, name, ['\n', 'x', '1.5', '1e3', '0x10', '1 2', '--1'], 'EINVAL')
            self.refused(pendant, name, ['65536', '-1', '4294967296', '99999999999999999999'],
                         'ERANGE')

    def test_step(self):
        pendant = self.plug()
        steps = pendant.get('step_available').split()
        self.accepted(pendant, 'step', [(step, step, int(step)) for step in steps])
        self.refused(pendant, 'step', ['\n', 'x', '1.5', '5 10'], 'EINVAL')
        self.refused(pendant, 'step', ['2', '-1', '1001', '11', '4294967296'], 'ERANGE')

    def test_step_code(self):
        """A step without a multiplier is written as its code, like bits of `state`."""
        pendant = self.plug()
        pendant.set('icon', '9')
        for written, read, code in (('0x0b', '0x0b', 0x0B), ('0xf', '0x0f', 0x0F),
                                    ('0x0C', '0x0c', 0x0C), ('0x3', '10', 3), ('0x0', '0', 0),
                                    ('0x0b', '0x0b', 0x0B), ('1000', '1000', 10)):
            with row(written=written):
                pendant.set('step', written + '\n')
                assert pendant.get('step') == read
                shown = pendant.flush()
                assert (shown['step_code'], shown['icon']) == (code, 9)
        self.refused(pendant, 'step', ['0x', '0xg', '0x0b 1', 'b', '0xb0x'], 'EINVAL')
        self.refused(pendant, 'step', ['0x10', '0xff', '0x100000000'], 'ERANGE')

    def test_icon(self):
        pendant = self.plug()
        pendant.set('step', '1000')
        self.accepted(pendant, 'icon', [(str(n), str(n), n) for n in range(16)])
        assert pendant.device.lcd.step == 1000
        self.refused(pendant, 'icon', ['\n', 'x', '1.0'], 'EINVAL')
        self.refused(pendant, 'icon', ['16', '-1', '256'], 'ERANGE')

    def test_state_hb04(self):
        pendant = self.plug('HB04')
        for written, read, byte in (
                ('run', 'run', 0x01), ('pause', 'pause', 0x02), ('inch', 'inch', 0x80),
                ('idle', 'idle', 0), ('run+inch', 'run+inch', 0x81),
                ('inch+run', 'run+inch', 0x81), ('run+0x40', 'run+0x40', 0x41),
                ('0x40+run', 'run+0x40', 0x41), ('32', '0x20', 0x20), ('0', 'idle', 0),
                ('129', 'run+inch', 0x81), ('0xff', 'run+pause+inch+0x7c', 0xFF)):
            with row(written=written):
                pendant.set('state', written + '\n')
                assert pendant.get('state') == read
                assert pendant.flush()['state_byte'] == byte
        pendant.set('state', 'run')
        self.refused(pendant, 'state', ['\n', 'x', 'running', 'run+', '+run', 'run++inch',
                                        'run run', 'run,inch', '1.5', 'run+x', 'ru'], 'EINVAL')
        self.refused(pendant, 'state', ['256', '0x100', 'run+256', '4294967296'], 'ERANGE')

    def test_every_state_byte_reads_back_as_it_was(self):
        for model in ('HB03', 'HB04'):
            pendant = self.plug(model)
            for byte in range(256):
                pendant.set('state', str(byte))
                text = pendant.get('state')
                pendant.set('state', '0')
                pendant.set('state', text)
                assert pendant.get('state') == text
                if byte % 16 == 1:
                    assert pendant.flush()['state_byte'] == byte

    def test_state_hb03_has_no_inch(self):
        pendant = self.plug('HB03')
        self.refused(pendant, 'state', ['inch', 'run+inch'], 'EINVAL')
        pendant.set('state', '0x81')
        assert pendant.get('state') == 'run+0x80'
        assert pendant.flush()['state_byte'] == 0x81

    def test_day(self):
        pendant = self.plug()
        self.accepted(pendant, 'day', [(str(day), str(day), day) for day in range(1, 32)])
        self.refused(pendant, 'day', ['\n', 'x', 'Auto!', '1.5', 'auto 1'], 'EINVAL')
        self.refused(pendant, 'day', ['0', '32', '-1', '256'], 'ERANGE')
        self.accepted(pendant, 'day', [('auto', 'auto', time.gmtime().tm_mday)])

    def test_refresh_ms(self):
        pendant = self.plug()
        for text in ('10', '1000', '333'):
            pendant.set('refresh_ms', text)
            assert pendant.get('refresh_ms') == text
        self.refused(pendant, 'refresh_ms', ['\n', 'x', '50ms', '1.5'], 'EINVAL')
        self.refused(pendant, 'refresh_ms', ['9', '1001', '0', '-1'], 'ERANGE')

    @pytest.mark.distro
    @pytest.mark.smoke
    def test_every_attribute_reaches_the_lcd(self):
        values = {
            'work_x': '-220.334', 'work_y': '135.17', 'work_z': '0',
            'machine_x': '0.0001', 'machine_y': '-0.5', 'machine_z': '65535.9999',
            'feedrate_override': '100', 'spindle_override': '80', 'feedrate': '65535',
            'spindle_speed': '24000', 'step': '500', 'icon': '9', 'state': 'run+inch', 'day': '17'}
        assert values.keys() == set(rig.DISPLAYED)
        pendant = self.plug()
        for name, value in values.items():
            with row(name):
                pendant.set(name, value)
                assert pendant.get(name) == value
                assert rig.wait(lambda name=name, value=value: pendant.shown(name) == value)
        assert {name: pendant.shown(name) for name in values} == values
        assert pendant.device.lcd.faults == []

    def test_everything_at_random(self):
        """Frames decoded by the simulator, which shares no code with the driver."""
        dice = random.Random(2)
        for model, decimals in (('HB03', 2), ('HB04', 4)):
            pendant = self.plug(model)
            for _ in range(40):
                wanted = {name: '%s%d.%0*d' % (dice.choice(['', '-']), dice.randrange(1, 64000),
                                               decimals, dice.randrange(10 ** decimals))
                          for name in COORDINATES}
                wanted.update({name: dice.randrange(64000) for name in NUMBERS})
                wanted.update(step=dice.choice([0, 1, 5, 10, 20, 30, 40, 50, 100, 500, 1000]),
                              icon=dice.randrange(16), day=dice.randrange(1, 32))
                for name, value in wanted.items():
                    pendant.set(name, str(value))
                shown = pendant.flush()
                assert {name: shown[name] for name in wanted} == wanted
                assert shown['faults'] == []


class TestPosition(Case):
    def test_all_six(self):
        pendant = self.plug()
        pendant.set('position', '1 -2.5 3.00005 0 65535.9999 -0.5\n')
        assert pendant.get('position') == '1 -2.5 3.0001 0 65535.9999 -0.5'
        shown = pendant.flush()
        assert [shown[name] for name in COORDINATES] == \
                         ['1.0000', '-2.5000', '3.0001', '0.0000', '65535.9999', '-0.5000']
        assert [pendant.get(name) for name in COORDINATES] == \
                         ['1', '-2.5', '3.0001', '0', '65535.9999', '-0.5']

    def test_blanks(self):
        pendant = self.plug()
        pendant.set('position', '  1   2\t3 4  5 6  \n')
        assert pendant.get('position') == '1 2 3 4 5 6'

    def test_reads_what_it_writes(self):
        pendant = self.plug()
        pendant.set('position', '-220.334 135.17 -77.89 0 0.0001 -0.0001')
        text = pendant.get('position')
        pendant.set('position', '0 0 0 0 0 0')
        pendant.set('position', text)
        assert pendant.get('position') == text

    def test_all_or_none(self):
        pendant = self.plug()
        pendant.set('position', '1 2 3 4 5 6')
        frames = pendant.settle()
        rows = [('9 9 9 9 9', 'EINVAL'), ('9 9 9 9 9 9 9', 'EINVAL'), ('9 9 9 9 9 x', 'EINVAL'),
                ('x 9 9 9 9 9', 'EINVAL'), ('\n', 'EINVAL'), ('9 9 9 9 9 65536', 'ERANGE'),
                ('-70000 9 9 9 9 9', 'ERANGE'), ('9,9,9,9,9,9', 'EINVAL'), ('9 ' * 1000, 'EINVAL')]
        for text, error in rows:
            with row(text=text[:40]):
                assert pendant.set_error('position', text) == error
                assert pendant.get('position') == '1 2 3 4 5 6'
        assert pendant.no_more_frames(frames)

    def test_no_frame_is_mixed(self):
        """Two writers, each with six equal values: so must be those of all frames and reads."""
        pendant = self.plug()
        pendant.set('refresh_ms', '10')
        stop = time.monotonic() + 1.0
        mixed = []

        def write(value):
            while time.monotonic() < stop or pendant.device.frame_count < 20:
                pendant.set('position', ' '.join([value] * 6))
                if len(set(pendant.get('position').split())) != 1:
                    mixed.append('read')
                time.sleep(0.001)           # all threads share one processor

        def look(picture):
            if len(set(picture.coordinates.values())) != 1:
                mixed.append(picture)

        pendant.device.on_frame = look
        writers = [threading.Thread(target=write, args=(value,)) for value in ('1.5', '-2.5')]
        for writer in writers:
            writer.start()
        for writer in writers:
            writer.join()
        pendant.flush()
        assert mixed == []


class TestWorker(Case):
    @staticmethod
    def pauses(pendant, frames):
        """Seconds between the end of each frame and the start of the next, for the last frames."""
        begins = [r.time for r in pendant.device.set_reports if r.data[1:3] == b'\xfe\xfd']
        ends = [when for when, _ in pendant.device.frames]
        assert len(begins) == len(ends)
        pauses = [begin - end for end, begin in zip(ends, begins[1:])]
        return pauses[-frames:]

    def test_write_alone_is_enough(self):
        pendant = self.plug()
        pendant.set('work_x', '12.5')
        assert pendant.shows('work_x', '12.5000')

    def test_a_burst_costs_few_frames(self):
        pendant = self.plug()
        pendant.set('refresh_ms', '200')
        before, start = pendant.settle(), time.monotonic()
        for number in range(1000):
            pendant.set('feedrate', str(number))
        seconds = time.monotonic() - start
        assert pendant.shows('feedrate', 999)
        assert pendant.settle() - before <= 2 + seconds / 0.2
        assert pendant.device.lcd.faults == []

    def test_a_short_burst_is_one_frame(self):
        """A short interval: the driver waits at least 5 ms for the rest of a burst."""
        pendant = self.plug()
        files = [os.open(pendant.file(name), os.O_WRONLY) for name in (
            'work_x', 'machine_z', 'feedrate', 'spindle_override', 'icon')]
        bursts = number = 0
        end = time.monotonic() + rig.PATIENCE
        while bursts < 10:
            assert time.monotonic() < end, 'the writes of a burst take too long, each time'
            number = number % 15 + 1
            before, start = pendant.settle(), time.monotonic()
            for fd in files:
                os.pwrite(fd, b'%d' % number, 0)
            short = time.monotonic() - start < 0.005
            frames = pendant.settle() - before
            assert pendant.no_more_frames(before + frames, 0.3)
            assert pendant.device.lcd.as_dict()['icon'] == number
            if short:
                bursts += 1
                assert frames == 1
        for fd in files:
            os.close(fd)

    @pytest.mark.distro
    def test_refresh_ms_is_the_least_time_between_frames(self):
        """Also where a jiffy is not 10 ms: in Debian's kernels it is 4 ms."""
        pendant = self.plug()
        late = 1 if rig.IN_DISTRO else 0.1      # an emulated machine may be slow
        for refresh in (30, 150, 400):
            with row(refresh=refresh):
                pendant.set('refresh_ms', str(refresh))
                pendant.flush()
                frames, number = pendant.settle(), 0
                while pendant.device.frame_count < frames + 6:
                    number += 1
                    pendant.set('feedrate', str(number % 60000))
                    time.sleep(0.002)
                pendant.settle()
                pauses = self.pauses(pendant, pendant.device.frame_count - frames)
                assert min(pauses) >= refresh / 1000
                assert min(pauses) < refresh / 1000 + late

    def test_unchanged_sends_nothing(self):
        pendant = self.plug()
        pendant.set('work_x', '1')
        pendant.set('state', 'run')
        before = pendant.settle()
        for _ in range(5):
            for name, text in (('work_x', '1.0'), ('work_x', '1.00001'), ('state', '1'),
                               ('icon', '0'), ('day', str(time.gmtime().tm_mday)),
                               ('day', 'auto'), ('position', '1 0 0 0 0 0')):
                pendant.set(name, text)
                assert pendant.no_more_frames(before, 0.1)
        pendant.flush()
        assert pendant.device.frame_count == before + 1

    def test_there_and_back_sends_nothing_new(self):
        """Only values that the display does not show yet cause a frame."""
        pendant = self.plug()
        pendant.set('refresh_ms', '1000')
        pendant.flush()                     # the next frame is due in a second
        before = pendant.device.frame_count
        pendant.set('work_x', '5')
        pendant.set('work_x', '0')
        assert pendant.no_more_frames(before, 1.5)
        pendant.flush()
        assert pendant.device.frame_count == before + 1

    def test_flush_sends_even_what_is_unchanged(self):
        pendant = self.plug()
        before = pendant.settle()
        for number in range(1, 4):
            pendant.set('flush', 'x')
            assert pendant.device.frame_count == before + number
        assert pendant.no_more_frames(before + 3)

    def test_flush_does_not_wait_for_refresh(self):
        pendant = self.plug()
        pendant.set('refresh_ms', '1000')
        pendant.flush()
        pendant.set('work_x', '3')
        shown = pendant.flush()
        assert self.pauses(pendant, 1)[0] < 0.9
        assert shown['work_x'] == '3.0000'

    def test_flush_by_many(self):
        pendant = self.plug()
        pendant.device.fault = 'slow:20'
        results = []
        threads = [threading.Thread(target=lambda: results.append(pendant.set_error('flush', '1')))
                   for _ in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(rig.PATIENCE)
        assert results == [None] * 8

    def test_a_slow_pendant_blocks_no_writer(self):
        """All writes return before the end of the frame in progress."""
        pendant = self.plug()
        frames = pendant.settle()
        pendant.device.fault = 'slow:400'           # a frame takes more than two seconds
        self.write_beside_a_frame(pendant, 200)
        assert pendant.device.frame_count == frames
        pendant.device.fault = 'none'
        assert pendant.shows('work_y', '199.0000')
        assert pendant.device.lcd.coordinates['work_x'] == '1.0000'

    def test_a_dead_pendant_blocks_no_writer(self):
        """All writes return before the end of the transfer, which takes five seconds."""
        pendant = self.plug()
        pendant.settle()
        pendant.device.fault = 'timeout'
        requests = self.write_beside_a_frame(pendant, 50)
        assert len(pendant.device.set_reports) == requests

    @staticmethod
    def write_beside_a_frame(pendant, count):
        """Writes while a frame is being sent; -> number of requests at its start"""
        sent = len(pendant.device.set_reports)
        pendant.set('work_x', '1')
        assert pendant.device.wait_for(lambda: len(pendant.device.set_reports) > sent)
        for number in range(count):
            pendant.set('work_y', str(number))
            assert pendant.get('work_y') == str(number)
            pendant.get('frames_sent')
        return sent + 1


class TestFailure(Case):
    def test_flush_tells_of_a_stall(self):
        pendant = self.plug()
        pendant.settle()
        pendant.device.set_fault('stall', count=1)
        assert pendant.set_error('flush', '1') == 'EIO'    # the only error of uhid
        assert pendant.stat('frame_errors') == 1

    def test_flush_tells_of_a_pendant_that_is_silent(self):
        pendant = self.plug()
        pendant.settle()
        pendant.device.set_fault('timeout', count=1)
        start = time.monotonic()
        assert pendant.set_error('flush', '1') == 'EIO'
        assert time.monotonic() - start < 9         # one timeout, not two
        assert pendant.set_error('flush', '1') is None

    def test_flush_after_a_failure_does_not_wait(self):
        pendant = self.plug()
        pendant.settle()
        pendant.device.set_fault('stall', count=1)
        pendant.set_error('flush', '1')
        stalled = pendant.device.set_reports[-1]
        pendant.flush()
        begin = pendant.device.set_reports[list(pendant.device.set_reports).index(stalled) + 1]
        assert begin.time - stalled.time < 0.9      # the driver retries after a second

    def test_again_after_a_second_with_the_newest(self):
        pendant = self.plug()
        before = pendant.settle()
        pendant.device.set_fault('stall', count=1)
        pendant.set('work_x', '1')
        assert rig.wait(lambda: pendant.stat('frame_errors') == 1)
        pendant.set('work_x', '2')
        time.sleep(0.3)
        pendant.set('work_y', '3')
        assert pendant.device.wait_frames(before + 1)
        stalled, again = [r.time for r in pendant.device.set_reports
                          if r.data[1:3] == b'\xfe\xfd'][-2:]
        assert 0.9 < again - stalled < 1.5
        assert pendant.no_more_frames(before + 1)
        shown = pendant.device.lcd.as_dict()
        assert (shown['work_x'], shown['work_y']) == ('2.0000', '3.0000')

    def test_until_it_works(self):
        pendant = self.plug()
        pendant.settle()
        pendant.device.set_fault('stall', count=4)
        pendant.set('work_x', '1')
        assert pendant.shows('work_x', '1.0000')
        assert pendant.stat('frame_errors') == 4

    def test_at_each_chunk(self):
        """An incomplete frame is sent again from its start."""
        pendant = self.plug()
        for skip in range(6):
            with row(skip=skip):
                pendant.settle()
                sent = len(pendant.device.set_reports)
                pendant.device.set_fault('stall', skip=skip, count=1)
                pendant.set('work_x', str(skip + 1))
                assert pendant.shows('work_x', '%d.0000' % (skip + 1))
                # up to the stall, then six
                assert len(pendant.device.set_reports) - sent == skip + 1 + 6
                assert pendant.stat('frame_errors') == skip + 1
        assert pendant.device.assembler.stray == 0

    def test_counters(self):
        pendant = self.plug()
        pendant.settle()
        assert (pendant.stat('frames_sent'), pendant.stat('frame_errors')) == (1, 0)
        pendant.set('flush', '1')
        assert (pendant.stat('frames_sent'), pendant.stat('frame_errors')) == (2, 0)
        pendant.device.set_fault('stall', count=1)
        pendant.set_error('flush', '1')
        assert (pendant.stat('frames_sent'), pendant.stat('frame_errors')) == (2, 1)

    def test_is_said_once(self):
        pendant = self.plug()
        pendant.settle()
        log = KernelLog()
        self.add_cleanup(log.close)
        pendant.device.fault = 'stall'
        pendant.set('work_x', '1')
        assert rig.wait(lambda: pendant.stat('frame_errors') >= 6)
        assert len([line for line in log.lines() if 'xhc' in line]) <= 1


class Clock(Case):
    """The clock is that of the test kernel."""

    def set_up(self):
        super().set_up()
        wall, steady = time.time(), time.monotonic()
        self.add_cleanup(lambda: time.clock_settime(
            time.CLOCK_REALTIME, wall + time.monotonic() - steady))

    @staticmethod
    def set_clock(*when):
        """year, month, day, hour, minute, second, in UTC"""
        seconds = int(time.mktime(when + (0, 0, 0))) - time.timezone
        time.clock_settime(time.CLOCK_REALTIME, seconds)


class TestCalendar(Clock):
    def test_midnight(self):
        for date, tomorrow in (((2026, 12, 31), 1), ((2028, 2, 28), 29), ((2027, 2, 28), 1),
                               ((2027, 4, 30), 1), ((2027, 5, 14), 15)):
            with row(date=date):
                self.set_clock(*date, 23, 59, 50)
                pendant = self.plug()
                assert pendant.device.lcd.day == date[2]
                assert pendant.no_more_frames(1)
                assert pendant.shows('day', tomorrow, 15), pendant.device.lcd.day
                assert pendant.no_more_frames(2)
                pendant.report(1)
                pendant.packet()
                assert pendant.stat('xor_mismatches') == 0
                assert pendant.get('day') == 'auto'
                pendant.unplug()

    def test_midnight_after_a_write(self):
        pendant = self.plug()
        self.set_clock(2027, 1, 9, 23, 59, 50)
        pendant.set('work_x', '1')
        assert pendant.shows('day', 9, 5)
        assert pendant.shows('day', 10, 15)

    def test_midnight_while_it_fails(self):
        self.set_clock(2027, 1, 9, 23, 59, 58)
        pendant = self.plug()
        pendant.device.fault = 'stall'
        time.sleep(4)
        pendant.device.fault = 'none'
        assert pendant.shows('day', 10, 70)

    def test_clock_that_is_set_past_midnight_is_noticed(self):
        self.set_clock(2027, 3, 5, 12, 0, 0)
        pendant = self.plug()
        assert pendant.device.lcd.day == 5
        self.set_clock(2027, 3, 17, 12, 0, 0)
        assert pendant.shows('day', 17)

    def test_clock_that_is_set_during_a_frame_is_noticed(self):
        self.set_clock(2027, 3, 5, 12, 0, 0)
        pendant = rig.Rig()
        days = []

        def set_before_the_answer(picture):
            if not days:
                self.set_clock(2027, 3, 17, 12, 0, 0)
            days.append(picture.day)

        pendant.device.on_frame = set_before_the_answer
        self.plug_rig(pendant)
        assert pendant.shows('day', 17)
        assert days == [5, 17]

    def test_clock_that_is_set_back_is_noticed_with_the_next_frame(self):
        self.set_clock(2027, 3, 17, 12, 0, 0)
        pendant = self.plug()
        assert pendant.device.lcd.day == 17
        self.set_clock(2027, 3, 5, 23, 59, 50)
        pendant.set('work_x', '1')
        assert pendant.shows('day', 5)
        assert pendant.shows('day', 6)          # and midnight is that of the time zone

    def test_a_day_that_was_set_stays(self):
        pendant = self.plug()
        pendant.set('day', '20')
        assert pendant.shows('day', 20)
        self.set_clock(2027, 1, 9, 23, 59, 58)
        pendant.set('work_x', '1')
        before = pendant.settle()
        assert pendant.no_more_frames(before, 130)
        assert pendant.device.lcd.day == 20

    def test_years_to_come(self):
        for year, month, day in ((2038, 1, 19), (2100, 2, 28), (2100, 3, 1)):
            self.set_clock(year, month, day, 12, 0, 0)
            pendant = self.plug()
            assert pendant.device.lcd.day == day
            pendant.unplug()


class Traced(Case):
    """With some events of the kernel in its trace"""

    ROOT = '/sys/kernel/tracing/'
    EVENTS = ()

    def set_up(self):
        super().set_up()
        if not rig.loaded():
            rig.load()
        self.forget()
        for event in self.EVENTS:
            enable = self.ROOT + 'events/%s/enable' % event
            rig.write_file(enable, '1')
            self.add_cleanup(rig.write_file, enable, '0')

    def forget(self):
        with open(self.ROOT + 'trace', 'w', encoding='ascii'):
            pass        # that it is truncated is what empties it

    def trace(self):
        return read_file(self.ROOT + 'trace').replace(' ', '')


class TestTracepoints(Traced):
    EVENTS = ('xhc',)

    @pytest.mark.distro
    def test_report(self):
        pendant = self.plug()
        pendant.report(1, 2, 0x11, -1, day=0)
        assert rig.wait(lambda: '04010211ff01' in self.trace())
        assert 'xhc_report:%s' % os.path.basename(pendant.path) in self.trace()

    @pytest.mark.distro
    def test_frame(self):
        pendant = self.plug()
        pendant.flush()
        frame = pendant.device.frames[-1][1][:pendant.device.model.frame_size]
        assert rig.wait(lambda: frame.hex() in self.trace())
        assert 'xhc_frame:%s' % os.path.basename(pendant.path) in self.trace()

    def test_frame_that_failed(self):
        pendant = self.plug()
        pendant.device.set_fault('stall', count=1)
        pendant.set_error('flush', '1')
        assert 'error=-5' in self.trace()


class TestWakeups(Clock, Traced):
    """When the worker of the display runs, and where"""

    EVENTS = ('workqueue/workqueue_queue_work', 'timer/hrtimer_expire_entry')

    def ours(self):
        """The times when the worker was queued, and when our timer went off"""
        return [line for line in self.trace().splitlines() if 'function=xhc_' in line]

    def test_transfers_are_on_the_queue_for_long_work(self):
        """A transfer may take seconds."""
        pendant = self.plug()
        self.forget()
        pendant.set('work_x', '1')
        pendant.settle()
        assert self.ours()
        for line in self.ours():
            assert 'function=xhc_dro_work' in line
            assert 'workqueue=events_long' in line

    def test_it_does_not_run_for_nothing(self):
        self.set_clock(2027, 3, 5, 12, 0, 0)
        pendant = self.plug()
        assert pendant.get('day') == 'auto'
        pendant.settle()
        self.forget()
        time.sleep(150)
        assert self.ours() == []
