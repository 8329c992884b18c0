#!/usr/bin/env bash
# How two workers compare with one on studies of ten seconds: the least of five runs each.
#
#     tools/workers.sh [PROGRAM [NAME...]]
#
# NAME: three-masses (few, longer orbits), elementary (many short ones); both unless given. Exit status 1 if two workers take more than 0.55 of the time
# of one; 77 if they do and the machine cannot do better, because two runs with one worker each, side by side, disturb each other.
set -eu
program=${1:-build/ricochet}
shift $(($# < 1 ? $# : 1))
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

study() # NAME
{
    case $1 in
    elementary) set -- "$1" 14 4 0 ;;
    *) set -- "$1" 16 2 12 ;;
    esac
    sed "s/^  impacts:.*/  impacts: $2/; s/^  multiply:.*/  multiply: $3/; s/^  depth:.*/  depth: $4/" "examples/$1/study.yaml"
}

seconds() # NAME WORKERS FILE
{
    rm -f "$folder/$3"
    local begin=$EPOCHREALTIME
    "$program" run "$folder/$1.yaml" -j "$2" -o "$folder/$3" >/dev/null 2>&1
    awk -v a="$begin" -v b="$EPOCHREALTIME" 'BEGIN {printf "%.3f\n", b - a}'
}

least() { sort -n "$1" | head -1; }
within() { awk -v a="$1" -v b="$2" -v most="$3" 'BEGIN {exit !(b <= most * a)}'; } # B is at most MOST times A

code=0
for name in "${@:-three-masses elementary}"; do
    for name in $name; do
        study "$name" >"$folder/$name.yaml"
        rm -f "$folder/one" "$folder/two"
        for round in 1 2 3 4 5; do # fewer, where the aim is met before
            seconds "$name" 1 a >>"$folder/one"
            seconds "$name" 2 a >>"$folder/two"
            one=$(least "$folder/one")
            two=$(least "$folder/two")
            ! within "$one" "$two" 0.55 || break
        done
        ratio=$(awk -v a="$one" -v b="$two" 'BEGIN {printf "%.3f", b / a}')
        echo "$name: one worker $one s, two workers $two s: $ratio of the time, least of $round"
        within "$one" "$two" 0.55 && continue
        seconds "$name" 1 b >"$folder/beside" &
        seconds "$name" 1 a >"$folder/alone"
        wait
        both=$(sort -n "$folder/beside" "$folder/alone" | tail -1)
        echo "$name: two runs side by side take $both s each"
        if within "$one" "$both" 1.03; then code=1; elif [ "$code" = 0 ]; then code=77; fi
    done
done
exit "$code"
