# SPDX-License-Identifier: GPL-2.0-only
"""Reports of a head: sysfs, hwmon, poll(), uevents, tracepoints."""

import os
import random
import time

import pytest

import head_rig
from head_rig import Case, wait
from kernel import read_file, write_file
from xy3_head_sim import wire

NODATA = 'ENODATA'
TRACING = '/sys/kernel/tracing/'
EVENTS = TRACING + 'events/xy3/'
TEXTS = {'vendor': wire.VENDOR, 'model': wire.MODEL, 'firmware': wire.FIRMWARE,
         'serial': wire.SERIAL}
COMPONENTS = wire.COMPONENTS


class TestAttributes(Case):
    def test_nothing_is_reported(self):
        head = self.attach()
        for name in TEXTS:
            assert head.get(name) == NODATA
        for folder, names in (('errors', COMPONENTS), ('hours', COMPONENTS),
                              ('frame_errors', wire.AXES)):
            assert head.all(folder) == dict.fromkeys(names, NODATA)
        assert head.hwmon() == {}
        assert head.stats() == dict.fromkeys(head_rig.STATS, 0)
        for name, text in (('in_sync', '0'), ('rate', '115200'), ('autobaud', '0'),
                           ('byte_order', 'little')):
            assert head.get(name) == text

    @pytest.mark.parametrize('name', TEXTS)
    def test_texts(self, name):
        head = self.synced()
        for text in (b'ACME', b'abc', b'x' * 200, b'Galvo 3/20 (rev. "B")'):
            head.send(wire.packet(TEXTS[name], text))
            assert head.get(name) == text.decode()

    @pytest.mark.parametrize('text, shown', (
        (b'a\nb', 'a?b'), (b'\x1b[2J!', '?[2J!'), (b'\x7f~ \x1f', '?~ ?'), (bytes(3), '???'),
        ('Gerät'.encode(), 'Ger??t'), (b'ab\0cd', 'ab?cd'), (b'\xff\xfe\x80', '???')))
    def test_texts_that_are_not_printable(self, text, shown):
        head = self.synced()
        head.send(wire.vendor(text))
        assert head.get('vendor') == shown

    def test_a_text_with_a_bad_length_changes_nothing(self):
        head = self.synced()
        head.send(wire.serial(b'SN 1'), wire.packet(wire.SERIAL, b'no'), head_rig.GOOD,
                  wire.packet(wire.SERIAL, b'n' * 201), head_rig.GOOD)
        assert head.get('serial') == 'SN 1'
        assert head.stat('bad_lengths') == 2

    def test_errors(self):
        head = self.synced()
        codes = [0, 1, 2, 3, 4, 5, 6, 7, 8, 99, 100, 255]
        head.send(wire.errors(codes))
        shown = [*wire.ERROR_NAMES, '8', '99', '100', '255']
        assert head.all('errors') == dict(zip(
            COMPONENTS, shown + [NODATA] * (len(COMPONENTS) - len(codes))))
        head.send(wire.errors([7] * len(COMPONENTS)))
        assert head.all('errors') == dict.fromkeys(COMPONENTS, 'mechanical')
        head.send(wire.errors([2]))
        assert head.all('errors') == {
            **dict.fromkeys(COMPONENTS, NODATA), 'head': 'data'}

    def test_hours(self):
        head = self.synced()
        head.send(wire.hours([0, 1, None, 0xFFFFFFFE] + [70000] * 18))
        assert head.all('hours') == {
            **dict.fromkeys(COMPONENTS, '70000'), 'head': '0', 'dsp': '1', 'dac_x': NODATA,
            'dac_y': '4294967294'}
        head.send(wire.hours([7]))
        assert head.all('hours') == {
            **dict.fromkeys(COMPONENTS, NODATA), 'head': '7'}

    def test_frame_errors(self):
        head = self.synced()
        head.send(wire.frame_errors([0, 1, 65536, 0xFFFFFFFF, 5]))
        assert head.all('frame_errors') == {
            'x': '0', 'y': '1', 'z': '65536', 'u': '4294967295', 'w': '5'}

    def test_byte_order(self):
        head = self.synced()
        report = (wire.hours([256], 'big') + wire.frame_errors([1, 2, 3, 4, 0x01020304], 'big') +
                  wire.temperatures([2500], 'big') + wire.errors([1]) + wire.vendor('ACME'))
        head.send(report)
        assert head.get('hours/head') == '65536'
        assert head.get('frame_errors/w') == '%d' % 0x04030201
        assert wait(lambda: head.hwmon().get('temp1_input') == '-153510')
        assert head.set('byte_order', 'big') is None
        assert head.get('byte_order') == 'big'
        assert (head.get('hours/head'), head.get('frame_errors/w'),
                          head.hwmon()['temp1_input']) == (NODATA,) * 3
        assert (head.get('errors/head'), head.get('vendor')) == ('temperature', 'ACME')
        head.send(report)
        assert (head.get('hours/head'), head.get('frame_errors/w'),
                          head.hwmon()['temp1_input']) == ('256', '%d' % 0x01020304, '25000')
        assert head.set('byte_order', 'big') is None        # no change: all values are kept
        assert head.get('hours/head') == '256'
        for text in ('\n', 'middle', 'bigger', '1'):
            assert head.set('byte_order', text) == 'EINVAL'
        assert head.get('byte_order') == 'big'

    @pytest.mark.parametrize('names, good, bad', (
        (('autocalib', 'temp_comp'), ('on', 'off', 'on x', 'off zw\n', 'on all'),
         ('\n', 'x', 'yes', 'on q', 'onx', 'off x y')),
        (('calibrate', 'reference'), ('x', 'xyzuw\n', 'all', '\n', 'XY'),
         ('q', 'x y', 'on', 'allx', '1'))), ids=('with on and off', 'with axes alone'))
    def test_commands(self, names, good, bad):
        """The error of invalid text differs from that of a missing forward channel."""
        head = self.synced()
        for name in names:
            for text in good:
                assert head.set(name, text) == 'ENODEV', (name, text)
            for text in bad:
                assert head.set(name, text) == 'EINVAL', (name, text)

    def test_modes(self):
        """Write permissions of all files of the head."""
        head = self.synced()
        head.send(wire.temperatures([2500]))
        assert wait(head.hwmon)
        writable = set()
        for folder, folders, files in os.walk(head.path):
            if 'power' in folders:
                folders.remove('power')
            for name in files:
                path = os.path.join(folder, name)
                mode = os.stat(path).st_mode & 0o777
                assert mode in (0o444, 0o644, 0o200), path
                if mode != 0o444 and name != 'uevent':
                    writable.add((os.path.relpath(path, head.path), mode))
        assert writable == {
            ('rate', 0o644), ('autobaud', 0o644), ('byte_order', 0o644), ('autocalib', 0o200),
            ('temp_comp', 0o200), ('calibrate', 0o200), ('reference', 0o200)}


