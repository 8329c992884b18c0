#!/bin/bash
# What pictures show: lines, marks, texts and numbers in their SVG.
set -u
. tests/support/tap.sh

if ! command -v gnuplot >/dev/null || ! command -v python3 >/dev/null; then
    echo '1..0 # SKIP gnuplot or python3 is not there'
    exit 77
fi
export PYTHONPATH=$PWD/tests/support PYTHONDONTWRITEBYTECODE=1

# atlas NAME STUDY: an atlas to draw
atlas() {
    "$ricochet" run "$2" -o "$folder/$1.ricochet" >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
}
# draw NAME ARGUMENTS...: NAME.svg
draw() {
    local name=$1
    shift
    "$ricochet" plot "$@" -o "$folder/$name.svg" 2>"$folder/message"
}
# seen WHAT NAME: a condition on the picture `p`, in Python, from standard input. All are looked at by one process at the end, in the
# pictures as they were here.
asked=0
seen() {
    local condition
    IFS= read -r -d '' condition
    asked=$((asked + 1))
    cp "$folder/$2.svg" "$folder/asked-$asked.svg"
    printf '%s\n%s' "$1" "$condition" >"$folder/asked-$asked"
}
all_seen() {
    python3 -S - "$folder" "$asked" <<'END' >"$folder/seen"
import contextlib, io, sys
import picture
for number in range(1, int(sys.argv[2]) + 1):
    path, said, why = f"{sys.argv[1]}/asked-{number}", io.StringIO(), "nothing was checked"
    name, _, condition = open(path, encoding="utf-8").read().partition("\n")
    try:
        with contextlib.redirect_stdout(said):
            exec(condition, dict(vars(picture), p=picture.Picture(path + ".svg")))
    except SystemExit as end: # of check()
        why = "" if not end.code else "it is not so: " + said.getvalue()
    except Exception as error:
        why = repr(error)
    print(name, " ".join(why.split()), sep="\t")
END
    [ $? = 0 ] && [ "$(wc -l <"$folder/seen")" = "$asked" ]
}
atlas mixed examples/stop-and-spring/study.yaml
atlas two examples/elementary/study.yaml

# ---------------------------------------------------------------- one orbit
ok 'an orbit with a stop on one side and a spring' draw stop orbit "$folder/mixed.ricochet" --branch 3 --energy 20
seen 'only the spring has a line below, in its colour' stop <<'END'
grey, own = p.lines["stop"], p.lines.get("stop of the second", [])
check(len(grey) == 2 and len(own) == 2 and "stop of the first" not in p.lines and p.has("spring closed"), p.lines.keys(), grey, own)
END
ok 'an orbit whose spring closes and opens twice' draw springs orbit "$folder/mixed.ricochet" --branch 7 --energy 20
seen 'openings are named apart from impacts' springs <<'END'
check(p.has("impact, closing") and p.has("opening") and p.has("contact closed"), p.texts)
END
seen 'each of four events of springs has an upright line' springs <<'END'
times = {line[0][0] for line in p.lines["grid"]}
check(len(times) == 6, times) # 0 closing stop, -1, 2, its opening, 1, and the stop again
END

untouched() { # BRANCH...
    local branch
    for branch; do
        for point in 3 6 9 12; do
            draw untouched orbit "$folder/mixed.ricochet" --branch "$branch" --point $point || return 1
            ! grep '>touch<' "$folder/untouched.svg" || return 1
        done
    done
}
ok 'the impact at the end of a flight is no touch besides' untouched 3 7
sed -e 's/energy: .*/energy: [0, 5.0e+6]/; s/frequency: .*/frequency: [200, 10000]/; s/\[\[9, -1\], \[-1, 1\]\]/[[9.0e+6, -1.0e+6], [-1.0e+6, 1.0e+6]]/' \
    -e '/^names:/,$d' examples/elementary/study.yaml >"$folder/quick.yaml"
atlas quick "$folder/quick.yaml"
ok 'speeds of four digits in portraits' draw quick orbits "$folder/quick.ricochet" --branch 'S2+[01]'
seen 'and their titles stay out of the panel before' quick <<'END'
right = max(x for line in p.lines["grid"] for x, y in line) # the end of the period
titles = [x for x, y, text, size in p.texts if text == "v_1"]
check(p.has("1000") and len(titles) == 5 and min(titles) > right + 12, titles, right)
END

# --------------------------------------------------------------------- axes
ok 'a large picture' draw large fep "$folder/two.ricochet" --size 2400x1680 --labels none --linear-frequency
seen 'has tics and numbers up to the end of its axis' large <<'END'
numbers = {text for x, y, text, size in p.texts if x < 68}
tics = [line for line in p.lines["axes"] if line[0][0] == 68 and line[0][1] == line[1][1] and abs(line[1][0] - 68) < 10]
check({"0.4", "10.0", "10.4"} <= numbers and min(line[0][1] for line in tics) < 60, numbers, tics[-3:])
END

