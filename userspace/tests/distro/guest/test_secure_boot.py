# SPDX-License-Identifier: GPL-2.0-only
"""Secure Boot is on, and the owner has enrolled the key that DKMS has signed our modules with.

Debian's kernel is locked down then: it refuses other modules, and writes to debugfs. The key was
created for the test: that created by DKMS is in the root, too, but not enrolled.
"""

import contextlib
import errno
import json
import os
import shutil
import subprocess

from harness import Plugged, command, error_of, module_loaded, read_file, unload_modules, write_file
from virtual_head import SIM, VirtualHead

EFI_VARIABLES = '/sys/firmware/efi/efivars'
SECURE_BOOT = EFI_VARIABLES + '/SecureBoot-8be4df61-93ca-11d2-aa0d-00e098032b8c'
LOCKDOWN = '/sys/kernel/security/lockdown'
SIGN = '/lib/modules/%s/build/scripts/sign-file' % os.uname().release
DKMS_KEY, DKMS_CERTIFICATE = '/var/lib/dkms/mok.key', '/var/lib/dkms/mok.pub'
REFUSED = 'Key was rejected by service'
TOOLS = {'hid-xhc': 'xhcctl', 'xy3': 'xy3ctl'}


@contextlib.contextmanager
def in_place_of(driver, *sign):
    """Replaces the file of a module: without a signature, or signed by `sign`"""
    path = command('modinfo', '-n', driver).strip()
    shutil.copy(path, '/tmp/kept.ko')
    command('strip', '--strip-debug', path)
    if sign:
        command(*sign, path)
    try:
        yield
    finally:
        shutil.copy('/tmp/kept.ko', path)


def run(*words):
    """-> status and output"""
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          check=False)
    return done.returncode, done.stdout


def signatures(tool):
    """Findings of its doctor about them: [(text, fix), ...]"""
    findings = json.loads(run(tool, 'doctor', '--json')[1])['findings']
    ours = [each for each in findings if each['id'] == 'signature']
    assert ours, '%s doctor does not look at signatures' % tool
    return [(each['text'], each['fix']) for each in ours if each['status'] == 'found']


def check_refused(driver):
    """-> the findings of the doctor"""
    status, output = run('modprobe', driver)
    assert (status, REFUSED in output) == (1, True), 'status of modprobe %s: %s' % (driver, output)
    assert not module_loaded(driver.replace('-', '_')), driver + ' is loaded'
    found = signatures(TOOLS[driver])
    assert found, 'a doctor that finds nothing'
    for text, fix in found:
        assert 'Secure Boot is on' in text, text
        assert 'mokutil --import ' + DKMS_CERTIFICATE in fix, fix
    return found


def test_secure_boot_is_on():
    command('mount', '-t', 'efivarfs', 'efivarfs', EFI_VARIABLES)
    command('mount', '-t', 'securityfs', 'securityfs', os.path.dirname(LOCKDOWN))
    with open(SECURE_BOOT, 'rb') as file:
        assert file.read()[4:] == b'\1'
    assert '[integrity]' in read_file(LOCKDOWN), 'the kernel is not locked down'


def test_modules_of_another_key_are_refused():
    for driver in TOOLS:
        with in_place_of(driver, SIGN, 'sha256', DKMS_KEY, DKMS_CERTIFICATE):
            for text, _ in check_refused(driver):
                assert 'if its key is not enrolled' in text, text


def test_modules_without_a_signature_are_refused():
    for driver in TOOLS:
        with in_place_of(driver):
            for text, _ in check_refused(driver):
                assert 'is not signed' in text, text


def test_pendant_works():
    with Plugged('HB04') as pendant:
        pendant.usb.press(0x01)
        assert pendant.events.report() == ['MSC_SCAN 1', 'BTN_TRIGGER_HAPPY1 1']
        assert signatures('xhcctl') == []
    unload_modules('hid-xhc')


def test_head_works():
    with VirtualHead(lines=4, framing='line') as head:
        head.set('out_angl0_raw', 524288)
        assert head.positions(20)[0] == 524288
        with head.attached():
            assert signatures('xy3ctl') == []
        # as documented for the virtual head
        assert error_of(write_file, SIM + 'report', '1') == errno.EPERM
    unload_modules('xy3-spi', 'xy3')