class TestHwmon(Case):
    def grown(self, head, count):
        return wait(lambda: sum('_input' in name for name in head.hwmon()) == count)

    def test_channels(self):
        head = self.synced()
        head.send(wire.temperatures([3150, None, -1250, 0, 32767, -32766, None]))
        assert self.grown(head, 5)
        shown = head.hwmon()
        assert shown.pop('name') == 'xy3'
        expected = {}
        for number, name, value in ((1, 'head', 31500), (3, 'dac_x', -12500), (4, 'dac_y', 0),
                                    (5, 'dac_z', 327670), (6, 'dac_u', -327660)):
            expected['temp%d_input' % number] = '%d' % value
            expected['temp%d_label' % number] = name
            expected['temp%d_fault' % number] = '0'
        assert shown == expected

    def test_all_channels(self):
        head = self.synced()
        head.send(wire.temperatures(range(100, 2300, 100)))
        assert self.grown(head, 22)
        shown = head.hwmon()
        for number, name in enumerate(COMPONENTS, 1):
            assert shown['temp%d_label' % number] == name
            assert shown['temp%d_input' % number] == '%d' % (1000 * number)

    def test_it_grows_and_never_shrinks(self):
        head = self.synced()
        head.send(wire.temperatures([2000]))
        assert self.grown(head, 1)
        head.send(wire.temperatures([None, 2100, 2200]))
        assert self.grown(head, 3)
        shown = head.hwmon()
        assert [shown['temp%d_input' % number] for number in (1, 2, 3)] == \
            [NODATA, '21000', '22000']
        head.send(wire.temperatures([2300]))
        time.sleep(0.3)
        shown = head.hwmon()
        assert [shown['temp%d_input' % number] for number in (1, 2, 3)] == \
            ['23000', NODATA, NODATA]

    def test_nothing_but_absent_thermometers(self):
        head = self.synced()
        head.send(wire.temperatures([None] * 22))
        time.sleep(0.3)
        assert head.hwmon() == {}
        head.send(wire.temperatures([None] * 21 + [2500]))
        assert self.grown(head, 1)
        assert head.hwmon()['temp22_label'] == 'mirror_w'

    def test_fault(self):
        head = self.synced()
        head.send(wire.temperatures([2500, 2500, 2500]), wire.errors([0, 1, 2]))
        assert self.grown(head, 3)
        shown = head.hwmon()
        assert [shown['temp%d_fault' % number] for number in (1, 2, 3)] == \
            ['0', '1', '0']
        head.send(wire.errors(['temperature']))
        shown = head.hwmon()
        assert [shown['temp%d_fault' % number] for number in (1, 2, 3)] == \
            ['1', '0', '0']

    def test_parent_and_end(self):
        """Each head has one as its child, which is removed with the head."""
        one, two = self.synced(), self.synced()
        for head in (one, two):
            head.send(wire.temperatures([2500]))
            assert self.grown(head, 1)
        assert len(os.listdir('/sys/class/hwmon')) == 2
        assert os.path.realpath(one.hwmon_path() + '/device') == \
            os.path.realpath(one.path)
        one.uart.cut()
        assert one.gone()
        assert len(os.listdir('/sys/class/hwmon')) == 1
        assert two.hwmon()['temp1_input'] == '25000'

    def test_open_while_it_grows(self):
        """A file of a replaced hwmon device returns an error, without side effects."""
        head = self.synced()
        head.send(wire.temperatures([2500]))
        assert self.grown(head, 1)
        fd = self.opened(head.hwmon_path() + '/temp1_input')
        assert os.pread(fd, 99, 0) == b'25000\n'
        head.send(wire.temperatures([2500, 2500]))
        assert self.grown(head, 2)
        assert head_rig.error_name(os.pread, fd, 99, 0) == 'ENODEV'


