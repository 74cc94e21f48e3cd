# SPDX-License-Identifier: GPL-2.0-only
"""All commands of the documents, run in order, with the required devices."""

import contextlib
import glob
import os

import pytest
from head_rig import error_name
from permissions import DIALOUT, wait_access
from harness import (BIND_TIME, Plugged, command, read_file, settle, unload_modules, wait_for,
                     write_file)
from serial_head import CLASS, DEVICES, STICK, heads, module, peer, plug, stop_ldattach, unplug
from typed_document import Document
from virtual_head import SIM, UART, VirtualHead, sim

ATTACH = 'xy3ctl attach --daemon /dev/ttyXY3SIM0'

pytestmark = pytest.mark.timeout(1200)    # an emulated machine is slow


# --- devices -----------------------------------------------------------------------------------

def wait_group(node):
    wait_for(lambda: os.path.exists(node) and os.stat(node).st_gid == DIALOUT,
             'the group of ' + node, BIND_TIME)


@contextlib.contextmanager
def pendant():
    with Plugged('HB04') as plugged:
        wait_group(plugged.node)
        wait_access(plugged.path('dro'))
        yield plugged


def wait_head(head):
    """Waits until the group has access to new nodes and files."""
    head.wait_bound()
    wait_group(head.buffer)
    wait_group(head.node)
    wait_access(head.path('.'))
    wait_access(head.iio + '/.')


@contextlib.contextmanager
def head(**parameters):
    with VirtualHead(**parameters) as virtual:
        wait_head(virtual)
        yield virtual


@contextlib.contextmanager
def head_by(document, text):
    """The virtual head that a command of the document creates"""
    document.run(text)
    virtual = VirtualHead()
    try:
        virtual.spi = '/sys/bus/spi/devices/' + sim('devices').split()[1]
        wait_head(virtual)
        yield virtual
    finally:
        unload_modules('xy3-sim')


@contextlib.contextmanager
def attached_by(document, text):
    """Its backchannel, attached by a command of the document"""
    document.run(text)
    try:
        wait_for(lambda: read_file(CLASS + '/xy3-0/in_sync') == '1\n', 'sync', BIND_TIME)
        yield
    finally:
        command('xy3ctl', 'detach', UART)


def work(plugged):
    """Operate a pendant: selector to X, STEP++ down, three detents, release all"""
    plugged.usb.select(0x11)
    plugged.usb.press(0x0D)
    plugged.usb.turn(3)
    plugged.usb.release(0x0D)
    plugged.usb.select(0)


def check_lcd(plugged, **fields):
    def shown():
        every = plugged.usb.lcd.as_dict()
        return {name: every[name] for name in fields}

    wait_for(lambda: shown() == fields, 'on the LCD: %r' % fields)


def healthy(found):
    """The output of a doctor without findings"""
    assert 'found' not in found, found


# --- pages -------------------------------------------------------------------------------------

def test_first_page():
    with Document('README.md') as document:
        with pendant() as plugged:
            document.run("xhcctl set position='135.17 -77.89 0 -220.334 0 1.5' step=10 state=run")
            document.run('xhcctl set feedrate=1200 spindle_speed=18000 feedrate_override=100 '
                         'spindle_override=80')
            check_lcd(plugged, work_x='135.1700', machine_z='1.5000', step=10, state='run',
                      feedrate=1200, spindle_override=80)
            document.follow('xhcctl monitor', lambda: work(plugged), 'selector X', 'wheel    +3',
                            'STEP++       up', ready='start')
        with head_by(document, 'modprobe xy3-sim lines=4 framing=line realtime=1'), \
                attached_by(document, ATTACH):
            document.run('echo 10000 changes > /sys/kernel/debug/xy3-sim/0/record')
            document.run('cd userspace/examples')
            sent = document.run('./figure.py circle square | ./stream.py --rate 20000')
            assert sent.startswith('5378 scans sent, '), sent
            document.shows('./draw.py')
            document.follow('xy3ctl watch', lambda: None, 'in_sync', 'temperature/head')


def test_page_on_installing():
    with Document('userspace/doc/install.md') as document:
        document.elsewhere('apt install dkms linux-headers-$(uname -r)', 'make install',
                           test='test-fresh-machine, alone')
        document.elsewhere("grep 'left out' /var/lib/dkms/xhc-xy3/*/*/*/log/make.log",
                           test='test-packages, by-need')
        document.elsewhere('make deb',
                           'apt install ./build/deb/*.deb linux-headers-$(uname -r)',
                           test='build-debs, test-packages')
        document.elsewhere('sudo usermod -aG dialout "$USER"', test='setpriv is as good')
        document.elsewhere('mokutil --import /var/lib/dkms/mok.pub',
                           test='secure-boot, by what the kernel sees of it')
        document.elsewhere(
            'openssl req -new -x509 -nodes -newkey rsa:2048 -days 3650 -subj "/CN=my modules/" '
            '-outform DER -keyout /etc/dkms/my.key -out /etc/dkms/my.der',
            'echo mok_signing_key=/etc/dkms/my.key >> /etc/dkms/framework.conf',
            'echo mok_certificate=/etc/dkms/my.der >> /etc/dkms/framework.conf',
            'dpkg-reconfigure xhc-xy3-dkms', test='test-packages own-key')
        document.elsewhere('mokutil --import /etc/dkms/my.der',
                           test='secure-boot, by what the kernel sees of it')


