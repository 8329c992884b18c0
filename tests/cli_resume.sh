#!/usr/bin/env bash
# A run that is stopped, killed or repeated ends with the atlas of an undisturbed run; a larger budget extends it to that of a fresh run.
set -u
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
number=0 failed=0

check() # NAME COMMAND...: one TAP line
{
    local name=$1
    shift
    number=$((number + 1))
    if "$@" >"$work/out" 2>&1; then echo "ok $number - $name"; else
        echo "not ok $number - $name"
        sed 's/^/# /' "$work/out" | head -20
        failed=1
    fi
}

study() # ENERGY DEPTH
{
    cat <<YAML
title: Two masses
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], clearance: 1.0, law: rigid}
explore: {energy: [0, $1], frequency: [0.2, 10], impacts: 6, multiply: 2, depth: $2, step: 0.005}
YAML
}

dump() # ATLAS: every row of every listing, to compare bit for bit
{
    "$RICOCHET" branches "$1" --json && "$RICOCHET" junctions "$1" --json
    "$RICOCHET" branches "$1" --csv | tail -n +2 | cut -d, -f1 | while read -r id; do "$RICOCHET" points "$1" --branch "$id" --csv; done
}

same() { diff -q "$1" "$2"; }

study 1000 0 >"$work/study.yaml"
study 200 2 >"$work/small.yaml"
check "an undisturbed run" "$RICOCHET" run "$work/study.yaml" -o "$work/whole.ricochet"
dump "$work/whole.ricochet" >"$work/whole.txt"
check "it has more than twenty branches" test "$(grep -c '"word"' "$work/whole.txt")" -gt 20

check "the same command again changes nothing" "$RICOCHET" run "$work/study.yaml" -o "$work/whole.ricochet"
dump "$work/whole.ricochet" >"$work/again.txt"
check "bit for bit" same "$work/whole.txt" "$work/again.txt"

for signal in KILL TERM INT; do
    rm -f "$work/broken.ricochet"*
    for attempt in 1 2 3 4 5 6; do
        "$RICOCHET" run "$work/study.yaml" -o "$work/broken.ricochet" 2>/dev/null &
        pid=$!
        sleep 0.0$((attempt * 7 % 10))$((RANDOM % 10))
        kill -$signal $pid 2>/dev/null
        wait $pid 2>/dev/null
    done
    check "after six times SIG$signal the run ends" "$RICOCHET" run "$work/study.yaml" -o "$work/broken.ricochet"
    dump "$work/broken.ricochet" >"$work/broken.txt"
    check "and its atlas equals the undisturbed one" same "$work/whole.txt" "$work/broken.txt"
done

check "a small budget" "$RICOCHET" run "$work/small.yaml" -o "$work/small.ricochet"
check "a larger one extends its atlas" "$RICOCHET" run "$work/study.yaml" -o "$work/small.ricochet"
dump "$work/small.ricochet" >"$work/small.txt"
check "to that of a fresh run" same "$work/whole.txt" "$work/small.txt"

sed 's/9, -1/9.5, -1/' "$work/study.yaml" >"$work/other.yaml"
other() { "$RICOCHET" run "$work/other.yaml" -o "$work/small.ricochet"; test $? -eq 1; }
check "another model is refused with exit code 1" other
dump "$work/small.ricochet" >"$work/after.txt"
check "and the atlas is untouched" same "$work/small.txt" "$work/after.txt"
echo "1..$number"
exit $failed
