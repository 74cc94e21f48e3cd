# SPDX-License-Identifier: GPL-2.0-only
"""xhcctl with a virtual WHB04B: differences to an HB03 or HB04 (see test_xhcctl.py)."""

import os
import signal

import rig
from case import row
from rig import wait
from test_xhcctl import Terminal
from tool import FAILURE, INTERRUPTED, OK, USAGE
from xhc_sim.whb04b import LEAD_ON_OTHERS, MODES
from xhcctl_tool import Follower, run

FOLDER = '/run/recordings'
AXES = (('x', 'X', 1), ('y', 'Y', 2), ('z', 'Z', 3), ('a', 'A', 4), ('b', 'B', 7), ('c', 'C', 8))
RATES = ('2%', '5%', '10%', '30%', '60%', '100%', 'Lead')
OVERRIDES = ('feedrate_override', 'spindle_override')


class ToolCase(rig.Case):
    def whb04b(self, streams=True):
        pendant = self.plug('WHB04B')
        pendant.device.streams = streams
        return pendant

    def follow(self, *arguments):
        follower = Follower(*arguments)
        self.add_cleanup(follower.kill)
        return follower

    def assert_says(self, result, status, *words):
        assert result.status == status, result.err
        for word in words:
            assert word in result.err


class TestAttributes(ToolCase):
    def test_list(self):
        pendant = self.whb04b()
        one, = run('list', '-j').json()[0]['pendants']
        assert (one['model'], one['event'], one['phys']) == \
            ('WHB04B', pendant.event_node, pendant.device.phys)
        assert '(whb04b)' in run('list').out

    def test_show_is_sysfs(self):
        """Exactly the attributes that the driver has for the model"""
        pendant = self.whb04b()
        pendant.set('rows', '1.5 -2 65535.9999')
        lines = dict(line.split(None, 1) for line in run('show').out.splitlines())
        names = [name for name in os.listdir(pendant.path + '/dro')
                 if name not in ('flush', 'rows')]
        assert sorted(name for name in lines if name.startswith('dro/')) == \
            sorted('dro/' + name for name in names)
        for name in names:
            assert lines['dro/' + name] == pendant.get(name), name

    def test_set_and_wait(self):
        pendant = self.whb04b()
        pendant.device.select(pendant.device.model.selector['x'])
        result = run('set', '--wait', 'rows=135.17 -77.89 0.5', 'mode=percent', 'coordinates=work',
                     'reset=0', 'feedrate_override=120', 'spindle_override=80')
        assert (result.status, result.out, result.err) == (OK, '', '')
        shown = pendant.device.lcd.as_dict()
        assert [shown[name] for name in ('row1', 'row2', 'row3', 'mode', 'coordinates', 'reset',
                                         *OVERRIDES, 'faults')] == \
            ['135.1700', '-77.8900', '0.5000', 'percent', 'work', 0, 120, 80, []]

    def test_all_or_none(self):
        self.whb04b()
        run('set', 'row1=1', 'mode=step')
        before = run('show', '-j').json()[0]['dro']
        for wrong, status in (('mode=walk', FAILURE), ('row3=65536', FAILURE), ('step=1', USAGE)):
            result = run('set', 'row1=9', 'reset=1', 'coordinates=work', wrong)
            self.assert_says(result, status, wrong.split('=')[0])
            assert run('show', '-j').json()[0]['dro'] == before

    def test_ranges(self):
        self.whb04b()
        for field, text, good, over, none in (
                ('row1', '-65535.9999..65535.9999', ['65535.9999', '-1'], ['65536'], ['', 'x']),
                ('rows', 'three of -65535.9999..65535.9999', ['1 2 3'], ['0 0 65536'],
                 ['1 2', '1 2 3 4']),
                ('mode', 'continuous, step, mpg or percent', MODES, [], ['walk', '']),
                ('coordinates', 'machine or work', ['machine', 'work'], [], ['both']),
                ('feedrate_override', '0..65535', ['0', '65535'], ['65536'], ['x'])):
            for value in good:
                with row(field, value=value):
                    self.assert_says(run('set', '%s=%s' % (field, value)), OK)
            for values, words in ((over, 'is out of range: '), (none, 'is not a value: ')):
                for value in values:
                    with row(field, value=value):
                        result = run('set', '%s=%s' % (field, value))
                        assert (result.status, result.err) == (
                            FAILURE, 'xhcctl: %s: "%s" %s%s\n' % (field, value, words, text))
        for value in ('0', '1'):
            self.assert_says(run('set', 'reset=' + value), OK)
        for value in ('2', 'x'):
            self.assert_says(run('set', 'reset=' + value), FAILURE, 'reset: "%s" ' % value,
                             ': 0 or 1')


