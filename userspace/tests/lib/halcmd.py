# SPDX-License-Identifier: GPL-2.0-only
"""Access to HAL, which connects the parts of LinuxCNC, by halcmd, as a member of dialout."""

import re
import subprocess

USER = ['setpriv', '--reuid', 'nobody', '--regid', 'dialout', '--clear-groups', '--']


class Halcmd:
    """One halcmd that executes all commands. HAL exists while a program uses it: it is removed,
    with remains of killed programs, when this one is closed as the last. A halcmd for each command
    could remove HAL while another program is just connecting.
    """

    def __init__(self, env=None):
        self.process = subprocess.Popen([*USER, 'halcmd', '-s', '-k', '-f'], env=env, text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT)
        self.run('status')

    def run(self, *commands):
        """-> output of halcmd; AssertionError if it refuses one of the commands"""
        self.process.stdin.write(''.join(command + '\n' for command in (*commands, 'print over')))
        self.process.stdin.flush()
        lines = []
        for line in self.process.stdout:
            if line.endswith('HALCMD MSG: over\n'):
                break
            lines.append(line)
        else:
            raise AssertionError('halcmd has exited: %s' % ''.join(lines))
        refused = [line for line in lines if re.match(r'<stdin>:\d+: ', line)]
        assert not refused, ''.join(refused)
        return ''.join(lines).strip()

    def pins(self, component):
        """-> {name: value} of the pins of a component, without its name in the names"""
        found = {}
        for line in self.run('show pin %s.' % component).splitlines():
            words = line.split()        # owner, type, direction, value, name, optionally a signal
            found[words[4].removeprefix(component + '.')] = words[3]
        return found

    def set_pins(self, component, values):
        self.run(*('setp %s.%s %s' % (component, *item) for item in values.items()))

    def close(self):
        self.process.stdin.close()
        self.process.wait(60)
        self.process.stdout.close()
