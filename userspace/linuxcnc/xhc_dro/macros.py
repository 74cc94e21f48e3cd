# SPDX-License-Identifier: GPL-2.0-only
"""What keys do by MDI: moves and offsets that depend on no modal state, and the owner's macros."""

import math
import os

ACTIONS = ('safe-z', 'goto-zero', 'goto-zero-selected', 'zero', 'half', *(
    '%s-%s' % (name, axis) for name in ('goto-zero', 'zero', 'half') for axis in 'xyzabc'))
MACROS = tuple('macro-%d' % number for number in range(1, 17))
OWNERS = ('probe-z', 'rewind') + MACROS
AXES = 'XYZABC'
ANGULAR = 'ABC'
RAPID, FEED, NO_MOTION = 0, 10, 800                     # G0, G1, G80
DIAMETER, INCHES, INCREMENTAL, INVERSE_TIME = 70, 200, 910, 930     # G7, G20, G91, G93
COMPENSATION = (410, 411, 420, 421)                     # G41, G41.1, G42, G42.1


def owners_lines(linuxcnc):
    """-> {name: [line]}: [XHC]PROBE_Z, MACRO_1 and so on of the ini, each with all its lines"""
    path = os.environ.get('INI_FILE_NAME')
    if not path:
        return {}
    ini = linuxcnc.ini(path)
    return {name: ini.findall('XHC', name.upper().replace('-', '_')) or [] for name in OWNERS}


def rotated(x, y, degrees):
    angle = math.radians(degrees)
    return (x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle))


class State:
    """What of LinuxCNC's state a line depends on"""

    def __init__(self, stat):
        self.stat = stat
        self.codes = stat.gcodes[1:]            # the first is a line number
        self.motion = self.codes[0]
        self.axes = [axis for bit, axis in enumerate(AXES) if stat.axis_mask >> bit & 1]

    def word(self, axis, value):
        """A word of G code, from the machine's units"""
        if axis not in ANGULAR:
            value /= self.stat.linear_units     # millimetres
            if INCHES in self.codes:
                value /= 25.4
        if axis == 'X' and DIAMETER in self.codes:
            value *= 2
        return '%s%.7f' % (axis, value)

    def _offset(self, number):
        """Of the work piece's system, before its rotation"""
        return self.stat.g5x_offset[number] + self.stat.tool_offset[number]

    def work_position(self, axis):
        number = AXES.index(axis)
        place = [self.stat.position[each] - self._offset(each) for each in range(len(AXES))]
        place[:2] = rotated(*place[:2], -self.stat.rotation_xy)
        return place[number] - self.stat.g92_offset[number]

    def work_zero(self):
        """-> {axis: place}: X and Y of the work piece's zero in the machine's coordinates"""
        place = rotated(*self.stat.g92_offset[:2], self.stat.rotation_xy)
        return {axis: place[number] + self._offset(number)
                for number, axis in enumerate('XY') if axis in self.axes}

    def axis_zero(self, axis):
        """-> {axis: place} of the work piece's zero of this axis, along it: with a rotation that is
        a way of X and Y
        """
        if axis not in 'XY':
            number = AXES.index(axis)
            return {axis: self.stat.g92_offset[number] + self._offset(number)}
        place = [0 if each == axis else self.work_position(each) for each in 'XY']
        place = rotated(*(place[number] + self.stat.g92_offset[number] for number in (0, 1)),
                        self.stat.rotation_xy)
        return {each: place[number] + self._offset(number)
                for number, each in enumerate('XY') if each in self.axes}

    def rapid(self, target):
        """The line which moves there; `target` is {axis: place} in the machine's coordinates.
        LinuxCNC refuses G53 while G91 is in force: then it is the way from here."""
        if INCREMENTAL not in self.codes:
            return 'G53 G0 ' + ' '.join(self.word(*each) for each in target.items())
        way = {axis: place - self.stat.position[AXES.index(axis)]
               for axis, place in target.items()}
        if self.stat.rotation_xy and way.keys() & {'X', 'Y'}:
            turned = rotated(way.get('X', 0), way.get('Y', 0), -self.stat.rotation_xy)
            way.update(zip('XY', turned))
        return 'G0 ' + ' '.join(self.word(*each) for each in way.items())

    def motion_again(self, target):
        """-> [line] after which the motion mode is as before, at the target. An arc or a cycle
        cannot be in force again without a move of it.
        """
        if self.motion == NO_MOTION:
            return ['G80']
        if self.motion == FEED and INVERSE_TIME not in self.codes:
            if INCREMENTAL in self.codes:
                return ['G1 %s0' % next(iter(target))]
            return ['G53 G1 ' + ' '.join(self.word(*each) for each in target.items())]
        return []


