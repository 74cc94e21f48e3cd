# SPDX-License-Identifier: GPL-2.0-only
"""Debian's LinuxCNC, unchanged, with the configuration of userspace/linuxcnc as an ordinary user
of the group dialout: the wheel of a virtual pendant moves a simulated mill, and the pendant's
display shows where the mill is.

No part of LinuxCNC has a display here; the pendant's keys, and halcmd for what a user would do on
the screen, are all that works it. The kernel is the one that checks nothing: in the other, on a
busy machine, xhc-dro is at times later than xhc-jog.hal allows.
"""

import glob
import os
import shutil
import signal
import subprocess
import time

from case import row
from halcmd import USER, Halcmd
import rig
from rig import find

SOURCE = os.path.join(rig.HERE, '..', '..', 'linuxcnc')
HOME = '/run/mill'
COPY = '/run/linuxcnc'
CONFIG = HOME + '/xhc-hb04'
ENVIRONMENT = {'HOME': HOME, 'PATH': CONFIG + ':/usr/bin:/bin:/usr/sbin:/sbin',
               'PYTHONDONTWRITEBYTECODE': '1'}
DIALOUT = 20
HOME_KEY = {'HB04': 'Goto home', 'WHB04B': 'M-Home'}
PATIENCE = 120          # for what takes no time on a machine that has nothing else to do
# what is printed when something does not come
PINS = ('halui.estop.reset', 'iocontrol.0.user-request-enable', 'iocontrol.0.user-enable-out',
        'iocontrol.0.emc-enable-in', 'halui.estop.is-activated', 'halui.machine.is-on',
        'halui.mode.is-manual', 'halui.mode.is-teleop', 'halui.mode.is-mdi',
        'halui.joint.0.is-homed', 'halui.joint.1.is-homed',
        'halui.joint.2.is-homed', 'halui.axis.x.pos-feedback', 'halui.axis.y.pos-feedback',
        'halui.axis.z.pos-feedback', 'motion.jog-is-active', 'motion.current-vel',
        'xhc-dro.wheel', 'xhc-dro.step', 'xhc.ok.and', 'xhc.on-x.and',
        'xhc.on-y.and', 'xhc.on-z.and', 'xhc.off.or')
NEAR = 3e-5             # millimetres; halcmd says seven digits, of places up to 99.99999


def pin(name):
    return Case.mill.halcmd.run('getp ' + name)


def set_pin(name, value):
    Case.mill.halcmd.run('setp %s %s' % (name, value))


def seen(names):
    """-> {name: value or None}, for messages"""
    found = {}
    for name in names:
        try:
            found[name] = pin(name)
        except AssertionError:
            found[name] = None          # its component is not there, or nothing is
    return found


def is_true(name):
    return pin(name) == 'TRUE'


def keys_down():
    """-> names of the pins of those which xhc-dro has read"""
    return {name for name, value in Case.mill.halcmd.pins('xhc-dro').items()
            if name.startswith('key-') and value == 'TRUE'}


def position(axis):
    return float(pin('halui.axis.%s.pos-feedback' % axis))


def is_at(axis, place):
    """halui has the last micrometres of a move a little later."""
    return abs(position(axis) - place) < NEAR


def processes(word):
    """Those that have `word` among their arguments."""
    found = []
    for path in glob.glob('/proc/[0-9]*/cmdline'):
        try:
            with open(path, 'rb') as file:
                words = file.read().decode(errors='replace').split('\0')
        except OSError:
            continue
        if any(os.path.basename(each) == word for each in words[:2]):
            found.append(int(path.split('/')[2]))
    return found


