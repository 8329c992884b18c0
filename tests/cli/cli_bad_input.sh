#!/bin/bash
# Wrong studies and wrong calls, from outside: exit code, one message on stderr, nothing on stdout, no file.
set -u
shopt -s lastpipe # `study | bad` counts its failures in this shell
ricochet=${RICOCHET:?the program to test}
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder" "$folder.out" "$folder.err"' EXIT
cd "$folder" || exit 1
failed=0

complain() {
    echo "FAILED: $1"
    sed 's/^/    /' "$folder.err" 2>/dev/null
    failed=$((failed + 1))
}

# expect CODE PATTERN ARGUMENTS...: runs the program in the folder, without a process that is not needed: there are 300 of them
expect() {
    local code=$1 pattern=$2 got
    shift 2
    "$ricochet" "$@" >"$folder.out" 2>"$folder.err" </dev/null
    got=$?
    [ "$got" = "$code" ] || complain "exit code $got instead of $code: $*"
    grep -q -e "$pattern" "$folder.err" || complain "no '$pattern' on stderr: $*"
    [ -s "$folder.out" ] && complain "output on stdout: $*"
}

nothing_else() { # but the study
    local all=(*)
    [ "${all[*]}" = s.yaml ] || complain "files left behind: ${all[*]}"
}

# bad PATTERN: the study on stdin is refused by `run` and by `check`, at a line, and leaves no file behind
bad() {
    cat >"$folder/s.yaml"
    for command in check run; do
        expect 2 "^ricochet: s.yaml:[0-9]*: .*$1" "$command" s.yaml
    done
    expect 2 "$1" run s.yaml -o out.ricochet
    nothing_else
}

# study LINE TEXT: a good study with one line replaced
study() {
    sed "$1s/.*/$2/" <<'END'
title: Two masses
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - normal: [-1, 1]
      clearance: 1
      law: rigid
explore:
  energy: [0, 20]
  impacts: 6
END
}

study 1 'titel: x' | bad 'titel: unknown key; did you mean'
study 2 'modell:' | bad 'modell: unknown key'
study 3 '  mass: [[2, 0], [0]]' | bad 'model.mass: row 2 has 1 entry, '
study 3 '  mass: [2, 1.5]' | bad 'model.mass: a plain list of numbers, and a matrix is a list of rows; .* written \[\[2, 0\], \[0, 1.5\]\]$'
study 4 '  stiffness: [1, 2, 3, 4, 5]' | bad 'model.stiffness: a plain list .* with all its zeros, or in a file, {file: M.mtx}'
study 4 '  stiffness: [1, x]' | bad "model.stiffness: 'x' is not a number"
study 3 '  mass: [[2, 0.1], [0, 1]]' | bad 'model.mass: not symmetric'
study 3 '  mass: [[2e301, 0], [0, 1e301]]' | bad 'model.mass: .*2e+301.*other units'
study 3 '  mass: [[2, 0], [0, 0]]' | bad 'model.mass: .*row 2, column 2, which is 0: a displacement without mass .*; condense it'
study 3 '  mass: [[2, 0], [0, -1]]' | bad 'model.mass: .*not positive definite.*eigenvalue'
study 3 '  mass: [[2, 0], [0, .nan]]' | bad 'model.mass, row 2, column 2: .*not finite'
study 3 '  mass: {file: absent.mtx}' | bad 'model.mass: absent.mtx: No such file.*; the name of a file is taken from the folder of the study'
study 4 '  stiffness: [[9]]' | bad 'model.stiffness: 1 x 1'
study 4 '  stiffness: [[-9, 0], [0, 1]]' | bad 'model.stiffness: .*not positive semidefinite'
study 6 '    - normal: [0, 0]' | bad 'model.contacts\[1\].normal: all zeros'
study 6 '    - normal: [1]' | bad 'model.contacts\[1\].normal: 1 number, '
study 7 '      clearance: 0' | bad 'model.contacts\[1\].clearance: zero.*small positive clearance'
study 7 '      clearance: -1' | bad 'model.contacts\[1\].clearance: .*preloaded'
study 7 '      clearance: .inf' | bad 'model.contacts\[1\].clearance: .*not finite'
study 8 '      stiffness: 1' | bad 'model.contacts\[1\].stiffness: not a key of law rigid'
study 8 '      law: bilinear' | bad 'model.contacts\[1\].stiffness: missing'
study 8 '      law: power' | bad 'model.contacts\[1\].clearance: not a key of law power'
study 8 '    - {normal: [1, 0], law: power, exponent: 3, stiffness: 3}' | bad 'model.contacts\[2\].law: power beside rigid'
study 8 '      restitution: 1' | bad 'restitution: unknown key'
study 10 '  energy: [20, 0]' | bad 'explore.energy: .*reversed'
study 11 '  impacts: many' | bad 'explore.impacts: .*whole number'
study 11 '  energy: [0, 1]' | bad 'explore.energy: given twice'
study 11 '  start: [3]' | bad 'explore.start: there is no mode 3'
study 11 'names: [{name: a, kind: b, energy: 1, frequency: 1}]' | bad 'names\[1\].kind: .*no kind of junction'
study 11 '  impacts: [1' | bad 'syntax: '
bad 'model: the study is empty' </dev/null
printf 'title: \xff\n' | bad 'text: .*not UTF-8'
printf '%05000d\n' 0 | tr 0 '[' | bad 'syntax: nested'

