# SPDX-License-Identifier: GPL-2.0-only
"""From the UART to the reader of /dev/xy3-<n>: only complete packets, all bytes counted."""

import os
import random
import select
import subprocess
import termios
import time

import pytest

import head_rig
from acm_cable import AcmCable
from case import row
from head_rig import Background, Case, error_name, get_speed, polled, split, wait
from xy3_head_sim import wire

P = wire.packet


def every_type():
    """Each known type with its minimum and maximum length, and unknown types."""
    for kind, lengths in wire.LENGTHS.items():
        for length in sorted({lengths[0], lengths[-1]}):
            yield P(kind, bytes(i * 7 + kind & 0xFF for i in range(length)))
    for kind, length in ((0x00, 0), (0x0A, 10), (0x20, 1), (0x40, 255), (0x48, 3), (0xFF, 254)):
        yield P(kind, bytes([0x48, 0x41, 0x00] * 85)[:length])


class TestStream(Case):
    """Data sent, data read, and the statistics."""

    def check(self, *pieces, head=None):
        """Sends the pieces; the reader and the counts must agree with another decoder."""
        head = head or self.attach()
        reader, decoder, expected = head.open(), wire.Decoder(), b''
        for piece in pieces:
            head.send(piece)
            expected += b''.join(P(*packet) for packet in decoder.feed(piece))
        assert reader.take(len(expected)) == expected
        assert reader.rest(0.1) == b''
        self.assert_counts(head, decoder)
        return decoder

    def test_every_type(self):
        packets = list(every_type())
        decoder = self.check(head_rig.GOOD, *packets)
        assert decoder.packets == 2 + len(packets)
        assert decoder.unknown == 6

    def test_all_in_one_piece(self):
        self.check(head_rig.GOOD + b''.join(every_type()))

    def test_byte_by_byte(self):
        self.check(*(bytes([byte]) for byte in b'junk' + head_rig.GOOD +
                     P(8, b'a debug text') + P(0x33) + P(5, bytes(44)) + b'!' + head_rig.GOOD))

    def test_split_at_each_byte(self):
        """One stream split at every position, by heads that are attached and detached."""
        stream = (b'H' + head_rig.GOOD + P(2, b'Galvo') + P(0x77, b'HA\0H') + b'\x48\x07' +
                  head_rig.GOOD + P(9, bytes(8)))
        for at in range(1, len(stream)):
            with row(at=at):
                head = self.attach()
                self.check(stream[:at], stream[at:], head=head)
                head.close()

    def test_nothing_before_the_first_sync(self):
        decoder = self.check(b'HHH\x48\x41\x01' + P(1, b'early') + P(0x41))
        assert (decoder.packets, decoder.kept) == (0, 3)

    @pytest.mark.parametrize('damage', [
        pytest.param(b'junk', id='junk'),
        pytest.param(b'\0', id='zero'),
        pytest.param(b'H', id='head byte'),
        pytest.param(b'HHHHHH', id='head bytes'),
        pytest.param(b'\x48', id='overlap'),
        pytest.param(b'\x48\x41', id='overlap of two'),
        pytest.param(P(1, b'ab'), id='text too short'),
        pytest.param(P(1, bytes(201)), id='text too long'),
        pytest.param(P(5, bytes(3)), id='odd temperatures'),
        pytest.param(P(5), id='no temperatures'),
        pytest.param(P(5, bytes(46)), id='too many temperatures'),
        pytest.param(P(6, bytes(16)), id='frame errors of four axes'),
        pytest.param(P(9, bytes(5)), id='hours cut'),
        pytest.param(P(7, bytes(23)), id='too many errors'),
        pytest.param(P(0x41, b'x'), id='sync with payload'),
        pytest.param(b'\x48\x07' + P(0x41), id='a sync sequence in it'),
    ])
    def test_resync(self, damage):
        decoder = self.check(head_rig.GOOD + P(3, b'before') + damage + head_rig.GOOD +
                             P(3, b'behind'))
        assert decoder.in_sync

    def test_false_sync(self):
        """Starting inside a payload that looks like the sync sequence: sync is recovered."""
        trap = P(8, b'on ' + wire.RESYNC + b'\x05\xff off')
        decoder = self.check(trap[1:] + head_rig.GOOD + P(1, b'ACME'))
        assert (decoder.bad_lengths, decoder.resyncs) == (1, 1)

    @pytest.mark.parametrize('size', (1, 7, 300, 4096, 65536))
    def test_random_streams(self, size):
        """Mutated streams in pieces of any size, 64 KB in one write included."""
        dice = random.Random(size)
        data = b''
        while len(data) < max(1200, min(40 * size, 100000)):
            piece = bytearray(dice.choice((wire.sync(), *every_type())))
            if dice.random() < 0.1:
                piece[dice.randrange(len(piece))] ^= 1 << dice.randrange(8)
            if dice.random() < 0.05:
                del piece[dice.randrange(len(piece)):]
            data += wire.sync() * dice.randrange(3) + piece
        decoder = self.check(*(data[at:at + size] for at in range(0, len(data), size)))
        assert decoder.packets > 10

    def test_writer_that_waits_for_room(self):
        """A writer of more data than fit into a pty is woken when there is room."""
        head = self.attach()
        os.set_blocking(head.uart.master, True)
        data = wire.sync() * 50000

        def write(left):
            while left:
                left = left[os.write(head.uart.master, left):]

        Background(write, memoryview(data)).result()
        assert wait(lambda: head.stat('rx_bytes') == len(data))

    def test_new_uart_new_parser(self):
        """An incomplete packet is not continued in the next connection."""
        head = self.synced()
        head.send(P(8, b'0123456789')[:8])
        head.detach()
        assert head.gone()
        head.attach()
        self.check(b'789' + head_rig.GOOD, head=head)


