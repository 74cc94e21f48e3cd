# SPDX-License-Identifier: GPL-2.0-only
"""Access to a pendant and a head: for the group dialout, without root, and for no other user.

The kernel and udevd are the real ones, with our rules; tests run with the ids of users.
"""

import array
import errno
import grp
import os
import pathlib
import re
import termios

import libevdev
from harness import (BIND_TIME, Events, Plugged, command, key, read_file, settle, trigger,
                     udev_properties, wait_for, write_file)
from permissions import (NOBODY, check_node, check_refused, files_below, member, open_error,
                         wait_access)
from virtual_head import VirtualHead
from xhc_sim.uhid import UhidPendant

DRIVER = '/sys/bus/hid/drivers/hid-xhc'
AXES = 4


# --- pendant -----------------------------------------------------------------------------------

def check_pendant(pendant):
    check_node(pendant.node)
    wait_access(pendant.path('dro'))
    check_refused(pendant.path('dro'))
    for_all = [name for name, (mode, _) in files_below(pendant.directory).items() if mode & 0o002]
    assert for_all == []
    with member():
        assert open_error(pendant.hidraw, os.O_RDWR) == errno.EACCES


def use_pendant(pendant, code):
    """All functions of a program, by a member of the group."""
    with member():
        events = Events(pendant.node)
        pendant.set('dro/position', '1 2 3 %d 5 6' % code)
        pendant.flush()
    assert pendant.usb.lcd.as_dict()['machine_x'] == '%d.0000' % code
    pendant.usb.press(code)
    assert events.report() == key(code, 1)
    pendant.usb.release(code)
    events.close()


def test_pendant_without_root():
    with Plugged() as pendant:
        check_pendant(pendant)
        use_pendant(pendant, 5)
        name = os.path.basename(pendant.directory)
        pendant.events.close()
        write_file(DRIVER + '/unbind', name)
        write_file(DRIVER + '/bind', name)
        pendant.wait_bound(pendant.usb.frame_count - 1)
        check_pendant(pendant)
        use_pendant(pendant, 6)
    with Plugged() as pendant:
        check_pendant(pendant)
        use_pendant(pendant, 7)
    with Plugged('HB03') as pendant:
        check_pendant(pendant)


def test_rules_that_come_after_the_pendant():
    """As on installation of the package with the pendant plugged in, by udevadm trigger."""
    with Plugged() as pendant:
        wait_access(pendant.path('dro'))
        for name in os.listdir(pendant.path('dro')):
            os.chown(pendant.path('dro/' + name), 0, 0)
        os.chown(pendant.node, 0, 0)
        settle()
        trigger(pendant.directory, pendant.node)
        check_pendant(pendant)


def test_names_of_pendants():
    """The first one keeps the short name; each has a name by its port."""
    command('modprobe', 'uhid')

    def short():
        return os.path.realpath('/dev/input/xhc-hb04')

    def by_id():
        return {os.path.realpath(path): path.name
                for path in pathlib.Path('/dev/input/by-id').glob('xhc-*')}

    with Plugged() as first:
        wait_for(lambda: short() == first.node, 'the short name', BIND_TIME)
        with Plugged() as second, Plugged(usb=UhidPendant()) as third:
            wanted = {one.node: 'xhc-hb04-%s-event-joystick' % re.sub('/', '_', one.usb.phys)
                      for one in (first, second, third)}
            wait_for(lambda: by_id() == wanted, 'names by id', BIND_TIME)
            settle()
            assert short() == first.node
            trigger(second.node, third.node, first.node)
            assert short() == first.node
            first.events.close()
            first.unplug()
            wait_for(lambda: short() in (second.node, third.node), 'heir of the name', BIND_TIME)
    wait_for(lambda: not by_id() and not os.path.lexists('/dev/input/xhc-hb04'), 'end of the names',
             BIND_TIME)


def test_devices_of_others_are_let_alone():
    """The vendor of pendants has other products, too."""
    command('modprobe', 'uinput')
    other = libevdev.Device()
    other.name = 'no pendant'
    other.id = {'bustype': 3, 'vendor': 0x10CE, 'product': 0xEA6A}
    other.enable(libevdev.EV_KEY.BTN_TRIGGER_HAPPY1)
    made = other.create_uinput_device()
    wait_for(lambda: os.path.exists(made.devnode), made.devnode, BIND_TIME)
    properties, _ = udev_properties(made.devnode)
    assert grp.getgrgid(os.stat(made.devnode).st_gid).gr_name == 'input'
    assert 'xhc' not in properties.get('DEVLINKS', ''), 'names %s' % properties.get('DEVLINKS')


# --- scanhead ----------------------------------------------------------------------------------

def check_head(head):
    for node in (head.node, head.buffer):
        check_node(node)
    for directory in (head.path('.'), head.iio + '/.'):
        wait_access(directory)
        check_refused(directory)
    with member():
        for path in (head.spi + '/line_map', '/sys/class/xy3/attach'):  # the wiring of heads
            assert open_error(path) == errno.EACCES, path


def test_head_without_root():
    with VirtualHead(lines=AXES) as head:
        check_head(head)
        with member():
            write_file(head.path('calibrate'), 'x')
            head.set('frame_bits', 32)
            head.set('sampling_frequency', 50000)
            head.set('out_angl2_raw', 4711)
        assert head.positions(26)[2] == 4711
    with VirtualHead(lines=2) as head:
        check_head(head)


def test_speed_without_root():
    with VirtualHead(lines=2) as head, head.attached():
        check_node(head.node)
        with member():
            fd = os.open(head.node, os.O_RDWR | os.O_NOCTTY)
            try:
                settings = termios.tcgetattr(fd)
                assert settings[4] == termios.B115200
                settings[4] = settings[5] = termios.B230400
                termios.tcsetattr(fd, termios.TCSANOW, settings)
            finally:
                os.close(fd)
        # tcsetattr() does not wait for that
        wait_for(lambda: read_file(head.path('rate')) == '230400\n', 'the rate', BIND_TIME)


def test_stream_without_root():
    """By the program of libiio, which uses other paths for the files of the buffer."""
    scans = 1024
    data = array.array('I', (scan * AXES + axis for scan in range(scans) for axis in range(AXES)))
    pathlib.Path('/tmp/access').write_bytes(data.tobytes())
    with VirtualHead(lines=AXES) as head:
        check_head(head)
        head.record(scans)
        command('setpriv', '--reuid', str(NOBODY), '--regid', str(NOBODY), '--groups', 'dialout',
                'sh', '-c', 'iio_writedev -b 512 -s %d xy3-100 < /tmp/access' % scans)
        head.check_record(data.tobytes())
        with member(), head.streaming(), open(head.buffer, 'wb', buffering=0) as file:
            assert file.write(data) == 4 * len(data)


def test_gate_without_root():
    """A line map with a gate has one more channel; root writes it, and the IIO device is new."""
    with VirtualHead(lines=4, framing='line', signals='sync,x,y,gate') as head:
        write_file(head.spi + '/line_map', 'sync x y gate')
        head.wait_bound()
        check_head(head)
        with member():
            head.set('scan_elements/out_voltage0_en', 1)
            with head.streaming(), open(head.buffer, 'wb', buffering=0) as file:
                assert file.write(array.array('I', (1, 2, 1))) == 12
