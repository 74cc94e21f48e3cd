# SPDX-License-Identifier: GPL-2.0-only
"""xy3ctl with a scanhead in an artificial /sys: the format of numbers, and files of scans."""

import os
import re
import shutil
import signal

import case
from planted_head import MIDDLE, TOP, PlantedHead
from tool import FAILURE, INTERRUPTED, OK, USAGE


class Case(case.Case):
    gate = False

    def set_up(self):
        self.head = PlantedHead(gate=self.gate)
        self.add_cleanup(self.head.close)
        self.head.plant()

    def run(self, *words, text=''):
        """-> status, output, errors; resets the record of streamed data"""
        self.head.forget()
        return self.head.xy3ctl.run(*words, text=text)

    def refused(self, status, *words, says='', text=''):
        """It exits with this status and such a message, and has sent nothing."""
        found, output, errors = self.run(*words, text=text)
        assert (found, output) == (status, ''), errors
        assert re.search(says, errors), errors
        assert self.head.scans() == []
        assert self.head.read('buffer/enable') == '0\n'


class TestNumbers(Case):
    """One format of numbers: decimal digits with a point, and nothing before or after it."""

    NONE = ('', ' ', 'x', '5x', ' 5', '5 ', '0,5', '1,5', '1.5.', '.', '-', '+', '--1', 'nan',
            'inf', '-inf', '0x', '1e', '0x1p3', '5\n')
    NOT_WHOLE = (*NONE, '0.5', '1.9', '1e3', '-1', '+1', '0x10', '99999999999999999999')

    FEW = ('', ' 5', '5x', '0,5', '0x1p3')      # for options by the same parser

    def test_options(self):
        for words, wrong in ((('stream', 'circle', '--repeat=%s'), self.NOT_WHOLE),
                             (('stream', 'circle', '--points=%s'), (*self.FEW, '4.7', '0')),
                             (('stream', 'circle', '--rate=%s'), (*self.FEW, '1e3', '0')),
                             (('stream', 'circle', '--bits=%s'), (*self.FEW, '25')),
                             (('stream', 'circle', '--spidev=a', '--lines=%s'),
                              (*self.FEW, '0', '3', '9')),
                             (('stream', 'circle', '--size=%s'),
                              (*self.NONE, '1.1', '-0.1', '1e999')),
                             (('stream', 'circle', '--gate-on-delay=%s'), (*self.FEW, '1e7')),
                             (('stream', 'circle', '--gate-off-delay=%s'), (*self.FEW, '-1e7')),
                             (('watch', '--count=%s'), (*self.FEW, '0.5', '0')),
                             (('watch', '--timeout=%s'), (*self.FEW, '0', '-1', '1e10')),
                             (('watch', '--interval=%s'), (*self.FEW, '0', '-1', '1e10')),
                             (('packets', '--count=%s'), (*self.FEW, '0.5', '0')),
                             (('packets', '--timeout=%s'), (*self.FEW, '0', '-1')),
                             (('attach', 'tty', '--rate=%s'), (*self.FEW, '9600', '115200x')),
                             (('command', 'rate', '%s'), (*self.FEW, '9600', '115200x'))):
            for text in wrong:
                with case.row(*words, text=text):
                    self.refused(USAGE, *[word.replace('%s', text) for word in words],
                                 says='^xy3ctl')

    def test_message_names_option_and_range(self):
        self.refused(USAGE, 'stream', 'circle', '--repeat', '0.5',
                     says="--repeat: '0.5' is not a whole number from 0 to 1000000000\n")
        self.refused(USAGE, 'stream', 'circle', '--size', '0,5',
                     says="--size: '0,5' is not a number from 0 to 1\n")

    def test_positions(self):
        for text in (*self.NONE, '0.5', '1e3'):
            with case.row(text=text):
                self.refused(USAGE, 'goto', 'x=' + text, says='not a whole number')
        for text in self.NONE:
            with case.row(text=text):
                self.refused(USAGE, 'goto', '-u', 'x=' + text, says='not a number')
        for text in ('-1', '1048576', '0x100000', '99999999999999999999'):
            with case.row(text=text):
                self.refused(FAILURE, 'goto', 'x=' + text, says='from 0 to 1048575')
        for text in ('1.1', '-2', '1e300', '1e999'):
            with case.row(text=text):
                self.refused(FAILURE, 'goto', '-u', 'x=' + text, says='from -1 to 1')

    def test_good_ones(self):
        for words, count in ((('--repeat', '2', '--points', '4'), 9),
                             (('--repeat=1', '--points=007'), 8),
                             (('--size', '.5', '--points', '4'), 5),
                             (('--size', '5e-1', '--points', '4'), 5),
                             (('--size', '1.', '--points', '4'), 5)):
            status, _, errors = self.run('stream', 'circle', *words)
            assert (status, errors) == (OK, '')
            assert len(self.head.scans()) == count
        for text, raw in (('0x10', '16'), ('0XFFFFF', '1048575'), ('077', '77'), ('0', '0'),
                          ('+5', '5')):
            self.goes('x=' + text, raw=raw)
        for text, raw in (('-1', '0'), ('+1', str(TOP)), ('-0', str(MIDDLE)), ('1e0', str(TOP))):
            self.goes('-u', 'x=' + text, raw=raw)

    def goes(self, *words, raw):
        """X moves to a code, with one scan; it is there already, as nothing moves here."""
        self.head.write(self.head.iio + '/out_angl0_raw', raw)
        assert self.run('goto', *words) == (OK, '', '')
        assert self.head.scans() == [(int(raw), MIDDLE, MIDDLE)]

    def test_goto_that_is_not_sent(self):
        """The controller reports an error after the write: the position is not reached."""
        status, _, errors = self.run('goto', 'x=5')
        assert status == FAILURE
        assert 'has not sent the position' in errors
        assert self.head.read('buffer/enable') == '0\n'

    def test_a_long_interval(self):
        """poll() waits for an int of milliseconds: the timeout still expires first."""
        for interval in ('3000000', '1e9', '1000000000'):
            status, output, errors = self.run('watch', '--interval', interval, '--timeout', '0.2')
            assert (status, errors) == (OK, '')
            assert 'in_sync 1\n' in output


