#!/usr/bin/env bash
# Exports are read back by other programs and compared with the tables of the atlas, bit for bit.
set -u
. tests/support/tap.sh

python=
for one in python3 /usr/bin/python3; do
    if "$one" -c 'import numpy' 2>/dev/null; then python=$one; break; fi
done
has() { [ -n "$python" ] && "$python" -c "import $1" 2>/dev/null; }
export_to() { [ "$("$ricochet" export "$folder/a.ricochet" -o "$folder/$1")" = "$folder/$1" ]; }

# Symmetric and asymmetric branches, words of several lengths and a title and names that are not plain.
sed -e 's/^title:.*/title: "Zwei Massen, \\"größer\\""/' examples/elementary/study.yaml >"$folder/a.yaml"
ok 'an atlas' "$ricochet" run "$folder/a.yaml" -o "$folder/a.ricochet"

for kind in h5 mat csv; do
    reader=$(case $kind in h5) echo h5py ;; mat) echo scipy.io ;; csv) echo numpy ;; esac)
    package=$(case $kind in h5) echo libhdf5-dev ;; mat) echo libmatio-dev ;; esac)
    "$ricochet" export "$folder/a.ricochet" -o "$folder/a.$kind" >"$folder/told" 2>"$folder/without"
    if grep -q "built without" "$folder/without"; then
        ok "$kind: what is missing is named" grep -q "install $package" "$folder/without"
        ok "$kind: and no file is left" test ! -e "$folder/a.$kind"
    else
        ok "$kind is written" export_to "a.$kind"
        if has "$reader"; then
            ok "$kind is the atlas, bit for bit" "$python" tests/support/compare_export.py "$folder/a.$kind" "$folder/a.ricochet"
        else
            left_out "$kind is the atlas, bit for bit" "no python3 with $reader"
        fi
    fi
done
if [ -e "$folder/a.mat" ] && command -v octave-cli >/dev/null && has numpy; then
    ok 'mat: Octave reads it' octave-cli --no-gui --no-init-file --no-history tests/support/export_octave.m "$folder/a.mat" "$folder/a.octave"
    ok 'mat: what Octave reads is the atlas, bit for bit' "$python" tests/support/compare_export.py "$folder/a.octave" "$folder/a.ricochet"
else
    left_out 'mat: Octave reads it' 'no octave-cli, which the long form installs, or no python3 with numpy, or no libmatio'
fi

# A branch with internal resonances, which JSON has as a list of objects.
printf '%s\n' 'model: {mass: [[1, 0], [0, 1]], stiffness: [[1, 0], [0, 85.1929]], contacts: [{normal: [1, 0.004], clearance: 1}]}' \
    'explore: {start: [1], energy: [0, 5], frequency: [0.1, 20], impacts: 2, multiply: 1, depth: 1, tongues: cross}' >"$folder/t.yaml"
"$ricochet" run "$folder/t.yaml" -o "$folder/t.ricochet" --quiet
resonances() {
    "$ricochet" export "$folder/t.ricochet" -o "$folder/t.csv" && "$ricochet" branches "$folder/t.ricochet" --json >"$folder/t.json" &&
        python3 -S - "$folder" <<'END'
import csv, json, sys
lines = list(csv.reader(open(sys.argv[1] + "/t.csv")))
begin = lines.index(["# branches"])
heading, rows = lines[begin + 1], [line for line in lines[begin + 2:lines.index(["# points"])] if line]
asked = json.load(open(sys.argv[1] + "/t.json"))
assert len(rows) == len(asked) and any(len(b["resonances"]) > 2 for b in asked) and "resonances" not in heading
for row, b in zip(rows, asked):
    one = dict(zip(heading, row))
    for name in "m", "n", "mode", "energy_from", "energy_to", "crossed":
        assert [float(x) for x in one["resonances_" + name].split()] == [r[name] for r in b["resonances"]], (one, b)
END
}
ok 'csv: internal resonances are there, too' resonances

untouched() { echo mine >"$folder/a.txt"; "$ricochet" export "$folder/a.ricochet" -o "$folder/a.txt"; [ $? = 2 ] && [ "$(cat "$folder/a.txt")" = mine ]; }
ok 'another ending is refused and the file left alone' untouched
no_folder() { mkdir "$folder/b.csv"; "$ricochet" export "$folder/a.ricochet" -o "$folder/b.csv"; [ $? = 2 ]; }
ok 'a folder is refused' no_folder
no_link() { ln -s "$folder/a.yaml" "$folder/c.csv"; "$ricochet" export "$folder/a.ricochet" -o "$folder/c.csv"; [ $? = 2 ] && grep -q '^title' "$folder/a.yaml"; }
ok 'a link is refused and what it points to left alone' no_link
# what was there stays until all of the new file is written
full() {
    echo old >"$folder/d.csv"
    (ulimit -f 8; "$ricochet" export "$folder/a.ricochet" -o "$folder/d.csv") 2>"$folder/told"
    [ $? = 1 ] && [ "$(cat "$folder/d.csv")" = old ] && [ "$(ls "$folder" | grep -c '^d.csv')" = 1 ] && cat "$folder/told" && grep -q 'is not written' "$folder/told"
}
ok 'a full disk leaves the old file and nothing else' full
full_of() { (ulimit -f 8; "$ricochet" export "$folder/a.ricochet" -o "$folder/e.$1") 2>/dev/null; [ $? = 1 ] && ! ls "$folder" | grep -q '^e\.'; }
for kind in h5 mat; do [ ! -e "$folder/a.$kind" ] || ok "a full disk leaves no $kind" full_of "$kind"; done
no_atlas() { "$ricochet" export "$folder/a.yaml" -o "$folder/f.csv"; [ $? != 0 ] && [ ! -e "$folder/f.csv" ]; }
ok 'what is no atlas is not exported' no_atlas
finish
