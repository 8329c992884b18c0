#!/usr/bin/env bash
# The notebooks run from the first cell to the last.
set -u
. tests/support/tap.sh
if sanitized; then
    echo '1..0 # SKIP the library is instrumented, and Python is not'
    exit 77
fi
if ! tools/python -with scipy,matplotlib,nbconvert,ipykernel -c '' 2>/dev/null; then
    echo '1..0 # SKIP no Python with scipy, matplotlib, nbconvert and ipykernel (Debian: python3-nbconvert, python3-ipykernel)'
    exit 77
fi
export RICOCHET_LIBRARY=$(dirname "$ricochet")/src/libricochet.so MPLCONFIGDIR=$folder/matplotlib IPYTHONDIR=$folder/ipython
export JUPYTER_CONFIG_DIR=$folder/jupyter JUPYTER_RUNTIME_DIR=$folder/runtime JUPYTER_DATA_DIR=$folder/data
python=$(tools/python -with scipy,matplotlib,nbconvert,ipykernel -c 'import sys; print(sys.executable)')

# The kernel is this Python, whatever kernels are installed.
mkdir -p "$folder/data/kernels/python3"
echo '{"argv": ["'"$python"'", "-m", "ipykernel_launcher", "-f", "{connection_file}"], "display_name": "Python 3", "language": "python"}' \
    >"$folder/data/kernels/python3/kernel.json"

clean() { # a notebook in the tree has no answers: they would be changed by every run
    "$python" - "$1" <<'END'
import json, sys
cells = json.load(open(sys.argv[1], encoding="utf-8"))["cells"]
assert all(not cell.get("outputs") and cell.get("execution_count") is None for cell in cells), "it has outputs"
END
}
for notebook in python/notebooks/*.ipynb; do
    name=$(basename "$notebook")
    cp "$notebook" "$folder/$name"
    ok "$name runs" tools/python -m nbconvert --to notebook --execute --inplace --ExecutePreprocessor.timeout=600 "$folder/$name"
    ok "$name has no answers in the tree" clean "$notebook"
    ok "$name shows a picture, a table and a motion" bash -c "grep -q image/png '$folder/$name' && grep -q '<table' '$folder/$name' && grep -q jshtml '$notebook'"
    ok "$name verifies" grep -q 'agree with the simulator; of [0-9]* rows of branches and junctions 0 do not agree' "$folder/$name"
done
finish
