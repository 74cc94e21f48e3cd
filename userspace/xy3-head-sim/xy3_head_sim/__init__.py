# SPDX-License-Identifier: GPL-2.0-only
"""xy3-head-sim: the simulated backchannel of an XY3-100 compatible scanhead.

wire      the format: tables, packets, and a decoder
faults    transmission faults between the head and the host
head      the state of the head, its packets and their schedule, and the counts
line      pseudo terminal, socket, file
script    commands, one per line
"""

VERSION = '0.1.0'
