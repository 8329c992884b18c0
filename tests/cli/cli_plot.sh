#!/bin/sh
# Every picture in every format, and that a failure leaves no file behind.
# usage: RICOCHET=path/to/ricochet tests/cli/cli_plot.sh [ATLAS]      (or: tests/cli/cli_plot.sh RICOCHET ATLAS)
# Without an atlas it makes a small one. Exit: 0 passed, 1 failed, 77 skipped.
set -u
if [ $# -ge 2 ]; then
    RICOCHET=$1
    shift
fi
ATLAS=${1:-${ATLAS:-}}
RICOCHET=${RICOCHET:-ricochet}
if ! command -v gnuplot >/dev/null 2>&1; then
    echo "cli_plot.sh: skipped, gnuplot is not installed"
    exit 77
fi
RICOCHET=$(command -v "$RICOCHET") || { echo "cli_plot.sh: no program ricochet"; exit 1; }
RICOCHET=$(cd "$(dirname "$RICOCHET")" && pwd)/$(basename "$RICOCHET")
[ -z "$ATLAS" ] || ATLAS=$(cd "$(dirname "$ATLAS")" && pwd)/$(basename "$ATLAS")
TOP=$PWD
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
if [ -z "$ATLAS" ]; then
    cat >study.yaml <<'END'
title: Two masses with symmetric stops
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], clearance: 1.0, sides: both, law: rigid}
explore: {energy: [0, 5], frequency: [0.5, 4], impacts: 2, multiply: 1, depth: 1}
END
    ATLAS=$work/small.ricochet
    if ! "$RICOCHET" run study.yaml -o "$ATLAS" >run.out 2>&1; then
        cat run.out
        echo "cli_plot.sh: the atlas to draw could not be made"
        exit 1
    fi
fi
passed=0
failed=0

note() { # note TEXT GOOD
    if [ "$2" = 0 ]; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
        echo "FAILED: $1"
        [ -s stderr ] && sed 's/^/    /' stderr
    fi
}

# exits CODE ARGUMENTS...: the exit code, silence on stdout, and a message exactly when it failed
exits() {
    want=$1
    shift
    "$RICOCHET" "$@" >stdout 2>stderr
    got=$?
    [ $got -eq "$want" ]
    note "'$*' exits $got instead of $want" $?
    [ ! -s stdout ]
    note "'$*' printed on stdout" $?
    if [ "$want" -ne 0 ]; then
        [ -s stderr ]
        note "'$*' gave no message" $?
    fi
}

# is_a FORMAT FILE: the right kind of file, whole from head to tail. Pictures as SVG are looked at in the end, by one process.
mkdir svg
drawn=0
is_a() {
    case $1 in
    svg) [ -s "$2" ] && drawn=$((drawn + 1)) && ln "$2" "svg/$drawn" ;; # what is drawn there next is another file
    pdf) [ "$(head -c 5 "$2")" = '%PDF-' ] && tail -c 16 "$2" | grep -q '%%EOF' ;;
    png) [ "$(head -c 4 "$2" | tail -c 3)" = PNG ] && tail -c 8 "$2" | head -c 4 | grep -q IEND ;;
    esac
}

# draws NAME ARGUMENTS...: as SVG, and the first picture of each kind in all formats, of which one line of the script for
# gnuplot decides; in the long form every picture
kinds=
draws() {
    name=$1
    shift
    formats=svg
    case $kinds in *" $2 "*) ;; *) formats='svg pdf png' ;; esac
    kinds="$kinds $2 "
    [ "${RICOCHET_TEST_LONG:-0}" = 0 ] || formats='svg pdf png'
    for format in $formats; do
        exits 0 "$@" -o "$name.$format"
        is_a $format "$name.$format" 2>/dev/null
        note "$name.$format is not a whole $format" $?
        note "$name.$format is suspiciously small" "$([ "$(wc -c <"$name.$format" 2>/dev/null || echo 0)" -gt 2000 ]; echo $?)"
    done
}

# leaves_nothing CODE ARGUMENTS...: fails without a file, not even a temporary one
leaves_nothing() {
    mkdir empty
    exits "$@"
    rmdir empty 2>rest # of an empty folder only
    note "'$*' left files: $(cat rest)" $?
    rm -rf empty
}

