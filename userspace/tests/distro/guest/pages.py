# SPDX-License-Identifier: GPL-2.0-only
"""The commands of a document.

Lines of a fenced block that start with "$ " are run by a member of the group dialout, with "# " by
root. A comment may follow after three blanks. The lines below, up to the next command, are its
output. A block marked "python" is a program for a member of the group, and one marked "sh" is run
as a whole on a fresh machine, see test-fresh-machine.
"""

import re
from collections import namedtuple

PROMPTS = {'$ ': 'member', '# ': 'root'}

# text: without the comment, as in tests; typed: the line as users copy it
# block: a number, the same for all lines of one block
Command = namedtuple('Command', 'user text typed shown block')


def blocks(text):
    """[(language of the fence, lines), ...]"""
    return [(info, body.splitlines()) for info, body in
            re.findall(r'^```(\w*)\n(.*?)^```$', text, re.DOTALL | re.MULTILINE)]


def commands(text):
    """All commands of a document, in order; the text of a program is its source."""
    found = []
    for number, (info, lines) in enumerate(blocks(text)):
        if info == 'python':
            source = '\n'.join(lines) + '\n'
            found.append(Command('program', source, source, [], number))
        if info:
            continue
        for line in lines:
            if line[:2] in PROMPTS:
                text = re.split(r' {3,}', line[2:])[0]
                found.append(Command(PROMPTS[line[:2]], text, line[2:], [], number))
            elif found and found[-1].block == number:
                found[-1].shown.append(line)
    return found
