# SPDX-License-Identifier: GPL-2.0-only
"""The gate of the laser: no scan is sent with the gate high unless the writer has set it, no matter
how a stream ends or its writer is delayed. It is not an interlock.
"""

import os
import random
import signal
import struct

import pytest
import forward_rig
from forward_rig import Case
from head_rig import error_name
from kernel import wait, write_file

ARRANGEMENTS = ((2, 'cs', 'x gate'), (4, 'cs', 'gate x - y'), (4, 'line', 'sync x y gate'),
                (8, 'line', 'sync x y z u w gate -'))
MIDDLE = 1 << 19


def packed(scans):
    return b''.join(struct.pack('<%dI' % len(scan), *scan) for scan in scans)


def high(count, first=1):
    """Scans of X and Y with the gate set, all at different positions."""
    return [(first + i, MIDDLE, 1) for i in range(count)]


class GateCase(Case):
    def gated(self, lines=4, framing='line', signals='sync x y gate', more=''):
        """A virtual head with a gate, with all channels enabled in its disabled buffer."""
        forward = self.forward(lines, framing, more=more)
        forward.set_sim('signals', signals)
        write_file(forward.spi + 'line_map', signals)
        forward.find()
        return forward

    def stream(self, forward, gate=True, **options):
        assert forward.set('scan_elements/out_voltage0_en', int(gate)) is None
        return forward.stream(**options)

    def gate(self, forward, name):
        return forward.sim_number('gate', name)

    def is_low(self, forward):
        """The level of the line, between scans and after the last one."""
        return wait(lambda: self.gate(forward, 'high') == 0)

    def judge(self, forward, written):
        """Checks the record: written scans, in order, and repetitions with the gate low.
        -> number of written scans received
        """
        rows = [tuple(map(int, line.split())) for line in forward.sim('record').splitlines()]
        done = 0
        for number, row in enumerate(rows):
            if done < len(written) and row == written[done]:
                done += 1
            else:
                assert done and row == (*written[done - 1][:-1], 0), 'row %d: %s' % (number, row)
        assert self.gate(forward, 'torn') == 0
        assert self.gate(forward, 'commands') == 0
        return done


class TestGate(GateCase):
    @pytest.mark.parametrize('lines, framing, signals', ARRANGEMENTS)
    def test_every_scan(self, lines, framing, signals):
        forward = self.gated(lines, framing, signals)
        chance = random.Random(lines)
        written = [(*(chance.randrange(1 << 20) for _ in range(forward.axes)),
                    chance.randrange(2)) for _ in range(3000)] + [(5,) * forward.axes + (1,)]
        forward.record(10000)
        stream = self.stream(forward)
        one = 4 * (forward.axes + 1)
        stream.write_all(packed(written), lambda: one * chance.choice((1, 10, 255, 256, 257)))
        stream.finish()
        assert self.judge(forward, written) == len(written)
        assert self.gate(forward, 'scans') == sum(scan[-1] for scan in written)
        assert self.is_low(forward)
        assert forward.bad_frames() == []

    def test_channel(self):
        forward = self.gated()
        assert forward.get('out_voltage0_label') == 'gate'
        assert not os.path.exists(forward.iio + 'out_voltage0_raw')
        assert forward.get('scan_elements/out_voltage0_type') == 'le:u1/32>>0'
        assert forward.axes == 2

    def test_nothing_but_one_raises_it(self):
        forward = self.gated()
        stream = self.stream(forward)
        stream.write(packed([(1, 2, gate) for gate in (0, 2, 3, 0x80000001, 0xffffffff, 256)]))
        stream.finish()
        assert self.gate(forward, 'scans') == 0

    def test_not_part_of_the_buffer(self):
        forward = self.gated()
        stream = self.stream(forward, gate=False)
        stream.write(struct.pack('<4I', 1, 1, 2, 1))
        stream.finish()
        assert forward.x_of('positions') == '2'
        assert self.gate(forward, 'scans') == 0


