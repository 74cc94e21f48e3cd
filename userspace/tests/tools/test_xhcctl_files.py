# SPDX-License-Identifier: GPL-2.0-only
"""xhcctl with virtual pendants: record, replay, and a layout that is activated."""

import json
import os
import shutil
import signal
import subprocess
import time

import rig
from rig import Case, pressed, released, selected, turned
from tool import FAILURE, INTERRUPTED, NO_DEVICE, OK
from xhc_sim import find
from xhc_sim.models import REPORT_DESCRIPTOR
from xhcctl_tool import LAYOUTS, Follower, environment, run, xhcctl
import re

FOLDER = '/run/recordings'


class FileCase(Case):
    def set_up(self):
        super().set_up()
        os.makedirs(FOLDER, exist_ok=True)

    def follow(self, *arguments, **options):
        follower = Follower(*arguments, **options)
        self.add_cleanup(follower.kill)
        return follower

    def assert_says(self, result, status, *words):
        assert result.status == status, result.err
        for word in words:
            assert word in result.err

    @staticmethod
    def as_nobody(*arguments):
        """Runs copies: only the owner may have access to the checkout."""
        shutil.copy(xhcctl.path, '/run/xhcctl')
        shutil.copytree(LAYOUTS, '/run/layouts', dirs_exist_ok=True)
        return run(*arguments, executable='/run/xhcctl', user=65534, group=65534, cwd='/',
                   env=environment(XHC_LAYOUTS='/run/layouts'))

    @staticmethod
    def write(name, text):
        path = os.path.join(FOLDER, name)
        with open(path, 'w', encoding='ascii') as file:
            file.write(text)
        return path


class TestRecord(FileCase):
    def begun(self, *arguments):
        """Waits for the head of the recording on standard output."""
        follower = self.follow('record', *arguments)
        return follower, [follower.line() for _ in range(4)]

    def test_head_and_reports(self):
        """No line `D: 0': hid-replay 0.12 stops at it"""
        for model, product in (('HB03', 'eb6e'), ('HB04', 'eb70')):
            pendant = self.plug(model)
            follower, head = self.begun('--count', '2')
            assert head == [
                'R: %d %s' % (len(REPORT_DESCRIPTOR), REPORT_DESCRIPTOR.hex(' ')),
                'N: KTURT.LTD', 'P: ' + pendant.device.phys, 'I: 3 10ce ' + product]
            pendant.report(key1=1, selector=0x11, wheel=-1, day=0)
            time.sleep(1.5)
            pendant.report(day=0)
            first, second = follower.rest()
            assert first == 'E: 000000.000000 6 04 01 00 11 ff 01'
            assert re.search(r'^E: 00000[12]\.\d{6} 6 04 00 00 00 00 00$', second)
            assert follower.end() == (OK, '')
            pendant.unplug()

    def test_to_a_file_until_interrupted(self):
        pendant = self.plug()
        path = os.path.join(FOLDER, 'interrupted')
        follower = self.follow('record', '--json', path)
        assert find.wait(lambda: os.path.exists(path) and
                                  'I: 3' in rig.read_file(path), 20)
        pendant.report(key1=1)
        assert find.wait(lambda: 'E: ' in rig.read_file(path), 20)
        follower.process.send_signal(signal.SIGINT)
        assert json.loads(follower.line()) == {
            'schema': 1, 'tool': 'xhcctl', 'verb': 'record', 'file': path, 'reports': 1,
            'name': os.path.basename(pendant.path)}
        assert follower.end() == (INTERRUPTED, '')
        assert run('replay', '-c', path).status == OK

    def test_unplugged(self):
        pendant = self.plug()
        follower, _ = self.begun()
        pendant.report(key1=1)
        assert follower.line().startswith('E: ')
        pendant.unplug()
        assert follower.rest() == []
        status, err = follower.end()
        assert status == NO_DEVICE
        assert 'has gone' in err

    def test_time_is_up(self):
        self.plug()
        assert run('record', '--timeout', '.1').status == OK
        self.assert_says(run('record', '-t', '.1', '-n', '1'), FAILURE, 'timed out: 0 of 1')

    def test_a_file_that_cannot_be_written(self):
        self.plug()
        self.assert_says(run('record', FOLDER), FAILURE, 'Is a directory')
        assert run('record', '-t', '5', '/dev/full').status == FAILURE

    def test_not_allowed(self):
        """The hidraw node requires root."""
        self.plug()

        self.assert_says(self.as_nobody('record'), FAILURE, '/dev/hidraw', 'Permission denied')


