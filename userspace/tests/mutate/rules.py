# SPDX-License-Identifier: GPL-2.0-only
"""Mutations made by rule: each changes one line of a source file in one way.

The rules are common mistakes: a missing call, lock or put, an inverted condition, an off-by-one
bound, another error, a wait that is too short.
"""

import random
import re
from dataclasses import dataclass

COMPARISONS = {' < ': ' <= ', ' <= ': ' < ', ' > ': ' >= ', ' >= ': ' > '}


@dataclass(frozen=True)
class Mutant:
    path: str               # of the file, relative to the top
    number: int             # of the line, from 1
    rule: str
    old: str                # the line
    new: str

    def apply(self, text):
        lines = text.splitlines(keepends=True)
        assert lines[self.number - 1] == self.old + '\n'
        lines[self.number - 1] = self.new + '\n'
        return ''.join(lines)

    def __str__(self):
        return f'{self.path}:{self.number}: {self.rule}: {self.old.strip()} -> {self.new.strip()}'


def replaced(pattern, replacement):
    """A rule by regular expression; one mutant for each match in the line."""
    def rule(line):
        return [line[:match.start()] + match.expand(replacement) + line[match.end():]
                for match in re.finditer(pattern, line)]
    return rule


PUT = re.compile(r'\t+(?:guard\(.*\)|\w*unlock\w*|\w*_put|put_\w+|get_device|kfree|'
                 r'\w*_unregister\w*|cancel_\w+)\(.*\);$')


def forgotten(line):
    """A lock or a reference that is not acquired or not released"""
    if PUT.match(line):
        return [re.sub(r'\S.*', ';', line)]
    match = re.match(r'(\t+)scoped_guard\(.*\)( \{)?$', line)
    return [f'{match[1]}if (true){match[2] or ""}'] if match else []


def dropped(line):
    """A call whose result is not used, except assertions, which are checks"""
    if forgotten(line) or not re.match(r'\t+(?!return\b|guard\b|lockdep_)\w+\(.*\);$', line):
        return []
    return [re.sub(r'\S.*', ';', line)]


def negated(line):
    match = re.match(r'(\t+(?:\} else )?if \()(.*)(\)(?: \{)?)$', line)
    return [f'{match[1]}!({match[2]}){match[3]}'] if match else []


def off_by_one(line):
    if re.match(r'#', line):
        return []
    found = [line[:match.start()] + COMPARISONS[match[0]] + line[match.end():]
             for match in re.finditer(r' [<>]=? ', line)]
    return found + replaced(r' [+-] 1\b', '')(line)


def other_error(line):
    found = []
    for match in re.finditer(r'-E[A-Z]+\b', line):
        other = '-EINVAL' if match[0] == '-EIO' else '-EIO'
        found.append(line[:match.start()] + other + line[match.end():])
    return found


RULES = {
    'dropped call': dropped,
    'forgotten lock or put': forgotten,
    'negated condition': negated,
    'off by one': off_by_one,
    'other error': other_error,
    'shortened wait': replaced(r'(#define \w*(?:_MS|_TIMEOUT)\w*\t+)(?:\d{2,}|HZ)', r'\g<1>1'),
}


def code_lines(text):
    """[(number, line), ...] without comments"""
    comment = False
    for number, line in enumerate(text.splitlines(), 1):
        begins = line.lstrip().startswith('/*')
        if not comment and not begins:
            yield number, line
        comment = (comment or begins) and '*/' not in line


def mutants_of(path, text):
    """{rule: [Mutant, ...]}"""
    return {name: [Mutant(path, number, name, line, new) for number, line in code_lines(text)
                   for new in rule(line)] for name, rule in RULES.items()}


def choose(sources, seed):
    """All mutants of the files {path: text} in random order, files and their rules in turn."""
    dice = random.Random(seed)
    queues = []
    for path, text in sources.items():
        rules = [mutants for mutants in mutants_of(path, text).values() if mutants]
        for mutants in rules:
            dice.shuffle(mutants)
        dice.shuffle(rules)
        queues.append(rules)
    while queues:
        for rules in list(queues):
            mutants = rules.pop(0)
            yield mutants.pop()
            if mutants:
                rules.append(mutants)
            elif not rules:
                queues.remove(rules)
