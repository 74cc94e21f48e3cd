# SPDX-License-Identifier: GPL-2.0-only
"""Millions of scans in a closed loop: none is lost or received twice, all are in order.

The scans are random, so that each is identified by its content. They are written like a program
would, in pieces of all sizes, with commands in between, and compared byte by byte with the scans
decoded by the virtual head.
"""

import random
import struct
import time

import pytest
import forward_rig
from forward_rig import ARRANGEMENTS, Case
from kernel import wait, write_file

LINE_SCANS = 2000000        # for each number of lines and bits: if SYNC is a line,
CS_SCANS = 300000           # and if it is the chip select
ROUND = 300000              # scans recorded at a time
# the used bits of the bytes of a code
MASKS = {24: (0xff, 0xff, 0x0f, 0), 32: (0xff, 0xff, 0xff, 0x03)}


def table(clear, put=0):
    """For bytes.translate(): clear some bits, and set others."""
    return bytes(byte & ~clear & 0xff | put for byte in range(256))


def random_scans(dice, count, axes, bits):
    """Bytes of scans; each scan differs from the one before."""
    data = bytearray(4 * axes * count)
    for place, mask in enumerate(MASKS[bits]):
        data[place::4] = dice.randbytes(axes * count).translate(table(~mask))
    one = 4 * axes
    for first, bit in ((0, 0), (one, 1)):
        data[first::2 * one] = data[first::2 * one].translate(table(1, bit))
    return bytes(data)


class TestVolume(Case):
    def difference(self, forward, got, want):
        """-> description of the first difference of the record and the written scans"""
        one = 4 * forward.axes
        words = ['%d scans recorded, %d written' % (len(got) // one, len(want) // one)]
        for at in range(0, min(len(got), len(want)), one):
            if got[at:at + one] != want[at:at + one]:
                codes = [struct.unpack('<%dI' % forward.axes, data[at:at + one])
                         for data in (got, want)]
                words.append('scan %d is %s, not %s' % (at // one, *codes))
                break
        return ', '.join(words)

    def one_round(self, forward, dice, bits, scans):
        data = random_scans(dice, scans, forward.axes, bits)
        one = 4 * forward.axes
        sent = forward.number('scans')
        repeated, commands = forward.number('repeated'), forward.number('commands')
        received = forward.sim_number('stats', 'scans')
        forward.record(scans + 1)
        stream = forward.stream()
        written = 0
        for at in range(0, len(data), len(data) // 4):
            stream.write_all(data[at:at + len(data) // 4],
                             lambda: one * dice.choice((1, 255, 257, 4000, 20000, 20000, 100000)))
            write_file(forward.head + 'calibrate', 'x')
            written += 1
        stream.finish()
        # the end of the stream does not wait for the last command
        assert wait(lambda: forward.number('commands') - commands == written)
        got = forward.recorded()
        if got != data:     # assert would print both
            pytest.fail(self.difference(forward, got, data))
        # a scan received twice in a row is not in the record, but counted by the head
        repeated = forward.number('repeated') - repeated
        assert forward.sim_number('stats', 'scans') - received == scans + repeated
        assert forward.number('scans') - sent == scans + repeated + written
        return written

    @pytest.mark.parametrize('bits', (24, 32))
    @pytest.mark.parametrize('lines, framing, cs_word', ARRANGEMENTS)
    def test_every_scan(self, lines, framing, cs_word, bits):
        scans = LINE_SCANS if framing == 'line' else CS_SCANS
        forward = self.forward(lines, framing, cs_word)
        assert forward.set('frame_bits', bits) is None
        dice = random.Random('%d %s %d %d' % (lines, framing, cs_word, bits))
        began, commands = time.monotonic(), 0
        for done in range(0, scans, ROUND):
            commands += self.one_round(forward, dice, bits, min(ROUND, scans - done))
        assert forward.bad_frames() == []
        assert forward.sim_number('stats', 'commands') == commands
        assert commands > 0
        assert forward.number('bus_errors') == 0
        print('    %d scans and %d commands, %d scans repeated, %.0f s'
              % (scans, commands, forward.number('repeated'), time.monotonic() - began))


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