class TestPollers(Case):
    def test_in_sync(self):
        head = self.attach()
        poller = self.poller(head, 'in_sync')
        assert not poller.changed(0.3)
        head.sync()
        assert poller.changed()
        head.send(wire.vendor('ACME'), wire.temperatures([2500]))
        assert not poller.changed(0.5)
        head.send(b'junk')
        assert poller.changed()
        assert poller.read() == '0\n'

    def test_errors(self):
        head = self.synced()
        dsp, other = self.poller(head, 'errors/dsp'), self.poller(head, 'errors/head')
        head.send(wire.errors([0, 1]))
        assert dsp.changed()
        assert dsp.read() == 'temperature\n'
        assert not other.changed(0.3)
        head.send(wire.errors([0, 1]))
        assert not dsp.changed(0.5)            # no change
        head.send(wire.errors([3]))
        assert dsp.changed()
        assert other.changed()
        assert (other.read(), dsp.read()) == ('range\n', NODATA)

    @pytest.mark.parametrize('way', ('cut', 'detach'))
    def test_the_head_goes(self, way):
        """A program that waits without a limit learns of the removal."""
        head = self.synced()
        head.send(wire.errors([0, 1]))
        watchers = {name: head_rig.Background(self.poller(head, name).removed)
                    for name in ('in_sync', *('errors/' + name for name in COMPONENTS))}
        time.sleep(0.3)                         # all are in poll() now
        (head.uart.cut if way == 'cut' else head.detach)()
        assert {name: watcher.result() for name, watcher in watchers.items()} == \
            dict.fromkeys(watchers, True)