class Mill:
    """LinuxCNC, from its start to its end."""

    def __init__(self):
        shutil.rmtree(HOME, ignore_errors=True)
        shutil.copytree(COPY, CONFIG)
        self._edit('DISPLAY = axis', 'DISPLAY = dummy')
        # the owner's own, which no key runs
        self._edit('[TRAJ]\n', '[HALUI]\nMDI_COMMAND = M64 P0\nMDI_COMMAND = M64 P0\n\n[TRAJ]\n')
        # so slow that a busy machine has time to see a move stopped
        self._edit('[AXIS_X]\nMAX_VELOCITY = 50', '[AXIS_X]\nMAX_VELOCITY = 5')
        subprocess.run(['chown', '-R', 'nobody:dialout', HOME], check=True)
        self.log = open(HOME + '/log', 'w+', encoding='utf-8', errors='replace')
        self.process = subprocess.Popen(
            [*USER, 'linuxcnc', '-r', CONFIG + '/xhc-hb04.ini'], env=ENVIRONMENT, cwd=HOME,
            stdin=subprocess.PIPE, stdout=self.log, stderr=subprocess.STDOUT)
        self.halcmd = None
        self.wait(lambda: 'DUMMY DISPLAY' in self.said())
        self.halcmd = Halcmd(env=ENVIRONMENT)

    @staticmethod
    def _edit(old, new):
        with open(CONFIG + '/xhc-hb04.ini', encoding='ascii') as file:
            text = file.read()
        if text.count(old) != 1:
            raise AssertionError('no %r' % old)
        with open(CONFIG + '/xhc-hb04.ini', 'w', encoding='ascii') as file:
            file.write(text.replace(old, new))

    def said(self):
        with open(HOME + '/log', encoding='utf-8', errors='replace') as file:
            return file.read()

    def wait(self, condition):
        if not find.wait(condition, PATIENCE, 0.05):
            raise AssertionError('it does not come: %r; LinuxCNC says: %s' % (
                seen(PINS) if self.halcmd else {}, self.said()[-3000:]))

    @staticmethod
    def try_click(name, lamp, lit=True, seconds=3):
        """A button on the screen, held down until it has done its work: halui looks at it now and
        then. -> whether it has
        """
        if is_true('halui.' + lamp) == lit:
            return True
        set_pin('halui.' + name, 1)
        came = find.wait(lambda: is_true('halui.' + lamp) == lit, seconds)
        set_pin('halui.' + name, 0)
        time.sleep(1)
        return came

    def click(self, name, lamp, lit=True, seconds=3):
        self.wait(lambda: self.try_click(name, lamp, lit, seconds))

    def switch_on(self):
        """Out of the emergency stop and on. Where the machine is busy LinuxCNC may take an
        emergency stop for pressed that it has just released, and stays in it, at any time until
        the machine is on: so both buttons are pressed until both have done their work.
        """
        self.wait(lambda: self.try_click('estop.reset', 'estop.is-activated', False) and
                  self.try_click('machine.on', 'machine.is-on'))

    def ready(self):
        """Out of the emergency stop, on, at home"""
        self.switch_on()
        self.home(2)

    def home(self, last):
        """By the key; the joint `last` is not homed before the others."""
        device = Case.pendant.device
        code = device.model.key_code(HOME_KEY[device.model.name])
        lamp = 'halui.joint.%d.is-homed' % last

        def homed():
            if not is_true(lamp):
                device.press(code)
                find.wait(lambda: is_true(lamp), 30)
                device.release(code)
            return is_true(lamp)

        self.wait(homed)
        self.wait(lambda: is_true('halui.mode.is-teleop'))

    def end(self):
        """-> its exit status"""
        self.halcmd.close()
        self.process.communicate(b'\n', timeout=PATIENCE)
        return self.process.returncode


def setup_module():
    """The lock file of LinuxCNC is in /tmp, which is read-only here, and may hold our own files:
    what of them is required has to be read before."""
    rig.load()
    shutil.copytree(SOURCE, COPY)
    subprocess.run(['mount', '-t', 'tmpfs', 'tmpfs', '/tmp'], check=True)


def teardown_module():
    if Case.mill:
        Case.end()
    subprocess.run(['umount', '--lazy', '/tmp'], check=True)


