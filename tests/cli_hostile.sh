#!/bin/bash
# Atlases that somebody has made to deceive.
set -u
. tests/tap.sh
if ! command -v python3 >/dev/null; then
    echo '1..0 # SKIP python3 is not there to edit atlases'
    exit 0
fi
export PYTHONDONTWRITEBYTECODE=1
atlas=$folder/a.ricochet
"$ricochet" run examples/elementary/study.yaml -o "$atlas" >/dev/null 2>&1 || exit 1

sql() { # ATLAS STATEMENT...: what the statements answer
    python3 -c 'import sqlite3, sys
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

finish
