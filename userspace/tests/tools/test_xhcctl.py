# SPDX-License-Identifier: GPL-2.0-only
"""xhcctl with virtual pendants: list, show, set and monitor."""

import fcntl
import json
import os
import pty
import signal
import struct
import termios
import threading

from case import row
import rig
import xhcctl_tool
from rig import Case
from tool import FAILURE, INTERRUPTED, NO_DEVICE, OK, USAGE
from xhc_sim.lcd import COORDINATES, NUMBERS
from xhc_sim.models import MODELS
from xhcctl_tool import Follower, run
import re

STATS = ('reports', 'bad_reports', 'xor_mismatches', 'unknown_keys', 'frames_sent',
         'frame_errors')


class ToolCase(Case):
    def assert_says(self, result, status, *words):
        assert result.status == status, result.err
        for word in words:
            assert word in result.err

    def follow(self, *arguments, **options):
        follower = Follower(*arguments, **options)
        self.add_cleanup(follower.kill)
        return follower

    @staticmethod
    def name(pendant):
        return os.path.basename(pendant.path)

    def choose(self, pendant, layout):
        self.add_cleanup(os.unlink, self.udev_entry(pendant, layout))

    @staticmethod
    def udev_entry(pendant, layout):
        """The udev database of a node with the layout's entry in the hwdb."""
        status = os.stat(pendant.event_node)
        os.makedirs('/run/udev/data', exist_ok=True)
        path = '/run/udev/data/c%d:%d' % (os.major(status.st_rdev), os.minor(status.st_rdev))
        with open(path, 'w', encoding='ascii') as file:
            file.write('I:1\nE:XHC_LAYOUT=%s\n' % layout)
        return path


class TestNoPendant(ToolCase):
    def test_every_verb(self):
        for arguments in (['list'], ['show'], ['set', 'step=1'], ['monitor'],
                          ['record', '/run/none'], ['list', '-d', '0']):
            with row(arguments):
                result = run(*arguments)
                self.assert_says(result, NO_DEVICE, 'xhcctl: no pendant')
                assert result.out == ''

    def test_list_in_json(self):
        result = run('list', '--json')
        assert result.status == NO_DEVICE
        assert result.json()[0]['pendants'] == []

    def test_a_pendant_of_another_driver_is_none(self):
        pendant = self.plug()
        pendant.unbind()
        self.assert_says(run('list'), NO_DEVICE)
        pendant.bind()

    def test_without_the_driver(self):
        rig.unload()
        self.assert_says(run('list'), NO_DEVICE)
        assert 'driver hid_xhc: not loaded' in run('--version').out

    def test_version_of_the_driver(self):
        version = rig.read_file('/sys/module/hid_xhc/version').strip()
        assert run('--version').out == \
                         'xhcctl %s\ndriver hid_xhc: %s\n' % (version, version)


class TestList(ToolCase):
    def test_text(self):
        pendant = self.plug()
        result = run('list')
        assert (result.status, result.err) == (OK, '')
        head, line = result.out.splitlines()
        assert head.split() == ['N', 'NAME', 'MODEL', 'AWAKE', 'EVENTS', 'HIDRAW',
                                        'LAYOUT', 'PHYS']
        assert line.split() == [
            '0', self.name(pendant), 'HB04', 'no', os.path.basename(pendant.event_node),
            os.path.basename(pendant.hidraw_node), '(hb04-18)', pendant.device.phys]
        for word in ('NAME', 'MODEL', 'AWAKE', 'EVENTS', 'HIDRAW', 'LAYOUT', 'PHYS'):
            assert line[head.index(word) - 1] == ' '
            assert line[head.index(word)] != ' '

    def test_json(self):
        one, two = self.plug('HB03'), self.plug()
        two.report(selector=0x11)
        self.choose(two, 'hb04-16')
        result = run('list', '-j')
        assert result.status == OK
        assert result.json()[0]['pendants'] == [
            {'index': 0, 'name': self.name(one), 'model': 'HB03', 'awake': False,
             'event': one.event_node, 'hidraw': one.hidraw_node, 'layout': None,
             'phys': one.device.phys},
            {'index': 1, 'name': self.name(two), 'model': 'HB04', 'awake': True,
             'event': two.event_node, 'hidraw': two.hidraw_node, 'layout': 'hb04-16',
             'phys': two.device.phys}]

    def test_every_name_of_a_pendant(self):
        one, two = self.plug('HB03'), self.plug()
        link = '/run/pendant'
        os.symlink(two.event_node, link)
        self.add_cleanup(os.unlink, link)
        for pendant, names in ((one, ['0']), (two, ['1', link])):
            node, raw = pendant.event_node, pendant.hidraw_node
            names += [self.name(pendant), self.name(pendant).lower(), node,
                      os.path.basename(node), raw, os.path.basename(raw), pendant.device.phys]
            for name in names:
                with row(name):
                    pendants = run('list', '-j', '-d', name).json()[0]['pendants']
                    assert [each['name'] for each in pendants] == [self.name(pendant)]

    def test_names_of_none(self):
        self.plug()
        for name in ('1', '-1', '', 'event', '/dev/null', '/dev/nothing', 'x' * 5000,
                     '0003:10CE:EB70.FFFF', '../..'):
            with row(name):
                self.assert_says(run('show', '--device=' + name), NO_DEVICE, 'no pendant')

    def test_of_several_one_must_be_named(self):
        self.plug('HB03'), self.plug()
        for arguments in (['show'], ['set', 'step=1'], ['monitor'], ['record', '/run/none']):
            with row(arguments):
                result = run(*arguments)
                self.assert_says(result, USAGE, 'there are 2 pendants', '--device')
                assert result.out == ''
        assert run('show', '-d', '1').status == OK