class Case(rig.Case):
    """All share one mill and one pendant, unless a case has ended them."""

    mill = None
    pendant = None

    @classmethod
    def setup_class(cls):
        if not Case.mill:
            Case.mill = Mill()
            Case.pendant = rig.Rig()
            cls.come()
            cls.mill.ready()

    @classmethod
    def end(cls):
        """-> LinuxCNC's exit status"""
        mill, Case.mill = cls.mill, None
        status = mill.end()
        cls.pendant.unplug()
        return status

    @classmethod
    def come(cls):
        """Plugs the pendant in, and does what udev's rules do."""
        pendant = cls.pendant.plug()
        for node in [pendant.event_node, *glob.glob(pendant.path + '/dro/*')]:
            if os.stat(node).st_mode & 0o200:
                os.chown(node, 0, DIALOUT)
                os.chmod(node, 0o660)
        cls.mill.wait(lambda: is_true('xhc.ok.and'))

    def select(self, name):
        device = self.pendant.device
        device.select(device.model.selector_code(name))
        for axis in 'xyz':
            self.mill.wait(lambda: is_true('xhc.on-%s.and' % axis) == (axis == name))
        # leaving an axis stops what moves, for a while in which no other jog begins
        self.finish_cycle()
        self.mill.wait(lambda: not is_true('xhc.off.or'))

    def finish_cycle(self):
        """HAL's components run one after another: what one has done is in all of them when the
        cycle is over, which this pin has the time of. So does xhc-dro, which looks at its pins
        between two changes of this one."""
        for name in ('servo-thread.time', 'xhc-dro.heartbeat'):
            for _ in range(2):
                before = pin(name)
                self.mill.wait(lambda: pin(name) != before)

    def press(self, name, done):
        """Holds a key down until it has done its work: on a busy machine LinuxCNC looks seldom."""
        device = self.pendant.device
        code = device.model.key_code(name)
        others = keys_down()
        device.press(code)
        self.mill.wait(done)
        device.release(code)
        self.mill.wait(lambda: keys_down() <= others)
        self.finish_cycle()

    def run_macro(self, name, places):
        """A key whose move ends there, in the mode in which it began."""
        def done():
            return all(is_at(*each) for each in places.items()) and self.still()

        self.press(name, lambda: is_true('halui.mode.is-mdi') or done())
        self.mill.wait(lambda: done() and is_true('halui.mode.is-manual'))

    def step(self, wanted):
        for _ in range(4):
            now = pin('xhc-dro.step')
            if now == wanted:
                return
            self.press('STEP++', lambda: pin('xhc-dro.step') != now)
        raise AssertionError('no step %s' % wanted)

    def turn(self, detents):
        self.pendant.device.turn(detents)

    def still(self):
        return not is_true('motion.jog-is-active') and float(pin('motion.current-vel')) == 0

    def assert_at(self, axis, wanted):
        """It comes there, and stays there."""
        self.mill.wait(lambda: is_at(axis, wanted) and self.still())
        assert is_at(axis, wanted)

    def counted(self, detents):
        """The wheel's counts, once they have come to LinuxCNC."""
        wanted = self.before + detents
        self.mill.wait(lambda: int(pin('xhc-dro.wheel')) == wanted)

    def set_up(self):
        super().set_up()
        self.mill.ready()
        self.be_patient()
        self.before = int(pin('xhc-dro.wheel'))
        self.select('off')

    def be_patient(self, width=PATIENCE):
        """Seconds without a word of xhc-dro that stop the wheel. The configuration has 0.5, and on
        a busy machine it is at times later: wherever a stop is not what is looked at, it may be."""
        set_pin('xhc.alive.width', width)
        set_pin('xhc-dro.patience', width)
        # it counts from the next word on
        self.mill.wait(lambda: float(pin('xhc.alive.time-left')) <= width)

    def long_jog(self):
        """100 mm, which take twenty seconds; -> where it was to end"""
        self.step('1')
        self.select('x')
        start = position('x')
        self.turn(-100)
        self.mill.wait(lambda: position('x') < start - 1)
        return start - 100

    def assert_stopped(self, end):
        """Far from where it was to end. What says that it moves may be old after a stop."""
        def rests():
            place = position('x')
            time.sleep(1)
            return position('x') == place

        self.mill.wait(rests)
        assert position('x') > end + 10


