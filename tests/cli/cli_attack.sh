#!/usr/bin/env bash
# Random structures and a judge that shares no code with the program (tools/attack). Seeds are printed.
set -u
. tests/support/tap.sh

if ! tools/attack/attack --help >/dev/null 2>&1; then
    echo "1..0 # SKIP no Python with NumPy and mpmath"
    exit 77
fi
# The short form plants each fault once, and takes one branch away.
ok "the judge sees planted faults" env ATTACK_PART=planted tools/attack/attack "$ricochet" $(some_of 1 "")
# try NAME ARGUMENTS...: what the judge is to be asked, all of it by one start of Python
try() {
    local name=$1
    shift
    printf '%s\t%s\n' "$name" "--program $ricochet $*" >>"$folder/asked"
}
# Kind, first seed, how many, points besides the ends of branches. Power laws take twenty times as long as stops.
few=$(some_of 2 16) power=$(some_of 1 11) clusters=$(some_of 1 4)
while read -r kind seed count points; do
    try "$count structures, $kind, from seed $seed on" -n "$count" --seed "$seed" --kind "$kind" --small --points "$points"
done <<END
rigid 1 $few 30
bilinear 1 $few 30
mixed 1 $few 30
power 1 $power 10
power 34 $clusters 10
END
# Frequencies 1e-6 to 1e-14 apart: the judge has as many multipliers as there are modes of their own.
for kind in rigid bilinear mixed power; do
    try "$few structures of all but equal frequencies, $kind" -n $few --near --kind $kind --points 8 --verify
done
# Several bodies that nothing holds, whose places only some of their contacts see.
try "$few structures of free bodies, with three steps" -n $few --bodies --seed 30 --points 8 --verify --compare step
# Other steps and orders of the coordinates find what they may not agree in elsewhere, or not at all, and the report of an atlas says
# so: labels that are not decided, a last orbit beside its junction, an energy that turns between two modes of nearly one frequency or
# right beside a multiplication, a mode that goes along unfelt, a grazing beside a singular point.
while read -r seed what kind; do
    [ -z "$seed" ] || try "what another $what gives of structure $seed differs by what is said" -n 1 --seed "$seed" $kind --points 1 --compare "$what"
done <<END
173 step --bodies
20520053 step --kind bilinear
19620163 step --kind mixed
23750029 order --kind rigid
$(some_of '' '20520015 step --kind bilinear')
$(some_of '' '19620140 step --kind mixed')
$(some_of '' '23650028 order --kind mixed')
$(some_of '' '23750051 step --kind rigid')
$(some_of '' '23750093 step --kind rigid')
$(some_of '' '23100028 step --bodies')
END
# Seed, points: orbits that repeat themselves but for a difference that some of their events do not have; clusters of near
# frequencies, of which all multipliers want many digits; orbits that are all but their own images, and go on otherwise, or for another time.
while read -r seed points; do
    [ -z "$seed" ] || try "all of structure $seed is confirmed" -n 1 --seed "$seed" --points "$points" --unconfirmed 0
done <<END
90022 400
90629 40
801281 40
$(some_of '' '850969 200')
END
# Right multipliers of orbits whose stored states, between stiff springs, lie beside them; a junction that is open by as many of its
# digits as the points beside it; a corner, where half a period is known to a whole turn.
while read -r seed kind; do
    try "verify does not take structure $seed for wrong" -n 1 --seed "$seed" --kind "$kind" --points 1 --verify
done <<END
23500137 bilinear
26600051 mixed
27600118 mixed
END
# Springs that multiply rounding by 1e11 in a period: what is polished is the stored orbit, and none beside it on its branch.
try "the margins of structure 2100519 are those of its orbits" -n 1 --seed 2100519 --kind bilinear
# Four equal touches, of which the last has come through flights that make 2.5e-7 of the last digits of the stored state.
for seed in $(some_of '' 9600042); do
    try "the grazings of structure $seed touch to what their digits hold" -n 1 --seed "$seed" --kind bilinear --points 1
done
# Orbits of two energies that are on no branch, by brute force: mixed; rigid, bilinear with two modes, rigid with three.
for seed in 130022 $(some_of '' '130004 130017 130012'); do
    try "no orbit of structure $seed is lost" -n 1 --seed "$seed" --small --points 1 --brute $(some_of 1 2)
done
tools/attack/attack --each <"$folder/asked" >"$folder/claims"
ok 'the judge has answered' test $? = 0 -a "$(wc -l <"$folder/claims")" -ge 20
claims "$folder/claims"
# Junctions that are followed while a parameter changes: grazings that end where a second gap touches.
ok "loci of structure 2500008" env ATTACK_PART=loci tools/attack/attack "$ricochet" mixed $(some_of 1 3) 2500008 $(some_of 1 12)
# The error of multipliers is within what the library states of it; a sanitizer's library is not for Python to load.
library=$(dirname "$ricochet")/src/libricochet.so
if [ -f "$library" ] && python3 -S -c 'import ctypes, sys; ctypes.CDLL(sys.argv[1])' "$library" 2>/dev/null; then
    for kind in rigid bilinear mixed power; do
        structures=$(some_of 2 4)
        [ $kind != power ] || structures=$(some_of 1 4) # ten times as dear
        ok "bounds of multipliers, $kind" env ATTACK_PART=bounds tools/attack/attack "$library" "$ricochet" $kind "$structures" 5000 8
    done
fi
finish