draws fep plot fep "$ATLAS"
draws fep-linear plot fep "$ATLAS" --linear --size 700x500 --labels all
draws fep-plain plot fep "$ATLAS" --labels none --title "it's a_{test} <&> \"quoted\" ~ \\ @ 100%"
draws fep-ghosts plot fep "$ATLAS" --ghosts
exits 2 plot "$ATLAS"
note "an atlas without a picture is told the one of it" "$(grep -qF "ricochet plot fep $ATLAS -o fep.svg" stderr; echo $?)"
red='#[eE]3122[dD]\|rgb( *227, *18, *45)' # only ghosts have it
note "ghosts are not in the picture" "$(grep -q "$red" fep-ghosts.svg && grep -q 'ghost' fep-ghosts.svg; echo $?)"
note "there are ghosts that nobody asked for" "$(! grep -q "$red" fep.svg; echo $?)"
exits 0 plot fep "$ATLAS" --ghosts --energy 1.8:4 --frequency 2.5:4 -o away.svg
note "ghosts outside of the window" "$(! grep -q 'ghost: no motion' away.svg; echo $?)"
draws orbit plot orbit "$ATLAS" --branch 1 --point 0
draws junction plot orbit "$ATLAS" --junction 1 --coordinates 1
draws tiny plot orbit "$ATLAS" --branch 1 --energy 1e-6
note "an axis of tiny numbers names their power of ten" "$(grep -q '0\.000[1-9]' tiny.svg; [ $? = 1 ] && grep -q 'displacement / 10<' tiny.svg; echo $?)"
cat >five.yaml <<'END'
model:
  mass: [[1, 0, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 1]]
  stiffness: [[2, -1, 0, 0, 0], [-1, 2, -1, 0, 0], [0, -1, 2, -1, 0], [0, 0, -1, 2, -1], [0, 0, 0, -1, 2]]
  contacts:
    - {normal: [0, 0, 0, 0, 1], clearance: 1.0, sides: both, law: rigid}
explore: {start: [1], energy: [0, 5], impacts: 1, multiply: 1, depth: 0}
END
"$RICOCHET" run five.yaml -o five.ricochet >run.out 2>&1
draws five plot orbit five.ricochet --branch 1 --point 0
note "one of five coordinates is left out without a word" \
    "$("$RICOCHET" plot orbit five.ricochet --branch 1 --point 0 -o five.svg 2>&1 >/dev/null | grep -q '4 of 5 coordinates are shown; --coordinates'; echo $?)"
note "what was asked for is said to be left out" \
    "$("$RICOCHET" plot orbit five.ricochet --branch 1 --point 0 --coordinates 5 -o five.svg 2>&1 >/dev/null | grep -c 'are shown')"
draws fep-duplicates plot fep "$ATLAS" --duplicates 3
draws fep-two plot fep "$ATLAS" --key one "$ATLAS" --key two --branch 1
draws fep-zoom plot fep "$ATLAS" --zoom 1.8:4,2.5:4 --zoom 0.6:1,0.9:1 --log-frequency --symmetric --mark 'P1: 1@0.5'
draws orbits plot orbits "$ATLAS" --orbit 1 --orbit 'P1: 1@0.5*2' --same-axes
draws along plot orbits "$ATLAS" --branch 'S2+[01]'
"$RICOCHET" plot orbits "$ATLAS" $(printf -- '--orbit S2+[01]@%s ' 0 0.25 0.5 0.75 1) -o each.svg
note "the orbits of a branch are five from end to end" "$(cmp each.svg along.svg; echo $?)"
leaves_nothing 2 plot orbits "$ATLAS" --branch nowhere -o empty/a.svg
leaves_nothing 2 plot orbits "$ATLAS" --orbit 1 "$ATLAS" --orbit 2 --branch 3 -o empty/a.svg
draws histories plot orbits "$ATLAS" --orbit 1 --orbit 2 --histories --columns 2 --coordinates 2
draws sheet plot sheet "$ATLAS" --segment 3 --orbits 6
draws strobe plot strobe "$ATLAS" --segment 2:3 --orbits 6 --samples 5 --stretch
draws curves plot curves "$ATLAS" --x energy --y frequency
draws curves-log plot curves "$ATLAS" --x energy --y x1 --log x --branch 1
draws floquet plot floquet "$ATLAS" --branch 1
draws curves-unnamed plot curves "$ATLAS" --x energy --y period --labels none
note "curves without names of junctions" "$(grep -q '>G<' curves.svg && ! grep -q '>G<' curves-unnamed.svg; echo $?)"

