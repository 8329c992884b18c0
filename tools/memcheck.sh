#!/usr/bin/env bash
# The test programs and the commands of ricochet under valgrind: reads of memory that is not theirs or was never written. Valgrind computes long double in
# 64 bits, so that what the programs say of accuracy does not count here, and whether they pass is left to `make test`, as leaks are to `make sanitize`.
#
#     tools/memcheck.sh [BUILD [SECONDS [NAME...]]]
#
# NAME: programs of BUILD/tests without `test_`, or `commands` for BUILD/ricochet with a call of every command; all unless given. Each is stopped after
# SECONDS (3600) and then counts as not finished, if nothing was found until then. Valgrind is some 40 times slower than the processor: of many random
# cases every RICOCHET_TEST_EVERY-th (7) is taken (tests/support/sample.h). Exit status 1 if valgrind finds something.
#
# Two settings make it two to three times faster: the mathematical library without fused multiplication and addition, each of which is a call of valgrind's
# own, and no exact account of the undefined bits of sums and comparisons of integers. Both can only make it find more: a finding is to be looked at
# once more without them.
set -u
export GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA
valgrind=(valgrind --quiet --error-exitcode=99 --expensive-definedness-checks=no --vgdb=no)
build=${1:-build}
seconds=${2:-3600}
shift $(($# < 2 ? $# : 2))
export RICOCHET_TEST_EVERY=${RICOCHET_TEST_EVERY:-7}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
bad=0

# checked NAME COMMAND...
checked()
{
    local begin=$SECONDS said= name=$1
    shift
    timeout -s KILL "$seconds" "${valgrind[@]}" --log-file="$folder/log" "$@" >"$folder/out" 2>&1
    local code=$?
    if [ $code = 99 ] || grep -Eq '== (Invalid|Conditional jump|Use of uninit|Mismatched|Source and dest)|uninitialised byte' "$folder/log"; then
        said="finding" bad=1 && head -40 "$folder/log"
    elif [ $code = 137 ]; then
        said="not finished"
    elif [ $code -gt 128 ]; then
        said="ended by signal $((code - 128))" bad=1
    else
        said="clean"
    fi
    echo "$name: $said, $((SECONDS - begin)) s"
}

# ---------------------------------------------------------------- the commands

small() # EXAMPLE IMPACTS DEPTH ENERGY
{
    sed "s/^  impacts:.*/  impacts: $2/; s/^  depth:.*/  depth: $3/; s/^  energy:.*/  energy: [0, $4]/; /^  at_energy/d; /^names/,\$d" "examples/$1/study.yaml"
}

# One line each, F for the folder; a quoted word is one argument.
calls()
{
    cat <<'CALLS'
new F/new
check F/new/study.yaml --json
check F/power.yaml
run F/rigid.yaml -o F/rigid.ricochet --max-step 0.2
run F/larger.yaml -o F/rigid.ricochet -j 2
run F/springs.yaml -o F/springs.ricochet
run F/power.yaml -o F/long.ricochet --seconds 20
run F/walls.yaml -o F/walls.ricochet
run F/wrong.yaml
run F/rigid.yaml -o F/power.ricochet
branches F/rigid.ricochet --elementary --segments
branches F/springs.ricochet --json
junctions F/rigid.ricochet --csv
junctions F/rigid.ricochet --duplicates 4 --branch 3 --ghost
bases F/rigid.ricochet
points F/rigid.ricochet --branch 3 --csv
points F/rigid.ricochet --branch 3 --ghost
report F/rigid.ricochet --json
orbit F/rigid.ricochet --branch 3 --energy 1.5
orbit F/rigid.ricochet --branch 3 --frequency 1.2 --history 0.5 --csv --physical
orbit F/springs.ricochet --branch 2 --point 1 --json
orbit F/power.ricochet --branch 1 --point 2
points F/power.ricochet --branch 2
verify F/rigid.ricochet --branch 3 --all
verify F/springs.ricochet
verify F/power.ricochet --branch 1
simulate F/power.yaml --state 0.1 -0.2 0 1.5 --time 5 --steps 10
simulate F/rigid.yaml --state 0.1 -0.2 0 2.5 --time 20 --impacts
simulate F/springs.yaml --state 0.1 -0.2 0 2.5 --time 2 --steps 10 --json
hunt F/rigid.yaml --energy 5 --impacts 3 --lines 60 --rows 2 --row 10 --random 50
section F/rigid.yaml --energy 5 --starts 3 --impacts 40 -j 2
section F/rigid.ricochet --energy 5 --orbits --radius 0.1 --impacts 40 --exponents
hunt F/rigid.yaml --energy 5 --impacts 3 --lines 60 --rows 2 --row 10 --random 50 --atlas F/rigid.ricochet --add
cascade F/rigid.ricochet --branch 3 --multiply 2
cascade F/power.ricochet --multiply 2
words 7 --limit 3
plot fep F/rigid.ricochet --break 2.2 --labels all -o F/fep.svg
plot fep F/rigid.ricochet --duplicates 4 --frequency 0.3:4 -o F/duplicates.png
plot fep F/rigid.ricochet --ghosts --energy 0.5:20 -o F/ghosts.svg
plot fep F/rigid.ricochet F/springs.ricochet -o F/both.pdf
plot orbit F/rigid.ricochet --branch 3 --energy 1.5 --coordinates 1,2 -o F/orbit.pdf
plot orbit F/springs.ricochet --branch 2 --point 1 -o F/closed.svg
plot orbit F/power.ricochet --branch 1 --point 2 -o F/smooth.svg
plot orbits F/rigid.ricochet --orbit C1_32 --orbit 'S2-[01]@E=5*2' -o F/orbits.svg
plot curves F/rigid.ricochet --x energy --y tau1 --branch 3 --log x -o F/curves.png
plot floquet F/rigid.ricochet --branch 3 --x energy -o F/floquet.svg
plot cascade F/rigid.ricochet --branch 3 --multiply 2 -o F/cascade.svg
plot sheet F/rigid.ricochet --segment 'A2[01]|C1_32 G1_2,2' -o F/sheet.svg
plot strobe F/rigid.ricochet --segment 'A2[01]|C1_32 G1_2,2' --samples 4 -o F/strobe.svg
CALLS
}

# A server that is asked for what the page asks for, then to extend the atlas, then to end.
served()
{
    local url token path begin=$SECONDS said=
    "${valgrind[@]}" --log-file="$folder/log" "$build/ricochet" view "$folder/rigid.ricochet" --no-browser --port 0 >"$folder/url" 2>&1 &
    local pid=$!
    for _ in $(seq 300); do grep -q token= "$folder/url" && break || sleep 0.1; done
    url=$(sed -n 's,/?token.*,,p' "$folder/url")
    token=$(sed -n 's/.*token=//p' "$folder/url")
    for path in / /app.js /api/status /api/atlas /api/points /api/outline /api/bases /api/cascades '/api/orbit?branch=3&energy=1.5' /none; do
        curl -s -m 60 -o /dev/null -H "X-Ricochet-Token: $token" "$url$path"
    done
    curl -s -m 60 -o /dev/null -H "X-Ricochet-Token: $token" -d '{"depth":5}' "$url/api/extend"
    for _ in $(seq 600); do curl -s -m 60 "$url/api/status" | grep -q '"running":true' && sleep 0.1 || break; done
    curl -s -m 60 "$url/api/status" >"$folder/status"
    kill -TERM "$pid"
    wait "$pid"
    if [ $? = 99 ]; then said="finding" bad=1 && head -40 "$folder/log"; elif ! grep -q '"running":false' "$folder/status"; then said="not finished"; else said="clean"; fi
    echo "ricochet view F/rigid.ricochet: $said, $((SECONDS - begin)) s"
}

check_commands()
{
    small elementary 4 2 20 >"$folder/rigid.yaml"
    small elementary 6 3 50 >"$folder/larger.yaml"
    small bilinear 4 1 8 >"$folder/springs.yaml"
    small power-3 4 1 3 >"$folder/little.yaml"
    small power-3 4 3 1000 >"$folder/power.yaml"
    "$build/ricochet" run "$folder/little.yaml" -o "$folder/power.ricochet" 2>"$folder/out"
    small two-walls 4 2 5 >"$folder/walls.yaml"
    sed 's/mass:.*/mass: [[2, 0], [0, -1]]/' "$folder/rigid.yaml" >"$folder/wrong.yaml"
    while read -r call; do
        eval "set -- ${call//F\//$folder/}"
        checked "ricochet $call" "$build/ricochet" "$@" </dev/null
    done < <(calls)
    served
}

names=("$@")
if [ $# = 0 ]; then for path in "$build"/tests/test_*; do [ -f "$path" ] && [ -x "$path" ] && names+=("${path##*/test_}"); done; names+=(commands); fi
for name in "${names[@]}"; do
    if [ "$name" = commands ]; then check_commands; else checked "$name" "$build/tests/test_$name"; fi
done
exit "$bad"
