#!/usr/bin/env bash
# How two workers compare with one on a study of ten seconds or more: the least of five runs each.
#
#     tools/workers.sh [PROGRAM]
set -eu
program=${1:-build/ricochet}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
sed 's/^  impacts:.*/  impacts: 14/; s/^  multiply:.*/  multiply: 4/' examples/elementary/study.yaml >"$folder/study.yaml"

least() # WORKERS
{
    for _ in 1 2 3 4 5; do
        rm -f "$folder/atlas.ricochet"
        local begin=$EPOCHREALTIME
        "$program" run "$folder/study.yaml" -j "$1" -o "$folder/atlas.ricochet" 2>/dev/null
        echo "$begin $EPOCHREALTIME"
    done | awk '{t = $2 - $1; if (NR == 1 || t < least) least = t} END {printf "%.2f", least}'
}

one=$(least 1)
two=$(least 2)
awk -v a="$one" -v b="$two" 'BEGIN {printf "one worker %s s, two workers %s s: %.3f of the time\n", a, b, b / a; exit !(b <= 0.55 * a)}'
