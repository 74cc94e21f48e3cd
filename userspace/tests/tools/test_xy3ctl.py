# SPDX-License-Identifier: GPL-2.0-only
"""xy3ctl with a virtual head (xy3-sim): its output, JSON and exit status; and the data that the
head has received.
"""

import array
import glob
import math
import os
import pty
import re
import select
import struct

import pytest
import forward_rig
import head_rig
import kernel
from kernel import read_file, wait, write_file
from tool import FAILURE, INTERRUPTED, NO_DEVICE, OK, USAGE, Tool

LIMIT = 60              # timeout in seconds; an idle machine needs none of it
xy3ctl = Tool('xy3ctl')
SPIDEV = os.environ.get('SPIDEV_MODULE', '')


def setup_module():
    forward_rig.load()
    kernel.load_module(SPIDEV)


def lines_with(running, *words):
    """-> the lines until all of these words were printed, in any order"""
    lines = []
    while not all(any(word in line for line in lines) for word in words):
        line = running.line()
        assert line, (lines, running.end())
        lines.append(line)
    return lines


class Case(forward_rig.Case):
    def head(self, *arguments, attach=True, **keywords):
        """A virtual head whose backchannel is attached."""
        forward = self.forward(*arguments, **keywords)
        if attach:
            assert forward.attach()
        return forward

    def started(self, *words, **options):
        running = xy3ctl.start(*words, **options)
        self.add_cleanup(running.close)
        return running

    def assert_status(self, status, *words, says='', text=''):
        """It exits with this status, a message on standard error, and no output"""
        found, output, errors = xy3ctl.run(*words, text=text)
        assert (found, output) == (status, ''), (words, errors)
        assert re.search(r'^xy3ctl', errors), words
        assert says in errors


class TestWords(Case):
    def test_version(self):
        status, output, _ = xy3ctl.run('--version')
        assert status == OK
        version = read_file('/sys/module/xy3/version').strip()
        assert output == 'xy3ctl %s\ndriver xy3: %s\ndriver xy3_spi: %s\n' \
                         % ((version,) * 3)


