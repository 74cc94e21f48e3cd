# SPDX-License-Identifier: GPL-2.0-only
"""xhcctl for tests: with the layouts of this tree, and its output line by line."""

import os
import queue
import subprocess
import threading

from tool import HERE, Tool

LAYOUTS = os.path.realpath(os.path.join(HERE, '..', '..', 'hwdb', 'layouts'))
xhcctl = Tool('xhcctl')


def environment(**more):
    # the programs are built with sanitizers; errors that they find have an exit status of their own
    # (without leaks: that sanitizer uses ptrace, which is used by the UML kernel itself)
    return {**os.environ, 'XHC_LAYOUTS': LAYOUTS, 'TZ': 'UTC', 'TERM': 'xterm',
            'ASAN_OPTIONS': 'exitcode=99:detect_leaks=0',
            'UBSAN_OPTIONS': 'halt_on_error=1:exitcode=99', **more}


def start(*arguments, **options):
    options.setdefault('env', environment())
    for stream in ('stdout', 'stderr'):
        options.setdefault(stream, subprocess.PIPE)
    options.setdefault('stdin', subprocess.DEVNULL)
    return subprocess.Popen([xhcctl.path, *arguments], **options)


class Result:
    def __init__(self, status, out, err):
        self.status = status
        self.out = out
        self.err = err

    def json(self):
        """The documents printed, each valid by the schema."""
        return xhcctl.documents(self.out)


def run(*arguments, text=None, timeout=60, **options):
    if text is not None:
        options['stdin'] = subprocess.PIPE
    process = start(*arguments, **options)
    if isinstance(text, str):
        text = text.encode()
    try:
        out, err = process.communicate(text, timeout)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        raise
    return Result(process.returncode, (out or b'').decode(), (err or b'').decode())


class Follower:
    """A verb that keeps running: its lines as they are printed."""

    def __init__(self, *arguments, **options):
        self.process = start(*arguments, **options)
        self.lines = queue.Queue()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.put(line.decode().rstrip('\n'))
        self.lines.put(None)

    def line(self, timeout=30):
        """The next line; None at the end.  queue.Empty after the timeout."""
        return self.lines.get(timeout=timeout)

    def document(self):
        document, = xhcctl.documents(self.line())
        return document

    def rest(self):
        """Waits for the end; -> the lines until then"""
        lines = []
        while True:
            line = self.line()
            if line is None:
                return lines
            lines.append(line)

    def end(self, signal=None):
        """-> exit status, and text on standard error"""
        if signal is not None:
            self.process.send_signal(signal)
        err = self.process.stderr.read().decode()
        status = self.process.wait(30)
        self.reader.join()
        self.process.stdout.close()
        self.process.stderr.close()
        return status, err

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
