# SPDX-License-Identifier: GPL-2.0-only
"""Plugs and unplugs at any time, hundreds of times, during all kinds of operations.

The verdict checks for errors: no report of KASAN, lockdep or any other checker, no leak. The tests
themselves only check that the operations took place, and that all works afterwards. Debian's
kernels run it in a guest with two processors, where a pendant on USB is a gadget: vhci_hcd is not
safe there. vhci_urb_dequeue() reads urb->hcpriv->vdev under vhci->lock, and the
thread that receives an answer frees it under vdev->priv_lock only (drivers/usb/usbip of 6.12).
"""

import glob
import os
import random
import subprocess
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from driven import MODELS
import rig
from hid_gadget import HidGadgetPendant, load_controllers
from raw_gadget import GadgetPendant
from rig import Case
from xhc_sim import find
from xhc_sim.uhid import UhidPendant
from xhc_sim.usb import UsbPendant

HID_GLOB = '/sys/bus/hid/devices/0003:10CE:EB*'
WRITES = (('work_x', '-220.334'), ('work_x', '1'), ('position', '1 2 3 4 5 6'), ('state', 'run'),
          ('state', 'idle'), ('feedrate', '1000'), ('step', '100'), ('step', '1'), ('icon', '3'),
          ('day', '5'), ('day', 'auto'), ('refresh_ms', '10'), ('flush', '1'))
PAUSE = 0.004               # seconds between two actions of a thread, on one CPU
READS = ('dro/position', 'dro/state', 'stats/reports', 'awake', 'model')


# an emulated machine is slower
ROUNDS = {'uhid': 80, 'gadget': 30, 'module': 15} if rig.IN_DISTRO else {
    'uhid': 300, 'usb': 120, 'gadget': 60, 'module': 50}
LEAST = 3 if rig.IN_DISTRO else 20      # frames, and actions of each user


class StressUsers:
    """Threads that use all interfaces of any pendant present.

    counts      numbers of actions, and of frames received meanwhile, see add_frames()
    """

    def __init__(self, seed):
        self.dice = random.Random(seed)
        self.stop = threading.Event()
        self.lock = threading.Lock()
        self.counts = dict.fromkeys(('writes', 'reads', 'events', 'nodes', 'frames'), 0)
        self.threads = [threading.Thread(target=self._run, args=(work,), daemon=True)
                        for work in (self._write, self._read, self._listen)]

    def __enter__(self):
        for thread in self.threads:
            thread.start()
        return self

    def __exit__(self, *_):
        self.stop.set()
        for thread in self.threads:
            thread.join(rig.PATIENCE)
        assert not any(thread.is_alive() for thread in self.threads), 'a user hangs'

    def add_frames(self, count):
        with self.lock:
            self.counts['frames'] += count

    def have_done(self, *names):
        """Whether there were enough of each action; of all actions, without names"""
        return all(self.counts[name] > LEAST for name in names or self.counts)

    def rounds(self, number, *names):
        """Runs this number of rounds; up to ten times as many, until there were enough actions."""
        for done in range(10 * number):
            if done >= number and self.have_done(*names):
                return
            yield done

    def _run(self, work):
        while not self.stop.is_set():
            pendants = glob.glob(HID_GLOB)
            if pendants:
                try:
                    work(self.dice.choice(pendants))
                except OSError:
                    pass                    # removed, as intended
            time.sleep(PAUSE)

    def _write(self, path):
        name, text = self.dice.choice(WRITES)
        rig.write_file('%s/dro/%s' % (path, name), text)
        self.counts['writes'] += 1

    def _read(self, path):
        rig.read_file('%s/%s' % (path, self.dice.choice(READS)))
        self.counts['reads'] += 1

    def _listen(self, path):
        event, raw = find.nodes(path)
        opened = []
        try:
            for node in (event, raw):
                if node:
                    opened.append(os.open(node, os.O_RDONLY | os.O_NONBLOCK))
                    self.counts['nodes'] += 1
            for _ in range(10):
                try:
                    self.counts['events'] += len(os.read(opened[0], 24 * 64)) // 24
                except BlockingIOError:
                    pass                # no frame yet
                time.sleep(PAUSE)
        except IndexError:
            pass
        finally:
            for fd in opened:
                os.close(fd)


def shake(device, dice, seconds):
    """Sends reports until the timeout, or until the device is removed."""
    end = time.monotonic() + seconds
    while device.plugged and time.monotonic() < end:
        try:
            device.report(bytes([4, dice.randrange(0x1A), dice.randrange(0x1A),
                                 dice.choice([0, 0x11, 0x12, 0x14, 0x18, 0x33]),
                                 dice.randrange(256), dice.randrange(256)]))
        except OSError:
            return
        time.sleep(0.002)


LIFE = 5 if rig.IN_DISTRO else 1        # seconds after which a pendant must have shown a frame
FAULTS = ('none', 'none', 'none', 'stall', 'timeout', 'slow:5', 'unplug')


