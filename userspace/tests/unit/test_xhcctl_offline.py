# SPDX-License-Identifier: GPL-2.0-only
"""Unit tests of xhcctl without a pendant: command line, layouts, recordings.

It is built here, with AddressSanitizer and UBSan.
"""

import os
import random
import re
import stat
import tempfile
import case

from busless_pendant import models
from tool import FAILURE, NO_DEVICE, OK, USAGE, build_sanitized
from xhcctl_tool import LAYOUTS, environment, run, xhcctl

VERBS = ('list', 'monitor', 'show', 'set', 'layout', 'record', 'replay', 'doctor')
HWDB = 'etc/udev/hwdb.d/61-xhc-pendant.hwdb'

HEAD = 'R: %d %s\nN: KTURT.LTD\nP: usb-1/input0\nI: 3 10ce eb70\n' % (
    len(models.REPORT_DESCRIPTOR), models.REPORT_DESCRIPTOR.hex(' '))
REPORTS = 'E: 000000.000000 6 04 01 00 11 00 17\nE: 000001.250000 6 04 00 00 11 fd 16\n'


def setup_module():
    xhcctl.path = os.path.join(build_sanitized(), 'xhcctl')


class Case(case.Case):
    def set_up(self):
        folder = tempfile.TemporaryDirectory()
        self.add_cleanup(folder.cleanup)
        self.folder = folder.name

    def file(self, name, content):
        path = os.path.join(self.folder, name)
        with open(path, 'wb') as file:
            file.write(content if isinstance(content, bytes) else content.encode())
        return path

    def assert_says(self, result, status, *words):
        assert result.status == status, result.err
        for word in words:
            assert word in result.err
        if status != OK:
            assert 'xhcctl' in result.err.split(':')[0]


class TestWords(Case):
    def test_help(self):
        result = run('--help')
        assert (result.status, result.err) == (OK, '')
        assert tuple(re.findall(r'^  (\w+) +\w', result.out, re.M))[:len(VERBS)] == VERBS
        for verb in VERBS:
            result = run(verb, '--help')
            assert (result.status, result.err) == (OK, '')
            for word in ('Usage: xhcctl ' + verb, '--device=DEVICE', '--json'):
                assert word in result.out

    def test_short_help(self):
        """-h is --help, for the tool and for each verb"""
        assert run('-h').out == run('--help').out
        for verb in VERBS:
            with case.row(verb):
                result = run(verb, '-h')
                assert (result.status, result.err) == (OK, '')
                assert result.out == run(verb, '--help').out

    def test_messages_begin_with_the_name_alone(self):
        """Without the path by which the tool was started"""
        for words in (['-x'], ['list', '-x'], ['set', 'x'], ['nosuch']):
            with case.row(words):
                assert run(*words).err.startswith('xhcctl'), run(*words).err

    def test_misuse(self):
        for words in ([], ['frobnicate'], ['--frobnicate'], ['list', '--frobnicate'],
                      ['list', 'extra'], ['show', 'extra'], ['monitor', 'extra'],
                      ['set'], ['set', 'work_x'], ['set', '=1'], ['set', 'work_x1=1'],
                      ['set', 'work=1'], ['set', 'flush=1'], ['set', 'step_available=1'],
                      ['set', 'step=1', 'step=1'], ['set', 'work_x=1', 'position=1 2 3 4 5 6'],
                      ['set', 'position=1 2 3 4 5 6', 'machine_z=1'],
                      ['set', 'rows=1 2 3', 'row2=1'], ['set', 'row3=1', 'rows=1 2 3'],
                      ['set', 'row4=1'], ['set', 'mode=step', 'mode=mpg'],
                      ['monitor', '--count=0'], ['monitor', '--count=-1'],
                      ['monitor', '--count=x'], ['monitor', '--count=1x'],
                      ['monitor', '--count=99999999999999999999'], ['monitor', '--timeout=0'],
                      ['monitor', '--timeout=-1'], ['monitor', '--timeout=nan'],
                      ['monitor', '--timeout=inf'], ['monitor', '--timeout=1x'],
                      ['monitor', '--timeout='], ['monitor', '--timeout=1e10'],
                      ['record', 'one', 'two'], ['record', '--json'], ['record', '--count=0'],
                      ['replay'], ['replay', 'one', 'two'], ['replay', '--before=x', 'one'],
                      ['replay', '--after=-1', 'one'], ['list', '--device'],
                      ['layout', 'one', 'two'], ['layout', 'list', '--write'],
                      ['layout', '--apply'], ['layout', '--captions'], ['layout', '-d', '0'],
                      ['layout', 'default'], ['layout', 'default', '-c', '-w'],
                      ['layout', 'default', '-d', '0', '-w'], ['layout', 'hb03', '--root=/x'],
                      ['layout', 'hb03', '--root=/x', '--apply'], ['layout', 'hb03', '-w', '-j'],
                      ['layout', 'none'], ['layout', ''], ['layout', '../hb03'],
                      ['layout', 'hb03/'], ['layout', '.'], ['layout', 'x' * 300]):
            with case.row(words):
                result = run(*words)
                self.assert_says(result, USAGE, '--help')
                assert result.out == ''

    def test_a_field_that_is_wrong_is_named(self):
        for words, message in ((['work=1'], 'no field work'), (['step=1', 'step=2'],
                               'step is given twice'), (['position=', 'work_y=1'],
                               'work_y is a part of position')):
            self.assert_says(run('set', *words), USAGE, message)

    def test_version(self):
        assert re.search(r'^xhcctl \d+\.\d+\.\d+\ndriver hid_xhc: .+\n$', run('--version').out)


