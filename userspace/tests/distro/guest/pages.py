# SPDX-License-Identifier: GPL-2.0-only
"""What a document tells its reader to type.

Lines of a fenced block that begin with "$ " are for a member of the group dialout, with "# " for
root. A comment may follow behind three blanks. Lines below, up to the next one, are what is
printed. A block marked "python" is a program for a member of the group, and one marked "sh" is
typed whole on a machine that has nothing yet, see test-fresh-machine.
"""

import re
from collections import namedtuple

PROMPTS = {'$ ': 'member', '# ': 'root'}

# text: without the comment, as tests name it; typed: the line as a reader copies it
# block: a number, the same for all lines of one block
Command = namedtuple('Command', 'user text typed shown block')


def blocks(text):
    """[(language of the fence, lines), ...]"""
    return [(info, body.splitlines()) for info, body in
            re.findall(r'^```(\w*)\n(.*?)^```$', text, re.DOTALL | re.MULTILINE)]


def commands(text):
    """All of a document, in its order; of a program the text is its source."""
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
