# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# Functions of scripts that install the drivers in a Debian root ($root); to be sourced by scripts
# that set $root, and $here to this folder.
#
#	$top, $name, $version	of the package of this tree
#	in_root COMMAND...	run COMMAND in the root
#	refuse WHY		print WHY and exit
#	ours DIR		list our modules below a folder
#	built_for KERNEL	check that they are installed for a kernel, and are found
#	left_out KERNEL		check that DKMS does not build for a kernel
#	by_need KERNEL		check that DKMS leaves out drivers whose requirements a kernel lacks

# shellcheck disable=SC2154 # see above
top=$(cd "$here/../../.." && pwd)
name=$(sed -n 's/^PACKAGE_NAME="\(.*\)"/\1/p' "$top/dkms.conf")
version=$(sed -n 's/^PACKAGE_VERSION="\(.*\)"/\1/p' "$top/dkms.conf")
drivers=(hid-xhc xy3 xy3-sim xy3-spi)

in_root() {
	# shellcheck disable=SC2154
	"$here/with-chroot" "$root" "$@"
}

refuse() {
	echo "$(basename "$0"): $*" >&2
	exit 1
}

ours() {
	local driver
	for driver in "${drivers[@]}"; do
		find "$1" -name "$driver.*"
	done
}

# $1: an alias requested by the kernel, $2: the module, $3: the kernel
leads_to() {
	in_root modprobe -S "$3" -R "$1" | grep -qx "$2" || refuse "$1 does not lead to $2"
}

built_for() {
	local kernel=$1 driver

	in_root dkms status -m "$name" -v "$version" -k "$kernel" | grep ': installed' ||
		refuse 'dkms status: not installed'
	for driver in "${drivers[@]}"; do
		in_root modinfo -k "$kernel" "$driver"
	done
	leads_to hid:b0003g0001v000010CEp0000EB93 hid_xhc "$kernel"
	leads_to hid:b0003g0001v000010CEp0000EB70 hid_xhc "$kernel"
	leads_to tty-ldisc-29 xy3 "$kernel"
	leads_to 'of:NbackchannelT(null)Clasia,xy3-100-backchannel' xy3 "$kernel"
	leads_to spi:xy3-100 xy3_spi "$kernel"
	leads_to 'of:NscanheadT(null)Clasia,xy3-100' xy3_spi "$kernel"

	installed_are "$kernel" "${drivers[@]}"
}

# $1: the kernel, $2...: our drivers that are installed for it, and no others
installed_are() {
	local kernel=$1 installed
	shift
	installed=$(find "$root/usr/lib/modules/$kernel/updates" -name '*.ko*' -printf '%P\n' |
		sed -E 's/\.(xz|zst|gz)$//' | sort)
	[ "$installed" = "$(printf 'dkms/%s.ko\n' "$@" | sort)" ] ||
		refuse "expected $*, installed: $installed"
}

# dkms' status 77: excluded by the package. Kernel packages call the hook; if it fails, so does
# the upgrade.
left_out() {
	local kernel=$1 status=0

	in_root dkms install -m "$name" -v "$version" -k "$kernel" || status=$?
	[ "$status" -eq 77 ] || refuse "dkms install ended with status $status, not 77"
	in_root /etc/kernel/postinst.d/dkms "$kernel" || refuse 'the kernel hook failed'
	[ -z "$(ours "$root/usr/lib/modules/$kernel")" ] || refuse 'a module was built'
}

# A custom kernel: the headers of kernel $1 with the name $2, without the symbols $3
without() {
	local file
	cp -a "$root/usr/src/linux-headers-$1" "$root/usr/src/linux-headers-$2"
	for file in .config include/config/auto.conf; do
		sed -i -E "s/^(CONFIG_($3))=.*/# \\1 is not set/" "$root/usr/src/linux-headers-$2/$file"
	done
	# Debian's Makefile has the path of the folder
	sed -i "s|/usr/src/linux-headers-$1\$|/usr/src/linux-headers-$2|" \
		"$root/usr/src/linux-headers-$2/Makefile"
	mkdir "$root/usr/lib/modules/$2"
	ln -s "/usr/src/linux-headers-$2" "$root/usr/lib/modules/$2/build"
}

# The headers are removed before dkms removes the modules
by_need() {
	local own=${1%%-*}-own status log driver

	without "$1" "$own" 'SPI|SERIAL_DEV_BUS|IIO_BUFFER'
	in_root dkms autoinstall -k "$own"
	installed_are "$own" hid-xhc
	log=$(cat "$root/var/lib/dkms/$name/$version/$own"/*/log/make.log)
	for driver in xy3 xy3-spi xy3-sim; do
		[ "$(grep -c "^$name: $driver is left out: .* CONFIG_SERIAL_DEV_BUS" <<< "$log")" \
			-eq 1 ] || refuse "make.log has not one line on $driver"
	done

	rm -r "$root/usr/src/linux-headers-$own" "$root/usr/lib/modules/$own/build"
	status=$(in_root dkms status -m "$name" -v "$version" -k "$own")
	[[ $status == *': installed' ]] || refuse "dkms status: $status"
	in_root dkms uninstall -m "$name" -v "$version" -k "$own"
	[ -z "$(ours "$root/usr/lib/modules/$own")" ] || refuse 'modules are left'
	in_root dkms unbuild -m "$name" -v "$version" -k "$own"
	[ -z "$(find "$root/var/lib/dkms" -name "*$own*")" ] || refuse 'dkms still has the kernel'
	rm -r "$root/usr/lib/modules/$own"
}
