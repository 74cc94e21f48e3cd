# SPDX-License-Identifier: GPL-2.0-only
"""What xhc-dro reads of [XHC] in the ini."""

import math
import re

READ_HERE = re.compile('KEYS|MODE|STEPS|SCALE(_[A-Z])?|SELECTOR_A|PROBE_Z|REWIND|MACRO_[0-9]+')


def number(name, text):
    """A position that is no number would be commanded without an error."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError('[XHC]%s: %s is not a number' % (name, text))
    return value


def check(path):
    """ValueError for an entry of a second section [XHC], of which linuxcnc.ini() reads nothing"""
    sections, inside = 0, False
    with open(path, encoding='utf-8', errors='replace') as file:
        for line in file:
            name = line.partition('=')[0].strip()
            if name.startswith('['):
                inside = name.startswith('[XHC]')
                sections += inside
            elif inside and sections > 1 and READ_HERE.fullmatch(name):
                raise ValueError(
                    '[XHC]%s is in a second section [XHC]: move it to the first' % name)
