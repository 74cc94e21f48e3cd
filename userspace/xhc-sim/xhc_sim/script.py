# SPDX-License-Identifier: GPL-2.0-only
"""Script mode: one command per line, checked as a whole before the first one runs."""

import time

from .lcd import normal_number
from .models import MODELS
from .pendant import Fault
from .whb04b import LEAD, LEAD_ON_OTHERS

# The table that --help prints and that the manual page describes.
COMMANDS = (
    ('key NAME|CODE down|up|press', 'hold a key, release it, or both (label, Fn+label, or 0x17)'),
    ('select POSITION|CODE', 'turn the selector: off x y z a b c feed spindle speed, or 0x11'),
    ('feed POSITION|CODE', 'turn the second rotary: 2% 5% 10% 30% 60% 100% lead, or 0x0d'),
    ('lead CODE', 'set the code that this unit has for Lead: 0x1c or 0x9b'),
    ('wheel COUNT', 'turn the wheel by COUNT detents in one report, -128..127'),
    ('sleep, wake', 'fall asleep, wake'),
    ('radio off|on', 'move the pendant out of range or back: reports and frames are lost'),
    ('report HEX', 'send these bytes, unchecked, as an input report'),
    ('wait MS|forever', 'wait'),
    ('lcd', 'print what the LCD shows'),
    ('expect FIELD VALUE', 'wait for the value of the field, fail after the timeout'),
    ('unplug, plug', 'unplug the cable, plug it in'),
    ('fault KIND [SKIP [COUNT]]', 'fault of display requests: none stall timeout slow:MS unplug'),
    ('echo TEXT', 'print a line'),
    ('quit', 'end the script with success'),
)

PRESS_TIME = 0.02           # seconds between down and up of a "press"
PENDANT_FIELDS = ('frames', 'awake', 'selector', 'model')
PICTURES = tuple({model.picture: None for model in MODELS.values()})
POSITIONS = {name for picture in PICTURES for name in picture.POSITIONS}
GROUPS = {picture.GROUP: picture.POSITIONS for picture in PICTURES}     # positions, all as one


def expect_fields(model):
    """The fields of a model."""
    return model.picture.FIELDS + PENDANT_FIELDS + (('feed',) if model.feed else ())


EXPECT_FIELDS = tuple(dict.fromkeys(
    name for model in MODELS.values() for name in expect_fields(model)))


class ScriptError(Exception):
    """The script is invalid."""


class Failure(Exception):
    """A command of a valid script failed."""


