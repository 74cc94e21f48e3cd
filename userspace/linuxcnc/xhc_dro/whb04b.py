# SPDX-License-Identifier: GPL-2.0-only
"""The text that the attributes of a WHB04B's display take."""

from .display import coordinate, number
from .wheel import MODES

SECOND = 'abc'              # the axes that have the rows while the selector is at one of them


def texts(pins, _options, _display):
    """-> attribute: text; `pins` are by name."""
    second = any(pins['select-' + axis] for axis in SECOND)
    system = 'machine' if pins['show-machine'] else 'work'
    return {
        'rows': ' '.join(coordinate(pins['%s-%s' % (system, axis)])
                         for axis in (SECOND if second else 'xyz')),
        'coordinates': system,
        'mode': next(mode for mode in MODES if pins['mode-' + mode]),
        'reset': str(int(pins['reset'])),
        'feedrate_override': number(100 * pins['feed-override']),
        'spindle_override': number(100 * pins['spindle-override']),
    }
