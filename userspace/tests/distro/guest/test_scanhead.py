# SPDX-License-Identifier: GPL-2.0-only
"""A scanhead's backchannel on a 8250 and on a FTDI stick, by the tools that its owner has."""

import errno
import fcntl
import hashlib
import os
import re
import struct
import subprocess

import pytest
from harness import (BIND_TIME, TRACING, command, error_of, module_loaded, read_file, settle,
                     wait_for, write_file)
from heads import (LDISC, STICK, TIOCSETD, UART, Attached, Cat, heads, module, on_both_ports,
                   packets, plug, unplug)


# --- coming ------------------------------------------------------------------------------------

@pytest.mark.smoke
@on_both_ports
def test_line_discipline_loads_the_module(port):
    """Must be first: nobody has loaded the module yet. Then what makes a head of a UART."""
    if module_loaded('xy3'):
        module.unload()                 # by the other port's turn
    assert not module_loaded('xy3'), 'the module is loaded before anything is attached'
    with Attached(port) as head:
        assert module_loaded('xy3'), 'the module is not loaded'
        assert head.name == 'xy3-0'
        assert head.get('in_sync') == '0'
        assert head.get('rate') == '115200'
        assert error_of(head.get, 'vendor') == errno.ENODATA
    assert not os.path.exists('/dev/xy3-0')


@on_both_ports
def test_links_by_udev(port):
    with Attached(port, vendor='Lasers Ltd', model='H 2', serial='0815') as head:
        wait_for(lambda: os.path.realpath('/dev/xy3') == head.node, '/dev/xy3', BIND_TIME)
        head.ask('report')
        wait_for(lambda: head.node in by_id().values(), 'link by identity', BIND_TIME)
        name = [name for name, node in by_id().items() if node == head.node][0]
        assert name.startswith('xy3-') and '0815' in name and 'Lasers' in name, name
    settle()
    assert not os.path.lexists('/dev/xy3')
    assert by_id() == {}


def by_id():
    """name -> node, of scanheads"""
    place = '/dev/serial/by-id'
    if not os.path.isdir(place):
        return {}
    return {name: os.path.realpath(os.path.join(place, name)) for name in os.listdir(place)
            if name.startswith('xy3-')}


@on_both_ports
def test_telemetry_in_sysfs(port):
    with Attached(port, firmware='4.2', order='big') as head:
        head.set('byte_order', 'big')
        head.ask('set', 'error', 'dac_y', 150)
        head.ask('set', 'frame_errors', 'w', 70000)
        head.ask('report')
        wait_for(lambda: head.get('in_sync') == '1' and head.stat('syncs') == 2, 'a round')
        wanted = {'vendor': 'Virtual', 'model': 'Head-2D', 'firmware': '4.2',
                  'serial': 'SIM-0001', 'errors/head': 'none', 'errors/dac_y': '150',
                  'hours/head': '1200', 'hours/galvo_x': '1150', 'frame_errors/x': '0',
                  'frame_errors/w': '70000', 'byte_order': 'big'}
        assert {name: head.get(name) for name in wanted} == wanted
        assert error_of(head.get, 'hours/mirror_w') == errno.ENODATA
        assert head.stat('rx_bytes') == head.ask('sent')['bytes']


# --- /dev/xy3-0 --------------------------------------------------------------------------------

def check_same(head, data):
    """What was read is what was sent, or, while that is decoded, the packets in it."""
    assert hashlib.sha1(data).hexdigest() == head.ask('sent')['sha1']


@pytest.mark.smoke
@on_both_ports
def test_cat_gives_what_was_sent(port):
    """Rounds of all packets, one of 255 bytes, and one of a type that nobody knows."""
    with Attached(port) as head, Cat(head) as cat:
        head.ask('mark')
        head.ask('report')
        head.ask('packet', 0x77, bytes(range(255)).hex())
        head.ask('packet', 0x0A, '')
        head.ask('stream', packets=500)
        data = cat.wait_size(head.ask('sent')['bytes'])
        check_same(head, data)
        assert len(packets(data)) == head.stat('rx_packets')
        assert head.stat('unknown_packets') == 2
        assert head.stat('dropped_bytes') + head.stat('lost_packets') == 0


