#!/usr/bin/env bash
# A hundred kills at random moments of one run, by turns of a run with two threads and of one with three ranks, then completion: the atlas equals that of
# an undisturbed run bit for bit. The long form of tests/cli/cli_resume.sh, cli_workers.sh and cli_mpi.sh.
#
#     tools/kills.sh [BUILD [KILLS]]
set -u
build=$(realpath "${1:-build}")
kills=${2:-100}
program=$build/ricochet mpi=$build/ricochet-mpi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
sed 's/^  impacts:.*/  impacts: 14/; s/^  multiply:.*/  multiply: 4/; s/^  depth:.*/  depth: 0/' examples/elementary/study.yaml >"$folder/study.yaml"
root=
[ "$(id -u)" -ne 0 ] || root=--allow-run-as-root

rows() # ATLAS: everything but the cache of traces
{
    python3 - "$1" <<'PYTHON'
import sqlite3, sys
atlas = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
for table in ("branch", "branch_junction", "point", "junction", "junction_branch"):
    for row in atlas.execute(f"SELECT * FROM {table} ORDER BY 1, 2"):
        print(table, *row)
PYTHON
}

start() # in the background, a group of processes of its own
{
    if [ "$1" = threads ] || [ ! -x "$mpi" ]; then
        setsid "$program" run "$folder/study.yaml" -j 2 -o "$folder/broken.ricochet" >/dev/null 2>&1 &
    else
        setsid mpirun $root --oversubscribe -n 3 "$mpi" run "$folder/study.yaml" -o "$folder/broken.ricochet" >/dev/null 2>&1 &
    fi
}

"$program" run "$folder/study.yaml" -o "$folder/whole.ricochet" 2>/dev/null || exit 1
rows "$folder/whole.ricochet" >"$folder/whole.txt"

done=0 ended=0 unread=0 kind=threads
while [ "$done" -lt "$kills" ]; do
    start $kind
    pid=$!
    sleep "$((RANDOM % 3)).$((RANDOM % 10))$((RANDOM % 10))"
    if kill -KILL -- -$pid 2>/dev/null; then
        pkill -KILL -f "$folder/study.yaml" 2>/dev/null # ranks that have left the group
        done=$((done + 1))
    else
        ended=$((ended + 1))
    fi
    { wait $pid; } 2>/dev/null
    [ ! -e "$folder/broken.ricochet" ] || "$program" report "$folder/broken.ricochet" >"$folder/said" 2>&1 || { unread=$((unread + 1)); cat "$folder/said"; }
    if [ $((done % 20)) = 0 ]; then # once in a while from nothing, for it has come to its end by then
        "$program" run "$folder/study.yaml" -j 2 -o "$folder/broken.ricochet" 2>/dev/null
        rows "$folder/broken.ricochet" | cmp - "$folder/whole.txt" || exit 1
        echo "$done kills: completed, equal to the undisturbed atlas"
        rm -f "$folder/broken.ricochet"
    fi
    if [ $kind = threads ]; then kind=ranks; else kind=threads; fi
done
echo "$done kills, $ended runs that had ended before, $unread atlases that could not be read between"
[ "$unread" = 0 ]
