# SPDX-License-Identifier: GPL-2.0-only
"""doctor with faults that are expensive to create on a machine, in an artificial root:
installation, DKMS, Secure Boot, udev's rules, a pendant on USB, and its holder.

Each is compared with the healthy root, in which nothing is found.
"""

import json
import os
import re
import shutil
import struct
import subprocess
import tempfile

import case
from tool import build_sanitized


HERE = os.path.dirname(os.path.realpath(__file__))
TOP = os.path.join(HERE, '..', '..', '..')
KERNEL = '6.12.0-test-amd64'
DKMS = 'var/lib/dkms/xhc-xy3'
MODULES = 'lib/modules/%s/' % KERNEL
SECURE_BOOT = 'sys/firmware/efi/efivars/SecureBoot-8be4df61-93ca-11d2-aa0d-00e098032b8c'
MOK_LIST = 'sys/firmware/efi/efivars/MokListRT-605dab50-e046-4300-abb6-3dd810dd8b23'
SIGNATURE = b'~Module signature appended~\n'
RULES = {'xhcctl': '70-xhc-pendant.rules', 'xy3ctl': '70-xy3.rules'}
DRIVER = {'xhcctl': 'hid-xhc', 'xy3ctl': 'xy3'}
HID = '0003:10CE:EB70.0001'


def version():
    with open(os.path.join(TOP, 'Makefile'), encoding='ascii') as file:
        return re.search(r'^VERSION := (\S+)', file.read(), re.M).group(1)


class Root:
    """A machine without faults of the tool's driver."""

    def __init__(self, tool):
        self.tool = tool
        self.path = tempfile.mkdtemp()
        self.driver = DRIVER[tool]
        self.module = MODULES + 'updates/dkms/%s.ko' % self.driver
        self.system('ID=debian')
        self.write('proc/sys/kernel/osrelease', KERNEL + '\n')
        self.write('usr/share/doc/linux-image-%s/copyright' % KERNEL, '')
        self.write(MODULES + 'build/Makefile', '')
        self.write(MODULES + 'modules.dep', 'kernel/lib/crc8.ko:\nupdates/dkms/%s.ko: a.ko b.ko\n'
                   % self.driver)
        self.write(self.module, b'module' + SIGNATURE)
        os.makedirs(self.at(DKMS + '/' + version()))
        os.symlink('x', self.at('%s/kernel-%s-x86_64' % (DKMS, KERNEL)))
        self.write('usr/lib/udev/rules.d/' + RULES[tool], '# rules\n')
        self.loaded(version())
        if tool == 'xhcctl':
            self.pendant()
        else:
            self.write('sys/class/xy3/xy3-0/rate', '115200\n')
            self.write('sys/class/xy3/xy3-0/in_sync', '1\n')
            self.write('sys/class/xy3/xy3-0/stats/rx_bytes', '1000\n')
            self.write('sys/class/xy3/xy3-0/stats/line_errors', '0\n')
            self.write('proc/tty/ldiscs', 'n_tty       0\nxy3        29\n')
            self.write('sys/module/xy3/parameters/ldisc', '29\n')

    def pendant(self):
        self.usb_device('1-2', 'eb70')
        self.driven(HID)

    def usb_device(self, name, product, driver='usbhid'):
        usb = 'sys/bus/usb/devices/%s/' % name
        for attribute, text in (('idVendor', '10ce'), ('idProduct', product), ('busnum', '1'),
                                ('devnum', '7')):
            self.write(usb + attribute, text + '\n')
        self.write('%s%s:1.0/bInterfaceClass' % (usb, name), '03\n')
        os.symlink('../../../drivers/' + driver, self.at('%s%s:1.0/driver' % (usb, name)))

    def driven(self, hid):
        """A HID device bound to our driver"""
        for folder in ('sys/bus/hid/devices/', 'sys/bus/hid/drivers/hid-xhc/'):
            self.write(folder + hid + '/awake', '1\n')
            self.write(folder + hid + '/stats/frame_errors', '0\n')
            self.write(folder + hid + '/stats/unknown_keys', '0\n')
        os.symlink('../../drivers/hid-xhc', self.at('sys/bus/hid/devices/%s/driver' % hid))

    def close(self):
        shutil.rmtree(self.path)

    def at(self, path):
        return os.path.join(self.path, path)

    def write(self, path, data):
        os.makedirs(os.path.dirname(self.at(path)), exist_ok=True)
        with open(self.at(path), 'wb') as file:
            file.write(data if isinstance(data, bytes) else data.encode())

    def remove(self, path):
        if os.path.isdir(self.at(path)) and not os.path.islink(self.at(path)):
            shutil.rmtree(self.at(path))
        else:
            os.unlink(self.at(path))

    def system(self, *lines):
        self.write('etc/os-release', ''.join(line + '\n' for line in lines))

    def runs(self, kernel):
        """Another kernel, without our modules"""
        self.write('proc/sys/kernel/osrelease', kernel + '\n')
        self.write('lib/modules/%s/modules.dep' % kernel, '')

    def loaded(self, number):
        self.write('sys/module/%s/version' % self.driver.replace('-', '_'), number + '\n')

    def not_loaded(self):
        self.remove('sys/module/' + self.driver.replace('-', '_'))


