# SPDX-License-Identifier: GPL-2.0-only
"""The backchannel of a scanhead on an 8250 and on an FTDI adapter, with the tools of users.

Tests that do not depend on the UART, udev or the kernel run in User Mode Linux (tests/head).
"""

import glob
import hashlib
import os
import re
import select
import subprocess
import termios
import time

import pytest
from harness import (BIND_TIME, TRACING, command, module_loaded, read_file, reload_rules, settle,
                     wait_for, write_file)
from head_rig import AttributePoller, Background, error_name, split
from serial_head import (STICK, UART, Cat, Reader, by_id, heads, module, peer, plug,
                         set_clock, unplug, whole_packets)

RATE = 921600
BYTES_PER_SECOND = RATE // 10
LDISC_AUTOLOAD = '/proc/sys/dev/tty/ldisc_autoload'
UART_SHARE = 100        # one interrupt per few bytes, each of them emulated


# --- attach ------------------------------------------------------------------------------------

@pytest.mark.smoke
def test_ldattach_loads_the_module(attach, port):
    """Must be first: the module is not loaded yet, or the test of the other port unloads it."""
    if module_loaded('xy3'):
        module.unload()
    assert not module_loaded('xy3')
    head = attach(port)
    assert module_loaded('xy3')
    assert head.name == 'xy3-0'
    assert head.get('in_sync') == '0'
    assert head.get('rate') == '115200'
    assert error_name(head.get, 'vendor') == 'ENODATA'


def test_links_by_udev(attach):
    head = attach(STICK, vendor='Lasers Ltd', model='H 2', serial='0815')
    wait_for(lambda: os.path.realpath('/dev/xy3') == head.node, '/dev/xy3', BIND_TIME)
    head.request('report')
    wait_for(lambda: head.node in by_id().values(), 'link by identity', BIND_TIME)
    name, = [name for name, node in by_id().items() if node == head.node]
    assert name.startswith('xy3-') and '0815' in name and 'Lasers' in name
    head.detach()
    wait_for(lambda: not os.path.lexists('/dev/xy3'), 'end of the link', BIND_TIME)
    wait_for(lambda: not by_id(), 'end of the links by identity', BIND_TIME)


def test_two_heads(attach):
    first, second = attach(UART, serial='first'), attach(STICK, serial='second')
    assert (first.name, second.name) == ('xy3-0', 'xy3-1')
    for head in (first, second):
        head.request('report')
        wait_for(lambda head=head: head.stat('syncs') == 2, 'report of ' + head.name)
        wait_for(lambda head=head: head.get('serial') == head.settings['serial'], 'serial')
    wait_for(lambda: sorted(by_id().values()) == ['/dev/xy3-0', '/dev/xy3-1'],
             'links by identity', BIND_TIME)
    wait_for(lambda: os.path.realpath('/dev/xy3') == '/dev/xy3-0', '/dev/xy3', BIND_TIME)
    first.detach()
    assert heads() == ['xy3-1']
    first.attach()
    assert first.name == 'xy3-0'


def stick_port():
    """The USB interface of the stick, which a rule can match by KERNELS."""
    plug(STICK)
    device = os.path.realpath('/sys/class/tty/ttyUSB0/device')
    unplug(STICK)
    return os.path.basename(os.path.dirname(device))


def unit_command():
    """-> words of the unit's command, which is run with the capabilities that the unit has"""
    unit = read_file('/usr/lib/systemd/system/xy3-attach@.service')
    settings = dict(re.findall(r'^(ExecStart|Environment|CapabilityBoundingSet)=(.*)', unit, re.M))
    start = settings['ExecStart'].replace('%I', 'ttyUSB0').replace(
        '${XY3_RATE}', settings['Environment'].removeprefix('XY3_RATE='))
    kept = ['+' + name.removeprefix('CAP_').lower()
            for name in settings['CapabilityBoundingSet'].split()]
    return ['setpriv', '--bounding-set', ','.join(['-all', *kept]), '--inh-caps', '-all',
            '--no-new-privs', *start.split()]


