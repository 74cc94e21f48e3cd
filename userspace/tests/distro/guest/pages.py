# SPDX-License-Identifier: GPL-2.0-only
"""What a document tells its reader to type.

Lines of a fenced block that begin with "$ " are for a member of the group dialout, with "# " for
root; three blanks end them, and a comment may follow. Lines below, up to the next
one, are what is printed. A block marked "python" is a program for a member of the group.
"""

import re
from collections import namedtuple

PROMPTS = {'$ ': 'member', '# ': 'root'}

# block: a number, the same for what stands in one block
Command = namedtuple('Command', 'user text shown block')


def blocks(text):
    """[(language of the fence, lines), ...]"""
    return [(info, body.splitlines()) for info, body in
            re.findall(r'^```(\w*)\n(.*?)^```$', text, re.DOTALL | re.MULTILINE)]


def commands(text):
    """All of a document, in its order; of a program the text is its source."""
    found = []
    for number, (info, lines) in enumerate(blocks(text)):
        if info == 'python':
            found.append(Command('program', '\n'.join(lines) + '\n', [], number))
        if info:
            continue
        for line in lines:
            if line[:2] in PROMPTS:
                typed = re.split(r' {3,}', line[2:])[0]
                found.append(Command(PROMPTS[line[:2]], typed, [], number))
            elif found and found[-1].block == number:
                found[-1].shown.append(line)
    return found
