# SPDX-License-Identifier: GPL-2.0-only
#
# For users; the kernel build reads Kbuild. `make help` lists all targets.

NAME := xhc-xy3
VERSION := 0.1.0

KVER ?= $(shell uname -r)
KDIR ?= /lib/modules/$(KVER)/build

PREFIX ?= /usr/local
DESTDIR ?=
UDEVDIR ?= /usr/lib/udev
UNITDIR ?= /usr/lib/systemd/system
SRCDIR := /usr/src/$(NAME)-$(VERSION)

# A kernel built by clang requires modules built by clang; dkms may have passed LLVM itself
ifneq ($(shell grep -hs '^CONFIG_CC_IS_CLANG=y' $(KDIR)/include/config/auto.conf),)
LLVM ?= 1
export LLVM
endif

.PHONY: all modules clean help install uninstall install-files uninstall-files demo demo-scanhead \
	lib install-lib uninstall-lib tools install-tools uninstall-tools deb requirements \
	series mutate bench check check-quick check-host check-kunit check-uml check-distro \
	check-boards lint

all: modules

modules:
	$(MAKE) -C $(KDIR) M=$(CURDIR) modules

clean:
	find drivers $(wildcard kunit) -type f \( -name '*.o' -o -name '*.ko' -o -name '*.mod' \
		-o -name '*.mod.c' -o -name '.*.cmd' -o -name 'modules.order' -o -name '*.o.d' \) \
		-delete
	rm -f Module.symvers modules.order .module-common.o .*.cmd
	rm -rf build/libxy3 build/tools

help:
	@echo 'Build and install (KVER=release or KDIR=folder choose another kernel):'
	@echo '  make               build the modules for the running kernel'
	@echo '  sudo make install  install them through DKMS, with udev rules and virtual devices;'
	@echo '                     with DESTDIR= only files are copied, for packagers'
	@echo '  sudo make uninstall  remove all that was installed, tools and libxy3 included'
	@echo '  make lib           libxy3 for programs in C, in build/libxy3; install-lib installs it'
	@echo '  make tools         xhcctl and xy3ctl, in build/tools; install-tools installs them'
	@echo '  make deb           packages for Debian, in build/deb'
	@echo '  make series KSRC=tree  commit the drivers to a git tree of a current kernel'
	@echo '  make clean         remove what was built here'
	@echo 'Try and test (need no device, never touch the running kernel):'
	@echo '  make check-quick   tests for a minute: requires gcc and python3, installs nothing'
	@echo '  sudo make demo     a virtual pendant in a virtual machine, also MODEL=whb04b'
	@echo '  sudo make demo-scanhead  a virtual scanhead, which draws what it receives'
	@echo '  sudo make check    all levels of tests:'
	@echo '    check-host         codecs, on this machine, under sanitizers'
	@echo '    check-kunit        codecs and driver in a debugging kernel (User Mode Linux)'
	@echo '    check-uml          the whole stack in that kernel, with virtual pendants'
	@echo '    check-distro       DKMS and the whole stack on stock Debian kernels (QEMU)'
	@echo '    check-boards       the drivers on a board for arm64, decoded at its pins (QEMU)'
	@echo '    lint               compilers, sparse, checkpatch, documents against code'
	@echo '  sudo make bench    speed of codecs and forward channel, compared with other code'
	@echo '  sudo make mutate   plant faults in the drivers, which a test must detect'

# The virtual devices: each has a program, a Python package with _ instead of -, and a manual page
SIMULATORS := xhc-sim xy3-head-sim

# Manual pages of the modules; that of xy3-spi is the page of xy3
MAN4 := userspace/xy3-sim/xy3-sim.4 userspace/doc/hid-xhc.4 userspace/doc/xy3.4

# Source of the drivers for DKMS, header for programs, udev rules, units, virtual devices
install-files: $(addprefix install-,$(SIMULATORS)) install-linuxcnc
	install -d $(DESTDIR)$(SRCDIR)
	cp -R --parents drivers Kbuild Makefile dkms.conf $(DESTDIR)$(SRCDIR)/
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/include/linux drivers/include/uapi/linux/xy3.h
	install -D -m 644 -t $(DESTDIR)$(UDEVDIR)/rules.d userspace/udev/*.rules
	install -D -m 644 -t $(DESTDIR)$(UNITDIR) userspace/systemd/*.service
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/$(NAME)/layouts userspace/hwdb/layouts/*
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/$(NAME)/overlays userspace/overlays/*.dtso
	install -D -t $(DESTDIR)$(PREFIX)/share/$(NAME)/examples userspace/examples/*.py
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/man/man4 $(MAN4)
	ln -sf xy3.4 $(DESTDIR)$(PREFIX)/share/man/man4/xy3-spi.4

$(addprefix install-,$(SIMULATORS)): install-%:
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/lib/$(NAME)/$(subst -,_,$*) \
		userspace/$*/$(subst -,_,$*)/*.py
	install -D -m 755 -t $(DESTDIR)$(PREFIX)/lib/$(NAME) userspace/$*/$*
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/man/man1 userspace/$*/$*.1
	install -d $(DESTDIR)$(PREFIX)/bin
	ln -sf ../lib/$(NAME)/$* $(DESTDIR)$(PREFIX)/bin/$*

