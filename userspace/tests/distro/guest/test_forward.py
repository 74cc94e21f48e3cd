# SPDX-License-Identifier: GPL-2.0-only
"""The scanhead's forward channel: a virtual head (xy3-sim) by the tools that its owner has."""

import array
import errno
import fcntl
import os
import re
import struct
import subprocess
import threading

import pytest
from harness import (BIND_TIME, command, error_of, module_loaded, read_file, settle, wait_for,
                     write_file)
from heads import RATES, Cat, heads, packets
from virtual import DRIVER, MODULES, SIM, UART, Virtual, footprint, sim
from xy3_head_sim import wire

LETTERS = 'xyzuw'
SCANS = 4096
AT_A_TIME = 512         # iio_writedev's buffer; it writes whole ones only
SPI_IOC_MESSAGE_2 = 0x40406B00

# a kernel has the transfers for eight lines, or not
EIGHT = [(8, 'cs', 32), pytest.param(8, 'line', 24, marks=pytest.mark.smoke)]
if tuple(map(int, re.findall(r'\d+', os.uname().release)[:2])) < (6, 12):
    EIGHT = []


@pytest.mark.smoke
def test_driver_comes_by_modalias():
    """Must be first. Of the virtual head alone somebody has asked."""
    for name in MODULES:
        assert not module_loaded(name), '%s is loaded already' % name
    with Virtual(lines=4) as head:
        assert read_file(head.spi + '/modalias').strip() == 'spi:xy3-100'
        assert os.path.realpath(head.spi + '/driver') == DRIVER
        assert heads() == ['xy3-0']
        assert error_of(read_file, head.path('rate')) == errno.ENODEV


# --- libiio's programs -------------------------------------------------------------------------

def test_iio_info_lists_it():
    with Virtual(lines=4) as head:
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
    with Virtual(lines=4) as head:
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


@pytest.mark.parametrize('lines, framing, bits', [
    (1, 'cs', 24), (2, 'cs', 32), (4, 'cs', 24), (4, 'line', 32), *EIGHT])
def test_iio_writedev(lines, framing, bits):
    top = (1 << (26 if bits == 32 else 20)) - 1
    with Virtual(lines=lines, framing=framing) as head:
        head.set('frame_bits', bits)
        data = array.array('I', (scan * 0x9E3779B1 + axis * 0x3779B97 & top
                                 for scan in range(SCANS) for axis in range(head.axes)))
        with open('/tmp/scan', 'wb') as file:
            data.tofile(file)
        head.record(SCANS)
        command('sh', '-c', 'iio_writedev -b %d -s %d xy3-100 < /tmp/scan' % (AT_A_TIME, SCANS))
        head.check_record(data.tobytes())
        assert head.number('scans') - head.number('repeated') == SCANS
        for name in ('commands', 'bus_errors', 'masked_codes'):
            assert head.number(name) == 0, name


if not EIGHT:
    def test_eight_lines_are_refused():
        """No head rather than one that gets rubbish."""
        with Virtual(lines=8, driver=None) as head:
            settle()
            assert not os.path.exists(head.spi + '/driver')
            assert heads() == []


# --- a program ---------------------------------------------------------------------------------

def test_numpy_array_is_a_circle():
    import numpy        # it takes ten seconds in here
    turn = numpy.linspace(0, 2 * numpy.pi, 5000, endpoint=False)
    circle = numpy.column_stack((numpy.cos(turn), numpy.sin(turn))) * 0x7ffff + 0x80000
    with Virtual(lines=2) as head:
        head.record(len(circle))
        scans = circle.astype('<u4')
        with head.streaming(), open(head.buffer, 'wb', buffering=0) as file:
            assert file.write(scans) == scans.nbytes
        head.check_record(scans.tobytes())


def test_what_cannot_be_is_refused():
    with Virtual(lines=4) as head:
        refused = ((head.iio + '/out_angl0_raw', '1048576', errno.ERANGE),
                   (head.iio + '/out_angl0_raw', '-1', errno.ERANGE),
                   (head.iio + '/out_angl0_raw', 'left', errno.EINVAL),
                   (head.iio + '/frame_bits', '28', errno.EINVAL),
                   (head.iio + '/sampling_frequency', '0', errno.ERANGE),
                   (head.iio + '/sampling_frequency', '100000000', errno.ERANGE),
                   (head.spi + '/line_map', 'x x', errno.EINVAL),
                   (head.spi + '/line_map', 'y z', errno.EINVAL),
                   (head.path('calibrate'), 'q', errno.EINVAL),
                   (head.path('autocalib'), 'x', errno.EINVAL))
        for path, text, error in refused:
            assert error_of(write_file, path, text) == error, 'errno of %s to %s' % (text, path)
        fd = os.open(head.buffer, os.O_WRONLY)
        try:
            assert error_of(os.write, fd, bytes(16)) == errno.EINVAL
            with head.streaming():
                assert error_of(os.write, fd, bytes(15)) == errno.EINVAL
                assert error_of(head.set, 'out_angl0_raw', 1) == errno.EBUSY
                os.write(fd, struct.pack('<4I', 1 << 20 | 5, 6, 7, 8))
        finally:
            os.close(fd)
        assert head.number('masked_codes') == 1
        assert head.positions(20) == [5, 6, 7, 8]
        assert sim('stats').split()[:4] == ['scans', str(head.number('scans')), 'commands', '0']


# --- the head ----------------------------------------------------------------------------------

