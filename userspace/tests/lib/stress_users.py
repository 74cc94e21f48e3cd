# SPDX-License-Identifier: GPL-2.0-only
"""Threads that use a device from all sides while a test takes it away."""

import random
import termios
import threading
import time

from kernel import wait


class StressUsers:
    """Threads, each of which repeats one action, a function of a random.Random, until the end.

    done: {name of an action: how often it has succeeded}
    unexpected: anything but success and the errors in `tolerated`
    """

    def __init__(self, actions, tolerated, pause, seed=0):
        self.tolerated = tolerated
        self.pause = pause          # seconds between two turns of a thread: there is one processor
        self.seed = seed
        self.stop = threading.Event()
        self.done = {action.__name__: 0 for action in actions}
        self.unexpected = []
        self.threads = [threading.Thread(target=self._run, args=(action,), daemon=True,
                                         name=action.__name__) for action in actions]

    def _run(self, action):
        name = action.__name__
        dice = random.Random('%s %s' % (self.seed, name))
        while not self.stop.is_set():
            try:
                action(dice)
                self.done[name] += 1
            except (OSError, termios.error) as error:
                if error.args[0] not in self.tolerated:        # its number
                    self.unexpected.append('%s: %s' % (name, error))
            except Exception as error:
                self.unexpected.append('%s: %r' % (name, error))
            time.sleep(self.pause)

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.stop.set()
        for thread in self.threads:
            thread.join(60)
            if thread.is_alive():
                self.unexpected.append('%s hangs' % thread.name)

    def all_done(self, least):
        """Whether each action has succeeded that often."""
        return min(self.done.values()) >= least

    def wait_done(self, least, timeout):
        """Waits until it has. -> whether it has"""
        return wait(lambda: self.all_done(least), timeout)

    def __str__(self):
        return ', '.join('%s %d' % item for item in sorted(self.done.items()))
