# SPDX-License-Identifier: GPL-2.0-only
"""hal_input's life: it ends when the pendant is unplugged, and has to be started again."""

import subprocess
import time

COMPONENT = 'hal_input'
PAUSE = 1.0             # seconds between two tries


class Input:
    """Runs a HAL file when a pendant has come; the file loads hal_input and wires its pins."""

    def __init__(self, file, hal, say):
        self.file = file
        self.hal = hal
        self.say = say
        self.path = None            # of the pendant that hal_input reads
        self.loading = None         # halcmd, while it runs
        self.loading_for = None
        self.next_try = 0.0
        self.failed = False

    def works_for(self, path):
        """Does hal_input read the pendant at `path`, and is it wired? If not, and there is one,
        work is begun on it. Never waits."""
        if self.loading:
            self._look_at_halcmd()
        if self.path and (path != self.path or not self._alive()):
            self.path = None
            # LinuxCNC may be ending its components one by one: we may be the next
            self.next_try = time.monotonic() + PAUSE
        if path and not self.path and not self.loading:
            self._start(path)
        return self.path is not None

    def _alive(self):
        return self.hal.component_exists(COMPONENT)

    def _start(self, path):
        """The one that read the pendant before must have ended first."""
        if time.monotonic() < self.next_try or self._alive():
            return
        self.loading_for = path
        try:
            self.loading = subprocess.Popen(['halcmd', '-f', self.file],
                                            stdin=subprocess.DEVNULL, start_new_session=True)
        except OSError as error:
            self._ended(error.strerror)

    def _look_at_halcmd(self):
        status = self.loading.poll()
        if status is not None:
            self._ended('status %d' % status if status else None)

    def _ended(self, trouble):
        """Says the first of several failures."""
        self.loading = None
        self.next_try = time.monotonic() + PAUSE
        if trouble is None:
            self.path = self.loading_for
        elif not self.failed:
            self.say('halcmd -f %s: %s' % (self.file, trouble))
        self.failed = trouble is not None