class TestWheel(Case):
    def test_a_detent_is_a_step(self):
        for step in ('0.001', '0.01', '0.1', '1'):
            self.step(step)
            for axis, detents in (('x', 5), ('x', -3), ('y', -2), ('z', -4), ('z', 1)):
                with row(axis=axis, step=step, detents=detents):
                    self.select(axis)
                    others = {other: position(other) for other in 'xyz' if other != axis}
                    start = position(axis)
                    self.turn(detents)
                    self.assert_at(axis, start + detents * float(step))
                    assert all(is_at(other, place) for other, place in others.items())

    def test_off_moves_nothing(self):
        self.step('1')
        places = {axis: position(axis) for axis in 'xyz'}
        self.turn(20)
        self.counted(20)
        self.select('y')
        assert all(is_at(axis, place) for axis, place in places.items())
        self.turn(1)
        self.assert_at('y', places['y'] + 1)
        assert is_at('x', places['x'])

    def test_another_step_makes_no_jump(self):
        self.step('0.001')
        self.select('x')
        start = position('x')
        self.turn(7)
        self.assert_at('x', start + 0.007)
        for step, place in (('0.01', 0.017), ('0.1', 0.117), ('1', 1.117), ('0.001', 1.118)):
            before = position('x')
            self.step(step)
            assert is_at('x', before)
            self.turn(1)
            self.assert_at('x', start + place)

    def test_steps_go_down_too(self):
        self.step('0.001')
        for step in ('1', '0.1', '0.01', '0.001'):
            self.press('MPG/MODE', lambda: pin('xhc-dro.step') == step)
            assert self.pendant.shows('step', round(float(step) * 1000), PATIENCE)

    def test_overrides(self):
        device = self.pendant.device
        for name, value in (('feed', 'halui.feed-override.value'),
                            ('spindle', 'halui.spindle.0.override.value')):
            for detents, percent in ((-10, 90), (10, 100)):
                device.select(device.model.selector_code(name))
                self.mill.wait(lambda: is_true('xhc.on-%s.and' % name))
                self.turn(detents)
                self.mill.wait(lambda: abs(float(pin(value)) - percent / 100) < NEAR)
                shown = {'feed': 'feedrate_override', 'spindle': 'spindle_override'}[name]
                assert self.pendant.shows(shown, percent, PATIENCE)


class TestDisplay(Case):
    def test_it_shows_where_the_axis_is(self):
        self.step('0.1')
        assert self.pendant.shows('step', 100, PATIENCE)
        self.select('x')
        end = position('x') + 12.3
        self.turn(123)
        self.assert_at('x', end)
        for name in ('machine_x', 'work_x'):
            assert self.pendant.shows(name, '%.4f' % end, PATIENCE)
        assert self.pendant.shows('state', 'idle', PATIENCE)
        assert self.pendant.device.lcd.faults == []


class TestStops(Case):
    def test_selector_off(self):
        end = self.long_jog()
        self.select('off')
        self.assert_stopped(end)

    def test_another_axis(self):
        end = self.long_jog()
        self.select('y')
        self.assert_stopped(end)

    def test_sleep(self):
        end = self.long_jog()
        self.pendant.device.sleep()
        self.assert_stopped(end)

    def test_the_display_program_hangs(self):
        """Then nothing shows any more that the pendant is there; what is turned is lost."""
        program, = processes('xhc-dro')
        end = self.long_jog()
        self.be_patient(0.5)
        os.kill(program, signal.SIGSTOP)
        self.add_cleanup(os.kill, program, signal.SIGCONT)
        self.mill.wait(lambda: not is_true('xhc.ok.and'))
        self.assert_stopped(end)
        place = position('x')
        counts = pin('xhc-dro.wheel')
        self.turn(5)
        self.mill.wait(lambda: any(name == 'REL_DIAL' and value > 0 for _, name, value in
                                   self.pendant.reader.packet() or ()))
        os.kill(program, signal.SIGCONT)
        self.mill.wait(lambda: is_true('xhc.ok.and'))
        self.finish_cycle()
        assert pin('xhc-dro.wheel') == counts
        self.be_patient()
        self.turn(1)
        self.assert_at('x', place + 1)

    def test_unplugged(self):
        """The selector was at X, and after that is at Y: the wheel does not move X any more. The
        screen shows a message.
        """
        screen = Screen()
        for _ in range(2):
            end = self.long_jog()
            self.pendant.unplug()
            self.mill.wait(lambda: not is_true('xhc.ok.and'))
            self.assert_stopped(end)
            self.mill.wait(lambda: screen.message() == 'pendant: unplugged')
            places = position('x'), position('y')
            self.pendant.device.pendant.selector = 0
            self.come()
            self.turn(9)
            self.before = int(pin('xhc-dro.wheel'))
            self.select('y')
            self.turn(2)
            self.assert_at('y', places[1] + 2)
            assert is_at('x', places[0])
            self.select('x')
            self.turn(30)
            self.assert_at('x', places[0] + 30)


