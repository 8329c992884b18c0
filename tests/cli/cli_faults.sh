#!/usr/bin/env bash
# No memory, a full disk or no power at any moment of a run, be it the first one, one that extends an atlas or one with two workers: it ends with a
# message or not at all, never with a crash; what stood in the atlas still stands there; and the same command then makes the atlas of an undisturbed
# run. FAULTS_ALL=1 tries every allocation, some 80,000 in an hour; otherwise a sample.
set -u
. tests/support/tap.sh

cc=${CC:-cc}
command -v "$cc" >/dev/null || { echo "1..0 # SKIP no compiler $cc"; exit 77; }
"$cc" -shared -fPIC -O1 -o "$folder/faults.so" tests/support/faults.c -ldl || exit 77
! sanitized || { echo "1..0 # SKIP a program built with sanitizers brings its own allocator"; exit 77; }

study() # IMPACTS DEPTH
{
    cat <<YAML
title: Two masses
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], clearance: 1.0, law: rigid}
explore: {energy: [0, 50], frequency: [0.2, 10], impacts: $1, multiply: 1, depth: $2}
YAML
}
study 4 2 >"$folder/study.yaml"
study 2 1 >"$folder/small.yaml"
atlas=$folder/a.ricochet
old= workers=1     # an atlas that the run finds and extends; its workers
declare -A resumed # what faults leave behind, and is known to be taken up well

rows() { "$ricochet" branches "$1" --json && "$ricochet" junctions "$1" --json; }

# The finished work in an atlas, which its tables are made of.
work() { python3 -S -c 'import sqlite3, sys; [print(*row) for row in sqlite3.connect(sys.argv[1]).execute("SELECT key, digest FROM trace ORDER BY key")]' "$1"; }

disturbed() # FAULT=K: exit code
{
    rm -f "$atlas"*
    [ -z "$old" ] || cp "$old" "$atlas"
    (export "$1" LD_PRELOAD="$folder/faults.so" && exec "$ricochet" run "$folder/study.yaml" -o "$atlas" -j $workers >/dev/null 2>"$folder/message") 2>/dev/null
}

left() { echo "$old $workers" "$atlas"* "$(cat "$atlas" "$atlas-journal" 2>/dev/null | md5sum)"; }

# The tables are the old ones or the new ones, and no finished work is lost.
keeps_old()
{
    rows "$atlas" >"$folder/rows" || return 1
    cmp "$folder/rows" "$folder/small" || cmp "$folder/rows" "$folder/whole" || return 1
    work "$atlas" >"$folder/work"
    [ -z "$(comm -23 "$folder/old-work" "$folder/work")" ]
}

is_whole()
{
    rows "$atlas" >"$folder/rows"
    cmp "$folder/rows" "$folder/whole"
}

resumes() { "$ricochet" run "$folder/study.yaml" -o "$atlas" 2>"$folder/message" && is_whole; }

# try NAME FAULT K EXPECTED-CODES MESSAGE
try()
{
    disturbed "$2=$3"
    local code=$? state=
    case " $4 " in *" $code "*) ;; *) echo "$1 $3: exit code $code"; cat "$folder/message"; return 1 ;; esac
    [ "$code" != 1 ] || grep -q "$5" "$folder/message" || { echo "$1 $3: message without '$5'"; cat "$folder/message"; return 1; }
    state="$code $(left)"
    [ -z "${resumed[$state]:-}" ] || return 0
    [ "$code" != 0 ] || is_whole || { echo "$1 $3: ended well, and is not whole"; return 1; }
    [ -z "$old" ] || keeps_old || { echo "$1 $3: something old is lost"; return 1; }
    resumes || { echo "$1 $3: not resumed"; cat "$folder/message"; return 1; }
    resumed[$state]=1
}

# every NAME FAULT CODES MESSAGE K...
every()
{
    local name=$1 fault=$2 codes=$3 message=$4
    shift 4
    for k in "$@"; do try "$name" "$fault" "$k" "$codes" "$message" || return 1; done
}

