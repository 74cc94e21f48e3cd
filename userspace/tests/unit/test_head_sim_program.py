# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xy3-head-sim, the program: scripts, command line, manual page."""

import contextlib
import io
import json
import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from unittest import mock

import pytest

from case import Case

PRODUCT = os.path.realpath(os.path.join(os.path.dirname(os.path.realpath(__file__)),
                                        '..', '..', 'xy3-head-sim'))
sys.path.insert(0, PRODUCT)

from xy3_head_sim import VERSION, cli, faults, head, line, wire  # noqa: E402 (needs the path)
from xy3_head_sim.script import COMMANDS, Failure, Runner, ScriptError  # noqa: E402
from xy3_head_sim.simulator import Simulator  # noqa: E402

PROGRAM = [sys.executable, '-B', os.path.join(PRODUCT, 'xy3-head-sim')]
LIMIT = 20                  # timeout in seconds for expected events


class TestScripts(Case):
    """Commands, on a pipe."""

    def set_up(self):
        self.reader, writer = os.pipe()
        os.set_blocking(self.reader, False)
        self.line = line.Line(writer, 'pipe')
        self.add_cleanup(os.close, self.reader)
        self.add_cleanup(self.line.close)
        self.head = head.Head(interval=0, sync_interval=0)
        self.simulator = Simulator(self.head, self.line)
        self.said = []
        self.runner = Runner(self.simulator, lambda event, **members:
                             self.said.append((event, members)), timeout=0.2)

    def run_text(self, *lines):
        """-> the data sent"""
        for number, text in enumerate(lines, 1):
            step = self.runner.parse(text, 'script:%d' % number)
            if step is not None and not self.runner.run(step):
                break
        try:
            return os.read(self.reader, 65536)
        except BlockingIOError:
            return b''

    def unpacked(self, text):
        data = self.run_text(text)
        return wire.unpack(data[1], data[3:], self.head.order)

    def test_texts(self):
        assert self.run_text('vendor Laser  Works', 'model ABC', 'firmware 1.2.3',
                                       'serial 0001', 'serial -') == \
                         wire.vendor('Laser  Works') + wire.model('ABC') + \
                         wire.firmware('1.2.3') + wire.serial('0001')
        assert self.head.serial is None

    def test_temp(self):
        assert self.unpacked('temp galvo_x 43.5')[12] == 4350
        assert self.unpacked('temp head -5')[0] == -500
        assert self.unpacked('temp dsp absent')[1] is None
        assert len(self.unpacked('temp galvo_y absent')) == 13

    def test_error(self):
        assert self.unpacked('error dac_y temperature')[3] == 1
        assert self.unpacked('error dac_y none')[3] == 0
        assert self.unpacked('error dac_y 0xff')[3] == 255
        assert len(self.unpacked('error mirror_w absent')) == 21

    def test_hours_and_frame_errors(self):
        assert self.unpacked('hours head 1234')[0] == 1234
        assert self.unpacked('hours head absent')[0] is None
        assert self.unpacked('frame-errors w 9') == [0, 0, 0, 0, 9]

    def test_order(self):
        self.run_text('order big')
        assert self.run_text('hours head 1')[3:7] == b'\0\0\0\1'

    def test_sending(self):
        assert self.run_text('sync') == wire.sync()
        assert self.run_text('debug a b') == wire.debug('a b')
        assert self.run_text('packet 0x20', 'packet 7 01 02') == \
                         wire.packet(0x20) + wire.errors([1, 2])
        assert self.run_text('raw 48 4100') == wire.sync()
        assert self.run_text('report') == b''.join(self.head.packets())

    def test_faults(self):
        assert len(self.run_text('fault lost 2', 'sync', 'sync', 'sync')) == 2 + 2 + 3
        self.run_text('fault noise always', 'fault torn 1/9')
        assert self.head.faults.active == ['noise', 'torn']
        self.run_text('fault noise off')
        assert self.head.faults.active == ['torn']
        self.run_text('fault off')
        assert self.head.faults.active == []

    def test_every_fault(self):
        for kind in faults.KINDS:
            self.run_text('fault %s once' % kind, 'sync')
            assert self.head.faults.counts[kind] == 1

    def test_silence(self):
        assert self.run_text('silence', 'sync', 'silence off', 'debug abc') == \
                         wire.debug('abc')
        with mock.patch.object(head.time, 'monotonic', return_value=100.0) as clock:
            assert self.run_text('silence 0.05', 'sync') == b''
            clock.return_value += 0.06
            assert self.run_text('debug abc') == wire.debug('abc')

    def test_rates(self):
        assert self.run_text('uart 115200', 'sync') == wire.sync()
        assert wire.START not in self.run_text('rate 57600', 'sync')
        assert self.run_text('uart 57600', 'sync') == wire.sync()
        assert self.run_text('rate 921600', 'uart auto', 'sync') == wire.sync()

    def test_intervals(self):
        data = self.run_text('interval 1000', 'sync-interval 0.01')
        deadline = time.monotonic() + LIMIT
        while data.count(wire.sync()) < 6 and time.monotonic() < deadline:
            data += self.run_text('sleep 0.02')
        data += self.run_text('interval 0', 'sync-interval 0')
        assert self.run_text('sleep 0.1', 'sync') == wire.sync()
        kinds = [kind for kind, _ in wire.Decoder().feed(data + b'H')]
        assert kinds.count(wire.VENDOR) == 1
        assert kinds.count(wire.SYNC) > 4

    def test_streams(self):
        self.run_text('stream 100')
        assert self.head.counts()['packets'] == 100
        self.run_text('zero', 'bytes 10000')
        assert 10000 <= self.head.counts()['bytes'] < 10258

    def test_counts_and_echo(self):
        self.run_text('sync', 'counts', 'echo one  two')
        assert self.said[0] == ('counts', self.head.counts())
        assert self.said[1] == ('echo', {'text': 'one  two'})

    def test_waits(self):
        self.run_text('wait open', 'wait sent')
        with pytest.raises(Failure, match='^script:1: wait closed: the line is still open'):
            self.run_text('wait closed')

    def test_a_stream_that_nobody_takes(self):
        with pytest.raises(Failure, match='bytes 1000000: the other end does not read'):
            self.run_text('bytes 1000000')

    def test_comments_and_quit(self):
        assert self.run_text('# sync', '', '  ', 'debug abc', 'quit', 'sync') == \
                         wire.debug('abc')

    @pytest.mark.parametrize('text', [
        'jump', 'text abc', '_text', 'frame_errors x 1', 'vendor', 'vendor ab',
        'model ' + 'x' * 201, 'temp', 'temp head', 'temp nose 1', 'temp head hot', 'temp head 400',
        'temp head nan',
        'temp head 1 2', 'error head fire', 'error head 256', 'error head -1', 'hours head -1',
        'hours head 4294967296', 'hours head 1.5', 'frame-errors v 1', 'frame-errors x', 'debug ab',
        'sync now', 'report all', 'packet', 'packet 256', 'packet 1 0', 'packet 1 ' + '00' * 256,
        'packet vendor', 'raw', 'raw 4', 'order middle', 'order', 'rate 9600', 'rate', 'uart',
        'uart fast', 'uart 0', 'interval', 'interval -1', 'sync-interval x', 'fault', 'fault lost',
        'fault fire once', 'fault lost 0', 'silence on', 'stream', 'stream 0', 'bytes -1', 'wait',
        'wait long', 'sleep', 'sleep -1', 'sleep inf', 'counts 1', 'zero 1', 'quit 1'],
        ids=lambda text: text[:30])
    def test_wrong_lines(self, text):
        with pytest.raises(ScriptError, match='^script:1: '):
            self.run_text(text)
        assert self.head.counts()['bytes'] == 0

    def test_every_documented_command_parses(self):
        names = {name for form, _ in COMMANDS for name in form.split()[0].split('|')}
        known = {name[len('_parse_'):].replace('_', '-') for name in dir(Runner)
                 if name.startswith('_parse_')}
        assert names == known