class TestEvents(Case):
    def test_coming_and_going(self):
        events = self.uevents('xy3', 'tty')
        head = self.attach()
        assert [(event['ACTION'], event['SUBSYSTEM'], event.get('DEVNAME'))
                          for event in events.take()] == \
            [('add', 'xy3', None), ('add', 'tty', 'xy3-0')]
        head.uart.cut()
        assert head.gone()
        assert [(event['ACTION'], event['SUBSYSTEM'], event.get('DEVNAME'))
                          for event in events.take()] == \
            [('remove', 'tty', 'xy3-0'), ('remove', 'xy3', None)]

    def test_sync(self):
        head = self.attach()
        events = self.uevents()
        head.sync()
        assert events.properties() == [{'EVENT': 'sync', 'IN_SYNC': '1'}]
        head.send(b'junk')
        assert events.properties() == [{'EVENT': 'sync', 'IN_SYNC': '0'}]
        head.send(b'more junk')
        assert events.properties() == []

    def test_sync_for_a_moment(self):
        """Lost and found again in one piece of data: reported as found."""
        head = self.synced()
        events = self.uevents()
        head.send(b'junk' + head_rig.GOOD)
        assert events.properties() == [{'EVENT': 'sync', 'IN_SYNC': '1'}]

    def test_errors(self):
        head = self.synced()
        events = self.uevents()
        head.send(wire.errors([0, 0, 0]))
        assert events.properties() == []         # no error, as assumed
        head.send(wire.errors([0, 1, 100]))
        assert events.properties() == [
            {'EVENT': 'error', 'COMPONENT': 'dsp', 'ERROR': 'temperature', 'ERROR_CODE': '1'},
            {'EVENT': 'error', 'COMPONENT': 'dac_x', 'ERROR': '100', 'ERROR_CODE': '100'}]
        head.send(wire.errors([0, 1, 100]), wire.errors([0, 1, 100]))
        assert events.properties() == []
        # the state of omitted components is unknown
        unknown = [{'EVENT': 'error', 'COMPONENT': name, 'ERROR': 'unknown'}
                   for name in ('dsp', 'dac_x')]
        head.send(wire.errors([0]))
        assert events.properties() == unknown
        assert head.get('errors/dsp') == NODATA
        head.send(wire.errors([0]))
        assert events.properties() == []
        head.send(wire.errors([0, 1, 0]))
        assert events.properties() == [
            {'EVENT': 'error', 'COMPONENT': 'dsp', 'ERROR': 'temperature', 'ERROR_CODE': '1'},
            {'EVENT': 'error', 'COMPONENT': 'dac_x', 'ERROR': 'none', 'ERROR_CODE': '0'}]
        head.send(wire.errors([0, 0, 0]), wire.errors([0]), wire.errors([0, 0, 0]))
        assert events.properties() == [
            {'EVENT': 'error', 'COMPONENT': 'dsp', 'ERROR': 'none', 'ERROR_CODE': '0'}]

    def test_identity(self):
        head = self.synced()
        events = self.uevents('xy3', 'tty')
        for name, kind in TEXTS.items():
            head.send(wire.packet(kind, b'first'))
            found = events.take()
            assert [(event['ACTION'], event['SUBSYSTEM'], event.get('XY3_EVENT'))
                              for event in found] == \
                [('change', 'xy3', 'identity'), ('change', 'tty', None)], name
            assert found[1]['DEVNAME'] == head.name
            head.send(wire.packet(kind, b'first'))
            assert events.take() == [], name
        head.send(wire.debug('no identity'), wire.hours([5]), wire.temperatures([99]))
        assert events.properties() == []

    def test_flapping(self):
        """For any number of changes: one round per 100 ms, the last one with the final state."""
        head = self.synced()
        dice = random.Random(7)
        for changes, pause, least in ((300, 0, 2), (150, 0.01, 10)):
            events = self.uevents()
            began = time.monotonic()
            for number in range(changes):
                head.send(wire.errors([number % 2, dice.randrange(256)]),
                          wire.errors([0, 255 - number % 2]))
                time.sleep(pause)
            head.send(wire.errors([3, 4]))
            found = events.properties()
            rounds = (time.monotonic() - began) / 0.1 + 2
            of_dsp = [event for event in found if event['COMPONENT'] == 'dsp']
            assert len(of_dsp) <= rounds
            assert len(found) <= 2 * rounds
            assert len(of_dsp) >= least
            last = {event['COMPONENT']: event['ERROR'] for event in found}
            assert last == {'head': 'range', 'dsp': 'power'}

    def test_flapping_sync(self):
        head = self.synced()
        events = self.uevents()
        began = time.monotonic()
        for _ in range(300):
            head.send(b'junk', head_rig.GOOD)
            time.sleep(0.005)
        found = events.properties()
        assert len(found) <= (time.monotonic() - began) / 0.1 + 2
        assert len(found) > 5
        assert found[-1]['IN_SYNC'] == '1'

    def test_udev_replays_it(self):
        """udevadm trigger: the uevent file works, and adds no properties of the driver."""
        head = self.synced()
        events = self.uevents()
        write_file(head.path + '/uevent', 'change')
        found = events.take()
        assert [(event['ACTION'], event.get('XY3_EVENT')) for event in found] == \
            [('change', None)]


