# SPDX-License-Identifier: GPL-2.0-only
"""The forward channel of a scanhead: a virtual head with the programs of users.

Tests that do not depend on libiio, udev or the kernel run in User Mode Linux (tests/forward).
"""

import array
import contextlib
import ctypes
import fcntl
import mmap
import os
import re
import struct
import subprocess
import tempfile
import threading

import pytest
from harness import (BIND_TIME, command, module_loaded, read_file, settle, unload_modules,
                     wait_for, write_file)
from head_rig import error_name
from serial_head import heads
from virtual_head import DRIVER, MODULES, UART, VirtualHead, footprint, sim
from xy3_head_sim import wire

SCANS = 4096
AT_A_TIME = 512         # the buffer of iio_writedev, which only writes full buffers

KERNEL = tuple(map(int, re.findall(r'\d+', os.uname().release)[:2]))
# whether the kernel supports transfers over eight lines, and over lanes
EIGHT = [pytest.param(8, 'line', 24, 0, marks=pytest.mark.smoke)] if KERNEL >= (6, 12) else []
LANES = [(8, 'cs', 24, 5), pytest.param(8, 'cs', 32, 5, marks=pytest.mark.smoke)
         ] if KERNEL >= (7, 2) else []


@pytest.mark.smoke
def test_driver_comes_by_modalias():
    """Must be first. Only the virtual head is loaded explicitly."""
    for name in MODULES:
        assert not module_loaded(name), '%s is loaded already' % name
    with VirtualHead(lines=4) as head:
        assert read_file(head.spi + '/modalias').strip() == 'spi:xy3-100'
        assert os.path.realpath(head.spi + '/driver') == DRIVER
        assert heads() == ['xy3-0']
        assert error_name(read_file, head.path('rate')) == 'ENODEV'


# --- libiio's programs -------------------------------------------------------------------------

def test_iio_info_lists_it():
    with VirtualHead(lines=4) as head:
        text = command('iio_info')
        assert '%s: xy3-100 (buffer capable)' % os.path.basename(head.iio) in text, text
        channels = re.findall(r'angl(\d): +\(output, index: (\d), format: (\S+)\)', text)
        assert channels == [(str(i), str(i), 'le:u20/32>>0') for i in range(4)]
        assert re.findall(r'label value: (\w)', text) == list('xyzu')
        settings = dict(re.findall(r': (\w+) value: (\w+)', text))
        for name, value in (('frame_bits', '24'), ('sampling_frequency', '100000'),
                            ('achieved_frequency', '0'), ('underruns', '0'), ('direction', 'out'),
                            ('data_available', '0')):
            assert settings.get(name) == value, name


