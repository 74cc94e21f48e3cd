# SPDX-License-Identifier: GPL-2.0-only
"""Script mode: one command a line."""

import math

from . import faults, wire
from .line import LineError
from .simulator import Timeout

# The table that --help prints and that the manual page describes.
COMMANDS = (
    ('vendor|model|firmware|serial TEXT', 'say who the head is, "-" to report it no more'),
    ('temp COMPONENT DEGREES|absent', 'set and send the temperatures'),
    ('error COMPONENT NAME|CODE|absent', 'set and send the error states'),
    ('hours COMPONENT HOURS|absent', 'set and send the hours'),
    ('frame-errors AXIS COUNT', 'set and send the frame error counts'),
    ('debug TEXT', 'send a debug packet'),
    ('sync', 'send a sync packet'),
    ('report', 'send a round of everything, between two sync packets'),
    ('packet TYPE [HEX]', 'send a packet of any type, 0..255, with any payload'),
    ('raw HEX', 'send these bytes, whatever they are'),
    ('order little|big', 'the byte order of what follows'),
    ('rate BITS', "the head's own rate: 57600 115200 230400 460800 921600"),
    ('uart BITS|auto', 'the rate at which the host listens, where the line does not know it'),
    ('interval SECONDS', 'time between rounds, 0 for none'),
    ('sync-interval SECONDS', 'time between sync packets, 0 for none'),
    ('fault KIND off|once|always|N|1/N', 'switch a fault; "fault off" ends them all'),
    ('silence [SECONDS|off]', 'send nothing, for so long or until "silence off"'),
    ('stream N', 'send N packets as fast as they are taken'),
    ('bytes N', 'the same until N bytes are reached, in whole packets'),
    ('wait open|closed|sent', 'until the line is open, is closed, has taken everything'),
    ('sleep SECONDS|forever', 'do nothing but what the intervals say'),
    ('counts', 'print everything counted, one line of JSON'),
    ('zero', 'count from 0 again, except what the receiver has'),
    ('echo TEXT', 'print a line'),
    ('quit', 'end here, successfully'),
)


class ScriptError(Exception):
    """The script cannot be understood."""


class Failure(Exception):
    """The script was understood, and something in it failed."""


class Runner:
    """Runs commands on a Simulator.

    say(event, **members) prints something; timeout: seconds that anything may take.
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
                raise ValueError('no command "%s"' % command)
            call = parse(rest)
        except (ValueError, LineError) as error:
            raise ScriptError('%s: %s' % (where, error)) from None
        return '%s: %s' % (where, line.strip()), call

    @staticmethod
    def run(step):
        """-> whether to go on; Failure if the step fails"""
        where, call = step
        try:
            return call() is not QUIT
        except BrokenPipeError:
            raise                           # nobody reads what is printed
        except (OSError, LineError, Timeout) as error:
            raise Failure('%s: %s' % (where, error)) from None

    # --- what the head knows --------------------------------------------------------------

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
            raise ValueError('a temperature is -327.68 to 327.67 degrees')
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

    # --- what it sends --------------------------------------------------------------------

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

    # --- how it sends ---------------------------------------------------------------------

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
        raise ValueError('%s wanted' % form)
    return words


def _nothing(rest):
    if rest:
        raise ValueError('nothing is wanted here: "%s"' % rest)


def _known(word, words):
    if word not in words:
        raise ValueError('"%s" is none of: %s' % (word, ' '.join(words)))


def _number(text):
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError('"%s" is no number' % text)
    return number


def _seconds(text):
    seconds = _number(text)
    if seconds < 0:
        raise ValueError('a time is not negative')
    return seconds


def _integer(text, least, most=math.inf):
    try:
        number = int(text, 0)
    except ValueError:
        raise ValueError('"%s" is no number' % text) from None
    if not least <= number <= most:
        raise ValueError('%s is not in %s..%s' % (text, least, most))
    return number


def _hex(text, least, most):
    data = bytes.fromhex(text)
    if not least <= len(data) <= most:
        raise ValueError('%d bytes, not %s to %s' % (len(data), least, most))
    return data