# The display of a pendant for LinuxCNC, and a configuration to copy
install-linuxcnc:
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/lib/$(NAME)/xhc_dro \
		$(addprefix userspace/linuxcnc/xhc_dro/*.,py keys)
	install -D -m 755 -t $(DESTDIR)$(PREFIX)/lib/$(NAME) userspace/linuxcnc/xhc-dro
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/man/man1 userspace/linuxcnc/xhc-dro.1
	install -D -m 644 -t $(DESTDIR)$(PREFIX)/share/$(NAME)/linuxcnc \
		$(addprefix userspace/linuxcnc/*.,hal tcl ini tbl)
	install -d $(DESTDIR)$(PREFIX)/bin
	ln -sf ../lib/$(NAME)/xhc-dro $(DESTDIR)$(PREFIX)/bin/xhc-dro

# The requirements of all goals of a command are checked once, before the first goal
ifeq ($(DESTDIR),)
INSTALLS := $(filter install install-lib install-tools,$(MAKECMDGOALS))
$(INSTALLS): requirements

requirements:
	@KVER=$(KVER) userspace/setup --missing $(INSTALLS)
endif

# The library requires a compiler, unlike install-files
lib:
	$(MAKE) -C userspace/libxy3 all

install-lib uninstall-lib: %-lib:
	$(MAKE) -C userspace/libxy3 $*

# The tools require libraries
tools:
	$(MAKE) -C userspace/tools all

install-tools uninstall-tools: %-tools:
	$(MAKE) -C userspace/tools $*

# Debian's packages, in build/deb
deb:
	userspace/packages/make-deb

# The drivers as commits to a kernel tree
series:
	userspace/tests/series/make-series $(KSRC)

# A second installation is no error: this version is first removed from dkms
install:
ifeq ($(DESTDIR),)
	if dkms status -m $(NAME) -v $(VERSION) | grep -q .; then \
		dkms remove -m $(NAME) -v $(VERSION) --all; fi
	rm -rf $(SRCDIR)
endif
	$(MAKE) install-files
ifeq ($(DESTDIR),)
	dkms install -m $(NAME) -v $(VERSION) -k $(KVER)
	-udevadm control --reload
	-systemctl daemon-reload
endif

uninstall-files: uninstall-lib uninstall-tools
	rm -rf $(DESTDIR)$(SRCDIR) $(DESTDIR)$(PREFIX)/lib/$(NAME) $(DESTDIR)$(PREFIX)/share/$(NAME)
	rm -f $(patsubst %,$(DESTDIR)$(PREFIX)/bin/%,$(SIMULATORS) xhc-dro)
	rm -f $(patsubst %,$(DESTDIR)$(PREFIX)/share/man/man1/%.1,$(SIMULATORS) xhc-dro)
	rm -f $(patsubst %,$(DESTDIR)$(PREFIX)/share/man/man4/%,$(notdir $(MAN4)) xy3-spi.4)
	rm -f $(DESTDIR)$(PREFIX)/include/linux/xy3.h
	for folder in include/linux share/man/man1 share/man/man3 share/man/man4; do \
		[ ! -d $(DESTDIR)$(PREFIX)/$$folder ] || \
		rmdir --ignore-fail-on-non-empty $(DESTDIR)$(PREFIX)/$$folder; done
	rm -f $(patsubst userspace/udev/%,$(DESTDIR)$(UDEVDIR)/rules.d/%,$(wildcard userspace/udev/*))
	rm -f $(patsubst userspace/systemd/%,$(DESTDIR)$(UNITDIR)/%,$(wildcard userspace/systemd/*))

uninstall:
ifeq ($(DESTDIR),)
	-systemctl stop 'xy3-attach@*.service'
	-modprobe -r xy3-sim xy3-spi xy3 hid-xhc
	-dkms remove -m $(NAME) -v $(VERSION) --all
endif
	$(MAKE) uninstall-files
ifeq ($(DESTDIR),)
	sh userspace/packages/debian/xhc-xy3-tools.postrm purge
	-udevadm control --reload
	-systemctl daemon-reload
endif

demo:
	userspace/demo/pendant/run-demo $(MODEL)

demo-scanhead:
	userspace/demo/scanhead/run-demo

check:
	@userspace/tests/check

check-quick:
	userspace/tests/check-quick

check-host:
	userspace/tests/check-host

check-kunit:
	userspace/tests/check-kunit

check-uml:
	userspace/tests/check-uml

check-distro:
	userspace/tests/check-distro

check-boards:
	userspace/tests/check-boards

lint:
	userspace/tests/check-lint

mutate:
	userspace/tests/mutate/mutate
	userspace/tests/mutate/score

bench:
	userspace/tests/bench/codec/bench-codec
	userspace/tests/bench/forward/bench-forward
