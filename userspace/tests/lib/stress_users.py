# SPDX-License-Identifier: GPL-2.0-only
"""Threads that use all interfaces of a device while a test removes it."""

import random
import termios
import threading
import time

from kernel import wait


class StressUsers:
    """Threads that each repeat one action, a function of a random.Random, until stopped.

    done: {name of an action: number of successes}
    unexpected: results other than success and the errors in `tolerated`
    """

    def __init__(self, actions, tolerated, pause, seed=0):
        self.tolerated = tolerated
        self.pause = pause          # seconds between two actions of a thread, on one CPU
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
                if error.args[0] not in self.tolerated:        # errno
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
        """Whether each action has succeeded that number of times."""
        return min(self.done.values()) >= least

    def wait_done(self, least, timeout):
        """Waits until it has, or for the timeout. -> whether it has"""
        return wait(lambda: self.all_done(least), timeout)

    def __str__(self):
        return ', '.join('%s %d' % item for item in sorted(self.done.items()))
