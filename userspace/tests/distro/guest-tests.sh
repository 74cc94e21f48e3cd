# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# Functions of scripts that run tests in a guest; to be sourced by scripts that set $here to this
# folder, and $suite, the first part of the names of their results.
#
#	$heads, $storms, $smoke	files of tests, as in guest-init/run-tests
#	boot_and_test NAME KERNEL TESTS [ARGUMENT...]	boot the copy of the root, $ROOT, with the
#			release KERNEL and further kernel arguments, and run TESTS: one result for
#			each test, one for the end of the guest, one for its log
#
# Both kinds of tests check modules that are loaded for the first time, so the order matters.

# shellcheck source=../lib.sh
. "$(dirname "${BASH_SOURCE[0]}")/../lib.sh"
level check-distro	# only for $out and the names: check-distro counts

# shellcheck disable=SC2034 # for the script that sources this
{
	heads=guest/backchannel,guest/forward_channel
	storms=pendant/storm,guest/backchannel_storm
	smoke=guest/pendant_udev,pendant/events,pendant/dro,pendant/whb04b,$heads
}

# shellcheck disable=SC2154 # set by the script that sources this, or by with-overlay
boot_and_test() {
	local name=$suite-$1 release=$2 tests=$3 dir=$out/$suite-$1 status=0 planned run
	shift 3

	rm -rf "$dir"
	APPEND="tests=$tests $*" LIMIT=${LIMIT:-3000} "$here/boot" "$ROOT" "$release" "$dir" \
		> "$out/$name.log" 2>&1 || status=$?
	[ -e "$dir/results" ] || touch "$dir/results" "$dir/console.log"

	sed -n -e "s/^ok /ok $name-/p" -e "s/^not ok /not ok $name-/p" -e '/^    /p' "$dir/results"
	planned=$(sed -n 's/^1\.\.\([0-9]*\)$/\1/p' "$dir/results")
	run=$(grep -cE '^(ok|not ok) ' "$dir/results" || true)
	if [ "$run" -eq "${planned:-0}" ] && [ "$run" -ge "$(least "$name")" ] &&
			[ "$status" -le 1 ]; then
		pass "$name-came-to-its-end"
	else
		tail -n 5 "$out/$name.log" "$dir/results" "$dir/console.log" | sed 's/^/    /'
		# lines that are no results: they may explain a missing one
		grep -nvE '^(ok|not ok|    |1\.\.|$)' "$dir/results" | tail -n 20 | sed 's/^/    /' || true
		fail "$name-came-to-its-end" \
			"$run of ${planned:-?} tests (at least $(least "$name")), status $status"
	fi
	attempt "$name-log-is-clean" "$here/console-clean" "$dir/console.log" || true
}
