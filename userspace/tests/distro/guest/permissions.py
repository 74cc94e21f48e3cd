# SPDX-License-Identifier: GPL-2.0-only
"""Access to the files and nodes of a device, by the ids of users."""

import contextlib
import errno
import grp
import os
import stat

from harness import BIND_TIME, error_of, find, udev_properties

NOBODY = 65534
DIALOUT = grp.getgrnam('dialout').gr_gid


@contextlib.contextmanager
def user(*groups):
    """Temporarily makes this process an unprivileged user in these groups."""
    os.setgroups(groups)
    os.setegid(NOBODY)
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(0)
        os.setgroups([])


def member():
    return user(DIALOUT)


def outsider():
    return user()


def open_error(path, flags=os.O_WRONLY):
    """The errno of open(2); 0 on success, and the file is closed again."""
    def attempt():
        os.close(os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY))

    return error_of(attempt)


# --- modes -------------------------------------------------------------------------------------

def files_below(directory):
    """-> {name: (mode, group)} of all files in sysfs below a directory, without following links"""
    found = {}
    for place, _, names in os.walk(directory):
        for name in names:
            path = os.path.join(place, name)
            state = os.lstat(path)
            if stat.S_ISREG(state.st_mode):
                found[os.path.relpath(path, directory)] = (stat.S_IMODE(state.st_mode),
                                                           state.st_gid)
    return found


def for_root(name):
    """Files of every device, files that affect other devices, and files that refuse all writes
    although the IIO core makes them writable."""
    return name.endswith('uevent') or 'power' in name.split('/') or \
        name in ('current_timestamp_clock', 'out_angl_scale', 'out_angl_offset')


def misplaced(directory):
    """Names of files with a wrong mode or group."""
    bad = []
    for name, (mode, group) in files_below(directory).items():
        open_to_group = group == DIALOUT and bool(mode & 0o020)
        wanted = bool(mode & 0o200) and not for_root(name)
        if mode & 0o002 or open_to_group != wanted:
            bad.append('%s: %o, group %d' % (name, mode, group))
    return bad


def wait_access(directory):
    """Waits until udevd has changed the group of all files of a device."""
    assert len([mode for mode, _ in files_below(directory).values() if mode & 0o200]) > 5, \
        'few files to write in ' + directory
    find.wait(lambda: not misplaced(directory), BIND_TIME)
    assert misplaced(directory) == [], 'files with another mode or group in ' + directory


def check_node(node):
    """Accessible to the group, and by a udev tag to the user at the seat."""
    def found():
        state = os.stat(node)
        return '%o, group %d' % (state.st_mode & 0o667, state.st_gid)

    wanted = '660, group %d' % DIALOUT
    find.wait(lambda: found() == wanted, BIND_TIME)     # udevd changes them one by one
    assert found() == wanted, 'mode of ' + node
    assert 'uaccess' in udev_properties(node)[1], 'no tag uaccess on ' + node
    with member():
        assert open_error(node, os.O_RDWR) == 0, 'errno of a member, ' + node
    with outsider():
        for flags in (os.O_RDONLY, os.O_WRONLY):
            assert open_error(node, flags) == errno.EACCES, 'errno of an outsider, ' + node


def check_refused(directory):
    """No file of a device can be written by other users."""
    names = [name for name, (mode, _) in files_below(directory).items() if mode & 0o200]
    with outsider():
        errors = {name: open_error(os.path.join(directory, name)) for name in names}
    assert {name for name, error in errors.items() if error != errno.EACCES} == set(), \
        'what an outsider may write in ' + directory