class TestTelling(Case):
    def told(self, forward):
        """A head that has reported all values."""
        for name, text in (('vendor', 'Lasers Ltd'), ('model', 'LX-20'), ('firmware', '1.2.3'),
                           ('serial', '4711'), ('temperatures', '3150 - 2980 -550'),
                           ('errors', '0 0 1 101'), ('hours', '1234 - 7'), ('report', '1')):
            forward.set_sim(name, text)
        last = {'serial': '4711\n', 'errors/dac_y': '101\n', 'hours/dac_x': '7\n'}
        assert wait(lambda: all(
            head_rig.error_name(read_file, forward.head + name) is None and
            read_file(forward.head + name) == text for name, text in last.items()), LIMIT)
        assert wait(lambda: {'head', 'dac_x', 'dac_y'} <= self.thermometers(forward), LIMIT)

    def thermometers(self, forward):
        """-> their labels; a worker registers the device, and again if there are more of them"""
        try:
            return {read_file(path).rstrip('\n')
                    for path in glob.glob(forward.head + 'hwmon*/temp*_label')}
        except OSError:
            return set()

    def test_list_and_show(self):
        forward = self.head(4, 'line')
        self.told(forward)
        status, output, errors = xy3ctl.run('list')
        assert (status, errors) == (OK, '')
        iio = os.path.basename(forward.iio.rstrip('/'))
        assert [line.split() for line in output.splitlines()] == \
                         [['HEAD', 'SYNC', 'RATE', 'BACK', 'FORWARD', 'IIO', 'VENDOR', 'MODEL'],
                          ['xy3-0', 'yes', '115200', 'ttyXY3SIM0', forward.device, iio, 'Lasers',
                           'Ltd', 'LX-20']]

        head, = xy3ctl.json('list')['heads']
        want = {'head': 'xy3-0', 'node': '/dev/xy3-0', 'back': 'ttyXY3SIM0', 'iio': iio,
                'forward': forward.device, 'vendor': 'Lasers Ltd', 'model': 'LX-20',
                'firmware': '1.2.3', 'serial': '4711', 'in_sync': True, 'rate': 115200,
                'temperature': {'head': 31.5, 'dac_x': 29.8, 'dac_y': -5.5},
                'errors': {'head': 'none', 'dsp': 'none', 'dac_x': 'temperature', 'dac_y': '101'},
                'hours': {'head': 1234, 'dac_x': 7}, 'frame_errors': dict.fromkeys('xyzuw', 0)}
        assert head == want
        for name in ('xy3-0', '0', '/dev/xy3-0'):
            show = xy3ctl.json('show', '-d', name)
            assert {key: show[key] for key in want} == want
        assert show['statistics'].keys() == set(head_rig.STATS)
        assert (show['stream']['frame_bits'], show['stream']['scans']) == (24, 0)

        status, output, errors = xy3ctl.run('show')
        assert (status, errors) == (OK, '')
        assert 'xy3-0  Lasers Ltd LX-20  firmware 1.2.3  serial 4711\n' in output
        assert 'in sync at 115200 bit/s' in output
        assert re.search(r'\ndac +29\.80 +-5\.50 +- +- +- +31\.50 +-\n', output)
        assert re.search(r'\nerrors +dac_x +temperature +dac_y +101 *\n', output)
        assert re.search(r'\n  rx_packets +[1-9]\d*\n', output)
        assert '\033' not in output

    def test_without_one_channel(self):
        forward = self.head(2, 'cs', attach=False)
        show = xy3ctl.json('show')
        assert (show['back'], show['rate'], show['vendor'], show['errors']) == \
                         (None, None, None, {})
        assert 'no backchannel' in xy3ctl.run('show')[1]
        self.assert_status(FAILURE, 'command', 'rate', '57600', says='no backchannel')
        assert forward.attach()
        forward.unbind()
        show = xy3ctl.json('show')
        assert (show['back'], show['iio'], show['stream']) == ('ttyXY3SIM0', None, None)
        self.assert_status(FAILURE, 'command', 'calibrate', says='no forward channel')
        self.assert_status(NO_DEVICE, 'goto', '1', says='forward channel')
        forward.bind()

    def test_watch_lines(self):
        forward = self.head(2, 'cs')
        self.told(forward)
        watch = self.started('watch')
        first = watch.until('frame_errors/w')
        assert re.search(r'^\d\d:\d\d:\d\d vendor Lasers Ltd$', first[0])
        assert [line.split(' ', 1)[1] for line in first if 'temperature/' in line] == \
                         ['temperature/head 31.50', 'temperature/dac_x 29.80',
                          'temperature/dac_y -5.50']
        forward.set_sim('errors', '0 4 0 0')
        forward.set_sim('report', '1')
        # it reads one file after another: the packet may arrive meanwhile
        assert {line.split(' ', 1)[1] for line in lines_with(
            watch, 'errors/dsp', 'errors/dac_x', 'errors/dac_y')} == \
            {'errors/dsp power', 'errors/dac_x none', 'errors/dac_y none'}
        assert watch.interrupt()[0] == INTERRUPTED

    def test_watch_json(self):
        forward = self.head(2, 'cs')
        self.told(forward)
        watch = self.started('watch', '-j', '-i', '0.2')
        watch.until('frame_errors/w')
        forward.set_sim('temperatures', '3160')
        forward.set_sim('report', '1')
        changed = xy3ctl.documents('\n'.join(lines_with(
            watch, 'temperature/head', 'temperature/dac_x', 'temperature/dac_y')))
        assert {line['name']: line['value'] for line in changed} == \
            {'temperature/head': 31.6, 'temperature/dac_x': None, 'temperature/dac_y': None}
        assert len(changed) == 3
        forward.close()                 # then the head ends with its forward channel
        forward.unbind()
        status, _, errors = watch.end()
        assert status == NO_DEVICE, errors
        forward.bind()

    def test_watch_ends(self):
        self.head(2, 'cs')
        assert xy3ctl.run('watch', '-n', '2')[0] == OK
        assert len(xy3ctl.run('watch', '-n', '2')[1].splitlines()) == 2
        assert xy3ctl.run('watch', '-t', '0.5')[0] == OK
        status, _, errors = xy3ctl.run('watch', '-n', '1000', '-t', '0.5')
        assert status == FAILURE
        assert 'timed out' in errors

    def test_watch_on_a_terminal(self):
        """A picture of at most 24 lines of 80 characters, with an error in red"""
        forward = self.head(4, 'line')
        self.told(forward)
        master, slave = pty.openpty()
        self.add_cleanup(os.close, master)
        process = os.fork()
        if not process:
            os.dup2(slave, 1)
            os.execve(xy3ctl.path, [xy3ctl.path, 'watch', '-n', '1'],
                      {**os.environ, 'TERM': 'xterm'})
        os.close(slave)
        data = b''
        while select.select([master], [], [], 20)[0]:
            try:
                data += os.read(master, 65536)
            except OSError:             # the program has exited
                break
        assert os.waitpid(process, 0)[1] == 0
        text = data.decode().replace('\r\n', '\n')
        assert '\033[31m' in text
        lines = re.sub(r'\033\[[0-9;]*[A-Za-z]', '', text).splitlines()
        assert len(lines) < 24
        assert max(map(len, lines)) <= 79
        assert 'dac           29.80     -5.50' in text.replace('\033[31m', '') \
                      .replace('\033[0m', '')


