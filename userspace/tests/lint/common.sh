# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# To be sourced by the scripts in this folder. Each of them is one check: it prints faults, and its
# status is 0 if there are none.

# shellcheck source=../lib.sh
. "$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)/lib.sh"

# files [PATTERN...]: list the files of the project, relative to its top; with patterns only
# matching files (shell patterns for the whole path, where * also matches /). Without git, files
# that git ignores are excluded explicitly.
files() {
	local file pattern
	cd "$top" || return 1
	if [ -e .git ] && command -v git > /dev/null; then
		# root may run this in the clone of another user
		git -c safe.directory="$top" ls-files --cached --others --exclude-standard
	else
		find . -path ./build -prune -o -type f -not -path '*/__pycache__/*' -printf '%P\n'
	fi | sort -u | while read -r file; do
		[ -f "$file" ] || continue	# deleted, and not committed yet
		[ $# -gt 0 ] || echo "$file"
		for pattern; do
			# shellcheck disable=SC2053 # it is a pattern
			if [[ $file == $pattern ]]; then
				echo "$file"
				break
			fi
		done
	done
}

# scripts WORD: list files whose first line has an interpreter with WORD in its name
scripts() {
	local file
	files | while read -r file; do
		if head -c 200 "$top/$file" | head -n 1 | grep -qaE "^#!.*\\b$1[0-9.]*\\b"; then
			echo "$file"
		fi
	done
}

# copy_sources DIR: copy the files that a kernel build requires, without build products
copy_sources() {
	local file
	rm -rf "$1"
	mkdir -p "$1"
	files 'drivers/*' 'kunit/*.[ch]' kunit/Kbuild Kbuild Makefile dkms.conf |
		while read -r file; do
			mkdir -p "$1/$(dirname "$file")"
			cp "$top/$file" "$1/$file"
		done
}

# The modules that a build must create: drivers/NAME.ko, each with a file *-core.c in its folder
# shellcheck disable=SC2034 # used by scripts that source this file
modules=(hid-xhc/hid-xhc xy3/xy3 xy3/spi/xy3-spi xy3/sim/xy3-sim)

# Sparse does not support that guard() unlocks at the end of its block, so it cannot count locks.
# shellcheck disable=SC2034 # used by scripts that source this file
sparse_flags='-D__CHECK_ENDIAN__ -Wno-context'

# quiet_build LOG: check that a build log has no warnings about our files. Findings of sparse, and
# warnings that -Werror does not cover, are only in the log.
quiet_build() {
	local ours='(^|[ /])(drivers/(hid-xhc|xy3|include)|kunit)/[^ :]*:[0-9]+:([0-9]+:)?'
	! grep -E "$ours (warning|error|fatal error)" "$1"
}
