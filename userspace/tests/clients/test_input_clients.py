# SPDX-License-Identifier: GPL-2.0-only
"""The node of hid-xhc in third-party programs: evtest, python-evdev, jstest, and hal_input of
LinuxCNC, each with all keys, all positions of the selector and the wheel; and libinput, which
ignores a pendant.
"""

import contextlib
import os
import re
import select
import subprocess

import evdev
import pytest

import rig
import udevd
from evdev import ecodes
from halcmd import USER, Halcmd
from kernel import is_loaded, load_module, wait

LIMIT = 60              # timeout in seconds; an idle machine needs none of it
SCAN_CODES = range(1, 0x18)
SELECTOR = {1: 'x', 2: 'y', 3: 'z', 4: 'a', 5: 'feed', 6: 'spindle'}      # ABS_MISC -> position
BUTTONS = [*(ecodes.BTN_TRIGGER_HAPPY + scan - 1 for scan in SCAN_CODES),
           *(ecodes.BTN_TRIGGER_HAPPY31 + number - 1 for number in SELECTOR)]
DIALOUT = 20


@pytest.fixture(scope='module', autouse=True)
def machine():
    rig.load()
    with udevd.running():
        yield


@pytest.fixture
def pendant():
    plugged = rig.Rig('HB04').plug()
    assert wait(lambda: os.stat(plugged.event_node).st_gid == DIALOUT, LIMIT), 'no rule of ours'
    yield plugged
    plugged.unplug()


class Program:
    """A program and the lines of its output"""

    def __init__(self, *words):
        self.process = subprocess.Popen(['stdbuf', '-oL', *words], stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT)
        self.rest = b''

    def line(self):
        """The next line, which must be printed"""
        while b'\n' not in self.rest:
            ready, _, _ = select.select([self.process.stdout], [], [], LIMIT)
            assert ready, 'not a line in %d s' % LIMIT
            data = os.read(self.process.stdout.fileno(), 65536)
            assert data, 'it has ended: %r' % self.rest
            self.rest += data
        line, self.rest = self.rest.split(b'\n', 1)
        return line.decode()

    def until(self, text):
        """-> the lines before the one that starts with this text"""
        lines = []
        while not (line := self.line()).startswith(text):
            lines.append(line)
        return lines

    def close(self):
        self.process.kill()
        self.process.communicate()


@contextlib.contextmanager
def running(*words):
    program = Program(*words)
    try:
        yield program
    finally:
        program.close()


def use_all(pendant):
    """Operates all controls; -> (control, number or detents, down) of each step, after it."""
    device = pendant.device
    for scan in SCAN_CODES:
        device.press(scan)
        yield 'key', scan, 1
        device.release(scan)
        yield 'key', scan, 0
    for number, position in SELECTOR.items():
        device.select(device.model.selector_code(position))
        yield 'selector', number, 1
    device.select(0)
    yield 'selector', 0, 1
    for detents in (1, -1, 10, -128, 127):
        device.turn(detents)
        yield 'wheel', detents, 1


def events_of(what, number, down, before):
    """The events of a step of use_all(); before: the previous position of the selector"""
    if what == 'key':
        return [(ecodes.EV_MSC, ecodes.MSC_SCAN, number),
                (ecodes.EV_KEY, ecodes.BTN_TRIGGER_HAPPY + number - 1, down)]
    if what == 'wheel':
        return [(ecodes.EV_REL, ecodes.REL_DIAL, number)]
    positions = [(before, 0), (number, 1)]
    return [(ecodes.EV_ABS, ecodes.ABS_MISC, number)] + [
        (ecodes.EV_KEY, ecodes.BTN_TRIGGER_HAPPY31 + position - 1, value)
        for position, value in positions if position]


def steps(pendant):
    """-> for each step of use_all(), after it: its events"""
    before = 0
    for what, number, down in use_all(pendant):
        yield events_of(what, number, down, before)
        before = number if what == 'selector' else before


