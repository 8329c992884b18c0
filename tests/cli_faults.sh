#!/usr/bin/env bash
# No memory, a full disk or no power at any moment of a run: it ends with a message or not at all, never with a crash, and the same command
# then makes the atlas of an undisturbed run. FAULTS_ALL=1 tries every allocation, otherwise a sample.
set -u
. tests/tap.sh

cc=${CC:-cc}
command -v "$cc" >/dev/null || { echo "1..0 # SKIP no compiler $cc"; exit 77; }
"$cc" -shared -fPIC -O1 -o "$folder/faults.so" tests/faults.c -ldl || exit 77
# A program built with sanitizers brings its own allocator.
! grep -q __asan_init "$ricochet" || exit 77

cat >"$folder/study.yaml" <<'YAML'
title: Two masses
model:
  mass: [[2, 0], [0, 1]]
  stiffness: [[9, -1], [-1, 1]]
  contacts:
    - {normal: [-1, 1], clearance: 1.0, law: rigid}
explore: {energy: [0, 50], frequency: [0.2, 10], impacts: 4, multiply: 1, depth: 2}
YAML
atlas=$folder/a.ricochet

rows() { "$ricochet" branches "$1" --json && "$ricochet" junctions "$1" --json; }

disturbed() # FAULT=K OPTION...: exit code
{
    local fault=$1
    shift
    (env "$fault" LD_PRELOAD="$folder/faults.so" "$ricochet" run "$folder/study.yaml" -o "$atlas" "$@" >/dev/null 2>"$folder/message") 2>/dev/null
}

resumed() # the atlas after the same command without a fault is that of an undisturbed run
{
    "$ricochet" run "$folder/study.yaml" -o "$atlas" 2>"$folder/message" || { cat "$folder/message"; return 1; }
    rows "$atlas" >"$folder/rows"
    cmp "$folder/rows" "$folder/whole"
}

"$ricochet" run "$folder/study.yaml" -o "$folder/whole.ricochet" 2>/dev/null
rows "$folder/whole.ricochet" >"$folder/whole"
ok "an undisturbed run counts its calls" disturbed "FAULT_COUNT=$folder/count"
read -r allocations writes <"$folder/count"
ok "there are many" test "$allocations" -gt 1000 -a "$writes" -gt 30

# try NAME FAULT K EXPECTED-CODES
try()
{
    rm -f "$atlas"*
    disturbed "$2=$3"
    local code=$?
    case " $4 " in *" $code "*) ;; *) echo "$1 $3: exit code $code"; cat "$folder/message"; return 1 ;; esac
    [ "$code" != 1 ] || [ -s "$folder/message" ] || { echo "$1 $3: no message"; return 1; }
    resumed || { echo "$1 $3: not resumed"; return 1; }
}

# every NAME FAULT CODES K...
every()
{
    local name=$1 fault=$2 codes=$3
    shift 3
    for k in "$@"; do try "$name" "$fault" "$k" "$codes" || return 1; done
}

ok "the disk is full from any of $writes writing calls on" every disk FAULT_DISK 1 $(seq 1 "$writes")
ok "the power fails at any of them" every power FAULT_POWER 137 $(seq 1 "$writes")
step=$((allocations / 120 + 1))
[ "${FAULTS_ALL:-0}" = 0 ] || step=1
# SQLite and LAPACK may do without what they asked for: then the run ends well.
ok "any allocation finds no memory (every ${step}th of $allocations)" every allocation FAULT_ALLOC "0 1" $(seq 1 $step "$allocations")
if [ "$(id -u)" -ne 0 ]; then
    mkdir "$folder/closed"
    chmod a-w "$folder/closed"
    refused() { ! "$ricochet" run "$folder/study.yaml" -o "$folder/closed/a.ricochet" 2>"$folder/message" && grep -q 'cannot write in its folder' "$folder/message"; }
    ok "a folder that may not be written is named" refused
fi
finish
