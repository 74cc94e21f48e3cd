# SPDX-License-Identifier: GPL-2.0-only
"""HAL, in which the parts of LinuxCNC meet, by halcmd, as an ordinary user of the group dialout."""

import re
import subprocess

USER = ['setpriv', '--reuid', 'nobody', '--regid', 'dialout', '--clear-groups', '--']


class Halcmd:
    """One halcmd that takes command after command. HAL lives while a program is in it: it goes,
    with what dead programs have left, when this one is closed as the last. A halcmd for each
    command could take HAL away from under a program that is just about to come in.
    """

    def __init__(self, env=None):
        self.process = subprocess.Popen([*USER, 'halcmd', '-s', '-k', '-f'], env=env, text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT)
        self.run('status')

    def run(self, *commands):
        """-> what halcmd prints; AssertionError if it refuses one of the commands"""
        self.process.stdin.write(''.join(command + '\n' for command in (*commands, 'print over')))
        self.process.stdin.flush()
        lines = []
        for line in self.process.stdout:
            if line.endswith('HALCMD MSG: over\n'):
                break
            lines.append(line)
        else:
            raise AssertionError('halcmd has ended: %s' % ''.join(lines))
        refused = [line for line in lines if re.match(r'<stdin>:\d+: ', line)]
        assert not refused, ''.join(refused)
        return ''.join(lines).strip()

    def pins(self, component):
        """-> {name: value} of a component's pins, the names without the component's"""
        found = {}
        for line in self.run('show pin %s.' % component).splitlines():
            words = line.split()        # owner, type, direction, value, name, perhaps a signal
            found[words[4].removeprefix(component + '.')] = words[3]
        return found

    def set_pins(self, component, values):
        self.run(*('setp %s.%s %s' % (component, *item) for item in values.items()))

    def close(self):
        self.process.stdin.close()
        self.process.wait(60)
        self.process.stdout.close()
