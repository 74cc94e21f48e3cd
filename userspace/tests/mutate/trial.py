# SPDX-License-Identifier: GPL-2.0-only
"""A copy of the tree with a fault, and the tests that fail."""

import re
import shutil
import subprocess
from pathlib import Path

TOP = Path(__file__).resolve().parents[3]
PARTS = ('.ci', 'drivers', 'kunit', 'userspace', 'Kbuild', 'Makefile', 'dkms.conf')


def copy_tree(tree, path, text):
    """Copy the tree, with other text in one file (path relative to the top)."""
    shutil.rmtree(tree, ignore_errors=True)
    tree.mkdir(parents=True)
    ignore = shutil.ignore_patterns('*.o', '*.ko', '*.mod', '*.mod.c', '*.cmd', '__pycache__')
    for part in PARTS:
        if (TOP / part).is_dir():
            shutil.copytree(TOP / part, tree / part, ignore=ignore)
        else:
            shutil.copy2(TOP / part, tree / part)
    (tree / path).write_text(text)


def run(command, log):
    """Run a command, write its output to a log, return its status and output."""
    result = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, text=True, check=False)
    log.write_text(result.stdout)
    return result.returncode, result.stdout


def failed_cases(text):
    """Names of the cases that the script of a level reports as failed."""
    return re.findall(r'^not ok (\w+\.\S+):', text, re.MULTILINE)