class TestPackets(Case):
    def test_live(self):
        forward = self.head(2, 'cs')
        packets = self.listening('--raw')
        for name, text in (('vendor', 'Lasers Ltd'), ('temperatures', '3150 - 2980'),
                           ('errors', '0 1 100'), ('hours', '12 -'), ('send', '48 77 02 0a 0b')):
            forward.set_sim(name, text)
        forward.set_sim('report', '1')
        lines = packets.until(' hours ')
        found = [line.split(None, 1)[1] for line in lines if re.match(r'\d\d:', line)]
        for text in ('vendor Lasers Ltd', 'temperatures head=31.50 dac_x=29.80',
                     'errors head=none dsp=temperature dac_x=100', 'hours head=12',
                     'type_77 0a 0b'):
            assert text in found
        assert '48 77 02 0a 0b' in [line.strip() for line in lines]
        assert packets.interrupt()[0] == INTERRUPTED

        packets = self.listening('-j', '-n', '3')
        forward.set_sim('report', '1')
        status, output, _ = packets.end()
        assert (status, len(xy3ctl.documents(output))) == (OK, 3)

    def listening(self, *options):
        """Packets are passed to programs that have the tty open."""
        packets = self.started('packets', *options)
        folder = '/proc/%d/fd/' % packets.process.pid
        assert wait(lambda: any(os.path.realpath(folder + name) == '/dev/xy3-0'
                                for name in os.listdir(folder)), LIMIT)
        return packets

    def test_head_goes(self):
        forward = self.head(2, 'cs')
        packets = self.started('packets')
        packets.line()
        forward.close()
        forward.unbind()
        status, _, errors = packets.end()
        assert (status, errors) == (NO_DEVICE, 'xy3ctl: the head has gone\n')
        forward.bind()


class TestGate(Case):
    def gated(self):
        forward = self.head(4, 'line')
        forward.set_sim('signals', 'sync x y gate')
        write_file(forward.spi + 'line_map', 'sync x y gate')
        forward.find()
        return forward

    def places(self, forward, *options):
        """-> X of the scans with a high gate, of ten scans of which the fourth and fifth set it"""
        with open('/run/scans', 'w', encoding='ascii') as file:
            for i in range(10):
                file.write('%d 5 %d\n' % (i, i in (3, 4)))
        forward.record(1000)
        status, _, errors = xy3ctl.run('stream', '--codes', '-r', '50000', *options, '/run/scans')
        assert (status, errors) == (OK, '')
        rows = [row.split() for row in forward.sim('record').splitlines()]
        assert [row[0] for row in rows][-1] == '9'
        return [int(x) for x, _, gate in rows if gate == '1']

    def test_column_and_delays(self):
        forward = self.gated()
        assert self.places(forward) == [3, 4]
        assert self.places(forward, '--gate-on-delay', '40', '--gate-off-delay=40') == [5, 6]
        assert self.places(forward, '--gate-on-delay=-60', '--gate-off-delay=-20') == [0, 1, 2, 3]
        assert self.places(forward, '--gate-on-delay=40') == []
        assert self.places(forward, '--gate-off-delay=20') == [3, 4, 5]

    def test_shape(self):
        forward = self.gated()
        for options, count in (((), 0), (('--gate',), 100)):
            before = forward.sim_number('gate', 'scans')
            assert xy3ctl.run('stream', 'circle', '--points=100', *options)[0] == OK
            assert forward.sim_number('gate', 'scans') - before == count
            assert forward.sim_number('gate', 'high') == 0

    def test_refused(self):
        self.gated()
        with open('/run/scans', 'w', encoding='ascii') as file:
            file.write('0 0 2\n')
        status, _, errors = xy3ctl.run('stream', '--codes', '/run/scans')
        assert status != OK and 'is not 0 or 1' in errors

    def test_no_gate(self):
        self.head(4, 'line')
        status, _, errors = xy3ctl.run('stream', 'circle', '--gate')
        assert status != OK and 'no gate' in errors


