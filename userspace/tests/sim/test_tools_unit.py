# SPDX-License-Identifier: GPL-2.0-only
"""Manual pages and completions of the tools: made from --help, so what --help says is in them, and
the shells take them.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import runner

HERE = os.path.dirname(os.path.realpath(__file__))
SOURCE = os.path.join(HERE, '..', '..', 'tools')
TOOLS = ('xhcctl', 'xy3ctl')
OPTION = re.compile(r'^ +(?:-., )? *(--[a-z-]+)', re.M)


def output(*words, **options):
    return subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True, **options).stdout


class Case(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.dir = tempfile.mkdtemp()
        subprocess.run(['make', '-s', '-C', SOURCE, 'O=' + cls.dir, 'CFLAGS=-O2 -Werror'],
                       check=True, stdout=sys.stderr)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.dir)

    def help(self, tool, *verb):
        return output(os.path.join(self.dir, tool), *verb, '--help')

    def verbs(self, tool):
        found = re.findall(r'^  ([a-z]+) +\S', self.help(tool), re.M)
        self.assertGreater(len(found), 5)
        return found

    def options(self, tool, verb):
        return OPTION.findall(self.help(tool, verb))

    # --- manual pages ---

    def test_pages(self):
        for tool in TOOLS:
            path = os.path.join(self.dir, tool + '.1')
            with self.subTest(tool):
                self.assertEqual(output('mandoc', '-T', 'lint', '-W', 'warning', path), '')
                page = output('mandoc', '-T', 'ascii', path)
                page = re.sub('.\b', '', page)
                verbs = page[page.index('\nVERBS\n'):]
                parts = re.split(r'^   ([a-z]+)$', verbs, flags=re.M)
                texts = dict(zip(parts[1::2], parts[2::2]))
                self.assertEqual(list(texts), self.verbs(tool))
                common = page[page.index('\nOPTIONS\n'):page.index('\nVERBS\n')]
                for verb in texts:
                    self.assertIn('%s %s' % (tool, verb), page)
                    for option in self.options(tool, verb):
                        self.assertIn(option, common + texts[verb], (tool, verb))
                for status in '0123':
                    self.assertRegex(page, r'(?m)^ +%s +[A-Z]' % status)

    # --- bash ---

    def complete(self, tool, *words):
        """-> what bash offers for the last word"""
        script = ('PATH=%s:$PATH; . %s; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _%s; '
                  'printf "%%s\\n" "${COMPREPLY[@]}"'
                  % (self.dir, os.path.join(self.dir, 'bash', tool), tool))
        return output('bash', '-c', script, 'bash', tool, *words).split()

    def test_bash(self):
        for tool in TOOLS:
            self.assertGreaterEqual(set(self.complete(tool, '')), set(self.verbs(tool)))
            for verb in self.verbs(tool):
                self.assertGreaterEqual(set(self.complete(tool, verb, '--')),
                                        set(self.options(tool, verb)))
                self.assertIn(verb, self.complete(tool, verb[:2]))
        self.assertEqual(self.complete('xy3ctl', 'stream', '--bits', ''), ['24', '32'])
        self.assertEqual(self.complete('xy3ctl', 'stream', '--bits', '=', '3'), ['32'])
        self.assertIn('circle', self.complete('xy3ctl', 'stream', 'ci'))
        self.assertEqual(self.complete('xy3ctl', 'command', 'cal'), ['calibrate'])
        self.assertEqual(self.complete('xy3ctl', 'watch', '--count', ''), [])
        self.assertIn('schema.json', self.complete_in(os.path.join(SOURCE, 'xy3ctl')))

    def complete_in(self, folder):
        before = os.getcwd()
        os.chdir(folder)
        try:
            return self.complete('xy3ctl', 'packets', 'sch')
        finally:
            os.chdir(before)

    def test_bash_is_clean(self):
        for tool in TOOLS:
            self.assertEqual(output('shellcheck', '-s', 'bash',
                                    os.path.join(self.dir, 'bash', tool)), '')

    # --- zsh ---

    def test_zsh(self):
        """It is read without a fault, as the function of its name, and knows all verbs."""
        for tool in TOOLS:
            path = os.path.join(self.dir, 'zsh', '_' + tool)
            subprocess.run(['zsh', '-n', path], check=True)
            script = ('fpath=(%s $fpath); autoload -Uz compinit; compinit -D -u; '
                      'print ${_comps[%s]}' % (os.path.dirname(path), tool))
            self.assertEqual(output('zsh', '-f', '-c', script), '_%s\n' % tool)
            with open(path, encoding='ascii') as file:
                text = file.read()
            for verb in self.verbs(tool):
                self.assertRegex(text, r"(?m)^\t\t'%s:" % verb)
                self.assertIn('\t\t%s) _arguments' % verb, text)
                for option in self.options(tool, verb):
                    self.assertIn(option, text)


if __name__ == '__main__':
    sys.exit(runner.main())
