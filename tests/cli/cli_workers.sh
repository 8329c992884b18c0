#!/usr/bin/env bash
# The atlas is the same, row for row, for any number of workers; and a run with workers that is killed goes on.
set -u
. tests/support/tap.sh

study() # IMPACTS MULTIPLY DEPTH
{
    sed "s/^  impacts:.*/  impacts: $1/; s/^  multiply:.*/  multiply: $2/; s/^  depth:.*/  depth: $3/" examples/elementary/study.yaml
}

rows() # ATLAS: all tables but the cache of traces
{
    "$ricochet" branches "$1" --json && "$ricochet" junctions "$1" --json
    for id in 1 2 3 5 8 13 21 34 55 89; do "$ricochet" points "$1" --branch $id --csv 2>/dev/null; done
}

study 8 4 3 >"$folder/two.yaml"
for case in "$folder/two.yaml" examples/three-masses/study.yaml examples/two-walls/study.yaml examples/cascade/study.yaml examples/bilinear/study.yaml examples/two-springs/study.yaml; do
    # the short form takes the examples with one and with five
    few=$([ "$case" = "$folder/two.yaml" ] && echo '1 2 5' || some_of '1 5' '1 2 5')
    for workers in $few; do
        rm -f "$folder/a.ricochet"
        ok "$(basename "$(dirname "$case")")/$(basename "$case") with $workers" "$ricochet" run "$case" -j $workers -o "$folder/a.ricochet"
        rows "$folder/a.ricochet" >"$folder/$workers.txt"
    done
    [ "$few" = '1 5' ] || ok "2 workers, the same rows" same "$folder/1.txt" "$folder/2.txt"
    ok "5 workers, the same rows" same "$folder/1.txt" "$folder/5.txt"
    ok "there are rows" test "$(grep -c '"word"' "$folder/1.txt")" -gt 5
done

# A stop with two sides and a spring with one: the grazings of both sides have energy, period and letters in common, and
# are no images of each other in the structure.
cat >"$folder/sides.yaml" <<'END'
model:
  mass: [[1.5, 0], [0, 2.0625]]
  stiffness: [[1250000, 937500], [937500, 953125]]
  contacts:
    - {normal: [1, 2], law: bilinear, clearance: 1.22, sides: upper, stiffness: 146500}
    - {normal: [-1, 1], law: rigid, clearance: 1.45, sides: both}
explore: {start: modes, energy: [0, 60000], frequency: [57.74, 3303], impacts: 2, multiply: 2, depth: 2}
END
for workers in 1 2; do
    ok "grazings of two sides with $workers" "$ricochet" run "$folder/sides.yaml" -j $workers -o "$folder/sides$workers.ricochet"
    rows "$folder/sides$workers.ricochet" >"$folder/sides$workers.txt"
done
ok "no trace is taken for that of the other side" same "$folder/sides1.txt" "$folder/sides2.txt"
ok "no branch is lost between them" sh -c "! grep -q failed '$folder/sides1.txt'"

study $(some_of "8 4 4" "10 4 4") >"$folder/long.yaml"
ok "an undisturbed run" "$ricochet" run "$folder/long.yaml" -j 3 -o "$folder/whole.ricochet"
rows "$folder/whole.ricochet" >"$folder/whole.txt"
kills=0
attempts=$(some_of '0 3' '0 1 2 3 4')
for attempt in $attempts; do
    "$ricochet" run "$folder/long.yaml" -j 3 -o "$folder/broken.ricochet" 2>/dev/null &
    break_off KILL $! "$folder/broken.ricochet" $((attempt * $(bytes "$folder/whole.ricochet") / 6 + 1)) && kills=$((kills + 1))
done
ok "it is killed on its way" test $kills -ge 1
ok "$(wc -w <<<"$attempts") kills later it comes to its end" "$ricochet" run "$folder/long.yaml" -j 2 -o "$folder/broken.ricochet"
rows "$folder/broken.ricochet" >"$folder/broken.txt"
ok "bit for bit" same "$folder/whole.txt" "$folder/broken.txt"

# What was traced is read back, not traced again: what is traced is stored under a new number of its row, even where the row was there before.
stored() { python3 -S -c 'import sqlite3, sys; [print(*row) for row in sqlite3.connect(sys.argv[1]).execute("SELECT rowid, key FROM trace ORDER BY rowid")]' "$1"; }
ok "a first run" "$ricochet" run "$folder/long.yaml" -j 2 -o "$folder/twice.ricochet"
stored "$folder/twice.ricochet" >"$folder/stored"
ok "stores what it traces" test "$(wc -l <"$folder/stored")" -gt 100
ok "a second run" "$ricochet" run "$folder/long.yaml" -j 2 -o "$folder/twice.ricochet"
stored "$folder/twice.ricochet" >"$folder/stored-again"
ok "traces nothing again" diff -q "$folder/stored" "$folder/stored-again"
rows "$folder/twice.ricochet" >"$folder/twice.txt"
ok "the same rows" same "$folder/whole.txt" "$folder/twice.txt"

ok "in one word, as make has it" sh -c "'$ricochet' run '$folder/two.yaml' -j99999 2>&1 | grep -q -- \"-j '99999' is not a whole number\""
ok "a number of workers below none is refused" sh -c "'$ricochet' run '$folder/two.yaml' -j -1 2>&1 | grep -q -- '-j'"
finish
