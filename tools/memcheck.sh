#!/usr/bin/env bash
# The test programs under valgrind: errors of memory and leaks only. Valgrind computes long double in 64 bits, so that what the programs say of accuracy
# does not count here, and whether they pass is left to `make test`.
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
    begin=$SECONDS
    # freed by the tests of failing allocation and by the system at the end: what is still reachable is no leak
    timeout -s KILL "$seconds" valgrind --quiet --child-silent-after-fork=yes --error-exitcode=99 --leak-check=full --errors-for-leak-kinds=definite --show-leak-kinds=definite \
        --log-file="$folder/log" "$build/tests/test_$name" >/dev/null 2>&1
    code=$?
    found=$(grep -c '== .* at 0x' "$folder/log")
    case $code in
    99) said="finding" bad=1 ;;
    137) said="not finished" found=0 ;;
    *) said="clean" ;;
    esac
    [ "$found" = 0 ] || { said="finding" bad=1; head -40 "$folder/log"; }
    echo "$name: $said, $((SECONDS - begin)) s"
done
exit "$bad"
