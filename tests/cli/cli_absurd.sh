#!/usr/bin/env bash
# Absurd studies end in a clear message or in an honest result, within bounded time and memory.
set -u
. tests/support/tap.sh
seconds=100 # of the processor, until which nothing hangs, however busy the machine
sanitized && seconds=1000
sanitized || ulimit -v 4000000 # address space, kB; a sanitizer reserves terabytes

# ends CODE PATTERN ARGUMENTS...: with that code in time, and the pattern in what it says
ends() {
    local code=$1 pattern=$2 got=0
    shift 2
    (ulimit -t "$seconds" && exec "$ricochet" "$@") >"$folder/out" 2>&1 || got=$?
    echo "exit code $got"
    tail -n 5 "$folder/out" | cut -c1-300
    [ "$got" = "$code" ] && grep -q -e "$pattern" "$folder/out"
}

study() # NAME MASS STIFFNESS CONTACTS EXPLORE
{
    printf 'title: %s\nmodel: {mass: %s, stiffness: %s, contacts: [%s]}\nexplore: {%s}\n' "$@" >"$folder/$1.yaml"
}
mass='[[2, 0], [0, 1]]' spring='[[9, -1], [-1, 1]]' window='energy: [0, 20], impacts: 6, depth: 2'
contact() { printf '{normal: %s, clearance: %s, law: rigid}' "$1" "$2"; }
branches() { "$ricochet" branches "$folder/$1.ricochet" --csv | tail -n +2 | cut -d, -f3-4,10-13 >"$folder/$1.csv"; }

study usual "$mass" "$spring" "$(contact '[-1, 1]' 1)" "$window"
ok "the usual one" ends 0 branches run "$folder/usual.yaml"
branches usual
for clearance in 1.0e-300 1.0e+300; do
    study "c$clearance" "$mass" "$spring" "$(contact '[-1, 1]' $clearance)" "$window"
    ok "clearance $clearance" ends 0 branches run "$folder/c$clearance.yaml"
    branches "c$clearance"
    ok "has the same branches" same "$folder/usual.csv" "$folder/c$clearance.csv"
    ok "that verify" ends 0 "agree with" verify "$folder/c$clearance.ricochet"
    ok "energies in its units are none" ends 0 "no double holds: they are left out" branches "$folder/c$clearance.ricochet" --physical --csv
    ok "and not shown as 0" test "$(tail -n 1 "$folder/out" | cut -d, -f11-12)" = ,
    ok "and none is asked for" ends 2 "no double holds" check "$folder/c$clearance.yaml" --physical
    ok "or drawn" ends 2 "no double holds" plot fep "$folder/c$clearance.ricochet" --physical -o "$folder/fep.svg"
done

study stiff "$mass" '[[1.0e16, -1], [-1, 1]]' "$(contact '[-1, 1]' 1)" "$window, frequency: [0.01, 1.0e9]"
ok "stiffness ratio 1e16: too many turns in one flight" ends 2 "explore.frequency: mode 2 .* raise the lower end" run "$folder/stiff.yaml"
ok "check says so, too, and shows the model" ends 0 "a run refuses this study: explore.frequency: mode 2 .* raise the lower end" check "$folder/stiff.yaml"
ok "and leaves no file" test ! -e "$folder/stiff.ricochet"
study window "$mass" '[[1.0e16, -1], [-1, 1]]' "$(contact '[-1, 1]' 1)" "$window"
ok "it can be looked at in the window that is chosen" ends 0 "2 degrees of freedom, 2 of them seen" check "$folder/window.yaml"
study heavy '[[1.0e16, 0], [0, 1]]' "$spring" "$(contact '[-1, 1]' 1)" "$window"
ok "mass ratio 1e16" ends 2 "singular to rounding" run "$folder/heavy.yaml"