def test_page_on_tools():
    command('modprobe', 'uhid')
    with Document('userspace/doc/tools.md') as document:
        with pendant() as plugged:
            pendant_by_tool(document, plugged)
        module.load()
        with head(lines=4, framing='line') as virtual, virtual.attached():
            head_by_tool(document, virtual)


def test_page_on_pendants():
    with Document('userspace/doc/pendant.md') as document:
        with pendant() as plugged:
            document.follow('evtest /dev/input/xhc-hb04', lambda: work(plugged),
                            'code 734 (BTN_TRIGGER_HAPPY31), value 1',
                            'code 7 (REL_DIAL), value 3', ready='Testing')
            pendant_layouts(document, plugged)
            document.run('echo 1 | tee /sys/bus/hid/drivers/hid-xhc/*/swap_feed_spindle')
            assert read_file(plugged.path('swap_feed_spindle')) == '1\n'
            write_file(plugged.path('swap_feed_spindle'), '0')
            document.run('echo options hid-xhc swap_feed_spindle=Y > /etc/modprobe.d/hid-xhc.conf')
            assert 'swap_feed_spindle=Y' in command('modprobe', '-c'), 'modprobe does not know'
            os.unlink('/etc/modprobe.d/hid-xhc.conf')
            document.run('cd /sys/bus/hid/drivers/hid-xhc/0003:10CE:EB70.*/dro')
            document.run('echo 135.17 -77.89 0 -220.334 0 1.5 > position; echo 10 > step; '
                         'echo run > state')
            document.run('echo 1200 > feedrate; echo 18000 > spindle_speed')
            document.run('echo 100 > feedrate_override; echo 80 > spindle_override')
            check_lcd(plugged, work_y='-77.8900', machine_x='-220.3340', step=10, state='run',
                      spindle_speed=18000, feedrate_override=100)
        document.run('cp -r /usr/share/xhc-xy3/linuxcnc ~/xhc-hb04')
        document.run('cd ~/xhc-hb04')
        document.elsewhere('linuxcnc xhc-hb04.ini', test='check-uml, test_linuxcnc')


def pendant_by_tool(document, plugged):
    assert 'HB04' in document.run('xhcctl list'), 'HB04 in the list'
    document.run('xhcctl set work_x=135.17 state=run step=10')
    check_lcd(plugged, work_x='135.1700', state='run', step=10)
    assert '135.17' in document.run('xhcctl show'), 'work_x'
    document.follow('xhcctl monitor', lambda: work(plugged), 'selector off', ready='start')
    healthy(document.run('xhcctl doctor'))
    recorded = '/src/pendant.hid'
    document.follow('xhcctl record pendant.hid', lambda: (
        wait_for(lambda: os.path.exists(recorded) and 'R: ' in read_file(recorded), 'recording'),
        work(plugged),
        wait_for(lambda: read_file(recorded).count('E: ') >= 5, 'reports')))
    document.run('xhcctl replay pendant.hid')


def pendant_layouts(document, plugged):
    assert 'hb04-16' in document.run('xhcctl layout list'), 'hb04-16'
    document.run('xhcctl layout hb04-16 --apply')
    assert code_of(plugged, 0x01) == 'KEY_STOP'
    document.run('xhcctl layout default --apply')
    assert code_of(plugged, 0x01) == 'BTN_TRIGGER_HAPPY1'
    document.file('cat /etc/udev/hwdb.d/61-xhc-pendant.hwdb')
    document.run('systemd-hwdb update && udevadm control --reload && '
                 'udevadm trigger /dev/input/xhc-hb04')
    settle()
    assert code_of(plugged, 0x17) == 'KEY_STOPCD'
    command('xhcctl', 'layout', 'default', '--apply')


def code_of(plugged, scan):
    """The event code of a key now"""
    plugged.open()
    plugged.usb.press(scan)
    report = plugged.events.report()
    plugged.usb.release(scan)
    return report[1].split()[0]


def test_page_on_scanheads():
    module.load()
    with Document('userspace/doc/scanhead.md') as document:
        head_of_examples(document)
        head_on_a_stick(document)
        head_on_spidev(document)
        with head(lines=4, framing='line') as virtual:
            head_told(document, virtual)
            with virtual.attached():
                head_read(document)