class TestCommanding(Case):
    def test_commands(self):
        forward = self.head(2, 'cs')
        for words, want in ((('autocalib', 'on', 'xy'), '80003 autocalib on xy'),
                            (('autocalib', 'off'), '40000 autocalib off xyzuw'),
                            (('temp-comp', 'on', 'w'), '88010 temp_comp on w'),
                            (('temp-comp', 'off', 'all'), '48000 temp_comp off xyzuw'),
                            (('calibrate', 'z'), 'c0004 calibrate z'),
                            (('reference',), '20000 reference xyzuw')):
            document = xy3ctl.json('command', *words)
            assert document['code'] == int(want.split()[0], 16)
            assert wait(lambda want=want: forward.sim('commands').endswith(want), LIMIT), \
                            (words, forward.sim('commands'))

    def test_rates(self):
        forward = self.head(2, 'cs')
        for rate in ('921600', '57600', '115200'):
            assert xy3ctl.run('command', 'rate', rate) == (OK, '', '')
            assert forward.sim('rate') == rate
            assert read_file(forward.head + 'rate').strip() == rate

    def test_head_that_does_not_follow(self):
        forward = self.head(2, 'cs')
        forward.set_sim('sync_ms', '0')
        forward.set_sim('interval_ms', '0')
        self.assert_status(FAILURE, 'command', 'rate', '57600', says='no sync at 57600 bit/s')


class TestMoving(Case):
    def positions(self, forward):
        return [int(line.split()[1]) for line in forward.sim('positions').splitlines()]

    def test_goto(self):
        forward = self.head(4, 'line', attach=False)
        assert xy3ctl.run('goto', '1', '0xfffff', '77') == (OK, '', '')
        assert self.positions(forward) == [1, 0xfffff, 77]
        document = xy3ctl.json('goto', 'y=5')
        assert document['codes'] == {'y': 5}
        assert self.positions(forward) == [1, 5, 77]
        assert xy3ctl.run('goto', '-u', 'x=-1', 'y=1', 'z=0')[0] == OK
        assert self.positions(forward) == [0, 0xfffff, 0x80000]
        assert xy3ctl.run('goto', '--bits', '32', 'x=67108863')[0] == OK
        assert forward.get('out_angl0_raw') == '67108863'
        assert xy3ctl.run('goto', '--bits', '24', 'x=0')[0] == OK
        before = self.positions(forward)
        for words, says in ((('x=1048576',), 'from 0 to 1048575'), (('x=7', 'y=-1'), 'from 0'),
                            (('-u', 'x=1.5'), 'from -1 to 1')):
            self.assert_status(FAILURE, 'goto', *words, says=says)
        for words in (('u=1',), ('x=1', 'x=2'), ('x=left',), ('x=',), ('-u', 'x=nan')):
            self.assert_status(USAGE, 'goto', *words)
        assert self.positions(forward) == before

    @pytest.mark.parametrize('lines, framing, signals, where', (
        (4, 'line', 'sync x y z', {'x': 1, 'y': 0xfffff, 'z': 77}),
        (4, 'line', 'sync x y z', {'z': 5, 'x': 6}),
        (8, 'cs', 'x y z u w - - -', {'x': 1, 'y': 2, 'z': 3, 'u': 4, 'w': 5}),
        (4, 'line', 'sync x y gate', {'x': 3, 'y': 4})))
    def test_goto_is_one_scan(self, lines, framing, signals, where):
        """No intermediate steps: the head receives no position between the old and the new one."""
        forward = self.head(lines, framing, attach=False,
                            more='signals=' + signals.replace(' ', ','))
        forward.record(100)
        assert xy3ctl.run('goto', *('%s=%d' % one for one in where.items()))[0] == OK
        columns = [word for word in signals.split() if word in 'xyzuw']
        want = [where.get(axis, 0x80000) for axis in columns] + [0] * ('gate' in signals)
        assert list(memoryview(forward.recorded()).cast('I')) == want
        assert forward.number('scans') - forward.number('repeated') == 1

    def test_goto_that_is_not_sent(self):
        forward = self.head(4, 'line', attach=False)
        forward.set_sim('faults/spi_error_in', '1')
        self.assert_status(FAILURE, 'goto', '1', '2', says='has not sent the position')
        assert forward.get('buffer/enable') == '0'
        assert xy3ctl.run('goto', '1', '2') == (OK, '', '')

    def test_not_while_a_stream_runs(self):
        forward = self.head(2, 'cs', attach=False)
        assert forward.start() is None
        self.assert_status(FAILURE, 'goto', '1', says='a stream runs')
        self.assert_status(FAILURE, 'stream', 'circle', says='a stream runs')
        assert forward.stop() is None
        assert xy3ctl.run('goto', '1')[0] == OK


