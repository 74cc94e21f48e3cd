# SPDX-License-Identifier: GPL-2.0-only
"""Fixtures for tests in guests."""

import contextlib
import pathlib

import pytest

pytest.register_assert_rewrite('harness', 'permissions', 'serial_head', 'typed_document',
                               'virtual_head')

from serial_head import PORTS, SerialHead  # noqa: E402


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """All tests in this folder have the mark `distro`."""
    for item in items:
        if item.path.parent == pathlib.Path(__file__).parent:
            item.add_marker('distro')


@pytest.fixture(params=PORTS)
def port(request):
    """The 8250, then the FTDI adapter"""
    return request.param


@pytest.fixture
def attach():
    """attach(port, **settings) -> a SerialHead, which is detached after the test"""
    with contextlib.ExitStack() as stack:
        def make(port, **settings):
            head = SerialHead(port, **settings)
            stack.callback(head.close)
            head.plug()
            head.attach()
            return head

        yield make