class TestReaders(Case):
    def test_no_reader(self):
        """Without a reader nothing is buffered, and nothing is counted as lost."""
        head = self.synced()
        head.send(P(1, b'before'))
        reader = head.open()
        assert reader.rest() == b''
        head.send(P(1, b'behind'))
        assert reader.rest() == P(1, b'behind')
        assert head.stat('lost_packets') == 0
        assert head.stat('rx_packets') == 4

    def test_opened_in_the_middle_of_a_packet(self):
        head = self.synced()
        head.send(P(8, b'0123456789')[:6])
        reader = head.open()
        assert reader.rest() == b''
        head.send(P(8, b'0123456789')[6:])
        assert reader.rest() == P(8, b'0123456789')

    def test_closed_in_the_middle_of_a_packet(self):
        """The next reader starts at a packet, regardless of unread data of the previous one."""
        head = self.synced()
        for left in (1, 5, 300, 5000):
            reader = head.open()
            head.send(P(8, b'x' * 200) * 40)
            assert len(reader.take(8120 - left)) == 8120 - left
            reader.close()
            head.send(P(8, b'nobody'))
            reader = head.open()
            head.send(P(8, b'anew'))
            assert reader.rest() == P(8, b'anew'), left
            reader.close()
        assert head.stat('lost_packets') == 0

    def test_several_openers(self):
        """They share the stream; it ends when the last one is closed."""
        head = self.synced()
        one, two = head.open(), head.open(os.O_RDWR)
        head.send(P(8, b'first'))
        assert one.rest() == P(8, b'first')
        head.send(P(8, b'second'))
        assert two.rest() == P(8, b'second')
        one.close()
        head.send(P(8, b'third'))
        assert two.rest() == P(8, b'third')
        two.close()
        head.send(P(8, b'fourth'))
        assert head.open().rest() == b''

    def test_small_reads(self):
        head = self.synced()
        reader = head.open()
        data = b''.join(every_type())
        head.send(data)
        assert reader.rest(0.05, size=1) == data
        head.send(data)
        assert reader.rest(0.05, size=5) == data

    def test_poll_and_nonblocking(self):
        head = self.synced()
        reader = head.open()
        assert error_name(os.read, reader.fd, 10) == 'EAGAIN'
        assert polled(reader.fd, select.POLLIN | select.POLLOUT, 0.1) == select.POLLOUT
        head.send(P(8, b'half a packet')[:9])
        assert polled(reader.fd, select.POLLIN, 0.1) == 0
        head.send(P(8, b'half a packet')[9:])
        assert polled(reader.fd, select.POLLIN) == select.POLLIN
        assert reader.rest() == P(8, b'half a packet')

    def test_blocking_read(self):
        head = self.synced()
        reader = head.open()
        os.set_blocking(reader.fd, True)
        read = Background(os.read, reader.fd, 100)
        time.sleep(0.1)
        assert read.is_alive()
        head.send(P(8, b'wake up'))
        assert read.result() == P(8, b'wake up')

    def test_slow_reader(self):
        """A slow reader loses complete packets, and each of them is counted."""
        dice = random.Random(8)
        head = self.synced()
        reader = head.open()
        texts = [b'%06d' % number + b'.' * dice.randrange(195) for number in range(20000)]
        stream = b''.join(P(8, text) for text in texts)
        for at in range(0, len(stream), 60000):
            head.send(stream[at:at + 60000])
        lost = head.stat('lost_packets')
        assert lost > 1000
        got = split(reader.rest())
        assert len(got) + lost == len(texts)
        sent = {P(8, text) for text in texts}
        assert [packet for packet in got if packet not in sent] == []
        assert got == sorted(got, key=lambda packet: packet[3:9])
        assert got[0] == P(8, texts[0])
        head.send(P(8, b'there is room again'))
        assert reader.rest() == P(8, b'there is room again')
        assert head.stat('lost_packets') == lost
        assert head.stat('rx_packets') == 2 + len(texts) + 1

    def test_fast_reader_loses_nothing(self):
        head = self.synced()
        reader = head.open()
        read = Background(reader.rest, 1.0)
        packets = list(every_type())
        for _ in range(100):
            head.send(b''.join(packets))
        assert split(read.result()) == packets * 100
        assert head.stat('lost_packets') == 0


