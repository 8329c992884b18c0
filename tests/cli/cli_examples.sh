#!/bin/bash
# Every example runs, has no failed branch, verifies, and shows what its comments say.
set -u
. tests/support/tap.sh

# Fields of a table by name: rows EXAMPLE branches|junctions FIELD... as lines of `field|field|...`
rows() {
    local file=$folder/$1.$2
    shift 2
    awk -F'\037' -v names="$*" '
        NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; n = split(names, name, " ") }
        NR == 1 { for (i = 1; i <= n; i++) if (!(name[i] in at)) { print "no column " name[i]; exit 1 } }
        NR > 1 { line = $at[name[1]]; for (i = 2; i <= n; i++) line = line "|" $at[name[i]]; print line }' "$file"
}
at_least() { # NUMBER: lines on stdin
    local found
    found=$(wc -l)
    echo "$found found, $1 wanted"
    [ "$found" -ge "$1" ]
}
branches() { rows "$1" branches label stop | at_least "$2"; }          # EXAMPLE LEAST
with_impacts() { rows "$1" branches impacts | awk -v least="$2" '$1 >= least' | at_least "$3"; } # EXAMPLE IMPACTS LEAST
labels() { # EXAMPLE LABEL...: there is a branch of each of them
    local found label example=$1
    shift
    found=$(rows "$example" branches label)
    for label in "$@"; do
        grep -qxF "$label" <<<"$found" || { echo "no branch $label"; return 1; }
    done
}
not_failed() {
    rows "$1" branches id label stop why >"$folder/rows" && [ -s "$folder/rows" ] || return 1
    ! grep -E '\|failed\|' "$folder/rows"
}
reasons() { # a junction that has refused departures says why
    rows "$1" junctions id departures refusal | awk -F'|' '$2 !~ /.refused.: 0/ && $3 == "" { print; bad = 1 } END { exit bad }'
}
exactly() { # NUMBER PATTERN EXAMPLE TABLE FIELD...
    local found number=$1 pattern=$2
    shift 2
    found=$(rows "$@" | grep -cE -e "$pattern")
    echo "$found found, $number wanted"
    [ "$found" = "$number" ]
}
has() { rows "$2" "$3" "$4" | grep -E -e "$1"; } # PATTERN EXAMPLE TABLE FIELD

if ! command -v python3 >/dev/null; then
    echo '1..0 # SKIP python3 is not there to read JSON'
    exit 77
fi

# Six examples take nearly all of the time, so the short form explores a part of them: the arm to a few times the energy of
# its first touch, beam-lumped and power-21 to a part of their energy, and the others not so deep.
study() # EXAMPLE
{
    local study=examples/$1/study.yaml part=
    case $1 in
    arm) part='s/times: .*/times: [0, 1.4]}/' ;;
    beam-lumped) part='s/depth: 6/depth: 2/; s/energy: .*/energy: [0, 20]/' ;;
    power-21) part='s/energy: .*/energy: [0, 100]/' ;;
    peeters | power-3 | power-7) part='s/depth: 2/depth: 1/' ;;
    esac
    if [ -n "$part" ] && ! long_form; then
        mkdir -p "$folder/short/$1" && cp "examples/$1/"* "$folder/short/$1/" && sed "$part" "$study" >"$folder/short/$1/study.yaml"
        cmp -s "$study" "$folder/short/$1/study.yaml" || study=$folder/short/$1/study.yaml
    fi
    echo "$study"
}

