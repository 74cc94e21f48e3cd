# SPDX-License-Identifier: GPL-2.0-only
"""The display, from sysfs to the frames on USB, decoded by the virtual pendant's own LCD."""

import errno
import os
import threading
import time

import pytest
from harness import Plugged, command, error_of, wait_for


VALUES = {
    'work_x': '-220.334', 'work_y': '135.17', 'work_z': '0',
    'machine_x': '0.0001', 'machine_y': '-0.5', 'machine_z': '65535.9999',
    'feedrate_override': '100', 'spindle_override': '80', 'feedrate': '65535',
    'spindle_speed': '24000', 'step': '500', 'icon': '9', 'state': 'run+inch', 'day': '17',
}


def frames(pendant):
    return pendant.usb.frame_count


def shown(pendant, name):
    """A value on the LCD, written as the driver's attribute would have it."""
    value = str(pendant.usb.lcd.as_dict()[name])
    if '.' in value:
        value = value.rstrip('0').rstrip('.')
    return value


def wait_shown(pendant, name, value):
    wait_for(lambda: pendant.usb.lcd and shown(pendant, name) == value,
             '%s %s on the LCD' % (name, value))


def test_first_frame_at_probe():
    """It tells the pendant the day, without which sleep looks like "all keys up"."""
    with Plugged() as pendant:
        assert pendant.usb.lcd.faults == []
        assert shown(pendant, 'day') == str(time.gmtime().tm_mday)
        assert shown(pendant, 'work_x') == '0'
        time.sleep(0.5)
        assert frames(pendant) == 1


@pytest.mark.smoke
def test_every_attribute_reaches_the_lcd():
    with Plugged() as pendant:
        for name, value in VALUES.items():
            pendant.set('dro/' + name, value)
            assert pendant.get('dro/' + name) == value, name
            wait_shown(pendant, name, value)
        assert {name: shown(pendant, name) for name in VALUES} == VALUES
        assert pendant.usb.lcd.faults == []


def test_position_is_taken_as_one():
    numbers = '1.5 -2.25 3 -4.0001 5 -6'
    with Plugged() as pendant:
        pendant.set('dro/position', numbers)
        assert pendant.get('dro/position') == numbers
        pendant.flush()
        names = ('work_x', 'work_y', 'work_z', 'machine_x', 'machine_y', 'machine_z')
        assert ' '.join(shown(pendant, name) for name in names) == numbers
        assert error_of(pendant.set, 'dro/position', '9 9 9 9 9 x') == errno.EINVAL
        assert pendant.get('dro/position') == numbers


def test_hb03_shows_two_decimals():
    with Plugged('HB03') as pendant:
        pendant.set('dro/work_x', '-220.336')
        pendant.flush()
        assert shown(pendant, 'work_x') == '-220.34'
        assert pendant.get('dro/work_x') == '-220.34'
        assert pendant.usb.lcd.faults == []


def test_requests_on_usb():
    """A frame is six SET_REPORT requests for feature report 6, eight bytes each."""
    with Plugged() as pendant:
        pendant.usb.set_reports.clear()
        pendant.flush()
        requests = list(pendant.usb.set_reports)
        assert [request.wvalue for request in requests] == [0x0306] * 6
        assert [request.windex for request in requests] == [0] * 6
        assert [len(request.data) for request in requests] == [8] * 6
        assert requests[0].data[:3] == b'\x06\xfe\xfd'


def test_wrong_values_are_refused():
    bad = [('work_x', 'abc', errno.EINVAL), ('work_x', '1e3', errno.EINVAL),
           ('work_x', '', errno.EINVAL), ('work_x', '65536', errno.ERANGE),
           ('feedrate', '-1', errno.ERANGE), ('feedrate', '65536', errno.ERANGE),
           ('step', '7', errno.ERANGE), ('icon', '16', errno.ERANGE),
           ('day', '0', errno.ERANGE), ('day', '32', errno.ERANGE),
           ('state', 'jog', errno.EINVAL), ('refresh_ms', '9', errno.ERANGE),
           ('refresh_ms', '1001', errno.ERANGE)]
    with Plugged() as pendant:
        for name, value, error in bad:
            old = pendant.get('dro/' + name)
            found = error_of(pendant.set, 'dro/' + name, value)
            assert found == error, 'errno of %s for "%s"' % (name, value)
            assert pendant.get('dro/' + name) == old, name
        assert frames(pendant) == 1


def test_a_burst_costs_few_frames():
    with Plugged() as pendant:
        pendant.set('dro/refresh_ms', 500)
        pendant.flush()
        before, start = frames(pendant), time.monotonic()
        for number in range(100):
            pendant.set('dro/work_x', number)
        seconds = time.monotonic() - start
        wait_shown(pendant, 'work_x', '99')
        assert frames(pendant) - before <= 2 + seconds / 0.5, \
            '%d frames for 100 writes in %.1f s' % (frames(pendant) - before, seconds)


