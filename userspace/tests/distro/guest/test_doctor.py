# SPDX-License-Identifier: GPL-2.0-only
"""doctor with DKMS, udev and a kernel of Debian, with faults injected into each of them.

Before each fault doctor finds nothing; if it suggests a fix that can be run here, it is run, and
doctor finds nothing again. Other faults of devices are in tests/tools/test_doctor.py.
"""

import contextlib
import fcntl
import glob
import json
import os
import struct
import subprocess

import pytest
from permissions import DIALOUT, wait_access
from harness import (BIND_TIME, Plugged, command, hid_xhc, module_loaded, read_file, reload_rules,
                     settle, unload_modules, wait_for, write_file)
from serial_head import CLASS, module
from virtual_head import VirtualHead, sim

PACKAGE = 'xhc-xy3'
KERNEL = os.uname().release
MODULES = '/lib/modules/' + KERNEL
RULES = '70-xhc-pendant.rules'
USBDEVFS_DISCONNECT_CLAIM = 0x8108551b

pytestmark = pytest.mark.timeout(400)     # depmod and udevd in an emulated machine


def look(tool):
    """-> {id: (text, fix)} of the findings"""
    done = subprocess.run([tool, 'doctor', '--json'], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, check=False)
    assert done.stderr == '', 'errors of %s doctor' % tool
    findings = json.loads(done.stdout)['findings']
    found = {each['id']: (each['text'], each['fix']) for each in findings
             if each['status'] == 'found'}
    assert done.returncode == (1 if found else 0), 'status of %s doctor' % tool
    return found


def well(tool):
    wait_for(lambda: not look(tool), '%s doctor finds nothing' % tool, BIND_TIME)


def check_found(tool, **wanted):
    """Exactly these findings; id=(part of the text, part of the fix)"""
    found = look(tool)
    assert sorted(found) == sorted(wanted), 'what %s doctor finds: %r' % (tool, found)
    for name, parts in wanted.items():
        for part, text in zip(parts, found[name]):
            assert part in text, '%s: no %r in %r' % (name, part, text)


def type_line(line):
    """Runs a fix printed by doctor; there is no sudo here."""
    command('sh', '-c', line.replace('sudo ', ''))


@contextlib.contextmanager
def away(path):
    """Temporarily removes files"""
    os.rename(path, path + '.away')
    try:
        yield
    finally:
        os.rename(path + '.away', path)


@contextlib.contextmanager
def pendant():
    with Plugged('HB04') as plugged:
        wait_for(lambda: os.stat(plugged.node).st_gid == DIALOUT, 'group of the node', BIND_TIME)
        wait_access(plugged.path('dro'))
        well('xhcctl')
        yield plugged
        well('xhcctl')


@contextlib.contextmanager
def head():
    module.will_come()
    with VirtualHead(lines=2, framing='cs') as virtual, virtual.attached():
        wait_access(virtual.path('.'))
        yield virtual


# --- how it is installed -----------------------------------------------------------------------

def test_headers_are_no_fault_when_the_modules_are_there():
    with pendant(), away(MODULES + '/build'):
        well('xhcctl')


@contextlib.contextmanager
def kept(*paths):
    """Restores these files and folders afterwards."""
    for number, path in enumerate(paths):
        copy = '/tmp/kept-%d' % number
        command('cp', '-a', path, copy)
    try:
        yield
    finally:
        for number, path in enumerate(paths):
            command('rm', '-rf', path)
            command('mv', '/tmp/kept-%d' % number, path)


def test_doctor_finds_modules_that_dkms_has_only_added():
    """As with a new kernel that was installed without headers.

    Building the modules again and depmod would take too long: the lines of our modules are removed
    from its index here, and restored.
    """
    if module_loaded('hid_xhc'):
        hid_xhc.unload()
    version, = map(os.path.basename, glob.glob('/var/lib/dkms/%s/[0-9]*' % PACKAGE))
    index = MODULES + '/modules.dep'
    with kept('/var/lib/dkms/' + PACKAGE, MODULES + '/updates', index):
        command('dkms', 'unbuild', '%s/%s' % (PACKAGE, version), '-k', KERNEL, '--no-depmod')
        command('sed', '-i', '/^updates/d', index)
        assert ': added' in command('dkms', 'status', PACKAGE)
        found = look('xhcctl')
        assert sorted(found) == ['dkms', 'driver']
        assert 'sudo dkms install %s/%s -k %s' % (PACKAGE, version, KERNEL) in found['dkms'][1]
        with away(MODULES + '/build'):
            found = look('xhcctl')
        assert sorted(found) == ['dkms', 'driver', 'headers']
        assert 'of kernel %s are missing' % KERNEL in found['headers'][0]
        assert found['headers'][1] == 'sudo apt install linux-headers-' + KERNEL
    with pendant():
        pass


