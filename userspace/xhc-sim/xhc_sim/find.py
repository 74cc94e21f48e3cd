# SPDX-License-Identifier: GPL-2.0-only
"""Find a virtual pendant: its sysfs directory, driver and nodes."""

import os
import time

HID_DEVICES = '/sys/bus/hid/devices'


def hid_directory(phys):
    """The HID device whose HID_PHYS is `phys`, or None."""
    try:
        names = os.listdir(HID_DEVICES)
    except OSError:
        return None
    for name in names:
        path = os.path.join(HID_DEVICES, name)
        try:
            with open(os.path.join(path, 'uevent'), encoding='utf-8', errors='replace') as uevent:
                if 'HID_PHYS=%s\n' % phys in uevent.read():
                    return os.path.realpath(path)
        except OSError:
            continue                    # removed meanwhile
    return None


def driver(directory):
    """Name of the driver that a HID device is bound to, or None."""
    try:
        return os.path.basename(os.readlink(os.path.join(directory, 'driver')))
    except OSError:
        return None


def nodes(directory):
    """-> (event node, hidraw node), each a path in /dev or None"""
    return (_node(os.path.join(directory, 'input'), 'event', '/dev/input/'),
            _node(directory, 'hidraw', '/dev/'))


def _node(directory, prefix, where):
    for path, names, _ in os.walk(directory):
        for name in names:
            if name.startswith(prefix) and name[len(prefix):].isdigit():
                return where + name
        if path.count(os.sep) > directory.count(os.sep) + 1:
            names.clear()
    return None


def wait(condition, timeout=5.0, pause=0.01):
    """Calls condition() until it is true or the timeout expires; -> its last value"""
    deadline = time.monotonic() + timeout
    while True:
        value = condition()
        if value or time.monotonic() >= deadline:
            return value
        time.sleep(pause)
