# SPDX-License-Identifier: GPL-2.0-only
"""Properties of a pendant in udev with each layout: neither a keyboard nor a power switch, and
access only for the group dialout.
"""

import contextlib
import fcntl
import os
import shutil
import struct
import subprocess

import evdev
import pytest

import rig
import udevd
from evdev import ecodes
from kernel import is_loaded, load_module, wait, write_file
from xhcctl_tool import LAYOUTS, environment, run

LIMIT = 60
DIALOUT = 20
EVIOCGKEYCODE = 0x80084504      # <linux/input.h>, missing in python3-evdev
ETC = '/etc/udev'
OWN_ENTRY = ETC + '/hwdb.d/62-own.hwdb'
# keys that systemd-logind, a desktop and the kernel act on
OWN_KEYS = {0x01: 'power', 0x02: 'power2', 0x03: 'sleep', 0x04: 'suspend', 0x05: 'a',
            0x06: 'leftctrl', 0x07: 'capslock', 0x08: 'numlock', 0x09: 'mute', 0x0A: 'playpause',
            0x17: 'restart'}
CHOICES = {'default': 'HB04', 'hb03': 'HB03', 'hb04-16': 'HB04', 'hb04-18': 'HB04', 'own': 'HB04',
           'whb04b': 'WHB04B'}
PRODUCTS = {'HB03': 'eb6e', 'HB04': 'eb70', 'WHB04B': 'eb93'}


@pytest.fixture(scope='module', autouse=True)
def machine():
    """The root of the guest is read-only: /etc/udev is in memory, as after an installation."""
    rig.load()
    if not is_loaded('joydev'):
        load_module(os.environ['JOYDEV_MODULE'])
    subprocess.run(['mount', '-t', 'tmpfs', 'tmpfs', ETC], check=True)
    os.mkdir(ETC + '/hwdb.d')
    with udevd.running():
        yield
    subprocess.run(['umount', '-l', ETC], check=True)


def udev(*words):
    subprocess.run(words, env=udevd.ENVIRONMENT, check=True)


def trigger(node, action='change'):
    udev('udevadm', 'trigger', '--action=' + action, node)
    udev('udevadm', 'settle')


def layout(*words):
    """xhcctl layout, with the layouts of this tree and the udev of the guest"""
    result = run('layout', *words, env=environment(SYSTEMD_IGNORE_CHROOT='1'))
    assert result.status == 0, result.err
    return result


@contextlib.contextmanager
def chosen(name):
    """A layout of this tree, or a user's entry without its restrictions"""
    if name == 'own':
        # the class that many keys would result in
        write_entry(' ID_INPUT_KEYBOARD=1\n' + ''.join(' KEYBOARD_KEY_%02x=%s\n' % key
                                                       for key in OWN_KEYS.items()))
        udev('systemd-hwdb', 'update')
        udev('udevadm', 'control', '--reload')
    elif name != 'default':
        layout(name, '--apply')
    try:
        yield
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(OWN_ENTRY)
        layout('default', '--apply')


@contextlib.contextmanager
def plugged(model='HB04', **options):
    pendant = rig.Rig(model, **options).plug()
    try:
        assert wait(lambda: os.stat(pendant.event_node).st_gid == DIALOUT, LIMIT), 'no rule of ours'
        udev('udevadm', 'settle')
        yield pendant
    finally:
        pendant.unplug()


@pytest.fixture(scope='module')
def keyboard():
    """A keyboard besides the pendant, which udev and libinput must classify as such"""
    keys = [*range(ecodes.KEY_ESC, ecodes.KEY_F12), ecodes.KEY_RESTART]
    with contextlib.closing(evdev.UInput({ecodes.EV_KEY: keys}, name='keyboard')) as device:
        assert wait(lambda: 'ID_INPUT_KEYBOARD' in udevd.properties(device.device.path), LIMIT)
        yield device.device.path


def tags(node):
    return set(udevd.properties(node).get('CURRENT_TAGS', '').strip(':').split(':'))