class TestEvtest:
    EVENT = re.compile(r'Event: time \d+\.\d+, type (\d+) \(\w+\), code (\d+) \(\w+\), '
                       r'value (-?\w+)$')

    def listening(self, pendant):
        return running('evtest', pendant.event_node)

    def test_what_there_is(self, pendant):
        with self.listening(pendant) as evtest:
            lines = [line.strip() for line in evtest.until('Testing')]
        assert lines[0].startswith('Input driver version')
        assert lines[1].startswith('Input device ID: bus 0x3 vendor 0x10ce product 0xeb70 version')
        assert lines[2] == 'Input device name: "XHC HB04 Pendant"'
        codes = [line for line in lines if line.startswith('Event code')]
        assert codes == ['Event code %d (%s)' % (code, name) for code, name in [
            *((code, 'BTN_TRIGGER_HAPPY%d' % (code - ecodes.BTN_TRIGGER_HAPPY + 1))
              for code in BUTTONS),
            (ecodes.REL_DIAL, 'REL_DIAL'), (ecodes.ABS_MISC, 'ABS_MISC'),
            (ecodes.MSC_SCAN, 'MSC_SCAN')]]
        assert [line.split() for line in lines if line[:3] in ('Val', 'Min', 'Max')] == \
            [['Value', '0'], ['Min', '0'], ['Max', '6']]

    def test_events(self, pendant):
        with self.listening(pendant) as evtest:
            evtest.until('Testing')
            for events in steps(pendant):
                found = []
                while 'SYN_REPORT' not in (line := evtest.line()):
                    kind, code, value = self.EVENT.match(line).groups()
                    scan = int(kind) == ecodes.EV_MSC       # in base 16
                    found.append((int(kind), int(code), int(value, 16 if scan else 10)))
                assert found == events

    def test_query(self, pendant):
        def query(button):
            return subprocess.run(['evtest', '--query', pendant.event_node, 'EV_KEY', str(button)],
                                  check=False).returncode

        pendant.device.press(0x17)
        assert wait(lambda: query(ecodes.BTN_TRIGGER_HAPPY23) == 10, LIMIT)
        assert query(ecodes.BTN_TRIGGER_HAPPY22) == 0
        pendant.device.release(0x17)
        assert wait(lambda: query(ecodes.BTN_TRIGGER_HAPPY23) == 0, LIMIT)


class TestPythonEvdev:
    @pytest.fixture
    def device(self, pendant):
        with contextlib.closing(evdev.InputDevice(pendant.event_node)) as device:
            yield device

    @staticmethod
    def read(device):
        """-> the events of the next report"""
        events = []
        while True:
            assert select.select([device], [], [], LIMIT)[0], 'no event'
            event = device.read_one()
            if (event.type, event.code) == (ecodes.EV_SYN, ecodes.SYN_REPORT):
                return events
            events.append((event.type, event.code, event.value))

    def test_what_there_is(self, pendant, device):
        assert (device.name, device.phys, device.uniq) == ('XHC HB04 Pendant', pendant.device.phys,
                                                           '')
        assert device.info[:3] == (ecodes.BUS_USB, 0x10CE, 0xEB70)
        found = device.capabilities()
        del found[ecodes.EV_SYN]
        assert found == {ecodes.EV_KEY: BUTTONS, ecodes.EV_REL: [ecodes.REL_DIAL],
                         ecodes.EV_ABS: [(ecodes.ABS_MISC, evdev.AbsInfo(0, 0, 6, 0, 0, 0))],
                         ecodes.EV_MSC: [ecodes.MSC_SCAN]}

    def test_events(self, pendant, device):
        for events in steps(pendant):
            assert self.read(device) == events

    def test_state(self, pendant, device):
        """State for a program that starts when a key is down and the selector at Z"""
        pendant.device.press(0x0C)
        pendant.device.select(0x13)
        for _ in range(2):
            self.read(device)
        with contextlib.closing(evdev.InputDevice(pendant.event_node)) as late:
            assert late.active_keys() == [ecodes.BTN_TRIGGER_HAPPY12, ecodes.BTN_TRIGGER_HAPPY33]
            assert late.absinfo(ecodes.ABS_MISC).value == 3

    def test_grab(self, pendant, device):
        device.grab()
        pendant.device.turn(1)
        assert self.read(device) == [(ecodes.EV_REL, ecodes.REL_DIAL, 1)]
        device.ungrab()
        pendant.device.turn(2)
        assert pendant.packet(LIMIT) == rig.turned(2)

    def test_unplugged(self, pendant, device):
        pendant.unplug()
        assert select.select([device], [], [], LIMIT)[0]
        with pytest.raises(OSError, match='No such device'):
            device.read_one()


