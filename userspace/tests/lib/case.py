# SPDX-License-Identifier: GPL-2.0-only
"""A base class for tests with their own fixtures."""

import contextlib

import pytest



class Case:
    """Functions of add_cleanup() run after a test, the last first, even if set_up() fails."""

    @pytest.fixture(autouse=True)
    def _life(self):
        with contextlib.ExitStack() as self._cleanups:
            self.set_up()
            yield

    def set_up(self):
        """Runs before each test; for classes to extend."""

    def add_cleanup(self, function, *arguments, **keywords):
        self._cleanups.callback(function, *arguments, **keywords)


@contextlib.contextmanager
def row(*what, **named):
    """One row of a table that a test iterates over with one device; a failure names the row."""
    try:
        yield
    except AssertionError as error:
        words = [str(word) for word in what] + ['%s=%r' % item for item in named.items()]
        raise AssertionError('%s: %s' % (', '.join(words), error)) from error
