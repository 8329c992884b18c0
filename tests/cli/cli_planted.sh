#!/bin/bash
# Faults that are planted in atlases of four kinds are found by `ricochet verify` (tools/attack/plant.py), which stops when it is asked to.
set -u
. tests/support/tap.sh

if ! command -v python3 >/dev/null; then
    echo '1..0 # SKIP python3 is not there to plant faults'
    exit 77
fi
study() # NAME MASS STIFFNESS ENERGY FREQUENCY CONTACT...
{
    printf 'model:\n  mass: %s\n  stiffness: %s\n  contacts:\n' "$2" "$3" >"$folder/$1.yaml"
    printf '    - {%s}\n' "${@:6}" >>"$folder/$1.yaml"
    printf 'explore: {energy: %s, frequency: %s, impacts: 6, multiply: 2, depth: 2}\n' "$4" "$5" >>"$folder/$1.yaml"
    "$ricochet" run "$folder/$1.yaml" -o "$folder/$1.ricochet"
}
planted() { tools/attack/plant.py --program "$ricochet" --places 60 --seed "$1" "$folder"/{rigid,bilinear,mixed,power}.ricochet; }
ends() # CODE COMMAND...
{
    "${@:2}"
    [ $? -eq "$1" ]
}
counts() { grep -E "$1" "$folder/said"; }

ok rigid study rigid '[[1.188, 0], [0, 1.903]]' '[[7.225, -2.0581], [-2.0581, 6.1725]]' '[0, 53.82]' '[0.5468, 7.7271]' \
    'law: rigid, normal: [0, 1], clearance: 0.663, sides: lower'
ok bilinear study bilinear '[[0.875, 0], [0, 1.581]]' '[[2.8262, 0.2414], [0.2414, 3.4362]]' '[0, 42.699]' '[0.4871, 5.4236]' \
    'law: bilinear, normal: [-1, 1], clearance: 1.236, sides: both, stiffness: 1.445'
ok mixed study mixed '[[1.188, 0], [0, 1.903]]' '[[7.225, -2.0581], [-2.0581, 6.1725]]' '[0, 53.82]' '[0.5468, 7.7271]' \
    'law: rigid, normal: [0, 1], clearance: 0.663, sides: lower' \
    'law: bilinear, normal: [1, -1], clearance: 0.544, sides: lower, stiffness: 1.005'
ok power study power '[[1.277, 0], [0, 1.062]]' '[[9.3866, -4.9833], [-4.9833, 4.0126]]' '[0, 18.549]' '[0.321, 9.5819]' \
    'law: power, normal: [-1, 1], exponent: 3, stiffness: 0.564'
ok 'all faults are found' planted 5
same() { "$ricochet" verify "$folder/mixed.ricochet" --all --json -j 1 >"$folder/one" && "$ricochet" verify "$folder/mixed.ricochet" --all --json -j 3 | cmp - "$folder/one"; }
ok "the same on three threads" same
ok 'the time given is over' ends 3 "$ricochet" verify "$folder/power.ricochet" --all --seconds 1e-9
cp "$folder/log" "$folder/said"
ok 'and what was not looked at is counted' counts '^ricochet: stopped when the time given was over: [0-9]+ of [0-9]+ points were not looked at$'
ok 'within a point alone, too' ends 3 "$ricochet" verify "$folder/power.ricochet" --branch 3 --point 1 --seconds 1e-9
interrupted() {
    "$ricochet" verify "$folder/power.ricochet" --all &
    listens $!
    kill -INT $!
    wait $!
}
ok 'a signal stops it' ends 130 interrupted
cp "$folder/log" "$folder/said"
ok 'and what was not looked at is counted, too' counts '^ricochet: stopped on request: [0-9]+ of [0-9]+ points were not looked at$'
kinds() { "$ricochet" verify "$folder/mixed.ricochet" --json | grep -c "\"kind\": \"$1\"" | grep -qv '^0$'; }
ok 'rows of branches' kinds branch
ok 'rows of junctions' kinds junction
ok 'a point alone' ends 0 "$ricochet" verify "$folder/mixed.ricochet" --branch 1 --point 2
ok 'no such point' ends 1 "$ricochet" verify "$folder/mixed.ricochet" --branch 1 --point 100000
ok 'a point of no branch' ends 2 "$ricochet" verify "$folder/mixed.ricochet" --point 2
cat >"$folder/stiff.yaml" <<'END'
model:
  mass: [[1.25, 0, 0, 0], [0, 0.75, 0, 0], [0, 0, 0.75, 0], [0, 0, 0, 1.5]]
  stiffness: [[1562500, -1562500, 0, 0], [-1562500, 2000000, -437500, 0], [0, -437500, 2062500, -1625000], [0, 0, -1625000, 1625000]]
  contacts:
    - {normal: [1, 0, -1, -1], law: bilinear, clearance: 1.8, sides: both, stiffness: 7511000}
    - {normal: [1, 0, 0, -1], law: bilinear, clearance: 1.8, sides: both, stiffness: 129400000000}
explore: {energy: [0, 16230000], frequency: [114.8, 6096], impacts: 5, multiply: 2, depth: 1}
END
"$ricochet" run "$folder/stiff.yaml" -o "$folder/stiff.ricochet" >/dev/null 2>&1
ok 'what stiff springs make of the stored digits is no fault' ends 0 "$ricochet" verify "$folder/stiff.ricochet" --all
ok 'no time at all' ends 2 "$ricochet" verify "$folder/mixed.ricochet" --seconds 0
finish
