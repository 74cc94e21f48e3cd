# SPDX-License-Identifier: GPL-2.0-only
"""The example that jogs a machine through bCNC, with an HTTP server that answers like bCNC."""

import contextlib
import http.server
import json
import os
import sys
import threading
import urllib.error
import urllib.parse

import pytest

HERE = os.path.dirname(os.path.realpath(__file__))
sys.path.insert(0, os.path.join(HERE, '..', '..', 'examples'))

import pendant_bcnc  # noqa: E402 (needs the path)


class Handler(http.server.BaseHTTPRequestHandler):
    """GET /state and /send of bCNC's Pendant.py"""

    def do_GET(self):
        page, _, query = self.path.partition('?')
        self.send_response(200)
        self.end_headers()
        if page == '/state':
            self.wfile.write(json.dumps({'controller': 'GRBL1', 'state': self.server.state,
                                         'wx': 0.0}).encode())
        elif page == '/send':
            self.server.sent += urllib.parse.parse_qsl(query)

    def log_message(self, *_):
        pass


@pytest.fixture
def bcnc():
    server = http.server.HTTPServer(('127.0.0.1', 0), Handler)
    server.state, server.sent = 'Idle', []
    server.url = 'http://127.0.0.1:%d' % server.server_port
    thread = threading.Thread(target=server.serve_forever, args=(0.01,))
    thread.start()
    yield server
    server.shutdown()
    thread.join()
    server.server_close()


class Clock:
    now = 100.0

    def __call__(self):
        return self.now


def jogger(bcnc, model='HB04'):
    """Starts at 1000 s, so that the machine has time for each step of a test"""
    result = pendant_bcnc.Jogger(model, pendant_bcnc.Bcnc(bcnc.url), Clock())
    bcnc.sent.clear()
    return result


def act(one, *actions):
    for action in actions:
        one.clock.now += 1000
        one.act(*action)


def jogs(bcnc):
    assert {what for what, _ in bcnc.sent} <= {'gcode'}
    return [line for _, line in bcnc.sent]


def test_wheel(bcnc):
    act(jogger(bcnc), ('selector', 'X'), ('wheel', 3), ('selector', 'Z'), ('wheel', -1))
    assert jogs(bcnc) == ['$J=G91 G21 X0.030 F1000', '$J=G91 G21 Z-0.010 F1000']


def test_nothing_moves(bcnc):
    """With the selector off or at an override, before it is known, and without a step"""
    act(jogger(bcnc), ('wheel', 1), ('selector', 'off'), ('wheel', 1), ('selector', 'feed'),
        ('wheel', 1), ('selector', 'spindle'), ('wheel', 1))
    act(jogger(bcnc, 'HB03'), ('selector', 'X'), ('selector', 'A'), ('wheel', 1))    # a speed
    act(jogger(bcnc, 'WHB04B'), ('selector', 'X'), ('rotary', 0), ('wheel', 1), ('rotary', 5),
        ('wheel', 1), ('rotary', 7), ('wheel', 1))
    assert bcnc.sent == []


@pytest.mark.parametrize('state', ('Run', 'Hold:0', 'Alarm', 'Home', 'Not connected'))
def test_no_jog_while_the_controller_is_busy(bcnc, state):
    one = jogger(bcnc)
    bcnc.state = state
    act(one, ('selector', 'X'), ('wheel', 1))
    assert bcnc.sent == []
    bcnc.state = 'Jog'
    act(one, ('wheel', 1))
    assert jogs(bcnc) == ['$J=G91 G21 X0.010 F1000']


def test_wheel_that_is_too_fast(bcnc):
    """Moves are limited to what the machine completes within the allowed lag."""
    one = jogger(bcnc)
    act(one, ('selector', 'X'), ('press', 0x0D), ('press', 0x0D))       # 1 mm, 0.06 s
    for _ in range(100):
        one.act('wheel', 1)
    assert len(jogs(bcnc)) == 1 + int(pendant_bcnc.LAG / 0.06)
    one.clock.now += 0.061
    one.act('wheel', 1)
    assert len(jogs(bcnc)) == 2 + int(pendant_bcnc.LAG / 0.06)


def test_step_buttons(bcnc):
    act(jogger(bcnc), ('selector', 'Y'), ('press', 0x0D), ('wheel', 1), ('press', 0x0D),
        ('wheel', 1), ('press', 0x0D), ('wheel', 1))
    assert [line.split()[2] for line in jogs(bcnc)] == ['Y0.100', 'Y1.000', 'Y0.010']
    act(jogger(bcnc, 'HB03'), ('selector', 'Y'), ('press', 0x0E), ('wheel', 1), ('press', 0x0D),
        ('wheel', 1))
    assert [line.split()[2] for line in jogs(bcnc)] == ['Y0.100', 'Y0.010']


def test_rotary(bcnc):
    act(jogger(bcnc, 'WHB04B'), ('selector', 'A'),
        *(action for value in (1, 2, 3, 4) for action in (('rotary', value), ('wheel', 1))))
    assert [line.split()[2] for line in jogs(bcnc)] == ['A0.001', 'A0.010', 'A0.100', 'A1.000']


@pytest.mark.parametrize('model, stop, pause', (('HB03', 0x01, 0x02), ('HB04', 0x16, 0x02),
                                                ('WHB04B', 0x02, 0x03)))
def test_commands(bcnc, model, stop, pause):
    """Also while a program runs; releasing a button has no effect."""
    bcnc.state = 'Run'
    one = jogger(bcnc, model)
    act(one, *((what, key) for key in (stop, pause) for what in ('press', 'release')))
    assert bcnc.sent == [('cmd', 'FEEDHOLD'), ('cmd', 'PAUSE')]


def test_no_bcnc(bcnc):
    """An error ends the program: it is not retried later."""
    one = jogger(bcnc)
    one.bcnc.url = 'http://127.0.0.1:1'
    act(one, ('selector', 'X'))
    with contextlib.ExitStack() as stack:
        stack.enter_context(pytest.raises(urllib.error.URLError))
        act(one, ('wheel', 1))
