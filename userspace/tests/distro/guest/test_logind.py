# SPDX-License-Identifier: GPL-2.0-only
"""The key Reset of a pendant and systemd-logind, which restarts the computer for a KEY_RESTART.

There is no systemd here to do so: its action is in its log.
"""

import contextlib
import os
import re
import subprocess
import time

import libevdev
import pytest
from harness import (BIND_TIME, Plugged, command, find, read_file, reload_rules, trigger,
                     udev_properties, wait_for)

RULES = '/usr/lib/udev/rules.d/70-xhc-pendant.rules'
OVERRIDE = '/etc/udev/rules.d/70-xhc-pendant.rules'
HWDB = '/etc/udev/hwdb.d/61-xhc-pendant.hwdb'
LOG = '/run/logind.log'
# Possible entries of a user who does not consider the computer: on Reset, and on other keys.
OWN = ''.join(' KEYBOARD_KEY_%02x=%s\n' % key for key in (
    (0x01, 'power'), (0x02, 'sleep'), (0x03, 'suspend'), (0x17, 'restart')))
LAYOUTS = {'hb03': 'HB03', 'hb04-16': 'HB04', 'hb04-18': 'HB04', 'own': 'HB04', 'whb04b': 'WHB04B'}
RESET = {'HB03': 0x17, 'HB04': 0x17, 'WHB04B': 0x01}
LONG_PRESS = 5          # seconds, of systemd-logind
PATIENCE = 30

pytestmark = pytest.mark.timeout(600)


def log():
    return read_file(LOG)


def count(text):
    return log().count(text)


@contextlib.contextmanager
def daemon(name, *words):
    with open('/run/%s.log' % name, 'wb') as file:
        process = subprocess.Popen(words, stdout=file, stderr=file, stdin=subprocess.DEVNULL, env={
            **os.environ, 'SYSTEMD_LOG_TARGET': 'console'})
    try:
        yield process
    finally:
        process.terminate()
        process.wait(PATIENCE)


@pytest.fixture(scope='module')
def logind():
    for folder in '/run/dbus', '/run/systemd':     # created by systemd
        os.makedirs(folder, exist_ok=True)
    with daemon('dbus', 'dbus-daemon', '--system', '--nofork', '--nopidfile'):
        wait_for(lambda: os.path.exists('/run/dbus/system_bus_socket'), "D-Bus's socket", PATIENCE)
        with daemon('logind', '/lib/systemd/systemd-logind') as process:
            assert find.wait(lambda: 'New seat seat0' in log(), BIND_TIME), log()
            yield process
            assert process.poll() is None, log()


class Keyboard:
    """A keyboard with a key that is supposed to restart the computer"""

    NAME = 'keyboard with a restart key'

    def __init__(self):
        device = libevdev.Device()
        device.name = self.NAME
        device.enable(libevdev.EV_KEY.KEY_RESTART)
        self.device = device.create_uinput_device()

    def press(self, value):
        self.device.send_events([libevdev.InputEvent(libevdev.EV_KEY.KEY_RESTART, value),
                                 libevdev.InputEvent(libevdev.EV_SYN.SYN_REPORT, 0)])


@pytest.fixture(scope='module')
def keyboard(logind):
    command('modprobe', 'uinput')
    keyboard = Keyboard()
    wait_for(lambda: re.search('Watching system buttons on .*' + keyboard.NAME, log()),
             'the keyboard', BIND_TIME)
    return keyboard


@pytest.fixture(scope='module')
def pendants(keyboard):
    """One pendant for each layout, and one with keys of a user, at the same time"""
    with contextlib.ExitStack() as stack:
        found = {name: stack.enter_context(Plugged(model)) for name, model in LAYOUTS.items()}
        entries = {name: command('xhcctl', 'layout', 'hb04-16' if name == 'own' else name,
                                 '--device', pendant.node) for name, pendant in found.items()}
        entries['own'] = entries['own'].split(' XHC_LAYOUT')[0] + OWN
        with open(HWDB, 'w', encoding='ascii') as file:
            file.write('\n'.join(entries.values()))
        stack.callback(command, 'xhcctl', 'layout', 'default', '--apply')
        command('systemd-hwdb', 'update')
        command('udevadm', 'control', '--reload')
        trigger(*(pendant.node for pendant in found.values()))
        yield found


def watched(node):
    return re.search(r'Watching system buttons on %s\b' % node, log())


def press(pendant, seconds=0.0):
    reset = RESET[pendant.get('model')]
    pendant.usb.press(reset)
    pendant.events.report()
    time.sleep(seconds)
    pendant.usb.release(reset)
    pendant.events.report()


def acts():
    """The number of its actions on long and on short presses of a key"""
    return count('key pressed long'), count('key pressed short')


def check_keyboard(keyboard):
    """Waits until systemd-logind has read all events, by a key of the keyboard."""
    long, short = acts()
    keyboard.press(1)
    keyboard.press(0)
    wait_for(lambda: acts() != (long, short), 'action on the keyboard', PATIENCE)
    assert acts() == (long, short + 1)


def test_it_acts_on_a_keyboard(keyboard):
    check_keyboard(keyboard)
    keyboard.press(1)
    wait_for(lambda: count('Reboot key pressed long') == 1, 'a long press', PATIENCE)
    keyboard.press(0)


def test_without_our_rule_it_acts_on_a_pendant(keyboard, pendants):
    """Shows that the test can fail. After restoring the rule logind closes the pendant."""
    rule = 'TAG-="power-switch"\n'
    text = read_file(RULES)
    assert text.count(rule) == 1
    pendant = pendants['own']
    with open(OVERRIDE, 'w', encoding='ascii') as file:
        file.write(text.replace(rule, ''))
    try:
        reload_rules()
        trigger(pendant.node)
        wait_for(lambda: watched(pendant.node), 'the pendant', PATIENCE)
        pendant.open()
        long, short = acts()
        press(pendant)
        wait_for(lambda: acts() == (long, short + 1), 'action on Reset', PATIENCE)
        pendant.usb.press(RESET['HB04'])
        wait_for(lambda: acts() == (long + 1, short + 1), 'action on Reset, held', PATIENCE)
        pendant.usb.release(RESET['HB04'])
    finally:
        os.unlink(OVERRIDE)
        reload_rules()
        trigger(pendant.node)
    pendant.open()
    before = acts()
    press(pendant)
    check_keyboard(keyboard)
    assert acts() == (before[0], before[1] + 1)


@pytest.mark.parametrize('name', LAYOUTS)
def test_it_does_not_act_on_a_pendant(keyboard, pendants, name):
    pendant = pendants[name]
    before = acts()
    properties, _ = udev_properties(pendant.node)
    assert ':power-switch:' not in properties['CURRENT_TAGS']
    pendant.open()
    for code in 0x01, 0x02, 0x03:
        pendant.usb.press(code)
        pendant.usb.release(code)
        pendant.events.reports(2)
    press(pendant)
    press(pendant, LONG_PRESS + 2)
    check_keyboard(keyboard)
    assert acts() == (before[0], before[1] + 1)
    if name != 'own':       # it was watched, by the previous test
        assert not watched(pendant.node)