class TestMessages(Case):
    """They contain the argument given, and what is missing."""

    def test_usage(self):
        for words, says in (((), 'missing verb'), (('fly',), "unknown verb 'fly'"),
                            (('command',), 'missing command'),
                            (('command', 'dance'), "unknown command 'dance'"),
                            (('command', 'autocalib'), 'autocalib: missing on or off'),
                            (('command', 'rate'), 'rate: missing rate'),
                            (('command', 'autocalib', 'perhaps'),
                             "autocalib: 'perhaps' is not on or off, then a list of axes"),
                            (('command', 'calibrate', 'q'), "calibrate: 'q' is not a list of axes"),
                            (('command', 'rate', '115200', 'x'), "no rate '115200 x'"),
                            (('command', 'rate', '1', '2', '3'), 'too many arguments'),
                            (('goto',), 'missing position'), (('stream',), 'missing FILE'),
                            (('attach',), 'missing UART'), (('packets', 'a', 'b'), 'only one'),
                            (('goto', 'x=1', 'x=2'), 'axis x is given twice'),
                            (('stream', 'a', '--lines', '4'), 'require --spidev')):
            with case.row(*words):
                self.refused(USAGE, *words, says=says)


class TestJson(Case):
    def test_seconds(self):
        """In milliseconds, without the digits of binary rounding"""
        for words, name in ((('stream', 'circle', '--points=9'), 'seconds'),
                            (('watch', '--count=1'), 'time')):
            status, output, errors = self.run(*words, '--json')
            assert (status, errors) == (OK, '')
            self.head.xy3ctl.documents(output)
            assert re.search(r'"%s":\d+\.\d{3}[,}]' % name, output), output


