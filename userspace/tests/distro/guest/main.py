# SPDX-License-Identifier: GPL-2.0-only
"""Run the tests of the modules that the kernel's command line names: tests=FIRST,SECOND.

Prints "1..COUNT" first, then one line "ok NAME" or "not ok NAME: why" for each test.
"""

import importlib
import os
import re
import signal
import sys
import time
import traceback

from harness import Failure, command

LIMIT = 200         # seconds for one test, unless it has a `limit` of its own


def say(line):
    """A line of its own, by one write(): a program that was killed in the middle of a word has
    perhaps left that word here.
    """
    os.write(1, ('\n%s\n' % line).encode())


def too_late(_signal, _frame):
    raise Failure('not done in time')


def complaint(error):
    """One line for the result, and the way to it as comments."""
    for line in traceback.format_exc().splitlines():
        say('# %s' % line)
    return ('%s: %s' % (type(error).__name__, error)).replace('\n', ' ')


def run(function):
    name = function.__name__.replace('_', '-')
    start = time.monotonic()
    signal.alarm(getattr(function, 'limit', LIMIT))
    try:
        function()
    except Exception as error:      # a broken test must not hide those behind it
        signal.alarm(0)
        say('not ok %s: %s' % (name, complaint(error)))
        return False
    signal.alarm(0)
    say('ok %s' % name)
    say('# %.1f s' % (time.monotonic() - start))
    return True


def main():
    with open('/proc/cmdline', encoding='ascii') as file:
        names = re.search(r'\btests=(\S+)', file.read()).group(1).split(',')
    command('modprobe', 'vhci-hcd')     # where pendants are plugged in
    modules = [importlib.import_module(name) for name in names]
    tests = [function for module in modules for function in module.TESTS]
    signal.signal(signal.SIGALRM, too_late)
    say('1..%d' % len(tests))
    failed = [function for function in tests if not run(function)]
    return 1 if failed else 0


sys.exit(main())
