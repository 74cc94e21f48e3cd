# SPDX-License-Identifier: GPL-2.0-only
"""Constants of the wire format common to all models."""

VENDOR = 0x10CE
MANUFACTURER = 'KTURT.LTD'

INPUT_ID = 0x04             # input report
FEATURE_ID = 0x06           # feature report: id and one chunk of the display frame
CHUNK_SIZE = 7
