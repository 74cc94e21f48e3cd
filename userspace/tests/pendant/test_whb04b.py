# SPDX-License-Identifier: GPL-2.0-only
"""The WHB04B: differences of its reports and its display to those of HB03 and HB04."""

import os
import random
import threading
import time

import pytest
from case import row
from raw_gadget import GadgetPendant
import rig
from rig import Case, pressed, read_file, released, selected, turned, write_file
from xhc_sim.models import MODELS, REPORT_DESCRIPTOR, REPORT_DESCRIPTOR_WHB04B
from xhc_sim.uhid import UhidPendant
from xhc_sim.usb import UsbPendant
from xhc_sim.whb04b import LEAD_ON_OTHERS, MODES, NUMBERS, ROWS

WHB04B = MODELS['WHB04B']
X = 0x11
EVERY_BUS = pytest.mark.parametrize('bus', (UhidPendant, UsbPendant, GadgetPendant),
                                    ids=('uhid', 'usb', 'gadget'))


def fed(position):
    """The events of a turn of the second rotary"""
    return [('EV_ABS', 'ABS_THROTTLE', position)]


class TestEvents(Case):
    def test_capabilities_are_exactly_these(self):
        device = self.plug('WHB04B').reader.device
        have = {kind.name: sorted(code.name for code in codes)
                for kind, codes in device.evbits.items()}
        have.pop('EV_SYN')
        keys = [rig.KEY[number] for number in (*range(1, 0x11), 31, 32, 33, 34, 37, 38)]
        assert have == {'EV_KEY': sorted(keys), 'EV_REL': ['REL_DIAL'],
                        'EV_ABS': ['ABS_MISC', 'ABS_THROTTLE'], 'EV_MSC': ['MSC_SCAN']}
        for axis, maximum in (('ABS_MISC', 8), ('ABS_THROTTLE', 7)):
            info = device.absinfo[getattr(rig.libevdev.EV_ABS, axis)]
            assert (info.minimum, info.maximum, info.fuzz, info.flat) == (0, maximum, 0, 0)

    @pytest.mark.distro
    def test_second_rotary(self):
        pendant = self.plug('WHB04B')
        codes = {0x0D: 1, 0x0E: 2, 0x0F: 3, 0x10: 4, 0x1A: 5, 0x1B: 6, 0x1C: 7,
                 LEAD_ON_OTHERS: 7}
        for code, position in codes.items():
            with row(code=code):
                pendant.report(feed=0x0D if position != 1 else 0x0E)
                pendant.packet()
                pendant.report(feed=code)
                self.assert_packet(pendant, fed(position))
        unknown = [code for code in range(1, 256) if code not in codes]
        pendant.report(feed=unknown[0])
        self.assert_packet(pendant, fed(0))
        for code in unknown:
            pendant.report(feed=code)
        pendant.report(wheel=1, feed=unknown[-1])
        self.assert_packet(pendant, turned(1))
        assert pendant.stat('unknown_keys') == len(unknown)

    def test_keys_of_other_models_are_unknown(self):
        pendant = self.plug('WHB04B')
        for code in range(0x11, 0x18):
            pendant.report(code)
            self.assert_packet(pendant, [('EV_MSC', 'MSC_SCAN', code)])
        assert pendant.stat('unknown_keys') == 7

    def test_order(self):
        pendant = self.plug('WHB04B')
        pendant.report(0x0C, 1, 0x15, 5, feed=0x1C)
        self.assert_packet(pendant, selected(0, 7) + fed(7) + pressed(0x0C) + pressed(1) +
                           turned(5))
        pendant.report(1, 0, 0x16, -5, feed=0x0D)
        self.assert_packet(pendant, selected(7, 8) + fed(1) + released(0x0C) + turned(-5))

    @EVERY_BUS
    def test_by_hands(self, bus):
        """The unmodified virtual unit, with streamed reports, a seed, and r in each report"""
        pendant = self.plug_rig(rig.Rig(device=bus('WHB04B')))
        unit = pendant.device
        unit.select(X)
        self.assert_packet(pendant, selected(0, 1) + fed(1))
        unit.press(0x0C)
        self.assert_packet(pendant, pressed(0x0C))
        unit.press(0x02)
        self.assert_packet(pendant, pressed(0x02))
        unit.release(0x0C)
        self.assert_packet(pendant, released(0x0C))
        unit.turn(-7)
        self.assert_packet(pendant, turned(-7))
        unit.turn_feed(0x1B)
        self.assert_packet(pendant, fed(6))
        before = pendant.stat('reports')
        assert rig.wait(lambda: pendant.stat('reports') > before + 50), 'nothing streams'
        for trailing in ('empty', 'positions'):
            unit.pendant.trailing = trailing
            unit.release(0x02)
            self.assert_packet(pendant, released(0x02))
            unit.sleep()
            self.assert_packet(pendant, selected(1, 0) + fed(0))
            assert rig.wait(lambda: pendant.get('awake') == '0')
            unit.press(0x02)
            self.assert_packet(pendant, selected(0, 1) + fed(6) + pressed(0x02))
        unit.select(WHB04B.selector['off'])
        self.assert_packet(pendant, selected(1, 0))
        assert pendant.stat('xor_mismatches') == 0
        assert pendant.stat('unknown_keys') == 0

    def test_streams_wake_nobody(self):
        """Streamed reports do not wake a program that waits for events."""
        pendant = self.plug('WHB04B')
        pendant.device.select(X)
        self.assert_packet(pendant, selected(0, 1) + fed(1))
        before = pendant.stat('reports')
        assert pendant.packet(timeout=2) is None
        assert pendant.stat('reports') > before + 20

    @pytest.mark.distro
    def test_silence_lets_all_go(self):
        """The radio is interrupted during streaming, and works again later."""
        pendant = self.plug('WHB04B')
        pendant.device.select(X)
        pendant.device.press(0x04)
        self.assert_packet(pendant, selected(0, 1) + fed(1))
        self.assert_packet(pendant, pressed(4))
        before = pendant.stat('reports')
        assert rig.wait(lambda: pendant.stat('reports') > before + 5)
        pendant.device.streams = False
        self.assert_packet(pendant, selected(1, 0) + fed(0) + released(4))
        assert pendant.get('awake') == '0'
        pendant.device.streams = True
        pendant.device.press(0x04)
        self.assert_packet(pendant, selected(0, 1) + fed(1) + pressed(4))

    @pytest.mark.distro
    def test_lets_go(self):
        for way in ('unplug', 'unbind'):
            with row(way):
                pendant = self.plug('WHB04B')
                self.assert_lets_go(pendant, getattr(
                    pendant if way == 'unbind' else pendant.device, way))
                pendant.unplug()