class Runner:
    """Runs scripts on a VirtualPendant.

    show(fields) prints the LCD, say(text) a line; timeout: seconds that "expect" waits.
    """

    def __init__(self, device, show, say, timeout=2.0):
        self.device = device
        self.show = show
        self.say = say
        self.timeout = timeout

    def parse(self, text, name='script'):
        """-> steps for run(); ScriptError if any line is wrong"""
        steps = []
        for number, line in enumerate(text.splitlines(), 1):
            words = line.split()
            if not words or words[0].startswith('#'):
                continue
            try:
                call = self._parse(words)
            except ValueError as error:
                raise ScriptError('%s:%d: %s' % (name, number, error)) from None
            steps.append(('%s:%d: %s' % (name, number, line.strip()), call))
        return steps

    @staticmethod
    def run(steps):
        """Failure at the first step that fails."""
        for where, call in steps:
            if call is None:
                return
            try:
                call()
            except (OSError, Failure) as error:
                raise Failure('%s: %s' % (where, error)) from None

    def _parse(self, words):
        """-> something to call, None for "quit"; ValueError if the line is wrong"""
        command, arguments = words[0].lower(), words[1:]
        if command == 'quit':
            _count(arguments, 0)
            return None
        parse = getattr(self, '_parse_' + command, None)
        if parse is None:
            raise ValueError('unknown command: %s' % words[0])
        return parse(arguments)

    # --- hands ----------------------------------------------------------------------------

    def _parse_key(self, arguments):
        if len(arguments) < 2 or arguments[-1] not in ('down', 'up', 'press'):
            raise ValueError('key NAME|CODE down|up|press')
        codes = self.device.model.key_codes(' '.join(arguments[:-1]))
        if 0 in codes:
            raise ValueError('key code 0 means "no key"')
        action = arguments[-1]
        if action == 'down':
            return lambda: self._down(codes)
        if action == 'up':
            return lambda: self._up(codes)
        return lambda: self._press(codes)

    def _down(self, codes):
        for code in codes:
            self.device.press(code)

    def _up(self, codes):
        for code in reversed(codes):
            self.device.release(code)

    def _press(self, codes):
        self._down(codes)
        time.sleep(PRESS_TIME)
        self._up(codes)

    def _parse_select(self, arguments):
        _count(arguments, 1)
        code = self.device.model.selector_code(arguments[0])
        return lambda: self.device.select(code)

    def _parse_feed(self, arguments):
        _count(arguments, 1)
        code = self.device.model.feed_code(arguments[0])
        return lambda: self.device.turn_feed(code)

    def _parse_lead(self, arguments):
        _count(arguments, 1)
        code = self.device.model.feed_code(arguments[0])
        if code not in (LEAD, LEAD_ON_OTHERS):
            raise ValueError('lead %#04x|%#04x' % (LEAD, LEAD_ON_OTHERS))
        return lambda: setattr(self.device.pendant, 'lead', code)

    def _parse_wheel(self, arguments):
        _count(arguments, 1)
        detents = int(arguments[0])
        if not -128 <= detents <= 127:
            raise ValueError('the wheel reports -128..127, not %d' % detents)
        return lambda: self.device.turn(detents)

    def _parse_sleep(self, arguments):
        _count(arguments, 0)
        return self.device.sleep

    def _parse_wake(self, arguments):
        _count(arguments, 0)
        return self.device.wake

    def _parse_radio(self, arguments):
        _count(arguments, 1)
        if arguments[0] not in ('off', 'on'):
            raise ValueError('radio off|on')
        return lambda: setattr(self.device, 'radio', arguments[0] == 'on')

    def _parse_report(self, arguments):
        data = bytes.fromhex(' '.join(arguments))
        if not data:
            raise ValueError('report HEX')
        return lambda: self.device.report(data)

    # --- cable ----------------------------------------------------------------------------

    def _parse_plug(self, arguments):
        _count(arguments, 0)
        return self.device.plug

    def _parse_unplug(self, arguments):
        _count(arguments, 0)
        return self.device.unplug

    def _parse_fault(self, arguments):
        if not 1 <= len(arguments) <= 3:
            raise ValueError('fault KIND [SKIP [COUNT]]')
        numbers = [int(word) for word in arguments[1:]]
        if any(number < 0 for number in numbers):
            raise ValueError('SKIP and COUNT must not be negative')
        Fault(arguments[0])                     # ValueError for an unknown kind
        return lambda: self.device.set_fault(arguments[0], *numbers)

    # --- time and text --------------------------------------------------------------------

    def _parse_wait(self, arguments):
        _count(arguments, 1)
        if arguments[0] == 'forever':
            return lambda: self._wait(float('inf'))
        milliseconds = int(arguments[0])
        if milliseconds < 0:
            raise ValueError('wait: the time must not be negative')
        return lambda: self._wait(milliseconds / 1000)

    def _wait(self, seconds):
        """Waits; a pendant that is not operated falls asleep meanwhile."""
        end = time.monotonic() + seconds
        while True:
            left = end - time.monotonic()
            if left <= 0:
                return
            time.sleep(min(left, 0.1))
            if self.device.plugged and self.device.pendant.sleepy():
                self.device.sleep()

    def _parse_lcd(self, arguments):
        _count(arguments, 0)
        return self.show

    def _parse_echo(self, arguments):
        return lambda: self.say(' '.join(arguments))

    # --- expectations ---------------------------------------------------------------------

    def _parse_expect(self, arguments):
        fields = expect_fields(self.device.model)
        if len(arguments) < 2 or arguments[0] not in fields:
            raise ValueError('expect FIELD VALUE; fields: %s' % ' '.join(fields))
        field, wanted = arguments[0], ' '.join(arguments[1:])
        self._comparable(field, wanted)         # ValueError for a value that can never match
        return lambda: self._expect(field, wanted)

    def _expect(self, field, wanted):
        goal = self._comparable(field, wanted)
        if not self.device.wait_for(lambda: self._now(field) == goal, self.timeout):
            raise Failure('it is %s' % self._value(field))

    def _now(self, field):
        value = self._value(field)
        return None if value is None else self._comparable(field, value)

    def _value(self, field):
        """A field's present value as text, None while the LCD is blank."""
        device = self.device
        if field == 'frames':
            return str(device.frame_count)
        if field == 'awake':
            return 'yes' if device.pendant.awake else 'no'
        if field == 'selector':
            return device.model.selector_name(device.pendant.selector)
        if field == 'feed':
            return device.model.feed_name(device.pendant.feed)
        if field == 'model':
            return device.model.name
        if device.seen is None:
            return None
        fields = device.seen.as_dict()
        if field in GROUPS:
            return ' '.join(fields[name] for name in GROUPS[field])
        if field == 'faults':
            return ', '.join(fields['faults']) or 'none'
        return str(fields[field])

    @staticmethod
    def _comparable(field, text):
        if field in POSITIONS:
            return normal_number(text)
        if field in GROUPS:
            values = [normal_number(word) for word in text.split()]
            if len(values) != len(GROUPS[field]):
                raise ValueError('%s: %d values' % (field, len(GROUPS[field])))
            return values
        if field == 'state':
            return sorted(text.lower().split('+'))
        return text.lower()


def _count(arguments, wanted):
    if len(arguments) != wanted:
        raise ValueError('%d arguments required, not %d' % (wanted, len(arguments)))
