# SPDX-License-Identifier: GPL-2.0-only
"""Runs in the kernel used for measurements: streams to the virtual head, and counts.

guest.py TREE SPIDEV ROUNDS SECONDS: TREE has the modules, SPIDEV is the module of the kernel. The
results are written to /run/out/result.json.
"""
import json
import os
import random
import statistics
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / 'lib'))

import kernel  # noqa: E402
import latency  # noqa: E402
import trace  # noqa: E402
from wire import Arrangement, Spidev, Stream  # noqa: E402

DEBUGFS = '/sys/kernel/debug/xy3-sim/0/'
SCANS = 4096            # of one write
LENGTH = 4 * SCANS      # of the IIO buffer
MESSAGE_SCANS = 256     # of one message, as in the driver
QUICK = [Arrangement(*words) for words in (
    (4, 'line', 24), (4, 'line', 32), (8, 'line', 24), (8, 'line', 32), (1, 'word', 24),
    (4, 'cs', 24))]
REAL_TIME = [(Arrangement(*words), rate) for *words, rate in (
    (4, 'line', 24, 100000), (4, 'line', 24, 200000), (4, 'line', 32, 100000),
    (4, 'line', 32, 200000), (8, 'line', 32, 200000))]
WRITER_PRIORITY = 60    # the driver has the controller's thread run with 50
QUICK_RATE = 100000     # nominal rate; without realtime it is not waited for


def numbers(name):
    """The content of a file with a name and a value in each line."""
    lines = kernel.read_file(DEBUGFS + name).splitlines()
    return {words[0]: int(words[1]) for words in map(str.split, lines)}


class Head:
    """A virtual head with an SPI device for the driver of this name; counts from 0."""

    def __init__(self, tree, arrangement, modalias, realtime, more=''):
        kernel.load_module(tree + '/drivers/xy3/sim/xy3-sim.ko',
                           f'{arrangement.module_parameters()} modalias={modalias} '
                           f'realtime={int(realtime)} {more}')
        self.devices = dict(map(str.split, kernel.read_file(DEBUGFS + 'devices').splitlines()))
        self.thread = self.find_thread()

    def find_thread(self):
        """-> process id of the controller's thread"""
        name = self.devices['spidev'].replace('spidev', 'spi').partition('.')[0]
        for comm in Path('/proc').glob('[0-9]*/comm'):
            if comm.read_text(encoding='ascii').strip() == name:
                return int(comm.parent.name)
        raise RuntimeError(f'no thread {name}')

    def sender(self, modalias, *arguments):
        if modalias == 'spidev':
            return Spidev('/dev/' + self.devices['spidev'], *arguments, MESSAGE_SCANS)
        folder = kernel.wait(lambda: list(Path('/sys/bus/iio/devices').glob('iio:device*')))[0]
        return Stream(str(folder), *arguments, LENGTH)

    @staticmethod
    def longest_silence_us():
        return numbers('bus')['longest_silence_ns'] / 1000

    def close(self):
        if not kernel.wait(lambda: not kernel.is_loaded('xy3_sim') or self.unload()):
            raise RuntimeError('xy3-sim cannot be unloaded')

    @staticmethod
    def unload():
        try:
            kernel.unload_module('xy3_sim')
        except OSError:
            return False
        return True


def check(arrangement, sent, repeated):
    """Check that the head has received all that was sent, without errors."""
    got = numbers('stats')
    if got['scans'] != sent + repeated or got['short_gaps'] or got['stray_clocks']:
        raise RuntimeError(f'{arrangement.name}: {sent} + {repeated} scans sent, then {got}')
    for name in ('parity_errors', 'length_errors', 'mode_errors'):
        if any(numbers(name).values()):
            raise RuntimeError(f'{arrangement.name}: {name} {numbers(name)}')


