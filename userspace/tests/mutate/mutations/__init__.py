# SPDX-License-Identifier: GPL-2.0-only
"""Faults to be planted in the drivers on purpose, a module for each driver."""

from dataclasses import dataclass

# Where a test notices; a leak is noticed in the run of SIM, by the kernel's scan for leaks alone
HOST, KERNEL, SIM, LEAK = range(4)


@dataclass
class Mutation:
    name: str
    file: str
    old: str                # stands once in the file
    new: str
    level: int = HOST       # the first level where a test is known to catch it


@dataclass
class Driver:
    sources: str            # the folder of its files
    host: dict              # its programs on the host (kunit/PROGRAM.c), and their suites
    kernel: tuple           # its suites in check-kunit
    sim: str                # its file in check-uml
    mutations: tuple
