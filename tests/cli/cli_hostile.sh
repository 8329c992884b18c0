#!/bin/bash
# Atlases that somebody has made to deceive.
set -u
. tests/support/tap.sh
if ! command -v python3 >/dev/null; then
    echo '1..0 # SKIP python3 is not there to edit atlases'
    exit 0
fi
export PYTHONDONTWRITEBYTECODE=1
atlas=$folder/a.ricochet
study=$folder/study.yaml # a small one: what is changed in an atlas makes its digest anew, each time
sed 's/depth: .*/depth: 2/' examples/elementary/study.yaml >"$study"
"$ricochet" run "$study" -o "$atlas" >/dev/null 2>&1 || exit 1

sql() { # ATLAS STATEMENT...: what the statements answer
    python3 -S -c 'import sqlite3, sys
db = sqlite3.connect(sys.argv[1])
for statement in sys.argv[2:]: print(*(row[0] for row in db.execute(statement)))
db.commit()' "$@"
}
remade_digest() { # the tool finds the digest that the program has written, and makes a changed file valid again
    [ "$(tools/attack/atlas_digest.py --show "$atlas")" = "$(sql "$atlas" "SELECT value FROM meta WHERE key = 'digest'")" ] || return 1
    cp "$atlas" "$folder/b.ricochet"
    sql "$folder/b.ricochet" "UPDATE junction SET name = 'bœuf' WHERE id = 2"
    "$ricochet" junctions "$folder/b.ricochet" 2>&1 && return 1
    tools/attack/atlas_digest.py "$folder/b.ricochet" && "$ricochet" junctions "$folder/b.ricochet" --json | grep -q bœuf
}
ok 'the digest of an atlas is made anew by a tool' remade_digest

trap 'rm -rf "$folder" "$folder"-*' EXIT
state() { find "$folder" -mindepth 1 ! -name log -printf '%P %y %l %s %U %m %n %T@\n' | sort; }
sed 's/depth: .*/depth: 3/' "$study" >"$folder/more.yaml"
cp "$atlas" "$folder/c.ricochet"
# What lies in the place of the files that the program itself names, or is to draw.
pictures=
! command -v gnuplot >/dev/null || pictures=pictures
python3 -S tests/support/in_the_way.py "$ricochet" "$folder" $pictures >"$folder-claims"
ok 'what lies in the way was tried' test $? = 0 -a "$(grep -c 'in the place of' "$folder-claims")" -ge 46
claims "$folder-claims"

if command -v gnuplot >/dev/null; then
    quoted() { # quotes in a title, also at its beginning
        "$ricochet" plot fep "$atlas" --title "'t Hooft's ''plot''" -o "$folder/h.svg" && grep -q "'t Hooft's ''plot''" "$folder/h.svg"
    }
    ok 'quotes in a title are drawn' quoted
    ranges() { # axes of a trace beyond all doubles, and of gaps of a million clearances, have a few ticks
        cp "$atlas" "$folder/h.ricochet"
        sql "$folder/h.ricochet" 'UPDATE point SET trace_asinh = 1e15 WHERE branch = 2' >/dev/null
        tools/attack/atlas_digest.py "$folder/h.ricochet"
        timeout 300 "$ricochet" plot floquet "$folder/h.ricochet" --branch 2 -o "$folder/h.svg" && grep -q '[0-9]e+14<' "$folder/h.svg" || return 1
        cp "$atlas" "$folder/h.ricochet"
        python3 -S -c 'import sqlite3, struct, sys
db = sqlite3.connect(sys.argv[1])
for branch, point, energy, state in db.execute("SELECT branch, point, energy, state FROM point").fetchall():
    numbers = struct.unpack(f"<{len(state) // 8}d", state)
    db.execute("UPDATE point SET energy = ?, state = ? WHERE branch = ? AND point = ?",
               [energy * 1e12, struct.pack(f"<{len(numbers)}d", *(1e6 * x for x in numbers)), branch, point])
db.commit()' "$folder/h.ricochet"
        tools/attack/atlas_digest.py "$folder/h.ricochet"
        timeout 300 "$ricochet" plot sheet "$folder/h.ricochet" --segment 1 -o "$folder/h.svg" && [ "$(grep -o ">[^<]*00000<" "$folder/h.svg" | wc -l)" -ge 3 ]
    }
    ok 'axes of absurd ranges have a few ticks' ranges
fi

