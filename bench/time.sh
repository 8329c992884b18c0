#!/usr/bin/env bash
# What is promised about time, on a machine that does nothing else meanwhile: the elementary structure up to energy 1000 and 24 impacts is complete in
# a second, Python has all arrays of a million points in half a second and their multipliers in another, and two workers take at most 0.55 of the time of one. The latter is skipped, with a
# word, where the machine has no second core to itself.
# It measures the machine as much as the program, so that it is no test of the suite: `make time`.
set -u
. tests/support/tap.sh

sed 's/^  energy:.*/  energy: [0, 1000]/; s/^  impacts:.*/  impacts: 24/; s/^  multiply:.*/  multiply: 1/; s/^  depth:.*/  depth: 0/' \
    examples/elementary/study.yaml >"$folder/study.yaml"

complete() {
    local TIMEFORMAT='%U' taken
    taken=$({ time "$ricochet" run "$folder/study.yaml" -o "$folder/atlas.ricochet" >"$folder/said" 2>&1; } 2>&1) || return 1
    cat "$folder/said"
    echo "processor time: $taken s"
    grep -q '^departures taken: ' "$folder/said" && ! grep -q 'refused\|failed\|no junctions' "$folder/said" && awk -v t="$taken" 'BEGIN {exit !(t < 1)}'
}
if sanitized; then
    ok "the elementary structure is complete" "$ricochet" run "$folder/study.yaml" -o "$folder/atlas.ricochet"
    left_out "in a second, and two workers in 0.55 of the time" "with sanitizers times mean nothing"
    finish
    exit
fi
ok "the elementary structure is complete in a second" complete

took() # COMMAND...: seconds of processor time, or nothing if it fails
{
    local TIMEFORMAT=%U
    { time "$@" >"$folder/log" 2>&1; } 2>&1 || echo failed
}
sed 's/^  impacts:.*/  impacts: 10/; s/^  multiply:.*/  multiply: 4/' examples/elementary/study.yaml >"$folder/long.yaml"
first=$(took "$ricochet" run "$folder/long.yaml" -o "$folder/twice.ricochet")
second=$(took "$ricochet" run "$folder/long.yaml" -o "$folder/twice.ricochet")
ok "a second run over a finished atlas costs less: $second s after $first s" awk -v a="$first" -v b="$second" 'BEGIN {exit !(b > 0 && b < a)}'

# All arrays of a million points in Python, without what opening the file takes.
columns() {
    tools/python - "$folder/million.ricochet" <<'END'
import sys, time
import ricochet
names = ("arclength", "energy", "frequency", "period", "trace", "log_trace", "rotation", "stable", "undecided", "reach", "approach", "residual",
         "state", "flights", "multipliers")
for attempt in range(3):  # others may be using the machine
    atlas = ricochet.Atlas(sys.argv[1])
    assert sum(map(len, atlas.branches)) >= 1e6
    taken, numbers = {}, 0
    for name in names:
        begin = time.process_time()
        numbers += sum(getattr(branch, name).size for branch in atlas.branches)
        taken[name] = time.process_time() - begin
        print(f"{name} {taken[name]:.3f} s", end=", ")
    rest = sum(taken[name] for name in names if name != "multipliers")
    print(f"{numbers} numbers: {rest:.2f} s, and multipliers")
    if rest <= 0.5 and taken["multipliers"] <= 0.5:
        sys.exit()
sys.exit(1)
END
}
if tools/python -c '' 2>/dev/null; then
    ok "an atlas of a million points" "$ricochet" run examples/elementary/study.yaml --max-step 0.0000155 -j 2 -o "$folder/million.ricochet"
    export RICOCHET_LIBRARY=$(dirname "$ricochet")/src/libricochet.so
    ok "all arrays of a million points within 0.5 s, and their multipliers, which are computed, within another 0.5 s" columns
    sed 's/^/# /' "$folder/log"
else
    left_out "arrays of a million points" "no Python with NumPy and cffi"
fi

if [ "$(nproc)" -lt 2 ]; then
    left_out "two workers" "one core"
    finish
    exit
fi
sed 's/^  impacts:.*/  impacts: 14/; s/^  multiply:.*/  multiply: 4/; s/^  depth:.*/  depth: 0/' examples/elementary/study.yaml >"$folder/wide.yaml"
alone() # less than 0.07 of the processor time
{
    tools/alone "$ricochet" run "$folder/wide.yaml" -j 2 -o "$folder/wide.ricochet" >"$folder/alone" || return 1
    cat "$folder/alone"
    awk -F'[(%]' '{exit !($2 < 7)}' "$folder/alone"
}
ok "of a run with two workers one thread does little alone" alone
tools/workers.sh "$ricochet" elementary >"$folder/speed"
code=$?
sed 's/^/# /' "$folder/speed"
case $code in
0) ok "two workers" true ;;
77) left_out "two workers" "the machine is busy: $(tail -1 "$folder/speed")" ;;
*)
    number=$((number + 1))
    echo "not ok $number - two workers: $(head -1 "$folder/speed")"
    failed=$((failed + 1))
    ;;
esac
finish
