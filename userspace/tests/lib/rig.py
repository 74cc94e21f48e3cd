# SPDX-License-Identifier: GPL-2.0-only
"""What the end-to-end tests share: the driver's module, a virtual pendant that it drives, and
the eyes and hands on both ends (libevdev, sysfs, hidraw).

The tests run as root of the test kernel (uml/run-uml), never on the machine itself; XHC_MODULE
is the path of hid-xhc.ko.
"""

import errno
import os
import select
import sys
import time
import case

import libevdev

from kernel import is_loaded, load_module, read_file, unload_module, write_file

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, '..', '..', 'xhc-sim'))

from xhc_sim import find  # noqa: E402
from xhc_sim.uhid import UhidPendant  # noqa: E402
from xhc_sim.usb import UsbPendant  # noqa: E402

MODULE = 'hid_xhc'
MODULE_FILE = os.environ.get('XHC_MODULE', '')
DRIVER_DIR = '/sys/bus/hid/drivers/hid-xhc'
PARAMETER = '/sys/module/hid_xhc/parameters/swap_feed_spindle'

KEY = ['BTN_TRIGGER_HAPPY%d' % number for number in range(41)]
POSITIONS = ['off', 'X', 'Y', 'Z', 'A', 'feed', 'spindle']


def load(parameters=''):
    load_module(MODULE_FILE, parameters)


def unload():
    unload_module(MODULE)


def loaded():
    return is_loaded(MODULE)


