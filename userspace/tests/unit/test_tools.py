# SPDX-License-Identifier: GPL-2.0-only
"""Manual pages and completions of the tools: made from --help, so what --help says is in them, and
the shells take them.
"""

import os
import re
import subprocess

from tool import SOURCE, build

OPTION = re.compile(r'^ +(?:-., )? *(--[a-z-]+)', re.M)


def output(*words, **options):
    return subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True, **options).stdout


class Tool:
    """The cases, for each of the two"""
    name = None

    @classmethod
    def setup_class(cls):
        cls.dir = build('unit-tools', '-O2')

    def at(self, *path):
        return os.path.join(self.dir, *path)

    def help(self, *verb):
        return output(self.at(self.name), *verb, '--help')

    def verbs(self):
        found = re.findall(r'^  ([a-z]+) +\S', self.help(), re.M)
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
        parts = re.split(r'^   ([a-z]+)$', page[page.index('\nVERBS\n'):], flags=re.M)
        texts = dict(zip(parts[1::2], parts[2::2]))
        assert list(texts) == self.verbs()
        for verb, text in texts.items():
            assert '%s %s' % (self.name, verb) in page
            for option in self.options(verb):
                assert option in common + text, verb

    def test_page_has_all_exit_statuses(self):
        for status in '0123':
            assert re.search(r'(?m)^ +%s +[A-Z]' % status, self.page())

    # --- bash ---

    def complete(self, *words):
        """-> what bash offers for the last word"""
        script = ('PATH=%s:$PATH; . %s; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _%s; '
                  'printf "%%s\\n" "${COMPREPLY[@]}"'
                  % (self.dir, self.at('bash', self.name), self.name))
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


class TestXy3ctl(Tool):
    name = 'xy3ctl'

    def test_bash_offers_values(self):
        assert self.complete('stream', '--bits', '') == ['24', '32']
        assert self.complete('stream', '--bits', '=', '3') == ['32']
        assert 'circle' in self.complete('stream', 'ci')
        assert self.complete('command', 'cal') == ['calibrate']
        assert self.complete('watch', '--count', '') == []

    def test_bash_offers_files(self):
        before = os.getcwd()
        os.chdir(os.path.join(SOURCE, self.name))
        try:
            assert 'schema.json' in self.complete('packets', 'sch')
        finally:
            os.chdir(before)