class TestLayouts(Case):
    def with_layouts(self, *arguments, **files):
        for name, content in files.items():
            self.file(name.replace('_', '-') + '.layout', content)
        return run(*arguments, env=environment(XHC_LAYOUTS=self.folder))

    def test_list(self):
        names = sorted(name.removesuffix('.layout') for name in os.listdir(LAYOUTS))
        assert names == ['hb03', 'hb04-16', 'hb04-18', 'whb04b']
        for words in ([], ['list']):
            lines = run('layout', *words).out.splitlines()
            assert [line.split()[0] for line in lines] == ['NAME'] + names
        listed = run('layout', '--json').json()[0]['layouts']
        assert [(one['name'], one['keys']) for one in listed] == \
                         [('hb03', 18), ('hb04-16', 16), ('hb04-18', 18), ('whb04b', 16)]

    def test_captions_are_those_of_the_virtual_pendants(self):
        for name, model in (('hb03', 'HB03'), ('hb04-18', 'HB04'), ('whb04b', 'WHB04B')):
            keys = run('layout', name, '--json').json()[0]['keys']
            assert {key['scan']: key['caption'] for key in keys} == \
                             models.MODELS[model].keys

    def test_captions_with_fn(self):
        """All keys except Fn have one, and each one is unique."""
        keys = run('layout', 'whb04b', '--json').json()[0]['keys']
        fn = {key['scan']: key['fn'] for key in keys}
        assert fn.pop(0x0c) is None
        assert sorted(fn.values()) == sorted('Macro %d' % number for number in range(1, 17)
                                             if number != 10)
        assert (fn[0x04], fn[0x01], fn[0x10]) == ('Macro 1', 'Macro 11', 'Macro 14')
        lines = run('layout', 'whb04b').out.splitlines()
        assert ' KEYBOARD_KEY_04=btn_trigger_happy4 # Feed+; with Fn: Macro 1' in lines
        assert ' KEYBOARD_KEY_0c=fn # Fn' in lines
        assert '# 04: Feed+; with Fn: Macro 1' in \
            run('layout', 'whb04b', '--captions').out.splitlines()
        for name in ('hb03', 'hb04-16', 'hb04-18'):
            for key in run('layout', name, '--json').json()[0]['keys']:
                assert key['fn'] is None

    def test_entry(self):
        lines = run('layout', 'hb04-16').out.splitlines()
        assert lines[0].startswith('# ')
        assert lines[1:3] == ['evdev:input:b0003v10CEpEB70*', ' XHC_LAYOUT=hb04-16']
        keys = dict(re.fullmatch(r' (\w+)=(\w+) # .+', line).groups() for line in lines[3:])
        assert list(keys) == ['KEYBOARD_KEY_%02x' % scan for scan in range(1, 0x18)]
        assert keys['KEYBOARD_KEY_01'] == 'stop'
        for scan in (4, 0x17, 0x16):    # keys without a code; one that these units lack
            assert keys['KEYBOARD_KEY_%02x' % scan] == 'btn_trigger_happy%d' % scan

    def test_a_key_that_stops_the_computer_is_refused(self):
        """lint/facts checks that no shipped layout has one"""
        for key, reason in (
                ('KEY_POWER', 'KEY_POWER would switch the computer off'),
                ('KEY_POWER2', 'KEY_POWER2 would switch the computer off'),
                ('KEY_RESTART', 'KEY_RESTART would restart the computer'),
                ('KEY_SLEEP', 'KEY_SLEEP would suspend the computer'),
                ('KEY_SUSPEND', 'KEY_SUSPEND would suspend the computer to disk'),
                ('KEY_LOGOFF', 'KEY_LOGOFF would end'), ('KEY_SYSRQ', 'KEY_SYSRQ gives commands'),
                ('KEY_COFFEE', 'KEY_COFFEE would lock the screen')):
            with case.row(key):
                bad = 'title\tT\nmatch\tM\n01\tStop\tKEY_STOP\n17\tReset\t%s\n' % key
                for words in (['--write', '--root', self.folder], ['--json'], []):
                    result = self.with_layouts('layout', 'bad', *words, bad=bad)
                    self.assert_says(result, FAILURE, '/bad.layout:4: ' + reason)
                    if '--json' in words:
                        document, = result.json()
                        assert reason in document.pop('error')
                        assert list(document) == ['schema', 'tool', 'verb']
                    else:
                        assert result.out == ''
                assert not os.path.exists(os.path.join(self.folder, HWDB))

    def test_entry_is_as_udev_wants_it(self):
        """Each property after one blank, each match at the start of its line."""
        for name in ('hb03', 'hb04-16', 'hb04-18', 'whb04b'):
            for line in run('layout', name).out.splitlines():
                assert re.search(
                    r'^(#.*|evdev:input:b0003v10CEpEB(6E|70|93)\*|'
                    r' (XHC_LAYOUT=%s|KEYBOARD_KEY_[0-9a-f]{2}=[a-z0-9_]+ # [ -~]+))$' % name,
                    line)

    def test_captions_alone(self):
        lines = run('layout', 'hb03', '--captions').out.splitlines()
        assert lines[1:3] == ['evdev:input:b0003v10CEpEB6E*', ' XHC_LAYOUT=hb03']
        assert lines[3:] == ['# %02x: %s' % (scan, models.MODELS['HB03'].keys.get(
            scan, '(no such key)')) for scan in range(1, 0x18)]

    def test_each_key_has_a_comment(self):
        for name, title in (('hb04-18', 'Reset'), ('hb04-16', 'Reset'), ('hb03', 'Yes')):
            lines = run('layout', name).out.splitlines()
            assert lines[-1] == ' KEYBOARD_KEY_17=%s # %s' % (
                'ok' if name == 'hb03' else 'btn_trigger_happy23', title)
        assert ' KEYBOARD_KEY_16=btn_trigger_happy22 # (no such key)' in \
            run('layout', 'hb04-16').out.splitlines()

    def test_write_and_remove(self):
        path = os.path.join(self.folder, HWDB)
        for name in ('hb04-18', 'hb03'):
            result = run('layout', name, '--write', '--root', self.folder)
            self.assert_says(result, OK, 'systemd-hwdb update --root=' + self.folder)
            with open(path, encoding='ascii') as file:
                assert file.read() == run('layout', name).out
            assert stat.S_IMODE(os.stat(path).st_mode) == 0o644
            assert os.listdir(os.path.dirname(path)) == [os.path.basename(path)]
        for _ in range(2):              # also if there is none
            self.assert_says(run('layout', 'default', '-w', '-r', self.folder), OK, 'plugged in')
            self.assert_says(run('layout', 'hb03', '-cw', '-r', self.folder), OK, 'plugged in')
            self.assert_says(run('layout', 'default', '-w', '-r', self.folder), OK, 'plugged in')
            assert os.listdir(os.path.dirname(path)) == []

    def test_what_cannot_be_written_leaves_the_old_file(self):
        os.makedirs(os.path.join(self.folder, 'etc/udev'))
        self.file('etc/udev/hwdb.d', 'in the way')
        result = run('layout', 'hb03', '-w', '-r', self.folder)
        self.assert_says(result, FAILURE, HWDB, 'Not a directory')

    def test_for_one_pendant_it_must_be_there(self):
        self.assert_says(run('layout', 'hb04-16', '-d', '9'), NO_DEVICE)

    def test_a_layout_of_ones_own(self):
        own = 'title\tMine\nmatch\tevdev:name:x:*\n02\tGo\tKEY_PLAY\n'
        result = self.with_layouts('layout', 'my-own', my_own=own)
        assert 'evdev:name:x:*\n XHC_LAYOUT=my-own\n' in result.out
        assert ' KEYBOARD_KEY_02=play # Go\n' in result.out

    def test_files_that_make_no_sense(self):
        head = 'title\tT\nmatch\tM\n'
        for line, content, why in (
                (1, '\n', 'required'), (1, 'title\n', 'title and a text'),
                (1, 'title\t\n', 'title and a text'), (2, 'title\tT\nmatch\tM\tN\n', 'match and'),
                (1, 'match\t%s\n' % ('x' * 200), 'match and'), (1, '01\tA\t-\n', 'come first'),
                (3, head + '01\tA\n', 'are required'),
                (3, head + '01\tA\t-\t-\t-\n', 'four fields'),
                (3, head + '01\tA\t-\tB\n', 'requires a line with fn'),
                (3, head + 'fn\t1\n', 'two hexa'), (3, head + 'fn\t18\n', '01 to 17'),
                (3, head + 'fn\n', 'fn and a code'), (4, head + '01\tA\t-\nfn\t01\n', 'before'),
                (4, head + 'fn\t02\n01\tA\t-\t\n', 'caption with Fn'),
                (4, head + 'fn\t02\n01\tA\t-\t%s\n' % ('x' * 32), 'caption with Fn'),
                (3, head + '1\tA\t-\n', 'two hexadecimal'), (3, head + 'xx\tA\t-\n', 'two hexa'),
                (3, head + '-1\tA\t-\n', 'two hexa'), (3, head + '00\tA\t-\n', '01 to 17'),
                (3, head + '18\tA\t-\n', '01 to 17'), (4, head + '02\tA\t-\n02\tB\t-\n', 'ascend'),
                (4, head + '02\tA\t-\n01\tB\t-\n', 'ascend'), (3, head + '01\t\t-\n', 'caption'),
                (3, head + '01\t%s\t-\n' % ('x' * 32), 'caption'),
                (3, head + '01\té\t-\n', 'ASCII'),
                (3, head + '01\tA\x1b[m\t-\n', 'ASCII'), (3, head + '01\tA\tKEY_NONE\n', 'no such'),
                (3, head + '01\tA\t\n', 'no such'), (3, head + '01\tA\tREL_X\n', 'no such'),
                (3, head + '01\t' + 'x' * 300 + '\t-\n', 'too long')):
            with case.row(content[:60]):
                result = self.with_layouts('layout', 'bad', bad=content)
                self.assert_says(result, FAILURE, '/bad.layout:%d: ' % line, why)
                assert result.out == ''
        self.assert_says(self.with_layouts('layout', 'bad', bad=head), FAILURE, 'no keys')
        listed = self.with_layouts('layout', bad='x\n', good=head + '01\tA\t-\n')
        self.assert_says(listed, FAILURE, 'bad.layout:1: ')
        assert 'good' in listed.out

    def test_lines_of_other_editors(self):
        plain = 'title\tT\nmatch\tM\n01\tA\tKEY_A\n02\tB\t-\n'
        entry = self.with_layouts('layout', 'plain', plain=plain)
        assert entry.status == OK
        for content in (plain.replace('\n', '\r\n'), '\ufeff' + plain,
                        '\ufeff' + plain.replace('\n', '\r\n')):
            result = self.with_layouts('layout', 'plain', plain=content)
            assert (result.status, result.out, result.err) == (OK, entry.out, '')
        for content in (plain.replace('A\t', 'A\r\t'), plain.replace('01', '\ufeff01')):
            self.assert_says(self.with_layouts('layout', 'plain', plain=content), FAILURE,
                             '/plain.layout:3: ')

    def test_a_folder_that_is_none(self):
        """It is named, and layouts found elsewhere are not affected."""
        for folder in ('/dev/null', self.folder + '/file'):
            self.file('file', '')
            result = run('layout', env=environment(XHC_LAYOUTS=folder))
            self.assert_says(result, FAILURE, folder + ': Not a directory')
            assert result.err.count('Not a directory') == 1
            result = run('layout', 'nosuch', env=environment(XHC_LAYOUTS=folder))
            self.assert_says(result, USAGE, 'no layout "nosuch"')

    def test_no_layouts(self):
        result = run('layout', env=environment(XHC_LAYOUTS=self.folder))
        if not os.path.isdir('/usr/local/share/xhc-xy3/layouts'):
            self.assert_says(result, FAILURE, 'no layouts')