@pytest.mark.parametrize('by', ('id', 'port'))
def test_stick_is_attached_by_rule_and_unit(by):
    """A user's rule marks the adapter. There is no systemd here: the test runs its unit.

    The module is loaded on a machine where only programs with CAP_SYS_MODULE may cause that.
    """
    rule = '/etc/udev/rules.d/69-test-heads.rules'
    match = 'ATTRS{idVendor}=="0403"' if by == 'id' else 'KERNELS=="%s"' % stick_port()
    with open(rule, 'w', encoding='ascii') as file:
        file.write('SUBSYSTEM=="tty", %s, ENV{XY3_BACKCHANNEL}="1"\n' % match)
    reload_rules()
    if module_loaded('xy3'):
        module.unload()

    def properties():
        return command('udevadm', 'info', '--query=property', '/dev/ttyUSB0').splitlines()

    plug(STICK)
    try:
        write_file(LDISC_AUTOLOAD, '0')
        wait_for(lambda: 'SYSTEMD_WANTS=xy3-attach@ttyUSB0.service' in properties(),
                 'the unit in the properties', BIND_TIME)
        tags, = [line for line in properties() if line.startswith('TAGS=')]
        assert ':systemd:' in tags
        module.will_come()
        with subprocess.Popen(unit_command()) as service:
            wait_for(heads, 'head', BIND_TIME)
            service.terminate()
        wait_for(lambda: not heads(), 'end of the head')
    finally:
        write_file(LDISC_AUTOLOAD, '1')
        os.unlink(rule)
        reload_rules()
        unplug(STICK)


# --- packets -----------------------------------------------------------------------------------

@pytest.mark.smoke
def test_cat_gives_what_was_sent(attach, port):
    """Rounds of all packets, one of 255 bytes, and one of an unknown type."""
    head = attach(port)
    with Cat(head.node) as cat:
        head.request('mark')
        head.request('report')
        head.request('packet', 0x77, bytes(range(255)).hex())
        head.request('packet', 0x0A, '')
        head.request('stream', packets=500)
        sent = head.request('sent')
        data = cat.wait_size(sent['bytes'])
    assert hashlib.sha1(data).hexdigest() == sent['sha1']
    assert len(split(data)) == head.stat('rx_packets')
    assert head.stat('unknown_packets') == 2
    assert head.stat('dropped_bytes') + head.stat('lost_packets') == 0