class TestStreaming(Case):
    def recorded(self, forward):
        """-> received scans, without those that repeat the previous one"""
        axes = forward.axes
        data = array.array('I', forward.recorded())
        return [tuple(data[i:i + axes]) for i in range(0, len(data), axes)]

    @staticmethod
    def unit(code):
        return code / 0xfffff * 2 - 1

    def test_circle(self):
        forward = self.head(4, 'line', attach=False)
        forward.record(10000)
        document = xy3ctl.json('stream', 'circle', '--points', '360', '--size', '0.5')
        assert document['scans'] == 361
        scans = self.recorded(forward)
        assert len(scans) == 361
        assert scans[0] == scans[-1]
        assert {scan[2] for scan in scans} == {0x80000}
        for i, scan in enumerate(scans):
            angle = math.pi / 4 + 2 * math.pi * i / 360
            assert abs(self.unit(scan[0]) - math.cos(angle) / 2) < 2e-6
            assert abs(self.unit(scan[1]) - math.sin(angle) / 2) < 2e-6
        assert forward.get('buffer/enable') == '0'

    def test_shapes_are_those_of_the_example(self):
        """figure.py, with the same arguments, has the same corners"""
        forward = self.head(2, 'cs', attach=False)
        corner = 0.9 * math.sqrt(0.5)
        for shape, corners in (('square', 4), ('grid', 20)):
            forward.record(100000)
            assert xy3ctl.run('stream', shape, '--repeat', '1')[0] == OK
            scans = [(self.unit(x), self.unit(y)) for x, y in self.recorded(forward)]
            assert math.dist(scans[0], (corner, corner)) < 1e-5
            assert math.dist(scans[-1], scans[0]) < 1e-5
            steps = [math.dist(a, b) for a, b in zip(scans, scans[1:])]
            assert max(steps) < 0.0021
            turns = sum(1 for a, b, c in zip(scans, scans[1:], scans[2:])
                        if abs((b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]))
                        > 1e-6)
            assert turns >= corners - 1
            assert max(max(map(abs, scan)) for scan in scans) < corner + 1e-5

    def test_numbers(self):
        forward = self.head(4, 'line', attach=False)
        forward.record(10)
        status, output, errors = xy3ctl.run(
            'stream', '-', text='# X Y Z\n-1 1 0\n0.5,0.5,1\n\n\t0 ; 0;0\r\n')
        assert (status, errors) == (OK, '')
        assert re.search(r'^3 scans in \d+\.\d\d s(, \d+ of 100000 frames/s)?, ' \
                                 r'\d+ underruns\n$', output)
        middle, three_quarters = 0x80000, round(0.75 * 0xfffff)
        assert self.recorded(forward) == \
                         [(0, 0xfffff, middle), (three_quarters, three_quarters, 0xfffff),
                          (middle, middle, middle)]

    def test_codes_and_raw(self):
        forward = self.head(2, 'cs', attach=False)
        scans = [(i, 0xfffff - i) for i in range(5000)]
        with open('/run/codes', 'w', encoding='ascii') as file:
            file.writelines('%d %d\n' % scan for scan in scans)
        with open('/run/raw', 'wb') as file:
            for scan in scans:
                file.write(struct.pack('<2I', *scan))
        for words in (('--codes', '/run/codes'), ('--raw', '/run/raw')):
            forward.record(10000)
            assert xy3ctl.json('stream', *words)['scans'] == 5000
            assert self.recorded(forward) == scans

    def test_files_that_are_wrong(self):
        forward = self.head(2, 'cs', attach=False)
        for words, text, says in (((), '0 0\n1 left\n', "line 2: 'left' is not a number"),
                                  ((), '0 1.5\n', "line 1: '1.5' is not from -1 to 1"),
                                  (('--codes',), '5 1048576\n', 'is not a code'),
                                  (('--raw',), '\0\0\0\0abc', 'in the middle of scan 1')):
            status, _, errors = xy3ctl.run('stream', *words, '-', text=text)
            assert status == FAILURE, (words, text)
            assert says in errors
            assert forward.get('buffer/enable') == '0'
        self.assert_status(FAILURE, 'stream', '/no/such/file', says='No such file')

    def test_rate_and_interruption(self):
        """It stops on a signal: the buffer is off, and the count is that of scans sent."""
        forward = self.head(2, 'cs', attach=False, more='realtime=1')
        stream = self.started('stream', 'circle', '--repeat', '0', '-r', '20000', '-j')
        assert wait(lambda: forward.number('scans') > 30000, LIMIT)
        status, output, errors = stream.interrupt()
        assert (status, errors) == (INTERRUPTED, '')
        document, = xy3ctl.documents(output)
        assert (forward.get('buffer/enable'), forward.get('sampling_frequency'),
                          document['rate']) == ('0', '20000', 20000)
        assert forward.number('scans') - forward.number('repeated') == document['scans']
        assert document['achieved'] > 0
        self.assert_status(FAILURE, 'stream', 'circle', '-r', '99999999', says='out of range')

    def test_interrupted_with_a_full_buffer(self):
        """4 s of scans are queued in the driver: they are dropped, and the gate is low at once."""
        forward = self.head(4, 'line', attach=False, more='realtime=1')
        forward.set_sim('signals', 'sync x y gate')
        write_file(forward.spi + 'line_map', 'sync x y gate')
        forward.find()
        stream = self.started('stream', 'circle', '--repeat=0', '-r', '1000', '--gate', '-j')
        assert wait(lambda: forward.number('scans') > 300, LIMIT)
        before = forward.number('scans')
        status, output, errors = stream.interrupt()
        assert (status, errors) == (INTERRUPTED, '')
        document, = xy3ctl.documents(output)
        assert forward.number('scans') - forward.number('repeated') == document['scans']
        assert forward.number('scans') - before < 2000
        assert forward.get('buffer/enable') == '0'
        assert forward.sim_number('gate', 'high') == 0

    def test_unbound_in_the_middle(self):
        forward = self.head(2, 'cs', attach=False, more='realtime=1')
        stream = self.started('stream', 'circle', '--repeat', '0')
        assert wait(lambda: forward.number('scans') > 5000, LIMIT)
        forward.unbind()
        status, _, errors = stream.end()
        assert status in (FAILURE, NO_DEVICE), errors
        forward.bind()
        assert wait(lambda: xy3ctl.run('goto', '5')[0] == OK, LIMIT)

    def test_controller_error(self):
        forward = self.head(2, 'cs', attach=False)
        forward.set_sim('faults/spi_error_in', '3')
        status, _, errors = xy3ctl.run('stream', 'grid')
        assert status == FAILURE
        assert 'Input/output error' in errors
        assert forward.get('buffer/enable') == '0'


