# SPDX-License-Identifier: GPL-2.0-only
"""What a WHB04B has instead of an HB04's display: pins, and the text that its attributes take."""

from .display import coordinate, number
from .macros import ACTIONS

AXES = 'xyzabc'
SECOND = 'abc'              # the axes that have the rows while the selector is at one of them
SYSTEMS = ('work', 'machine')

FLOATS = tuple('%s-%s' % (system, axis) for system in SYSTEMS for axis in AXES) + (
    'feed-override', 'spindle-override')
BITS = tuple('select-' + axis for axis in AXES) + ('show-machine', 'mpg', 'reset', 'fn')
WITHOUT_FN = ACTIONS + ('macro-10',)


def texts(pins, _options, _display):
    """-> attribute: text; `pins` are by name."""
    second = any(pins['select-' + axis] for axis in SECOND)
    system = 'machine' if pins['show-machine'] else 'work'
    return {
        'rows': ' '.join(coordinate(pins['%s-%s' % (system, axis)])
                         for axis in (SECOND if second else 'xyz')),
        'coordinates': system,
        'mode': 'mpg' if pins['mpg'] else 'step',
        'reset': str(int(pins['reset'])),
        'feedrate_override': number(100 * pins['feed-override']),
        'spindle_override': number(100 * pins['spindle-override']),
    }


def runs(name, pins):
    """Most keys are a macro together with Fn; one is a macro without it."""
    return bool(pins['fn']) != (name in WITHOUT_FN)
