# SPDX-License-Identifier: GPL-2.0-only
"""The forward channel in a closed loop: the virtual head receives what is written to the IIO
device, in order, on all arrangements of lines; and commands, rates, errors of the controller.
"""

import errno
import glob
import os
import random
import select
import signal
import struct
import threading
import time

import pytest
import forward_rig
import head_rig
from forward_rig import ARRANGEMENTS, Case
from head_rig import error_name, polled
from kernel import read_file, wait, write_file


class TestClosedLoop(Case):
    @pytest.mark.parametrize('bits', (24, 32))
    @pytest.mark.parametrize('lines, framing, cs_word', ARRANGEMENTS)
    def test_every_scan(self, lines, framing, cs_word, bits):
        scans = 20000 if framing == 'line' else 3000
        forward = self.forward(lines, framing, cs_word)
        assert forward.set('frame_bits', bits) is None
        chance = random.Random(lines * 100 + bits)
        top = (1 << (26 if bits == 32 else 20)) - 1
        codes = [chance.randint(0, top) for _ in range(scans * forward.axes)]
        forward.record(scans + 2)
        stream = forward.stream()
        one = 4 * forward.axes
        stream.write_all(struct.pack('<%dI' % len(codes), *codes),
                         lambda: one * chance.choice((1, 10, 255, 256, 257, 4000)))
        stream.finish()
        want = [' '.join(map(str, codes[i:i + forward.axes]))
                for i in range(0, len(codes), forward.axes)]
        assert len(forward.sim('record').splitlines()) == scans
        assert forward.sim('record').splitlines() == want
        assert forward.bad_frames() == []
        last = [int(line.split()[1]) for line in forward.sim('positions').splitlines()]
        assert last == codes[-forward.axes:]
        assert forward.number('scans') - forward.number('repeated') == scans
        assert forward.number('bus_errors') == 0

    def test_positions_while_a_stream_runs(self):
        """Those that the controller has, not pending ones; also while it is being disabled."""
        forward = self.forward(4, 'line', more='realtime=1')
        assert forward.set('sampling_frequency', 1000) is None
        assert forward.set('out_angl0_raw', 0) is None
        stream = forward.stream()
        scans = b''.join(struct.pack('<3I', i, 7, 0) for i in range(4000))
        assert stream.write(scans) == len(scans)
        assert forward.number('out_angl0_raw') < 2000
        assert wait(lambda: forward.number('out_angl0_raw') > 2000)
        assert forward.number('out_angl0_raw') < 3999
        assert forward.set('abort', 1) is None
        assert wait(lambda: forward.number('repeated') > 0)
        assert forward.x_of('positions') == forward.get('out_angl0_raw') != '3999'
        # a disabled axis keeps the position sent last
        stream.finish()
        stream = forward.stream(axes=(1,))
        stream.write(struct.pack('<I', 9))
        stream.finish()
        assert forward.x_of('positions') == forward.get('out_angl0_raw') != '3999'
        assert forward.number('out_angl1_raw') == 9

    def test_one_axis_left_out(self):
        forward = self.forward(4, 'line')
        assert forward.set('out_angl1_raw', 777) is None
        forward.record(100)
        stream = forward.stream(axes=(0, 2))
        stream.write(struct.pack('<6I', 1, 2, 3, 4, 5, 6))
        stream.finish()
        assert forward.sim('record').splitlines() == ['1 777 2', '3 777 4', '5 777 6']

    @pytest.mark.parametrize('bits', (24, 32))
    def test_out_of_the_field(self, bits):
        """Clamped to the nearest edge, never to the opposite one; and counted."""
        last = (1 << {24: 20, 32: 26}[bits]) - 1
        forward = self.forward(1, 'cs')
        assert forward.set('frame_bits', bits) is None
        forward.record(10)
        stream = forward.stream()
        stream.write(struct.pack('<2I4i', last, 0, last + 1, -1, 0x7fffffff, -0x80000000))
        stream.finish()
        assert forward.number('clamped_codes') == 4
        assert [int(row) for row in forward.sim('record').split()] == [last, 0, last, 0, last, 0]

    def test_begins_in_the_middle(self):
        """Setting an axis, or streaming to it, does not move the others to a corner."""
        forward = self.forward(4, 'cs')
        assert forward.get('out_angl1_raw') == str(1 << 19)
        forward.record(10)
        assert forward.set('out_angl0_raw', 5) is None
        assert forward.set('frame_bits', 32) is None
        assert forward.set('out_angl1_raw', 6) is None
        middle = (1 << 19, 1 << 25)
        assert forward.sim('record').splitlines() == [
            '5 %d %d %d' % (middle[0], middle[0], middle[0]),
            '%d 6 %d %d' % (5 << 6, middle[1], middle[1])]

    def test_late_writer(self):
        """One underrun each time that it is late, independent of the delay."""
        forward = self.forward(4, 'line', more='realtime=1')
        stream = forward.stream()
        for round_ in range(1, 4):
            stream.write(struct.pack('<3I', round_, 0, 0) * 300)
            # more than the controller had received in the last round
            enough = forward.number('repeated') + 1000
            assert wait(lambda enough=enough: forward.number('repeated') > enough)
            assert forward.number('underruns') == round_
            assert forward.x_of('positions') == str(round_)
        stream.finish()

    def test_underruns_are_notified(self):
        """The start of each, to pollers and as uevents; nothing else."""
        forward = self.forward(4, 'line', more='realtime=1')
        poller = head_rig.AttributePoller(forward.iio + 'underruns')
        self.add_cleanup(poller.close)
        events = head_rig.Uevents(('iio',))
        self.add_cleanup(events.close)
        stream = forward.stream()
        events.take()
        assert not poller.changed(0.3)
        for number in (1, 2):
            stream.write(struct.pack('<3I', 1, 2, 3) * 300)
            assert poller.changed(5)
            assert poller.read() == '%d\n' % number
            assert events.properties() == [{'EVENT': 'underrun'}]
            assert not poller.changed(0.3)      # the same one continues
        stream.finish()

    def test_many_underruns(self):
        """Notified in groups, and the last one is never lost."""
        forward = self.forward(4, 'line', more='realtime=1')
        poller = head_rig.AttributePoller(forward.iio + 'underruns')
        self.add_cleanup(poller.close)
        events = head_rig.Uevents(('iio',))
        self.add_cleanup(events.close)
        stream = forward.stream()
        events.take()
        for number in range(1, 101):
            stream.write(struct.pack('<3I', 1, 2, 3))
            assert wait(lambda number=number: forward.number('underruns') == number)
        assert wait(lambda: poller.changed(5) and poller.read() == '100\n')
        assert 1 <= len(events.properties()) < 50
        stream.finish()

    @pytest.mark.parametrize('way', ('unbind', 'line_map'))
    def test_pollers_of_underruns_learn_of_the_removal(self, way):
        """A new line map removes the IIO device, too."""
        forward = self.forward(4, 'line')
        poller = head_rig.AttributePoller(forward.iio + 'underruns')
        self.add_cleanup(poller.close)
        watcher = head_rig.Background(poller.removed)
        time.sleep(0.3)                         # it is in poll() now
        if way == 'unbind':
            forward.unbind()
        else:
            write_file(forward.spi + 'line_map', 'sync x y gate')
        assert watcher.result() is True

    def test_writes_that_are_no_scans(self):
        forward = self.forward(4, 'line')
        stream = forward.open(os.O_NONBLOCK)
        assert error_name(stream.write, b'\0' * 12) == 'EINVAL'   # no stream
        assert forward.start() is None
        assert error_name(stream.write, b'\0' * 11) == 'EINVAL'
        assert stream.write(b'\0' * 12) == 12
        stream.finish()


