#!/bin/bash
# The gallery: every command of docs/gallery.md runs and gives a picture, the atlases verify and have the numbers that the article states, and
# every figure from 1 to 30 is on the page.
set -u
root=$PWD
. tests/support/tap.sh

if ! command -v gnuplot >/dev/null || ! command -v python3 >/dev/null; then
    echo '1..0 # SKIP gnuplot or python3 is not there'
    exit 77
fi

# Some figures take nearly all of the time, with their atlases of powers and of a base; the short form takes them as they are
# in the tree.
left='fig21 fig22 fig24 fig25 fig26 fig27a fig28 fig29a'
ok 'all commands of the page run' env WITHOUT="$(some_of "$left" '')" tools/paper "$(dirname "$ricochet")" "$folder"
while IFS= read -r picture; do
    ok "$picture is a whole picture" sh -c 'test "$(wc -c <"$1")" -gt 5000 && tail -c 20 "$1" | grep -q "</svg>"' sh "$folder/$(basename "$picture")"
    ok "$picture is in the tree" test -s "docs/$picture"
done < <(grep -oE '\]\(gallery/[^)]*\)' docs/gallery.md | tr -d ']()')
long_form || left_out 'every point of all atlases verifies' 'make long takes all, here some points of five atlases'
long_form || left_out 'Figs. 21, 22 and 24 to 29 are what is drawn today' 'they are drawn by make long; here they are the files of the tree'
ok "the pictures in the tree$(some_of ', but for Figs. 21, 22 and 24 to 29,' '') are what is drawn today" env PYTHONPATH=tests/support PYTHONDONTWRITEBYTECODE=1 python3 \
    tests/support/same_pictures.py docs/gallery "$folder"
"$ricochet" run examples/elementary/study.yaml -o "$folder/demo.ricochet" >"$folder/log" 2>&1
"$ricochet" plot fep "$folder/demo.ricochet" --break 2.2 -o "$folder/elementary.svg" 2>"$folder/log"
ok 'so is that of the README' env PYTHONPATH=tests/support PYTHONDONTWRITEBYTECODE=1 python3 -S tests/support/same_pictures.py docs "$folder" \
    elementary.svg
# Lines from labels to their points: how many branches they may cross, where there is no other place. Names of figures, numbers.
ok 'lines to labels cross no branch but where there is no other place' env PYTHONPATH=tests/support PYTHONDONTWRITEBYTECODE=1 python3 -S - docs/gallery <<'END'
import os, sys
from picture import Picture, crossed
most = {"fig08": 1, "fig10": 1, "fig15": 1, "fig17": 1, "fig20b": 1, "fig21": 6, "fig24": 6, "fig25": 6, "fig26": 1}
names = sorted(n[:-4] for n in os.listdir(sys.argv[1]) if n.endswith(".svg"))
found = {n: crossed(Picture(os.path.join(sys.argv[1], n + ".svg"))) for n in names}
wrong = {n: k for n, k in found.items() if k > most.get(n, 0)}
print("crossed:", wrong)
sys.exit(len(names) < 30 or bool(wrong))
END
ok 'the page in one file has them all' sh -c 'test "$(grep -c data:image/svg "$1")" -eq "$(grep -c "^!\[" docs/gallery.md)"' sh "$folder/gallery.html"
for figure in $(seq 1 30); do
    ok "figure $figure is on the page" grep -q "^## Fig. $figure:" docs/gallery.md
done

# Nothing is drawn from an atlas that another program would refuse.
every=$(some_of '' --all)
for study in $(some_of 'modes elementary path duplicates cascade' "$(sed -n 's|.*-o build/paper/\(.*\)\.ricochet.*|\1|p' docs/gallery.md)"); do
    ok "$study: $(some_of 'some points' 'every point') of each branch verifies" "$ricochet" verify "$folder/$study.ricochet" $every
done