class TestMonitor(ToolCase):
    def start(self, pendant, *arguments):
        """The pendant is awake, and no axis is selected."""
        pendant.device.wake()
        assert wait(lambda: pendant.get('awake') == '1')
        follower = self.follow('monitor', '--json', *arguments)
        start = follower.document()
        assert (start['event'], start['model'], start['layout'], start['selector']) == \
            ('start', 'WHB04B', 'whb04b', 'off')
        return follower, start

    @staticmethod
    def next(follower):
        document = follower.document()
        return {key: value for key, value in document.items()
                if key not in ('schema', 'tool', 'verb', 'time')}

    @staticmethod
    def key(scan, caption, down):
        return {'event': 'key', 'scan': scan, 'caption': caption, 'down': down,
                'code': 'BTN_TRIGGER_HAPPY%d' % scan}

    def test_rotaries_and_wheel(self):
        """While an axis is selected reports are streamed; none of them is an event."""
        pendant = self.whb04b()
        follower, start = self.start(pendant)
        assert start['rotary'] == '2%'
        device, model = pendant.device, pendant.device.model
        for name, position, value in AXES:
            device.select(model.selector[name])
            assert self.next(follower) == {
                'event': 'selector', 'position': position, 'value': value}
        for value, position in enumerate(RATES[1:], 2):
            device.turn_feed(model.feed[position.lower()])
            assert self.next(follower) == {
                'event': 'rotary', 'position': position, 'value': value}
        device.turn_feed(model.feed['2%'])
        assert self.next(follower)['value'] == 1
        device.turn_feed(LEAD_ON_OTHERS)
        assert self.next(follower)['position'] == 'Lead'
        for detents in (1, -1, 127, -128):
            device.turn(detents)
            assert self.next(follower) == {'event': 'wheel', 'detents': detents}
        device.select(model.selector['off'])
        assert self.next(follower) == {'event': 'selector', 'position': 'off', 'value': 0}

    def test_every_key_without_and_with_fn(self):
        pendant = self.whb04b()
        follower, _ = self.start(pendant)
        layout = run('layout', 'whb04b', '-j').json()[0]['keys']
        for key in layout:
            pendant.device.press(key['scan'])
            assert self.next(follower) == self.key(key['scan'], key['caption'], True)
            pendant.device.release(key['scan'])
            assert self.next(follower) == self.key(key['scan'], key['caption'], False)
        for key in layout:
            if not key['fn']:
                continue
            pendant.device.press(0x0c)
            assert self.next(follower) == self.key(0x0c, 'Fn', True)
            pendant.device.press(key['scan'])
            assert self.next(follower) == self.key(key['scan'], key['fn'], True)
            pendant.device.release(0x0c)            # the label of the key stays
            assert self.next(follower) == self.key(0x0c, 'Fn', False)
            pendant.device.release(key['scan'])
            assert self.next(follower) == self.key(key['scan'], key['fn'], False)

    def test_sleep(self):
        pendant = self.whb04b()
        follower, _ = self.start(pendant)
        pendant.device.select(pendant.device.model.selector['b'])
        pendant.device.press(2)
        assert [self.next(follower)['event'] for _ in range(2)] == ['selector', 'key']
        pendant.device.sleep()
        got = []
        while {'event': 'awake', 'awake': False} not in got or len(got) < 3:
            got.append(self.next(follower))
        assert self.key(2, 'Stop', False) in got
        assert {'event': 'selector', 'position': 'off', 'value': 0} in got

    def test_out_of_range(self):
        """Streamed reports stop: no key stays down, no position stays selected."""
        pendant = self.whb04b()
        follower, _ = self.start(pendant)
        pendant.device.select(pendant.device.model.selector['y'])
        pendant.device.press(4)
        assert [self.next(follower)['event'] for _ in range(2)] == ['selector', 'key']
        assert wait(lambda: pendant.stat('reports') > 10)
        pendant.device.radio = False
        got = []
        while {'event': 'awake', 'awake': False} not in got or len(got) < 3:
            got.append(self.next(follower))
        assert self.key(4, 'Feed+', False) in got
        assert {'event': 'selector', 'position': 'off', 'value': 0} in got

    def test_unplugged(self):
        """Keys and positions are released, and the second rotary is unknown."""
        pendant = self.whb04b()
        follower, _ = self.start(pendant)
        pendant.device.select(pendant.device.model.selector['c'])
        pendant.device.press(2)
        assert [self.next(follower)['event'] for _ in range(2)] == ['selector', 'key']
        pendant.unplug()
        got = []
        while {'event': 'gone'} not in got:
            got.append(self.next(follower))
        for event in (self.key(2, 'Stop', False),
                      {'event': 'selector', 'position': 'off', 'value': 0},
                      {'event': 'rotary', 'position': 'unknown', 'value': 0}):
            assert got.count(event) == 1, got

    def test_display(self):
        pendant = self.whb04b()
        follower, start = self.start(pendant, '--display')
        assert start['dro']['row1'] == 0
        pendant.set('rows', '1 2 3')
        event = self.next(follower)
        assert (event['event'], event['dro']['row1'], event['dro']['row3']) == ('display', 1, 3)

    def test_lines(self):
        pendant = self.whb04b()
        pendant.device.wake()
        assert wait(lambda: pendant.get('awake') == '1')
        follower = self.follow('monitor', '--lines', '--display')
        assert follower.line().endswith(' awake selector off rotary 2%')
        pendant.device.turn_feed(pendant.device.model.feed['30%'])
        assert follower.line().endswith(' rotary   30%')
        pendant.set('rows', '1 2.5 -3')
        assert ' display  rows 1 2.5 -3 ' in follower.line()
        assert follower.end(signal.SIGINT)[0] == INTERRUPTED


