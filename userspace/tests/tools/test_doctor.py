# SPDX-License-Identifier: GPL-2.0-only
"""doctor with real faults of virtual pendants and heads, each compared with the device without it.

Checks of the installation (headers, DKMS, Secure Boot, udev's rules) are in test_doctor_root.py:
the test kernel has none of these.
"""

import fcntl
import grp
import os
import shutil
import struct
import subprocess

import forward_rig
import head_rig
import rig
from kernel import read_file, wait, write_file
from tool import FAILURE, OK, Tool
from xy3_head_sim import wire

xhcctl, xy3ctl = Tool('xhcctl'), Tool('xy3ctl')
INSTALLATION = {'headers', 'dkms', 'module', 'blacklist', 'version', 'signature', 'rules'}
USBDEVFS_DISCONNECT_CLAIM = 0x8108551b
USBDEVFS_RELEASEINTERFACE = 0x80045510
LIMIT = 60              # timeout in seconds; an idle machine needs none of it
DIALOUT = grp.getgrnam('dialout').gr_gid


def look(tool, *words):
    """-> {id: [(status, text, fix), ...]} of the checks of devices"""
    status, output, errors = tool.run('doctor', '--json', *words)
    document, = tool.documents(output)
    found = any(finding['status'] == 'found' for finding in document['findings'])
    if errors or status != (FAILURE if found else OK):
        raise AssertionError('status %d, %s: %s' % (status, errors, output))
    findings = {}
    for finding in document['findings']:
        if finding['id'] not in INSTALLATION:
            findings.setdefault(finding['id'], []).append(
                (finding['status'], finding['text'], finding['fix']))
    return findings


class Checks:
    """Common to cases of pendants and heads"""

    def found(self, *words):
        """-> {id: (text, fix)} of findings, except about udev: there is no udevd here"""
        return {check: finding[1:] for check, all_of_it in look(self.tool, *words).items()
                for finding in all_of_it if finding[0] == 'found' and check != 'access'}

    def assert_well(self):
        assert self.found() == {}

    def assert_found(self, check, text, fix):
        """Exactly this check has a finding"""
        found = self.found()
        assert list(found) == [check], found
        assert text in found[check][0]
        assert fix in found[check][1]

    def give(self, *paths):
        """Does what the udev rules do"""
        for path in paths:
            os.chown(path, -1, DIALOUT)
            os.chmod(path, os.stat(path).st_mode | 0o060)

    def access(self):
        return {finding[0] for finding in look(self.tool)['access']}