# A file name is only a name, whatever it looks like.
for name in 'a b.svg' "quote'.svg" '$(touch oops).svg' '| touch oops .svg' '-dash.svg' 'new
line.svg'; do
    "$RICOCHET" plot fep "$ATLAS" "-o=$name" >stdout 2>stderr
    is_a svg "./$name" 2>/dev/null
    note "file name '$name'" $?
done
note "a file name was interpreted" "$([ ! -e oops ]; echo $?)"

# The same picture twice, and an old picture replaced.
"$RICOCHET" plot fep "$ATLAS" -o again.svg 2>stderr
note "the same call gives another picture" "$(cmp -s fep.svg again.svg; echo $?)"
echo old >again.png
exits 0 plot fep "$ATLAS" -o again.png
note "an old file was not replaced" "$(is_a png again.png; echo $?)"

# Wrong calls: 2.
leaves_nothing 2 plot
leaves_nothing 2 plot nonsense "$ATLAS" -o empty/a.svg
leaves_nothing 2 plot cascade "$ATLAS" -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS"
leaves_nothing 2 plot fep -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" -o empty/a
leaves_nothing 2 plot fep "$ATLAS" -o empty/a.jpeg
leaves_nothing 2 plot fep "$ATLAS" -o empty
leaves_nothing 2 plot fep "$ATLAS" --nonsense -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --energy 2:1 -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --log --energy 0:1 -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --frequency x:y -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --break 1e9 -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --log --zoom 0:1,0:1 -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --break 2 --log-frequency -o empty/a.svg
leaves_nothing 2 plot curves "$ATLAS" --x energy --y x1 --window 1:2 -o empty/a.svg
leaves_nothing 2 plot orbits "$ATLAS" -o empty/a.svg
leaves_nothing 2 plot sheet "$ATLAS" --segment 1 --orbits 1 -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --labels some -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --marks some -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --log --linear -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --linear-frequency --break 2 -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --duplicates 0 -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --size 10x10 -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" --size big -o empty/a.svg
leaves_nothing 2 plot orbit "$ATLAS" -o empty/a.svg
leaves_nothing 2 plot orbit "$ATLAS" --branch 1 -o empty/a.svg
leaves_nothing 2 plot orbit "$ATLAS" --branch 1 --point 0 --energy 1 -o empty/a.svg
leaves_nothing 2 plot orbit "$ATLAS" --branch 1 --junction 1 -o empty/a.svg
leaves_nothing 2 plot orbit "$ATLAS" --branch 1 --point 0 --coordinates 0 -o empty/a.svg
leaves_nothing 2 plot orbit "$ATLAS" --branch 1 --point 0 --coordinates 1,,2 -o empty/a.svg
leaves_nothing 2 plot curves "$ATLAS" --x energy -o empty/a.svg
leaves_nothing 2 plot curves "$ATLAS" --x energy --y nonsense -o empty/a.svg
leaves_nothing 2 plot curves "$ATLAS" --x energy --y x0 -o empty/a.svg
leaves_nothing 2 plot curves "$ATLAS" --x energy --y x1 --labels some -o empty/a.svg
leaves_nothing 2 plot floquet "$ATLAS" -o empty/a.svg

# What is in a picture.
shows() { grep -q ">$2</tspan>" "$work/$1"; }
"$RICOCHET" plot fep "$ATLAS" --branch 'S2+[01]' --energy 1.2:4 --log --frequency 1.28:1.48 --size 900x560 -o part.svg
shows part.svg 1.5 && shows part.svg 2.5
note "less than a decade has labels between whole numbers" $?
shows part.svg 'thin: unstable' && ! grep -q undecided part.svg
note "stability changes at the junction itself, with nothing undecided around it" $?
"$RICOCHET" run "$TOP/examples/elementary/study.yaml" -o demo.ricochet >/dev/null 2>&1
"$RICOCHET" plot fep demo.ricochet -o demo.svg 2>/dev/null
"$RICOCHET" points demo.ricochet --branch 13 --csv | cut -d, -f9 | grep -q undecided
note "the demo has an orbit with a multiplier at -1 that is no junction" $?
shows demo.svg 'thin: unstable' && ! grep -q "undecided\|dasharray='0.1,4.4'" demo.svg
note "stability changes at an orbit that is undecided between stable and unstable" $?
"$RICOCHET" plot fep demo.ricochet --energy 0.3:100 --frequency 0.5:4 --frame '(z): 0.59:0.6,0.95:0.951' -o frame.svg 2>/dev/null
python3 -S -c 'import re
path = re.search("dasharray=.4.0,3.0.  d=.M([^z\x27]*)", open("frame.svg").read())[1]
xs, ys = zip(*[map(float, p.split(",")) for p in path.replace("L", "").split()])
raise SystemExit(not (max(xs) - min(xs) > 14 and max(ys) - min(ys) > 14))'
note "a frame has room for what it shows" $?
cp "$ATLAS" lost.ricochet
python3 -S -c 'import sqlite3
db = sqlite3.connect("lost.ricochet")
db.execute("UPDATE point SET stable = 2 WHERE branch = 3 AND point > 32")
db.commit()'
"$TOP/tools/attack/atlas_digest.py" lost.ricochet >/dev/null
"$RICOCHET" plot fep lost.ricochet --key lost demo.ricochet --key demo -o two.svg 2>/dev/null
shows two.svg 'dotted: undecided'
note "what is dotted is told of several atlases, too" $?
"$RICOCHET" plot orbits "$ATLAS" --orbit 'S2+[01]@E=4' -o small.svg
note "no axis has a single number" "$([ "$(grep -c '>−1</tspan>' small.svg)" = 4 ]; echo $?)"

