#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""Judge one run of the test kernel by its output files (see run-uml).

verdict.py OUT [--name NAME] [--suite NAME:CASES]... [--no-leak-scan] [--plain]

Prints one line for each KUnit case, and one (NAME.clean) for the run: it is ok only if the kernel
powered off, the status of the command is 0, the console shows no report of a checker, the kernel is
not tainted, lockdep is still on, and no memory leaked. (A --plain kernel has neither lockdep nor
kmemleak.) Each --suite must be complete, with at least that number of cases; any other suite is a
fault. A skipped case is a failure.
The last line is "verdict: N passed, N failed"; the status is 0 if none failed.
"""
import argparse
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / 'lib'), str(HERE.parents[2] / 'kunit')]
import ktap                                     # noqa: E402
from kernel_trouble import trouble              # noqa: E402
from ktap import block_faults, why_not          # noqa: E402

# Bits of /proc/sys/kernel/tainted that are set in every run: out-of-tree modules, KUnit
EXPECTED_TAINT = 1 << 12 | 1 << 18


def read(path):
    try:
        return path.read_text(errors='replace')
    except FileNotFoundError:
        return None


def check_end(out):
    end = (read(out / 'end') or 'no end').strip()
    if end != 'ok':
        yield f'the kernel did not come to its end: {end}'
        return
    status = (read(out / 'status') or '').strip()
    if status != '0':
        yield f"the command's status is {status or 'unknown'}"


def check_console(out, allowed):
    console = read(out / 'console.log')
    if not console or 'init: ' not in console:
        yield 'console: the kernel did not reach init'
        return
    for line in trouble(console, allowed):
        yield f'console: {line}'


def check_taint(out):
    taint = read(out / 'tainted')
    if taint is None:
        yield 'taint: not recorded'
    elif int(taint) & ~EXPECTED_TAINT:
        yield f'taint: {int(taint)} has unexpected bits {int(taint) & ~EXPECTED_TAINT:#x}'


def check_lockdep(out):
    state = re.search(r'debug_locks:\s*(\d)', read(out / 'lockdep') or '')
    if not state:
        yield 'lockdep: state not recorded'
    elif state.group(1) != '1':
        yield 'lockdep has switched itself off'


def check_leaks(out, allowed):
    leaks = read(out / 'kmemleak')
    if leaks is None:
        yield 'kmemleak: no scan'
        return
    found = [leak for leak in re.split(r'^(?=unreferenced object)', leaks, flags=re.MULTILINE)
             if leak.strip() and not allowed(leak)]
    if found:
        yield f'kmemleak: {len(found)} unreferenced objects, see kmemleak in {out}'


def diagnostics(result):
    own = list(result.diagnostics)
    for row in result.rows():
        if why_not(row):
            own += diagnostics(row)
    return own


class Suite:
    """The cases and faults of a suite, from its KTAP."""

    def __init__(self, name, text):
        self.name = name
        self.cases = []
        self.faults = []
        try:
            document = ktap.parse(text)
        except ktap.Malformed as error:
            self.faults.append(f'suite {name}: {error}')
            return
        self.faults += block_faults(document, f'suite {name}', True)
        for suite in document.results:
            self.read_result(suite)

    def read_result(self, suite):
        if suite.name != self.name:
            self.faults.append(f'suite {self.name}: its result is named {suite.name}')
        if suite.block is None:
            self.faults.append(f'suite {self.name}: no cases')
            return
        if suite.block.plan is None:
            self.faults.append(f'suite {self.name}: its cases have no plan line')
        self.cases += suite.block.results
        cases_passed = all(why_not(case) is None for case in suite.block.results)
        if cases_passed and why_not(suite):
            self.faults.append(f'suite {self.name} {why_not(suite)}, but none of its cases')

    def demand(self, least):
        if len(self.cases) < least:
            self.faults.append(
                f'suite {self.name}: {len(self.cases)} cases, at least {least} wanted')


def read_suites(out, wanted):
    """-> the suites of the run, compared with the requested ones, and further faults"""
    suites = [Suite(path.stem, read(path)) for path in sorted((out / 'ktap').glob('*.ktap'))]
    faults = []
    for suite in suites:
        if suite.name in wanted:
            suite.demand(wanted[suite.name])
        else:
            faults.append(f'suite {suite.name} was not asked for: it has no minimum')
    for name in sorted(set(wanted) - {suite.name for suite in suites}):
        faults.append(f'suite {name} did not run')
    return suites, faults


def judge_case(suite, case):
    """Print the line of a case; True if it passed."""
    why = why_not(case)
    if why is None:
        print(f'ok {suite.name}.{case.name}')
        return True
    for line in diagnostics(case):
        print(f'    {line}')
    print(f'not ok {suite.name}.{case.name}: {why}')
    return False


def judge(out, name, wanted, leaks_wanted, allow=(), plain=False):
    """Print the results -> (passed, failed)"""
    def allowed(text):
        return any(re.search(pattern, text) for pattern in allow)

    suites, faults = read_suites(out, wanted)
    verdicts = [judge_case(suite, case) for suite in suites for case in suite.cases]
    for suite in suites:
        faults += suite.faults
    for check in (check_end, check_taint):
        faults += check(out)
    if not plain:
        faults += check_lockdep(out)
    faults += check_console(out, allowed)
    if leaks_wanted and not plain:
        faults += check_leaks(out, allowed)
    for fault in faults:
        print(f'    {fault}')
    print(f'not ok {name}.clean: {faults[0]}' if faults else f'ok {name}.clean')
    verdicts.append(not faults)
    return verdicts.count(True), verdicts.count(False)


def suite_argument(text):
    name, _, least = text.partition(':')
    if not name or not least.isdigit() or int(least) < 1:
        raise argparse.ArgumentTypeError(f'{text}: not NAME:CASES with CASES at least 1')
    return name, int(least)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', maxsplit=1)[0])
    parser.add_argument('out', type=Path, help='output directory of userspace/tests/uml/run-uml')
    parser.add_argument('--name', help='name of the run (default: of the directory)')
    parser.add_argument('--suite', type=suite_argument, action='append', default=[],
                        metavar='NAME:CASES', help='a suite and its minimum number of cases')
    parser.add_argument('--no-leak-scan', action='store_true', help='run was called with -l')
    parser.add_argument('--plain', action='store_true', help='run by build-kernel --plain')
    parser.add_argument('--allow', action='append', default=[], metavar='REGEX',
                        help='ignore console lines and leaks that match; comment why')
    args = parser.parse_args()
    passed, failed = judge(args.out, args.name or args.out.name, dict(args.suite),
                           not args.no_leak_scan, args.allow, args.plain)
    print(f'verdict: {passed} passed, {failed} failed')
    return failed > 0


if __name__ == '__main__':
    sys.exit(main())