class TestTrace(Case):
    def set_up(self):
        super().set_up()
        for name in ('xy3_packet', 'xy3_sync', 'xy3_frame'):
            write_file(EVENTS + name + '/enable', '1')
            self.add_cleanup(write_file, EVENTS + name + '/enable', '0')
        with open(TRACING + 'trace', 'w', encoding='ascii'):
            pass                                    # opening it for writing empties it

    def lines(self):
        """-> [(event, text), ...]"""
        found = []
        for line in read_file(TRACING + 'trace').splitlines():
            if not line.startswith('#'):
                name, _, text = line.split(': ', 1)[1].partition(': ')
                found.append((name, text))
        return found

    def test_packets_and_sync(self):
        head = self.attach()
        head.send(b'ju' + wire.sync() + wire.packet(0x33, b'\x01\xff') + b'!')
        assert self.lines() == [
            ('xy3_packet', 'xy3-0 type=41 length=0 payload='),
            ('xy3_packet', 'xy3-0 type=33 length=2 payload=01 ff')]
        head.send(wire.sync() + b'H')
        head.send(bytes([0x20, 255]) + bytes(range(255)))
        head.send(b'junk')
        lines = self.lines()[2:]
        assert lines[-1][0] == 'xy3_sync'
        assert lines[-1][1] == 'xy3-0 in_sync=0 dropped=%d' % head.stat('dropped_bytes')
        assert ('xy3_packet',
                'xy3-0 type=20 length=255 payload=' + bytes(range(255)).hex(' ')) in lines
        assert ('xy3_sync', 'xy3-0 in_sync=1 dropped=3') in lines

    def test_frames(self):
        head = self.synced()
        writer = head.open(os.O_RDWR)
        for frame in (wire.command_frame('calibrate', 'x'),
                      wire.command_frame('reference', bits=32)):
            assert head_rig.error_name(os.write, writer.fd, frame) == 'ENODEV'
        assert head.set('autocalib', 'on y') == 'ENODEV'
        assert head_rig.error_name(os.write, writer.fd, b'bad') == 'EINVAL'
        frames = [text for name, text in self.lines() if name == 'xy3_frame']
        assert frames == [
            'xy3-0 error=-19 frames=' + wire.command_frame('calibrate', 'x').hex(' '),
            'xy3-0 error=-19 frames=' + wire.command_frame('reference', bits=32).hex(' '),
            'xy3-0 error=-19 frames=' + wire.command_frame('autocalib on', 'y').hex(' ')]
