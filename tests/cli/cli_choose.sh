#!/usr/bin/env bash
# Rows that are asked for are those of the whole list that have it, and a table is as wide as the terminal.
set -u
. tests/support/tap.sh

atlas="$folder/e.ricochet"
"$ricochet" run examples/elementary/study.yaml -o "$atlas" >"$folder/run" 2>&1 || cat "$folder/run"

# both COMMAND OPTION...: the whole list as all, and that with the options as some
both() {
    local command=$1 more=()
    shift
    [ "$command" != points ] || more=(--branch 3)
    "$ricochet" "$command" "$atlas" "${more[@]}" --json >"$folder/all" \
        && "$ricochet" "$command" "$atlas" "${more[@]}" "$@" --json >"$folder/some"
}

# rows COMMAND CONDITION OPTION...: the rows are those that fulfil a condition of Python on row r, and not all or none
rows() {
    local command=$1 condition=$2
    shift 2
    both "$command" "$@" || return 1
    python3 -S -c "
import json, sys
rows, some = json.load(open(sys.argv[1])), json.load(open(sys.argv[2]))
wanted = [r for r in rows if $condition]
assert 0 < len(wanted) < len(rows), len(wanted)
assert some == wanted, (len(some), len(wanted))" "$folder/all" "$folder/some"
}
ok 'branches: energy' rows branches "r['energy_max'] >= 20 and r['energy_min'] <= 30" --energy 20,30
ok 'branches: frequency' rows branches "r['frequency_max'] >= 3 and r['frequency_min'] <= 4" --frequency 3,4
ok 'branches: stable' rows branches "r['stable_fraction'] == 0" --stable no
ok 'branches: partly' rows branches "0 < r['stable_fraction'] < 1" --stable partly
planted() { # a share that is a rounding error is none
    python3 -S -c '
import sqlite3, sys
db = sqlite3.connect(sys.argv[1])
db.execute("UPDATE branch SET stable_fraction = 3e-14 WHERE id = 3")
db.commit()' "$folder/p.ricochet" && tools/attack/atlas_digest.py "$folder/p.ricochet" >/dev/null
}
cp "$atlas" "$folder/p.ricochet"
ok 'a share of rounding is planted' planted
ok 'and is none' test "$("$ricochet" branches "$folder/p.ricochet" --stable no --csv | grep '^3,' | cut -d, -f9)" = 0
ok 'branches: impacts and word' rows branches "r['impacts'] == 2 and r['word'] == '01'" --impacts 2 --word 01
ok 'branches: limit' rows branches "r['id'] <= 3" --limit 3
ok 'junctions: kind' rows junctions "r['kind'] == 'grazing'" --kind grazing
ok 'junctions: energy' rows junctions "1 <= r['energy'] <= 3" --energy 1,3
ok 'points: stable, energy' rows points "r['stable'] == 'no' and r['energy'] <= 30" --stable no --energy 0,30

refused() { # PATTERN ARGUMENT...
    local pattern=$1
    shift
    "$ricochet" "$@" >"$folder/out" 2>"$folder/said"
    [ $? = 2 ] && [ ! -s "$folder/out" ] && grep -q "$pattern" "$folder/said"
}
ok 'no range' refused 'no range' branches "$atlas" --energy 3
ok 'an empty range' refused 'is empty' branches "$atlas" --energy 3,2
ok 'no such stability' refused 'yes, no, partly' branches "$atlas" --stable maybe
ok 'a column that is not there' refused "no column 'impacts'" branches "$atlas" --segments --impacts 2
said() { "$ricochet" branches "$atlas" --limit 3 2>&1 >/dev/null | grep -q '3 of 14 rows'; }
ok 'a limit is said' said
none() { "$ricochet" branches "$atlas" --energy 1e9,1e10 2>&1 >/dev/null | grep -q 'none of 14 rows'; }
ok 'nothing found is said' none

