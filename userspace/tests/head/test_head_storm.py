# SPDX-License-Identifier: GPL-2.0-only
"""Heads are attached and removed at any time, more than a thousand times, during all operations.

The verdict checks for errors: no report of KASAN, lockdep or any other checker, no leak. The tests
themselves check that the operations took place, and that received data are counted exactly.
"""

import contextlib
import errno
import functools
import os
import random
import select
import threading
import time

import head_rig
import kernel
from head_rig import (CLASS, LDISC, N_TTY, Background, Case, Pty, error_name, heads, polled,
                      set_ldisc, set_speed, wait)
from kernel import read_file, write_file
from stress_users import StressUsers
from xy3_head_sim import faults, head, line, simulator, wire

READS = ('vendor', 'in_sync', 'rate', 'stats/rx_bytes', 'stats/lost_packets', 'errors/dsp',
         'hours/head', 'frame_errors/x', 'byte_order', 'uevent')
WRITES = (('byte_order', 'big'), ('byte_order', 'little'), ('autobaud', '1'), ('autobaud', '0'),
          ('calibrate', 'x'), ('uevent', 'change'), *(('rate', str(rate)) for rate in wire.RATES))
PACKETS = (wire.sync(), wire.sync(), wire.vendor('ACME'), wire.vendor('Other'), wire.hours([5]),
           wire.temperatures([2500]), wire.temperatures([None, 2600, -2600]),
           wire.errors([0, 1]), wire.errors([1, 0, 200]), wire.frame_errors([1, 2, 3, 4, 5]),
           wire.packet(0x20, b'unknown'), wire.debug('x' * 200), b'junk', b'\x48\x07')
PAUSE = 0.003               # seconds between two steps in the life of a head
USER_PAUSE = 0.02           # and between two actions of a user, on one CPU
# permitted errors of a user whose head is removed
TOLERATED = {errno.ENOENT, errno.EIO, errno.ENXIO, errno.EAGAIN, errno.ENODEV, errno.EINVAL,
             errno.ENODATA}


class HeadUsers(StressUsers):
    """Threads that use any heads present."""

    def __init__(self, seed):
        actions = (self.reads, self.writes, self.receives, self.polls, self.rates)
        super().__init__([self.of_a_head(action) for action in actions], TOLERATED, USER_PAUSE,
                         seed)
        self.done.update(opens=0, bytes=0)

    @staticmethod
    def of_a_head(action):
        """Runs the action with a present head; without one it fails as if the head was removed."""
        @functools.wraps(action)
        def act(dice):
            found = heads()
            if not found:
                raise FileNotFoundError(errno.ENOENT, 'no head')
            action(dice, dice.choice(found))
        return act

    def reads(self, dice, name):
        read_file('%s/%s/%s' % (CLASS, name, dice.choice(READS)))

    def writes(self, dice, name):
        attribute, text = dice.choice(WRITES)
        write_file('%s/%s/%s' % (CLASS, name, attribute), text)

    @contextlib.contextmanager
    def open(self, name):
        fd = os.open('/dev/' + name, os.O_RDWR | os.O_NONBLOCK | os.O_NOCTTY)
        self.done['opens'] += 1
        try:
            yield fd
        finally:
            os.close(fd)

    def receives(self, _dice, name):
        """The first bytes read are the start of a packet."""
        data = b''
        with self.open(name) as fd:
            for _ in range(5):
                if polled(fd, select.POLLIN, 0.01) & select.POLLIN:
                    more = os.read(fd, 1 << 16)
                    data += more
                    if not more:
                        break
        self.done['bytes'] += len(data)
        if data and data[0] != wire.START:
            self.unexpected.append('the first byte is %#x' % data[0])

    def polls(self, _dice, name):
        with self.open(name) as fd:
            if polled(fd, select.POLLPRI, 0.02) & select.POLLHUP:
                os.read(fd, 1)
            frame = wire.command_frame('reference', 'x')
            # without a forward channel; EIO: the head was removed
            assert error_name(os.write, fd, frame) in ('ENODEV', 'EIO')

    def rates(self, dice, name):
        with self.open(name) as fd:
            set_speed(fd, dice.choice(wire.RATES + (9600,)))


