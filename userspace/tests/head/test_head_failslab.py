# SPDX-License-Identifier: GPL-2.0-only
"""Each allocation fails once: in attach, detach, open, the attributes and insmod.

For n = 1, 2, 3, ... the n-th allocation of a call fails, until there is no n-th one; the call
either succeeds or fails cleanly. KASAN, lockdep and kmemleak are enabled, and at the end the driver
works as before.
"""

import os

import head_rig
import kernel
from failslab import DRIVER_CORE, FAILSLAB, function_range, module_range, setup_failslab, walk
from head_rig import LDISC, N_TTY, Case, Pty, get_speed, heads, set_ldisc, set_speed, wait
from kernel import read_file, write_file
from xy3_head_sim import wire


class TestWalk(Case):
    def set_up(self):
        super().set_up()
        setup_failslab()

    def report(self, what, count, outcomes):
        print('    %s: %d allocations failed: %s' % (what, count, ', '.join(
            '%s %d' % item for item in sorted(outcomes.items()))))

    def works(self, head):
        """Checks that everything works without faults."""
        reader = head.open()
        head.send(head_rig.GOOD + wire.vendor('ACME') + wire.temperatures([2500]))
        assert reader.take(18) == head_rig.GOOD + wire.vendor('ACME') + wire.temperatures([2500])
        assert head.get('vendor') == 'ACME'
        assert wait(lambda: head.hwmon().get('temp1_input') == '25000')
        reader.close()

    def test_attach(self):
        uart = self.closing(Pty())
        attached = []

        def after(failure):
            assert len(heads()) == int(failure is None), failure
            assert os.path.exists('/dev/xy3-0') == (failure is None)
            if failure is None:
                attached.append(True)
                set_ldisc(uart.slave, N_TTY)
            else:                               # still the former tty
                os.write(uart.slave, b'x')
                assert os.read(uart.master, 9) == b'x'

        count, outcomes = walk(lambda: set_ldisc(uart.slave, LDISC), after, DRIVER_CORE)
        self.report('attach', count, outcomes)
        assert count > 100
        assert outcomes.get('ENOMEM', 0) > 50
        assert attached
        self.works(self.attach(uart))

    def test_detach(self):
        """Removal must not require memory."""
        head = self.synced()
        head.send(wire.temperatures([2500]))
        assert wait(head.hwmon)

        def after(failure):
            assert failure is None
            assert head.gone()
            head.attach()

        count, outcomes = walk(head.detach, after)
        self.report('detach', count, outcomes)
        self.works(head)

    def test_hangup(self):
        """The same, with a reader, so that the tty of the head is hung up."""
        ends = []

        def attempt():
            ends[-1][0].uart.cut()

        def begin():
            head = self.attach()
            ends.append((head, head.open()))

        def after(failure):
            assert failure is None
            head, reader = ends.pop()
            assert reader.read() == b''
            head.close()
            begin()

        begin()
        count, outcomes = walk(attempt, after)
        self.report('hangup', count, outcomes)
        self.works(ends[-1][0])

    def test_open_and_speed(self):
        head = self.synced()

        def attempt():
            fd = os.open(head.node, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                set_speed(fd, 230400 if get_speed(fd) == 115200 else 115200)
            finally:
                os.close(fd)

        count, outcomes = walk(attempt, lambda failure: None)
        self.report('open', count, outcomes)
        assert outcomes.get('ENOMEM', 0) > 1
        self.works(head)

    def test_write_to_the_tty(self):
        head = self.synced()
        frame = wire.command_frame('calibrate')
        errors = set()

        def attempt():
            fd = os.open(head.node, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            try:
                errors.add(head_rig.error_name(os.write, fd, frame))
            finally:
                os.close(fd)

        count, outcomes = walk(attempt, lambda failure: None)
        self.report('write', count, outcomes)
        assert 'ENODEV' in errors
        assert errors <= {'ENODEV', 'ENOMEM'}
        self.works(head)

    def test_attributes(self):
        """A failed write changes nothing, and a failed read succeeds on retry."""
        head = self.synced()
        head.send(wire.vendor('ACME') + wire.errors([1]) + wire.hours([5]))
        total = 0
        for name, old, new in (('rate', '115200', '230400'), ('autobaud', '0', '1'),
                               ('byte_order', 'little', 'big')):
            head.set(name, old)

            def after(failure, name=name, old=old, new=new):
                assert head.get(name) == (old if failure else new)
                head.set(name, old)

            path = '%s/%s' % (head.path, name)
            count, outcomes = walk(lambda path=path, new=new: write_file(path, new), after)
            self.report(name, count, outcomes)
            total += count
        assert total > 3
        for name in ('vendor', 'errors/head', 'stats/rx_bytes', 'in_sync'):
            good, path = head.get(name), '%s/%s' % (head.path, name)

            def still_good(_failure, name=name, good=good):
                assert head.get(name) == good

            walk(lambda path=path: read_file(path), still_good)
        self.works(head)

    def test_insmod(self):
        """Only allocations of init may fail: in load_module(), before it, the kernel warns if it
        cannot allocate the description of a tracepoint.
        """
        head_rig.unload()

        def after(failure):
            assert kernel.is_loaded(head_rig.MODULE) == (failure is None), failure
            assert os.path.isdir(head_rig.CLASS) == (failure is None)
            for path in ('/proc/tty/drivers', '/proc/tty/ldiscs'):
                assert ('xy3' in read_file(path)) == (failure is None), path
            if failure is None:
                head_rig.unload()

        setup_failslab(*function_range('do_init_module'))
        count, outcomes = walk(head_rig.load, after, DRIVER_CORE)
        setup_failslab()
        self.report('insmod', count, outcomes)
        assert count > 20
        assert outcomes.get('ENOMEM', 0) > 10
        head_rig.load()
        self.works(self.attach())


class TestWorker(Case):
    """Allocations called from the driver fail at random, in any thread."""

    def set_up(self):
        super().set_up()
        setup_failslab()
        self.add_cleanup(setup_failslab)

    def fail_allocations(self, percent):
        setup_failslab(*module_range(head_rig.MODULE))
        write_file(FAILSLAB + 'probability', '%d' % percent)

    def test_telemetry(self):
        """The state requires no memory; a hwmon device that was not created is created later.

        A failure to create it is logged once, though many follow.
        """
        head = self.synced()
        reader = head.open()
        log = self.closing(kernel.KernelLog())
        refused = 0
        for number in range(1, 23):
            self.fail_allocations(20)
            sent = (wire.vendor('%03d' % number) + wire.errors([number]) +
                    wire.temperatures([100 * number] * number))
            head.send(sent)
            kernel.wait(lambda: False, 0.15)
            setup_failslab()
            assert head.get('vendor') == '%03d' % number
            assert head.get('errors/head') == wire.error_name(number)
            shown = head.hwmon()
            refused += 'temp%d_input' % number not in shown
        assert refused > 1
        assert sum('no hwmon device' in line for line in log.lines()) <= 1
        head.send(wire.vendor('news'))
        assert wait(lambda: 'temp22_input' in head.hwmon())
        assert head.hwmon()['temp22_input'] == '22000'
        # packets without memory for the reader are lost completely, and counted
        got = head_rig.split(reader.rest())
        assert len(got) + head.stat('lost_packets') == 22 * 3 + 1
        assert got[-1] == wire.vendor('news')

    def test_packets(self):
        """Without any memory for the reader all packets are counted as lost."""
        head = self.synced()
        reader = head.open()
        self.fail_allocations(100)
        sent = wire.debug('x' * 200) * 500
        head.send(sent)
        setup_failslab()
        lost = head.stat('lost_packets')
        assert lost > 400
        got = head_rig.split(reader.rest())
        assert len(got) + lost == 500
        assert head.stat('rx_packets') == 502
        head.send(wire.debug('again'))
        assert reader.rest() == wire.debug('again')
