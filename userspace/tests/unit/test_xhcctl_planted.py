# SPDX-License-Identifier: GPL-2.0-only
"""xhcctl with pendants in an artificial /sys: list, show and set, for each model by its row.

The tool runs in a mount namespace in which that tree is /sys. Its files accept all writes:
refusals of the driver are tested in tools/test_xhcctl*.py.
"""

import os
import tempfile

import case
from tool import FAILURE, NO_DEVICE, OK, USAGE, build_sanitized
from xhcctl_tool import environment, run, xhcctl

STATS = ('reports', 'bad_reports', 'xor_mismatches', 'unknown_keys', 'frames_sent', 'frame_errors')
HB = {'position': '1.5 -2 3 -220.334 0 0.0001', 'feedrate_override': '100',
      'spindle_override': '80', 'feedrate': '1200', 'spindle_speed': '18000', 'step': '10',
      'step_available': '0 1 5 10', 'icon': '3', 'state': 'run', 'day': 'auto', 'refresh_ms': '50'}
WHB04B = {'rows': '135.17 -77.89 0', 'feedrate_override': '100', 'spindle_override': '80',
          'mode': 'step', 'coordinates': 'work', 'reset': '0', 'refresh_ms': '50'}
SHOWN = {
    'HB03': ['work_x', 'work_y', 'work_z', 'machine_x', 'machine_y', 'machine_z',
             'feedrate_override', 'spindle_override', 'feedrate', 'spindle_speed', 'step',
             'step_available', 'icon', 'state', 'day', 'refresh_ms'],
    'WHB04B': ['row1', 'row2', 'row3', 'feedrate_override', 'spindle_override', 'mode',
               'coordinates', 'reset', 'refresh_ms'],
    'NEXT': [],                         # a model of a later driver
}
SHOWN['HB04'] = SHOWN['HB03']
PLANTED = {'HB03': ('EB6E', HB), 'HB04': ('EB70', HB), 'WHB04B': ('EB93', WHB04B),
           'NEXT': ('EBFF', {})}
LAYOUT = {'HB03': 'hb03', 'HB04': 'hb04-18', 'WHB04B': 'whb04b', 'NEXT': 'none'}


def setup_module():
    xhcctl.path = os.path.join(build_sanitized(), 'xhcctl')


