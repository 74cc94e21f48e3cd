#!/usr/bin/python3
# SPDX-License-Identifier: GPL-2.0-only
"""Judge the KTAP of one user-space program, by the same rules as for the kernel.

judge.py --min N < output

Prints "PASSED FAILED": numbers of cases, where each parameter of a case counts. Reasons of failures
go to stderr. The status is 0 if the text is complete, nothing failed or was skipped, and at least N
cases passed.
"""
import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import ktap      # noqa: E402


def leaves(result):
    """The results without results below them."""
    rows = result.rows()
    return [leaf for row in rows for leaf in leaves(row)] if rows else [result]


def judge(text, minimum):
    """Return (passed, failed, faults)."""
    try:
        document = ktap.parse(text)
    except ktap.Malformed as error:
        return 0, 1, [str(error)]
    faults = list(ktap.block_faults(document, 'program', True))
    for suite in document.results:
        why = ktap.why_not(suite)
        if why:
            faults.append(f'{suite.name}: {why}')
    verdicts = [ktap.why_not(leaf) is None for suite in document.results
                for leaf in leaves(suite)]
    passed, failed = verdicts.count(True), verdicts.count(False)
    if passed < minimum:
        faults.append(f'{passed} cases passed, at least {minimum} wanted')
    return passed, max(failed, 1) if faults else failed, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n', maxsplit=1)[0])
    parser.add_argument('--min', type=int, default=1, metavar='N', help='fewest good cases')
    passed, failed, faults = judge(sys.stdin.read(), parser.parse_args().min)
    for fault in faults:
        print(f'judge: {fault}', file=sys.stderr)
    print(passed, failed)
    return bool(faults)


if __name__ == '__main__':
    sys.exit(main())
