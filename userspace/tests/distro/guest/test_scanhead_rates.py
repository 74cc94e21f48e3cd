# SPDX-License-Identifier: GPL-2.0-only
"""The backchannel's rate, from stty and sysfs down to what QEMU sees of the UART."""

import errno
import subprocess

from harness import BIND_TIME, command, error_of, wait_for
from heads import UART, Attached, set_clock, on_both_ports


def speed(node):
    return int(command('stty', '-F', node, 'speed'))


def stty(node, rate):
    """-> whether stty was content"""
    done = subprocess.run(['stty', '-F', node, str(rate)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)
    assert done.returncode == 0 or 'unable to perform' in done.stdout, 'stty: ' + done.stdout
    return done.returncode == 0


def check_rate(head, rate, what):
    """Everybody agrees on the rate: sysfs, both ttys, and the hardware."""
    wait_for(lambda: speed(head.node) == rate, '%s: %d at the upper tty' % (what, rate))
    assert head.get('rate') == str(rate), what + ': rate'
    assert speed(head.device) == rate, what + ': lower tty'
    wait_for(lambda: head.ask('rate') == rate, '%s: %d at the hardware' % (what, rate))


@on_both_ports
def test_stty_moves_the_uart(port):
    if port == UART:
        set_clock(921600)
    with Attached(port) as head:
        head.sync()
        for rate in (230400, 921600, 57600, 460800, 115200):
            assert stty(head.node, rate), 'stty %d has complained' % rate
            check_rate(head, rate, 'stty')
            assert head.get('in_sync') == '0'
            head.ask('report')          # the head has not followed: this is garbage
            head.ask('set', 'rate', rate)
            head.sync()
        assert not stty(head.node, 9600)
        check_rate(head, 115200, 'after a wrong rate')
        head.set('rate', 230400)
        check_rate(head, 230400, 'sysfs')
        assert error_of(head.set, 'rate', 9600) == errno.EINVAL
        check_rate(head, 230400, 'after a wrong rate')
        assert stty(head.device, 57600), 'stty of the lower tty has complained'
        check_rate(head, 57600, 'lower tty')


def test_rate_that_the_uart_cannot_do():
    """A 8250 with the clock that most have ends at 115200."""
    set_clock(115200)
    try:
        with Attached(UART) as head:
            assert not stty(head.node, 230400)
            check_rate(head, 115200, 'refused')
            assert error_of(head.set, 'rate', 921600) == errno.EINVAL
            check_rate(head, 115200, 'refused')
            assert stty(head.node, 57600), 'stty 57600 has complained'
            check_rate(head, 57600, 'stty')
    finally:
        set_clock(921600)


@on_both_ports
def test_autobaud_finds_the_head(port):
    with Attached(port) as head:
        assert head.get('autobaud') == '0'
        for rate in (460800, 57600):
            head.set('autobaud', 0)
            head.ask('set', 'rate', rate)
            head.ask('talk', 0.5, 0.1)
            command('sleep', '1')
            assert not (head.get('rate') == str(rate))
            head.set('autobaud', 1)
            wait_for(lambda: head.get('in_sync') == '1', 'sync at %d' % rate, BIND_TIME)
            head.ask('talk', 0, 0)
            check_rate(head, rate, 'autobaud')


def test_break_is_a_line_error():
    with Attached(UART) as head:
        head.sync()
        head.ask('line_break')
        wait_for(lambda: head.stat('line_errors') == 1, 'line error')
        assert head.get('in_sync') == '0'
        assert head.stat('dropped_bytes') == 1
        head.sync()
        assert head.stat('resyncs') == 1
