#!/bin/bash
# Cascades from outside: what is printed, in the atlas and beyond it, pictures, and wrong calls.
set -u
. tests/support/tap.sh
exits() { # CODE PATTERN COMMAND...: the exit code, and what is said
    local code=$1 pattern=$2
    shift 2
    "$@" >"$folder/said" 2>&1
    local got=$?
    cat "$folder/said"
    echo "exit $got, $code wanted"
    [ "$got" = "$code" ] && grep -qE -e "$pattern" "$folder/said"
}

if ! command -v python3 >/dev/null; then
    echo '1..0 # SKIP python3 is not there to read JSON'
    exit 77
fi
atlas=$folder/cascade.ricochet elementary=$folder/elementary.ricochet
ok 'the example runs' "$ricochet" run examples/cascade/study.yaml -o "$atlas"
ok 'so do the two masses' "$ricochet" run examples/elementary/study.yaml -o "$elementary"
before=$(cksum <"$elementary")
id() { "$ricochet" branches "$1" --json | python3 -S -c 'import json, sys; print(next(b["id"] for b in json.load(sys.stdin) if b["label"] == sys.argv[1]))' "$2"; }
s2=$(id "$elementary" 'S2-[01]') a5=$(id "$elementary" 'A5[00101]') s6=$(id "$atlas" 'S6[010101]')

stored() { # the path of the article is in the atlas, with the numbers that are followed beyond it
    "$ricochet" cascade "$atlas" --multiply 2/3,2,4 --json >"$folder/stored" && "$ricochet" cascade "$elementary" --branch "$s2" --multiply 2/3,2,4 --json >"$folder/followed" \
        && python3 -S - "$folder/stored" "$folder/followed" <<'END'
import json, sys
stored, followed = (json.load(open(name)) for name in sys.argv[1:])
paths = {}
for row in stored:
    paths.setdefault(row["path"], []).append(row)
assert [row["impacts"] for row in followed] == [2, 6, 12, 46], followed
assert followed[-1]["grazings"] == 2 and len(followed[2]["word"]) == 12
assert [row["multiple"] for row in followed] == [3, 2, 4, None]
assert all(row["residual"] < 1e-14 for row in followed)
def same(path):
    return all(abs(a["energy"] / b["energy"] - 1) < 1e-9 and abs(a["frequency"] / b["frequency"] - 1) < 1e-9 for a, b in zip(path, followed))
assert any(len(path) == 4 and same(path) for path in paths.values()), paths
END
}
ok 'tripling, doubling, quadrupling, in the atlas and followed' stored
doublings() {
    "$ricochet" cascade "$elementary" --branch "$a5" --doublings 7 --csv | tail -n 1 | awk -F, '{ print; exit !($9 > 8.7201 && $9 < 8.7221 && $4 == 320) }'
}
ok 'seven doublings: 8.7210972' doublings
ok 'the table names long words by their period' sh -c '"$1" cascade "$2" --branch "$3" --doublings 5 | grep -F "[00101]^16"' sh "$ricochet" "$elementary" "$a5"
same() { [ "$(cksum <"$elementary")" = "$before" ]; }
ok 'the atlas is left as it is' same

ok 'an atlas without paths says what to do' exits 0 'explore.multiply' "$ricochet" cascade "$elementary"
ok 'no such cascade' exits 1 '0 of 2 multiplications' "$ricochet" cascade "$elementary" --branch "$(id "$elementary" 'A3[001]')" --doublings 2
ok 'a linear mode' exits 1 'linear mode' "$ricochet" cascade "$elementary" --branch 1 --doublings 2
ok 'no such branch' exits 1 'no branch 999: the numbers run from 1 to' "$ricochet" cascade "$elementary" --branch 999 --doublings 2
ok '--doublings without a branch' exits 2 'needs --branch' "$ricochet" cascade "$elementary" --doublings 2
ok '--doublings and --multiply' exits 2 'choose one' "$ricochet" cascade "$elementary" --branch 3 --doublings 2 --multiply 2
cubic=$folder/cubic.ricochet
cat >"$folder/cubic.yaml" <<'END'
title: t
model: {mass: [[2, 0], [0, 1]], stiffness: [[9, -1], [-1, 1]], contacts: [{normal: [-1, 1], law: power, exponent: 3, length: 1, reference: 1}]}
explore: {energy: [0, 880], frequency: [0.15, 10], multiply: 2, depth: 2}
END
ok 'a cubic spring runs' "$ricochet" run "$folder/cubic.yaml" -o "$cubic"
ok 'its cascades are followed' exits 0 '719\.90979' "$ricochet" cascade "$cubic" --branch "$(id "$cubic" S-)" --multiply 2/3,2,4
ok 'and listed' exits 0 '1/2' "$ricochet" cascade "$cubic" --multiply 2

