#!/usr/bin/env bash
# The Python package: explorations, reduction, pictures, its documentation, and pip without a network.
set -u
. tests/support/tap.sh
needs_python
export MPLBACKEND=Agg MPLCONFIGDIR=$folder/matplotlib RICOCHET_LIBRARY=$(dirname "$ricochet")/src/libricochet.so

# part MODULE NAME: a file of tests in Python, with what it prints
part()
{
    if tools/python -with "$1" -c '' 2>/dev/null; then
        RICOCHET=$ricochet ok "$2" tools/python -with "$1" "tests/python/$2.py"
        grep '^#' "$folder/log" 2>/dev/null
    else
        left_out "$2" "no Python with $1"
    fi
}
part scipy test_explore
part scipy test_around
part numpy test_forced
part scipy test_reduce
part matplotlib test_plot

documented() { tools/python tools/python-reference | diff docs/python.md -; }
ok 'docs/python.md is what tools/python-reference makes of the package' documented

# pip builds and installs it without a network, and what is installed works far from the tree.
python=$(tools/python -c 'import sys; print(sys.executable)')
if "$python" -m pip --version >/dev/null 2>&1; then
    ok 'pip install . needs no network' "$python" -m pip install --quiet --no-index --no-deps --target "$folder/installed" .
    installed() { cd "$folder" && unset RICOCHET_LIBRARY && PYTHONPATH=$folder/installed "$python" -c '
import ricochet, sys
from ricochet import _library
assert _library.library_path.startswith(sys.argv[1]), _library.library_path
ricochet.Model([[1]], [[1]], [dict(normal=[1], clearance=1)])' "$folder/installed"; }
    ok 'the installed package has its own library' bash -c "$(declare -f installed); folder='$folder' python='$python'; installed"
else
    left_out 'pip install .' "no pip for $python"
fi
# The first python3 on PATH finds the packages of Debian, if it is of the same version.
fits() { [ "$(python3 -c 'import sys; print(sys.version_info[:2])')" = "$(/usr/bin/python3 -c 'import sys; print(sys.version_info[:2])')" ]; }
if fits 2>/dev/null && /usr/bin/python3 -c 'import numpy, cffi' 2>/dev/null; then
    ok 'PYTHONPATH=python python3' env PYTHONPATH=python PYTHONDONTWRITEBYTECODE=1 python3 -c 'import ricochet; ricochet.Model'
else
    left_out 'PYTHONPATH=python python3' 'it is of another version than /usr/bin/python3, or that has no NumPy and cffi'
fi
# A library that is not that of the header would give wrong numbers, not errors.
tree=$folder/tree
mkdir -p "$tree/include" "$tree/build/src"
cp -r python "$tree/"
rm -f "$tree/python/ricochet/libricochet.so"
cp "$(dirname "$ricochet")/src/libricochet.so" "$tree/build/src/"
imports() { PYTHONPATH=$tree/python env -u RICOCHET_LIBRARY "$python" -B -c 'import ricochet' 2>&1; }
header() { sed "$1" include/ricochet.h >"$tree/include/ricochet.h" && touch -d "$2" "$tree/include/ricochet.h"; } # SED TIME
ok 'a header and its library' eval 'header "" yesterday && imports'
ok 'a library that lacks a function is refused' eval 'header "s/^const char \*ric_version/void ric_nothing(void);\n&/" yesterday && imports | grep -q "lacks ric_nothing"'
ok 'a library of another version is refused' eval 'header "s/\(RIC_VERSION \"\)/\19./" yesterday && imports | grep -q "of version"'
ok 'a library that is older than its header is refused' eval 'header "" tomorrow && imports | grep -q "older than its header"'
missing() { RICOCHET_LIBRARY=/nowhere tools/python -c 'import ricochet' 2>&1 | grep -q 'RICOCHET_LIBRARY names /nowhere'; }
ok 'a library that is not there is told' missing
finish
