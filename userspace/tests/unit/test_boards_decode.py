# SPDX-License-Identifier: GPL-2.0-only
"""The decoder of the lines of a board: it accepts correct data, and detects each fault."""

import importlib.machinery
import importlib.util
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[1] / 'boards/decode'
loader = importlib.machinery.SourceFileLoader('boards_decode', str(PROGRAM))
decode = importlib.util.module_from_spec(importlib.util.spec_from_loader('boards_decode', loader))
loader.exec_module(decode)

# from the protocol pages: position 5, calibrate x; in 32 bits position 33554432
EXAMPLES = (('400016', (24, 'position', 5)), ('300007', (24, 'command', 0xC0001)),
            ('e0000001', (32, 'position', 33554432)), ('80c00013', (32, 'command', 0xC0001)))


def bits_of(code):
    return format(int(code, 16), '0%db' % (4 * len(code)))


def frame(bits, kind, data):
    text = '%d%d' % (bits == 32, kind == 'position') + format(data, '0%db' % decode.DATA[bits])
    return text + format(bin(data).count('1') % (1 << decode.CHECK[bits]),
                         '0%db' % decode.CHECK[bits])


X = ['x']
PINS = decode.Pl061
# line maps of a controller with four lines
QUAD = (['sync', 'x', 'y', 'z'], ['x', 'y', 'z', 'u'], ['sync', 'x', 'y', 'gate'])


def sent():
    return [frame(*one[0][0]) for _, scans in decode.stages(X) for one in scans]


def pins(frames):
    """QEMU's trace of these frames."""
    changes = [(PINS.SELECT, 1)]
    for bits in frames:
        changes.append((PINS.SELECT, 0))
        for bit in bits:
            changes += [(PINS.SCK, 1), (PINS.MOSI, int(bit)), (PINS.SCK, 0)]
        changes.append((PINS.SELECT, 1))
    return changes


def judged(source, lines, trace):
    for text in trace:
        source.feed(text)
    return [name for name, why in decode.judge(source, lines) if why]


def failures(changes):
    return judged(decode.Pl061(), X, ['setting output %d to %d\n' % change for change in changes])


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
    assert not failures(pins([one for one in sent()
                              for _ in range(2 if one[1] == '1' else 1)]))     # not a command


def test_nothing():
    assert len(failures([])) == len(list(decode.stages(X)))


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
    """In mode 1 a bit is sampled at the falling edge; a change at that edge is too late."""
    changes = pins(sent())
    for n, change in enumerate(changes[:-1]):
        if change[0] == PINS.MOSI and changes[n + 1] == (PINS.SCK, 0):
            changes[n], changes[n + 1] = changes[n + 1], changes[n]
    assert 'frames' in failures(changes)


def test_mode_0():
    """There a bit is valid before the clock rises, and just until it falls."""
    changes = pins(sent())
    for n, change in enumerate(changes[:-1]):
        if change[0] == PINS.SCK and change[1] and changes[n + 1][0] == PINS.MOSI:
            changes[n], changes[n + 1] = changes[n + 1], changes[n]
    assert failures(changes) == ['signals']


def test_clock_without_chip_select():
    assert failures(pins(sent()) + [(PINS.SCK, 1), (PINS.SCK, 0)]) == ['signals']


def test_chip_select_while_the_clock_is_high():
    changes = pins(sent())
    at = changes.index((PINS.SELECT, 0))
    changes.insert(at, (PINS.SCK, 1))
    assert 'signals' in failures(changes)


# ---- several lines at once ----

def clocks_of(lines, scans, block=7):
    """Levels of all lines, for each time that the chip select is low."""
    selected = []
    for n, (frames, gate) in enumerate(scans):
        texts = dict(zip(decode.axes_of(lines), (frame(*one) for one in frames)))
        size = len(texts['x'])
        texts.update(sync='0' * size, gate=str(gate) * size)
        clocks = [tuple(int(texts[line][at]) for line in lines) for at in range(size)]
        if 'sync' not in lines:
            selected.append(clocks)
            continue
        last = n % block == block - 1 or n == len(scans) - 1
        levels = {'sync': 1, 'gate': gate and not last}
        gap = decode.GAP * [tuple(int(levels.get(line, 0)) for line in lines)]
        if n % block == 0:
            selected.append(decode.GAP * [tuple(int(line == 'sync') for line in lines)])
        selected[-1] += clocks + gap
    return selected


def scans_of(lines):
    return [scan for _, scans in decode.stages(lines) for scan in scans]


def sifive(selected, mode=1, proto=2, hold=True):
    """QEMU's trace of the SiFive controller: a byte has two clocks of four lines."""
    def write(address, value):
        return 'memory_region_ops_write addr 0x%x value 0x%x size 4\n' % (address, value)

    yield write(decode.Sifive.SCKMODE, mode)
    yield write(decode.Sifive.FMT, 8 << 16 | 8 | proto)
    for clocks in selected:
        if hold:
            yield write(decode.Sifive.CSMODE, 2)
        for at in range(0, len(clocks), 2):
            bits = [level for clock in clocks[at:at + 2] for level in reversed(clock)]
            yield write(decode.Sifive.TXDATA, int(''.join(map(str, bits)), 2))
        yield write(decode.Sifive.CSMODE, 0)


def quad_failures(lines, selected, **options):
    return judged(decode.Sifive(), lines, sifive(selected, **options))


@pytest.mark.parametrize('lines', QUAD)
def test_what_the_guest_sends_on_four_lines(lines):
    assert not quad_failures(lines, clocks_of(lines, scans_of(lines)))