# sorted_by COMMAND KEY OPTION...: the rows of the whole list by that key of Python, those without a value last
sorted_by() {
    local command=$1 key=$2
    shift 2
    both "$command" "$@" || return 1
    python3 -S -c "
import json, sys
rows, some = json.load(open(sys.argv[1])), json.load(open(sys.argv[2]))
wanted = sorted(rows, key=lambda r: $key)
assert some == wanted != rows" "$folder/all" "$folder/some"
}
ok 'sort' sorted_by branches "r['energy_max']" --sort energy_max
ok 'sort, falling' sorted_by branches "-r['frequency_min']" --sort -frequency_min
ok 'sort, behind an equals sign' sorted_by branches "-r['points']" --sort=-points
ok 'sort texts' sorted_by branches "r['key']" --sort key
ok 'sort: no value comes last' sorted_by branches "(r['to'] is None, -(r['to'] or 0))" --sort -to
ok 'sort: no before yes' sorted_by junctions "(r['decided'] is None, r['decided'] or False)" --sort decided
ok 'sort points' sorted_by points "-r['approach']" --sort -approach
ok 'sort by nothing' refused 'no such column; they have id key label' branches "$atlas" --sort size
ok 'sort by a list' refused 'which have no order' branches "$atlas" --sort junctions
ok 'sort without a column' refused 'needs a value' branches "$atlas" --sort --json

# hertz COMMAND KEYS OPTION...: the same rows, frequencies over 2 pi
hertz() {
    "$ricochet" "$1" "$atlas" "${@:3}" --json >"$folder/all" && "$ricochet" "$1" "$atlas" "${@:3}" --hz --json >"$folder/some" || return 1
    python3 -S - "$folder/all" "$folder/some" $2 <<'P'
import json, math, sys
rows, some, keys = json.load(open(sys.argv[1])), json.load(open(sys.argv[2])), sys.argv[3:]
assert rows and len(rows) == len(some)
for a, b in zip(rows, some):
    assert a.keys() == b.keys()
    for key, value in a.items():
        assert b[key] == (value / (2 * math.pi) if key in keys else value), key
P
}
ok 'hertz: branches' hertz branches 'frequency_min frequency_max'
ok 'hertz: segments' hertz branches 'frequency_min frequency_max' --segments
ok 'hertz: junctions' hertz junctions frequency
ok 'hertz: points' hertz points frequency --branch 3
ok 'hertz: an orbit' hertz orbit frequency --branch 3 --energy 1.5
ok 'hertz: bases' hertz bases 'frequency_min frequency_max'
at_hertz() { # an orbit, and rows, that are asked for by a frequency in Hz
    diff <("$ricochet" orbit "$atlas" --branch 3 --frequency 1.4 --csv | cut -d, -f2) \
        <("$ricochet" orbit "$atlas" --branch 3 --frequency "$(python3 -S -c 'import math; print(repr(1.4 / (2 * math.pi)))')" --hz --csv | cut -d, -f2) &&
        "$ricochet" branches "$atlas" --frequency 3,4 --csv | cut -d, -f1 >"$folder/a" &&
        diff "$folder/a" <("$ricochet" branches "$atlas" --hz --frequency 0.477464829275686,0.636619772367581 --csv | cut -d, -f1)
}
ok 'hertz: what is asked for' at_hertz

# wide COMMAND OPTION...: every number of a list has a column of its own, and all of them are those of --json
wide() {
    "$ricochet" "$1" "$atlas" "${@:2}" --json >"$folder/all" && "$ricochet" "$1" "$atlas" "${@:2}" --wide >"$folder/wide" || return 1
    python3 -S - "$folder/all" "$folder/wide" <<'P'
import csv, json, sys
def cells(name, value):
    if isinstance(value, dict):
        return {f"{name}_{key}": v for key, v in value.items()}
    if not isinstance(value, list):
        return {name: value}
    if name == "state":
        n = len(value) // 2
        return {f"{'xv'[i // n]}{i % n + 1}": v for i, v in enumerate(value)}
    if value and isinstance(value[0], list):
        return {f"{name}_{i + 1}_{part}": v for i, pair in enumerate(value) for part, v in zip(("re", "im"), pair)}
    return {f"{name}_{i + 1}": v for i, v in enumerate(value)}
rows, table = json.load(open(sys.argv[1])), list(csv.DictReader(open(sys.argv[2])))
assert rows and len(rows) == len(table)
for row, line in zip(rows, table):
    wanted = {}
    for name, value in row.items():
        wanted.update(cells(name, value))
    for name, text in line.items():
        value = wanted.pop(name, None)
        if value is None: assert text == "", (name, text)
        elif isinstance(value, bool): assert text == str(value).lower()
        elif isinstance(value, float): assert float(text) == value
        else: assert text == str(value), (name, text, value)
    wanted.pop("resonances", None)
    assert not any(value not in (None, []) for value in wanted.values()), wanted
P
}
ok 'wide: junctions' wide junctions
ok 'wide: branches' wide branches
ok 'wide: an orbit' wide orbit --branch 3 --energy 1.5
ok 'wide: the same list without lists' diff <("$ricochet" points "$atlas" --branch 3 --wide) <("$ricochet" points "$atlas" --branch 3 --csv)

