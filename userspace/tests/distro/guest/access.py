# SPDX-License-Identifier: GPL-2.0-only
"""Who may use a pendant and a head: the group dialout, without root, and nobody else.

The kernel and udevd are the real ones, with our rules; users are made by taking their ids.
"""

import array
import contextlib
import errno
import grp
import os
import pathlib
import re
import stat
import termios

import libevdev
from events import key, udev_properties
from harness import (BIND_TIME, Events, Plugged, command, equal, error_of, find, read_file,
                     settle, true, wait_for, write_file)
from virtual import Virtual
from xhc_sim.uhid import UhidPendant

TESTS = []
NOBODY = 65534
DIALOUT = grp.getgrnam('dialout').gr_gid
DRIVER = '/sys/bus/hid/drivers/hid-xhc'
AXES = 4


def test(function):
    TESTS.append(function)
    return function


@contextlib.contextmanager
def user(*groups):
    """All of this process is somebody without rights, in these groups, for a while."""
    os.setgroups(groups)
    os.setegid(NOBODY)
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(0)
        os.setgroups([])


def member():
    return user(DIALOUT)


def outsider():
    return user()


def open_error(path, flags=os.O_WRONLY):
    """The errno with which open(2) fails; 0 if it does not, and the file is closed again."""
    def attempt():
        os.close(os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY))

    return error_of(attempt)


# --- modes -------------------------------------------------------------------------------------

def files_below(directory):
    """-> {name: (mode, group)} of all files in sysfs below a directory, not by links"""
    found = {}
    for place, _, names in os.walk(directory):
        for name in names:
            path = os.path.join(place, name)
            state = os.lstat(path)
            if stat.S_ISREG(state.st_mode):
                found[os.path.relpath(path, directory)] = (stat.S_IMODE(state.st_mode),
                                                           state.st_gid)
    return found


def for_root(name):
    """What every device has, and what changes more than the one device."""
    return name.endswith('uevent') or 'power' in name.split('/') or \
        name == 'current_timestamp_clock'


def misplaced(directory):
    """Names of files whose mode or group is not what it is to be."""
    bad = []
    for name, (mode, group) in files_below(directory).items():
        open_to_group = group == DIALOUT and bool(mode & 0o020)
        wanted = bool(mode & 0o200) and not for_root(name)
        if mode & 0o002 or open_to_group != wanted:
            bad.append('%s: %o, group %d' % (name, mode, group))
    return bad


def wait_access(directory):
    """Until udevd has given all files of a device to the group."""
    true(len([mode for mode, _ in files_below(directory).values() if mode & 0o200]) > 5,
         'few files to write in ' + directory)
    find.wait(lambda: not misplaced(directory), BIND_TIME)
    equal(misplaced(directory), [], 'files with another mode or group in ' + directory)


def check_node(node):
    """For the group, and by udev's tag for who sits at the machine."""
    def found():
        state = os.stat(node)
        return '%o, group %d' % (state.st_mode & 0o667, state.st_gid)

    wanted = '660, group %d' % DIALOUT
    find.wait(lambda: found() == wanted, BIND_TIME)     # udevd changes one after the other
    equal(found(), wanted, 'mode of ' + node)
    true('uaccess' in udev_properties(node)[1], 'no tag uaccess on ' + node)
    with member():
        equal(open_error(node, os.O_RDWR), 0, 'errno of a member, ' + node)
    with outsider():
        for flags in (os.O_RDONLY, os.O_WRONLY):
            equal(open_error(node, flags), errno.EACCES, 'errno of an outsider, ' + node)


def check_refused(directory):
    """No file of a device can be written by an outsider."""
    names = [name for name, (mode, _) in files_below(directory).items() if mode & 0o200]
    with outsider():
        errors = {name: open_error(os.path.join(directory, name)) for name in names}
    equal({name for name, error in errors.items() if error != errno.EACCES}, set(),
          'what an outsider may write in ' + directory)


# --- pendant -----------------------------------------------------------------------------------

def check_pendant(pendant):
    check_node(pendant.node)
    wait_access(pendant.path('dro'))
    check_refused(pendant.path('dro'))
    equal([name for name, (mode, _) in files_below(pendant.directory).items() if mode & 0o002], [],
          'what the world may write')
    with member():
        equal(open_error(pendant.hidraw, os.O_RDWR), errno.EACCES, 'errno of hidraw')


