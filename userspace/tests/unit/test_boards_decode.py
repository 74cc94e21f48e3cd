# SPDX-License-Identifier: GPL-2.0-only
"""The decoder of a board's pins: it accepts what the guest sends, and refuses each fault."""

import importlib.machinery
import importlib.util
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[1] / 'boards/decode'
loader = importlib.machinery.SourceFileLoader('boards_decode', str(PROGRAM))
decode = importlib.util.module_from_spec(importlib.util.spec_from_loader('boards_decode', loader))
loader.exec_module(decode)

# of the pages of the protocol: position 5, calibrate x; in 32 bits position 33554432
EXAMPLES = (('400016', (24, 'position', 5)), ('300007', (24, 'command', 0xC0001)),
            ('e0000001', (32, 'position', 33554432)), ('80c00013', (32, 'command', 0xC0001)))


def bits_of(code):
    return format(int(code, 16), '0%db' % (4 * len(code)))


def frame(bits, kind, data):
    text = '%d%d' % (bits == 32, kind == 'position') + format(data, '0%db' % decode.DATA[bits])
    return text + format(bin(data).count('1') % (1 << decode.CHECK[bits]),
                         '0%db' % decode.CHECK[bits])


def sent():
    return [frame(*one) for _, frames in decode.stages() for one in frames]


def pins(frames):
    """QEMU's trace of these frames."""
    changes = [(decode.SELECT, 1)]
    for bits in frames:
        changes.append((decode.SELECT, 0))
        for bit in bits:
            changes += [(decode.SCK, 1), (decode.MOSI, int(bit)), (decode.SCK, 0)]
        changes.append((decode.SELECT, 1))
    return changes


def trace(changes):
    return ['pl061_set_output /machine/unattached/device[6] setting output %d to %d\n' % change
            for change in changes]


def failures(changes):
    return [name for name, why in decode.judge(trace(changes)) if why]


@pytest.mark.parametrize('code, meaning', EXAMPLES)
def test_examples_of_the_protocol(code, meaning):
    assert decode.read(bits_of(code)) == meaning


@pytest.mark.parametrize('code', ('400017', 'c00000', '40001600', '4000', ''))
def test_wrong_frames(code):
    with pytest.raises(ValueError):
        decode.read(bits_of(code) if code else '')


def test_what_the_guest_sends():
    assert not failures(pins(sent()))


def test_repetitions():
    assert not failures(pins([one for one in sent() for _ in range(2)]))


def test_nothing():
    assert len(failures([])) == len(list(decode.stages()))


@pytest.mark.parametrize('at, name', ((2, 'positions-24'), (4, 'command-24'), (500, 'stream-24')))
def test_lost_frame(at, name):
    frames = sent()
    del frames[at]
    assert failures(pins(frames))[0] == name


def test_two_frames_swapped():
    frames = sent()
    frames[500:502] = reversed(frames[500:502])
    assert failures(pins(frames)) == ['stream-24']


def test_one_more_frame():
    assert failures(pins(sent() + [frame(32, 'position', 5)])) == ['no-more']


@pytest.mark.parametrize('bit', (0, 1, 2, 12, 23))
def test_one_wrong_bit(bit):
    frames = sent()
    wrong = list(frames[500])
    wrong[bit] = '10'[int(wrong[bit])]
    frames[500] = ''.join(wrong)
    assert failures(pins(frames))


def test_bit_too_few():
    frames = sent()
    frames[500] = frames[500][:-1]
    assert 'frames' in failures(pins(frames))


def test_bits_at_the_other_edge():
    """In mode 1 a bit is taken at the falling edge; one that changes with it is too late."""
    changes = pins(sent())
    for n, change in enumerate(changes[:-1]):
        if change[0] == decode.MOSI and changes[n + 1] == (decode.SCK, 0):
            changes[n], changes[n + 1] = changes[n + 1], changes[n]
    assert 'frames' in failures(changes)


def test_mode_0():
    """There a bit comes before the clock rises, and is still there when it falls: only just."""
    changes = pins(sent())
    for n, change in enumerate(changes[:-1]):
        if change[0] == decode.SCK and change[1] and changes[n + 1][0] == decode.MOSI:
            changes[n], changes[n + 1] = changes[n + 1], changes[n]
    assert failures(changes) == ['signals']


def test_clock_without_chip_select():
    assert failures(pins(sent()) + [(decode.SCK, 1), (decode.SCK, 0)]) == ['signals']


def test_chip_select_while_the_clock_is_high():
    changes = pins(sent())
    at = changes.index((decode.SELECT, 0))
    changes.insert(at, (decode.SCK, 1))
    assert 'signals' in failures(changes)
