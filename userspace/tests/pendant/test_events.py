# SPDX-License-Identifier: GPL-2.0-only
"""Reports in, events out: content and order, read by libevdev, evtest and hidraw."""

import errno
import fcntl
import os
import select
import struct
import subprocess
import threading
import time

import pytest
from case import row
from driven import MODELS
import rig
from rig import (KEY, LAST_KEY, PARAMETER, Case, pressed, read_file, released, selected, turned,
                 write_file)
from xhc_sim import find

EVIOCGKEYCODE, EVIOCSKEYCODE = 0x80084504, 0x40084504
EVIOCGKEYCODE_V2, EVIOCSKEYCODE_V2 = 0x80284504, 0x40284504
KEYMAP_ENTRY = struct.Struct('<BBHI32s')        # flags, len, index, keycode, scancode
KEY_A, KEY_B, BTN_TRIGGER_HAPPY1 = 30, 48, 0x2C0
EVTEST_DOWN = 10                                # exit status of evtest --query

# Selector byte -> ABS_MISC.  HB03 by the table of the seed document; HB04 as real units send it.
SELECTOR = {
    'HB03': {0x00: 0, 0x11: 1, 0x12: 2, 0x13: 3, 0x18: 4, 0x14: 5, 0x15: 6},
    'HB04': {0x00: 0, 0x11: 1, 0x12: 2, 0x13: 3, 0x18: 4, 0x15: 5, 0x14: 6},
    'WHB04B': {0x06: 0, 0x11: 1, 0x12: 2, 0x13: 3, 0x14: 4, 0x15: 7, 0x16: 8},
}


def hidiocsfeature(size):
    return 0xC0004806 | size << 16


class TestDevice(Case):
    @pytest.mark.parametrize('model, product', [
        ('HB03', 0xEB6E), ('HB04', 0xEB70), ('WHB04B', 0xEB93)])
    def test_identity(self, model, product):
        pendant = self.plug(model)
        device = pendant.reader.device
        assert device.name == 'XHC %s Pendant' % model
        assert device.phys == pendant.device.phys
        assert (device.id['bustype'], device.id['vendor'], device.id['product']) == \
            (3, 0x10CE, product)
        assert pendant.get('model') == model
        assert len(os.listdir(pendant.path + '/input')) == 1

    def test_capabilities_are_exactly_these(self):
        device = self.plug().reader.device
        have = {kind.name: sorted(code.name for code in codes)
                for kind, codes in device.evbits.items()}
        have.pop('EV_SYN')
        keys = [KEY[code] for code in range(1, 0x18)] + [KEY[code] for code in range(31, 37)]
        assert have == {'EV_KEY': sorted(keys), 'EV_REL': ['REL_DIAL'],
                                'EV_ABS': ['ABS_MISC'], 'EV_MSC': ['MSC_SCAN']}

    def test_selector_axis(self):
        info = self.plug().reader.device.absinfo[rig.libevdev.EV_ABS.ABS_MISC]
        assert (info.minimum, info.maximum, info.fuzz, info.flat) == (0, 6, 0, 0)

    def test_axis_value_before_and_after_a_report(self):
        pendant = self.plug()
        assert pendant.reader.device.value[rig.libevdev.EV_ABS.ABS_MISC] == 0
        pendant.report(key1=3, selector=0x13)
        pendant.packet()
        later = rig.EvdevReader(pendant.event_node)
        self.add_cleanup(later.close)
        assert later.device.value[rig.libevdev.EV_ABS.ABS_MISC] == 3
        assert later.device.value[rig.libevdev.EV_KEY.BTN_TRIGGER_HAPPY3] == 1
        assert later.device.value[rig.libevdev.EV_KEY.BTN_TRIGGER_HAPPY33] == 1

    def test_reports_flow_before_anybody_opens_the_node(self):
        """The driver receives reports from probe on, to know the state when the node is opened."""
        pendant = self.plug()
        pendant.close_reader()
        assert pendant.device.opened
        pendant.report(selector=0x12)
        assert rig.wait(lambda: pendant.stat('reports') == 1)
        later = rig.EvdevReader(pendant.event_node)
        self.add_cleanup(later.close)
        assert later.device.value[rig.libevdev.EV_ABS.ABS_MISC] == 2

    def test_clone_by_new_id(self):
        """The last number is the product id of the model that the clone resembles."""
        self.add_cleanup(rig.load)
        self.add_cleanup(rig.unload)
        write_file(rig.DRIVER_DIR + '/new_id', '3 10ce eb71 eb70')
        clone = self.plug('HB04', product=0xEB71)
        assert clone.get('model') == 'HB04'
        assert clone.reader.device.id['product'] == 0xEB71
        clone.report(3)
        self.assert_packet(clone, pressed(3))
        for product, model in ((0xEB72, '0'), (0xEB74, 'eb71'), (0xEB75, 'ffffffffffffffff')):
            with row(model=model):
                write_file(rig.DRIVER_DIR + '/new_id', '3 10ce %x %s' % (product, model))
                device = rig.UhidPendant('HB04', product=product)
                device.plug()
                self.add_cleanup(device.unplug)
                path = rig.wait(lambda phys=device.phys: find.hid_directory(phys))
                assert path
                assert not rig.takes(path)

    def test_two_pendants_differ_by_phys(self):
        one, two = self.plug(), self.plug()
        assert one.reader.device.name == two.reader.device.name
        assert one.reader.device.phys != two.reader.device.phys
        one.report(key1=1)
        two.report(key1=2)
        self.assert_packet(one, pressed(1))
        self.assert_packet(two, pressed(2))


