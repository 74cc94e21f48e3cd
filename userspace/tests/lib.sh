# shellcheck shell=bash
# SPDX-License-Identifier: GPL-2.0-only
#
# Functions of all level scripts; to be sourced, by a path relative to the script:
#	. "$(cd "$(dirname "$0")" && pwd)/lib.sh"
#
#	$top, $cache	see paths.sh
#	$out		results and logs of this level (set by `level`)
#	level NAME	start a level
#	need LEVEL...	install the packages that these levels require
#	pass NAME	one test passed
#	fail NAME WHY	one test failed
#	attempt NAME COMMAND...	pass or fail by COMMAND's status; its output goes to $out/NAME.log
#	take NAME LEAST COMMAND...	run COMMAND, whose last line is "WORD: P passed, F failed"; show
#			its output, add up its counts, and fail if there were fewer than LEAST
#	least PART	the minimum number of cases of a part of this level, see the file minimum
#	minima LEVEL	lines "PART CASES" of a level
#	tally P F	add a sub-run's counts
#	boots DIR	end the level if the test kernel whose run is in DIR did not boot: it has
#			failed already, and would fail again in each further run
#	finish		print "LEVEL: P passed, F failed" as the last line; exit 1 unless all passed

# shellcheck source=paths.sh
. "$(dirname "${BASH_SOURCE[0]}")/../paths.sh"

level() {
	level_name=$1
	level_passed=0
	level_failed=0
	out=$top/build/$1
	mkdir -p "$out"
}

need() {
	"$top/userspace/setup" "$@"
}

pass() {
	level_passed=$((level_passed + 1))
	echo "ok $1"
}

fail() {
	level_failed=$((level_failed + 1))
	echo "not ok $1: ${2:-failed}"
}

attempt() {
	local name=$1 log
	shift
	log=$out/${name//[^A-Za-z0-9._-]/_}.log
	if "$@" > "$log" 2>&1 < /dev/null; then
		pass "$name"
		return 0
	fi
	tail -n 40 "$log" | sed 's/^/    /'
	fail "$name" "see ${log#"$top"/}"
	return 1
}

take() {
	local name=$1 least=$2 output count='^[a-z0-9_-]+: ([0-9]+) passed, ([0-9]+) failed$'
	shift 2
	output=$("$@" 2>&1 < /dev/null)
	if [[ ! ${output##*$'\n'} =~ $count ]]; then
		echo "$output"
		fail "$name" 'it ended without a count'
		return 1
	fi
	[ "$output" = "${BASH_REMATCH[0]}" ] || echo "${output%$'\n'*}"
	tally "${BASH_REMATCH[1]}" "${BASH_REMATCH[2]}"
	if [ $((BASH_REMATCH[1] + BASH_REMATCH[2])) -lt "$least" ]; then
		fail "$name" "fewer than $least tests"
		return 1
	fi
	[ "${BASH_REMATCH[2]}" -eq 0 ]
}

minima() {
	awk -v level="$1" '$1 == level { print $2, $3 }' "$top/userspace/tests/minimum"
}

least() {	# a part without a line fails
	minima "$level_name" | awk -v part="$1" '$1 == part { n = $2 } END { print n ? n : 999999 }'
}

tally() {
	case ${1-}/${2-} in
	/*|*/|*[!0-9/]*)
		fail "$level_name" "these are no counts: ${1-} ${2-}"
		return ;;
	esac
	level_passed=$((level_passed + $1))
	level_failed=$((level_failed + $2))
}

boots() {
	! grep -qs '^no boot' "$1/end" || finish
}

# A level that has run no tests fails, too.
finish() {
	[ $((level_passed + level_failed)) -gt 0 ] || fail "$level_name" 'no test ran'
	echo "$level_name: $level_passed passed, $level_failed failed"
	[ "$level_failed" -eq 0 ] && [ "$level_passed" -gt 0 ] || exit 1
	exit 0
}