# Texts of a study and of its atlas steer no terminal.
steering=$(printf '[\001-\010\013-\037\177]')
inert() { # COMMAND...: exit status and output without control characters, the text written out
    "$ricochet" "$@" >"$folder-out" 2>&1
    cat -v "$folder-out" | head -5
    ! LC_ALL=C grep -q "$steering" "$folder-out" && grep -q '\\x1b\[2J' "$folder-out"
}
sed -e 's/^title:.*/title: "a \\e[2J"/' -e 's/- normal:/- name: "b \\e[2J"\n      normal:/' "$study" >"$folder/t.yaml"
cp "$atlas" "$folder/t.ricochet"
sql "$folder/t.ricochet" "UPDATE branch SET label = 'c ' || char(27) || '[2J' || char(10) || 'd'" "UPDATE junction SET name = 'c ' || char(27) || '[2J'" >/dev/null
tools/attack/atlas_digest.py "$folder/t.ricochet" >/dev/null
ok 'check writes out what would steer a terminal' inert check "$folder/t.yaml"
ok 'branches writes out what would steer a terminal' inert branches "$folder/t.ricochet"
ok 'junctions writes out what would steer a terminal' inert junctions "$folder/t.ricochet"
ok 'a message writes out what would steer a terminal' inert check "$folder/$(printf '\033[2J')"
ok 'a run writes out what would steer a terminal' inert run "$folder/t.yaml" -o "$folder/$(printf '\033[2J').ricochet"
ok 'a new study writes out what would steer a terminal' inert new "$folder/absent/$(printf '\033[2J')"
on_terminal() { # COMMAND...: what it writes to a terminal
    python3 -S tests/support/terminal.py 80 "$ricochet" "$@" >"$folder-out"
    cat -v "$folder-out" | head -5
    ! LC_ALL=C grep -q "$steering" "$folder-out" && grep -q '\\x1b\[2J' "$folder-out"
}
ok 'CSV on a terminal steers none' on_terminal branches "$folder/t.ricochet" --csv
raw() { "$ricochet" branches "$folder/t.ricochet" --csv | grep -qF "$(printf '"c \033[2J')"; }
ok 'CSV in a file holds the text itself' raw
rm -f "$folder"/t.* "$folder"/*2J*

# Standard streams that fail or are closed.
if [ -c /dev/full ]; then
    unheard() { # the summary of a run is lost, not the atlas
        "$ricochet" run "$study" -o "$folder/u.ricochet" >/dev/full
        [ $? = 1 ] && "$ricochet" branches "$folder/u.ricochet" >/dev/null
    }
    ok 'a report that cannot be written is a failure' unheard
fi
closed() { # no file that is opened takes the place of a standard stream
    rm -rf "$folder/u" "$folder/u.ricochet"
    "$ricochet" new "$folder/v" >/dev/null && "$ricochet" new "$folder/u" >&- 2>"$folder-out"
    [ $? = 1 ] && grep 'cannot be written' "$folder-out" && sed 's/"u"/"v"/' "$folder/u/study.yaml" | diff - "$folder/v/study.yaml" || return 1
    "$ricochet" run "$study" -o "$folder/u.ricochet" <&- >&- 2>&-
    [ $? = 1 ] && "$ricochet" branches "$folder/u.ricochet" <&-
}
ok 'closed standard streams are not taken for files' closed
rm -rf "$folder"/u* "$folder"/v

small_files() { # a limit of the size of files is an error with a message
    (ulimit -f 60; "$ricochet" run "$folder/more.yaml" -o "$folder/l.ricochet") >"$folder-out" 2>&1
    local code=$?
    cat "$folder-out"
    [ $code = 1 ] && grep -q '^ricochet: .*l.ricochet: ' "$folder-out"
}
ok 'a file that may not grow is reported' small_files

names_another() { # a journal can have SQLite remove a file of any name: such a one is refused
    echo precious >"$folder/x"
    python3 -S -c 'import sys, struct
name, magic = sys.argv[2].encode(), b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7"
head = magic + struct.pack(">iIIII", 0, 1, 80, 512, 4096)
open(sys.argv[1], "wb").write(head.ljust(512, b"\0") + struct.pack(">I", 80) + name + struct.pack(">II", len(name), sum(name)) + magic)' "$folder/c.ricochet-journal" "$folder/x"
    state >"$folder-before"
    "$ricochet" branches "$folder/c.ricochet" 2>&1 | tee "$folder-out"
    "$ricochet" run "$folder/more.yaml" -o "$folder/c.ricochet" 2>&1 | tee -a "$folder-out"
    state | diff "$folder-before" - && [ "$(grep -c 'a journal that names further files' "$folder-out")" = 2 ]
}
ok 'a journal that names a file to be removed is refused' names_another
rm -f "$folder/c.ricochet-journal"

ahead() { # a reader makes no file beside an atlas that another program has left in write-ahead mode
    sql "$folder/c.ricochet" 'PRAGMA journal_mode = WAL'
    rm -f "$folder/c.ricochet-"*
    state >"$folder-before"
    "$ricochet" branches "$folder/c.ricochet" >/dev/null && state | diff "$folder-before" -
}
ok 'an atlas in write-ahead mode is read without a file beside it' ahead

through() { # a link to an atlas is the atlas
    ln -s c.ricochet "$folder/named"
    "$ricochet" run "$folder/more.yaml" -o "$folder/named" >/dev/null && [ -L "$folder/named" ] && "$ricochet" branches "$folder/named" >/dev/null
}
ok 'a link to an atlas stands for it' through

slow() { # an orbit that agrees with itself and lasts longer than the windows of its study is refused, and not integrated
    cat >"$folder/s.yaml" <<'EOF'
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts: [{normal: [-1, 1], law: power, exponent: 3, stiffness: 2}]
explore: {energy: [0, 6], frequency: [0.3, 8], multiply: 1, depth: 0, step: 0.3}
EOF
    "$ricochet" run "$folder/s.yaml" -o "$folder/s.ricochet" >/dev/null || return 1
    python3 -S -c 'import sqlite3, struct, sys
db = sqlite3.connect(sys.argv[1])
for row in db.execute("SELECT branch, point, frequency, flights FROM point").fetchall():
    times = struct.unpack(f"<{len(row[3]) // 8}d", row[3])
    db.execute("UPDATE point SET frequency = ?, flights = ? WHERE branch = ? AND point = ?",
               [row[2] / 1e4, struct.pack(f"<{len(times)}d", *(1e4 * t for t in times)), *row[:2]])
db.commit()' "$folder/s.ricochet"
    tools/attack/atlas_digest.py "$folder/s.ricochet"
    timeout 300 "$ricochet" verify "$folder/s.ricochet" --all >"$folder-out" 2>&1
    [ $? = 1 ] && cat "$folder-out" && grep -q 'flights: a period of .* s, where the windows and the modes of the study end at 20.944 s' "$folder-out"
}
ok 'orbits beyond the windows of the study are refused' slow

outside() { # linear modes are listed wherever they lie
    sed -e 's/law: power.*/clearance: 1, sides: both, law: rigid}]/' -e 's/\[0.3, 8\]/[2.9, 8]/' "$folder/s.yaml" >"$folder/r.yaml"
    rm -f "$folder/s.ricochet"
    "$ricochet" run "$folder/r.yaml" -o "$folder/s.ricochet" >/dev/null &&
        "$ricochet" points "$folder/s.ricochet" --branch 1 | grep -q ' 0\.928'
}
ok 'linear modes beyond the windows are read' outside