class TestReplay(FileCase):
    SCENE = ((1, 0, 0x11, 0), (1, 2, 0x11, -3), (0, 2, 0x12, 5), (0, 0, 0x12, 0), (0, 0, 0, 127),
             (0x16, 0x17, 0, -128), (0, 0, 0, 0))
    EVENTS = (selected(0, 1) + pressed(1), pressed(2) + turned(-3),
              selected(1, 2) + released(1) + turned(5), released(2),
              selected(2, 0) + turned(127), pressed(0x16) + pressed(0x17) + turned(-128),
              released(0x16) + released(0x17))

    def play(self, scene, pendant):
        for key1, key2, selector, wheel in scene:
            pendant.report(key1, key2, selector, wheel)

    def recorded(self, name):
        pendant = self.plug(phys='recorded-%s/input0' % name)
        path = os.path.join(FOLDER, name)
        follower = self.follow('record', '--count', str(len(self.SCENE)), path)
        assert find.wait(lambda: os.path.exists(path) and
                                  'I: 3' in rig.read_file(path), 20)
        self.play(self.SCENE, pendant)
        assert follower.end() == (OK, '')
        for events in self.EVENTS:
            assert [event for event in pendant.packet()] == \
                             events
        pendant.unplug()
        return path, pendant.device.phys

    def eyes(self, phys):
        """Events on the node of the pendant that replay creates."""
        path = find.wait(lambda: find.hid_directory(phys), 20)
        assert path
        node = find.wait(lambda: find.nodes(path)[0], 20)
        assert find.wait(lambda: os.path.exists(node), 20)
        eyes = rig.EvdevReader(node)
        self.add_cleanup(eyes.close)
        return eyes

    def test_what_was_recorded_gives_the_same_events(self):
        for number, more in enumerate(([], ['--fast'])):
            path, phys = self.recorded('same%d' % number)
            follower = self.follow('replay', '--json', '--before', '20', '--after', '20', path,
                                   *more)
            eyes = self.eyes(phys)
            for events in self.EVENTS:
                assert eyes.packet(40) == events
            document = follower.document()
            assert (document['reports'], document['sent']) == (7, 7)
            assert follower.end() == (OK, '')
            assert find.wait(lambda: not find.hid_directory(phys), 20)

    def timed(self, *more):
        path = self.write('timed', 'R: %d %s\nP: timed/input0\nI: 3 10ce eb70\n' % (
            len(REPORT_DESCRIPTOR), REPORT_DESCRIPTOR.hex(' ')) +
            'E: 000100.000000 6 04 01 00 00 00 01\nE: 000103.000000 6 04 02 00 00 00 02\n')
        self.follow('replay', '--before', '20', '--after', '20', path, *more)
        eyes = self.eyes('timed/input0')
        assert eyes.packet(40) == pressed(1)
        began = time.monotonic()
        assert eyes.packet(40) == released(1) + pressed(2)
        return time.monotonic() - began

    def test_the_recorded_pauses(self):
        assert self.timed() > 2.5

    def test_fast(self):
        assert self.timed('--fast') < 2.5

    def test_the_display_of_a_replayed_one(self):
        """Its frames are accepted; it works like any other pendant."""
        path, phys = self.recorded('display')
        follower = self.follow('replay', '--before', '30', path)
        self.eyes(phys)
        self.assert_says(run('set', '-d', phys, '--wait', 'work_x=1'), OK)
        assert run('show', '-d', phys, '-j').json()[0]['dro']['work_x'] == 1
        assert follower.end(signal.SIGINT)[0] == INTERRUPTED

    def test_no_driver(self):
        path = self.write('strange', 'R: %d %s\nI: 3 1234 5678\n' % (
            len(REPORT_DESCRIPTOR), REPORT_DESCRIPTOR.hex(' ')))
        self.assert_says(run('replay', path), FAILURE, 'no driver is bound')

    def test_a_descriptor_that_the_kernel_refuses(self):
        path = self.write('broken', 'R: 3 c0 c0 c0\nI: 3 10ce eb70\n')
        self.assert_says(run('replay', path), FAILURE)

    def test_a_hostile_file_makes_no_device(self):
        path = self.write('hostile', 'R: 1 00\nP: hostile/input0\nI: 3 10ce eb70\nE: x\n')
        self.assert_says(run('replay', path), FAILURE, 'hostile:4: ')
        assert find.hid_directory('hostile/input0') is None

    def test_without_uhid(self):
        os.rename('/dev/uhid', '/dev/uhid.away')
        self.add_cleanup(os.rename, '/dev/uhid.away', '/dev/uhid')
        path = self.write('good', 'R: 1 00\nI: 3 10ce eb70\n')
        self.assert_says(run('replay', path), NO_DEVICE, 'modprobe uhid')


