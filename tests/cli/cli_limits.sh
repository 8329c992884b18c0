#!/usr/bin/env bash
# Runs with a limit: they stop in time whatever they are doing, say what is left, and the next one goes on from there.
set -u
. tests/support/tap.sh

# A chain of eight masses under a law of power 99: a single branch of it takes minutes.
python3 -S - >"$folder/slow.yaml" <<'P'
n = 8
row = lambda f: "[" + ", ".join(map(str, f)) + "]"
print("title: A chain\nmodel:")
print("  mass:", row(row(int(i == j) for j in range(n)) for i in range(n)))
print("  stiffness:", row(row(2 + 0.1 * i if i == j else -int(abs(i - j) == 1) for j in range(n)) for i in range(n)))
print("  contacts:")
for i in range(0, n, 2):
    print(f"    - {{normal: {row(int(j == i) for j in range(n))}, law: power, exponent: 99, length: 1, reference: {1 + 0.1 * i}}}")
print("explore: {start: [1], energy: [0.01, 20], frequency: [0.3, 10], multiply: 2, depth: 2}")
P
cat >"$folder/many.yaml" <<'Y'
title: Two masses
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], clearance: 1, law: rigid}
explore: {energy: [0, 200], frequency: [0.2, 10], impacts: 18, multiply: 4, depth: 2}
Y

# stops CODE PATTERN SECONDS COMMAND...: ends with that code and message, and with less work than that: the processor's seconds are the same on a busy
# machine
stops() {
    local code=$1 pattern=$2 limit=$3 got=0 LC_ALL=C TIMEFORMAT=%U
    shift 3
    { time "$@" >"$folder/out" 2>&1; } 2>"$folder/time" || got=$?
    cat "$folder/out"
    echo "exit $got after $(cat "$folder/time") s of work"
    sanitized && limit=$((20 * limit))
    [ "$got" = "$code" ] && grep -q -e "$pattern" "$folder/out" && awk -v limit=$limit 'NF { read = 1; if ($1 + 0 >= limit) exit 1 } END { if (!read) exit 1 }' "$folder/time"
}
points() { # of what is kept: bytes, more with every step
    python3 -S - "$folder/slow.ricochet" <<'P'
import sqlite3, sys
rows = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True).execute("SELECT length(blob) FROM trace").fetchall()
print(sum(n for n, in rows))
P
}
run_slow() { "$ricochet" run "$folder/slow.yaml" -o "$folder/slow.ricochet" --seconds 1; }

ok 'a run that is in the midst of one branch stops in time' stops 3 'the 1 s given are over' 10 run_slow
ok 'it says what is left and how to go on' grep -q 'departures* of depth 0 [a-z]* left' "$folder/out"
ok 'and that the branch under way is kept' grep -q '[1-9][0-9]* steps* of this run [a-z]* kept' "$folder/out"
before=$(points)
run_slow 2>/dev/null
further() { echo "$before, then $(points)"; [ "$before" -gt 0 ] && [ "$(points)" -gt "$before" ]; }
ok 'the next one is further along the branch' further
# works PID: half a second of the processor's, after which it is in the midst of its branch
works() { while [ "$(sed 's/.*) //' "/proc/$1/stat" 2>/dev/null | awk '{ print ($12 + $13 >= 0.5 * hertz) }' hertz="$(getconf CLK_TCK)")" = 0 ]; do sleep 0.05; done; }
interrupted() {
    "$ricochet" run "$folder/slow.yaml" -o "$folder/slow.ricochet" &
    listens $!
    works $!
    kill -INT $!
    wait $!
}
before=$(points)
"$ricochet" run "$folder/slow.yaml" -o "$folder/slow.ricochet" --seconds 1 -j 2 2>/dev/null
ok 'so is one with workers' further
ok 'Ctrl-C ends it at once, with another exit code' stops 130 'continues there' 10 interrupted

ok 'a run with many branches stops in time' stops 3 'labels* [a-z]* not measured yet' 10 "$ricochet" run "$folder/many.yaml" -o "$folder/many.ricochet" --seconds 1
shown() {
    "$ricochet" report "$folder/many.ricochet" | grep 'not measured yet' || return 1
    "$ricochet" junctions "$folder/many.ricochet" --json | python3 -S -c '
import json, sys
rows = [j for j in json.load(sys.stdin) if "??" in j["label"]]
assert rows and all(j["a"] is None and j["b"] is None and j["decided"] is None for j in rows)'
}
ok 'junctions without a label are shown as such' shown
# Between two samples of a step lies a point at which no orbit was found: it was asked for again, for ever.
cat >"$folder/samples.yaml" <<'YAML'
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], length: 1, exponent: 7, law: power}
explore: {energy: [0, 200], frequency: [0.11, 11]}
YAML
ends_in_time() { timeout -s KILL 600 "$ricochet" run "$folder/samples.yaml" -o "$folder/samples.ricochet" --seconds 15; [ $? -le 3 ]; }
ok "a point that cannot be inserted between others keeps no run from its end" ends_in_time

finish
