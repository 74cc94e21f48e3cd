# SPDX-License-Identifier: GPL-2.0-only
"""Coming and going: unplug, sleep, module removal, tracing, and what remains of it all."""

import glob
import os
import select

import pytest
from harness import (BIND_TIME, TRACING, Plugged, Watcher, find, hid_xhc, module_loaded, read_file,
                     wait_for, write_file)
from xhc_sim.usb import UsbPendant


def hold_two_keys(pendant):
    """-> a Watcher of what happens to them"""
    pendant.usb.report(bytes([4, 1, 2, 0x12, 0, 0]))
    pendant.events.report()
    return Watcher(pendant.node)


def check_let_go(events):
    """Key 1, key 2 and position 2 were held: all of them go, in one report."""
    ups = [event for event in events if not event.startswith('MSC_SCAN')]
    assert sorted(ups) == ['ABS_MISC 0', 'BTN_TRIGGER_HAPPY1 0', 'BTN_TRIGGER_HAPPY2 0',
                        'BTN_TRIGGER_HAPPY32 0', 'SYN_REPORT 0']
    assert events[-1] == 'SYN_REPORT 0'


def test_keys_go_up_when_the_cable_is_cut():
    with Plugged() as pendant:
        watcher = hold_two_keys(pendant)
        pendant.unplug()
        check_let_go(watcher.rest())


def test_keys_go_up_when_the_port_is_switched_off():
    with Plugged() as pendant:
        watcher = hold_two_keys(pendant)
        pendant.usb.detach()
        pendant.wait_gone()
        check_let_go(watcher.rest())


def test_plugged_again():
    usb = UsbPendant()
    for number in range(3):
        with Plugged(usb=usb) as pendant:
            pendant.set('dro/feedrate', number + 1)
            pendant.flush()
            assert usb.lcd.as_dict()['feedrate'] == number + 1
            usb.press(3)
            assert pendant.events.report() == ['MSC_SCAN 3', 'BTN_TRIGGER_HAPPY3 1']
            usb.release(3)
            pendant.events.report()


def test_awake_can_be_polled():
    with Plugged() as pendant:
        fd = os.open(pendant.path('awake'), os.O_RDONLY)
        try:
            poll = select.poll()
            poll.register(fd, select.POLLPRI | select.POLLERR)
            for act, value in ((pendant.usb.wake, b'1\n'), (pendant.usb.sleep, b'0\n')):
                os.pread(fd, 16, 0)
                act()
                wait_for(lambda: poll.poll(100), 'wake-up of the poller')
                assert os.pread(fd, 16, 0) == value
        finally:
            os.close(fd)


def test_strange_descriptor_is_refused():
    """Another product with these ids: the driver does not touch it."""
    other = bytes.fromhex('06 00 FF 09 01 A1 01 85 04 09 01 15 00 26 FF 00 95 09 75 08 81 02 C0')
    usb = UsbPendant(report_descriptor=other)
    hid_xhc.will_come()
    usb.plug()
    try:
        wait_for(lambda: find.hid_directory(usb.phys), 'HID device', BIND_TIME)
        assert not usb.polled.wait(1), 'somebody has opened it'
        assert find.driver(find.hid_directory(usb.phys)) is None
    finally:
        usb.unplug()
    wait_for(lambda: find.hid_directory(usb.phys) is None, 'end of the HID device')


@pytest.mark.smoke
def test_keys_go_up_when_the_module_goes():
    with Plugged() as pendant:
        watcher = hold_two_keys(pendant)
        hid_xhc.unload()
        check_let_go(watcher.rest())
        assert not module_loaded('hid_xhc'), 'the module is still there'
        hid_xhc.load()
        pendant.wait_bound()
        pendant.usb.press(3)
        assert pendant.events.report() == ['MSC_SCAN 3', 'BTN_TRIGGER_HAPPY3 1']


def test_module_in_and_out():
    with Plugged() as first, Plugged('HB03') as second:
        for number in range(4):
            hid_xhc.unload()
            hid_xhc.load()
            first.wait_bound()
            second.wait_bound()
            first.set('dro/feedrate', number)
            first.flush()
        assert first.usb.lcd.as_dict()['feedrate'] == 3
        first.usb.press(1)
        assert first.events.report() == ['MSC_SCAN 1', 'BTN_TRIGGER_HAPPY1 1']


def test_tracepoints():
    hid_xhc.load()
    for event in ('report', 'frame'):
        write_file('%s/events/xhc/%s/enable' % (TRACING, event), '1')
    try:
        write_file(TRACING + '/trace', '\n')
        with Plugged() as pendant:
            pendant.usb.press(5)
            pendant.events.report()
            pendant.set('dro/day', 9)
            pendant.flush()
            name = os.path.basename(pendant.directory)
            trace = read_file(TRACING + '/trace')
        for line in ('report: %s error=0 data=04 05 00 00 00' % name,
                     'frame: %s error=0 data=fe fd 09' % name):
            assert line in trace, 'no trace of %s in: %s' % (line, trace[-600:])
    finally:
        for event in ('report', 'frame'):
            write_file('%s/events/xhc/%s/enable' % (TRACING, event), '0')
        write_file(TRACING + '/trace', '\n')


# --- memory ---------------------------------------------------------------------------------

def test_no_memory_is_left():
    """Last but one: after all that was done above."""
    hid_xhc.load()
    with Plugged() as pendant:
        pendant.flush()
        assert hid_xhc.allocations(), 'even of a plugged pendant no allocation is seen'
    wait_for(lambda: not hid_xhc.allocations(), 'end of what a pendant had', BIND_TIME)
    hid_xhc.unload()


def test_nothing_is_left_in_the_system():
    """Must be last."""
    assert not module_loaded('hid_xhc'), 'the module is still loaded'
    assert not os.path.exists(TRACING + '/events/xhc'), 'the tracepoints are still there'
    assert glob.glob('/sys/bus/hid/devices/*:10CE:*') == []
    assert not os.path.exists('/sys/bus/hid/drivers/hid-xhc')
