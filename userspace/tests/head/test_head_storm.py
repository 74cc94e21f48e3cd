# SPDX-License-Identifier: GPL-2.0-only
"""Heads that come and go at any instant, more than a thousand times, with everything in flight.

What is looked for is in the verdict: no report of KASAN, lockdep or any other checker, no leak.
The tests themselves make sure that things did happen, and that what arrives is counted exactly.
"""

import os
import random
import select
import termios
import threading
import time

import head_rig
import kernel
from head_rig import CLASS, LDISC, N_TTY, Case, Pty, heads, polled, set_ldisc, set_speed, wait
from kernel import read_file, write_file
from xy3_head_sim import faults, head, line, simulator, wire

READS = ('vendor', 'in_sync', 'rate', 'stats/rx_bytes', 'stats/lost_packets', 'errors/dsp',
         'hours/head', 'frame_errors/x', 'byte_order', 'uevent')
WRITES = (('byte_order', 'big'), ('byte_order', 'little'), ('autobaud', '1'), ('autobaud', '0'),
          ('calibrate', 'x'), ('uevent', 'change'), *(('rate', str(rate)) for rate in wire.RATES))
PACKETS = (wire.sync(), wire.sync(), wire.vendor('ACME'), wire.vendor('Other'), wire.hours([5]),
           wire.temperatures([2500]), wire.temperatures([None, 2600, -2600]),
           wire.errors([0, 1]), wire.errors([1, 0, 200]), wire.frame_errors([1, 2, 3, 4, 5]),
           wire.packet(0x20, b'unknown'), wire.debug('x' * 200), b'junk', b'\x48\x07')
PAUSE = 0.003               # seconds between two doings of a head
CROWD_PAUSE = 0.02          # and of a thread of the crowd: there is one processor only


class Crowd:
    """Threads that use whatever heads there are, from all sides, until told to stop."""

    def __init__(self, seed):
        self.dice = random.Random(seed)
        self.stop = threading.Event()
        self.counts = dict.fromkeys(('reads', 'writes', 'bytes', 'opens', 'rates', 'frames'), 0)
        self.strange = []           # errors that nobody must see
        self.threads = [threading.Thread(target=self._run, args=(work,), daemon=True) for work in
                        (self._read, self._write, self._listen, self._poll, self._rates)]

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.stop.set()
        for thread in self.threads:
            thread.join(30)
            if thread.is_alive():
                self.strange.append('a thread hangs')

    def _run(self, work):
        while not self.stop.is_set():
            found = heads()
            if found:
                try:
                    work(self.dice.choice(found))
                except (OSError, termios.error) as error:
                    if not isinstance(error, OSError):
                        error = OSError(*error.args)
                    if error.errno not in (2, 5, 6, 11, 19, 22, 61):
                        self.strange.append('%s: %s' % (work.__name__, error))
            time.sleep(CROWD_PAUSE)

    def _read(self, name):
        read_file('%s/%s/%s' % (CLASS, name, self.dice.choice(READS)))
        self.counts['reads'] += 1

    def _write(self, name):
        attribute, text = self.dice.choice(WRITES)
        write_file('%s/%s/%s' % (CLASS, name, attribute), text)
        self.counts['writes'] += 1

    def _open(self, name):
        fd = os.open('/dev/' + name, os.O_RDWR | os.O_NONBLOCK | os.O_NOCTTY)
        self.counts['opens'] += 1
        return fd

    def _listen(self, name):
        """Only whole packets come, up to a hangup."""
        fd, data = self._open(name), b''
        try:
            for _ in range(5):
                if polled(fd, select.POLLIN, 0.01) & select.POLLIN:
                    more = os.read(fd, 1 << 16)
                    if not more:
                        return
                    data += more
        finally:
            os.close(fd)
            self.counts['bytes'] += len(data)
        if data and data[0] != wire.START:
            self.strange.append('the first byte is %#x' % data[0])

    def _poll(self, name):
        fd = self._open(name)
        try:
            self.counts['frames'] += 1
            if polled(fd, select.POLLPRI, 0.02) & select.POLLHUP:
                os.read(fd, 1)
            os.write(fd, wire.command_frame('reference', 'x'))
        finally:
            os.close(fd)

    def _rates(self, name):
        fd = self._open(name)
        try:
            set_speed(fd, self.dice.choice(wire.RATES + (9600,)))
            self.counts['rates'] += 1
        finally:
            os.close(fd)


