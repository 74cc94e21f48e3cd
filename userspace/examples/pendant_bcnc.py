#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""pendant_bcnc.py [-n] [-u URL] [NODE]: jog a Grbl machine with an XHC pendant, through bCNC.

Requires python3-evdev, and bCNC with its web pendant (`bCNC --pendant 8080`), which takes G-code
and bCNC's own commands by HTTP. The wheel moves the axis that the selector points to; nothing moves
while it is off, or while bCNC's controller is neither idle nor jogging. This is not an emergency
stop.
"""

import argparse
import json
import sys
import time
import urllib.parse
import urllib.request

import evdev
import pendant_events

FEED = 1000                     # mm or degrees per minute, of each jog
LAG = 0.25                      # seconds that the machine may be behind the wheel
STEPS = (0.01, 0.1, 1.0)        # mm or degrees per detent, for the step buttons
ROTARY = {1: 0.001, 2: 0.01, 3: 0.1, 4: 1.0}    # the same by the WHB04B's second rotary
AXES = {'HB03': 'XYZ', 'HB04': 'XYZA', 'WHB04B': 'XYZABC'}      # its A is a speed on the HB03
# By model, for what is printed on its buttons. HB04 is that with 18 keys; with 16 keys Stop is 01h.
STEP_BUTTONS = {'HB03': {0x0D: -1, 0x0E: 1}, 'HB04': {0x0D: 1}, 'WHB04B': {}}
COMMANDS = {
    'HB03': {0x01: 'FEEDHOLD', 0x02: 'PAUSE'},
    'HB04': {0x16: 'FEEDHOLD', 0x02: 'PAUSE', 0x17: 'RESET'},
    'WHB04B': {0x02: 'FEEDHOLD', 0x03: 'PAUSE', 0x01: 'RESET'},
}


class Bcnc:
    def __init__(self, url):
        self.url = url

    def get(self, page):
        with urllib.request.urlopen(self.url + page, timeout=2) as answer:
            return answer.read()

    def ready(self):
        return json.loads(self.get('/state'))['state'] in ('Idle', 'Jog')

    def send(self, **what):
        self.get('/send?' + urllib.parse.urlencode(what))


class Printer:
    """In place of bCNC: nothing moves."""

    def ready(self):
        return True

    def send(self, **what):
        print(*('%s %s' % item for item in what.items()), flush=True)


class Jogger:
    def __init__(self, model, bcnc, clock=time.monotonic):
        self.model, self.bcnc, self.clock = model, bcnc, clock
        self.axis, self.step = None, STEPS[0]
        self.done = 0           # when the machine has made all jogs

    def act(self, what, value):
        if what == 'selector':
            self.axis = value if value in AXES[self.model] else None
        elif what == 'rotary':
            self.step = ROTARY.get(value)
        elif what == 'wheel' and self.axis and self.step:
            self.jog(value * self.step)
        elif what == 'press' and value in STEP_BUTTONS[self.model]:
            number = STEPS.index(self.step) + STEP_BUTTONS[self.model][value]
            self.step = STEPS[number % len(STEPS)]
        elif what == 'press' and value in COMMANDS[self.model]:
            self.bcnc.send(cmd=COMMANDS[self.model][value])

    def jog(self, distance):
        """Counts of a wheel that is too fast are dropped, so that the machine stops with it."""
        now = self.clock()
        if self.done > now + LAG or not self.bcnc.ready():
            return
        self.done = max(self.done, now) + abs(distance) / FEED * 60
        self.bcnc.send(gcode='$J=G91 G21 %s%.3f F%d' % (self.axis, distance, FEED))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('-n', '--dry-run', action='store_true', help='print what would be sent')
    parser.add_argument('-u', '--url', default='http://localhost:8080', help='of the web pendant')
    parser.add_argument('node', nargs='?', metavar='NODE')
    options = parser.parse_args()
    device = evdev.InputDevice(options.node) if options.node else pendant_events.find()
    jogger = Jogger(pendant_events.model(device), Printer() if options.dry_run else
                    Bcnc(options.url.rstrip('/')))
    try:
        for what, value in pendant_events.actions(device):
            jogger.act(what, value)
    except OSError as error:            # no pendant any more, or no bCNC
        sys.exit('pendant_bcnc.py: %s' % error)
    except KeyboardInterrupt:
        pass


if __name__ == '__main__':
    main()
