# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xhc-sim, the program: scripts, command line, screen, manual page."""

import contextlib
import errno
import io
import json
import os
import pty
import re
import select
import sys
import tempfile
import threading
import time

import pytest

from case import Case
from busless_pendant import HB03, HB04, PRODUCT, Bench, frame
from xhc_sim import VERSION, cli, pendant, terminal
from xhc_sim.script import COMMANDS, EXPECT_FIELDS, Failure, Runner, ScriptError

LIMIT = 20                  # timeout in seconds for expected events


class TestScripts(Case):
    def set_up(self):
        self.bench = Bench()
        self.bench.plug()
        self.said = []
        self.runner = Runner(self.bench, lambda: self.said.append(self.bench.screen()),
                             self.said.append, timeout=0.05)

    def run_text(self, text):
        self.runner.run(self.runner.parse(text))

    def test_hands(self):
        self.run_text('key Goto zero down\nkey 0x17 down\nkey goto ZERO up\n'
                      'select x\nwheel -3\nsleep\nwake\nreport 04 00')
        assert [r.hex() for r in self.bench.reports] == [
            '040100000001', '040117000001', '041700000017', '041700110017', '04170011fd17',
            '040000000000', '040000110000', '0400']

    def test_press(self):
        self.run_text('key Reset press')
        assert [r[1] for r in self.bench.reports] == [0x17, 0]

    def test_comments_and_quit(self):
        self.run_text('# nothing\n\n  echo one two\nquit\necho three')
        assert self.said == ['one two']

    def test_expect(self):
        self.bench.send(frame(HB04, [(220, 3340 | 0x8000)] + [(0, 0)] * 5, step=8, state=0x81))
        self.run_text('expect work_x -220.334\nexpect state inch+run\nexpect step 100\n'
                      'expect frames 1\nexpect faults none\nexpect awake yes\n'
                      'expect selector off\nexpect model hb04\n'
                      'expect position -220.334 0 0 0 0.0 -0')
        with pytest.raises(Failure, match='script:1: expect step 5: it is 100'):
            self.run_text('expect step 5')

    def test_expect_on_a_blank_display(self):
        with pytest.raises(Failure):
            self.run_text('expect work_x 0')

    def test_expect_waits(self):
        self.runner.timeout = LIMIT
        threading.Timer(0.05, self.bench.send, [frame(HB04, day=7)]).start()
        self.run_text('expect day 7')

    def test_faults(self):
        self.run_text('fault stall 0 2')
        self.bench.send(frame(HB04))
        assert [r.status for r in self.bench.set_reports] == \
                         [-errno.EPIPE] * 2 + [0] * 4

    def test_cable(self):
        self.run_text('unplug')
        with pytest.raises(Failure, match='unplugged'):
            self.run_text('wheel 1')
        self.run_text('plug\nwheel 1')

    @pytest.mark.parametrize('line', [
        'jump', 'key Reset', 'key 0 down', 'key nothing down', 'select q', 'wheel', 'wheel 128',
        'wheel x', 'report', 'report 0', 'wait -1', 'wait', 'expect', 'expect colour red',
        'expect work_x', 'expect work_x one', 'expect position 1 2', 'fault', 'fault fire',
        'fault stall -1', 'sleep now', 'lcd 2', 'quit 1', 'plug 2', '_parse', 'count 1'])
    def test_wrong_lines(self, line):
        with pytest.raises(ScriptError):
            self.run_text(line)

    def test_nothing_runs_if_a_line_is_wrong(self):
        with pytest.raises(ScriptError):
            self.run_text('wheel 1\nbroken')
        assert self.bench.reports == []

    def test_every_documented_command_parses(self):
        names = {name for form, _ in COMMANDS for name in
                 (part.split()[0] for part in form.split(', '))}
        known = {name[len('_parse_'):] for name in dir(Runner) if name.startswith('_parse_')}
        assert names == known | {'quit'}

    def test_idle_pendant_falls_asleep_while_waiting(self):
        self.bench.pendant.quiet_since -= 60
        self.run_text('wait 150\nexpect awake no')
        assert self.bench.reports == [pendant.SLEEP_REPORT]