class TestCase(case.Case):
    @classmethod
    def setup_class(cls):
        cls.dir = build_sanitized()

    def root(self, tool):
        root = Root(tool)
        self.add_cleanup(root.close)
        return root

    def ask(self, root, *words):
        """-> {id: [(status, text, fix), ...]}, exit status"""
        done = subprocess.run(
            [os.path.join(self.dir, root.tool), 'doctor', '--json', '--root', root.path, *words],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
        assert done.stderr == ''
        findings = {}
        for finding in json.loads(done.stdout)['findings']:
            findings.setdefault(finding['id'], []).append(
                (finding['status'], finding['text'], finding['fix']))
        return findings, done.returncode

    def found(self, root):
        """-> {id: (text, fix)} of the findings"""
        return {check: finding[1:] for check, all_of_it in self.ask(root)[0].items()
                for finding in all_of_it if finding[0] == 'found'}

    def assert_found(self, root, check, text, fix):
        """Exactly this is found"""
        findings, status = self.ask(root)
        found = [(key, *finding[1:]) for key, all_of_it in findings.items()
                 for finding in all_of_it if finding[0] == 'found']
        assert [key for key, _, _ in found] == [check], found
        assert text in found[0][1]
        assert fix in found[0][2]
        assert status == 1

    def assert_well(self, root):
        findings, status = self.ask(root)
        assert [key for key, all_of_it in findings.items()
                          for finding in all_of_it if finding[0] == 'found'] == [], findings
        assert status == 0
        return findings

    # --- the controls ---

    def test_healthy(self):
        for tool in RULES:
            findings = self.assert_well(self.root(tool))
            for check in ('headers', 'dkms', 'module', 'blacklist', 'version', 'signature',
                          'rules'):
                assert [finding[0] for finding in findings[check]] == ['ok'], check

    def test_text(self):
        root = self.root('xy3ctl')
        root.remove(MODULES + 'build')
        root.write(MODULES + 'modules.dep', '')
        root.not_loaded()
        done = subprocess.run([os.path.join(self.dir, 'xy3ctl'), 'doctor', '--root', root.path],
                              stdout=subprocess.PIPE, text=True, check=False)
        assert done.returncode == 1
        assert 'found    headers      headers of kernel %s are missing' % KERNEL in done.stdout
        assert 'fix:          sudo apt install linux-headers-%s\n' % KERNEL in done.stdout

    # --- what is installed ---

    def test_headers(self):
        for tool in RULES:
            root = self.root(tool)
            root.remove(MODULES + 'build')
            # they are only required to build
            assert self.assert_well(root)['headers'][0][0] == 'skipped'
            root.not_loaded()
            root.write(MODULES + 'modules.dep', '')
            root.remove('%s/kernel-%s-x86_64' % (DKMS, KERNEL))
            found = self.found(root)
            assert sorted(found) == ['dkms', 'headers']
            assert found['headers'][1] == 'sudo apt install linux-headers-' + KERNEL

    def test_dkms_added(self):
        root = self.root('xhcctl')
        root.remove('%s/kernel-%s-x86_64' % (DKMS, KERNEL))
        fix = 'dkms install xhc-xy3/%s -k %s' % (version(), KERNEL)
        self.assert_found(root, 'dkms', 'not built', fix)
        # for another kernel, even one whose name starts the same
        os.symlink('x', root.at('%s/kernel-%s-x86_64' % (DKMS, KERNEL + 'x')))
        self.assert_found(root, 'dkms', 'not built', fix)
        root.write('%s/%s/build/make.log' % (DKMS, version()), 'error\n')
        self.assert_found(root, 'dkms', '/build/make.log', fix)
        # a driver that was built manually has none
        root.remove(DKMS)
        assert self.assert_well(root)['dkms'][0][0] == 'skipped'

    def test_module(self):
        root = self.root('xy3ctl')
        root.not_loaded()
        root.write('sys/module/xy3/parameters/ldisc', '29\n')
        root.remove('sys/module/xy3')
        self.assert_well(root)
        root.write(MODULES + 'modules.dep', 'updates/dkms/not-xy3.ko:\n')
        again = 'dkms install --force xhc-xy3/%s -k %s' % (version(), KERNEL)
        self.assert_found(root, 'module', 'has no module xy3', again)
        # a module that dkms has not built is built by dkms: one fix, not two
        root.remove('%s/kernel-%s-x86_64' % (DKMS, KERNEL))
        self.assert_found(root, 'dkms', 'not built', 'dkms install xhc-xy3/' + version())
        # without DKMS its commands are not available
        root.remove(DKMS)
        self.assert_found(root, 'module', 'has no module xy3', 'sudo make install ')

    def test_module_that_the_kernel_has_no_means_for(self):
        root = self.root('xy3ctl')
        root.remove('sys/module/xy3')
        root.write(MODULES + 'modules.dep', 'updates/dkms/hid-xhc.ko:\n')
        built, link = '%s/%s/x86_64' % (version(), KERNEL), '%s/kernel-%s-x86_64' % (DKMS, KERNEL)
        root.remove(link)
        os.symlink(built, root.at(link))
        log = '%s/%s/log/make.log' % (DKMS, built)
        why = 'the kernel has no CONFIG_HWMON CONFIG_SERIAL_DEV_BUS'
        root.write(log, 'xhc-xy3: xy3 is left out: %s\n'
                        'xhc-xy3: xy3-spi is left out: the kernel has no CONFIG_SPI\n' % why)
        self.assert_found(root, 'module', 'has no module xy3: it was left out, as ' + why,
                          'boot a kernel with these options')
        # the log only has a line on another module
        root.write(log, 'xhc-xy3: xy3-spi is left out: the kernel has no CONFIG_SPI\n')
        self.assert_found(root, 'module', 'has no module xy3', 'dkms install --force xhc-xy3/')

    # --- advice by distribution ---

    def headers_fix(self, kernel, *system, package=False, **files):
        root = self.root('xhcctl')
        root.not_loaded()
        root.remove(DKMS)
        root.runs(kernel)
        root.system(*system)
        if package:
            root.write('usr/share/doc/linux-image-%s/copyright' % kernel, '')
        for path, data in files.items():
            root.write(path.replace('__', '/').replace('KERNEL', kernel), data)
        return self.found(root)['headers'][1]

    def test_headers_by_distribution(self):
        fix = self.headers_fix
        arch = '6.17.8-arch1-1'
        assert fix(arch, 'ID=arch', lib__modules__KERNEL__pkgbase='linux\n') == \
            'sudo pacman -S linux-headers'
        assert fix('6.12.9-1-lts', 'ID="manjaro"', 'ID_LIKE=arch',
                   lib__modules__KERNEL__pkgbase='linux-lts\n') == \
            'sudo pacman -S linux-lts-headers'
        assert 'pacman' not in fix(arch, 'ID=arch')
        fedora = '6.17.5-300.fc43.x86_64'
        assert fix(fedora, 'ID=fedora') == 'sudo dnf install kernel-devel-' + fedora
        assert fix(fedora, 'ID="rocky"', 'ID_LIKE="rhel centos fedora"') == \
            'sudo dnf install kernel-devel-' + fedora
        for kernel, system in (('6.8.0-45-generic', ('ID=ubuntu', 'ID_LIKE=debian')),
                               ('6.8.0-45-generic', ('ID=linuxmint', 'ID_LIKE="ubuntu debian"')),
                               ('6.12.25+rpt-rpi-v8', ('ID=debian',)),
                               ('6.1.0-56-amd64', ('PRETTY_NAME="Debian"', 'ID="debian"'))):
            assert fix(kernel, *system, package=True) == 'sudo apt install linux-headers-' + kernel
        # a kernel without a package
        assert 'apt' not in fix('6.17.0', 'ID=debian')
        mainline = fix('6.17.8-061708-generic', 'ID=ubuntu', package=True)
        assert 'mainline' in mainline and 'apt' not in mainline
        assert 'sudo' not in fix('6.6.1_1', 'ID=void')
        assert 'sudo' not in fix('6.6.1_1')

    def test_headers_of_a_kernel_that_is_no_longer_installed(self):
        root = self.root('xhcctl')
        root.remove(DKMS)
        root.not_loaded()
        root.write('proc/sys/kernel/osrelease', '6.17.7-arch1-1\n')
        root.system('ID=arch')
        assert self.found(root)['headers'][1].startswith('restart the computer')

    def test_a_kernel_of_64_bits_in_a_system_of_32(self):
        """Raspberry Pi OS has no headers of that kernel for armhf"""
        for bits, words in ((b'\x01', 'arm_64bit=0'), (b'\x02', 'apt install')):
            fix = self.headers_fix('6.1.0-rpi7-rpi-v8', 'ID=raspbian', 'ID_LIKE=debian',
                                   package=True, bin__sh=b'\x7fELF' + bits + b'\x01')
            assert words in fix

    def test_an_image(self):
        """DKMS cannot work there: none of its commands is suggested."""
        for lines, path in ((('ID=fedora', 'VARIANT_ID=silverblue'), 'run/ostree-booted'),
                            (('ID=steamos', 'ID_LIKE=arch'), None)):
            root = self.root('xhcctl')
            root.system(*lines)
            if path:
                root.write(path, '')
            root.not_loaded()
            root.remove(MODULES + 'build')
            root.write(MODULES + 'modules.dep', '')
            for check in (('dkms', 'headers'), ('module', 'headers')):
                if 'dkms' in check:
                    root.remove('%s/kernel-%s-x86_64' % (DKMS, KERNEL))
                else:
                    root.remove(DKMS)
                found = self.found(root)
                assert sorted(found) == list(sorted(check))
                for _, fix in found.values():
                    assert 'image' in fix and 'sudo' not in fix

    def test_a_compiler_that_is_missing(self):
        for line, name in (('/bin/sh: 1: gcc-14: not found', 'gcc-14'),
                           ('bash: line 1: clang-19: command not found', 'clang-19')):
            for system, command in (('ID=ubuntu', 'sudo apt install '), ('ID=fedora', 'sudo dnf '),
                                    ('ID=void', 'install ')):
                root = self.root('xhcctl')
                root.system(system)
                root.remove('%s/kernel-%s-x86_64' % (DKMS, KERNEL))
                root.write('%s/%s/build/make.log' % (DKMS, version()),
                           'make: entering\nwarning: sparse: not found\n%s\nmake: ***\n' % line)
                text, fix = self.found(root)['dkms']
                assert 'its compiler %s is missing' % name in text
                assert fix.startswith(command) and fix.endswith(name)

    def test_the_key_of_secure_boot_by_distribution(self):
        for lines, key in ((('ID=ubuntu',), '/var/lib/shim-signed/mok/MOK.der'),
                           (('ID=linuxmint', 'ID_LIKE="ubuntu debian"'),
                            '/var/lib/shim-signed/mok/MOK.der'),
                           (('ID=debian',), '/var/lib/dkms/mok.pub'),
                           (('ID=fedora',), '/var/lib/dkms/mok.pub')):
            root = self.root('xhcctl')
            root.system(*lines)
            root.write(SECURE_BOOT, b'\x06\0\0\0\x01')
            root.not_loaded()
            self.assert_found(root, 'signature', key, 'mokutil --import ' + key)
            root.write(root.module, b'module without')
            self.assert_found(root, 'signature', 'is not signed', 'mokutil --import ' + key)
            root.remove(DKMS)           # the signer is not known then
            self.assert_found(root, 'signature', 'refused', 'sign it with a key')

    def test_blacklist(self):
        for path, text in (('etc/modprobe.d/x.conf', 'blacklist hid_xhc\n'),
                           ('usr/lib/modprobe.d/x.conf', '# x\nalias a b\nblacklist  hid-xhc\n'),
                           ('run/modprobe.d/x.conf', 'install hid-xhc /bin/false\n'),
                           ('proc/cmdline', 'quiet module_blacklist=a,hid_xhc,b ro\n'),
                           ('proc/cmdline', 'modprobe.blacklist=hid-xhc\n')):
            with case.row(text):
                root = self.root('xhcctl')
                root.write(path, text)
                assert self.assert_well(root)['blacklist'][0][0] == 'skipped'   # it is loaded
                root.not_loaded()
                where = "the kernel's command line" if path == 'proc/cmdline' else '/' + path
                self.assert_found(root, 'blacklist', where + ' prevents loading hid-xhc',
                                  'remove that line')
        for text in ('# blacklist hid-xhc\n', 'blacklist hid-xhcx\n', 'blacklist hid\n',
                     'install hid-xhc modprobe -i hid-xhc\n', 'blacklist\n', '\n'):
            root.remove('proc/cmdline')
            root.write('proc/cmdline', 'module_blacklist= xmodule_blacklist=hid-xhc hid-xhc\n')
            root.write('etc/modprobe.d/x.conf', text)
            assert self.assert_well(root)['blacklist'][0][0] == 'ok'

    def test_version(self):
        root = self.root('xhcctl')
        root.loaded('0.0.1')
        self.assert_found(root, 'version', '0.0.1 is loaded', 'sudo modprobe -r hid-xhc')
        for text, fix in ((version(), 'sudo modprobe -r hid-xhc'),
                          ('0.0.1', 'sudo dkms install --force xhc-xy3/%s -k %s && '
                           'sudo modprobe -r hid-xhc' % (version(), KERNEL))):
            root.write(root.module, b'x\0srcversion=1\0version=%s\0a=b\0%s' % (text.encode(),
                                                                            SIGNATURE))
            found = self.found(root)
            assert list(found) == ['version'] and found['version'][1].startswith(fix)
        # DKMS has an old source as well
        root.remove('%s/%s' % (DKMS, version()))
        os.makedirs(root.at(DKMS + '/0.0.1'))
        self.assert_found(root, 'version', 'hid-xhc 0.0.1 is loaded and installed',
                          'sudo make install install-tools')

    # --- signatures ---

    def test_secure_boot(self):
        for tool in RULES:
            root = self.root(tool)
            root.write(SECURE_BOOT, b'\x06\0\0\0\x01')
            self.assert_well(root)               # it is loaded: the key is known
            root.not_loaded()
            self.assert_found(root, 'signature', 'Secure Boot is on',
                             'mokutil --import /var/lib/dkms/mok.pub')
            # the same certificate is in the firmware's list
            key = b'\x30\x82' + bytes(range(200))
            root.write('var/lib/dkms/mok.pub', key)
            self.assert_found(root, 'signature', 'Secure Boot is on', 'mokutil --import')
            root.write(MOK_LIST, b'\7\0\0\0list' + key[:-1] + b'x')
            self.assert_found(root, 'signature', 'Secure Boot is on', 'mokutil --import')
            root.write(MOK_LIST, b'\7\0\0\0list' + key + b'end')
            assert self.assert_well(root)['signature'] == [
                ('ok', 'Secure Boot is on, and the key of %s is enrolled' % root.driver, None)]
            root.write(root.module, b'module without')
            found = self.found(root)
            assert found['signature'][1].startswith('sudo dkms build --force xhc-xy3/')
            root.remove(MOK_LIST)
            for fix in ('dkms build --force xhc-xy3/', 'dkms install --force xhc-xy3/'):
                self.assert_found(root, 'signature', 'is not signed', fix)
            root.write(SECURE_BOOT, b'\x06\0\0\0\0')
            self.assert_well(root)

    def test_other_enforcers(self):
        root = self.root('xhcctl')
        root.not_loaded()
        root.write('sys/module/module/parameters/sig_enforce', 'Y\n')
        self.assert_found(root, 'signature', 'module.sig_enforce', 'mokutil --import')
        root.write('sys/module/module/parameters/sig_enforce', 'N\n')
        root.write('sys/kernel/security/lockdown', 'none [integrity] confidentiality\n')
        self.assert_found(root, 'signature', 'locked down', 'mokutil --import')
        root.write('sys/kernel/security/lockdown', '[none] integrity confidentiality\n')
        self.assert_well(root)

    # --- udev's rules ---

    def test_rules(self):
        for tool, name in RULES.items():
            root = self.root(tool)
            root.remove('usr/lib/udev/rules.d/' + name)
            self.assert_found(root, 'rules', name + ' is missing', 'make install')
            root.write('lib/udev/rules.d/' + name, '# rules\n')
            self.assert_well(root)
            root.write('etc/udev/rules.d/' + name, '')
            self.assert_found(root, 'rules', 'disables the rules',
                             'rm /etc/udev/rules.d/' + name)

    # --- a pendant ---

    def test_no_pendant(self):
        root = self.root('xhcctl')
        for path in ('sys/bus/usb', 'sys/bus/hid'):
            root.remove(path)
        self.assert_found(root, 'driver', 'no HB03, HB04 or WHB04B', 'lsusb -d 10ce:')

    def test_models(self):
        """Each one that the driver supports is named and checked"""
        for product, name in (('eb6e', 'an HB03'), ('eb70', 'an HB04'),
                              ('eb93', 'a WHB04B-4 or WHB04B-6')):
            with case.row(product):
                root = self.root('xhcctl')
                hid = '0003:10CE:%s.0009' % product.upper()
                root.usb_device('1-3', product)
                root.driven(hid)
                findings = self.assert_well(root)
                assert ('ok', '1-3 (10ce:%s) is %s, supported' % (product, name), None) in \
                    findings['model']
                assert ('ok', '1-3:1.0 is bound to usbhid', None) in findings['holder']
                assert ('ok', hid + ' is bound to hid-xhc', None) in findings['driver']
                root.remove('sys/bus/hid/devices/%s/driver' % hid)
                self.assert_found(root, 'driver', hid + ' has no driver', 'modprobe hid-xhc')

    def test_a_clone(self):
        root = self.root('xhcctl')
        root.usb_device('1-3', 'eb91')
        os.makedirs(root.at('sys/bus/hid/devices/0003:10CE:EB91.0002'))
        self.assert_found(root, 'model', '1-3 (10ce:eb91) is a clone of the WHB04B',
                          'echo 3 10ce eb91 eb93 | sudo tee /sys/bus/hid/drivers/hid-xhc/new_id')
        # this was done already
        root.remove('sys/bus/hid/devices/0003:10CE:EB91.0002')
        root.driven('0003:10CE:EB91.0002')
        findings = self.assert_well(root)
        assert ('ok', '0003:10CE:EB91.0002 is bound to hid-xhc', None) in findings['driver']
        assert ('ok', '1-3 (10ce:eb91) is a clone of the WHB04B, and hid-xhc drives it', None) in \
            findings['model']
        # a clone may have a holder like any other
        root.remove('sys/bus/usb/devices/1-3/1-3:1.0/driver')
        self.assert_found(root, 'holder', '1-3:1.0 has no driver', 'usbhid/bind')

    def test_one_that_may_be_a_pendant(self):
        root = self.root('xhcctl')
        root.usb_device('1-3', 'eb71')
        self.assert_found(root, 'model', '1-3 (10ce:eb71) is perhaps a pendant',
                          'lsusb -v -d 10ce:eb71')

    def test_alone(self):
        """A device that hid-xhc ignores is found once; then the receiver is not missing."""
        for product, check, text, fix in (
                ('eb91', 'model', '1-3 (10ce:eb91) is a clone', 'new_id'),
                ('eb71', 'model', '1-3 (10ce:eb71) is perhaps a pendant', 'lsusb'),
                ('abcd', 'driver', 'no HB03, HB04 or WHB04B is plugged in',
                 'report the output of `lsusb -v -d 10ce:%s' % 'abcd')):
            with case.row(product):
                root = self.root('xhcctl')
                for path in ('sys/bus/usb/devices/1-2', 'sys/bus/hid'):
                    root.remove(path)
                root.usb_device('1-3', product)
                self.assert_found(root, check, text, fix)

    def test_no_pendants(self):
        """Neither is a fault, and no other check uses them"""
        for product, name, todo in (('ea6a', 'a serial bridge', 'cp210x'),
                                    ('eb73', 'a motion card', "its maker's program")):
            with case.row(product):
                root = self.root('xhcctl')
                root.usb_device('1-3', product, 'another')
                status, text, fix = self.assert_well(root)['model'][-1]
                assert (status, fix) == ('skipped', None)
                assert text.startswith('1-3 (10ce:%s) is not a pendant but %s' % (product, name))
                assert todo in text
                # and none of them is the selected pendant
                for path in ('sys/bus/usb/devices/1-2', 'sys/bus/hid'):
                    root.remove(path)
                self.assert_found(root, 'driver', 'no HB03, HB04 or WHB04B', 'lsusb -d 10ce:')

    def test_a_device_that_is_not_known(self):
        root = self.root('xhcctl')
        root.usb_device('1-3', 'abcd', 'another')
        assert ('skipped', '1-3 (10ce:%s) is not known; hid-xhc ignores it' % 'abcd',
                None) in self.assert_well(root)['model']

    def test_pendant_held_by_libusb(self):
        root = self.root('xhcctl')
        driver = 'sys/bus/usb/devices/1-2/1-2:1.0/driver'
        bind = 'echo 1-2:1.0 | sudo tee /sys/bus/usb/drivers/usbhid/bind'
        root.remove(driver)
        self.assert_found(root, 'holder', 'no driver', bind)
        os.symlink('../../../drivers/usbfs', root.at(driver))
        self.assert_found(root, 'holder', 'usbfs', bind)
        root.write('proc/4242/comm', 'xhc-hb04\n')
        os.makedirs(root.at('proc/4242/fd'))
        os.symlink('/dev/bus/usb/001/007', root.at('proc/4242/fd/5'))
        self.assert_found(root, 'holder', 'xhc-hb04 has detached 1-2:1.0', 'kill 4242')
        # devices of other drivers are ignored here
        root.write('sys/bus/usb/devices/1-2/idProduct', 'ffff\n')
        self.assert_well(root)

    def test_held_by_libusb_is_the_only_fault(self):
        """The kernel has no HID device then. doctor must not suggest to plug in the pendant."""
        root = self.root('xhcctl')
        root.remove('sys/bus/usb/devices/1-2/1-2:1.0/driver')
        root.remove('sys/bus/hid')
        self.assert_found(root, 'holder', 'no driver', 'usbhid/bind')
        (status, text, _), = self.ask(root)[0]['driver']
        assert status == 'skipped' and 'see holder' in text

    def test_plugged_in_without_a_hid_device(self):
        root = self.root('xhcctl')
        root.remove('sys/bus/hid')
        self.assert_found(root, 'driver', 'usbhid has made no HID device', 'usbhid.quirks')

    def test_other_driver(self):
        root = self.root('xhcctl')
        driver = 'sys/bus/hid/devices/%s/driver' % HID
        root.remove(driver)
        self.assert_found(root, 'driver', 'no driver', 'modprobe hid-xhc')
        os.symlink('../../drivers/hid-generic', root.at(driver))
        self.assert_found(root, 'driver', 'hid-generic instead of hid-xhc',
                         'tee /sys/bus/hid/drivers/hid-generic/unbind')

    def test_pendant_state(self):
        root = self.root('xhcctl')
        stats = 'sys/bus/hid/drivers/hid-xhc/%s/stats/' % HID
        root.write(stats + 'frame_errors', '3\n')
        self.assert_found(root, 'state', '3 display frames', 'dmesg')
        root.write(stats + 'frame_errors', '0\n')
        root.write(stats + 'unknown_keys', '2\n')
        self.assert_found(root, 'state', 'does not know', 'evtest')
        root.write(stats + 'unknown_keys', '0\n')
        root.write('sys/bus/hid/drivers/hid-xhc/%s/awake' % HID, '0\n')
        assert 'asleep' in self.assert_well(root)['state'][0][1]

    def test_keys_with_names_and_linuxcnc_with_numbers(self):
        root = self.root('xhcctl')
        bits = 8 * struct.calcsize('l')

        def keys(codes):
            number = sum(1 << code for code in codes)
            words = []
            while number:
                words.insert(0, '%x' % (number % (1 << bits)))
                number >>= bits
            root.write('sys/bus/hid/drivers/hid-xhc/%s/input/input7/capabilities/key' % HID,
                       ' '.join(words) + '\n')

        hal = 'home/me/linuxcnc/configs/mill/jog.hal'
        numbers = [0x2c0 + number for number in range(40)]      # BTN_TRIGGER_HAPPY1 and on
        keys(numbers)
        assert self.assert_well(root)['linuxcnc'][0][0] == 'skipped'    # no HAL file
        root.write(hal, '# net a input.0.btn-trigger-happy99\nnet s input.0.btn-trigger-happy31\n'
                        'net r input.0.btn-trigger-happy23\nnet z  input.0.btn-trigger-happy13\n')
        assert self.assert_well(root)['linuxcnc'][0][0] == 'ok'
        for missing in (13, 23):
            keys([128, 166] + [code for code in numbers if code != 0x2c0 + missing - 1])
            self.assert_found(root, 'linuxcnc', '/%s uses btn-trigger-happy%d,' % (hal, missing),
                              'xhcctl layout default --apply')
        keys([128, 166])                # all keys have names
        self.assert_found(root, 'linuxcnc', '/' + hal, 'xhcctl layout default --apply')
        os.rename(root.at('home/me'), root.at('root'))
        self.assert_found(root, 'linuxcnc', '/root/linuxcnc/', 'xhcctl layout default --apply')

    # --- a scanhead ---

    def test_ldisc_number(self):
        root = self.root('xy3ctl')
        root.write('sys/module/xy3/parameters/ldisc', '28\n')
        root.write('proc/tty/ldiscs', 'n_tty       0\nxy3        28\nother        29\n')
        self.assert_found(root, 'ldisc', 'number 28 instead of 29',
                          'ldattach -s 115200 -8 -n -1 28')
        root.not_loaded()
        self.assert_found(root, 'ldisc', 'number 29 is that of other', 'options xy3 ldisc=28')

    # --- serial ports ---

    def port(self, root, name, *, usb=None, head=None):
        """A serial port, that of a head"""
        device = 'sys/devices/' + ('usb/%s/%s:1.0/%s' % (usb, usb, name) if usb else name)
        os.makedirs(root.at(device))
        root.write('sys/class/tty/%s/dev' % name, '188:0\n')
        os.symlink('../../../../' + device, root.at('sys/class/tty/%s/device' % name))
        if head:
            os.symlink('../../tty/' + name, root.at('sys/class/xy3/%s/back' % head))

    def root_without_head(self):
        root = self.root('xy3ctl')
        root.remove('sys/class/xy3')
        return root

    def process(self, root, pid, name, *nodes):
        root.write('proc/%d/comm' % pid, name + '\n')
        os.makedirs(root.at('proc/%d/fd' % pid))
        for number, node in enumerate(nodes):
            os.symlink(node, root.at('proc/%d/fd/%d' % (pid, number)))

    def test_nothing_attached(self):
        """The selected port exists and is free."""
        root = self.root_without_head()
        self.assert_found(root, 'head', 'nothing is attached', 'plug in the adapter')
        root.write('sys/class/tty/ttyS0/type', '0\n')          # without a UART
        os.makedirs(root.at('sys/class/tty/ttyS0/device'))
        os.makedirs(root.at('sys/class/tty/tty1'))
        self.assert_found(root, 'head', 'nothing is attached', 'plug in the adapter')
        self.port(root, 'ttyUSB1', usb='1-1')
        self.assert_found(root, 'head', 'nothing is attached', 'attach /dev/ttyUSB1 ')

    def test_console_and_getty(self):
        """Irrelevant if there is another port"""
        for way, text, fix in (
                ('console', 'ttyAMA0 is the kernel\'s console', 'cmdline.txt'),
                ('getty', 'ttyAMA0 has a login prompt', 'serial-getty@ttyAMA0.service')):
            with case.row(way):
                root = self.root_without_head()
                self.port(root, 'ttyAMA0')
                if way == 'console':
                    root.write('sys/class/tty/console/active', 'tty0 ttyAMA0\n')
                else:
                    self.process(root, 4242, 'agetty', '/dev/ttyAMA0')
                found = self.found(root)
                assert sorted(found) == ['head', 'port']
                assert text in found['port'][0] and fix in found['port'][1]
                assert 'no serial port that is free' in found['head'][1]
                self.port(root, 'ttyUSB0', usb='1-1')
                self.assert_found(root, 'head', 'nothing', 'attach /dev/ttyUSB0 ')
        root = self.root('xy3ctl')
        self.port(root, 'ttyS1', head='xy3-0')
        self.assert_well(root)
        root.write('sys/class/tty/console/active', 'ttyS1\n')
        self.assert_found(root, 'port', 'ttyS1 is the kernel', '/etc/default/grub')
        root.write('sys/class/tty/console/active', 'ttyS11\n')
        self.assert_well(root)
        # a head on a pseudo terminal: the console is irrelevant
        root.remove('sys/class/xy3/xy3-0/back')
        root.write('sys/class/tty/console/active', 'ttyS1\n')
        self.assert_well(root)

    def test_mini_uart(self):
        root = self.root('xy3ctl')
        self.port(root, 'ttyS0', head='xy3-0')
        compatible = 'sys/class/tty/ttyS0/device/of_node/compatible'
        root.write(compatible, b'arm,pl011\0arm,primecell\0')
        self.assert_well(root)
        root.write(compatible, b'brcm,bcm2835-aux-uart\0')
        self.assert_found(root, 'port', 'ttyS0 is the mini-UART', 'dtoverlay=disable-bt')

    def test_a_better_port(self):
        """With no head attached, trouble of one port is irrelevant if another has none."""
        root = self.root_without_head()
        self.port(root, 'ttyS0')
        root.write('sys/class/tty/ttyS0/device/of_node/compatible', b'brcm,bcm2835-aux-uart\0')
        self.process(root, 4242, 'ModemManager')
        found = self.found(root)
        assert 'ttyS0 is the mini-UART' in found['port'][0]
        assert 'attach /dev/ttyS0 ' in found['head'][1]
        self.port(root, 'ttyUSB0', usb='1-1')
        texts = [finding[1] for finding in self.ask(root)[0]['port']]
        assert ['ttyS0' in text or 'ModemManager may open ttyUSB0' in text for text in texts] == \
            [True, True]
        root.write('run/udev/data/c188:0', 'E:ID_BUS=usb\nE:ID_MM_PORT_IGNORE=1\n')
        self.port(root, 'ttyUSB1', usb='1-2')
        self.assert_found(root, 'head', 'nothing is attached', 'attach /dev/ttyUSB0 ')

    def test_latency_of_ftdi(self):
        root = self.root('xy3ctl')
        self.port(root, 'ttyUSB0', usb='1-1', head='xy3-0')
        timer = 'sys/class/tty/ttyUSB0/device/latency_timer'
        root.write(timer, '1\n')
        self.assert_well(root)
        root.write(timer, '16\n')
        self.assert_found(root, 'port', 'ttyUSB0 delays bytes by up to 16 ms',
                          'echo 1 | sudo tee /' + timer)
        self.port(root, 'ttyUSB1', usb='1-2')
        root.write(timer, '1\n')
        root.write('sys/class/tty/ttyUSB1/device/latency_timer', '16\n')
        self.assert_well(root)          # not that of a head

    def test_modem_manager(self):
        root = self.root('xy3ctl')
        self.port(root, 'ttyUSB0', usb='1-1.2', head='xy3-0')
        self.assert_well(root)
        self.process(root, 4242, 'ModemManager')
        self.assert_found(root, 'port', 'ModemManager may open ttyUSB0',
                          'SUBSYSTEM=="tty", KERNELS=="1-1.2:1.0", ENV{XY3_BACKCHANNEL}="1"')
        root.write('run/udev/data/c188:0', 'E:ID_BUS=usb\nE:ID_MM_PORT_IGNORE=1\n')
        self.assert_well(root)
        # a port of the board is irrelevant
        root = self.root('xy3ctl')
        self.port(root, 'ttyAMA0', head='xy3-0')
        self.process(root, 4242, 'ModemManager')
        self.assert_well(root)

    def test_adapters(self):
        """brltty detaches one from its driver, and then there is no ttyUSB0."""
        root = self.root('xy3ctl')
        usb = 'sys/bus/usb/devices/1-1.2/'
        root.write(usb + 'idVendor', '1a86\n')
        root.write(usb + 'idProduct', '7523\n')
        driver = usb + '1-1.2:1.0/driver'
        os.makedirs(root.at(usb + '1-1.2:1.0'))
        self.assert_found(root, 'adapter', '1-1.2 (1a86:7523)', 'sudo modprobe ch341')
        for bound in ('', 'usbfs'):
            if bound:
                os.symlink('../drivers/' + bound, root.at(driver))
                self.assert_found(root, 'adapter', 'has the driver usbfs', 'plug it in again')
            root.write('usr/lib/udev/rules.d/85-brltty.rules', '')
            for system, command in (('ID=ubuntu', 'sudo apt remove brltty '),
                                    ('ID=fedora', 'sudo dnf remove brltty '),
                                    ('ID=arch', 'remove brltty ')):
                root.system(system)
                self.assert_found(root, 'adapter', 'brltty has claimed it', command)
            root.remove('usr/lib/udev/rules.d/85-brltty.rules')
        root.remove(driver)
        os.symlink('../drivers/ch341', root.at(driver))
        root.write('usr/lib/udev/rules.d/85-brltty.rules', '')
        self.assert_well(root)

    def test_halves(self):
        root = self.root('xy3ctl')
        root.write('sys/class/xy3/xy3-1/in_sync', '0\n')
        os.symlink('../x', root.at('sys/class/xy3/xy3-1/forward'))
        os.makedirs(root.at('sys/class/xy3/x'))
        self.assert_found(root, 'head', 'xy3-0 has only a backchannel, and xy3-1',
                         'echo xy3-1 | sudo tee /sys/class/xy3/attach')

    def test_names_of_pendants(self):
        """Each name in list selects the device; any other selects none, and no check succeeds."""
        root = self.root('xhcctl')
        later = '0003:10CE:EB6E.0009'       # its product sorts first, its number does not
        root.driven(later)
        device = 'sys/bus/hid/devices/%s/' % HID
        for path in ('input/input7/event3', 'hidraw/hidraw2'):
            os.makedirs(root.at(device + path))
        root.write(device + 'uevent', 'DRIVER=hid-xhc\nHID_PHYS=usb-0000:00:14.0-2/input0\n')
        os.makedirs(root.at('dev/input'))
        os.symlink('event3', root.at('dev/input/xhc-hb04'))
        root.remove('sys/bus/hid/devices/%s/driver' % HID)
        for name in ('0', HID, HID.lower(), 'event3', '/dev/input/event3', '/dev/input/xhc-hb04',
                     'hidraw2', '/dev/hidraw2', 'usb-0000:00:14.0-2/input0'):
            with case.row(name):
                findings, status = self.ask(root, '-d', name)
                assert status == 1
                assert [text for _, text, _ in findings['driver']] == [HID + ' has no driver']
        for name in ('1', later):
            with case.row(name):
                findings, status = self.ask(root, '-d', name)
                assert status == 0
                assert findings['driver'][0][:2] == ('ok', later + ' is bound to hid-xhc')

    def test_no_such_device(self):
        for tool, names in (('xhcctl', ('1', '-1', 'event9', 'nosuch', '0003:10CE:EB70.0002', '')),
                            ('xy3ctl', ('1', 'xy3-1', '/dev/xy3-1', 'nosuch', ''))):
            root = self.root(tool)
            for name in names:
                with case.row(tool, name):
                    done = subprocess.run(
                        [os.path.join(self.dir, tool), 'doctor', '-j', '--root', root.path,
                         '--device=' + name], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                        text=True, check=False)
                    assert done.returncode == 3
                    assert 'no %s %s' % (
                        {'xhcctl': 'pendant', 'xy3ctl': 'scanhead'}[tool], name) in done.stderr
                    assert 'findings' not in json.loads(done.stdout)

    def test_names_of_heads(self):
        root = self.root('xy3ctl')
        for name in ('0', 'xy3-0', '/dev/xy3-0'):
            assert self.ask(root, '-d', name)[0]['back'][0][0] == 'ok'
        os.rename(root.at('sys/class/xy3/xy3-0'), root.at('sys/class/xy3/xy3-2'))
        assert self.ask(root, '-d', '2')[0]['back'][0][1].startswith('xy3-2 ')

    def test_device(self):
        """Only findings of the selected one"""
        root = self.root('xy3ctl')
        root.write('sys/class/xy3/xy3-1/rate', '115200\n')
        root.write('sys/class/xy3/xy3-1/in_sync', '0\n')
        root.write('sys/class/xy3/xy3-1/stats/rx_bytes', '0\n')
        assert self.ask(root, '-d', 'xy3-0')[1] == 0
        findings, status = self.ask(root, '-d', 'xy3-1')
        assert status == 1
        assert 'no byte was received' in findings['back'][0][1]