class TestJstest:
    """The joystick interface: a button for each key and position, an axis for the selector"""

    @pytest.fixture
    def jstest(self, pendant):
        if not is_loaded('joydev'):
            load_module(os.environ['JOYDEV_MODULE'])
        node = wait(lambda: self.node(pendant), LIMIT)
        assert node, 'joydev makes no node'
        with running('jstest', '--event', node) as jstest:
            yield jstest

    @staticmethod
    def node(pendant):
        """js..., once it exists"""
        event = os.path.realpath('/sys/class/input/' + os.path.basename(pendant.event_node))
        for name in os.listdir(os.path.dirname(event)):
            if re.match(r'js\d+$', name) and os.path.exists('/dev/input/' + name):
                return '/dev/input/' + name
        return None

    @staticmethod
    def event(jstest):
        line = jstest.line()
        found = re.match(r'Event: type (\d+), time -?\d+, number (\d+), value (-?\d+)$', line)
        assert found, line
        return tuple(map(int, found.groups()))

    def test_events(self, pendant, jstest):
        head = ' '.join(jstest.until('Testing'))
        assert 'Joystick (XHC HB04 Pendant) has 1 axes ' in head
        assert 'and %d buttons' % len(BUTTONS) in head
        start = {self.event(jstest) for _ in range(len(BUTTONS) + 1)}
        assert start == {(129, number, 0) for number in range(len(BUTTONS))} | {(130, 0, -32767)}
        for events in steps(pendant):
            for kind, code, value in events:
                if kind == ecodes.EV_KEY:
                    assert self.event(jstest) == (1, BUTTONS.index(code), value)
                elif kind == ecodes.EV_ABS:
                    assert self.event(jstest)[:2] == (2, 0)
        # no wheel: the next event that it shows is a key
        pendant.device.press(1)
        assert self.event(jstest) == (1, 0, 1)


class TestHalInput:
    """Runs as a user of the group dialout"""

    @pytest.fixture
    def hal(self, pendant):
        halcmd = Halcmd()
        process = subprocess.Popen([*USER, 'hal_input', '-KRA', 'XHC'])
        try:
            assert wait(lambda: process.poll() is not None or 'hal_input' in
                        halcmd.run('show comp hal_input').split(), LIMIT)
            assert wait(lambda: process.poll() is not None or
                        'rel-dial-counts' in halcmd.pins('input.0'), LIMIT)
            assert process.poll() is None
            yield halcmd
        finally:
            process.terminate()
            process.wait(LIMIT)
            halcmd.close()

    @staticmethod
    def state(hal):
        """-> (keys and positions that are down, position, counts of the wheel)"""
        pins = hal.pins('input.0')
        down = {name for name, value in pins.items()
                if re.match(r'btn-trigger-happy\d+$', name) and value == 'TRUE'}
        for name in down:
            assert pins[name + '-not'] == 'FALSE'
        return down, int(pins['abs-misc-counts']), int(pins['rel-dial-counts'])

    def test_pins(self, pendant, hal):
        buttons = {'btn-trigger-happy%d' % (code - ecodes.BTN_TRIGGER_HAPPY + 1)
                   for code in BUTTONS}
        assert {name for name in hal.pins('input.0') if re.match(r'btn-.*\d$', name)} == buttons
        counts = 0
        for what, number, down in use_all(pendant):
            wanted, position = set(), 0
            if what == 'key' and down:
                wanted = {'btn-trigger-happy%d' % number}
            elif what == 'selector' and number:
                wanted, position = {'btn-trigger-happy%d' % (30 + number)}, number
            elif what == 'wheel':
                counts += number
            assert wait(lambda: self.state(hal) == (wanted, position, counts), LIMIT, 0.02), \
                (what, number, down, self.state(hal))

    def test_sleep_lets_everything_go(self, pendant, hal):
        pendant.device.press(3)
        pendant.device.select(0x12)
        assert wait(lambda: self.state(hal)[:2] ==
                    ({'btn-trigger-happy3', 'btn-trigger-happy32'}, 2), LIMIT, 0.02)
        pendant.device.sleep()
        assert wait(lambda: self.state(hal)[:2] == (set(), 0), LIMIT, 0.02), self.state(hal)


class TestLibinput:
    """The library that a desktop uses for keyboards and mice"""

    @staticmethod
    def devices():
        text = subprocess.run(['libinput', 'list-devices'], stdout=subprocess.PIPE, text=True,
                              check=True, env=udevd.ENVIRONMENT).stdout
        return re.findall(r'(?m)^Device: +(.*)$', text)

    @pytest.fixture
    def keyboard(self):
        """A keyboard besides the pendant, which is not ignored"""
        keys = range(ecodes.KEY_ESC, ecodes.KEY_F12)
        with contextlib.closing(evdev.UInput({ecodes.EV_KEY: keys}, name='keyboard')) as device:
            assert wait(lambda: 'ID_INPUT_KEYBOARD' in udevd.properties(device.device.path), LIMIT)
            yield

    def test_left_alone(self, pendant, keyboard):
        assert wait(lambda: udevd.properties(pendant.event_node).get('ID_INPUT_JOYSTICK') == '1',
                    LIMIT)
        assert self.devices() == ['keyboard']