class TestSettings(Case):
    def test_one_position(self):
        forward = self.forward(4, 'cs')
        assert [forward.get('out_angl%d_label' % i) for i in range(4)] == list('xyzu')
        for axis, code in enumerate((0, 1, 0xfffff, 0x12345)):
            assert forward.set('out_angl%d_raw' % axis, code) is None
            assert forward.number('out_angl%d_raw' % axis) == code
        assert forward.sim('positions').splitlines() == \
            ['x 0 20', 'y 1 20', 'z %d 20' % 0xfffff, 'u %d 20' % 0x12345]
        assert forward.set('out_angl0_raw', 1 << 20) == 'ERANGE'
        assert forward.set('out_angl0_raw', -1) == 'ERANGE'
        assert forward.set('out_angl0_raw', 'left') == 'EINVAL'
        assert forward.set('frame_bits', 32) is None
        assert forward.number('out_angl3_raw') == 0x12345 << 6
        assert forward.set('out_angl0_raw', (1 << 26) - 1) is None
        assert forward.x_of('positions') == str((1 << 26) - 1)
        assert forward.set('frame_bits', 28) == 'EINVAL'

    def test_not_while_a_stream_runs(self):
        forward = self.forward(4, 'line')
        assert forward.start() is None
        for name, value in (('out_angl0_raw', 1), ('frame_bits', 32),
                            ('sampling_frequency', 1000)):
            assert forward.set(name, value) == 'EBUSY', name
        assert error_name(write_file, forward.spi + 'line_map', 'x') == 'EBUSY'
        assert forward.stop() is None

    def test_rate(self):
        forward = self.forward(4, 'line', more='max_speed_hz=5200000 realtime=1')
        assert forward.number('sampling_frequency') == 100000
        for rate in (1, 199999, 200000):
            assert forward.set('sampling_frequency', rate) is None
        for rate in (0, -5, 200001):
            assert forward.set('sampling_frequency', rate) == 'ERANGE', rate
        assert forward.set('frame_bits', 32) is None      # 34 clocks: slower
        assert forward.number('sampling_frequency') == 5200000 // 34

    def test_line_map(self):
        forward = self.forward(4, 'cs')
        path = forward.spi + 'line_map'
        assert read_file(path) == 'x y z u\n'
        for text in ('', 'y z', 'x x', 'x q', 'x y z u w', 'sync', 'x y z u -'):
            assert error_name(write_file, path, text + '\n') == 'EINVAL', text
            assert read_file(path) == 'x y z u\n'
        write_file(path, 'sync w - x\n')
        assert read_file(path) == 'sync w - x\n'
        forward.set_sim('signals', 'sync w - x')
        forward.find()
        assert [forward.get('out_angl%d_label' % i) for i in range(2)] == ['x', 'w']
        assert forward.set('out_angl0_raw', 5) is None
        assert forward.set('out_angl1_raw', 6) is None
        assert forward.sim('positions').splitlines() == ['x 5 20', 'w 6 20']

    def test_line_map_keeps_positions_and_rate(self):
        forward = self.forward(4, 'cs')
        assert forward.set('out_angl0_raw', 5) is None
        assert forward.set('out_angl2_raw', 7) is None
        assert forward.set('sampling_frequency', 1234) is None
        for signals, codes in (('sync x y u', (5, 1 << 19, 1 << 19)), ('z - - x', (5, 7))):
            write_file(forward.spi + 'line_map', signals + '\n')
            forward.find()
            assert tuple(forward.number('out_angl%d_raw' % i)
                         for i in range(forward.axes)) == codes
            assert forward.get('sampling_frequency') == '1234'

    def test_suspend_stops_a_stream(self):
        """Pending scans are dropped; another start begins a new stream."""
        forward = self.forward(4, 'line', more='realtime=1')
        assert forward.set('sampling_frequency', 1000) is None
        write_file('/sys/module/suspend/parameters/pm_test_delay', '0')
        write_file('/sys/power/pm_test', 'devices')
        stream = forward.stream()
        assert stream.write(struct.pack('<3I', 1, 2, 3) * 4000) == 48000
        assert error_name(write_file, '/sys/power/state', 'freeze') is None
        scans = forward.number('scans')
        assert scans < 2000
        assert error_name(stream.write, b'\0' * 12) == 'ESHUTDOWN'
        assert error_name(write_file, forward.head + 'calibrate', 'x') == 'ESHUTDOWN'
        assert forward.number('scans') == scans     # no scans are sent
        assert forward.number('bus_errors') == 0
        assert forward.stop() is None
        assert forward.start() is None
        stream.write(struct.pack('<3I', 4, 5, 6))
        stream.finish()
        assert forward.x_of('positions') == '4'
        assert error_name(write_file, '/sys/power/state', 'freeze') is None
        assert forward.set('out_angl0_raw', 5) is None

    def test_another_drivers_device(self):
        """A device with another name in firmware, as on boards with /dev/spidevB.C."""
        self.sim(1, 'cs', more='modalias=spidev')
        device = read_file(forward_rig.DEBUGFS + '0/devices').split()[1]
        write_file('/sys/bus/spi/devices/%s/driver_override' % device, 'xy3-spi')
        write_file(forward_rig.DRIVER + 'bind', device)
        forward = self.channel()
        assert forward.axes == 1
        assert forward.set('out_angl0_raw', 4321) is None
        assert forward.x_of('positions') == '4321'

    def test_controller_with_fewer_lines(self):
        self.sim(1, 'cs', more='device_lines=4')
        assert wait(lambda: 'the controller has no 4 data lines' in head_rig.run('dmesg')[1])
        assert glob.glob('/sys/bus/iio/devices/iio:device*') == []
        assert head_rig.heads() == []

    def test_links_to_the_transports(self):
        forward = self.forward(2, 'cs')

        def links():
            return {name: os.path.basename(os.path.realpath(forward.head + name))
                    for name in ('back', 'forward') if os.path.islink(forward.head + name)}

        assert links() == {'forward': forward.device}
        assert forward.attach()
        both = {'back': 'ttyXY3SIM0', 'forward': forward.device}
        assert links() == both
        forward.unbind()
        assert links() == {'back': 'ttyXY3SIM0'}
        forward.bind()
        assert links() == both
        forward.close()
        assert wait(lambda: links() == {'forward': forward.device}), links()