class TestKeys(Case):
    @pytest.mark.distro
    @pytest.mark.smoke
    @pytest.mark.parametrize('model', MODELS)
    def test_every_key_goes_down_and_up(self, model):
        pendant = self.plug(model)
        for code in range(1, LAST_KEY[model] + 1):
            with row(code=code):
                pendant.report(key1=code)
                self.assert_packet(pendant, pressed(code))
                pendant.report()
                self.assert_packet(pendant, released(code))

    def test_second_slot_is_as_good_as_the_first(self):
        pendant = self.plug()
        for code in range(1, 0x18):
            with row(code=code):
                pendant.report(key2=code)
                self.assert_packet(pendant, pressed(code))
                pendant.report()
                self.assert_packet(pendant, released(code))

    def test_two_keys(self):
        pendant = self.plug()
        pendant.report(1, 2)
        self.assert_packet(pendant, pressed(1) + pressed(2))
        pendant.report(2)
        self.assert_packet(pendant, released(1))
        pendant.report()
        self.assert_packet(pendant, released(2))

    def test_key_in_both_slots_is_down_once(self):
        pendant = self.plug()
        pendant.report(5, 5)
        self.assert_packet(pendant, pressed(5))
        pendant.report(0, 5)
        pendant.report(5, 0)
        self.assert_silent(pendant)
        pendant.report()
        self.assert_packet(pendant, released(5))

    def test_swapped_slots_say_nothing(self):
        pendant = self.plug()
        pendant.report(7, 9)
        self.assert_packet(pendant, pressed(7) + pressed(9))
        for _ in range(3):
            pendant.report(9, 7)
            pendant.report(7, 9)
        self.assert_silent(pendant)
        pendant.report(9, 0)
        self.assert_packet(pendant, released(7))

    def test_up_before_down(self):
        pendant = self.plug()
        pendant.report(1, 2)
        pendant.packet()
        pendant.report(3, 4)
        self.assert_packet(pendant, released(1) + released(2) + pressed(3) + pressed(4))
        pendant.report(4, 0x17)
        self.assert_packet(pendant, released(3) + pressed(0x17))

    def test_same_report_again_says_nothing(self):
        pendant = self.plug()
        pendant.report(1, 0, 0x11)
        pendant.packet()
        for _ in range(5):
            pendant.report(1, 0, 0x11)
        self.assert_silent(pendant)

    def test_unknown_code(self):
        pendant = self.plug()
        for number, code in enumerate((0x18, 0x20, 0x21, 0x26, 0x7F, 0x80, 0xFF), 1):
            with row(code=code):
                pendant.report(code)
                self.assert_packet(pendant, [('EV_MSC', 'MSC_SCAN', code)])
                pendant.report(code)
                pendant.report()
                self.assert_silent(pendant)
                assert pendant.stat('unknown_keys') == number

    def test_unknown_code_beside_a_key(self):
        pendant = self.plug()
        pendant.report(0x99, 4)
        packet = pendant.packet()
        assert ('EV_MSC', 'MSC_SCAN', 0x99) in packet
        assert packet[-2:] == pressed(4)
        pendant.report(4)
        self.assert_silent(pendant)
        assert pendant.stat('unknown_keys') == 1