class TestCommandLine(Case):
    def call(self, *arguments, device=None, text=None):
        """-> (exit status, stdout, stderr)"""
        out, err = io.StringIO(), io.StringIO()
        saved = cli.make_device, sys.stdin
        try:
            if device is not None:
                cli.make_device = lambda options, model: device
            sys.stdin = io.StringIO(text or '')
            with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
                try:
                    status = cli.main(list(arguments))
                except SystemExit as end:
                    status = end.code
        finally:
            cli.make_device, sys.stdin = saved
        return status, out.getvalue(), err.getvalue()

    def test_version(self):
        assert self.call('--version')[:2] == (0, 'xhc-sim %s\n' % VERSION)

    @pytest.mark.parametrize('arguments', [
        '--no-such', '--model HB99', '', '--json', '--timeout -1', '--script /does/not/exist',
        'surplus'])
    def test_usage_errors(self, arguments):
        assert self.call(*arguments.split())[0] == 2

    def test_list_keys(self):
        for model in (HB03, HB04):
            status, out, _ = self.call('--list-keys', '--model', model.name.lower())
            assert status == 0
            for code, name in model.keys.items():
                assert '0x%02x  %s\n' % (code, name) in out
            for name, code in model.selector.items():
                assert '0x%02x  %s\n' % (code, name) in out

    def test_script_from_stdin(self):
        status, out, _ = self.call('--script', '-', device=Bench(), text='echo hello\nlcd\n')
        assert status == 0
        assert out.startswith('hello\n+- HB04 -')

    def test_script_from_file(self):
        with tempfile.NamedTemporaryFile('w', suffix='.xhc') as file:
            file.write('wheel 1\nexpect frames 7\n')
            file.flush()
            status, _, err = self.call('-t', '10', '-s', file.name, device=Bench())
        assert status == 1
        assert ':2: expect frames 7: it is 0' in err

    def test_bad_script(self):
        assert self.call('-s', '-', device=Bench(), text='jump')[0] == 2

    def test_no_device(self):
        class Nothing(Bench):
            def plug(self):
                raise pendant.NoDevice(errno.ENOENT, 'No such file', '/dev/uhid')
        status, _, err = self.call('-s', '-', device=Nothing())
        assert (status, err) == (3, 'xhc-sim: /dev/uhid: No such file\n')

    def test_json(self):
        bench = Bench()
        bench.turn = lambda detents: bench.send(frame(HB04, step=3))    # a frame, when turned
        status, out, _ = self.call('-j', '-s', '-', device=bench, text='lcd\nwheel 1\nlcd\n')
        assert status == 0
        blank, first, second = [json.loads(line) for line in out.splitlines()]
        assert blank['lcd'] is None
        assert (first['event'], second['event']) == ('frame', 'lcd')
        assert (first['schema'], first['model'], first['frames']) == (1, 'HB04', 1)
        assert (first['lcd'], first['lcd']['step']) == (second['lcd'], 10)


