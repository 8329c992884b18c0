#!/usr/bin/env bash
# The test programs under valgrind: reads of memory that is not theirs or was never written. Valgrind computes long double in 64 bits, so that what the
# programs say of accuracy does not count here, and whether they pass is left to `make test`, as leaks are to `make sanitize`.
#
#     tools/memcheck.sh [BUILD [SECONDS [NAME...]]]
#
# NAME: programs of BUILD/tests without `test_`; all unless given. Each is stopped after SECONDS (600) and then counts as not finished. Exit status 1 if
# valgrind finds something.
set -u
build=${1:-build}
seconds=${2:-600}
shift $(($# < 2 ? $# : 2))
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bad=0
names=("$@")
if [ $# = 0 ]; then for path in "$build"/tests/test_*; do [ -f "$path" ] && [ -x "$path" ] && names+=("${path##*/test_}"); done; fi
for name in "${names[@]}"; do
    begin=$SECONDS said=
    timeout -s KILL "$seconds" valgrind --quiet --error-exitcode=99 --log-file="$folder/log" "$build/tests/test_$name" >/dev/null 2>&1
    case $? in
    99) said="finding" bad=1 && head -40 "$folder/log" ;;
    137) said="not finished" ;;
    *) said="clean" ;;
    esac
    echo "$name: $said, $((SECONDS - begin)) s"
done
exit "$bad"