# ------------------------------------------------------------------- labels
ok 'letters of springs in a word, and minus signs' draw labels fep "$folder/mixed.ricochet"
seen 'a word with openings is set as one' labels <<'END'
check(p.has("A_3[0−121]"), p.texts)
END
cp "$folder/two.ricochet" "$folder/renamed.ricochet"
python3 -S - "$folder/renamed.ricochet" <<'END'
import sqlite3, sys
db = sqlite3.connect(sys.argv[1])
for old, new in ("C1_31", "C21?"), ("C1_32", "C77_21?"), ("G1_0,2", "Free text [x]"):
    db.execute("UPDATE junction SET label = ?, name = '' WHERE label = ?", [new, old])
for old, new in ("S2-[01]", "S2(7)[01]"), ("S2+[01]", "S2^{3(8)}[01]"):
    db.execute("UPDATE branch SET label = ? WHERE label = ?", [new, old])
db.commit()
END
tools/attack/atlas_digest.py "$folder/renamed.ricochet" >/dev/null
ok 'labels of every form' draw forms fep "$folder/renamed.ricochet" --labels all
seen 'have their indices set as such' forms <<'END'
texts = [t[2] for t in p.texts]
check({"C_21?", "21?", "(7)", "3(8)", "Free text [x]", "S_6 minimum"} <= set(texts)
      and not any(t in text for text in texts for t in ("C21?", "C77", "S2(", "S2^", "\\")), texts)
END

# --------------------------------------------------- the picture by itself
# Of the two masses one branch goes up to 10 rad/s, all others lie below 2.2.
ok 'a picture without any option' draw plain fep "$folder/two.ricochet"
seen 'shows all branches, and says which scales it chose' plain <<'END'
curves = [point for name in p.lines if name.endswith(("stable", "unstable")) for line in p.lines[name] for point in line if point[1] < 0.87 * p.height]
low = sum(y > 0.3 * p.height for x, y in curves) / len(curves) # the part below the break
titles = {t[2] for t in p.texts}
check(any(t.startswith("frequency ω (rad/s), logarithmic above 1.") for t in titles) and "scaled energy E, logarithmic" in titles and low > 0.6,
      titles, low)
END
draw linear fep "$folder/two.ricochet" --linear-frequency --log
seen 'scales that were asked for are not told' linear <<'END'
check(p.has("frequency ω (rad/s)") and p.has("scaled energy E") and p.has("10"), p.texts)
END
# A beam of which mode 1 has no more than its touch, the branches of mode 3 lie between 9 and 10 rad/s, and modes 2, 4 and 5 do nothing.
atlas beam examples/beam-midspan/study.yaml
ok 'frequencies far apart' draw cut fep "$folder/beam.ricochet"
cp "$folder/message" "$folder/left-out"
seen 'are drawn in pieces, with numbers of their own, and what is left out is said' cut <<'END'
solved = [y for name in p.lines if name.endswith(("stable", "unstable")) and "linear" not in name for line in p.lines[name] for x, y in line if y < 0.75 * p.height]
check(p.has("1.005") and p.has("9.2") and p.has("9.8") and not p.has("ω_2") and max(solved) - min(solved) > 0.4 * p.height, p.texts, min(solved), max(solved))
END
ok 'with their number' grep -q 'linear modes touch no contact in the windows and are not shown, at 4 to 25 rad/s' "$folder/left-out"
draw uncut fep "$folder/beam.ricochet" --linear-frequency
seen 'but not where a scale was asked for' uncut <<'END'
check(p.has("ω_2") and p.has("8") and not p.has("9.2"), p.texts)
END
ok 'energies that begin at zero' draw zero fep "$folder/two.ricochet" --energy 0:5
seen 'are on a linear axis' zero <<'END'
check(p.has("scaled energy E") and p.has("0"), p.texts)
END
atlas base examples/fractal-base/study.yaml
draw crowd fep "$folder/base.ricochet" --labels none
cp "$folder/message" "$folder/crowded"
draw whole fep "$folder/base.ricochet" --labels none --marks all
draw bare fep "$folder/base.ricochet" --labels none --marks none
marks() { grep -c '<polygon' "$folder/$1.svg"; }
count() { # COUNT in the legend and in the message
    local told
    told=$(sed -n 's/^ricochet: \([0-9]*\) junctions are not marked.*/\1/p' "$folder/crowded")
    echo "$told told"
    [ -n "$told" ] && grep -q ">$told more junctions not marked<" "$folder/crowd.svg"
}
ok 'junctions that would hide their curve are counted in the legend' count
ok 'few marks, all, or none' sh -c 'echo "$@"; test "$1" -lt "$2" && test "$3" -eq 0' sh "$(marks crowd)" "$(marks whole)" "$(marks bare)"