class Eyes:
    """Reads one event node by libevdev."""

    def __init__(self, node):
        self.fd = os.open(node, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        self.file = os.fdopen(self.fd, 'rb', buffering=0)
        self.device = libevdev.Device(self.file)
        self.seen = []

    def close(self):
        self.file.close()

    def _fill(self, timeout):
        poll = select.poll()
        poll.register(self.fd, select.POLLIN)
        if poll.poll(max(0, timeout * 1000)):
            self.seen += [(event.type.name, event.code.name, event.value)
                          for event in self.device.events()]

    def packet(self, timeout=2.0):
        """Events up to the next SYN_REPORT, without it; None if none comes in time."""
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


class Rig:
    """A virtual pendant that hid-xhc drives, and access to both its ends."""

    def __init__(self, model='HB04', device=None, **options):
        self.device = device or UhidPendant(model, **options)
        self.path = None
        self.eyes = None
        self.event_node = None
        self.hidraw_node = None

    # --- coming and going -----------------------------------------------------------------

    def plug(self, first_frame=True):
        """Plugs it in and waits until the driver has it (and the display its first frame)."""
        frames = self.device.frame_count
        self.device.plug()
        self.path = find.wait(self._driven, 10)
        if not self.path:
            raise AssertionError('hid-xhc does not bind to %s' % self.device.phys)
        if not find.wait(self._nodes, 10):
            raise AssertionError('no event or hidraw node for %s' % self.device.phys)
        self.eyes = Eyes(self.event_node)
        if first_frame and not self.device.wait_frames(frames + 1):
            raise AssertionError('no first frame')
        return self

    def _driven(self):
        path = find.hid_directory(self.device.phys)
        if path and find.driver(path) == 'hid-xhc' and os.path.exists(path + '/dro/flush'):
            return path
        return None

    def _nodes(self):
        self.event_node, self.hidraw_node = find.nodes(self.path)
        return (self.event_node and os.path.exists(self.event_node) and
                self.hidraw_node and os.path.exists(self.hidraw_node))

    def look_again(self):
        """Opens the event node anew: libevdev reads the keymap and the state only then."""
        self.eyes.close()
        self.eyes = Eyes(self.event_node)

    def unplug(self):
        if self.eyes:
            self.eyes.close()
            self.eyes = None
        self.device.detach()
        if self.path and not find.wait(lambda: not os.path.exists(self.path), 10):
            raise AssertionError('%s does not go away' % self.path)
        self.path = None

    def unbind(self):
        write_file(DRIVER_DIR + '/unbind', os.path.basename(self.path))

    def bind(self):
        write_file(DRIVER_DIR + '/bind', os.path.basename(self.path))

    # --- sysfs ----------------------------------------------------------------------------

    def file(self, name):
        """dro/work_x, stats/reports, awake: work_x and reports will do."""
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
        """-> name of the error that the write ends with, or None"""
        try:
            self.set(name, text)
        except OSError as error:
            return errno.errorcode[error.errno]
        return None

    # --- display --------------------------------------------------------------------------

    def flush(self):
        """Sends a frame and waits for it; -> what the LCD shows"""
        frames = self.device.frame_count
        self.set('flush', '1')
        if not self.device.wait_frames(frames + 1):
            raise AssertionError('flush sent no frame')
        self.settle(0.02)           # a gadget sees requests by usbmon, a moment later
        return self.device.lcd.as_dict()

    def shows(self, name, value, timeout=3.0):
        """Waits until the LCD shows it; -> whether it does"""
        return self.device.wait_for(
            lambda: self.device.lcd and self.device.lcd.as_dict()[name] == value, timeout)

    def settle(self, quiet=0.3):
        """Waits until no frame has come for a while; -> how many have come in all"""
        count = self.device.frame_count
        while self.device.wait_frames(count + 1, quiet):
            count = self.device.frame_count
        return count

    # --- pendant --------------------------------------------------------------------------

    def report(self, key1=0, key2=0, selector=0, wheel=0, day=None):
        """One good input report, with the day of the last frame unless another is given."""
        day = self.device.pendant.day if day is None else day
        self.device.report(bytes([4, key1, key2, selector, wheel & 0xFF, day ^ key1]))

    def asleep(self):
        self.device.report(bytes([4, 0, 0, 0, 0, 0]))

    def packet(self, timeout=2.0):
        return self.eyes.packet(timeout)


def released(scan, name=None):
    return [('EV_MSC', 'MSC_SCAN', scan), ('EV_KEY', name or KEY[scan], 0)]


def pressed(scan, name=None):
    return [('EV_MSC', 'MSC_SCAN', scan), ('EV_KEY', name or KEY[scan], 1)]


def selected(was, now):
    """What a turn of the selector gives, by number of position."""
    events = [('EV_ABS', 'ABS_MISC', now)]
    if was:
        events.append(('EV_KEY', KEY[30 + was], 0))
    if now:
        events.append(('EV_KEY', KEY[30 + now], 1))
    return events


def turned(detents):
    return [('EV_REL', 'REL_DIAL', detents)]


class Case(case.Case):
    """A test with the driver loaded; what it plugs in is unplugged behind it."""

    def set_up(self):
        if not loaded():
            load()

    def plug(self, model='HB04', first_frame=True, **options):
        return self.plug_rig(Rig(model, **options), first_frame)

    def plug_usb(self, model='HB04', first_frame=True, **options):
        return self.plug_rig(Rig(device=UsbPendant(model, **options)), first_frame)

    def plug_rig(self, rig, first_frame=True):
        self.add_cleanup(rig.unplug)
        return rig.plug(first_frame)

    def assert_packet(self, rig, events):
        """The next SYN_REPORT brings exactly these events."""
        assert rig.packet() == events

    def assert_silent(self, rig, seconds=0.15):
        """No event comes; a report that must make one proves that the node is alive."""
        packet = rig.packet(seconds)
        assert packet is None


class KernelLog:
    """What the kernel says from now on."""

    def __init__(self):
        self.fd = os.open('/dev/kmsg', os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        os.lseek(self.fd, 0, os.SEEK_END)

    def lines(self):
        """Messages since the last call."""
        found = []
        while True:
            try:
                record = os.read(self.fd, 8192).decode(errors='replace')
            except BlockingIOError:
                return found
            except BrokenPipeError:             # the ring overtook us
                continue
            found.append(record.partition(';')[2].split('\n')[0])

    def close(self):
        os.close(self.fd)