# faults WHAT SAMPLE SKIP: some SAMPLE allocations and every SKIPth writing call, or all
faults()
{
    ok "$1, undisturbed: calls are counted" disturbed "FAULT_COUNT=$folder/count"
    read -r allocations writes <"$folder/count"
    ok "$1: there are many" test "$allocations" -gt 1000 -a "$writes" -gt 30
    local step=$((allocations / $2 + 1)) skip=$3
    [ "${FAULTS_ALL:-0}" = 0 ] || step=1 skip=1
    ok "$1: the disk is full from a writing call on (every ${skip}th of $writes)" every disk FAULT_DISK 1 . $(seq 1 $skip "$writes")
    ok "$1: the power fails at a writing call" every power FAULT_POWER 137 . $(seq 1 $skip "$writes")
    # SQLite and LAPACK may do without what they asked for: then the run ends well.
    ok "$1: any allocation finds no memory (every ${step}th of $allocations)" every allocation FAULT_ALLOC "0 1" memory $(seq 1 $step "$allocations")
}

"$ricochet" run "$folder/study.yaml" -o "$folder/whole.ricochet" 2>/dev/null
rows "$folder/whole.ricochet" >"$folder/whole"
faults "a first run" "$(some_of 12 120)" "$(some_of 19 1)"

"$ricochet" run "$folder/small.yaml" -o "$folder/small.ricochet" 2>/dev/null
rows "$folder/small.ricochet" >"$folder/small"
work "$folder/small.ricochet" >"$folder/old-work"
ok "the small atlas has less in it" eval '! cmp -s "$folder/small" "$folder/whole" && test -s "$folder/old-work"'
old=$folder/small.ricochet
faults "a run that extends an atlas" "$(some_of 6 60)" "$(some_of 23 1)"

workers=2
faults "the same with two workers" "$(some_of 4 30)" "$(some_of 37 7)"
echo "# ${#resumed[@]} kinds of remains were taken up"

last=$(every_of 29) number_of=0
# What only reads an atlas either shows all of it or says that memory ran out.
reads() # COMMAND...
{
    "$ricochet" "$@" >"$folder/all" 2>/dev/null || return 1
    (export FAULT_COUNT="$folder/count" LD_PRELOAD="$folder/faults.so" && exec "$ricochet" "$@" >/dev/null 2>&1)
    local allocations step code
    read -r allocations _ <"$folder/count"
    step=$((allocations / $(some_of 6 20) + 1))
    [ "${FAULTS_ALL:-0}" = 0 ] || step=1
    # the last ones make the rows, and are each of another kind: one in 29 of them, others for each command
    number_of=$((number_of + 1))
    for k in $(seq 1 $step "$allocations") $(seq $((allocations > 250 ? allocations - 250 + number_of % last : 1)) $last "$allocations"); do
        (export FAULT_ALLOC=$k LD_PRELOAD="$folder/faults.so" && exec "$ricochet" "$@" >"$folder/shown" 2>"$folder/message") 2>/dev/null
        code=$?
        case $code in
        0) cmp "$folder/shown" "$folder/all" || { echo "allocation $k: something is left out"; return 1; } ;;
        1) grep memory "$folder/message" || { echo "allocation $k: message without 'memory'"; cat "$folder/message"; return 1; } ;;
        *) echo "allocation $k: exit code $code"; return 1 ;;
        esac
    done
}
for command in 'branches --json' 'junctions --csv' 'points --branch 3' 'report --json' 'orbit --branch 3 --energy 1.5'; do
    ok "${command%% *}: all or nothing" reads ${command%% *} "$folder/whole.ricochet" ${command#* }
done
ok "verify: all or nothing" reads verify "$folder/whole.ricochet"
ok "check: all or nothing" reads check "$folder/study.yaml"

if [ "$(id -u)" -ne 0 ]; then
    mkdir "$folder/closed"
    chmod a-w "$folder/closed"
    refused() { ! "$ricochet" run "$folder/study.yaml" -o "$folder/closed/a.ricochet" 2>"$folder/message" && grep -q 'cannot write in its folder' "$folder/message"; }
    ok "a folder that may not be written is named" refused
fi
finish