# An atlas needs restitution 1, the simulator does not: `check` takes the study, `run` refuses it.
study 2 'model:\n  restitution: 0.5' >"$folder/s.yaml"
expect 2 's.yaml:3: model.restitution: 0.5.*an atlas needs 1' run s.yaml
nothing_else

# Wrong calls.
study 1 'title: good' >"$folder/s.yaml"
expect 2 'usage: ricochet COMMAND'
expect 2 "unknown command 'braches'; did you mean 'branches'" braches
expect 2 "unknown command 'xyzzy'" xyzzy
study 1 'title: x' >"$folder/-s.yaml"
expect 2 "option '-s.yaml' is unknown; the file of that name is written ./-s.yaml" check -s.yaml
rm -f "$folder/-s.yaml"
expect 2 "'--json' stands before the command; write .ricochet COMMAND ... --json." --json branches
expect 2 'argument is missing' check
expect 2 'one argument too many' check s.yaml s.yaml
expect 2 "'extra' is one argument too many" --version extra
expect 2 "'extra' is one argument too many" --help extra
expect 2 'argument 1 is empty' check ''
expect 2 "option '--jsno' is unknown" check s.yaml --jsno
expect 2 'choose one' check s.yaml --json --csv
expect 2 "option '-jx' is unknown" run s.yaml -jx
expect 2 'absent.yaml: No such file.*ricochet new' check absent.yaml
expect 2 'absent/x: No such file.*make the folder' new absent/x
expect 2 "'x' after --state is not a number" simulate s.yaml --state 0 0 0 x --time 1
expect 2 "'0,0,0,1' after --state is not a number" simulate --time 1 --state 0,0,0,1 s.yaml
expect 2 'after a blank' simulate s.yaml --state=0 0 0 1 --time 1
expect 2 'this is a folder' run .
expect 2 '-o needs a value' run s.yaml -o
expect 2 "-j '-1' is not a whole number from 0" run s.yaml -j -1
expect 2 '--max-step: 0 is out of range' run s.yaml --max-step 0
expect 2 '--max-step: .x. is not a number' run s.yaml --max-step x
expect 2 'would overwrite the study' run s.yaml -o s.yaml
expect 2 "N '0' is not a whole number" words 0
expect 2 "N 'six' is not a whole number" words six
expect 2 'the name is empty' new ''
nothing_else

# An atlas in the place of a study.
printf 'SQLite format 3\0' >"$folder/a.ricochet"
expect 2 'this is an atlas' check a.ricochet
rm "$folder/a.ricochet"

# `new` keeps what is there.
mkdir "$folder/old"
echo precious >"$folder/old/study.yaml"
expect 1 'old/study.yaml exists' new old
[ "$(cat "$folder/old/study.yaml")" = precious ] || complain 'new has overwritten a study'

# And what it writes is a study.
(cd "$folder" && "$ricochet" new fresh && "$ricochet" check fresh/study.yaml) >"$folder.out" 2>"$folder.err" || complain 'new, then check'
[ -s "$folder.err" ] && complain 'a message about a fresh study'
rm -f "$folder.out" "$folder.err"

[ "$failed" = 0 ] && echo 'all wrong input is refused as it should be'
exit $((failed > 0))