class TestCommandLine(Case):
    def call(self, *arguments):
        """-> (exit status, stdout, stderr)"""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                status = cli.main(list(arguments))
            except SystemExit as end:
                status = end.code
        return status, out.getvalue(), err.getvalue()

    def script(self, *lines):
        file = tempfile.NamedTemporaryFile('w', suffix='.head', delete=False)
        self.add_cleanup(os.unlink, file.name)
        with file:
            file.write('\n'.join(lines))
        return file.name

    def test_version(self):
        assert self.call('--version')[:2] == (0, 'xy3-head-sim %s\n' % VERSION)

    @pytest.mark.parametrize('arguments', [
        '--no-such', 'surplus', '-r 9600', '-i -1', '-i nan', '-y x', '--order middle',
        '--vendor ab', '-f lost', '-f fire=once', '-c nowhere', '-l tcp:example.org:1', '-p -o x',
        '-n 0', '-n 1 -b 1', '-n 1 -s -', '-x', '-o /dev/null -L x', '--scr -',
        '-o /dev/null -s /does/not/exist'])
    def test_usage_errors(self, arguments):
        status, out, err = self.call(*arguments.split())
        assert (status, out) == (2, '')
        assert 'xy3-head-sim: ' in err

    def test_options_reach_the_head(self):
        options = cli.make_parser().parse_args(
            ['--vendor', 'Abc', '--serial', '', '--order', 'big', '-r', '57600', '-i', '5', '-y',
             '0', '-f', 'lost=3', '--fault', 'noise=1/7', '--seed', '9'])
        one = cli.make_head(options)
        assert (one.vendor, one.model, one.serial, one.order, one.rate, one.interval,
                          one.sync_interval, one.faults.active) == \
                         ('Abc', 'Head-2D', None, 'big', 57600, 5.0, 0.0, ['noise', 'lost'])

    def test_stream_to_a_file(self):
        with tempfile.NamedTemporaryFile() as file:
            for arguments, packets in ((['-n', '12345'], 12345), (['-b', '200000'], 0)):
                status, out, _ = self.call('-o', file.name, *arguments)
                assert status == 0
                first, counts = out.splitlines()
                assert first == 'ready ' + file.name
                counts = json.loads(counts)
                with open(file.name, 'rb') as result:
                    data = result.read()
                decoder = wire.Decoder()
                decoder.feed(data)
                assert (counts['bytes'], counts['receiver']) == \
                                 (len(data), decoder.counts())
                assert counts['packets'] == (packets or decoder.packets)

    def test_script_from_a_file(self):
        script = self.script('echo hello', 'sync', 'counts')
        status, out, _ = self.call('-o', '/dev/null', '-i', '0', '-y', '0', '-s', script)
        assert status == 0
        ready, hello, counts = out.splitlines()
        assert (ready, hello) == ('ready /dev/null', 'hello')
        assert json.loads(counts)['packets'] == 1

    def test_nothing_runs_if_a_line_is_wrong(self):
        script = self.script('echo hello', 'jump')
        status, out, err = self.call('-o', '/dev/null', '-s', script)
        assert (status, out) == (2, '')
        assert err == 'xy3-head-sim: %s:2: unknown command "jump"\n' % script

    def test_a_script_that_fails(self):
        script = self.script('wait closed', 'echo no')
        status, out, err = self.call('-o', '/dev/null', '-t', '0.1', '-s', script)
        assert (status, out) == (1, 'ready /dev/null\n')
        assert ':1: wait closed: the line is still open' in err

    @pytest.mark.parametrize('arguments', [
        '-o /no/such/file', '-c unix:/no/such -w 0', '-l unix:/no/such/place', '-o /dev/full -n 1',
        '-L /no/such/place'])
    def test_a_line_that_fails(self, arguments):
        status, _, err = self.call(*arguments.split())
        assert status == 1
        assert re.search(r'^xy3-head-sim: [^\n]*(/no/such|/dev/full)[^\n]*\n$', err)

    def test_json(self):
        script = self.script('echo hello', 'counts')
        out = self.call('-j', '-o', '/dev/null', '-s', script)[1]
        ready, echo, counts = [json.loads(text) for text in out.splitlines()]
        assert ready == {'schema': 1, 'event': 'ready', 'line': '/dev/null'}
        assert echo == {'schema': 1, 'event': 'echo', 'text': 'hello'}
        assert (counts['schema'], counts['event']) == (1, 'counts')