class TestFiles(Case):
    """A file of numbers: ambiguous values are refused, and nothing is sent then."""

    HALF, QUARTER = round(0.75 * TOP), round(0.625 * TOP)

    def sent(self, text, *options):
        """-> the scans sent for a file"""
        status, _, errors = self.run('stream', '-', *options, text=text)
        assert (status, errors) == (OK, '')
        return self.head.scans()

    def test_separators(self):
        want = [(0, TOP, MIDDLE), (self.HALF, self.QUARTER, MIDDLE)]
        for text in ('-1 1 0\n0.5 0.25 0\n', '-1,1,0\n0.5,0.25,0\n', '-1;1;0\n0.5;0.25;0\n',
                     '-1, 1, 0\r\n.5 ,2.5e-1\t,\t0\r\n', '\t-1  1\t0 \n\n  # 1 2 3\n0.5 0.25 0',
                     '\ufeff-1 ; 1 ; 0\n+0.5;0.25;-0\n', '# X;Y,Z\n-1 1 0\n0.5,0.25,0\n'):
            with case.row(text=text):
                assert self.sent(text) == want
        assert self.sent('0.5\n-1\n') == [(self.HALF, MIDDLE, MIDDLE), (0, MIDDLE, MIDDLE)]
        assert self.sent('0,1048575\n7,9', '--codes') == [(0, TOP, MIDDLE), (7, 9, MIDDLE)]

    def test_unsure(self):
        for text, says in (
                ('0,1;0\n', 'line 1: commas and semicolons: a number has a decimal point'),
                ('0,5 0,5\n', "line 1: '5 0' is not a number"),
                ('0.5,,0.5\n', 'line 1: number 2 is empty'),
                (';0.5\n', 'line 1: number 1 is empty'),
                ('0.5,0.5,\n', 'line 1: number 3 is empty'),
                ('0,1\n1\n', 'line 2: 1 numbers, where the lines before have 2'),
                ('0 0\n0 0 0\n', 'line 2: 3 numbers, where the lines before have 2'),
                ('0 0 0 0\n', 'line 1: 4 numbers, and the head has 3 axes'),
                ('x,y\n0,0\n', "line 1: 'x' is not a number; a line of names begins with #"),
                ('0 0\n0 left\n', "line 2: 'left' is not a number"),
                ('"0","0"\n', 'line 1: .* is not a number'),
                ('0x1 0\n', "line 1: '0x1' is not a number"),
                ('nan 0\n', "line 1: 'nan' is not a number"),
                ('0 0\0 1\n', 'line 1: a byte of 0'),
                ('0 1.0000001\n', "line 1: '1.0000001' is not from -1 to 1"),
                ('', 'no scan'), ('# nothing\n\n', 'no scan')):
            with case.row(text=text):
                self.refused_file(text, says=says)
        for text, says in (('5 1048576\n', "line 1: '1048576' is not a code from 0 to 1048575"),
                           ('5 0.5\n', "line 1: '0.5' is not a whole number"),
                           ('5 -1\n', "line 1: '-1' is not a code from 0 to 1048575")):
            with case.row(text=text):
                self.refused_file(text, '--codes', says=says)

    def refused_file(self, text, *options, says):
        """A file and a pipe are both refused this early; a file before the stream starts."""
        data = text.encode()
        self.head.write(self.head.iio + '/buffer/enable', '0')
        with open(self.head.folder + '/scans', 'wb') as file:
            file.write(data)
        self.refused(FAILURE, 'stream', self.head.folder + '/scans', *options, says=says)
        with open(self.head.folder + '/scans', 'rb') as file:
            self.refused(FAILURE, 'stream', '-', *options, text=file, says=says)
        status, _, errors = self.run('stream', '-', *options, text=data)
        assert status == FAILURE and re.search(says, errors), errors

    def test_late_errors(self):
        """Of a file nothing is sent; of a pipe all scans before the invalid line."""
        good = ['%d 7' % i for i in range(1500)]
        for options, data, says in (
                (('--codes',), '\n'.join(good + ['oops']).encode(), "line 1501: 'oops' is not"),
                (('--raw',), b'\0\0\0\0' * 4500 + b'\0\0\0\x10' * 3,
                 'scan 1501: .* is the highest'),
                (('--raw',), b'\0\0\0\0' * 4502, 'ends in the middle of scan 1501')):
            with case.row(*options, says=says):
                with open(self.head.folder + '/scans', 'wb') as file:
                    file.write(data)
                self.refused(FAILURE, 'stream', *options, self.head.folder + '/scans', says=says)
                status, output, errors = self.run('stream', *options, '-', text=data)
                assert status == FAILURE and re.search(says, errors), errors
                assert output.startswith('1500 scans ')
                assert len(self.head.scans()) == 1500
        status, _, errors = self.run('stream', '--codes', '-', text='\n'.join(good))
        assert (status, errors) == (OK, '')
        assert self.head.scans() == [(i, 7, MIDDLE) for i in range(1500)]

    def test_the_rest_of_a_file(self):
        """If standard input is a file it is read from its current offset."""
        with open(self.head.folder + '/scans', 'w', encoding='ascii') as file:
            file.write('wrong\n1 2\n3 4\n')
        with open(self.head.folder + '/scans', 'rb', buffering=0) as file:
            file.seek(6)
            status, _, errors = self.run('stream', '--codes', '-', text=file)
        assert (status, errors) == (OK, '')
        assert self.head.scans() == [(1, 2, MIDDLE), (3, 4, MIDDLE)]