class TestPendant(Checks, rig.Case):
    tool = xhcctl

    def test_none(self):
        self.assert_found('driver', 'no HB03, HB04 or WHB04B', 'lsusb')

    def test_held_by_libusb(self):
        pendant = self.plug_usb()
        self.assert_well()
        interface = os.path.basename(os.path.dirname(pendant.path))
        usb = os.path.dirname(os.path.dirname(pendant.path))
        node = '/dev/bus/usb/%03d/%03d' % tuple(
            int(read_file('%s/%s' % (usb, name))) for name in ('busnum', 'devnum'))
        fd = os.open(node, os.O_RDWR)
        try:
            fcntl.ioctl(fd, USBDEVFS_DISCONNECT_CLAIM, struct.pack('II256s', 0, 0, b''), False)
            found = self.found()
            name = read_file('/proc/self/comm').strip()
            assert '%s has detached %s from its driver' % (name, interface) in \
                          found['holder'][0]
            assert 'kill %d && sleep 1 && echo %s | sudo tee /sys/bus/usb/drivers/usbhid/bind' \
                          % (os.getpid(), interface) in found['holder'][1]
            fcntl.ioctl(fd, USBDEVFS_RELEASEINTERFACE, struct.pack('I', 0))
        finally:
            os.close(fd)
        assert 'no driver' in self.found()['holder'][0]
        # the suggested fix
        write_file('/sys/bus/usb/drivers/usbhid/bind', interface)
        assert wait(lambda: not self.found())

    def test_whb04b(self):
        self.plug_usb('WHB04B')
        self.assert_well()
        (status, text, _), = look(xhcctl)['model']
        assert (status, text.split(' ', 1)[1]) == (
            'ok', '(10ce:eb93) is a WHB04B-4 or WHB04B-6, supported')

    def test_other_driver(self):
        pendant = self.plug()
        self.assert_well()
        name = os.path.basename(pendant.path)
        pendant.unbind()
        self.assert_found('driver', '%s has no driver' % name, 'modprobe hid-xhc')
        try:
            write_file('/sys/bus/hid/drivers/hid-generic/bind', name)
        except OSError:
            pass                        # it ignores devices that have their own driver
        else:
            self.assert_found('driver', 'hid-generic instead of hid-xhc', 'unbind')
            write_file('/sys/bus/hid/drivers/hid-generic/unbind', name)
        pendant.bind()
        assert wait(lambda: not self.found())

    def test_frames_that_are_not_taken(self):
        pendant = self.plug_usb()
        pendant.settle()
        self.assert_well()
        pendant.device.set_fault('stall', skip=0, count=1)
        assert pendant.set_error('flush', '1') == 'EPIPE'
        self.assert_found('state', 'has not accepted 1 display frames', 'dmesg')

    def test_unknown_key(self):
        pendant = self.plug()
        pendant.report(0x2a)
        assert wait(lambda: pendant.stat('unknown_keys'))
        self.assert_found('state', 'does not know', 'evtest')

    def test_asleep(self):
        pendant = self.plug()
        pendant.report(1)
        pendant.asleep()
        assert wait(lambda: pendant.get('awake') == '0')
        self.assert_well()
        assert 'asleep' in look(xhcctl)['state'][0][1]

    def test_access(self):
        pendant = self.plug()
        assert self.access() == {'found'}
        assert 'udevadm trigger' in look(xhcctl)['access'][0][2]
        self.give(pendant.event_node, pendant.file('flush'))
        assert self.access() == {'ok'}

    def test_access_of_users(self):
        """A user who is not a member, and a new member who has not logged in again"""
        pendant = self.plug()
        self.give(pendant.event_node, pendant.file('flush'))
        shutil.copy(xhcctl.path, '/run/xhcctl')
        for member, text, fix in (('', 'you are not in the group dialout', 'usermod -aG dialout'),
                                  ('nobody', 'but were not when you logged in', 'log out and in')):
            with open('/run/group', 'w', encoding='ascii') as file:
                file.write('root:x:0:\ndialout:x:%d:%s\n' % (DIALOUT, member))
            subprocess.run(['mount', '--bind', '/run/group', '/etc/group'], check=True)
            try:
                done = subprocess.run(['/run/xhcctl', 'doctor', '-j'], stdout=subprocess.PIPE,
                                      user=65534, group=65534, extra_groups=[], cwd='/',
                                      env={**os.environ, 'ASAN_OPTIONS': 'detect_leaks=0'},
                                      check=False)
            finally:
                subprocess.run(['umount', '/etc/group'], check=True)
            document, = xhcctl.documents(done.stdout.decode())
            access = [finding for finding in document['findings'] if finding['id'] == 'access']
            assert [finding['status'] for finding in access] == ['found', 'found']
            assert text in access[0]['text']
            assert fix in access[0]['fix']


