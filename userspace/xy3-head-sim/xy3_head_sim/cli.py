# SPDX-License-Identifier: GPL-2.0-only
"""The command xy3-head-sim."""

import argparse
import json
import math
import os
import signal
import sys

from . import VERSION, faults, head, line, wire
from .script import COMMANDS, Failure, Runner, ScriptError
from .simulator import Simulator, Timeout

OK, FAILED, USAGE = 0, 1, 2
SCHEMA = 1                  # of JSON objects; incremented when a member is changed or removed
LAST_WORDS = 5.0            # seconds for the other end to read the remaining data

EPILOG = """script commands:
%s

faults, for the next packet (once), all, N packets, or one in N at random (1/N):
%s

components: %s
axes: %s
errors: %s, or a number

# starts a comment. A file is checked as a whole before its first command runs, standard
input line by line.

exit status: 0 success, 1 failure, 2 invalid usage or script
"""


class Wrong(Exception):
    """Invalid usage, found after the options were parsed."""


def number(least, whole=False):
    """A type for argparse: a finite number, at least least."""
    def read(text):
        value = int(text) if whole else float(text)
        if not math.isfinite(value) or value < least:
            raise ValueError
        return value
    read.__name__ = 'number'                # argparse prints it in its message
    return read


def fault(text):
    kind, _, how = text.partition('=')
    if kind not in faults.KINDS:
        raise argparse.ArgumentTypeError('unknown fault "%s"' % kind)
    try:
        faults.parse_how(how)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return kind, how


