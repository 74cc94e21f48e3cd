# SPDX-License-Identifier: GPL-2.0-only
"""HAL pins -> the display of an XHC pendant, and whether the pendant may jog."""

VERSION = '0.1.0'