# A list that is too long for a line of a table is cut in it, also where the table goes into a file.
python3 -S - >"$folder/chain.yaml" <<'P'
n = 12
row = lambda f: "[" + ", ".join(map(str, f)) + "]"
print("model:\n  mass:", row(row(int(i == j) for j in range(n)) for i in range(n)))
print("  stiffness:", row(row(2 * (i == j) - (abs(i - j) == 1) for j in range(n)) for i in range(n)))
print("  contacts:\n    - {normal:", row(int(i == n // 2) for i in range(n)) + ", clearance: 1}\nexplore: {start: [1], impacts: 1, multiply: 1, depth: 1}")
P
"$ricochet" run "$folder/chain.yaml" >"$folder/run" 2>&1 || cat "$folder/run"
"$ricochet" orbit "$folder/chain.ricochet" --branch 1 --point 1 >"$folder/out" 2>"$folder/said"
ok 'a table of lists: no line is long' test "$(awk '{ if (length > m) m = length } END { print m }' "$folder/out")" -lt 200
ok 'what is cut says how many there are' grep ' \.\.\. (24 in all)$' "$folder/out"
ok 'and how to see them' grep 'long lists are cut; --csv or --json shows all' "$folder/said"

# on_terminal WIDTH COMMAND...: no line of the table is wider, and energy and frequency are there from 80 columns on
on_terminal() {
    python3 -S tests/support/terminal.py "$1" "$ricochet" "${@:2}" >"$folder/shown" || return 1
    python3 -S - "$1" "$folder/shown" <<'P'
import sys
width = int(sys.argv[1])
lines = [line for line in open(sys.argv[2]).read().splitlines() if line and not line.startswith("ricochet:")]
assert len(lines) > 10 and max(map(len, lines)) <= width, (len(lines), max(map(len, lines)))
assert width < 80 or "energy" in lines[0] and "frequency" in lines[0], lines[0]
P
}
for width in 40 80 120; do
    for list in branches junctions; do ok "$list: a terminal of $width columns" on_terminal $width $list "$atlas"; done
    ok "points: a terminal of $width columns" on_terminal $width points "$atlas" --branch 3
done
whole() { "$ricochet" branches "$atlas" | head -n 1 | grep -q 'energy_min.*depth$'; }
ok 'in a pipe a table is whole' whole

# A study where an atlas belongs, and the other way round: the same exit code, and what to do.
swapped() { "$ricochet" "$@" >"$folder/out" 2>"$folder/said"; [ $? = 2 ] && [ ! -s "$folder/out" ]; }
for command in branches verify report cascade; do
    ok "$command of a study ends with 2" swapped $command examples/elementary/study.yaml
    ok "$command says how to make the atlas" grep -q 'is a study, .*`ricochet run examples/elementary/study.yaml` makes it' "$folder/said"
done
for command in check run; do
    ok "$command of an atlas ends with 2" swapped $command "$atlas"
    ok "$command asks for the study" grep -q 'name the study that it was made from' "$folder/said"
done

# hertz COMMAND...: every frequency is the one without --hz over 2 pi, in rows that are the same otherwise
hertz() {
    "$ricochet" "$@" --json >"$folder/all" 2>/dev/null && "$ricochet" "$@" --hz --json >"$folder/some" 2>/dev/null || return 1
    python3 -S - "$folder/all" "$folder/some" <<'P'
import json, math, sys
all, some = (json.load(open(f)) for f in sys.argv[1:])
assert len(all) == len(some) > 0
ratio = lambda a, b: abs(a / b / (2 * math.pi) - 1) < 1e-14
for a, b in zip(all, some):
    for name in a:
        if name in ("frequency", "locked_1") and a[name]: assert ratio(a[name], b[name]), (name, a, b)
        elif name == "window_frequency": assert ratio(a[name][0], b[name][0]) and ratio(a[name][1], b[name][1])
        else: assert a[name] == b[name], (name, a, b)
P
}
ok 'check --hz' hertz check examples/elementary/study.yaml
ok 'cascade --hz' hertz cascade "$atlas" --branch 3 --doublings 3
ok 'check --hz says so' bash -c '"$0" check "$1" --hz | grep -q "frequency Hz .*period s"' "$ricochet" examples/elementary/study.yaml

# falling COMMAND COLUMN OPTION...: the same rows, the column in falling order
falling() {
    "$ricochet" "$1" "${@:3}" --json >"$folder/all" 2>/dev/null && "$ricochet" "$1" "${@:3}" --sort "-$2" --json >"$folder/some" 2>/dev/null || return 1
    python3 -S - "$folder/all" "$folder/some" "$2" <<'P'
import json, sys
all, some = (json.load(open(f)) for f in sys.argv[1:3])
values = [row[sys.argv[3]] for row in some if row[sys.argv[3]] is not None]
assert len(some) > 2 and values == sorted(values, reverse=True) and len(set(values)) > 1
assert sorted(map(json.dumps, all)) == sorted(map(json.dumps, some))
P
}
ok 'cascade --sort' falling cascade energy "$atlas" --branch 3 --doublings 3
few='--lines 400 --rows 5 --row 60 --random 2000'
ok 'hunt --sort' falling hunt period examples/elementary/study.yaml --energy 1 $few
ok 'verify --sort' falling verify return_error "$atlas" --branch 3
# before: a wrong column is refused before anything is looked for, also where there is nothing to be found
before() {
    "$ricochet" "$@" --sort colour >"$folder/out" 2>"$folder/said"
    [ $? = 2 ] && [ ! -s "$folder/out" ] && cat "$folder/said" && grep -q '^ricochet: --sort colour: .* no such column; they have ' "$folder/said"
}
ok 'hunt: a column that is not there' before hunt examples/elementary/study.yaml --energy 1e-9 $few
ok 'cascade: a column that is not there' before cascade "$atlas" --branch 3 --doublings 3
ok 'verify: a column that is not there' before verify "$atlas" --seconds 1e-9
ok 'a column of lists' bash -c '"$@" 2>&1 | grep -q "holds lists"' bash "$ricochet" hunt examples/elementary/study.yaml --energy 1e-9 $few --sort state
# known COMMAND OPTION...: the columns that the refusal names are all those of the rows that hold no lists
known() {
    "$ricochet" "$@" --json >"$folder/rows" 2>/dev/null
    "$ricochet" "$@" --sort colour >/dev/null 2>"$folder/said"
    python3 -S - "$folder/rows" "$folder/said" <<'P'
import json, sys
named = open(sys.argv[2]).read().split("they have ")[1].split()
rows = json.load(open(sys.argv[1]))
lists = {name for row in rows for name, value in row.items() if isinstance(value, list)}
assert rows and sorted(named) == sorted(rows[0].keys() - lists), (named, rows[0].keys(), lists)
P
}
ok 'hunt names its columns' known hunt examples/elementary/study.yaml --energy 1 $few
ok 'hunt names its columns beside an atlas' known hunt examples/elementary/study.yaml --energy 1 $few --atlas "$atlas"
ok 'cascade names its columns' known cascade "$atlas" --branch 3 --doublings 3
ok 'verify names its columns' known verify "$atlas" --branch 3
if "$ricochet" prove --complete examples/elementary/study.yaml --energy 1e-3 >/dev/null 2>&1; then
    ok 'prove: a column that is not there' before prove --complete examples/elementary/study.yaml --energy 1e-3
    ok 'prove names its columns' known prove --complete examples/elementary/study.yaml --energy 2 --impacts 2
fi

# A study where an atlas belongs, and a kind that there is not, are wrong calls.
study=examples/elementary/study.yaml
wanted() { # COMMAND ARGUMENTS: refused, with the command that makes the atlas
    refusal "$1" 2 ': examples/elementary/study.yaml is a study, and this wants its atlas: `ricochet run examples/elementary/study.yaml`' "${@:2}"
}
ok 'a study is no atlas: plot fep' wanted plot fep "$study" -o "$folder/no.svg"
ok 'a study is no atlas: force' wanted force "$study" --force 1,0 --damping 0.1
ok 'a study is no atlas: response' wanted response "$study" --force 1,0 --damping 0.1 -o "$folder/no.response"
ok 'a study is no atlas: verify' wanted verify "$study"
ok 'a study is no atlas, but where all of one energy is proved' wanted prove "$study"
ok 'a kind that there is not' refusal junctions 2 '^ricochet: --kind graze: there are start, grazing, corner, .* and user$' "$atlas" --kind graze
finish
