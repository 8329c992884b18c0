#!/usr/bin/env bash
# Random structures and a judge that shares no code with the program (tools/attack). Seeds are printed.
set -u
. tests/tap.sh

if ! tools/attack/attack --help >/dev/null 2>&1; then
    echo "1..0 # SKIP no Python with NumPy and mpmath"
    exit 77
fi
ok "the judge sees planted faults" env ATTACK_PART=planted tools/attack/attack "$ricochet"
for kind in rigid bilinear; do
    ok "20 $kind structures from seed 1 on" tools/attack/attack --program "$ricochet" -n 20 --seed 1 --kind $kind --small --points 30
done
finish
