# SPDX-License-Identifier: GPL-2.0-only
"""Allocations that fail on demand.

/proc/self/task/*/fail-nth lets the n-th allocation of this thread fail; /sys/kernel/debug/failslab
lets them fail at random, in any thread.
"""

import contextlib
import errno
import functools
import os
import threading

from kernel import read_file, write_file

FAILSLAB = '/sys/kernel/debug/failslab/'
FAIL_PAGE_ALLOC = '/sys/kernel/debug/fail_page_alloc/'
ENOUGH = 5000               # upper limit of allocations in a test
ALL_CODE = (0, (1 << 64) - 1)

# The driver core returns -EINVAL if it cannot allocate the name of a device (device_add()) or the
# folder of a module's drivers (module_add_driver())
DRIVER_CORE = ('ENOMEM', 'EINVAL')


def setup_failslab(start=ALL_CODE[0], end=ALL_CODE[1], spared='__vmalloc_node_range_noprof'):
    """start, end: only allocations whose call path includes this range of code may fail.

    spared: except through this function. vmalloc() prints a call trace on failure.

    fail-nth also counts pages, allocated anywhere: these must not fail. They are allocated by the
    slab (which retries with smaller ones, unnoticed by the caller) and at random by KASAN.
    """
    write_file(FAIL_PAGE_ALLOC + 'require-end', '0')
    spared = function_range(spared)
    for name, value in (('probability', '0'), ('ignore-gfp-wait', 'N'), ('verbose', '0'),
                        ('times', '-1'), ('stacktrace-depth', '32'),
                        ('require-start', '%#x' % start), ('require-end', '%#x' % end),
                        ('reject-start', '%#x' % spared[0]), ('reject-end', '%#x' % spared[1])):
        write_file(FAILSLAB + name, value)


@functools.cache
def function_range(name):
    """-> (start, end) of a function of the kernel or of a loaded module"""
    with open('/proc/kallsyms', encoding='ascii') as symbols:
        rows = sorted((int(row[0], 16), row[2]) for row in map(str.split, symbols)
                      if row[1] in 'tT')
    start = next(address for address, symbol in rows if symbol == name)
    return start, next(address for address, _ in rows if address > start)


@contextlib.contextmanager
def fail_all(start, end):
    """with fail_all(*function_range(name)): all allocations of this function fail."""
    setup_failslab(start, end)
    write_file(FAILSLAB + 'probability', '100')
    try:
        yield
    finally:
        setup_failslab()


class FailNth:
    """with FailNth(n) as fault: ... ; fault.struck is true if there was an n-th one."""

    def __init__(self, number):
        self.number = number
        self.struck = False
        self.fd = os.open('/proc/self/task/%d/fail-nth' % threading.get_native_id(), os.O_RDWR)

    def __enter__(self):
        os.pwrite(self.fd, b'%d' % self.number, 0)
        return self

    def __exit__(self, *_):
        left = os.pread(self.fd, 32, 0).split()[0].rstrip(b'\0')
        os.pwrite(self.fd, b'0', 0)
        os.close(self.fd)
        self.struck = left == b'0'


def walk(attempt, after, errors=('ENOMEM',)):
    """Calls attempt() with each fault in turn, and after(error or None) after each.

    errors: permitted errors of attempt()

    -> (number of allocations that failed, {error: number of times})
    """
    outcomes = {}
    for number in range(1, ENOUGH):
        fault, failure = FailNth(number), None
        with fault:
            try:
                attempt()
            except OSError as error:
                failure = error
        name = errno.errorcode[failure.errno] if failure else 'ok'
        assert name in ('ok', *errors), 'the allocation %d: %s' % (number, name)
        if fault.struck:
            outcomes[name] = outcomes.get(name, 0) + 1
        after(failure)
        if not fault.struck:
            return number - 1, outcomes
    raise AssertionError('no end after %d allocations' % ENOUGH)


def module_range(name):
    """-> (start, end) of a module's code"""
    start = int(read_file('/sys/module/%s/sections/.text' % name), 16)
    return start, start + int(read_file('/sys/module/%s/coresize' % name))