# ------------------------------------------------------- curves, not chords
# Energies and frequencies between stored points are solved anew, and looked for on the curve that is drawn.
close_curve() { # LABEL E0:E1 F0:F1
    "$ricochet" plot fep "$folder/two.ricochet" --branch "$1" --energy "$2" --frequency "$3" --linear --linear-frequency --labels none \
        --marks none -o "$folder/curve.svg" || return 1
    python3 -S - "$ricochet" "$folder" "$1" "$2" "$3" <<'END'
import json, subprocess, sys
from picture import *
program, folder, label, energies, frequencies = sys.argv[1:]
ask = lambda *words: json.loads(subprocess.run([program, words[0], folder + "/two.ricochet", *words[1:], "--json"], capture_output=True, check=True).stdout)
branch = str(next(b["id"] for b in ask("branches") if b["label"] == label))
points = ask("points", "--branch", branch)
p = Picture(folder + "/curve.svg")
frame = p.lines["axes"][0]
def scale(text, value, low, high):
    a, b = map(float, text.split(":"))
    return low + (high - low) * (value - a) / (b - a)
place = lambda e, f: (scale(energies, e, frame[0][0], frame[1][0]), scale(frequencies, f, frame[0][1], frame[2][1]))
pieces = [piece for name in p.lines if name.endswith(("stable", "undecided")) for line in p.lines[name] if line[0][1] <= frame[0][1]
          for piece in zip(line, line[1:])]
worst = tried = 0
for a, b in zip(points, points[1:]):
    p0, p1 = place(a["energy"], a["frequency"]), place(b["energy"], b["frequency"])
    across = abs(p1[0] - p0[0]) > abs(p1[1] - p0[1])
    if dist(p0, p1) < 4:
        continue
    middle = (["--energy", repr((a["energy"] + b["energy"]) / 2)] if across else ["--frequency", repr((a["frequency"] + b["frequency"]) / 2)])
    for orbit in ask("orbit", "--branch", branch, *middle):
        at = place(orbit["energy"], orbit["frequency"])
        if frame[0][0] < at[0] < frame[1][0] and frame[2][1] < at[1] < frame[0][1]:
            tried += 1
            worst = max(worst, min(distance(at, piece) for piece in pieces))
print(tried, "orbits, at most", worst, "pixels beside the curve")
check(tried > 5 and worst < 0.1)
END
}
ok 'orbits between stored points lie on the curve' close_curve 'A4[0101]' 27:82 1.66:1.683
ok 'around a fold, too' close_curve 'S2-[01]' 1.8:3 2.1:3.4
ok 'an orbit with round portraits' draw round orbit "$folder/mixed.ricochet" --branch 3 --energy 20
seen 'has no corner in them that is seen' round <<'END'
from math import atan2, pi, remainder
# the loop of the second mass: one closed line in the lower right panel
loop = max((line for line in p.lines["portrait of the second"] if min(q[0] for q in line) > 0.66 * p.width and min(q[1] for q in line) > 0.5 * p.height), key=len)
turns = [abs(remainder(atan2(c[1] - b[1], c[0] - b[0]) - atan2(b[1] - a[1], b[0] - a[0]), 2 * pi)) for a, b, c in zip(loop, loop[1:], loop[2:])]
check(max(turns) < 0.06, len(loop), max(turns))
END

# -------------------------------------------------------------------- units
# Half a clearance: lengths are halved, energies a quarter; the same curves with other numbers at the axes.
sed 's/clearance: *1\(\.0\)*/clearance: 0.5/' examples/elementary/study.yaml >"$folder/half.yaml"
atlas half "$folder/half.yaml"
window=(--log --linear-frequency --labels none)
ok 'a window in scaled units' draw scaled fep "$folder/half.ricochet" "${window[@]}" --energy 1:16 --frequency 0.8:3
ok 'the same one in those of the study and in Hz' draw physical fep "$folder/half.ricochet" "${window[@]}" --physical --hz --energy 0.25:4 \
    --frequency "$(python3 -S -c 'from math import pi; print(f"{0.8 / 2 / pi!r}:{3 / 2 / pi!r}")')"
