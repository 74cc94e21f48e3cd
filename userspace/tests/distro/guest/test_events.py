# SPDX-License-Identifier: GPL-2.0-only
"""Keys, selector and wheel, from the USB report to evdev, udev and evtest."""

import os
import re
import subprocess
import tempfile

import libevdev
import pytest
from harness import (BIND_TIME, EVENT_TIME, Events, Plugged, command, find, key, module_loaded,
                     read_file, selector, udev_properties, wait_for)
from xhc_sim.uhid import UhidPendant


@pytest.mark.smoke
def test_autoload_by_modalias():
    """Must be first: nobody has loaded the driver yet."""
    assert not module_loaded('hid_xhc'), 'the driver is loaded before a pendant is plugged'
    with Plugged() as pendant:
        assert module_loaded('hid_xhc'), 'the driver is not loaded'
        assert find.driver(pendant.directory) == 'hid-xhc'
        assert pendant.get('model') == 'HB04'
    assert module_loaded('hid_xhc'), 'the driver does not stay'


def test_input_device_identity():
    for model, product in (('HB03', 0xEB6E), ('HB04', 0xEB70)):
        with Plugged(model) as pendant:
            device = pendant.events.device
            assert device.name == 'XHC %s Pendant' % model
            assert device.phys == pendant.usb.phys
            assert device.id['bustype'] == 3
            assert device.id['vendor'] == 0x10CE
            assert device.id['product'] == product
            nodes = os.listdir(pendant.path('input'))
            assert len(nodes) == 1


def test_capabilities():
    with Plugged() as pendant:
        device = pendant.events.device
        keys = {code.name for code in device.evbits[libevdev.EV_KEY]}
        wanted = {'BTN_TRIGGER_HAPPY%d' % n for n in [*range(1, 24), *range(31, 37)]}
        assert keys == wanted
        assert {code.name for code in device.evbits[libevdev.EV_REL]} == {'REL_DIAL'}
        assert {code.name for code in device.evbits[libevdev.EV_ABS]} == {'ABS_MISC'}
        info = device.absinfo[libevdev.EV_ABS.ABS_MISC]
        assert (info.minimum, info.maximum, info.fuzz, info.flat) == (0, 6, 0, 0)


@pytest.mark.smoke
def test_every_key():
    with Plugged() as pendant:
        for code in range(1, 0x18):
            pendant.usb.press(code)
            pendant.usb.release(code)
            assert pendant.events.reports(2) == [key(code, 1), key(code, 0)], 'key %#x' % code


def test_every_selector_position():
    positions = {'HB03': (0x11, 0x12, 0x13, 0x18, 0x14, 0x15),
                 'HB04': (0x11, 0x12, 0x13, 0x18, 0x15, 0x14)}
    for model, codes in positions.items():
        with Plugged(model) as pendant:
            old = 0
            for new, code in enumerate(codes, 1):
                pendant.usb.select(code)
                assert pendant.events.report() == selector(old, new), '%s %#x' % (model, code)
                old = new
            pendant.usb.select(0)
            assert pendant.events.report() == selector(old, 0), '%s off' % model


def test_wheel_is_signed():
    with Plugged() as pendant:
        for detents in (1, -1, 127, -128, 5):
            pendant.usb.turn(detents)
            assert pendant.events.report() == ['REL_DIAL %d' % detents]


def test_order_in_one_report():
    with Plugged() as pendant:
        pendant.usb.report(bytes([4, 0x01, 0x02, 0x11, 0, 0]))
        assert pendant.events.report() == selector(0, 1) + key(1, 1) + key(2, 1)
        pendant.usb.report(bytes([4, 0x02, 0x17, 0x12, 0xFE, 0]))
        assert pendant.events.report() == \
            selector(1, 2) + key(1, 0) + key(0x17, 1) + ['REL_DIAL -2']
        pendant.usb.report(bytes([4, 0, 0, 0, 3, 1]))
        released = pendant.events.report()
        assert released[:2] == selector(2, 0)
        assert sorted(released[2:-1]) == sorted(key(2, 0) + key(0x17, 0))
        assert released[-1] == 'REL_DIAL 3'


