#!/usr/bin/env bash
# Random structures and a judge that shares no code with the program (tools/attack). Seeds are printed.
set -u
. tests/tap.sh

if ! tools/attack/attack --help >/dev/null 2>&1; then
    echo "1..0 # SKIP no Python with NumPy and mpmath"
    exit 77
fi
ok "the judge sees planted faults" env ATTACK_PART=planted tools/attack/attack "$ricochet"
# Kind, first seed, points besides the ends of branches.
while read -r kind seed points; do
    ok "15 structures, $kind, from seed $seed on" \
        tools/attack/attack --program "$ricochet" -n 15 --seed "$seed" --kind "$kind" --small --points "$points"
done <<'END'
rigid 1 30
bilinear 1 30
mixed 18 30
power 19 10
END
finish
