# SPDX-License-Identifier: GPL-2.0-only
"""Debian's xhc-hb04, the HAL component of LinuxCNC that drives real HB04 units by libusb, with the
virtual HB04: the LCD shows the values that the program sends, and keys, selector and wheel appear
on its pins. Both were written independently.

The program detaches the pendant from hid-xhc, which must be bound again afterwards.
"""

import contextlib
import glob
import os
import re
import signal
import subprocess
import threading

import pytest

import rig
import udevd
from case import row
from halcmd import USER, Halcmd
from kernel import wait
from rig import find, pressed
from xhc_sim.lcd import COORDINATES
from xhc_sim.usb import UsbPendant
from xhcctl_tool import LAYOUTS, environment, run

COMPONENT = 'xhc-hb04'
LIMIT = 60              # timeout in seconds; an idle machine needs none of it
CONFIG = '/usr/share/linuxcnc/hallib/xhc-hb04-%s.cfg'
POSITIONS = ['%s.pos-%s' % (axis, kind) for kind in ('relative', 'absolute') for axis in 'xyz']
SELECTOR = {'off': 'off', 'x': 'x', 'y': 'y', 'z': 'z', 'a': 'a', 'spindle': 'spindle-override',
            'feed': 'feed-override'}
# the name of a key in the program -> its labels in our layouts
CAPTIONS = {
    'goto-zero': ['Goto zero'], 'start-pause': ['Start/Pause'], 'rewind': ['Rewind'],
    'probe-z': ['Probe-Z'], 'macro-3': ['Macro 3'], 'half': ['1/2='], 'zero': ['0='],
    'safe-z': ['Safe-Z'], 'home': ['Goto home', 'Home'], 'macro-1': ['Macro 1'],
    'macro-2': ['Macro 2'], 'spindle': ['Spindle'], 'step': ['STEP++', 'Step'],
    'mode': ['MPG/MODE', 'Mode'], 'macro-6': ['Macro 6'], 'macro-7': ['Macro 7'],
    'stop': ['Stop'], 'reset': ['Reset'], 'x2': ['X/2='], 'y2': ['Y/2='], 'x0': ['X=0'],
    'y0': ['Y=0'], 'z0': ['Z=0'],
}