while IFS='|' read -r list said; do
    ok "--multiply '$list'" exits 2 "$said" "$ricochet" cascade "$elementary" --branch 3 --multiply "$list"
done <<'END'
1|the multiplicity '1' is not a whole number from 2 to
2,x|the multiplicity 'x' is not a whole number
4/3|p of p/q '4' is not a whole number from 1 to 2
|--multiply needs a value
2,,0|the multiplicity '0' is not a whole number
END

if command -v gnuplot >/dev/null; then
    picture() { # NAME OPTION...
        "$ricochet" plot cascade "$atlas" "${@:2}" -o "$folder/$1" && whole "$folder/$1"
    }
    drawn() { # SVG PATTERN...: lines of `curves`
        curves "$folder/$1" >"$folder/curves"
        cat "$folder/curves"
        for pattern in "${@:2}"; do grep -qxE "$pattern" "$folder/curves" || return 1; done
    }
    base=$(id "$atlas" 'S2-[01]')
    ok 'diagram' picture diagram.svg --branch "$base" --multiply 2/3,2,4
    ok 'a line at each multiplication, and the path' drawn diagram.svg 'natural frequency: 3' 'a?symmetric, (un)?stable: [1-9][0-9]*'
    ok 'what is stable is told apart, in words' sh -c 'for word in stable unstable "every other family"; do grep -q ">$word<" "$1" || exit 1; done' sh "$folder/diagram.svg"
    ok 'diagram of x1' picture x1.pdf --branch "$base" --multiply 2/3,2,4 --dof 1
    ok 'shapes' picture shapes.png --branch "$base" --multiply 2/3,2,4 --shapes
    ok 'circle' picture circle.svg --branch "$s6" --circle --duplicate 12
    ok 'what is drawn of the circle, and multipliers' drawn circle.svg 'grid: 12' 'a?symmetric, (un)?stable: [1-9][0-9]*'
    ok 'circle and a list' exits 2 'leave out' "$ricochet" plot cascade "$atlas" --branch "$s6" --circle --multiply 2 -o "$folder/no.svg"
    ok 'no list' exits 2 'missing' "$ricochet" plot cascade "$atlas" --branch "$s6" -o "$folder/no.svg"
    ok 'no such displacement' exits 2 'displacements 1 to 2' "$ricochet" plot cascade "$atlas" --branch "$base" --multiply 3,2 --dof 3 -o "$folder/no.svg"
    ok 'nothing on the circle' exits 1 'unit circle' "$ricochet" plot cascade "$elementary" --branch "$(id "$elementary" 'A3[001]')" --circle -o "$folder/no.svg"
    of_cubic() {
        rm -f "$folder/cubic.svg"
        "$ricochet" plot "$@" "$cubic" --branch "$(id "$cubic" S+)" -o "$folder/cubic.svg" && whole "$folder/cubic.svg" && drawn cubic.svg 'axes: [1-9][0-9]*'
    }
    for picture in "cascade --multiply 2,2" "cascade --multiply 2,2 --shapes" "cascade --circle"; do
        # shellcheck disable=SC2086
        ok "plot $picture" of_cubic $picture
    done
fi

# A mirrored chain between two springs: its trace touches -2, and steps of another length pass both doublings there.
cat >"$folder/mirrored.yaml" <<'END'
model:
  mass: [[3.5, 0], [0, 3.5]]
  stiffness: [[21.75, -16], [-16, 21.75]]
  contacts: [{normal: [-1, 0], law: bilinear, clearance: 1, sides: upper, stiffness: 19.18}, {normal: [0, 1], law: bilinear, clearance: 1, sides: upper, stiffness: 19.18}]
explore: {start: [1], impacts: 2, multiply: 2, depth: 1}
END
"$ricochet" run "$folder/mirrored.yaml" -o "$folder/mirrored.ricochet" --quiet
doubled() {
    python3 -S - <("$ricochet" cascade "$folder/mirrored.ricochet" --branch 'A2+[01]' --doublings 1 --json) \
        <("$ricochet" junctions "$folder/mirrored.ricochet" --kind multiplication --json) <<'END'
import json, sys
steps, junctions = (json.load(open(path)) for path in sys.argv[1:])
assert len(steps) == 1 and any(abs(j["energy"] - steps[0]["energy"]) < 1e-9 * j["energy"] for j in junctions), (steps, junctions)
END
}
ok 'a doubling that the atlas has begins a cascade' doubled
finish