class TestSelector(Case):
    def turn_through(self, pendant, table):
        was = 0
        for code, now in list(table.items()) + [(0x11, 1), (None, 0)]:
            with row(code=code):
                pendant.report(selector=code)
                if now != was:
                    self.assert_packet(pendant, selected(was, now))
                was = now
        assert pendant.stat('unknown_keys') == 0

    @pytest.mark.parametrize('model', SELECTOR)
    def test_every_position(self, model):
        self.turn_through(self.plug(model), SELECTOR[model])

    @pytest.mark.parametrize('model', ('HB03', 'HB04'))
    def test_swap_feed_spindle(self, model):
        swap = {5: 6, 6: 5}
        write_file(PARAMETER, 'Y')
        self.add_cleanup(write_file, PARAMETER, 'N')
        self.turn_through(self.plug(model), {code: swap.get(position, position)
                                             for code, position in SELECTOR[model].items()})

    def test_swap_feed_spindle_of_one_pendant(self):
        """It takes effect on the next report, also while the selector is at one of the two."""
        one, two = self.plug(), self.plug()
        for pendant in (one, two):
            assert pendant.get('swap_feed_spindle') == '0'
            pendant.report(selector=0x15)
            self.assert_packet(pendant, selected(0, 5))
        one.set('swap_feed_spindle', 'Y')
        assert one.get('swap_feed_spindle') == '1'
        assert two.get('swap_feed_spindle') == '0'
        for pendant in (one, two):
            pendant.report(selector=0x15)
        self.assert_packet(one, selected(5, 6))
        self.assert_silent(two)
        one.set('swap_feed_spindle', '0')
        one.report(selector=0x15)
        self.assert_packet(one, selected(6, 5))
        assert one.set_error('swap_feed_spindle', 'x') == 'EINVAL'

    def test_swap_feed_spindle_parameter_is_the_default(self):
        """It applies to pendants that are plugged in later."""
        before = self.plug()
        write_file(PARAMETER, 'Y')
        self.add_cleanup(write_file, PARAMETER, 'N')
        after = self.plug()
        assert before.get('swap_feed_spindle') == '0'
        assert after.get('swap_feed_spindle') == '1'
        before.report(selector=0x15)
        self.assert_packet(before, selected(0, 5))
        after.report(selector=0x15)
        self.assert_packet(after, selected(0, 6))

    def test_swap_feed_spindle_is_a_load_parameter(self):
        rig.unload()
        rig.load('swap_feed_spindle=1')
        self.add_cleanup(rig.load)
        self.add_cleanup(rig.unload)
        assert read_file(PARAMETER) == 'Y\n'
        pendant = self.plug('HB04')
        pendant.report(selector=0x14)
        self.assert_packet(pendant, selected(0, 5))
        pendant.unplug()

    def test_unknown_code_is_off(self):
        pendant = self.plug()
        pendant.report(selector=0x11)
        self.assert_packet(pendant, selected(0, 1))
        pendant.report(selector=0x16)
        self.assert_packet(pendant, selected(1, 0))
        assert pendant.stat('unknown_keys') == 1
        pendant.report(selector=0x16)
        self.assert_silent(pendant)
        assert pendant.stat('unknown_keys') == 1
        pendant.report(selector=0x12)
        self.assert_packet(pendant, selected(0, 2))

    @pytest.mark.parametrize('model', SELECTOR)
    def test_every_other_code_is_off(self, model):
        pendant = self.plug(model)
        # 00h, which a WHB04B only sends on falling asleep, is off and known
        unknown = [code for code in range(1, 256) if code not in SELECTOR[model]]
        for code in unknown:
            pendant.report(selector=0x11)
            self.assert_packet(pendant, selected(0, 1))
            pendant.report(selector=code)
            self.assert_packet(pendant, selected(1, 0))
        assert pendant.stat('unknown_keys') == len(unknown)


