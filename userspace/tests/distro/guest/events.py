# SPDX-License-Identifier: GPL-2.0-only
"""Keys, selector and wheel, from the USB report to evdev, udev and evtest."""

import os
import re
import subprocess
import tempfile

import libevdev
from harness import (BIND_TIME, EVENT_TIME, Events, Plugged, command, equal, find, module_loaded,
                     read_file, settle, true, wait_for)
from xhc_sim.uhid import UhidPendant

TESTS = []


def test(function):
    TESTS.append(function)
    return function


def key(code, value):
    """What a key with a scan code gives."""
    return ['MSC_SCAN %d' % code, 'BTN_TRIGGER_HAPPY%d %d' % (code, value)]


def selector(old, new):
    """What turning the selector gives; positions 0..6 as in ABS_MISC."""
    events = ['ABS_MISC %d' % new]
    if old:
        events.append('BTN_TRIGGER_HAPPY%d 0' % (30 + old))
    if new:
        events.append('BTN_TRIGGER_HAPPY%d 1' % (30 + new))
    return events


@test
def autoload_by_modalias():
    """Must be first: nobody has loaded the driver yet."""
    true(not module_loaded('hid_xhc'), 'the driver is loaded before a pendant is plugged')
    with Plugged() as pendant:
        true(module_loaded('hid_xhc'), 'the driver is not loaded')
        equal(find.driver(pendant.directory), 'hid-xhc', 'driver')
        equal(pendant.get('model'), 'HB04', 'model')
    true(module_loaded('hid_xhc'), 'the driver does not stay')


@test
def input_device_identity():
    for model, product in (('HB03', 0xEB6E), ('HB04', 0xEB70)):
        with Plugged(model) as pendant:
            device = pendant.events.device
            equal(device.name, 'XHC %s Pendant' % model, 'name')
            equal(device.phys, pendant.usb.phys, 'phys')
            equal(device.id['bustype'], 3, 'bus')
            equal(device.id['vendor'], 0x10CE, 'vendor')
            equal(device.id['product'], product, 'product')
            nodes = os.listdir(pendant.path('input'))
            equal(len(nodes), 1, 'number of input devices')


@test
def capabilities():
    with Plugged() as pendant:
        device = pendant.events.device
        keys = {code.name for code in device.evbits[libevdev.EV_KEY]}
        wanted = {'BTN_TRIGGER_HAPPY%d' % n for n in [*range(1, 24), *range(31, 37)]}
        equal(keys, wanted, 'keys')
        equal({code.name for code in device.evbits[libevdev.EV_REL]}, {'REL_DIAL'}, 'wheels')
        equal({code.name for code in device.evbits[libevdev.EV_ABS]}, {'ABS_MISC'}, 'axes')
        info = device.absinfo[libevdev.EV_ABS.ABS_MISC]
        equal((info.minimum, info.maximum, info.fuzz, info.flat), (0, 6, 0, 0), 'ABS_MISC')


@test
def every_key():
    with Plugged() as pendant:
        for code in range(1, 0x18):
            pendant.usb.press(code)
            pendant.usb.release(code)
            equal(pendant.events.reports(2), [key(code, 1), key(code, 0)], 'key %#x' % code)


@test
def every_selector_position():
    positions = {'HB03': (0x11, 0x12, 0x13, 0x18, 0x14, 0x15),
                 'HB04': (0x11, 0x12, 0x13, 0x18, 0x15, 0x14)}
    for model, codes in positions.items():
        with Plugged(model) as pendant:
            old = 0
            for new, code in enumerate(codes, 1):
                pendant.usb.select(code)
                equal(pendant.events.report(), selector(old, new), '%s %#x' % (model, code))
                old = new
            pendant.usb.select(0)
            equal(pendant.events.report(), selector(old, 0), '%s off' % model)


@test
def wheel_is_signed():
    with Plugged() as pendant:
        for detents in (1, -1, 127, -128, 5):
            pendant.usb.turn(detents)
            equal(pendant.events.report(), ['REL_DIAL %d' % detents], 'wheel')


