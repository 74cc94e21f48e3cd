# SPDX-License-Identifier: GPL-2.0-only
"""Each allocation fails once: in probe, a write to dro/, and insmod.

For n = 1, 2, 3, ... the n-th allocation of a call fails, until there is no n-th one; the call
either succeeds or fails cleanly. KASAN, lockdep and kmemleak are enabled, and at the end the driver
works as before.
"""

import os

import rig
from failslab import DRIVER_CORE, FAILSLAB, function_range, module_range, setup_failslab, walk
from hid_gadget import HidGadgetPendant
from rig import Case, pressed, read_file, released, write_file
from xhc_sim import find
from xhc_sim.uhid import UhidPendant

class FaultCase(Case):
    def plug_gadget(self, model='HB04'):
        """On USB by dummy_hcd and f_hid, which handle failed allocations.  vhci_hcd drops a URB for
        which it has no memory, so that its owner waits forever; raw_gadget stops working."""
        return self.plug_rig(rig.Rig(device=HidGadgetPendant(model)))


class TestWalk(FaultCase):
    def set_up(self):
        super().set_up()
        setup_failslab()

    def report(self, what, count, outcomes):
        print('    %s: %d allocations failed: %s' % (what, count, ', '.join(
            '%s %d' % item for item in sorted(outcomes.items()))))

    def works(self, pendant):
        pendant.count_frames_anew()
        pendant.look_again()
        pendant.report(1)
        self.assert_packet(pendant, pressed(1))
        pendant.asleep()
        pendant.packet()
        pendant.set('work_x', '1.5')
        assert float(pendant.flush()['work_x']) == 1.5

    def bind_walk(self, pendant, least):
        """The probe runs in the thread that writes to bind."""
        pendant.close_reader()
        pendant.unbind()
        bound = []

        def after(failure):
            has_driver = find.driver(pendant.path) == 'hid-xhc'
            assert has_driver == (failure is None), failure
            assert os.path.exists(pendant.path + '/dro') == has_driver
            if has_driver:
                bound.append(True)
                pendant.unbind()

        count, outcomes = walk(pendant.bind, after, DRIVER_CORE)
        self.report('bind', count, outcomes)
        assert count > least
        assert outcomes.get('ENOMEM', 0) > 10
        assert bound
        pendant.bind()
        pendant.wait_bound()
        self.works(pendant)

    def test_probe_uhid(self):
        self.bind_walk(self.plug('HB04'), 40)

    def test_probe_usb(self):
        self.bind_walk(self.plug_gadget('HB03'), 40)

    def test_create_uhid(self):
        """UHID_CREATE2 itself; the probe of this device runs in another thread, without faults."""
        device = UhidPendant('HB04')
        event, fds = device.create_event(), []

        def attempt():
            os.write(fds[-1], event)

        def after(failure):
            os.close(fds.pop())
            assert rig.wait(lambda: find.hid_directory(device.phys) is None)
            fds.append(os.open('/dev/uhid', os.O_RDWR))

        fds.append(os.open('/dev/uhid', os.O_RDWR))
        count, outcomes = walk(attempt, after)
        os.close(fds.pop())
        self.report('create', count, outcomes)
        assert count > 2
        self.works(self.plug())

    def test_unbind(self):
        """Removal must not require memory."""
        pendant = self.plug()
        pendant.close_reader()

        def after(failure):
            if failure is None:
                assert not os.path.exists(pendant.path + '/dro')
                pendant.bind()

        count, outcomes = walk(pendant.unbind, after)
        self.report('unbind', count, outcomes)
        pendant.wait_bound()
        self.works(pendant)

    def test_write(self):
        """A failed write changes nothing."""
        pendant = self.plug()
        values = {'position': ('1 2 3 4 5 6', '6 5 4 3 2 1'), 'work_x': ('7', '8'),
                  'feedrate': ('1', '2'), 'step': ('1', '5'), 'icon': ('1', '2'),
                  'state': ('run', 'pause'), 'day': ('1', '2'), 'refresh_ms': ('20', '30')}
        total = 0
        for name, (old, new) in values.items():
            pendant.set(name, old)

            def after(failure, name=name, old=old, new=new):
                assert pendant.get(name) == (old if failure else new)
                pendant.set(name, old)

            path = pendant.file(name)
            count, outcomes = walk(lambda path=path, new=new: write_file(path, new), after)
            self.report(name, count, outcomes)
            total += count
        assert total > len(values)
        self.works(pendant)

    def test_read(self):
        pendant = self.plug()
        for name in ('position', 'state', 'step_available', 'reports', 'awake'):
            good, path = pendant.get(name), pendant.file(name)

            def still_good(_failure, name=name, good=good):
                assert pendant.get(name) == good

            walk(lambda path=path: read_file(path), still_good)

    def test_flush(self):
        pendant = self.plug()
        path = pendant.file('flush')
        count, outcomes = walk(lambda: write_file(path, '1'), lambda failure: None)
        self.report('flush', count, outcomes)
        self.works(pendant)

    def test_insmod(self):
        """With a pendant plugged in, so that the init of the module also probes.

        Only allocations of init may fail: in load_module(), before it, the kernel warns if it
        cannot allocate the description of a tracepoint.
        """
        rig.unload()
        device = UhidPendant('HB04')
        device.plug()
        self.add_cleanup(device.unplug)
        path = rig.wait(lambda: find.hid_directory(device.phys))
        assert rig.wait(lambda: find.driver(path))

        def after(failure):
            assert rig.loaded() == (failure is None), failure
            if failure is None:
                rig.unload()

        setup_failslab(*function_range('do_init_module'))
        count, outcomes = walk(rig.load, after, DRIVER_CORE)
        setup_failslab()
        self.report('insmod', count, outcomes)
        assert count > 100
        rig.load()
        assert rig.wait(lambda: find.driver(path) == 'hid-xhc')

    def test_open_and_ioctl(self):
        pendant = self.plug()

        def attempt():
            os.close(os.open(pendant.event_node, os.O_RDONLY))
            os.close(os.open(pendant.hidraw_node, os.O_RDWR))

        walk(attempt, lambda failure: None)
        self.works(pendant)


class TestWorker(FaultCase):
    """Allocations called from the driver fail at random, in any thread."""

    def set_up(self):
        super().set_up()
        self.add_cleanup(setup_failslab)

    def frames(self, pendant):
        setup_failslab(*module_range(rig.MODULE))
        write_file(FAILSLAB + 'probability', '5')
        results = [pendant.set_error('flush', '1') for _ in range(60)]
        setup_failslab()
        failed = len(results) - results.count(None)
        print('    %d of %d frames failed' % (failed, len(results)))
        assert failed > 5
        assert results.count(None) > 1
        assert pendant.stat('frame_errors') >= failed
        pendant.count_frames_anew()
        pendant.set('work_x', '1')
        assert pendant.flush()['work_x'] == '1.0000'

    def test_frames_uhid(self):
        self.frames(self.plug())

    def test_frames_usb(self):
        self.frames(self.plug_gadget())

    def test_events(self):
        """Reports require no memory."""
        pendant = self.plug()
        setup_failslab(*module_range(rig.MODULE))
        write_file(FAILSLAB + 'probability', '100')
        for code in range(1, 0x18):
            pendant.report(code)
            self.assert_packet(pendant, (released(code - 1) if code > 1 else []) + pressed(code))
        setup_failslab()