class TestWheel(Case):
    def test_every_value(self):
        pendant = self.plug()
        for detents in range(-128, 128):
            if detents:
                pendant.report(wheel=detents)
                self.assert_packet(pendant, turned(detents))

    def test_each_report_counts(self):
        pendant = self.plug()
        for _ in range(10):
            pendant.report(wheel=-3)
        assert [pendant.packet() for _ in range(10)] == [turned(-3)] * 10

    def test_a_busy_reader_loses_nothing(self):
        """A second of reports at the full rate of the bus, without reading."""
        pendant = self.plug()
        for number in range(500):
            pendant.report(wheel=1 if number % 3 else -1)
        assert rig.wait(lambda: pendant.stat('reports') == 500)
        assert [pendant.packet() for _ in range(500)] == \
                         [turned(1 if number % 3 else -1) for number in range(500)]

    def test_zero_says_nothing(self):
        pendant = self.plug()
        pendant.report(wheel=0)
        self.assert_silent(pendant)
        assert pendant.stat('reports') == 2


class TestOrder(Case):
    def test_selector_keys_wheel(self):
        pendant = self.plug()
        pendant.report(1, 2, 0x11, 5)
        self.assert_packet(pendant, selected(0, 1) + pressed(1) + pressed(2) + turned(5))
        pendant.report(3, 2, 0x12, -5)
        self.assert_packet(pendant, selected(1, 2) + released(1) + pressed(3) + turned(-5))
        pendant.report(0, 0, 0, 1)
        packet = pendant.packet()
        assert packet[:2] == selected(2, 0)
        assert packet[-1:] == turned(1)
        assert sorted(packet[2:-1]) == sorted(released(2) + released(3))

    def test_a_thousand_reports_in_a_row(self):
        pendant = self.plug()
        for number in range(1000):
            pendant.report(key1=1 + number % 2, wheel=1)
            if number % 10 == 9:        # the buffer of evdev holds some hundred events
                for _ in range(10):
                    assert pendant.packet()[-1:] == turned(1)
        assert pendant.stat('reports') == 1000
        assert pendant.stat('bad_reports') == 0


