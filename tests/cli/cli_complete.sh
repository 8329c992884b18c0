#!/usr/bin/env bash
# A census from the command line: what is there, that it says when it is not complete, and what it refuses.
set -u
. tests/support/tap.sh

study=examples/elementary/study.yaml
said=$("$ricochet" prove --complete "$study" --energy 5 --impacts 1 2>&1)
if grep -q 'left out of this program' <<<"$said"; then
    echo '1..0 # SKIP the program was built without FLINT'
    exit 77
fi

# census ARGUMENT...: rows to $folder/rows, the rest to $folder/said
census() { "$ricochet" prove --complete "$@" --json >"$folder/rows" 2>"$folder/said"; }

agrees() {
    census "$study" --energy 1.5 --impacts 2 --period 20 -j 2 || return 1
    "$ricochet" hunt "$study" --energy 1.5 --impacts 2 --period 20 --json >"$folder/hunt" 2>/dev/null || return 1
    python3 -S - "$folder/rows" "$folder/hunt" <<'END'
import json, sys
census, hunt = (json.load(open(name)) for name in sys.argv[1:])
assert len(census) == len(hunt) == 7
for row, other in zip(sorted(census, key=lambda r: r["period"]), sorted(hunt, key=lambda r: r["period"])):
    low, high = row["period_within"]
    assert low - 1e-11 < other["period"] < high + 1e-11 and high - low < 1e-10
    low, high = row["trace_within"]
    assert low - 1e-7 < other["trace"] < high + 1e-7
    assert row["symmetric"] == other["symmetric"] and row["reversible"] == other["reversible"]
    assert row["stable"] == ("yes" if abs(row["trace"]) < 2 else "no")
END
}

# An orbit of the census, flown by the simulator for its period, comes back.
replays() {
    census "$study" --energy 5 --impacts 2 && grep -q '^complete: 3 orbits .* of any period' "$folder/said" || return 1
    python3 -S - "$folder/rows" "$ricochet" "$study" <<'END'
import json, subprocess, sys
for row in json.load(open(sys.argv[1])):
    call = [sys.argv[2], "simulate", sys.argv[3], "--state", *map(repr, row["state"]), "--time", repr(row["period"]), "--steps", "1", "--json"]
    last = json.loads(subprocess.run(call, capture_output=True, text=True, check=True).stdout)[-1]
    end = [last[name] for name in ("x1", "x2", "v1", "v2")]
    # at an impact: before it or behind it, which differ by the turn of the speed of the gap
    gap = lambda z: (z[1] - z[0], z[3] - z[2])
    assert max(abs(a - b) for a, b in zip(end[:2], row["state"][:2])) < 1e-8, (end, row["state"])
    assert abs(abs(gap(end)[1]) - abs(gap(row["state"])[1])) < 1e-8
END
}

stops() {
    census "$study" --energy 5 --impacts 5 --seconds 0.2
    [ $? = 3 ] && grep -q '^not complete: ' "$folder/said" && grep -q 'are undecided, .* of all flight times' "$folder/said"
}

# refuses TEXT ARGUMENT...: exit code 2 and the text
refuses() {
    census "${@:2}"
    [ $? = 2 ] && grep -q -- "$1" "$folder/said"
}

ok 'the orbits of a census are those of the hunt, with intervals that hold their numbers' agrees
ok 'above the touch of both modes a census is of all periods' replays
ok 'a census that is stopped says what is undecided' stops
# Work is counted: 15,600 boxes, and 208,000 where only flight times are divided.
fewer() {
    census "$study" --energy 5 --impacts 3 -j 2 && grep -q '^complete: 6 orbits .* of any period' "$folder/said" &&
        [ "$(grep -o '^[0-9]* boxes' "$folder/said" | cut -d' ' -f1)" -lt 25000 ]
}
ok 'motions are followed from impact to impact while it is known where they are' fewer
# 77,000 boxes; the hunt that follows knows the same ten.
four() {
    census "$study" --energy 5 --impacts 4 -j 2 && grep -q '^complete: 10 orbits .* of any period' "$folder/said" &&
        grep -q '^a hunt finds 10 orbits there, of which 0 are missing' "$folder/said" &&
        [ "$(grep -o '^[0-9]* boxes' "$folder/said" | cut -d' ' -f1)" -lt 120000 ]
}
ok 'four impacts are complete' four
# Where every linear motion comes back, those that touch a stop lie on a curve: some thousand boxes instead of millions.
returns() { # RATIO STIFFNESS NORMALS ENERGY PERIOD IMPACTS BOXES
    printf 'model:\n  mass: [[1, 0], [0, 1]]\n  stiffness: %s\n  contacts:\n' "$2" >"$folder/two.yaml"
    printf '    - {normal: %s, clearance: 1}\n' $3 >>"$folder/two.yaml"
    census "$folder/two.yaml" --energy "$4" --impacts "$6" --period "$5" --seconds 200
    [ $? = 1 ] && grep -q '^not complete: ' "$folder/said" && grep -q "^the modes turn $1 times " "$folder/said" &&
        [ "$(grep -o '^[0-9]* boxes of' "$folder/said" | cut -d' ' -f1)" -lt "$7" ]
}
ok 'two modes of one frequency end, and it is told why' returns '1 : 1' '[[2, 0], [0, 2]]' '[1,0] [0.6,0.6]' 5 9 1 20000
ok 'so do modes of 1 and 2 rad/s' returns '1 : 2' '[[2.5, -1.5], [-1.5, 2.5]]' '[1,0]' 3 50 1 20000
# Two impacts on one face at once are none, whatever the motion: a surface, which boxes of 1e-4 tile without an end.
! long_form || ok 'two impacts end there, too' returns '1 : 1' '[[2, 0], [0, 2]]' '[1,0] [0.6,0.6]' 5 9 2 300000
ok 'no energy is refused' refuses 'energy is missing' "$study"
ok 'springs are refused' refuses 'bilinear springs' examples/bilinear/study.yaml --energy 1
ok 'three modes are refused' refuses 'here they see 3' examples/three-masses/study.yaml --energy 1
ok 'words that are too long are refused' refuses 'impacts' "$study" --energy 1 --impacts 7
ok 'an energy that is none is refused' refuses 'not positive' "$study" --energy=-1
finish