class TestGate(Case):
    gate = True

    def test_column(self):
        status, _, errors = self.run('stream', '--codes', '-', text='1 2 3 0\n4 5 6 1\n')
        assert (status, errors) == (OK, '')
        assert self.head.scans() == [(1, 2, 3, 0), (4, 5, 6, 1)]
        for number in ('2', '-1', '0.5', 'on'):
            self.run('stream', '--codes', '-', text='1 2 3 %s\n' % number)
            assert self.head.scans() == []


class TestSettings(Case):
    def test_refused_before_they_are_set(self):
        path = os.path.join(self.head.folder, 'scans')
        self.head.write(path, '0 0\n2 0')
        for words, says in ((('goto', 'x=67108864'), 'from 0 to 67108863'),
                            (('goto', 'u=1'), 'no axis u'), (('stream', path), 'line 2')):
            with case.row(*words):
                status, _, errors = self.run(*words, '--bits', '32', '--rate', '1000')
                assert status in (FAILURE, USAGE)
                assert says in errors
                assert self.head.read('frame_bits') == '24\n'
                assert self.head.read('sampling_frequency') == '100000\n'


class TestShow(Case):
    def shown(self):
        _, output, _ = self.run('show', '--json')
        document, = self.head.xy3ctl.documents(output)
        return set(document['stream'])

    def test_counters_for_root_only(self):
        names = {'frame_bits', 'sampling_frequency', 'achieved_frequency', 'underruns'}
        assert self.shown() == names | {'scans', 'repeated', 'commands'}
        shutil.rmtree(self.head.counters)
        assert self.shown() == names


class TestInterrupted(Case):
    """An interrupted stream is aborted: scans queued in the driver are dropped."""

    def interrupt(self, number):
        """-> its result, after its first scans were read from a device that accepts no more; and
        the bytes of all scans written
        """
        os.unlink(self.head.node)
        os.mkfifo(self.head.node)
        stream = self.head.xy3ctl.start('stream', 'circle', '--repeat', '0', '--json')
        self.add_cleanup(stream.close)
        with open(self.head.node, 'rb') as node:
            assert len(node.read(1200)) == 1200
            stream.process.send_signal(number)
            return (*stream.end(), 1200 + len(node.read()))

    def test_aborted(self):
        for number, status in ((signal.SIGINT, INTERRUPTED), (signal.SIGTERM, OK),
                               (signal.SIGHUP, OK)):
            with case.row(number):
                self.head.write(self.head.iio + '/abort', '')
                self.head.write(self.head.iio + '/buffer/enable', '0')
                found, output, errors, _ = self.interrupt(number)
                assert (found, errors) == (status, '')
                assert self.head.read('abort') == '1'
                assert self.head.read('buffer/enable') == '0\n'
                document, = self.head.xy3ctl.documents(output)
                # none, as the driver's counter of scans has not changed
                assert document['scans'] == 0

    def test_without_counters(self):
        """Only root can read the counter: scans sent are those written that are not queued."""
        shutil.rmtree(self.head.counters)
        self.head.write(self.head.iio + '/buffer/data_available', '60')
        found, output, errors, size = self.interrupt(signal.SIGINT)
        assert (found, errors) == (INTERRUPTED, '')
        document, = self.head.xy3ctl.documents(output)
        assert document['scans'] == size // 12 - 60

    def test_not_aborted(self):
        """A stream that reaches its end, or an error, sends the accepted scans."""
        self.run('stream', 'circle')
        assert self.head.read('abort') == '\n'
        self.run('stream', '-', text='0 0\nx\n')
        assert self.head.read('abort') == '\n'
        assert len(self.head.scans()) == 1


