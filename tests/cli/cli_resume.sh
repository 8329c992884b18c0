#!/usr/bin/env bash
# A run that is stopped, killed or repeated ends with the atlas of an undisturbed run; a larger budget extends it to that of a fresh run.
set -u
. tests/support/tap.sh

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

study 1000 0 >"$folder/study.yaml"
study 200 2 >"$folder/small.yaml"
ok "an undisturbed run" "$ricochet" run "$folder/study.yaml" -o "$folder/whole.ricochet"
tables "$folder/whole.ricochet" >"$folder/whole.txt"
ok "it has more than twenty branches" test "$("$ricochet" branches "$folder/whole.ricochet" --csv | tail -n +2 | wc -l)" -gt 20

ok "the same command again changes nothing" "$ricochet" run "$folder/study.yaml" -o "$folder/whole.ricochet"
tables "$folder/whole.ricochet" >"$folder/again.txt"
ok "bit for bit" same "$folder/whole.txt" "$folder/again.txt"

attempts=$(some_of '0 3' '0 1 2 3 4 5 6')
for signal in KILL TERM INT; do
    rm -f "$folder/broken.ricochet"*
    stops=0
    # The first one comes as soon as there is a file: the rest of the run is the longer part of it, on any machine.
    for attempt in $attempts; do
        "$ricochet" run "$folder/study.yaml" -o "$folder/broken.ricochet" 2>/dev/null &
        break_off $signal $! "$folder/broken.ricochet" $((attempt * $(bytes "$folder/whole.ricochet") / 8 + 1)) && stops=$((stops + 1))
    done
    ok "SIG$signal stops it on its way" test $stops -ge 1
    ok "after $(wc -w <<<"$attempts") times SIG$signal the run ends" "$ricochet" run "$folder/study.yaml" -o "$folder/broken.ricochet"
    tables "$folder/broken.ricochet" >"$folder/broken.txt"
    ok "and its atlas equals the undisturbed one" same "$folder/whole.txt" "$folder/broken.txt"
done

ok "a small budget" "$ricochet" run "$folder/small.yaml" -o "$folder/small.ricochet"
ok "a larger one extends its atlas" "$ricochet" run "$folder/study.yaml" -o "$folder/small.ricochet"
tables "$folder/small.ricochet" >"$folder/small.txt"
# A label that was shown before the atlas grew stays, and so a fresh run numbers junctions otherwise.
for name in whole small; do
    cp "$folder/$name.ricochet" "$folder/unlabelled.ricochet"
    python3 -S -c 'import sqlite3, sys; a = sqlite3.connect(sys.argv[1]); a.execute("UPDATE junction SET label = 1"); a.commit()' \
        "$folder/unlabelled.ricochet"
    tables "$folder/unlabelled.ricochet" >"$folder/$name-unlabelled.txt"
done
ok "to that of a fresh run" same "$folder/whole-unlabelled.txt" "$folder/small-unlabelled.txt"

sed 's/9, -1/9.5, -1/' "$folder/study.yaml" >"$folder/other.yaml"
other() { "$ricochet" run "$folder/other.yaml" -o "$folder/small.ricochet"; test $? -eq 1; }
ok "another model is refused with exit code 1" other
tables "$folder/small.ricochet" >"$folder/after.txt"
ok "and the atlas is untouched" same "$folder/small.txt" "$folder/after.txt"
finish