class TestPicture(ToolCase):
    def test_the_lcd_is_what_the_pendant_shows(self):
        pendant = self.whb04b()
        device, model = pendant.device, pendant.device.model
        device.select(model.selector['x'])
        terminal = Terminal('monitor')
        self.add_cleanup(terminal.close)
        for number, (name, _, _) in enumerate(AXES):
            device.select(model.selector[name])
            device.turn_feed(model.feed[RATES[number].lower()])
            pendant.set('mode', MODES[number % 4])
            pendant.set('coordinates', ('machine', 'work')[number % 2])
            pendant.set('reset', str(number // 3))
            pendant.set('rows', '%d.5 -65535.9999 0' % number)
            pendant.set('feedrate_override', str(100 * number))
            pendant.set('spindle_override', str(65535 * (number % 2)))
            pendant.flush()
            for line in device.screen():
                assert terminal.shows(line), (line, terminal.lines())
        assert terminal.shows('selector  C, rotary 100%')
        device.press(0x0c)
        device.press(4)
        for text in ('keys      Macro 1', '            Fn'):
            assert terminal.shows(text), terminal.lines()
        lines = terminal.lines()
        assert len(lines) <= 24
        assert max(map(len, lines)) <= 80


class TestFiles(ToolCase):
    def test_record_and_replay(self):
        """Replay of a recording causes the same events."""
        os.makedirs(FOLDER, exist_ok=True)
        path = FOLDER + '/whb04b'
        pendant = self.whb04b(streams=False)
        follower = self.follow('record', '--count', '4', path)
        assert wait(lambda: os.path.exists(path) and 'I: 3' in rig.read_file(path))
        device, model = pendant.device, pendant.device.model
        device.select(model.selector['c'])
        device.turn_feed(model.feed['60%'])
        device.press(0x10)
        device.turn(-5)
        assert follower.end() == (OK, '')
        with open(path, encoding='ascii') as file:
            text = file.read()
        assert 'I: 3 10ce eb93\n' in text
        descriptor = model.report_descriptor
        assert 'R: %d %s\n' % (len(descriptor), descriptor.hex(' ')) in text
        assert [line.split()[2] for line in text.splitlines() if line[0] == 'E'] == ['8'] * 4
        pendant.unplug()

        replay = self.follow('replay', '--before', '5', '--after', '5', path)
        assert wait(lambda: run('list').status == OK)
        monitor = self.follow('monitor', '--json', '--timeout', '60')
        assert monitor.document()['event'] == 'start'
        seen = []
        for line in monitor.rest():
            seen += [line] if '"event":"gone"' not in line.replace(' ', '') else []
        text = ''.join(seen).replace(' ', '')
        for wanted in ('"position":"C","value":8', '"position":"60%","value":5',
                       '"caption":"Macro10"', '"detents":-5'):
            assert wanted in text, text
        assert replay.end()[0] == OK
