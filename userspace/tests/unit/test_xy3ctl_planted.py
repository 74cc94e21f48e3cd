# SPDX-License-Identifier: GPL-2.0-only
"""xy3ctl with a scanhead of a made-up /sys: what it takes for a number, and files of scans."""

import re

import case
from planted_head import MIDDLE, TOP, PlantedHead
from tool import FAILURE, OK, USAGE


class Case(case.Case):
    gate = False

    def set_up(self):
        self.head = PlantedHead(gate=self.gate)
        self.add_cleanup(self.head.close)
        self.head.plant()

    def run(self, *words, text=''):
        """-> status, output, errors; and what was streamed begins anew"""
        self.head.forget()
        return self.head.xy3ctl.run(*words, text=text)

    def refused(self, status, *words, says='', text=''):
        """It ends with this status and such a message, and has sent nothing."""
        found, output, errors = self.run(*words, text=text)
        assert (found, output) == (status, ''), errors
        assert re.search(says, errors), errors
        assert self.head.scans() == []
        assert self.head.read('buffer/enable') == '0\n'


class TestNumbers(Case):
    """One idea of a number: decimal digits with a point, and nothing else before or behind."""

    NONE = ('', ' ', 'x', '5x', ' 5', '5 ', '0,5', '1,5', '1.5.', '.', '-', '+', '--1', 'nan', 'inf',
            '-inf', '0x', '1e', '0x1p3', '5\n')
    NOT_WHOLE = (*NONE, '0.5', '1.9', '1e3', '-1', '+1', '0x10', '99999999999999999999')

    def test_options(self):
        for words, wrong in ((('stream', 'circle', '--repeat=%s'), self.NOT_WHOLE),
                             (('stream', 'circle', '--points=%s'), (*self.NOT_WHOLE, '0')),
                             (('stream', 'circle', '--rate=%s'), (*self.NOT_WHOLE, '0')),
                             (('stream', 'circle', '--bits=%s'), (*self.NOT_WHOLE, '25')),
                             (('stream', 'circle', '--spidev=a', '--lines=%s'),
                              (*self.NOT_WHOLE, '0', '3')),
                             (('stream', 'circle', '--size=%s'), (*self.NONE, '1.1', '-0.1', '1e999')),
                             (('stream', 'circle', '--gate-on-delay=%s'), (*self.NONE, '1e7')),
                             (('stream', 'circle', '--gate-off-delay=%s'), (*self.NONE, '-1e7')),
                             (('watch', '--count=%s'), (*self.NOT_WHOLE, '0')),
                             (('watch', '--timeout=%s'), (*self.NONE, '0', '-1', '1e10')),
                             (('watch', '--interval=%s'), (*self.NONE, '0', '-1', '1e10')),
                             (('packets', '--count=%s'), (*self.NOT_WHOLE, '0')),
                             (('packets', '--timeout=%s'), (*self.NONE, '0', '-1')),
                             (('attach', 'tty', '--rate=%s'), (*self.NOT_WHOLE, '9600', '115200x')),
                             (('command', 'rate', '%s'), (*self.NONE[1:], '9600', '115200x'))):
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
        for text, raw in (('0x10', '16'), ('0XFFFFF', '1048575'), ('077', '77'), ('0', '0')):
            self.head.write(self.head.iio + '/out_angl0_raw', '')
            assert self.run('goto', 'x=' + text) == (OK, '', '')
            assert self.head.read('out_angl0_raw') == raw
        for text, raw in (('-1', '0'), ('+1', str(TOP)), ('-0', str(MIDDLE)), ('1e0', str(TOP))):
            self.head.write(self.head.iio + '/out_angl0_raw', '')
            assert self.run('goto', '-u', 'x=' + text) == (OK, '', '')
            assert self.head.read('out_angl0_raw') == raw

    def test_a_long_interval(self):
        """poll() waits for an int of milliseconds: the time-out comes first all the same."""
        for interval in ('3000000', '1e9', '1000000000'):
            status, output, errors = self.run('watch', '--interval', interval, '--timeout', '0.2')
            assert (status, errors) == (OK, '')
            assert 'in_sync 1\n' in output
