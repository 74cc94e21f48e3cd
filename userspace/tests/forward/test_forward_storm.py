# SPDX-License-Identifier: GPL-2.0-only
"""All operations on a forward channel at the same time: streams, commands, settings, rates, and the
driver unbound from the device and bound again.

The verdict checks the result: no report of KASAN, lockdep or any other checker, no leak.
The tests themselves make sure that things did happen, and that all works when it is over.
"""

import errno
import glob
import os
import select
import struct
import time

import forward_rig
import head_rig
from forward_rig import Case
from head_rig import wire
from kernel import read_file, wait, write_file
from stress_users import StressUsers

SECONDS = 5             # minimum duration of a storm
LEAST = 5               # minimum number of successes of each action
PAUSE = 0.002
# X, Y and a gate
GATED = struct.pack('<15000I', *(n for x in range(5000) for n in (x * 12345 % (1 << 20), 5, x & 1)))
# errors for a user whose device is removed, or used by others
TOLERATED = {errno.ENODEV, errno.ENOENT, errno.ENXIO, errno.EBUSY, errno.EINVAL, errno.EAGAIN,
             errno.EIO, errno.ETIMEDOUT, errno.ERANGE, errno.EPERM}


class TestStorm(Case):
    def set_up(self):
        self.head = None

    def device(self):
        found = glob.glob('/sys/bus/iio/devices/iio:device*')
        if not found:
            raise FileNotFoundError(errno.ENOENT, 'no IIO device')
        return found[0] + '/'

    def open(self, flags=0):
        return os.open('/dev/' + os.path.basename(self.device()[:-1]), os.O_WRONLY | flags)

    # ---- what the users do ----

    def writes(self, dice):
        fd = self.open()
        try:
            os.write(fd, dice.randbytes(12 * dice.choice((1, 100, 256, 3000))))
        finally:
            os.close(fd)

    def polls(self, dice):
        fd = self.open(os.O_NONBLOCK)
        try:
            head_rig.polled(fd, select.POLLOUT, 0.01)
            os.write(fd, dice.randbytes(12 * 200))
        finally:
            os.close(fd)

    def enables(self, dice):
        device = self.device()
        for axis in range(len(glob.glob(device + 'out_angl*_raw'))):
            if not dice.randrange(10):
                write_file(device + 'scan_elements/out_angl%d_en' % axis,
                           str(dice.randrange(2)))
        if dice.randrange(2):
            write_file(device + 'buffer/length', str(dice.choice((2, 1000, 5000))))
        write_file(device + 'buffer/enable', '1')

    def disables(self, dice):
        time.sleep(dice.random() / 10)
        write_file(self.device() + 'buffer/enable', '0')

    def aborts(self, dice):
        time.sleep(dice.random() / 10)
        write_file(self.device() + 'abort', '1')

    def moves(self, dice):
        write_file(self.device() + 'out_angl%d_raw' % dice.randrange(3),
                   str(dice.randrange(1 << 20)))

    def sets(self, dice):
        name, value = dice.choice((('frame_bits', 24), ('frame_bits', 32),
                                   ('sampling_frequency', 50000),
                                   ('sampling_frequency', 100000)))
        write_file(self.device() + name, str(value))

    def maps(self, dice):
        time.sleep(dice.random() / 5)
        write_file(self.head.spi + 'line_map', dice.choice(('sync x y z', 'sync x - y',
                                                            'sync z y x')))

    def reads(self, dice):
        device = self.device()
        for name in ('out_angl0_raw', 'underruns', 'achieved_frequency', 'frame_bits',
                     'sampling_frequency', 'out_angl1_label', 'buffer/data_available'):
            if dice.randrange(2):
                read_file(device + name)
        read_file(self.head.counters + 'scans')
        read_file(self.head.spi + 'line_map')

    def commands(self, dice):
        if dice.randrange(2):
            write_file(self.head.head + dice.choice(('calibrate', 'reference')), 'x')
            return
        fd = os.open('/dev/xy3-0', os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            os.write(fd, wire.command_frame('calibrate', 'x', 32) * dice.randrange(1, 30))
        finally:
            os.close(fd)

    def rates(self, dice):
        write_file(self.head.head + 'rate', str(dice.choice(wire.RATES)))

    def rebinds(self, dice):
        time.sleep(dice.random() / 5)
        self.head.unbind()
        time.sleep(dice.random() / 50)
        self.head.bind()

    # with a gate: of these scans, those with an odd X have it high

    def gate_writes(self, dice):
        first = dice.randrange(2000)
        count = dice.choice((1, 100, 256, 3000))
        fd = self.open()
        try:
            os.write(fd, GATED[12 * first:12 * (first + count)])
        finally:
            os.close(fd)

    def gate_enables(self, dice):
        device = self.device()
        for name in ('angl0', 'angl1', 'voltage0'):
            write_file(device + 'scan_elements/out_%s_en' % name, '1')
        write_file(device + 'buffer/length', str(dice.choice((2, 1000, 5000))))
        write_file(device + 'buffer/enable', '1')

    def errors(self, dice):
        time.sleep(0.05)
        self.head.set_sim('faults/spi_error_in', dice.randrange(1, 5))

    # ---- the storms ----

    def calm(self, forward):
        """After a storm, a stream is received."""
        forward.set_sim('faults/spi_error_in', 0)
        head_rig.error_name(forward.bind)       # it may be unbound
        forward.find()
        forward.stop()
        write_file(forward.spi + 'line_map', 'sync x y z')
        forward.find()
        assert forward.set('frame_bits', 24) is None
        forward.set_sim('reset', 'power')
        forward.record(2001)
        stream = forward.stream()
        data = struct.pack('<6000I', *range(6000))
        stream.write(data)
        stream.finish()
        assert forward.recorded() == data
        assert forward.bad_frames() == []

    def users(self, *actions):
        return StressUsers(actions, TOLERATED, PAUSE)

    def storm(self, forward, *actions, calm=None):
        self.head = forward
        with self.users(*actions) as users:
            time.sleep(SECONDS)
            users.wait_done(LEAST, 240)
        print('    %s' % users)
        assert users.unexpected == []
        assert users.all_done(LEAST), users
        (calm or self.calm)(forward)

    def test_streams_and_commands(self):
        """The device stays bound: all data on the wire are correct."""
        forward = self.forward(4, 'line')
        assert forward.attach()
        self.storm(forward, self.writes, self.polls, self.enables, self.disables, self.aborts,
                   self.moves, self.sets, self.reads, self.commands, self.rates)

    def test_line_maps(self):
        forward = self.forward(4, 'line')
        self.storm(forward, self.writes, self.enables, self.disables, self.aborts, self.maps,
                   self.sets, self.reads, self.commands, self.moves)

    def test_unbind(self):
        forward = self.forward(4, 'line')
        assert forward.attach()
        self.storm(forward, self.writes, self.polls, self.enables, self.disables, self.aborts,
                   self.moves, self.sets, self.maps, self.reads, self.commands, self.rates,
                   self.rebinds)

    def test_on_a_slow_wire(self):
        """With pending messages during all operations, and errors of the controller."""
        forward = self.forward(4, 'line', more='realtime=1')
        self.storm(forward, self.writes, self.polls, self.enables, self.disables, self.aborts,
                   self.moves, self.sets, self.reads, self.commands, self.rebinds, self.errors)

    def test_enabled_and_disabled(self):
        """By two users at the same time, while a third one writes all the time."""
        forward = self.forward(4, 'line', more='realtime=1')
        assert forward.start() is None
        self.storm(forward, self.writes, self.enables, self.disables, self.aborts)

    def gate_is_right(self, forward):
        """No scan had the gate high that the writer has not asked for it."""
        forward.stop()
        assert wait(lambda: forward.sim_number('gate', 'high') == 0)
        assert forward.sim_number('gate', 'torn') == 0
        assert forward.sim_number('gate', 'commands') == 0
        numbers = memoryview(forward.recorded()).cast('I')
        high = [x for x, gate in zip(numbers[::3], numbers[2::3]) if gate]
        print('    %d scans, %d with the gate high' % (len(numbers) // 3, len(high)))
        assert len(high) > 1000
        assert all(x % 2 for x in high)

    def test_gate(self):
        forward = self.forward(4, 'line', more='realtime=1 signals=sync,x,y,gate')
        forward.record(1000000)
        self.storm(forward, self.gate_writes, self.gate_enables, self.disables, self.aborts,
                   self.moves, self.reads, self.commands, self.errors, calm=self.gate_is_right)

    def test_module_goes(self):
        """The controller is removed with all operations in progress."""
        for round_ in range(5):
            self.head = self.forward(4, 'line', more='realtime=%d' % (round_ % 2))
            assert self.head.start() is None
            with self.users(self.writes, self.commands, self.enables, self.disables,
                            self.aborts, self.reads) as users:
                sent = wait(lambda: self.head.number('scans') > 5000)
                forward_rig.unload_sim()
            assert sent
            assert users.unexpected == []
            assert head_rig.heads() == []


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
