# SPDX-License-Identifier: GPL-2.0-only
"""What is broken in the pendant's driver, hid-xhc."""

from . import KERNEL, SIM, Driver, Mutation

MUTATIONS = (
    Mutation('off-by-one in the fraction', 'xhc-codec.c',
             '\tfraction = magnitude % scale;\n',
             '\tfraction = magnitude % scale + (magnitude % scale > 0);\n'),
    Mutation('dropped sign', 'xhc-codec.c',
             'negative = units < 0 && magnitude;',
             'negative = false;'),
    Mutation('swapped chunks', 'xhc-codec.c',
             'size_t start = index * XHC_CHUNK_PAYLOAD;',
             'size_t start = (index ^ 1) * XHC_CHUNK_PAYLOAD;'),
    Mutation('no carry', 'xhc-codec.c',
             'put_unaligned_le16(magnitude / scale, p);',
             'put_unaligned_le16(xhc_magnitude(units) / 10000, p);'),
    Mutation('wrong magic order', 'xhc-codec.c',
             '*p++ = XHC_MAGIC_0;\n\t*p++ = XHC_MAGIC_1;',
             '*p++ = XHC_MAGIC_1;\n\t*p++ = XHC_MAGIC_0;'),
    Mutation('key slot 2 ignored', 'xhc-codec.c',
             'in->key[i] = report->key[i];',
             'in->key[i] = i ? 0 : report->key[i];'),
    Mutation('day 0', 'xhc-codec.c',
             'if (display->day < 1 || display->day > XHC_DAY_MAX)',
             'if (display->day > XHC_DAY_MAX)'),
    Mutation('sign of wheel', 'xhc-codec.c',
             'in->wheel = report->wheel;',
             'in->wheel = -report->wheel;'),
    Mutation('one key too many up', 'xhc-codec.c',
             'if (!from[i] || xhc_key_in(from[i], other))',
             'if (!from[i] || (down && xhc_key_in(from[i], other)))'),
    Mutation('selector before keys swapped', 'xhc-input.c',
             '\txhc_emit_selector(evdev, in, selector_was);\n'
             '\tunknown += xhc_emit_keys(evdev, in, was);\n',
             '\tunknown += xhc_emit_keys(evdev, in, was);\n'
             '\txhc_emit_selector(evdev, in, selector_was);\n',
             KERNEL),
    # beyond the list of the ten
    Mutation('half is rounded down', 'xhc-codec.c',
             '(magnitude % step >= (step + 1) / 2)',
             '(magnitude % step > (step + 1) / 2)'),
    Mutation('feed and spindle of HB04 as in the document', 'xhc-codec.c',
             '{ 0x15, XHC_SEL_FEED }, { 0x14, XHC_SEL_SPINDLE }',
             '{ 0x14, XHC_SEL_FEED }, { 0x15, XHC_SEL_SPINDLE }'),
    Mutation('keys stay down on suspend and unplug', 'xhc-input.c',
             '\txhc_input_release(evdev);\n',
             '', KERNEL),
    Mutation('an unchanged frame is sent again', 'xhc-dro.c',
             'if (!force && size == dro->shown_size',
             'if (!force && !size && size == dro->shown_size', SIM),
    Mutation('frames follow one another at once', 'xhc-dro.c',
             'err ? XHC_RETRY_MS : dro->refresh_ms',
             'err ? XHC_RETRY_MS : 0', SIM),
)

DRIVER = Driver(
    sources='drivers/hid-xhc',
    host={'xhc_codec_test': 'hid_xhc_codec'},
    kernel=('hid_xhc_driver',),
    sim='dro',
    mutations=MUTATIONS,
)
