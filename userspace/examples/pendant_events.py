#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""pendant_events.py [NODE]: print what is done on an XHC pendant, one line per event.

Requires python3-evdev. NODE is /dev/input/event<n>; the default is the first pendant. A button is
printed by its scan code, which is the same whatever layout has been chosen.
"""

import argparse
import sys

import evdev
from evdev import ecodes

# of the selector, by value of ABS_MISC
POSITIONS = ('off', 'X', 'Y', 'Z', 'A', 'feed', 'spindle', 'B', 'C')


def find():
    """The first pendant"""
    for path in sorted(evdev.list_devices(), key=lambda path: (len(path), path)):
        device = evdev.InputDevice(path)
        if device.name.startswith('XHC '):
            return device
        device.close()
    sys.exit('no pendant: is it plugged in, and are you in the group dialout?')


def model(device):
    """HB03, HB04 or WHB04B"""
    return device.name.split()[1]


def rotaries(device):
    """Where they are now"""
    values = {code: info.value for code, info in device.capabilities()[ecodes.EV_ABS]}
    yield 'selector', POSITIONS[values[ecodes.ABS_MISC]]
    if ecodes.ABS_THROTTLE in values:           # the second one of a WHB04B
        yield 'rotary', values[ecodes.ABS_THROTTLE]


def actions(device):
    """Yields ('selector', 'X'), ('rotary', 3), ('press', 0x0d), ('release', 0x0d), ('wheel', -2)"""
    yield from rotaries(device)
    scan = 0
    for event in device.read_loop():
        if event.type == ecodes.EV_MSC and event.code == ecodes.MSC_SCAN:
            scan = event.value
        elif event.type == ecodes.EV_KEY and scan:      # the selector's have no scan code
            yield ('press' if event.value else 'release'), scan
            scan = 0
        elif event.type == ecodes.EV_REL and event.code == ecodes.REL_DIAL:
            yield 'wheel', event.value
        elif event.type == ecodes.EV_ABS and event.code == ecodes.ABS_MISC:
            yield 'selector', POSITIONS[event.value]
        elif event.type == ecodes.EV_ABS and event.code == ecodes.ABS_THROTTLE:
            yield 'rotary', event.value
        elif event.type == ecodes.EV_SYN:
            scan = 0                                    # its key was in the same report
            if event.code == ecodes.SYN_DROPPED:
                yield from rotaries(device)             # this program was too slow


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('node', nargs='?', metavar='NODE')
    options = parser.parse_args()
    device = evdev.InputDevice(options.node) if options.node else find()
    print(device.name, device.path, flush=True)
    try:
        for what, value in actions(device):
            print(what, '%02xh' % value if what in ('press', 'release') else value, flush=True)
    except OSError:
        sys.exit('the pendant is gone')
    except KeyboardInterrupt:
        pass


if __name__ == '__main__':
    main()