def head_by_tool(document, virtual):
    assert 'xy3-0' in document.run('xy3ctl list'), 'xy3-0 in the list'
    wait_for(lambda: error_name(read_file, virtual.path('serial')) is None, 'the serial number',
             BIND_TIME)
    assert 'Virtual' in document.run('xy3ctl show')
    document.follow('xy3ctl watch', lambda: None, 'in_sync', 'temperature/head')
    document.follow('xy3ctl packets --raw', lambda: None, 'temperatures head=')
    document.run('xy3ctl goto x=524288 y=524288')
    assert virtual.positions(20)[:2] == [524288, 524288]
    sent = document.run('xy3ctl stream circle --rate 20000 --repeat 10')
    assert 'scans' in sent, sent
    document.run('xy3ctl command calibrate xy')
    wait_for(lambda: sim('commands').endswith('calibrate xy'), 'the command')
    document.run('xy3ctl command rate 230400')
    assert sim('rate') == '230400'
    healthy(document.run('xy3ctl doctor'))


def head_of_examples(document):
    with head_by(document, 'modprobe xy3-sim lines=4 framing=line'), \
            attached_by(document, ATTACH):
        document.run('echo 100000 changes > /sys/kernel/debug/xy3-sim/0/record')
        document.run('cd userspace/examples')
        document.run('./figure.py circle grid | ./stream.py')
        assert '⠒' in document.run('./draw.py; ./draw.py -o circle.png'), 'a picture'
        assert os.path.getsize('/src/userspace/examples/circle.png') > 100, 'another picture'


def head_on_a_stick(document):
    plug(STICK, rate=115200)
    try:
        document.run('ldattach -s 115200 -8 -n -1 29 /dev/ttyUSB0')
        wait_for(heads, 'head', BIND_TIME)
        peer.request(STICK, 'report', 'sync', 'sync')
        wait_for(lambda: read_file(CLASS + '/xy3-0/in_sync') == '1\n', 'sync', BIND_TIME)
        document.shows('cat /sys/class/xy3/xy3-0/in_sync')
    finally:
        stop_ldattach(DEVICES[STICK])
        wait_for(lambda: not heads(), 'end of the head', BIND_TIME)
        unplug(STICK)
    document.file('cat /etc/udev/rules.d/69-my-heads.rules')
    document.elsewhere('systemctl status xy3-attach@ttyUSB0', test='lint, live-udev')


def head_on_spidev(document):
    with VirtualHead(driver=None, modalias='spidev'):
        names = [('spi0.0', sim('devices').split()[1])]
        document.run('modprobe xy3-spi')
        for text in ('echo xy3-spi > /sys/bus/spi/devices/spi0.0/driver_override',
                     'echo spi0.0 > /sys/bus/spi/drivers/spidev/unbind',
                     'echo spi0.0 > /sys/bus/spi/drivers/xy3-spi/bind'):
            document.run(text, names)
        assert heads() == ['xy3-0']


def head_told(document, virtual):
    document.run('cd /sys/bus/iio/devices/iio:device0')
    document.run('echo 524288 > out_angl0_raw')
    assert virtual.positions(20)[0] == 524288
    before = virtual.number('scans')
    document.program()
    assert virtual.number('scans') - before >= 100000, 'a hundred circles'
    wait_group(virtual.node)
    document.run('echo x > /sys/class/xy3/xy3-0/calibrate')
    document.run("printf '\\060\\000\\007' > /dev/xy3")
    wait_for(lambda: [line.split(' ', 2)[2] for line in sim('commands').splitlines()] ==
             ['calibrate x'] * 2, 'both commands')


def head_read(document):
    def fail():
        write_file(SIM + 'errors', ' '.join(['0'] * 12 + ['1']))
        write_file(SIM + 'report', '1')

    document.follow_program(lambda: write_file(SIM + 'report', '1'), 'temperatures [', 'errors [')
    wait_for(lambda: glob.glob(CLASS + '/xy3-0/hwmon*/temp1_input'), 'a thermometer', BIND_TIME)
    assert 'head:' in document.run('sensors'), 'the head in sensors'
    document.follow('udevadm monitor -p -s xy3', fail, 'XY3_EVENT=error', 'XY3_COMPONENT=galvo_x',
                    'XY3_ERROR=temperature', 'XY3_ERROR_CODE=1', ready='KERNEL')
    document.file('cat /etc/udev/rules.d/90-scanhead.rules')
    document.run('stty -F /dev/xy3 230400')
    wait_for(lambda: sim('rate') == '230400', 'the rate at the head', BIND_TIME)
    write_file(CLASS + '/xy3-0/rate', '115200')
    document.run('echo 230400 > /sys/class/xy3/xy3-0/rate')
    assert sim('rate') == '230400'
    document.run('echo 1 > /sys/class/xy3/xy3-0/autobaud')
    document.run('echo options xy3 autobaud=Y > /etc/modprobe.d/xy3.conf')
    assert 'autobaud=Y' in command('modprobe', '-c'), 'modprobe does not know'
    for path in ('/etc/modprobe.d/xy3.conf', '/etc/udev/rules.d/69-my-heads.rules',
                 '/etc/udev/rules.d/90-scanhead.rules'):
        os.unlink(path)