@pytest.mark.parametrize('lines', QUAD)
@pytest.mark.parametrize('line', range(4))
def test_one_wrong_level(lines, line):
    selected = clocks_of(lines, scans_of(lines))
    wrong = list(selected[100][8])
    wrong[line] ^= 1
    selected[100][8] = tuple(wrong)
    assert 'frames' in quad_failures(lines, selected)


@pytest.mark.parametrize('lines', QUAD)
def test_two_axes_swapped(lines):
    other = [{'x': 'y', 'y': 'x'}.get(line, line) for line in lines]
    selected = [[tuple(clock[other.index(line)] for line in lines) for clock in clocks]
                for clocks in clocks_of(lines, scans_of(lines))]
    assert 'stream-24' in quad_failures(lines, selected)


@pytest.mark.parametrize('lines', QUAD)
def test_lost_scan(lines):
    scans = scans_of(lines)
    del scans[500]
    assert quad_failures(lines, clocks_of(lines, scans))[0] == 'stream-24'


@pytest.mark.parametrize('lines', QUAD)
def test_repeated_positions(lines):
    scans = [again for frames, gate in scans_of(lines)
             for again in [(frames, gate)] + [(frames, 0)] * (frames[0][1] == 'position')]
    assert not quad_failures(lines, clocks_of(lines, scans))


def test_repeated_command():
    scans = [again for scan in scans_of(QUAD[0])
             for again in [scan] * (1 + (scan[0][0][1] == 'command'))]
    assert 'stream-24' in quad_failures(QUAD[0], clocks_of(QUAD[0], scans))


def test_gate_of_a_repetition():
    scans = scans_of(QUAD[2])
    at = next(n for n, (_, gate) in enumerate(scans) if gate)
    scans.insert(at, scans[at])
    assert 'stream-24' in quad_failures(QUAD[2], clocks_of(QUAD[2], scans))


def test_gate_behind_a_block():
    selected = clocks_of(QUAD[2], scans_of(QUAD[2]))
    selected[100][-2:] = [tuple(int(level or line == 'gate') for line, level in zip(QUAD[2], clock))
                          for clock in selected[100][-2:]]
    assert 'frames' in quad_failures(QUAD[2], selected)


@pytest.mark.parametrize('clocks', (0, 1, 3))
def test_length_of_the_gap(clocks):
    selected = clocks_of(QUAD[0], scans_of(QUAD[0]))
    selected[100][26:28] = clocks * [(1, 0, 0, 0)]
    assert 'frames' in quad_failures(QUAD[0], selected)


@pytest.mark.parametrize('options', ({'mode': 0}, {'mode': 3}, {'hold': False}))
def test_signals_of_the_controller(options):
    selected = clocks_of(QUAD[0], scans_of(QUAD[0]))
    assert 'signals' in quad_failures(QUAD[0], selected, **options)


def test_on_one_line():
    selected = clocks_of(QUAD[0], scans_of(QUAD[0]))
    assert 'frames' in quad_failures(QUAD[0], selected, proto=0)


# ---- one line, by a controller's registers ----

def write_of(address, value):
    return 'addr 0x%x value 0x%x\n' % (address, value)


def imx(frames, config=0x101, gpio=True):
    """CPHA is bit 0, CPOL bit 4, and bit 8 toggles the chip select between words."""
    gpio3 = decode.Imx.GPIO3
    yield from (write_of(gpio3, 0), write_of(gpio3, 1 << 19))   # not driven yet, then not selected
    yield write_of(decode.Imx.CONFIG, config)
    for bits in frames:
        if gpio:
            yield write_of(gpio3, 0)
        yield write_of(decode.Imx.CONTROL, len(bits) - 1 << 20)
        yield write_of(decode.Imx.TXDATA, int(bits, 2))
        yield write_of(gpio3, 1 << 19)


def bcm2835(frames, control=0x84, gpio=True):
    """CPHA is bit 2, CPOL bit 3, and bit 7 is that of a transfer."""
    yield write_of(decode.Bcm2835.SET, 1 << 8)
    yield write_of(decode.Bcm2835.CONTROL, control)
    for bits in frames:
        if gpio:
            yield write_of(decode.Bcm2835.CLEAR, 1 << 8)
        for at in range(0, len(bits), 8):
            yield write_of(decode.Bcm2835.FIFO, int(bits[at:at + 8], 2))
        yield write_of(decode.Bcm2835.SET, 1 << 8)


ONE_LINE = ((decode.Imx, imx), (decode.ImxWord, imx), (decode.Bcm2835, bcm2835))


@pytest.mark.parametrize('source, trace', ONE_LINE)
def test_what_the_guest_sends_by_registers(source, trace):
    assert not judged(source(), X, trace(sent()))


@pytest.mark.parametrize('source, trace', ONE_LINE)
def test_lost_frame_by_registers(source, trace):
    frames = sent()
    del frames[500]
    assert judged(source(), X, trace(frames))[0] == 'stream-24'


@pytest.mark.parametrize('source, trace, options', (
    (decode.Imx, imx, {'config': 0x100}), (decode.Imx, imx, {'config': 0x111}),
    (decode.Imx, imx, {'gpio': False}), (decode.ImxWord, imx, {'config': 1}),
    (decode.Bcm2835, bcm2835, {'control': 0x80}), (decode.Bcm2835, bcm2835, {'control': 0x8c}),
    (decode.Bcm2835, bcm2835, {'control': 4}), (decode.Bcm2835, bcm2835, {'gpio': False})))
def test_signals_by_registers(source, trace, options):
    assert 'signals' in judged(source(), X, trace(sent(), **options))