seen 'has the same curves, and other numbers' physical <<END
import math
q = Picture("$folder/scaled.svg")
close = lambda a, b: len(a) == len(b) and all(math.dist(u, v) < 0.05 for s, t in zip(a, b) for u, v in zip(s, t))
names = [name for name in p.lines if "stable" in name]
check(names and all(close(p.lines[n], q.lines[n]) for n in names) and p.has("frequency f (Hz)") and p.has("energy E, in units of the study")
      and p.has("0.5") and not p.has("10") and q.has("10") and p.has("f_1") and q.has("ω_1"), names, p.texts)
END
ok 'an orbit in units of the study' draw units orbit "$folder/half.ricochet" --branch 3 --energy 0.75 --physical --hz
seen 'says so in its title, and has its stop at half a clearance' units <<'END'
title = next(t[2] for t in p.texts if "E = " in t[2])
check("E = 0.75," in title and title.count(" Hz") == 1 and p.has("displacement"), title)
END
refuses() { # ARGUMENTS...: of plot
    "$ricochet" plot "$@" -o "$folder/refused.svg" 2>"$folder/message"
    [ $? = 2 ] && cat "$folder/message" && [ ! -e "$folder/refused.svg" ]
}
ok 'two units of length in one picture are refused' refuses fep "$folder/half.ricochet" "$folder/two.ricochet" --physical
ok 'a picture in units of the study refuses them' refuses law "$folder/half.ricochet" --hz
for picture in "sheet $folder/half.ricochet --segment 3 --orbits 5" "sheet $folder/half.ricochet --segment 3 --orbits 5 --space x1,x2,v2" \
    "strobe $folder/half.ricochet --segment 3 --orbits 5" "section $folder/half.ricochet --energy 1.25 --starts 4 --impacts 50"; do
    ok "plot ${picture%% *} has units" draw units $picture --physical --hz
    seen 'and other numbers with them' units <<'END'
texts = {t[2] for t in p.texts}
check(not any("rad/s" in t or "ω" in t for t in texts), texts)
END
done

# -------------------------------------------------------------------- print
ok 'letters of 12 points' draw print fep "$folder/two.ricochet" --font 12
seen 'are a third larger, in a picture of the same size' print <<'END'
sizes = {t[3] for t in p.texts}
check((p.width, p.height) == (740, 500) and 16.0 in sizes and min(sizes - {max(sizes)}) > 11.5, sizes)
END
# Letters of a journal: 7 points on two columns, 174 mm; of an index raised or lowered 5. Nobody gives a size.
for picture in "fep $folder/two.ricochet --zoom 1:3,1:1.7 --zoom 1:9,1.6:1.7" "orbit $folder/two.ricochet --junction C1_32" \
    "orbits $folder/two.ricochet --orbit C1_32 --orbit G1_2,4 --histories --columns 3" "sheet $folder/two.ricochet --segment S2-[01]" \
    "cascade $folder/two.ricochet --branch 3 --circle" "floquet $folder/two.ricochet --branch 3"; do
    draw letters $picture
    seen "printed on 174 mm the letters of plot ${picture%% *} have 7 points and more" letters <<'END'
points = [t[3] * 174 / 25.4 * 72 / p.width for t in p.texts]
check(points and min(points) > 5 and all(size >= 7 or len(t[2]) < 6 for size, t in zip(points, p.texts)), p.width, sorted(points)[:8])
END
done
seen 'no study has its title in a picture' print <<'END'
check(not p.has("Two masses with symmetric stops"), p.texts)
END
dots() { # FILE: width and height of a PNG
    python3 -S -c 'import struct, sys
print(*struct.unpack(">II", open(sys.argv[1], "rb").read(24)[16:]))' "$1"
}
ok 'twice the dots' "$ricochet" plot fep "$folder/two.ricochet" --dpi 192 -o "$folder/dots.png"
ok 'make a PNG of twice the size' test "$(dots "$folder/dots.png")" = '1480 1000'
ok 'dots go with PNG only' refuses fep "$folder/two.ricochet" --dpi 192
ok 'letters that fill the page are refused' refuses fep "$folder/two.ricochet" --font 48 --size 500x400
ok 'the script of gnuplot' env PATH=/nowhere "$ricochet" plot fep "$folder/two.ricochet" --font 12 -o "$folder/print.gp"
by_hand() {
    gnuplot "$folder/print.gp" >"$folder/hand.svg" && python3 -S - "$folder" <<'END'
import sys
from picture import *
p, q = (Picture(f"{sys.argv[1]}/{name}.svg") for name in ("hand", "print"))
check([t[2] for t in p.texts] == [t[2] for t in q.texts] and {n: len(l) for n, l in p.lines.items() if n in q.lines} == {n: len(l) for n, l in q.lines.items()},
      len(p.texts), len(q.texts))
END
}
ok 'needs no gnuplot, and draws the same picture with it' by_hand

