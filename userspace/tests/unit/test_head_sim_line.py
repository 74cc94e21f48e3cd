# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xy3-head-sim, its lines: pseudo terminal, sockets, files, and the loop."""

import contextlib
import os
import select
import socket
import stat
import sys
import tempfile
import termios
import threading
import time
import pytest
import case


sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)),
                                '..', '..', 'xy3-head-sim'))

from xy3_head_sim import head, line, simulator, wire  # noqa: E402 (the path has to be set first)

LIMIT = 20                  # timeout in seconds for expected events


def quiet_head(**options):
    return head.Head(interval=0, sync_interval=0, **options)


class Listener(threading.Thread):
    """Reads a file descriptor until its end or until enough was received."""

    def __init__(self, fd, enough):
        super().__init__(daemon=True)
        self.fd, self.enough, self.data = fd, enough, bytearray()
        self.start()

    def run(self):
        while len(self.data) < self.enough:
            try:
                data = os.read(self.fd, 65536)
            except OSError:
                return
            if not data:
                return
            self.data += data

    def wait(self):
        self.join(LIMIT)
        decoder = wire.Decoder()
        return decoder.feed(bytes(self.data)), decoder


class Case(case.Case):
    def set_up(self):
        self.stack = contextlib.ExitStack()
        self.add_cleanup(self.stack.close)
        self.dir = self.stack.enter_context(tempfile.TemporaryDirectory())
        self.said = []

    def simulate(self, one, a_line):
        self.stack.callback(a_line.close)
        return simulator.Simulator(one, a_line, lambda event, **members:
                                   self.said.append((event, *members.values())))

    def counts_match(self, one, decoder):
        """The received data equal the counts of the head."""
        counts = one.counts()
        assert decoder.counts() == counts['receiver']
        assert (counts['queued'], counts['unsent']) == (0, 0)
        return counts


