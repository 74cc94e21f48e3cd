# SPDX-License-Identifier: GPL-2.0-only
"""Plugging and unplugging without waiting for anything, while others use the device.

For a guest with two processors. What is looked for are races: the verdict is mostly that of
the kernel's log, but keys must not stay down either.
"""

import os
import random
import threading
import time

from harness import BIND_TIME, Plugged, command, find, hid_xhc, wait_for
from xhc_sim.uhid import UhidPendant
from xhc_sim.usb import UsbPendant

UHID_ROUNDS = 80
USB_ROUNDS = 8          # vhci_hcd needs up to 5 s to give up a transfer whose device has gone
SEED = 4711


class Users:
    """Threads that write and read what they find of a pendant, whether it is there or not."""

    def __init__(self, device):
        self.device = device
        self.writes = 0
        self.reads = 0
        self.ended = threading.Event()
        self.threads = [threading.Thread(target=work, daemon=True)
                        for work in (self._write, self._flush, self._read)]

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        for thread in self.threads:
            thread.join(30)
        assert not any(thread.is_alive() for thread in self.threads), 'a user hangs'

    def wait_for_write(self):
        """Until the driver has taken one more value."""
        writes = self.writes
        wait_for(lambda: self.writes > writes, 'write into sysfs', BIND_TIME)

    def _directory(self):
        if not self.device.plugged:
            return None                 # before the first plug() it has no phys yet
        return find.hid_directory(self.device.phys)

    def _write(self):
        number = 0
        while not self.ended.is_set():
            directory = self._directory()
            number = (number + 1) % 1000
            for name in ('work_x', 'feedrate'):
                if directory and self._put(directory + '/dro/' + name, number):
                    self.writes += 1
            time.sleep(0.002)

    def _flush(self):
        while not self.ended.is_set():
            directory = self._directory()
            if directory:
                self._put(directory + '/dro/flush', 1)
            time.sleep(0.01)

    @staticmethod
    def _put(path, value):
        try:
            fd = os.open(path, os.O_WRONLY)
        except OSError:
            return False            # not there, or not any more
        try:
            os.write(fd, b'%d\n' % value)
            return True
        except OSError:
            return False
        finally:
            os.close(fd)

    def _read(self):
        while not self.ended.is_set():
            directory = self._directory()
            node = find.nodes(directory)[0] if directory else None
            try:
                fd = os.open(node or '/nowhere', os.O_RDONLY | os.O_NONBLOCK)
            except OSError:
                time.sleep(0.01)
                continue
            try:
                while not self.ended.is_set():
                    try:
                        self.reads += len(os.read(fd, 24 * 64)) // 24
                    except BlockingIOError:
                        time.sleep(0.002)
            except OSError:
                pass                # ENODEV: unplugged
            finally:
                os.close(fd)


def send_noise(device, chance):
    """Input reports at random."""
    try:
        for _ in range(chance.randrange(20)):
            device.report(bytes([4, chance.randrange(0x18), chance.randrange(0x18),
                                 chance.choice((0, 0x11, 0x12, 0x18)), chance.randrange(256), 0]))
    except OSError:
        pass                    # unplugged by a fault


def plug_and_unplug(device, rounds, fault, ways):
    """Every other time the driver has come to life before the pendant goes.

    fault   what happens to display requests in every third round
    ways    functions that unplug
    """
    chance = random.Random(SEED)
    hid_xhc.will_come()
    with Users(device) as users:
        for number in range(rounds):
            device.fault = 'none'
            device.plug()
            if number % 2 == 0:
                users.wait_for_write()
            send_noise(device, chance)
            time.sleep(chance.uniform(0, 0.1))
            if number % 3 == 0:
                device.set_fault(fault, skip=chance.randrange(8))
                send_noise(device, chance)
                time.sleep(0.1)
            chance.choice(ways)()
        print('# %d writes, %d events read' % (users.writes, users.reads))
    wait_for(lambda: find.hid_directory(device.phys) is None, 'end of the HID device', 20)


def test_uhid_plug_storm():
    command('modprobe', 'uhid')
    device = UhidPendant()
    plug_and_unplug(device, UHID_ROUNDS, 'timeout', (device.unplug, device.crash))


def test_usb_plug_storm():
    device = UsbPendant()
    plug_and_unplug(device, USB_ROUNDS, 'unplug', (device.unplug, device.detach))


def test_module_storm():
    """The driver goes and comes while the pendant is used and plugged."""
    chance = random.Random(SEED)
    usb = UsbPendant()
    usb.plug(timeout=30)
    with Users(usb) as users:
        for _ in range(15):
            users.wait_for_write()
            time.sleep(chance.uniform(0, 0.1))
            send_noise(usb, chance)
            command('modprobe', '-r', 'hid-xhc')
            hid_xhc.load()
    usb.unplug()
    wait_for(lambda: find.hid_directory(usb.phys) is None, 'end of the HID device', 20)


def test_keys_are_up_after_all():
    with Plugged() as pendant:
        pendant.usb.press(1)
        pendant.events.report()
        pendant.usb.release(1)
        assert pendant.events.report() == ['MSC_SCAN 1', 'BTN_TRIGGER_HAPPY1 0']
        assert [code.name for code, down in pressed(pendant) if down] == []


def pressed(pendant):
    device = pendant.events.device
    for kind, codes in device.evbits.items():
        if kind.name == 'EV_KEY':
            for code in codes:
                yield code, device.value[code]
