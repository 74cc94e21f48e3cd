# SPDX-License-Identifier: GPL-2.0-only
"""machine.py NODE: a very small CNC control.

The wheel moves the selected axis, Start/Pause runs and stops the program.

All that it uses of the driver is an event node and files in sysfs.
"""

import os
import struct
import sys

EVENT = struct.Struct('@qqHHi')
EV_KEY, EV_REL, EV_ABS = 1, 2, 3
ABS_MISC, REL_DIAL = 0x28, 0x07
START = 0x2C1                       # BTN_TRIGGER_HAPPY2: scan code 02h
STEP = 10                           # thousandths of a millimetre for one detent
AXES = {1: 'x', 2: 'y', 3: 'z'}


class Machine:
    def __init__(self, dro):
        self.dro = dro
        self.position = {'x': 0, 'y': 0, 'z': 0}
        self.axis = None
        self.running = False
        self.show('position', '0 0 0 -220.334 135.17 -12.5')
        self.show('step', STEP)
        self.show('feedrate', 1200)
        self.show('spindle_speed', 18000)
        self.show('feedrate_override', 100)
        self.show('spindle_override', 80)

    def show(self, name, value):
        with open(os.path.join(self.dro, name), 'w', encoding='ascii') as file:
            file.write(str(value))

    def event(self, kind, code, value):
        if (kind, code) == (EV_ABS, ABS_MISC):
            self.axis = AXES.get(value)
            print('axis %s' % (self.axis or 'none'))
        elif (kind, code) == (EV_REL, REL_DIAL) and self.axis:
            self.move(value)
        elif (kind, code, value) == (EV_KEY, START, 1):
            self.running = not self.running
            self.show('state', 'run' if self.running else 'pause')
            print('program %s' % ('runs' if self.running else 'pauses'))

    def move(self, detents):
        axis = self.axis
        self.position[axis] += detents * STEP
        millimetres = '%.3f' % (self.position[axis] / 1000)
        self.show('work_' + axis, millimetres)
        print('%s goes to %s mm' % (axis, millimetres))


def main():
    event = os.path.basename(sys.argv[1])
    dro = os.path.realpath('/sys/class/input/%s/device/device/dro' % event)
    with open(sys.argv[1], 'rb', buffering=0) as node:
        machine = Machine(dro)
        print('ready')
        try:
            while True:
                _, _, kind, code, value = EVENT.unpack(node.read(EVENT.size))
                machine.event(kind, code, value)
        except OSError:
            print('the pendant is gone')


main()
