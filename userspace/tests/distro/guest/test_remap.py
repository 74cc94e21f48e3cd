# SPDX-License-Identifier: GPL-2.0-only
"""Keys under other names: by EVIOCSKEYCODE, and by udev's hwdb."""

import errno
import fcntl
import os
import re
import struct

import libevdev
import pytest
from harness import Plugged, command, error_of, read_file, settle


# struct input_keymap_entry: flags, length of the scan code, index, key code, scan code
KEYMAP_ENTRY = struct.Struct('=BBHI32s')
EVIOCGKEYCODE_V2 = 0x80284504
EVIOCSKEYCODE_V2 = 0x40284504

LAYOUTS = '/usr/share/xhc-xy3/layouts/'
HWDB = '/etc/udev/hwdb.d/61-xhc-pendant.hwdb'


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


def test_keymap_can_be_read():
    first = libevdev.EV_KEY.BTN_TRIGGER_HAPPY1.value
    with Plugged() as pendant:
        assert [get_code(pendant, scan) for scan in range(1, 0x18)] == \
            [first + n for n in range(0x17)]
        assert [get_code(pendant, scan) for scan in range(0x21, 0x27)] == \
            [first + 30 + n for n in range(6)]
        assert error_of(get_code, pendant, 0x40) == errno.EINVAL


def test_eviocskeycode():
    with Plugged() as pendant:
        set_code(pendant, 1, libevdev.EV_KEY.KEY_F13.value)
        set_code(pendant, 0x21, libevdev.EV_KEY.KEY_F14.value)
        pendant.usb.press(1)
        assert pendant.events.report() == ['MSC_SCAN 1', 'KEY_F13 1']
        pendant.usb.release(1)
        assert pendant.events.report() == ['MSC_SCAN 1', 'KEY_F13 0']
        pendant.usb.select(0x11)
        assert pendant.events.report() == ['ABS_MISC 1', 'KEY_F14 1']


def test_remapped_while_held():
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
        assert 'KEY_F15 1' not in events, 'the new name went down: %r' % events


# --- layouts: what is printed on the keys, as an entry of the hwdb -----------------------------

def read_layout(name):
    """-> {scan code: name of the key code, or None}, see userspace/hwdb/README"""
    rows = [line.split('\t') for line in read_file(LAYOUTS + name + '.layout').splitlines()]
    return {int(row[0], 16): None if row[2] == '-' else row[2] for row in rows if len(row) == 3}


def choose(name, keys):
    """The entry for an HB04; udev is told of it. None: there is none any more."""
    if keys is None:
        os.unlink(HWDB)
    else:
        with open(HWDB, 'w', encoding='ascii') as file:
            file.write('evdev:input:b0003v10CEpEB70*\n XHC_LAYOUT=%s\n' % name)
            for code, word in keys.items():
                file.write(' KEYBOARD_KEY_%02x=%s\n' % (code, re.sub('^key_', '', word.lower())))
    command('systemd-hwdb', 'update')


def trigger(pendant):
    settle()
    command('udevadm', 'trigger', '--settle', pendant.node)


def check_layout(pendant, name, keys):
    settle()
    pendant.open()                      # its capabilities may have changed
    properties = command('udevadm', 'info', '--query=property', pendant.node).splitlines()
    assert [line for line in properties if line.startswith('XHC_LAYOUT')] == \
        (['XHC_LAYOUT=' + name] if name else [])
    assert 'ID_INPUT_JOYSTICK=1' in properties, 'it is no joystick any more'
    for code, word in keys.items():
        pendant.usb.press(code)
        pendant.usb.release(code)
        assert pendant.events.reports(2) == [['MSC_SCAN %d' % code, word + ' 1'],
                                          ['MSC_SCAN %d' % code, word + ' 0']], 'key %#x' % code


@pytest.mark.timeout(400)     # three times all of the hwdb is compiled
def test_layout_by_hwdb():
    """Chosen by hand, and there when the pendant is plugged again; changed; taken away."""
    layout = read_layout('hb04-18')
    first = {code: 'BTN_TRIGGER_HAPPY%d' % code for code in layout}
    named = {code: word or first[code] for code, word in layout.items()}
    own = {**first, 0x0A: 'KEY_F16'}
    assert sum(named[code] != first[code] for code in layout) > 5, 'few keys have another name'
    with Plugged() as pendant:
        check_layout(pendant, None, first)
        choose('hb04-18', named)
        trigger(pendant)
        check_layout(pendant, 'hb04-18', named)
    with Plugged() as pendant:
        check_layout(pendant, 'hb04-18', named)
        choose('mine', own)
        trigger(pendant)
        check_layout(pendant, 'mine', own)
        choose(None, None)
    with Plugged() as pendant:
        check_layout(pendant, None, first)