def test_no_event_without_change():
    with Plugged() as pendant:
        pendant.usb.press(3)
        assert pendant.events.report() == key(3, 1)
        pendant.usb.wake()          # the same once more
        pendant.events.quiet()


def test_sleep_releases_all():
    with Plugged() as pendant:
        assert pendant.get('awake') == '0'
        pendant.usb.report(bytes([4, 5, 6, 0x13, 0, 0]))
        pendant.events.report()
        assert pendant.get('awake') == '1'
        pendant.usb.sleep()
        released = pendant.events.report()
        assert released[:2] == selector(3, 0)
        assert sorted(released[2:]) == sorted(key(5, 0) + key(6, 0))
        assert pendant.get('awake') == '0'
        assert os.path.exists(pendant.node), 'the node is gone, though the pendant only sleeps'


def test_unknown_codes_are_counted():
    with Plugged() as pendant:
        pendant.usb.press(0x42)
        assert pendant.events.report() == ['MSC_SCAN %d' % 0x42]
        pendant.usb.release(0x42)
        pendant.usb.select(0x11)
        assert pendant.events.report() == selector(0, 1)
        pendant.usb.select(0x77)
        assert pendant.events.report() == selector(1, 0)
        assert pendant.get('stats/unknown_keys') == '2'


def test_bad_reports_are_dropped():
    """Of these the HID core drops two itself: one with an unknown id, one without any byte."""
    with Plugged() as pendant:
        for data in (b'\x04', b'\x04\1\0\0\0', b'\x09\1\0\0\0\1', b''):
            pendant.usb.report(data)
        pendant.usb.press(2)
        assert pendant.events.report() == key(2, 1)
        assert pendant.get('stats/bad_reports') == '2'
        assert pendant.get('stats/reports') == '3'


def test_state_for_late_readers():
    """Who opens the node later asks for the state of keys and selector, and gets it."""
    with Plugged() as pendant:
        axis = libevdev.EV_ABS.ABS_MISC
        assert pendant.events.device.absinfo[axis].value == 0
        pendant.events.close()
        pendant.usb.report(bytes([4, 7, 0, 0x18, 0, 0]))
        wait_for(lambda: pendant.get('stats/reports') != '0', 'report while nobody reads')
        pendant.open()
        device = pendant.events.device
        assert device.absinfo[axis].value == 4
        assert device.value[libevdev.EV_KEY.BTN_TRIGGER_HAPPY7] == 1
        assert device.value[libevdev.EV_KEY.BTN_TRIGGER_HAPPY34] == 1
        assert device.value[libevdev.EV_KEY.BTN_TRIGGER_HAPPY8] == 0


def test_feed_and_spindle_swapped():
    parameter = '/sys/module/hid_xhc/parameters/swap_feed_spindle'
    with Plugged() as pendant:
        with open(parameter, 'w', encoding='ascii') as file:
            file.write('Y')
        try:
            pendant.usb.select(0x14)
            assert pendant.events.report() == selector(0, 5)
            pendant.usb.select(0x15)
            assert pendant.events.report() == selector(5, 6)
        finally:
            with open(parameter, 'w', encoding='ascii') as file:
                file.write('N')


def test_hidraw_beside_the_driver():
    with Plugged() as pendant:
        wait_for(lambda: os.path.exists(pendant.hidraw), 'hidraw node')
        with open(pendant.hidraw, 'rb', buffering=0) as hidraw:
            for code in (1, 0x10):
                pendant.usb.press(code)
                assert pendant.events.report() == key(code, 1)
                assert hidraw.read(64)[:2] == bytes([4, code])
                pendant.usb.release(code)
                assert pendant.events.report() == key(code, 0)
                assert hidraw.read(64)[:2] == bytes([4, 0])


