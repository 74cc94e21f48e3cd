# SPDX-License-Identifier: GPL-2.0-only
"""The modules that DKMS and Kbuild build for a kernel, depending on its configuration.

dkms.conf is sourced like by dkms 3.0 and 3.2, by bash and with their variables; Kbuild is read by
make, with the variables of the kernel's build.
"""

import itertools
import os
import re
import shutil
import subprocess
import tempfile

import pytest

HERE = os.path.dirname(os.path.realpath(__file__))
TOP = os.path.realpath(os.path.join(HERE, '..', '..', '..'))
KERNEL, ARCH = '6.1.0-own', 'x86_64'
with open(os.path.join(TOP, 'Makefile'), encoding='ascii') as makefile:
    PACKAGE = 'xhc-xy3/' + re.search(r'^VERSION := (\S+)', makefile.read(), re.M).group(1)

MODULES = {'hid-xhc': 'drivers/hid-xhc', 'xy3': 'drivers/xy3', 'xy3-spi': 'drivers/xy3/spi',
           'xy3-sim': 'drivers/xy3/sim'}
SYMBOLS = ('HID', 'USB_HID', 'HWMON', 'SERIAL_DEV_BUS', 'SPI', 'IIO', 'IIO_BUFFER', 'CONFIGFS_FS')

# Enabled symbols, disabled symbols, and the expected modules
CASES = {
    'own realtime kernel, no IIO': (
        ('HID', 'USB_HID', 'HWMON', 'SPI', 'SERIAL_DEV_BUS', 'CONFIGFS_FS'),
        ('IIO', 'IIO_BUFFER'),
        ['hid-xhc', 'xy3']),
    'own kernel, no configfs': (
        SYMBOLS[:-1], ('CONFIGFS_FS',), ['hid-xhc', 'xy3', 'xy3-spi']),
    'own realtime kernel, no SPI, no serdev': (
        ('HID', 'USB_HID'), ('SPI', 'SERIAL_DEV_BUS', 'IIO_BUFFER'),
        ['hid-xhc']),
    'cloud': ((), ('HID', 'USB_HID'), []),
}

# Prints the variables that dkms uses: "NAME[INDEX]=VALUE"
SOURCE = '''
shopt -s extglob
. "$1/dkms.conf" > /dev/null
for name in BUILT_MODULE_NAME BUILT_MODULE_LOCATION DEST_MODULE_NAME DEST_MODULE_LOCATION \\
		BUILD_EXCLUSIVE_CONFIG AUTOINSTALL PACKAGE_NAME PACKAGE_VERSION; do
	for index in $(eval echo "\\${!$name[@]}"); do
		eval echo "'$name[$index]='\\"\\${$name[$index]}\\""
	done
done
'''