@pytest.mark.timeout(600)
class TestStorm(Case):
    def cycles(self, make, users, seed, number, longest):
        """Plugs in and unplugs the pendants of make(dice), at least `number` times."""
        dice = random.Random(seed)
        for _ in users.rounds(number):
            device = make(dice)
            device.set_fault(dice.choice(FAULTS), skip=dice.randrange(14))
            device.plug()
            if dice.random() < 0.5:             # half of them show a frame
                device.wait_for(lambda: device.frame_count or not device.plugged, LIFE)
            shake(device, dice, dice.random() * longest)
            dice.choice([device.unplug, device.detach, getattr(device, 'crash', device.unplug)])()
            users.add_frames(device.frame_count)

    def calm(self):
        """Checks the state afterwards: no device is left, and a new pendant works."""
        assert rig.wait(lambda: not glob.glob(HID_GLOB))
        pendant = self.plug_rig(rig.Rig(device=UhidPendant('HB04')))
        pendant.report(1)
        self.assert_packet(pendant, rig.pressed(1))
        pendant.report()
        self.assert_packet(pendant, rig.released(1))
        pendant.look_again()
        assert pendant.reader.keys_down() == []
        pendant.set('work_x', '1')
        assert pendant.flush()['work_x'] == '1.0000'
        pendant.unplug()

    def storm(self, make, threads, number, longest, seed):
        """Plugs `number` pendants by several threads; make(dice, number of thread) creates one."""
        def work(which):
            self.cycles(lambda dice: make(dice, which), users, seed + which, number // threads,
                        longest)

        with StressUsers(seed) as users, ThreadPoolExecutor(threads) as workers:
            list(workers.map(work, range(threads)))
        print('    ' + ', '.join('%d %s' % (count, what) for what, count in users.counts.items()))
        assert users.have_done(), users.counts
        self.calm()

    def test_uhid_one_after_the_other(self):
        self.storm(lambda dice, _: UhidPendant(dice.choice(list(MODELS))), 1, ROUNDS['uhid'], 0.06,
                   100)

    @pytest.mark.distro
    def test_uhid_four_at_once(self):
        self.storm(lambda dice, _: UhidPendant(dice.choice(list(MODELS))), 4, ROUNDS['uhid'], 0.10,
                   200)

    def test_usb(self):
        self.storm(lambda dice, _: UsbPendant(dice.choice(list(MODELS))), 2, ROUNDS['usb'], 0.3,
                   300)

    @pytest.mark.distro
    def test_hid_gadget(self):
        """Each of two pendants is unplugged and plugged in again, with transfers in flight."""
        def make(_, which):
            device = HidGadgetPendant(('HB03', 'HB04')[which])
            device.set_fault = lambda *_, **__: None        # it answers or is removed
            return device

        if rig.IN_DISTRO:
            load_controllers()
        self.storm(make, 2, ROUNDS['gadget'], 0.3, 800)

    def test_raw_gadget(self):
        def make(dice):
            device = GadgetPendant(dice.choice(list(MODELS)))
            device.set_fault = lambda *_, **__: None        # it answers or is removed
            return device
        with StressUsers(400) as users:
            dice = random.Random(400)
            for _ in users.rounds(25, 'writes', 'frames'):
                device = make(dice)
                device.plug()
                if device.configured.wait(5):
                    # report() waits for the host: it must not hang when the pendant is unplugged
                    for _ in range(dice.randrange(20)):
                        device.report(bytes([4, 1, 0, 0x11, 1, 0]))
                    if dice.random() < 0.7:
                        device.wait_frames(1, 3)
                    time.sleep(dice.random() * 0.1)
                device.unplug()
                users.add_frames(device.frame_count)
        assert users.have_done('writes', 'frames')
        self.calm()


@pytest.mark.timeout(600)
class TestDriver(Case):
    """The driver is loaded and unloaded, the pendant stays plugged in."""

    def around(self, go, come, number, seed):
        if rig.IN_DISTRO:
            load_controllers()
        device = HidGadgetPendant() if rig.IN_DISTRO else UhidPendant('HB04')
        pendant = self.plug_rig(rig.Rig(device=device))
        name = os.path.basename(pendant.path)
        stop, dice = threading.Event(), random.Random(seed)

        def shake_on():
            while not stop.is_set():
                shake(pendant.device, dice, 0.1)

        shaker = threading.Thread(target=shake_on)
        shaker.start()
        try:
            with StressUsers(seed) as users:
                for _ in users.rounds(number, 'writes', 'frames'):
                    frames = pendant.device.frame_count
                    time.sleep(dice.random() * LIFE / 30)
                    go(name)
                    come(name)
                    users.add_frames(pendant.device.frame_count - frames)
        finally:
            stop.set()
            shaker.join(rig.PATIENCE)
        assert users.have_done('writes', 'frames')
        pendant.wait_bound()
        pendant.asleep()
        pendant.set('work_y', '1')
        pendant.set('flush', '1')
        # frames of earlier drivers may still be pending: their number is not known
        assert pendant.shows('work_y', '1.0000')
        pendant.unplug()

    def test_bound_and_unbound(self):
        self.around(lambda name: rig.write_file(rig.DRIVER_DIR + '/unbind', name),
                    lambda name: rig.write_file(rig.DRIVER_DIR + '/bind', name), 150, 500)

    @pytest.mark.distro
    def test_loaded_and_unloaded(self):
        self.around(lambda _: self.unload(), lambda _: rig.load(), ROUNDS['module'], 600)

    @staticmethod
    def unload():
        """Readers may use the module for a moment. Does not wait for pending events of udevd."""
        def once():
            try:
                rig.unload()
                return True
            except OSError:
                return False

        if rig.IN_DISTRO:
            subprocess.run(['modprobe', '-r', rig.MODULE], check=True)
        else:
            assert rig.wait(once), 'the module does not unload'
