#!/usr/bin/env bash
# Keys damping, restitution and forcing of a study: the same as the options, which go before them; the atlas stays.
set -u
. tests/support/tap.sh

keys='damping: 0.01\nrestitution: 0.98\nforcing: {vector: [1, 0], amplitude: 0.2, frequency: [1.1, 1.3]}\n'
study() { printf 'model:\n  mass: [[2, 0], [0, 1]]\n  stiffness: [[9, -1], [-1, 1]]\n  contacts: [{normal: [-1, 1], clearance: 1}]\nexplore: {energy: [0, 10], depth: 1, impacts: 4}\n'"$1"; }
study '' >"$folder/bare.yaml"
study "$keys" >"$folder/s.yaml"
ok "an atlas without" "$ricochet" run "$folder/bare.yaml" -o "$folder/bare" --quiet
ok "an atlas with" "$ricochet" run "$folder/s.yaml" -o "$folder/a"
branches() { "$ricochet" branches "$1" --json; }
ok "is the same one" diff <(branches "$folder/bare") <(branches "$folder/a")
says() { "$@" 2>&1 | grep -q 'the atlas is that of the structure without losses and force'; }
ok "run says so" says "$ricochet" run "$folder/s.yaml" -o "$folder/a"
ok "check says so" says "$ricochet" check "$folder/s.yaml"
ok "report says so" says "$ricochet" report "$folder/a"
says() { "$@" 2>&1 >"$folder/out" | grep -q ' is that of the structure without losses and force'; }
ok "section says so" says "$ricochet" section "$folder/s.yaml" --energy 5 --starts 2 --impacts 10
ok "its picture says so" says "$ricochet" plot section "$folder/s.yaml" --energy 5 --starts 2 --impacts 10 -o "$folder/p.svg"
ok "hunt says so" says "$ricochet" hunt "$folder/s.yaml" --energy 5 --impacts 1 --period 4
ok "the atlas without is taken by the study with" "$ricochet" run "$folder/s.yaml" -o "$folder/bare" --quiet
same() { diff <("$ricochet" force "$1" --energy 1 --json "${@:2}") <("$ricochet" force "$folder/a" --energy 1 --force 1,0 --damping 0.01 --restitution 0.98 --level 0.2 --json); }
ok "force takes the keys" same "$folder/a"
ok "those that were run into it, too" same "$folder/bare"
ok "options go before them" same "$folder/a" --level 0.2 --damping 0.01
other() { ! same "$folder/a" --damping 0.02 >"$folder/out"; }
ok "other options, other numbers" other
study "${keys/0.98/0.5}" >"$folder/t.yaml"
ok "--study takes those of another study" same "$folder/a" --study "$folder/s.yaml"
ok "which has others" eval "! same '$folder/a' --study '$folder/t.yaml' >'$folder/out'"
ok "response takes the keys" "$ricochet" response "$folder/a" -o "$folder/r" --csv
curves() { diff <("$ricochet" response "$folder/r" --points --json) <("$ricochet" response "$folder/a" --force 1,0 --damping 0.01 --restitution 0.98 --level 0.2 --omega 1.1,1.3 -o "$folder/r2" >"$folder/out" && "$ricochet" response "$folder/r2" --points --json); }
ok "as its options" curves
simulated() { diff <("$ricochet" simulate "$folder/s.yaml" --state 0 0 1 2 --time 9 --omega 1.2 --csv) <("$ricochet" simulate "$folder/bare.yaml" --state 0 0 1 2 --time 9 --omega 1.2 --force 1,0 --level 0.2 --damping 0.01 --restitution 0.98 --csv); }
ok "simulate takes the keys" simulated
free() { diff <("$ricochet" simulate "$folder/s.yaml" --state 0 0 1 2 --time 9 --level 0 --damping 0 --restitution 1 --csv | tail -1 | cut -c1-12) <("$ricochet" simulate "$folder/bare.yaml" --state 0 0 1 2 --time 9 --csv | tail -1 | cut -c1-12); }
ok "and lets go of them" free

