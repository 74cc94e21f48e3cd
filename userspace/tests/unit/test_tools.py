# SPDX-License-Identifier: GPL-2.0-only
"""Manual pages and completions of the tools: they contain all of --help, from which they are made,
and the shells accept them.
"""

import os
import re
import subprocess
import tempfile

import case
from tool import SOURCE, build
from xhcctl_tool import LAYOUTS

OPTION = re.compile(r'^ +(?:-., )? *(--[a-z-]+)', re.M)


def output(*words, **options):
    return subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True, **options).stdout


class Tool(case.Case):
    """The cases for each of the two tools"""
    name = None

    @classmethod
    def setup_class(cls):
        cls.dir = build('unit-tools', '-O2')

    def at(self, *path):
        return os.path.join(self.dir, *path)

    def help(self, *verb):
        return output(self.at(self.name), *verb, '--help')

    def verbs(self):
        listed = self.help().partition('\nVerbs:\n')[2].partition('\n\n')[0]
        found = re.findall(r'^  ([a-z]+) +\S', listed, re.M)
        assert len(found) > 5
        return found

    def options(self, verb):
        found = OPTION.findall(self.help(verb))
        assert len(found) > 3
        return found

    # --- manual pages ---

    def page(self):
        return re.sub('.\b', '', output('mandoc', '-T', 'ascii', self.at(self.name + '.1')))

    def test_page_is_clean(self):
        assert output('mandoc', '-T', 'lint', '-W', 'warning',
                                self.at(self.name + '.1')) == ''

    def test_page_has_all_verbs_and_options(self):
        page = self.page()
        common = page[page.index('\nOPTIONS\n'):page.index('\nVERBS\n')]
        verbs = page[page.index('\nVERBS\n'):page.index('\nEXIT STATUS\n')]
        parts = re.split(r'^   ([a-z]+)$', verbs, flags=re.M)
        texts = dict(zip(parts[1::2], parts[2::2]))
        assert list(texts) == self.verbs()
        for verb, text in texts.items():
            assert '%s %s' % (self.name, verb) in page
            for option in self.options(verb):
                assert option in common + text, verb

    def test_page_has_all_exit_statuses(self):
        for status in ('0', '1', '2', '3', '130'):
            assert re.search(r'(?m)^ +%s +[A-Z]' % status, self.page())

    def test_page_has_what_man_pages_have(self):
        titles = re.findall(r'(?m)^[A-Z ]+$', self.page())
        for title in ('NAME', 'SYNOPSIS', 'DESCRIPTION', 'OPTIONS', 'EXIT STATUS', 'ENVIRONMENT',
                      'FILES', 'EXAMPLES', 'SEE ALSO'):
            assert titles.count(title) == 1, title

    def test_examples_have_their_lines(self):
        """Each indented line of --help is a line of the page."""
        page = self.page()
        examples = page[page.index('\nEXAMPLES\n'):page.index('\nSEE ALSO\n')]
        lines = [' '.join(line.split()) for line in examples.splitlines()]
        found = 0
        for verb in [None, *self.verbs()]:
            text = output(self.at(self.name), *[verb] if verb else [], '--help',
                          env={**os.environ, 'ARGP_HELP_FMT': 'rmargin=200'})
            for line in re.findall(r'(?m)^  ((?:sudo )?%s .*)$' % self.name, text):
                assert ' '.join(line.split()) in lines, line
                # a command to be typed as it is: anything else is a comment
                assert '   ' not in line.partition('#')[0].strip(), line
                found += 1
        assert found > 3

    # --- bash ---

    def complete(self, *words, path=None):
        """-> completions of bash for the last word; path: the folder of the tool"""
        script = ('PATH=%s:$PATH; . %s; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _%s; '
                  'printf "%%s\\n" "${COMPREPLY[@]}"'
                  % (path or self.dir, self.at('bash', self.name), self.name))
        return output('bash', '-c', script, 'bash', self.name, *words).split()

    def test_bash_offers_verbs(self):
        assert set(self.complete('')) >= set(self.verbs())
        for verb in self.verbs():
            assert verb in self.complete(verb[:2])

    def test_bash_offers_options(self):
        for verb in self.verbs():
            assert set(self.complete(verb, '--')) >= set(self.options(verb))

    def test_bash_is_clean(self):
        assert output('shellcheck', '-s', 'bash', self.at('bash', self.name)) == ''

    # --- zsh ---

    def test_zsh_finds_it(self):
        subprocess.run(['zsh', '-n', self.at('zsh', '_' + self.name)], check=True)
        script = ('fpath=(%s $fpath); autoload -Uz compinit; compinit -D -u; '
                  'print ${_comps[%s]}' % (self.at('zsh'), self.name))
        assert output('zsh', '-f', '-c', script) == '_%s\n' % self.name

    def test_zsh_has_all_verbs_and_options(self):
        with open(self.at('zsh', '_' + self.name), encoding='ascii') as file:
            text = file.read()
        for verb in self.verbs():
            assert re.search(r"(?m)^\t\t'%s:" % verb, text)
            case = re.search(r'^\t\t%s\) _arguments (.*?) ;;$' % verb, text, re.M | re.S).group(1)
            for option in self.options(verb):
                assert option in case, verb


