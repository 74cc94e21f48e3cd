# SPDX-License-Identifier: GPL-2.0-only
"""The list of signs of trouble in a kernel log: each entry finds its planted line."""

import re

import pytest
from kernel_trouble import TROUBLE, trouble

HARMLESS = (
    'usb 1-1: new full-speed USB device number 2 using vhci_hcd',
    'hid-generic 0003:10CE:EB70.0001: unbalanced collection at end of report description',
    'Kernel command line: console=ttyS0 panic=-1',
    'INFO: lockdep selftest passed',
    'random: crng init done',
)


@pytest.mark.parametrize('pattern, line', TROUBLE, ids=[pattern for pattern, _ in TROUBLE])
def test_entry_finds_its_line(pattern, line):
    assert re.search(pattern, line)
    assert trouble('[    1.000000] first\n[   12.345678] %s\r\n' % line) == [line]


@pytest.mark.parametrize('line', HARMLESS)
def test_harmless(line):
    assert not trouble('[    1.000000] %s\n' % line)


def test_no_kernel_line():
    """Output of programs on the same console is not that of the kernel."""
    assert not trouble('BUG: of a program\nok test_WARNING: \n')


def test_each_once():
    line = '[    1.000000] BUG: sleeping function called from invalid context\n'
    assert trouble(line + line.replace('1.0', '2.0')) == [line.strip().split('] ')[1]]


def test_allowed():
    log = '[    1.000000] BUG: one\n[    1.000000] BUG: two\n'
    assert trouble(log, lambda text: 'one' in text) == ['BUG: two']