# Two at a time; the results do not depend on it.
examples=$(cd examples && echo */study.yaml) # examples/paper belongs to docs/gallery.md
examples=${examples//\/study.yaml/}
for example in $examples; do
    echo $example $(study "$example")
done | xargs -P 2 -L 1 sh -c '"$1" run "$4" -o "$2/$3.ricochet" >"$2/$3.out" 2>&1; echo $? >"$2/$3.code"
    "$1" verify "$2/$3.ricochet" >"$2/$3.replay" 2>&1; echo $? >>"$2/$3.code"' sh "$ricochet" "$folder"

# What rows() reads: the tables of all, by one start of Python.
python3 -S - "$ricochet" "$folder" $examples <<'END'
import json, subprocess, sys
ricochet, folder, *examples = sys.argv[1:]
for example in examples:
    for table in ("branches", "junctions"):
        said = subprocess.run([ricochet, table, f"{folder}/{example}.ricochet", "--json"], stdout=subprocess.PIPE)
        if said.returncode:
            continue
        found = json.loads(said.stdout)
        names = list(found[0]) if found else ()
        with open(f"{folder}/{example}.{table}", "w", encoding="utf-8") as file:
            for row in (dict(zip(names, names)), *found):
                print(*(row[name] for name in names), sep="\37", file=file)
END
ok 'all tables are read' test $? = 0 -a "$(ls "$folder"/*.branches "$folder"/*.junctions | wc -l)" = $((2 * $(wc -w <<<"$examples")))

# Ghosts of every branch that has one: they all end for a reason, with every point solved. The short form takes every third
# branch, of beam-lumped every seventh.
ghosts() { # EXAMPLE
    local id
    rows "$1" branches id >"$folder/ids"
    local few=3
    [ "$1" != beam-lumped ] || few=7
    awk -v every="$(every_of $few)" 'NR % every == 2 % every' "$folder/ids" >"$folder/some" && mv "$folder/some" "$folder/ids"
    [ -s "$folder/ids" ] || return 1
    while IFS= read -r id; do
        "$ricochet" points "$folder/$1.ricochet" --branch "$id" --ghost --csv 2>&1 | awk -v id="$id" -F, '
            /stopped: failed/ || /not fit|not converge/ { print "branch " id ": " $0; bad = 1 }
            $1 == "end" { for (i = 1; i <= NF; i++) if ($i == "residual") column = i }
            ($1 == "from" || $1 == "to") && !($column < 1e-12) { print "branch " id ": " $0; bad = 1 }
            END { exit bad }' || return 1
    done <"$folder/ids"
}

ran() { cat "$folder/$1.out" && [ "$(sed -n 1p "$folder/$1.code")" = 0 ]; }
verified() { grep -v 'yes *yes$' "$folder/$1.replay"; [ "$(sed -n 2p "$folder/$1.code")" = 0 ]; }
for example in $examples; do
    ok "$example: run" ran "$example"
    ok "$example: no branch failed" not_failed "$example"
    ok "$example: verify" verified "$example"
    ok "$example: every refusal has a reason" reasons "$example"
    ok "$example: ghosts" ghosts "$example"
done

ok 'elementary: branches' branches elementary 14
complete() { # up to high energies and many impacts nothing is refused or lost
    sed 's/^  energy:.*/  energy: [0, 1000]/; s/^  impacts:.*/  impacts: 24/; s/^  multiply:.*/  multiply: 1/; s/^  depth:.*/  depth: 0/' \
        examples/elementary/study.yaml >"$folder/complete.yaml"
    "$ricochet" run "$folder/complete.yaml" -o "$folder/complete.ricochet" >"$folder/said" 2>&1 || return 1
    cat "$folder/said"
    grep -q '^departures taken: ' "$folder/said" && ! grep -q 'refused\|failed\|no junctions' "$folder/said"
}
ok 'elementary: complete up to energy 1000 and 24 impacts' complete

# The path of symmetric branches, and frequencies that close in on the locked one, 1.6329931618554521, from both sides.
path='S6[010101] S4[0011] S10[0101010101] S6[000111] S14[01010101010101] S8[00001111] S18[010101010101010101]'
ok 'symmetric-path: S6, S4, S10, S6, S14, S8, S18' labels symmetric-path $path
ok 'symmetric-path: branches' branches symmetric-path 30
only_symmetric() { rows symmetric-path branches label symmetric impacts | awk -F'|' '$2 != "True" { print; bad = 1 } END { exit bad }'; }
ok 'symmetric-path: symmetric branches only' only_symmetric
closes_in() { # extreme frequencies of the S(2k)[0..01..1] and of the S(4k+2)[01] branches approach the locked one from below and above
    rows symmetric-path branches label frequency_min frequency_max energy_max | python3 -S -c '
import re, sys
locked, below, above = 1.6329931618554521, {}, {}
for line in sys.stdin:
    label, low, high, energy = line.strip().split("|")
    word = re.search(r"\[(.*)\]", label)
    word = word.group(1) if word else ""
    half = len(word) // 2
    if half > 1 and word == "0" * half + "1" * half:
        below[half] = min(below.get(half, 9), float(low))
    if half > 2 and half % 2 and word == "01" * half:
        above[half] = max(above.get(half, 0), float(high))
below = [below[k] for k in sorted(below)]
above = [above[k] for k in sorted(above)]
print("below", below, "above", above)
ok = len(below) >= 4 and len(above) >= 4
ok = ok and all(a < b < locked for a, b in zip(below, below[1:])) and all(a > b > locked for a, b in zip(above, above[1:]))
sys.exit(not ok)'
}
ok 'symmetric-path: extreme frequencies close in on the locked one' closes_in

# The corner, computed independently, to 1e-8.
corner() {
    rows corner junctions kind energy frequency id | awk -F'|' '
        $1 == "corner" && ($2 / 1.798382934 - 1)^2 < 1e-16 && ($3 / 2.639443043 - 1)^2 < 1e-16 { print $4 }' >"$folder/corner"
    cat "$folder/corner"
    [ "$(wc -l <"$folder/corner")" = 1 ] && rows corner branches stop to | grep -qx "corner|$(cat "$folder/corner")"
}
ok 'corner: found where it should be, and ends a branch' corner
ok 'corner: branches' branches corner 12

# Corners of orthogonal normals: both sides are branches, with two letters exchanged.
ok 'two-walls: a corner without a way on says why' exactly 1 '^corner.*for good' two-walls junctions kind refusal
ok 'two-walls: three corners are passed' exactly 3 "^corner.*'taken': [01], 'known': [12], .*'over_budget': 0, 'refused': 0" two-walls junctions kind departures
ok 'two-walls: a path through two corners' labels two-walls 'A6[020212]' 'A6[010222]'
ok 'three-masses: branches' branches three-masses 10
ok 'three-masses: impacts on both contacts in one word' has '0.*[12]|[12].*0' three-masses branches word
ok 'free-pair: two branches' exactly 2 . free-pair branches id
ok 'free-pair: no branch point' exactly 0 branch-point free-pair junctions kind
low() { rows loose-mass branches label energy_min | grep -E '^S2.*\|0\.0(10*|09999999999[0-9]*)$'; }
ok 'loose-mass: the family of the loose mass starts at the lower edge of the window' low
ok 'loose-mass: branches' branches loose-mass 10
ok 'gears: branches of free gears' branches gears 20
ok 'gears: seventeen of them from no linear mode' exactly 17 '^S2\[01\]$' gears branches label
tongue() { # S+ goes on to the end of the window from where it touches the 3-duplicate of S-, over two more extrema
    rows peeters branches id label stop energy_max junctions | grep '^1|S+|window|10000' >"$folder/path" && cat "$folder/path" || return 1
    rows peeters junctions id kind multiple energy frequency branches | python3 -S -c '
import sys
path = [int(i) for i in sys.argv[1].strip("[]").split(", ")]
rows = {int(row[0]): row for row in (line.strip().split("|") for line in sys.stdin)}
wanted = [("extremum", 4680.546292756), ("multiplication", 285.1593439288), ("extremum", 285.1589908027), ("extremum", 2105.466020769),
          ("extremum", 1786.385084028)]
found = [i for i in path if any(rows[i][1] == kind and abs(float(rows[i][3]) / energy - 1) < 1e-9 for kind, energy in wanted)]
print(*(rows[i] for i in found), sep="\n")
touch = rows[found[1]]
sys.exit(not (len(found) == len(wanted) and touch[2] == "3" and touch[5] == "[1, 2]" and abs(float(touch[4]) - 1.407414986264) < 1e-9))' \
        "$(cut -d'|' -f5 "$folder/path")"
}
ok 'peeters: the tongue leads to the 3-duplicate of the other mode and back to the backbone' tongue
arm() { # FREQUENCY TONGUES
    rows arm branches label frequency_max tongues | grep -F 'S2(1)[01]' | tee "$folder/backbone"
    awk -F'|' -v least="$1" '{ exit !($2 > least) }' "$folder/backbone" && grep -qE "steps over $2 tongues" "$folder/backbone"
}
ok "arm: the backbone with all modes goes to $(some_of 476 638) rad/s, over its tongues" arm $(some_of '476 8[0-9]' '638 6[0-9][0-9]')
ok 'beam-lumped: branches' branches beam-lumped "$(some_of 6 50)"
ok "beam-lumped: some of $(some_of two four) or more impacts" with_impacts beam-lumped $(some_of '2 3' '4 10')
made() { # the matrices are those that the script makes
    mkdir "$folder/beam" && tools/beam.py "$folder/beam" 10 4 0.5 4.05 && cmp "$folder/beam/M.mtx" examples/beam-lumped/M.mtx \
        && cmp "$folder/beam/K.mtx" examples/beam-lumped/K.mtx
}
ok 'beam-lumped: tools/beam.py makes its matrices' made
unseen() { "$ricochet" check examples/beam-midspan/study.yaml | grep '4 of them seen'; }
ok 'beam-midspan: half of the modes are unseen' unseen
warned() { "$ricochet" check examples/beam-midspan/study.yaml | grep 'do not converge with the number of modes'; }
ok 'beam-midspan: check warns of a rigid stop on a truncated continuum' warned
sprung() { # and not of a spring, which it shows
    sed 's/law: rigid/law: bilinear\n      stiffness: 300/' examples/beam-midspan/study.yaml >"$folder/sprung.yaml"
    "$ricochet" check "$folder/sprung.yaml" >"$folder/out" && grep 'a spring of stiffness 300 beyond' "$folder/out" && ! grep warning "$folder/out"
}
ok 'beam-midspan: nor of a spring in its place' sprung
ok 'beam-midspan: five linear modes' exactly 5 '^S0' beam-midspan branches label
ok 'beam-midspan: branches' branches beam-midspan 10
ok 'symmetric-chain: three linear modes' exactly 3 '^S0' symmetric-chain branches label
ok 'symmetric-chain: one corner, where both stops close at one instant' exactly 1 '^K' symmetric-chain junctions label
ok 'symmetric-chain: two stops that are touched one after the other are a grazing' exactly 2 '^G[12]_2,4' symmetric-chain junctions label
ok 'symmetric-chain: departures that close both stops are refused by name' has 'two contacts close together' symmetric-chain junctions refusal

finish