class TestXhcctl(Tool):
    name = 'xhcctl'

    def test_bash_offers_layouts(self):
        os.environ['XHC_LAYOUTS'] = LAYOUTS
        try:
            assert set(self.complete('layout', '')) >= {'list', 'default', 'hb03', 'whb04b'}
            assert self.complete('layout', 'wh') == ['whb04b']
        finally:
            del os.environ['XHC_LAYOUTS']

    def test_bash_offers_the_fields_of_the_pendant(self):
        """The fields of show, those of the model"""
        folder = tempfile.TemporaryDirectory()
        self.add_cleanup(folder.cleanup)
        fake = os.path.join(folder.name, 'xhcctl')
        with open(fake, 'w', encoding='ascii') as file:
            file.write('#!/bin/sh\n[ "$1" = show ] && printf "%s\\n" "model  WHB04B" '
                       '"dro/row1   0" "dro/row2   -1.5" "dro/mode   step" "stats/reports 7"\n')
        os.chmod(fake, 0o755)
        assert self.complete('set', 'ro', path=folder.name) == ['row1=', 'row2=']
        assert 'mode=' in self.complete('set', '', path=folder.name)
        assert self.complete('set', 'row1', '=', path=folder.name) == []
        assert self.complete('set', 'row1', '=', '1', path=folder.name) == []
        assert self.complete('set', 'row1', '=', '1', 'm', path=folder.name) == ['mode=']
        assert 'reports=' not in self.complete('set', '', path=folder.name)

    def test_zsh_has_a_function_for_each_list(self):
        with open(self.at('zsh', '_xhcctl'), encoding='ascii') as file:
            text = file.read()
        for what in ('fields', 'layouts'):
            assert '\n_xhcctl_%s() {\n' % what in text
            assert re.search(r":_xhcctl_%s'" % what, text)


class TestXy3ctl(Tool):
    name = 'xy3ctl'

    def test_bash_offers_values(self):
        assert self.complete('stream', '--bits', '') == ['24', '32']
        assert self.complete('stream', '--bits', '=', '3') == ['32']
        assert 'circle' in self.complete('stream', 'ci')
        assert self.complete('command', 'cal') == ['calibrate']
        assert set(self.complete('command', 'rate', '')) - set(self.options('command')) == \
            {'57600', '115200', '230400', '460800', '921600'}
        assert self.complete('command', 'rate', '9') == ['921600']
        assert self.complete('command', 'autocalib', 'o') == ['on', 'off']
        assert self.complete('command', 'calibrate', '1') == []
        assert {'autocalib', 'temp-comp', 'rate'} <= set(self.complete('command', ''))
        assert 'on' not in self.complete('command', '')
        assert self.complete('watch', '--count', '') == []

    def test_bash_offers_files(self):
        before = os.getcwd()
        os.chdir(os.path.join(SOURCE, self.name))
        try:
            assert 'schema.json' in self.complete('packets', 'sch')
        finally:
            os.chdir(before)