class TestPath(Case):
    """Vertices with jumps, at 100 000 scans/s; the unit is half of the field"""

    gate = True
    SPEEDS = ('--jump-speed=50000', '--mark-speed=25000')
    VERTICES = '-1 -1 -1 0\n0 -1 -1 0\n0 0 -1 1\n1 0 -1 0\n'

    def drawn(self, *options, text=VERTICES):
        """-> X, Y and gate of each scan, in units"""
        status, _, errors = self.run('stream', '-', *options, text=text)
        assert (status, errors) == (OK, '')
        scans = self.head.scans()
        assert {scan[2] for scan in scans} == {0}
        return [(round(x / TOP * 2 - 1, 4), round(y / TOP * 2 - 1, 4), gate)
                for x, y, _, gate in scans]

    def test_speeds(self):
        assert self.drawn(*self.SPEEDS) == \
            [(-1, -1, 0), (-.5, -1, 0), (0, -1, 0), (0, -.75, 1), (0, -.5, 1), (0, -.25, 1),
             (0, 0, 1), (.5, 0, 0), (1, 0, 0)]

    def test_delays(self):
        jumped = [(-1, -1, 0)] * 3 + [(-.5, -1, 0)] + [(0, -1, 0)] * 3
        marked = [(0, -.75, 1), (0, -.5, 1), (0, -.25, 1), (0, 0, 1)]
        end = [(.5, 0, 0)] + [(1, 0, 0)] * 3
        options = (*self.SPEEDS, '--jump-delay=20', '--mark-delay=30')
        assert self.drawn(*options) == jumped + marked + [(0, 0, 0)] * 3 + end
        # the fall of the gate, as required for a laser with a delay
        assert self.drawn(*options, '--gate-off-delay=20') == \
            jumped + marked + [(0, 0, 1)] * 2 + [(0, 0, 0)] + end + [(1, 0, 0)] * 2

    def test_codes(self):
        text = '0 0 0 0\n4 0 0 1\n'
        speed = '--mark-speed=%.9f' % (2 / TOP * 2 * 1e5)
        assert self.drawn('--codes', '--jump-speed=1', speed, text=text)
        assert self.head.scans() == [(0, 0, 0, 0), (2, 0, 0, 1), (4, 0, 0, 1)]

    def test_a_file_longer_than_a_piece(self):
        text = '-1 -1 -1 0\n' + '1 1 -1 1\n-1 -1 -1 1\n' * 700
        scans = self.drawn('--jump-speed=50000', '--mark-speed=100000', text=text)
        assert len(scans) == 1 + 1400 * 3
        assert [scan for scan in scans[1:] if not scan[2]] == []

    def test_late_error(self):
        """From a pipe, vertices before the invalid one are drawn."""
        status, _, errors = self.run('stream', '-', *self.SPEEDS, text=self.VERTICES + 'x\n')
        assert status == FAILURE
        assert errors.count('line 5') == 1
        assert len(self.head.scans()) == 9

    def test_refused(self):
        for words, says in ((('-', '--jump-speed=1'), 'require each other'),
                            (('-', '--mark-speed=1'), 'require each other'),
                            (('-', '--jump-delay=1'), 'require speeds'),
                            (('-', '--mark-delay=1'), 'require speeds'),
                            (('circle', *self.SPEEDS), 'require a FILE'),
                            (('-', '--jump-speed=0', '--mark-speed=1'), 'from 0.001 to 1000000')):
            with case.row(*words):
                self.refused(USAGE, 'stream', *words, says=says, text=self.VERTICES)


class TestPathWithoutGate(Case):
    def test_refused(self):
        self.refused(USAGE, 'stream', '-', *TestPath.SPEEDS, text='0 0\n', says='no gate')


class TestHelp(Case):
    def test_examples_of_motions_work(self):
        """Exactly as in --help of the tool and of the verb"""
        found = set()
        for words in (('--help',), ('goto', '--help'), ('stream', '--help')):
            text = self.run(*words)[1]
            found |= set(re.findall(r'^  xy3ctl (goto .*|stream circle.*)$', text, re.M))
        assert len(found) >= 4, found
        for line in found:
            with case.row(line):
                status, _, errors = self.run(*line.split())
                if line.startswith('goto'):     # nothing moves here, except on request
                    for axis, code in enumerate(self.head.scans()[0]):
                        self.head.write('%s/out_angl%d_raw' % (self.head.iio, axis), str(code))
                    status, _, errors = self.run(*line.split())
                assert (status, errors) == (OK, '')
