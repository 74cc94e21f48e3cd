# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# Common to check-host and check-quick; to be sourced after lib.sh.
#
#	suites TOOLCHAIN	run the suites of pure code and the exhaustive tests with a toolchain of
#				kunit/host/run-suites; each case counts as one test

# shellcheck disable=SC2154 # $top and $out are set by lib.sh
host=$top/kunit/host
codec=$top/userspace/tests/codec
programs=("$top"/kunit/*_codec_test.c "$codec"/exhaustive/*.c "$host"/selftest/*_test.c)

suites() {
	local toolchain=$1 dir=$out/$1 results=$out/$1.results program passed failed ran
	rm -rf "$dir"
	mkdir -p "$dir"
	minima check-host > "$out/minimum"
	if ! "$host/run-suites" -m "$out/minimum" "$toolchain" "$dir" "${programs[@]}" \
			> "$results" 2> "$dir.log"; then
		sed 's/^/    /' "$dir.log"
	fi
	while read -r program passed failed; do
		tally "$passed" "$failed"
		if [ "$failed" = 0 ]; then
			echo "ok $toolchain: $program: $passed cases"
		else
			echo "not ok $toolchain: $program: $passed passed, $failed failed"
		fi
	done < "$results"
	# each program must have run once
	ran=$(cut -d ' ' -f 1 "$results" | sort)
	if [ "$ran" != "$(basename -s .c "${programs[@]}" | sort)" ]; then
		fail "$toolchain" 'not all programs have run'
	fi
}