class TestStorm(Case):
    def check(self, users):
        print('    %s' % users)
        assert users.unexpected == []
        assert users.all_done(21), users

    def calm(self):
        """Checks the state afterwards: no head is left, and a new one works."""
        assert wait(lambda: not heads())
        head = self.synced()
        assert head.name == 'xy3-0'
        reader = head.open()
        head.send(wire.vendor('ACME'))
        assert reader.rest() == wire.vendor('ACME')
        assert head.get('vendor') == 'ACME'
        head.close()

    def cycle(self, dice):
        """The complete life of a head."""
        uart = Pty()
        try:
            set_ldisc(uart.slave, LDISC)
            for _ in range(dice.randrange(4)):
                uart.write(head_rig.GOOD + b''.join(dice.choices(PACKETS, k=20)))
                time.sleep(dice.random() * PAUSE)
            how = dice.randrange(4)
            if how == 0:
                set_ldisc(uart.slave, N_TTY)
            elif how == 1:
                set_speed(uart.slave, dice.choice(wire.RATES))
            elif how == 2:
                set_ldisc(uart.slave, N_TTY)
                set_ldisc(uart.slave, LDISC)        # again at once, often with the same number
        finally:
            uart.close()

    def cycles(self, seed, number, done):
        dice = random.Random(seed)
        for _ in range(number):
            self.cycle(dice)
            done.append(seed)

    def test_attach_and_detach(self):
        done = []
        with HeadUsers(1) as users:
            workers = [Background(self.cycles, seed, 350, done) for seed in (10, 20, 30)]
            for worker in workers:
                worker.result(600)
        assert len(done) == 1050
        self.check(users)
        self.calm()

    def test_hangup_under_load(self):
        """A waiting reader receives the data sent up to some byte, and then end of file."""
        dice = random.Random(2)
        stream = wire.sync() + b''.join(
            wire.debug(b'%06d' % number + b'.' * dice.randrange(190)) for number in range(600))
        ends = []
        for _ in range(60):
            head = self.attach()
            head.uart.write(wire.sync())
            reader = head.open()
            os.set_blocking(reader.fd, True)
            received = Background(self.until_the_end, reader.fd)
            size = dice.randrange(len(stream))
            head.uart.write(stream[:size])
            if dice.random() < 0.5:
                time.sleep(dice.random() * 0.002)
            head.uart.cut()
            data = received.result()
            start = 3 if data.startswith(wire.sync() * 2) else 0
            assert (wire.sync() + stream).startswith(data) or stream.startswith(data[start:])
            ends.append(len(data))
            head.close()
        assert len(set(ends)) > 20
        self.calm()

    @staticmethod
    def until_the_end(fd):
        """-> all data read up to a hangup"""
        data = b''
        while more := os.read(fd, 4096):
            data += more
        return data

    @staticmethod
    def unloads():
        return head_rig.error_name(kernel.unload_module, head_rig.MODULE) is None

    def test_module_comes_and_goes(self):
        """insmod and rmmod while UARTs are attached at the same time."""
        dice, stop, attached = random.Random(3), threading.Event(), []

        def attach():
            while not stop.is_set():
                uart = Pty()
                try:
                    set_ldisc(uart.slave, LDISC)
                    attached.append(True)
                    uart.write(head_rig.GOOD)
                except OSError:
                    pass
                time.sleep(dice.random() * PAUSE)
                uart.close()
                time.sleep(PAUSE)

        threads = [Background(attach) for _ in range(2)]
        try:
            for number in range(400):
                if number >= 40 and len(attached) > 20:
                    break
                assert wait(self.unloads, step=0.0005)
                assert not kernel.is_loaded(head_rig.MODULE)
                head_rig.load()
                time.sleep(dice.random() * 0.01)
        finally:
            stop.set()
        for thread in threads:
            thread.result()
        assert len(attached) > 20
        self.calm()