# The first step is made for the mode, and under a steep spring its sub-steps overflow.
echo 'model: {mass: [[1]], stiffness: [[1]], contacts: [{normal: [1], law: power, exponent: 7, stiffness: 1.0e+6}]}' >"$folder/steep.yaml"
steep() {
    python3 -S - <("$ricochet" simulate "$folder/steep.yaml" --state 3 0 --time 0.5 --steps 5 --json) \
        <("$ricochet" simulate "$folder/steep.yaml" --state 3 0 --time 0.5 --steps 5 --force 1 --level 1e-12 --omega 1 --json) <<'END'
import json, sys
free, shaken = (json.load(open(path)) for path in sys.argv[1:])
assert len(free) == len(shaken) == 6 and all(abs(a["x1"] - b["x1"]) < 1e-9 and abs(a["v1"] - b["v1"]) < 1e-2 for a, b in zip(free, shaken)), shaken
END
}
ok "a steep spring is followed, with a force as without" steep
drawn() { "$ricochet" plot simulate "$folder/$1" --state 0 0 1 2 --time 9 --omega 1.2 "${@:3}" -o "$folder/$2.gp"; }
ok "plot simulate takes options" drawn bare.yaml shaken --force 1,0 --level 0.2 --damping 0.01 --restitution 0.98
ok "and takes the keys" eval 'drawn s.yaml keys && diff <(grep "^[-0-9]" "$folder/shaken.gp") <(grep "^[-0-9]" "$folder/keys.gp")'
ok "and lets go of them" eval 'drawn s.yaml free --level 0 --damping 0 --restitution 1 && ! diff -q "$folder/free.gp" "$folder/keys.gp" >"$folder/out"'

# ends CODE WORDS ARGUMENT...: the exit code, and the message
ends() {
    local code=$1 words=$2 got=0
    shift 2
    "$ricochet" "$@" >"$folder/out" 2>"$folder/err" || got=$?
    [ "$got" = "$code" ] && grep -q -e "$words" "$folder/err"
}
study "" | sed 's/^  contacts/  restitution: 0.98\n&/' >"$folder/m.yaml"
ok "model.restitution is refused, with a word where it goes" ends 2 'm.yaml:4: model.restitution: 0.98.*`restitution: 0.98` at the top' run "$folder/m.yaml" -o "$folder/x"
ok "by hunt, too" ends 2 'losses' hunt "$folder/m.yaml" --energy 5
ok "check says so" eval '"$ricochet" check "$folder/m.yaml" | grep -q "an atlas needs 1"'
study "restitution: 0.98\n" >"$folder/n.yaml"
with() { "$ricochet" force "$folder/a" --energy 1 --force 1,0 --damping 0 --level 0.2 --study "$1" --json; }
ok "force takes it" diff <(with "$folder/m.yaml") <(with "$folder/n.yaml")
before=$(cksum "$folder/a")
bad() { study "$2" >"$folder/bad.yaml" && ends 2 "bad.yaml:6: $1" run "$folder/bad.yaml" -o "$folder/a"; }
ok "negative damping" bad 'damping: .*negative' 'damping: -0.01\n'
ok "a force of the wrong length" bad 'forcing.vector: .*3 numbers' 'forcing: {vector: [1, 0, 0]}\n'
ok "restitution above 1" bad 'restitution' 'restitution: 1.5\n'
ok "curves are no atlas, and are called what they are" ends 1 'not an atlas but curves' plot fep "$folder/r" -o "$folder/fep.svg"
ok "a force that does not change" ends 2 'omega 0 is a force that does not change' simulate "$folder/bare.yaml" --state 0 0 1 2 --time 9 --force 1,0 --omega 0
ok "a window without a frequency" ends 2 'omega' simulate "$folder/s.yaml" --state 0 0 1 2 --time 9
study 'restitution: 0\nforcing: {coordinate: 1, amplitude: 0.2, frequency: [1, 2]}\n' >"$folder/z.yaml"
ok "restitution 0, where bodies would stay together" ends 2 'restitution 0' force "$folder/a" --study "$folder/z.yaml"
ok "and in a response" ends 2 'restitution 0' response "$folder/a" --study "$folder/z.yaml" -o "$folder/z"
ok "a window with no orbit" ends 1 'no forced orbit was found' response "$folder/a" --branch 3 --omega 90,91 -o "$folder/n"
lambda=$(python3 -S -c "print(((11 - 57 ** 0.5) / 4) ** 0.5)")
ok "a force at a mode that nothing damps" ends 1 'has the frequency .* of mode 1, which is not damped' response "$folder/a" --damping 0 --along level --level 0.1,0.2 --omega "$lambda" -o "$folder/m0"
ok "a branch that is a linear mode" ends 1 'branch 1 is a linear mode' response "$folder/a" --damping 0 --along level --level 0.1,0.2 --omega "$lambda" --branch 1 -o "$folder/m"
sed 's/1, 0\], \[0, 1\]/1, 0], [0, 3]/; s/\[\[2/[[3/' "$folder/s.yaml" >"$folder/o.yaml"
ok "a study of another structure" ends 2 'another structure' force "$folder/a" --study "$folder/o.yaml"
ok "nothing is lost" test "$before" = "$(cksum "$folder/a")"
finish
