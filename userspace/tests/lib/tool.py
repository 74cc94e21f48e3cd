# SPDX-License-Identifier: GPL-2.0-only
"""Runs xhcctl or xy3ctl like users and scripts. TOOLS is the folder of the programs."""

import json
import os
import select
import signal
import subprocess
import sys
import time

import jsonschema

HERE = os.path.dirname(os.path.realpath(__file__))
BUILD = os.path.realpath(os.path.join(HERE, '..', '..', '..', 'build'))
TOOLS = os.environ.get('TOOLS', '')
SOURCE = os.path.join(HERE, '..', '..', 'tools')
OK, FAILURE, USAGE, NO_DEVICE = range(4)
INTERRUPTED = 130        # by SIGINT, the status of a shell
PATIENCE = 60           # seconds; only reached on failure


def build(name, flags, *goals):
    """For tests without TOOLS. -> the folder of the tools, in build/"""
    folder = os.path.join(BUILD, name)
    subprocess.run(['make', '-s', '-j%d' % os.cpu_count(), '-C', SOURCE, 'O=' + folder,
                    'CFLAGS=-Werror ' + flags, *goals], check=True, stdout=sys.stderr)
    return folder


def build_sanitized():
    return build('unit-tools-sanitized',
                 '-O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all', 'programs')


class Tool:
    """A tool, by name."""

    def __init__(self, name):
        self.name = name
        self.path = os.path.join(TOOLS, name)
        with open(os.path.join(SOURCE, name, 'schema.json'), encoding='ascii') as file:
            self.schema = jsonschema.Draft7Validator(json.load(file))

    def run(self, *words, text='', timeout=60):
        """-> (status, output, standard error)"""
        done = subprocess.run([self.path, *words], input=text, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, timeout=timeout, check=False)
        return done.returncode, done.stdout, done.stderr

    def documents(self, output):
        """Documents printed by --json, one per line, each valid by the schema."""
        documents = [json.loads(line) for line in output.splitlines()]
        for document in documents:
            self.schema.validate(document)
        return documents

    def json(self, *words, status=OK, text=''):
        """-> the only document"""
        found, output, errors = self.run(*words, '--json', text=text)
        if found != status:
            raise AssertionError('%s: status %d: %s' % (' '.join(words), found, errors))
        document, = self.documents(output)
        return document

    def start(self, *words, **options):
        return Running(self, words, **options)


class Running:
    """A running tool; its lines are read as they arrive."""

    def __init__(self, tool, words, **options):
        self.process = subprocess.Popen([tool.path, *words], stdout=subprocess.PIPE,
                                        stderr=subprocess.PIPE, **options)
        self.rest = b''             # of its output, after the last line read

    def _read_line(self):
        """-> the next line with its end, '' at the end of the output"""
        deadline = time.monotonic() + PATIENCE
        while b'\n' not in self.rest:
            left = max(0, deadline - time.monotonic())
            assert select.select([self.process.stdout], [], [], left)[0], \
                'no further line in %d s' % PATIENCE
            data = os.read(self.process.stdout.fileno(), 65536)
            if not data:
                break
            self.rest += data
        line, newline, self.rest = self.rest.partition(b'\n')
        return (line + newline).decode()

    def line(self):
        """The next line, which must arrive; '' at the end of the output"""
        return self._read_line().rstrip('\n')

    def until(self, wanted):
        """-> the lines up to the first one that contains `wanted`"""
        lines = []
        while not lines or wanted not in lines[-1]:
            line = self._read_line()
            if not line:
                raise AssertionError('no %r in %r; %s' % (wanted, lines, self.end()))
            lines.append(line.rstrip('\n'))
        return lines

    def interrupt(self):
        self.process.send_signal(signal.SIGINT)
        return self.end()

    def end(self, timeout=60):
        """-> (status, rest of the output, text on standard error)"""
        output, errors = self.process.communicate(timeout=timeout)
        return self.process.returncode, (self.rest + output).decode(), errors.decode()

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.communicate()