@pytest.mark.smoke
def test_flush_of_a_full_buffer(attach):
    """tcsetattr(TCSAFLUSH) drops complete packets from the buffer of N_TTY, on all kernels."""
    head = attach(UART)
    head.sync()
    fd = os.open(head.node, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        head.request('mark')
        head.request('stream', packets=1000)
        sent = head.request('sent')['bytes']
        assert sent > 2 * 4096
        wait_for(lambda: head.stat('rx_bytes') >= sent, 'the stream', BIND_TIME)
        termios.tcsetattr(fd, termios.TCSAFLUSH, termios.tcgetattr(fd))
        data = b''
        while select.select([fd], [], [], 1)[0]:
            data += os.read(fd, 65536)
    finally:
        os.close(fd)
    assert len(split(data)) > 100
    assert sent - 4096 <= len(data) < sent
    assert head.stat('lost_packets') == 0


def seconds_of_traffic():
    """traffic=SECONDS of the kernel's command line: how much, as time at 921600 bit/s."""
    return int(re.search(r'\btraffic=(\d+)', read_file('/proc/cmdline')).group(1))


@pytest.mark.timeout(600)
def test_traffic_without_loss(attach, port):
    """At the highest rate nothing is lost, by the count of the simulator.

    The emulated lines do not have exact rates: the adapter is several times faster, the 8250
    slower.
    """
    size = seconds_of_traffic() * BYTES_PER_SECOND
    if port == UART:
        set_clock(RATE)
        size //= UART_SHARE
    head = attach(port, rate=RATE)
    with Reader(head) as reader:
        head.sync()
        sent = reader.take_stream(size)
        counts = head.request('counts')
        assert reader.bytes == sent
        assert reader.digest.hexdigest() == head.request('sent')['sha1']
    wanted = {'rx_bytes': counts['bytes'], 'rx_packets': counts['packets'],
              'syncs': counts['by_type']['sync'], 'resyncs': 0, 'dropped_bytes': 0,
              'bad_lengths': 0, 'unknown_packets': 0, 'line_errors': 0, 'lost_packets': 0}
    assert {name: head.stat(name) for name in wanted} == wanted
    assert head.request('rate') == RATE


def test_break_is_a_line_error(attach):
    head = attach(UART)
    head.sync()
    head.request('line_break')
    wait_for(lambda: head.stat('line_errors') == 1, 'line error')
    assert head.get('in_sync') == '0'
    assert head.stat('dropped_bytes') == 1
    head.sync()
    assert head.stat('resyncs') == 1


# --- sensors, uevents --------------------------------------------------------------------------

@pytest.mark.smoke
def test_sensors_prints_temperatures(attach):
    head = attach(UART)
    head.request('set', 'temperature', 'mirror_x', -12.5)
    head.request('report')
    text = wait_for(lambda: find_chip('mirror_x'), 'thermometers in sensors', BIND_TIME)
    for label, degrees in (('head', '+31.5'), ('dsp', '+44.2'), ('driver_x', '+38.0'),
                           ('galvo_y', '+36.5'), ('mirror_x', '-12.5')):
        assert re.search(r'^%s: +%s.C' % (label, re.escape(degrees)), text, re.M), label
    assert 'dac_x' not in text
    head.request('set', 'error', 'dsp', 'temperature')
    head.request('report', 'errors')
    wait_for(lambda: re.search(r'^dsp: +FAULT|^dsp:.*(ALARM|FAULT)', find_chip('dsp'), re.M),
             'fault in sensors')
    head.detach()
    assert find_chip('') == ''


def find_chip(word):
    """The output of `sensors` for the head, if it contains `word`; else ''."""
    text = subprocess.run(['sensors'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False).stdout
    for chip in text.split('\n\n'):
        if chip.startswith('xy3-') and word in chip:
            return chip
    return ''


class UdevMonitor:
    """udevadm monitor, as users run it to watch errors of a head."""

    PLACE = '/tmp/monitor'

    def __enter__(self):
        self._file = open(self.PLACE, 'wb')
        self._process = subprocess.Popen(['udevadm', 'monitor', '--property',
                                          '--subsystem-match=xy3'], stdout=self._file)
        wait_for(lambda: 'KERNEL' in read_file(self.PLACE), 'udevadm monitor', BIND_TIME)
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        self._file.close()

    def events(self, **properties):
        """Events of the kernel and of udev that have all these properties."""
        wanted = {'%s=%s' % pair for pair in properties.items()}
        return [event for event in read_file(self.PLACE).split('\n\n')
                if wanted <= set(event.splitlines())]

    def wait(self, **properties):
        wait_for(lambda: len(self.events(**properties)) >= 2, 'uevent %r' % properties, BIND_TIME)


def test_udevadm_monitor_shows_errors(attach):
    head = attach(UART)
    with UdevMonitor() as monitor:
        head.request('report')
        monitor.wait(XY3_EVENT='sync', XY3_IN_SYNC='1')
        monitor.wait(XY3_EVENT='identity')
        assert monitor.events(XY3_EVENT='error') == []
        head.request('set', 'error', 'galvo_x', 'temperature')
        head.request('set', 'error', 'dac_y', 150)
        head.request('report', 'errors')
        monitor.wait(ACTION='change', XY3_EVENT='error', XY3_COMPONENT='galvo_x',
                     XY3_ERROR='temperature', XY3_ERROR_CODE='1')
        monitor.wait(XY3_EVENT='error', XY3_COMPONENT='dac_y', XY3_ERROR='150',
                     XY3_ERROR_CODE='150')
        head.request('set', 'error', 'galvo_x', 'none')
        head.request('report', 'errors')
        monitor.wait(XY3_EVENT='error', XY3_COMPONENT='galvo_x', XY3_ERROR='none')
        assert len(monitor.events(XY3_EVENT='error')) == 6


# --- rates, from stty and sysfs down to what QEMU sees of the UART -----------------------------

def speed(node):
    return int(command('stty', '-F', node, 'speed'))


def stty(node, rate):
    """-> whether stty succeeded"""
    done = subprocess.run(['stty', '-F', node, str(rate)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)
    assert done.returncode == 0 or 'unable to perform' in done.stdout
    return done.returncode == 0


def check_rate(head, rate):
    """Waits until sysfs, both ttys and the hardware have the same rate."""
    wait_for(lambda: (head.get('rate'), speed(head.node), speed(head.device)) ==
             (str(rate), rate, rate), '%d in sysfs and at both ttys' % rate)
    wait_for(lambda: head.request('rate') == rate, '%d at the hardware' % rate)


def test_stty_moves_the_uart(attach, port):
    if port == UART:
        set_clock(921600)
    head = attach(port)
    head.sync()
    for rate in (230400, 921600, 57600, 460800, 115200):
        assert stty(head.node, rate), rate
        check_rate(head, rate)
        assert head.get('in_sync') == '0'
        head.request('report')              # the head has kept its rate: this is garbage
        head.request('set', 'rate', rate)
        head.sync()
    assert not stty(head.node, 9600)
    check_rate(head, 115200)
    head.set('rate', 230400)
    check_rate(head, 230400)
    assert error_name(head.set, 'rate', 9600) == 'EINVAL'
    check_rate(head, 230400)
    assert stty(head.device, 57600)
    check_rate(head, 57600)


def test_rate_that_the_uart_cannot_do(attach):
    """An 8250 with the usual clock is limited to 115200."""
    set_clock(115200)
    try:
        head = attach(UART)
        stty(head.node, 230400)         # its result is known later
        check_rate(head, 115200)
        assert error_name(head.set, 'rate', 921600) == 'EINVAL'
        check_rate(head, 115200)
        assert stty(head.node, 57600)
        check_rate(head, 57600)
    finally:
        set_clock(921600)


def test_autobaud_finds_the_head(attach):
    """On a real UART the search changes the rate of the hardware."""
    set_clock(921600)
    head = attach(UART)
    for rate in (460800, 57600):
        head.set('autobaud', 0)
        head.request('set', 'rate', rate)
        head.request('send_every', 0.5, 0.1)
        head.set('autobaud', 1)
        wait_for(lambda: head.get('in_sync') == '1', 'sync at %d' % rate, BIND_TIME)
        head.request('send_every', 0, 0)
        check_rate(head, rate)


# --- detach and unplug -------------------------------------------------------------------------

@pytest.mark.smoke
def test_unplugged_while_it_streams(attach):
    """A reader gets end of file, and the adapter can be plugged in again."""
    for number in range(2):
        head = attach(STICK, serial='No. %d' % number)
        with Cat(head.node) as cat:
            head.send_request('stream_until_next_request')
            wait_for(lambda: len(cat.data()) > 50000, 'a stream', BIND_TIME)
            head.send_request('unplug')
            peer.receive()                 # of the stream
            peer.receive()
            assert cat.wait_end() == 0
            # the hangup of a tty drops unread data, even part of a packet
            whole_packets(cat.data(), cut=True)
        wait_for(lambda: not heads(), 'end of the head')
        wait_for(lambda: not os.path.exists(head.node), 'end of the node')
        head.close()


def test_unplugged_while_files_are_open(attach):
    """The adapter is unplugged while files are open, and the next head gets its number.

    A program that polls an attribute learns of the removal.
    """
    head = attach(STICK)
    pollers = [AttributePoller(head.path(name)) for name in ('in_sync', 'errors/dsp')]
    watchers = [Background(poller.removed, 150) for poller in pollers]
    time.sleep(1)                       # they are in poll() now
    upper = os.open(head.node, os.O_RDONLY)
    lower = os.open(head.device, os.O_RDWR | os.O_NOCTTY)
    sysfs = os.open(head.path('in_sync'), os.O_RDONLY)
    try:
        unplug(STICK)
        assert os.read(upper, 100) == b''
        wait_for(lambda: not heads(), 'end of the head')
        assert error_name(os.pread, sysfs, 16, 0) == 'ENODEV'
        assert [watcher.result(160) for watcher in watchers] == [True, True]
        other = attach(UART)
        assert other.name == 'xy3-0'
        with Cat(other.node) as cat:
            other.request('mark')
            other.request('report')
            cat.wait_size(other.request('sent')['bytes'])
    finally:
        for fd in (upper, lower, sysfs):
            os.close(fd)
        for poller in pollers:
            poller.close()


@pytest.mark.smoke
def test_module_stays_while_it_is_used(attach):
    """Also checks that the memory of a head is found, so that a leak would be detected."""
    head = attach(UART)
    head.sync()
    assert module.allocations()
    settle()
    done = subprocess.run(['modprobe', '-r', 'xy3'], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)
    assert done.returncode and 'in use' in done.stdout
    assert module_loaded('xy3')


@pytest.mark.smoke
def test_module_leaves_nothing():
    """Must be last: no memory and no objects of all heads above are left."""
    module.unload()
    assert not module_loaded('xy3')
    for path in (TRACING + '/events/xy3', '/sys/class/xy3'):
        assert not os.path.exists(path)
    for pattern in ('/dev/xy3*', '/dev/serial/by-id/xy3*'):
        wait_for(lambda pattern=pattern: not glob.glob(pattern), 'end of ' + pattern, BIND_TIME)
    for name in ('drivers', 'ldiscs'):
        assert 'xy3' not in read_file('/proc/tty/' + name)
    assert 'xy3' not in [read_file(path).strip() for path in glob.glob('/sys/class/hwmon/*/name')]