@test
def order_in_one_report():
    with Plugged() as pendant:
        pendant.usb.report(bytes([4, 0x01, 0x02, 0x11, 0, 0]))
        equal(pendant.events.report(), selector(0, 1) + key(1, 1) + key(2, 1), 'first report')
        pendant.usb.report(bytes([4, 0x02, 0x17, 0x12, 0xFE, 0]))
        equal(pendant.events.report(),
              selector(1, 2) + key(1, 0) + key(0x17, 1) + ['REL_DIAL -2'], 'second report')
        pendant.usb.report(bytes([4, 0, 0, 0, 3, 1]))
        released = pendant.events.report()
        equal(released[:2], selector(2, 0), 'selector in the third report')
        equal(sorted(released[2:-1]), sorted(key(2, 0) + key(0x17, 0)), 'keys in the third report')
        equal(released[-1], 'REL_DIAL 3', 'end of the third report')


@test
def no_event_without_change():
    with Plugged() as pendant:
        pendant.usb.press(3)
        equal(pendant.events.report(), key(3, 1), 'report')
        pendant.usb.wake()          # the same once more
        pendant.events.quiet()


@test
def sleep_releases_all():
    with Plugged() as pendant:
        equal(pendant.get('awake'), '0', 'awake before the first report')
        pendant.usb.report(bytes([4, 5, 6, 0x13, 0, 0]))
        pendant.events.report()
        equal(pendant.get('awake'), '1', 'awake')
        pendant.usb.sleep()
        released = pendant.events.report()
        equal(released[:2], selector(3, 0), 'selector')
        equal(sorted(released[2:]), sorted(key(5, 0) + key(6, 0)), 'keys')
        equal(pendant.get('awake'), '0', 'awake')
        true(os.path.exists(pendant.node), 'the node is gone, though the pendant only sleeps')


@test
def unknown_codes_are_counted():
    with Plugged() as pendant:
        pendant.usb.press(0x42)
        equal(pendant.events.report(), ['MSC_SCAN %d' % 0x42], 'unknown key')
        pendant.usb.release(0x42)
        pendant.usb.select(0x11)
        equal(pendant.events.report(), selector(0, 1), 'selector')
        pendant.usb.select(0x77)
        equal(pendant.events.report(), selector(1, 0), 'unknown position')
        equal(pendant.get('stats/unknown_keys'), '2', 'unknown_keys')


@test
def bad_reports_are_dropped():
    """Of these the HID core drops two itself: one with an unknown id, one without any byte."""
    with Plugged() as pendant:
        for data in (b'\x04', b'\x04\1\0\0\0', b'\x09\1\0\0\0\1', b''):
            pendant.usb.report(data)
        pendant.usb.press(2)
        equal(pendant.events.report(), key(2, 1), 'the good report behind')
        equal(pendant.get('stats/bad_reports'), '2', 'bad_reports')
        equal(pendant.get('stats/reports'), '3', 'reports')


@test
def state_for_late_readers():
    """Who opens the node later asks for the state of keys and selector, and gets it."""
    with Plugged() as pendant:
        axis = libevdev.EV_ABS.ABS_MISC
        equal(pendant.events.device.absinfo[axis].value, 0, 'ABS_MISC before the first report')
        pendant.events.close()
        pendant.usb.report(bytes([4, 7, 0, 0x18, 0, 0]))
        wait_for(lambda: pendant.get('stats/reports') != '0', 'report while nobody reads')
        pendant.open()
        device = pendant.events.device
        equal(device.absinfo[axis].value, 4, 'ABS_MISC')
        equal(device.value[libevdev.EV_KEY.BTN_TRIGGER_HAPPY7], 1, 'key that is held')
        equal(device.value[libevdev.EV_KEY.BTN_TRIGGER_HAPPY34], 1, 'button of the selector')
        equal(device.value[libevdev.EV_KEY.BTN_TRIGGER_HAPPY8], 0, 'key that is not')


@test
def feed_and_spindle_swapped():
    parameter = '/sys/module/hid_xhc/parameters/swap_feed_spindle'
    with Plugged() as pendant:
        with open(parameter, 'w', encoding='ascii') as file:
            file.write('Y')
        try:
            pendant.usb.select(0x14)
            equal(pendant.events.report(), selector(0, 5), 'HB04 code 14h, swapped')
            pendant.usb.select(0x15)
            equal(pendant.events.report(), selector(5, 6), 'HB04 code 15h, swapped')
        finally:
            with open(parameter, 'w', encoding='ascii') as file:
                file.write('N')


