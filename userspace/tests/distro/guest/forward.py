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

from harness import (BIND_TIME, command, equal, error_of, module_loaded, read_file, settle, true,
                     wait_for, write_file)
from heads import RATES, Cat, heads, packets
from virtual import DRIVER, MODULES, SIM, UART, Virtual, footprint, sim
from xy3_head_sim import wire

TESTS = []
LETTERS = 'xyzuw'
EIGHT_LINES = tuple(map(int, re.findall(r'\d+', os.uname().release)[:2])) >= (6, 12)
SCANS = 4096
AT_A_TIME = 512         # iio_writedev's buffer; it writes whole ones only
SPI_IOC_MESSAGE_2 = 0x40406B00


def test(function):
    TESTS.append(function)
    return function


@test
def driver_comes_by_modalias():
    """Must be first. Of the virtual head alone somebody has asked."""
    for name in MODULES:
        true(not module_loaded(name), '%s is loaded already' % name)
    with Virtual(lines=4) as head:
        equal(read_file(head.spi + '/modalias').strip(), 'spi:xy3-100', 'modalias')
        equal(os.path.realpath(head.spi + '/driver'), DRIVER, 'driver')
        equal(heads(), ['xy3-0'], 'heads')
        equal(error_of(read_file, head.path('rate')), errno.ENODEV, 'errno of rate')


# --- libiio's programs -------------------------------------------------------------------------

@test
def iio_info_lists_it():
    with Virtual(lines=4) as head:
        text = command('iio_info')
        true('%s: xy3-100 (buffer capable)' % os.path.basename(head.iio) in text, text)
        channels = re.findall(r'angl(\d): +\(output, index: (\d), format: (\S+)\)', text)
        equal(channels, [(str(i), str(i), 'le:u20/32>>0') for i in range(4)], 'channels')
        equal(re.findall(r'label value: (\w)', text), list('xyzu'), 'labels')
        settings = dict(re.findall(r': (\w+) value: (\w+)', text))
        for name, value in (('frame_bits', '24'), ('sampling_frequency', '100000'),
                            ('achieved_frequency', '0'), ('underruns', '0'), ('direction', 'out'),
                            ('data_available', '0')):
            equal(settings.get(name), value, name)


