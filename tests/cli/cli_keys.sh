#!/bin/bash
# Keys of branches and junctions: those of the two masses for good, and that no budget changes one.
set -u
. tests/support/tap.sh

atlas=$folder/elementary.ricochet
"$ricochet" run examples/elementary/study.yaml -o "$atlas" >/dev/null 2>&1

# What stands here stands in scripts and manuscripts of others: it may only grow.
cat >"$folder/branches" <<END
bve87hv9j,S0+
bbkpqtg8r,S0-
bcbhr3dzr,S2+[01]
b0v4r1tbq,S2-[01]
b20jw7j33,A2[01]
bw6jxbtm6,A3[001]
bfx7bkkfv,A4[0001]
bsp2nd6z0,S4[0011]
bvew82t3n,A4[0101]
bmvq302nf,A5[00101]
b6rnyv3mn,S6[010101]
bant6jann,S4[0011]
bqkpj4fr1,A6[010101]
b6cdxcp6k,A4[0011]
END
cat >"$folder/junctions" <<END
jvaq563rv,G1_0,2
j3nb897ff,G2_0,2
jpr864d85,C1_31
je61ja3wc,C2_31
jna6p8eac,C1_32
jw5sw45ps,G1_2,2
jqzfc0k01,G1_2,4
jtmg496qv,C3_31
jttxz1wx6,P1
jeatjephq,C4_32
jsmr38zey,C2_32
j7nxvx6ap,G1_4,2
j7jxyvtfk,G2_4,2
jhcssf5xt,G3_4,2
jp4qw52zj,A5 C21
jgraym3ye,S6 minimum
j9mf41qkm,C1_33
j4gwrncn0,C3_32
END

listed() { # COMMAND COLUMN...: these columns of all rows, from JSON
    "$ricochet" "$1" "$atlas" --json | python3 -S -c '
import json, sys
for row in json.load(sys.stdin):
    print(row["key"], next(row[name] for name in sys.argv[1:] if row[name]), sep=",")' "${@:2}"
}
for what in branches junctions; do
    if [ $what = branches ]; then listed branches label >"$folder/found"; else listed junctions name label >"$folder/found"; fi
    ok "keys of the two masses: $what" diff "$folder/$what" "$folder/found"
    ok "$what: the keys in the table, in CSV and in JSON are the same" diff <("$ricochet" $what "$atlas" | awk 'NR > 1 { print $2 }') \
        <(cut -d, -f1 "$folder/found")
    ok "$what: CSV has them as well" diff <("$ricochet" $what "$atlas" --csv | cut -d, -f2 | tail -n +2 | tr -d '\r') <(cut -d, -f1 "$folder/found")
done

# what S6[010101] and its C1_33 go by, all in one command
points() { "$ricochet" points "$atlas" "$@" --csv; }
points --branch 11 >"$folder/points"
s6=$(awk -F, '/^b.*,S6\[/ { print $1 }' "$folder/branches")
for handle in "$s6" "${s6:0:5}" 'S6[010101]' 'S6[010101]|C1_33' "$(awk -F, 'NR == 20 { print $3 "," $4 }' "$folder/points")"; do
    ok "--branch $handle" diff "$folder/points" <(points --branch "$handle")
    ok "--branch=$handle" diff "$folder/points" <(points "--branch=$handle")
done
ok '--at' diff "$folder/points" <(points --at "$(awk -F, 'NR == 20 { print $3 "," $4 }' "$folder/points")")
c33=$(awk -F, '/C1_33/ { print $1 }' "$folder/junctions")
"$ricochet" plot orbit "$atlas" --junction 17 -o "$folder/id.svg"
for handle in "$c33" "${c33:0:5}" C1_33 3.8487371,1.6862381; do
    ok "--junction $handle" "$ricochet" plot orbit "$atlas" --junction "$handle" -o "$folder/$number.svg"
    ok "--junction $handle: the same picture" cmp "$folder/id.svg" "$folder/$((number - 1)).svg"
done
ok 'a key is a segment of a picture' "$ricochet" plot fep "$atlas" --branch "${s6:0:5}" --label "$c33" -o "$folder/fep.svg"
refused() { # WORDS ARGUMENT...: exit code 2 with these words
    "$ricochet" "${@:2}" 2>"$folder/said" >&2
    [ $? = 2 ] && grep -q -- "$1" "$folder/said" || { cat "$folder/said"; return 1; }
}
one=$(cut -c 1-2 "$folder/branches" | sort | uniq -d | head -n 1)
ok 'an ambiguous beginning lists what fits' refused "keys begin like this: $one" points "$atlas" --branch "$one"
ok 'a key that is none' refused 'no branch has this label or key' points "$atlas" --branch bzzzzzzzz
ok 'the beginning of a label' refused "'A3\[[01]*\]' begins so" points "$atlas" --branch A3
ok 'branches that meet at a junction are equally near' refused 'equally near' points "$atlas" --at 0.601588369489,0.928731065046
ok 'a place is two numbers' refused 'write a scaled energy and a frequency' points "$atlas" --at 5
ok 'a place is above 0' refused 'above 0' points "$atlas" --branch 5,-1
ok 'not both' refused 'both given' points "$atlas" --at 5,1 --branch 3
ok 'an atlas is needed' refused 'argument is missing' points --at 5,1
far() { "$ricochet" points "$atlas" --at 4000,1 2>&1 >/dev/null | grep -q 'nothing is there; the nearest branch'; }
ok 'what is far is said' far

studies=(examples/elementary/study.yaml)
long_form && studies=(examples/*/study.yaml)
ok 'keys stay with other budgets, steps and workers' tools/keys --program "$ricochet" "${studies[@]}"

# Labels, too, once a finished atlas has shown them.
studies=(elementary three-masses two-springs fractal-base stop-and-spring)
long_form && studies=($(ls examples))
ok 'labels stay with their keys while an atlas grows' python3 -S tests/support/labels_last.py "$ricochet" "$folder" 100 \
    $(printf 'examples/%s/study.yaml ' "${studies[@]}")
older() { # an atlas of before, which does not keep them, has them in its tables
    sed 's/^  depth:.*/  depth: 2/' examples/elementary/study.yaml >"$folder/small.yaml"
    rm -f "$folder/old.ricochet"
    "$ricochet" run "$folder/small.yaml" -o "$folder/old.ricochet" --quiet || return 1
    python3 -S -c 'import sqlite3, sys; a = sqlite3.connect(sys.argv[1]); a.execute("DELETE FROM meta WHERE key = '"'labels'"'"); a.commit()' "$folder/old.ricochet"
    python3 -S tools/attack/atlas_digest.py "$folder/old.ricochet" >/dev/null
    "$ricochet" junctions "$folder/old.ricochet" --csv | cut -d, -f2,4 | sort >"$folder/shown"
    sed '/^names:/,/^[a-z]/d' examples/elementary/study.yaml >"$folder/large.yaml"
    "$ricochet" run "$folder/large.yaml" -o "$folder/old.ricochet" --quiet || return 1
    "$ricochet" junctions "$folder/old.ricochet" --csv | cut -d, -f2,4 | sort >"$folder/now"
    [ "$(comm -12 "$folder/shown" "$folder/now" | wc -l)" = "$(wc -l <"$folder/shown")" ]
}
ok 'those of an older file' older

finish