class TestPty(Case):
    def set_up(self):
        super().set_up()
        self.head = quiet_head()
        self.link = os.path.join(self.dir, 'head')
        self.pty = line.Pty(self.link)
        self.simulator = self.simulate(self.head, self.pty)

    def open(self):
        self.taken = self.head.counts()['bytes']
        slave = os.open(self.link, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self.simulator.wait_open(LIMIT)
        return slave

    def close(self, slave):
        os.close(slave)
        self.simulator.wait_closed(LIMIT)

    @staticmethod
    def set_speed(slave, speed):
        modes = termios.tcgetattr(slave)
        modes[4:6] = [speed, speed]
        termios.tcsetattr(slave, termios.TCSANOW, modes)

    def read(self, slave):
        """The number of bytes that the head has sent since the last call, and any others."""
        data, wanted = b'', self.head.counts()['bytes'] - self.taken
        while len(data) < wanted and select.select([slave], [], [], LIMIT)[0]:
            data += os.read(slave, 4095)
        self.taken += len(data)
        return data

    def test_telemetry(self):
        slave = self.open()
        self.head.report()
        decoder = wire.Decoder()
        decoder.feed(self.read(slave))
        assert self.counts_match(self.head, decoder)['packets'] == 10
        os.close(slave)

    def test_raw(self):
        slave = self.open()
        iflag, oflag, cflag, lflag, speed, _, _ = termios.tcgetattr(slave)
        assert (iflag, oflag, lflag) == (0, 0, 0)
        assert (cflag & termios.CSIZE, speed) == (termios.CS8, termios.B115200)
        self.head.send_raw(bytes(range(256)))
        assert self.read(slave) == bytes(range(256))
        os.close(slave)

    def test_wrong_rate(self):
        slave = self.open()
        speeds = {57600: termios.B57600, 115200: termios.B115200, 230400: termios.B230400,
                  460800: termios.B460800, 921600: termios.B921600}
        for rate in wire.RATES:
            self.head.set_rate(rate)
            for host in wire.RATES:
                with case.row(head=rate, host=host):
                    self.set_speed(slave, speeds[host])
                    self.head.report('model')
                    data = self.read(slave)
                    if host == rate:
                        assert data == wire.model('Head-2D')
                    else:
                        assert wire.START not in data
        assert self.head.counts()['garbled_packets'] == 20
        os.close(slave)

    def test_other_speeds_are_wrong(self):
        slave = self.open()
        self.set_speed(slave, termios.B9600)
        self.head.report('model')
        assert wire.START not in self.read(slave)
        os.close(slave)

    def test_speed_is_told(self):
        slave = self.open()
        self.set_speed(slave, termios.B230400)
        self.head.sync_interval = 0.01
        assert self.simulator.run(lambda: ('uart', 230400) in self.said, LIMIT)
        os.close(slave)

    def test_forced_rate(self):
        slave = self.open()
        self.pty.force_uart_rate(57600)
        self.head.report('model')
        assert wire.START not in self.read(slave)
        self.pty.force_uart_rate(None)
        self.pty.set_uart_rate(230400)
        assert self.pty.uart_rate() == 230400
        os.close(slave)

    def test_nobody_listens(self):
        self.head.report()
        assert self.head.counts()['unheard_packets'] == 10
        slave = self.open()
        self.head.report('vendor')
        assert self.read(slave) == wire.vendor('Virtual')
        os.close(slave)

    def test_opened_again(self):
        """The next one receives no data that the previous one has not read."""
        for number in range(3):
            slave = self.open()
            self.head.report('sync', 'vendor')
            assert self.read(slave) == wire.sync() + wire.vendor('Virtual')
            self.head.report('model')
            self.close(slave)
            assert self.head.counts()['openings'] == number + 1
        assert self.said == [('opened',), ('closed',)] * 3

    def test_a_new_listener_is_told_everything(self):
        self.head.interval = 1000
        for _ in range(2):
            slave = self.open()
            self.simulator.run(lambda: self.head.receiver.packets == 10, LIMIT)
            data = self.read(slave)
            assert len(wire.Decoder().feed(data)) == 10
            self.close(slave)

    def test_modes_of_the_last_one_do_not_stay(self):
        slave = self.open()
        modes = termios.tcgetattr(slave)
        modes[0:4] = [termios.ICRNL, termios.OPOST, termios.CS8 | termios.CREAD,
                      termios.ECHO | termios.ICANON]
        modes[4:6] = [termios.B57600] * 2
        termios.tcsetattr(slave, termios.TCSANOW, modes)
        self.close(slave)
        slave = self.open()
        modes = termios.tcgetattr(slave)
        assert (modes[0], modes[3]) == (0, 0)
        assert modes[4] == termios.B57600      # but stty before cat is effective
        os.close(slave)

    def test_stream_to_a_slow_reader(self):
        slave = self.open()
        os.set_blocking(slave, True)
        listener = Listener(slave, 3_000_000)
        self.simulator.stream(size=3_000_000, timeout=LIMIT)
        packets, decoder = listener.wait()
        counts = self.counts_match(self.head, decoder)
        assert (counts['packets'], counts['bytes']) == (len(packets), len(listener.data))
        os.close(slave)

    def test_hangup_in_a_stream(self):
        slave = self.open()
        threading.Timer(0.1, os.close, [slave]).start()
        with pytest.raises(line.LineError, match='disconnected during the stream'):
            self.simulator.stream(packets=10_000_000, timeout=LIMIT)
        assert self.head.counts()['unsent'] > 0
        assert self.head.counts()['unheard_packets'] < 100     # the stream stopped at once
        slave = self.open()
        self.head.report('vendor')
        assert self.read(slave) == wire.vendor('Virtual')
        os.close(slave)

    def test_a_reader_that_does_not_read(self):
        slave = self.open()
        with pytest.raises(simulator.Timeout):
            self.simulator.stream(size=1_000_000, timeout=0.2)
        assert self.head.counts()['queued'] > 0
        os.close(slave)

    def test_link(self):
        assert os.readlink(self.link) == self.pty.name
        self.pty.close()
        assert not os.path.lexists(self.link)

    def test_link_over_a_link_but_not_over_a_file(self):
        other = os.path.join(self.dir, 'other')
        os.symlink('/nowhere', other)
        line.Pty(other).close()
        with open(other, 'w', encoding='utf-8'):
            pass
        with pytest.raises(line.LineError, match='File exists'):
            line.Pty(other)
        assert os.path.isfile(other)


class TestSockets(Case):
    def unix(self):
        return 'unix:' + os.path.join(self.dir, 'socket')

    def pair(self):
        ours, theirs = socket.socketpair()
        self.add_cleanup(ours.close)
        self.add_cleanup(theirs.close)
        return ours, theirs

    def test_server(self):
        for address in (self.unix(), 'tcp:0'):
            with case.row(address):
                one = quiet_head()
                server = line.Server(address)
                sim = self.simulate(one, server)
                family, place = line._parse_address(server.name)
                for number in range(2):             # it accepts one after another
                    with socket.socket(family) as peer:
                        peer.connect(place)
                        sim.wait_open(LIMIT)
                        one.forget_counts()
                        listener = Listener(peer.fileno(), 2_000_000)
                        sim.stream(size=2_000_000, timeout=LIMIT)
                        _, decoder = listener.wait()
                        assert self.counts_match(one, decoder)['bytes'] == \
                                         len(listener.data)
                    sim.wait_closed(LIMIT)

    def test_one_at_a_time(self):
        server = line.Server(self.unix())
        sim = self.simulate(quiet_head(), server)
        with socket.socket(socket.AF_UNIX) as first, socket.socket(socket.AF_UNIX) as second:
            first.connect(self.unix()[5:])
            sim.wait_open(LIMIT)
            second.connect(self.unix()[5:])
            assert sim.run(lambda: select.select([second], [], [], 0)[0], LIMIT)
            assert second.recv(1) == b''
            sim.head.report('vendor')
            assert first.recv(100) == wire.vendor('Virtual')

    def test_client(self):
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind(self.unix()[5:])
            threading.Timer(0.2, listener.listen).start()       # the client retries
            client = line.Client(self.unix(), wait=LIMIT)
            one = quiet_head()
            sim = self.simulate(one, client)
            peer, _ = listener.accept()
        with peer:
            one.report()
            reader = Listener(peer.fileno(), one.counts()['bytes'])
            sim.flush(LIMIT)
            self.counts_match(one, reader.wait()[1])
        with pytest.raises(line.LineError, match='disconnected'):
            sim.run(timeout=LIMIT)

    def test_nobody_to_connect_to(self):
        with pytest.raises(line.LineError, match='No such file'):
            line.Client(self.unix(), wait=0)

    def test_stale_socket(self):
        with socket.socket(socket.AF_UNIX) as dead:
            dead.bind(self.unix()[5:])
        first = line.Server(self.unix())
        with pytest.raises(line.LineError, match='in use'):
            line.Server(self.unix())
        first.close()
        assert os.listdir(self.dir) == []

    def test_addresses(self):
        for text in ('unix:a', 'tcp:1', 'tcp:localhost:1', 'tcp:127.0.0.1:1'):
            line.check_address(text)

    @pytest.mark.parametrize('text', ['unix:', 'tcp:', 'tcp:x', 'tcp:65536', 'tcp:example.org:80',
                                      'udp:1', '', 'tcp:10.0.0.1:80'])
    def test_wrong_addresses(self, text):
        with pytest.raises(line.LineError):
            line.check_address(text)

    def test_queue(self):
        """A reader that starts late receives all bytes, in order."""
        ours, theirs = self.pair()
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        one = quiet_head()
        sim = self.simulate(one, line.Line(os.dup(ours.fileno()), 'pair'))
        for number in range(1000):
            one.debug('number %d' % number)
        assert one.counts()['queued'] > 0
        reader = Listener(theirs.fileno(), one.counts()['bytes'])
        sim.flush(LIMIT)
        packets, decoder = reader.wait()
        assert bytes(reader.data) == b''.join(
            wire.debug('number %d' % number) for number in range(1000))
        self.counts_match(one, decoder)
        assert packets == []                   # there was no sync among them

    def test_what_the_host_sends_is_thrown_away(self):
        ours, theirs = self.pair()
        a_line = line.Line(os.dup(ours.fileno()), 'pair')
        sim = self.simulate(quiet_head(), a_line)
        theirs.sendall(bytes(1000))
        assert sim.run(lambda: a_line.received == 1000, LIMIT)

    def test_pace(self):
        ours, theirs = self.pair()
        one = quiet_head(rate=57600)
        sim = self.simulate(one, line.Line(os.dup(ours.fileno()), 'pair', pace=True))
        began = time.monotonic()
        for _ in range(30):
            one.debug('x' * 189)
        # 5760 bytes per second, a tenth of it in advance
        reader = Listener(theirs.fileno(), 5760)
        sim.flush(LIMIT)
        assert time.monotonic() - began > 0.85
        reader.wait()
        assert len(reader.data) == 5760

    def test_the_loop_sleeps(self):
        """An idle loop uses no CPU time, in any state of the line."""
        ours, _ = self.pair()
        a_pty, server = line.Pty(), line.Server(self.unix())
        slave = os.open(a_pty.name, os.O_RDWR | os.O_NOCTTY)
        self.add_cleanup(os.close, slave)
        for name, a_line in (('pair', line.Line(os.dup(ours.fileno()), 'pair')),
                             ('pty', line.Pty()), ('open pty', a_pty), ('server', server)):
            with case.row(name):
                sim = self.simulate(head.Head(), a_line)
                sim.run(timeout=0.05)
                steps, step = [], sim._step
                sim._step = lambda deadline, step=step, steps=steps: (steps.append(1),
                                                                      step(deadline))
                sim.run(timeout=0.2)
                assert 0 < len(steps) < 24


class TestFiles(Case):
    def path(self, name='file'):
        return os.path.join(self.dir, name)

    def test_file(self):
        one = quiet_head()
        sim = self.simulate(one, line.File(self.path()))
        sim.stream(packets=5000, timeout=LIMIT)
        sim.flush(LIMIT)
        with open(self.path(), 'rb') as file:
            data = file.read()
        decoder = wire.Decoder()
        decoder.feed(data)
        assert self.counts_match(one, decoder)['bytes'] == len(data)
        assert stat.S_ISREG(os.stat(self.path()).st_mode)

    def test_fifo(self):
        os.mkfifo(self.path())
        with pytest.raises(line.LineError, match='No such device'):
            line.File(self.path())                  # there is no reader
        reader = os.open(self.path(), os.O_RDONLY | os.O_NONBLOCK)
        sim = self.simulate(quiet_head(), line.File(self.path()))
        sim.head.report('vendor')
        assert os.read(reader, 100) == wire.vendor('Virtual')
        os.close(reader)
        with pytest.raises(line.LineError, match='disconnected'):
            sim.run(timeout=LIMIT)

    def test_tty(self):
        """A tty is set to the rate of the head, so that wrong rates are effective."""
        master, slave = os.openpty()
        self.add_cleanup(os.close, master)
        self.add_cleanup(os.close, slave)
        a_line = line.File(os.ttyname(slave))
        one = quiet_head(rate=57600)
        self.simulate(one, a_line)
        assert termios.tcgetattr(slave)[5] == termios.B57600
        one.set_rate(921600)
        modes = termios.tcgetattr(slave)
        assert (modes[5], modes[3]) == (termios.B921600, 0)
        one.send_raw(b'\n\r\x03')
        assert os.read(master, 100) == b'\n\r\x03'
        assert a_line.uart_rate() is None

    def test_no_such_file(self):
        with pytest.raises(line.LineError, match='No such file'):
            line.File(self.path('no/such'))

    def test_full_disk(self):
        sim = self.simulate(quiet_head(), line.File('/dev/full'))
        with pytest.raises(line.LineError, match='/dev/full: No space'):
            sim.head.report()