class Kernel:
    """The configuration in kernel headers, and the folder of dkms"""

    def __init__(self, on=(), off=(), files=('.config', 'include/config/auto.conf')):
        self.path = tempfile.mkdtemp()
        self.on = on
        self.headers = os.path.join(self.path, 'headers')
        lines = ['CONFIG_%s=%s\n' % (symbol, 'ym'[i % 2]) for i, symbol in enumerate(on)]
        # looks like a symbol, but is none
        lines += ['CONFIG_%s_OTHER=y\n' % symbol for symbol in off]
        for name in files:
            os.makedirs(os.path.dirname(os.path.join(self.headers, name)), exist_ok=True)
            with open(os.path.join(self.headers, name), 'w', encoding='ascii') as file:
                file.writelines(lines)
                if name == '.config':
                    file.writelines('# CONFIG_%s is not set\n' % symbol for symbol in off)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.path)

    def has_built(self, *files):
        folder = os.path.join(self.path, PACKAGE, KERNEL, ARCH, 'module')
        os.makedirs(folder)
        for name in files:
            with open(os.path.join(folder, name), 'wb'):
                pass

    def by_dkms(self):
        """The names of the modules; none if the package is skipped"""
        done = subprocess.run(
            ['bash', '-c', SOURCE, 'dkms', TOP], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
            text=True, check=True, cwd='/',
            env={'PATH': os.environ['PATH'], 'kernelver': KERNEL, 'arch': ARCH,
                 'kernel_source_dir': self.headers, 'dkms_tree': self.path})
        assert done.stderr == ''
        said = dict(line.split('=', 1) for line in done.stdout.splitlines())
        assert said['AUTOINSTALL[0]'] == 'yes'
        assert '%s/%s' % (said['PACKAGE_NAME[0]'], said['PACKAGE_VERSION[0]']) == PACKAGE

        # dkms 3.0 requires a module, and all versions require an array without holes
        names = [said['BUILT_MODULE_NAME[%d]' % i]
                 for i in range(sum(key.startswith('BUILT_MODULE_NAME') for key in said))]
        assert names
        for array in ('BUILT_MODULE_LOCATION', 'DEST_MODULE_LOCATION'):
            assert [key for key in said if key.startswith(array)] == [
                '%s[%d]' % (array, i) for i in range(len(names))]
        for i, name in enumerate(names):
            assert said['BUILT_MODULE_LOCATION[%d]' % i] == MODULES[name]
            assert said['DEST_MODULE_LOCATION[%d]' % i] == '/updates/dkms'

        exclusive = said['BUILD_EXCLUSIVE_CONFIG[0]'].split()
        assert exclusive
        if os.path.exists(self.headers) and not {s.removeprefix('CONFIG_')
                                                 for s in exclusive} <= set(self.on):
            return []
        return names

    def by_kbuild(self, *variables):
        """The folders of the modules, and the output of make"""
        done = subprocess.run(
            ['make', '-s', '-f', '-', 'src=' + TOP, *variables,
             *('CONFIG_%s=y' % symbol for symbol in self.on)],
            input='include %s/Kbuild\nall:\n\t@echo "modules:$(obj-m)"\n' % TOP,
            stdout=subprocess.PIPE, text=True, check=True)
        *printed, modules = done.stdout.splitlines()
        folders = [folder.rstrip('/') for folder in modules.removeprefix('modules:').split()]
        return [name for name, folder in MODULES.items() if folder in folders], printed


@pytest.mark.parametrize('name', CASES)
@pytest.mark.parametrize('files', [('.config',), ('include/config/auto.conf',),
                                   ('.config', 'include/config/auto.conf')])
@pytest.mark.parametrize('others', ['off', 'on'])
def test_kernel_gets_what_it_can_have(name, files, others):
    on, off, expected = CASES[name]
    if others == 'on':
        on = [symbol for symbol in SYMBOLS if symbol not in off]
        if name == 'own realtime kernel, no IIO':
            assert set(on) == set(CASES[name][0])
    with Kernel(on, off, files) as kernel:
        assert kernel.by_dkms() == expected


def test_either_file_of_the_configuration_counts():
    """dkms 3.0 reads .config, dkms 3.2 and the kernel's build read auto.conf"""
    few, all_of_them = ('HID', 'USB_HID'), SYMBOLS
    for name in '.config', 'include/config/auto.conf':
        with Kernel(all_of_them) as kernel, Kernel(few, files=(name,)) as other:
            shutil.copy(os.path.join(other.headers, name), os.path.join(kernel.headers, name))
            assert kernel.by_dkms() == ['hid-xhc']


def test_kernel_with_all():
    with Kernel(SYMBOLS) as kernel:
        assert kernel.by_dkms() == list(MODULES)
        assert kernel.by_kbuild() == (list(MODULES), [])


def test_modules_are_those_of_the_source():
    found = {}
    for folder, _, files in os.walk(os.path.join(TOP, 'drivers')):
        if 'Kbuild' in files:
            with open(os.path.join(folder, 'Kbuild'), encoding='ascii') as file:
                for name in re.findall(r'^obj-.* \+= (\S+)\.o$', file.read(), re.M):
                    found[name] = os.path.relpath(folder, TOP)
    assert found == MODULES


def test_dkms_and_kbuild_agree():
    """For each combination of requirements DKMS lists the modules that Kbuild builds"""
    seen = set()
    for count in range(len(SYMBOLS) + 1):
        for on in itertools.combinations(SYMBOLS, count):
            with Kernel(on) as kernel:
                built, _ = kernel.by_kbuild()
                seen.add(tuple(built))
                # without the driver of pendants DKMS skips all
                assert kernel.by_dkms() == (built if 'hid-xhc' in built else []), on
    assert {(), ('hid-xhc',), ('hid-xhc', 'xy3'), tuple(MODULES)} <= seen