@test
def hidraw_beside_the_driver():
    with Plugged() as pendant:
        wait_for(lambda: os.path.exists(pendant.hidraw), 'hidraw node')
        with open(pendant.hidraw, 'rb', buffering=0) as hidraw:
            for code in (1, 0x10):
                pendant.usb.press(code)
                equal(pendant.events.report(), key(code, 1), 'evdev')
                equal(hidraw.read(64)[:2], bytes([4, code]), 'hidraw')
                pendant.usb.release(code)
                equal(pendant.events.report(), key(code, 0), 'evdev')
                equal(hidraw.read(64)[:2], bytes([4, 0]), 'hidraw')


@test
def two_pendants():
    """Two equal ones differ by phys only, and do not hear each other."""
    with Plugged() as first, Plugged() as second, Plugged('HB03') as third:
        true(first.events.device.phys != second.events.device.phys, 'the same phys twice')
        first.usb.press(1)
        second.usb.press(2)
        third.usb.press(3)
        equal(first.events.report(), key(1, 1), 'first')
        equal(second.events.report(), key(2, 1), 'second')
        equal(third.events.report(), key(3, 1), 'third')
        second.unplug()
        first.usb.release(1)
        equal(first.events.report(), key(1, 0), 'first, after the second has gone')
        first.events.quiet()


@test
def uhid_pendant():
    """Not on USB: nothing that the driver does with USB devices may be done to this one."""
    command('modprobe', 'uhid')
    with Plugged(usb=UhidPendant()) as pendant:
        pendant.usb.press(9)
        equal(pendant.events.report(), key(9, 1), 'key')
        equal(pendant.usb.set_reports[0].wvalue, 0x0306, 'kind and id of the report')


# --- udev and its tools ---------------------------------------------------------------------

def udev_properties(node):
    """-> (dict of properties, set of tags), once udevd has seen the node"""
    settle()
    lines = command('udevadm', 'info', '--query=property', '--name=' + node).splitlines()
    properties = dict(line.split('=', 1) for line in lines)
    return properties, set(properties.get('TAGS', '').strip(':').split(':'))


@test
def udev_makes_it_a_joystick():
    """So the user at the seat may read it, and desktops do not take its keys for typing."""
    with Plugged() as pendant:
        properties, tags = udev_properties(pendant.node)
        equal(properties.get('ID_INPUT'), '1', 'ID_INPUT')
        equal(properties.get('ID_INPUT_JOYSTICK'), '1', 'ID_INPUT_JOYSTICK')
        for kind in ('KEYBOARD', 'KEY', 'MOUSE', 'TABLET', 'TOUCHPAD'):
            true('ID_INPUT_' + kind not in properties, 'ID_INPUT_%s is set' % kind)
        true('uaccess' in tags, 'no tag uaccess, only %s' % sorted(tags))


@test
def evtest_query():
    """evtest --query: status 0 when the key is up, 10 when it is down."""
    def status():
        return subprocess.run(['evtest', '--query', pendant.node, 'EV_KEY',
                               'BTN_TRIGGER_HAPPY4'], check=False).returncode

    with Plugged() as pendant:
        equal(status(), 0, 'status with the key up')
        pendant.usb.press(4)
        pendant.events.report()
        equal(status(), 10, 'status with the key down')


@test
def evtest_prints_events():
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
            true(re.search(line, printed), 'evtest does not print %s: %s' % (line, printed))


@test
def stays_awake_on_usb():
    """The pendant's USB port is not suspended, even where autosuspend is switched on."""
    with Plugged() as pendant:
        device = os.path.realpath(pendant.path('../..'))
        with open(device + '/power/control', 'w', encoding='ascii') as file:
            file.write('auto')
        with open(device + '/power/autosuspend_delay_ms', 'w', encoding='ascii') as file:
            file.write('0')
        reader = Events(pendant.node)
        reader.quiet(1.0)
        equal(read_file(device + '/power/runtime_status').strip(), 'active', 'runtime_status')
        reader.close()