class XhcHb04:
    """The program as LinuxCNC starts it, in a separate HAL"""

    def __init__(self, *options, config='layout2'):
        self.halcmd = Halcmd()
        self.process = subprocess.Popen(
            [*USER, 'xhc-hb04', '-I', CONFIG % config, '-H', *options],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def pins(self):
        return self.halcmd.pins(COMPONENT)

    def set(self, pins):
        self.halcmd.set_pins(COMPONENT, pins)

    def wait_for(self, **wanted):
        """Waits until pins have these values; - and . of pin names are _ in arguments."""
        found = {}

        def as_wanted():
            assert self.process.poll() is None, self.process.stdout.read()
            found.update((re.sub('[-.]', '_', name), value) for name, value in self.pins().items())
            return wanted.items() <= found.items()

        assert wait(as_wanted, LIMIT, 0.02), {name: found.get(name) for name in wanted}

    def keys(self):
        """Names of pressed keys"""
        return [name.removeprefix('button-') for name, value in self.pins().items()
                if name.startswith('button-') and value == 'TRUE']

    def end(self, how=signal.SIGTERM):
        """-> its output"""
        self.process.send_signal(how)
        return self.process.communicate(timeout=LIMIT)[0]

    def close(self):
        if self.process.poll() is None:
            self.end(signal.SIGKILL)
        self.halcmd.close()


class TryOut(XhcHb04):
    """The program as a user starts it to test a pendant: without HAL it prints the reports and
    moves a simulated machine."""

    def __init__(self):
        self.process = subprocess.Popen([*USER, 'xhc-hb04', '-I', CONFIG % 'layout2'], text=True,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def close(self):
        if self.process.poll() is None:
            self.end(signal.SIGKILL)


def wait_seen(device):
    """Waits until the program has read all reports: it does so before it sends a frame, and the
    frame in progress may have been started before the last report."""
    assert wait(lambda: not device.pending(), LIMIT), 'it does not ask for reports'
    assert device.wait_frames(device.frame_count + 2, LIMIT), 'it sends no frame'


@contextlib.contextmanager
def using(program, pendant):
    """The program, once it has claimed the pendant"""
    try:
        assert wait(lambda: find.driver(pendant.interface) == 'usbfs', LIMIT), \
            'it does not take the pendant'
        wait_seen(pendant.device)
        yield program
    finally:
        program.close()


def find_interface():
    """The USB interface of the pendant with any driver; None if there is none"""
    for path in glob.glob('/sys/bus/usb/devices/*:1.0'):
        with contextlib.suppress(OSError):          # it is being removed
            if rig.read_file(os.path.realpath(path) + '/../idVendor') == '10ce\n':
                return os.path.realpath(path)
    return None


def usb_node(interface):
    """The node that libusb opens"""
    usb = os.path.dirname(interface)
    return '/dev/bus/usb/%03d/%03d' % tuple(
        int(rig.read_file('%s/%s' % (usb, name))) for name in ('busnum', 'devnum'))


def bind(pendant):
    """Binds hid-xhc to the pendant again, as a user does"""
    rig.write_file('/sys/bus/usb/drivers/usbhid/bind', os.path.basename(pendant.interface))


def assert_driven(pendant):
    """hid-xhc is bound again: keys cause events, and the display shows its values."""
    pendant.plug(first_frame=False)
    pendant.interface = find_interface()
    pendant.device.press(0x17)
    assert pendant.packet(LIMIT) == pressed(0x17)
    pendant.device.release(0x17)
    assert pendant.packet(LIMIT)
    pendant.set('work_x', '-220.334')
    assert pendant.shows('work_x', '-220.3340', LIMIT)


@pytest.fixture(scope='module', autouse=True)
def machine():
    rig.load()
    with udevd.running():
        yield


@pytest.fixture(scope='class')
def pendant():
    """Plugged in, bound to hid-xhc, and accessible to the program by the rule of LinuxCNC"""
    plugged = rig.Rig(device=UsbPendant('HB04')).plug()
    plugged.interface = find_interface()
    node = usb_node(plugged.interface)
    assert wait(lambda: os.stat(node).st_mode & 0o777 == 0o666, LIMIT), 'no rule for libusb'
    yield plugged
    plugged.unplug()


@pytest.fixture(scope='class')
def program(pendant):
    with using(XhcHb04(), pendant) as running:
        yield running


class TestDisplay:
    VALUES = {          # value of a pin -> text on the LCD: the program rounds to 1/1000
        '135.17': '135.1700', '-220.334': '-220.3340', '12.3456': '12.3460', '1.9996': '2.0000',
        '-0.0004': '0.0000', '-0.5': '-0.5000', '9999.999': '9999.9990', '-9999.999': '-9999.9990',
        '0': '0.0000', '-77.89': '-77.8900',
    }

    @staticmethod
    def assert_shown(pendant, wanted):
        device = pendant.device
        assert device.wait_for(lambda: wanted.items() <= device.lcd.as_dict().items(), LIMIT), \
            {name: device.lcd.as_dict()[name] for name in wanted}
        assert device.lcd.faults == []

    @pytest.mark.parametrize('first', range(len(VALUES)))
    def test_positions(self, pendant, program, first):
        """Six different values at a time, each once in each field"""
        values = (list(self.VALUES) * 2)[first:first + len(POSITIONS)]
        program.set(dict(zip(POSITIONS, values)))
        self.assert_shown(pendant, dict(zip(COORDINATES, [self.VALUES[value] for value in values])))

    @pytest.mark.parametrize('feed_override, spindle_override, feed, speed', [
        ('1.23', '0.8', '20', '300'),           # per cent; per second on the pins, per minute shown
        ('0', '1', '0.5', '1092'), ('655.35', '2.5', '1092.25', '0.1'), ('1', '0', '0', '416.65')])
    def test_numbers(self, pendant, program, feed_override, spindle_override, feed, speed):
        program.set({'feed-override': feed_override, 'spindle-rps': speed,
                                    'spindle-override': spindle_override, 'feed-value': feed})
        self.assert_shown(pendant, {
            'feedrate_override': round(float(feed_override) * 100),
            'spindle_override': round(float(spindle_override) * 100),
            'feedrate': round(float(feed) * 60), 'spindle_speed': round(float(speed) * 60)})

    def test_inch(self, pendant, program):
        for value, state in (('1', 'inch'), ('0', 'idle')):
            program.set({'inch-icon': value})
            self.assert_shown(pendant, {'state': state})

    def test_axis_a(self, pendant, program):
        """A has no separate field: the program shows it in that of X."""
        program.set({'x.pos-relative': 1, 'x.pos-absolute': 2, 'a.pos-relative': -3,
                                    'a.pos-absolute': -4})
        for position, work, machine in (('a', '-3.0000', '-4.0000'), ('x', '1.0000', '2.0000')):
            pendant.device.select(pendant.device.model.selector_code(position))
            self.assert_shown(pendant, {'work_x': work, 'machine_x': machine})


class TestSteps:
    """The five sequences of steps of the program; in LinuxCNC STEP++ selects the next step."""

    @pytest.mark.parametrize('number, steps', [
        ('1', [1, 10, 100, 1000]), ('2', [1, 5, 10, 20]), ('3', [1, 10, 100]),
        ('4', [1, 5, 10, 20, 50, 100]), ('5', [1, 10, 50, 100, 1000])])
    def test_sequence(self, pendant, number, steps):
        device = pendant.device
        with using(XhcHb04('-s', number), pendant) as program:
            program.halcmd.run('net next xhc-hb04.button-step => xhc-hb04.stepsize-up')
            program.wait_for(stepsize=str(steps[0]))
            assert pendant.shows('step', steps[0], LIMIT)
            for step in [*steps[1:], *steps]:
                device.press(device.model.key_code('STEP++'))
                assert pendant.shows('step', step, LIMIT)
                device.release(device.model.key_code('STEP++'))
                wait_seen(device)
            program.wait_for(stepsize=str(steps[-1]))
            assert device.lcd.faults == []


class TestReports:
    @pytest.mark.parametrize('config, layout', [('layout1', 'hb04-16'), ('layout2', 'hb04-18')])
    def test_keys(self, pendant, config, layout):
        """Scan codes and labels of the program equal those of our layouts."""
        with open('%s/%s.layout' % (LAYOUTS, layout), encoding='ascii') as file:
            keys = [line.split('\t')[:2] for line in file if line[:2].isalnum()
                    and line[2] == '\t']
        assert len(keys) == int(layout[-2:])
        with using(XhcHb04(config=config), pendant) as program:
            for scan, caption in keys:
                with row(scan, caption):
                    pendant.device.press(int(scan, 16))
                    assert wait(program.keys, LIMIT), 'no key'
                    name, = program.keys()
                    assert caption in CAPTIONS[name]
                    pendant.device.release(int(scan, 16))
                    assert wait(lambda: not program.keys(), LIMIT), 'it stays down'

    def test_reports_byte_by_byte(self, pendant):
        """As printed by the program, which also shows the movement of the wheel on the display"""
        device = pendant.device
        with using(TryOut(), pendant) as program:
            device.select(0x11)
            device.press(0x17)
            device.turn(3)
            device.release(0x17)
            device.turn(-5)
            assert pendant.shows('work_x', '-0.0020', LIMIT)
            device.sleep()
            device.wake()
            wait_seen(device)
            lines = program.end().splitlines()
        # it sends day 12
        assert [line.strip() for line in lines if line.startswith('04 ')] == [
            '04 00 00 11 00 0C', '04 17 00 11 00 1B button-reset pressed',
            '04 17 00 11 03 1B button-reset pressed delta  +3', '04 00 00 11 00 0C',
            '04 00 00 11 FB 0C  delta  -5', '04 00 00 00 00 00', '04 00 00 11 00 0C']


class TestHands:
    def test_selector(self, pendant, program):
        for position, name in [*SELECTOR.items(), *reversed(SELECTOR.items())]:
            pendant.device.select(pendant.device.model.selector_code(position))
            program.wait_for(**{'jog_enable_' + each.replace('-', '_'):
                                'TRUE' if each == name else 'FALSE' for each in SELECTOR.values()})

    def test_wheel(self, pendant, program):
        place = 0
        for detents in (1, -1, 5, -10, 10, 127, -128):
            pendant.device.turn(detents)
            place += detents
            program.wait_for(jog_counts=str(place), jog_counts_neg=str(-place))

    def test_sleep(self, pendant, program):
        device = pendant.device
        device.select(device.model.selector_code('y'))
        device.press(device.model.key_code('Rewind'))
        program.wait_for(sleeping='FALSE', jog_enable_y='TRUE', button_rewind='TRUE')
        device.sleep()
        program.wait_for(sleeping='TRUE', jog_enable_y='FALSE', jog_enable_off='TRUE',
                         button_rewind='FALSE')
        device.wake()
        program.wait_for(sleeping='FALSE', jog_enable_y='TRUE', jog_enable_off='FALSE')

    def test_idle_is_not_sleep(self, pendant, program):
        """With the selector off and no key, only the day in the last byte differs."""
        device = pendant.device
        device.wake()
        device.select(0)
        program.wait_for(sleeping='FALSE', jog_enable_off='TRUE')
        device.sleep()
        program.wait_for(sleeping='TRUE', jog_enable_off='TRUE')
        device.wake()
        program.wait_for(sleeping='FALSE', jog_enable_off='TRUE')


class TestDriver:
    """hid-xhc when the pendant is detached, and afterwards"""

    def test_bind_after_it_has_ended(self, pendant):
        node = pendant.event_node
        with using(XhcHb04(), pendant) as program:
            assert find.hid_directory(pendant.device.phys) is None
            assert wait(lambda: not os.path.exists(node), LIMIT)
            program.end()
            assert program.process.returncode == 0
        assert find.driver(pendant.interface) is None
        bind(pendant)
        assert_driven(pendant)

    def test_bind_after_it_was_killed(self, pendant):
        with using(XhcHb04(), pendant) as program:
            program.end(signal.SIGKILL)
        assert find.driver(pendant.interface) is None
        bind(pendant)
        assert_driven(pendant)

    def test_plugged_in_again_after_it_has_ended(self, pendant):
        with using(XhcHb04(), pendant) as program:
            program.end()
        pendant.device.detach()
        assert wait(lambda: not os.path.exists(pendant.interface), LIMIT)
        pendant.plug()
        assert_driven(pendant)

    def test_the_command_that_doctor_prints(self, pendant):
        """Ends the program and binds hid-xhc again, without the delay of sudo and tee."""
        at_once = 'sudo() { "$@"; }; tee() { read -r line && echo "$line" > "$1"; }; '
        with using(XhcHb04(), pendant) as program:
            document, = run('doctor', '--json', env=environment()).json()
            findings = {finding['id']: finding for finding in document['findings']}
            assert 'xhc-hb04 has detached' in findings['holder']['text']
            subprocess.run(['bash', '-c', at_once + findings['holder']['fix']], check=True)
            assert program.process.wait(LIMIT) == 0
        assert_driven(pendant)

    def test_taken_while_its_display_is_written(self, pendant):
        done = threading.Event()
        written = []

        def write():
            path, number = pendant.path, 0
            with contextlib.suppress(OSError):      # until it has exited
                while not done.is_set():
                    number += 1
                    rig.write_file(path + '/dro/work_x', '%d' % number)
                    rig.write_file(path + '/dro/flush', '1')
                    written.append(number)

        for _ in range(3):
            writer = threading.Thread(target=write)
            writer.start()
            assert wait(lambda: written, LIMIT)
            with using(XhcHb04(), pendant) as program:
                writer.join(LIMIT)
                assert not writer.is_alive()
                program.end()
            bind(pendant)
            assert_driven(pendant)
            written.clear()

    def test_unplugged_while_it_is_taken(self, pendant):
        """The program waits for the pendant, and detaches it again before hid-xhc can be used."""
        with using(XhcHb04(), pendant) as program:
            pendant.device.unplug()
            program.wait_for(connected='FALSE')
            pendant.device.plug()
            program.wait_for(connected='TRUE')
            program.set({'z.pos-absolute': '7.5'})
            assert pendant.shows('machine_z', '7.5000', LIMIT)
            program.end()
            assert program.process.returncode == 0
        pendant.interface = find_interface()
        bind(pendant)
        assert_driven(pendant)
