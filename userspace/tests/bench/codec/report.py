# SPDX-License-Identifier: GPL-2.0-only
"""Common parts of the reports of all benchmarks."""
import platform
import subprocess
import time
from pathlib import Path

TOP = Path(__file__).resolve().parents[4]
OUT = TOP / 'build' / 'bench'


def output(*command):
    return subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True,
                          check=True).stdout


def processor():
    for line in Path('/proc/cpuinfo').read_text(encoding='utf-8').splitlines():
        key, _, value = line.partition(':')
        if key.strip() in ('model name', 'Model'):
            return value.strip()
    return platform.machine()


def circumstances():
    """The conditions of the measurements."""
    return {'version': 1, 'date': time.strftime('%Y-%m-%d'), 'processor': processor(),
            'compiler': output('gcc', '--version').splitlines()[0]}


def number(value, places=3):
    """With this number of significant digits."""
    if value is None:
        return '-'
    digits = len(str(int(value))) if value >= 1 else 0
    return f'{value:.{max(places - digits, 0)}f}'