# ------------------------------------------------------------------ panels
ok 'a panel without a letter and one with another' draw letters fep "$folder/two.ricochet" --zoom 0.57:0.63,0.9:1.02 --letters ,c \
    --label C1_31 --label C1_32 --label 'S2-[01]'
seen 'are lettered so' letters <<'END'
names = [t[2] for t in p.texts if t[2].startswith("(")]
check(names == ["(c)", "(c)"], names)  # the zoom, and its window in the first panel
END
seen 'what a zoom shows has its label there' letters <<'END'
places = {index: [t[0] > p.width / 2 for t in p.texts if t[2] == index and t[3] < 10] for index in ("31", "32")}
check(places == {"31": [True], "32": [False]}, places, p.texts)
END
ok 'a strobe with segments of equal width' draw strobe strobe "$folder/two.ricochet" --segment '2:S2+[01]|C1_31 C1_32' \
    --segment 'S2+[01]|C1_32 G1_2,4' --orbits 40 --samples 4 --stretch
seen 'says what each passes' strobe <<'END'
check(p.has("2 periods, 0.21 rad/s") and p.has("1 period, 0.285 rad/s"), p.texts)
END

# ------------------------------------------------------------------ colours
ok 'six atlases in a picture' draw six fep "$folder/two.ricochet" --branch 1 "$folder/two.ricochet" --branch 2 "$folder/two.ricochet" --branch 3 \
    "$folder/two.ricochet" --branch 4 "$folder/two.ricochet" --branch 5 "$folder/two.ricochet" --branch 6 --marks none --labels none
seen 'are told apart by a colour-blind reader, and in grey print' six <<'END'
far, grey = apart([colour for name, colour in p.colours.items() if name.startswith("atlas") and name.endswith(", stable")])
print(p.colours, far, grey)
check(len(far) == 4 and min(far.values()) > 25 and grey > 8)
END
ok 'two atlases with the same key' draw same fep "$folder/two.ricochet" --branch 1 --key one "$folder/two.ricochet" --branch 3 --key one
seen 'share a colour' same <<'END'
check("atlas 2, stable" not in p.lines and [t[2] for t in p.texts].count("one") == 1, p.lines.keys())
END
ok 'a frame, and marks that are asked for' draw framed fep "$folder/two.ricochet" --marks asked --label C1_32 --frame 'here: 1:4,1:1.5'
seen 'are all that is drawn' framed <<'END'
check(p.has("here") and "window of a zoom" in p.lines and not p.has("grazing") and p.has("branch point"), p.texts)
END
seen 'so are the kinds of branches' plain <<'END'
far, grey = apart([p.colours[kind + ", stable"] for kind in ("symmetric", "asymmetric", "linear")])
check(min(far.values()) > 40 and grey > 10, far, grey)
END
ok 'a branch that loses its stability at a branch point, of which a point is stored' draw loses fep "$folder/two.ricochet" \
    --branch 'S6[010101]' --energy 20:30 --frequency 1.665:1.69 --linear --linear-frequency --labels none --marks none
seen 'is thick up to there' loses <<'END'
frame = p.lines["axes"][0]
end = frame[0][0] + (frame[1][0] - frame[0][0]) * (22.98740319908 - 20) / 10
thick = max(x for line in p.lines["symmetric, stable"] for x, y in line if y < frame[0][1])
check(abs(thick - end) < 0.5, thick, end)
END
ok 'a duplicate with a stable part' draw dashed fep "$folder/two.ricochet" --branch 'S2-[01]' --duplicates 3
seen 'is thick where it is stable, thin where it is not' dashed <<'END'
thick, thin = (p.lines.get("symmetric, %s, duplicate" % word) for word in ("stable", "unstable"))
check(thick and thin and p.has("duplicate, symmetric"), p.lines.keys())
END

# ------------------------------------------------ islands, proofs, arrows
cat >"$folder/island.yaml" <<'END'
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], clearance: 1.0, sides: both, law: rigid}
explore: {energy: [0, 20], frequency: [0.9, 4], impacts: 5, multiply: 1, depth: 2}
END
atlas island "$folder/island.yaml"
draw land fep "$folder/island.ricochet"
"$ricochet" hunt "$folder/island.ricochet" --energy 5 --impacts 3 --lines 4000 --rows 10 --row 200 --random 3000 --add >"$folder/log" 2>&1
atlas island "$folder/island.yaml"
ok 'an atlas with an island, and with proofs of a branch' sh -c '"$1" prove "$2/island.ricochet" --branch 3 >"$2/proved" 2>&1; test $? != 2' \
    sh "$ricochet" "$folder"
