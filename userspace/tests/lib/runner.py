# SPDX-License-Identifier: GPL-2.0-only
"""Runs the unittest cases of a file; one line for each: "ok NAME" or "not ok NAME: why".

The last line is "FILE: N passed, N failed".  A skipped case has failed, and so has a file
without cases.
"""

import os
import sys
import time
import traceback
import unittest


class Lines(unittest.TestResult):
    """Prints as it goes, so that a hang shows where."""

    def __init__(self, prefix):
        super().__init__()
        self.prefix = prefix
        self.passed = 0
        self.failed = 0
        self.why = None
        self.began = 0.0

    def startTest(self, test):
        super().startTest(test)
        self.why = None
        self.began = time.monotonic()

    def stopTest(self, test):
        super().stopTest(test)
        name = '%s.%s' % (self.prefix, test.id().split('.', 1)[1])
        if self.why is None:
            self.passed += 1
            print('ok %s' % name)
        else:
            self.failed += 1
            print('not ok %s: %s' % (name, self.why))
        slow = time.monotonic() - self.began
        if slow > 10:
            print('    (%.0f s)' % slow)
        sys.stdout.flush()

    def _note(self, error, what=''):
        lines = ''.join(traceback.format_exception(*error)).rstrip().split('\n')
        print('\n'.join('    ' + line for line in lines))
        if self.why is None:
            message = str(error[1]).split('\n')[0] or error[0].__name__
            self.why = what + message

    def addError(self, test, err):
        if not hasattr(test, '_testMethodName'):    # setUpClass: no stopTest() will come
            self.why = None
            self._note(err)
            self.failed += 1
            print('not ok %s.%s: %s' % (self.prefix, test.id(), self.why))
            return
        self._note(err, err[0].__name__ + ': ')

    def addFailure(self, test, err):
        self._note(err)

    def addSubTest(self, test, subtest, err):
        if err is not None:
            self._note(err, subtest._subDescription() + ': ')

    def addSkip(self, test, reason):
        self.why = 'skipped: ' + reason

    def addExpectedFailure(self, test, err):
        self.why = 'an expected failure is a failure'

    def addUnexpectedSuccess(self, test):
        self.why = 'unexpected success'


def main(names=None):
    """Runs the cases of the program's file (or only those named on the command line)."""
    module = sys.modules['__main__']
    prefix = os.path.basename(module.__file__).removesuffix('.py').removeprefix('test_')
    loader = unittest.TestLoader()
    names = sys.argv[1:] if names is None else names
    suite = (loader.loadTestsFromNames(names, module) if names
             else loader.loadTestsFromModule(module))
    result = Lines(prefix)
    suite.run(result)
    if result.passed + result.failed == 0:
        result.failed += 1
        print('not ok %s: no cases' % prefix)
    print('%s: %d passed, %d failed' % (prefix, result.passed, result.failed))
    sys.stdout.flush()
    return 1 if result.failed else 0
