# SPDX-License-Identifier: GPL-2.0-only
"""Keys under other names: by EVIOCSKEYCODE, and by udev's hwdb."""

import errno
import fcntl
import os
import struct

import libevdev
from harness import Plugged, command, equal, error_of, settle, true, wait_for

TESTS = []

# struct input_keymap_entry: flags, length of the scan code, index, key code, scan code
KEYMAP_ENTRY = struct.Struct('=BBHI32s')
EVIOCGKEYCODE_V2 = 0x80284504
EVIOCSKEYCODE_V2 = 0x40284504

HWDB = '/etc/udev/hwdb.d/99-test.hwdb'


def test(function):
    TESTS.append(function)
    return function


def entry(scan, code=0):
    return bytearray(KEYMAP_ENTRY.pack(0, 4, 0, code, struct.pack('=I', scan)))


def get_code(pendant, scan):
    data = entry(scan)
    fcntl.ioctl(pendant.events.file, EVIOCGKEYCODE_V2, data)
    return KEYMAP_ENTRY.unpack(data)[3]


def set_code(pendant, scan, code):
    """Then reads the device's capabilities anew, which have changed with it."""
    fd = os.open(pendant.node, os.O_RDWR)
    try:
        fcntl.ioctl(fd, EVIOCSKEYCODE_V2, entry(scan, code))
    finally:
        os.close(fd)
    pendant.open()


@test
def keymap_can_be_read():
    first = libevdev.EV_KEY.BTN_TRIGGER_HAPPY1.value
    with Plugged() as pendant:
        equal([get_code(pendant, scan) for scan in range(1, 0x18)],
              [first + n for n in range(0x17)], 'codes of the keys')
        equal([get_code(pendant, scan) for scan in range(0x21, 0x27)],
              [first + 30 + n for n in range(6)], 'codes of the selector')
        equal(error_of(get_code, pendant, 0x40), errno.EINVAL, 'errno for a code outside')


@test
def eviocskeycode():
    with Plugged() as pendant:
        set_code(pendant, 1, libevdev.EV_KEY.KEY_F13.value)
        set_code(pendant, 0x21, libevdev.EV_KEY.KEY_F14.value)
        pendant.usb.press(1)
        equal(pendant.events.report(), ['MSC_SCAN 1', 'KEY_F13 1'], 'remapped key')
        pendant.usb.release(1)
        equal(pendant.events.report(), ['MSC_SCAN 1', 'KEY_F13 0'], 'remapped key')
        pendant.usb.select(0x11)
        equal(pendant.events.report(), ['ABS_MISC 1', 'KEY_F14 1'], 'remapped position')


@test
def remapped_while_held():
    """The key's old name goes up, whatever happens: it must not stay down for ever."""
    with Plugged() as pendant:
        pendant.usb.press(2)
        pendant.events.report()
        reader = pendant.events
        pendant.events = None
        set_code(pendant, 2, libevdev.EV_KEY.KEY_F15.value)
        pendant.usb.release(2)
        events = reader.until(lambda seen: 'BTN_TRIGGER_HAPPY2 0' in seen, 'old key up')
        reader.close()
        true('KEY_F15 1' not in events, 'the new name went down: %r' % events)


@test
def hwdb():
    """By hand (udevadm trigger), and by itself when the pendant is plugged again."""
    with open(HWDB, 'w', encoding='ascii') as file:
        file.write('evdev:input:b0003v10CEpEB70*\n KEYBOARD_KEY_0a=f16\n KEYBOARD_KEY_17=esc\n')
    with Plugged() as pendant:
        settle()
        command('systemd-hwdb', 'update')
        command('udevadm', 'trigger', '--settle', pendant.node)
        check_hwdb(pendant)
    with Plugged() as pendant:
        check_hwdb(pendant)


def check_hwdb(pendant):
    wait_for(lambda: get_code(pendant, 0x0A) == libevdev.EV_KEY.KEY_F16.value,
             'remapping by udev', 60)
    settle()
    pendant.open()
    for code, name in ((0x0A, 'KEY_F16'), (0x17, 'KEY_ESC'), (0x16, 'BTN_TRIGGER_HAPPY22')):
        pendant.usb.press(code)
        pendant.usb.release(code)
        equal(pendant.events.reports(2), [['MSC_SCAN %d' % code, name + ' 1'],
                                          ['MSC_SCAN %d' % code, name + ' 0']], name)