@on_both_ports
def test_cat_gives_whole_packets_of_a_damaged_stream(port):
    """What the simulator's own receiver makes of it, byte for byte."""
    faults = ('noise', 'lost', 'doubled', 'torn', 'length', 'flipped', 'false-sync', 'trap')
    with Attached(port) as head, Cat(head) as cat:
        head.ask('mark', decode=True)
        head.ask('report')
        for fault in faults:
            head.ask('fault', fault, '1/40')
        head.ask('stream', packets=600)
        for fault in faults:
            head.ask('fault', fault, 'off')
        head.ask('raw', '00' * 300)     # the end of whatever was begun
        head.ask('report', 'sync', 'sync')
        data = cat.wait_size(head.ask('sent')['bytes'])
        check_same(head, data)
        packets(data)
        receiver = head.ask('counts')['receiver']
        for name, count in {'rx_packets': receiver['packets'], 'syncs': receiver['syncs'],
                            'dropped_bytes': receiver['dropped'],
                            'bad_lengths': receiver['bad_lengths'],
                            'resyncs': receiver['resyncs']}.items():
            assert head.stat(name) == count, name
        assert receiver['resyncs'] > 20 and receiver['bad_lengths'] > 5, 'too little damage'


def test_slow_reader_loses_whole_packets():
    with Attached(STICK) as head:
        fd = os.open(head.node, os.O_RDONLY | os.O_NONBLOCK)
        try:
            head.ask('stream', size=1000000)
            sent = head.ask('sent')['bytes']
            head.wait_bytes(sent)
            lost = head.stat('lost_packets')
            assert lost > 0, 'nothing is lost though nobody reads'
            data = read_rest(fd)
            assert len(packets(data)) + lost == head.stat('rx_packets')
            head.ask('mark')
            head.ask('report')
            size = head.ask('sent')['bytes']
            wait_for(lambda: head.stat('rx_bytes') == sent + size, 'a round more')
            data = read_rest(fd)
            assert len(data) == size
            check_same(head, data)
        finally:
            os.close(fd)


def read_rest(fd):
    """Until nothing has come for a while."""
    data = b''

    def more():
        nonlocal data
        try:
            data += os.read(fd, 65536)
            return False
        except BlockingIOError:
            return True

    quiet = 0
    while quiet < 3:
        quiet = quiet + 1 if wait_for(more, 'end of the data') else 0
        command('sleep', '0.1')
    return data


