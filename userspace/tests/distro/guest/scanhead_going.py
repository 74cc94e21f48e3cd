# SPDX-License-Identifier: GPL-2.0-only
"""The end of a head: unplug, module removal, and what remains of it all."""

import errno
import glob
import os
import subprocess

from harness import (BIND_TIME, TRACING, equal, error_of, module_loaded, read_file, settle, true,
                     wait_for)
from heads import STICK, UART, Attached, Cat, heads, module, packets, peer, unplug

TESTS = []


def test(function):
    TESTS.append(function)
    return function


@test
def unplugged_while_it_streams():
    """A reader gets the end of the file, and the stick can be plugged again."""
    for number in range(2):
        with Attached(STICK, serial='No. %d' % number) as head, Cat(head) as cat:
            head.tell('stream_until_asked')
            wait_for(lambda: len(cat.data()) > 50000, 'a stream', BIND_TIME)
            head.tell('unplug')
            peer.hear()                 # of the stream
            peer.hear()
            equal(cat.wait_end(), 0, 'status of cat')
            # a tty's hangup throws away what has not been read, be it half of a packet
            packets(cat.data(), cut=True)
            wait_for(lambda: not heads(), 'end of the head')
            equal(os.path.exists(head.node), False, 'node')


@test
def unplugged_while_nobody_lets_go():
    """Files stay open across the unplug; the stick plugged again is served all the same."""
    with Attached(STICK) as head:
        upper = os.open(head.node, os.O_RDONLY)
        lower = os.open(head.device, os.O_RDWR | os.O_NOCTTY)
        sysfs = os.open(head.path('in_sync'), os.O_RDONLY)
        try:
            unplug(STICK)
            equal(os.read(upper, 100), b'', 'read')
            equal(error_of(os.pread, sysfs, 16, 0), errno.ENODEV, 'errno of sysfs')
            wait_for(lambda: not heads(), 'end of the head')
            with Attached(UART) as other:
                equal(other.name, 'xy3-0', 'name of the next head')
                with Cat(other) as cat:
                    other.ask('mark')
                    other.ask('report')
                    cat.wait_size(other.ask('sent')['bytes'])
        finally:
            for fd in (upper, lower, sysfs):
                os.close(fd)


@test
def module_stays_while_it_is_used():
    with Attached(UART):
        settle()
        done = subprocess.run(['modprobe', '-r', 'xy3'], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        true(done.returncode and 'in use' in done.stdout, 'modprobe -r: ' + done.stdout)
        true(module_loaded('xy3'), 'the module has gone')
    module.unload()
    true(not module_loaded('xy3'), 'the module is still there')


@test
def memory_is_seen_and_given_back():
    """Last but one. That nothing remains is looked at whenever the module is unloaded."""
    module.load()
    with Attached(UART) as head:
        head.sync()
        true(module.allocations(), 'even of a head no allocation is seen')
    module.unload()


@test
def nothing_of_heads_is_left():
    """Must be last."""
    true(not module_loaded('xy3'), 'the module is still loaded')
    true(not os.path.exists(TRACING + '/events/xy3'), 'the tracepoints are still there')
    true(not os.path.exists('/sys/class/xy3'), 'the class is still there')
    equal(glob.glob('/dev/xy3*'), [], 'nodes')
    equal(glob.glob('/dev/serial/by-id/xy3*'), [], 'links')
    for name in ('drivers', 'ldiscs'):
        true('xy3' not in read_file('/proc/tty/' + name), name)
    names = [read_file(path).strip() for path in glob.glob('/sys/class/hwmon/*/name')]
    true('xy3' not in names, 'hwmon')
