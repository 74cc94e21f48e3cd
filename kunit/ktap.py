# SPDX-License-Identifier: GPL-2.0-only
"""Read KTAP, the kernel's test result format, into a tree.

    KTAP version 1
    1..1
        KTAP version 1
        # Subtest: suite
        1..2
        ok 1 first_case
            KTAP version 1
            # Subtest: second_case
            ok 1 row
        ok 2 second_case
    ok 1 suite

Each level is indented by four blanks; the results of a level precede the line with their sum.
"""
import re
from dataclasses import dataclass, field

VERSION = re.compile(r'KTAP version \d+$')
PLAN = re.compile(r'1\.\.(\d+)')
RESULT = re.compile(r'(not ok|ok) (\d+) ?(.*)$')
DIRECTIVE = re.compile(r'\s*#\s*SKIP\b.*$', re.IGNORECASE)


@dataclass
class Block:
    """The results of one level, and the number in its plan line (None: no plan line)."""
    plan: int | None = None
    results: list = field(default_factory=list)
    diagnostics: list = field(default_factory=list)


@dataclass
class Result:
    number: int
    name: str
    ok: bool
    skipped: bool
    block: Block | None         # the results below this line; None: nothing
    diagnostics: list

    def rows(self):
        return self.block.results if self.block else []


class Malformed(Exception):
    """The text is not a complete KTAP document."""


def parse(text):
    """-> the outermost block of the document"""
    open_blocks = []            # one for each level, from the outermost
    for line in text.splitlines():
        words = line.lstrip(' ')
        level = (len(line) - len(words)) // 4
        if VERSION.match(words):
            _open(open_blocks, level)
        elif PLAN.match(words) and level < len(open_blocks):
            open_blocks[level].plan = int(PLAN.match(words).group(1))
        elif RESULT.match(words):
            _close(open_blocks, level, RESULT.match(words))
        elif words.startswith('#') and open_blocks:
            open_blocks[min(level, len(open_blocks) - 1)].diagnostics.append(words)
    if len(open_blocks) != 1:
        raise Malformed('the text is cut off, or no KTAP at all')
    return open_blocks[0]


def _open(open_blocks, level):
    if level > len(open_blocks):
        raise Malformed(f'level {level} begins, level {level - 1} has not begun')
    if level < len(open_blocks):
        raise Malformed(f'level {level} begins twice, its first run has no result line')
    open_blocks.append(Block())


def _close(open_blocks, level, match):
    """A result line: it belongs to `level`, and is the sum of the level below, if that is open."""
    if not level < len(open_blocks) <= level + 2:
        raise Malformed(f'a result at level {level} that is not open: {match.group(0)}')
    inner = open_blocks.pop() if len(open_blocks) == level + 2 else None
    outer = open_blocks[level]
    rest = match.group(3)
    directive = DIRECTIVE.search(rest)
    name = DIRECTIVE.sub('', rest).removeprefix('- ').strip()
    outer.results.append(Result(
        number=int(match.group(2)), name=name, ok=match.group(1) == 'ok',
        skipped=bool(directive), block=inner, diagnostics=outer.diagnostics))
    outer.diagnostics = []


def block_faults(block, where, plan_needed):
    """Faults of the format: a level must have the number of results in its plan, from 1."""
    if block.plan is None and plan_needed:
        yield f'{where}: no plan line'
    if block.plan is not None and block.plan != len(block.results):
        yield f'{where}: {block.plan} planned, {len(block.results)} there'
    if [result.number for result in block.results] != list(range(1, len(block.results) + 1)):
        yield f'{where}: results are not numbered from 1'
    if not block.results:
        yield f'{where}: empty'
    for result in block.results:
        if result.block:
            yield from block_faults(result.block, f'{where}.{result.name}', False)


def why_not(result):
    """The reason why a result is not a success, or None."""
    if result.skipped:
        return 'skipped'
    if not result.ok:
        rows = [row.name for row in result.rows() if why_not(row)]
        return 'failed' + (f' in {", ".join(rows)}' if rows else '')
    bad = [row.name for row in result.rows() if why_not(row)]
    return f'ok, but not its rows {", ".join(bad)}' if bad else None