class TestLow(GateCase):
    def test_late_writer(self):
        forward = self.gated()
        written = high(300)
        forward.record(10000)
        stream = self.stream(forward)
        stream.write(packed(written))
        assert wait(lambda: forward.number('repeated') > 200)
        assert self.is_low(forward)
        assert self.gate(forward, 'scans') == 300
        written += high(300, 1000)
        stream.write(packed(written[300:]))
        stream.finish()
        assert self.judge(forward, written) == 600
        assert self.gate(forward, 'scans') == 600
        assert self.is_low(forward)

    @pytest.mark.parametrize('lines, framing, signals', ARRANGEMENTS[:3])
    def test_stop(self, lines, framing, signals):
        """Immediately after the last scan, without time for a repetition."""
        forward = self.gated(lines, framing, signals)
        for count in (1, 2, 256, 700):
            stream = self.stream(forward)
            stream.write(packed([scan[-forward.axes - 1:] for scan in high(count)]))
            stream.finish()
            assert self.gate(forward, 'high') == 0

    def test_single_position(self):
        forward = self.gated()
        stream = self.stream(forward)
        stream.write(packed(high(10)))
        stream.finish()
        assert forward.set('out_angl0_raw', 77) is None
        assert forward.x_of('positions') == '77'
        assert self.gate(forward, 'scans') == 10
        assert self.gate(forward, 'high') == 0

    @pytest.mark.parametrize('message', (1, 2, 5))
    def test_controller_error(self, message):
        """The writer gets the error; the gate is low before that."""
        forward = self.gated()
        stream = self.stream(forward)
        forward.set_sim('faults/spi_error_in', message)
        data = packed(high(256))
        error = None
        for _ in range(100):
            error = error_name(stream.write, data)
            if error in ('EIO', 'ETIMEDOUT', 'EREMOTEIO'):
                break
        assert forward.number('bus_errors') >= 1
        assert self.is_low(forward)
        stream.close()
        forward.stop()
        assert self.gate(forward, 'high') == 0
        assert self.gate(forward, 'torn') == 0

    def test_unbound(self):
        forward = self.gated()
        for _ in range(5):
            stream = self.stream(forward)
            stream.write(packed(high(2000)))
            forward.unbind()
            assert self.gate(forward, 'high') == 0
            stream.close()
            forward.bind()
            write_file(forward.spi + 'line_map', 'sync x y gate')
            forward.find()

    def test_suspended(self):
        forward = self.gated(more='realtime=1')
        write_file('/sys/module/suspend/parameters/pm_test_delay', '0')
        write_file('/sys/power/pm_test', 'devices')
        stream = self.stream(forward)
        stream.write(packed(high(4000)))
        write_file('/sys/power/state', 'freeze')
        assert self.gate(forward, 'high') == 0
        assert 0 < self.gate(forward, 'scans') < 4000
        stream.finish()
        assert self.gate(forward, 'high') == 0

    @pytest.mark.parametrize('lines, framing, signals', ARRANGEMENTS[:3])
    def test_suspended_while_disabling(self, lines, framing, signals):
        """The line is low while the devices are suspended, not only when the stream has ended."""
        forward = self.gated(lines, framing, signals, more='realtime=1 idle=keep')
        assert forward.set('sampling_frequency', 200) is None
        write_file('/sys/module/suspend/parameters/pm_test_delay', '5')
        write_file('/sys/power/pm_test', 'devices')
        stream = self.stream(forward)
        stream.write(packed([scan[-forward.axes - 1:] for scan in high(4000)]))
        child = os.fork()
        if not child:
            os._exit(forward.stop() is not None)
        assert wait(lambda: forward.number('scans') > 100)
        forward.set_sim('reset', 'counts')
        write_file('/sys/power/state', 'freeze')
        assert os.waitpid(child, 0) == (child, 0)
        assert self.gate(forward, 'high') == 0
        assert forward.number('scans') < 2000
        # nothing is sent after the suspend, which takes five seconds
        assert forward.sim_number('bus', 'longest_silence_ns') < 1e9

    def test_aborted(self):
        forward = self.gated(more='realtime=1')
        written = high(4000)
        forward.record(10000)
        stream = self.stream(forward)
        stream.write(packed(written))
        assert forward.set('abort', 1) is None
        assert self.is_low(forward)
        stream.finish()
        assert 0 < self.judge(forward, written) < 4000
        assert self.gate(forward, 'high') == 0

    def test_killed_writer(self):
        forward = self.gated(more='realtime=1')
        stream = self.stream(forward)
        child = os.fork()
        if not child:
            while True:
                os.write(stream.fd, packed(high(512)))
        assert wait(lambda: self.gate(forward, 'scans') > 3000)
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        assert self.is_low(forward)
        stream.finish()
        assert self.gate(forward, 'high') == 0

    def test_commands(self):
        forward = self.gated()
        stream = self.stream(forward)
        for _ in range(20):
            stream.write(packed(high(300)))
            write_file(forward.head + 'autocalib', 'on')
        stream.finish()
        assert wait(lambda: forward.number('commands') == 20)
        assert self.gate(forward, 'commands') == 0
        assert self.gate(forward, 'scans') == 6000

    def test_many_scans(self):
        """The head receives all scans written with the gate high, over pauses and new starts."""
        forward = self.gated()
        chance = random.Random(12)
        asked = 0
        for _ in range(20):
            stream = self.stream(forward)
            for _ in range(chance.randrange(1, 20)):
                count = chance.randrange(1, 1500)
                gate = chance.randrange(2)
                stream.write(packed([(i, MIDDLE, gate) for i in range(count)]))
                asked += count * gate
                if chance.randrange(3) == 0:
                    late = forward.number('repeated')
                    assert wait(lambda late=late: forward.number('repeated') > late)
            stream.finish()
            assert self.gate(forward, 'high') == 0
        assert self.gate(forward, 'scans') == asked
        assert self.gate(forward, 'torn') == 0


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
