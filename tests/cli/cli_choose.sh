#!/usr/bin/env bash
# Rows that are asked for are those of the whole list that have it, and a table is as wide as the terminal.
set -u
. tests/support/tap.sh

atlas="$folder/e.ricochet"
"$ricochet" run examples/elementary/study.yaml -o "$atlas" >"$folder/run" 2>&1 || cat "$folder/run"

# rows COMMAND CONDITION OPTION...: the rows are those that fulfil a condition of Python on row r, and not all or none
rows() {
    local command=$1 condition=$2 more=()
    shift 2
    [ "$command" != points ] || more=(--branch 3)
    "$ricochet" "$command" "$atlas" "${more[@]}" --json >"$folder/all" \
        && "$ricochet" "$command" "$atlas" "${more[@]}" "$@" --json >"$folder/some" || return 1
    python3 -c "
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

# on_terminal WIDTH COMMAND...: no line of the table is wider, and energy and frequency are there from 80 columns on
on_terminal() {
    python3 - "$ricochet" "$@" <<'P'
import fcntl, os, pty, struct, sys, termios
width = int(sys.argv[2])
child, terminal = pty.fork()
if child == 0:
    fcntl.ioctl(1, termios.TIOCSWINSZ, struct.pack("HHHH", 24, width, 0, 0))
    os.execv(sys.argv[1], [sys.argv[1], *sys.argv[3:]])
text = b""
while True:
    try:
        more = os.read(terminal, 65536)
    except OSError:
        break
    if not more:
        break
    text += more
assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
lines = [line for line in text.decode().splitlines() if line and not line.startswith("ricochet:")]
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
finish