class TestApply(FileCase):
    """With programs instead of udev that record their arguments."""

    CALLED = '/run/called'
    SOCKET = '/run/udev/control'    # of udevd
    RELOAD = ['systemd-hwdb update', 'udevadm control --reload']

    @staticmethod
    def trigger(pendant):
        settle = 'udevadm settle --timeout=60'
        return [settle, 'udevadm trigger ' + pendant.event_node, settle]

    def set_up(self):
        super().set_up()
        os.makedirs('/run/udev', exist_ok=True)
        with open(self.SOCKET, 'w', encoding='ascii'):
            pass
        self.add_cleanup(os.unlink, self.SOCKET)

    def apply(self, name, status=0):
        folder = '/run/programs'
        os.makedirs(folder, exist_ok=True)
        for program in ('systemd-hwdb', 'udevadm'):
            path = os.path.join(folder, program)
            with open(path, 'w', encoding='ascii') as file:
                file.write('#!/bin/sh\necho %s "$@" >> %s\nexit %d\n' % (
                    program, self.CALLED, status))
            os.chmod(path, 0o755)
        with open(self.CALLED, 'w', encoding='ascii'):
            pass
        # a separate /etc, as the root of the kernel is that of the host
        return subprocess.run(
            ['unshare', '-m', 'sh', '-c', 'mount -t tmpfs tmpfs /etc && "$0" layout %s --apply; '
             'status=$?; cat /etc/udev/hwdb.d/* 2> /dev/null; exit $status' % name, xhcctl.path],
            env=environment(PATH=folder + ':' + os.environ['PATH']), check=False,
            stdin=subprocess.DEVNULL, capture_output=True, text=True)

    def called(self):
        return rig.read_file(self.CALLED).splitlines()

    def test_layout(self):
        one, two = self.plug(), self.plug('HB03')
        result = self.apply('hb04-16')
        assert (result.returncode, result.stderr) == (OK, '')
        assert result.stdout == run('layout', 'hb04-16').out
        assert self.called() == self.RELOAD + self.trigger(one) + self.trigger(two)

    def test_nothing_is_triggered_without_a_pendant(self):
        assert self.apply('hb04-16').returncode == OK
        assert self.called() == self.RELOAD

    def test_without_udevd(self):
        """As in a container: udevadm would fail. There is a pendant, whose codes are not set."""
        self.plug()
        os.rename(self.SOCKET, self.SOCKET + '.away')
        self.add_cleanup(os.rename, self.SOCKET + '.away', self.SOCKET)
        for name in 'hb04-16', 'default':
            result = self.apply(name)
            assert (result.returncode, result.stderr) == (OK, '')
            assert self.called() == self.RELOAD[:1]

    def test_default(self):
        pendant = self.plug()
        result = self.apply('default')
        assert (result.returncode, result.stdout, result.stderr) == (OK, '', '')
        assert self.called() == self.RELOAD + self.trigger(pendant)

    def test_a_program_that_fails(self):
        self.plug()
        result = self.apply('hb04-16', 1)
        assert result.returncode == FAILURE
        assert 'xhcctl: systemd-hwdb update has failed' in result.stderr
        assert self.called() == ['systemd-hwdb update']

    def test_without_root(self):
        self.assert_says(self.as_nobody('layout', 'hb03', '--write'), FAILURE,
                         '/etc/udev/hwdb.d/61-xhc-pendant.hwdb')
        os.mkdir('/run/closed', 0o755)
        self.add_cleanup(shutil.rmtree, '/run/closed')
        self.assert_says(self.as_nobody('layout', 'hb03', '--write', '--root', '/run/closed'),
                         FAILURE, '61-xhc-pendant.hwdb: permission denied: run this as root')

    def test_set_without_the_group(self):
        self.plug()
        self.assert_says(self.as_nobody('set', 'work_x=1'), FAILURE,
                         'work_x: permission denied: join the group dialout')

    def test_entry_for_one_pendant(self):
        pendant = self.plug()
        result = run('layout', 'hb04-16', '-d', '0')
        assert result.out.splitlines()[1] == 'evdev:name:XHC HB04 Pendant:phys:%s:*' \
                         % pendant.device.phys

    def test_how_to_put_it_to_work(self):
        pendant = self.plug()
        result = run('layout', 'hb04-16', '--write', '--root', '/run/root')
        assert 'systemd-hwdb update --root=/run/root' in result.err
        assert pendant.event_node not in result.err