def test_kbuild_and_kconfig_agree():
    """Out of tree a module requires symbols that it depends on, or selects, in the kernel tree"""
    entries = {}
    for folder in 'drivers/hid-xhc', 'drivers/xy3':
        with open(os.path.join(TOP, folder, 'Kconfig'), encoding='ascii') as file:
            for entry in re.split(r'^config ', file.read(), flags=re.M)[1:]:
                lines = re.findall(r'^\t(?:depends on|select) (.*)$', entry, re.M)
                entries[entry.split()[0]] = set(re.findall(r'[A-Z]\w+', ' '.join(lines)))

    def required(symbol):
        found = set()
        for name in entries[symbol]:
            found |= required(name) if name in entries else {name}
        return found

    with Kernel() as kernel:
        lines = kernel.by_kbuild('need-modorder=1')[1]
    assert len(lines) == len(MODULES)
    for line in lines:
        module, lacks = re.fullmatch(r'xhc-xy3: (\S+) is left out: the kernel has no (.*)',
                                     line).groups()
        symbol = {'hid-xhc': 'HID_XHC'}.get(module, module.upper().replace('-', '_'))
        # IIO_BUFFER implies IIO
        assert required(symbol) - {'IIO'} == set(lacks.replace('CONFIG_', '').split()), module


def test_clean_goes_where_the_installed_source_has_folders():
    """The clean target of the kernel also enters disabled folders; kunit is not installed"""
    def folders(*variables):
        done = subprocess.run(
            ['make', '-s', '-f', '-', 'src=' + TOP, *variables],
            input='include %s/Kbuild\nall:\n\t@echo "$(obj-)+$(obj-m)"\n' % TOP,
            stdout=subprocess.PIPE, text=True, check=True)
        off, on = done.stdout.strip().split('+')
        return {folder.rstrip('/') for folder in off.split()}, on.split()

    assert folders() == (set(MODULES.values()), [])
    assert folders('KUNIT_TESTS=m') == (set(MODULES.values()), ['kunit/'])


def test_what_is_left_out_is_named_with_what_the_kernel_lacks():
    on, _, _ = CASES['own realtime kernel, no IIO']
    with Kernel(on) as kernel:
        assert kernel.by_kbuild('need-modorder=1')[1] == [
            'xhc-xy3: xy3-spi is left out: the kernel has no CONFIG_IIO_BUFFER',
            'xhc-xy3: xy3-sim is left out: the kernel has no CONFIG_IIO_BUFFER']
        # modpost reads the file again
        assert kernel.by_kbuild()[1] == []
    with Kernel(('HID', 'USB_HID', 'HWMON')) as kernel:
        assert kernel.by_kbuild('need-modorder=1')[1][0] == (
            'xhc-xy3: xy3 is left out: the kernel has no CONFIG_SERIAL_DEV_BUS')
    with Kernel() as kernel:
        assert kernel.by_kbuild('need-modorder=1')[1][:2] == [
            'xhc-xy3: hid-xhc is left out: the kernel has no CONFIG_HID CONFIG_USB_HID',
            'xhc-xy3: xy3 is left out: the kernel has no CONFIG_HWMON CONFIG_SERIAL_DEV_BUS']


def test_kernel_whose_configuration_is_not_there():
    """For example dkms add and status: there are no headers yet"""
    with Kernel(files=()) as kernel:
        assert not os.path.exists(kernel.headers)
        assert kernel.by_dkms() == list(MODULES)


@pytest.mark.parametrize('suffix', ['', '.xz', '.zst'])
def test_what_was_built_is_removed_without_headers(suffix):
    with Kernel(files=()) as kernel:
        kernel.has_built('hid-xhc.ko' + suffix, 'xy3.ko' + suffix)
        assert kernel.by_dkms() == ['hid-xhc', 'xy3']


def test_what_was_built_is_removed_after_the_configuration_has_changed():
    with Kernel(SYMBOLS) as kernel:
        kernel.has_built('hid-xhc.ko')
        assert kernel.by_dkms() == ['hid-xhc']
    with Kernel(('HID', 'USB_HID')) as kernel:
        kernel.has_built(*(name + '.ko' for name in MODULES))
        assert kernel.by_dkms() == list(MODULES)