draw sea fep "$folder/island.ricochet"
seen 'has a band under the island, and under nothing else' sea <<END
q = Picture("$folder/land.svg")
band = [line for line in p.lines["island"] if len(line) > 2]
low = min(y for line in band for x, y in line)
own = [line for name in p.lines if name == "asymmetric, unstable" for line in p.lines[name] if len(line) > 2]
check("island" not in q.lines and len(band) == len(own) and p.has("island: linked to no linear mode"), len(band), len(own))
END
if "$ricochet" --version | grep -q FLINT || grep -q ' points proved' "$folder/proved"; then
    seen 'and rings at points with a proof' sea <<'END'
said = [t[2] for t in p.texts if t[2].startswith("proved: ")]
check(len(p.lines.get("proved", [])) > 20 and len(said) == 1 and " points, 0 of " in said[0], said)
END
fi
ok 'duplicates with what they inherit' draw arrows fep "$folder/two.ricochet" --branch 'S2-[01]' --duplicates 6 --arrows --log-frequency \
    --energy 1.7:20 --frequency 0.2:10
seen 'have upright arrows from the 3-duplicate to the 6-duplicate' arrows <<'END'
shafts = [line for line in p.lines["inherited"] if len(line) == 2 and line[0][0] == line[1][0]]
check(shafts and all(line[1][1] > line[0][1] for line in shafts) and p.has("inherited"), p.lines["inherited"])
END
ok 'arrows go with duplicates' refuses fep "$folder/two.ricochet" --arrows

# ------------------------------------------------------- space and overlays
ok 'a curve in space' draw space curves "$folder/two.ricochet" --x energy --y x1 --z x1 --branch 3
seen 'lies over its shadow, and rises with it' space <<'END'
curve = [q for name in p.lines if name.startswith("symmetric, ") for line in p.lines[name] if len(line) > 2 for q in line]
shade = [q for line in p.lines["shadow"] for q in line]
under = [min(shade, key=lambda s: abs(s[0] - q[0])) for q in curve]
check(len(curve) > 20 and all(s[1] > q[1] - 0.5 for q, s in zip(curve, under)), len(curve))
END
ok 'a window of three axes has three ranges' refuses curves "$folder/two.ricochet" --x energy --y x1 --z v1 --window 1:2,0:1
ok 'a view is two angles' refuses curves "$folder/two.ricochet" --x energy --y x1 --z v1 --view 10
ok 'a part of a branch in the phase space' draw surface sheet "$folder/two.ricochet" --segment 'up: S2+[01]' --space x1,x2,v2 --orbits 9
seen 'is shaded by energy from end to end' surface <<'END'
check({"shade 1", "shade 15"} <= set(p.lines) and p.has("up") and p.has("v_2"), p.lines.keys())
END
ok 'coordinates that are not there' refuses sheet "$folder/two.ricochet" --segment 3 --space x1,x2,v3
ok 'orbits over one another' draw over orbits "$folder/two.ricochet" --orbit 'S2+[01]@E=1' --orbit 'two: S2+[01]@E=4' --overlay --gap
seen 'begin in phase: both gaps are 1 at a quarter of the period' over <<'END'
frame = [line for line in p.lines["axes"] if len(line) > 3]
gap = max((f for f in frame if f[0][0] < 100), key=lambda f: f[0][1])
left, right, top = gap[0][0], gap[1][0], gap[2][1]
tips = [min((q for line in p.lines[name] for q in line if left <= q[0] <= right and top <= q[1] <= gap[0][1]), key=lambda q: q[1])
        for name in ("first of several", "second of several")]
check(all(abs((x - left) / (right - left) - 0.25) < 0.01 for x, y in tips) and len(p.lines["stop"]) >= 2, tips)
END
sed 's/depth: 2/depth: 1/' examples/power-3/study.yaml >"$folder/cubic.yaml"
atlas cubic "$folder/cubic.yaml"
draw springs fep "$folder/cubic.ricochet" --labels none
seen 'the energy of springs is H' springs <<'END'
check(any(t[2].startswith("scaled energy H") for t in p.texts), p.texts)
END

# ------------------------------------------------------- motions and measurements
for motion in motion shaken; do
start=(--state 0.1 -0.2 0 2.5 --time 20)
[ "$motion" = motion ] || start+=(--force 1,0 --omega 1.2 --level 0.4 --phase 0.3 --damping 0.02 --restitution 0.9)
"$ricochet" simulate examples/stop-and-spring/study.yaml "${start[@]}" --steps 60 --csv >"$folder/own.csv"
ok "the $motion of a study, with what was measured" draw "$motion" simulate examples/stop-and-spring/study.yaml "${start[@]}" --data "$folder/own.csv"
seen 'goes through all dots, and marks every impact' "$motion" <<END
import json, subprocess
rows = json.loads(subprocess.run(["$ricochet", "simulate", "examples/stop-and-spring/study.yaml", *"${start[*]}".split(), "--impacts", "--json"],
                                 capture_output=True, check=True).stdout)
