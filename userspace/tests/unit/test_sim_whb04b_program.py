# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xhc-sim, the program, with a WHB04B: scripts, screen, command line."""

import io
import json
import time

import pytest

from busless_pendant import WHB04B, Bench, whb04b_frame
from case import Case
from xhc_sim.uhid import UhidPendant  # noqa: E402
from xhc_sim.usb import UsbPendant  # noqa: E402
from xhc_sim import cli, terminal
from xhc_sim.script import Failure, Runner, ScriptError


class TestScripts(Case):
    def set_up(self):
        self.bench = Bench('WHB04B')
        self.bench.plug()
        self.add_cleanup(self.bench.unplug)
        self.said = []
        self.runner = Runner(self.bench, lambda: self.said.append(self.bench.screen()),
                             self.said.append, timeout=0.05)

    def run_text(self, text):
        self.runner.run(self.runner.parse(text))

    def fields(self):
        """Fields of all reports: keys, second rotary, axis, wheel."""
        return [report[2:7].hex() for report in self.bench.reports]

    def test_hands(self):
        self.run_text('select c\nfeed 0x1b\nfeed 5%\nkey M-Home down\nwheel -2\nkey 8 up\nwheel 1')
        assert self.fields() == ['00000d1600', '00001b1600', '00000e1600', '08000e1600',
                                 '08000e16fe', '00000e1600', '00000e1601']

    def test_fn(self):
        self.run_text('key Fn+Spindle+ down\nkey Fn+Spindle+ up')
        assert [report[2:4].hex() for report in self.bench.reports] == ['0c00', '0c06', '0c00',
                                                                        '0000']
        self.bench.reports.clear()
        self.run_text('key fn+STOP press')
        assert [report[2:4].hex() for report in self.bench.reports] == ['0c00', '0c02', '0c00',
                                                                        '0000']

    def test_lead(self):
        self.run_text('feed lead\nlead 0x9b\nfeed lead\nexpect feed lead\nlead 0x1c\nfeed lead')
        assert [report[4] for report in self.bench.reports] == [0x1C, 0x9B, 0x1C]

    def test_sleep(self):
        self.run_text('sleep\nexpect awake no\nwake\nexpect awake yes')
        assert self.fields() == ['0000000000', '0000000000', '00000d0600']

    def test_out_of_range(self):
        """The receiver accepts frames, and sends nothing, not even the sleep report."""
        self.run_text('select x\nradio off')
        self.bench.reports.clear()
        self.bench.send(whb04b_frame(((7, 0), (0, 0), (0, 0)), flags=1))
        self.run_text('key Stop down\nwheel 3\nsleep\nwake\nexpect frames 1')
        assert self.bench.reports == []
        assert self.bench.seen is None
        self.run_text('radio on\nwheel 1')
        assert self.fields() == ['00000d1101']
        assert self.bench.seen is None          # lost frames are not sent again
        self.bench.send(whb04b_frame(((8, 0), (0, 0), (0, 0)), flags=1))
        self.run_text('expect row1 8')

    @pytest.mark.parametrize('bus', [UhidPendant, UsbPendant])
    def test_radio_of_a_bus(self, bus, monkeypatch):
        device, reports = bus('WHB04B'), []
        monkeypatch.setattr(device, 'report', reports.append)
        device.press(2)
        device.radio = False
        device.release(2)
        device.sleep()
        device.radio = True
        device.wake()
        assert [report[2] for report in reports] == [2, 0]

    def test_expect(self):
        self.run_text('select x')
        self.bench.send(whb04b_frame([(1, 5000), (6, 7890 | 0x8000), (0, 0)], (110, 80),
                                     flags=0x81))
        self.run_text('expect row1 1.5\nexpect rows 1.50 -6.789 0\nexpect mode step\n'
                      'expect coordinates work\nexpect reset 0\nexpect flags 129\n'
                      'expect feedrate_override 110\nexpect spindle_override 80\n'
                      'expect seed 254\nexpect faults none\nexpect frames 1\n'
                      'expect feed 2%\nexpect selector x\nexpect model whb04b\n')
        for wrong in ('row1 1.6', 'rows 1.5 -6.789 1', 'mode mpg', 'reset 1', 'feed 5%'):
            with pytest.raises(Failure):
                self.run_text('expect ' + wrong)

    def test_expect_is_of_what_is_seen(self):
        self.bench.send(whb04b_frame([(1, 0)] * 3))
        self.run_text('expect frames 1')
        with pytest.raises(Failure):
            self.run_text('expect row1 1')
        self.run_text('select x\nexpect row1 1\nselect off')
        self.bench.send(whb04b_frame([(2, 0)] * 3))
        self.run_text('expect frames 2\nexpect row1 1')
        with pytest.raises(Failure):
            self.run_text('expect row1 2')

    @pytest.mark.parametrize('line', [
        'expect work_x 1', 'expect position 1 2 3 4 5 6', 'expect step 1', 'expect rows 1 2',
        'select feed', 'feed', 'feed 7%', 'radio', 'radio maybe', 'lead 0x1b', 'lead',
        'key Fn+ down', 'key Fn+0 down'])
    def test_wrong_lines(self, line):
        with pytest.raises(ScriptError):
            self.run_text(line)

    @pytest.mark.parametrize('line', ['feed 2%', 'feed 0x0d', 'lead 0x1c', 'expect row1 1',
                                      'expect feed 2%', 'select b', 'key Fn+Stop down'])
    def test_wrong_lines_of_other_models(self, line):
        with pytest.raises(ScriptError):
            Runner(Bench('HB04'), None, None).parse(line)


