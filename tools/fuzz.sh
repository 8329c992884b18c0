#!/usr/bin/env bash
# Runs the fuzzing harnesses one after the other and reports executions and findings.
#
#     tools/fuzz.sh [FOLDER [SECONDS [NAME...]]]
#
# FOLDER holds the harnesses (build-fuzz), each runs for SECONDS (60) from its corpus in fuzz/corpus; what it adds stays in FOLDER/corpus.
# A finding is left in FOLDER as crash-..., timeout-... or leak-...; exit status 1 if there is one.
set -u
folder=$(realpath "${1:-build-fuzz}")
seconds=${2:-60}
shift $(($# < 2 ? $# : 2))
corpus=$(realpath fuzz/corpus)
bad=0
# The folders of the harnesses lie in one of this run, so that another run keeps its own.
if [ -d /dev/shm ] && [ -w /dev/shm ]; then room=/dev/shm; else room=${TMPDIR:-/tmp}; fi
FUZZ_ROOM=$(mktemp -d "$room/ricochet-fuzz-run-XXXXXX") || exit 1
export FUZZ_ROOM
trap 'rm -rf "$FUZZ_ROOM"' EXIT
for name in "${@:-study matrix atlas rows command}"; do
    for harness in $name; do
        mkdir -p "$folder/corpus/$harness"
        log=$folder/$harness.log
        UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 "$folder/fuzz/fuzz-$harness" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=3000 \
            -max_len=4096 -close_fd_mask=3 -print_final_stats=1 -artifact_prefix="$folder/" "$folder/corpus/$harness" "$corpus/$harness" >"$log" 2>&1 || bad=1
        printf '%-8s %s executions%s\n' "$harness" "$(sed -n 's/^stat::number_of_executed_units: *//p' "$log")" \
            "$(sed -n 's/.*Test unit written to/, finding/p' "$log" | tr '\n' ' ')"
    done
done
exit "$bad"
