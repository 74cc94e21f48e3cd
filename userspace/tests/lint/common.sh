# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# For the scripts beside it, to be sourced. Each of them is one check: it prints what is wrong and
# its status is 0 if nothing is.

# shellcheck source=../lib.sh
. "$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)/lib.sh"

# files [PATTERN...]: the project's files, with paths from its top; with patterns those only
# (shell patterns against the whole path, where * also stands for /). Without git, what it would
# ignore is left out by hand.
files() {
	local file pattern
	cd "$top" || return 1
	if [ -e .git ] && command -v git > /dev/null; then
		# root may run this in another user's clone
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

# scripts WORD: files whose first line names an interpreter with WORD in its name
scripts() {
	local file
	files | while read -r file; do
		if head -c 200 "$top/$file" | head -n 1 | grep -qaE "^#!.*\\b$1[0-9.]*\\b"; then
			echo "$file"
		fi
	done
}

# copy_sources DIR: what the kernel's build needs, clean
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

# What a build must bring forth: drivers/NAME.ko, with a file *-core.c beside each
# shellcheck disable=SC2034 # used by those who source this
modules=(hid-xhc/hid-xhc xy3/xy3 xy3/spi/xy3-spi xy3/sim/xy3-sim)

# Sparse does not know that guard() unlocks where its block ends, so it cannot count locks.
# shellcheck disable=SC2034 # used by those who source this
sparse_flags='-D__CHECK_ENDIAN__ -Wno-context'

# quiet_build LOG: whether a build's log has nothing to say about our own files. Sparse's findings,
# and whatever -Werror does not cover, are there and nowhere else.
quiet_build() {
	local ours='(^|[ /])(drivers/(hid-xhc|xy3|include)|kunit)/[^ :]*:[0-9]+:([0-9]+:)?'
	! grep -E "$ours (warning|error|fatal error)" "$1"
}