def test_doctor_finds_missing_rules():
    place, = [path for path in glob.glob('/usr/lib/udev/rules.d/*') if path.endswith(RULES)]
    with pendant():
        with away(place):
            check_found('xhcctl', rules=(RULES + ' is missing', 'make install'))
        reload_rules()      # udevd may have read them while they were removed


def test_doctor_finds_rules_that_are_switched_off():
    with pendant():
        os.symlink('/dev/null', '/etc/udev/rules.d/' + RULES)
        found = look('xhcctl')
        assert list(found) == ['rules'], 'what is found: %r' % found
        type_line(found['rules'][1])
        reload_rules()


def test_doctor_finds_a_pendant_without_permissions():
    """Plugged in while the rules were removed"""
    with pendant() as plugged:
        os.chown(plugged.node, 0, 0)
        os.chmod(plugged.node, 0o600)
        found = look('xhcctl')
        assert list(found) == ['access'], 'what is found: %r' % found
        type_line(found['access'][1])
        settle()


# --- pendants ----------------------------------------------------------------------------------

def test_doctor_finds_a_program_that_holds_the_pendant():
    """Claimed as by libusb: the kernel driver is detached."""
    with pendant() as plugged:
        interface = os.path.dirname(os.path.realpath(plugged.directory))
        usb = os.path.dirname(interface)
        node = '/dev/bus/usb/%03d/%03d' % tuple(
            int(read_file('%s/%s' % (usb, name))) for name in ('busnum', 'devnum'))
        plugged.events.close()
        fd = os.open(node, os.O_RDWR)
        try:
            fcntl.ioctl(fd, USBDEVFS_DISCONNECT_CLAIM, struct.pack('II256s', 0, 0, b''), False)
            text, fix = look('xhcctl')['holder']
            assert 'python3 has detached %s' % os.path.basename(interface) in text, text
            assert 'kill %d && sleep 1 && echo ' % os.getpid() in fix, fix
        finally:
            os.close(fd)
        before = plugged.usb.frame_count
        type_line(fix.split(' && ', 1)[1])     # the holder has exited already
        plugged.wait_bound(before)


def test_doctor_finds_a_pendant_without_driver():
    with pendant() as plugged:
        name = os.path.basename(plugged.directory)
        plugged.events.close()
        write_file('/sys/bus/hid/drivers/hid-xhc/unbind', name)
        text, fix = look('xhcctl')['driver']
        assert '%s has no driver' % name in text, text
        assert 'modprobe hid-xhc' in fix, fix
        before = plugged.usb.frame_count
        type_line(fix)
        plugged.wait_bound(before)


# --- scanheads ---------------------------------------------------------------------------------

def test_doctor_finds_another_number_of_the_line_discipline():
    unload_modules('xy3-sim', 'xy3-spi', 'xy3')
    command('modprobe', 'xy3', 'ldisc=28')
    try:
        text, fix = look('xy3ctl')['ldisc']
        assert 'number 28 instead of 29' in text, text
        assert '-n -1 28' in fix, fix
    finally:
        unload_modules('xy3')
    module.load()
    assert 'ldisc' not in look('xy3ctl'), 'it is found with the right number, too'


def test_doctor_finds_a_head_at_another_rate():
    with head() as virtual:
        well('xy3ctl')
        device = os.path.basename(virtual.spi)
        # while bound, it would send the rate to the head
        write_file('/sys/bus/spi/drivers/xy3-spi/unbind', device)
        write_file(CLASS + '/xy3-0/rate', '57600')
        found = wait_for(lambda: look('xy3ctl').get('back'), 'it is found', BIND_TIME)
        assert '57600' in found[0], found[0]
        type_line(found[1])
        wait_for(lambda: 'back' not in look('xy3ctl'), 'the rate is found', BIND_TIME)
        assert read_file(CLASS + '/xy3-0/rate').strip() == sim('rate')
        found = look('xy3ctl')
        assert list(found) == ['spi'], 'what is found: %r' % found
        write_file('/sys/bus/spi/drivers/xy3-spi/bind', device)
        virtual.wait_bound()