class TestHead(Checks, forward_rig.Case):
    tool = xy3ctl

    @classmethod
    def setup_class(cls):
        forward_rig.load()

    @classmethod
    def teardown_class(cls):
        forward_rig.unload()

    def head(self, *arguments, **keywords):
        forward = self.forward(*arguments, **keywords)
        assert forward.attach()
        return forward

    def pty(self, **options):
        head = head_rig.Head(**options)
        self.add_cleanup(head.close)
        return head.attach()

    def test_none(self):
        assert wait(lambda: not head_rig.heads())
        self.assert_found('head', 'nothing is attached', 'no serial port that is free')

    def test_silent_and_at_another_rate(self):
        head = self.pty()
        self.assert_found('back', 'no byte was received', 'wires')
        head.send(b'\x00\xff' * 100)
        self.assert_found('back', 'another rate', 'autobaud')
        head.sync()
        self.assert_well()

    def test_head_at_another_rate(self):
        """A real fault, and the suggested fix"""
        forward = self.head(2, 'cs')
        assert 'back' not in self.found()
        write_file(forward.head + 'autobaud', '0')
        forward.unbind()                # else a command would set the rate of the head
        write_file(forward.head + 'rate', '57600')
        assert wait(lambda: 'back' in self.found(), LIMIT)
        assert '57600' in self.found()['back'][0]
        assert 'echo 1 | sudo tee %sautobaud' % forward.head in self.found()['back'][1]
        write_file(forward.head + 'autobaud', '1')
        assert wait(lambda: 'back' not in self.found(), LIMIT)
        forward.bind()

    def test_another_program_at_the_uart(self):
        forward = self.head(2, 'cs')
        # this process acts as ldattach, but has another name
        self.assert_found('uart', 'has /dev/ttyXY3SIM0 open', 'kill %d' % os.getpid())
        forward.close()
        attach = xy3ctl.start('attach', '/dev/ttyXY3SIM0')
        self.add_cleanup(attach.close)
        attach.line()
        assert wait(lambda: not self.found(), LIMIT), self.found()

    def test_two_halves(self):
        forward = self.forward(2, 'cs')
        write_file('/sys/class/xy3/attach', 'new')
        self.pty().sync()
        self.assert_found('head', 'xy3-1 has only a backchannel, and xy3-0 only a forward',
                         'echo xy3-0 | sudo tee /sys/class/xy3/attach')
        assert forward.device

    def test_no_driver_on_spi(self):
        forward = self.head(2, 'cs')
        forward.close()
        forward.unbind()
        assert '%s has no driver' % forward.device in self.found()['spi'][0]
        assert 'modprobe xy3-spi' in self.found()['spi'][1]
        forward.bind()
        assert 'spi' not in self.found()

    def test_controller_with_too_few_lines(self):
        self.sim(1, 'cs', more='device_lines=4')
        assert wait(lambda: 'has refused its controller' in
                             self.found().get('spi', ('',))[0])

    def test_byte_order(self):
        head = self.pty().sync()
        head.send(wire.temperatures([2980]))
        assert wait(head.hwmon_path)
        self.assert_well()
        head.send(wire.temperatures([2980], 'big'))
        assert wait(lambda: 'order' in self.found())
        assert 'echo big | sudo tee' in self.found()['order'][1]

    def test_frames_that_are_not_read(self):
        forward = self.head(2, 'cs')
        forward.set_sim('faults/spi_flip', '3')
        assert forward.set('out_angl0_raw', 5) is None
        assert forward.set('out_angl0_raw', 6) is None
        forward.set_sim('report', '1')
        assert wait(lambda: 'frames' in self.found(), LIMIT)
        assert 'SYNC and CLK' in self.found()['frames'][1]

    def test_access(self):
        forward = self.head(2, 'cs')
        assert self.access() == {'found'}
        self.give('/dev/xy3-0', forward.head + 'calibrate')
        assert self.access() == {'ok'}


class TestNumber(Checks, forward_rig.Case):
    """That of the line discipline, a module parameter"""
    tool = xy3ctl

    def test_another_number(self):
        head_rig.load('ldisc=28')
        self.add_cleanup(head_rig.unload)
        found = self.found()
        assert 'number 28 instead of 29' in found['ldisc'][0]
        assert 'ldattach -s 115200 -8 -n -1 28' in found['ldisc'][1]

    def test_our_number(self):
        head_rig.load()
        self.add_cleanup(head_rig.unload)
        assert 'ldisc' not in self.found()
        assert look(xy3ctl)['ldisc'][0][:2] == ('ok', "number 29 is xy3's")
