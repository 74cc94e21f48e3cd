# SPDX-License-Identifier: GPL-2.0-only
"""Report descriptors that the driver must refuse, and unusual ones that it must accept."""

from xhc_sim.models import REPORT_DESCRIPTOR


def item(prefix, value=None, size=0):
    """One short item of a report descriptor."""
    return bytes([prefix | {0: 0, 1: 1, 2: 2, 4: 3}[size]]) + (
        value.to_bytes(size, 'little') if size else b'')


def collection(report_id, count, main, bits=8):
    """An application collection with one report: main is 81h input, 91h output, B1h feature."""
    return (bytes.fromhex('0600FF0901A101') + item(0x84, report_id, 1) +
            bytes.fromhex('0901150026FF00') + item(0x94, count, 2) + item(0x74, bits, 1) +
            bytes([main, 0x02, 0xC0]))


INPUT, OUTPUT, FEATURE = 0x81, 0x91, 0xB1
GOOD_INPUT, GOOD_FEATURE = collection(4, 5, INPUT), collection(6, 7, FEATURE)

REFUSED = {
    'no input report': GOOD_FEATURE,
    'no feature report': GOOD_INPUT,
    'neither': collection(1, 5, INPUT),
    'input report 5 for 4': collection(5, 5, INPUT) + GOOD_FEATURE,
    'feature report 7 for 6': GOOD_INPUT + collection(7, 7, FEATURE),
    'report 4 is an output': collection(4, 5, OUTPUT) + GOOD_FEATURE,
    'report 4 is a feature': collection(4, 5, FEATURE) + GOOD_FEATURE,
    'report 6 is an output': GOOD_INPUT + collection(6, 7, OUTPUT),
    'report 6 is an input': GOOD_INPUT + collection(6, 7, INPUT),
    'input of 4 bytes': collection(4, 4, INPUT) + GOOD_FEATURE,
    'input of 6 bytes': collection(4, 6, INPUT) + GOOD_FEATURE,
    'input of 39 bits': collection(4, 39, INPUT, 1) + GOOD_FEATURE,
    'input of 41 bits': collection(4, 41, INPUT, 1) + GOOD_FEATURE,
    'input of 1000 bytes': collection(4, 1000, INPUT) + GOOD_FEATURE,
    'feature of 0 bytes': GOOD_INPUT + collection(6, 0, FEATURE),
    'feature of 1 byte': GOOD_INPUT + collection(6, 1, FEATURE),
    'feature of 6 bytes': GOOD_INPUT + collection(6, 6, FEATURE),
    'feature of 55 bits': GOOD_INPUT + collection(6, 55, FEATURE, 1),
    'nothing but an end': b'\xc0',
    'no main item': bytes.fromhex('0600FF0901'),
    'zeros': bytes(46),
    'ones': b'\xff' * 46,
    'no ids': bytes.fromhex('0600FF0901A1010901150026FF009505750881020901950775 08B102C0'),
    'larger than HID allows': collection(4, 0xFFFF, INPUT) + GOOD_FEATURE,
    'feature larger than HID allows': GOOD_INPUT + collection(6, 0xFFFF, FEATURE),
    'four kilobytes of pushes': b'\xa4' * 4096,
    'four kilobytes of collections': b'\xa1\x01' * 2048,
}
ACCEPTED = {
    'as the real one': REPORT_DESCRIPTOR,
    'the other way round': GOOD_FEATURE + GOOD_INPUT,
    'input of 40 bits': collection(4, 40, INPUT, 1) + GOOD_FEATURE,
    'feature of 8 bytes': GOOD_INPUT + collection(6, 8, FEATURE),
    'feature of 63 bytes': GOOD_INPUT + collection(6, 63, FEATURE),
    'feature of 1000 bytes': GOOD_INPUT + collection(6, 1000, FEATURE),
    'more reports': GOOD_INPUT + collection(5, 60, INPUT) + GOOD_FEATURE + collection(
        7, 30, FEATURE) + collection(9, 8, OUTPUT),
    'a keyboard beside it': REPORT_DESCRIPTOR + bytes.fromhex(
        '05010906A1018501050719E029E71500250175019508810295067508150025650507190029658100C0'),
}
