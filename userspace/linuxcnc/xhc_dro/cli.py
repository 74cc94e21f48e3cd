# SPDX-License-Identifier: GPL-2.0-only
"""The command line of xhc-dro."""

import argparse
import os
import re
import signal
import sys

from . import VERSION
from .component import MODELS, Component
from .settings import check

FAILURE = 1
HALUI_DIES = re.compile(r'2\.9\.[56]\b')


def say(text):
    print('xhc-dro: ' + text, file=sys.stderr, flush=True)


def positive(text):
    value = float(text)
    if not 0 < value < float('inf'):
        raise ValueError
    return value


def parser():
    words = argparse.ArgumentParser(
        prog='xhc-dro', description='HAL component for an XHC pendant, started by loadusr: its '
        'wheel and keys, and positions on its display.')
    words.add_argument('-f', '--filtered', metavar='AXES', default='',
                       help='axes with a filter, for which one detent is 1000 counts: xyz')
    words.add_argument('-m', '--model', choices=sorted(MODELS), default='hb04',
                       help='model of the pendant (default: hb04, also for an HB03)')
    words.add_argument('-n', '--name', default='xhc-dro',
                       help='name of the component, and prefix of its pins (default: '
                       'xhc-dro)')
    words.add_argument('-p', '--phys', metavar='PHYS',
                       help='use the pendant with this HID_PHYS (default: the first)')
    words.add_argument('-u', '--unit', metavar='LENGTH', type=positive,
                       help='the step that the display shows as x1 (default: 0.001; where the '
                       'machine is in inches, 0.0001)')
    words.add_argument('-V', '--version', action='version', version='xhc-dro ' + VERSION)
    return words


def stop(*_):
    raise SystemExit(0)


def main(arguments=None):
    options = parser().parse_args(arguments)
    try:
        import hal
        import linuxcnc
    except ImportError as error:
        say('LinuxCNC is not installed: /usr/bin/python3 has no module %r' % error.name)
        return FAILURE
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, stop)
    if HALUI_DIES.match(linuxcnc.version):
        say('halui of LinuxCNC %s does not respond after an MDI_COMMAND of [HALUI], nor do the '
            'keys Start, Stop and Reset then: use another version' % linuxcnc.version)
    try:
        if 'INI_FILE_NAME' in os.environ:
            check(os.environ['INI_FILE_NAME'])
        component = Component(hal, linuxcnc, options, say)
    except (hal.error, OSError, ValueError) as error:
        say(str(error))
        return FAILURE
    try:
        component.run()
    finally:
        component.end()
    return 0