def test_refresh_is_kept():
    with Plugged() as pendant:
        pendant.set('dro/refresh_ms', 200)
        before, start = frames(pendant), time.monotonic()
        number = 0
        while frames(pendant) < before + 5 or time.monotonic() - start < 1:
            number = number % 1000 + 1
            pendant.set('dro/feedrate', number)
            assert time.monotonic() - start < 60, ('only %d frames in a minute'
                 % (frames(pendant) - before))
            time.sleep(0.01)
        times = [when for when, _ in list(pendant.usb.frames)[before + 1:]]
        gaps = [later - earlier for earlier, later in zip(times, times[1:])]
        assert min(gaps) > 0.15, 'frames %.3f s apart' % min(gaps)


def test_unchanged_values_send_nothing():
    with Plugged() as pendant:
        pendant.set('dro/work_x', '1.25')
        pendant.flush()
        time.sleep(0.3)
        before = frames(pendant)
        for text in ('1.25', '1.2500', '+1.25'):
            pendant.set('dro/work_x', text)
        time.sleep(0.5)
        assert frames(pendant) == before
        pendant.flush()
        assert frames(pendant) == before + 1


def test_stall_is_told_by_flush():
    with Plugged() as pendant:
        pendant.flush()         # the first frame is counted by now
        good = pendant.get('stats/frames_sent')
        pendant.usb.fault = 'stall'
        pendant.set('dro/work_y', '7')
        assert error_of(pendant.flush) == errno.EPIPE
        assert int(pendant.get('stats/frame_errors')) >= 1, 'frame_errors is 0'
        assert pendant.get('stats/frames_sent') == good
        pendant.set('dro/work_y', '8')
        pendant.usb.fault = 'none'
        wait_shown(pendant, 'work_y', '8')      # the driver tries again by itself


def test_stall_in_mid_frame():
    with Plugged() as pendant:
        pendant.usb.set_fault('stall', skip=3, count=1)
        assert error_of(pendant.flush) == errno.EPIPE
        pendant.flush()
        assert pendant.usb.lcd.faults == []


def test_slow_pendant_blocks_no_writer():
    with Plugged() as pendant:
        pendant.usb.fault = 'slow:200'
        pendant.set('dro/work_x', '1')
        wait_for(lambda: pendant.usb.set_reports[-1].data[3:] != b'', 'request')
        slowest = 0
        for number in range(20):
            start = time.monotonic()
            pendant.set('dro/work_x', number)
            slowest = max(slowest, time.monotonic() - start)
        assert slowest < 0.2, 'a write took %.2f s' % slowest
        pendant.usb.fault = 'none'
        wait_shown(pendant, 'work_x', '19')


def test_unplug_in_mid_frame():
    """The cable goes while a frame is under way, and somebody waits for it.

    The virtual host controller leaves it to the transfer's time-out, 5 s, to end it.
    """
    with Plugged() as pendant:
        pendant.usb.set_fault('unplug', skip=2)
        assert error_of(pendant.flush), 'flush has succeeded'
        pendant.wait_gone()


def test_unplug_while_a_request_is_unanswered():
    with Plugged() as pendant:
        pendant.usb.set_fault('timeout')
        found = []
        waiter = threading.Thread(target=lambda: found.append(error_of(pendant.flush)))
        waiter.start()
        wait_for(lambda: pendant.usb.set_reports[-1].status == -errno.ETIMEDOUT, 'request')
        pendant.unplug()
        waiter.join(10)
        assert found and found[0], 'flush still waits, or has succeeded'


def test_attribute_kept_open_across_unplug():
    with Plugged() as pendant:
        fd = os.open(pendant.path('dro/work_x'), os.O_RDWR)
        try:
            pendant.unplug()
            assert error_of(os.write, fd, b'1\n') == errno.ENODEV
            assert error_of(os.pread, fd, 16, 0) == errno.ENODEV
        finally:
            os.close(fd)


def test_values_and_day_of_the_month():
    """"auto" follows the clock, a number does not."""
    with Plugged() as pendant:
        assert pendant.get('dro/day') == 'auto'
        pendant.set('dro/day', 31)
        pendant.flush()
        assert shown(pendant, 'day') == '31'
        pendant.usb.press(1)
        pendant.events.report()
        assert pendant.get('stats/xor_mismatches') == '0'
        command('date', '--utc', '--set=2031-03-04 12:00:00')
        pendant.set('dro/day', 'auto')
        wait_shown(pendant, 'day', '4')