class TestShow(ToolCase):
    def test_text_is_sysfs(self):
        for model in ('HB03', 'HB04'):
            pendant = self.plug(model)
            pendant.set('position', '1.5 -2 3 -220.334 0 1')
            pendant.set('state', 'run+0x40')
            pendant.report(selector=0x11)
            pendant.settle()                # so that no number changes meanwhile
            result = run('show')
            assert (result.status, result.err) == (OK, '')
            lines = dict(line.split(None, 1) for line in result.out.splitlines())
            assert lines.pop('name') == self.name(pendant)
            assert lines.pop('layout') == '-'
            names = os.listdir(pendant.path + '/dro')
            names = ['dro/' + name for name in names if name not in ('flush', 'position')]
            names += ['stats/' + name for name in STATS] + ['model', 'awake']
            assert sorted(lines) == sorted(names)
            for name, value in lines.items():
                assert value == pendant.get(os.path.basename(name)), name
            pendant.unplug()

    def test_json_is_sysfs(self):
        pendant = self.plug()
        pendant.set('position', '65535.9999 -2 3 -220.334 0 -0.0001')
        pendant.set('day', '31')
        pendant.settle()                    # so that no number changes meanwhile
        shown = run('show', '--json').json()[0]
        assert (shown['name'], shown['model'], shown['awake'], shown['layout']) == \
                         (self.name(pendant), 'HB04', False, None)
        for name in COORDINATES + NUMBERS + ('step', 'icon', 'state', 'day', 'refresh_ms'):
            assert str(shown['dro'][name]).removesuffix('.0') == \
                             pendant.get(name), name
        assert ' '.join(map(str, shown['dro']['step_available'])) == \
                         pendant.get('step_available')
        assert shown['stats'] == {name: pendant.stat(name) for name in STATS}

    def test_a_closed_pipe_is_told(self):
        self.plug()
        with open('/dev/full', 'wb') as full:
            self.assert_says(run('show', stdout=full), FAILURE, 'standard output')


