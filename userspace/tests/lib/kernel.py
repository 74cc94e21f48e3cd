# SPDX-License-Identifier: GPL-2.0-only
"""The kernel under test: its modules, its files, and how to wait for it."""

import ctypes
import os
import time

SYS_FINIT_MODULE, SYS_DELETE_MODULE = 313, 176      # x86_64, the only one that UML has
_libc = ctypes.CDLL(None, use_errno=True)


def syscall(*arguments):
    """OSError if it fails."""
    result = _libc.syscall(*arguments)
    if result < 0:
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))
    return result


def load_module(path, parameters=''):
    """insmod in this process, so that fail-nth counts its allocations."""
    fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        syscall(SYS_FINIT_MODULE, fd, parameters.encode(), 0)
    finally:
        os.close(fd)


def unload_module(name):
    """rmmod; OSError if the module is in use"""
    syscall(SYS_DELETE_MODULE, name.encode(), os.O_NONBLOCK)


def remove_module(name):
    """rmmod as soon as the module is unused: some files are released by a worker later."""
    def removed():
        try:
            unload_module(name)
        except BlockingIOError:         # EAGAIN
            return False
        return True

    if not wait(removed):
        raise AssertionError('%s is in use: %s users'
                             % (name, read_file('/sys/module/%s/refcnt' % name).strip()))


def is_loaded(name):
    return os.path.isdir('/sys/module/' + name)


def read_file(path):
    with open(path, encoding='utf-8') as file:
        return file.read()


def write_file(path, text):
    """One write(), whose error is raised as OSError."""
    fd = os.open(path, os.O_WRONLY | os.O_CLOEXEC)
    try:
        os.write(fd, text.encode())
    finally:
        os.close(fd)


# Whether time only passes while nothing can run: then no pause is too short, on any host
TIME_TRAVEL = 'time-travel' in read_file('/proc/cmdline').split()


def wait(condition, timeout=60.0, step=0.005):
    """Waits until condition() is true or the timeout expires. -> its last value

    The timeout is for failures: it allows for a busy host.
    """
    deadline = time.monotonic() + timeout
    while True:
        result = condition()
        if result or time.monotonic() >= deadline:
            return result
        time.sleep(step)


class KernelLog:
    """Reads kernel messages from now on."""

    def __init__(self):
        self.fd = os.open('/dev/kmsg', os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        os.lseek(self.fd, 0, os.SEEK_END)

    def lines(self):
        """Messages since the last call."""
        found = []
        while True:
            try:
                record = os.read(self.fd, 8192).decode(errors='replace')
            except BlockingIOError:
                return found
            except BrokenPipeError:             # messages were overwritten
                continue
            found.append(record.partition(';')[2].split('\n')[0])

    def close(self):
        os.close(self.fd)