check_dots = []
for dots, curve, portrait in (("data of the first", "first", "portrait of the first"), ("data of the second", "second", "portrait of the second")):
    pieces = [piece for name in (curve, portrait) for line in p.lines[name] for piece in zip(line, line[1:])]
    check_dots += [min(distance(line[0], piece) for piece in pieces) for line in p.lines[dots]]
lines = {line[0][0] for line in p.lines["grid"]}
check(len(check_dots) > 200 and max(check_dots) < 0.35 and len(lines) == len({row["t"] for row in rows}) > 5, len(check_dots), max(check_dots), len(lines), len(rows))
END
done
ok 'a state of another length is refused' refuses simulate examples/elementary/study.yaml --state 1 2 --time 3
ok 'a motion without an end, too' refuses simulate examples/elementary/study.yaml --state 0 0 1 2
ok 'an orbit in units of the study with data' draw measured orbit "$folder/mixed.ricochet" --branch 3 --energy 20 --data "$folder/own.csv"
printf 'time,x1\n1,2\n' >"$folder/bare.csv"
ok 'data without times are refused' refuses orbit "$folder/mixed.ricochet" --branch 3 --energy 20 --data "$folder/bare.csv"
"$ricochet" points "$folder/two.ricochet" --branch 3 --csv >"$folder/points.csv"
ok 'points of a branch as data of a curve' draw points curves "$folder/two.ricochet" --x energy --y period --branch 3 --data "$folder/points.csv"
seen 'lie on it' points <<'END'
pieces = [piece for name in p.lines if name.startswith("symmetric") for line in p.lines[name] for piece in zip(line, line[1:])]
far = max(min(distance(line[0], piece) for piece in pieces) for line in p.lines["data"] if len(line) == 2 and dist(*line) < 1)
check(far < 0.1 and p.has("points.csv"), far)
END

# ----------------------------------------------------------- laws and models
# The force at s = 1.2 clearances, read off the picture, is that of the study: 10^4 (s - 1) and s^3.
ok 'the laws of a spring beyond a gap, of a power and of a stop' draw law law examples/bilinear/study.yaml --key soft examples/power-3/study.yaml \
    --key cubic examples/elementary/study.yaml --key stop
seen 'have the forces of the study' law <<'END'
frames = [line for line in p.lines["axes"] if len(line) > 3]
def force(name, frame, s):
    (left, bottom), (right, _), (_, top) = frame[:3]
    x = (left + right) / 2 + s / 1.6 * (right - left) / 2
    line = next(line for line in p.lines[name] if len(line) > 2 and left - 1 < line[0][0] < right + 1)
    y = next(b[1] + (a[1] - b[1]) * (b[0] - x) / (b[0] - a[0]) for a, b in zip(line, line[1:]) if a[0] <= x <= b[0] and a[0] < b[0])
    return ((bottom + top) / 2 - y) / ((bottom - top) / 2)
soft, cubic = force("first of several", frames[0], 1.2), force("second of several", frames[1], 1.2)
stop = [x for line in p.lines["third of several"] for x, y in line]
check(len(frames) == 2 and abs(soft - 0.2 / 0.4) < 0.01 and abs(cubic - 1.2**3 / 1.4**3) < 0.01 and p.has("cubic") and len(stop) > 6, soft, cubic)
END
ok 'a chain with a wall and a gap' draw chain model examples/three-masses/study.yaml
seen 'has its masses, springs, walls and stops' chain <<'END'
springs = [line for line in p.lines["part"] if len(line) == 12]
texts = {"m = 1.5", "m = 1", "m = 0.8", "k = 4", "k = 1", "k = 2", "k = 3", "wall:  s = x_1,  closes at 1,  rigid", "gap:  s = x_3 − x_2,  closes at ±0.7,  rigid"}
check(len(springs) == 4 and texts <= {t[2] for t in p.texts}, len(springs), [t[2] for t in p.texts])
END
# digits MASS...: a chain of masses and springs with such numbers, and its picture
digits() {
    python3 -S - "$@" >"$folder/digits.yaml" <<'END'
import sys
m, n = sys.argv[1:], len(sys.argv) - 1
rows = lambda at: "[" + ", ".join("[" + ", ".join(at(i, k) for k in range(n)) + "]" for i in range(n)) + "]"
print("model:\n  mass:", rows(lambda i, k: m[i] if i == k else "0"))
print("  stiffness:", rows(lambda i, k: str(2 * 1.2345e4) if i == k else "-1.2345e4" if abs(i - k) == 1 else "0"))
print("  contacts: [{normal: [" + ", ".join(["1"] + ["0"] * (n - 1)) + "], clearance: 1, sides: both, law: rigid}]")
END
    draw digits model "$folder/digits.yaml"
}
for masses in '1.188 12.34' '1.188 1.188e-5 1.188e5 100 1 2' '1.188 1.188e-5 1.188e5 100 1 2 3 4 5 6'; do
    ok "masses $masses" digits $masses
    seen 'stand in their boxes, and beside them what springs have' digits <<'END'
