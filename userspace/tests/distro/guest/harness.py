# SPDX-License-Identifier: GPL-2.0-only
"""Common to all tests in the guest: checks, waiting, commands, and a plugged pendant."""

import glob
import os
import re
import subprocess
import time

import libevdev
from xhc_sim import find
from xhc_sim.usb import UsbPendant

BIND_TIME = 60.0        # seconds: udevd and modprobe are slow in an emulated machine
EVENT_TIME = 10.0
PAUSE = 0.05                # between two checks, which slow down the guest
TRACING = '/sys/kernel/tracing'


def wait_for(condition, what, timeout=EVENT_TIME):
    """-> the first true value of the condition"""
    value = find.wait(condition, timeout, PAUSE)
    assert value, '%s: not within %g s' % (what, timeout)
    return value


def error_of(function, *arguments):
    """The errno of a failed call, 0 on success."""
    try:
        function(*arguments)
    except OSError as error:
        return error.errno
    return 0


def command(*words):
    """Runs a program that must succeed; -> its output"""
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False)
    assert done.returncode == 0, ('%s: status %d: %s' % (' '.join(words), done.returncode,
                                                      done.stdout[-300:]))
    return done.stdout


def is_running(pid):
    """Whether a process has open files: false after it has exited, reaped or not."""
    try:
        return read_file('/proc/%d/stat' % pid).rpartition(')')[2].split()[0] not in 'XZ'
    except OSError:
        return False


def read_file(path):
    with open(path, encoding='ascii') as file:
        return file.read()


def write_file(path, text):
    """One write(2), so that an error of the kernel is raised by this call."""
    fd = os.open(path, os.O_WRONLY)
    try:
        os.write(fd, text.encode())
    finally:
        os.close(fd)


def module_loaded(name):
    return os.path.isdir('/sys/module/' + name)


def module_addresses(name):
    """First and last address of a loaded module."""
    for line in read_file('/proc/modules').splitlines():
        found, size, _, _, _, address = line.split()[:6]
        if found == name:
            return int(address, 16), int(address, 16) + int(size)
    raise AssertionError('%s is not loaded' % name)


def jiffies():
    """The clock of the kernel, used for the age of memory."""
    return int(re.search(r'^jiffies: (\d+)', read_file('/proc/timer_list'), re.M).group(1))


def live_allocations(places, since=0):
    """Lines of the kernel about live objects that were allocated by our modules with kmalloc.

    places: {module: [its module_addresses() of each load]}. since: jiffies when the first one was
    loaded; older objects belong to the init code of a module that was loaded there before. Requires
    slub_debug=U. A line is "COUNT CALLER [MODULE] ... age=...", and after the module was unloaded
    "COUNT 0xADDRESS".
    """
    ranges = [addresses for each in places.values() for addresses in each]
    pattern = re.compile(r'^( *\d+ (\S+)(?: \[(\w+)\])? .*\bage=(\d+).*)', re.M)
    lines = []
    for path in glob.glob('/sys/kernel/debug/slab/kmalloc-*/alloc_traces'):
        found = pattern.findall(read_file(path))
        now = jiffies()                 # after the file was read, or new objects seem older
        for line, caller, module, age in found:
            ours = module in places or caller.startswith('0x') and any(
                first <= int(caller, 16) < last for first, last in ranges)
            if ours and now - int(age) >= since:
                lines.append('%s: %s' % (path.split('/')[-2], line.strip()))
    return lines


def check_no_allocations(places, what, since=0):
    """Some are freed some time later."""
    if not find.wait(lambda: not live_allocations(places, since), 20):
        raise AssertionError('%s: memory is left: %r' % (what, live_allocations(places, since)))