class Screen:
    """What an owner does on the screen: commands by MDI, modes, and reading the messages."""

    def __init__(self):
        import linuxcnc     # only where LinuxCNC is
        os.environ['HOME'] = HOME       # its table of tools is there
        self.linuxcnc = linuxcnc
        self.stat = linuxcnc.stat()
        self.command = linuxcnc.command()
        self.errors = linuxcnc.error_channel()
        while self.errors.poll():
            pass

    def mode(self, name):
        self.command.mode(getattr(self.linuxcnc, 'MODE_' + name))
        assert self.command.wait_complete(PATIENCE) == self.linuxcnc.RCS_DONE
        # halui is later
        Case.mill.wait(lambda: is_true('halui.mode.is-' + name.lower()))

    def mdi(self, *lines):
        self.mode('MDI')
        for line in lines:
            self.command.mdi(line)
            assert self.command.wait_complete(PATIENCE) == self.linuxcnc.RCS_DONE, line
        self.mode('MANUAL')

    def codes(self):
        """All modal G codes in force: not the line number and the last code that is not modal"""
        self.stat.poll()
        return self.stat.gcodes[1:2] + self.stat.gcodes[3:]

    def message(self):
        """-> the text of the next message"""
        found = []

        def came():
            message = self.errors.poll()
            if message:
                found.append(message[1].strip())
            return found

        Case.mill.wait(came)
        return found[0]


class TestMacros(Case):
    def set_up(self):
        super().set_up()
        self.screen = Screen()
        self.add_cleanup(self.as_usual)

    def as_usual(self):
        self.screen.mdi('G90 G21 G40 G49 G8 G94 G17 G64 G80', 'G10 L2 P1 X0 Y0 Z0 R0', 'G92.1')

    def refused(self, name, reason, pin_name=None):
        places = {axis: position(axis) for axis in 'xyz'}
        said = []
        self.press(name, lambda: said or said.append(self.screen.message()))
        pin_name = pin_name or name.lower().replace(' ', '-')
        assert said == ['pendant: %s: %s' % (pin_name, reason)]
        time.sleep(1)
        assert all(is_at(axis, place) for axis, place in places.items())

    def test_refused(self):
        self.screen.mdi('G53 G0 X3 Z-4')
        self.screen.mode('AUTO')
        for name in ('Safe-Z', 'Macro 1'):
            self.refused(name, 'not in auto mode')
        self.screen.mode('MANUAL')
        self.screen.mdi('G41.1 D1')
        self.refused('Goto zero', 'not with cutter compensation (G41, G42)')
        self.screen.mdi('G40')
        self.refused('0=', 'no axis is selected', 'zero')
        self.screen.command.teleop_enable(0)
        self.mill.wait(lambda: not is_true('halui.mode.is-teleop'))
        self.screen.command.unhome(2)
        self.mill.wait(lambda: not is_true('halui.joint.2.is-homed'))
        self.refused('Goto zero', 'the machine is not homed')
        self.press('Reset', lambda: is_true('halui.estop.is-activated'))
        self.refused('Goto zero', 'the machine is not on')
        self.mill.ready()

    def test_stop_is_before_the_next_line(self):
        self.screen.mdi('G53 G0 X3 Z-30')
        device = self.pendant.device
        device.press(device.model.key_code('Goto zero'))
        self.mill.wait(lambda: position('z') > -29)
        self.press('Stop', lambda: is_true('halui.mode.is-manual') and self.still())
        device.release(device.model.key_code('Goto zero'))
        time.sleep(1)
        assert is_at('x', 3) and position('z') < -1

    def test_zero_and_half(self):
        for lines in ([], ['G20', 'G91'], ['G10 L2 P1 X1 Y2 Z3 R30'], ['G7', 'G92 X1 Z2']):
            with row(lines=lines):
                self.screen.mdi('G53 G0 X4 Y-6 Z-5', *lines)
                before = self.screen.codes()
                for axis in 'xz':
                    self.select(axis)
                    for name, factor in (('1/2=', 0.5), ('0=', 0)):
                        wanted = factor * self.work(axis)
                        self.press(name, lambda: is_true('halui.mode.is-mdi') or
                                   abs(self.work(axis) - wanted) < NEAR)
                        self.mill.wait(lambda: abs(self.work(axis) - wanted) < NEAR)
                        self.mill.wait(lambda: is_true('halui.mode.is-manual'))
                assert self.screen.codes() == before
                assert [round(position(each), 3) for each in 'xyz'] == [4, -6, -5]
                self.select('off')
                self.as_usual()

    @staticmethod
    def work(axis):
        return float(pin('halui.axis.%s.pos-relative' % axis))

    def test_the_owners(self):
        for name in ('Probe-Z', 'Rewind', 'Macro 1', 'Macro 2', 'Macro 3', 'Macro 6', 'Macro 7'):
            said = []
            self.press(name, lambda: said or said.append(self.screen.message()))
            assert said[0].lower() == name.lower().replace('-', ' ')
            self.mill.wait(lambda: is_true('halui.mode.is-manual'))
        assert not is_true('motion.digital-out-00')

    def test_modal_states(self):
        """Whatever is in force, a key ends at the same place, and leaves it in force."""
        system = 'G10 L2 P1 X3 Y4 Z-2 R%d'
        for lines, zero in ((['G91', 'G1 F500 X0'], (0, 0)), (['G20'], (0, 0)),
                            (['G1 F500 X11', system % 0, 'G43.1 Z5'], (3, 4)),
                            ([system % 30, 'G91', 'G20'], (3, 4)), (['G7', 'G91'], (0, 0)),
                            ([system % 90, 'G92 X0 Y0 Z0'], (12, -6)), (['G93', 'G7'], (0, 0)),
                            ([system % 0, 'G20', 'G7', 'G18', 'G61'], (3, 4))):
            for name in ('Safe-Z', 'Goto zero'):
                with row(lines=lines, key=name):
                    self.screen.mdi('G53 G0 X12 Y-6 Z-5', *lines)
                    before = self.screen.codes()
                    x, y = zero if name == 'Goto zero' else (position('x'), position('y'))
                    self.run_macro(name, {'x': x, 'y': y, 'z': 0})
                    assert self.screen.codes() == before
                    self.as_usual()


