#!/usr/bin/env bash
# The same structure in other units has the same atlas: masses times 1e-3, stiffnesses times 1e6, lengths times 1e-4, also where a power law
# is given by its stiffness alone, which leaves the scale of lengths at 1, and where a second stop lies a thousand times nearer than the first.
set -u
. tests/support/tap.sh

# study NAME MASS STIFFNESS CONTACTS ENERGY FREQUENCY: each a number by which the unit multiplies
cat >"$folder/make.py" <<'PY'
import sys

mass, stiffness, length = map(float, sys.argv[2:5])
kind = sys.argv[1]
k = lambda x: x * stiffness
contacts = {
    "power": [f"{{normal: [-1, 1], law: power, exponent: 3, stiffness: {k(0.7) / length ** 2!r}}}",
              f"{{normal: [0, 1], law: power, exponent: 7, length: {1.5 * length!r}, reference: {k(2)!r}}}"],
    "rigid": [f"{{normal: [1, 0], law: rigid, clearance: {1000 * length!r}}}", f"{{normal: [-1, 1], law: rigid, clearance: {length!r}}}"],
    "mixed": [f"{{normal: [-1, 1], law: rigid, clearance: {length!r}}}",
              f"{{normal: [0, 1], law: bilinear, clearance: {0.5 * length!r}, stiffness: {k(2)!r}}}"],
}[kind]
# scaled energies go with the square of the first length over which they are scaled: 1 where a stiffness stands alone
scale = stiffness * {"power": length ** 2, "rigid": 1e-6, "mixed": 1}[kind]
omega = (stiffness / mass) ** 0.5
print(f"""model:
  mass: [[{2 * mass!r}, 0], [0, {mass!r}]]
  stiffness: [[{k(9)!r}, {k(-1)!r}], [{k(-1)!r}, {k(1)!r}]]
  contacts:""")
for contact in contacts:
    print(f"    - {contact}")
print(f"explore: {{energy: [0, {20 * scale!r}], frequency: [{0.3 * omega!r}, {6 * omega!r}], impacts: 5, multiply: 2, depth: 2}}")
PY

cat >"$folder/compare.py" <<'PY'
import json
import subprocess
import sys

program, *atlases = sys.argv[1:3 + 1]
scale, omega = map(float, sys.argv[4:6])
rows = [json.loads(subprocess.run([program, "junctions", atlas, "--json"], capture_output=True, check=True).stdout) for atlas in atlases]
assert len(rows[0]) == len(rows[1]) > 5, (len(rows[0]), len(rows[1]))
for a, b in zip(*rows):
    assert (a["kind"], a["word"], a["label"], a["departures"]) == (b["kind"], b["word"], b["label"], b["departures"]), (a, b)
    if a["kind"] == "start":
        continue  # its energy is small, and not otherwise defined
    for name, unit in (("energy", scale), ("frequency", omega)):
        assert abs(b[name] - a[name] * unit) <= 1e-9 * abs(b[name]), (a["label"], name, a[name], b[name] / unit)
PY

for kind in power rigid mixed; do
    python3 -S "$folder/make.py" $kind 1 1 1 >"$folder/one.yaml"
    python3 -S "$folder/make.py" $kind 1e-3 1e6 1e-4 >"$folder/other.yaml"
    ok "$kind: a run" "$ricochet" run "$folder/one.yaml" -o "$folder/$kind-one.ricochet"
    ok "$kind: a run in other units" "$ricochet" run "$folder/other.yaml" -o "$folder/$kind-other.ricochet"
    scale=1e6
    [ $kind = power ] && scale=1e-2
    ok "$kind: the same junctions" python3 -S "$folder/compare.py" "$ricochet" "$folder/$kind-one.ricochet" "$folder/$kind-other.ricochet" $scale 31622.776601683792
    ok "$kind: all of it verifies" "$ricochet" verify --all "$folder/$kind-other.ricochet"
done
finish