class TestSleep(Case):
    @pytest.mark.distro
    def test_all_up_in_one_packet(self):
        pendant = self.plug()
        pendant.report(1, 2, 0x13)
        pendant.packet()
        pendant.asleep()
        self.assert_packet(pendant, selected(3, 0) + released(1) + released(2))
        pendant.asleep()
        self.assert_silent(pendant)

    def test_awake(self):
        pendant = self.plug()
        assert pendant.get('awake') == '0'
        pendant.report()
        assert rig.wait(lambda: pendant.get('awake') == '1')
        pendant.asleep()
        assert rig.wait(lambda: pendant.get('awake') == '0')

    def test_idle_is_not_sleep(self):
        pendant = self.plug()
        assert pendant.device.pendant.day != 0
        pendant.report()
        pendant.report(1)
        pendant.packet()
        assert pendant.get('awake') == '1'

    def test_poll_on_awake(self):
        pendant = self.plug()
        with open(pendant.file('awake'), 'rb', buffering=0) as awake:
            poll = select.poll()
            poll.register(awake, select.POLLPRI)
            assert awake.read() == b'0\n'
            poll.poll(0)                # the state before the first read
            awake.seek(0)
            awake.read()
            for report, text in ((pendant.report, b'1\n'), (pendant.asleep, b'0\n')):
                assert poll.poll(100) == []
                report()
                assert poll.poll(rig.PATIENCE * 1000), 'poll() does not wake'
                awake.seek(0)
                assert awake.read() == text

    @staticmethod
    def watch(fd, ends):
        """Polls and reads `awake` like a program that waits without a limit.

        At its timeout poll() checks again and finds the file removed, so the time is measured.
        """
        poll = select.poll()
        poll.register(fd, select.POLLPRI)
        while True:
            try:
                os.pread(fd, 8, 0)
            except OSError as error:
                ends.append(errno.errorcode[error.errno])
                return
            start = time.monotonic()
            poll.poll(rig.PATIENCE * 1000)
            if time.monotonic() - start > rig.PATIENCE / 2:
                ends.append('poll() does not wake')
                return

    def test_poll_on_awake_ends_at_unplug(self):
        for asleep in (True, False):
            for way in ('unplug', 'unbind'):
                with row(asleep=asleep, way=way):
                    pendant, ends = self.plug(), []
                    if not asleep:
                        pendant.report(1)
                        pendant.packet()
                    fd = os.open(pendant.file('awake'), os.O_RDONLY)
                    self.add_cleanup(os.close, fd)
                    watcher = threading.Thread(target=self.watch, args=(fd, ends))
                    watcher.start()
                    time.sleep(0.2)         # the thread is in poll() now
                    getattr(pendant, way)()
                    watcher.join()
                    assert ends == ['ENODEV']

    def test_node_stays_while_asleep(self):
        pendant = self.plug()
        pendant.report(selector=0x11)
        pendant.asleep()
        pendant.report(selector=0x11, wheel=1)
        assert [pendant.packet() for _ in range(3)] == \
                         [selected(0, 1), selected(1, 0), selected(0, 1) + turned(1)]


class TestLetting(Case):
    """Keys are released and the selector is off after removal of the pendant or its driver."""

    @pytest.mark.distro
    def test_unplug(self):
        pendant = self.plug()
        self.assert_lets_go(pendant, pendant.device.unplug)

    def test_unbind(self):
        pendant = self.plug()
        self.assert_lets_go(pendant, pendant.unbind)

    @pytest.mark.distro
    @pytest.mark.smoke
    def test_module_removal(self):
        pendant = self.plug()
        self.add_cleanup(rig.load)
        self.assert_lets_go(pendant, rig.unload)