class TestSet(ToolCase):
    def test_several_fields_reach_the_display_in_one_frame(self):
        pendant = self.plug()
        pendant.set('refresh_ms', '1000')
        for turn in range(1, 6):
            pendant.flush()                 # so that no frame is due while the tool runs
            before = pendant.settle()
            result = run('set', 'work_x=%d.5' % turn, 'work_y=-77.89', 'machine_z=-%d' % turn,
                         'feedrate=%d' % turn, 'spindle_override=80', 'step=%d' % (turn % 2),
                         'state=run+pause', 'icon=%d' % turn)
            assert (result.status, result.out, result.err) == (OK, '', '')
            assert pendant.device.wait_frames(before + 1)
            assert pendant.settle() == before + 1
            shown = pendant.device.lcd.as_dict()
            assert [shown[name] for name in (
                'work_x', 'work_y', 'machine_z', 'feedrate', 'spindle_override', 'step',
                'state', 'icon')] == ['%d.5000' % turn, '-77.8900', '-%d.0000' % turn, turn, 80,
                                    turn % 2, 'run+pause', turn]

    def test_position(self):
        pendant = self.plug('HB03')
        assert run('set', 'position=1 2 3 4 5 6.125').status == OK
        assert pendant.get('position') == '1 2 3 4 5 6.13'

    def test_step_code_in_json(self):
        """A code without a multiplier is a text; one with a multiplier is a number"""
        self.plug()
        for code, shown in (('0x0b', '0x0b'), ('0x03', 10)):
            assert run('set', 'step=' + code, '-j').json()[0]['dro']['step'] == shown

    def test_json_says_what_the_display_has(self):
        self.plug()
        result = run('set', 'work_x=1.99999', 'day=auto', '-j')
        assert (result.status, result.json()[0]['dro']['work_x']) == (OK, 2)

    def test_wait(self):
        pendant = self.plug()
        assert run('set', '--wait', 'work_x=4').status == OK
        assert pendant.device.lcd.as_dict()['work_x'] == '4.0000'

    def test_wait_tells_of_a_pendant_that_takes_nothing(self):
        pendant = self.plug()
        pendant.settle()
        pendant.device.fault = 'stall'
        result = run('set', '--wait', 'work_x=4')
        self.assert_says(result, FAILURE, 'xhcctl: the pendant has not accepted it: Input/output')
        pendant.device.fault = 'none'

    def test_wait_when_it_is_unplugged(self):
        pendant = self.plug()
        pendant.settle()
        pendant.device.fault = 'unplug'
        self.assert_says(run('set', '--wait', 'work_x=4'), NO_DEVICE, 'has gone')

    def test_all_or_none(self):
        pendant = self.plug()
        run('set', 'work_x=1', 'feedrate=2', 'state=run', '--wait')
        before = run('show', '-j').json()[0]['dro']
        for wrong in ('icon=16', 'step=7', 'work_y=65536', 'day=0'):
            result = run('set', 'work_x=9', 'feedrate=9', 'state=pause', wrong)
            self.assert_says(result, FAILURE, wrong.split('=')[0])
            assert run('show', '-j').json()[0]['dro'] == before
        pendant.flush()
        assert pendant.device.lcd.as_dict()['work_x'] == '1.0000'

    def ranges(self, model, rows):
        """rows: (field, text of the range, values in range, values out of range, invalid values)"""
        self.plug(model)
        for field, text, good, over, none in rows:
            for value in good:
                with row(model, field=field, value=value):
                    self.assert_says(run('set', '%s=%s' % (field, value)), OK)
            for values, words in ((over, 'is out of range: '), (none, 'is not a value: ')):
                for value in values:
                    with row(model, field=field, value=value):
                        result = run('set', '%s=%s' % (field, value))
                        self.assert_says(result, FAILURE)
                        assert result.err == 'xhcctl: %s: "%s" %s%s\n' % (
                            field, value, words, text)

    def test_ranges(self):
        number = ('0..65535', ['0', '65535'], ['-1', '65536'], ['', 'x', '1.5'])
        multipliers = ['0', '1', '5', '10', '20', '30', '40', '50', '100', '500', '1000']
        steps = 'one of %s, or a code 0x0..0xf' % ' '.join(multipliers)
        rows = [(name, *number) for name in NUMBERS] + [
            ('icon', '0..15', ['0', '15'], ['-1', '16'], ['', '0x1']),
            ('step', steps, [*multipliers, '0x0b'], ['2', '1001', '0x10'], ['', 'x']),
            ('day', '1..31 or auto', ['1', '31', 'auto'], ['0', '32'], ['today']),
            ('refresh_ms', '10..1000', ['10', '1000', '50'], ['9', '1001'], ['x']),
        ]
        self.ranges('HB04', rows + [
            ('work_x', '-65535.9999..65535.9999', ['-65535.9999', '65535.9999'], ['65536'],
             ['', '1,5']),
            ('position', 'six of -65535.9999..65535.9999', ['1 2 3 4 5 6'], ['0 0 0 0 0 65536'],
             ['1 2 3 4 5', '1 2 3 4 5 6 7', '']),
            ('state', 'idle, run, pause, inch, joined by +, or a number 0..255',
             ['idle', 'run+inch', '255', '0x40'], ['256'], ['walk', '', 'run+'])])

    def test_ranges_of_the_hb03(self):
        self.ranges('HB03', [
            ('machine_z', '-65535.99..65535.99', ['-65535.99', '65535.99'], ['65536'], ['-']),
            ('state', 'idle, run, pause, joined by +, or a number 0..255', ['pause+run', '128'],
             ['256'], ['inch'])])


