# SPDX-License-Identifier: GPL-2.0-only
"""The program xhc-sim as users run it, with the driver bound to its pendant."""

import glob
import json
import os
import pty
import select
import subprocess
import threading
import time

from case import row
import rig
from rig import Case, pressed, released, selected, turned, write_file
from xhc_sim import find

PROGRAM = os.path.join(rig.HERE, '..', '..', 'xhc-sim', 'xhc-sim')
HB04_GLOB = '/sys/bus/hid/devices/0003:10CE:EB70.*/dro'


def xhc_sim(*arguments, script='', on_pendant=None):
    """Runs a script; calls on_pendant(directory) once the driver is bound to the pendant.

    -> (exit status, output, errors)
    """
    process = subprocess.Popen([PROGRAM, *arguments], stdin=subprocess.PIPE, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if on_pendant:
        thread = threading.Thread(
            target=lambda: on_pendant(os.path.dirname(rig.wait(lambda: glob.glob(HB04_GLOB))[0])))
        thread.start()
    out, errors = process.communicate(script, timeout=60)
    if on_pendant:
        thread.join()
    return process.returncode, out, errors


class TestScript(Case):
    def test_display(self):
        """Values written to dro/ are found by "expect" and printed by "lcd"."""
        for bus in ((), ('--usb',)):
            with row(bus):
                status, out, errors = xhc_sim(
                    *bus, '--timeout', '8000', '--script', '-',
                    script='expect work_x -220.334\nexpect state run+inch\n'
                           'expect faults none\nlcd\n',
                    on_pendant=lambda path: (write_file(path + '/dro/state', 'run+inch'),
                                             write_file(path + '/dro/work_x', '-220.334')))
                assert (status, errors) == (0, '')
                assert '-220.3340' in out
                assert 'RUN INCH' in out
                assert rig.wait(lambda: not glob.glob(HB04_GLOB))

    def test_events(self):
        """Events of keys, selector and wheel of a script are reported in order.

        The reader signals to the script on the LCD when it is ready, and when it has read all.
        """
        packets = []

        def listen(path):
            node = rig.wait(lambda: find.nodes(path)[0])
            assert rig.wait(lambda: os.path.exists(node))
            reader = rig.EvdevReader(node)
            write_file(path + '/dro/feedrate', '1')
            packets.extend(reader.packet() for _ in range(7))
            write_file(path + '/dro/feedrate', '2')
            reader.close()

        script = ('expect feedrate 1\nkey Reset down\nselect x\nwheel +3\nkey Reset up\n'
                  'key stop press\nsleep\nexpect feedrate 2\n')
        status, _, errors = xhc_sim('--timeout', '30000', '--script', '-', on_pendant=listen,
                                    script=script)
        assert (status, errors) == (0, '')
        assert packets == [
            pressed(0x17), selected(0, 1), turned(3), released(0x17), pressed(0x16),
            released(0x16), selected(1, 0)]

    def test_json(self):
        status, out, errors = xhc_sim('--json', '--script', '-', script='expect frames 1\nlcd\n')
        assert (status, errors) == (0, '')
        lines = [json.loads(line) for line in out.splitlines()]
        assert [line['event'] for line in lines] == ['frame', 'lcd']
        assert lines[0]['lcd'] == lines[1]['lcd']
        assert lines[0]['lcd']['day'] == time.gmtime().tm_mday

    def test_cable_and_faults(self):
        status, _, errors = xhc_sim('--script', '-', '--timeout', '8000', script=(
            'expect frames 1\nunplug\nplug\nexpect frames 2\nunplug\nfault stall 2 1\nplug\n'
            'expect frames 3\n'))
        assert (status, errors) == (0, '')

    def test_model(self):
        status, out, errors = xhc_sim('--model', 'hb03', '--script', '-',
                                      script='expect frames 1\nexpect work_x 0\nlcd\n')
        assert (status, errors) == (0, '')
        assert 'HB03' in out

    def test_failure(self):
        status, _, errors = xhc_sim('--script', '-', '--timeout', '100',
                                    script='expect work_x 1\n')
        assert status == 1
        assert 'stdin:1: expect work_x 1: ' in errors

    def test_usage(self):
        assert xhc_sim('--script', '-', script='jump\n')[0] == 2
        assert xhc_sim()[0] == 2

    def test_no_uhid(self):
        """Renames /dev/uhid, which is simpler than hiding it in a mount namespace."""
        os.rename('/dev/uhid', '/dev/uhid.away')
        self.add_cleanup(os.rename, '/dev/uhid.away', '/dev/uhid')
        status, _, errors = xhc_sim('--script', '-', script='wait 1\n')
        assert (status, errors) == \
                         (3, 'xhc-sim: /dev/uhid: No such file or directory\n')


class TestTerminal(Case):
    def test_a_session(self):
        pid, master = pty.fork()
        if pid == 0:
            os.execv(PROGRAM, [PROGRAM])
        self.add_cleanup(os.close, master)
        seen = b''

        def read_until(text, timeout=rig.PATIENCE):
            nonlocal seen
            end = time.monotonic() + timeout
            while text not in seen and time.monotonic() < end:
                if select.select([master], [], [], 0.1)[0]:
                    try:
                        seen += os.read(master, 4096)
                    except OSError:
                        return
            assert text in seen

        read_until(b'driver hid-xhc')
        path = os.path.dirname(rig.wait(lambda: glob.glob(HB04_GLOB))[0])
        reader = rig.EvdevReader(find.nodes(path)[0])
        self.add_cleanup(reader.close)
        for typed, events in ((b'\x1b[C', turned(1)), (b'\x1b[D', turned(-1)),
                              (b'\x1b[A', selected(0, 1)), (b'a', pressed(1)),
                              (b'', released(1)), (b's', selected(1, 0))):
            os.write(master, typed)
            assert reader.packet() == events
        write_file(path + '/dro/work_z', '-77.89')
        read_until(b'-77.8900')
        os.write(master, b'u')
        read_until(b'unplugged')
        assert rig.wait(lambda: not os.path.exists(path))
        os.write(master, b'uq')
        _, status = os.waitpid(pid, 0)
        assert status == 0