class TestRemap(Case):
    def entry(self, pendant, scan):
        """-> key code of a scan code by both ioctls"""
        old = struct.pack('<II', scan, 0)
        old = fcntl.ioctl(pendant.reader.fd, EVIOCGKEYCODE, old)
        new = KEYMAP_ENTRY.pack(0, 4, 0, 0, struct.pack('<I', scan))
        new = fcntl.ioctl(pendant.reader.fd, EVIOCGKEYCODE_V2, new)
        code = struct.unpack('<II', old)[1]
        assert KEYMAP_ENTRY.unpack(new)[3] == code
        return code

    def remap(self, pendant, scan, code):
        entry = KEYMAP_ENTRY.pack(0, 4, 0, code, struct.pack('<I', scan))
        fcntl.ioctl(pendant.reader.fd, EVIOCSKEYCODE_V2, entry)
        pendant.look_again()

    def test_keymap(self):
        pendant = self.plug()
        for scan in range(1, 0x18):
            assert self.entry(pendant, scan) == BTN_TRIGGER_HAPPY1 + scan - 1
        for position in range(1, 7):
            assert self.entry(pendant, 0x20 + position) == \
                             BTN_TRIGGER_HAPPY1 + 30 + position - 1
        for scan in (0x27, 0x100, 0xFFFFFFFF):
            with pytest.raises(OSError) as caught:
                self.entry(pendant, scan)
            assert caught.value.errno == errno.EINVAL

    def test_key(self):
        pendant = self.plug()
        self.remap(pendant, 0x04, KEY_A)
        assert self.entry(pendant, 0x04) == KEY_A
        pendant.report(0x04)
        self.assert_packet(pendant, pressed(4, 'KEY_A'))
        pendant.report()
        self.assert_packet(pendant, released(4, 'KEY_A'))

    def test_by_the_old_ioctl(self):
        pendant = self.plug()
        fcntl.ioctl(pendant.reader.fd, EVIOCSKEYCODE, struct.pack('<II', 0x05, KEY_B))
        pendant.look_again()
        pendant.report(0x05)
        self.assert_packet(pendant, pressed(5, 'KEY_B'))

    def test_selector_button(self):
        pendant = self.plug()
        self.remap(pendant, 0x21, KEY_A)
        pendant.report(selector=0x11)
        self.assert_packet(pendant, [('EV_ABS', 'ABS_MISC', 1), ('EV_KEY', 'KEY_A', 1)])
        pendant.report()
        self.assert_packet(pendant, [('EV_ABS', 'ABS_MISC', 0), ('EV_KEY', 'KEY_A', 0)])

    def test_while_held_nothing_stays_down(self):
        pendant = self.plug()
        pendant.report(0x04, 0, 0x11)
        pendant.packet()
        self.remap(pendant, 0x04, KEY_A)
        self.remap(pendant, 0x21, KEY_B)
        assert pendant.reader.keys_down() == []
        pendant.report(0x04, 0x05, 0x11)
        # no KEY_A: that was not a press; but the selector is always reported
        self.assert_packet(pendant, [('EV_KEY', 'KEY_B', 1)] + pressed(5))
        pendant.report()
        pendant.look_again()
        assert pendant.reader.keys_down() == []

    def test_two_keys_on_one_code(self):
        """It is down while either key is down."""
        pendant = self.plug()
        self.remap(pendant, 0x02, BTN_TRIGGER_HAPPY1)
        pendant.report(1, 2)
        assert [event for event in pendant.packet() if event[0] == 'EV_KEY'] == \
                         [('EV_KEY', KEY[1], 1)]
        pendant.report(2)
        self.assert_packet(pendant, [('EV_MSC', 'MSC_SCAN', 1)])
        pendant.report()
        assert ('EV_KEY', KEY[1], 0) in pendant.packet()

    def test_for_this_pendant_only(self):
        one, two = self.plug(), self.plug()
        self.remap(one, 1, KEY_A)
        two.report(1)
        self.assert_packet(two, pressed(1))


class TestEvtest(Case):
    @pytest.mark.distro
    def test_stream(self):
        pendant = self.plug()
        evtest = subprocess.Popen(['evtest', pendant.event_node], stdout=subprocess.PIPE,
                                  text=True, env={**os.environ, 'LC_ALL': 'C'})
        self.add_cleanup(evtest.stdout.close)
        text = ''
        while 'Testing' not in text:
            text += evtest.stdout.readline()
        pendant.report(0x16, 0, 0x11, -2)
        while 'SYN_REPORT' not in text:
            line = evtest.stdout.readline()
            assert line, 'evtest ended'
            text += line
        evtest.kill()
        evtest.wait()
        for part in ('Input device name: "XHC HB04 Pendant"',
                     'bus 0x3 vendor 0x10ce product 0xeb70', '(ABS_MISC), value 1',
                     '(BTN_TRIGGER_HAPPY31), value 1', '(MSC_SCAN), value 16',
                     '(BTN_TRIGGER_HAPPY22), value 1', '(REL_DIAL), value -2'):
            assert part in text

    def query(self, pendant, code):
        return subprocess.run(['evtest', '--query', pendant.event_node, 'EV_KEY', str(code)],
                              check=False, stdout=subprocess.DEVNULL).returncode

    def test_query(self):
        pendant = self.plug()
        assert self.query(pendant, BTN_TRIGGER_HAPPY1) == 0
        pendant.report(1, 0, 0x12)
        pendant.packet()
        assert self.query(pendant, BTN_TRIGGER_HAPPY1) == EVTEST_DOWN
        assert self.query(pendant, BTN_TRIGGER_HAPPY1 + 31) == EVTEST_DOWN
        assert self.query(pendant, BTN_TRIGGER_HAPPY1 + 30) == 0
        pendant.asleep()
        pendant.packet()
        assert self.query(pendant, BTN_TRIGGER_HAPPY1) == 0
        assert self.query(pendant, BTN_TRIGGER_HAPPY1 + 31) == 0