class TestStreams(Case):
    """Complete streams of the simulator; its counts must equal those of the driver."""

    def start(self, seed, **how):
        """-> a simulated head, the attached UART, and a reader, not running yet"""
        sim_head = head.Head(interval=0, sync_interval=0, seed=seed)
        uart = self.closing(line.Pty())
        sim = simulator.Simulator(sim_head, uart)
        slave = self.opened(uart.name, os.O_RDWR | os.O_NOCTTY)
        before = heads()
        set_ldisc(slave, LDISC)
        name = next(name for name in heads() if name not in before)
        reader = self.closing(head_rig.Reader('/dev/' + name))

        def run():
            sim.wait_open(10)
            sim.stream(timeout=300, **how)

        return sim_head, name, Background(reader.rest, 2.0), run

    def finish(self, sim_head, name, received, streamed):
        streamed.result(400)
        receiver = sim_head.counts()['receiver']
        stats = {stat: int(read_file('%s/%s/stats/%s' % (CLASS, name, stat)))
                 for stat in head_rig.STATS}
        assert wait(lambda: int(read_file('%s/%s/stats/rx_bytes' % (CLASS, name))) ==
                             sim_head.counts()['bytes']), stats
        data = received.result()
        stats = {stat: int(read_file('%s/%s/stats/%s' % (CLASS, name, stat)))
                 for stat in head_rig.STATS}
        assert stats == {
            'rx_bytes': receiver['packet_bytes'] + receiver['dropped'] + receiver['kept'],
            'rx_packets': receiver['packets'], 'syncs': receiver['syncs'],
            'resyncs': receiver['resyncs'], 'dropped_bytes': receiver['dropped'],
            'bad_lengths': receiver['bad_lengths'], 'unknown_packets': receiver['unknown'],
            'line_errors': 0, 'lost_packets': 0}
        packets = head_rig.split(data)
        assert len(packets) == receiver['packets']
        assert len(data) == receiver['packet_bytes']
        return receiver

    def test_two_at_once(self):
        """Exact counts, and each packet was received by the reader of its head."""
        both = [self.start(seed, packets=4000) for seed in (1, 2)]
        streamed = [Background(run) for *_, run in both]
        for (*one, _), thread in zip(both, streamed):
            receiver = self.finish(*one, thread)
            assert receiver['packets'] >= 4000
            assert receiver['resyncs'] == 0

    def test_faults_at_full_speed(self):
        """All kinds of faults of the simulator, at random."""
        *one, run = self.start(3, packets=6000)
        for kind in faults.KINDS:
            if kind != 'wrong-rate':
                one[0].faults.set(kind, '1/60')
        receiver = self.finish(*one, Background(run))
        assert receiver['resyncs'] > 100
        assert receiver['bad_lengths'] > 50
        assert receiver['unknown'] > 50

    def test_garbage_at_full_speed(self):
        """Random bytes: all are dropped except those that look like packets by chance."""
        dice = random.Random(4)
        head = self.attach()
        reader, decoder = head.open(), wire.Decoder()
        letters = bytes((0x48, 0x48, 0x48, 0x41, 0x41, 0x00, 0x00, 0x07, 0x05, 0x01, 0xFF, 0x20))
        expected = b''
        for number in range(40):
            data = (dice.randbytes(8192) if number % 4 == 0
                    else bytes(dice.choices(letters, k=8192)))
            head.send(data)
            expected += b''.join(wire.packet(*packet) for packet in decoder.feed(data))
        assert reader.rest() == expected
        self.assert_counts(head, decoder)
        assert decoder.packets > 100
        assert decoder.resyncs > 100