class TestSeed(Case):
    def test_wrong_check_byte_is_counted_and_not_dropped(self):
        pendant = self.plug('WHB04B')
        frames = pendant.settle()
        pendant.random = 0xFF - 0x3B
        pendant.report(1, day=0x01)
        self.assert_packet(pendant, pressed(1))
        assert pendant.stat('xor_mismatches') == 1
        assert pendant.device.wait_frames(frames + 1, rig.PATIENCE)
        pendant.report(2)
        self.assert_packet(pendant, released(1) + pressed(2))
        assert pendant.stat('xor_mismatches') == 1

    def test_a_clone_that_never_matches(self):
        """Streamed reports with wrong check bytes do not cause a storm of frames."""
        pendant = self.plug('WHB04B')
        pendant.device.pendant.check_error = 0x40
        pendant.device.select(X)
        assert rig.wait(lambda: pendant.stat('xor_mismatches') > 100)
        assert pendant.stat('frames_sent') <= 3     # plugged in, woken up, the first mismatch


class TestDisplay(Case):
    def test_files(self):
        pendant = self.plug('WHB04B')
        assert set(os.listdir(pendant.path + '/dro')) == {
            *ROWS, *NUMBERS, 'rows', 'mode', 'coordinates', 'reset', 'refresh_ms', 'flush'}
        assert not os.path.exists(pendant.path + '/swap_feed_spindle')
        beginning = {'row1': '0', 'rows': '0 0 0', 'mode': 'continuous', 'coordinates': 'machine',
                     'reset': '0', 'feedrate_override': '0', 'refresh_ms': '50'}
        for name, text in beginning.items():
            assert pendant.get(name) == text, name
        other = self.plug('HB04')
        for name in ROWS + ('rows', 'mode', 'coordinates', 'reset'):
            assert not os.path.exists(other.path + '/dro/' + name)

    @pytest.mark.distro
    @pytest.mark.smoke
    def test_every_attribute_reaches_the_lcd(self):
        values = {'row1': '-220.334', 'row2': '0.0001', 'row3': '65535.9999',
                  'feedrate_override': '65535', 'spindle_override': '80', 'mode': 'mpg',
                  'coordinates': 'work', 'reset': '1'}
        pendant = self.plug('WHB04B')
        assert values.keys() == set(pendant.displayed)
        for name, value in values.items():
            with row(name):
                pendant.set(name, value)
                assert pendant.get(name) == value
                assert rig.wait(lambda name=name, value=value: pendant.shown(name) == value)
        assert {name: pendant.shown(name) for name in values} == values
        assert pendant.device.lcd.faults == []

    def test_everything_at_random(self):
        """Frames decoded by the simulator, which shares no code with the driver."""
        dice = random.Random(4)
        pendant = self.plug('WHB04B')
        for _ in range(60):
            wanted = {name: '%s%d.%04d' % (dice.choice(['', '-']), dice.randrange(1, 65536),
                                           dice.randrange(10000)) for name in ROWS}
            wanted.update({name: dice.randrange(65536) for name in NUMBERS})
            wanted.update(mode=dice.choice(MODES), reset=dice.randrange(2),
                          coordinates=dice.choice(('machine', 'work')))
            for name, value in wanted.items():
                pendant.set(name, str(value))
            shown = pendant.flush()
            assert {name: shown[name] for name in wanted} == wanted
            assert shown['faults'] == []

    def test_refused(self):
        pendant = self.plug('WHB04B')
        pendant.set('rows', '1 -2 3')
        frames = pendant.settle()
        for name, text, error in (
                ('rows', '1 2', 'EINVAL'), ('rows', '1 2 3 4', 'EINVAL'),
                ('rows', '1 x 3', 'EINVAL'), ('rows', '9 9 65536', 'ERANGE'),
                ('row2', 'x', 'EINVAL'), ('row2', '-65536', 'ERANGE'),
                ('mode', 'steps', 'EINVAL'), ('mode', '1', 'EINVAL'), ('mode', '\n', 'EINVAL'),
                ('coordinates', 'w', 'EINVAL'), ('coordinates', '0', 'EINVAL'),
                ('reset', '2', 'ERANGE'), ('reset', '-1', 'ERANGE'), ('reset', 'yes', 'EINVAL'),
                ('feedrate_override', '65536', 'ERANGE'), ('refresh_ms', '9', 'ERANGE')):
            with row(name, text=text):
                before = pendant.get(name)
                assert pendant.set_error(name, text) == error
                assert pendant.get(name) == before
        assert pendant.get('rows') == '1 -2 3'
        assert pendant.no_more_frames(frames)

    def test_the_sign_of_nothing(self):
        pendant = self.plug('WHB04B')
        pendant.set('rows', '-0.00001 -0.00005 1.99999')
        assert pendant.get('rows') == '0 -0.0001 2'
        shown = pendant.flush()
        assert [shown[name] for name in ROWS] == ['0.0000', '-0.0001', '2.0000']
        assert shown['faults'] == []

    def test_rows_are_taken_as_one(self):
        pendant = self.plug('WHB04B')
        pendant.set('refresh_ms', '10')
        mixed = []
        pendant.device.on_frame = lambda picture: mixed.extend(
            [picture] if len(set(picture.coordinates.values())) != 1 else [])
        writers = [threading.Thread(target=self.write_rows, args=(pendant, value))
                   for value in ('1.5', '-2.5')]
        for writer in writers:
            writer.start()
        for writer in writers:
            writer.join()
        pendant.flush()
        assert mixed == []

    @staticmethod
    def write_rows(pendant, value):
        for _ in range(300):
            pendant.set('rows', ' '.join([value] * 3))
            time.sleep(0.001)           # all threads share one processor

    def test_reset_is_shown_until_the_first_frame(self):
        pendant = self.plug('WHB04B')
        assert pendant.device.lcd.as_dict()['reset'] == 0

    def test_wake_up(self):
        """It may have lost frames that were sent while it slept."""
        pendant = self.plug('WHB04B')
        pendant.device.select(X)
        frames = pendant.settle()
        pendant.device.sleep()
        assert rig.wait(lambda: pendant.get('awake') == '0')
        pendant.device.wake()
        assert pendant.device.wait_frames(frames + 1, rig.PATIENCE)