many() { for ((i = 0; i < $1; i++)); do printf ', {normal: [1, 0.001], clearance: %d, sides: upper, law: rigid}' $((1000 + i)); done; }
study many "$mass" '[[3, -1], [-1, 2]]' "$(contact '[0, 1]' 0.6)$(many 70)" "$window"
ok "more faces than a set of closed springs can hold" ends 0 branches run "$folder/many.yaml"
ok "their section" ends 0 "2 starts, 40 impacts" section "$folder/many.yaml" --energy 6 --starts 2 --impacts 20
ok "their forced motions" ends 0 "threshold" force "$folder/many.ricochet" --force 1,0 --damping 0.01
spring_behind='{normal: [1, 0], clearance: 0.5, sides: upper, law: bilinear, stiffness: 5}'
study most "$mass" '[[3, -1], [-1, 2]]' "$spring_behind, $(contact '[0, 1]' 0.6)$(many 61)" "$window"
ok "as many with a spring as it can hold" ends 0 branches run "$folder/most.yaml"
study toomany "$mass" '[[3, -1], [-1, 2]]' "$spring_behind$(many 63), $(contact '[0, 1]' 0.6)" "$window"
ok "one more is refused" ends 2 "64 faces at most, and there are 66" run "$folder/toomany.yaml"
study twice "$mass" "$spring" "$(contact '[-1, 1]' 1), $(contact '[-1, 1]' 1)" "$window"
ok "one contact twice" ends 0 "2 branches" run "$folder/twice.yaml"
ok "with the reason why nothing leaves" grep -q -i -e "one instant\|together\|coincid\|same" <("$ricochet" junctions "$folder/twice.ricochet" --json)
study turned "$mass" "$spring" "$(contact '[-1, 1]' 1), $(contact '[2, -2]' 2.0000000001)" "$window"
ok "almost the same one turned round" ends 0 branches run "$folder/turned.yaml"

study low "$mass" "$spring" "$(contact '[-1, 1]' 1)" "energy: [0, 1.0e-9], impacts: 6, depth: 2"
ok "an energy window below all touches" ends 0 "2 branches, 0 junctions" run "$folder/low.yaml"
study fast "$mass" "$spring" "$(contact '[-1, 1]' 1)" "energy: [0, 20], frequency: [1.0e11, 1.0e12], impacts: 6, depth: 2"
ok "a frequency window with nothing in it" ends 0 "2 branches" run "$folder/fast.yaml"
study unseen '[[1, 0, 0], [0, 1, 0], [0, 0, 1]]' '[[2, 0, 0], [0, 3, 0], [0, 0, 1.0e12]]' "$(contact '[0, 0, 1]' 1)" "$window, frequency: [10, 1.0e7]"
ok "the only mode that is seen lies far above" ends 0 "3 branches" run "$folder/unseen.yaml"
for normal in 1.0e+200 1.0e-200; do
    study "n$normal" "$mass" "$spring" "$(contact "[$normal, $normal]" 1)" "$window"
    ok "a normal of $normal" ends 2 "contact 1: c.c = .* divide normal and clearance by one number" run "$folder/n$normal.yaml"
done
study light '[[1.0e-320, 0], [0, 1.0e-320]]' "$spring" "$(contact '[-1, 1]' 1)" "$window"
ok "masses that are no more than rounding" ends 2 "contact 1: c.c = .* choose another unit of mass" run "$folder/light.yaml"
study faint '[[1, 0], [0, 1]]' '[[2, 0], [0, 3]]' "$(contact '[1, 1.0e-15]' 1)" "$window"
ok "a mode seen at rounding level" ends 0 branches run "$folder/faint.yaml"
ok "is said to be unseen" grep -q "no contact sees" <("$ricochet" branches "$folder/faint.ricochet" --csv)

ok "speed 1e300" ends 1 "more than 1000000 impacts" simulate "$folder/usual.yaml" --state 0 0 0 1e300 --time 20
ok "a time at which no digit is known" ends 1 "no digit would be known after" simulate "$folder/usual.yaml" --state 0.1 0.1 0 0 --time 1e300
ok "a time of too many steps" ends 1 "follow it in shorter pieces" simulate examples/power-3/study.yaml --state 0.1 0.1 0 0 --time 1e300
ok "a hunt at energy 1e300" ends 0 "orbits" hunt "$folder/usual.yaml" --energy 1e300 --lines 100 --rows 2 --row 10 --random 100 --impacts 3
ok "a hunt at energy 1e-300" ends 0 "0 orbits" hunt "$folder/usual.yaml" --energy 1e-300 --lines 100 --rows 2 --row 10 --random 100