def use_pendant(pendant, code):
    """All that a program has to do with it, by a member of the group."""
    with member():
        events = Events(pendant.node)
        pendant.set('dro/position', '1 2 3 %d 5 6' % code)
        pendant.flush()
    equal(pendant.usb.lcd.as_dict()['machine_x'], '%d.0000' % code, 'machine_x on the LCD')
    pendant.usb.press(code)
    equal(events.report(), key(code, 1), 'key')
    pendant.usb.release(code)
    events.close()


@test
def pendant_without_root():
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


@test
def rules_that_come_after_the_pendant():
    """As when the package is installed with the pendant plugged in: udevadm trigger does it."""
    with Plugged() as pendant:
        wait_access(pendant.path('dro'))
        for name in os.listdir(pendant.path('dro')):
            os.chown(pendant.path('dro/' + name), 0, 0)
        os.chown(pendant.node, 0, 0)
        settle()
        command('udevadm', 'trigger', '--settle', pendant.directory, pendant.node)
        check_pendant(pendant)


@test
def names_of_pendants():
    """The first one keeps the short name; each has one by where it is plugged in."""
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
            equal(short(), first.node, 'the short name, of three')
            command('udevadm', 'trigger', '--settle', second.node, third.node, first.node)
            equal(short(), first.node, 'the short name, after all were looked at again')
            first.events.close()
            first.unplug()
            wait_for(lambda: short() in (second.node, third.node), 'heir of the name', BIND_TIME)
    wait_for(lambda: not by_id() and not os.path.lexists('/dev/input/xhc-hb04'), 'end of the names',
             BIND_TIME)


@test
def devices_of_others_are_let_alone():
    """The vendor of pendants makes other things, too."""
    command('modprobe', 'uinput')
    other = libevdev.Device()
    other.name = 'no pendant'
    other.id = {'bustype': 3, 'vendor': 0x10CE, 'product': 0xEA6A}
    other.enable(libevdev.EV_KEY.BTN_TRIGGER_HAPPY1)
    made = other.create_uinput_device()
    wait_for(lambda: os.path.exists(made.devnode), made.devnode, BIND_TIME)
    properties, _ = udev_properties(made.devnode)
    equal(grp.getgrgid(os.stat(made.devnode).st_gid).gr_name, 'input', 'group')
    true('xhc' not in properties.get('DEVLINKS', ''), 'names %s' % properties.get('DEVLINKS'))


# --- scanhead ----------------------------------------------------------------------------------

def check_head(head):
    for node in (head.node, head.buffer):
        check_node(node)
    for directory in (head.path('.'), head.iio + '/.'):
        wait_access(directory)
        check_refused(directory)
    with member():
        equal([open_error(path) for path in (head.spi + '/line_map', '/sys/class/xy3/attach')],
              [errno.EACCES] * 2, 'errno of what says how heads are wired')


@test
def head_without_root():
    with Virtual(lines=AXES) as head:
        check_head(head)
        with member():
            write_file(head.path('calibrate'), 'x')
            head.set('frame_bits', 32)
            head.set('sampling_frequency', 50000)
            head.set('out_angl2_raw', 4711)
        equal(head.positions(26)[2], 4711, 'position')
    with Virtual(lines=2) as head:
        check_head(head)


@test
def speed_without_root():
    with Virtual(lines=2) as head, head.attached():
        check_node(head.node)
        with member():
            fd = os.open(head.node, os.O_RDWR | os.O_NOCTTY)
            try:
                settings = termios.tcgetattr(fd)
                equal(settings[4], termios.B115200, 'speed')
                settings[4] = settings[5] = termios.B230400
                termios.tcsetattr(fd, termios.TCSANOW, settings)
                equal(termios.tcgetattr(fd)[4], termios.B230400, 'speed')
            finally:
                os.close(fd)
        equal(read_file(head.path('rate')), '230400\n', 'rate')


@test
def stream_without_root():
    """By libiio's program, which has its own idea of where the buffer's files are."""
    scans = 1024
    data = array.array('I', (scan * AXES + axis for scan in range(scans) for axis in range(AXES)))
    pathlib.Path('/tmp/access').write_bytes(data.tobytes())
    with Virtual(lines=AXES) as head:
        check_head(head)
        head.record(scans)
        command('setpriv', '--reuid', str(NOBODY), '--regid', str(NOBODY), '--groups', 'dialout',
                'sh', '-c', 'iio_writedev -b 512 -s %d xy3-100 < /tmp/access' % scans)
        head.check_record(data.tobytes())
        with member(), head.streaming(), open(head.buffer, 'wb', buffering=0) as file:
            equal(file.write(data), 4 * len(data), 'bytes taken')
