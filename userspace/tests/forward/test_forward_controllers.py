# SPDX-License-Identifier: GPL-2.0-only
"""The forward channel on controllers with more limits than the virtual one has by default. Each is
a controller of mainline, with its name: it works, or it is refused with a message.
"""

import glob
import os
import struct
import time

import pytest
import forward_rig
import head_rig
from forward_rig import Case, unload_sim
from kernel import read_file, wait, write_file


def log():
    return head_rig.run('dmesg')[1]


class TestLatency(Case):
    @pytest.mark.parametrize('rate', (300, 1000, 10000, 100000, 200000))
    def test_one_scan(self, rate):
        """Written while the last position is repeated, it waits for the message being sent and for
        one more, of at most 1 ms or one frame each: it is on the wire within 2 ms.
        """
        forward = self.forward(4, 'line', more='realtime=1')
        assert forward.set('sampling_frequency', rate) is None
        stream = forward.stream()
        stream.write(struct.pack('<3I', 1000, 1000, 1000))
        for code in range(1, 20):
            assert wait(lambda code=code: forward.number('underruns') == code)
            forward.record(1000000, changes=False)
            stream.write(struct.pack('<3I', code, code, code))
            before = forward.sim_number('stats', 'recorded')
            assert wait(lambda code=code: forward.x_of('positions') == str(code))
            waited = list(memoryview(forward.recorded()).cast('I')[::3]).index(code) - before
            assert waited <= max(1, rate / 1000)
        stream.finish()


