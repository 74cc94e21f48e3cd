# SPDX-License-Identifier: GPL-2.0-only
"""The pendant's display: its directory in sysfs, and the text that its attributes take."""

import errno
import math
import os
import time

DRIVER = '/sys/bus/hid/drivers/hid-xhc'
AXES = 'xyz'
FARTHEST = 65535.99         # what every model can show
GREATEST = 65535
UDEV_TIME = 5.0             # seconds until the group may write, at the latest


def find(models, phys=None, driver=DRIVER):
    """The directory of the first pendant of one of these models, with `phys` of that whose HID_PHYS
    this is; None without one.
    """
    try:
        names = sorted(os.listdir(driver))
    except OSError:
        return None
    for name in names:
        path = os.path.join(driver, name)
        if os.path.isdir(path + '/dro') and _model(path) in models and phys in (None, _phys(path)):
            return path
    return None


def _model(path):
    try:
        with open(path + '/model', encoding='ascii') as file:
            return file.read().strip()
    except OSError:
        return None             # it was unplugged in the meantime


def _phys(path):
    try:
        with open(path + '/uevent', encoding='utf-8', errors='replace') as uevent:
            for line in uevent:
                if line.startswith('HID_PHYS='):
                    return line.partition('=')[2].rstrip('\n')
    except OSError:
        pass                # it went away while we looked
    return None


def coordinate(value):
    """As far as the display goes; a position that is no number shows as 0."""
    if math.isnan(value):
        value = 0.0
    return '%.4f' % max(-FARTHEST, min(FARTHEST, value))


def number(value):
    """A whole number that the display takes."""
    if math.isnan(value):
        value = 0.0
    return '%d' % round(max(0, min(GREATEST, value)))


def multiplier(step, unit, available):
    """How many units a step has, if the display can say so, else 0"""
    times = step / unit if unit > 0 else 0
    nearest = round(times) if math.isfinite(times) else 0
    return str(nearest) if nearest in available and abs(times - nearest) < 1e-3 else '0'


def state(pins):
    """Words for the state; `pins` are by name."""
    if pins['paused']:
        words = ['pause']
    elif pins['running']:
        words = ['run']
    else:
        words = []
    if pins['inch']:
        words.append('inch')
    return '+'.join(words) or 'idle'


def texts(pins, unit, available):
    """-> attribute: text; `pins` are by name. The fourth axis has the row of X while selected."""
    fourth = pins['fourth']
    axes = fourth + 'yz' if fourth and pins['select-' + fourth] else AXES
    return {
        'position': ' '.join(coordinate(pins['%s-%s' % (system, axis)])
                             for system in ('work', 'machine') for axis in axes),
        'feedrate_override': number(100 * pins['feed-override']),
        'spindle_override': number(100 * pins['spindle-override']),
        'feedrate': number(60 * abs(pins['velocity'])),
        'spindle_speed': number(abs(pins['spindle-speed'])),
        'step': multiplier(pins['step'], unit, available),
        'state': state(pins),
    }


class Display:
    """The attributes of one pendant, each open for as long as it is plugged in."""

    def __init__(self, path, say):
        self.path = path
        self.model = _model(path)
        self.say = say
        self.files = {}
        self.shown = {}
        self.troubles = set()
        self.available = self._available()
        self.born = time.monotonic()

    def _available(self):
        try:
            with open(self.path + '/dro/step_available', encoding='ascii') as file:
                return [int(word) for word in file.read().split()]
        except (OSError, ValueError):
            return []

    def there(self):
        return os.path.isdir(self.path + '/dro')

    def show(self, wanted):
        """Writes what has changed; what cannot be written is tried again."""
        for name, text in wanted.items():
            if self.shown.get(name) == text:
                continue
            try:
                self._write(name, text)
            except OSError as error:
                self.shown.pop(name, None)
                self._complain(name, text, error)
            else:
                self.shown[name] = text

    def _write(self, name, text):
        if name not in self.files:
            self.files[name] = os.open('%s/dro/%s' % (self.path, name), os.O_WRONLY | os.O_CLOEXEC)
        os.pwrite(self.files[name], text.encode('ascii'), 0)

    def _complain(self, name, text, error):
        """Once for each attribute and error; a pendant that has gone is no trouble, nor is one that
        udevd has not come to yet."""
        if (name, error.errno) in self.troubles or not self.there():
            return
        if error.errno == errno.EACCES and time.monotonic() < self.born + UDEV_TIME:
            return
        self.troubles.add((name, error.errno))
        self.say('%s: %s: %s' % (name, text, error.strerror))

    def close(self):
        for file in self.files.values():
            os.close(file)
        self.files.clear()
