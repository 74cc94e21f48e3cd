# SPDX-License-Identifier: GPL-2.0-only
"""xy3ctl without a head: usage, help, and captures in files."""

import os
import re

import case
import pytest
from planted_head import PlantedHead
from tool import FAILURE, NO_DEVICE, OK, USAGE, Tool, build_sanitized
from xy3_head_sim import wire

xy3ctl = Tool('xy3ctl')


def setup_module():
    xy3ctl.path = os.path.join(build_sanitized(), 'xy3ctl')


def assert_status(status, *words, says='', tool=xy3ctl):
    """It exits with this status, such a message on standard error, and no output."""
    with case.row(*words):
        found, output, errors = tool.run(*words)
        assert (found, output) == (status, ''), errors
        assert re.search('^xy3ctl', errors), errors
        assert says in errors


def test_usage():
    for words in (('list', '-x'), ('list', 'more'), ('goto', 'q=1'), ('goto', 'xy=1'),
                  ('goto', '1', '2', '3', '4', '5', '6'), ('stream', 'circle', 'grid'),
                  ('stream', 'circle', '--raw'), ('command', 'rate', '9600'),
                  ('attach', 'a', 'b'), ('detach',)):
        assert_status(USAGE, *words)


def test_help():
    status, output, errors = xy3ctl.run('--help')
    assert (status, errors) == (OK, '')
    verbs = re.findall(r'^  ([a-z]+) ', output.split('\nVerbs:\n')[1].split('\n\n')[0], re.M)
    assert set(verbs) >= {'list', 'show', 'watch', 'packets', 'command', 'goto', 'stream',
                          'attach', 'detach'}
    for verb in verbs:
        status, output, errors = xy3ctl.run(verb, '--help')
        assert (status, errors) == (OK, ''), verb
        assert 'Usage: xy3ctl %s ' % verb in output


def test_no_head():
    """With an empty /sys and /dev"""
    planted = PlantedHead()
    try:
        for words in (('list',), ('show',), ('watch',), ('packets',), ('goto', '1'),
                      ('stream', 'circle'), ('command', 'calibrate'), ('show', '-d', 'xy3-7'),
                      ('show', '-d', 'nonsense'), ('detach', 'xy3-7'),
                      ('attach', '/dev/no-such-tty'),
                      ('goto', '1', '--spidev', '/dev/spidev99.9')):
            assert_status(NO_DEVICE, *words, tool=planted.xy3ctl)
        listed = planted.xy3ctl.json('list', status=NO_DEVICE)
        assert listed['heads'] == []
        assert listed['error'].startswith('no scanhead')
        assert planted.xy3ctl.json('stream', 'circle', status=NO_DEVICE)['error'].startswith(
            'no scanhead')
    finally:
        planted.close()


def test_no_serial_port():
    assert_status(FAILURE, 'attach', '/dev/null', says='not a serial port')


# --- captures ---


@pytest.fixture
def capture(tmp_path):
    """capture(data) -> the name of a file with these data"""
    def write(data):
        path = tmp_path / 'capture'
        path.write_bytes(data)
        return str(path)

    return write


def test_capture(capture):
    good = (wire.sync() + wire.sync() + wire.vendor('Lasers Ltd') + wire.packet(0x50, b'abc')
            + wire.frame_errors([1, 2, 3, 4, 5]))
    data = b'\x01\x02' + good + b'\xff' * 5 + wire.sync() + wire.hours([7]) + b'\x48\x05'
    path = capture(data)
    status, output, errors = xy3ctl.run('packets', path)
    assert status == OK
    assert [line.split(None, 1) for line in output.splitlines()] == \
        [['2', 'sync'], ['5', 'sync'], ['8', 'vendor Lasers Ltd'], ['21', 'type_50 61 62 63'],
         ['27', 'frame_errors x=1 y=2 z=3 u=4 w=5'], ['55', 'sync'], ['58', 'hours head=7']]
    assert 'dropped_bytes 7' in errors
    status, output, errors = xy3ctl.run('packets', '-j', '-r', path)
    assert (status, errors) == (OK, '')
    documents = xy3ctl.documents(output)
    assert documents[4]['value'] == {'x': 1, 'y': 2, 'z': 3, 'u': 4, 'w': 5}
    assert documents[3]['raw'] == '48 50 03 61 62 63'
    assert documents[-1]['counts'] == {
        'packets': 7, 'packet_bytes': len(data) - 9, 'dropped_bytes': 7, 'waiting_bytes': 2,
        'resyncs': 1, 'bad_lengths': 0, 'unknown_packets': 1}


def test_capture_in_the_other_order(capture):
    path = capture(wire.sync() * 2 + wire.temperatures([3150], 'big'))
    assert 'head=31.50' in xy3ctl.run('packets', '--big-endian', path)[1]


@pytest.mark.parametrize('seed', range(20))
def test_damaged_capture(capture, seed):
    """The tool counts what an independent decoder counts."""
    data = bytearray()
    for number in range(60):
        data += wire.sync() + wire.temperatures([seed * 10 + number] * 3)
    for place in range(seed * 7 + 5, len(data), 41 + seed):
        data[place] ^= 1 << (place % 8)
    decoder = wire.Decoder()
    decoder.feed(bytes(data))
    status, output, _ = xy3ctl.run('packets', '-j', capture(data))
    assert status == OK
    documents = xy3ctl.documents(output)
    counts = documents[-1]['counts']
    assert [counts[name] for name in ('packets', 'dropped_bytes', 'resyncs', 'bad_lengths')] == \
        [decoder.packets, decoder.dropped, decoder.resyncs, decoder.bad_lengths]
    assert len(documents) - 1 == decoder.packets


def test_no_packet(capture):
    for data in b'\xff' * 100, b'':
        assert xy3ctl.run('packets', capture(data))[0] == FAILURE
    assert_status(FAILURE, 'packets', '/tmp', says='directory')
    assert_status(FAILURE, 'packets', '/no/such/file', says='No such file')
