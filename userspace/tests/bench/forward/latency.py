# SPDX-License-Identifier: GPL-2.0-only
"""How long a scan takes from write() to the controller, how long the driver takes to hand over the
next message, and the longest silence on the wire: idle and under load, with the real-time priority
that the driver requires of the controller's thread, and without it.
"""
import contextlib
import os
import subprocess
import sys
import time

import trace
from wire import Arrangement

RATE = 100000
ARRANGEMENT = Arrangement(4, 'line', 24)
TURNAROUND_US = 20      # as of a controller with a FIFO
PAUSE = 0.003           # seconds between two scans: longer than all that is queued meanwhile
LOAD = 2                # processes, on one processor


@contextlib.contextmanager
def load(count):
    # the writer's real-time priority would be inherited, and nothing else run any more
    words = ['chrt', '--other', '0', sys.executable, '-c', 'while True: pass']
    programs = [subprocess.Popen(words) for _ in range(count)]
    try:
        yield
    finally:
        for program in programs:
            program.kill()
            program.wait()


def part(values, share):
    """The value that this share of all does not exceed."""
    return sorted(values)[min(len(values) - 1, int(len(values) * share))]


def summary(values):
    return {'count': len(values), 'p50_us': part(values, 0.5), 'p99_9_us': part(values, 0.999),
            'longest_us': max(values)}


def to_the_controller(writes, events):
    """us from each write() until the controller begins with the message that it has made"""
    found = []
    submits = [(event.time, event.message) for event in events
               if event.name == 'spi_message_submit' and event.pid == os.getpid()]
    starts = [(event.time, event.message) for event in events
              if event.name == 'spi_message_start']
    for write in writes:
        submitted, message = next(each for each in submits if each[0] >= write)
        found.append(next(time for time, which in starts
                          if which == message and time >= submitted) - write)
    return found


def handovers(events):
    """us from the end of a message to the start of the next one. The driver's part in it, in which
    interrupts are off, is shorter.
    """
    found, done = [], None
    for event in events:
        if event.name == 'spi_message_done':
            done = event.time
        elif event.name == 'spi_message_start' and done is not None:
            found.append(event.time - done)
    return found


def microseconds():
    return time.monotonic_ns() // 1000


def first_scans(head, count):
    """Each is the first one of a stream, before which nothing is sent."""
    found = []
    for _ in range(max(count // 10, 5)):
        sender = head.sender('xy3-100', ARRANGEMENT, [1 << 19] * ARRANGEMENT.axes, RATE)
        trace.start()
        write = microseconds()
        sender.send()
        time.sleep(PAUSE)
        found += to_the_controller([write], trace.stop_messages())
        sender.finish()
    return found


def later_scans(head, count):
    """One at a time, while the stream repeats the last. -> (latencies, handovers)"""
    sender = head.sender('xy3-100', ARRANGEMENT, [1 << 19] * ARRANGEMENT.axes, RATE)
    sender.send()
    time.sleep(0.1)
    trace.start()
    writes = []
    for _ in range(count):
        writes.append(microseconds())
        sender.send()
        time.sleep(PAUSE)
    events = trace.stop_messages()
    sender.finish()
    return to_the_controller(writes, events), handovers(events)


def measure(make_head, count):
    """`make_head`: -> a virtual head with these lines and more parameters -> rows"""
    for busy in (0, LOAD):
        for realtime in (True, False):
            with load(busy):
                found = []
                for scans in (first_scans, later_scans):
                    head = make_head(ARRANGEMENT, f'turnaround_us={TURNAROUND_US}')
                    if not realtime:
                        os.sched_setscheduler(head.thread, os.SCHED_OTHER, os.sched_param(0))
                    found.append(scans(head, count))
                    silence = head.longest_silence_us()
                    head.close()
            first, (later, handover) = found
            yield {'load': busy, 'realtime': realtime, 'first': summary(first),
                   'later': summary(later), 'handover': summary(handover),
                   'longest_silence_us': silence}
