#!/usr/bin/env bash
# The notebooks run from the first cell to the last.
set -u
. tests/support/tap.sh
if sanitized; then
    echo '1..0 # SKIP the library is instrumented, and Python is not'
    exit 77
fi
build=$(dirname "$ricochet")
why=$(tools/python -with scipy,matplotlib,nbconvert,ipykernel -c '' 2>&1) || { echo "1..0 # SKIP $why"; exit 77; }
python=$(tools/python -with scipy,matplotlib,nbconvert,ipykernel -c 'import sys; print(sys.executable)')

clean() { # a notebook in the tree has no answers: they would be changed by every run
    "$python" - "$1" <<'END'
import json, sys
cells = json.load(open(sys.argv[1], encoding="utf-8"))["cells"]
assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in cells), "it has outputs"
END
}
shows() { # a picture and a table; a motion where it says so
    grep -q image/png "$folder/$1" && grep -q '<table' "$folder/$1" && { ! grep -q jshtml "python/notebooks/$1" || grep -q '<img id=\|<div class=.*anim' "$folder/$1"; }
}
# Most of the time goes into the pictures of motions, of which the short form has a quarter.
ok 'the notebooks run' env FRAMES="$(some_of 6 '')" tools/notebooks "$build" "$folder"
for notebook in python/notebooks/*.ipynb; do
    name=$(basename "$notebook")
    ok "$name has no answers in the tree" clean "$notebook"
    ok "$name shows a picture, a table and a motion" shows "$name"
    ok "$name verifies" grep -q 'agree with the simulator; of [0-9]* rows of branches and junctions 0 do not agree' "$folder/$name"
done
finish
