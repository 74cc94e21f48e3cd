# SPDX-License-Identifier: GPL-2.0-only
"""The commands of a document, run one after another.

A test names each command in the order of the document: an unexpected command, or one that is not
reached, is a failure. Documents and examples are below PLACE.
"""

import os
import signal
import subprocess
import tempfile

from permissions import DIALOUT, NOBODY
from harness import BIND_TIME, find, read_file
from pages import commands

PLACE = '/src'
COMMAND_TIME = 300.0        # seconds: systemd-hwdb and matplotlib take long on a busy host
HOME = '/tmp/home'
MEMBER = ['setpriv', '--reuid', str(NOBODY), '--regid', str(NOBODY), '--groups', str(DIALOUT), '--']


class Document:
    """with Document('README.md') as document: document.run('xhcctl list') ..."""

    def __init__(self, name):
        self.name = name
        with open(os.path.join(PLACE, name), encoding='utf-8') as file:
            self.left = commands(file.read())
        self.block = None
        self.folder = PLACE

    def __enter__(self):
        if not os.path.isdir(HOME):
            os.mkdir(HOME)
            os.chown(HOME, NOBODY, NOBODY)
        return self

    def __exit__(self, kind, *_):
        if kind is None:
            assert [command.text for command in self.left] == [], \
                'commands of %s that no test knows' % self.name

    def next(self, text=None):
        """The next command, which must be this one; None: it must be a program"""
        assert self.left, '%s: no command %r' % (self.name, text)
        command = self.left.pop(0)
        if text is None:
            assert command.user == 'program', 'in %s: %r' % (self.name, command.text)
        else:
            assert command.text == text, 'next command of ' + self.name
        if command.block != self.block:
            self.block, self.folder = command.block, PLACE
        return command

    def start(self, command, text, **options):
        words = ['bash', '-c', text] if command.user != 'program' else ['python3', '-u', '-c', text]
        if command.user != 'root':
            words = MEMBER + words
        return subprocess.Popen(words, cwd=self.folder, stderr=subprocess.STDOUT,
                                stdin=subprocess.DEVNULL, start_new_session=True,
                                env={**os.environ, 'HOME': HOME, 'TERM': 'dumb'}, **options)

    def finish(self, command, text, status=0):
        """Runs it to its end -> its output"""
        # not a pipe, which a program in the background would keep open
        with tempfile.TemporaryFile('w+', encoding='utf-8') as file:
            process = self.start(command, text, stdout=file)
            try:
                found = process.wait(COMMAND_TIME)
            except subprocess.TimeoutExpired:
                found = 'none'
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
            file.seek(0)
            output = file.read()
        assert found == status, ('status of %r in %s, with %r' % (command.text, self.name,
                                                              output[-500:]))
        return output

    def run(self, text, names=(), status=0):
        """-> its output. names: [(name in the document, name here), ...]"""
        command = self.next(text)
        typed = command.typed
        for name, here in names:
            typed = typed.replace(name, here)
        if typed.startswith('cd '):
            self.folder = self.finish(command, 'set -e\n%s\npwd' % typed).strip()
            return ''
        return self.finish(command, typed, status)

    def shows(self, text):
        """A command whose output is exactly that in the document"""
        shown = self.left[0].shown if self.left else []
        assert self.run(text).splitlines() == shown, 'what %r prints' % text

    def file(self, text):
        """"cat FILE": a file that users are to write"""
        shown = [line for line in self.left[0].shown if line] if self.left else []
        with open(text.split()[1], 'w', encoding='utf-8') as file:
            file.write('\n'.join(shown) + '\n')
        self.shows(text)

    def follow(self, text, act, *words, ready=''):
        """A running command: calls act() after the output `ready`, until all words are printed."""
        command = self.next(text)
        with tempfile.NamedTemporaryFile('w') as file:
            process = self.start(command, command.typed, stdout=file)

            def printed(word):
                return lambda: word in read_output(file.name) or process.poll() is not None

            try:
                find.wait(printed(ready), BIND_TIME)
                act()
                for word in words:
                    find.wait(printed(word), BIND_TIME)
                output = read_output(file.name)
                missing = [word for word in words if word not in output]
                assert not missing, '%r has not printed %r: %s' % (command.text, missing, output)
            finally:
                if process.poll() is None:
                    os.killpg(process.pid, signal.SIGINT)
                process.wait(BIND_TIME)

    def program(self):
        command = self.next()
        return self.finish(command, command.text)

    def follow_program(self, act, *words):
        self.follow(None, act, *words)

    def elsewhere(self, *texts, test):
        """Commands that cannot be run here; `test` names the test that covers them."""
        assert test, 'no test'
        for text in texts:
            self.next(text)


def read_output(path):
    try:
        return read_file(path)
    except UnicodeDecodeError:
        with open(path, encoding='utf-8', errors='replace') as file:
            return file.read()
