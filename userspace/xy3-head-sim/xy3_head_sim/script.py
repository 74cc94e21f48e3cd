# SPDX-License-Identifier: GPL-2.0-only
"""Script mode: one command per line."""

import math

from . import faults, wire
from .line import LineError
from .simulator import Timeout

# --help prints this table, and the manual page describes it.
COMMANDS = (
    ('vendor|model|firmware|serial TEXT', 'set and send the text, "-" to stop reporting it'),
    ('temp COMPONENT DEGREES|absent', 'set and send the temperatures'),
    ('error COMPONENT NAME|CODE|absent', 'set and send the error states'),
    ('hours COMPONENT HOURS|absent', 'set and send the hours'),
    ('frame-errors AXIS COUNT', 'set and send the frame error counts'),
    ('debug TEXT', 'send a debug packet'),
    ('sync', 'send a sync packet'),
    ('report', 'send a round of everything, between two sync packets'),
    ('packet TYPE [HEX]', 'send a packet of any type, 0..255, with any payload'),
    ('raw HEX', 'send these bytes, unchecked'),
    ('order little|big', 'set the byte order of numbers'),
    ('rate BITS', 'set the rate of the head: 57600 115200 230400 460800 921600'),
    ('uart BITS|auto', 'set the rate of the host, for lines that do not provide it'),
    ('interval SECONDS', 'set the time between rounds, 0 to disable'),
    ('sync-interval SECONDS', 'set the time between sync packets, 0 to disable'),
    ('fault KIND off|once|always|N|1/N', 'set a fault; "fault off" disables all faults'),
    ('silence [SECONDS|off]', 'send nothing for that time, or until "silence off"'),
    ('stream N', 'send N packets as fast as possible'),
    ('bytes N', 'the same until N bytes are reached, in complete packets'),
    ('wait open|closed|sent', 'wait until the line is open, is closed, all data are sent'),
    ('sleep SECONDS|forever', 'wait; only packets of the intervals are sent'),
    ('counts', 'print all counts as one line of JSON'),
    ('zero', 'reset the counts, except those of the receiver'),
    ('echo TEXT', 'print a line'),
    ('quit', 'end the script with success'),
)


class ScriptError(Exception):
    """The script is invalid."""


class Failure(Exception):
    """A command of a valid script failed."""


