# SPDX-License-Identifier: GPL-2.0-only
"""A UART on USB: CDC ACM over dummy_hcd, with the kernel's gadget driver as the other end.

Unlike a pty it flags line errors, stops when it is throttled, and can be unplugged.
"""

import glob
import os
import re
import termios
import tty

from head_rig import Pty, set_speed
from kernel import read_file, wait, write_file

GADGET = '/sys/kernel/config/usb_gadget/xy3'
FUNCTION = GADGET + '/functions/acm.usb0'
UDC = 'dummy_udc.0'
PORT = '/sys/devices/platform/dummy_hcd.0'


class AcmCable(Pty):
    """Used by tests like a Pty. The gadget is created once; the host may use it or not."""

    def __init__(self, rate=115200):
        self.master = self.slave = self.node = None
        self.rate = rate
        self.plug()

    @staticmethod
    def _build():
        for folder in ('', '/strings/0x409', '/configs/c.1', '/functions/acm.usb0'):
            os.mkdir(GADGET + folder)
        write_file(GADGET + '/idVendor', '0x0525')
        write_file(GADGET + '/idProduct', '0xa4a7')
        os.symlink(FUNCTION, GADGET + '/configs/c.1/acm.usb0')
        write_file(GADGET + '/UDC', UDC)

    @staticmethod
    def _authorize(text):
        bus = next(name[3:] for name in os.listdir(PORT) if re.fullmatch(r'usb\d+', name))
        write_file('/sys/bus/usb/devices/%s-1/authorized' % bus, text)

    def plug(self):
        if os.path.isdir(GADGET):
            self._authorize('1')
        else:
            self._build()
        nodes = wait(lambda: [node for node in glob.glob('/dev/ttyACM*') if os.path.exists(node)])
        if not nodes:
            raise AssertionError('no ttyACM')
        self.node = nodes[0]
        self.master = self._open('/dev/ttyGS' + read_file(FUNCTION + '/port_num').strip())
        self.slave = self._open(self.node)
        os.set_blocking(self.slave, True)
        set_speed(self.slave, self.rate)

    @staticmethod
    def _open(node):
        fd = os.open(node, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC)
        tty.setraw(fd)
        modes = termios.tcgetattr(fd)
        modes[2] |= termios.CLOCAL
        termios.tcsetattr(fd, termios.TCSANOW, modes)
        return fd

    def unplug(self):
        """Hangs up both ends."""
        if self.master is None:
            return
        self._authorize('0')
        if not wait(lambda: not os.path.exists(self.node)):
            raise AssertionError('%s does not go away' % self.node)
        self.close_slave()
        os.close(self.master)
        self.master = None

    cut = close = unplug

    def send_break(self):
        termios.tcsendbreak(self.master, 0)

    def flood(self, size):
        """Writes as many bytes as fit."""
        try:
            while size > 0:
                size -= os.write(self.master, bytes(min(size, 4096)))
        except BlockingIOError:
            pass