def test_commands_reach_the_head():
    """By sysfs, and as frames by the tty."""
    with Virtual(lines=2) as head:
        for name, text in (('autocalib', 'on xy'), ('temp_comp', 'off'), ('calibrate', 'z'),
                           ('reference', 'all')):
            write_file(head.path(name), text)
        fd = os.open(head.node, os.O_WRONLY | os.O_NOCTTY)
        try:
            frames = (wire.command_frame('temp_comp on', 'u'),
                      wire.command_frame('reference', 'w', 32))
            assert os.write(fd, b''.join(frames)) == 7
            assert error_of(os.write, fd, wire.position_frame(1)) == errno.EINVAL
        finally:
            os.close(fd)
        wait_for(lambda: head.number('commands') == 6, 'six commands')
        assert [line.split(' ', 2)[2] for line in sim('commands').splitlines()] == [
            'autocalib on xy', 'temp_comp off xyzuw', 'calibrate z', 'reference xyzuw',
            'temp_comp on u', 'reference w']


@pytest.mark.smoke
def test_stty_moves_head_and_uart():
    with Virtual(lines=4, framing='line') as head, head.attached():
        for rate in RATES[::-1] + (115200,):
            command('stty', '-F', head.node, str(rate))
            assert sim('rate') == str(rate)
            assert '\nspeed %d\n' % rate in sim('uart'), sim('uart')
            assert read_file(head.path('rate')).strip() == str(rate)
            wait_for(lambda: read_file(head.path('in_sync')) == '1\n', 'sync', BIND_TIME)


def test_cat_gives_its_packets():
    with Virtual(lines=1) as head, head.attached():
        write_file(SIM + 'vendor', 'Lasers Ltd')
        with Cat(head) as cat:
            wait_for(lambda: (wire.VENDOR, b'Lasers Ltd') in packets(cat.data(), cut=True),
                     'the vendor', BIND_TIME)
        wait_for(lambda: read_file(head.path('vendor')) == 'Lasers Ltd\n', 'vendor in sysfs')


# --- coming and going --------------------------------------------------------------------------

def test_unbound_while_it_streams():
    with Virtual(lines=4, framing='line', realtime=1) as head:
        head.start()
        fd = os.open(head.buffer, os.O_WRONLY)
        errors = []

        def write():
            while not errors:
                error = error_of(os.write, fd, bytes(4 * head.axes * 1000))
                if error:
                    errors.append(error)

        writer = threading.Thread(target=write, daemon=True)
        writer.start()
        wait_for(lambda: head.number('scans') > 10000, 'scans')
        write_file(DRIVER + '/unbind', os.path.basename(head.spi))
        writer.join(BIND_TIME)
        # who is at it may see that the stream has stopped before the device has gone
        assert errors and errors[0] in (errno.EINVAL, errno.ENODEV), 'the writer: %r' % errors
        assert error_of(os.write, fd, bytes(4 * head.axes)) == errno.ENODEV
        os.close(fd)
        assert heads() == []
        write_file(DRIVER + '/bind', os.path.basename(head.spi))
        head.wait_bound()
        head.set('out_angl0_raw', 77)
        assert head.positions(20)[0] == 77
        for name in ('parity_errors', 'length_errors'):
            assert head.counts(name) == [0] * head.axes, name


def test_spidev_sends_raw_frames():
    """Where xy3-spi cannot be used; then it can, on a device that the board calls spidev."""
    with Virtual(lines=1, modalias='spidev', driver=None) as head:
        node = '/dev/' + re.search(r'spidev (\S+)', sim('devices')).group(1)
        wait_for(lambda: os.path.exists(node), node, BIND_TIME)
        fd = os.open(node, os.O_RDWR)
        try:
            os.write(fd, wire.position_frame(0x12345, 24))
            assert head.positions(20) == [0x12345]
            two = [array.array('B', wire.command_frame('calibrate', 'x')),
                   array.array('B', wire.position_frame(0x3abcdef))]
            # struct spi_ioc_transfer; cs_change ends a frame
            fcntl.ioctl(fd, SPI_IOC_MESSAGE_2, b''.join(
                struct.pack('=QQIIHBBI', data.buffer_info()[0], 0, len(data), 0, 0, 8, more, 0)
                for data, more in zip(two, (1, 0))))
        finally:
            os.close(fd)
        assert head.positions(26) == [0x3abcdef]
        assert sim('commands').endswith('calibrate x'), sim('commands')
        assert head.counts('frames') == [3]
        assert heads() == []

        name = os.path.basename(head.spi)
        write_file(head.spi + '/driver_override', 'xy3-spi')
        write_file('/sys/bus/spi/drivers/spidev/unbind', name)
        command('modprobe', 'xy3-spi')
        write_file('/sys/bus/spi/drivers_probe', name)
        head.wait_bound()
        head.set('out_angl0_raw', 3)
        assert head.positions(20) == [3]


@pytest.mark.smoke
def test_modules_go_and_leave_nothing():
    """Must be last. The driver stays while somebody has a file of a head that has gone."""
    with Virtual(lines=4) as head:
        assert footprint.left(), 'even of a head no allocation is seen'
        fd = os.open(head.buffer, os.O_WRONLY)
    try:
        assert error_of(os.write, fd, bytes(16)) == errno.ENODEV
        settle()
        done = subprocess.run(['modprobe', '-r', 'xy3-spi'], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        assert done.returncode and 'in use' in done.stdout, 'modprobe -r: ' + done.stdout
    finally:
        os.close(fd)
    command('modprobe', '-r', 'xy3-spi')
    for name in MODULES:
        assert not module_loaded(name), '%s is still loaded' % name
    for path in ('/sys/class/xy3', '/sys/bus/spi/drivers/xy3-spi', '/dev/xy3-0', '/dev/xy3',
                 head.buffer, UART, '/sys/kernel/debug/xy3-sim'):
        assert not os.path.lexists(path), '%s is still there' % path
    footprint.check()