cp "$ATLAS" open.ricochet
python3 -S -c 'import sqlite3
db = sqlite3.connect("open.ricochet")
db.execute("UPDATE junction SET label = label || ? WHERE label = ?", ["?", "C1_31"])
db.execute("UPDATE junction SET name = ?", [""])
db.commit()'
"$TOP/tools/attack/atlas_digest.py" open.ricochet >/dev/null
"$RICOCHET" plot fep open.ricochet --labels all --size 1600x1200 -o open.svg 2>/dev/null
! grep -q 'C1_31?' open.svg && shows open.svg '31?'
note "a label that is not decided has its index lowered, too" $?

# What could not be done: 1; what is missing: 2.
echo "this is no atlas" >foreign
leaves_nothing 2 plot fep missing.ricochet -o empty/a.svg
leaves_nothing 2 plot fep "$ATLAS" missing.ricochet -o empty/a.svg
leaves_nothing 1 plot fep foreign -o empty/a.svg
leaves_nothing 1 plot fep "$ATLAS" --energy 1e300:1e301 -o empty/a.svg
leaves_nothing 1 plot fep "$ATLAS" -o empty/no-such-folder/a.svg
leaves_nothing 1 plot orbit "$ATLAS" --branch 99999 --point 0 -o empty/a.svg
leaves_nothing 1 plot orbit "$ATLAS" --branch 1 --point 99999999 -o empty/a.svg
leaves_nothing 1 plot orbit "$ATLAS" --branch 1 --energy 1e300 -o empty/a.svg
leaves_nothing 1 plot orbit "$ATLAS" --junction 99999 -o empty/a.svg
leaves_nothing 1 plot curves "$ATLAS" --x energy --y tau99999 -o empty/a.svg
leaves_nothing 1 plot floquet "$ATLAS" --branch 99999 -o empty/a.svg

# gnuplot missing, failing, or writing half a picture.
mkdir none failing half
printf '#!/bin/sh\necho boom >&2\nexit 3\n' >failing/gnuplot
printf '#!/bin/sh\necho half\n' >half/gnuplot
chmod +x failing/gnuplot half/gnuplot
with_only() { # with_only FOLDER: as leaves_nothing 1, seeing no programs but those of the folder
    mkdir -p empty
    (PATH=$work/$1 && "$RICOCHET" plot fep "$ATLAS" -o empty/a.png) >stdout 2>stderr
    [ $? -eq 1 ] && [ -s stderr ] && [ -z "$(ls -A empty)" ]
}
with_only none
note "without gnuplot" $?
with_only failing
note "with a failing gnuplot" $?
with_only half
note "with a gnuplot that writes rubbish" $?

rm -f stderr
looked=$(python3 -S - svg/* <<'END' 2>&1
import sys, xml.etree.ElementTree as xml
for name in sys.argv[1:]:
    try:
        root = xml.parse(name).getroot()
    except xml.ParseError as error:
        sys.exit(f"{name}: {error}")
    if not (root.tag.endswith("}svg") and any(path.get("d") for path in root.iter("{http://www.w3.org/2000/svg}path"))):
        print(f"{name} draws nothing", *[text.text for text in root.iter("{http://www.w3.org/2000/svg}text")][:9])
print(len(sys.argv) - 1, "looked at")
END
)
[ "$drawn" -gt 20 ] && [ "$looked" = "$drawn looked at" ]
note "pictures as SVG: $looked" $?

echo "$passed passed, $failed failed"
[ $failed -eq 0 ]