class TestProgram(Case):
    def set_up(self):
        self.bench = Bench('WHB04B')
        self.bench.plug()
        self.add_cleanup(self.bench.unplug)
        self.terminal = terminal.Terminal(self.bench)

    def test_every_key_has_a_letter(self):
        caps = self.terminal.caps
        assert sorted(caps.values()) == sorted(WHB04B.keys)
        assert not set(caps) & {key for key in terminal.KEYS if len(key) == 1}

    def test_fits_80x24(self):
        self.bench.press(0x0E)
        self.terminal.message = 'x' * 200
        picture = self.terminal.picture()
        assert len(picture) <= 24
        assert max(map(len, picture)) <= 80
        text = '\n'.join(picture)
        for name in (*WHB04B.keys.values(), '[off]', '[2%]', 'lead', '[Continuous/MPG]',
                     *terminal.HELP):
            assert name in text

    def test_second_rotary(self):
        for key in '-+=+---':
            self.terminal.key(key)
        assert [report[4] for report in self.bench.reports] == [0x0D, 0x0E, 0x0F, 0x10, 0x0F, 0x0E,
                                                               0x0D]
        for _ in range(9):
            self.terminal.key('+')
        assert self.bench.reports[-1][4] == 0x1C
        assert '[lead]' in '\n'.join(self.terminal.picture())

    def test_radio(self):
        self.terminal.key('~')
        self.terminal.key('+')
        assert 'out of range' in '\n'.join(self.terminal.picture())
        assert self.bench.reports == []
        self.terminal.key('~')
        self.terminal.key('+')
        assert [report[4] for report in self.bench.reports] == [0x0F]
        assert 'out of range' not in '\n'.join(self.terminal.picture())

    def test_second_rotary_of_other_models(self):
        bench = Bench('HB04')
        bench.plug()
        screen = terminal.Terminal(bench)
        assert screen.key('+')
        assert bench.reports == []
        assert not any(line.startswith('-/+') for line in screen.picture())

    def test_selector(self):
        for _ in range(8):
            self.terminal.key('\x1b[A')
        assert [report[5] for report in self.bench.reports] == \
            [0x11, 0x12, 0x13, 0x14, 0x15, 0x16, 0x16, 0x16]
        self.terminal.key('\x1b[B')
        assert self.bench.reports[-1][5] == 0x15

    def test_fn_held_with_a_key(self):
        letter = {code: letter for letter, code in self.terminal.caps.items()}
        self.terminal.key(letter[0x0C].upper())
        self.terminal.key(letter[2])
        assert self.bench.pendant.slots == [0x0C, 2]
        time.sleep(terminal.CLICK)
        self.terminal.passing()
        assert self.bench.pendant.slots == [0x0C, 0]

    def test_list_keys(self, capsys):
        assert cli.main(['--list-keys', '--model', 'whb04b']) == 0
        lines = capsys.readouterr().out.splitlines()
        for table in (WHB04B.keys, {code: name for name, code in
                                    (*WHB04B.selector.items(), *WHB04B.feed.items())}):
            for code, name in table.items():
                assert '  0x%02x  %s' % (code, name) in lines

    def test_json_of_what_is_seen(self, monkeypatch, capsys):
        bench = Bench('WHB04B')
        bench.turn = lambda _: bench.send(whb04b_frame([(1, 0)] * 3))       # a frame, when turned
        monkeypatch.setattr(cli, 'make_device', lambda *_: bench)
        monkeypatch.setattr('sys.stdin', io.StringIO('wheel 1\nlcd\nselect x\nlcd'))
        assert cli.main(['--json', '--script', '-', '--model', 'whb04b']) == 0
        frame, blank, shown = map(json.loads, capsys.readouterr().out.splitlines())
        assert (frame['event'], frame['model'], frame['lcd']['row1']) == ('frame', 'WHB04B',
                                                                          '1.0000')
        assert (blank['event'], blank['lcd']) == ('lcd', None)
        assert shown['lcd'] == frame['lcd']
