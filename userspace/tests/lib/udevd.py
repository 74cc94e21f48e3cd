# SPDX-License-Identifier: GPL-2.0-only
"""The systemd-udevd of this machine with the rules of this tree, in the test kernel."""

import contextlib
import glob
import os
import shutil
import subprocess

from kernel import wait

SOURCE = os.path.join(os.path.dirname(os.path.realpath(__file__)), '..', '..', 'udev')
RULES = '/run/udev/rules.d'
# it does nothing if it detects a chroot
ENVIRONMENT = {**os.environ, 'SYSTEMD_IGNORE_CHROOT': '1'}


@contextlib.contextmanager
def running():
    os.makedirs(RULES, exist_ok=True)
    for path in glob.glob(SOURCE + '/*.rules'):
        shutil.copy(path, RULES)
    with open('/run/udevd.log', 'w', encoding='utf-8') as log:
        process = subprocess.Popen(['/lib/systemd/systemd-udevd'], env=ENVIRONMENT, stdout=log,
                                   stderr=log)
    try:
        assert wait(lambda: os.path.exists('/run/udev/control')), 'no udevd'
        # it answers once it also receives events of the kernel, which is later
        subprocess.run(['udevadm', 'control', '--ping'], env=ENVIRONMENT, check=True)
        yield
    finally:
        process.terminate()
        process.wait(60)


def properties(node):
    """Properties of a node in the database of udevd: {name: text}"""
    text = subprocess.run(['udevadm', 'info', '--query=property', node], env=ENVIRONMENT,
                          stdout=subprocess.PIPE, text=True, check=True).stdout
    return dict(line.split('=', 1) for line in text.splitlines())