def test_two_pendants():
    """Two equal ones differ by phys only, and do not hear each other."""
    with Plugged() as first, Plugged() as second, Plugged('HB03') as third:
        assert first.events.device.phys != second.events.device.phys, 'the same phys twice'
        first.usb.press(1)
        second.usb.press(2)
        third.usb.press(3)
        assert first.events.report() == key(1, 1)
        assert second.events.report() == key(2, 1)
        assert third.events.report() == key(3, 1)
        second.unplug()
        first.usb.release(1)
        assert first.events.report() == key(1, 0)
        first.events.quiet()


def test_uhid_pendant():
    """Not on USB: nothing that the driver does with USB devices may be done to this one."""
    command('modprobe', 'uhid')
    with Plugged(usb=UhidPendant()) as pendant:
        pendant.usb.press(9)
        assert pendant.events.report() == key(9, 1)
        assert pendant.usb.set_reports[0].wvalue == 0x0306


# --- udev and its tools ---------------------------------------------------------------------

def test_udev_makes_it_a_joystick():
    """So the user at the seat may read it, and desktops do not take its keys for typing."""
    with Plugged() as pendant:
        properties, tags = udev_properties(pendant.node)
        assert properties.get('ID_INPUT') == '1'
        assert properties.get('ID_INPUT_JOYSTICK') == '1'
        for kind in ('KEYBOARD', 'KEY', 'MOUSE', 'TABLET', 'TOUCHPAD'):
            assert 'ID_INPUT_' + kind not in properties, 'ID_INPUT_%s is set' % kind
        assert 'uaccess' in tags, 'no tag uaccess, only %s' % sorted(tags)


def test_evtest_query():
    """evtest --query: status 0 when the key is up, 10 when it is down."""
    def status():
        return subprocess.run(['evtest', '--query', pendant.node, 'EV_KEY',
                               'BTN_TRIGGER_HAPPY4'], check=False).returncode

    with Plugged() as pendant:
        assert status() == 0
        pendant.usb.press(4)
        pendant.events.report()
        assert status() == 10


def test_evtest_prints_events():
    wanted = [r'Input device name: "XHC HB04 Pendant"',
              r'Event code 40 \(ABS_MISC\)',
              r'type 3 \(EV_ABS\), code 40 \(ABS_MISC\), value 2',
              r'type 1 \(EV_KEY\), code 735 \(BTN_TRIGGER_HAPPY32\), value 1',
              r'type 4 \(EV_MSC\), code 4 \(MSC_SCAN\), value 17',
              r'type 1 \(EV_KEY\), code 726 \(BTN_TRIGGER_HAPPY23\), value 1',
              r'type 2 \(EV_REL\), code 7 \(REL_DIAL\), value -3']
    with Plugged() as pendant, tempfile.NamedTemporaryFile('r', encoding='ascii') as output:
        with subprocess.Popen(['evtest', pendant.node], stdout=output, stdin=subprocess.DEVNULL,
                              stderr=subprocess.STDOUT) as evtest:
            try:
                wait_for(lambda: 'interrupt to exit' in read_file(output.name),
                         'evtest', BIND_TIME)
                pendant.usb.select(0x12)
                pendant.usb.report(bytes([4, 0x17, 0, 0x12, 0xFD, 0]))
                wait_for(lambda: 'REL_DIAL), value' in read_file(output.name), 'events',
                         EVENT_TIME)
            finally:
                evtest.terminate()
        printed = read_file(output.name)
        for line in wanted:
            assert re.search(line, printed), 'evtest does not print %s: %s' % (line, printed)


def test_stays_awake_on_usb():
    """The pendant's USB port is not suspended, even where autosuspend is switched on."""
    with Plugged() as pendant:
        device = os.path.realpath(pendant.path('../..'))
        with open(device + '/power/control', 'w', encoding='ascii') as file:
            file.write('auto')
        with open(device + '/power/autosuspend_delay_ms', 'w', encoding='ascii') as file:
            file.write('0')
        reader = Events(pendant.node)
        reader.quiet(1.0)
        assert read_file(device + '/power/runtime_status').strip() == 'active'
        reader.close()