class TestRecordings(Case):
    def check(self, content, *more):
        return run('replay', '--check', *more, self.file('recording', content))

    def test_good_ones(self):
        for content, reports in ((HEAD, 0), (HEAD + REPORTS, 2), ('# x\n\nD: 0\n' + HEAD, 0),
                                 ((HEAD + REPORTS).replace('\n', '\r\n'), 2),
                                 ((HEAD + REPORTS).rstrip('\n'), 2),
                                 (HEAD + REPORTS + '#' + 'x' * 9000 + '\n', 2)):
            with case.row(content[:20]):
                result = self.check(content, '--json')
                self.assert_says(result, OK)
                assert result.json()[0]['reports'] == reports
        assert self.check(HEAD + REPORTS).out == \
                         '0 of 2 reports sent, the recording is valid\n'

    def test_standard_input(self):
        self.assert_says(run('replay', '-c', '-', text=HEAD), OK)
        self.assert_says(run('replay', '-c', '-', text='x'), FAILURE, '-:1: ')

    def test_no_file(self):
        self.assert_says(run('replay', self.folder + '/none'), FAILURE, 'No such file')
        self.assert_says(run('replay', self.folder), FAILURE, 'Is a directory')

    def test_no_device_of_its_own(self):
        result = run('replay', '-d', '0', self.file('recording', HEAD))
        self.assert_says(result, USAGE, '--device cannot be used')

    def test_hostile_ones(self):
        for line, text, why in (
                (5, 'x\n', 'not a line'), (5, 'X: 1\n', 'not a line'), (5, 'E\n', 'not a line'),
                (5, 'D: 1\n', 'one device'), (5, 'D: x\n', 'one device'),
                (5, 'R: 1 00\n', 'twice'), (5, 'N: again\n', 'twice'), (5, 'P: again\n', 'twice'),
                (5, 'I: 3 1 1\n', 'twice'), (5, 'E: \n', 'no time'), (5, 'E: 1 1 00\n', 'no time'),
                (5, 'E: 0.0 1 00\n', 'no time'), (5, 'E: -1.000000 1 00\n', 'no time'),
                (5, 'E: 0.-00001 1 00\n', 'no time'), (5, 'E: 0.1234567 1 00\n', 'no time'),
                (5, 'E: 9999999999.000000 1 00\n', 'no time'), (5, 'E: 0.000000\n', 'no time'),
                (5, 'E: 0.000000 0\n', 'no size'), (5, 'E: 0.000000 x\n', 'no size'),
                (5, 'E: 0.000000 4097 00\n', 'no size'), (5, 'E: 0.000000 -1 00\n', 'no size'),
                (5, 'E: 0.000000 18446744073709551617 00\n', 'no size'),
                (5, 'E: 0.000000 2 00\n', 'fewer'), (5, 'E: 0.000000 1 100\n', 'fewer'),
                (5, 'E: 0.000000 1 zz\n', 'fewer'), (5, 'E: 0.000000 1 -1\n', 'fewer'),
                (5, 'E: 0.000000 1 00 00\n', 'more'), (5, 'E: 0.000000 1 00x\n', 'more'),
                (7, REPORTS + 'E: 000001.249999 1 00\n', 'earlier'),
                (5, 'E: ' + ' ' * 70000 + '\n', 'too long'), (5, 'N: a\0b\n', 'byte 0'),
                (6, '#\n\0\n', 'byte 0')):
            with case.row(text[:40]):
                self.assert_says(self.check(HEAD + text), FAILURE, '/recording:%d: ' % line, why)

    def test_heads_that_lack_something(self):
        for content, line, why in (
                ('', 0, 'without a report descriptor'), ('I: 3 1 1\n', 1, 'without a report'),
                ('R: 1 00\n', 1, 'without the ids'), (REPORTS, 1, 'before the descriptor'),
                ('R: 4097 00\n', 1, 'no size'), ('R: 0\n', 1, 'no size'), ('R:\n', 1, 'no size'),
                ('N: %s\n' % ('x' * 128), 1, 'too long'), ('P: %s\n' % ('x' * 64), 1, 'too long'),
                ('I: 3 10ce\n', 1, 'are required'), ('I: 3 10000 1\n', 1, 'are required'),
                ('I: 3 1 1 1\n', 1, 'are required')):
            with case.row(content[:30]):
                self.assert_says(self.check(content), FAILURE, '/recording:%d: ' % line, why)

    def test_the_largest(self):
        whole = 'R: 4096 ' + ' '.join(['ff'] * 4096) + '\nI: 3 1 1\nN: %s\nP: %s\n' % (
            'x' * 127, 'x' * 63) + ('E: 000000.000000 4096 ' + ' '.join(['ff'] * 4096) + '\n') * 99
        assert self.check(whole, '-j').json()[0]['reports'] == 99

    def test_noise(self):
        """Any mutation of a file is accepted, or refused with the number of one of its lines."""
        chance = random.Random(5)
        good = (HEAD + REPORTS * 2).encode()
        for turn in range(150):
            content = bytearray(good)
            for _ in range(chance.randint(1, 6)):
                at = chance.randrange(len(content))
                how = chance.randrange(4)
                if how == 0:
                    content[at] = chance.randrange(256)
                elif how == 1:
                    del content[at:at + chance.randint(1, 40)]
                elif how == 2:
                    content[at:at] = content[:chance.randint(1, 60)]
                else:
                    content[at:at] = bytes(chance.choices(b'0 9:.-fERNPID\n', k=5))
                content = content or bytearray(b'#')
            with case.row(turn=turn, content=bytes(content)):
                result = self.check(bytes(content))
                assert result.status in (OK, FAILURE), result.err
                if result.status == FAILURE:
                    number = re.search(r'/recording:(\d+): .', result.err)
                    assert number is not None, result.err
                    assert int(number[1]) <= content.count(b'\n') + 1
