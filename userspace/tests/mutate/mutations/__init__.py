# SPDX-License-Identifier: GPL-2.0-only
"""Faults to plant in the drivers, a module for each driver."""

from dataclasses import dataclass

# The level whose test fails; a leak is detected in the run of SIM, by kmemleak only
HOST, KERNEL, SIM, LEAK = range(4)


@dataclass
class Mutation:
    name: str
    file: str
    old: str                # occurs once in the file
    new: str
    level: int = HOST       # the first level in which a test is known to catch it


@dataclass
class Driver:
    sources: str            # the folder of its files
    host: dict              # its programs on the host (kunit/PROGRAM.c), and their suites
    kernel: tuple           # its suites in check-kunit
    sim: str                # its file in check-uml
    mutations: tuple