class TestMonitor(ToolCase):
    def start(self, *arguments):
        follower = self.follow('monitor', '--json', *arguments)
        start = follower.document()
        assert start['event'] == 'start'
        return follower, start

    @staticmethod
    def short(document):
        """An event without the members common to all"""
        return {key: value for key, value in document.items()
                if key not in ('schema', 'tool', 'verb', 'time')}

    def next(self, follower):
        return self.short(follower.document())

    @staticmethod
    def key(scan, caption, down):
        return {'event': 'key', 'scan': scan, 'caption': caption, 'down': down,
                'code': 'BTN_TRIGGER_HAPPY%d' % scan}

    def test_every_key_has_its_caption(self):
        for model in ('HB03', 'HB04'):
            pendant = self.plug(model)
            follower, start = self.start()
            assert (start['model'], start['name'], start['selector'], start['awake']) == \
                             (model, self.name(pendant), 'off', False)
            pendant.report()
            assert self.next(follower) == {'event': 'awake', 'awake': True}
            for scan in range(1, 0x18):
                caption = MODELS[model].keys.get(scan)
                pendant.report(key1=scan)
                assert self.next(follower) == self.key(scan, caption, True)
                pendant.report()
                assert self.next(follower) == self.key(scan, caption, False)
            assert follower.end(signal.SIGINT) == (INTERRUPTED, '')
            pendant.unplug()

    def test_selector_and_wheel(self):
        for model, last in (('HB03', 'speed'), ('HB04', 'A')):
            pendant = self.plug(model)
            pendant.report()
            follower, start = self.start()
            assert start['awake']
            for code, position, value in ((0x11, 'X', 1), (0x13, 'Z', 3), (0x18, last, 4),
                                          (0, 'off', 0)):
                pendant.report(selector=code)
                assert self.next(follower) == {
                    'event': 'selector', 'position': position, 'value': value}
            for detents in (1, -1, 127, -128):
                pendant.report(wheel=detents)
                assert self.next(follower) == {'event': 'wheel', 'detents': detents}
            pendant.unplug()

    def test_the_chosen_layout(self):
        pendant = self.plug()
        pendant.report()
        self.choose(pendant, 'hb04-16')
        follower, start = self.start()
        assert start['layout'] == 'hb04-16'
        pendant.report(key1=8)
        assert self.next(follower)['caption'] == 'Probe-Z'

    def test_a_layout_that_nobody_has(self):
        pendant = self.plug()
        pendant.report()
        self.choose(pendant, 'of-a-friend')
        follower, start = self.start()
        assert start['layout'] == None
        pendant.report(key1=8)
        assert self.next(follower)['caption'] == None
        status, err = follower.end(signal.SIGTERM)
        assert status == OK
        assert 'no layout "of-a-friend"' in err

    def test_a_key_that_was_mapped_anew(self):
        pendant = self.plug()
        pendant.report()
        follower, _ = self.start()
        event = rig.libevdev.EV_KEY.KEY_STOP.value
        entry = struct.pack('<BBHI4s28x', 0, 4, 0, event, struct.pack('<I', 0x16))
        fcntl.ioctl(pendant.reader.fd, 0x40284504, entry)
        pendant.report(key1=0x16)
        assert self.next(follower) == dict(self.key(0x16, 'Stop', True),
                                                   code='KEY_STOP')

    def test_an_unknown_key(self):
        pendant = self.plug()
        pendant.report()
        follower, _ = self.start()
        pendant.report(key1=0x42)
        assert self.next(follower) == {'event': 'unknown', 'scan': 0x42}

    def test_sleep(self):
        pendant = self.plug()
        pendant.report(key1=2, selector=0x12)
        follower, start = self.start()
        assert (start['selector'], start['awake']) == ('Y', True)
        pendant.asleep()
        got = [self.next(follower) for _ in range(3)]
        assert sorted(got, key=lambda event: event['event']) == [
            {'event': 'awake', 'awake': False}, self.key(2, 'Start/Pause', False),
            {'event': 'selector', 'position': 'off', 'value': 0}]

    def test_unplugged_with_a_key_down(self):
        """The release of the key is printed, regardless of what the kernel had time to report."""
        pendant = self.plug()
        pendant.report(key1=2, selector=0x12)
        follower, _ = self.start()
        pendant.report(key1=2, key2=3, selector=0x12)
        assert self.next(follower) == self.key(3, 'Rewind', True)
        pendant.unplug()
        got = [self.short(json.loads(line)) for line in follower.rest()]
        assert got.pop()['error'].endswith(' has gone')
        assert got.pop() == {'event': 'gone'}
        for event in (self.key(2, 'Start/Pause', False), self.key(3, 'Rewind', False),
                      {'event': 'selector', 'position': 'off', 'value': 0}):
            assert got.count(event) == 1, got
        status, err = follower.end()
        assert status == NO_DEVICE
        assert 'has gone' in err

    def test_unplugged_while_nothing_happens(self):
        pendant = self.plug()
        for arguments in ([], ['--display'], ['--timeout', '60']):
            follower, _ = self.start(*arguments)
            pendant.unplug()
            gone, error = [self.short(json.loads(line)) for line in follower.rest()[-2:]]
            assert gone == {'event': 'gone'}
            assert error['error'].endswith(' has gone')
            assert follower.end()[0] == NO_DEVICE
            pendant.plug()

    def test_driver_taken_away(self):
        pendant = self.plug()
        follower, _ = self.start()
        pendant.unbind()
        follower.rest()
        assert follower.end()[0] == NO_DEVICE
        pendant.bind()

    def test_no_key_latches_when_events_are_lost(self):
        """The monitor is stopped while more events occur than the kernel buffers."""
        pendant = self.plug()
        pendant.report(key1=5)
        follower, _ = self.start()
        pendant.report(key1=5, key2=6, selector=0x11)
        for event in (self.next(follower) for _ in range(2)):
            assert event['event'] in ('key', 'selector')
        follower.process.send_signal(signal.SIGSTOP)
        for turn in range(3000):
            pendant.report(key1=7, wheel=1 if turn % 2 else -1, selector=0x13)
        pendant.report(key1=7, selector=0x13)
        assert rig.find.wait(lambda: pendant.stat('reports') == 3003, 30)
        follower.process.send_signal(signal.SIGCONT)
        held, selector, kinds = {5, 6}, 'X', set()
        pendant.report(key1=9, selector=0x13)
        while 9 not in held or selector != 'Z':
            event = self.next(follower)
            kinds.add(event['event'])
            if event['event'] == 'key':
                (held.add if event['down'] else held.discard)(event['scan'])
            elif event['event'] == 'selector':
                selector = event['position']
        assert held == {9}
        assert 'lost' in kinds

    def test_display(self):
        pendant = self.plug()
        follower, start = self.start('--display')
        assert start['dro']['work_x'] == 0
        pendant.set('position', '1 2 3 4 5 6')
        event = self.next(follower)
        assert (event['event'], event['dro']['work_x'], event['dro']['machine_z']) == \
                         ('display', 1, 6)

    def test_count_and_timeout(self):
        pendant = self.plug()
        pendant.report()
        follower, _ = self.start('--count', '2')
        pendant.report(key1=1, wheel=3)
        pendant.report(key1=2)
        assert len(follower.rest()) == 2
        assert follower.end() == (OK, '')
        assert run('monitor', '--timeout', '0.2').status == OK
        self.assert_says(run('monitor', '--timeout=.2', '-n', '3'), FAILURE, 'timed out: 0 of 3')

    def test_lines(self):
        pendant = self.plug()
        pendant.report()
        follower = self.follow('monitor', '--count', '6')
        time_of = r'\d\d:\d\d:\d\d\.\d{3} '
        assert re.search(time_of + 'start    %s awake selector off$' \
                         % self.name(pendant), follower.line())
        pendant.report(key1=0x0D, selector=0x11, wheel=-3)
        pendant.report(key1=0x18)
        for pattern in ('selector X', 'key      STEP[+][+]       down  0dh BTN_TRIGGER_HAPPY13',
                        r'wheel    -3', 'selector off'):
            assert re.search(time_of + pattern + '$', follower.line())
        rest = [line.split(None, 1)[1] for line in follower.rest()]
        assert 'unknown  -            down  18h' in rest
        assert follower.end() == (OK, '')

    def test_a_reader_that_has_gone(self):
        """xhcctl monitor | head -1"""
        pendant = self.plug()
        process = xhcctl_tool.start('monitor')
        self.add_cleanup(process.communicate)
        self.add_cleanup(process.kill)
        assert b'start' in process.stdout.readline()
        process.stdout.close()
        pendant.report(key1=1)
        assert process.wait(30) == -signal.SIGPIPE


