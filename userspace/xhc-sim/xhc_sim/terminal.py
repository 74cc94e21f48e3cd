# SPDX-License-Identifier: GPL-2.0-only
"""Interactive mode: an 80x24 terminal shows the pendant, and its keys operate it."""

import os
import select
import termios
import time
import tty

from . import find

CLICK = 0.15                # seconds that a pressed key stays down
REFRESH = 0.2
LETTERS = 'abcdefghijklmnoprtvwxyz'         # without s, u and q, which are commands
FAULTS = ('none', 'stall', 'timeout')
WIDTH, HEIGHT = 80, 24

# Input of the terminal -> (action, amount)
KEYS = {
    '\x1b[C': ('wheel', 1), '\x1b[D': ('wheel', -1),
    '\x1bOC': ('wheel', 1), '\x1bOD': ('wheel', -1),
    '\x1b[6~': ('wheel', 10), '\x1b[5~': ('wheel', -10),
    '\x1b[A': ('select', 1), '\x1b[B': ('select', -1),
    '\x1bOA': ('select', 1), '\x1bOB': ('select', -1),
    '+': ('feed', 1), '=': ('feed', 1), '-': ('feed', -1),
    's': ('sleep', 0), 'u': ('cable', 0), '!': ('fault', 0), '~': ('radio', 0),
    'q': ('quit', 0), '\x03': ('quit', 0),
}
HELP = (
    'left/right wheel 1   PgUp/PgDn wheel 10   up/down selector   letter press a key',
    'capital letter hold/release   s sleep   u unplug   ! fault   ~ radio   q quit',
)


