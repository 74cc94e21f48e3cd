# SPDX-License-Identifier: GPL-2.0-only
"""Fixtures for the end-to-end tests of the pendant: the module, a virtual pendant bound to it, and
access to both ends (libevdev, sysfs, hidraw).

The tests run as root of a guest, never on the machine itself. TEST_WORLD is the kind of guest:

uml     (default) the test kernel, uml/run-uml; XHC_MODULE is the path of hid-xhc.ko. A pendant is
        a uhid device unless a test asks for USB.
distro  Debian's kernel, distro/boot: modprobe finds the module, and udevd also loads it when a
        pendant is plugged in. A pendant is a USB device on vhci_hcd. Only tests with the mark
        "distro" run there.
"""

import errno
import os
import select
import struct
import subprocess
import sys
import time

import case
import libevdev
from kernel import is_loaded, load_module, read_file, unload_module, write_file

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, '..', '..', 'xhc-sim'))

from xhc_sim import find  # noqa: E402
from xhc_sim.lcd import COORDINATES, NUMBERS, normal_number  # noqa: E402
from xhc_sim import whb04b  # noqa: E402
from xhc_sim.uhid import UhidPendant  # noqa: E402
from xhc_sim.usb import UsbPendant  # noqa: E402

MODULE = 'hid_xhc'
MODULE_FILE = os.environ.get('XHC_MODULE', '')
DRIVER_DIR = '/sys/bus/hid/drivers/hid-xhc'
PARAMETER = '/sys/module/hid_xhc/parameters/swap_feed_spindle'

IN_DISTRO = os.environ.get('TEST_WORLD', 'uml') == 'distro'
if IN_DISTRO:
    from harness import hid_xhc

# Timeout in seconds for expected events; only reached on failure. In the test kernel time passes as
# on the host while a program runs, and a busy host makes little progress in a second; when all
# wait, it skips to the next timer. In an emulated machine udevd and modprobe take seconds.
PATIENCE = 60 if IN_DISTRO else 30
PAUSE = 0.05 if IN_DISTRO else 0.01     # between polls, which slow down the guest

# fields of the LCD of the HB03 and HB04, and of the WHB04B
DISPLAYED = (*COORDINATES, *NUMBERS, 'step', 'icon', 'state', 'day')
DISPLAYED_WHB04B = (*whb04b.ROWS, *whb04b.NUMBERS, 'mode', 'coordinates', 'reset')
DECIMAL = COORDINATES + whb04b.ROWS
KEY = ['BTN_TRIGGER_HAPPY%d' % number for number in range(41)]
POSITIONS = ['off', 'X', 'Y', 'Z', 'A', 'feed', 'spindle', 'B', 'C']
# By name of the model
LAST_KEY = {'HB03': 0x17, 'HB04': 0x17, 'WHB04B': 0x10}


def wait(condition, timeout=PATIENCE):
    """Waits until condition() is true or the timeout expires. -> its last value"""
    return find.wait(condition, timeout, PAUSE)


def load(parameters=''):
    if IN_DISTRO:
        assert not parameters
        hid_xhc.load()
    else:
        load_module(MODULE_FILE, parameters)


def unload():
    if IN_DISTRO:
        hid_xhc.unload()        # and checks for leaked memory
    else:
        unload_module(MODULE)


def loaded():
    return is_loaded(MODULE)


def takes(path):
    """Whether hid-xhc binds a HID device; waits for a probe in progress, and tries again."""
    try:
        write_file(DRIVER_DIR + '/bind', os.path.basename(path))
    except OSError:
        pass
    return find.driver(path) == 'hid-xhc'


