# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# Functions of the demonstrations, to be sourced: a Debian kernel, the modules built for it, and a
# virtual machine under QEMU. Missing packages are installed on this machine (which requires root);
# its kernel is not changed.
#
#	prepare		the packages, the kernel, the modules; results are in build/demo
#	initramfs FOLDER CODE OPTION...	the files of the guest: FOLDER/init, all of FOLDER in /demo,
#			and the files that Python loads to run CODE; OPTIONs are those of
#			userspace/vm/initramfs
#	watch ARGUMENT...	boot with these additional arguments for QEMU, and show the output of
#			the guest; fails if the guest fails

vm=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
# shellcheck source=paths.sh
. "$vm/../paths.sh"
out=$top/build/demo
python=/usr/bin/python3

say() {
	echo "demo: $*"
}

build_modules() {
	rm -rf "$out/modules"
	mkdir -p "$out/modules"
	(cd "$top" && cp -R --parents drivers Kbuild "$out/modules/")
	make -C "$kernel/usr/src/linux-headers-$release" M="$out/modules" modules \
		> "$out/build.log" 2>&1 || { tail -n 30 "$out/build.log"; return 1; }
}

prepare() {
	local image

	mkdir -p "$out"
	"$top/userspace/setup" demo
	say 'unpacking the kernel'
	kernel=$("$vm/debian-kernel")
	release=$(basename "$kernel"/lib/modules/*)
	say "building the modules for $release"
	build_modules
	image=$kernel/boot/vmlinuz-$release
	[ -e "$image" ] || image=$kernel/lib/modules/$release/vmlinuz
	"$vm/vmlinux" "$image" "$out/vmlinux"
}

# The files of the Python library that some code loads
python_files() {
	(cd / && "$python" -B) <<-END
	import encodings.ascii, encodings.latin_1, encodings.utf_16_le, sys, traceback
	$1
	for module in list(sys.modules.values()):
	    file = getattr(module, '__file__', None)
	    if file and file.startswith('/usr/'):
	        print(file)
	        if getattr(module, '__cached__', None) and module.__cached__ != file:
	            print(module.__cached__)
	END
}

initramfs() {
	local folder=$1 code=$2 file
	shift 2
	local -a options=(--init "$folder/init" --modules "$kernel/lib/modules/$release"
		--program "$python" --tree "$folder:/demo" --tree "$top/userspace/demo/guest:/guest" "$@")

	# loaded by the C library when a thread ends
	options+=(--file "$(ldconfig -p | awk '$1 == "libgcc_s.so.1" && !n++ { print $NF }')")
	while read -r file; do
		[ ! -e "$file" ] || options+=(--file "$file")
	done < <(python_files "$code")
	"$vm/initramfs" "${options[@]}" "$out/initramfs"
}

watch() {
	local status=0

	say 'starting a virtual machine; its output appears after some seconds'
	timeout --foreground 240 qemu-system-x86_64 \
		-M pc -accel tcg,thread=multi -cpu max -smp 1 -m 768 \
		-nodefaults -no-user-config -display none -no-reboot -serial stdio \
		-device isa-debug-exit,iobase=0xf4,iosize=1 \
		-kernel "$out/vmlinux" -initrd "$out/initramfs" \
		-append "console=ttyS0 loglevel=3 panic=-1 oops=panic panic_on_warn=1 mitigations=off \
			tsc=unstable clocksource=hpet no_timer_check random.trust_cpu=on cryptomgr.notests" \
		"$@" < /dev/null | sed -u 's/\r$//' | tee "$out/screen.log" || status=$?
	# guest/start.sh writes 16 + its status to the exit port; QEMU ends with twice that, plus 1
	[ $status = 33 ] || { say 'failed'; return 1; }
}
