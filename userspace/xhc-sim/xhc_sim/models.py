# SPDX-License-Identifier: GPL-2.0-only
"""Differences between the pendant models: one table.

HB03 and HB04: key codes, selector codes and the layout of the display frame are from the seed
document "XHC xHB03 & xHB04 internals"; the report descriptor, the USB descriptors and the meaning
of the selector codes 14h and 15h are from the project's protocol rulings.  WHB04B: everything is
from the rulings, which are based on programs for real units.  Nothing is shared with the driver.
"""

from . import hands, lcd, whb04b
from .lcd import STEPS
from .wire import CHUNK_SIZE, FEATURE_ID, MANUFACTURER, VENDOR

__all__ = ['CHUNK_SIZE', 'FEATURE_ID', 'MANUFACTURER', 'MODELS', 'Model', 'REPORT_DESCRIPTOR',
           'STEPS', 'VENDOR', 'get_model']

# Two application collections on a vendor page: input report 4 with five data bytes, feature
# report 6 with seven.
REPORT_DESCRIPTOR = bytes.fromhex(
    '06 00 FF 09 01 A1 01 85 04 09 01 15 00 26 FF 00 95 05 75 08 81 02 C0'
    '06 00 FF 09 01 A1 01 85 06 09 01 15 00 26 FF 00 95 07 75 08 B1 06 C0')
# The same shape with seven input data bytes, and FF00h for the logical maximum.
REPORT_DESCRIPTOR_WHB04B = bytes.fromhex(
    '06 00 FF 09 01 A1 01 85 04 09 01 15 00 26 00 FF 75 08 95 07 81 02 C0'
    '06 00 FF 09 01 A1 01 85 06 09 01 15 00 26 00 FF 75 08 95 07 B1 06 C0')

KEYS_HB03 = {
    0x17: 'Yes', 0x16: 'No', 0x01: 'Stop', 0x02: 'Start/Pause', 0x03: 'Rewind', 0x04: 'Probe-Z',
    0x0C: 'Goto zero', 0x06: 'X/2=', 0x07: 'Y/2=', 0x08: 'Safe-Z', 0x09: 'X=0', 0x0A: 'Y=0',
    0x0B: 'Z=0', 0x05: 'Goto home', 0x0D: 'Step left', 0x0E: 'Step right', 0x0F: 'Fine xyz',
    0x10: 'Spindle',
}
KEYS_HB04 = {
    0x17: 'Reset', 0x16: 'Stop', 0x01: 'Goto zero', 0x02: 'Start/Pause', 0x03: 'Rewind',
    0x04: 'Probe-Z', 0x0C: 'Spindle', 0x06: '1/2=', 0x07: '0=', 0x08: 'Safe-Z',
    0x09: 'Goto home', 0x0A: 'Macro 1', 0x0B: 'Macro 2', 0x05: 'Macro 3', 0x0D: 'STEP++',
    0x0E: 'MPG/MODE', 0x0F: 'Macro 6', 0x10: 'Macro 7',
}

KEYS_WHB04B = {
    0x01: 'Reset', 0x02: 'Stop', 0x03: 'Start/Pause', 0x04: 'Feed+', 0x05: 'Feed-',
    0x06: 'Spindle+', 0x07: 'Spindle-', 0x08: 'M-Home', 0x09: 'Safe-Z', 0x0A: 'W-Home',
    0x0B: 'Spindle on/off', 0x0C: 'Fn', 0x0D: 'Probe-Z', 0x0E: 'Continuous/MPG', 0x0F: 'Step',
    0x10: 'Macro 10',
}

# The rotary switch, clockwise from "off".
SELECTOR_HB03 = {
    'off': 0x00, 'x': 0x11, 'y': 0x12, 'z': 0x13, 'feed': 0x14, 'spindle': 0x15, 'speed': 0x18,
}
SELECTOR_HB04 = {
    'off': 0x00, 'x': 0x11, 'y': 0x12, 'z': 0x13, 'a': 0x18, 'spindle': 0x14, 'feed': 0x15,
}

SELECTOR_WHB04B = {
    'off': 0x06, 'x': 0x11, 'y': 0x12, 'z': 0x13, 'a': 0x14, 'b': 0x15, 'c': 0x16,
}

# The second rotary switch of the WHB04B, by its meaning in all modes except "step".
FEED_WHB04B = {
    '2%': 0x0D, '5%': 0x0E, '10%': 0x0F, '30%': 0x10, '60%': 0x1A, '100%': 0x1B,
    'lead': whb04b.LEAD,
}


