# SPDX-License-Identifier: GPL-2.0-only
"""What user space finds of a forward channel, beside the scans: where its counters are, and what
another line map leaves as it was.
"""

import os
import struct

import forward_rig
from forward_rig import Case
from kernel import wait

COUNTERS = ('scans', 'repeated', 'commands', 'bus_errors', 'clamped_codes')


class TestCounters(Case):
    def test_where_they_are(self):
        """In debugfs, but for what users poll and what a stream is judged by."""
        forward = self.forward(4, 'line')
        for name in COUNTERS:
            assert not os.path.exists(forward.iio + name), name
        assert sorted(os.listdir(forward.counters)) == sorted(COUNTERS)
        for name in ('underruns', 'achieved_frequency'):
            assert forward.get(name) == '0', name

    def test_they_count(self):
        forward = self.forward(4, 'line')
        stream = forward.stream()
        stream.write(struct.pack('<9I', 1, 2, 3, 1 << 20, 2, 3, 4, 5, 6))
        assert wait(lambda: forward.number('repeated') > 0)
        stream.finish()
        assert forward.number('scans') == 3 + forward.number('repeated')
        assert forward.number('clamped_codes') == 1
        assert forward.number('commands') == forward.number('bus_errors') == 0

    def test_two_heads(self):
        """Each has its own, which go with it."""
        self.sim(4, 'line', more='heads=2')
        one, two = self.channel(0), self.channel(1)
        assert two.set('out_angl0_raw', 5) is None
        assert (one.number('scans'), two.number('scans')) == (0, 1)
        one.unbind()
        assert not os.path.exists(one.counters)
        assert two.number('scans') == 1
        one.bind()
        one.find()
        assert one.number('scans') == 0


def setup_module():
    forward_rig.load()


def teardown_module():
    forward_rig.unload()