class TestSettings(Case):
    def modes(self, fd):
        """-> (iflag, oflag, lflag, cflag without the speed)"""
        iflag, oflag, cflag, lflag = termios.tcgetattr(fd)[:4]
        return iflag, oflag, lflag, cflag & ~0o10017

    def test_raw_from_the_beginning(self):
        """All byte values are passed unchanged, and nothing is echoed."""
        head = self.synced()
        reader = head.open(os.O_RDWR)
        assert self.modes(reader.fd) == \
            (0, 0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL)
        payload = bytes(range(255))
        head.send(P(0x50, payload), P(0x51, b'\xff\r\n\x03\x04\x11\x13\0'))
        assert reader.rest() == P(0x50, payload) + P(0x51, b'\xff\r\n\x03\x04\x11\x13\0')
        assert polled(head.uart.master, select.POLLIN, 0.1) == 0

    def test_raw_for_ever(self):
        """Modes enabled by stty, getty or a terminal program stay off; `stty raw` succeeds."""
        head = self.synced()
        reader = head.open(os.O_RDWR)
        for modes in ('sane', 'echo', 'icanon', 'isig', 'opost', 'ixon', 'parmrk', 'icrnl'):
            status, _ = head_rig.run('stty', '-F', head.node, modes)
            assert status != 0, modes
            assert self.modes(reader.fd)[:3] == (0, 0, 0), modes
        subprocess.run(['stty', '-F', head.node, 'raw', '-echo'], check=True)
        payload = bytes(range(255))
        head.send(P(0x50, payload), P(0x51, b'\xff\r\n\x03\x04\x11\x13\0'))
        assert reader.rest() == P(0x50, payload) + P(0x51, b'\xff\r\n\x03\x04\x11\x13\0')

    def test_it_is_a_tty(self):
        head = self.synced()
        reader = head.open()
        assert os.isatty(reader.fd)
        assert os.ttyname(reader.fd) == head.node
        assert os.ttyname(head.uart.slave) == head.uart.node
        assert get_speed(reader.fd) == 115200

    def test_bits_and_parity_stay(self):
        head = self.synced()
        reader = head.open()
        before = self.modes(reader.fd)
        status, _ = head_rig.run('stty', '-F', head.node, 'cs7', 'parenb', 'cstopb')
        assert status != 0
        assert self.modes(reader.fd) == before