class EvdevReader:
    """Reads one event node by libevdev."""

    def __init__(self, node):
        self.fd = os.open(node, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        self.file = os.fdopen(self.fd, 'rb', buffering=0)
        self.device = libevdev.Device(self.file)
        self.seen = []

    def close(self):
        self.file.close()

    def keys_down(self):
        """Names of the keys that were down when the node was opened."""
        return [code.name for code in self.device.evbits[libevdev.EV_KEY]
                if self.device.value[code]]

    def _fill(self, timeout):
        """libevdev's Python binding hides ENODEV: a removed device is detected by poll()."""
        poll = select.poll()
        poll.register(self.fd, select.POLLIN)
        ready = poll.poll(max(0, timeout * 1000))
        if ready and ready[0][1] & (select.POLLHUP | select.POLLERR):
            raise OSError(errno.ENODEV, 'the device was removed; events before: %s' % self.seen)
        if ready:
            self.seen += [(event.type.name, event.code.name, event.value)
                          for event in self.device.events()]

    def packet(self, timeout=PATIENCE):
        """Events up to the next SYN_REPORT, without it; None after the timeout."""
        deadline = time.monotonic() + timeout
        while True:
            for at, (kind, code, _) in enumerate(self.seen):
                if kind == 'EV_SYN' and code == 'SYN_REPORT':
                    packet, self.seen = self.seen[:at], self.seen[at + 1:]
                    return packet
            left = deadline - time.monotonic()
            if left <= 0:
                return None
            self._fill(left)


class EvdevRecorder:
    """A program that reads an event node until the device is removed.

    evdev drops unread events when the device is removed. Therefore the program has a real-time
    priority and waits in read(): it is the first to run when the driver has sent the events and
    waits itself. It is not a thread of this process, which other threads could delay.
    """

    EVENT = struct.Struct('@qqHHi')

    def __init__(self, node):
        self.program = subprocess.Popen(['chrt', '--fifo', '1', 'cat', node],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                                        bufsize=0)
        self.data = b''
        assert wait(lambda: self._has_open(node)), 'cat does not open %s' % node

    def _has_open(self, node):
        folder = '/proc/%d/fd' % self.program.pid
        try:
            return node in [os.readlink(os.path.join(folder, name)) for name in os.listdir(folder)]
        except FileNotFoundError:
            return False            # it has closed another file meanwhile

    def _sleeps(self):
        """Whether it waits in read(), not for something else, such as a page of its code"""
        stat = read_file('/proc/%d/stat' % self.program.pid)
        return stat.rpartition(')')[2].split()[0] == 'S'

    def _events(self):
        """(type, code, value) by name of all complete events so far."""
        size = self.EVENT.size
        whole = self.data[:len(self.data) // size * size]
        for _, _, kind, code, value in self.EVENT.iter_unpack(whole):
            bit = libevdev.evbit(kind, code)
            yield bit.type.name, bit.name, value

    def next_packet(self):
        """Events up to the next SYN_REPORT, without it. The program then waits for more."""
        while ('EV_SYN', 'SYN_REPORT', 0) not in self._events():
            ready = select.select([self.program.stdout], [], [], PATIENCE)[0]
            more = ready and self.program.stdout.read(64 * self.EVENT.size)
            assert more, 'no packet; events: %s' % list(self._events())
            self.data += more
        events = list(self._events())
        at = events.index(('EV_SYN', 'SYN_REPORT', 0))
        self.data = self.data[(at + 1) * self.EVENT.size:]
        assert wait(self._sleeps), 'cat does not wait for more'
        return events[:at]

    def rest(self):
        """All further events, up to the end of the device."""
        more, _ = self.program.communicate(timeout=PATIENCE)
        self.data += more
        return list(self._events())

    def close(self):
        self.program.kill()
        self.program.communicate()


class Rig:
    """A virtual pendant bound to hid-xhc, and access to both ends."""

    def __init__(self, model='HB04', device=None, **options):
        self.device = device or (UsbPendant if IN_DISTRO else UhidPendant)(model, **options)
        self.path = None
        self.reader = None
        self.event_node = None
        self.hidraw_node = None
        self.frames_before = 0      # frames of the device before the counters of the driver started
        self.held = (0, 0, None)    # keys and selector of the last report
        self.random = 0             # byte 1 of the next report of a WHB04B

    # --- plug and unplug ------------------------------------------------------------------

    def plug(self, first_frame=True):
        """Plugs it in and waits until the driver is bound (and the display has its first frame)."""
        self.frames_before = self.device.frame_count
        self.device.plug()
        self.wait_bound()
        if first_frame:
            self.wait_first_frame()
        return self

    def wait_bound(self):
        """Waits until the driver is bound, with attributes and nodes."""
        self.path = wait(self._driven)
        if not self.path:
            raise AssertionError('hid-xhc does not bind to %s' % self.device.phys)
        if not wait(self._nodes):
            raise AssertionError('no event or hidraw node for %s' % self.device.phys)
        self.look_again()

    def wait_first_frame(self):
        if not self.device.wait_frames(self.frames_before + 1, PATIENCE):
            raise AssertionError('no first frame')

    def _driven(self):
        path = find.hid_directory(self.device.phys)
        if path and find.driver(path) == 'hid-xhc' and os.path.exists(path + '/dro/flush'):
            return path
        return None

    def _nodes(self):
        self.event_node, self.hidraw_node = find.nodes(self.path)
        return (self.event_node and os.path.exists(self.event_node) and
                self.hidraw_node and os.path.exists(self.hidraw_node))

    def close_reader(self):
        if self.reader:
            self.reader.close()
            self.reader = None

    def look_again(self):
        """Reopens the event node: libevdev only reads the keymap and the state on open."""
        self.close_reader()
        self.reader = EvdevReader(self.event_node)

    def unplug(self):
        self.close_reader()
        self.device.detach()
        self.wait_gone()
        if self.path and isinstance(self.device, UsbPendant):
            # the HID device may be removed earlier; a hub that has not yet detected the empty
            # port takes the next device there for this one
            usb_device = os.path.dirname(os.path.dirname(self.path))
            assert wait(lambda: not os.path.exists(usb_device)), '%s stays' % usb_device
        self.path = None

    def wait_gone(self):
        """Waits until the kernel has removed the device."""
        if self.path and not wait(lambda: not os.path.exists(self.path)):
            raise AssertionError('%s does not go away' % self.path)

    def unbind(self):
        write_file(DRIVER_DIR + '/unbind', os.path.basename(self.path))

    def bind(self):
        self.frames_before = self.device.frame_count
        write_file(DRIVER_DIR + '/bind', os.path.basename(self.path))

    # --- sysfs ----------------------------------------------------------------------------

    def file(self, name):
        """Path of an attribute; the folders dro/ and stats/ may be left out."""
        for folder in ('dro', 'stats', ''):
            path = os.path.join(self.path, folder, name)
            if os.path.isfile(path):
                return path
        raise AssertionError('no attribute %s' % name)

    def get(self, name):
        """An attribute's text; it must be one line."""
        text = read_file(self.file(name))
        if not text.endswith('\n') or '\n' in text[:-1]:
            raise AssertionError('%s: not one line: %r' % (name, text))
        return text[:-1]

    def stat(self, name):
        return int(self.get(name))

    def set(self, name, text):
        write_file(self.file(name), text)

    def set_error(self, name, text):
        """-> name of the error of the write, or None"""
        try:
            self.set(name, text)
        except OSError as error:
            return errno.errorcode[error.errno]
        return None

    # --- display --------------------------------------------------------------------------

    def flush(self):
        """Sends a frame and waits for it; -> the fields of the LCD"""
        self.set('flush', '1')
        # the count of the device lags if it receives the requests from usbmon
        assert self.device.wait_frames(self._frames_sent(), PATIENCE), 'flush sent no frame'
        return self.device.lcd.as_dict()

    def _frames_sent(self):
        """Number of frames of the device that the driver has counted."""
        return self.frames_before + self.stat('frames_sent')

    def count_frames_anew(self):
        """After failed allocations, for which usbmon drops requests that the driver has sent."""
        count = self.device.frame_count
        while self.device.wait_frames(count + 1, 0.5):
            count = self.device.frame_count
        self.frames_before = count - self.stat('frames_sent')

    def shown(self, name):
        """A value on the LCD in the format of the driver's attribute; None: the LCD is blank"""
        if self.device.lcd is None:
            return None
        value = str(self.device.lcd.as_dict()[name])
        return normal_number(value) if name in DECIMAL else value

    def shows(self, name, value, timeout=PATIENCE):
        """Waits until the LCD shows the value; -> whether it does"""
        return self.device.wait_for(
            lambda: self.device.lcd and self.device.lcd.as_dict()[name] == value, timeout)

    @property
    def displayed(self):
        """Names of the attributes that are displayed on the LCD"""
        return DISPLAYED_WHB04B if self.device.model.feed else DISPLAYED

    def settle(self):
        """Waits until the driver has nothing to send; -> total number of received frames

        Then the LCD shows the values of the attributes, and the driver has counted its frame.
        """
        assert wait(self._settled), 'the LCD does not show the values of the attributes'
        return self.device.frame_count

    def _settled(self):
        if self._frames_sent() != self.device.frame_count:
            return False
        wanted = {name: self.get(name) for name in self.displayed}
        if wanted.get('day') == 'auto':
            wanted['day'] = str(time.gmtime().tm_mday)
        return wanted == {name: self.shown(name) for name in self.displayed}

    def no_more_frames(self, count, seconds=0.5):
        """Whether `count` frames were received, and no more in this time."""
        return not self.device.wait_frames(count + 1, seconds) and self.device.frame_count == count

    # --- pendant --------------------------------------------------------------------------

    def report(self, key1=0, key2=0, selector=None, wheel=0, day=None, feed=0):
        """Sends a valid input report, by default with the day or seed of the last frame.

        The selector is off by default. `feed`, the second rotary of a WHB04B, is 0 (unknown) by
        default, which real units only send on sleep; it causes no event.
        """
        device = self.device
        self.held = (key1, key2, selector)
        if selector is None:
            selector = device.model.selector['off']
        if not device.model.feed:
            day = device.pendant.day if day is None else day
            device.report(bytes([4, key1, key2, selector, wheel & 0xFF, day ^ key1]))
            return
        seed = device.pendant.seed if day is None else day
        self.random = (self.random + 0x3B) & 0xFF
        device.report(bytes([4, self.random, key1, key2, feed, selector, wheel & 0xFF,
                             whb04b.check_byte(self.random, key1, seed)]))

    def asleep(self):
        """Sends the sleep report, and the one that follows it on a WHB04B."""
        if self.device.model.feed:
            for _ in range(2):
                self.report(selector=0)
        else:
            self.device.report(bytes([4, 0, 0, 0, 0, 0]))
        self.held = (0, 0, None)

    def packet(self, timeout=PATIENCE):
        return self.reader.packet(timeout)


def released(scan, name=None):
    return [('EV_MSC', 'MSC_SCAN', scan), ('EV_KEY', name or KEY[scan], 0)]


def pressed(scan, name=None):
    return [('EV_MSC', 'MSC_SCAN', scan), ('EV_KEY', name or KEY[scan], 1)]


def selected(was, now):
    """The events of a turn of the selector, by number of position."""
    events = [('EV_ABS', 'ABS_MISC', now)]
    if was:
        events.append(('EV_KEY', KEY[30 + was], 0))
    if now:
        events.append(('EV_KEY', KEY[30 + now], 1))
    return events


def turned(detents):
    return [('EV_REL', 'REL_DIAL', detents)]


class Case(case.Case):
    """A test with the driver loaded; its pendants are unplugged after it."""

    def set_up(self):
        if IN_DISTRO:
            hid_xhc.will_come()                 # loaded by udevd
        elif not loaded():
            load()

    def plug(self, model='HB04', first_frame=True, **options):
        return self.plug_rig(Rig(model, **options), first_frame)

    def plug_usb(self, model='HB04', first_frame=True, **options):
        return self.plug_rig(Rig(device=UsbPendant(model, **options)), first_frame)

    def plug_rig(self, rig, first_frame=True):
        self.add_cleanup(rig.unplug)
        return rig.plug(first_frame)

    def assert_packet(self, rig, events):
        """The next packet consists of exactly these events."""
        assert rig.packet() == events

    def assert_lets_go(self, pendant, go):
        """When go() removes the device one packet releases all keys and turns the selector off."""
        program = EvdevRecorder(pendant.event_node)
        self.add_cleanup(program.close)
        pendant.report(1, 2, 0x12)
        assert program.next_packet() == selected(0, 2) + pressed(1) + pressed(2)
        pendant.close_reader()
        go()
        rest = program.rest()
        assert rest == (selected(2, 0) + released(1) + released(2) +
                        [('EV_SYN', 'SYN_REPORT', 0)]), rest

    def assert_silent(self, rig):
        """The last report causes no event: the next event is that of a turn of the wheel."""
        rig.report(*rig.held, wheel=1)
        self.assert_packet(rig, turned(1))
