# SPDX-License-Identifier: GPL-2.0-only
"""The rate of the backchannel: setting, display and search."""

import termios
import threading
import time

import pytest

import head_rig
from acm_cable import AcmCable
from head_rig import Background, Case, get_speed, set_speed, wait
from xy3_head_sim import wire


class TestRates(Case):
    def shown(self, head, rate):
        """Checks the rate at all three places."""
        reader = head.open()
        ok = wait(lambda: (head.get('rate'), get_speed(head.uart.slave), get_speed(reader.fd)) ==
                  (str(rate), rate, rate))
        reader.close()
        return ok

    def test_attribute(self):
        head = self.synced()
        for rate in (*wire.RATES, *reversed(wire.RATES), 115200):
            assert head.set('rate', '%d\n' % rate) is None
            assert self.shown(head, rate), rate
        for text in ('9600', '0', '115201', '-1', 'fast', '\n', '4294967296', '115200 8'):
            assert head.set('rate', text) in ('EINVAL', 'ERANGE'), text
            assert self.shown(head, 115200), text

    def test_upper_stty(self):
        head = self.synced()
        reader = head.open()
        for rate in (*wire.RATES, *reversed(wire.RATES)):
            status, text = head_rig.run('stty', '-F', head.node, str(rate))
            assert (status, text) == (0, '')
            assert self.shown(head, rate), rate
            assert head_rig.run('stty', '-F', head.node, 'speed') == (0, '%d\n' % rate)
        for rate in ('9600', '38400', '1000000', '0'):
            status, text = head_rig.run('stty', '-F', head.node, rate)
            assert status == 1, rate
            assert 'unable to perform all requested operations' in text
            assert self.shown(head, 57600), rate
        reader.close()

    def test_lower_stty(self):
        head = self.synced()
        reader = head.open()
        for rate in (*reversed(wire.RATES), 9600, 115200):
            status, _ = head_rig.run('stty', '-F', head.uart.node, str(rate))
            assert status == 0
            assert self.shown(head, rate), rate
        reader.close()

    @pytest.mark.parametrize('rate', (57600, 921600, 9600))
    def test_attached_at_another_rate(self, rate):
        assert self.shown(self.attach(rate=rate), rate)

    def test_sync_is_lost(self):
        """Data at another rate are another stream; an incomplete packet is lost."""
        head = self.synced()
        head.send(wire.vendor('ACME')[:4])
        head.set('rate', '230400')
        assert head.get('in_sync') == '0'
        assert head.stat('dropped_bytes') == 4
        head.sync()
        head.set('rate', '230400')              # no change
        assert head.get('in_sync') == '1'

    def test_on_usb(self):
        """The rate is set in the UART (CDC SET_LINE_CODING)."""
        cable = self.closing(AcmCable())
        head = self.attach(cable)
        for rate in wire.RATES:
            assert head.set('rate', str(rate)) is None
            assert self.shown(head, rate), rate
        head.sync()
        cable.unplug()
        assert head.gone()

    def test_all_at_once(self):
        """After changes in three ways at the same time all places have the same rate."""
        head = self.synced()
        reader = head.open()

        def work(change):
            for number in range(60):
                try:
                    change(wire.RATES[number * 7 % 5])
                except termios.error:
                    pass                        # changed by another thread

        ways = (lambda rate: head.set('rate', str(rate)),
                lambda rate: set_speed(reader.fd, rate),
                lambda rate: set_speed(head.uart.slave, rate))
        for thread in [Background(work, way) for way in ways]:
            thread.result()
        assert wait(lambda: self.shown(head, get_speed(head.uart.slave)))
        head.set('rate', '460800')
        assert self.shown(head, 460800)


class Peer:
    """A scanhead at one rate: at any other rate the host receives garbage."""

    GARBAGE = bytes(range(0x80, 0xC0))

    def __init__(self, uart, rate, pause=0.05):
        self.uart, self.rate, self.pause = uart, rate, pause
        self.host_rates = []            # rates of the host, in order
        self.sent = dict.fromkeys(wire.RATES, 0)        # bytes sent at each
        self.stop = threading.Event()
        self.thread = Background(self._run)

    def _run(self):
        while not self.stop.is_set():
            rate = get_speed(self.uart.slave)
            if self.host_rates[-1:] != [rate]:
                self.host_rates.append(rate)
            data = (wire.sync() * 2 + wire.vendor('ACME') if rate == self.rate
                    else self.GARBAGE)
            self.uart.write(data)
            self.sent[rate] += len(data)
            time.sleep(self.pause)

    def close(self):
        self.stop.set()
        self.thread.result()


class TestAutobaud(Case):
    def found(self, head, rate, timeout=30):
        return wait(lambda: head.get('in_sync') == '1' and head.get('rate') == str(rate), timeout,
                    0.05)

    @pytest.mark.parametrize('rate', wire.RATES)
    def test_every_rate(self, rate):
        head = self.attach()
        assert head.set('autobaud', '1') is None
        peer = self.closing(Peer(head.uart, rate))
        assert self.found(head, rate)
        peer.close()
        assert get_speed(head.uart.slave) == rate
        assert peer.host_rates[0] == 115200     # the search starts at the current rate

    def test_a_head_that_sends_rarely(self):
        """Sync every two seconds: each round of the search waits longer."""
        head = self.attach()
        head.set('autobaud', '1')
        self.closing(Peer(head.uart, 921600, 2))
        assert self.found(head, 921600, 120)

    def test_a_loud_head_is_found_sooner(self):
        """1 KiB without sync is sufficient, even before half a second has passed."""
        head = self.attach()
        head.set('autobaud', '1')
        peer = self.closing(Peer(head.uart, 57600, 0.001))
        assert self.found(head, 57600)
        assert len(peer.host_rates) <= 6
        for rate in (230400, 460800, 921600):
            assert peer.sent[rate] > 500
            assert peer.sent[rate] < 6000

    def test_off(self):
        head = self.attach()
        peer = self.closing(Peer(head.uart, 57600))
        time.sleep(10)
        assert (peer.host_rates, head.get('rate')) == ([115200], '115200')
        head.set('autobaud', '1')
        assert self.found(head, 57600)
        for text, error in (('2', 'EINVAL'), ('maybe', 'EINVAL'), ('\n', 'EINVAL'), ('off', None)):
            assert head.set('autobaud', text) == error
        assert head.get('autobaud') == '0'

    def test_the_head_changes_its_rate(self):
        head = self.attach()
        head.set('autobaud', '1')
        peer = self.closing(Peer(head.uart, 230400))
        assert self.found(head, 230400)
        time.sleep(10)
        assert head.get('rate') == '230400'        # no search while in sync
        peer.rate = 460800
        assert self.found(head, 460800)

    def test_silence(self):
        """Without a head it continues from rate to rate, waiting longer in each round."""
        head = self.attach()
        head.set('autobaud', '1')
        seen = []
        for _ in range(600):
            time.sleep(0.1)
            if seen[-1:] != [head.get('rate')]:
                seen.append(head.get('rate'))
        assert set(seen) == set(map(str, wire.RATES))
        assert len(seen) > 10
        assert len(seen) < 50          # 120 if each rate took half a second
