# SPDX-License-Identifier: GPL-2.0-only
"""Much traffic at the highest rate: nothing is lost, by the simulator's own count.

traffic=SECONDS on the kernel's command line says how much, as time at 921600 bit/s. The emulated
lines do not keep to their rates: the stick is several times as fast, the 8250 slower.
"""

import re

from harness import equal, read_file
from heads import STICK, UART, Attached, Reader, set_clock

TESTS = []
RATE = 921600
BYTES_PER_SECOND = RATE // 10
UART_SHARE = 100        # it takes an interrupt for a few bytes, and each of them is emulated


def test(function):
    TESTS.append(function)
    return function


def seconds():
    found = re.search(r'\btraffic=(\d+)', read_file('/proc/cmdline'))
    return int(found.group(1)) if found else 60


def check_traffic(port, size):
    with Attached(port, rate=RATE) as head, Reader(head) as reader:
        head.sync()
        sent = reader.take_stream(size)
        counts = head.ask('counts')
        equal(reader.bytes, sent, 'bytes read')
        equal(reader.digest.hexdigest(), head.ask('sent')['sha1'], 'checksum')
        wanted = {'rx_bytes': counts['bytes'], 'rx_packets': counts['packets'],
                  'syncs': counts['by_type']['sync'], 'resyncs': 0, 'dropped_bytes': 0,
                  'bad_lengths': 0, 'unknown_packets': 0, 'line_errors': 0, 'lost_packets': 0}
        equal({name: head.stat(name) for name in wanted}, wanted, 'statistics')
        equal(head.ask('rate'), RATE, 'rate of the hardware')
        print('# %d packets, %d bytes' % (counts['packets'], sent))


@test
def traffic_without_loss_stick():
    check_traffic(STICK, seconds() * BYTES_PER_SECOND)


@test
def traffic_without_loss_uart():
    set_clock(RATE)
    check_traffic(UART, seconds() * BYTES_PER_SECOND // UART_SHARE)


for function in TESTS:
    function.limit = 600