# Labels as a browser sets them, which has letters of its own; in the short form those of every third picture.
pictures=($(ls "$folder"/*.svg | awk -v every="$(every_of 3)" 'NR % every == 2 % every'))
browser=$(browser_there)
if [ -n "$browser" ] && command -v node >/dev/null && [ -e web/node_modules/playwright-core/package.json ]; then
    ok 'no label is cut or lies on another' node tests/cli/gallery_texts.mjs "$browser" "${pictures[@]}"
fi

# Numbers of the article, its points by their names: STUDY NAME ENERGY FREQUENCY
# K STUDY BRANCH: K - 1 multiplications on the K-duplicate of a branch (Figs. 20a, 23, 30). All by one process, which asks each atlas once.
numbers() {
    PYTHONDONTWRITEBYTECODE=1 python3 -S - "$ricochet" "$folder" 3<&0 <<'PROGRAM'
import functools, json, os, subprocess, sys
ricochet, folder = sys.argv[1:]

@functools.cache
def rows(command, study, *options):
    answer = subprocess.run([ricochet, command, f"{folder}/{study}.ricochet", *options, "--json"], stdout=subprocess.PIPE)
    return json.loads(answer.stdout) if answer.returncode == 0 else []

def near(a, b):
    return abs(a - b) <= 1e-9 * abs(b)

def place(study, name, energy, frequency):
    found = [(j["energy"], j["frequency"]) for j in rows("junctions", study) if j["name"] == name]
    return "" if len(found) == 1 and near(found[0][0], float(energy)) and near(found[0][1], float(frequency)) else str(found)

def multiplications(k, study, label):
    branches = [str(b["id"]) for b in rows("branches", study) if b["label"] == label]
    found = rows("junctions", study, "--duplicates", k, "--branch", branches[0]) if branches else []
    n = sum(p["k"] == int(k) and p["kind"] == "multiplication" and p["origin"] != "copy" for p in found)
    return "" if n == int(k) - 1 else f"{n}, {label} is {branches}"

for line in open(3, encoding="utf-8"):
    words = line.split()
    if words[0].isdigit():
        print(f"the {words[0]}-duplicate of {words[2]} has {int(words[0]) - 1} points C_33", multiplications(*words), sep="\t")
    elif os.path.exists(f"{folder}/{words[0]}.ricochet"):
        print(f"{words[0]}: {words[1]}", place(*words), sep="\t")
    else:
        print(f"{words[0]}: {words[1]}", "left out", sep="\t")
PROGRAM
}
numbers >"$folder/numbers" <<'END'
elementary G1_0,2 0.601588369489 0.9287310650464
elementary G2_0,2 2.960911630511 2.153475936438
elementary C1_31 0.5935887039620914 0.9615592867033224
elementary C2_31 1.8245662467804078 2.7537248237692933
elementary C1_32 1.901327637945699 1.3820239896966182
elementary G1_2,2 2.5197414093965973 1.3820239896966182
elementary G1_2,4 80.97406747026484 1.6667902994358654
elementary G2_4,2 28.644438205 1.680665446
elementary G1_4,2 18.968887538984884 1.6983835151921738
elementary C3_32 22.98740319908438 1.673922264624197
elementary C1_33 3.8487372168924985 1.6862380961394556
elementary C2_32 16.13227945265392 1.6667902994358654
elementary C3_31 9.158308399286632 1.5192560925039564
elementary C4_32 15.557457022590903 1.5319867157145204
duplicates C6_33 2.2556893214 1.80003134035
duplicates C7_33 1.8899969588 1.01057218023333
duplicates C5_33 6.3037444738 1.658849298425
path C2_33 9.5171204595 1.64837958998
cascade C84_33 17.8169663303 0.8376801827
power-3 C1_32 2.764187897 1.2411838299
2 duplicates S2-[01]
3 duplicates S2-[01]
4 duplicates S2-[01]
5 duplicates S2-[01]
6 duplicates S2-[01]
7 duplicates S2-[01]
8 duplicates S2-[01]
9 duplicates S2-[01]
8 cascade S6[010101]
END
while IFS=$'\t' read -r what why; do
    if [ "$why" = 'left out' ]; then left_out "$what" 'in make long; `power` looks for it, too'
    else ok "$what" eval 'echo "$why"; [ -z "$why" ]'; fi
done <"$folder/numbers"
ok 'all of them were asked for' test "$(wc -l <"$folder/numbers")" = 29

# Names that mean nothing, or more than one thing.
refused() { # PATTERN ARGUMENTS...
    local pattern=$1
    shift
    ! "$ricochet" plot "$@" -o "$folder/refused.svg" 2>"$folder/message" && grep -q "$pattern" "$folder/message" && [ ! -e "$folder/refused.svg" ]
}
atlas=$folder/elementary.ricochet
ok 'a label of many branches' refused 'branch S4\[0011\]: 2 branches fit, [0-9]*, [0-9]*; give an id' fep "$atlas" --branch 'S4[0011]'
ok 'a branch that is not there' refused 'no branch has this label' fep "$atlas" --branch 'S4[01]'
ok 'a junction that is not on the branch' refused 'meets these junctions' fep "$atlas" --branch 'S6[010101]|C1_31'
ok 'a junction that is not there' refused 'no junction has this name' fep "$atlas" --label C9_99
ok 'a duplicate without a number' refused 'K:BRANCH' fep "$atlas" --duplicate 'S2-[01]'
ok 'a base that is not there' refused 'no base' fep "$atlas" --base F7_9
ok 'a zoom that is no window' refused 'window' fep "$atlas" --zoom 1:2
ok 'a label before the first of two atlases' refused 'stands behind' fep --label C1_32 "$atlas" "$folder/path.ricochet"
ok 'an orbit at an energy that two have' refused 'orbits fit' orbits "$atlas" --orbit 'S2-[01]@E=2.5'
ok 'an orbit beyond its branch' refused 'between 0 and 1' orbits "$atlas" --orbit 'S2-[01]@1.5'
ok 'orbits without any' refused 'missing' orbits "$atlas"
ok 'a sheet without a segment' refused 'missing' sheet "$atlas"
ok 'a strobe of a displacement that is not there' refused 'displacements' strobe "$atlas" --segment 'S2+[01]' --dof 3
ok 'a name of a junction for one orbit' "$ricochet" plot orbit "$atlas" --junction C1_32 -o "$folder/named.svg"

finish
