#!/usr/bin/env bash
# The tables of docs/article.md that go from level to level: some lines of each, computed anew.
set -u
. tests/support/tap.sh
export PYTHONDONTWRITEBYTECODE=1

ok 'the lines of the page are what is computed' tools/scaling.py "$ricochet" $(some_of --short '') --page docs/article.md
powers() # of y = 3 x^-4 (1 + 1 / x), and of one without a correction: the power is within its error
{
    PYTHONPATH=tools python3 -S -c '
from scaling import power
for y in (lambda x: 3 * x**-4 * (1 + 1 / x), lambda x: 3 * x**-4 * (1 + 2 / x**2), lambda x: 3 * x**-4):
    p, error = power([(x, y(x)) for x in range(2, 20)])
    print(p, error)
    assert abs(p + 4) <= error + 1e-12 and error < 0.1'
}
ok 'a power is found within its error' powers
awk '/^\| 4 \| 0.01880651/ { sub("0.1408402", "0.1408403") } { print }' docs/article.md >"$folder/page.md"
differs() { ! tools/scaling.py "$ricochet" --short --page "$folder/page.md" >"$folder/out" 2>&1 && grep -q 'has not' "$folder/out"; }
ok 'a digit that is off is seen' differs
finish