class TestProgram(Case):
    """The program as a separate process."""

    def start(self, *arguments):
        process = subprocess.Popen([*PROGRAM, *arguments], stdin=subprocess.PIPE,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        guard = threading.Timer(3 * LIMIT, process.kill)
        guard.start()
        self.add_cleanup(guard.cancel)
        for stream in (process.stdin, process.stdout, process.stderr):
            self.add_cleanup(stream.close)
        self.add_cleanup(process.wait)
        self.add_cleanup(process.kill)
        return process

    def tell(self, process, text):
        process.stdin.write(text.encode() + b'\n')
        process.stdin.flush()

    def line_of(self, process):
        return process.stdout.readline().decode().strip()

    def read(self, fd, enough):
        data = b''
        while len(data) < enough and select.select([fd], [], [], LIMIT)[0]:
            data += os.read(fd, 65536)
        return data

    def open_pty(self, process):
        ready, name = self.line_of(process).split()
        assert ready == 'ready'
        slave = os.open(name, os.O_RDWR | os.O_NOCTTY)
        self.add_cleanup(os.close, slave)
        assert self.line_of(process) == 'opened'
        return slave

    def test_commands_while_it_runs(self):
        process = self.start('-s', '-', '-i', '0', '-y', '0')
        slave = self.open_pty(process)
        self.tell(process, 'temp galvo_x 43.5')
        data = self.read(slave, 3)
        assert (data[1], wire.unpack(data[1], data[3:])[12]) == (wire.TEMPERATURES, 4350)
        self.tell(process, 'counts')
        assert json.loads(self.line_of(process))['bytes'] == len(data)
        self.tell(process, 'quit')
        assert process.wait(LIMIT) == 0

    def test_telemetry_by_itself(self):
        process = self.start('--vendor', 'By itself')
        decoder = wire.Decoder()
        packets, slave = [], self.open_pty(process)
        while len(packets) < 15:
            data = self.read(slave, 1)
            assert data
            packets += decoder.feed(data)
        assert (wire.VENDOR, b'By itself') in packets
        assert decoder.dropped == 0
        process.send_signal(signal.SIGTERM)
        assert process.wait(LIMIT) == 0

    def test_stream_waits_for_its_reader(self):
        process = self.start('-n', '50000')
        slave = self.open_pty(process)
        time.sleep(0.2)
        decoder = wire.Decoder()
        while decoder.packets < 50000:
            data = self.read(slave, 1)
            assert data
            decoder.feed(data)
        counts = json.loads(self.line_of(process))
        assert (counts['receiver'], counts['bytes'], counts['packets']) == \
                         (decoder.counts(), decoder.packet_bytes, 50000)
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        assert (process.wait(LIMIT), process.stderr.read()) == (0, b'')

    def test_a_wrong_line_on_stdin(self):
        process = self.start('-s', '-', '-o', '/dev/null')
        out, err = process.communicate(b'echo hello\njump\necho no\n', LIMIT)
        assert (process.returncode, out, err) == (
            2, b'ready /dev/null\nhello\n', b'xy3-head-sim: stdin:2: unknown command "jump"\n')

    def test_last_line_without_newline(self):
        process = self.start('-s', '-', '-o', '/dev/null')
        out, _ = process.communicate(b'echo hello', LIMIT)
        assert (process.returncode, out) == (0, b'ready /dev/null\nhello\n')

    def test_nobody_reads_stdout(self):
        process = self.start('-s', '-', '-o', '/dev/null')
        self.line_of(process)
        process.stdout.close()
        for _ in range(2):
            with contextlib.suppress(BrokenPipeError):
                self.tell(process, 'echo hello')
        assert (process.wait(LIMIT), process.stderr.read()) == (1, b'')

    def test_interrupted_with_a_link(self):
        with tempfile.TemporaryDirectory() as folder:
            link = os.path.join(folder, 'head')
            process = self.start('-L', link)
            self.line_of(process)
            assert os.path.exists(link)
            process.terminate()
            assert process.wait(LIMIT) == 0
            assert os.listdir(folder) == []

    def test_client_whose_server_goes(self):
        with tempfile.TemporaryDirectory() as folder:
            address = 'unix:' + os.path.join(folder, 'socket')
            server = self.start('-l', address, '-s', '-')
            assert self.line_of(server) == 'ready ' + address
            client = self.start('-c', address)
            assert self.line_of(server) == 'opened'
            self.tell(server, 'quit')
            assert server.wait(LIMIT) == 0
            assert client.wait(LIMIT) == 1
            assert b'the other end has disconnected' in client.stderr.read()


class TestManual(Case):
    """The manual page agrees with --help."""

    @classmethod
    def setup_class(cls):
        with open(os.path.join(PRODUCT, 'xy3-head-sim.1'), encoding='utf-8') as page:
            cls.page = page.read()
        cls.parser = cli.make_parser()

    def section(self, title):
        return re.search(r'(?ms)^\.S[sh] %s$.*?(?=^\.S[sh] |\Z)' % title, self.page).group()

    def test_options(self):
        wanted = {option.lstrip('-') for action in self.parser._actions
                  for option in action.option_strings}
        described = self.section('DESCRIPTION')
        found = set()
        for item in re.findall(r'(?m)^\.It Fl .*$', described):
            found |= set(re.findall(r'Fl -?([\w-]+)', item))
        assert found == wanted
        assert len(wanted) > 30

    def test_defaults(self):
        page = self.section('DESCRIPTION').replace('\n', ' ')
        for name, default in (('wait', '5'), ('interval', '1'), ('sync-interval', r'0\.1'),
                              ('seed', '0'), ('order', 'little')):
            assert re.search(r'Fl -%s [^.]*\.?[^.]*?\. The default is %s\b' % (name, default), page)
            value = self.parser.get_default(name.replace('-', '_'))
            assert (format(value, 'g') if isinstance(value, float) else str(value)) == \
                             default.replace('\\', '')
        for rate in wire.RATES:
            assert str(rate) in page

    def test_commands(self):
        names = {name for form, _ in COMMANDS for name in form.split()[0].split('|')}
        assert set(re.findall(r'(?m)^\.It Ic ([\w-]+)', self.section('Scripts'))) == names

    def test_faults(self):
        text = self.section('Faults')
        assert re.findall(r'(?m)^\.It Cm ([\w-]+)$', text) == list(faults.KINDS)
        words = re.sub(r'\s+', ' ', text).lower()
        for what in faults.KINDS.values():
            assert what.lower() in words

    def test_names(self):
        words = set(re.findall(r'\w+', self.section('Scripts')))
        for name in wire.COMPONENTS + wire.AXES + wire.ERROR_NAMES:
            assert name in words

    def test_counts(self):
        words = set(re.findall(r'\w+', self.section('Output')))
        for name in (*head.Head().counts(), *wire.Decoder().counts()):
            assert name in words

    def test_statuses(self):
        for status in (cli.OK, cli.FAILED, cli.USAGE):
            assert re.search(r'(?m)^\.It %d$' % status, self.section('EXIT STATUS'))

    def test_help_has_everything(self):
        text = self.parser.format_help()
        for words in ([form for form, _ in COMMANDS], faults.KINDS, wire.COMPONENTS):
            for word in words:
                assert word in text
