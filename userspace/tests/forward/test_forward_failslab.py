# SPDX-License-Identifier: GPL-2.0-only
"""Each allocation of the forward channel fails once: bind, unbind, line map, buffer, positions.

For n = 1, 2, 3, ... the n-th allocation of a call fails, until the call has fewer allocations. The
call succeeds or fails cleanly; the previous state is restored, and the next try succeeds.
"""

import glob
import os
import select
import signal
import struct

import forward_rig
import head_rig
from failslab import (DRIVER_CORE, fail_all, function_range, module_range, setup_failslab,
                      walk)
from forward_rig import Case
from kernel import read_file, wait, write_file


class TestWalk(Case):
    def set_up(self):
        # a failure here is silent, but undone when the IIO device is removed
        setup_failslab(spared='software_node_notify')
        self.calls = 0

    def report(self, what, count, outcomes):
        print('    %s: %d allocations failed: %s' % (what, count, ', '.join(
            '%s %d' % item for item in sorted(outcomes.items()))))

    def works(self, forward):
        """All functions without faults: a position, a command, a stream."""
        forward.find()
        self.calls += 1
        assert forward.set('out_angl0_raw', self.calls) is None
        assert forward.x_of('positions') == str(self.calls)
        commands = forward.sim_number('stats', 'commands')
        write_file(forward.head + 'calibrate', 'x')
        assert wait(lambda: forward.sim_number('stats', 'commands') == commands + 1)
        data = struct.pack('<%dI' % (600 * forward.axes), *range(600 * forward.axes))
        forward.record(601)
        stream = forward.stream()
        stream.write(data)
        stream.finish()
        assert forward.recorded() == data

    def test_bind(self):
        forward = self.forward(2, 'cs')
        forward.unbind()
        bound = []

        def after(failure):
            there = failure is None
            assert len(head_rig.heads()) == int(there), failure
            assert len(glob.glob(forward.spi + 'iio:device*')) == int(there), failure
            assert len(glob.glob('/dev/iio:device*')) == int(there), failure
            assert os.path.exists(forward.spi + 'driver') == there
            if there:
                bound.append(True)
                if len(bound) % 64 == 1:        # it takes longer than the loop itself
                    self.works(forward)
                forward.unbind()

        count, outcomes = walk(forward.bind, after, DRIVER_CORE)
        self.report('bind', count, outcomes)
        assert count > 200
        assert outcomes.get('ENOMEM', 0) > 100
        forward.bind()
        self.works(forward)

    def test_unbind(self):
        """Unbinding must not allocate memory in any state. (Writing to sysfs does.)"""
        forward = self.forward(4, 'line')
        setup_failslab(*module_range('xy3_spi'))
        streams = []

        def begin():
            streams.append(forward.stream())
            streams[0].write(bytes(12 * 1000))

        def after(failure):
            assert failure is None
            stream = streams.pop()
            assert head_rig.error_name(stream.write, bytes(12)) == 'ENODEV'
            stream.close()
            assert head_rig.heads() == []
            forward.bind()
            forward.find()
            begin()

        begin()
        count, outcomes = walk(forward.unbind, after)
        self.report('unbind', count, outcomes)
        streams.pop().finish()
        self.works(forward)

    def test_line_map(self):
        """The result is the new one, or the old one."""
        forward = self.forward(2, 'cs')
        path = forward.spi + 'line_map'
        old, new = 'x y\n', 'x -\n'

        def after(failure):
            assert read_file(path) == (old if failure else new)
            forward.find()
            assert forward.axes == (2 if failure else 1)
            assert forward.set('out_angl0_raw', 5) is None
            write_file(path, old)

        count, outcomes = walk(lambda: write_file(path, new), after)
        self.report('line map', count, outcomes)
        assert outcomes.get('ENOMEM', 0) > 50
        self.works(forward)

    def test_line_map_without_memory_for_the_old_one(self):
        """There is no IIO device until the next change: commands fail, and no writer waits."""
        forward = self.forward(2, 'cs')
        path = forward.spi + 'line_map'
        tty = os.open('/dev/xy3-0', os.O_RDWR | os.O_NOCTTY)
        self.add_cleanup(os.close, tty)
        with fail_all(*function_range('xy3_iio_register')):
            assert head_rig.error_name(write_file, path, 'x -') == 'ENOMEM'
        assert glob.glob(forward.spi + 'iio:device*') == []
        assert head_rig.polled(tty, select.POLLOUT, 0) == select.POLLOUT
        frame = head_rig.wire.command_frame('calibrate', 'x')
        writer = os.fork()
        if not writer:
            os._exit(head_rig.error_name(os.write, tty, frame) != 'ENODEV')
        try:
            assert wait(lambda: os.waitid(os.P_PID, writer, os.WEXITED | os.WNOHANG | os.WNOWAIT))
        finally:
            os.kill(writer, signal.SIGKILL)
            status = os.waitpid(writer, 0)[1]
        assert status == 0
        assert head_rig.error_name(write_file, forward.head + 'calibrate', 'x') == 'ENODEV'
        write_file(path, 'x y')
        self.works(forward)

    def test_buffer(self):
        forward = self.forward(8, 'cs')
        assert forward.start(length=2000) is None
        assert forward.stop() is None

        def after(failure):
            assert forward.get('buffer/enable') == ('0' if failure else '1')
            if failure:
                assert forward.set('out_angl0_raw', 7) is None
            else:
                assert forward.stop() is None

        count, outcomes = walk(lambda: write_file(forward.iio + 'buffer/enable', '1'), after)
        self.report('buffer', count, outcomes)
        assert outcomes.get('ENOMEM', 0) > 20
        self.works(forward)

    def test_position(self):
        forward = self.forward(4, 'cs')
        assert forward.set('out_angl0_raw', 1) is None

        def after(failure):
            code = '1' if failure else '2'
            assert forward.get('out_angl0_raw') == code
            assert forward.x_of('positions') == code
            assert forward.set('out_angl0_raw', 1) is None

        count, outcomes = walk(lambda: write_file(forward.iio + 'out_angl0_raw', '2'), after)
        self.report('position', count, outcomes)
        assert outcomes.get('ENOMEM', 0) > 1
        self.works(forward)

    def test_stream(self):
        """A running stream and commands allocate no memory, so that none can fail."""
        forward = self.forward(4, 'line')
        setup_failslab(*module_range('xy3_spi'))
        stream = forward.stream()
        data = bytes(12 * 3000)
        command = os.open(forward.head + 'calibrate', os.O_WRONLY)
        self.add_cleanup(os.close, command)
        stream.write(data)              # the first write makes one-time allocations

        def attempt():
            assert stream.write(data) == len(data)
            assert os.pwrite(command, b'x', 0) == 1

        def after(failure):
            assert failure is None

        count, outcomes = walk(attempt, after)
        assert (count, outcomes) == (0, {})
        stream.finish()
        self.works(forward)


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
