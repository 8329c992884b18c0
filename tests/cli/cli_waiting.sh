#!/usr/bin/env bash
# What a run says while one waits for it, in a log, and when it is stopped: how far it is, what it has, how to go on, and that cores are idle.
set -u
. tests/support/tap.sh

python3 -S - >"$folder/long.yaml" <<'P'
n = 60
row = lambda f: "[" + ", ".join(map(str, f)) + "]"
print("model:\n  mass:", row(row(int(i == j) for j in range(n)) for i in range(n)))
print("  stiffness:", row(row(2 * (i == j) - (abs(i - j) == 1) for j in range(n)) for i in range(n)))
print("  contacts:\n    - {normal:", row(int(i == n // 2) for i in range(n)) + ", clearance: 1}")
print("explore: {points: 0, step: 0.0005}") # minutes on any machine: a first look may take less than the four seconds
P
# Once it has begun a run stands still while the clock goes on, which is what it asks: computing all that time shows no more.
stands_still() # PID
{
    listens "$1"
    sleep 0.3
    kill -STOP "$1"
    sleep 4
    kill -CONT "$1"
}
stops() { # CODE OPTION...: a run that is stopped by its time, or by Ctrl-C
    local code=$1
    shift
    rm -f "$folder/long.ricochet"
    "$ricochet" run "$folder/long.yaml" --seconds 4 "$@" >"$folder/out" 2>"$folder/said" &
    stands_still $!
    wait $!
    [ $? = "$code" ]
}
in_said() { cat "$folder/said"; grep -q -e "$1" "$folder/said"; }
not_said() { ! in_said "$1"; }
in_out() { cat "$folder/out"; grep -q -e "$1" "$folder/out"; }
several_cores() { [ "$(getconf _NPROCESSORS_ONLN)" -gt 1 ]; }

ok 'a run stopped by its time' stops 3
ok 'its log says how far it is' in_said '^ricochet: [0-9]* branch[es]*, [0-9]* junctions*, depth [0-9]* of 3: [0-9]* of [0-9]* departures* ([0-9]* %), [0-9]* steps*/s, 1 at a time, [1-9][0-9]* s$'
ok 'a line now and then' test "$(grep -c 'steps/s' "$folder/said")" -le 4
ok 'the report of what there is' in_out '^branches: '
ok 'and no reasons for what is not there yet' test -z "$(grep 'no orbit that meets' "$folder/out")"
ok 'it says how to go on' in_said 'the same command continues there: ricochet run '
if several_cores; then ok 'cores that are idle' in_said 'one of [0-9]* cores was used; `run -j 0` takes all of them'
else left_out 'cores that are idle' 'there is one core'
fi
ok 'nothing of cores where one was asked for' stops 3 -j 1
ok 'nor said' not_said 'cores was used'
ok 'quiet' stops 3 --quiet
ok 'no progress' not_said 'steps/s\|cores'
ok 'nor report' test ! -s "$folder/out"

interrupted() {
    rm -f "$folder/long.ricochet"
    "$ricochet" run "$folder/long.yaml" >"$folder/out" 2>"$folder/said" &
    local pid=$!
    stands_still $pid
    for _ in $(seq 2400); do grep -q 'steps/s' "$folder/said" && break; sleep 0.1; done
    kill -INT $pid
    wait $pid
    [ $? = 130 ]
}
set -m # else the shell lets its children ignore Ctrl-C
ok 'Ctrl-C' interrupted
set +m
ok 'the report after it' in_out '^branches: '
ok 'and how to go on' in_said 'the same command continues there'
again() { # the command that goes on is the one that was given, as a shell reads it
    "$ricochet" run examples/elementary/study.yaml -o "$folder/it's long.ricochet" -j 1 --max-step 0.001 --seconds 1e-9 >/dev/null 2>"$folder/said"
    [ $? = 3 ] && grep -q "^ricochet: the same command continues there: ricochet run examples/elementary/study.yaml -o '.*/it'.''s long.ricochet' -j 1 --max-step 0.001$" "$folder/said"
}
ok 'with its options and its file' again
finish
