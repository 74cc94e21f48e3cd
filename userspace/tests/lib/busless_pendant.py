# SPDX-License-Identifier: GPL-2.0-only
"""A pendant without a bus, and frames built field by field: for the unit tests of xhc-sim."""

import errno
import os
import struct
import sys

HERE = os.path.dirname(os.path.realpath(__file__))
PRODUCT = os.path.join(HERE, '..', '..', 'xhc-sim')
sys.path.insert(0, PRODUCT)

from xhc_sim import models, pendant  # noqa: E402

HB03, HB04, WHB04B = (models.MODELS[name] for name in ('HB03', 'HB04', 'WHB04B'))


def frame(model, coordinates=None, numbers=(0, 0, 0, 0), day=22, step=0, state=0):
    """A frame built field by field; coordinates: (integer, raw fraction) x 6"""
    data = bytes([0xFE, 0xFD, day])
    for whole, fraction in coordinates or [(0, 0)] * 6:
        data += struct.pack('<HB' if model is HB03 else '<HH', whole, fraction)
    data += struct.pack('<4HBB', *numbers, step, state)
    return data.ljust(model.chunks * 7, b'\0')


def whb04b_frame(rows=((0, 0),) * 3, overrides=(0, 0), seed=0xFE, flags=0):
    """The same for the WHB04B; rows: (integer, raw fraction) x 3"""
    data = bytes([0xFE, 0xFD, seed, flags])
    for whole, fraction in rows:
        data += struct.pack('<HH', whole, fraction)
    return data + struct.pack('<HHB', *overrides, 0)


def chunks(data):
    return [data[at:at + 7] for at in range(0, len(data), 7)]


class Bench(pendant.VirtualPendant):
    """A pendant without a bus: records its input reports.

    Unlike hardware it streams no reports, unless a test sets `streams`.
    """

    phys = 'bench'

    def __init__(self, model='HB04'):
        super().__init__(model)
        self.streams = False
        self.reports = []

    def plug(self):
        self.power_on()
        self.plugged = True
        self.start_stream()

    def unplug(self):
        with self.changed:
            self.plugged = False
            self.changed.notify_all()

    def report(self, data):
        if not self.plugged:
            raise OSError(errno.ENODEV, 'unplugged')
        self.reports.append(bytes(data))

    def send(self, data):
        for chunk in chunks(data):
            self.set_report(0x0306, 0, b'\x06' + chunk)
