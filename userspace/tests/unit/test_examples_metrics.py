# SPDX-License-Identifier: GPL-2.0-only
"""The example that converts the output of xy3ctl to metrics, with a head in an artificial /sys."""

import os
import re
import subprocess
import sys

import pytest
from planted_head import PlantedHead

HERE = os.path.dirname(os.path.realpath(__file__))
METRICS = os.path.join(HERE, '..', '..', 'examples', 'xy3_metrics.py')
SAMPLE = re.compile(r'([a-z0-9_]+)\{((?:[a-z]+="(?:[^"\\]|\\.)*",?)+)\} (-?[0-9.]+)')


@pytest.fixture
def head():
    planted = PlantedHead()
    planted.plant()
    yield planted
    planted.close()


def metrics(text, *words):
    return subprocess.run([sys.executable, '-B', METRICS, *words], input=text, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)


def shown(head):
    """-> the output of the example for the output of xy3ctl, and its samples"""
    status, document, errors = head.xy3ctl.run('show', '--json')
    assert (status, errors) == (0, '')
    done = metrics(document)
    assert (done.returncode, done.stderr) == (0, '')
    samples = {}
    for line in done.stdout.splitlines():
        if not line.startswith('#'):
            name, labels, value = SAMPLE.fullmatch(line).groups()
            assert samples.setdefault((name, labels), float(value)) == float(value)
    return done.stdout, samples


def test_all_of_a_head(head):
    for name, text in (('vendor', 'A "B" \\ C'), ('serial', '0042'), ('temperature/head', '31500'),
                       ('errors/galvo_x', 'temperature'), ('hours/dac_x', '1230'),
                       ('frame_errors/x', '7'), ('stats/lost_packets', '3')):
        head.write('%s/%s' % (head.head, name), text)
    head.write(head.iio + '/underruns', '5')
    _, samples = shown(head)
    assert samples['xy3_info', 'head="xy3-0",vendor="A \\"B\\" \\\\ C",model="",firmware="",'
                               'serial="0042"'] == 1
    for name, labels, value in (
            ('xy3_in_sync', '', 1), ('xy3_rate_bits_per_second', '', 115200),
            ('xy3_error', ',component="galvo_x",error="temperature"', 1),
            ('xy3_operating_hours', ',component="dac_x"', 1230),
            ('xy3_frame_errors', ',axis="x"', 7),
            ('xy3_backchannel_total', ',counter="lost_packets"', 3),
            ('xy3_forward_total', ',counter="underruns"', 5),
            ('xy3_forward_frames_per_second', ',kind="sampling"', 100000)):
        assert samples[name, 'head="xy3-0"' + labels] == value, name
    assert ('xy3_forward_total', 'head="xy3-0",counter="frame_bits"') not in samples


def test_format(head):
    """Each metric is described once, before its contiguous samples."""
    text, _ = shown(head)
    names = [re.split('[ {]', line)[2 if line.startswith('#') else 0] for line in text.splitlines()]
    assert [name for at, name in enumerate(names) if name not in names[:at]] == \
        [name for name, before in zip(names, [''] + names) if name != before]
    for name in set(names):
        kinds = [line.split()[3] for line in text.splitlines()
                 if line.startswith('# TYPE %s ' % name)]
        assert kinds == ['counter' if name.endswith('_total') else 'gauge']


def test_two_heads(head):
    _, document, _ = head.xy3ctl.run('show', '--json')
    text = metrics(document + document.replace('xy3-0', 'xy3-1')).stdout
    assert text.count('# TYPE xy3_in_sync ') == 1
    assert 'xy3_in_sync{head="xy3-0"} 1\nxy3_in_sync{head="xy3-1"} 1\n' in text


def test_no_head():
    """No sample, and no error: the collector then drops the metrics of a removed head."""
    done = metrics('{"schema": 1, "tool": "xy3ctl", "verb": "show", "error": "no scanhead"}\n')
    assert (done.returncode, done.stdout, done.stderr) == (0, '', '')


def test_file(head, tmp_path):
    """It is replaced atomically, and no other file is left."""
    path = tmp_path / 'xy3.prom'
    path.write_text('old\n')
    with open(path, encoding='ascii') as reader:
        _, document, _ = head.xy3ctl.run('show', '--json')
        assert metrics(document, '-o', str(path)).stdout == ''
        assert reader.read() == 'old\n'
    assert path.read_text() == metrics(document).stdout
    assert os.listdir(tmp_path) == ['xy3.prom']