def libinput_devices():
    lines = subprocess.run(['libinput', 'list-devices'], stdout=subprocess.PIPE, text=True,
                           check=True, env=udevd.ENVIRONMENT).stdout.splitlines()
    return [line.split(':', 1)[1].strip() for line in lines if line.startswith('Device:')]


def check(node):
    properties = udevd.properties(node)
    classes = {name for name in properties if name.startswith('ID_INPUT')}
    assert classes == {'ID_INPUT', 'ID_INPUT_JOYSTICK'}
    assert properties['LIBINPUT_IGNORE_DEVICE'] == '1'
    assert tags(node) & {'power-switch', 'uaccess'} == {'uaccess'}


@pytest.mark.parametrize('choice', CHOICES)
def test_neither_keyboard_nor_power_switch(choice, keyboard):
    assert 'power-switch' in tags(keyboard)
    with chosen(choice):
        for _ in range(2):
            with plugged(CHOICES[choice]) as pendant:
                if choice != 'default':
                    codes = evdev.InputDevice(pendant.event_node).capabilities()[ecodes.EV_KEY]
                    assert min(codes) < ecodes.BTN_MISC, 'the layout is not there'
                check(pendant.event_node)
                assert libinput_devices() == ['keyboard']
                for action in 'change', 'add':
                    trigger(pendant.event_node, action)
                    check(pendant.event_node)


BIN = ETC + '/hwdb.bin'


def contents(folder):
    """{path: contents} of all files below a folder"""
    found = {}
    for place, _, names in os.walk(folder):
        for name in names:
            with open(os.path.join(place, name), 'rb') as file:
                found[os.path.join(place, name)] = file.read()
    return found


def codes(pendant):
    """{scan code: key code} of the keys and the positions of the selector"""
    scans = [*range(1, 0x18), *range(0x21, 0x27)]
    with open(pendant.event_node, 'rb') as node:
        found = [struct.pack('II', scan, 0) for scan in scans]
        found = [fcntl.ioctl(node, EVIOCGKEYCODE, pair) for pair in found]
    return dict(struct.unpack('II', pair) for pair in found)


FIRST_CODES = {**{scan: ecodes.BTN_TRIGGER_HAPPY + scan - 1 for scan in range(1, 0x18)},
               **{0x20 + number: ecodes.BTN_TRIGGER_HAPPY31 + number - 1 for number in range(1, 7)}}


def codes_of(name):
    with open(os.path.join(LAYOUTS, name + '.layout'), encoding='ascii') as file:
        rows = [line.rstrip('\n').split('\t') for line in file]
    return {**FIRST_CODES, **{int(row[0], 16): ecodes.ecodes[row[2]] for row in rows
                              if len(row) > 2 and row[2] != '-'}}


def layout_property(pendant):
    return udevd.properties(pendant.event_node).get('XHC_LAYOUT')


def write_entry(text):
    with open(OWN_ENTRY, 'w', encoding='ascii') as file:
        file.write('evdev:input:b0003v10CEpEB70*\n' + text)