class TestStorm(Case):
    def check(self, crowd):
        print('    %s' % ', '.join('%d %s' % (count, what)
                                   for what, count in crowd.counts.items()))
        assert crowd.strange == []
        for what, count in crowd.counts.items():
            assert count > 20, what

    def calm(self):
        """Afterwards all is as before: no head is left, and a new one works."""
        assert wait(lambda: not heads())
        head = self.synced()
        assert head.name == 'xy3-0'
        reader = head.open()
        head.send(wire.vendor('ACME'))
        assert reader.rest() == wire.vendor('ACME')
        assert head.get('vendor') == 'ACME'
        head.close()

    def cycle(self, dice):
        """A head's whole life."""
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
                set_ldisc(uart.slave, LDISC)        # at once again, the same number as often as not
        finally:
            uart.close()

    def cycles(self, seed, number, done):
        dice = random.Random(seed)
        for _ in range(number):
            self.cycle(dice)
            done.append(seed)

    def test_attach_and_detach(self):
        done = []
        with Crowd(1) as crowd:
            workers = [threading.Thread(target=self.cycles, args=(seed, 350, done))
                       for seed in (10, 20, 30)]
            for worker in workers:
                worker.start()
            for worker in workers:
                worker.join()
        assert len(done) == 1050
        self.check(crowd)
        self.calm()

    def test_hangup_under_load(self):
        """A reader that waits gets what was sent up to some byte, and then the end."""
        dice = random.Random(2)
        stream = wire.sync() + b''.join(
            wire.debug(b'%06d' % number + b'.' * dice.randrange(190)) for number in range(600))
        ends = []
        for _ in range(60):
            head = head_rig.Head().attach()
            head.uart.write(wire.sync())
            fd = os.open(head.node, os.O_RDONLY | os.O_NOCTTY)
            got = []

            def listen(fd=fd, got=got):
                while True:
                    data = os.read(fd, 4096)
                    got.append(data)
                    if not data:
                        return

            thread = threading.Thread(target=listen)
            thread.start()
            size = dice.randrange(len(stream))
            head.uart.write(stream[:size])
            if dice.random() < 0.5:
                time.sleep(dice.random() * 0.002)
            head.uart.cut()
            thread.join(20)
            assert not thread.is_alive()
            data = b''.join(got)
            start = 3 if data.startswith(wire.sync() * 2) else 0
            assert (wire.sync() + stream).startswith(data) or \
                            stream.startswith(data[start:])
            ends.append(len(data))
            os.close(fd)
            head.close()
        assert len(set(ends)) > 20
        self.calm()

    @staticmethod
    def unloads():
        return head_rig.error_name(kernel.unload_module, head_rig.MODULE) is None

    def test_module_comes_and_goes(self):
        """insmod and rmmod against those who attach at the same time."""
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

        threads = [threading.Thread(target=attach) for _ in range(2)]
        for thread in threads:
            thread.start()
        try:
            for number in range(400):
                if number >= 40 and len(attached) > 20:
                    break
                assert wait(self.unloads, 30, 0.0005)
                assert not kernel.is_loaded(head_rig.MODULE)
                head_rig.load()
                time.sleep(dice.random() * 0.01)
        finally:
            stop.set()
            for thread in threads:
                thread.join(20)
        assert len(attached) > 20
        self.calm()


class TestStreams(Case):
    """Whole streams of the simulator's, whose own count must be the driver's."""

    def start(self, seed, **how):
        """A simulated head, the UART attached, and a reader. -> them, not yet running"""
        talker = head.Head(interval=0, sync_interval=0, seed=seed)
        uart = self.closing(line.Pty())
        sim = simulator.Simulator(talker, uart)
        slave = os.open(uart.name, os.O_RDWR | os.O_NOCTTY)
        before = heads()
        set_ldisc(slave, LDISC)
        name = next(name for name in heads() if name not in before)
        reader = head_rig.Reader('/dev/' + name)
        got = []
        listener = threading.Thread(target=lambda: got.append(reader.rest(2.0)))
        listener.start()

        def run():
            sim.wait_open(10)
            sim.stream(timeout=300, **how)

        def end():
            os.close(slave)
            reader.close()

        self.add_cleanup(end)
        return talker, name, got, listener, threading.Thread(target=run)

    def finish(self, talker, name, got, listener, thread):
        thread.join(400)
        assert not thread.is_alive()
        receiver = talker.counts()['receiver']
        stats = {stat: int(read_file('%s/%s/stats/%s' % (CLASS, name, stat)))
                 for stat in head_rig.STATS}
        assert wait(lambda: int(read_file('%s/%s/stats/rx_bytes' % (CLASS, name))) ==
                             talker.counts()['bytes']), stats
        listener.join(60)
        stats = {stat: int(read_file('%s/%s/stats/%s' % (CLASS, name, stat)))
                 for stat in head_rig.STATS}
        assert stats == {
            'rx_bytes': receiver['packet_bytes'] + receiver['dropped'] + receiver['kept'],
            'rx_packets': receiver['packets'], 'syncs': receiver['syncs'],
            'resyncs': receiver['resyncs'], 'dropped_bytes': receiver['dropped'],
            'bad_lengths': receiver['bad_lengths'], 'unknown_packets': receiver['unknown'],
            'line_errors': 0, 'lost_packets': 0}
        packets = head_rig.split(got[0])
        assert len(packets) == receiver['packets']
        assert len(got[0]) == receiver['packet_bytes']
        return receiver

    def test_two_at_once(self):
        """Exact counts, and every packet has come to its own reader."""
        both = [self.start(seed, packets=4000) for seed in (1, 2)]
        for one in both:
            one[-1].start()
        for one in both:
            receiver = self.finish(*one)
            assert receiver['packets'] >= 4000
            assert receiver['resyncs'] == 0

    def test_faults_at_full_speed(self):
        """Every kind of damage that the simulator knows, at random."""
        one = self.start(3, packets=6000)
        for kind in faults.KINDS:
            if kind != 'wrong-rate':
                one[0].faults.set(kind, '1/60')
        one[-1].start()
        receiver = self.finish(*one)
        assert receiver['resyncs'] > 100
        assert receiver['bad_lengths'] > 50
        assert receiver['unknown'] > 50

    def test_garbage_at_full_speed(self):
        """Bytes that are nothing: all are dropped but what looks like packets by chance."""
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