class TestSpidev(Case):
    def spidev(self, lines, framing):
        forward_rig.load_sim(lines, framing, more='modalias=spidev')
        self.add_cleanup(forward_rig.unload_sim)
        node = '/dev/' + re.search(r'spidev (\S+)',
                                   read_file(forward_rig.DEBUGFS + '0/devices')).group(1)
        assert wait(lambda: os.path.exists(node))
        return node

    def sim(self, name):
        return read_file(forward_rig.DEBUGFS + '0/' + name)

    def positions(self):
        return [int(line.split()[1]) for line in self.sim('positions').splitlines()]

    def test_all_verbs(self):
        node = self.spidev(4, 'line')
        where = ('--spidev', node, '--lines', '4', '--map', 'sync x y z')
        document = xy3ctl.json('goto', 'x=7', 'z=9', *where)
        assert document == {**document, 'head': node, 'codes': {'x': 7, 'z': 9}}
        assert self.positions() == [7, 0x80000, 9]
        assert '\nscans 1\n' in '\n' + self.sim('stats')
        assert xy3ctl.run('command', 'calibrate', 'xy', *where)[0] == OK
        assert self.sim('commands').strip().endswith('c0003 calibrate xy')
        write_file(forward_rig.DEBUGFS + '0/record', '10000')
        document = xy3ctl.json('stream', 'square', '--points', '1000', *where)
        assert (document['scans'], document['underruns']) == (1001, None)
        assert len(self.sim('record').splitlines()) == 1001
        assert not re.search(r' [1-9]', self.sim('parity_errors') + self.sim('length_errors'))

    def test_refused(self):
        node = self.spidev(1, 'cs')
        self.assert_status(USAGE, 'goto', '1', '--spidev', node, '--lines', '3', says='line map')
        self.assert_status(USAGE, 'goto', '1', '--spidev', node, '--map', 'y z')
        self.assert_status(FAILURE, 'goto', '1', '--spidev', node, '--lines', '4', says='lines')
        self.assert_status(FAILURE, 'goto', 'x=1048576', '--spidev', node)
        self.assert_status(FAILURE, 'stream', 'circle', '-r', '90000000', '--spidev', node)