class TestPlanted(case.Case):
    def set_up(self):
        folder = tempfile.TemporaryDirectory()
        self.add_cleanup(folder.cleanup)
        self.sys = folder.name
        self.count = 0

    def write(self, path, text):
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, 'w', encoding='ascii') as file:
            file.write(text + '\n')

    def plant(self, model):
        """-> its folder"""
        product, dro = PLANTED[model]
        self.count += 1
        name = '0003:10CE:%s.%04X' % (product, self.count)
        path = '%s/devices/%s' % (self.sys, name)
        self.write(path + '/uevent', 'DRIVER=hid-xhc\nHID_PHYS=port%d' % self.count)
        self.write(path + '/model', model)
        self.write(path + '/awake', '1')
        self.write(path + '/dro/flush', '')
        for number, stat in enumerate(STATS):
            self.write('%s/stats/%s' % (path, stat), str(number))
        for attribute, text in dro.items():
            self.write('%s/dro/%s' % (path, attribute), text)
        group, = ([SHOWN[model][number] for number in range(len(dro[name].split()))]
                  for name in ('position', 'rows') if name in dro) if SHOWN[model] else [[]]
        for attribute in group:
            self.write('%s/dro/%s' % (path, attribute), '?')    # read together, not one by one
        os.makedirs(self.sys + '/bus/hid/drivers/hid-xhc', exist_ok=True)
        os.makedirs(self.sys + '/bus/hid/devices', exist_ok=True)
        os.symlink('../../bus/hid', path + '/subsystem')
        os.symlink('../../bus/hid/drivers/hid-xhc', path + '/driver')
        os.symlink('../../../devices/' + name, '%s/bus/hid/devices/%s' % (self.sys, name))
        return path

    def run(self, *words):
        """libudev would refuse a /sys that is not a sysfs."""
        script = 'mount --bind "$0" /sys && exec "$@"'
        path, xhcctl.path = xhcctl.path, '/usr/bin/unshare'
        try:
            return run('--user', '--map-root-user', '--mount', 'sh', '-c', script, self.sys, path,
                       *words, env=environment(SYSTEMD_DEVICE_VERIFY_SYSFS='0'))
        finally:
            xhcctl.path = path

    def read(self, path, attribute):
        """Contents planted or written; in these plain files longer old text is not truncated"""
        with open('%s/dro/%s' % (path, attribute), encoding='ascii') as file:
            return file.read()

    # --- the cases ---

    def test_list(self):
        for model in PLANTED:
            self.plant(model)
        result = self.run('list')
        assert (result.status, result.err) == (OK, '')
        head, *lines = result.out.splitlines()
        for line, (model, (product, _)) in zip(lines, PLANTED.items()):
            words = line.split()
            assert words[1:4] == ['0003:10CE:%s.000%s' % (product, int(words[0]) + 1), model,
                                  'yes']
            assert words[6] == '(%s)' % LAYOUT[model]
            for word in ('AWAKE', 'LAYOUT', 'PHYS'):
                assert line[head.index(word) - 1] == ' '
                assert line[head.index(word)] != ' '
        assert len(lines) == len(PLANTED)
        known = [one for one in PLANTED if one != 'NEXT']
        for index, model in enumerate(known):
            pendant, = self.run('list', '-j', '-d', str(index)).json()[0]['pendants']
            assert (pendant['model'], pendant['layout']) == (model, None)

    def test_show(self):
        """Exactly the fields of the model, in its order."""
        for model, names in SHOWN.items():
            with case.row(model):
                path = self.plant(model)
                result = self.run('show', '-d', os.path.basename(path))
                assert (result.status, result.err) == (OK, '')
                lines = [line.split(None, 1) for line in result.out.splitlines()]
                assert [name for name, _ in lines if name.startswith('dro/')] == \
                    ['dro/' + name for name in names]
                shown = {name.removeprefix('dro/'): value for name, value in lines}
                dro = PLANTED[model][1]
                values = dro.get('position', dro.get('rows', '')).split()
                assert [shown[name] for name in names[:len(values)]] == values
                for name in names[len(values):]:
                    assert shown[name] == dro[name]
                assert shown['stats/frame_errors'] == '5'

    def test_show_in_json(self):
        for model, names in SHOWN.items():
            if model == 'NEXT':
                continue
            with case.row(model):
                path = self.plant(model)
                shown, = self.run('show', '-j', '-d', os.path.basename(path)).json()
                assert (shown['model'], list(shown['stats'])) == (model, list(STATS))
                assert sorted(shown['dro']) == sorted(names)
            if model == 'WHB04B':
                whb04b = shown['dro']
        assert (whb04b['row2'], whb04b['mode'], whb04b['reset']) == (-77.89, 'step', False)

    def test_a_failure_in_json(self):
        """A document with the message of standard error; a usage error has none."""
        os.makedirs(self.sys + '/bus/hid/devices')
        for verb in ('list', 'show', 'monitor', 'record'):
            with case.row(verb):
                more = [os.path.join(self.sys, 'file')] if verb == 'record' else []
                result = self.run(verb, '--json', *more)
                document, = result.json()
                assert result.status == NO_DEVICE
                assert document['verb'] == verb
                assert document['error'] == result.err.strip().removeprefix('xhcctl: ')
                assert 'no pendant' in document['error']
        assert self.run('list', '-j').json()[0]['pendants'] == []
        result = self.run('set', '-j', 'nosuch=1')
        assert (result.status, result.out) == (USAGE, '')
        path = self.plant('WHB04B')
        document, = self.run('show', '-j').json()
        assert 'error' not in document
        os.unlink(path + '/dro/mode')
        document, = self.run('show', '-j').json()
        assert document['error'].endswith(': No such file or directory')

    def test_set(self):
        path = self.plant('WHB04B')
        result = self.run('set', 'rows=1 2 3', 'mode=mpg', 'coordinates=machine', 'reset=1',
                          'feedrate_override=7', 'spindle_override=8', 'refresh_ms=20', '--wait')
        assert (result.status, result.err) == (OK, '')
        for name, value in (('rows', '1 2 3'), ('mode', 'mpg'), ('coordinates', 'machine'),
                            ('reset', '1'), ('feedrate_override', '7'),
                            ('spindle_override', '8'), ('refresh_ms', '20'), ('flush', '1')):
            assert self.read(path, name).startswith(value), name
        assert self.run('set', 'row2=-4.5').status == OK
        assert self.read(path, 'row2').startswith('-4.5')

    def test_a_field_of_another_model(self):
        """Nothing is written, not even the fields before it."""
        for model, good, wrong in (
                ('WHB04B', 'mode=percent', ('step=1', 'work_x=1', 'position=1 2 3 4 5 6', 'day=1',
                                            'state=run', 'icon=1', 'feedrate=1')),
                ('HB04', 'feedrate=5', ('row1=1', 'rows=1 2 3', 'mode=step', 'reset=0',
                                        'coordinates=work')),
                ('NEXT', None, ('refresh_ms=50', 'rows=1 2 3'))):
            path = self.plant(model)
            for word in wrong:
                with case.row(model, word=word):
                    result = self.run('set', '-d', os.path.basename(path),
                                      *[each for each in (good, word) if each])
                    assert result.status == USAGE
                    assert 'the %s has no %s' % (model, word.split('=')[0]) in result.err
                    if good:
                        name = good.split('=')[0]
                        assert self.read(path, name) == PLANTED[model][1][name] + '\n'

    def test_one_that_does_not_answer(self):
        """A missing attribute is an error that names the pendant, not an empty value."""
        path = self.plant('WHB04B')
        os.unlink(path + '/dro/mode')
        result = self.run('show')
        assert (result.status, result.out) == (FAILURE, '')
        assert os.path.basename(path) in result.err