class Terminal:
    """A terminal of 80 columns and 24 lines, as far as the monitor uses its functions."""

    def __init__(self, *arguments, **more):
        self.master, slave = pty.openpty()
        fcntl.ioctl(slave, termios.TIOCSWINSZ, struct.pack('HHHH', 24, 80, 0, 0))
        self.process = xhcctl_tool.start(*arguments, stdin=slave, stdout=slave,
                                  env=xhcctl_tool.environment(NO_COLOR='1', **more))
        os.close(slave)
        self.bytes = b''
        self.changed = threading.Condition()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        while True:
            try:
                data = os.read(self.master, 65536)
            except OSError:         # the other end was closed
                return
            with self.changed:
                self.bytes += data
                self.changed.notify_all()

    def lines(self):
        """The last complete picture"""
        pictures = self.bytes.decode().split('\x1b[H')
        picture = pictures[-1]
        if not picture.count('\n') >= 24 - 1 and len(pictures) > 2:
            picture = pictures[-2]
        for sequence in ('\x1b[K', '\x1b[?25h', '\x1b[?25l', '\x1b[2J', '\r'):
            picture = picture.replace(sequence, '')
        return picture.split('\n')

    def shows(self, text, timeout=30):
        with self.changed:
            return self.changed.wait_for(
                lambda: any(text in line for line in self.lines()), timeout)

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        self.process.stderr.close()
        os.close(self.master)