class TestHidraw(Case):
    def open(self, pendant):
        fd = os.open(pendant.hidraw_node, os.O_RDWR | os.O_NONBLOCK)
        self.add_cleanup(os.close, fd)
        return fd

    def test_sees_what_evdev_sees(self):
        pendant = self.plug()
        fd = self.open(pendant)
        pendant.report(2, 0, 0x11, 1)
        self.assert_packet(pendant, selected(0, 1) + pressed(2) + turned(1))
        assert os.read(fd, 64) == bytes([4, 2, 0, 0x11, 1,
                                                 pendant.device.pendant.day ^ 2])

    def test_feature_report(self):
        pendant = self.plug()
        pendant.settle()
        before = len(pendant.device.set_reports)
        fcntl.ioctl(self.open(pendant), hidiocsfeature(8), bytearray(b'\x06abcdefg'))
        assert [report.data for report in
                          list(pendant.device.set_reports)[before:]] == [b'\x06abcdefg']

    def test_descriptor_is_the_devices_own(self):
        pendant = self.plug()
        descriptor = bytearray(4 + 4096)
        struct.pack_into('<I', descriptor, 0, 46)
        fcntl.ioctl(self.open(pendant), 0x90044802, descriptor)
        assert bytes(descriptor[4:50]) == pendant.device.model.report_descriptor

    def test_unplug_while_open(self):
        pendant = self.plug()
        fd = self.open(pendant)
        pendant.unplug()
        with pytest.raises(OSError):
            fcntl.ioctl(fd, hidiocsfeature(8), bytearray(b'\x06abcdefg'))


class TestCounters(Case):
    def test_reports(self):
        pendant = self.plug()
        for _ in range(7):
            pendant.report()
        assert rig.wait(lambda: pendant.stat('reports') == 7)
        assert pendant.stat('bad_reports') == 0
        assert pendant.stat('xor_mismatches') == 0

    def test_xor_mismatch_is_counted_and_not_dropped(self):
        pendant = self.plug()
        day = pendant.device.pendant.day
        pendant.report(1, day=day ^ 5)
        self.assert_packet(pendant, pressed(1))
        pendant.report(2)
        self.assert_packet(pendant, released(1) + pressed(2))
        assert pendant.stat('xor_mismatches') == 1

    def test_report_before_the_frame_has_returned_is_no_mismatch(self):
        pendant = self.plug()
        pendant.device.on_frame = lambda picture: pendant.report(1, day=picture.day)
        pendant.set('day', str(pendant.device.pendant.day % 28 + 1))
        self.assert_packet(pendant, pressed(1))
        assert pendant.stat('xor_mismatches') == 0

    def test_sleep_is_no_mismatch(self):
        pendant = self.plug()
        pendant.report(1)
        pendant.asleep()
        pendant.packet()
        pendant.packet()
        assert pendant.stat('xor_mismatches') == 0

    def test_each_pendant_counts_for_itself(self):
        one, two = self.plug(), self.plug()
        one.report(0x80)
        one.packet()
        assert (one.stat('reports'), two.stat('reports')) == (1, 0)
        assert (one.stat('unknown_keys'), two.stat('unknown_keys')) == (1, 0)