class Model:
    """One row: all differences between the models."""

    def __init__(self, name, product, *, descriptor, input_size, packet_size, frame_size, decimals,
                 keys, selector, feed, states, hands, picture, blank, stream_period):
        self.name = name
        self.product = product
        self.report_descriptor = descriptor
        self.input_size = input_size            # bytes of an input report
        self.packet_size = packet_size          # of the interrupt endpoint
        self.interval = 2                       # of the interrupt endpoint, in ms
        self.frame_size = frame_size            # bytes of a display frame
        self.chunks = -(-frame_size // CHUNK_SIZE)
        self.decimals = decimals                # digits after the point on the LCD
        self.fraction_size = 1 if decimals == 2 else 2
        self.keys = keys                        # scan code -> label
        self.selector = selector                # position -> code
        self.feed = feed                        # position of the second rotary -> code
        self.states = states                    # bit of the state byte -> word on the LCD
        self.hands = hands                      # class: operation -> input reports
        self.picture = picture                  # class: a frame -> contents of the LCD
        self.blank = blank                      # function: the LCD before the first frame
        self.stream_period = stream_period      # seconds between reports that stream, None: none

    def key_code(self, text):
        """Scan code for a label ("Start/Pause", any case) or a number; ValueError if neither."""
        wanted = text.strip().lower()
        for code, name in self.keys.items():
            if name.lower() == wanted:
                return code
        return _byte(text, 'key')

    def key_codes(self, text):
        """Scan codes for a key, or for one with Fn: "Fn+Stop"; ValueError if there is none."""
        first, plus, second = text.partition('+')
        fn = [code for code, name in self.keys.items() if name == 'Fn']
        if fn and plus and first.strip().lower() == 'fn':
            return fn + [self.key_code(second)]
        return [self.key_code(text)]

    def selector_code(self, text):
        """Code for a selector position or a number; ValueError if neither."""
        wanted = text.strip().lower()
        if wanted in self.selector:
            return self.selector[wanted]
        return _byte(text, 'selector position')

    def selector_name(self, code):
        return _name(self.selector, code)

    def feed_code(self, text):
        """Code for a position of the second rotary or a number; ValueError if neither."""
        if not self.feed:
            raise ValueError('the %s has no second rotary' % self.name)
        wanted = text.strip().lower()
        if wanted in self.feed:
            return self.feed[wanted]
        return _byte(text, 'position of the second rotary')

    def feed_name(self, code):
        return _name(self.feed, code)


def _name(table, code):
    for name, known in table.items():
        if known == code:
            return name
    return '0x%02x' % code


def _byte(text, what):
    try:
        value = int(text, 0)
    except ValueError:
        raise ValueError('unknown %s: %s' % (what, text)) from None
    if not 0 <= value <= 255:
        raise ValueError('%s out of range: %s' % (what, text))
    return value


MODELS = {model.name: model for model in (
    Model('HB03', 0xEB6E, descriptor=REPORT_DESCRIPTOR, input_size=6, packet_size=64,
          frame_size=31, decimals=2, keys=KEYS_HB03, selector=SELECTOR_HB03, feed={},
          states={0x01: 'run', 0x02: 'pause'},
          hands=hands.Pendant, picture=lcd.Picture, blank=lcd.blank, stream_period=None),
    Model('HB04', 0xEB70, descriptor=REPORT_DESCRIPTOR, input_size=6, packet_size=64,
          frame_size=37, decimals=4, keys=KEYS_HB04, selector=SELECTOR_HB04, feed={},
          states={0x01: 'run', 0x02: 'pause', 0x80: 'inch'},
          hands=hands.Pendant, picture=lcd.Picture, blank=lcd.blank, stream_period=None),
    Model('WHB04B', 0xEB93, descriptor=REPORT_DESCRIPTOR_WHB04B, input_size=8, packet_size=8,
          frame_size=21, decimals=4, keys=KEYS_WHB04B, selector=SELECTOR_WHB04B, feed=FEED_WHB04B,
          states={}, hands=whb04b.Pendant, picture=whb04b.Picture, blank=whb04b.blank,
          stream_period=whb04b.STREAM_PERIOD),
)}


def get_model(name):
    """A Model by name, any case; ValueError if there is none."""
    try:
        return MODELS[name.upper()]
    except KeyError:
        raise ValueError('unknown model: %s (there are: %s)'
                         % (name, ' '.join(MODELS))) from None