def unload_modules(*names):
    """After udevd has processed the last device, or it may load them again.

    Programs with an open file of theirs may be about to close it.
    """
    settle()

    def gone():
        done = subprocess.run(['modprobe', '-r', *names], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        assert done.returncode == 0 or re.search('in use|temporarily unavailable', done.stdout), \
            done.stdout
        return done.returncode == 0

    wait_for(gone, 'end of ' + ', '.join(names), BIND_TIME)


class Module:
    """A module that udev or the kernel loads on demand, and its leaks."""

    def __init__(self, name):
        self.name = name                # as in /proc/modules
        self.since = 0                  # jiffies before it was loaded

    def will_come(self):
        """To be called before anything that may load it."""
        if not module_loaded(self.name):
            self.since = jiffies()

    def load(self):
        self.will_come()
        command('modprobe', self.name)

    def unload(self):
        addresses = module_addresses(self.name)
        unload_modules(self.name)
        check_no_allocations({self.name: [addresses]}, 'the module has gone', self.since)

    def allocations(self):
        return live_allocations({self.name: [module_addresses(self.name)]}, self.since)


hid_xhc = Module('hid_xhc')


def settle():
    """Waits until udevd has processed all events; retries if it closes the connection of udevadm.

    Hundreds of events of a storm take minutes on a busy host: the limit of the test is shorter.
    """
    def done():
        found = subprocess.run(['udevadm', 'settle', '--timeout=600'], stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, check=False)
        assert found.returncode == 0 or 'reply: Broken pipe' in found.stdout, (
            'udevadm settle: status %d: %s%s' % (found.returncode, found.stdout, udevd_state()))
        return found.returncode == 0

    wait_for(done, 'answer of udevd', BIND_TIME)


def trigger(*paths):
    """Makes udevd process devices again. (`udevadm trigger --settle` of 252 to 254 may hang.)"""
    command('udevadm', 'trigger', *paths)
    settle()


def reload_rules():
    """Waits until udevd has read the current rules.

    It checks for changes at most every three seconds, and it may close the connection of udevadm:
    a rule that marks /dev/null shows that all rules have been read.
    """
    place = '/etc/udev/rules.d/99-test-mark.rules'
    mark = 'TEST_MARK=%d' % time.monotonic_ns()
    with open('/etc/udev/test-mark', 'w', encoding='ascii') as file:
        file.write('SUBSYSTEM=="mem", KERNEL=="null", ENV{%s}="%s"\n' % tuple(mark.split('=')))
    os.rename('/etc/udev/test-mark', place)     # udevd never reads an incomplete file

    def loaded():
        subprocess.run(['udevadm', 'control', '--reload'], check=False)
        trigger('/dev/null')
        return mark in command('udevadm', 'info', '--query=property', '/dev/null').splitlines()

    wait_for(loaded, 'reload of the rules', BIND_TIME)


def udevd_state():
    """The state of udevd and its workers, for the message of a failure."""
    lines = []
    for path in glob.glob('/proc/[0-9]*/comm'):
        if read_file(path).strip() in ('systemd-udevd', 'udevadm', '(udev-worker)'):
            place = os.path.dirname(path)
            lines.append('%s: %s' % (place, read_file(place + '/stat').split(') ')[1]))
            for name in ('wchan', 'syscall', 'stack'):
                try:
                    lines.append('  %s: %s' % (name, read_file('%s/%s' % (place, name)).strip()))
                except OSError as error:
                    lines.append('  %s: %s' % (name, error))
    lines.append('queue: %s' % os.path.exists('/run/udev/queue'))
    return '\n'.join(lines)


def udev_properties(node):
    """-> (dict of properties, set of tags), once udevd has processed the node"""
    settle()
    lines = command('udevadm', 'info', '--query=property', '--name=' + node).splitlines()
    properties = dict(line.split('=', 1) for line in lines)
    return properties, set(properties.get('TAGS', '').strip(':').split(':'))


def key(code, value):
    """The events of a key with a scan code."""
    return ['MSC_SCAN %d' % code, 'BTN_TRIGGER_HAPPY%d %d' % (code, value)]


class Events:
    """An event node, read by libevdev; events are text: ["ABS_MISC 1", "SYN_REPORT 0"]."""

    def __init__(self, node):
        self.file = open(node, 'rb')
        os.set_blocking(self.file.fileno(), False)
        self.device = libevdev.Device(self.file)

    def close(self):
        self.file.close()

    def more(self):
        """The events that can be read now."""
        return ['%s %d' % (event.code.name, event.value) for event in self.device.events()]

    def until(self, enough, what):
        events = []

        def done():
            events.extend(self.more())
            return enough(events)

        find.wait(done, EVENT_TIME)
        assert enough(events), '%s: there is only %r' % (what, events)
        return events

    def reports(self, count):
        """The next `count` reports: lists of events, each up to its SYN_REPORT."""
        events = self.until(lambda seen: seen.count('SYN_REPORT 0') >= count,
                            '%d reports' % count)
        found = [[]]
        for event in events:
            if event == 'SYN_REPORT 0':
                found.append([])
            else:
                found[-1].append(event)
        assert found.pop() == []
        assert len(found) == count
        return found

    def report(self):
        return self.reports(1)[0]

    def quiet(self, seconds=0.3):
        time.sleep(seconds)
        assert self.more() == []


class Plugged:
    """A pendant in a USB port, with its driver bound and its nodes created.

        with Plugged('HB04') as pendant:
            pendant.usb.press(1)
            pendant.events.report()

    wvalues and frames are those received since the pendant was plugged in, including the forced
    frame of the driver's probe, which has been received when the pendant is ready.
    """

    def __init__(self, model='HB04', usb=None, driver='hid-xhc'):
        self.usb = usb or UsbPendant(model)
        self.driver = driver
        self.directory = None
        self.node = None
        self.hidraw = None
        self.events = None

    def __enter__(self):
        try:
            return self.plug()
        except BaseException:
            self.usb.unplug()
            raise

    def __exit__(self, *_):
        if self.events:
            self.events.close()
        if self.usb.plugged:
            self.unplug()

    def plug(self):
        before = self.usb.frame_count
        hid_xhc.will_come()
        self.usb.plug()
        self.wait_bound(before)
        return self

    def wait_bound(self, frames_before=0):
        """Waits until the driver is bound and has opened the device."""
        wait_for(self._bound, 'driver %s' % self.driver, BIND_TIME)
        if self.driver == 'hid-xhc':
            wait_for(self._find_nodes, 'event node', BIND_TIME)
            assert self.usb.wait_frames(frames_before + 1, BIND_TIME), 'no first frame'
            # attributes are created after probe, and the frame may be sent earlier
            wait_for(lambda: os.path.exists(self.path('stats/reports')), 'attributes')
            self.open()

    def open(self):
        if self.events:
            self.events.close()
        self.events = Events(self.node)

    def _bound(self):
        self.directory = find.hid_directory(self.usb.phys)
        return self.directory and find.driver(self.directory) == self.driver

    def _find_nodes(self):
        self.node, self.hidraw = find.nodes(self.directory)
        return self.node and self.hidraw and os.path.exists(self.node)

    def unplug(self):
        """Unplugs the cable and waits until the kernel has detected it."""
        self.usb.unplug()
        self.wait_gone()

    def wait_gone(self):
        wait_for(lambda: find.hid_directory(self.usb.phys) is None, 'end of the HID device')

    # --- sysfs ----------------------------------------------------------------------------

    def path(self, name):
        return os.path.join(self.directory, name)

    def get(self, name):
        return read_file(self.path(name)).rstrip('\n')

    def set(self, name, value):
        write_file(self.path(name), '%s\n' % value)

    def input_path(self, name):
        """A path in the directory of the input device."""
        return glob.glob(self.path('input/input*'))[0] + '/' + name

    def flush(self):
        self.set('dro/flush', 1)
