# SPDX-License-Identifier: GPL-2.0-only
"""An independent reader of PNG files: 8 bits, RGB or a palette, no filter."""

import struct
import zlib

RGB, INDEXED = 2, 3


def read(path):
    """-> rows of pixels, each three bytes"""
    with open(path, 'rb') as file:
        data = file.read()
    assert data[:8] == b'\x89PNG\r\n\x1a\n'
    at, parts = 8, {}
    while at < len(data):
        size, kind = struct.unpack_from('>I4s', data, at)
        body = data[at + 8:at + 8 + size]
        check, = struct.unpack_from('>I', data, at + 8 + size)
        assert check == zlib.crc32(kind + body)
        assert kind not in parts
        parts[kind] = body
        at += 12 + size
    width, height, *form = struct.unpack('>IIBBBBB', parts[b'IHDR'])
    assert form in ([8, RGB, 0, 0, 0], [8, INDEXED, 0, 0, 0])
    palette = parts.get(b'PLTE')
    assert list(parts) == [b'IHDR', *([b'PLTE'] if palette else []), b'IDAT', b'IEND']
    assert (palette is not None) == (form[1] == INDEXED)
    raw = zlib.decompress(parts[b'IDAT'])
    step = 1 + width * (1 if palette else 3)
    rows = [raw[i:i + step] for i in range(0, len(raw), step)]
    assert (len(rows), {row[0] for row in rows}, len(rows[-1])) == (height, {0}, step)
    if palette:
        return [[palette[3 * dot:3 * dot + 3] for dot in row[1:]] for row in rows]
    return [[row[i:i + 3] for i in range(1, step, 3)] for row in rows]
