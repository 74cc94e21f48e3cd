# SPDX-License-Identifier: GPL-2.0-only
"""The examples of userspace/doc/protocol-xhc.md, converted by the virtual pendant

Each function takes (about, bytes, words) and returns bytes and words of the simulator.
"""

import re
from decimal import ROUND_HALF_UP, Decimal

from xhc_sim import lcd, models, pendant


def report(about, data, words):
    """Applies the words to a pendant -> its report"""
    device = pendant.Pendant(models.get_model(about))
    fields = [field.rpartition(' ')[::2] for field in words.split(', ')]
    if words == 'asleep':
        return device.sleep(), words
    wheel = 0
    for name, value in fields:
        if name == 'key':
            device.press(int(value, 16))
        elif name == 'selector':
            device.select(device.model.selector[value])
        elif name == 'wheel':
            wheel = int(value)
        elif name == 'day':
            device.day = int(value)
        else:
            return data, 'unknown: ' + name
    return device.turn(wheel), words


def selector(about, data, _):
    name = models.get_model(about).selector_name(data[0])
    if name == '0x%02x' % data[0]:
        return data, 'unknown'
    return data, {'speed': 'a'}.get(name, name)     # same position, other name on the HB03


def picture_with(about, at, data):
    """A picture that is empty except for these bytes"""
    model = models.get_model(about)
    frame = bytearray(lcd.MAGIC + bytes([1]) + bytes(model.frame_size - 3))
    frame[at:at + len(data)] = data
    return lcd.Picture(model, frame)


def position(about, data, words):
    """Compares the displayed number with another way of rounding"""
    written = words.split()[0]
    picture = picture_with(about, 3, data)
    shown = picture.coordinates['work_x']
    rounded = Decimal(written).quantize(Decimal(1).scaleb(-picture.model.decimals), ROUND_HALF_UP)
    if picture.faults or Decimal(shown) != rounded:
        return data, '%s, %s' % (picture.faults, rounded)
    return data, '%s  %s' % (written, shown)


def step(_, data, __):
    picture = picture_with('HB04', models.get_model('HB04').frame_size - 2, data)
    return data, 'step %s, icon %d' % ('unknown' if picture.step is None else picture.step,
                                       picture.icon)


def state(about, data, _):
    picture = picture_with(about, models.get_model(about).frame_size - 1, data)
    return data, picture.state_text()


def picture(about, data, words):
    """Sends all reports to the pendant -> the content of its LCD"""
    model = models.get_model(about)
    assembler, frames = lcd.Assembler(model), []
    for at in range(0, len(data), 1 + models.CHUNK_SIZE):
        if data[at] != models.FEATURE_ID:
            return data, 'report %02x' % data[at]
        frames.append(assembler.feed(data[at + 1:at + 1 + models.CHUNK_SIZE]))
    if len([frame for frame in frames if frame]) != 1 or not frames[-1] or assembler.stray:
        return data, 'no frame'
    fields = lcd.Picture(model, frames[-1]).as_dict()
    if fields['faults']:
        return data, ', '.join(fields['faults'])
    names = re.findall(r'(\w+) [^,]+', words)
    if len(set(names)) != len(names) or set(names) != set(lcd.COORDINATES + lcd.NUMBERS +
                                                          ('day', 'step', 'icon', 'state')):
        return data, 'not all fields once: %s' % names
    for name in lcd.COORDINATES:
        fields[name] = lcd.normal_number(fields[name])
    return data, ', '.join('%s %s' % (name, fields[name]) for name in names)


KINDS = {'report': report, 'selector': selector, 'position': position, 'step': step,
         'state': state, 'picture': picture}