class TestControllers(Case):
    def sends(self, more, lines=4, framing='line', cs_word=0):
        """A position and a command are received correctly."""
        forward = self.forward(lines, framing, cs_word, more=more)
        assert forward.set('out_angl0_raw', 4321) is None
        assert forward.x_of('positions') == '4321'
        assert forward.bad_frames() == []
        return forward

    def refused(self, sentence, more, lines=4, framing='line', cs_word=0):
        self.sim(lines, framing, cs_word, more=more)
        assert wait(lambda: sentence in log()), log()[-2000:]
        assert glob.glob('/sys/bus/iio/devices/iio:device*') == []
        assert head_rig.heads() == []

    @pytest.mark.parametrize('modes', ('0,3', '0', 'all', 'claimed'))
    def test_crossed_clock(self, modes):
        """qcom-qspi, stm32-qspi, any, tegra210-quad: all work with the pair of CLK crossed."""
        self.sends('modes=%s clock_inverted=1' % modes)

    @pytest.mark.parametrize('modes', ('0,3', '0'))
    def test_no_mode_1(self, modes):
        self.refused('lasia,clock-inverted', 'modes=' + modes)

    def test_mode_1_claimed(self):
        """A driver that accepts mode 1 but uses mode 0 is only known by its name."""
        self.sim(4, 'line', more='modes=claimed driver=tegra-qspi')
        assert wait(lambda: 'known to send in SPI mode 0' in log())
        forward = self.channel()
        assert forward.set('out_angl0_raw', 4321) is None
        assert forward.bad_frames() != []

    @pytest.mark.parametrize('driver', ('mtk-spi', 'dw_spi_mmio', 'dw_spi_pci'))
    def test_lines_claimed(self, driver):
        """mt65xx up to 6.12 and dw in 7.3 accept four lines and use one."""
        self.sim(4, 'line', more='driven_lines=1 driver=' + driver)
        assert wait(lambda: 'known to use one data line' in log())
        forward = self.channel()
        assert forward.set('out_angl0_raw', 4321) is None
        assert forward.x_of('positions') != '4321'

    def test_short_words(self):
        """davinci and orion toggle the chip select for each word, and have no words of 24 bits."""
        self.sends('word_bits=16', 1, 'cs', 1)

    @pytest.mark.parametrize('us', (0, 50, 2000))
    @pytest.mark.parametrize('lines, framing', ((4, 'line'), (2, 'cs')))
    def test_messages_that_are_prepared(self, lines, framing, us):
        """spi-axi-spi-engine sleeps to prepare a message: never under a lock, and all are
        unprepared. Most others prepare nothing.
        """
        forward = self.forward(lines, framing, more='prepare_us=%d' % us)
        one = 4 * forward.axes
        for bits, rate in ((24, 100000), (32, 50000)):
            assert forward.set('frame_bits', bits) is None
            assert forward.set('sampling_frequency', rate) is None
            forward.record(2000)
            stream = forward.stream()
            for size in (1, 7, 256, 300, 1, 1):
                stream.write(bytes(one * size))
                write_file(forward.head + 'calibrate', 'x')
            stream.finish()
            assert wait(lambda: len(forward.recorded()) == one)
            assert forward.bad_frames() == []
        assert wait(lambda: forward.number('commands') == 12)
        forward.unbind()
        assert forward.sim_number('bus', 'prepared') == 0
        assert 'sleeping function' not in log()

    @pytest.mark.parametrize('lines, framing', ((4, 'line'), (8, 'line'), (4, 'cs')))
    @pytest.mark.parametrize('idle', ('keep', 'low', 'high', 'float'))
    def test_idle_lines(self, idle, lines, framing):
        """No frame is lost, for all levels of the lines between messages."""
        forward = self.forward(lines, framing, more='idle=' + idle)
        for bits in (24, 32):
            assert forward.set('frame_bits', bits) is None
            for code in range(1, 20):
                assert forward.set('out_angl0_raw', code) is None
                assert forward.x_of('positions') == str(code)
            write_file(forward.head + 'calibrate', 'x')
            forward.record(3000)
            stream = forward.stream()
            scans = b''.join(struct.pack('<I', i) * forward.axes for i in range(2000))
            for size in (1, 1, 300, 1698):
                stream.write(scans[:4 * forward.axes * size])
                scans = scans[4 * forward.axes * size:]
            stream.finish()
            assert [int(row.split()[0]) for row in forward.sim('record').splitlines()] == \
                list(range(2000))
        assert wait(lambda: len(forward.codes()) == 2)
        assert forward.bad_frames() == []

    @pytest.mark.parametrize('us', (None, 0, 200))
    def test_turnaround(self, us):
        """Every controller takes time between two messages, in which the lines do not change. It
        reduces the achieved rate.
        """
        forward = self.forward(4, 'line',
                               more='realtime=1' + (' turnaround_us=%d' % us if us is not None
                                                    else ''))
        us = 20 if us is None else us
        forward.set_sim('reset', 'counts')
        stream = forward.stream()
        scans = bytes(12 * 2048)
        for _ in range(60):
            stream.write(scans)
        achieved = forward.number('achieved_frequency')
        stream.finish()
        bus = {name: int(value) for name, value in
               (line.split() for line in forward.sim('bus').splitlines())}
        assert bus['turnaround_ns'] == us * 1000 * (bus['messages'] - 1)
        assert bus['longest_silence_ns'] >= us * 1000
        most = 100000 * 2560 / (2560 + us)
        assert most * 0.98 < achieved < most * 1.01

    def test_locked_bus(self):
        """Another device may lock the bus for some time: only time is lost."""
        forward = self.forward(4, 'line', more='realtime=1')

        def lock():
            forward.set_sim('bus_lock_ms', 100)

        lock()
        write_file(forward.head + 'calibrate', 'x')
        write_file(forward.head + 'calibrate', 'y')
        assert wait(lambda: forward.codes() == ['c0001', 'c0002'])
        forward.record(10000)
        stream = forward.stream()
        scans = [struct.pack('<3I', i, i, i) for i in range(2000)]
        stream.write(b''.join(scans[:1000]))
        lock()
        for number in range(1000, 2000, 50):
            stream.write(b''.join(scans[number:number + 50]))
            time.sleep(0.015)
        lock()
        time.sleep(0.05)
        stream.finish()
        assert forward.recorded() == b''.join(scans)
        lock()
        assert forward.set('out_angl0_raw', 7) is None
        assert forward.set('out_angl0_raw', 8) is None
        assert forward.x_of('positions') == '8'
        assert forward.number('bus_errors') == 0
        lock()
        write_file(forward.head + 'calibrate', 'z')
        forward.unbind()

    def test_abort_while_the_bus_is_locked(self):
        """Scans that wait for the bus are dropped, too, and the mirrors do not move."""
        forward = self.forward(4, 'line', more='realtime=1')
        scans = struct.pack('<3I', 7, 8, 9) * 1000
        assert forward.set('out_angl0_raw', 5) is None
        stream = forward.stream()
        for x in (5, 6):
            sent = forward.written()
            forward.set_sim('bus_lock_ms', 500)
            time.sleep(0.1)
            stream.write(scans)
            time.sleep(0.1)
            assert forward.set('abort', 1) is None
            time.sleep(0.6)
            assert forward.x_of('positions') == str(x)
            assert forward.written() == sent
            stream.write(struct.pack('<3I', 6, 8, 9))
            assert wait(lambda: forward.x_of('positions') == '6')
        repeated = forward.number('repeated')
        assert wait(lambda: forward.number('repeated') > repeated)
        stream.finish()
        assert forward.number('bus_errors') == 0

    def test_slowest_clock(self):
        """A divider has a maximum (spi-synquacer: 254): the supported rates are listed."""
        forward = self.forward(4, 'line', more='min_speed_hz=260000 max_speed_hz=5200000')
        for bits, lowest, highest in ((24, 10000, 200000), (32, 7648, 152941)):
            assert forward.set('frame_bits', bits) is None
            assert forward.get('sampling_frequency_available') == '[%d 1 %d]' % (lowest, highest)
            for rate, error in ((lowest - 1, 'ERANGE'), (lowest, None), (highest, None),
                                (highest + 1, 'ERANGE'), (0, 'ERANGE'), (-1, 'ERANGE'),
                                (lowest, None)):
                assert forward.set('sampling_frequency', rate) == error, rate
            assert forward.set('out_angl0_raw', 4321) is None
        # with short frames, which have fewer clocks, the lowest rate is higher
        assert forward.set('frame_bits', 24) is None
        assert forward.number('sampling_frequency') == 10000
        assert forward.bad_frames() == []

    @pytest.mark.parametrize('clock, highest, achieved', (
        ('divided', 30000000, 30000000 / 12 / 26),      # spi-bcm2835, spi-dw
        ('halved', 30000000, 30000000 / 16 / 26),       # spi-stm32
        ('setup', 5200000, 200000),                     # spi-stm32-qspi
        ('fixed', 5200000, 200000)))                    # spi-xilinx
    def test_clocks(self, clock, highest, achieved):
        """The rate is that of the actual clock of the controller, and it is reported."""
        forward = self.forward(4, 'line', more='realtime=1 turnaround_us=0 clock=%s max_speed_hz=%d'
                                               % (clock, highest))
        assert forward.set('sampling_frequency', 100000) is None
        count = int(achieved * 1.2)     # measures the mean over half a second twice
        forward.record(2 * count)
        stream = forward.stream()
        scans = b''.join(struct.pack('<3I', i, i, i) for i in range(count))
        for at in range(0, len(scans), 12 * 1024):
            stream.write(scans[at:at + 12 * 1024])
        assert achieved * 0.98 < forward.number('achieved_frequency') < achieved * 1.01
        stream.finish()
        assert forward.recorded() == scans
        assert forward.bad_frames() == []

    @pytest.mark.parametrize('clock, driver', (('setup', 'microchip,coreqspi'),
                                               ('fixed', 'xilinx_spi')))
    def test_clock_claimed(self, clock, driver):
        """A driver that ignores the clock of a transfer is only known by its name."""
        self.sim(4, 'line', more='clock=%s driver=%s' % (clock, driver))
        assert wait(lambda: 'known to send at one clock' in log())

    @pytest.mark.parametrize('driver', ('stm32-qspi', 'stm32-ospi'))
    def test_no_gpio_as_chip_select(self, driver):
        """These drivers never finish a plain transfer whose chip select is not a GPIO."""
        self.refused('chip select must be a GPIO: cs-gpios', 'driver=' + driver)

    @pytest.mark.parametrize('driver', ('amd_spi', 'amd_spi_pci'))
    def test_changed_messages(self, driver):
        """spi-amd shortens the messages that it sends, and these are sent many times."""
        self.refused('the controller changes messages', 'driver=' + driver)

    @pytest.mark.parametrize('driver', ('fsl_espi', 'sqi-pic32', 'ti-qspi'))
    def test_chip_select_claimed(self, driver):
        """These drivers send a message in one piece, which is not a frame."""
        def warnings():
            return log().count('known to ignore cs_change')

        before = warnings()
        self.sim(4, 'line', more='driver=' + driver)
        forward = self.channel()
        assert warnings() == before
        write_file(forward.spi + 'line_map', 'x y z u')
        assert wait(lambda: warnings() == before + 1)

    def test_priority(self):
        """Other work does not delay the next block to the controller."""
        forward = self.forward(4, 'line')
        thread = os.path.realpath(forward.spi).split('/')[-2]
        found = [path for path in glob.glob('/proc/[0-9]*/comm')
                 if read_file(path).strip() == thread]
        assert len(found) == 1, thread
        assert os.sched_getscheduler(int(found[0].split('/')[2])) == os.SCHED_FIFO

    def test_flash_only(self):
        """zynqmp-gqspi has only flash operations."""
        self.refused('the controller has flash operations only', 'flash_only=1')

    def test_short_transfers(self):
        """A scan with the gaps before and after it."""
        self.refused('the controller takes 17 bytes at a time, a scan has up to 18',
                     'max_transfer=17')
        unload_sim()
        self.refused('the controller takes 17 bytes at a time, a scan has up to 18',
                     'max_message=17')
        unload_sim()
        self.sends('max_transfer=18')

    @pytest.mark.parametrize('limit', ('max_transfer=100', 'max_message=510', 'max_message=70'))
    @pytest.mark.parametrize('lines, framing, cs_word',
                             ((4, 'line', 0), (4, 'cs', 0), (1, 'cs', 1)))
    def test_short_blocks(self, lines, framing, cs_word, limit):
        """spi-bcm63xx-hsspi accepts 510 bytes in a message, spi-amd 70: a stream is split into
        messages of this size.
        """
        forward = self.forward(lines, framing, cs_word, more=limit)
        for bits in (24, 32):
            assert forward.set('frame_bits', bits) is None
            forward.set_sim('reset', 'counts')
            forward.record(10000)
            stream = forward.stream()
            scans = b''.join(struct.pack('<I', i) * forward.axes for i in range(1, 3001))
            for at in range(0, len(scans), 1200 * forward.axes):
                stream.write(scans[at:at + 1200 * forward.axes])
            write_file(forward.head + 'calibrate', 'x')
            stream.finish()
            assert forward.recorded() == scans
            assert wait(lambda: len(forward.codes()) == 1)
            assert forward.sim_number('bus', 'failed_messages') == 0
        assert forward.bad_frames() == []

    def test_lowest_bit_first(self):
        """Firmware cannot change the bit order of the head."""
        self.sends('lsb_first=1')

    def test_lanes(self):
        """The first cell of an array of widths is not used alone. This kernel has no lanes."""
        self.refused('this kernel has no 4 lanes', 'lanes=4')


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