class TestUsb(Case):
    def test_identity(self):
        pendant = self.plug_usb('WHB04B')
        assert read_file(pendant.path + '/modalias') == 'hid:b0003g0001v000010CEp0000EB93\n'
        sent = list(pendant.device.set_reports)[:3]
        assert [(r.wvalue, r.windex, len(r.data)) for r in sent] == [(0x0306, 0, 8)] * 3
        assert sent[0].data == bytes.fromhex('06 fe fd fe 00 00 00 00')

    def test_reset_in_place(self):
        """The driver is not notified; it detects this by the first check byte with the seed 01h."""
        pendant = self.plug_usb('WHB04B')
        pendant.settle()
        pendant.report()
        assert rig.wait(lambda: pendant.get('awake') == '1')
        frames = pendant.settle()
        pendant.device.forget()
        pendant.random = 0xFF - 0x3B
        pendant.report()
        assert pendant.device.wait_frames(frames + 1, rig.PATIENCE)


class TestHostile(Case):
    @pytest.mark.parametrize('model', MODELS)
    def test_reports_of_the_other_size(self, model):
        pendant, whb = self.plug(model), model == 'WHB04B'
        pendant.report(1, 0, X)
        pendant.packet()
        for size in (6, 8):
            for start in (4, 0x11, 0, 0, 1, 0), (4, 0x5A, 2, 3, 0x0D, 0x12):
                if (size == 8) != whb:
                    pendant.device.report(bytes(start).ljust(size, b'\x01'))
        self.assert_silent(pendant)
        assert pendant.stat('bad_reports') == 2

    def test_descriptors_of_the_other_model(self):
        for model, descriptor in (('WHB04B', REPORT_DESCRIPTOR),
                                  ('HB04', REPORT_DESCRIPTOR_WHB04B),
                                  ('HB03', REPORT_DESCRIPTOR_WHB04B)):
            with row(model):
                device = UhidPendant(model, report_descriptor=descriptor)
                device.plug()
                self.add_cleanup(device.unplug)
                path = rig.wait(lambda phys=device.phys: rig.find.hid_directory(phys))
                assert path
                assert not rig.takes(path)

    def test_every_byte_everywhere(self):
        pendant = self.plug('WHB04B')
        for at in range(1, 8):
            for value in range(256):
                data = bytearray.fromhex('04 ba 00 00 0e 11 00 ba')
                data[at] = value
                pendant.device.report(data)
        pendant.report(1)
        assert rig.wait(lambda: pendant.stat('reports') == 7 * 256 + 1)
        pendant.asleep()
        assert rig.wait(lambda: pendant.get('awake') == '0')
        pendant.look_again()
        assert pendant.reader.keys_down() == []

    def test_clone_by_new_id(self):
        self.add_cleanup(rig.load)
        self.add_cleanup(rig.unload)
        write_file(rig.DRIVER_DIR + '/new_id', '3 10ce eb91 eb93')
        clone = self.plug('WHB04B', product=0xEB91)
        assert clone.get('model') == 'WHB04B'
        assert clone.reader.device.id['product'] == 0xEB91
        clone.report(3, 0, 0x16)
        self.assert_packet(clone, selected(0, 8) + pressed(3))
        clone.set('mode', 'percent')
        assert clone.flush()['mode'] == 'percent'

    @pytest.mark.parametrize('product', (0xEA6A, 0xEB71, 0xEB73, 0xEB91), ids=hex)
    def test_ids_of_others_are_left_alone(self, product):
        device = UhidPendant('WHB04B', product=product)
        device.plug()
        self.add_cleanup(device.unplug)
        path = rig.wait(lambda: rig.find.hid_directory(device.phys))
        assert path
        assert not rig.takes(path)