# A chain of 1000 masses with a stop at one of them; of 204, whose modes cost a hundredth, in the short form. One that is allowed more modes than 200
# has to be told when to end.
n=204
long_form && n=1000
awk -v n=$n 'BEGIN {print "%%MatrixMarket matrix coordinate real symmetric"; print n, n, n; for (i = 1; i <= n; i++) print i, i, 1}' >"$folder/M.mtx"
awk -v n=$n 'BEGIN {print "%%MatrixMarket matrix coordinate real symmetric"; print n, n, 2 * n - 1
    for (i = 1; i <= n; i++) print i, i, 2; for (i = 1; i < n; i++) print i + 1, i, -1}' >"$folder/K.mtx"
normal=$(awk -v n=$n 'BEGIN {for (i = 1; i <= n; i++) printf "%s%d", (i > 1 ? ", " : "["), (i == int(n / 3)); print "]"}')
study chain '{file: M.mtx}' '{file: K.mtx}' "$(contact "$normal" 1)" "energy: [0, 0.1], frequency: [1.9, 10], impacts: 2, depth: 1, start: [1]"
seconds=600
if ! sanitized; then
    ok "n = $n is checked" ends 0 "$n degrees of freedom, [0-9]* of them seen" check "$folder/chain.yaml"
    ok "a run without end is refused" ends 2 "$n modes take part .* --seconds" run "$folder/chain.yaml"
    ok "with a time to end it is not" ends 0 "too large to do so in passing" run "$folder/chain.yaml" --seconds 500
else
    left_out "n = $n" "it takes minutes with sanitizers"
fi
study spring "$mass" "$spring" "{normal: [-1, 1], clearance: 1, law: bilinear, stiffness: 1.0e+12}" "$window"
ok "a spring that is as good as a stop" ends 2 "contact 1: its stiffness .* law: rigid" run "$folder/spring.yaml"
# Matrices do not lie on the stack: one of 80 kB is enough for 18 modes under a power law, and their multipliers, of 128 kB for 24.
python3 -S - "$(some_of 18 24)" >"$folder/wide.yaml" <<'END'
import sys
n = int(sys.argv[1])
rows = lambda entry: "".join(f"    - {[entry(i, j) for j in range(n)]}\n" for i in range(n))
print("model:\n  mass:\n" + rows(lambda i, j: int(i == j)), end="")
print("  stiffness:\n" + rows(lambda i, j: 2 * (i == j) - (abs(i - j) == 1)), end="")
print(f"  contacts:\n    - {{normal: {[int(i == 0) for i in range(n)]}, law: power, exponent: 3, stiffness: 0.5}}")
print("explore: {start: [1], energy: [0, 1.0e-5], frequency: [0.01, 3], impacts: 1, multiply: 1, depth: 1}")
END
on_little()
{
    (ulimit -s "$(some_of 80 128)" && "$ricochet" run "$folder/wide.yaml" -o "$folder/wide.ricochet" --seconds 100) || return 1
    (ulimit -s "$(some_of 80 128)" && "$ricochet" verify "$folder/wide.ricochet" --branch 1 --point 2)
}
if ! sanitized; then ok 'a small stack is enough' on_little
else left_out 'a small stack' 'sanitizers want a larger one'
fi
study long "$mass" "$spring" "$(contact '[-1, 1]' 1)" "energy: [0, 20], impacts: 14, multiply: 4"
ok "no time is none" ends 2 "no time" run "$folder/long.yaml" --seconds 0
ok "a run stops when its time is over" ends 3 "0.3 s given are over" run "$folder/long.yaml" --seconds 0.3
finish