class TestScreen(Case):
    """The interactive mode on a pseudo terminal."""

    def set_up(self):
        self.bench = Bench()
        self.bench.plug()
        self.master, self.slave = pty.openpty()
        self.add_cleanup(os.close, self.master)
        self.add_cleanup(os.close, self.slave)
        self.terminal = terminal.Terminal(self.bench, self.slave, self.slave)

    def test_every_key_has_a_letter(self):
        for model in (HB03, HB04):
            caps = terminal.Terminal(Bench(model.name)).caps
            assert sorted(caps.values()) == sorted(model.keys)
            assert not set(caps) & set('suq')

    def test_fits_80x24(self):
        for model in ('HB03', 'HB04'):
            bench = Bench(model)
            bench.plug()
            bench.press(1)
            screen = terminal.Terminal(bench)
            screen.message = 'x' * 200
            picture = screen.picture()
            assert len(picture) <= 24
            assert max(map(len, picture)) <= 80
            for name in bench.model.keys.values():
                assert any(name in line for line in picture), name

    def test_split_keys(self):
        assert terminal.split_keys('a\x1b[C\x1b[5~q') == ['a', '\x1b[C', '\x1b[5~', 'q']
        assert terminal.split_keys('\x1bx') == ['\x1b', 'x']

    def test_keys(self):
        for key in ('\x1b[C', '\x1b[D', '\x1b[A', '\x1b[A', '\x1b[B'):
            self.terminal.key(key)
        assert [(r[4], r[3]) for r in self.bench.reports] == \
                         [(1, 0), (255, 0), (0, 0x11), (0, 0x12), (0, 0x11)]

    def test_hold_and_click(self):
        self.terminal.key('A')
        assert self.bench.pendant.slots == [1, 0]
        self.terminal.key('b')
        assert self.bench.pendant.slots == [1, 2]
        time.sleep(terminal.CLICK)
        self.terminal.passing()
        assert self.bench.pendant.slots == [1, 0]
        self.terminal.key('A')
        assert self.bench.pendant.slots == [0, 0]

    def test_sleep_cable_fault(self):
        self.terminal.key('s')
        assert not self.bench.pendant.awake
        self.terminal.key('s')
        assert self.bench.pendant.awake
        self.terminal.key('u')
        assert not self.bench.plugged
        count = len(self.bench.reports)
        self.terminal.key('a')
        assert len(self.bench.reports) == count
        assert 'unplugged' in self.terminal.message
        self.terminal.key('u')
        assert self.bench.plugged
        for fault in ('stall', 'timeout', 'none'):
            self.terminal.key('!')
            assert self.bench.fault == fault

    def test_run_until_q(self):
        thread = threading.Thread(target=self.terminal.run, daemon=True)
        thread.start()
        text = os.read(self.master, 1)      # raw mode drops earlier input
        os.write(self.master, b'\x1b[C')
        self.bench.send(frame(HB04, [(135, 1700)] + [(0, 0)] * 5))
        os.write(self.master, b'q')
        while b'\x1b[?25h' not in text:
            assert select.select([self.master], [], [], LIMIT)[0], text
            text += os.read(self.master, 4096)
        thread.join(LIMIT)
        assert not thread.is_alive()
        assert b'HB04 10ce:eb70' in text
        assert self.bench.reports[0][4] == 1


class TestManual(Case):
    """The manual page agrees with --help."""

    @classmethod
    def setup_class(cls):
        with open(os.path.join(PRODUCT, 'xhc-sim.1'), encoding='utf-8') as page:
            cls.page = page.read()
        cls.help = cli.make_parser().format_help()

    def test_options(self):
        shorts = set(re.findall(r'(?:^|[ ,\[])-(\w)\b', self.help))
        longs = set(re.findall(r'--([a-z-]+)', self.help))
        page = self.page.replace('\\-', '-')
        assert set(re.findall(r'^\.It Fl (\w) ', page, re.M)) == shorts
        assert set(re.findall(r'^\.It Fl \w [^\n]*Fl -([a-z-]+)', page, re.M)) == \
                         longs & {'help', 'model', 'usb', 'script', 'json', 'timeout',
                                  'list-keys', 'version'}
        assert len(shorts) == 8

    def test_commands_and_fields(self):
        for form, _ in COMMANDS:
            for part in form.split(', '):
                assert re.search(r'(?m)^\.It (Ic|Cm) ([a-z]+ , )?%s\b' \
                                 % part.split()[0], self.page)
        for field in EXPECT_FIELDS:
            assert re.search(r'\b%s\b' % field, self.page)

    def test_faults_and_statuses(self):
        for kind in pendant.Fault.KINDS:
            assert re.search(r'(?m)^\.It Cm %s\b' % kind, self.page)
        for status in (cli.OK, cli.FAILED, cli.USAGE, cli.NO_DEVICE):
            assert re.search(r'(?m)^\.It %d$' % status, self.page)