class TestCommands(Case):
    def test_attributes(self):
        forward = self.forward(2, 'cs')
        for name, text, want in (('autocalib', 'on xy', ('80003', 'autocalib on xy')),
                                 ('autocalib', 'off', ('40000', 'autocalib off xyzuw')),
                                 ('temp_comp', 'on w', ('88010', None)),
                                 ('temp_comp', 'off all', ('48000', None)),
                                 ('calibrate', 'z', ('c0004', None)),
                                 ('reference', '\n', ('20000', None))):
            write_file(forward.head + name, text)
            assert wait(lambda want=want: forward.codes()[-1:] == [want[0]]), \
                (name, text, forward.commands())
            if want[1]:
                assert ' '.join(forward.commands()[-1][1:]) == want[1]

    @pytest.mark.parametrize('bits', (24, 32))
    @pytest.mark.parametrize('lines, framing', ((2, 'cs'), (4, 'cs'), (4, 'line'), (8, 'line')))
    def test_frames_of_the_other_axes(self, lines, framing, bits):
        """During a command they have the same length, and no effect."""
        forward = self.forward(lines, framing)
        assert forward.set('frame_bits', bits) is None
        assert forward.set('out_angl1_raw', 6) is None
        for _ in range(3):
            write_file(forward.head + 'calibrate', 'x')
        assert wait(lambda: len(forward.codes()) == 3)
        assert forward.bad_frames() == []
        assert forward.number('out_angl1_raw') == 6

    def test_frames_by_the_tty(self):
        forward = self.forward(1, 'cs')
        fd = os.open('/dev/xy3-0', os.O_RDWR | os.O_NOCTTY)
        self.add_cleanup(os.close, fd)
        frames = b''.join(head_rig.wire.command_frame(name, 'x', bits)
                          for name, bits in (('calibrate', 24), ('reference', 32)))
        assert os.write(fd, frames) == 7
        assert error_name(os.write, fd, frames[:5]) == 'EINVAL'
        # if any of those five bytes were sent, it would arrive before this one
        assert os.write(fd, head_rig.wire.command_frame('reference', 'y')) == 3
        assert wait(lambda: forward.codes()[-1:] == ['20002'])
        assert forward.codes() == ['c0001', '20001', '20002']

    def test_more_frames_than_fit(self):
        """A blocking write is complete; poll() and O_NONBLOCK agree about free space."""
        forward = self.forward(1, 'cs')
        fd = os.open('/dev/xy3-0', os.O_RDWR | os.O_NOCTTY)
        self.add_cleanup(os.close, fd)
        frame = head_rig.wire.command_frame('calibrate', 'x')
        assert os.write(fd, frame * 1000) == 3000
        assert wait(lambda: forward.number('commands') == 1000)
        os.set_blocking(fd, False)
        sent = 1000
        while sent < 2000:
            assert polled(fd, select.POLLOUT, 20) == select.POLLOUT
            sent += os.write(fd, frame * (2000 - sent)) // 3
        assert wait(lambda: forward.number('commands') == 2000)
        assert set(forward.codes()) == {'c0001'}

    @pytest.mark.parametrize('frames, times', (((24,), 25000), ((24, 32), 10000)),
                             ids=('24 bits', '24 and 32 bits'))
    def test_a_long_write(self, frames, times):
        """The tty core passes pieces of 64 KiB, which end within a frame."""
        forward = self.forward(1, 'cs')
        fd = os.open('/dev/xy3-0', os.O_RDWR | os.O_NOCTTY)
        self.add_cleanup(os.close, fd)
        data = b''.join(head_rig.wire.command_frame('calibrate', 'x', bits=bits)
                        for bits in frames) * times
        assert len(data) > 65536
        assert os.write(fd, data) == len(data)
        assert wait(lambda: forward.number('commands') == len(frames) * times)
        assert set(forward.codes()) == {'c0001'}

    def test_in_the_middle_of_a_stream(self):
        forward = self.forward(4, 'line')
        scans = 30000
        forward.record(scans + 1)
        stream = forward.stream()
        for part in range(30):
            stream.write(b''.join(struct.pack('<3I', part * 1000 + i, i, part)
                                  for i in range(1000)))
            write_file(forward.head + 'calibrate', 'x')
        stream.finish()
        assert wait(lambda: forward.number('commands') == 30)
        assert forward.sim('record').splitlines() == \
            ['%d %d %d' % (n, n % 1000, n // 1000) for n in range(scans)]
        assert 'commands 30' in forward.sim('stats')
        assert forward.x_of('parity_errors') == '0'

    def test_rates(self):
        forward = self.forward(4, 'line')
        assert forward.attach()
        for rate in (230400, 921600, 57600, 460800, 115200):
            status, text = head_rig.run('stty', '-F', '/dev/xy3-0', str(rate))
            assert (status, text) == (0, '')
            assert wait(lambda rate=rate: read_file(forward.head + 'rate') == '%d\n' % rate), rate
            assert forward.sim('rate') == str(rate)
            assert wait(lambda: read_file(forward.head + 'in_sync') == '1\n'), rate


class TestBackchannel(Case):
    def uart(self):
        uart = head_rig.Pty()
        self.add_cleanup(uart.close)
        head_rig.set_ldisc(uart.slave, head_rig.LDISC)
        return uart

    def test_the_uart_goes(self):
        """The state of components is unknown then; they have not recovered."""
        forward = self.forward(1, 'cs')
        wire = head_rig.wire
        lost = [{'EVENT': 'sync', 'IN_SYNC': '0'}, {'EVENT': 'identity'},
                {'EVENT': 'error', 'COMPONENT': 'dsp', 'ERROR': 'unknown'}]
        found = [{'EVENT': 'sync', 'IN_SYNC': '1'}, {'EVENT': 'identity'},
                 {'EVENT': 'error', 'COMPONENT': 'dsp', 'ERROR': 'temperature',
                  'ERROR_CODE': '1'}]
        events = head_rig.Uevents()
        self.add_cleanup(events.close)
        for _ in range(2):
            uart = self.uart()
            uart.write(head_rig.GOOD + wire.vendor(b'ACME') + wire.errors([0, 1]))
            assert events.properties() == found
            assert read_file(forward.head + 'errors/dsp') == 'temperature\n'
            uart.cut()
            assert events.properties() == lost
            assert error_name(read_file, forward.head + 'errors/dsp') == 'ENODATA'
            assert error_name(read_file, forward.head + 'errors/head') == 'ENODATA'
        self.uart().write(head_rig.GOOD + wire.errors([0, 0]))
        assert events.properties() == [
            found[0], {'EVENT': 'error', 'COMPONENT': 'dsp', 'ERROR': 'none', 'ERROR_CODE': '0'}]


class TestAbort(Case):
    SCANS = 4096
    DATA = struct.pack('<3I', 1, 2, 3) * SCANS
    RATE = 200      # sending the written scans takes 20 s

    def slow_stream(self):
        forward = self.forward(4, 'line', more='realtime=1')
        assert forward.set('sampling_frequency', self.RATE) is None
        return forward, forward.stream()

    def disable(self, forward):
        """Disables in another process -> its pid"""
        child = os.fork()
        if not child:
            os._exit(forward.stop() is not None)
        return child

    def ended(self, child):
        """-> exit status, before all could have been sent"""
        start = time.monotonic()
        status = os.waitpid(child, 0)[1]
        assert time.monotonic() - start < self.SCANS / self.RATE / 2
        return status

    def test_abort(self):
        forward, stream = self.slow_stream()
        assert stream.write(self.DATA) == len(self.DATA)
        assert forward.set('abort', 1) is None
        assert forward.number('buffer/data_available') == 0
        assert wait(lambda: forward.number('repeated') > 0)
        assert forward.written() < self.SCANS / 2
        assert stream.write(struct.pack('<3I', 7, 8, 9)) == 12      # it is running
        stream.finish()
        assert forward.x_of('positions') == '7'

    def test_frames_after_an_abort(self):
        """Three blocks are with the controller, of four frames each at a low rate."""
        self.RATE = 10
        forward, stream = self.slow_stream()
        stream.write(self.DATA)
        assert forward.set('abort', 1) is None
        assert wait(lambda: forward.number('repeated') > 0)
        assert forward.written() <= 12
        stream.finish()

    def test_abort_of_a_write_that_waits(self):
        """All of it is dropped, not only the part in the buffer; and nothing of the next one."""
        forward, stream = self.slow_stream()
        scans = self.DATA + struct.pack('<3I', 4, 5, 6) * self.SCANS * 4
        taken = []
        writer = threading.Thread(target=lambda: taken.append(stream.write(scans)), daemon=True)
        writer.start()
        assert wait(lambda: forward.number('buffer/data_available') > self.SCANS * 3 // 2)
        time.sleep(0.5)                                     # no space for the rest
        assert forward.set('abort', 1) is None
        writer.join(60)
        assert taken == [len(scans)]
        assert forward.number('buffer/data_available') == 0
        assert wait(lambda: forward.number('repeated') > 0)
        assert forward.x_of('positions') == '1'
        assert stream.write(struct.pack('<3I', 7, 8, 9)) == 12
        stream.finish()
        assert forward.x_of('positions') == '7'

    def test_abort_is_written_only(self):
        forward = self.forward(4, 'line')
        assert os.stat(forward.iio + 'abort').st_mode & 0o777 == 0o200
        for text in ('0', 'x', ''):
            assert forward.set('abort', text + '\n') == 'EINVAL', text
        assert forward.set('abort', 1) is None          # without a stream

    def test_abort_ends_disabling(self):
        forward, stream = self.slow_stream()
        stream.write(self.DATA)
        child = self.disable(forward)
        time.sleep(0.5)
        assert forward.set('abort', 1) is None
        assert self.ended(child) == 0
        assert forward.written() < self.SCANS / 2

    def test_killed_while_disabling(self):
        forward, stream = self.slow_stream()
        stream.write(self.DATA)
        child = self.disable(forward)
        time.sleep(0.5)
        os.kill(child, signal.SIGKILL)
        self.ended(child)
        assert forward.get('buffer/enable') == '0'
        assert forward.written() < self.SCANS / 2

    def test_suspend_while_disabling(self):
        """Neither the freezer nor the device waits until all scans have been sent."""
        forward, stream = self.slow_stream()
        write_file('/sys/module/suspend/parameters/pm_test_delay', '0')
        write_file('/sys/power/pm_test', 'devices')
        stream.write(self.DATA)
        child = self.disable(forward)
        time.sleep(0.5)
        assert error_name(write_file, '/sys/power/state', 'freeze') is None
        assert self.ended(child) == 0
        assert forward.written() < self.SCANS / 2
        assert forward.set('out_angl0_raw', 5) is None

    def test_write_while_disabling(self):
        """A writer does not wait until all scans have been sent."""
        forward, stream = self.slow_stream()
        stream.write(self.DATA)
        disabling = self.disable(forward)
        time.sleep(0.5)
        writer = os.fork()
        if not writer:
            os._exit(error_name(stream.write, self.DATA) != 'EINVAL')
        try:
            assert self.ended(writer) == 0
        finally:
            forward.set('abort', 1)
            self.ended(disabling)

    def test_unbinding_drops(self):
        forward, stream = self.slow_stream()
        stream.write(self.DATA)
        start = time.monotonic()
        forward.unbind()
        assert time.monotonic() - start < self.SCANS / self.RATE / 2
        assert error_name(stream.write, self.DATA) == 'ENODEV'
        stream.close()
        forward.bind()
        forward.find()


class TestErrors(Case):
    def test_controller_error(self):
        forward = self.forward(4, 'line')
        logged = 'the controller has not sent a block: error %d' % -errno.EIO
        before = head_rig.run('dmesg')[1].count(logged)
        stream = forward.stream()
        forward.set_sim('faults/spi_error_in', 3)
        with pytest.raises(OSError) as caught:
            for _ in range(100000):
                stream.write(b'\0' * 12 * 256)
        assert caught.value.errno == errno.EIO
        # neither a refused command nor remaining positions are sent later
        assert error_name(write_file, forward.head + 'calibrate', 'x') == 'EIO'
        assert head_rig.run('dmesg')[1].count(logged) == before + 1
        assert forward.stop() is None
        scans = forward.number('scans')     # the controller has no data of the stream any more
        for more, (axis, code) in enumerate((('y', '20002'), ('z', '20004')), 1):
            write_file(forward.head + 'reference', axis)
            assert wait(lambda: forward.codes()[-1:] == [code])
            assert wait(lambda: forward.number('scans') >= scans + more)
        assert forward.codes() == ['20002', '20004']
        assert forward.number('scans') == scans + 2
        assert forward.number('bus_errors') == 1
        assert forward.start() is None      # a new stream can start
        assert stream.write(b'\0' * 12) == 12
        stream.finish()
        forward.set_sim('faults/spi_error_in', 1)
        assert forward.set('out_angl0_raw', 5) == 'EIO'
        assert forward.number('out_angl0_raw') == 0
        assert forward.set('out_angl0_raw', 5) is None

    def test_positions_after_an_error(self):
        """Positions that the controller has never received are not reported."""
        forward = self.forward(4, 'line', more='realtime=1')
        assert forward.set('sampling_frequency', 2000) is None
        for axis in range(3):
            assert forward.set('out_angl%d_raw' % axis, 500) is None
        stream = forward.stream()
        forward.set_sim('faults/spi_error_in', 2)
        scans = b''.join(struct.pack('<3I', 1000 + i, 2000 + i, 3000) for i in range(2000))
        assert stream.write(scans) == len(scans)
        assert wait(lambda: forward.number('bus_errors') == 1)
        assert forward.stop() is None
        x, y, z = (forward.number('out_angl%d_raw' % axis) for axis in range(3))
        assert 1000 < x < 2999
        assert (y, z) == (x + 1000, 3000)
        assert forward.set('out_angl0_raw', 5) is None
        assert forward.sim('positions').splitlines() == ['x 5 20', 'y %d 20' % y, 'z 3000 20']

    def test_start_and_stop(self):
        forward = self.forward(4, 'line')
        stream = forward.open()
        for n in range(300):
            assert forward.start(length=1024) is None
            stream.write(struct.pack('<3I', n, n, n) * (n % 7 * 100 + 1))
            assert forward.stop() is None
            assert forward.x_of('positions') == str(n)

    def test_unbound_in_the_middle_of_a_stream(self):
        forward = self.forward(4, 'line')
        for _ in range(20):
            stream = forward.stream()
            stream.write(b'\1\0\0\0' * 3 * 5000)
            forward.unbind()
            assert error_name(stream.write, b'\0' * 12) == 'ENODEV'
            assert head_rig.heads() == []
            stream.close()
            forward.bind()
            forward.find()


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