def run(tree, modalias, arrangement, rate, seconds, realtime, traced):
    """Send for some seconds -> the measured values"""
    chance = random.Random(arrangement.name)
    codes = [chance.getrandbits(arrangement.code_bits) for _ in range(SCANS * arrangement.axes)]
    # spidev's messages have no gap in front, and would lose a frame behind lines that float
    head = Head(tree, arrangement, modalias, realtime, 'idle=keep turnaround_us=0')
    sender = head.sender(modalias, arrangement, codes, rate)
    if traced:
        trace.start()
    sent, began = 0, time.monotonic()
    while time.monotonic() - began < seconds:
        sender.send()
        sent += SCANS
    said = sender.get('achieved_frequency') if modalias == 'xy3-100' else None
    sender.finish()
    took = time.monotonic() - began
    events = trace.stop() if traced else None

    stream = {name: sender.get(name) for name in ('repeated', 'underruns', 'bus_errors')} \
        if modalias == 'xy3-100' else {'repeated': 0}
    check(arrangement, sent, stream['repeated'])
    bus = numbers('bus')
    found = {'seconds': took, 'scans_per_second': sent / took, 'achieved_frequency': said,
             **stream, **{name: bus[name] for name in ('gaps', 'gap_ns', 'longest_gap_ns')}}
    if traced:
        found.update(processor(events, head.thread))
        found.update(in_hand(events, arrangement, rate))
        found['on_the_wire'] = (sent + stream['repeated']) / trace.lasted(events)
    head.close()
    return found


def processor(events, thread):
    share = trace.shares(events)
    writer = share.get(os.getpid(), 0)
    controller = share.get(thread, 0)
    idle = share.get(0, 0)
    return {'writer': writer, 'controller': controller,
            'others': max(0, 1 - writer - controller - idle)}


def in_hand(events, arrangement, rate):
    """The pending data of the controller when it got more."""
    usec = 1e6 * 8 / arrangement.lines / arrangement.clocks / rate
    if arrangement.framing == 'word':
        usec = 1e6 / 4 / rate
    leads = trace.leads(events, lambda size: size * usec)
    late = sum(after < 0 <= before for before, after in zip([0, *leads], leads))
    return {'least_lead_us': min(leads), 'median_lead_us': statistics.median(leads), 'late': late}


def quick(tree, rounds, seconds):
    """At full speed: the driver and spidev in turns; then a traced run, for CPU time."""
    for arrangement in QUICK:
        row = {'name': arrangement.name, 'axes': arrangement.axes, 'driver': [], 'spidev': []}
        for _ in range(rounds):
            for name, modalias in (('driver', 'xy3-100'), ('spidev', 'spidev')):
                row[name].append(run(tree, modalias, arrangement, QUICK_RATE, seconds, False,
                                     False))
        row['traced'] = run(tree, 'xy3-100', arrangement, QUICK_RATE, seconds, False, True)
        yield row


def real_time(tree, rounds, seconds):
    """At the speed of the wire."""
    for arrangement, rate in REAL_TIME:
        row = {'name': arrangement.name, 'axes': arrangement.axes, 'rate': rate, 'driver': [],
               'spidev': []}
        for _ in range(rounds):
            for name, modalias in (('driver', 'xy3-100'), ('spidev', 'spidev')):
                row[name].append(run(tree, modalias, arrangement, rate, seconds, True, True))
        yield row


def main():
    tree, spidev, rounds, seconds = sys.argv[1:]
    rounds, seconds = int(rounds), float(seconds)
    # the writer has priority over the controller thread, as in a program for a laser: otherwise the
    # controller, faster than any wire, would spend its time repeating the last position
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(WRITER_PRIORITY))
    kernel.load_module(tree + '/drivers/xy3/xy3.ko')
    kernel.load_module(tree + '/drivers/xy3/spi/xy3-spi.ko')
    kernel.load_module(spidev, 'bufsiz=65536')
    result = {'write_scans': SCANS, 'buffer_scans': LENGTH, 'message_scans': MESSAGE_SCANS,
              'seconds': seconds,
              'quick': list(quick(tree, rounds, seconds)),
              'real_time': list(real_time(tree, rounds, 2 * seconds)),
              'latency': list(latency.measure(
                  lambda arrangement, more: Head(tree, arrangement, 'xy3-100', True, more),
                  max(10, int(1000 * seconds))))}
    Path('/run/out/result.json').write_text(json.dumps(result), encoding='ascii')


if __name__ == '__main__':
    main()
