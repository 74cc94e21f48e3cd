# SPDX-License-Identifier: GPL-2.0-only
"""The end of a head: unplug, module removal, and what remains of it all."""

import errno
import glob
import os
import subprocess

import pytest
from harness import BIND_TIME, TRACING, error_of, module_loaded, read_file, settle, wait_for
from heads import STICK, UART, Attached, Cat, heads, module, packets, peer, unplug


@pytest.mark.smoke
def test_unplugged_while_it_streams():
    """A reader gets the end of the file, and the stick can be plugged again."""
    for number in range(2):
        with Attached(STICK, serial='No. %d' % number) as head, Cat(head) as cat:
            head.tell('stream_until_asked')
            wait_for(lambda: len(cat.data()) > 50000, 'a stream', BIND_TIME)
            head.tell('unplug')
            peer.hear()                 # of the stream
            peer.hear()
            assert cat.wait_end() == 0
            # a tty's hangup throws away what has not been read, be it half of a packet
            packets(cat.data(), cut=True)
            wait_for(lambda: not heads(), 'end of the head')
            assert not os.path.exists(head.node)


def test_unplugged_while_nobody_lets_go():
    """Files stay open across the unplug; the stick plugged again is served all the same."""
    with Attached(STICK) as head:
        upper = os.open(head.node, os.O_RDONLY)
        lower = os.open(head.device, os.O_RDWR | os.O_NOCTTY)
        sysfs = os.open(head.path('in_sync'), os.O_RDONLY)
        try:
            unplug(STICK)
            assert os.read(upper, 100) == b''
            assert error_of(os.pread, sysfs, 16, 0) == errno.ENODEV
            wait_for(lambda: not heads(), 'end of the head')
            with Attached(UART) as other:
                assert other.name == 'xy3-0'
                with Cat(other) as cat:
                    other.ask('mark')
                    other.ask('report')
                    cat.wait_size(other.ask('sent')['bytes'])
        finally:
            for fd in (upper, lower, sysfs):
                os.close(fd)


@pytest.mark.smoke
def test_module_stays_while_it_is_used():
    with Attached(UART):
        settle()
        done = subprocess.run(['modprobe', '-r', 'xy3'], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        assert done.returncode and 'in use' in done.stdout, 'modprobe -r: ' + done.stdout
        assert module_loaded('xy3'), 'the module has gone'
    module.unload()
    assert not module_loaded('xy3'), 'the module is still there'


def test_memory_is_seen_and_given_back():
    """Last but one. That nothing remains is looked at whenever the module is unloaded."""
    module.load()
    with Attached(UART) as head:
        head.sync()
        assert module.allocations(), 'even of a head no allocation is seen'
    module.unload()


def test_nothing_of_heads_is_left():
    """Must be last."""
    assert not module_loaded('xy3'), 'the module is still loaded'
    assert not os.path.exists(TRACING + '/events/xy3'), 'the tracepoints are still there'
    assert not os.path.exists('/sys/class/xy3'), 'the class is still there'
    assert glob.glob('/dev/xy3*') == []
    assert glob.glob('/dev/serial/by-id/xy3*') == []
    for name in ('drivers', 'ldiscs'):
        assert 'xy3' not in read_file('/proc/tty/' + name), name
    names = [read_file(path).strip() for path in glob.glob('/sys/class/hwmon/*/name')]
    assert 'xy3' not in names, 'hwmon'