class TestWriting(Case):
    COMMAND = wire.command_frame('calibrate', 'xy')
    WIDE = wire.command_frame('calibrate', 'xy', bits=32)

    @pytest.mark.parametrize('data, error', [
        pytest.param(COMMAND, 'ENODEV', id='a frame'),
        pytest.param(WIDE, 'ENODEV', id='a frame of 32 bits'),
        pytest.param(COMMAND + WIDE + COMMAND, 'ENODEV', id='several frames'),
        pytest.param(wire.position_frame(5), 'EINVAL', id='a position'),
        pytest.param(wire.position_frame(5, 24), 'EINVAL', id='a position of 24 bits'),
        pytest.param(COMMAND[:2] + bytes([COMMAND[2] ^ 1]), 'EINVAL', id='bad parity'),
        pytest.param(COMMAND[:2], 'EINVAL', id='torn'),
        pytest.param(WIDE[:3], 'EINVAL', id='torn, 32 bits'),
        pytest.param(COMMAND + COMMAND[:1], 'EINVAL', id='torn behind a good one'),
        pytest.param(b'hello\n', 'EINVAL', id='text'),
        pytest.param(COMMAND * 1000, 'ENODEV', id='many frames'),
        pytest.param(COMMAND * 1000 + b'\0', 'EINVAL', id='the last of many is bad'),
        pytest.param(COMMAND * 30000, 'ENODEV', id='more than the tty core passes at a time'),
    ])
    def test_command_frames(self, data, error):
        """There is no forward channel; invalid command frames are refused before that."""
        head = self.synced()
        writer = head.open(os.O_RDWR)
        assert error_name(os.write, writer.fd, data) == error
        assert polled(head.uart.master, select.POLLIN, 0.1) == 0

    def test_the_uart_itself(self):
        """While it is attached its file can neither be read nor written; afterwards it can."""
        head = self.synced()
        slave, master = head.uart.slave, head.uart.master
        assert error_name(os.write, slave, b'hello') == 'ENOTSUP'
        assert error_name(os.read, slave, 10) == 'EIO'
        assert polled(master, select.POLLIN, 0.1) == 0
        head.detach()
        os.write(slave, b'hello')
        assert os.read(master, 10) == b'hello'
        os.write(master, b'hello')
        assert os.read(slave, 10) == b'hello'


class TestAcm(Case):
    """A UART on USB (CDC ACM over dummy_hcd), which unlike a pty supports line errors."""

    def set_up(self):
        super().set_up()
        self.cable = self.closing(AcmCable())
        self.head = self.attach(self.cable)

    def test_packets(self):
        reader = self.head.open()
        data = head_rig.GOOD + b''.join(every_type()) * 20
        self.head.send(data)
        assert reader.take(len(data)) == data

    def test_break(self):
        """A flagged byte is not data: buffered bytes are dropped, and sync is lost."""
        head = self.head
        reader = head.open()
        head.send(head_rig.GOOD + P(8, b'whole') + P(8, b'cut by a break')[:7])
        self.cable.send_break()
        head.sent += 1
        assert wait(lambda: head.stat('line_errors') == 1)
        assert head.get('in_sync') == '0'
        assert head.stat('dropped_bytes') == 8
        head.send(P(8, b'cut by a break')[7:], head_rig.GOOD + P(8, b'whole again'))
        assert split(reader.rest())[2:] == [P(8, b'whole'), wire.sync(), wire.sync(),
                                                    P(8, b'whole again')]
        stats = head.stats()
        assert (stats['rx_bytes'], stats['resyncs'], stats['line_errors']) == \
            (head.sent, 1, 1)

    def test_uart_that_was_stopped(self):
        """Before, a program had it open and did not read, until it was throttled."""
        self.head.detach()
        assert self.head.gone()
        # the buffer of the tty has 4095 bytes, and the UART stops a little before that; bytes of
        # requests in flight still arrive, one at a time
        for size in (4000, *[1] * 60):
            self.cable.write(bytes(size))
            time.sleep(0.01)
        assert polled(self.cable.slave, select.POLLIN) == select.POLLIN
        self.head.attach()
        self.cable.write(head_rig.GOOD)
        assert wait(lambda: self.head.get('in_sync') == '1')

    def test_uart_that_was_stopped_with_more_to_come(self):
        self.head.detach()
        assert self.head.gone()
        for _ in range(10):
            self.cable.flood(20000)
            time.sleep(0.1)
        assert polled(self.cable.master, select.POLLOUT, 0.5) == 0
        self.head.attach()
        assert polled(self.cable.master, select.POLLOUT) == select.POLLOUT
        self.cable.write(head_rig.GOOD)
        assert wait(lambda: self.head.get('in_sync') == '1')

    def test_unplugged(self):
        head = self.head
        head.send(head_rig.GOOD + P(8, b'cut by the cable')[:7])
        reader = head.open()
        self.cable.unplug()
        assert head.gone()
        assert reader.read() == b''
        assert polled(reader.fd, select.POLLIN) & select.POLLHUP
        self.cable.plug()
        head.attach()
        fresh = head.open()
        head.send(head_rig.GOOD + P(8, b'back'))
        assert fresh.take(13) == head_rig.GOOD + P(8, b'back')
