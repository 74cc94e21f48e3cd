# SPDX-License-Identifier: GPL-2.0-only
"""The result lines of a run of pytest, for the levels' scripts (lib.sh).

First "1..N", then for each test "ok FILE.CLASS.TEST" or "not ok FILE.CLASS.TEST: why", and at the
end "FILE: N passed, N failed" (FILE is "pytest" for several files). A skipped test, an expected
failure and a run without tests are failures.
"""

import pathlib

import pytest

SLOW = 10               # the time of tests that take longer is printed, in seconds


def test_name(nodeid):
    """pendant/test_events.py::Keys::test_every_key[7] -> events.Keys.test_every_key[7]"""
    path, _, rest = nodeid.partition('::')
    stem = pathlib.PurePath(path).stem.removeprefix('test_')
    return '.'.join([stem, *rest.split('::')]) if rest else stem


def why_not(report):
    """The reason why a phase of a test failed, in one line; None on success."""
    if hasattr(report, 'wasxfail'):
        return 'an expected failure is a failure'
    if report.skipped:
        return 'skipped: %s' % (report.longrepr[2] if isinstance(report.longrepr, tuple)
                                else report.longrepr)
    if not report.failed:
        return None
    crash = getattr(report.longrepr, 'reprcrash', None)
    why = crash.message if crash else str(report.longrepr).rstrip()
    why = why.splitlines()[0] if crash else why.splitlines()[-1]
    return why if report.when in ('call', 'collect') else '%s: %s' % (report.when, why)


class ResultLines:
    """Counts results, and prints each at once, to show where a test hangs."""

    def __init__(self, writer):
        self.writer = writer
        self.passed = 0
        self.failed = 0
        self.files = set()
        self.why = {}           # the first phase that failed of the running test
        self.seconds = {}

    def line(self, text):
        # one write(), so that no other output gets into the line
        self.writer.write(text + '\n', flush=True)

    def fail(self, name, why):
        self.failed += 1
        self.line('not ok %s: %s' % (name, why))

    def details(self, report):
        if report.failed:
            for line in report.longreprtext.splitlines():
                self.line('    ' + line)
            for title, text in report.sections:
                for line in ['--- %s' % title, *text.splitlines()]:
                    self.line('    ' + line)

    def pytest_collectreport(self, report):
        why = why_not(report)
        if why:
            self.details(report)
            self.fail(test_name(report.nodeid), why)

    def pytest_collection_finish(self, session):
        self.files = {item.path for item in session.items}
        self.line('1..%d' % len(session.items))

    def pytest_runtest_logreport(self, report):
        name, why = test_name(report.nodeid), why_not(report)
        if why:
            self.details(report)
            self.why.setdefault(name, why)
        self.seconds[name] = self.seconds.get(name, 0) + report.duration
        if report.when == 'teardown':
            self.finish(name)

    def finish(self, name):
        seconds = self.seconds.pop(name)
        if name in self.why:
            self.fail(name, self.why.pop(name))
        else:
            self.passed += 1
            self.line('ok ' + name)
        if seconds > SLOW:
            self.line('    (%.0f s)' % seconds)

    @pytest.hookimpl(trylast=True)
    def pytest_sessionfinish(self, session):
        if self.passed + self.failed == 0:
            self.fail('pytest', 'no test ran')
        session.exitstatus = 1 if self.failed else 0

    def pytest_unconfigure(self):
        """Prints the summary after the output of pytest."""
        files = [test_name(path.name) for path in self.files]
        self.line('%s: %d passed, %d failed' % (files[0] if len(files) == 1 else 'pytest',
                                                self.passed, self.failed))


@pytest.hookimpl(tryfirst=True)
def pytest_report_teststatus(report):
    """Disables the output of pytest for a test."""
    return report.outcome, '', ''


@pytest.hookimpl(trylast=True)
def pytest_configure(config):
    config.pluginmanager.register(ResultLines(config.get_terminal_writer()), 'result-lines')
