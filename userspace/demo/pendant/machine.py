# SPDX-License-Identifier: GPL-2.0-only
"""machine.py NODE: a very small CNC control.

The wheel moves the selected axis.  With an HB03 or HB04, Start/Pause runs and stops the program;
with a WHB04B the second rotary switch selects the step, and keys select the mode.

It only uses an event node and files in sysfs of the driver.
"""

import fcntl
import os
import struct
import sys

EVENT = struct.Struct('@qqHHi')
EV_KEY, EV_REL, EV_ABS = 1, 2, 3
REL_DIAL, ABS_THROTTLE, ABS_MISC = 0x07, 0x06, 0x28
BTN_TRIGGER_HAPPY = 0x2BF           # of scan code 0
EVIOCGABS = 0x80184540
AXES = {1: 'x', 2: 'y', 3: 'z', 4: 'a', 7: 'b', 8: 'c'}


class Machine:
    """Common to all models."""

    step = 10                           # thousandths of a millimetre for one detent

    def __init__(self, dro):
        self.dro = dro
        self.position = dict.fromkeys('xyzabc', 0)
        self.axis = None

    def show(self, name, value):
        with open(os.path.join(self.dro, name), 'w', encoding='ascii') as file:
            file.write(str(value))

    def millimetres(self, axis):
        return '%.3f' % (self.position[axis] / 1000)

    def event(self, kind, code, value):
        if (kind, code) == (EV_ABS, ABS_MISC):
            self.select(AXES.get(value))
        elif (kind, code) == (EV_REL, REL_DIAL) and self.axis:
            self.position[self.axis] += value * self.step
            self.show_position()
            print('%s moves to %s mm' % (self.axis, self.millimetres(self.axis)))
        elif (kind, value) == (EV_KEY, 1):
            self.key(code - BTN_TRIGGER_HAPPY)

    def select(self, axis):
        self.axis = axis
        print('axis %s' % (axis or 'none'))


class Hb(Machine):
    START = 0x02

    def __init__(self, dro):
        super().__init__(dro)
        self.running = False
        self.show('position', '0 0 0 -220.334 135.17 -12.5')
        self.show('step', self.step)
        self.show('feedrate', 1200)
        self.show('spindle_speed', 18000)
        self.show('feedrate_override', 100)
        self.show('spindle_override', 80)

    def show_position(self):
        self.show('work_' + self.axis, self.millimetres(self.axis))

    def key(self, scan):
        if scan == self.START:
            self.running = not self.running
            self.show('state', 'run' if self.running else 'pause')
            print('program %s' % ('runs' if self.running else 'pauses'))


class Whb04b(Machine):
    FEED_PLUS, FN, CONTINUOUS, STEP = 0x04, 0x0C, 0x0E, 0x0F
    STEPS = {1: 1, 2: 10, 3: 100, 4: 1000, 5: 5000, 6: 10000}

    def __init__(self, dro):
        super().__init__(dro)
        self.fn = False
        self.rows = 'xyz'
        self.show_position()
        self.show('mode', 'step')
        self.show('coordinates', 'work')
        self.show('feedrate_override', 100)
        self.show('spindle_override', 80)
        self.show('reset', 0)

    def show_position(self):
        self.show('rows', ' '.join(self.millimetres(axis) for axis in self.rows))

    def select(self, axis):
        super().select(axis)
        if axis:
            self.rows = 'abc' if axis in 'abc' else 'xyz'
            self.show_position()

    def event(self, kind, code, value):
        super().event(kind, code, value)
        if (kind, code) == (EV_ABS, ABS_THROTTLE) and value in self.STEPS:
            self.step = self.STEPS[value]
            print('step %.3f mm' % (self.step / 1000))
        elif (kind, code) == (EV_KEY, BTN_TRIGGER_HAPPY + self.FN):
            self.fn = bool(value)

    def key(self, scan):
        if scan == self.FEED_PLUS and self.fn:
            print('macro 1')
        elif scan in (self.CONTINUOUS, self.STEP):
            mode = 'mpg' if scan == self.CONTINUOUS else 'step'
            self.show('mode', mode)
            print('mode %s' % mode)


MACHINES = {'HB03': Hb, 'HB04': Hb, 'WHB04B': Whb04b}


def main():
    event = os.path.basename(sys.argv[1])
    dro = os.path.realpath('/sys/class/input/%s/device/device/dro' % event)
    with open(os.path.join(dro, '../model'), encoding='ascii') as file:
        model = file.read().strip()
    with open(sys.argv[1], 'rb', buffering=0) as node:
        machine = MACHINES[model](dro)
        # the positions of the rotary switches; events only report changes
        for code in (ABS_THROTTLE, ABS_MISC):
            value, = struct.unpack_from('i', fcntl.ioctl(node, EVIOCGABS + code, bytes(24)))
            machine.event(EV_ABS, code, value)
        print('ready')
        try:
            while True:
                _, _, kind, code, value = EVENT.unpack(node.read(EVENT.size))
                machine.event(kind, code, value)
        except OSError:
            print('the pendant was removed')


main()