class TestApply:
    """The pendant stays plugged in, and all changes are complete when xhcctl exits."""

    def check(self, pendant, name, keys):
        assert (layout_property(pendant), codes(pendant)) == (name, keys)
        check(pendant.event_node)

    def test_chosen_and_taken_back(self):
        before = contents(ETC)
        assert BIN not in before
        with plugged() as pendant:
            for name in 'hb04-18', 'hb04-16':
                layout(name, '--apply')
                self.check(pendant, name, codes_of(name))
            for _ in range(2):      # also if there is none
                assert layout('default', '--apply').err == ''
                self.check(pendant, None, FIRST_CODES)
                assert contents(ETC) == before

    def test_captions_give_no_codes(self):
        with plugged() as pendant:
            layout('hb04-18', '--apply')
            layout('hb04-16', '--captions', '--apply')
            self.check(pendant, 'hb04-16', FIRST_CODES)
            layout('default', '--apply')

    def test_selector_by_hand(self):
        with plugged() as pendant:
            layout('hb04-18', '--apply')
            with open(ETC + '/hwdb.d/61-xhc-pendant.hwdb', 'a', encoding='ascii') as file:
                file.write(' KEYBOARD_KEY_21=f16\n')
            udev('systemd-hwdb', 'update')
            udev('udevadm', 'control', '--reload')
            trigger(pendant.event_node)
            self.check(pendant, 'hb04-18', {**codes_of('hb04-18'), 0x21: ecodes.KEY_F16})
            layout('default', '--apply')
            self.check(pendant, None, FIRST_CODES)

    def test_an_entry_of_the_users_own_stays(self):
        write_entry(' KEYBOARD_KEY_01=f16\n')
        try:
            with plugged() as pendant:
                layout('hb04-18', '--apply')
                self.check(pendant, 'hb04-18', {**codes_of('hb04-18'), 1: ecodes.KEY_F16})
                layout('default', '--apply')
                self.check(pendant, None, {**FIRST_CODES, 1: ecodes.KEY_F16})
                assert contents(ETC).keys() == {OWN_ENTRY, BIN}
        finally:
            os.unlink(OWN_ENTRY)
            layout('default', '--apply')
        assert contents(ETC) == {}

    def test_an_update_of_udev_with_a_layout(self):
        """Debian's udev then compiles the entry into its own file, too."""
        with plugged() as pendant:
            layout('hb04-18', '--apply')
            shutil.copy(BIN, '/run/updated.bin')
            subprocess.run(['mount', '--bind', '/run/updated.bin', '/usr/lib/udev/hwdb.bin'],
                           check=True)
            try:
                layout('default', '--apply')
                self.check(pendant, None, FIRST_CODES)
                assert contents(ETC).keys() == {BIN}
            finally:
                subprocess.run(['umount', '-l', '/usr/lib/udev/hwdb.bin'], check=True)
                layout('default', '--apply')
        assert contents(ETC) == {}

    def test_all_pendants_are_told(self):
        with plugged() as one, plugged() as two, plugged('HB03') as other:
            layout('hb04-16', '--apply')
            for pendant in one, two:
                self.check(pendant, 'hb04-16', codes_of('hb04-16'))
            self.check(other, None, FIRST_CODES)
            layout('default', '--apply')
            for pendant in one, two, other:
                self.check(pendant, None, FIRST_CODES)


def test_the_layouts_are_all_that_are_shipped():
    names = {name.removesuffix('.layout') for name in os.listdir(LAYOUTS)}
    assert names == CHOICES.keys() - {'default', 'own'}


def check_access(pendant):
    """The node of joydev reports the keys, too."""
    folder = os.path.dirname(os.path.realpath('/sys/class/input/' +
                                              os.path.basename(pendant.event_node)))
    names = [name for name in os.listdir(folder) if os.path.exists('/dev/input/' + name)]
    assert sorted(name.rstrip('0123456789') for name in names) == ['event', 'js']
    for name in names:
        node = '/dev/input/' + name
        for action in 'change', 'add':
            trigger(node, action)
            state = os.stat(node)
            assert (state.st_gid, state.st_mode & 0o777) == (DIALOUT, 0o660), node
            assert 'uaccess' in tags(node)


def test_every_node_is_for_dialout_only():
    with plugged() as pendant:
        check_access(pendant)


@pytest.mark.parametrize('model', PRODUCTS)
def test_a_clone_is_as_its_model(model, keyboard):
    """The rules do not know the id of a clone, which the driver binds by new_id."""
    try:
        write_file(rig.DRIVER_DIR + '/new_id', '3 10ce eb91 %s' % PRODUCTS[model])
        with plugged(model, product=0xEB91) as pendant:
            check(pendant.event_node)
            assert libinput_devices() == ['keyboard']
            assert os.path.realpath('/dev/input/xhc-' + model.lower()) == pendant.event_node
            check_access(pendant)
    finally:        # the driver forgets the id
        rig.unload()
        rig.load()
