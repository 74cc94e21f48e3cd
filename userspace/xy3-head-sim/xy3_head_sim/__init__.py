# SPDX-License-Identifier: GPL-2.0-only
"""xy3-head-sim: a simulated XY3-100 compatible scanhead, its backchannel side.

wire      the format: tables, packets, and a decoder
faults    what can go wrong between the head and the host
head      what the head knows, what it sends and when, and the counts
line      pseudo terminal, socket, file
script    commands, one per line
"""

VERSION = '0.1.0'