class Terminal:
    """Runs a plugged VirtualPendant from a terminal until q."""

    def __init__(self, device, source=0, sink=1):
        self.device = device
        self.source = source
        self.sink = sink
        self.message = ''
        self.releases = []                  # (time, code) of keys to release
        self.caps = dict(zip(LETTERS, sorted(device.model.keys)))
        self.detents = 0
        self.drawn = None
        self.driver_text = ''
        self.driver_looked = 0.0

    def run(self):
        saved = termios.tcgetattr(self.source)
        try:
            tty.setraw(self.source)
            self._write('\x1b[?25l\x1b[2J')
            self._loop()
        finally:
            termios.tcsetattr(self.source, termios.TCSADRAIN, saved)
            self._write('\x1b[?25h\x1b[%d;1H\r\n' % HEIGHT)

    def _loop(self):
        while True:
            self._draw()
            ready, _, _ = select.select([self.source], [], [], self._pause())
            if ready:
                typed = os.read(self.source, 64).decode('ascii', 'replace')
                if not typed:
                    return
                for key in split_keys(typed):
                    if not self._safely(self.key, key):
                        return
            self._safely(self.passing)

    def _pause(self):
        """Seconds until the next action without a key."""
        if not self.releases:
            return REFRESH
        return max(0.0, min(REFRESH, self.releases[0][0] - time.monotonic()))

    def _safely(self, call, *arguments):
        """A removed pendant is reported, not fatal; -> False to end"""
        try:
            return call(*arguments) is not False
        except OSError as error:
            self.message = str(error)
            return True

    # --- actions --------------------------------------------------------------------------

    def key(self, key):
        """Performs the action of a terminal key; False for quit."""
        self.message = ''
        device = self.device
        what, amount = KEYS.get(key, (None, 0))
        if what == 'quit':
            return False
        if what == 'cable':
            self._cable()
        elif what == 'fault':
            device.fault = FAULTS[(FAULTS.index(device.fault) + 1) % len(FAULTS)]
        elif what == 'radio':
            device.radio = not device.radio
        elif key.lower() in self.caps or what:
            if not device.plugged:
                self.message = 'unplugged: press u'
            elif what == 'wheel':
                self.detents += amount
                device.turn(amount)
            elif what == 'select':
                device.select(next_code(device.model.selector, device.pendant.selector, amount))
            elif what == 'feed':
                self._turn_feed(amount)
            elif what == 'sleep':
                device.sleep() if device.pendant.awake else device.wake()
            else:
                self._cap(key)
        return True

    def _cable(self):
        if self.device.plugged:
            self.device.unplug()
            self.releases.clear()
            self.device.pendant.slots = [0, 0]
        else:
            self.device.plug()

    def _turn_feed(self, step):
        model, pendant = self.device.model, self.device.pendant
        if model.feed:
            self.device.turn_feed(next_code(model.feed, pendant.feed, step))

    def _cap(self, key):
        code = self.caps[key.lower()]
        held = code in self.device.pendant.slots
        if key.isupper() and held:
            self.device.release(code)
        elif not held:
            self.device.press(code)
            if key.islower():
                self.releases.append((time.monotonic() + CLICK, code))

    def passing(self):
        """Timed actions: keys are released, the pendant falls asleep."""
        now = time.monotonic()
        while self.releases and self.releases[0][0] <= now:
            _, code = self.releases.pop(0)
            self.device.release(code)
        if self.device.plugged and self.device.pendant.sleepy(now):
            self.device.sleep()

    # --- picture --------------------------------------------------------------------------

    def _draw(self):
        picture = self.picture()
        if picture != self.drawn:
            self.drawn = picture
            self._write('\x1b[H' + '\r\n'.join(line + '\x1b[K' for line in picture))

    def picture(self):
        """The screen: at most HEIGHT lines of at most WIDTH characters."""
        device, model = self.device, self.device.model
        lines = ['xhc-sim   %s 10ce:%04x   %s' % (model.name, model.product, self._whereabouts()),
                 '']
        lines += ['    ' + line for line in device.screen()]
        lines += ['', 'selector  ' + positions(model.selector, device.pendant.selector)]
        if model.feed:
            lines.append('-/+       ' + positions(model.feed, device.pendant.feed))
        lines += ['wheel     %+d' % self.detents, '']
        lines += self._key_rows()
        lines += ['', 'frames %d   fault %s%s   %s' % (
            device.frame_count, device.fault, '' if device.radio else '   out of range',
            self.message)]
        lines += HELP
        return [line[:WIDTH] for line in lines]

    def _key_rows(self):
        """The keys, column by column; a held one in brackets."""
        cells = []
        for letter, code in self.caps.items():
            form = '%s [%s]' if code in self.device.pendant.slots else '%s  %s '
            cells.append('%-20s' % (form % (letter, self.device.model.keys[code])))
        rows = -(-len(cells) // 4)
        return [''.join(cells[row::rows]) for row in range(rows)]

    def _whereabouts(self):
        """The driver of the pendant; looked up once per second."""
        if not self.device.plugged:
            return 'unplugged'
        now = time.monotonic()
        if now - self.driver_looked > 1:
            self.driver_looked = now
            self.driver_text = whereabouts(self.device.phys)
        return self.driver_text

    def _write(self, text):
        data = text.encode()
        while data:
            data = data[os.write(self.sink, data):]


def positions(rotary, here):
    """The positions of a rotary switch; the current one in brackets."""
    return ' '.join(('[%s]' if code == here else ' %s ') % name for name, code in rotary.items())


def next_code(rotary, here, step):
    """The code of a rotary switch after a turn, limited to its ends."""
    codes = list(rotary.values())
    index = codes.index(here) if here in codes else 0
    return codes[max(0, min(len(codes) - 1, index + step))]


def whereabouts(phys):
    directory = find.hid_directory(phys)
    if directory is None:
        return 'not enumerated yet'
    event, hidraw = find.nodes(directory)
    return 'driver %s   %s' % (find.driver(directory) or 'none',
                               ' '.join(node for node in (event, hidraw) if node))


def split_keys(typed):
    """Splits input into characters and escape sequences."""
    keys = []
    while typed:
        known = next((seq for seq in KEYS if len(seq) > 1 and typed.startswith(seq)), typed[0])
        keys.append(known)
        typed = typed[len(known):]
    return keys
