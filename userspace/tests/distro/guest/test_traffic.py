# SPDX-License-Identifier: GPL-2.0-only
"""Much traffic at the highest rate: nothing is lost, by the simulator's own count.

traffic=SECONDS on the kernel's command line says how much, as time at 921600 bit/s. The emulated
lines do not keep to their rates: the stick is several times as fast, the 8250 slower.
"""

import re

import pytest
from harness import read_file
from heads import UART, Attached, Reader, on_both_ports, set_clock

RATE = 921600
BYTES_PER_SECOND = RATE // 10
UART_SHARE = 100        # it takes an interrupt for a few bytes, and each of them is emulated


def seconds():
    found = re.search(r'\btraffic=(\d+)', read_file('/proc/cmdline'))
    return int(found.group(1)) if found else 60


@pytest.mark.timeout(600)
@on_both_ports
def test_traffic_without_loss(port):
    size = seconds() * BYTES_PER_SECOND
    if port == UART:
        set_clock(RATE)
        size //= UART_SHARE
    with Attached(port, rate=RATE) as head, Reader(head) as reader:
        head.sync()
        sent = reader.take_stream(size)
        counts = head.ask('counts')
        assert reader.bytes == sent
        assert reader.digest.hexdigest() == head.ask('sent')['sha1']
        wanted = {'rx_bytes': counts['bytes'], 'rx_packets': counts['packets'],
                  'syncs': counts['by_type']['sync'], 'resyncs': 0, 'dropped_bytes': 0,
                  'bad_lengths': 0, 'unknown_packets': 0, 'line_errors': 0, 'lost_packets': 0}
        assert {name: head.stat(name) for name in wanted} == wanted
        assert head.ask('rate') == RATE