def lines_for_axis(name, state, axis):
    """Its last word is the letter of the axis, or it is for `axis`"""
    words = name.split('-')
    named = len(words[-1]) == 1
    if named:
        axis = words[-1].upper()
    if axis not in state.axes:
        raise ValueError('the machine has no axis ' + axis if named else 'no axis is selected')
    if words[0] == 'goto':
        target = state.axis_zero(axis)
        return [state.rapid(target)] + state.motion_again(target)
    value = state.work_position(axis) / 2 if words[0] == 'half' else 0
    return ['G10 L20 P0 ' + state.word(axis, value)]


def lines(name, state, axis, owners):
    """-> [line]; ValueError with the reason why there is none"""
    if name in owners:
        if not owners[name]:
            raise ValueError('[XHC]%s is not in the ini' % name.upper().replace('-', '_'))
        return list(owners[name])
    if name not in ('safe-z', 'goto-zero'):
        return lines_for_axis(name, state, axis)
    if 'Z' not in state.axes:
        raise ValueError('the machine has no axis Z')
    targets = [{'Z': 0}] + [state.work_zero()] * (name == 'goto-zero')
    return [state.rapid(each) for each in targets] + state.motion_again(targets[-1])


class Macros:
    """Made of the module `linuxcnc`, so that a test can bring its own."""

    def __init__(self, linuxcnc, say):
        self.linuxcnc = linuxcnc
        self.say = say
        self.owners = owners_lines(linuxcnc)
        self.stat = None
        self.command = None
        self.lines = []         # still to be sent
        self.mode = None        # to go back to, while a macro runs

    def start(self, name, axis=None):
        """Begins one, or reports why not; nothing moves then."""
        try:
            self._connect()
            self.stat.poll()
            try:
                self._check()
                self.lines = lines(name, State(self.stat), axis, self.owners)
            except ValueError as reason:
                self.command.error_msg('pendant: %s: %s' % (name, reason))
                return
            self.mode = self.stat.task_mode
            self.command.mode(self.linuxcnc.MODE_MDI)
        except self.linuxcnc.error as error:
            self._give_up('%s: %s' % (name, error))

    def _connect(self):
        if not self.stat:
            self.stat, self.command = self.linuxcnc.stat(), self.linuxcnc.command()

    def report(self, text):
        """On the screen"""
        try:
            self._connect()
            self.command.error_msg('pendant: ' + text)
        except self.linuxcnc.error as error:
            self.say(str(error))

    def _check(self):
        stat, linuxcnc = self.stat, self.linuxcnc
        if self.mode is not None:
            raise ValueError('another macro is running')
        if stat.task_state != linuxcnc.STATE_ON:
            raise ValueError('the machine is not on')
        if stat.interp_state != linuxcnc.INTERP_IDLE:
            raise ValueError('a program is running')
        if stat.task_mode == linuxcnc.MODE_AUTO:
            raise ValueError('not in auto mode')
        if not all(stat.homed[:stat.joints]):
            raise ValueError('the machine is not homed')
        if not stat.inpos:
            raise ValueError('the machine is moving')
        if any(code in stat.gcodes[1:] for code in COMPENSATION):
            raise ValueError('not with cutter compensation (G41, G42)')

    def drop(self):
        """The pendant is gone, and with it its key Stop: no further line is sent."""
        self.lines = []

    def turn(self):
        """Sends the next line when the one before is done; after the last, back to the mode."""
        if self.mode is None:
            return
        try:
            self.stat.poll()
            self._go_on()
        except self.linuxcnc.error as error:
            self._give_up(str(error))

    def _go_on(self):
        stat, linuxcnc = self.stat, self.linuxcnc
        later = stat.echo_serial_number - self.command.serial
        if later < 0:
            return
        if later > 0 or stat.state == linuxcnc.RCS_ERROR or stat.task_mode != linuxcnc.MODE_MDI:
            self.lines = []     # refused, or another command has come, which may be Stop
        if stat.task_state != linuxcnc.STATE_ON or stat.task_mode != linuxcnc.MODE_MDI:
            self.mode = None
        elif (stat.state == linuxcnc.RCS_EXEC or stat.interp_state != linuxcnc.INTERP_IDLE or
              not stat.inpos):
            pass
        elif self.lines:
            self.command.mdi(self.lines.pop(0))
        else:
            mode, self.mode = self.mode, None
            self.command.mode(mode)

    def _give_up(self, reason):
        self.lines = []
        self.mode = None
        self.say(reason)