class Runner:
    """Runs commands on a Simulator.

    say(event, **members) prints an event; timeout: seconds for each command that waits.
    """

    def __init__(self, simulator, say, timeout=math.inf):
        self.simulator = simulator
        self.head = simulator.head
        self.say = say
        self.timeout = timeout

    def parse(self, line, where):
        """-> a step for run(), None for a blank line; ScriptError if the line is wrong"""
        words = line.split(None, 1)
        if not words or words[0].startswith('#'):
            return None
        command, rest = words[0].lower(), (words[1].strip() if len(words) > 1 else '')
        parse = getattr(self, '_parse_' + command.replace('-', '_'), None)
        try:
            if parse is None or '_' in command:
                raise ValueError('unknown command "%s"' % command)
            call = parse(rest)
        except (ValueError, LineError) as error:
            raise ScriptError('%s: %s' % (where, error)) from None
        return '%s: %s' % (where, line.strip()), call

    @staticmethod
    def run(step):
        """-> whether to continue; Failure if the step fails"""
        where, call = step
        try:
            return call() is not QUIT
        except BrokenPipeError:
            raise                           # the reader has closed the output
        except (OSError, LineError, Timeout) as error:
            raise Failure('%s: %s' % (where, error)) from None

    # --- state of the head ----------------------------------------------------------------

    def _text(self, name, rest):
        text = None if rest == '-' else rest
        if text is not None:
            getattr(wire, name)(text)
        return lambda: self._set(name, self.head.set_text, name, text)

    def _parse_vendor(self, rest):
        return self._text('vendor', rest)

    def _parse_model(self, rest):
        return self._text('model', rest)

    def _parse_firmware(self, rest):
        return self._text('firmware', rest)

    def _parse_serial(self, rest):
        return self._text('serial', rest)

    def _parse_temp(self, rest):
        component, value = _words(rest, 'COMPONENT DEGREES|absent')
        _known(component, wire.COMPONENTS)
        degrees = None if value == 'absent' else _number(value)
        if degrees is not None and not -327.68 <= degrees <= 327.67:
            raise ValueError('a temperature must be -327.68 to 327.67 degrees')
        return lambda: self._set('temperatures', self.head.set_temperature, component, degrees)

    def _parse_error(self, rest):
        component, value = _words(rest, 'COMPONENT NAME|CODE|absent')
        _known(component, wire.COMPONENTS)
        if value == 'absent':
            code = None
        elif value in wire.ERROR_NAMES:
            code = wire.error_code(value)
        else:
            code = _integer(value, 0, 255)
        return lambda: self._set('errors', self.head.set_error, component, code)

    def _parse_hours(self, rest):
        component, value = _words(rest, 'COMPONENT HOURS|absent')
        _known(component, wire.COMPONENTS)
        hours = None if value == 'absent' else _integer(value, 0, 0xFFFFFFFF)
        return lambda: self._set('hours', self.head.set_hours, component, hours)

    def _parse_frame_errors(self, rest):
        axis, value = _words(rest, 'AXIS COUNT')
        _known(axis, wire.AXES)
        count = _integer(value, 0, 0xFFFFFFFF)
        return lambda: self._set('frame_errors', self.head.set_frame_errors, axis, count)

    def _set(self, packet, setter, *arguments):
        setter(*arguments)
        self.head.report(packet)

    # --- packets --------------------------------------------------------------------------

    def _parse_debug(self, rest):
        packet = wire.debug(rest)
        return lambda: self.head.send(packet)

    def _parse_sync(self, rest):
        _nothing(rest)
        return lambda: self.head.report('sync')

    def _parse_report(self, rest):
        _nothing(rest)
        return self.head.report

    def _parse_packet(self, rest):
        kind, _, payload = rest.partition(' ')
        packet = wire.packet(_integer(kind, 0, 255), _hex(payload, 0, wire.MAX_PAYLOAD))
        return lambda: self.head.send(packet)

    def _parse_raw(self, rest):
        data = _hex(rest, 1, math.inf)
        return lambda: self.head.send_raw(data)

    def _parse_stream(self, rest):
        packets = _integer(rest, 1)
        return lambda: self.simulator.stream(packets=packets, timeout=self.timeout)

    def _parse_bytes(self, rest):
        size = _integer(rest, 1)
        return lambda: self.simulator.stream(size=size, timeout=self.timeout)

    # --- settings -------------------------------------------------------------------------

    def _parse_order(self, rest):
        _known(rest, ('little', 'big'))
        return lambda: self.head.set_order(rest)

    def _parse_rate(self, rest):
        _known(rest, list(map(str, wire.RATES)))
        return lambda: self.head.set_rate(int(rest))

    def _parse_uart(self, rest):
        rate = None if rest == 'auto' else _integer(rest, 1)
        return lambda: self.simulator.line.force_uart_rate(rate)

    def _parse_interval(self, rest):
        seconds = _seconds(rest)
        return lambda: self._interval(seconds, self.head.sync_interval)

    def _parse_sync_interval(self, rest):
        seconds = _seconds(rest)
        return lambda: self._interval(self.head.interval, seconds)

    def _interval(self, interval, sync_interval):
        self.head.interval, self.head.sync_interval = interval, sync_interval
        self.head.reschedule()

    def _parse_fault(self, rest):
        if rest == 'off':
            return self.head.faults.clear
        kind, how = _words(rest, 'KIND off|once|always|N|1/N')
        _known(kind, faults.KINDS)
        faults.parse_how(how)
        return lambda: self.head.faults.set(kind, how)

    def _parse_silence(self, rest):
        seconds = {'': math.inf, 'off': 0.0}.get(rest)
        if seconds is None:
            seconds = _seconds(rest)
        return lambda: self.head.silence(seconds)

    # --- time and text --------------------------------------------------------------------

    def _parse_wait(self, rest):
        simulator = self.simulator
        waits = {'open': simulator.wait_open, 'closed': simulator.wait_closed,
                 'sent': simulator.flush}
        _known(rest, waits)
        return lambda: waits[rest](self.timeout)

    def _parse_sleep(self, rest):
        seconds = math.inf if rest == 'forever' else _seconds(rest)
        return lambda: self.simulator.run(timeout=seconds)

    def _parse_counts(self, rest):
        _nothing(rest)
        return lambda: self.say('counts', **self.head.counts())

    def _parse_zero(self, rest):
        _nothing(rest)
        return self.head.forget_counts

    def _parse_echo(self, rest):
        return lambda: self.say('echo', text=rest)

    def _parse_quit(self, rest):
        _nothing(rest)
        return lambda: QUIT


QUIT = object()


def _words(rest, form):
    words = rest.split()
    if len(words) != len(form.split()):
        raise ValueError('%s required' % form)
    return words


def _nothing(rest):
    if rest:
        raise ValueError('unexpected argument: "%s"' % rest)


def _known(word, words):
    if word not in words:
        raise ValueError('"%s" must be one of: %s' % (word, ' '.join(words)))


def _number(text):
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError('"%s" is not a number' % text)
    return number


def _seconds(text):
    seconds = _number(text)
    if seconds < 0:
        raise ValueError('a time must not be negative')
    return seconds


def _integer(text, least, most=math.inf):
    try:
        number = int(text, 0)
    except ValueError:
        raise ValueError('"%s" is not a number' % text) from None
    if not least <= number <= most:
        raise ValueError('%s is out of range %s..%s' % (text, least, most))
    return number


def _hex(text, least, most):
    data = bytes.fromhex(text)
    if not least <= len(data) <= most:
        raise ValueError('%s to %s bytes required, not %d' % (least, most, len(data)))
    return data