class TestAttaching(Case):
    def test_attach_and_detach(self):
        self.forward(2, 'cs')
        attach = self.started('attach', '/dev/ttyXY3SIM0')
        assert attach.line() == 'xy3-0'
        assert wait(lambda: xy3ctl.json('show')['in_sync'], LIMIT)
        self.assert_status(FAILURE, 'attach', '/dev/xy3-0')      # a head is not a UART
        assert xy3ctl.run('detach', 'xy3-0') == (OK, '', '')
        assert attach.end()[0] == OK
        assert xy3ctl.json('show')['rate'] is None
        self.assert_status(FAILURE, 'detach', '/dev/ttyXY3SIM0', says='no head')

    def test_ends(self):
        self.forward(2, 'cs')
        attach = self.started('attach', '-j', '-r', '57600', '/dev/ttyXY3SIM0')
        document, = xy3ctl.documents(attach.line())
        assert (document['head'], document['uart']) == ('xy3-0', '/dev/ttyXY3SIM0')
        assert xy3ctl.json('show')['rate'] == 57600
        assert attach.interrupt()[0] == INTERRUPTED
        assert wait(lambda: xy3ctl.json('show')['rate'] is None)

    def test_daemon(self):
        self.forward(2, 'cs')
        assert xy3ctl.run('attach', '--daemon', '/dev/ttyXY3SIM0')[:2] == (OK, 'xy3-0\n')
        assert wait(lambda: xy3ctl.json('show')['in_sync'], LIMIT)
        self.assert_status(FAILURE, 'attach', '/dev/ttyXY3SIM0', says='already')
        assert len(self.holders('/dev/ttyXY3SIM0')) == 1
        # after it the UART is free, for another program or for modprobe -r
        assert xy3ctl.run('detach', '/dev/ttyXY3SIM0')[0] == OK
        assert self.holders('/dev/ttyXY3SIM0') == []

    def test_uart_goes(self):
        uart = head_rig.Pty()
        self.add_cleanup(uart.close)
        attach = self.started('attach', uart.node)
        assert attach.line() == 'xy3-0'
        uart.cut()
        assert attach.end()[0] == NO_DEVICE
        assert wait(lambda: not head_rig.heads())

    @staticmethod
    def holders(node):
        found = []
        for pid in filter(str.isdigit, os.listdir('/proc')):
            try:
                files = os.listdir('/proc/%s/fd' % pid)
                found += [pid for name in files
                          if os.path.realpath('/proc/%s/fd/%s' % (pid, name)) == node]
            except OSError:
                continue                # the program has exited
        return found