@test
def iio_attr_moves_the_mirrors():
    with Virtual(lines=4) as head:
        for axis, code in enumerate((1, 0xfffff, 4711, 0x80000)):
            command('iio_attr', '-c', 'xy3-100', 'angl%d' % axis, 'raw', str(code))
        equal(head.positions(20), [1, 0xfffff, 4711, 0x80000], 'positions')
        equal(command('iio_attr', '-c', 'xy3-100', 'angl2', 'raw').strip(), '4711', 'raw')
        command('iio_attr', '-d', 'xy3-100', 'frame_bits', '32')
        command('iio_attr', '-c', 'xy3-100', 'angl0', 'raw', str((1 << 26) - 1))
        equal(head.positions(26), [(1 << 26) - 1, 0xfffff << 6, 4711 << 6, 0x80000 << 6],
              'positions in frames of 32 bits')
        done = subprocess.run(['iio_attr', '-c', 'xy3-100', 'angl0', 'raw', str(1 << 26)],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        true(done.returncode, 'a code of 27 bits is taken')
        equal(head.positions(26)[0], (1 << 26) - 1, 'position behind it')


def check_writedev(lines, framing, bits):
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
        equal(head.number('scans') - head.number('repeated'), SCANS, 'scans that were no repeats')
        for name in ('commands', 'bus_errors', 'masked_codes'):
            equal(head.number(name), 0, name)


def writedev(lines, framing, bits):
    def stream():
        check_writedev(lines, framing, bits)
    stream.__name__ = 'iio_writedev_over_%d_lines_%s' % (lines, framing)
    return test(stream)


for arrangement in ((1, 'cs', 24), (2, 'cs', 32), (4, 'cs', 24), (4, 'line', 32)):
    writedev(*arrangement)
if EIGHT_LINES:
    writedev(8, 'cs', 32)
    writedev(8, 'line', 24)
else:
    @test
    def eight_lines_are_refused():
        """The kernel has no such transfers: no head rather than one that gets rubbish."""
        with Virtual(lines=8, driver=None) as head:
            settle()
            equal(os.path.exists(head.spi + '/driver'), False, 'a driver')
            equal(heads(), [], 'heads')


# --- a program ---------------------------------------------------------------------------------

@test
def numpy_array_is_a_circle():
    import numpy        # it takes ten seconds in here
    turn = numpy.linspace(0, 2 * numpy.pi, 5000, endpoint=False)
    circle = numpy.column_stack((numpy.cos(turn), numpy.sin(turn))) * 0x7ffff + 0x80000
    with Virtual(lines=2) as head:
        head.record(len(circle))
        scans = circle.astype('<u4')
        with head.streaming(), open(head.buffer, 'wb', buffering=0) as file:
            equal(file.write(scans), scans.nbytes, 'bytes taken')
        head.check_record(scans.tobytes())


@test
def what_cannot_be_is_refused():
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
            equal(error_of(write_file, path, text), error, 'errno of %s to %s' % (text, path))
        fd = os.open(head.buffer, os.O_WRONLY)
        try:
            equal(error_of(os.write, fd, bytes(16)), errno.EINVAL, 'errno without a stream')
            with head.streaming():
                equal(error_of(os.write, fd, bytes(15)), errno.EINVAL, 'errno of a torn scan')
                equal(error_of(head.set, 'out_angl0_raw', 1), errno.EBUSY, 'errno while it runs')
                os.write(fd, struct.pack('<4I', 1 << 20 | 5, 6, 7, 8))
        finally:
            os.close(fd)
        equal(head.number('masked_codes'), 1, 'masked_codes')
        equal(head.positions(20), [5, 6, 7, 8], 'positions')
        equal(sim('stats').split()[:4], ['scans', str(head.number('scans')), 'commands', '0'],
              'what the head has seen')


# --- the head ----------------------------------------------------------------------------------

@test
def commands_reach_the_head():
    """By sysfs, and as frames by the tty."""
    with Virtual(lines=2) as head:
        for name, text in (('autocalib', 'on xy'), ('temp_comp', 'off'), ('calibrate', 'z'),
                           ('reference', 'all')):
            write_file(head.path(name), text)
        fd = os.open(head.node, os.O_WRONLY | os.O_NOCTTY)
        try:
            frames = (wire.command_frame('temp_comp on', 'u'),
                      wire.command_frame('reference', 'w', 32))
            equal(os.write(fd, b''.join(frames)), 7, 'bytes taken')
            equal(error_of(os.write, fd, wire.position_frame(1)), errno.EINVAL, 'errno')
        finally:
            os.close(fd)
        wait_for(lambda: head.number('commands') == 6, 'six commands')
        equal([line.split(' ', 2)[2] for line in sim('commands').splitlines()],
              ['autocalib on xy', 'temp_comp off xyzuw', 'calibrate z', 'reference xyzuw',
               'temp_comp on u', 'reference w'], 'commands')


@test
def stty_moves_head_and_uart():
    with Virtual(lines=4, framing='line') as head, head.attached():
        for rate in RATES[::-1] + (115200,):
            command('stty', '-F', head.node, str(rate))
            equal(sim('rate'), str(rate), 'rate of the head')
            true('\nspeed %d\n' % rate in sim('uart'), sim('uart'))
            equal(read_file(head.path('rate')).strip(), str(rate), 'rate')
            wait_for(lambda: read_file(head.path('in_sync')) == '1\n', 'sync', BIND_TIME)


@test
def cat_gives_its_packets():
    with Virtual(lines=1) as head, head.attached():
        write_file(SIM + 'vendor', 'Lasers Ltd')
        with Cat(head) as cat:
            wait_for(lambda: (wire.VENDOR, b'Lasers Ltd') in packets(cat.data(), cut=True),
                     'the vendor', BIND_TIME)
        wait_for(lambda: read_file(head.path('vendor')) == 'Lasers Ltd\n', 'vendor in sysfs')


# --- coming and going --------------------------------------------------------------------------

@test
def unbound_while_it_streams():
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
        true(errors and errors[0] in (errno.EINVAL, errno.ENODEV), 'the writer: %r' % errors)
        equal(error_of(os.write, fd, bytes(4 * head.axes)), errno.ENODEV, 'errno of the next one')
        os.close(fd)
        equal(heads(), [], 'heads')
        write_file(DRIVER + '/bind', os.path.basename(head.spi))
        head.wait_bound()
        head.set('out_angl0_raw', 77)
        equal(head.positions(20)[0], 77, 'position')
        for name in ('parity_errors', 'length_errors'):
            equal(head.counts(name), [0] * head.axes, name)


@test
def spidev_sends_raw_frames():
    """Where xy3-spi cannot be used; then it can, on a device that the board calls spidev."""
    with Virtual(lines=1, modalias='spidev', driver=None) as head:
        node = '/dev/' + re.search(r'spidev (\S+)', sim('devices')).group(1)
        wait_for(lambda: os.path.exists(node), node, BIND_TIME)
        fd = os.open(node, os.O_RDWR)
        try:
            os.write(fd, wire.position_frame(0x12345, 24))
            equal(head.positions(20), [0x12345], 'position')
            two = [array.array('B', wire.command_frame('calibrate', 'x')),
                   array.array('B', wire.position_frame(0x3abcdef))]
            # struct spi_ioc_transfer; cs_change ends a frame
            fcntl.ioctl(fd, SPI_IOC_MESSAGE_2, b''.join(
                struct.pack('=QQIIHBBI', data.buffer_info()[0], 0, len(data), 0, 0, 8, more, 0)
                for data, more in zip(two, (1, 0))))
        finally:
            os.close(fd)
        equal(head.positions(26), [0x3abcdef], 'position')
        true(sim('commands').endswith('calibrate x'), sim('commands'))
        equal(head.counts('frames'), [3], 'frames')
        equal(heads(), [], 'heads')

        name = os.path.basename(head.spi)
        write_file(head.spi + '/driver_override', 'xy3-spi')
        write_file('/sys/bus/spi/drivers/spidev/unbind', name)
        command('modprobe', 'xy3-spi')
        write_file('/sys/bus/spi/drivers_probe', name)
        head.wait_bound()
        head.set('out_angl0_raw', 3)
        equal(head.positions(20), [3], 'position by the driver')


@test
def modules_go_and_leave_nothing():
    """Must be last. The driver stays while somebody has a file of a head that has gone."""
    with Virtual(lines=4) as head:
        true(footprint.left(), 'even of a head no allocation is seen')
        fd = os.open(head.buffer, os.O_WRONLY)
    try:
        equal(error_of(os.write, fd, bytes(16)), errno.ENODEV, 'errno of write')
        settle()
        done = subprocess.run(['modprobe', '-r', 'xy3-spi'], stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, check=False)
        true(done.returncode and 'in use' in done.stdout, 'modprobe -r: ' + done.stdout)
    finally:
        os.close(fd)
    command('modprobe', '-r', 'xy3-spi')
    for name in MODULES:
        true(not module_loaded(name), '%s is still loaded' % name)
    for path in ('/sys/class/xy3', '/sys/bus/spi/drivers/xy3-spi', '/dev/xy3-0', '/dev/xy3',
                 head.buffer, UART, '/sys/kernel/debug/xy3-sim'):
        true(not os.path.lexists(path), '%s is still there' % path)
    footprint.check()