half() { # atlases of before have a rotation of -1/2 where a multiplier is exactly -1; others below zero there are none
    cp "$atlas" "$folder/r.ricochet"
    sql "$folder/r.ricochet" "UPDATE point SET rotation = $1 WHERE branch = 2 AND point = 1" >/dev/null
    tools/attack/atlas_digest.py "$folder/r.ricochet" && "$ricochet" branches "$folder/r.ricochet" >"$folder-out" 2>&1
    local code=$?
    tail -1 "$folder-out"
    [ $code = "$2" ]
}
ok 'a rotation of -1/2 is read' half -0.5 0
ok 'a rotation of -0.4 is refused' half -0.4 1
rm -f "$folder"/s.* "$folder"/r.*

# A run reads all that a file holds before it writes the first byte: one that comes upon damage on its way has by then
# stored what it has traced.
bend() { # WHAT: a row of the file is changed, and the digests are made anew
    cp "$atlas" "$folder/w.ricochet"
    PYTHONPATH=tools/attack python3 -S - "$1" "$folder/w.ricochet" <<'EOF'
import sqlite3, struct, sys
import atlas_digest
what, path = sys.argv[1:]
db = sqlite3.connect(path)
traces = [row for row in db.execute("SELECT key, blob FROM trace ORDER BY rowid DESC") if row[1] and row[0][0].isdigit()]
key, blob = traces[0]
label = db.execute("SELECT key FROM trace WHERE key LIKE 'label %' ORDER BY rowid DESC").fetchone()[0]
def put(key, blob, fit=True):
    digest = atlas_digest.over_bytes(atlas_digest.START, blob) if fit else 7
    db.execute("INSERT OR REPLACE INTO trace (key, blob, digest) VALUES (?, ?, ?)", [key, blob, digest - (1 << 64) if digest >> 63 else digest])
if what == "bytes": put(key, blob[:-9] + b"\1" + blob[-8:], False)
elif what == "cut": put(key, blob[:-8])
elif what == "infinite": # the last number of ordinary size, which belongs to the event at the end
    places = [i for i in range(0, len(blob) - 7, 4) if 1e-3 < abs(struct.unpack_from("<d", blob, i)[0]) < 1e3]
    put(key, blob[:places[-1]] + struct.pack("<d", float("inf")) + blob[places[-1] + 8:])
elif what == "paused": put(key + " paused", b"half done")
elif what == "label": put(label, b"\xff" * 12)
elif what == "key": put("0 of nothing", blob)
elif what == "factor": put(" ".join("2147483647" if i == 12 else word for i, word in enumerate(key.split(" "))), blob)
elif what == "text": db.execute("UPDATE trace SET blob = 'a text' WHERE key = ?", [key])
elif what == "twice":
    db.execute("CREATE TABLE loose AS SELECT * FROM trace")
    db.execute("INSERT INTO loose SELECT * FROM trace LIMIT 1")
    db.execute("DROP TABLE trace")
    db.execute("ALTER TABLE loose RENAME TO trace")
elif what == "starts": db.execute("INSERT INTO meta (key, value) VALUES ('starts', '2 0 x')")
elif what == "point": db.execute("UPDATE point SET energy = 9e9 WHERE branch = 3 AND point = 2")
elif what == "ahead":
    put(key, blob[:-8])
    db.commit()
    db.execute("PRAGMA journal_mode = WAL")
db.commit()
db.close()
atlas_digest.update(path)
EOF
}
kept_whole() { # WHAT PATTERN: a run that would extend the atlas is refused, and neither file nor folder is changed
    bend "$1" || return 1
    rm -f "$folder/w.ricochet-"*
    state >"$folder-before"
    md5sum <"$folder/w.ricochet" >"$folder-bytes"
    timeout 300 "$ricochet" run "$folder/more.yaml" -o "$folder/w.ricochet" >"$folder-out" 2>&1
    local code=$?
    cat "$folder-out"
    state | diff "$folder-before" - && md5sum <"$folder/w.ricochet" | cmp - "$folder-bytes" && [ $code = 1 ] &&
        grep -q "w.ricochet: damaged atlas ($2.*); restore it from a copy, or remove it and run the study again" "$folder-out"
}
damages='bytes:the_bytes_do_not_match_their_digest cut:no_run_can_have_kept infinite:no_run_can_have_kept paused:no_run_can_have_kept
    label:no_run_can_have_kept key:no_run_can_have_kept factor:no_run_can_have_kept ahead:no_run_can_have_kept text:not_a_row_of_bytes twice:twice'