@on_both_ports
def test_nothing_to_write_to(port):
    """A backchannel alone has no way to the head."""
    frame = bytes.fromhex('203a00')     # 24 bits, a command; its parity is right
    with Attached(port) as head:
        fd = os.open(head.node, os.O_WRONLY)
        lower = os.open(head.device, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            found = error_of(os.write, fd, frame)
            assert found in (errno.ENODEV, errno.EINVAL), 'errno %d of a frame' % found
            assert error_of(os.write, fd, b'?') == errno.EINVAL
            assert error_of(os.write, lower, b'x') == errno.EOPNOTSUPP
            for name, value in (('calibrate', 'xy'), ('temp_comp', 'on'), ('reference', 'all')):
                assert error_of(head.set, name, value) == errno.ENODEV, 'errno of ' + name
            assert error_of(head.set, 'calibrate', 'q') == errno.EINVAL
        finally:
            os.close(fd)
            os.close(lower)


# --- sensors, uevents ----------------------------------------------------------------------------

@pytest.mark.smoke
@on_both_ports
def test_sensors_prints_temperatures(port):
    with Attached(port) as head:
        head.ask('set', 'temperature', 'mirror_x', -12.5)
        head.ask('report')
        text = wait_for(lambda: find_chip('mirror_x'), 'thermometers in sensors', BIND_TIME)
        for label, degrees in (('head', '+31.5'), ('dsp', '+44.2'), ('driver_x', '+38.0'),
                               ('galvo_y', '+36.5'), ('mirror_x', '-12.5')):
            assert re.search(r'^%s: +%s.C' % (label, re.escape(degrees)), text, re.M), \
                'no %s %s in: %s' % (label, degrees, text)
        assert 'dac_x' not in text, 'a thermometer that is not there: ' + text
        head.ask('set', 'error', 'dsp', 'temperature')
        head.ask('report', 'errors')
        wait_for(lambda: re.search(r'^dsp: +FAULT|^dsp:.*(ALARM|FAULT)', find_chip('dsp'), re.M),
                 'fault in sensors')
    assert find_chip('') == ''


def find_chip(word):
    """What `sensors` says of the head, when `word` is in there; else ''."""
    text = subprocess.run(['sensors'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False).stdout
    for chip in text.split('\n\n'):
        if chip.startswith('xy3-') and word in chip:
            return chip
    return ''


class UdevMonitor:
    """udevadm monitor, as somebody would run it who waits for a head's error."""

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
        """From the kernel and from udev: those that have all these properties."""
        wanted = {'%s=%s' % pair for pair in properties.items()}
        return [event for event in read_file(self.PLACE).split('\n\n')
                if wanted <= set(event.splitlines())]

    def wait(self, **properties):
        wait_for(lambda: len(self.events(**properties)) >= 2, 'uevent %r' % properties, BIND_TIME)


def test_udevadm_monitor_sees_an_error():
    with Attached(UART) as head, UdevMonitor() as monitor:
        head.ask('report')
        monitor.wait(XY3_EVENT='sync', XY3_IN_SYNC='1')
        monitor.wait(XY3_EVENT='identity')
        assert monitor.events(XY3_EVENT='error') == []
        head.ask('set', 'error', 'galvo_x', 'temperature')
        head.ask('set', 'error', 'dac_y', 150)
        head.ask('report', 'errors')
        monitor.wait(ACTION='change', XY3_EVENT='error', XY3_COMPONENT='galvo_x',
                     XY3_ERROR='temperature', XY3_ERROR_CODE='1')
        monitor.wait(XY3_EVENT='error', XY3_COMPONENT='dac_y', XY3_ERROR='150',
                     XY3_ERROR_CODE='150')
        head.ask('set', 'error', 'galvo_x', 'none')
        head.ask('report', 'errors')
        monitor.wait(XY3_EVENT='error', XY3_COMPONENT='galvo_x', XY3_ERROR='none')
        assert len(monitor.events(XY3_EVENT='error')) == 6


# --- and more ------------------------------------------------------------------------------------

def test_two_heads():
    with Attached(UART, serial='first') as first, Attached(STICK, serial='second') as second:
        assert (first.name, second.name) == ('xy3-0', 'xy3-1')
        for head, text in ((first, 'first'), (second, 'second')):
            head.ask('report')
            wait_for(lambda head=head, text=text: head.stat('syncs') == 2 and
                     head.get('serial') == text, 'serial')
        wait_for(lambda: sorted(by_id().values()) == ['/dev/xy3-0', '/dev/xy3-1'],
                 'links by identity', BIND_TIME)
        assert os.path.realpath('/dev/xy3') == '/dev/xy3-0'
        first.detach()
        assert heads() == ['xy3-1']
        first.attach()
        assert first.name == 'xy3-0'


def test_plugged_stick_is_attached_by_rule_and_unit():
    """The owner's rule names the stick. There is no systemd here: its unit is obeyed by hand."""
    with open('/etc/udev/rules.d/69-test-heads.rules', 'w', encoding='ascii') as file:
        file.write('SUBSYSTEM=="tty", ATTRS{idVendor}=="0403", ENV{XY3_BACKCHANNEL}="1"\n')
    command('udevadm', 'control', '--reload')
    unit = read_file('/usr/lib/systemd/system/xy3-attach@.service')
    start = re.search(r'^ExecStart=(.*)', unit, re.M).group(1)
    rate = re.search(r'^Environment=XY3_RATE=(.*)', unit, re.M).group(1)
    plug(STICK)
    try:
        settle()
        found = command('udevadm', 'info', '--query=property', '/dev/ttyUSB0').splitlines()
        assert 'SYSTEMD_WANTS=xy3-attach@ttyUSB0.service' in found, 'properties %r' % found
        tags = [line for line in found if line.startswith('TAGS=')]
        assert tags and ':systemd:' in tags[0], 'tags %r' % tags
        words = start.replace('%I', 'ttyUSB0').replace('${XY3_RATE}', rate).split()
        with subprocess.Popen(words) as service:
            wait_for(heads, 'head', BIND_TIME)
            service.terminate()
        wait_for(lambda: not heads(), 'end of the head')
    finally:
        os.unlink('/etc/udev/rules.d/69-test-heads.rules')
        command('udevadm', 'control', '--reload')
        unplug(STICK)


def test_only_for_the_administrator():
    plug(UART)
    fd = os.open('/dev/ttyS1', os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        module.load()
        child = os.fork()
        if not child:
            os.setresuid(65534, 65534, 65534)
            os._exit(error_of(fcntl.ioctl, fd, TIOCSETD, struct.pack('i', LDISC)))
        assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == errno.EPERM
        assert heads() == []
    finally:
        os.close(fd)


def test_tracepoints_of_packets():
    with Attached(UART) as head:
        for event in ('packet', 'sync'):
            write_file('%s/events/xy3/%s/enable' % (TRACING, event), '1')
        try:
            write_file(TRACING + '/trace', '\n')
            head.ask('packet', 0x77, '0102')
            head.ask('report', 'sync')
            head.ask('packet', 0x78, 'a1b2')
            wait_for(lambda: head.stat('rx_packets') == 2, 'packets')
            trace = read_file(TRACING + '/trace')
            for line in ('sync: xy3-0 in_sync=1 dropped=5',
                         'packet: xy3-0 type=78 length=2 payload=a1 b2'):
                assert line in trace, 'no trace of %s in: %s' % (line, trace[-600:])
        finally:
            for event in ('packet', 'sync'):
                write_file('%s/events/xy3/%s/enable' % (TRACING, event), '0')
            write_file(TRACING + '/trace', '\n')