def test_iio_attr_moves_the_mirrors():
    with VirtualHead(lines=4) as head:
        for axis, code in enumerate((1, 0xfffff, 4711, 0x80000)):
            command('iio_attr', '-c', 'xy3-100', 'angl%d' % axis, 'raw', str(code))
        assert head.positions(20) == [1, 0xfffff, 4711, 0x80000]
        assert command('iio_attr', '-c', 'xy3-100', 'angl2', 'raw').strip() == '4711'
        command('iio_attr', '-d', 'xy3-100', 'frame_bits', '32')
        command('iio_attr', '-c', 'xy3-100', 'angl0', 'raw', str((1 << 26) - 1))
        assert head.positions(26) == [(1 << 26) - 1, 0xfffff << 6, 4711 << 6, 0x80000 << 6]
        done = subprocess.run(['iio_attr', '-c', 'xy3-100', 'angl0', 'raw', str(1 << 26)],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        assert done.returncode, 'a code of 27 bits is taken'
        assert head.positions(26)[0] == (1 << 26) - 1


@pytest.mark.parametrize('lines, framing, bits, lanes', [
    (1, 'cs', 24, 0), pytest.param(4, 'line', 32, 0, marks=pytest.mark.smoke), *EIGHT, *LANES])
def test_iio_writedev(lines, framing, bits, lanes):
    top = (1 << (26 if bits == 32 else 20)) - 1
    with VirtualHead(lines=lines, framing=framing, lanes=lanes) as head:
        if lanes:
            assert head.axes == lanes
        head.set('frame_bits', bits)
        data = array.array('I', (scan * 0x9E3779B1 + axis * 0x3779B97 & top
                                 for scan in range(SCANS) for axis in range(head.axes)))
        with open('/tmp/scan', 'wb') as file:
            data.tofile(file)
        head.record(SCANS)
        command('sh', '-c', 'iio_writedev -b %d -s %d xy3-100 < /tmp/scan' % (AT_A_TIME, SCANS))
        head.check_record(data.tobytes())
        assert head.number('scans') - head.number('repeated') == SCANS
        for name in ('commands', 'bus_errors', 'clamped_codes'):
            assert head.number(name) == 0, name


if not EIGHT:
    def test_eight_lines_are_refused():
        """No head is created instead of one that would receive garbage."""
        with VirtualHead(lines=8, driver=None) as head:
            settle()
            assert not os.path.exists(head.spi + '/driver')
            assert heads() == []


if LANES:
    def test_lanes_carry_positions_and_commands():
        with VirtualHead(lines=8, framing='cs', lanes=5, controller='spi-engine') as head:
            assert 'on lanes that were not chosen' in command('dmesg')
            for axis, code in enumerate((1, 0xfffff, 4711, 0x80000, 0x12345)):
                head.set('out_angl%d_raw' % axis, code)
            assert head.positions(20) == [1, 0xfffff, 4711, 0x80000, 0x12345]
            with open(head.path('calibrate'), 'w', encoding='ascii') as file:
                file.write('xw')
            wait_for(lambda: head.number('commands') == 1, 'the command', BIND_TIME)
            for name in ('parity_errors', 'length_errors', 'mode_errors'):
                assert head.counts(name) == [0] * 5, name
    def test_lanes_that_the_controller_has_not():
        """Nor are the words of all of them sent one after another, to X."""
        with VirtualHead(lines=1, framing='cs', cs_word=1, lanes=5, driver=None) as head:
            settle()
            assert not os.path.exists(head.spi + '/driver')
            assert heads() == []
            assert 'has not set up 5 lanes' in command('dmesg')
else:
    def test_lanes_are_refused():
        with VirtualHead(lines=8, framing='cs', lanes=5, driver=None) as head:
            settle()
            assert not os.path.exists(head.spi + '/driver')
            assert heads() == []


@pytest.mark.smoke
def test_stty_moves_head_and_uart():
    with VirtualHead(lines=4, framing='line') as head, head.attached():
        for rate in wire.RATES[::-1] + (115200,):
            command('stty', '-F', head.node, str(rate))
            wait_for(lambda rate=rate: read_file(head.path('rate')).strip() == str(rate),
                     '%d in sysfs' % rate, BIND_TIME)
            assert sim('rate') == str(rate)
            assert '\nspeed %d\n' % rate in sim('uart'), sim('uart')
            wait_for(lambda: read_file(head.path('in_sync')) == '1\n', 'sync', BIND_TIME)


# --- a writer whose memory another program supplies ---------------------------------------------

SYS_USERFAULTFD = {'x86_64': 323, 'aarch64': 282}[os.uname().machine]
UFFDIO_API, UFFDIO_REGISTER = 0xc018aa3f, 0xc020aa00
UFFD_API, REGISTER_MODE_MISSING = 0xaa, 1
IIO_BUFFER_GET_FD = 0xc0046991


def missing_page():
    """-> a page whose reads block, and the file that ends this when it is closed"""
    page = mmap.mmap(-1, mmap.PAGESIZE)
    fault = ctypes.CDLL(None, use_errno=True).syscall(SYS_USERFAULTFD, os.O_CLOEXEC)
    assert fault >= 0, os.strerror(ctypes.get_errno())
    fcntl.ioctl(fault, UFFDIO_API, struct.pack('3Q', UFFD_API, 0, 0))
    address = ctypes.addressof(ctypes.c_char.from_buffer(page))
    fcntl.ioctl(fault, UFFDIO_REGISTER,
                struct.pack('4Q', address, mmap.PAGESIZE, REGISTER_MODE_MISSING, 0))
    return page, fault


def start_writer(fd, page, size):
    """-> a thread whose write() waits for the page"""
    writer = threading.Thread(target=error_name, daemon=True,
                              args=(os.write, fd, memoryview(page)[:size]))
    writer.start()
    wait_for(lambda: 'userfault' in read_file('/proc/self/task/%d/wchan' % writer.native_id),
             'the fault', BIND_TIME)
    return writer


def test_writer_without_its_page():
    """A write() that waits for its page blocks nothing: the stream ends, the driver is unloaded."""
    with VirtualHead(lines=4, framing='line') as head:
        head.start()
        fd = os.open(head.buffer, os.O_WRONLY)
        page, fault = missing_page()
        try:
            size = 100 * 4 * head.axes
            writer = start_writer(fd, page, size)
            for text, path in (('0', head.iio + '/buffer/enable'),
                               (os.path.basename(head.spi), DRIVER + '/unbind')):
                end = subprocess.Popen(['sh', '-c', 'echo %s > %s' % (text, path)])
                wait_for(lambda end=end: end.poll() is not None, path, BIND_TIME)
                assert end.returncode == 0, path
        finally:
            os.close(fault)
            writer.join(BIND_TIME)
            os.close(fd)
        assert not writer.is_alive()


def test_driver_stays_for_its_writer():
    """A file of the buffer alone does not hold the module, but a write() does."""
    with VirtualHead(lines=4, framing='line') as head:
        head.start()
        device = os.open(head.buffer, os.O_WRONLY)
        number = bytearray(4)
        fcntl.ioctl(device, IIO_BUFFER_GET_FD, number)
        fd, = struct.unpack('i', number)
        os.close(device)
        page, fault = missing_page()
        try:
            writer = start_writer(fd, page, 100 * 4 * head.axes)
            done = subprocess.run(['modprobe', '-r', 'xy3-spi'], stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True, check=False)
        finally:
            os.close(fault)
        writer.join(BIND_TIME)
        os.close(fd)
        assert not writer.is_alive()
        assert done.returncode and 'in use' in done.stdout, 'modprobe -r: ' + done.stdout
        head.set('buffer/enable', 0)


@contextlib.contextmanager
def memory_cgroup():
    """-> the folder of a new cgroup with the memory controller"""
    with tempfile.TemporaryDirectory() as root:
        command('mount', '-t', 'cgroup2', 'cgroup2', root)
        try:
            write_file(root + '/cgroup.subtree_control', '+memory')
            os.mkdir(root + '/xy3')
            yield root + '/xy3'
            os.rmdir(root + '/xy3')
        finally:
            command('umount', root)


def test_memory_of_the_buffer_is_accounted():
    """The length of the buffer is writable for a group."""
    with VirtualHead(lines=4) as head, memory_cgroup() as group:
        head.set('buffer/length', 131072)
        child = os.fork()
        if not child:
            try:
                write_file(group + '/cgroup.procs', str(os.getpid()))
                head.start()
                os._exit(0)
            finally:
                os._exit(1)
        assert os.waitpid(child, 0)[1] == 0
        # twice that number of scans, of 13 bytes each
        assert int(read_file(group + '/memory.current')) > 2 * 131072 * 13
        head.set('buffer/enable', 0)


# --- removal -----------------------------------------------------------------------------------

@pytest.mark.smoke
def test_modules_go_and_leave_nothing():
    """Must be last. The driver stays loaded while a file of a removed head is open."""
    with VirtualHead(lines=4) as head:
        assert footprint.left(), 'even of a head no allocation is seen'
        fd = os.open(head.buffer, os.O_WRONLY)
    try:
        assert error_name(os.write, fd, bytes(16)) == 'ENODEV'
        settle()
        done = subprocess.run(['modprobe', '-r', 'xy3-spi'], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        assert done.returncode and 'in use' in done.stdout, 'modprobe -r: ' + done.stdout
    finally:
        os.close(fd)
    unload_modules('xy3-spi')
    for name in MODULES:
        assert not module_loaded(name), '%s is still loaded' % name
    for path in ('/sys/class/xy3', '/sys/bus/spi/drivers/xy3-spi', '/dev/xy3-0', head.buffer, UART,
                 '/sys/kernel/debug/xy3-sim'):
        assert not os.path.lexists(path)
    wait_for(lambda: not os.path.lexists('/dev/xy3'), 'end of the link', BIND_TIME)
    footprint.check()
