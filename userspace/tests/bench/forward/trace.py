# SPDX-License-Identifier: GPL-2.0-only
"""Measurements by tracepoints: CPU time of processes, and the times at which the SPI controller got
messages. User Mode Linux counts CPU time in ticks of 10 ms, which is too coarse.
"""
import re
from collections import defaultdict, namedtuple
from pathlib import Path

TRACING = Path('/sys/kernel/tracing')
EVENTS = ('sched/sched_switch', 'spi/spi_message_submit', 'spi/spi_message_start',
          'spi/spi_message_done')
BUFFER_KB = 65536

LINE = re.compile(r' (\d+)\.(\d{6}): (\w+): (.*)')
SWITCH = re.compile(r'prev_pid=(\d+) .* next_pid=(\d+) ')
DONE = re.compile(r' len=(\d+)/')
MESSAGE = re.compile(r'-(\d+) +\[\d+\].* (\d+)\.(\d{6}): (spi_message_\w+): \S+ (\w+)')
Event = namedtuple('Event', 'time name pid message')     # us; the task; which message


def write(name, text):
    (TRACING / name).write_text(text, encoding='ascii')


def start():
    write('tracing_on', '0')
    write('trace_clock', 'mono')
    write('buffer_size_kb', str(BUFFER_KB))
    write('options/hash-ptr', '0')      # pointers tell messages apart, from the start on
    for event in EVENTS:
        write(f'events/{event}/enable', '1')
    write('trace', '')
    write('tracing_on', '1')


def stop_lines():
    """-> lines of the trace"""
    write('tracing_on', '0')
    for event in EVENTS:
        write(f'events/{event}/enable', '0')
    stats = (TRACING / 'per_cpu/cpu0/stats').read_text(encoding='ascii')
    if int(re.search(r'^overrun: (\d+)', stats, re.MULTILINE).group(1)):
        raise RuntimeError('the trace is too long for its buffer')
    lines = (TRACING / 'trace').read_text(encoding='ascii').splitlines()
    write('trace', '')
    return lines


def stop():
    """-> [(time in us, event, what it says), ...]"""
    found = []
    for line in stop_lines():
        match = LINE.search(line)
        if match:
            seconds, usec, event, text = match.groups()
            found.append((int(seconds) * 1000000 + int(usec), event, text))
    return found


def stop_messages():
    """-> [Event, ...] of SPI messages"""
    found = []
    for match in filter(None, map(MESSAGE.search, stop_lines())):
        pid, seconds, usec, event, message = match.groups()
        found.append(Event(int(seconds) * 1000000 + int(usec), event, int(pid), message))
    return found


def shares(trace):
    """{process id: its share of CPU time}; 0 is idle time"""
    had = defaultdict(int)
    since = None
    for time, event, text in trace:
        if event != 'sched_switch':
            continue
        before, _ = SWITCH.search(text).groups()
        if since is not None:
            had[int(before)] += time - since
        else:
            first = time
        since = time
    return {pid: time / (since - first) for pid, time in had.items()}


def lasted(trace):
    """From the start of the first message to the end of the last one, in seconds."""
    start = next(time for time, event, _ in trace if event == 'spi_message_start')
    done = next(time for time, event, _ in reversed(trace) if event == 'spi_message_done')
    return (done - start) / 1e6


def leads(trace, usec):
    """The time in us by which each message was given to the controller before it had sent all
    earlier ones; negative: it had nothing to send for this time, if its wire had not waited for the
    processor. usec() returns the time for a number of bytes.
    """
    given, found = [], []
    until, done = None, 0
    for time, event, text in trace:
        if event == 'spi_message_submit':
            given.append((time, done == len(given)))
        elif event == 'spi_message_start' and until is None:
            until = time
        elif event == 'spi_message_done':
            submitted, was_idle = given[done]
            found.append(until - submitted)
            if was_idle:    # the wire starts again with this one
                until = max(until, submitted)
            until += usec(int(DONE.search(text).group(1)))
            done += 1
    if not found or len(found) != len(given):
        raise RuntimeError(f'{len(given)} messages given, {len(found)} done')
    return found[1:]