class TestPicture(ToolCase):
    def terminal(self, *arguments, **more):
        terminal = Terminal('monitor', *arguments, **more)
        self.add_cleanup(terminal.close)
        return terminal

    def test_the_lcd_is_what_the_pendant_shows(self):
        for model in ('HB03', 'HB04'):
            pendant = self.plug(model)
            pendant.report(selector=0x11)
            pendant.device.pendant.selector = 0x11
            terminal = self.terminal()
            for number, position in enumerate((
                    '0 0 0 0 0 0', '135.17 -77.89 0 -220.334 0 1.5', '0.5 -0.01 100 7 -8 9',
                    '65535.99 -65535.99 0 0 0 0')):
                pendant.set('position', position)
                pendant.set('step', '100')
                pendant.set('state', 'run+0x40')
                pendant.set('icon', '15')
                for at, name in enumerate(NUMBERS):
                    pendant.set(name, str(number * 1000 + at))
                pendant.flush()
                for line in pendant.device.screen():
                    assert terminal.shows(line), (line, terminal.lines())
            pendant.unplug()

    def test_events_beside_and_below(self):
        pendant = self.plug()
        pendant.report()
        terminal = self.terminal()
        assert terminal.shows('selector  off')
        pendant.report(key1=0x0D, key2=0x17, selector=0x12, wheel=5)
        for text in ('selector  Y', 'wheel     +5, last +5', 'keys      STEP++', 'Reset',
                     'selector Y', 'STEP++       down  0dh BTN_TRIGGER_HAPPY13'):
            assert terminal.shows(text), (text, terminal.lines())
        pendant.report(selector=0x12, wheel=-2)
        assert terminal.shows('wheel     +3, last -2')
        assert terminal.shows('keys      -')
        lines = terminal.lines()
        assert len(lines) <= 24
        assert max(map(len, lines)) <= 80
        terminal.process.send_signal(signal.SIGINT)
        assert terminal.process.wait(30) == INTERRUPTED
        assert rig.find.wait(lambda: terminal.bytes.endswith(b'\x1b[?25h'))

    def test_more_events_than_lines(self):
        pendant = self.plug()
        pendant.report()
        terminal = self.terminal()
        assert terminal.shows('selector  off')
        for turn in range(1, 41):
            pendant.report(wheel=turn)
        assert terminal.shows('wheel    +40'), terminal.lines()
        events = [line for line in terminal.lines() if ' wheel    +' in line]
        assert [event.split()[-1] for event in events] == \
                         ['+%d' % turn for turn in range(31, 41)]
        assert len(terminal.lines()) <= 24

    def test_asleep_and_unplugged(self):
        pendant = self.plug()
        terminal = self.terminal()
        assert terminal.shows('HB04 asleep')
        pendant.unplug()
        assert terminal.process.wait(30) == NO_DEVICE
        assert rig.find.wait(lambda: terminal.bytes.rstrip().endswith(b'\x1b[?25h'))

    def test_a_terminal_that_can_do_nothing_gets_lines(self):
        pendant = self.plug()
        terminal = self.terminal('-n', '1', TERM='dumb')
        assert terminal.shows('start')
        pendant.report()
        assert terminal.process.wait(30) == OK
        assert b'\x1b' not in terminal.bytes