for kind in $damages; do
    what=${kind#*:}
    ok "stored work that is damaged is refused before anything is written: ${kind%%:*}" kept_whole "${kind%%:*}" "table trace, row [0-9l].*: .*${what//_/ }"
done
ok 'a damaged point is refused by a run before anything is written' kept_whole point 'table point, row 3, 2, state: '
ok 'damaged starts are refused by a run before anything is written' kept_whole starts 'table meta, row starts: '
rm -f "$folder"/w.*

# Points that are no orbits: what is computed from them would belong to nothing, and take any time.
no_orbits() { # COMMAND...
    cp "$atlas" "$folder/n.ricochet"
    python3 -S -c 'import array, sqlite3, sys
db = sqlite3.connect(sys.argv[1])
for branch, point, flights in db.execute("SELECT branch, point, flights FROM point").fetchall():
    times = array.array("d", flights)
    if len(times) > 1: # as long a period
        times[0] += times[1] / 2
        times[1] /= 2
    db.execute("UPDATE point SET flights = ? WHERE branch = ? AND point = ?", [times.tobytes(), branch, point])
db.commit()' "$folder/n.ricochet"
    tools/attack/atlas_digest.py "$folder/n.ricochet" >/dev/null
    timeout 300 "$ricochet" "$1" ${2:+"$2"} "$folder/n.ricochet" "${@:3}" >"$folder-out" 2>&1
    local code=$?
    cat "$folder-out"
    [ $code = 1 ] && grep -q 'damaged atlas (table point, row .*: what is stored is no orbit' "$folder-out"
}
ok 'an orbit is not solved from a point that is none' no_orbits orbit '' --branch 3 --energy 1
ok 'nor a stored point shown' no_orbits orbit '' --branch 3 --point 1
ok 'nor ghosts followed' no_orbits plot fep --ghosts -o "$folder/n.svg"

# The short form of tools/attack/craft.py: fields of every table replaced by hostile values. 10,000 under the sanitizers take half an hour.
count=$(some_of 15 100)
ok "$count atlases with hostile values end in answers or messages" tools/attack/craft.py --program "$ricochet" --count $count --seed 7 --short

finish
