# SPDX-License-Identifier: GPL-2.0-only
"""The examples for pendants, as documented, with a virtual pendant of each model; and the picture
of an LCD in README.md.
"""

import os
import select
import subprocess
import sys

import pytest
import rig

EXAMPLES = os.path.realpath(os.path.join(rig.HERE, '..', '..', 'examples'))
LIMIT = 60              # seconds; only reached on failure
sys.path.insert(0, os.path.join(EXAMPLES, '..', 'demo'))

import pictures  # noqa: E402 (needs the path)


@pytest.fixture(scope='module', autouse=True)
def driver():
    rig.load()
    yield
    rig.unload()


@pytest.fixture(params=('HB03', 'HB04', 'WHB04B'))
def pendant(request):
    plugged = rig.Rig(request.param).plug()
    yield plugged
    if plugged.path:
        plugged.unplug()


class Example:
    def __init__(self, name, *words):
        self.process = subprocess.Popen(
            ['/usr/bin/python3', '-B', '%s/%s.py' % (EXAMPLES, name), *words], text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.text = ''          # output not returned yet: several lines may arrive at once

    def line(self):
        pipe = self.process.stdout.fileno()
        while '\n' not in self.text:
            ready, _, _ = select.select([pipe], [], [], LIMIT)
            assert ready, 'not a line in %d s' % LIMIT
            data = os.read(pipe, 4096)
            assert data, 'it has ended'
            self.text += data.decode()
        line, _, self.text = self.text.partition('\n')
        return line

    def has_open(self, node):
        """Whether it has opened a node: it only receives later events."""
        folder = '/proc/%d/fd' % self.process.pid
        try:
            return node in [os.readlink(os.path.join(folder, name)) for name in os.listdir(folder)]
        except FileNotFoundError:
            return False            # it has closed another file meanwhile

    def end(self):
        """-> (status, last line)"""
        _, errors = self.process.communicate(timeout=LIMIT)
        return self.process.returncode, errors.strip()

    def close(self):
        self.process.kill()
        self.process.communicate()


@pytest.fixture
def example():
    programs = []

    def start(*words):
        programs.append(Example(*words))
        return programs[-1]

    yield start
    for program in programs:
        program.close()


def test_events(pendant, example):
    """The state at its start, and all later operation"""
    device, model = pendant.device, pendant.device.model
    device.select(model.selector_code('y'))
    assert pendant.packet()
    program = example('pendant_events')
    assert program.line() == 'XHC %s Pendant %s' % (model.name, pendant.event_node)
    assert program.line() == 'selector Y'
    if model.feed:
        assert program.line().startswith('rotary ')
        device.turn_feed(model.feed_code('10%'))
        assert program.line() == 'rotary 3'
    for scan in range(1, rig.LAST_KEY[model.name] + 1):
        device.press(scan)
        assert program.line() == 'press %02xh' % scan
        device.release(scan)
        assert program.line() == 'release %02xh' % scan
    device.press(0x40)          # the driver knows no such key, and sends its scan code alone
    device.release(0x40)
    for position, name in (('x', 'X'), ('z', 'Z'), ('off', 'off')):
        device.select(model.selector_code(position))
        assert program.line() == 'selector ' + name
    device.select(model.selector_code('x'))
    assert program.line() == 'selector X'
    for detents in (1, -1, 20, -128, 127):
        device.turn(detents)
        assert program.line() == 'wheel %d' % detents
    device.select(model.selector_code('off'))
    assert program.line() == 'selector off'
    pendant.unplug()
    assert program.end() == (1, 'the pendant is gone')


def test_bcnc(pendant, example):
    device, model = pendant.device, pendant.device.model
    device.select(model.selector_code('x'))
    step = 0.01
    if model.feed:
        device.turn_feed(model.feed_code('10%'))
        step = 0.1
    program = example('pendant_bcnc', '--dry-run', pendant.event_node)
    assert rig.wait(lambda: program.has_open(pendant.event_node))
    device.turn(-2)
    assert program.line() == 'gcode $J=G91 G21 X%.3f F1000' % (-2 * step)
    device.press({'HB03': 0x01, 'HB04': 0x16, 'WHB04B': 0x02}[model.name])
    assert program.line() == 'cmd FEEDHOLD'
    pendant.unplug()
    status, words = program.end()
    assert (status, words.count('\n')) == (1, 0)
    assert 'No such device' in words


@pytest.mark.parametrize('name', ('pendant_events', 'pendant_bcnc'))
def test_no_pendant(example, name):
    status, words = example(name).end()
    assert (status, words.count('\n')) == (1, 0)
    assert 'no pendant' in words


def test_picture():
    """The commands of README.md give the LCD of its picture."""
    plugged = rig.Rig('HB04').plug()
    try:
        plugged.set('position', '135.17 -77.89 0 -220.334 0 1.5')
        for name, text in (('step', '10'), ('state', 'run'), ('feedrate', '1200'),
                           ('spindle_speed', '18000'), ('feedrate_override', '100'),
                           ('spindle_override', '80')):
            plugged.set(name, text)
        plugged.settle()
        lines = plugged.device.lcd.lines(selector='x')
        assert [line[2:42] for line in lines[1:-1]] == pictures.lcd_lines()
    finally:
        plugged.unplug()
