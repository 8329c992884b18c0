#!/usr/bin/env bash
# Every number that the Python package returns is that of the program, to the bit, over all examples.
set -u
. tests/support/tap.sh
if sanitized; then
    echo '1..0 # SKIP the library is instrumented, and Python is not'
    exit 77
fi
if ! tools/python -c '' 2>"$folder/missing"; then
    echo "1..0 # SKIP $(cat "$folder/missing")"
    exit 77
fi
RICOCHET=$ricochet tools/python tests/python/test_numbers.py
