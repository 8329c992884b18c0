#!/usr/bin/env bash
# The notebooks run from the first cell to the last.
set -u
. tests/support/tap.sh
if sanitized; then
    echo '1..0 # SKIP the library is instrumented, and Python is not'
    exit 77
fi
build=$(dirname "$ricochet")
clean() { # a notebook in the tree has no answers: they would be changed by every run
    python3 - "$1" <<'END'
import json, sys
cells = json.load(open(sys.argv[1], encoding="utf-8"))["cells"]
assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in cells), "it has outputs"
END
}
shows() { # a picture and a table; a motion where it says so
    grep -q image/png "$folder/$1" && grep -q '<table' "$folder/$1" && { ! grep -q jshtml "python/notebooks/$1" || grep -q '<img id=\|<div class=.*anim' "$folder/$1"; }
}
# Pictures of motions are dear: the short form has two of each, and two of the notebooks.
names=$(some_of 'cubic-spring.ipynb five-minutes.ipynb' "$(cd python/notebooks && echo *.ipynb)")
FRAMES="$(some_of 2 '')" tools/notebooks "$build" "$folder" $names >"$folder/said" 2>&1
code=$?
if [ $code = 77 ]; then
    echo "1..0 # SKIP $(cat "$folder/said")"
    exit 77
fi
ended() { cat "$folder/said" && [ $code = 0 ]; }
ok 'the notebooks run' ended
for notebook in python/notebooks/*.ipynb; do
    name=$(basename "$notebook")
    ok "$name has no answers in the tree" clean "$notebook"
    case " $names " in
    *" $name "*) ;;
    *) left_out "$name" 'make long runs it, and make site' && continue ;;
    esac
    ok "$name shows a picture, a table and a motion" shows "$name"
    ok "$name verifies" grep -q 'agree with the simulator; of [0-9]* rows of branches and junctions 0 do not agree' "$folder/$name"
done
finish
