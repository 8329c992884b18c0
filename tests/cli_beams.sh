#!/bin/bash
# Beams whose lumped mass hangs on other springs than the example's: multipliers of 1e11, pitchforks of radius 1e-4, poles beside zeros.
set -u
work=$(mktemp -d) || exit 1
trap 'rm -rf "$work"' EXIT
number=0 failed=0

check() # NAME COMMAND...: one TAP line
{
    local name=$1
    shift
    number=$((number + 1))
    if "$@" >"$work/out" 2>&1; then echo "ok $number - $name"; else
        echo "not ok $number - $name"
        tail -n 8 "$work/out" | sed 's/^/# /'
        failed=1
    fi
}

study() # SPRING
{
    mkdir -p "$work/$1" && tools/beam.py "$work/$1" 10 4 0.5 "$1" || return 1
    sed -e 's/start: .*/start: [1]/; s/impacts: .*/impacts: 4/; s/depth: .*/depth: 3/' examples/beam-lumped/study.yaml >"$work/$1/study.yaml"
}
explored() { study "$1" && "$RICOCHET" run "$work/$1/study.yaml" -o "$work/$1.ricochet"; }
closed() { "$RICOCHET" branches "$work/$1.ricochet" --csv >"$work/rows" && ! grep ,failed, "$work/rows"; }
lists() { "$RICOCHET" junctions "$work/$1.ricochet" --json | grep -E "$2"; }
lists_no() { ! lists "$@"; }

if ! command -v python3 >/dev/null; then
    echo '1..0 # SKIP python3 is not there to make the matrices'
    exit 77
fi
for spring in 3.98 3.99 4.01; do
    check "spring $spring: run" explored $spring
    check "spring $spring: no branch failed" closed $spring
    check "spring $spring: every stored point verifies" "$RICOCHET" verify "$work/$spring.ricochet" --all
done
check 'spring 3.5: run' explored 3.5
check 'spring 3.5: seven symmetry-breaking branch points' lists 3.5 'C7_33|C[0-9]+_33'
check 'spring 3.5: no pole is listed as one, none is refused for its kernel' lists_no 3.5 'branch-point.*"C[0-9]+_31"|has not two dimensions'
echo "1..$number"
exit $failed
