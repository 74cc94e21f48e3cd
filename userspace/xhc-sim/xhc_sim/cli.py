# SPDX-License-Identifier: GPL-2.0-only
"""The command xhc-sim."""

import argparse
import json
import os
import sys
import time

from . import VERSION
from .models import get_model
from .pendant import NoDevice
from .script import COMMANDS, Failure, Runner, ScriptError

OK, FAILED, USAGE, NO_DEVICE = 0, 1, 2, 3
SCHEMA = 1                  # of JSON objects; incremented when a member is changed or removed

EPILOG_TAIL = """
Coordinates are compared by value ("expect work_x -220.334"); the other fields of "expect"
are the names of the driver's dro/ attributes and: position step_code faults frames awake
selector model, and for the WHB04B: rows flags seed feed (the second rotary switch).
# starts a comment.

exit status: 0 success, 1 failure, 2 invalid usage or script, 3 no /dev/uhid or vhci_hcd
"""


def make_parser():
    commands = '\n'.join('  %-29s %s' % row for row in COMMANDS)
    parser = argparse.ArgumentParser(
        prog='xhc-sim', formatter_class=argparse.RawDescriptionHelpFormatter,
        description='Create a virtual XHC HB03, HB04 or WHB04B pendant with the real report\n'
                    'descriptor, show its LCD, and operate keys, wheel and selector.',
        epilog='script commands:\n' + commands + '\n' + EPILOG_TAIL)
    parser.add_argument('-m', '--model', default='HB04', metavar='MODEL',
                        help='HB03, HB04 (default) or WHB04B')
    parser.add_argument('-u', '--usb', action='store_true',
                        help='use vhci_hcd (a USB device) instead of /dev/uhid')
    parser.add_argument('-s', '--script', metavar='FILE',
                        help='run commands from FILE, or from standard input if it is -')
    parser.add_argument('-j', '--json', action='store_true',
                        help='print each frame and "lcd" as a line of JSON; requires --script')
    parser.add_argument('-t', '--timeout', type=int, default=2000, metavar='MS',
                        help='timeout of "expect" (default 2000)')
    parser.add_argument('-k', '--list-keys', action='store_true',
                        help="print the model's key codes and rotary codes, and exit")
    parser.add_argument('-V', '--version', action='version', version='xhc-sim ' + VERSION)
    return parser


def list_keys(model):
    print('%s keys' % model.name)
    for code in sorted(model.keys):
        print('  0x%02x  %s' % (code, model.keys[code]))
    print('%s selector' % model.name)
    for name, code in model.selector.items():
        print('  0x%02x  %s' % (code, name))
    if model.feed:
        print('%s second rotary' % model.name)
        for name, code in model.feed.items():
            print('  0x%02x  %s' % (code, name))


def make_device(options, model):
    if options.usb:
        from .usb import UsbPendant
        return UsbPendant(model)
    from .uhid import UhidPendant
    return UhidPendant(model)


def load_module(options):
    """vhci_hcd is not loaded automatically; plug() reports a failure."""
    if options.usb and not os.path.exists('/sys/devices/platform/vhci_hcd.0'):
        try:
            os.spawnlp(os.P_WAIT, 'modprobe', 'modprobe', '-q', 'vhci-hcd')
        except OSError:
            pass


def complain(error):
    text = str(error)
    if isinstance(error, OSError) and error.strerror:
        text = '%s: %s' % (error.filename, error.strerror) if error.filename else error.strerror
    print('xhc-sim: %s' % text, file=sys.stderr)


def json_line(kind, device, picture):
    fields = {} if picture is None else picture.as_dict()
    head = {'schema': SCHEMA, 'event': kind, 'time': round(time.time(), 3),
            'model': device.model.name, 'frames': device.frame_count}
    print(json.dumps({**head, 'lcd': fields or None}), flush=True)


def run_script(options, device, text, name):
    def show():
        if options.json:
            json_line('lcd', device, device.seen)
        else:
            print('\n'.join(device.screen()), flush=True)

    if options.json:
        device.on_frame = lambda picture: json_line('frame', device, picture)
    runner = Runner(device, show, lambda line: print(line, flush=True), options.timeout / 1000)
    steps = runner.parse(text, name)
    load_module(options)
    device.plug()
    runner.run(steps)


def run_terminal(options, device):
    from .terminal import Terminal
    load_module(options)
    device.plug()
    Terminal(device).run()


def read_script(path):
    """-> (text, name for messages)"""
    if path == '-':
        return sys.stdin.read(), 'stdin'
    with open(path, encoding='utf-8') as file:
        return file.read(), path


def main(arguments=None):
    parser = make_parser()
    options = parser.parse_args(arguments)
    try:
        model = get_model(options.model)
    except ValueError as error:
        parser.error(str(error))
    if options.list_keys:
        list_keys(model)
        return OK
    if options.timeout < 0:
        parser.error('--timeout must not be negative')
    if options.json and not options.script:
        parser.error('--json requires --script')
    if not options.script and not (sys.stdin.isatty() and sys.stdout.isatty()):
        parser.error('not a terminal: use --script')

    text = name = None
    if options.script:
        try:
            text, name = read_script(options.script)
        except (OSError, UnicodeDecodeError) as error:
            complain(error)
            return USAGE

    device = make_device(options, model)
    try:
        if options.script:
            run_script(options, device, text, name)
        else:
            run_terminal(options, device)
    except ScriptError as error:
        complain(error)
        return USAGE
    except NoDevice as error:
        complain(error)
        return NO_DEVICE
    except (Failure, OSError) as error:
        complain(error)
        return FAILED
    except KeyboardInterrupt:
        return OK
    finally:
        device.unplug()
    return OK
