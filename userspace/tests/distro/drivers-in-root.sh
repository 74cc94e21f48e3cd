# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# What all scripts that install the drivers in a Debian tree ($root) share; to be sourced by those
# who have set $root, and $here to this folder.
#
#	$top, $name, $version	of this tree's package
#	in_root COMMAND...	in the tree
#	refuse WHY		the end
#	ours DIR		our modules below a folder
#	built_for KERNEL	they are there for this kernel, and found
#	left_out KERNEL		DKMS leaves this kernel out

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

# $1: an alias as the kernel asks for it, $2: the module, $3: the kernel
leads_to() {
	in_root modprobe -S "$3" -R "$1" | grep -qx "$2" || refuse "$1 does not lead to $2"
}

built_for() {
	local kernel=$1 driver installed

	in_root dkms status -m "$name" -v "$version" -k "$kernel" | grep ': installed' ||
		refuse 'not installed, says dkms'
	for driver in "${drivers[@]}"; do
		in_root modinfo -k "$kernel" "$driver"
	done
	leads_to hid:b0003g0001v000010CEp0000EB70 hid_xhc "$kernel"
	leads_to tty-ldisc-29 xy3 "$kernel"
	leads_to 'of:NbackchannelT(null)Clasia,xy3-100-backchannel' xy3 "$kernel"
	leads_to spi:xy3-100 xy3_spi "$kernel"
	leads_to 'of:NscanheadT(null)Clasia,xy3-100' xy3_spi "$kernel"

	installed=$(find "$root/usr/lib/modules/$kernel/updates" -name '*.ko*' -printf '%P\n' |
		sed -E 's/\.(xz|zst|gz)$//' | sort)
	[ "$installed" = "$(printf 'dkms/%s.ko\n' "${drivers[@]}" | sort)" ] ||
		refuse "installed was more or less than the drivers: $installed"
}

# dkms' status 77: excluded by the package itself. What kernel packages call is the hook; if
# that fails, the upgrade does.
left_out() {
	local kernel=$1 status=0

	in_root dkms install -m "$name" -v "$version" -k "$kernel" || status=$?
	[ "$status" -eq 77 ] || refuse "dkms install ended with status $status, not 77"
	in_root /etc/kernel/postinst.d/dkms "$kernel" || refuse 'the kernel hook failed'
	[ -z "$(ours "$root/usr/lib/modules/$kernel")" ] || refuse 'a module came to be'
}