boxes = [line for line in p.lines["part"] if len(line) == 5]
edges = sorted((min(x for x, y in b), max(x for x, y in b)) for b in boxes)
def wide(text, size): return 0.52 * size * len(text)
inner = [t for t in p.texts if any(lo < t[0] < hi for lo, hi in edges) and min(y for x, y in boxes[0]) < t[1] < max(y for x, y in boxes[0])]
numbers = [t for t in inner if not t[2].startswith("x")]
check(len(numbers) == len(boxes) and all(wide(t[2], t[3]) < edges[0][1] - edges[0][0] for t in numbers), edges, inner)
between = edges[1][0] - edges[0][1]
springs = [t for t in p.texts if "2345" in t[2].replace(".", "")]
check(springs and all(wide(t[2], t[3]) < between for t in springs), between, springs)
END
done
cat >"$folder/middle.yaml" <<'END'
model:
  mass: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
  stiffness: [[250, -100, 0], [-100, 450.25, -100], [0, -100, 200]]
  contacts: [{normal: [0, 1, 0], clearance: 1}]
END
ok 'a mass in the middle with a spring to the ground and two stops' draw middle model "$folder/middle.yaml"
seen 'has its spring apart from its number and its stops' middle <<'END'
spring = next(l for l in p.lines["part"] if len(l) == 12 and abs(l[0][0] - l[-1][0]) < 0.1)
low, high = (tuple(pick(q[i] for q in spring) for i in (0, 1)) for pick in (min, max))
inside = [q for l in p.lines["part"] if l is not spring for q in l if low[0] - 3 < q[0] < high[0] + 3 and low[1] + 1 < q[1] < high[1] - 1]
x, _, text, size = next(t for t in p.texts if t[2] == "k = 250.2")
anchor = next(g.get("text-anchor") for g in p.root.iter() if "translate(%.2f" % x in (g.get("transform") or ""))
check(not inside and x + (0 if anchor == "end" else 0.26 * size * len(text)) < low[0] - 2, inside, x, anchor, low)
END
ok 'a structure with nodes' draw nodes model examples/arm/study.yaml
seen 'is drawn from them' nodes <<'END'
line = sorted({q for l in p.lines["member"] for q in l})
check(len(line) == 6 and all(abs(q[1] - line[0][1]) < 0.01 for q in line) and p.has("x_9") and not p.has("m = 1"), line)
END
ok 'a stiffness that is not of springs is said to be none' sh -c '"$1" plot model examples/two-walls/study.yaml -o "$2/walls.svg" 2>&1 |
    grep -q "not that of springs"' sh "$ricochet" "$folder"

# ------------------------------------------------------------------ own data
"$ricochet" points "$folder/half.ricochet" --branch 3 --physical --csv >"$folder/own.csv" # has both columns, and others
ok 'points of a branch as data in physical units' draw own fep "$folder/half.ricochet" --physical --branch 3 --data "$folder/own.csv" --marks none --labels none
seen 'lie on the branch, each of them' own <<'END'
dots = [line[0] for line in p.lines["data"] if len(line) == 2 and abs(line[1][0] - line[0][0]) < 1]
pieces = [piece for name in p.lines if name.startswith("symmetric") for line in p.lines[name] for piece in zip(line, line[1:])]
far = max(min(distance(d, piece) for piece in pieces) for d in dots)
check(len(dots) > 30 and far < 0.1 and p.has("own.csv"), len(dots), far)
END
printf 'frequency,energy\n1.5,20\n1.6,much\n' >"$folder/bad.csv"
ok 'data that are no numbers are refused by their line' refuses fep "$folder/two.ricochet" --data "$folder/bad.csv"
ok 'and told' grep -q 'bad.csv:3:' "$folder/message"
printf '1.5,20\n' >"$folder/bare.csv"
ok 'data without names of columns are refused' refuses fep "$folder/two.ricochet" --data "$folder/bare.csv"
ok 'a file that is not there, too' refuses fep "$folder/two.ricochet" --data "$folder/nowhere.csv"

ok 'all pictures were looked at' all_seen
claims "$folder/seen"
finish