def identity(name):
    def read(text):
        try:
            if text:
                getattr(wire, name)(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None
        return text
    return read


def address(text):
    try:
        line.check_address(text)
    except line.LineError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return text


def make_parser():
    commands = '\n'.join('  %-34s %s' % row for row in COMMANDS)
    kinds = '\n'.join('  %-34s %s' % row for row in faults.KINDS.items())
    parser = argparse.ArgumentParser(
        prog='xy3-head-sim', formatter_class=argparse.RawDescriptionHelpFormatter,
        usage='%(prog)s [options]', allow_abbrev=False,
        description='Simulate the backchannel of an XY3-100 compatible scanhead on a pseudo\n'
                    'terminal, a socket, or a file.',
        epilog=EPILOG % (commands, kinds, ' '.join(wire.COMPONENTS), ' '.join(wire.AXES),
                         ' '.join(wire.ERROR_NAMES)))
    where = parser.add_mutually_exclusive_group()
    where.add_argument('-p', '--pty', action='store_true',
                       help='create a pseudo terminal and print its name (default)')
    where.add_argument('-c', '--connect', type=address, metavar='ADDRESS',
                       help='connect to unix:PATH, tcp:PORT or tcp:HOST:PORT of this machine')
    where.add_argument('-l', '--listen', type=address, metavar='ADDRESS',
                       help='listen at ADDRESS, for one connection at a time')
    where.add_argument('-o', '--output', metavar='FILE', help='write to a file, FIFO or tty')
    parser.add_argument('-L', '--link', metavar='PATH',
                        help='create a symbolic link to the pseudo terminal')
    parser.add_argument('-w', '--wait', type=number(0), default=5.0, metavar='SECONDS',
                        help='time for which --connect retries (default 5)')
    parser.add_argument('-P', '--pace', action='store_true',
                        help='send no faster than the rate of the head')
    parser.add_argument('-r', '--rate', type=int, choices=wire.RATES, default=wire.DEFAULT_RATE,
                        metavar='BITS', help='rate of the head (default 115200)')
    for name in head.TEXTS:
        parser.add_argument('--' + name, type=identity(name), metavar='TEXT',
                            help='%s of the head, not reported if empty' % name)
    parser.add_argument('--order', choices=('little', 'big'), default='little',
                        help='byte order of numbers (default little)')
    parser.add_argument('-i', '--interval', type=number(0), default=1.0, metavar='SECONDS',
                        help='time between rounds of telemetry (default 1), 0 to disable')
    parser.add_argument('-y', '--sync-interval', type=number(0), default=0.1, metavar='SECONDS',
                        help='time between sync packets (default 0.1), 0 to disable')
    parser.add_argument('-f', '--fault', type=fault, action='append', default=[],
                        metavar='KIND=HOW', help='enable a fault: once, always, N or 1/N')
    parser.add_argument('--seed', type=int, default=0, metavar='N',
                        help='seed of random faults (default 0)')
    traffic = parser.add_mutually_exclusive_group()
    traffic.add_argument('-n', '--stream', type=number(1, whole=True), metavar='N',
                         help='send N packets as fast as possible, print the counts')
    traffic.add_argument('-b', '--bytes', type=number(1, whole=True), metavar='N',
                         help='the same until N bytes are reached, in complete packets')
    traffic.add_argument('-s', '--script', metavar='FILE',
                         help='run commands from FILE, or from standard input if it is -')
    parser.add_argument('-x', '--exit', action='store_true',
                        help='exit after --stream or --bytes without waiting for the other end')
    parser.add_argument('-t', '--timeout', type=number(0), metavar='SECONDS',
                        help='timeout of streams and "wait" (default: none)')
    parser.add_argument('-j', '--json', action='store_true',
                        help='print all output as lines of JSON')
    parser.add_argument('-V', '--version', action='version', version='xy3-head-sim ' + VERSION)
    return parser


class Output:
    """Prints events as text or JSON."""

    def __init__(self, as_json):
        self.as_json = as_json

    def say(self, event, **members):
        if self.as_json or event == 'counts':
            text = json.dumps({'schema': SCHEMA, 'event': event, **members})
        elif event == 'echo':
            text = members['text']
        else:
            text = ' '.join([event] + [str(value) for value in members.values()])
        print(text, flush=True)


class Lines:
    """Standard input, line by line, while the simulator runs."""

    def __init__(self, simulator, fd):
        self.simulator = simulator
        self.fd = fd
        self.ended = False
        self._text = b''
        simulator.read_also(fd, self._read)

    def _read(self):
        data = os.read(self.fd, 65536)
        if not data:
            self.ended = True
            self.simulator.read_also(self.fd, None)
        self._text += data

    def __iter__(self):
        while True:
            self.simulator.run(until=lambda: self.ended or b'\n' in self._text)
            text, newline, rest = self._text.partition(b'\n')
            if not newline and not text:
                return
            self._text = rest
            yield text.decode('utf-8', 'replace')


def complain(error):
    text = str(error)
    if isinstance(error, OSError) and error.strerror:
        text = '%s: %s' % (error.filename, error.strerror) if error.filename else error.strerror
    print('xy3-head-sim: %s' % text, file=sys.stderr)


def make_line(options):
    if options.link and (options.connect or options.listen or options.output):
        raise Wrong('--link requires a pseudo terminal')
    if options.exit and not (options.stream or options.bytes):
        raise Wrong('--exit requires --stream or --bytes')
    if options.connect:
        return line.Client(options.connect, options.wait, options.pace)
    if options.listen:
        return line.Server(options.listen, options.pace)
    if options.output:
        return line.File(options.output, options.pace)
    return line.Pty(options.link, options.pace)


def make_head(options):
    texts = {name: getattr(options, name) or None for name in head.TEXTS
             if getattr(options, name) is not None}
    result = head.Head(order=options.order, rate=options.rate, interval=options.interval,
                       sync_interval=options.sync_interval, seed=options.seed, **texts)
    for kind, how in options.fault:
        result.faults.set(kind, how)
    return result


def run_script(options, simulator, say):
    runner = Runner(simulator, say, math.inf if options.timeout is None else options.timeout)
    if options.script == '-':
        lines, name = Lines(simulator, sys.stdin.fileno()), 'stdin'
        steps = (runner.parse(text, '%s:%d' % (name, at)) for at, text in enumerate(lines, 1))
    else:
        try:
            with open(options.script, encoding='utf-8') as file:
                lines = file.read().splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise ScriptError('%s: %s' % (options.script,
                                          getattr(error, 'strerror', None) or error)) from None
        steps = [runner.parse(text, '%s:%d' % (options.script, at))
                 for at, text in enumerate(lines, 1)]
    say('ready', line=simulator.line.name)
    for step in steps:
        if step is not None and not runner.run(step):
            break
    simulator.run(until=lambda: not simulator.line.pending, timeout=LAST_WORDS)


def run_stream(options, simulator, say):
    say('ready', line=simulator.line.name)
    simulator.stream(options.stream or 0, options.bytes or 0,
                     math.inf if options.timeout is None else options.timeout)
    say('counts', **simulator.head.counts())
    simulator.head.interval = simulator.head.sync_interval = 0
    if not options.exit and not options.output:
        try:
            simulator.wait_closed()
        except line.LineError:
            pass                            # the expected end


def run(options):
    the_line = make_line(options)
    say = Output(options.json).say
    try:
        simulator = Simulator(make_head(options), the_line, say)
        if options.script:
            run_script(options, simulator, say)
        elif options.stream or options.bytes:
            run_stream(options, simulator, say)
        else:
            say('ready', line=the_line.name)
            simulator.run()
    finally:
        the_line.close()


def main(arguments=None):
    parser = make_parser()
    options = parser.parse_args(arguments)
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    signal.signal(signal.SIGINT, signal.default_int_handler)    # even if it was ignored
    try:
        run(options)
    except Wrong as error:
        parser.error(str(error))
    except ScriptError as error:
        complain(error)
        return USAGE
    except BrokenPipeError:
        # The reader has closed the output; flushing the rest must not fail again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except (Failure, Timeout, line.LineError, OSError) as error:
        complain(error)
        return FAILED
    except KeyboardInterrupt:
        return OK
    return OK