class TestKeys(Case):
    def test_go_to_zero(self):
        self.step('1')
        for axis, detents in (('x', 3), ('z', -5)):
            self.select(axis)
            end = position(axis) + detents
            self.turn(detents)
            self.assert_at(axis, end)
        self.select('off')
        self.run_macro('Goto zero', {'x': 0, 'z': 0})
        assert not is_true('motion.digital-out-00')

    def test_stop_ends_a_jog(self):
        end = self.long_jog()
        self.press('Stop', self.still)
        self.assert_stopped(end)

    def test_start_pauses_and_resumes(self):
        """Of a program that another key, Stop, ends"""
        screen = Screen()
        self.add_cleanup(lambda: screen.mode('MANUAL'))
        with open(HOME + '/program.ngc', 'w', encoding='ascii') as file:
            file.write('G21 G90 G94\nG1 F60 X30\nM2\n')
        screen.mode('AUTO')
        screen.command.program_open(HOME + '/program.ngc')
        assert screen.command.wait_complete(PATIENCE) == screen.linuxcnc.RCS_DONE
        screen.mode('MANUAL')
        place = position('x')
        for _ in range(2):
            self.press('Start/Pause', lambda: is_true('halui.program.is-running'))
            self.mill.wait(lambda: position('x') > place + 0.1)
            self.press('Start/Pause', lambda: is_true('halui.program.is-paused'))
            self.mill.wait(lambda: float(pin('motion.current-vel')) == 0)
            place = position('x')
        self.press('Stop', lambda: is_true('halui.program.is-idle'))
        assert place < 25

    def test_spindle(self):
        self.press('Spindle', lambda: is_true('halui.spindle.0.is-on'))
        self.press('Spindle', lambda: not is_true('halui.spindle.0.is-on'))

    def test_reset_is_the_emergency_stop(self):
        end = self.long_jog()
        self.press('Reset', lambda: is_true('halui.estop.is-activated'))
        self.assert_stopped(end)
        self.mill.ready()


class TestEnd(Case):
    def test_nothing_stays(self):
        mill = self.mill
        assert self.end() == 0
        assert find.wait(lambda: not processes('xhc-dro'), 10)
        said = mill.said()
        assert 'xhc-dro:' not in said and 'Traceback' not in said
