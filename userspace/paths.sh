# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# Folders used by several scripts; to be sourced.
#
#	$top		the tree
#	$cache		built kernels and Debian root file systems, outside the tree; always safe to
#			delete

# shellcheck disable=SC2034 # used by scripts that source this file
top=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
cache=${XHC_XY3_CACHE:-${XDG_CACHE_HOME:-${HOME:-/root}/.cache}/xhc-xy3}
mkdir -p "$cache"
export XHC_XY3_CACHE="$cache"	# for called scripts
