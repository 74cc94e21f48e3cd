# SPDX-License-Identifier: GPL-2.0-only
"""wizard.py stepconf|pncconf: a configuration, written by LinuxCNC's own program without its
windows, in ~/linuxcnc/configs/mill. What an owner would choose in the windows is set here; hardware
that is not there gets a stand-in.
"""

import importlib.machinery
import importlib.util
import re
import sys

AXES = 'xyz'


def load(name):
    """The program as a module, which opens no window"""
    path = sys.argv[0] = '/usr/bin/' + name     # it looks for its files beside itself
    loader = importlib.machinery.SourceFileLoader(name, path)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    sys.dont_write_bytecode = True
    loader.exec_module(module)
    sys.excepthook = sys.__excepthook__         # its own shows a window
    return module


def prepare(module, app, private, data):
    """What `app` has when its windows are open"""
    app._p, app.d = private, data
    module.debug, module.dbg = False, app.dbg
    app.INI, app.HAL = module.build_INI.INI(app), module.build_HAL.HAL(app)
    app.warning_dialog = lambda *_: False       # "Quit?"
    data.machinename = 'mill'
    return data


def edit(path, old, new):
    with open(path, encoding='utf-8') as file:
        text, count = re.subn(old, new, file.read())
    assert count
    with open(path, 'w', encoding='utf-8') as file:
        file.write(text)


def stepconf():
    """A mill in millimetres on a parallel port: a spindle by PWM, one input for all limit switches,
    which stepconf simulates, and an MDI command for halui
    """
    module = load('stepconf')
    app = object.__new__(module.StepconfApp)
    private = module.Private_Data()
    app._p = private
    data = prepare(module, app, private, module.Data(private))
    data.sim_hardware = True
    data.manualtoolchange = False
    data.units = 1
    data.set_axis_unit_defaults(False)
    data.latency = 480000           # a base thread that a busy machine can keep
    data.pin10 = private.ALL_LIMIT
    data.halui, data.halui_list = 1, ['M64 P0']
    for axis in AXES:
        data[axis + 'scale'] = 800.0
        data[axis + 'minlim'], data[axis + 'maxlim'] = -100, 100
    app.buid_config()
    ini = app.build_base() + '/mill.ini'
    # its threads are late on a busy machine, and steps come late
    edit(ini, r'(?m)^((MIN_)?FERROR) = .*', r'\1 = 100')
    # without switches stepconf does not allow to home all by one key
    edit(ini, r'(?m)^HOME_OFFSET = .*', r'\g<0>\nHOME_SEQUENCE = 0')


def pncconf():
    """A mill in inches on a Mesa 5i25, and a spindle. The card, which is not there, is replaced: a
    joint is at once where it is sent.
    """
    module = load('pncconf')
    app = object.__new__(module.App)
    app.debugstate = ''
    module._PD = module.private_data.Private_Data(app, module.BIN, module.BASE)
    data = prepare(module, app, module._PD, module.data.Data(
        app, module._PD, module.BASE, module.LINUXCNCVERSION))
    data.toolchangeprompt = False
    data.available_axes = [*AXES, 's']
    data.mesa0_currentfirmwaredata = next(
        each for each in module._PD.MESA_INTERNAL_FIRMWAREDATA if each[1] == '5i25')
    for axis in data.available_axes:
        data[axis + 'scale'], data[axis + 'P'] = 8000.0, 1000
    app.buid_config()
    path = app.build_base() + '/mill.hal'
    edit(path, r'(?m)^.*\b(hostmot2|hm2_\w+).*\n', '')
    with open(path, 'a', encoding='utf-8') as file:
        file.write('loadrt scale names=card.x,card.y,card.z\n')
        for number, axis in enumerate(AXES):
            file.write('addf card.{0} servo-thread\nsetp card.{0}.gain 1\n'
                       'net {0}-pos-cmd joint.{1}.motor-pos-cmd => card.{0}.in\n'
                       'net {0}-pos-fb card.{0}.out => joint.{1}.motor-pos-fb\n'.format(
                           axis, number))


if __name__ == '__main__':
    {'stepconf': stepconf, 'pncconf': pncconf}[sys.argv[1]]()
