# SPDX-License-Identifier: GPL-2.0-only
"""Leaks of all tests of pendants: must be the last of them."""

import glob
import os

from harness import BIND_TIME, TRACING, Plugged, hid_xhc, module_loaded, wait_for


def test_no_memory_is_left():
    hid_xhc.load()
    with Plugged() as pendant:
        pendant.flush()
        assert hid_xhc.allocations(), 'even of a plugged pendant no allocation is seen'
    wait_for(lambda: not hid_xhc.allocations(), 'end of what a pendant had', BIND_TIME)
    hid_xhc.unload()


def test_nothing_is_left_in_the_system():
    """Must be last."""
    assert not module_loaded('hid_xhc'), 'the module is still loaded'
    assert not os.path.exists(TRACING + '/events/xhc'), 'the tracepoints are still there'
    assert glob.glob('/sys/bus/hid/devices/*:10CE:*') == []
    assert not os.path.exists('/sys/bus/hid/drivers/hid-xhc')
