# SPDX-License-Identifier: GPL-2.0-only
"""Functions of udevd for a pendant: the driver, the properties, and other names for keys."""

import os
import re

import pytest
from harness import Plugged, command, find, module_loaded, read_file, settle, udev_properties

LAYOUTS = '/usr/share/xhc-xy3/layouts/'
HWDB = '/etc/udev/hwdb.d/61-xhc-pendant.hwdb'


@pytest.mark.smoke
def test_autoload_by_modalias():
    """Must be first: the driver is not loaded yet."""
    assert not module_loaded('hid_xhc'), 'the driver is loaded before a pendant is plugged'
    with Plugged() as pendant:
        assert module_loaded('hid_xhc'), 'the driver is not loaded'
        assert find.driver(pendant.directory) == 'hid-xhc'
        assert pendant.get('model') == 'HB04'
    assert module_loaded('hid_xhc'), 'the driver does not stay'


def test_udev_makes_it_a_joystick():
    """The user at the seat may read it, and desktops ignore its keys."""
    with Plugged() as pendant:
        properties, tags = udev_properties(pendant.node)
        assert properties.get('ID_INPUT') == '1'
        assert properties.get('ID_INPUT_JOYSTICK') == '1'
        for kind in ('KEYBOARD', 'KEY', 'MOUSE', 'TABLET', 'TOUCHPAD'):
            assert 'ID_INPUT_' + kind not in properties, 'ID_INPUT_%s is set' % kind
        assert 'uaccess' in tags, 'no tag uaccess, only %s' % sorted(tags)


# --- layouts: what is printed on the keys, as an entry of the hwdb -----------------------------

def read_layout(name):
    """-> {scan code: name of the key code, or None}, see userspace/hwdb/README"""
    rows = [line.split('\t') for line in read_file(LAYOUTS + name + '.layout').splitlines()]
    return {int(row[0], 16): None if row[2] == '-' else row[2] for row in rows if len(row) == 3}


def choose(name, keys):
    """Activates the entry for an HB04 in udev; None removes it."""
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
    assert not [line for line in properties if re.match('CURRENT_TAGS=.*:power-switch:', line)]
    assert not [line for line in properties if re.match('ID_INPUT_KEY', line)], 'it is a keyboard'
    assert [line for line in properties if line.startswith('XHC_LAYOUT')] == \
        (['XHC_LAYOUT=' + name] if name else [])
    assert 'ID_INPUT_JOYSTICK=1' in properties, 'it is no joystick any more'
    for code, word in keys.items():
        pendant.usb.press(code)
        pendant.usb.release(code)
        assert pendant.events.reports(2) == [['MSC_SCAN %d' % code, word + ' 1'],
                                          ['MSC_SCAN %d' % code, word + ' 0']], 'key %#x' % code


@pytest.mark.timeout(400)     # the hwdb is compiled three times
def test_layout_by_hwdb():
    """Chosen manually, and present when the pendant is plugged in again; changed; removed."""
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
